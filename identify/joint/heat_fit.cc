#include "identify/joint/heat_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>

#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

// A log as the heat balance sees it: heat that flows before each row, and how far the cell is above
// its surroundings there.
struct Warming {
  std::vector<double> dt_s;
  std::vector<double> heat_W;
  std::vector<double> above_K;
};

// After a step of the current diffusion and branches grow from nothing, within a row or two where rows are far apart.
constexpr std::array kAfterAChange{1.0 / 256.0, 1.0 / 64.0, 1.0 / 16.0, 0.25, 0.5};

Warming WarmingOf(const Cell& cell, const LoadedLog& log) {
  const Record& record = log.log.record;
  const CellModel<double> model(cell.Parameters());
  const Surroundings measured{.measured_degC = record.temperature_degC};
  RecordStepper<double> stepper(
      model, record.hold, StartAmong(model, log.entry.initial_soc, measured));
  const double first_degC = record.temperature_degC.front();
  const double ambient_degC =
      log.ambient_doubted ? first_degC : log.entry.ambient_degC.value_or(first_degC);
  Warming of;
  double flowed_before_A = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double now_K = record.temperature_degC[k] + kZeroCelsius_K;
    double dt_s = 0.0;
    double mean_W = 0.0;
    if (k == 0) {
      stepper.Row(record.time_s[k], record.current_A[k], now_K);
    } else {
      const double flowed_A = record.current_A[record.hold == Hold::kBackward ? k : k - 1];
      const double before_K = record.temperature_degC[k - 1] + kZeroCelsius_K;
      dt_s = record.time_s[k] - record.time_s[k - 1];
      double at = 0.0;
      double at_W = model.Heat(stepper.state(), flowed_A);
      // To this share of the step.
      const auto advance = [&](double to, double time_s, double current_A) {
        stepper.Row(time_s, current_A, before_K + to * (now_K - before_K));
        const double then_W = model.Heat(stepper.state(), flowed_A);
        mean_W += (to - at) * 0.5 * (at_W + then_W);
        at_W = then_W;
        at = to;
      };
      if (flowed_A != flowed_before_A) {
        for (const double to : kAfterAChange)
          advance(to, record.time_s[k - 1] + to * dt_s, flowed_A);
      }
      advance(1.0, record.time_s[k], record.current_A[k]);
      flowed_before_A = flowed_A;
    }
    of.dt_s.push_back(dt_s);
    of.heat_W.push_back(mean_W);
    of.above_K.push_back(record.temperature_degC[k] - ambient_degC);
  }
  return of;
}

// R_th and the squared error for a time constant; logs count the same.
struct AtTau {
  double tau_s = 0.0;
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
  return {
      tau_s, with_rest / with_itself, std::max(rest - with_rest * with_rest / with_itself, 0.0)};
}

AtTau Search(const std::vector<const Warming*>& logs) {
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
  return Solve(logs, std::exp(log_tau));
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

// The logs that tell of heat, and by how much the warmest of them rises.
struct AllWarming {
  std::vector<Warming> logs;
  double largest_rise_K = 0.0;
};

AllWarming WarmingOfAll(const Cell& pack, const std::vector<LoadedLog>& logs) {
  const Cell one = pack.AsOne();
  std::vector<const LoadedLog*> used;
  for (const LoadedLog& log : logs) {
    const Record& record = log.log.record;
    if (log.entry.kind == LogKind::kValidation || record.temperature_degC.empty() ||
        log.temperature_predicted)
      continue;
    if (record.size() > 2) used.push_back(&log);
  }
  AllWarming all{.logs = std::vector<Warming>(used.size())};
  ParallelFor(used.size(), [&](std::size_t l) { all.logs[l] = WarmingOf(one, *used[l]); });
  for (const Warming& log : all.logs) {
    const double most_K = *std::max_element(log.above_K.begin(), log.above_K.end());
    all.largest_rise_K = std::max(all.largest_rise_K, most_K - log.above_K.front());
  }
  return all;
}

// With or without the reversible heat, as the cell has it.
std::optional<HeatFit> FitHeatOf(const Cell& one, const std::vector<LoadedLog>& logs) {
  const AllWarming all = WarmingOfAll(one, logs);
  HeatFit fit;
  fit.logs = all.logs.size();
  fit.largest_rise_K = all.largest_rise_K;
  if (fit.largest_rise_K < kLeastRise_K) return std::nullopt;
  std::vector<const Warming*> seen;
  for (const Warming& log : all.logs) seen.push_back(&log);
  const AtTau best = Search(seen);
  if (!std::isfinite(best.mean_square_K2)) return std::nullopt;
  const auto balance_of = [](const AtTau& found) {
    return HeatBalance<double>{
        .heat_capacity_J_per_K = found.tau_s / found.thermal_resistance_K_per_W,
        .thermal_resistance_K_per_W = found.thermal_resistance_K_per_W};
  };
  fit.balance = balance_of(best);
  fit.rmse_K = std::sqrt(best.mean_square_K2);
  std::vector<double> capacities;
  std::vector<double> resistances;
  for (std::size_t l = 0; l < seen.size() && seen.size() > 2; ++l) {
    auto rest = seen;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(l));
    const AtTau without = Search(rest);
    if (!std::isfinite(without.mean_square_K2)) continue;
    capacities.push_back(balance_of(without).heat_capacity_J_per_K);
    resistances.push_back(without.thermal_resistance_K_per_W);
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

std::optional<HeatFit> PlanHeat(const Cell& cell,
                                const std::vector<LoadedLog>& logs,
                                double temperature_noise_K) {
  if (!cell.temperature || !cell.temperature->heat) return std::nullopt;
  const AllWarming all = WarmingOfAll(cell, logs);
  HeatFit fit;
  fit.balance = *cell.temperature->heat;
  fit.logs = all.logs.size();
  fit.largest_rise_K = all.largest_rise_K;
  if (fit.largest_rise_K < kLeastRise_K) return std::nullopt;
  const double r_th = fit.balance.thermal_resistance_K_per_W;
  const double c_th = fit.balance.heat_capacity_J_per_K;
  const double tau_s = c_th * r_th;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();  // of the scores, per noise²
  for (const Warming& log : all.logs) {
    const auto rows = static_cast<double>(log.dt_s.size());
    const double weight = 1.0 / rows;
    // T = R y + T_0 e^(-t/tau), where y, the low pass of the heat, and T_0, the first row, which is
    // no better measured than the others.
    double y_W = 0.0;
    double y_by_tau = 0.0;
    double start = 1.0;
    double start_by_tau = 0.0;
    Eigen::Vector2d of_first = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < log.dt_s.size(); ++k) {
      const double decay = std::exp(-log.dt_s[k] / tau_s);
      const double decay_by_tau = decay * log.dt_s[k] / (tau_s * tau_s);
      y_by_tau = decay * y_by_tau + decay_by_tau * (y_W - log.heat_W[k]);
      y_W = decay * y_W + (1.0 - decay) * log.heat_W[k];
      start_by_tau = decay * start_by_tau + decay_by_tau * start;
      start *= decay;
      const double by_tau = r_th * y_by_tau + log.above_K.front() * start_by_tau;
      // tau = C R.
      const Eigen::Vector2d by(r_th * by_tau, y_W + c_th * by_tau);
      information += weight * by * by.transpose();
      scatter += weight * weight * by * by.transpose();
      of_first -= weight * start * by;
    }
    // In the first row itself the error and what it does to the prediction are the same.
    scatter += of_first * of_first.transpose();
  }
  const Eigen::Matrix2d inverse = information.inverse();
  const Eigen::Matrix2d covariance =
      temperature_noise_K * temperature_noise_K * inverse * scatter * inverse;
  fit.heat_capacity_standard_error_J_per_K = std::sqrt(covariance(0, 0));
  fit.thermal_resistance_standard_error_K_per_W = std::sqrt(covariance(1, 1));
  fit.covariance_s = covariance(0, 1);
  return fit;
}

}  // namespace lipoid
