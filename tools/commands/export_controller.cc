// lipoid export-controller -o DIR: the flight controller as C, for a microcontroller.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/analysis/placed_gains.h"
#include "model/analysis/stability.h"
#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "model/export/controller_export.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/foreign_files.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"

namespace lipoid {
namespace {

// Where a part of the controller comes from: a shipped set by its name, a file by its hash.
std::string OriginOf(std::string_view what,
                     const std::string& name,
                     const std::vector<std::string>& shipped) {
  const bool known = std::find(shipped.begin(), shipped.end(), name) != shipped.end();
  return known ? fmt::format("{} {}, shipped with lipoid.", what, name)
               : fmt::format("{} file {}, SHA-256 {}.", what, name, Sha256OfFile(name));
}

std::string OriginOfGains(const std::string& name, const ControllerExportRequest& request) {
  if (request.gains.name == kPlacedGains)
    return fmt::format("The {}.", PlaceGains(request.vehicle).Brief());
  return OriginOf("Gains", name.empty() ? request.gains.name : name, ShippedGainsNames());
}

// At the voltage of a full pack, and at the lowest one under which it is to fly.
std::vector<HoverStability> LoopsOf(const ControllerExportRequest& request) {
  FlightSetup setup;
  setup.vehicle = request.vehicle;
  setup.gains = request.gains;
  setup.controller = request.controller;
  std::vector<HoverStability> hovers = CheckFlightLoops(setup);
  setup.xi = request.lowest_V / request.vehicle.nominal_voltage_V;
  for (HoverStability& hover : CheckFlightLoops(setup)) {
    hover.when = "lowest voltage";
    hovers.push_back(std::move(hover));
  }
  return hovers;
}

}  // namespace

cli::ExitCode ExportControllerCommand(cli::CommandLine& line) {
  std::string folder;
  std::string vehicle_name = "mambo-coupled";
  std::string gains_name;
  std::string cell_name;
  std::optional<double> lowest_V;
  ControllerExportRequest request;
  line.Describe(
      "Writes the flight controller that flies in the simulator, and its estimator, as C99 (which "
      "is C++ too): references, error controllers, inversion, allocation, saturation, command "
      "generation. Steps of 5 ms, no allocation, no library but libm. lipoid_controller.h says how "
      "to call it, lipoid_example.c is the whole loop.",
      "lipoid export-controller --vehicle mambo-coupled --gains aware --compensate -o flight");
  line.Example("lipoid export-controller --precision double --controller pid -o flight");
  line.Input(
      "vehicle", vehicle_name, "VEHICLE", "a vehicle file, or the name of a shipped vehicle");
  line.Input(
      "gains",
      gains_name,
      "GAINS",
      "unaware, aware, placed (by the lag of the vehicle's motors), or a gains file (default "
      "aware for a Mambo, placed for any other vehicle or controller lqr)");
  line.Text("controller",
            request.controller.law,
            "NAME",
            "inversion, or another of `lipoid list controllers`");
  line.Flag("compensate",
            request.controller.compensate,
            "turn commands into duty cycles by the measured voltage of the battery (5.52)");
  line.Input(
      "cell",
      cell_name,
      "CELL",
      "a cell file, or the name of a shipped cell: at the cut-off of its pack the references "
      "must still be within the motors' reach (default gifi-600mAh-1)");
  line.Option("lowest-V",
              lowest_V,
              Range{1e-3, 1e5},
              "voltage of the pack under load at which a flight ends, V, instead of --cell");
  line.Option("precision",
              request.precision,
              Names(),
              "precision of all numbers; -DLIPOID_DOUBLE=1 or 0 when compiling decides otherwise");
  line.RequiredText("output,o", folder, "DIR", "the folder to write to; made where it is missing");
  line.Group("controller", request.controller);
  line.Group("estimator", request.estimator);
  if (!line.Parse()) return cli::ExitCode::kDone;

  if (line.Given("controller") && line.Sets("controller.law"))
    throw OptionError("options --controller and --set controller.law: give one of them");
  std::vector<std::string> paths;
  for (const std::string& name : ExportedControllerNames())
    paths.push_back((std::filesystem::path(folder) / name).string());
  line.AddOutputs("-o", paths);
  // One of them says for all who wrote them.
  if (std::none_of(paths.begin(), paths.end(), cli::IsExportOfLipoid))
    cli::RefuseToReplace(line, paths);
  if (lowest_V && !cell_name.empty()) {
    throw OptionError("options --lowest-V and --cell: give one of them");
  }
  request.vehicle = LoadVehicle(vehicle_name);
  request.gains = GainsFor(gains_name, request.vehicle, "aware", request.controller.law);
  request.origin = {OriginOf("Vehicle", vehicle_name, ShippedVehicleNames()),
                    OriginOfGains(gains_name, request)};
  if (!lowest_V) {
    if (cell_name.empty()) cell_name = "gifi-600mAh-1";
    Cell cell = LoadCell(line, cell_name);
    if (cell.series == 1 && request.vehicle.series_cells > 1) {
      cell.series = request.vehicle.series_cells;
      line.Message(
          "{} in series, for which {} is made", Counted(cell.series, "cell"), request.vehicle.name);
    }
    lowest_V = cell.series * cell.cutoff_V;
    request.origin.push_back(OriginOf("Cut-off of the cell", cell_name, ShippedCellNames()));
  }
  if (*lowest_V > request.vehicle.nominal_voltage_V) {
    throw OptionError(fmt::format(
        "option --lowest-V: expected at most the {:g} V of {} at its fullest, found {:g}",
        request.vehicle.nominal_voltage_V,
        request.vehicle.name,
        *lowest_V));
  }
  request.lowest_V = *lowest_V;
  const auto files = ExportController(request);
  const auto hovers = LoopsOf(request);
  const bool hovers_at_lowest = hovers.size() == 2;
  const bool flies = hovers.empty() || hovers.front().stable();
  const bool stable = flies && (!hovers_at_lowest || hovers.back().stable());
  for (const std::string& warning : StabilityWarnings(hovers)) line.Message("{}", warning);
  if (!stable) {
    line.Message("this controller is not to be flown{}; {}",
                 flies ? " down to that voltage" : "",
                 kPlacedGainsHint);
  }
  if (!hovers_at_lowest) {
    line.Message(
        "{} cannot hover at {:.3g} V, the lowest voltage that this code is made for: give the voltage at which its flights end as --lowest-V",
        request.vehicle.name,
        request.lowest_V);
  }

  NewFolder made(folder);
  for (std::size_t k = 0; k < files.size(); ++k) WriteFileAtomically(paths[k], files[k].content);
  made.Keep();

  Json written = Json::array();
  for (std::size_t k = 0; k < files.size(); ++k) {
    written.push_back({{"file", paths[k]}, {"bytes", files[k].content.size()}});
  }
  line.summary()["files"] = std::move(written);
  line.summary()["vehicle"] = request.vehicle.name;
  line.summary()["gains"] = request.gains.name;
  line.summary()["controller"] = request.controller.law;
  line.summary()["precision"] = options_internal::ToText(request.precision);
  line.summary()["lowest_V"] = request.lowest_V;
  line.summary()["loops"] = StabilityToJson(hovers);
  for (const std::string& path : paths) line.Message("{}", path);
  const double follow_rad_per_s = 1.0 / (MotorLag_s(request.vehicle) + 0.5 * kControlStep_s);
  const References references = ReferencesOf(request.gains.references, request.controller);
  const double by_estimator_rad_per_s = std::min(references.attitude_rad_per_s, follow_rad_per_s);
  line.summary()["references"] = {
      {"attitude_rad_per_s", references.attitude_rad_per_s},
      {"attitude_by_estimator_rad_per_s", by_estimator_rad_per_s},
      {"slower_by_estimator", by_estimator_rad_per_s < references.attitude_rad_per_s}};
  if (by_estimator_rad_per_s < references.attitude_rad_per_s) {
    line.Message(
        "where this code flies by its own estimator, references of the attitude that are faster than "
        "the motors let the noise of the sensors swing weak attitude gains up: give --set "
        "controller.attitude_omega_rad_per_s={:.0f}, as `lipoid fly --estimate` does",
        by_estimator_rad_per_s);
  }
  line.Message(
      "Next: cc -std=c99 -O2 -ffp-contract=off lipoid_example.c lipoid_controller.c -lm -o "
      "example, in {}",
      folder);
  return flies ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
