#include "tools/commands/trust_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "model/core/options.h"
#include "tools/cli/text_table.h"

namespace lipoid {

std::string TrustText(const TrustReport& report) {
  using cli::Align;
  using cli::Significant;
  if (report.quantities.empty()) return "";
  cli::TextTable table({{"trust", Align::kLeft},
                        {"estimate"},
                        {"std. error"},
                        {"95 % from"},
                        {"to"},
                        {"unit", Align::kLeft},
                        {"verdict", Align::kLeft}});
  const auto number = [](double value, int digits) {
    return std::isfinite(value) ? Significant(value, digits) : std::string("-");
  };
  for (const auto& q : report.quantities) {
    std::string verdict = options_internal::ToText(q.verdict);
    if (!q.with.empty()) verdict += fmt::format(" {}", fmt::join(q.with, ", "));
    table.Row({"   " + q.name,
               number(q.estimate, 5),
               number(q.standard_error, 2),
               number(q.low, 6),
               number(q.high, 6),
               q.unit,
               verdict});
  }
  return table.Text() +
         (report.sentence.empty() ? "" : cli::Bullets("", {report.sentence}).substr(1));
}

}  // namespace lipoid
