#include "tools/commands/joint_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/battery/cell_parameters.h"
#include "tools/cli/text_table.h"
#include "tools/commands/identify_report.h"
#include "tools/commands/trust_text.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;
using cli::TextTable;

std::string TriedText(const JointChoice& choice) {
  // beta and tau_j of each stand in the summary.
  TextTable table(
      {{"structure tried (errors in mV)", Align::kLeft}, {"fitted"}, {"held out"}, {"gain"}},
      "Structures that were tried, and how well they predict logs held out.");
  for (const auto& row : choice.tried) {
    table.Row({(row.taken ? "=> " : "   ") + row.what,
               Significant(1e3 * row.errors.fitted_V, 3),
               Significant(1e3 * row.errors.left_out_V, 3),
               std::isnan(row.gain.standard_error)
                   ? "-"
                   : fmt::format("{} +- {}",
                                 Significant(1e3 * row.gain.gain, 2),
                                 Significant(1e3 * row.gain.standard_error, 2))});
  }
  return table.Text();
}

// A constant, or what a table spans.
std::string RangeText(const Resistance<double>& r) {
  if (r.constant()) return Significant(r.resistance_Ohm[0], 5);
  const auto [least, most] = std::minmax_element(r.resistance_Ohm.begin(), r.resistance_Ohm.end());
  return fmt::format("{} .. {} ({} at half charge)",
                     Significant(*least, 3),
                     Significant(*most, 3),
                     Significant(r(0.5), 4));
}

std::string FoundText(const JointResult& result) {
  const Cell& cell = result.cell;
  TextTable table({{"found", Align::kLeft}, {"", Align::kLeft}}, "The cell.");
  const auto row = [&](const std::string& name, const std::string& value) {
    table.Row({"   " + name, value});
  };
  row("alpha / C",
      fmt::format("{} ({})",
                  Significant(result.alpha_C, 6),
                  result.alpha_source != "cut-off" ? AlphaSourceInWords(result.alpha_source)
                  : result.cutoff.extrapolated
                      ? "A = 0 where the last slope of v_oc reaches the cut-off"
                      : "A = 0 where v_oc is the cut-off"));
  for (const std::string& name : CellResistanceNames(cell))
    row(name + " / Ohm", RangeText(*CellResistance(cell, name)));
  for (const std::string& name : CellParameterNames(cell)) {
    if (name == "alpha" || name.starts_with("c_") || CellResistance(cell, name) != nullptr)
      continue;
    row(fmt::format("{} / {}", name, CellParameterUnit(name)),
        Significant(*CellParameter(cell, name), 5));
  }
  if (const auto& heat = result.heat) {
    row("heat capacity / J/K",
        fmt::format("{} +- {}",
                    Significant(heat->balance.heat_capacity_J_per_K, 3),
                    Significant(heat->heat_capacity_standard_error_J_per_K, 2)));
    row("thermal resistance / K/W",
        fmt::format("{} +- {}, temperatures to {} degC rms",
                    Significant(heat->balance.thermal_resistance_K_per_W, 3),
                    Significant(heat->thermal_resistance_standard_error_K_per_W, 2),
                    Significant(heat->rmse_K, 2)));
  }
  row("v_oc(A)",
      fmt::format("{} nodes, {} .. {} V",
                  cell.open_circuit_voltage.soc().size(),
                  Significant(cell.open_circuit_voltage(cell.open_circuit_voltage.soc_lo()), 4),
                  Significant(cell.open_circuit_voltage(cell.open_circuit_voltage.soc_hi()), 4)));
  return table.Text() + fmt::format("   {} evaluations, {} s with the staged run\n",
                                    result.evaluations,
                                    Significant(result.wall_s, 3));
}

// The staged method may miss by any factor, and its digits then say nothing.
std::string StagedError(double percent) {
  return percent > 100.0 ? ">100" : Significant(percent, 3);
}

std::string ErrorsText(const JointResult& result) {
  TextTable table({{"errors over all rows", Align::kFile},
                   {"mean_%"},
                   {"max_%"},
                   {"rmse_mV"},
                   {"staged mean_%"}},
                  "How well the cell describes its logs.");
  for (std::size_t l = 0; l < result.fitted.size(); ++l) {
    const auto& log = result.fitted[l];
    table.Row({"   " + log.file,
               Significant(log.all.mean_error_percent, 3),
               Significant(log.all.max_error_percent, 3),
               Significant(1e3 * log.all.rmse),
               StagedError(result.fitted_staged[l].all.mean_error_percent)});
  }
  for (std::size_t l = 0; l < result.validation.size(); ++l) {
    const auto& log = result.validation[l];
    table.Row({"   " + log.file + " (validation)",
               Significant(log.all.mean_error_percent, 3),
               Significant(log.all.max_error_percent, 3),
               Significant(1e3 * log.all.rmse),
               StagedError(result.staged.validation[l].all.mean_error_percent)});
  }
  return table.Text();
}

}  // namespace

std::string JointReport(const JointResult& result, const TrustReport& trust, bool verbose) {
  std::string text;
  if (verbose) text += TriedText(result.choice) + "\n" + FoundText(result) + "\n";
  text += ErrorsText(result);
  if (verbose) text += ConstantCurrentText(result.constant_current);
  text += "\n" + TrustText(trust);
  if (!result.staged.done_instead.empty())
    text += "\n" + cli::Bullets("Fallbacks of the staged method, from which the joint fit started",
                                result.staged.done_instead);
  if (!result.cautions.empty()) text += "\n" + cli::Bullets("Caveats", result.cautions);
  return text;
}

}  // namespace lipoid
