#include "identify/synthesis/protocols.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/battery/at_temperature.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/significant_digits.h"

namespace lipoid {
namespace {

constexpr double kForever_s = std::numeric_limits<double>::infinity();

std::vector<double> ParseList(const char* option, const std::string& text, const Range& valid) {
  std::vector<double> values;
  for (std::size_t from = 0; from <= text.size();) {
    const auto to = std::min(text.find(',', from), text.size());
    values.push_back(options_internal::ParseDouble(option, text.substr(from, to - from), valid));
    if (std::count(values.begin(), values.end(), values.back()) > 1) {
      throw OptionError(
          fmt::format("option {}: {} stands twice in '{}'", option, values.back(), text));
    }
    from = to + 1;
  }
  return values;
}

double CurrentAtRate(const Cell& cell, double rate_C) {
  return RoundToDigits(rate_C * cell.capacity_Ah, 12);
}

}  // namespace

double HighestSuitableRate(const Cell& cell) {
  constexpr double kDrop_V = 0.5;
  const auto drop_V = [&](double rate_C) {
    const double current_A = rate_C * cell.capacity_Ah;
    const double ohmic_V = cell.series_resistance_Ohm(1.0) * current_A;
    return cell.charge_transfer ? ohmic_V + cell.charge_transfer->Drop(1.0, current_A) : ohmic_V;
  };
  double rate_C = 8.0;
  while (rate_C > 1.0 && drop_V(rate_C) > kDrop_V) rate_C -= 1.0;
  return rate_C;
}

double HighestSuitableRate(const Cell& cell, const std::vector<double>& ambient_degC) {
  if (ambient_degC.empty()) return HighestSuitableRate(cell);
  return HighestSuitableRate(
      AtOneTemperature(cell, *std::min_element(ambient_degC.begin(), ambient_degC.end())));
}

std::vector<TestPlan> ThesisProtocol(const Cell& cell, const SynthesisOptions& options) {
  std::vector<double> ambients_degC;
  if (!options.ambient_degC.empty())
    ambients_degC = ParseList("ambient_degC", options.ambient_degC, kTemperatures_degC);
  const double highest_C = HighestSuitableRate(cell, ambients_degC);
  std::vector<double> rates_C;
  if (options.rates_C.empty()) {
    for (double rate = 1.0; rate <= highest_C; rate += 1.0) rates_C.push_back(rate);
  } else {
    rates_C = ParseList("rates_C", options.rates_C, Range{1e-6, 1e4});
  }
  std::vector<TestPlan> plans;
  plans.reserve(rates_C.size() + 2);
  for (const double rate : rates_C) {
    plans.push_back({LogKind::kConstantCurrent,
                     fmt::format("cc_{}C.csv", rate),
                     {{CurrentAtRate(cell, rate), kForever_s}}});
  }
  const double low_A = RoundToDigits(cell.alpha_C() / (3600.0 * options.low_rate_h), 3);
  plans.push_back({LogKind::kLowRate, "low_rate.csv", {{low_A, kForever_s}}});
  const double pulse_C = options.pulse_rate_C > 0.0 ? options.pulse_rate_C : highest_C;
  plans.push_back({LogKind::kPulses,
                   "pulses.csv",
                   {{CurrentAtRate(cell, pulse_C), options.pulse_s}, {0.0, options.rest_s}}});
  if (ambients_degC.empty()) return plans;
  const TestPlan pulses = plans.back();
  for (TestPlan& plan : plans) plan.ambient_degC = ambients_degC.front();
  for (std::size_t k = 1; k < ambients_degC.size(); ++k)
    plans.push_back(AtAnotherTemperature(pulses, ambients_degC[k]));
  return plans;
}

TestPlan AtAnotherTemperature(TestPlan plan, double ambient_degC) {
  plan.file.insert(plan.file.rfind('.'), fmt::format("_{}degC", ambient_degC));
  plan.ambient_degC = ambient_degC;
  return plan;
}

const Protocol& FindProtocol(std::string_view name) {
  std::string known;
  for (const auto& protocol : kProtocols) {
    if (protocol.name == name) return protocol;
    known += (known.empty() ? "" : ", ") + std::string(protocol.name);
  }
  throw OptionError(fmt::format("option --protocol: expected one of {}, found '{}'", known, name));
}

}  // namespace lipoid
