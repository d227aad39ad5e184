// lipoid import FILE -o CELL: the battery of another program as a cell.
#include <nlohmann/json.hpp>

#include "identify/export/import_cell.h"
#include "model/battery/cell_file.h"
#include "model/battery/ranges.h"
#include "model/core/run_record.h"
#include "tools/commands.h"

namespace lipoid {

cli::ExitCode ImportCommand(cli::CommandLine& line) {
  std::string file;
  std::string output;
  ImportOptions options;
  line.Describe(
      "Makes a cell file of the battery of another program: a table of lipoid export --to tables, an "
      "equivalent circuit as JSON (the keys of the package thevenin or of PyBaMM), a frame model of "
      "ArduPilot, or an SDF with Gazebo's LinearBatteryPlugin. The format is found from the content.",
      "lipoid import frame.json --series 3 -o cell.json");
  line.InputArgument("FILE", file, "the file that describes the battery");
  line.Output(output, "FILE", "the cell file");
  line.Text("name", options.name, "NAME", "name of the cell, instead of the file's own");
  line.Option("series",
              options.series,
              kPackSizes,
              "cells in series of the pack whose numbers the file has");
  line.Option("parallel",
              options.parallel,
              kPackSizes,
              "cells in parallel of the pack whose numbers the file has");
  line.Option("capacity-Ah",
              options.capacity_Ah,
              Range{1e-9, 1e9},
              "capacity of a cell in Ah, where the file has none");
  line.Option("cutoff-V",
              options.cutoff_V,
              Range{0.0, 1e5},
              "cut-off of a cell in V, where the file has none");
  if (!line.Parse()) return cli::ExitCode::kDone;

  const std::string text = ReadTextFile(file);
  ImportedCell imported = ImportCell(text, file, options);
  RunRecord run;
  run.command = line.CommandText();
  run.options = {{"format", imported.format}};
  run.seed = line.seed();
  run.inputs = {file};
  run.sha256 = {Sha256OfBytes(text)};
  imported.cell.run = std::make_shared<const Json>(run.ToJson());
  WriteCellFile(imported.cell, output);

  Json& summary = line.summary();
  summary["format"] = imported.format;
  summary["cell"] = CellToJson(imported.cell);
  summary["notes"] = imported.notes;
  summary["output"] = output;
  const Cell& cell = imported.cell;
  line.Message("{}: {} from {}: {:.4g} Ah, {:.4g} V to {:.4g} V, {} in series, {} in parallel",
               output,
               cell.name,
               imported.format,
               cell.capacity_Ah,
               cell.open_circuit_voltage(1.0),
               cell.cutoff_V,
               cell.series,
               cell.parallel);
  for (const auto& note : imported.notes) line.Message("{}", note);
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
