#include "tools/commands/identify_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/validation.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/prediction.h"
#include "model/core/counted.h"
#include "model/core/csv_writer.h"
#include "tools/cli/text_table.h"
#include "tools/commands/trust_text.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Bullets;
using cli::Significant;
using cli::TextTable;

std::string PlusMinus(double value, double standard_error, std::string_view unit) {
  if (!std::isfinite(standard_error) || standard_error == 0.0) {
    return fmt::format("{} {}", Significant(value, 5), unit);
  }
  return fmt::format("{} +- {} {}", Significant(value, 5), Significant(standard_error, 2), unit);
}

std::string DischargeTimesText(const StagedResult& result) {
  std::string text = "1  discharge times (4.53)\n";
  if (!result.discharge_times) {
    return text + fmt::format("   none; alpha {} C ({})\n",
                              Significant(result.alpha_C, 5),
                              AlphaSourceInWords(result.alpha_source));
  }
  const auto& stage = *result.discharge_times;
  text += fmt::format("   alpha {}\n", PlusMinus(stage.alpha_C, stage.alpha_standard_error_C, "C"));
  if (stage.identifiable) {
    text += fmt::format(
        "   beta  {}\n",
        PlusMinus(stage.beta_per_sqrt_s, stage.beta_standard_error_per_sqrt_s, "s^-1/2"));
  } else if (!(stage.beta_lower_bound_per_sqrt_s > 0.0)) {
    text += fmt::format("   beta  not taken from the times: {}\n", stage.reason);
  } else {
    text += fmt::format("   beta  not identifiable; at least {} s^-1/2 (95 %)\n",
                        Significant(stage.beta_lower_bound_per_sqrt_s, 3));
  }
  TextTable table(
      {{"   log", Align::kFile}, {"current_A"}, {"measured_s"}, {"predicted_s"}, {"error_%"}},
      "Discharge times, measured and predicted.");
  for (const auto& row : stage.rows) {
    table.Row({"   " + row.file,
               Significant(row.current_A),
               Significant(row.measured_s, 5),
               Significant(row.predicted_s, 5),
               Significant(row.error_percent, 3)});
  }
  text += table.Text();
  return text + fmt::format("   mean {} %, max {} %, rmse {} s\n",
                            Significant(stage.errors.mean_error_percent, 3),
                            Significant(stage.errors.max_error_percent, 3),
                            Significant(stage.errors.rmse, 3));
}

std::string FromRestsText(const OcvFromRests& stage) {
  TextTable table({{"   from rests", Align::kLeft},
                   {"SOC"},
                   {"v_oc / V"},
                   {"rest / s"},
                   {"drift / mV"},
                   {"slope / mV/h"}},
                  "Open-circuit voltage from the rests between pulses.");
  for (const auto& rest : stage.rests) {
    table.Row({"",
               Significant(rest.soc, 4),
               Significant(rest.voltage_V, 5),
               Significant(rest.rest_s, 4),
               Significant(1e3 * rest.drift_V, 2),
               Significant(3.6e6 * rest.slope_V_per_s, 2)});
  }
  std::string text = table.Text();
  text += "   drift: how far the voltage moved in the second half of the rest\n";
  if (stage.guessed_to_soc) {
    text += fmt::format("   below SOC {} a guess from the voltage under load, good to {} mV\n",
                        Significant(stage.rests.front().soc, 3),
                        Significant(1e3 * stage.half_gap_V, 2));
  }
  return text;
}

std::string OpenCircuitVoltageText(const StagedResult& result) {
  std::string text = "2  open-circuit voltage (4.59)\n";
  if (result.from_rests) return text + FromRestsText(*result.from_rests);
  if (!result.open_circuit_voltage) return text + "   given\n";
  const auto& stage = *result.open_circuit_voltage;
  const auto method = options_internal::ToText(stage.curve.method());
  text += stage.curve.soc().empty()
              ? fmt::format("   {}, {} coefficients",
                            method,
                            stage.curve.coefficients_V().size() + stage.curve.sine_V().size())
              : fmt::format("   {}, {} nodes", method, stage.curve.soc().size());
  text += fmt::format(" from {}; on held-out rows: mean {} %, max {} %, rmse {} mV\n",
                      Counted(stage.rows, "row"),
                      Significant(stage.errors.mean_error_percent, 3),
                      Significant(stage.errors.max_error_percent, 3),
                      Significant(1e3 * stage.errors.rmse, 3));
  return text + fmt::format("   charge of the log {} C; alpha is {} of it\n",
                            Significant(result.low_rate_charge_C, 5),
                            Significant(result.alpha_C / result.low_rate_charge_C, 5));
}

std::string PulsesText(const StagedResult& result) {
  TextTable table({{"3  pulses", Align::kLeft}, {"beta held (4.60)"}, {"beta free (4.61)"}},
                  "What the pulses give.");
  const auto row = [&](const std::string& name, const auto& value) {
    table.Row({"   " + name,
               result.pulses_beta_held ? value(*result.pulses_beta_held) : "-",
               value(result.pulses)});
  };
  const bool diffusion = result.cell.diffusion.has_value();
  if (diffusion) {
    row("beta / s^-1/2",
        [](const auto& fit) { return Significant(fit.parameters.beta_per_sqrt_s, 5); });
  }
  row("r_s / Ohm",
      [](const auto& fit) { return Significant(fit.parameters.series_resistance_Ohm, 5); });
  for (std::size_t j = 0; j < result.pulses.parameters.time_constant_s.size(); ++j) {
    const auto gone = [j](const auto& fit) { return fit.parameters.resistance_Ohm[j] <= 0.0; };
    row(fmt::format("r_{} / Ohm", j + 1),
        [j](const auto& fit) { return Significant(fit.parameters.resistance_Ohm[j], 5); });
    row(fmt::format("c_{} / F", j + 1), [&](const auto& fit) {
      return gone(fit)
                 ? std::string("-")
                 : Significant(fit.parameters.time_constant_s[j] / fit.parameters.resistance_Ohm[j],
                               5);
    });
    row(fmt::format("tau_{} / s", j + 1), [&](const auto& fit) {
      return gone(fit) ? std::string("-") : Significant(fit.parameters.time_constant_s[j], 5);
    });
  }
  row("mean error / %",
      [](const auto& fit) { return Significant(fit.errors.mean_error_percent, 3); });
  row("max error / %",
      [](const auto& fit) { return Significant(fit.errors.max_error_percent, 3); });
  row("rmse / mV", [](const auto& fit) { return Significant(1e3 * fit.errors.rmse); });
  row("evaluations", [](const auto& fit) { return fmt::format("{}", fit.evaluations); });
  row("time / s", [](const auto& fit) { return Significant(fit.wall_s, 2); });
  row("at bound", [](const auto& fit) {
    std::string names;
    for (const auto& name : fit.at_bound) names += (names.empty() ? "" : " ") + name;
    return names.empty() ? std::string("-") : names;
  });
  return table.Text();
}

}  // namespace

std::string ValidationText(const std::vector<LogErrors>& logs) {
  if (logs.empty()) return "";
  TextTable table(
      {{"validation", Align::kFile}, {"mean_%"}, {"max_%"}, {"rmse_mV"}, {"mean_% above 10 % SOC"}},
      "How well the cell predicts logs that it was not made from.");
  for (const auto& log : logs) {
    table.Row({"   " + log.file,
               Significant(log.all.mean_error_percent, 3),
               Significant(log.all.max_error_percent, 3),
               Significant(1e3 * log.all.rmse),
               Significant(log.above_10_soc.mean_error_percent, 3)});
  }
  return "\n" + table.Text();
}

std::string ConstantCurrentText(const std::vector<ConstantCurrentErrors>& logs) {
  if (logs.empty()) return "";
  TextTable table({{"constant current", Align::kFile},
                   {"current_A"},
                   {"measured_s"},
                   {"predicted_s"},
                   {"error_%"},
                   {"mean_%"},
                   {"max_%"},
                   {"rmse_mV"},
                   {"mean_% above 10 % SOC"}},
                  "Discharges at constant current, measured and predicted.");
  for (const auto& log : logs) {
    const bool ends = std::isfinite(log.predicted_s);
    table.Row({"   " + log.voltage.file,
               Significant(log.current_A),
               Significant(log.measured_s, 5),
               ends ? Significant(log.predicted_s, 5) : "never",
               ends ? Significant(log.error_percent, 3) : "-",
               Significant(log.voltage.all.mean_error_percent, 3),
               Significant(log.voltage.all.max_error_percent, 3),
               Significant(1e3 * log.voltage.all.rmse),
               Significant(log.voltage.above_10_soc.mean_error_percent, 3)});
  }
  return "\n" + table.Text();
}

std::string IdentifyReport(const StagedResult& result, bool verbose) {
  std::string text;
  if (verbose) {
    text = DischargeTimesText(result) + "\n" + OpenCircuitVoltageText(result) + "\n" +
           PulsesText(result) + "\n";
  }
  text += TrustText(result.trust, "alpha and v_oc(A)");
  text += ConstantCurrentText(result.constant_current) + ValidationText(result.validation);
  if (!result.done_instead.empty()) text += "\n" + Bullets("Fallbacks", result.done_instead);
  if (!result.cautions.empty()) text += "\n" + Bullets("Caveats", result.cautions);
  return text;
}

std::string TruthTable(const CellComparison& comparison) {
  TextTable table(
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

TextAndJson SpreadOfCells(const std::vector<Cell>& cells,
                          const std::string& error_name,
                          const std::vector<double>& errors_percent) {
  TextAndJson spread{"", Json::object()};
  TextTable table({{"parameter", Align::kLeft},
                   {"mean"},
                   {"std. dev."},
                   {"std. dev. / %"},
                   {"least"},
                   {"most"},
                   {"unit", Align::kLeft}},
                  "Spread over the cells.");
  const auto add =
      [&](const std::string& name, const std::string& unit, const std::vector<double>& values) {
        if (values.size() < 2) return;
        double mean = 0.0;
        for (const double v : values) mean += v / static_cast<double>(values.size());
        double squares = 0.0;
        for (const double v : values) squares += (v - mean) * (v - mean);
        const double deviation = std::sqrt(squares / static_cast<double>(values.size() - 1));
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        table.Row({name,
                   Significant(mean, 5),
                   Significant(deviation, 3),
                   Significant(100.0 * deviation / mean, 3),
                   Significant(*least, 5),
                   Significant(*most, 5),
                   unit});
        spread.json[name] = {{"mean", mean},
                             {"standard_deviation", deviation},
                             {"least", *least},
                             {"most", *most},
                             {"values", values}};
      };
  for (const auto& name : CellParameterNames(cells.front())) {
    std::vector<double> values;
    for (const auto& cell : cells) {
      if (const auto value = CellParameter(cell, name)) values.push_back(*value);
    }
    add(name, std::string(CellParameterUnit(name)), values);
  }
  add(error_name, "%", errors_percent);
  spread.text = fmt::format("Spread over {} cells\n", cells.size()) + table.Text();
  return spread;
}

void WriteResiduals(const Identification& found,
                    const std::vector<LoadedLog>& logs,
                    const std::string& file) {
  CsvWriter csv(file, "log,time_s,current_A,voltage_V,fitted_V,residual_V,soc");
  const Cell one = found.cell.AsOne();  // the records are those of one cell
  const std::vector<LogKind> kinds = found.fitted_kinds();
  for (std::size_t n = 0; n < logs.size(); ++n) {
    if (std::find(kinds.begin(), kinds.end(), logs[n].entry.kind) == kinds.end()) continue;
    const Record& record = logs[n].log.record;
    std::vector<double> flowing_A = record.current_A.ToVector();
    if (found.joint) {
      for (double& i : flowing_A) i = found.joint->choice.best.rates.Flowing(i);
    }
    const auto fitted = Predict(one,
                                record.time_s,
                                flowing_A,
                                record.hold,
                                logs[n].entry.initial_soc,
                                SurroundingsOf(record, logs[n].entry));
    for (std::size_t k = 0; k < record.size(); ++k) {
      csv.Row(static_cast<double>(n + 1),
              record.time_s[k],
              record.current_A[k],
              record.voltage_V[k],
              fitted.voltage_V[k],
              record.voltage_V[k] - fitted.voltage_V[k],
              fitted.soc[k]);
    }
  }
  csv.Commit();
}

}  // namespace lipoid
