// lipoid simulate CELL --current LOG -o CSV: the voltage that a cell would show under a recorded
// current.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "identify/logs/all_rows.h"
#include "identify/logs/beyond_curve.h"
#include "identify/logs/cutoff_crossing.h"
#include "identify/logs/discharge.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "identify/validation.h"
#include "model/battery/prediction.h"
#include "model/battery/prediction_band.h"
#include "model/core/counted.h"
#include "model/core/csv_writer.h"
#include "model/core/errors.h"
#include "tools/commands.h"
#include "tools/commands/ensemble_option.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/surroundings_options.h"
#include "tools/report/report.h"

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

// What became of a cell on its way along a log.
struct Way {
  std::size_t rows = 0;  // before the cut-off
  PredictedSoc reached;
  double first_s = 0.0;
  double last_s = 0.0;
  double soc = 0.0;
  double voltage_V = 0.0;
  double lowest_V = std::numeric_limits<double>::infinity();
  std::optional<double> cutoff_s;  // when the voltage fell to the cut-off, where rows end there
  double last_A = 0.0;             // of the last row, or of the one there
};

// write(time_s, current_A, row) for the rows before the first one that lies below the cut-off of the
// pack.
class Walk {
 public:
  Walk(const Cell& cell, Hold hold, double initial_soc, std::size_t rows_of_log, bool beyond_cutoff)
      : cell_(cell),
        predictor_(cell, hold, initial_soc),
        crossing_(cell.series * cell.cutoff_V),
        rows_of_log_(rows_of_log),
        beyond_cutoff_(beyond_cutoff) {}

  template <class Write>
  void Rows(const Record& rows, const Surroundings& surroundings, const Write& write) {
    if (way_.cutoff_s) return;
    predictor_.Rows(
        rows.time_s, rows.current_A, surroundings, [&](std::size_t k, const PredictedRow& row) {
          if (way_.cutoff_s) return;
          crossing_.Row(rows.time_s[k], rows.current_A[k], row.voltage_V);
          way_.last_A = rows.current_A[k];
          if (!beyond_cutoff_ &&
              IsBelowCutoff(cell_, way_.last_A, row.voltage_V, way_.rows, rows_of_log_)) {
            way_.cutoff_s = crossing_.time_s();
            return;
          }
          if (way_.rows++ == 0) way_.first_s = rows.time_s[k];
          way_.last_s = rows.time_s[k];
          way_.soc = row.soc;
          way_.reached.Row(cell_.open_circuit_voltage, row.soc);
          way_.voltage_V = row.voltage_V;
          if (row.voltage_V < way_.lowest_V) way_.lowest_V = row.voltage_V;
          write(rows.time_s[k], rows.current_A[k], row);
        });
  }

  [[nodiscard]] const Way& way() const { return way_; }

 private:
  const Cell& cell_;
  RowPredictor predictor_;
  CutoffCrossing crossing_;
  std::size_t rows_of_log_;
  bool beyond_cutoff_;
  Way way_;
};

// What the page of `--report` draws of the rows that a log holds in memory, before the cut-off.
Series Simulated(const Record& record,
                 const Surroundings& surroundings,
                 const Cell& cell,
                 const PredictionBand& band,
                 Walk& walk) {
  std::vector<double> predicted_V;
  std::vector<double> open_circuit_V;
  std::vector<double> soc;
  std::vector<double> temperature_degC;
  walk.Rows(record, surroundings, [&](double, double, const PredictedRow& row) {
    predicted_V.push_back(row.voltage_V);
    open_circuit_V.push_back(cell.series * row.stepper.OpenCircuit());
    soc.push_back(row.soc);
    if (cell.temperature)
      temperature_degC.push_back(row.stepper.state().temperature_K - kZeroCelsius_K);
  });
  Series series{.kind = "simulation", .name = "", .rows = soc.size()};
  const auto add = [&](const char* name, std::span<const double> values) {
    const auto until = values.first(std::min(values.size(), soc.size()));
    if (!until.empty()) series.columns.push_back({name, {until.begin(), until.end()}});
  };
  add("time_s", record.time_s);
  add("current_A", record.current_A);
  add("voltage_V", record.voltage_V);
  add("predicted_V", predicted_V);
  add("open_circuit_V", open_circuit_V);
  add("soc", soc);
  add("temperature_degC", temperature_degC);
  add("voltage_low_V", band.voltage_low_V);
  add("voltage_high_V", band.voltage_high_V);
  return series;
}

Json WayToJson(const Way& way, double initial_soc) {
  Json told = {{"duration_s", 0.0},
               {"initial_soc", initial_soc},
               {"final_soc", nullptr},
               {"final_voltage_V", nullptr},
               {"minimum_voltage_V", nullptr},
               {"cutoff_s", nullptr},
               {"rows_outside_curve", way.reached.outside()}};
  if (way.cutoff_s) told["cutoff_s"] = *way.cutoff_s;
  if (way.rows > 0) {
    told["duration_s"] = way.last_s - way.first_s;
    told["final_soc"] = way.soc;
    told["final_voltage_V"] = way.voltage_V;
    told["minimum_voltage_V"] = way.lowest_V;
  }
  return told;
}

// Where the rows end before the log does, or below the cut-off.
void TellAboutEnd(cli::CommandLine& line,
                  const Cell& cell,
                  const Way& way,
                  std::size_t rows_of_log,
                  bool beyond_cutoff) {
  const double cutoff_V = cell.series * cell.cutoff_V;
  const bool whole = !way.cutoff_s;
  const bool begins_empty =
      way.rows > 0 && way.lowest_V < cutoff_V - cell.series * kCutoffTolerance_V;
  if (!whole && begins_empty) {
    line.Message(
        "the cell is below its cut-off of {:.4g} V before any current flows: {} of {}, at rest, were written; begin "
        "with more charge (--initial-soc; --beyond-cutoff writes all)",
        cutoff_V,
        way.rows,
        Counted(rows_of_log, "row"));
  } else if (!whole) {
    line.Message(
        "the cell reaches its cut-off of {:.4g} V at {:.10g} s under {:.4g} A: the {} of {} "
        "above it, within {:g} mV, were written (--beyond-cutoff writes all)",
        cutoff_V,
        std::round(100.0 * *way.cutoff_s) / 100.0,
        way.last_A,
        way.rows,
        Counted(rows_of_log, "row"),
        1e3 * cell.series * kCutoffTolerance_V);
  }
  if (whole && !beyond_cutoff && way.rows > 0 && way.last_A > 0.0 &&
      way.voltage_V < cutoff_V - cell.series * kCutoffTolerance_V) {
    line.Message(
        "the last row, {:.4g} V, lies below the cut-off of {:.4g} V, which the cell reaches within the "
        "row's time: a current that ends there is written whole",
        way.voltage_V,
        cutoff_V);
  }
}

}  // namespace

cli::ExitCode SimulateCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::string current_file;
  std::string output;
  bool beyond_cutoff = false;
  ReadingRequest reading;
  LoggedPackRequest pack;
  StartRequest start;
  EnsembleOption ensemble;
  SurroundingsRequest surroundings_request;
  line.Describe(
      "Predicts the terminal voltage, the open-circuit voltage and the state of charge of a cell "
      "under the current of a log, row by row, until the cell reaches its cut-off. The log's own "
      "voltage may be absent; where it is there, it is only asked whether the log begins where it is said to.",
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
  line.Each(start);
  line.Each(surroundings_request);
  line.Each(pack);
  line.Each(reading);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  Cell cell = LoadCell(line, cell_name);
  pack.ApplyTo(cell);
  TellWhatSaysNothing(line, cell, surroundings_request);
  auto read = reading.Resolve();
  read.voltage_optional = true;
  read.progress = [&](double share) { line.progress().Update(share, "reading"); };
  Log log = ReadLog(current_file, read);
  for (const auto& warning : log.report.warnings) line.Message("{}: {}", current_file, warning);
  const std::size_t rows_of_log = log.report.rows;
  const Surroundings surroundings = surroundings_request.Of(log.record);
  TellWhatIsMeasured(line, cell, current_file, surroundings_request, surroundings);
  TellWhatIsExtrapolated(line, cell, {&surroundings, 1});
  TellWhatTemperatureMayExplain(line, cell, current_file, surroundings);
  const double initial_soc = start.Soc(cell, surroundings);
  if (const auto doubt = DoubtAboutStart(cell, log.record, initial_soc); !doubt.empty())
    line.Message("{} {}", current_file, doubt);
  const Hold hold = log.record.hold;

  PredictionBand band;
  if (ensemble.asked()) {
    if (log.report.thinned) {
      throw OptionError(fmt::format(
          "option --ensemble: expected a log of at most {} rows, found {}; take a part of "
          "it, or keep all of its rows (--most-rows)",
          read.most_rows,
          rows_of_log));
    }
    Walk walk(cell, hold, initial_soc, rows_of_log, beyond_cutoff);
    walk.Rows(log.record, surroundings, [](double, double, const PredictedRow&) {});
    const std::size_t rows = walk.way().rows;
    auto drawn = ensemble.Draw(line, cell, cell_name, start, surroundings);
    const Record& record = log.record;
    band = PredictBand(drawn.cells,
                       drawn.initial_soc,
                       std::span(record.time_s).first(rows),
                       std::span(record.current_A).first(rows),
                       hold,
                       surroundings);
    line.summary()["ensemble"] = std::move(drawn.json);
    line.summary()["ensemble"].update(WidthOf(band));
  }

  if (!line.report_file().empty()) {
    Walk walk(cell, hold, initial_soc, rows_of_log, beyond_cutoff);
    line.report_series().push_back(Simulated(log.record, surroundings, cell, band, walk));
  }
  std::string header = "time_s,current_A,voltage_V,open_circuit_V,soc";
  if (cell.temperature) header += ",temperature_degC";
  if (ensemble.asked()) header += ",voltage_low_V,voltage_high_V";
  std::optional<CsvWriter> csv;
  if (line.earlier() == nullptr) csv.emplace(output, header);
  std::vector<double> columns;
  std::size_t outside_band = 0;
  Walk walk(cell, hold, initial_soc, rows_of_log, beyond_cutoff);
  read.progress = [&](double share) { line.progress().Update(share, "simulating"); };
  ForEachBlockOfRows(log, read, [&](Record& block) {
    Surroundings now = surroundings;
    if (!now.measured_degC.empty()) now.measured_degC = block.temperature_degC;
    walk.Rows(block, now, [&](double time_s, double current_A, const PredictedRow& row) {
      columns.assign(
          {time_s, current_A, row.voltage_V, cell.series * row.stepper.OpenCircuit(), row.soc});
      if (cell.temperature) columns.push_back(row.stepper.state().temperature_K - kZeroCelsius_K);
      if (ensemble.asked()) {
        const std::size_t k = walk.way().rows - 1;
        columns.insert(columns.end(), {band.voltage_low_V[k], band.voltage_high_V[k]});
        constexpr double kRounding_V = 1e-9;  // at rest a band may have no width
        const bool within = row.voltage_V >= band.voltage_low_V[k] - kRounding_V &&
                            row.voltage_V <= band.voltage_high_V[k] + kRounding_V;
        if (!within) ++outside_band;
      }
      if (csv) csv->RowOf(columns);
    });
  });
  if (csv) csv->Commit();
  const Way& way = walk.way();
  const bool whole = !way.cutoff_s;

  Json told = {{"file", current_file},
               {"output", output},
               {"rows", way.rows},
               {"rows_of_current", rows_of_log}};
  told.update(WayToJson(way, initial_soc));
  line.summary()["logs"] = Json::array({std::move(told)});
  TellAboutEnd(line, cell, way, rows_of_log, beyond_cutoff);
  if (outside_band > 0) {
    line.Message("in {} of {} the band leaves out what the cell itself predicts",
                 outside_band,
                 Counted(way.rows, "row"));
  }
  if (ensemble.asked()) line.summary()["ensemble"]["rows_outside_band"] = outside_band;
  if (const std::string doubt = way.reached.DoubtAboutCurve(); !doubt.empty())
    line.Message("{}", doubt);
  const bool overfull = way.reached.is_overfull();
  if (overfull) {
    line.Message(
        "the log charges the cell to a soc of {:.3g}, which no cell holds: say whether its current is "
        "the other way round (--current-sign), or how empty the cell begins (--initial-soc)",
        way.reached.overfull());
  }
  line.summary()["messages"] = line.messages();
  if (ensemble.asked() && way.rows > 0) {
    const Json& of = line.summary()["ensemble"];
    line.Message("95 % of {} cells lie within a band of {:.4f} V on average, {:.4f} V at most",
                 ensemble.count,
                 of["band_mean_V"].get<double>(),
                 of["band_max_V"].get<double>());
  }
  if (way.rows > 0) {
    line.Message("{}: {}, soc {:.4f} to {:.4f}, lowest voltage {:.4f} V",
                 output,
                 Counted(way.rows, "row"),
                 initial_soc,
                 way.soc,
                 way.lowest_V);
  }
  return whole && !overfull ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
