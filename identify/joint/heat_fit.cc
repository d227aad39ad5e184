#include "identify/joint/heat_fit.h"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>

#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

// A log as the heat balance sees it: heat that flows until each row, and how far the cell is above
// its surroundings there.
struct Warming {
  std::vector<double> dt_s;
  std::vector<double> heat_W;
  std::vector<double> above_K;
};

Warming WarmingOf(const Cell& cell, const LoadedLog& log) {
  const Record& record = log.log.record;
  const CellModel<double> model(cell.Parameters());
  const Surroundings measured{.measured_degC = record.temperature_degC};
  RecordStepper<double> stepper(
      model, record.hold, StartAmong(model, log.entry.initial_soc, measured));
  const double ambient_degC = log.entry.ambient_degC.value_or(record.temperature_degC.front());
  Warming of;
  for (std::size_t k = 0; k < record.size(); ++k) {
    stepper.Row(record.time_s[k], record.current_A[k]);
    stepper.SetTemperature(record.temperature_degC[k] + kZeroCelsius_K);
    const double flowed_A =
        k == 0 ? 0.0 : record.current_A[record.hold == Hold::kBackward ? k : k - 1];
    of.dt_s.push_back(k == 0 ? 0.0 : record.time_s[k] - record.time_s[k - 1]);
    of.heat_W.push_back(model.Heat(stepper.state(), flowed_A));
    of.above_K.push_back(record.temperature_degC[k] - ambient_degC);
  }
  return of;
}

// R_th and the squared error for a time constant; logs count the same.
struct AtTau {
  double thermal_resistance_K_per_W = 0.0;
  double mean_square_K2 = std::numeric_limits<double>::infinity();
};

AtTau Solve(const std::vector<const Warming*>& logs, double tau_s) {
  double with_itself = 0.0;  // sums over rows: low pass of the heat, and what is left to explain
  double with_rest = 0.0;
  double rest = 0.0;
  for (const Warming* log : logs) {
    const double weight = 1.0 / static_cast<double>(log->dt_s.size() * logs.size());
    double low_pass_W = 0.0;
    double start_K = log->above_K.front();
    for (std::size_t k = 0; k < log->dt_s.size(); ++k) {
      const double share = -std::expm1(-log->dt_s[k] / tau_s);
      low_pass_W += share * (log->heat_W[k] - low_pass_W);
      start_K -= share * start_K;
      const double left_K = log->above_K[k] - start_K;
      with_itself += weight * low_pass_W * low_pass_W;
      with_rest += weight * low_pass_W * left_K;
      rest += weight * left_K * left_K;
    }
  }
  if (!(with_itself > 0.0) || !(with_rest > 0.0)) return {};
  return {with_rest / with_itself, std::max(rest - with_rest * with_rest / with_itself, 0.0)};
}

struct Found {
  double tau_s = 0.0;
  AtTau at;
};

Found Search(const std::vector<const Warming*>& logs) {
  constexpr double kShortest_s = 30.0;
  constexpr double kLongest_s = 3e4;
  constexpr int kPoints = 24;
  const double width = std::log(kLongest_s / kShortest_s) / kPoints;
  const auto cost = [&](double log_tau) { return Solve(logs, std::exp(log_tau)).mean_square_K2; };
  double best = std::log(kShortest_s);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= kPoints; ++k) {
    const double at = std::log(kShortest_s) + k * width;
    const double here = cost(at);
    if (here < least) {
      least = here;
      best = at;
    }
  }
  constexpr int kBits = 20;
  std::uintmax_t most = 60;
  const double log_tau =
      boost::math::tools::brent_find_minima(cost, best - width, best + width, kBits, most).first;
  return {std::exp(log_tau), Solve(logs, std::exp(log_tau))};
}

// The covariance of two estimates over what leaving one out gives, Tukey's jackknife.
double Jackknife(const std::vector<double>& one, const std::vector<double>& two) {
  const auto n = static_cast<double>(one.size());
  if (n < 3.0) return std::numeric_limits<double>::quiet_NaN();
  double mean_one = 0.0;
  double mean_two = 0.0;
  for (const double value : one) mean_one += value / n;
  for (const double value : two) mean_two += value / n;
  double products = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k)
    products += (one[k] - mean_one) * (two[k] - mean_two);
  return (n - 1.0) / n * products;
}

}  // namespace

namespace {

// With or without the reversible heat, as the cell has it.
std::optional<HeatFit> FitHeatOf(const Cell& one, const std::vector<LoadedLog>& logs) {
  std::vector<const LoadedLog*> used;
  for (const LoadedLog& log : logs) {
    const Record& record = log.log.record;
    if (log.entry.kind == LogKind::kValidation || record.temperature_degC.empty()) continue;
    if (record.size() > 2) used.push_back(&log);
  }
  std::vector<Warming> all(used.size());
  ParallelFor(used.size(), [&](std::size_t l) { all[l] = WarmingOf(one, *used[l]); });
  HeatFit fit;
  fit.logs = all.size();
  std::vector<const Warming*> seen;
  for (const Warming& log : all) {
    seen.push_back(&log);
    const double most_K = *std::max_element(log.above_K.begin(), log.above_K.end());
    fit.largest_rise_K = std::max(fit.largest_rise_K, most_K - log.above_K.front());
  }
  if (fit.largest_rise_K < kLeastRise_K) return std::nullopt;
  const Found best = Search(seen);
  if (!std::isfinite(best.at.mean_square_K2)) return std::nullopt;
  const auto balance_of = [](const Found& found) {
    return HeatBalance<double>{
        .heat_capacity_J_per_K = found.tau_s / found.at.thermal_resistance_K_per_W,
        .thermal_resistance_K_per_W = found.at.thermal_resistance_K_per_W};
  };
  fit.balance = balance_of(best);
  fit.rmse_K = std::sqrt(best.at.mean_square_K2);
  std::vector<double> capacities;
  std::vector<double> resistances;
  for (std::size_t l = 0; l < seen.size() && seen.size() > 2; ++l) {
    auto rest = seen;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(l));
    const Found without = Search(rest);
    if (!std::isfinite(without.at.mean_square_K2)) continue;
    capacities.push_back(balance_of(without).heat_capacity_J_per_K);
    resistances.push_back(without.at.thermal_resistance_K_per_W);
  }
  fit.heat_capacity_standard_error_J_per_K = std::sqrt(Jackknife(capacities, capacities));
  fit.thermal_resistance_standard_error_K_per_W = std::sqrt(Jackknife(resistances, resistances));
  fit.covariance_s = Jackknife(capacities, resistances);
  return fit;
}

}  // namespace

std::optional<HeatFit> FitHeat(const Cell& cell, const std::vector<LoadedLog>& logs) {
  Require(cell.temperature.has_value(), "a cell that knows temperature");
  Cell one = cell;
  one.series = one.parallel = 1;
  auto with = FitHeatOf(one, logs);
  if (with) with->rmse_reversible_K = with->rmse_K;
  if (!one.temperature->entropy) return with;
  one.temperature->entropy->reversible_heat = false;
  auto without = FitHeatOf(one, logs);
  if (!without || (with && with->rmse_K <= without->rmse_K)) return with;
  without->reversible = false;
  without->rmse_reversible_K = with ? with->rmse_K : std::numeric_limits<double>::quiet_NaN();
  return without;
}

}  // namespace lipoid
