// lipoid fly MANEUVER: a flight of a vehicle on an identified cell, or on an ideal source.
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/core/errors.h"
#include "model/flight/flight_ensemble.h"
#include "model/flight/flight_log.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/allocation.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/ensemble_option.h"
#include "tools/commands/start_options.h"
#include "tools/commands/wind_option.h"
#include "tools/report/flight_series.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

enum class Battery { kCell, kIdeal };

constexpr std::array<std::pair<Battery, std::string_view>, 2> OptionNames(Battery) {
  return {{{Battery::kCell, "cell"}, {Battery::kIdeal, "ideal"}}};
}

// A log of every control step takes 60 kB a second: of a flight that takes longer, it is thinned.
constexpr double kLongFlight_s = 600.0;
constexpr double kLongFlightLogStep_s = 1.0;

Json Summary(const FlightResult& flight) {
  Json trim = {{"possible", flight.trim.possible()},
               {"speed_rad_per_s", flight.trim.speed_rad_per_s},
               {"duty", flight.trim.duty},
               {"battery_V", flight.trim.battery_V},
               {"battery_A", flight.trim.battery_A}};
  Json summary = {{"outcome", options_internal::ToText(flight.outcome)},
                  {"reason", flight.reason},
                  {"trim", std::move(trim)},
                  {"steps", flight.steps},
                  {"simulated_s", flight.simulated_s},
                  {"wall_s", flight.wall_s},
                  {"peak_altitude_error_m", flight.peak_altitude_error_m},
                  {"mse_altitude_m2", NumberOrNull(flight.mse_altitude_m2)},
                  {"mse_pitch_deg2", NumberOrNull(flight.mse_pitch_deg2)},
                  {"charge_C", NumberOrNull(flight.charge_C)},
                  {"final_voltage_V", NumberOrNull(flight.final_voltage_V)},
                  {"final_soc", NumberOrNull(flight.final_soc)},
                  {"minimum_voltage_V", NumberOrNull(flight.minimum_voltage_V)},
                  {"saturated_share", flight.saturated_share}};
  if (flight.landed_s) summary["landed_s"] = *flight.landed_s;
  return summary;
}

// What a drawing of the vehicle needs: where the motors are, ahead and to the right of the centre of
// mass, and which way they turn seen from above.
Json Geometry(const Vehicle& vehicle) {
  Json motors = Json::array();
  for (std::size_t i = 0; i < kPitchSign.size(); ++i) {
    const bool as_front_right = kYawSign[i] == kYawSign[0];
    const bool clockwise = (vehicle.front_right_turns == Turning::kClockwise) == as_front_right;
    motors.push_back(
        {{"ahead_m", vehicle.lever_m() * kPitchSign[i]},
         {"right_m", -vehicle.lever_m() * kRollSign[i]},
         {"turns",
          options_internal::ToText(clockwise ? Turning::kClockwise : Turning::kCounterClockwise)}});
  }
  return {{"arm_m", vehicle.arm_m}, {"motors", std::move(motors)}};
}

// Above the voltage at rest it would land before it took off.
void CheckLandingVoltage(const FlightSetup& setup) {
  const double full_V =
      setup.cell ? setup.cell->series * setup.cell->open_circuit_voltage(setup.initial_soc)
                 : setup.xi * setup.vehicle.nominal_voltage_V;
  if (setup.land_below_V < full_V) return;
  throw OptionError(fmt::format(
      "option --land-below-V: {:g} V is not below the {:.4g} V that the battery has at rest when it "
      "takes off; give less",
      setup.land_below_V,
      full_V));
}

void PrintFlight(cli::CommandLine& line, std::string_view maneuver, const FlightResult& flight) {
  cli::TextTable table({{std::string(maneuver), Align::kLeft}, {"value"}, {"unit", Align::kLeft}});
  const auto row = [&](std::string what, std::string value, std::string unit) {
    table.Row({std::move(what), std::move(value), std::move(unit)});
  };
  row("outcome", options_internal::ToText(flight.outcome), "");
  row("simulated", fmt::format("{:.3f}", flight.simulated_s), "s");
  row("hover duty", fmt::format("{:.3f}", flight.trim.duty), "at the start");
  row("hover current", fmt::format("{:.3f}", flight.trim.battery_A), "A");
  row("altitude error", Significant(std::sqrt(flight.mse_altitude_m2)), "m rms");
  row("pitch error", Significant(std::sqrt(flight.mse_pitch_deg2)), "degrees rms");
  for (std::size_t k = 0; k < flight.peak_altitude_error_m.size(); ++k) {
    row(fmt::format("peak after step {}", k + 1),
        fmt::format("{:.4f}", flight.peak_altitude_error_m[k]),
        "m of the reference above the altitude");
  }
  row("charge", fmt::format("{:.2f}", flight.charge_C), "C");
  row("voltage", fmt::format("{:.4f}", flight.final_voltage_V), "V at the end");
  row("", fmt::format("{:.4f}", flight.minimum_voltage_V), "V at the lowest");
  if (std::isfinite(flight.final_soc))
    row("soc", fmt::format("{:.4f}", flight.final_soc), "at the end");
  if (flight.saturated_share > 0.0) {
    row("saturated", fmt::format("{:.1f}", 100.0 * flight.saturated_share), "% of the steps");
  }
  line.Print("{}", table.Text());
}

struct FlightNumber {
  std::string_view key;
  std::string_view what;
  double FlightResult::*of;
};

// What an ensemble gives intervals of.
constexpr FlightNumber kFlightNumbers[] = {
    {"final_soc", "soc at the end", &FlightResult::final_soc},
    {"minimum_voltage_V", "lowest voltage / V", &FlightResult::minimum_voltage_V},
    {"simulated_s", "flown / s", &FlightResult::simulated_s},
    {"mse_altitude_m2", "altitude error / m^2", &FlightResult::mse_altitude_m2},
    {"charge_C", "charge / C", &FlightResult::charge_C}};

Json EnsembleSummary(const std::vector<FlightResult>& flights) {
  Json intervals = Json::object();
  for (const FlightNumber& number : kFlightNumbers) {
    const auto [low, high] = IntervalOf(flights, number.of);
    intervals[std::string(number.key)] = {NumberOrNull(low), NumberOrNull(high)};
  }
  return {{"completed", CountOf(flights, Outcome::kCompleted)},
          {"crashed", CountOf(flights, Outcome::kCrashed)},
          {"battery_empty", CountOf(flights, Outcome::kBatteryEmpty)},
          {"interval_95", std::move(intervals)}};
}

void PrintEnsemble(cli::CommandLine& line,
                   const FlightResult& flight,
                   const std::vector<FlightResult>& flights) {
  cli::TextTable table({{fmt::format("{} cells drawn", flights.size()), Align::kLeft},
                        {"estimate"},
                        {"95 % from"},
                        {"to"}});
  for (const FlightNumber& number : kFlightNumbers) {
    const auto [low, high] = IntervalOf(flights, number.of);
    table.Row({std::string(number.what),
               Significant(flight.*number.of),
               Significant(low),
               Significant(high)});
  }
  line.Print("\n{}completed {}, crashed {}, battery empty {}\n",
             table.Text(),
             CountOf(flights, Outcome::kCompleted),
             CountOf(flights, Outcome::kCrashed),
             CountOf(flights, Outcome::kBatteryEmpty));
}

}  // namespace

cli::ExitCode FlyCommand(cli::CommandLine& line) {
  std::string maneuver_name;
  std::string cell_name;
  std::string vehicle_name;
  std::string gains_name = "aware";
  std::string output;
  std::string wind;
  ManeuverRequest request;
  std::map<std::string_view, ManeuverRequest> values;  // of each maneuver
  FlightSetup setup;
  StartOptions start;
  EnsembleOption ensemble;
  std::optional<Battery> battery;
  std::optional<double> xi;
  std::optional<double> duration_s;
  std::optional<double> log_step_s;

  std::vector<std::string> names;
  for (const Maneuver& maneuver : Maneuvers()) names.emplace_back(maneuver.name);
  line.Describe(
      "Flies a maneuver: rigid body, motors, battery and flight controller, coupled through the "
      "battery's voltage. Starts hovering. Exit code 1 where the vehicle crashes or the battery "
      "runs empty.",
      "lipoid fly altitude-steps --cell gifi-600mAh-1 --vehicle mambo-coupled -o flight.csv");
  line.Example("lipoid fly altitude-steps --battery ideal --xi 0.8 --gains unaware");
  line.Example("lipoid fly hover --cell cell.json --ensemble 200");
  line.Argument("MANEUVER", maneuver_name, fmt::format("one of: {}", fmt::join(names, ", ")));
  line.Option("battery",
              battery,
              Names(),
              "an identified cell, or an ideal source of xi times the nominal voltage");
  line.Input("cell",
             cell_name,
             "CELL",
             "a cell file, or the name of a shipped cell (default gifi-600mAh-1)");
  line.Option(
      "xi", xi, Range{0.01, 2.0}, "voltage of the ideal source over the nominal one (default 1)");
  line.Input("vehicle",
             vehicle_name,
             "VEHICLE",
             "a vehicle file, or the name of a shipped vehicle (default mambo-coupled on a cell, "
             "mambo-thesis on an ideal source)");
  line.Input("gains", gains_name, "GAINS", "unaware, aware, or a gains file");
  line.Text("controller",
            setup.controller.law,
            "NAME",
            "inversion, or another of `lipoid list controllers` (default inversion)");
  line.Flag("compensate", setup.controller.compensate, "commands use the measured voltage (5.52)");
  line.Flag("estimate",
            setup.estimate,
            "the controller sees noisy sensors through the estimator, not the true state");
  line.Input("waypoints",
             request.waypoints_file,
             "FILE",
             "places for the maneuver waypoints (docs/formats.md)");
  line.Text("wind", wind, "X[,Y[,Z]]", "m/s that the air moves along x, y and down");
  line.Option("gusts",
              setup.wind.gusts_m_per_s,
              Range{0.0, 60.0},
              "Dryden gusts by the wind speed at 20 ft: 7.7 light, 15.4 moderate, 23.2 severe");
  line.Option(
      "duration", duration_s, Range{kControlStep_s, 1e6}, "seconds, instead of the maneuver's own");
  line.Option("land-below-V",
              setup.land_below_V,
              Range{0.0, 1e4},
              "land when the battery has been below it for a second; 0: never");
  line.Option(
      "log-step-s",
      log_step_s,
      Range{kControlStep_s, 1e4},
      fmt::format("seconds between rows of the flight log (default {} up to {} s of flight, {} "
                  "beyond: endurance)",
                  kControlStep_s,
                  kLongFlight_s,
                  kLongFlightLogStep_s));
  start.AddTo(line);
  ensemble.AddTo(line, "how far the flight on each of them differs; the log is of the estimate");
  line.OutputOption("output,o",
                    output,
                    "CSV",
                    "flight log: state, references, motors, battery (docs/formats.md)");
  line.ReportOption();
  for (const Maneuver& maneuver : Maneuvers()) {
    if (maneuver.options == nullptr) continue;
    line.Group(maneuver.name,
               maneuver.options(),
               [&maneuver, &values](std::string_view name, std::string_view text) {
                 auto& own = values[maneuver.name].values;
                 own[std::string(name)] = text;
                 (void)maneuver.values(values[maneuver.name]);  // the value is checked here
               });
  }
  line.Group("controller", setup.controller);
  line.Group("simulation", setup.simulation);
  line.Group("sensors", setup.sensors);
  line.Group("estimator", setup.estimator);
  if (!line.Parse()) return cli::ExitCode::kDone;

  const Maneuver& maneuver = FindManeuver(maneuver_name);
  if (maneuver.needs_file != !request.waypoints_file.empty()) {
    throw OptionError(maneuver.needs_file
                          ? "maneuver waypoints needs a file of places: --waypoints FILE"
                          : fmt::format("option --waypoints is for the maneuver waypoints, not {}",
                                        maneuver.name));
  }
  for (const auto& [name, own] : values) {
    if (name != maneuver.name) {
      throw OptionError(fmt::format("option --set {}.{}: the maneuver is {}",
                                    name,
                                    own.values.begin()->first,
                                    maneuver.name));
    }
    request.values = own.values;
  }
  const Battery source =
      battery.value_or(xi && cell_name.empty() ? Battery::kIdeal : Battery::kCell);
  if (source == Battery::kIdeal && !cell_name.empty()) {
    throw OptionError("options --battery ideal and --cell: give one of them");
  }
  if (source == Battery::kCell && xi) {
    throw OptionError(
        "option --xi is for an ideal source: a cell has its own voltage. Give --battery ideal, or "
        "leave --xi out");
  }
  if (source == Battery::kIdeal && (start.initial_soc || start.initial_voltage_V)) {
    throw OptionError(
        "options --initial-soc and --initial-voltage-V are for a cell; an ideal source has --xi");
  }
  if (source == Battery::kIdeal && ensemble.asked()) {
    throw OptionError("option --ensemble is for a cell; an ideal source has no uncertainty");
  }
  if (source == Battery::kCell) {
    if (cell_name.empty()) cell_name = "gifi-600mAh-1";
    setup.cell = LoadCell(cell_name);
    setup.initial_soc = start.Soc(*setup.cell);
  }
  setup.xi = xi.value_or(1.0);
  if (vehicle_name.empty()) vehicle_name = setup.cell ? "mambo-coupled" : "mambo-thesis";
  setup.vehicle = LoadVehicle(vehicle_name);
  CheckLandingVoltage(setup);
  (void)FindControlLaw(setup.controller.law);  // before anything is computed
  setup.gains = LoadGains(gains_name);
  setup.seed = line.seed();
  ReadWind("wind", wind, setup.wind);
  if (maneuver.until_empty && !setup.cell && !duration_s) {
    throw OptionError(
        fmt::format("maneuver {} ends with an empty battery, and an ideal source is never empty: "
                    "give --duration",
                    maneuver.name));
  }
  FlightPlan plan = maneuver.plan(request);
  if (duration_s) plan.duration_s = *duration_s;

  EnsembleOption::Drawn drawn;
  if (ensemble.asked()) drawn = ensemble.Draw(line, *setup.cell, cell_name, start);

  std::optional<FlightLogWriter> log;
  std::optional<FlightSeries> series;
  FlightRecorder recorder;
  const double step_s =
      log_step_s.value_or(plan.duration_s > kLongFlight_s ? kLongFlightLogStep_s : kControlStep_s);
  if (!output.empty()) log.emplace(output);
  if (!line.report_file().empty()) series.emplace();
  if (log || series) {
    const auto every = std::max(1LL, std::llround(step_s / kControlStep_s));
    recorder = [&log, &series, every, k = 0LL](const FlightSample& sample) mutable {
      if (k++ % every != 0) return;
      if (log) log->Row(sample);
      if (series) series->Row(sample);
    };
  }
  const FlightResult flight = Fly(
      setup, plan, recorder, [&](double fraction) { line.progress().Update(fraction, "flying"); });
  const std::vector<FlightResult> flights =
      FlyOnEach(setup, plan, drawn.cells, drawn.initial_soc, [&](double fraction) {
        line.progress().Update(fraction, "flying the cells drawn");
      });
  if (log) log->Commit();
  if (log && !log_step_s && step_s > kControlStep_s) {
    line.Message("{}: a row each {} s of a long flight; --log-step-s {} writes every control step",
                 output,
                 step_s,
                 kControlStep_s);
  }

  line.summary() = Summary(flight);
  line.summary()["maneuver"] = maneuver.name;
  line.summary()["maneuver_options"] = Json::object();
  if (maneuver.values != nullptr) {
    for (const auto& [name, value] : maneuver.values(request))
      line.summary()["maneuver_options"][name] = value;
  }
  line.summary()["vehicle"] = setup.vehicle.name;
  line.summary()["battery"] =
      setup.cell ? setup.cell->name : fmt::format("ideal source, xi = {}", setup.xi);
  line.summary()["gains"] = setup.gains.name;
  line.summary()["controller"] = setup.controller.law;
  line.summary()["compensate"] = setup.controller.compensate;
  line.summary()["estimate"] = setup.estimate;
  line.summary()["cutoff_V"] =
      setup.cell ? Json(setup.cell->series * setup.cell->cutoff_V) : Json(nullptr);
  line.summary()["vehicle_geometry"] = Geometry(setup.vehicle);
  if (series) line.report_series().push_back(series->Take(output));
  PrintFlight(line, maneuver.name, flight);
  if (ensemble.asked()) {
    line.summary()["ensemble"] = std::move(drawn.json);
    line.summary()["ensemble"].update(EnsembleSummary(flights));
    PrintEnsemble(line, flight, flights);
  }
  line.Message("{} on {}, {} gains{}",
               setup.vehicle.name,
               setup.cell ? setup.cell->name
                          : fmt::format("an ideal source of {:.3f} V",
                                        setup.xi * setup.vehicle.nominal_voltage_V),
               setup.gains.name,
               setup.controller.compensate ? ", commands compensated for the voltage" : "");
  if (!flight.trim.possible()) {
    line.Message("{} cannot hover on this battery: {}",
                 setup.vehicle.name,
                 flight.trim.power_suffices
                     ? fmt::format("it would need a duty cycle of {:.3f} at {:.3f} V",
                                   flight.trim.duty,
                                   flight.trim.battery_V)
                     : std::string("it never gives the power"));
  }
  if (!flight.reason.empty()) line.Message("{}", flight.reason);
  return flight.outcome == Outcome::kCompleted ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
