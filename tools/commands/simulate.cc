// lipoid simulate CELL --current LOG -o CSV: the voltage that a cell would show under a recorded
// current.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "identify/logs/discharge.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/battery/prediction_band.h"
#include "model/core/csv_writer.h"
#include "model/core/errors.h"
#include "tools/commands.h"
#include "tools/commands/ensemble_option.h"
#include "tools/commands/log_options.h"
#include "tools/commands/start_options.h"
#include "tools/commands/surroundings_options.h"

namespace lipoid {
namespace {

// The width of a band, on the average and at most; the average of no rows is null.
Json WidthOf(const PredictionBand& band) {
  double sum_V = 0.0;
  double most_V = 0.0;
  for (std::size_t k = 0; k < band.voltage_low_V.size(); ++k) {
    const double width_V = band.voltage_high_V[k] - band.voltage_low_V[k];
    sum_V += width_V;
    most_V = std::max(most_V, width_V);
  }
  const auto rows = static_cast<double>(band.voltage_low_V.size());
  return {{"band_mean_V", NumberOrNull(sum_V / rows)}, {"band_max_V", most_V}};
}

// The rows before the first one that lies below the cut-off of the pack. A current that ends where
// the cut-off is reached is whole: the last row of a discharge lies on a steep end.
std::size_t RowsUntilCutoff(const std::vector<double>& voltage_V, const Cell& cell) {
  constexpr double kLastStep_V = 0.3;
  const double least_V = cell.series * (cell.cutoff_V - kCutoffTolerance_V);
  const auto below =
      std::find_if(voltage_V.begin(), voltage_V.end(), [&](double v) { return !(v >= least_V); });
  const auto rows = static_cast<std::size_t>(below - voltage_V.begin());
  const bool only_the_last =
      rows > 0 && rows + 1 == voltage_V.size() && *below >= least_V - cell.series * kLastStep_V;
  return only_the_last ? voltage_V.size() : rows;
}

}  // namespace

cli::ExitCode SimulateCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::string current_file;
  std::string output;
  bool beyond_cutoff = false;
  LogOptions log_options;
  PackOptions pack;
  StartOptions start;
  EnsembleOption ensemble;
  SurroundingsOptions options_of_surroundings;
  line.Describe(
      "Predicts the terminal voltage, the open-circuit voltage and the state of charge of a cell "
      "under the current of a log, row by row, until the cell reaches its cut-off. The log's own "
      "voltage is not used and may be absent.",
      "lipoid simulate gifi-600mAh-1 --current flight.csv -o predicted.csv");
  line.Example("lipoid simulate cell.json --current flight.csv --ensemble 200 -o predicted.csv");
  line.InputArgument("CELL", cell_name, "a cell file, or the name of a shipped cell");
  line.RequiredInput(
      "current", current_file, "LOG", "the log whose current flows; time_s,current_A is enough");
  line.Output(output,
              "CSV",
              "time_s, current_A, voltage_V, open_circuit_V, soc; temperature_degC of a cell that "
              "knows temperature; with --ensemble voltage_low_V and voltage_high_V");
  ensemble.AddTo(line, "between which voltages 95 % of them lie in each row");
  line.Flag("beyond-cutoff",
            beyond_cutoff,
            "write all rows, also those below the cell's cut-off, where no cell would go on");
  start.AddTo(line);
  options_of_surroundings.AddTo(line);
  pack.AddTo(line);
  log_options.AddTo(line);
  if (!line.Parse()) return cli::ExitCode::kDone;

  Cell cell = LoadCell(cell_name);
  pack.ApplyTo(cell.series, cell.parallel);
  const double initial_soc = start.Soc(cell);
  auto read = log_options.ToReadOptions();
  read.voltage_optional = true;
  const Log read_log = ReadLog(current_file, read);
  for (const auto& warning : read_log.report.warnings)
    line.Message("{}: {}", current_file, warning);
  const Record& record = read_log.record;
  const Surroundings surroundings = options_of_surroundings.Of(record);
  const auto prediction =
      Predict(cell, record.time_s, record.current_A, record.hold, initial_soc, surroundings);

  const std::size_t rows =
      beyond_cutoff ? record.size() : RowsUntilCutoff(prediction.voltage_V, cell);
  const bool whole = rows == record.size();
  const auto outside =
      std::count_if(prediction.soc.begin(),
                    prediction.soc.begin() + static_cast<std::ptrdiff_t>(rows),
                    [&](double soc) { return !cell.open_circuit_voltage.InRange(soc); });

  PredictionBand band;
  if (ensemble.asked()) {
    auto drawn = ensemble.Draw(line, cell, cell_name, start);
    band = PredictBand(drawn.cells,
                       drawn.initial_soc,
                       std::span(record.time_s).first(rows),
                       std::span(record.current_A).first(rows),
                       record.hold,
                       surroundings);
    line.summary()["ensemble"] = std::move(drawn.json);
    line.summary()["ensemble"].update(WidthOf(band));
  }

  std::string header = "time_s,current_A,voltage_V,open_circuit_V,soc";
  if (cell.temperature) header += ",temperature_degC";
  if (ensemble.asked()) header += ",voltage_low_V,voltage_high_V";
  CsvWriter csv(output, header);
  std::vector<double> columns;
  for (std::size_t k = 0; k < rows; ++k) {
    columns.assign({record.time_s[k],
                    record.current_A[k],
                    prediction.voltage_V[k],
                    prediction.open_circuit_V[k],
                    prediction.soc[k]});
    if (cell.temperature) columns.push_back(prediction.temperature_degC[k]);
    if (ensemble.asked())
      columns.insert(columns.end(), {band.voltage_low_V[k], band.voltage_high_V[k]});
    csv.RowOf(columns);
  }
  csv.Commit();

  const double cutoff_V = cell.series * cell.cutoff_V;
  Json log = {{"file", current_file},
              {"output", output},
              {"rows", rows},
              {"rows_of_current", record.size()},
              {"duration_s", 0.0},
              {"initial_soc", initial_soc},
              {"final_soc", nullptr},
              {"final_voltage_V", nullptr},
              {"minimum_voltage_V", nullptr},
              {"cutoff_s", nullptr},
              {"rows_outside_curve", outside}};
  if (!whole) log["cutoff_s"] = record.time_s[rows];
  if (rows > 0) {
    const auto written = prediction.voltage_V.begin() + static_cast<std::ptrdiff_t>(rows);
    const double lowest_V = *std::min_element(prediction.voltage_V.begin(), written);
    log["duration_s"] = record.time_s[rows - 1] - record.time_s.front();
    log["final_soc"] = prediction.soc[rows - 1];
    log["final_voltage_V"] = prediction.voltage_V[rows - 1];
    log["minimum_voltage_V"] = lowest_V;
    line.Message("{}: {} rows, soc {:.4f} to {:.4f}, lowest voltage {:.4f} V",
                 output,
                 rows,
                 initial_soc,
                 prediction.soc[rows - 1],
                 lowest_V);
  }
  line.summary()["logs"] = Json::array({std::move(log)});
  if (!whole) {
    line.Message(
        "the cell reaches its cut-off of {:.4g} V at {:.10g} s under {:.4g} A: the {} of {} rows "
        "before it were written (--beyond-cutoff writes all)",
        cutoff_V,
        record.time_s[rows],
        record.current_A[rows],
        rows,
        record.size());
  }
  if (ensemble.asked() && rows > 0) {
    const Json& of = line.summary()["ensemble"];
    line.Message("95 % of {} cells lie within a band of {:.4f} V on average, {:.4f} V at most",
                 ensemble.count,
                 of["band_mean_V"].get<double>(),
                 of["band_max_V"].get<double>());
  }
  if (outside > 0) {
    line.Message(
        "{} rows lie outside the soc that v_oc(A) was made for: it goes on with its end slope "
        "there",
        outside);
  }
  return whole ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
