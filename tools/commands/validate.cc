// lipoid validate CELL LOG...: prediction against measurement.
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/fit_quality.h"
#include "identify/logs/all_rows.h"
#include "identify/logs/load_campaign.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "identify/stages/staged_report.h"
#include "identify/validation.h"
#include "model/core/counted.h"
#include "model/core/foreign_text.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/log_options.h"
#include "tools/commands/surroundings_options.h"
#include "tools/report/log_series.h"

namespace lipoid {

cli::ExitCode ValidateCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::vector<std::string> files;
  ReadingRequest reading;
  LoggedPackRequest pack;
  StartRequest start;
  SurroundingsRequest surroundings;
  line.Describe(
      "Predicts the voltage of measured logs from their current and says how far off it is: mean "
      "and maximum of the relative error (4.57), (4.58) and the root mean square, over all rows "
      "and over those above 10 % state of charge. The first line judges the prediction as `lipoid "
      "identify` judges a fit, by errors over which every log counts the same; the exit code is 0 whatever it says.",
      "lipoid validate cell.json pulses.csv flight.csv");
  line.InputArgument("CELL", cell_name, "a cell file, or the name of a shipped cell");
  line.InputArguments("LOG", files, "logs of any known format");
  line.Each(start);
  line.Each(surroundings);
  line.Each(reading);
  line.Each(pack);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  Cell cell = LoadCell(line, cell_name);
  pack.ApplyTo(cell);
  TellWhatSaysNothing(line, cell, surroundings);
  Campaign campaign;
  campaign.series = cell.series;
  campaign.parallel = cell.parallel;
  AddLogs(campaign, LogKind::kValidation, files, reading.Resolve());
  const Cell one = cell.AsOne();  // the records come as those of one cell
  Json rows = Json::array();
  cli::TextTable table({{"log", cli::Align::kFile},
                        {"rows"},
                        {"mean / %"},
                        {"max / %"},
                        {"rmse / V"},
                        {"mean above 10 % / %"},
                        {"rmse above 10 % / V"}},
                       "How well the cell predicts the logs.");
  auto logs = LoadLogs(line, campaign);
  std::vector<std::size_t> lengths;
  for (const auto& loaded : logs) {
    (void)CheckPlausible(loaded.log.record, cell.capacity_Ah, cell.series, cell.parallel);
    CheckSeries(loaded.log.record, cell.open_circuit_voltage, cell.series);
    lengths.push_back(loaded.log.record.size());
  }
  constexpr std::size_t kColumns = 4;  // current, voltage, prediction, perhaps temperature
  const auto most_rows = RowsOfPage(lengths, kColumns);
  const std::vector<PredictedColumn> predicted{{"predicted_V", &one}};
  std::vector<LogErrors> all;
  std::vector<StartDoubt> starts;
  std::vector<Surroundings> felt;
  for (auto& loaded : logs) {
    const Surroundings among = felt.emplace_back(surroundings.Of(loaded.log.record));
    TellWhatIsMeasured(line, cell, loaded.entry.file, surroundings, among);
    const double initial_soc = start.Soc(cell, among);
    Validation validation(one, loaded.log.record.hold, initial_soc);
    if (!loaded.log.report.thinned) {  // every row is there, and one of the cell already
      validation.Add(loaded.log.record, among);
    } else {
      ForEachBlockOfRows(loaded.log, loaded.entry.read, [&](Record& block) {
        DivideByPack(block, cell.series, cell.parallel);
        Surroundings now = among;
        if (!now.measured_degC.empty()) now.measured_degC = block.temperature_degC;
        validation.Add(block, now);
      });
    }
    LogErrors errors = validation.Result();
    errors.file = loaded.entry.file;
    if (auto doubt = DoubtOfStart(one, loaded.log.record, initial_soc, among)) {
      doubt->file = errors.file;
      starts.push_back(std::move(*doubt));
    }
    if (const auto doubt = DoubtAboutLoadedStart(one, loaded.log.record, initial_soc);
        !doubt.empty())
      line.Message("{} {}", errors.file, doubt);
    table.Row({errors.file,
               fmt::format("{}", errors.all.rows),
               cli::Significant(errors.all.mean_error_percent),
               cli::Significant(errors.all.max_error_percent),
               cli::Significant(errors.all.rmse),
               cli::Significant(errors.above_10_soc.mean_error_percent),
               cli::Significant(errors.above_10_soc.rmse)});
    rows.push_back(LogErrorsToJson(errors));
    all.push_back(errors);
    if (std::isfinite(errors.temperature_rmse_K)) {
      line.Message("{}: the predicted temperature is {:.2f} degC rms off the measured one",
                   errors.file,
                   errors.temperature_rmse_K);
    }
    if (!line.report_file().empty()) {
      line.report_series().push_back(LogSeries(predicted,
                                               loaded.log.record,
                                               errors.file,
                                               initial_soc,
                                               most_rows[line.report_series().size()],
                                               among));
    }
    if (errors.rows_outside_curve == 0) continue;
    line.Message(
        "{}: {} outside the soc that v_oc(A) was made for: it goes on with its end slope there",
        errors.file,
        Counted(errors.rows_outside_curve, "row"));
  }
  const bool one_start = starts.size() == 1;
  if (const auto doubts = DoubtsAboutStarts(
          std::move(starts), "--initial-soc is one for all logs, so validate these one by one");
      !doubts.empty())
    line.Message("{}{}", doubts, one_start ? " (--initial-soc)" : "");
  if (cell.series > 1) line.Message("voltages are those of one cell of {} in series", cell.series);
  const FitQuality quality = JudgeFit(one, all, {}, 0.0, 0.0, AlphaOf::kElsewhere);
  for (std::size_t k = 0; k < logs.size() && quality.grade != FitGrade::kGood; ++k)
    TellWhatTemperatureMayExplain(line, cell, logs[k].entry.file, felt[k]);
  TellWhatIsExtrapolated(line, cell, felt);
  line.summary()["fit"] = FitToJson(quality);
  line.summary()["edges"] = EdgesToJson(quality.edges);
  line.summary()["logs"] = std::move(rows);
  line.summary()["messages"] = line.messages();
  const std::string verdict =
      fmt::format("{} {}",
                  ForeignText(cell.name),
                  quality.Sentence(files.size() == 1 ? "this log" : "these logs"));
  line.Print("{}\n\n{}", cli::Wrapped(verdict), table.Text());
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
