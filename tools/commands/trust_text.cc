#include "tools/commands/trust_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/core/options.h"
#include "tools/cli/text_table.h"

namespace lipoid {

using cli::Align;
using cli::Significant;

std::string VerdictText(const QuantityTrust& quantity) {
  if (quantity.verdict != Verdict::kOnlyInCombination)
    return options_internal::ToText(quantity.verdict);
  std::string names;
  for (const auto& name : quantity.with) names += (names.empty() ? "" : ", ") + name;
  return "only with " + names;
}

namespace {

// Down to a tenth of the error: the ends of a narrow interval must not look alike.
int Digits(double estimate, double error) {
  const double share = std::abs(estimate) / error;
  if (!std::isfinite(share)) return 5;
  return std::clamp(static_cast<int>(std::log10(std::max(share, 1.0))) + 2, 4, 9);
}

// An end that is nowhere is said as such, not as a missing number.
std::string End(double value, int digits) {
  return std::isinf(value) ? std::string("unknown") : Significant(value, digits);
}

}  // namespace

std::string KnownText(const Identification& found) {
  cli::TextTable table({{"what the logs know", Align::kLeft},
                        {"value"},
                        {"95 % from"},
                        {"to"},
                        {"unit", Align::kLeft}},
                       "What the logs know of the cell.");
  const auto row =
      [&](const std::string& what, double value, double low, double high, const std::string& unit) {
        const int digits = Digits(value, 0.5 * std::max(high - value, value - low));
        table.Row({"   " + what,
                   Significant(value, std::min(digits, 6)),
                   std::isnan(low) ? "-" : End(low, digits),
                   std::isnan(high) ? "-" : End(high, digits),
                   unit});
      };
  constexpr double kAhPerC = 1.0 / 3600.0;
  const double alpha_C = found.joint ? found.joint->alpha_C : found.staged->alpha_C;
  double low_C = std::numeric_limits<double>::quiet_NaN();
  double high_C = low_C;
  for (const QuantityTrust& q : found.trust.quantities) {
    if (q.name != "alpha") continue;
    low_C = q.low;
    high_C = q.high;
  }
  row("charge alpha", kAhPerC * alpha_C, kAhPerC * low_C, kAhPerC * high_C, "Ah");
  for (const PulseResistance& r : found.trust.resistance) {
    const std::string warmth =
        r.temperature_degC ? fmt::format(", {:.3g} degC", *r.temperature_degC) : std::string();
    row(fmt::format("resistance at half charge after {:g} s of {} A{}",
                    r.after_s,
                    Significant(r.current_A, 3),
                    warmth),
        1e3 * r.resistance_Ohm,
        1e3 * r.low_Ohm,
        1e3 * r.high_Ohm,
        "mOhm");
  }
  const ExpectedError& error = found.expected_error;
  if (std::isfinite(error.percent)) {
    const std::string part = found.fitted_part();
    row("mean error to expect of new " + (part.empty() ? "logs of these kinds" : part),
        error.percent,
        error.low_percent,
        error.high_percent,
        "%");
  }
  return table.Text();
}

std::string TrustText(const TrustReport& report, const std::string& exact) {
  if (report.quantities.empty()) return "";
  cli::TextTable table({{"parameter", Align::kLeft},
                        {"estimate"},
                        {"std. error"},
                        {"95 % from"},
                        {"to"},
                        {"unit", Align::kLeft},
                        {"identifiability", Align::kLeft}},
                       "Parameters of the cell with intervals of 95 %.");
  for (const auto& q : report.quantities) {
    const int digits = Digits(q.estimate, q.standard_error);
    table.Row({"   " + q.name,
               Significant(q.estimate, digits),
               std::isinf(q.standard_error) ? "unknown" : Significant(q.standard_error, 2),
               End(q.low, digits),
               End(q.high, digits),
               q.unit,
               VerdictText(q)});
  }
  std::vector<std::string> sentences{report.sentence};
  if (!exact.empty()) sentences.push_back(fmt::format("the intervals take {} as exact", exact));
  std::string text = table.Text();
  const std::string bullets = cli::Bullets("", sentences);
  return text + bullets.substr(1);  // no title
}

}  // namespace lipoid
