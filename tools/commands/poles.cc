// lipoid poles altitude|attitude: closed-loop poles against the voltage ratio xi.
#include "model/analysis/poles.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/analysis/placed_gains.h"
#include "model/control/gains.h"
#include "model/core/csv_writer.h"
#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "model/flight/trim.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/number_range.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/poles_json.h"

namespace lipoid {
namespace {

// "-1.36, -0.25 ± 2.1i"
std::string ToText(const Poles& poles) {
  std::string text;
  for (const auto& pole : poles) {
    if (pole.imag() > 0.0) continue;  // its partner stands for both
    if (!text.empty()) text += ", ";
    text += fmt::format("{:.4g}", pole.real());
    if (pole.imag() != 0.0) text += fmt::format(" \u00b1 {:.4g}i", -pole.imag());
  }
  return text;
}

Loop FindLoop(const std::string& name) {
  if (name == "altitude") return Loop::kAltitude;
  if (name == "attitude") return Loop::kAttitude;
  throw OptionError(UnknownName("loop", name, {"altitude", "attitude"}));
}

}  // namespace

cli::ExitCode PolesCommand(cli::CommandLine& line) {
  std::string loop_name;
  std::string vehicle_name = "mambo-thesis";
  std::string gains_name;
  std::string range = "0.8:0.01:1";
  std::string output;
  line.Describe(
      "Closed-loop poles of the altitude or the attitude (pitch) loop as the battery's voltage "
      "falls: by the closed form, by differentiating the flight with the motors at their "
      "equilibrium, and with the motors' lag.",
      "lipoid poles altitude --vehicle mambo-thesis --gains unaware --xi 0.8:0.01:1");
  line.Argument("LOOP", loop_name, "altitude, or attitude");
  line.Input(
      "vehicle", vehicle_name, "VEHICLE", "a vehicle file, or the name of a shipped vehicle");
  line.Input(
      "gains",
      gains_name,
      "GAINS",
      "unaware, aware, placed (by the lag of the vehicle's motors), or a gains file (default "
      "unaware for a Mambo, placed for any other vehicle)");
  line.Text("xi", range, "RANGE", "voltage over the nominal one: FIRST:STEP:LAST, or one number");
  line.OutputOption(
      "output,o",
      output,
      "CSV",
      "one row per pole: xi, kappa, kind (0: closed form (5.21), 1: quasi-static motors, 2: with the lag of the motors), real and imaginary part in 1/s");
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Loop loop = FindLoop(loop_name);
  const Vehicle vehicle = LoadVehicle(vehicle_name);
  const Gains gains = GainsFor(gains_name, vehicle, "unaware");
  const ErrorGains& own = loop == Loop::kAltitude ? gains.altitude : gains.attitude;
  if (!(gains.altitude.integral > 0.0)) {
    throw OptionError(fmt::format(
        "gains {}: the altitude has no integral gain, so hover at xi < 1 is no equilibrium and has "
        "no poles. Give it one",
        gains.name));
  }

  cli::TextTable table({{"xi"},
                        {"kappa"},
                        {"closed form", cli::Align::kLeft},
                        {"quasi-static", cli::Align::kLeft},
                        {"with motor lag", cli::Align::kLeft}},
                       "Poles of the loop over xi.");
  Json rows = Json::array();
  std::vector<PolesRow> all;
  for (const double xi : ReadRange("xi", range, Range{1e-3, 2.0})) {
    const PolesRow row = PolesAt(loop, vehicle, gains, xi);
    table.Row({fmt::format("{:.4g}", xi),
               fmt::format("{:.4f}", row.kappa),
               ToText(row.closed_form),
               ToText(row.quasistatic),
               ToText(row.full)});
    rows.push_back(PolesRowToJson(row));
    all.push_back(row);
  }
  if (!output.empty()) {
    // 0 closed form, 1 quasi-static, 2 full.
    CsvWriter csv(output, "xi,kappa,kind,re,im");
    for (const PolesRow& row : all) {
      double kind = 0.0;
      for (const Poles* poles : {&row.closed_form, &row.quasistatic, &row.full}) {
        for (const auto& pole : *poles) csv.Row(row.xi, row.kappa, kind, pole.real(), pole.imag());
        kind += 1.0;
      }
    }
    csv.Commit();
  }
  line.summary()["rows"] = std::move(rows);
  line.summary()["loop"] = loop_name;
  line.summary()["vehicle"] = vehicle.name;
  line.summary()["gains"] = gains.name;
  line.summary()["error_gains"] = {{"proportional", own.proportional},
                                   {"integral", own.integral},
                                   {"derivative", own.derivative}};
  line.Print("{}", table.Text());
  line.Message("{} loop of {} with K_e {}, K_eI {}, K_edot {} ({})",
               loop_name,
               vehicle.name,
               own.proportional,
               own.integral,
               own.derivative,
               gains.name);
  const auto unstable = std::count_if(
      all.begin(), all.end(), [](const PolesRow& row) { return row.full.front().real() >= 0.0; });
  if (unstable > 0) {
    line.Message("with motor lag {} of {} are unstable", unstable, all.size());
  }
  const double lowest_xi = LowestHoverXi(vehicle);
  const auto below = std::count_if(
      all.begin(), all.end(), [&](const PolesRow& row) { return row.xi < lowest_xi; });
  if (below > 0) {
    line.Message("{} cannot hover below xi = {:.3f}: rows of flights that cannot be: {} of {}",
                 vehicle.name,
                 lowest_xi,
                 below,
                 all.size());
  }
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
