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

std::string KnownText(const Identification& found) {
  cli::TextTable table({{"what the logs know", Align::kLeft},
                        {"value"},
                        {"95 % from"},
                        {"to"},
                        {"unit", Align::kLeft}});
  const auto end = [](double value) {
    return std::isfinite(value) ? Significant(value, 3) : std::string("unknown");
  };
  const double per_Ah = 1.0 / 3600.0;
  const double alpha_C = found.joint ? found.joint->alpha_C : found.staged->alpha_C;
  double low_C = std::numeric_limits<double>::quiet_NaN();
  double high_C = low_C;
  for (const QuantityTrust& q : found.trust.quantities) {
    if (q.name != "alpha") continue;
    low_C = q.low;
    high_C = q.high;
  }
  const auto charge = [&](double value_C) {
    return std::isfinite(value_C) ? Significant(value_C * per_Ah, 4) : std::string("-");
  };
  table.Row({"   charge alpha", charge(alpha_C), charge(low_C), charge(high_C), "Ah"});
  for (const PulseResistance& r : found.trust.resistance) {
    table.Row({fmt::format("   resistance at half charge after {} s of {} A",
                           fmt::format("{:g}", r.after_s),
                           Significant(r.current_A, 3)),
               Significant(1e3 * r.resistance_Ohm, 4),
               end(1e3 * r.low_Ohm),
               end(1e3 * r.high_Ohm),
               "mOhm"});
  }
  const ExpectedError& error = found.expected_error;
  if (std::isfinite(error.percent)) {
    table.Row({"   mean error to expect of new logs of these kinds",
               Significant(error.percent, 2),
               end(error.low_percent),
               end(error.high_percent),
               "%"});
  }
  return table.Text();
}

std::string TrustText(const TrustReport& report, const std::string& exact) {
  if (report.quantities.empty()) return "";
  cli::TextTable table({{"trust", Align::kLeft},
                        {"estimate"},
                        {"std. error"},
                        {"95 % from"},
                        {"to"},
                        {"unit", Align::kLeft},
                        {"verdict", Align::kLeft}});
  // An end that is nowhere is said as such, not as a missing number.
  const auto end = [](double value, int digits) {
    return std::isinf(value) ? std::string("unknown") : Significant(value, digits);
  };
  for (const auto& q : report.quantities) {
    // Down to a tenth of the standard error: the ends of a narrow interval must not look alike.
    int digits = 5;
    if (const double share = std::abs(q.estimate) / q.standard_error; std::isfinite(share))
      digits = std::clamp(static_cast<int>(std::log10(std::max(share, 1.0))) + 2, 4, 9);
    table.Row({"   " + q.name,
               Significant(q.estimate, digits),
               std::isinf(q.standard_error) ? "unknown" : Significant(q.standard_error, 2),
               end(q.low, digits),
               end(q.high, digits),
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
