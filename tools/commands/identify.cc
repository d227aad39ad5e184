// lipoid identify CAMPAIGN... -o CELL: from logs to a cell file.
#include <fmt/ranges.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "identify/health/flights_report.h"
#include "identify/health/health_report.h"
#include "identify/identification.h"
#include "identify/identify_request.h"
#include "identify/logs/campaign.h"
#include "identify/logs/load_campaign.h"
#include "model/battery/cell_comparison.h"
#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/json_text.h"
#include "model/core/run_record.h"
#include "tools/cli/shell_word.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/campaign_options.h"
#include "tools/commands/identify_report.h"
#include "tools/commands/joint_text.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/log_options.h"
#include "tools/commands/profile_text.h"
#include "tools/commands/staged_options.h"
#include "tools/commands/trust_text.h"
#include "tools/report/identify_series.h"

namespace lipoid {
namespace {

std::string IdentificationText(const Campaign& campaign,
                               const Identification& found,
                               bool verbose) {
  std::string text =
      cli::Wrapped(fmt::format("{} {}",
                               campaign.name.empty() ? "The cell" : ForeignText(campaign.name),
                               found.Verdict())) +
      "\n\n";
  if (found.flights_alone) {
    text += TrustText(found.trust, "") + "\n";
    return text + cli::Bullets("What flights alone do not tell", found.flights_alone->cautions);
  }
  text += KnownText(found) + "\n";
  text += found.joint ? JointReport(*found.joint, found.trust, verbose)
                      : IdentifyReport(*found.staged, verbose);
  if (found.flights_with_lab)
    text += "\n" + cli::Wrapped(FlightsWithLabText(*found.flights_with_lab), 0) + "\n" +
            cli::Bullets("Flights left out", FilesWithReasons(found.flights_with_lab->refused));
  if (found.health) {
    text += "\nThe flights, against the cell of the lab logs\n";
    for (const FlightHealth& flight : found.health->flights) {
      text += cli::Wrapped(
          fmt::format("   {}: {}", flight.file, HealthSentence(*found.health, flight)), 3);
      text += "\n";
    }
  }
  if (!found.not_drawn.empty()) {
    text += fmt::format(
        "\nCells drawn from this one (--ensemble) vary only in what is known of {}: no prediction "
        "of the logs depends on the rest\n",
        fmt::join(found.not_drawn, ", "));
  }
  if (!found.profiles.empty()) text += "\n" + ProfilesText(found.profiles);
  return text;
}

// Where the cell of a campaign goes: the file named, or one in the folder named, called after the
// campaign (or after its folder, where all are called the same).
std::string CellPath(const std::string& output, const Campaign& campaign, bool folder) {
  if (!folder) return cli::OutputPath(output);
  namespace fs = std::filesystem;
  const fs::path file = fs::absolute(campaign.file);
  const std::string stem = file.stem() == "campaign" ? file.parent_path().filename() : file.stem();
  return (fs::path(output) / (stem + ".cell.json")).string();
}

std::vector<std::string> InputsOf(const Campaign& campaign, const StagedGiven& given) {
  std::vector<std::string> inputs;
  if (!campaign.file.empty()) inputs.push_back(campaign.file);
  for (const auto& log : campaign.logs) {
    if (std::find(inputs.begin(), inputs.end(), log.path) == inputs.end())
      inputs.push_back(log.path);
  }
  if (given.open_circuit_voltage) inputs.push_back(given.open_circuit_voltage_source);
  return inputs;
}

void AddSeries(cli::CommandLine& line,
               const Cell& cell,
               const Cell* staged,
               const std::vector<LoadedLog>& logs,
               std::size_t n,
               std::size_t campaigns) {
  auto series = IdentifySeries(cell, staged, logs, n, campaigns);
  std::move(series.begin(), series.end(), std::back_inserter(line.report_series()));
}

// The series of an earlier result: its cells predict the logs again, and only the staged method,
// which is quick, is run again where the joint one was used.
void ShowAgain(cli::CommandLine& line,
               const Json& earlier,
               const std::vector<Campaign>& campaigns,
               const IdentifyOptions& options) {
  const Json results = earlier.contains("cells") ? earlier.at("cells") : Json::array({earlier});
  for (std::size_t n = 0; n < results.size(); ++n) {
    const Json& result = results[n];
    const auto campaign =
        std::find_if(campaigns.begin(), campaigns.end(), [&](const Campaign& candidate) {
          return result.contains("campaign") && result["campaign"].at("file") == candidate.file;
        });
    if (campaign == campaigns.end())
      throw OptionError("the summary does not say which campaign each cell is from");
    const auto logs = LoadLogs(line, *campaign);
    const Cell cell = ParseCell(JsonText(result.at("cell")), "the cell of the summary");
    if (!result.contains("staged")) {
      AddSeries(line, cell, nullptr, logs, n, results.size());
      continue;
    }
    const StagedResult staged = IdentifyStaged(*campaign, logs, options.staged, options.given);
    AddSeries(line, cell, &staged.cell, logs, n, results.size());
  }
}

// Hashes files where other work leaves a core idle.
class Hashing {
 public:
  explicit Hashing(std::vector<std::string> files)
      : files_(std::move(files)), sha256_(files_.size()) {
    arena_.execute([this] {
      for (std::size_t k = 0; k < files_.size(); ++k)
        tasks_.run([this, k] { sha256_[k] = Sha256OfFile(files_[k]); });
    });
  }
  ~Hashing() {
    tasks_.cancel();
    try {
      Wait();
    } catch (const std::exception&) {  // on the way out of another one
    }
  }
  Hashing(const Hashing&) = delete;
  Hashing& operator=(const Hashing&) = delete;

  void AddTo(RunRecord& run) {
    Wait();
    run.inputs = files_;
    run.sha256 = sha256_;
  }

 private:
  void Wait() {
    arena_.execute([this] { tasks_.wait(); });
  }

  std::vector<std::string> files_;
  std::vector<std::string> sha256_;
  tbb::task_arena arena_{tbb::task_arena::automatic, 1, tbb::task_arena::priority::low};
  tbb::task_group tasks_;
};

struct AskedIdentify {
  std::vector<std::string> campaign_files;
  CampaignOptions campaigns;
  IdentifyRequest request;
  std::string output;
  std::string residuals;
  std::string truth_file;
  bool verbose = false;

  [[nodiscard]] bool batch() const { return campaign_files.size() > 1; }
};

bool Ask(cli::CommandLine& line, AskedIdentify& asked) {
  line.Describe(
      "Finds the parameters of a lithium-polymer cell from its lab logs and writes a cell file. The "
      "joint method, the default, is one fit of all logs, with resistances over the state of charge "
      "where these predict held-out rows better. The staged method is that of the thesis: discharge "
      "times give alpha and beta, a low-rate discharge gives v_oc(A), and pulses give beta again with r_s and "
      "the branches. Where a kind of log is missing, the report says what was done instead. The "
      "first line says how well the cell predicts its own logs; a cell that does not describe them "
      "ends with exit code 1. Several campaigns give one cell file each, in a folder, and a table "
      "of their spread.",
      "lipoid identify campaign.toml -o cell.json");
  line.Example("lipoid identify --low-rate c20.csv --pulses hppc.csv --cutoff-V 3 -o cell.json");
  line.Example("lipoid identify campaign.toml --method staged -o cell.json");
  line.Example("lipoid identify --flight flight.bin --series 4 --capacity-Ah 5.2 -o cell.json");
  line.Example("lipoid identify cell1.toml cell2.toml cell3.toml -o cells/");
  line.InputArguments("CAMPAIGN",
                      asked.campaign_files,
                      "campaign files (TOML); none where logs are given by options",
                      0);
  line.RequiredText(
      "output,o", asked.output, "CELL", "the cell file to write, or a folder for several");
  asked.campaigns.AddTo(line);
  line.Each(asked.request);
  line.OutputOption("residuals",
                    asked.residuals,
                    "CSV",
                    "write measured and fitted voltages of the last fit, row by row");
  line.Input(
      "truth", asked.truth_file, "CELL", "compare with this cell: for logs that were synthesized");
  line.Flag("verbose",
            asked.verbose,
            "print also the structures that were tried, or each stage, and what they found");
  line.ReportOption();
  asked.request.EachGroup([&](std::string_view name, auto& group) { line.Group(name, group); });
  return line.Parse();
}

void SayWhatChangesNothing(cli::CommandLine& line, bool joint) {
  if (!joint && line.Sets("joint.")) {
    line.Message(
        "options --set joint.* change nothing with --method staged: leave them out, or take --method "
        "joint");
  }
  if (joint && line.Sets("open_circuit_voltage.")) {
    line.Message(
        "options --set open_circuit_voltage.* shape the curve of the staged run alone, from which the "
        "joint fit starts: v_oc(A) of the cell is a table (--set joint.voltage_nodes), or the curve "
        "that is given");
  }
  if (joint && (line.Sets("pulses.branches") || line.Sets("pulses.starts"))) {
    line.Message(
        "options --set pulses.branches and pulses.starts are of the staged run alone, from which the joint fit "
        "starts: --branches says how many the cell has");
  }
  if (joint && (line.Sets("solver.") || line.Sets("discharge_times."))) {
    line.Message(
        "options --set solver.* and discharge_times.* are of the staged run alone, from which the joint fit starts");
  }
}

// The cell file of each campaign, in a folder that is there.
std::vector<std::string> CellPaths(const AskedIdentify& asked,
                                   const std::vector<Campaign>& campaigns) {
  const std::string& output = asked.output;
  const bool batch = asked.batch();
  if (batch && cli::OutputPath(output) == cli::OutputPath("-"))
    throw OptionError("option -o: several cells are files in a folder; name one in place of -");
  std::error_code none;
  const bool folder = batch || std::filesystem::is_directory(output, none);
  if (asked.residuals.size() + asked.truth_file.size() > 0 && batch) {
    throw OptionError("--residuals and --truth go with one campaign at a time");
  }
  if (folder && asked.campaigns.ByOptions())
    throw OptionError(fmt::format("option -o: '{}' is a folder; name a file", output));
  std::vector<std::string> paths;
  if (folder && !campaigns.empty()) NewFolder(output).Keep();
  for (const auto& campaign : campaigns) {
    paths.push_back(CellPath(output, campaign, folder));
    if (std::count(paths.begin(), paths.end(), paths.back()) > 1) {
      throw OptionError(fmt::format(
          "two campaigns would write '{}'; name the campaign files differently", paths.back()));
    }
  }
  return paths;
}

}  // namespace

cli::ExitCode IdentifyCommand(cli::CommandLine& line) {
  AskedIdentify asked;
  if (!Ask(line, asked)) return cli::ExitCode::kDone;
  CheckSaidOnce(line, asked.request);
  const IdentifyOptions options = asked.request.Resolve();
  const bool joint = options.method == IdentifyMethod::kJoint;
  SayWhatChangesNothing(line, joint);
  const bool batch = asked.batch();
  std::vector<LoadError> failed;  // of a batch: the others are identified all the same
  const std::vector<Campaign> campaigns = asked.campaigns.Campaigns(
      line, asked.campaign_files, options.given.open_circuit_voltage, batch ? &failed : nullptr);
  if (line.earlier() != nullptr) {
    ShowAgain(line, *line.earlier(), campaigns, options);
    return cli::ExitCode::kDone;
  }
  const std::vector<std::string> paths = CellPaths(asked, campaigns);
  line.AddOutputs("-o", paths);
  std::optional<Cell> truth;
  if (!asked.truth_file.empty()) truth = LoadCell(line, asked.truth_file);

  bool converged = true;
  bool usable = true;
  bool internal = false;
  Json cells = Json::array();
  std::vector<Cell> found;
  std::vector<double> mean_errors;
  const auto identify_one = [&](std::size_t k) {
    const Campaign& campaign = campaigns[k];
    const auto began = std::chrono::steady_clock::now();
    const auto share = [&](double part) {
      return (static_cast<double>(k) + part) / static_cast<double>(campaigns.size());
    };
    CheckCampaign(campaign,
                  options.given.open_circuit_voltage.has_value() || options.given.reference);
    line.progress().Update(share(0.0), "reading logs");
    const auto logs = LoadLogs(line, campaign, share);
    Hashing hashing(InputsOf(campaign, options.given));
    const StageProgress tell = [&](std::string_view stage, double part) {
      line.progress().Update(share(0.2 + 0.7 * part), stage);
    };
    Identification result = Identify(campaign, logs, options, tell);
    for (std::size_t n = NotesOnLogs(logs).size(); n < result.log_notes.size(); ++n)
      line.Message("{}", result.log_notes[n]);
    const Json report = IdentificationToJson(result);
    line.progress().Update(share(0.95), "writing");
    RunRecord run;
    run.command = line.CommandText();
    run.seed = line.seed();
    hashing.AddTo(run);
    line.AddHashes(run.inputs, run.sha256);
    Json metrics = report;
    if (!campaign.age.empty()) metrics["age"] = campaign.age;
    AddRunRecord(result, options, std::move(metrics), std::move(run));
    if (!asked.residuals.empty()) WriteResiduals(result, logs, asked.residuals);
    if (line.earlier() == nullptr) WriteCellFile(result.cell, paths[k]);
    converged = converged && result.converged;
    usable = usable && result.usable();

    Json entry = {{"cell", CellToJson(result.cell)}, {"file", paths[k]}};
    entry.update(report);
    entry["campaign"] = CampaignToJson(campaign, logs);
    if (!line.report_file().empty()) {
      AddSeries(line,
                result.cell,
                result.joint ? &result.joint->staged.cell : nullptr,
                logs,
                cells.size(),
                campaigns.size());
    }
    entry["wall_s"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    cells.push_back(std::move(entry));
    if (batch) cli::TablesForPaper::About(paths[k]);
    line.Print("{}", IdentificationText(campaign, result, asked.verbose));
    if (truth) {
      const auto comparison = CompareCells(*truth, result.cell);
      line.Print("\nTruth against estimate, branches by the nearest time constant\n{}",
                 TruthTable(comparison));
      cells.back()["truth"] = ComparisonToJson(comparison);
    }
    line.Print("\nCell file: {}\n", paths[k]);
    if (!batch && result.quality.grade != FitGrade::kPoor) {
      line.Print("Next: lipoid {}\n",
                 result.flights_alone
                     ? fmt::format("health --cell {} --series {} FLIGHT...",
                                   cli::ShellWord(paths[k]),
                                   campaign.series)
                     : fmt::format("validate {} LOG...", cli::ShellWord(paths[k])));
    }
    if (k + 1 < campaigns.size()) line.Print("\n");
    mean_errors.push_back(result.mean_error_percent());
    found.push_back(std::move(result.cell));
    if (batch) line.CommitOutputs();  // hours of work are not lost with a later campaign
  };
  std::vector<std::string> failed_files;
  for (const LoadError& error : failed)
    failed_files.push_back(error.diagnostics().front().position.file);
  for (std::size_t k = 0; k < campaigns.size(); ++k) {
    try {
      identify_one(k);
      continue;
    } catch (const LoadError& error) {
      if (!batch) throw;
      failed.push_back(error);
    } catch (const OptionError& error) {
      if (!batch) throw;
      failed.emplace_back(SourcePosition{campaigns[k].file}, error.what());
    } catch (const std::exception& error) {
      if (!batch) throw;
      internal = true;
      failed.emplace_back(SourcePosition{campaigns[k].file},
                          std::string("this should not have happened: ") + error.what());
    }
    failed_files.push_back(campaigns[k].file);
  }
  if (!batch) {
    line.summary().update(cells[0]);
  } else if (found.size() < 2) {
    line.summary()["cells"] = std::move(cells);
  } else {
    cli::TablesForPaper::About("");
    const auto spread =
        SpreadOfCells(found, joint ? "mean error" : "pulse mean error", mean_errors);
    line.Print("\n{}", spread.text);
    line.summary()["cells"] = std::move(cells);
    line.summary()["spread"] = spread.json;
  }
  if (batch) line.summary()["failed"] = Json::array();
  for (std::size_t k = 0; k < failed.size(); ++k) {
    line.Problem(failed[k]);
    line.summary()["failed"].push_back(
        {{"campaign", failed_files[k]}, {"message", failed[k].what()}});
  }
  if (!failed.empty()) {
    line.Message("not identified: {} of {} campaigns ({}); the cells of the others are written",
                 failed.size(),
                 asked.campaign_files.size(),
                 fmt::join(failed_files, ", "));
    return internal ? cli::ExitCode::kInternal : cli::ExitCode::kBadInput;
  }
  if (!converged)
    line.Message("not converged: the cell file says so; see `message` in its metrics");
  if (!usable && converged) {
    line.Message(
        "the cell does not describe its own logs, as the verdict says; look at the cut-off, the capacity, "
        "the kinds and where each log starts, then run it again");
  }
  return usable ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
