#include "tools/commands/trust_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
