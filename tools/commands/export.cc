// lipoid export CELL --to TARGET -o FILE: the battery of another program, and how far it is from
// the cell.
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "identify/export/export_report.h"
#include "identify/export/law_limits.h"
#include "identify/export/mission.h"
#include "identify/export/targets.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "model/export/export_error.h"
#include "model/export/provenance.h"
#include "tools/cli/foreign_files.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"
#include "tools/report/report.h"

namespace lipoid {
namespace {

std::string TargetHelp() {
  std::vector<std::string> rows;
  for (const auto& target : ExportTargets())
    rows.push_back(fmt::format("{}: {}", target.name, target.summary));
  return fmt::format("{}", fmt::join(rows, "; "));
}

// An option that this target does not take is a mistake of the user's, not to be passed over.
void RequireTaken(const cli::CommandLine& line,
                  const ExportTarget& target,
                  std::string_view option) {
  if (!line.Given(option) || target.Takes(option)) return;
  std::vector<std::string_view> takers;
  for (const auto& other : ExportTargets()) {
    if (other.Takes(option)) takers.push_back(other.name);
  }
  throw OptionError(
      fmt::format("option --{}: {} does not take it; {} {}",
                  option,
                  target.name,
                  takers.empty() ? "no target" : fmt::format("{}", fmt::join(takers, ", ")),
                  takers.size() > 1 ? "do" : "does"));
}

// The first line: what it is and how good.
std::string Headline(const ExportTarget& target,
                     const ExportRequest& request,
                     const Exported& exported) {
  std::string text =
      fmt::format("{} ({})", target.name, KindOfExport(target, request, exported).words);
  if (exported.error) {
    text += fmt::format(": {:.3f} mV rms, {:.3f} mV at most from the cell",
                        1e3 * exported.error->rmse_V,
                        1e3 * exported.error->max_error_V);
  } else if (exported.charge_error) {
    text += fmt::format(": {:.3f} % rms, {:.3f} % at most from the cell's state of charge",
                        1e2 * exported.charge_error->rms,
                        1e2 * exported.charge_error->max_error);
  }
  return text + fmt::format(", of {} in series and {} in parallel",
                            request.cell.series,
                            request.cell.parallel);
}

// The files beside the first one. OptionError where they or the first one cannot be.
std::vector<std::string> CheckOutputs(cli::CommandLine& line,
                                      const ExportTarget& target,
                                      const std::string& output) {
  std::vector<std::string> outputs;
  for (const auto& suffix : target.FurtherSuffixes()) outputs.push_back(FileBeside(output, suffix));
  const std::filesystem::path first(output);
  const bool special = output == cli::OutputPath("-") ||
                       (std::filesystem::exists(first) && !std::filesystem::is_regular_file(first));
  if (!outputs.empty() && special) {
    throw OptionError(fmt::format(
        "option -o: {} writes {} files; name the first one", target.name, outputs.size() + 1));
  }
  if (std::find(outputs.begin(), outputs.end(), output) != outputs.end()) {
    throw OptionError(fmt::format("option -o: the first file of {} is its {}; give {}",
                                  target.name,
                                  target.extension,
                                  FileBeside(output, std::string(target.extension))));
  }
  if (!special && first.extension() != target.extension) {
    line.Message("{}: a file for {} usually ends in {}", output, target.name, target.extension);
  }
  line.AddOutputs("-o", outputs);
  std::vector<std::string> foreign = outputs;
  std::erase_if(foreign, cli::IsExportOfLipoid);
  cli::RefuseToReplace(line, foreign);
  return outputs;
}

// What the page of `--report` draws: the cell and the target's law over the mission.
Series Drawn(const ExportRequest& request, const Exported& exported) {
  const ExportMission& mission = request.mission;
  Series series{.kind = "export", .name = "", .rows = mission.time_s.size()};
  series.columns = {{"time_s", mission.time_s},
                    {"current_A", mission.current_A},
                    {"cell_V", ReferenceOf(request).voltage_V},
                    {"exported_V", exported.error->law_V}};
  if (exported.naive) series.columns.push_back({"naive_V", exported.naive->law_V});
  return series;
}

}  // namespace

cli::ExitCode ExportCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::string target_name;
  std::string output;
  std::string mission_file;
  std::string into;
  PackRequest pack;
  ReadingRequest reading;
  StartRequest start;
  ExportRequest request;
  double limit_mV = 30.0;
  line.Describe(
      "Writes the cell as the battery of another program, with the numbers that this program's own "
      "law holds best, and says how far that law is from the cell over a mission, with the "
      "mission's current imposed, and how far it would be with numbers read off the cell file.",
      "lipoid export gifi-600mAh-1 --to ardupilot --series 3 -o frame.json");
  line.Example("lipoid export cell.json --to thevenin --mission flight.csv -o cell.yaml");
  line.InputArgument("CELL", cell_name, "a cell file, or the name of a shipped cell");
  line.RequiredText("to", target_name, "TARGET", TargetHelp());
  line.Output(
      output,
      "FILE",
      "the file to write; where a target has several, the others stand beside it with its stem");
  line.Input("mission",
             mission_file,
             "LOG",
             "what the numbers are fitted and compared over: a log as simulate reads it, "
             "time_s,power_W, or a flight of lipoid; default: two levels of current with rests");
  line.Each(pack);
  line.Each(request);
  line.Input("into",
             into,
             "FILE",
             "a frame model of ArduPilot that the battery is merged into; the file itself stays");
  line.Option("error-limit-mV",
              limit_mV,
              Range{0.0, 1e6},
              "rms error of one cell, mV, above which a warning is given");
  line.Each(start);
  line.Each(reading);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const ExportTarget& target = FindExportTarget(target_name);
  for (const auto* const option : {"branches", "precision", "into"})
    RequireTaken(line, target, option);
  std::vector<std::string> outputs;
  if (line.earlier() == nullptr) outputs = CheckOutputs(line, target, output);

  const std::string text = CellText(cell_name);
  Cell cell = ParseCell(text, cell_name);
  TellAboutFit(line, cell, cell_name);
  pack.ApplyTo(cell);
  SetCell(request, cell);
  request.source = cell_name;
  request.sha256 = Sha256OfBytes(text);
  request.name = IdentifierOf(request.cell.name);
  request.stem = std::filesystem::path(output).stem().string();
  if (!into.empty()) {
    request.into_file = into;
    request.into_text = ReadTextFile(into);
  }
  if (!(request.cell.open_circuit_voltage(1.0) > request.cell.cutoff_V)) {
    throw LoadError({cell_name},
                    fmt::format("expected a battery, found one that is below its cut-off of {:.4g} "
                                "V when full: v_oc(1) is {:.4g} V",
                                request.cell.cutoff_V,
                                request.cell.open_circuit_voltage(1.0)));
  }
  if (mission_file.empty()) {
    if (start.given()) {
      throw OptionError(
          "options --initial-soc and --initial-voltage-V are of a --mission: the default one "
          "starts full");
    }
    if (!(DefaultCurrent_A(request.cell) > 0.0)) {
      throw LoadError(
          {cell_name},
          "expected a cell that lasts at some current, found one that is at its cut-off "
          "under any; --mission gives another mission");
    }
    request.mission = DefaultMission(request.cell);
  } else {
    ReadMission read = ReadMissionFile(request.Whole(), mission_file, reading.Resolve(), start);
    for (const auto& warning : read.warnings) line.Message("{}: {}", mission_file, warning);
    request.mission = std::move(read.mission);
  }

  const Exported exported = Export(target, request);

  Json& summary = line.summary();
  summary = ExportToJson(target, request, exported);
  if (!line.report_file().empty() && exported.error)
    line.report_series().push_back(Drawn(request, exported));
  if (line.earlier() != nullptr) return cli::ExitCode::kDone;
  summary["files"] = Json::array();

  cli::TextTable table({{"parameter", cli::Align::kLeft}, {"value"}, {"unit", cli::Align::kLeft}},
                       "What is exported.");
  for (const auto& parameter : exported.parameters)
    table.Row({parameter.name, fmt::format("{:.6g}", parameter.value), parameter.unit});
  line.Print("{}\n\n{}\n", Headline(target, request, exported), table.Text());
  line.Print("{}", Commented(ProvenanceLines(request, exported), ""));

  if (exported.files.empty()) {
    line.Message("nothing is written: {}",
                 exported.notes.empty() ? "no numbers were found" : exported.notes.back());
    summary["messages"] = line.messages();
    return cli::ExitCode::kIncomplete;
  }
  for (std::size_t k = 0; k < exported.files.size(); ++k) {
    const auto& file = exported.files[k];
    const std::string path = k == 0 ? output : FileBeside(output, file.suffix);
    Require(k == 0 || std::find(outputs.begin(), outputs.end(), path) != outputs.end(),
            "every file of a target is declared in its row");
    WriteFileAtomically(path, file.content);
    summary["files"].push_back(path);
  }
  if (exported.error && !(exported.error->rmse_V <= 1e-3 * limit_mV * request.cell.series)) {
    line.Message(
        "warning: {:.3f} mV rms of {} cell{} in series is more than {:g} mV for each: {} cannot "
        "hold this cell over this mission (--error-limit-mV)",
        1e3 * exported.error->rmse_V,
        request.cell.series,
        request.cell.series == 1 ? "" : "s",
        limit_mV,
        target.name);
  }
  constexpr double kMostOfCharge = 0.05;
  if (!exported.error && exported.charge_error && !(exported.charge_error->rms <= kMostOfCharge)) {
    line.Message(
        "warning: a state of charge that is {:.3g} % rms off: {} cannot hold this cell over this "
        "mission",
        1e2 * exported.charge_error->rms,
        target.name);
  }
  summary["messages"] = line.messages();
  for (std::size_t k = 0; k < exported.files.size(); ++k) {
    line.Message(
        "{}: {} bytes", summary["files"][k].get<std::string>(), exported.files[k].content.size());
  }
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
