#include "identify/synthesis/protocols.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kForever_s = std::numeric_limits<double>::infinity();

std::vector<double> ParseRates(const std::string& text) {
  std::vector<double> rates;
  for (std::size_t from = 0; from <= text.size();) {
    const auto to = std::min(text.find(',', from), text.size());
    rates.push_back(
        options_internal::ParseDouble("rates_C", text.substr(from, to - from), Range{1e-6, 1e4}));
    if (std::count(rates.begin(), rates.end(), rates.back()) > 1) {
      throw OptionError(fmt::format("option rates_C: {} stands twice in '{}'", rates.back(), text));
    }
    from = to + 1;
  }
  return rates;
}

// The double nearest to x with so many significant digits: 6 * 0.6 A is 3.6 A.
double RoundToDigits(double x, int digits) {
  const auto text = fmt::format("{:.{}e}", x, digits - 1);
  std::from_chars(text.data(), text.data() + text.size(), x);
  return x;
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

std::vector<TestPlan> ThesisProtocol(const Cell& cell, const SynthesisOptions& options) {
  std::vector<double> rates_C;
  if (options.rates_C.empty()) {
    for (double rate = 1.0; rate <= HighestSuitableRate(cell); rate += 1.0) rates_C.push_back(rate);
  } else {
    rates_C = ParseRates(options.rates_C);
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
  const double pulse_C =
      options.pulse_rate_C > 0.0 ? options.pulse_rate_C : HighestSuitableRate(cell);
  plans.push_back({LogKind::kPulses,
                   "pulses.csv",
                   {{CurrentAtRate(cell, pulse_C), options.pulse_s}, {0.0, options.rest_s}}});
  return plans;
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
