// lipoid synthesize CELL --protocol P -o DIR: the lab's logs of a cell that is known.
#include "identify/synthesis/synthesize.h"

#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "identify/pack_request.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "tools/cli/assignments.h"
#include "tools/cli/foreign_files.h"
#include "tools/cli/shell_word.h"
#include "tools/commands.h"
#include "tools/commands/ambient_option.h"
#include "tools/commands/loaded_cell.h"

namespace lipoid {
namespace {

bool IsShipped(const std::string& cell) {
  const auto names = ShippedCellNames();
  return std::find(names.begin(), names.end(), cell) != names.end();
}

}  // namespace

cli::ExitCode SynthesizeCommand(cli::CommandLine& line) {
  std::string cell_name;
  std::string folder;
  std::string protocol = std::string(kProtocols[0].name);
  std::vector<std::string> changes;
  PackRequest pack;
  SynthesisOptions options;
  line.Describe(
      "Writes the logs that a lab would record from a known cell: one CSV per test, a campaign "
      "file beside them, and the truth in truth.json.",
      "lipoid synthesize gifi-600mAh-1 --protocol thesis -o logs");
  line.Example(
      "lipoid synthesize gifi-600mAh-1 --with r_1=0.03,c_1=1500 --voltage-noise-V 0.001 --seed 7 "
      "-o logs");
  line.Example("lipoid synthesize cell.json --ambient-degC 25,0 --sampling-s 1 -o logs");
  line.InputArgument("CELL", cell_name, "a cell file, or the name of a shipped cell");
  std::vector<std::string> protocols;
  for (const auto& row : kProtocols)
    protocols.push_back(fmt::format("{}: {}", row.name, row.summary));
  line.Text("protocol", protocol, "NAME", fmt::format("{}", fmt::join(protocols, "; ")));
  line.RequiredText("output,o", folder, "DIR", "the folder to write to; made where it is missing");
  line.Texts(
      "with",
      changes,
      "NAME=VALUE",
      "change parameters of the cell: alpha, beta, r_s, r_1, c_1, tau_1, ..., tau_h and rho_h "
      "(self-heating), i_0 and r_ct (charge transfer)");
  line.Each(pack);
  line.Each(options);
  if (!line.Parse()) return cli::ExitCode::kDone;

  Cell cell = LoadCell(line, cell_name);
  const auto changed = ParseAssignments("--with", changes);
  try {
    SetCellParameters(cell, changed);
  } catch (const OptionError& error) {
    throw OptionError(fmt::format("option --with: {}", error.what()));
  }
  pack.ApplyTo(cell);
  cell.uncertainty.reset();  // it is the truth now
  if (!options.ambient_degC.empty()) cell = KnowingTemperature(line, cell, cell_name);
  std::vector<std::string> outputs;
  for (const auto& name : SynthesizedNames(cell, FindProtocol(protocol), options))
    outputs.push_back((std::filesystem::path(folder) / name).string());
  line.AddOutputs("-o", outputs);
  if (!IsSynthesized(folder)) cli::RefuseToReplace(line, outputs);
  for (const std::string& doubt : DoubtsAboutSynthesis(cell, FindProtocol(protocol), options))
    line.Message("{}", doubt);
  RunRecord run;
  run.command = line.CommandText();
  run.options = OptionsToJson<Json>(options);
  run.seed = line.seed();
  if (!IsShipped(cell_name)) run.inputs.push_back(cell_name);
  const auto files =
      Synthesize(cell, FindProtocol(protocol), options, run, folder, [&](double done) {
        line.progress().Update(done, "synthesizing");
      });

  Json rows = Json::array();
  for (const auto& file : files) {
    const auto path = (std::filesystem::path(folder) / file.file).string();
    rows.push_back({{"file", path}, {"rows", file.rows}, {"bytes", file.bytes}});
    line.Message("{}{}", path, file.rows > 0 ? ": " + Counted(file.rows, "row") : "");
  }
  line.summary()["files"] = std::move(rows);
  line.Message("Next: lipoid identify {} -o cell.json",
               cli::ShellWord((std::filesystem::path(folder) / "campaign.toml").string()));
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
