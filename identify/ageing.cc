#include "identify/ageing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/battery/arrhenius.h"
#include "model/battery/fit_record.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

struct Estimate {
  double value = kNaN;
  double low = kNaN;
  double high = kNaN;
  double temperature_degC = kNaN;  // NaN: not known
};

// What is further apart in temperature is not compared. Of cells that know temperature, whose numbers are of one;
// and where one does not, which is as warm as its logs were: in one chamber an old cell warms more than a young one.
// Two degrees are 3 to 6 % of a resistance.
constexpr double kSameByLaw_K = 0.5;
constexpr double kSameByLogs_K = 2.0;

double NumberOr(const Json& json, double otherwise) {
  return json.is_number() ? json.get<double>() : otherwise;
}

void TakeInterval(const Json& entry, double scale, Estimate& estimate) {
  if (!entry.contains("interval_95") || !entry["interval_95"].is_array() ||
      entry["interval_95"].size() != 2)
    return;
  estimate.low = scale * NumberOr(entry["interval_95"][0], kNaN);
  estimate.high = scale * NumberOr(entry["interval_95"][1], kNaN);
}

Estimate Parameter(const Cell& cell, const char* name, double value, double scale) {
  Estimate estimate{.value = scale * value};
  const Json& parameters = FitMetric(cell, "parameters");
  if (!parameters.is_array()) return estimate;
  for (const Json& entry : parameters) {
    if (entry.is_object() && entry.value("name", "") == name) TakeInterval(entry, scale, estimate);
  }
  return estimate;
}

// At which its numbers hold.
double TemperatureOf(const Cell& cell) {
  if (cell.temperature) return cell.temperature->reference_K - kZeroCelsius_K;
  return cell.reference_degC.value_or(kNaN);
}

Estimate Capacity(const Cell& cell) {
  Estimate estimate = Parameter(cell, "alpha", cell.alpha_C(), 1.0 / 3600.0);
  estimate.temperature_degC = TemperatureOf(cell);
  return estimate;
}

// Resistances are those at half charge, so that they are of one place only where it is known how far apart the
// halves may be: by intervals of the capacities, which those of the resistances hold, or because they are the same.
bool ShareHalfCharge(const Cell& a, const Cell& b) {
  constexpr double kSame = 0.01;
  const Estimate first = Capacity(a);
  const Estimate now = Capacity(b);
  const auto known = [](const Estimate& e) {
    return std::isfinite(e.low) && std::isfinite(e.high);
  };
  return (known(first) && known(now)) || std::abs(now.value / first.value - 1.0) <= kSame;
}

Estimate Beta(const Cell& cell) {
  Estimate estimate =
      Parameter(cell, "beta", cell.diffusion ? cell.diffusion->beta_per_sqrt_s : kNaN, 1.0);
  estimate.temperature_degC = TemperatureOf(cell);
  return estimate;
}

Estimate ResistanceAfterPulse(const Cell& cell, double after_s) {
  Estimate estimate{.temperature_degC = TemperatureOf(cell)};
  const Json& resistances = FitMetric(cell, "resistance");
  if (!resistances.is_array()) return estimate;
  for (const Json& entry : resistances) {
    if (!entry.is_object() || NumberOr(entry.value("after_s", Json()), kNaN) != after_s) continue;
    estimate.value = NumberOr(entry.value("resistance_Ohm", Json()), kNaN);
    estimate.temperature_degC =
        NumberOr(entry.value("temperature_degC", Json()), estimate.temperature_degC);
    TakeInterval(entry, 1.0, estimate);
  }
  return estimate;
}

// The interval of a ratio to the first: each side by the sides that make it. On a scale of logarithms, on
// which no quantity falls below zero.
AgedValue Against(const Estimate& first, const Estimate& now, bool is_first) {
  AgedValue aged{.value = now.value,
                 .low = now.low,
                 .high = now.high,
                 .change_percent = 100.0 * (now.value - first.value) / first.value,
                 .change_low_percent = kNaN,
                 .change_high_percent = kNaN,
                 .verdict = ChangeVerdict::kNoInterval};
  if (is_first) {
    aged.verdict = ChangeVerdict::kFirst;
    return aged;
  }
  const auto apart = [](double high, double low) {
    return low > 0.0 ? std::log(high / low) : high / std::max(low, 0.0);  // infinite, or not known
  };
  const double down = std::hypot(apart(now.value, now.low), apart(first.high, first.value));
  const double up = std::hypot(apart(now.high, now.value), apart(first.value, first.low));
  if (std::isnan(down) || std::isnan(up)) return aged;
  const double ratio = now.value / first.value;
  aged.change_low_percent = 100.0 * (ratio * std::exp(-down) - 1.0);
  aged.change_high_percent = 100.0 * (ratio * std::exp(up) - 1.0);
  const bool holds_zero = aged.change_low_percent <= 0.0 && aged.change_high_percent >= 0.0;
  aged.verdict = holds_zero ? ChangeVerdict::kNotShown : ChangeVerdict::kChanged;
  return aged;
}

AgedValue Alone(const Estimate& now, ChangeVerdict because) {
  return {.value = now.value,
          .low = now.low,
          .high = now.high,
          .change_percent = kNaN,
          .change_low_percent = kNaN,
          .change_high_percent = kNaN,
          .verdict = because};
}

// Of what a capacity may have become.
constexpr double kMostGrowth_percent = 5.0;
constexpr double kMostLoss_percent = 50.0;

}  // namespace

std::vector<std::pair<std::size_t, std::string>> DoubtsAboutAges(
    const std::vector<AgedQuantity>& quantities) {
  std::vector<std::pair<std::size_t, std::string>> doubts;
  for (const AgedQuantity& quantity : quantities) {
    if (quantity.name != "capacity") continue;
    for (std::size_t k = 1; k < quantity.at.size(); ++k) {
      const AgedValue& aged = quantity.at[k];
      if (aged.change_percent > kMostGrowth_percent &&
          !(aged.change_low_percent <= kMostGrowth_percent)) {
        doubts.emplace_back(
            k,
            fmt::format("has {:.0f} % more capacity than the first: are both one cell, "
                        "and the youngest first?",
                        aged.change_percent));
      } else if (aged.change_percent < -kMostLoss_percent) {
        doubts.emplace_back(
            k,
            fmt::format("has {:.0f} % less capacity than the first: are both one cell?",
                        -aged.change_percent));
      }
    }
  }
  return doubts;
}

std::string DoubtAboutTemperatures(const std::vector<Cell>& cells) {
  std::vector<std::string> silent;
  for (const Cell& cell : cells) {
    if (std::isnan(TemperatureOf(cell)))
      silent.push_back(AgeOf(cell).empty() ? cell.name : AgeOf(cell));
  }
  if (silent.empty() || cells.size() < 2) return "";
  constexpr std::string_view kTell = "(temperature_degC, or ambient_degC in the campaign)";
  if (silent.size() == cells.size()) {
    return fmt::format(
        "no cell file says at which temperature its logs were {}: a change may be one of the temperature, 6 K of "
        "which are a sixth of a resistance",
        kTell);
  }
  return fmt::format(
      "{} {} not say at which temperature the logs were {}, and others do: these are not compared, because 6 K "
      "are a sixth of a resistance",
      fmt::join(silent, ", "),
      silent.size() == 1 ? "does" : "do",
      kTell);
}

std::string AgeOf(const Cell& cell) {
  const Json& age = FitMetric(cell, "age");
  return age.is_string() ? age.get<std::string>() : "";
}

std::vector<AgedQuantity> CompareAges(const std::vector<Cell>& cells) {
  Require(!cells.empty(), "at least one cell");
  std::vector<AgedQuantity> quantities;
  const auto add = [&](std::string name,
                       std::string what,
                       std::string unit,
                       double same_by_law_K,
                       auto&& estimate_of) {
    AgedQuantity quantity{std::move(name), std::move(what), std::move(unit), {}};
    const Estimate first = estimate_of(cells.front());
    bool known = false;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Estimate now = estimate_of(cells[k]);
      // Where one cell does not know at which temperature it was seen, nobody knows that they are alike.
      const double off_K = std::abs(now.temperature_degC - first.temperature_degC);
      const bool both_unknown =
          std::isnan(now.temperature_degC) && std::isnan(first.temperature_degC);
      const bool unknown = std::isnan(off_K) && !both_unknown;
      const bool by_law = cells.front().temperature && cells[k].temperature;
      const bool apart = off_K > (by_law ? same_by_law_K : kSameByLogs_K);
      const bool poor = IsOfPoorFit(cells.front()) || IsOfPoorFit(cells[k]);
      quantity.at.push_back(poor                      ? Alone(now, ChangeVerdict::kPoorFit)
                            : std::isnan(now.value)   ? Alone(now, ChangeVerdict::kNotKnown)
                            : std::isnan(first.value) ? Alone(now, ChangeVerdict::kFirstNotKnown)
                            : unknown ? Alone(now, ChangeVerdict::kTemperatureNotKnown)
                            : apart   ? Alone(now, ChangeVerdict::kOtherTemperature)
                                      : Against(first, now, k == 0));
      known = known || std::isfinite(quantity.at.back().value);
    }
    if (known) quantities.push_back(std::move(quantity));
  };
  // Cells that know temperature have one capacity at every temperature.
  add("capacity", "capacity", "Ah", kInfinity, &Capacity);
  add("beta", "beta", "s^-1/2", kSameByLaw_K, &Beta);
  for (const double after_s : {1.0, 10.0, 30.0}) {
    add(fmt::format("resistance_{:g}s", after_s),
        fmt::format("resistance after {:g} s", after_s),
        "Ohm",
        kSameByLaw_K,
        [&](const Cell& cell) {
          Estimate estimate = ResistanceAfterPulse(cell, after_s);
          if (!ShareHalfCharge(cells.front(), cell)) estimate.low = estimate.high = kNaN;
          return estimate;
        });
  }
  return quantities;
}

}  // namespace lipoid
