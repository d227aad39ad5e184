#include "tools/commands/truth_table.h"

#include <fmt/format.h>

#include "tools/cli/text_table.h"

namespace lipoid {

std::string TruthTable(const CellComparison& comparison) {
  using cli::Align;
  using cli::Significant;
  cli::TextTable table(
      {{"parameter", Align::kLeft}, {"unit", Align::kLeft}, {"truth"}, {"estimate"}, {"error / %"}},
      "The cell that was identified, beside the one that made the logs.");
  const auto text = [](const std::optional<double>& value, int digits) {
    return value ? Significant(*value, digits) : std::string("-");
  };
  for (const auto& one : comparison.parameters) {
    table.Row({one.name,
               one.unit,
               text(one.truth, 5),
               text(one.estimate, 5),
               one.error_percent ? fmt::format("{:+.2g}", *one.error_percent) : "-"});
  }
  return table.Text() + fmt::format("v_oc after equal charge: {} mV rms, {} mV at most\n",
                                    Significant(1e3 * comparison.open_circuit_rms_V, 3),
                                    Significant(1e3 * comparison.open_circuit_max_V, 3));
}

}  // namespace lipoid
