// lipoid fly MANEUVER: a flight of a vehicle on an identified cell, or on an ideal source.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "identify/pack_request.h"
#include "model/analysis/before_flight.h"
#include "model/analysis/placed_gains.h"
#include "model/control/gains.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/flight/coupling.h"
#include "model/flight/flight_ensemble.h"
#include "model/flight/flight_log.h"
#include "model/flight/flight_report.h"
#include "model/flight/fly_request.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/ambient_option.h"
#include "tools/commands/ensemble_option.h"
#include "tools/commands/loaded_cell.h"
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

void PrintFlight(cli::CommandLine& line, std::string_view maneuver, const FlightResult& flight) {
  if (flight.outcome == Outcome::kOffCourse)
    line.Print("{}", cli::Wrapped(fmt::format("Off course: {}.\n\n", flight.reason)));
  cli::TextTable table({{std::string(maneuver), Align::kLeft}, {"value"}, {"unit", Align::kLeft}},
                       "The flight.");
  const auto row = [&](std::string what, std::string value, std::string unit) {
    table.Row({std::move(what), std::move(value), std::move(unit)});
  };
  row("outcome", options_internal::ToText(flight.outcome), "");
  row("simulated", fmt::format("{:.3f}", flight.simulated_s), "s");
  row("hover duty", fmt::format("{:.3f}", flight.trim.duty), "at the start");
  row("hover current",
      flight.trim.power_suffices ? fmt::format("{:.3f}", flight.trim.battery_A) : "-",
      "A");
  row("altitude error", Significant(std::sqrt(flight.mse_altitude_m2)), "m rms");
  row("pitch error", Significant(std::sqrt(flight.mse_pitch_deg2)), "degrees rms");
  if (std::isfinite(flight.mse_position_m2)) {
    row("position error", Significant(std::sqrt(flight.mse_position_m2)), "m rms");
    row("", Significant(flight.largest_position_error_m), "m at the largest");
    row("speed", Significant(flight.fastest_m_per_s), "m/s at the largest, along x or y");
  }
  constexpr std::size_t kMostShown = 8;
  const auto& distances_m = flight.waypoint_distance_m;
  if (distances_m.size() > kMostShown) {
    row(fmt::format("largest of {} distances from waypoints", distances_m.size()),
        Significant(*std::max_element(distances_m.begin(), distances_m.end())),
        "m at the end of its stay");
  }
  for (std::size_t k = 0; k < distances_m.size() && distances_m.size() <= kMostShown; ++k) {
    row(fmt::format("waypoint {}", k + 1),
        Significant(flight.waypoint_distance_m[k]),
        "m away at the end of its stay");
    constexpr double kSeen_degrees = 1.0;
    const double degrees = flight.waypoint_heading_error_rad[k] * 180.0 / std::numbers::pi;
    if (degrees > kSeen_degrees) row("", Significant(degrees), "degrees from its heading then");
  }
  for (std::size_t k = 0; k < flight.peak_altitude_error_m.size(); ++k) {
    row(fmt::format("peak after step {}", k + 1),
        fmt::format("{:.4f}", flight.peak_altitude_error_m[k]),
        "m of the reference above the altitude");
  }
  row("charge",
      fmt::format("{:.2f}", flight.charge_C),
      fmt::format("C, {:.4g} Ah", flight.charge_C / 3600.0));
  row("voltage", fmt::format("{:.4f}", flight.final_voltage_V), "V at the end");
  row("", fmt::format("{:.4f}", flight.minimum_voltage_V), "V at the lowest");
  if (std::isfinite(flight.final_soc)) {
    row("soc", fmt::format("{:.4f}", flight.final_soc), "at the end, available under load");
    row("charge left",
        fmt::format("{:.4f}", flight.rest_soc),
        "of what the pack can deliver: what it has after a rest");
  }
  if (std::isfinite(flight.final_temperature_degC))
    row("temperature", fmt::format("{:.2f}", flight.final_temperature_degC), "degC at the end");
  if (flight.saturated_share > 0.0) {
    row("saturated", fmt::format("{:.1f}", 100.0 * flight.saturated_share), "% of the steps");
  }
  line.Print("{}", table.Text());
}

void PrintEnsemble(cli::CommandLine& line,
                   const FlightResult& flight,
                   const std::vector<FlightResult>& flights) {
  cli::TextTable table({{Counted(flights.size(), "cell") + " drawn", Align::kLeft},
                        {"estimate"},
                        {"95 % from"},
                        {"to"}},
                       "The flight on cells drawn from what the identification leaves open.");
  for (const FlightNumber& number : kFlightNumbers) {
    const auto [low, high] = IntervalOf(flights, number.of);
    table.Row({std::string(number.what),
               Significant(flight.*number.of),
               Significant(low),
               Significant(high)});
  }
  line.Print("\n{}completed {}, crashed {}, battery empty {}, off course {}\n",
             table.Text(),
             CountOf(flights, Outcome::kCompleted),
             CountOf(flights, Outcome::kCrashed),
             CountOf(flights, Outcome::kBatteryEmpty),
             CountOf(flights, Outcome::kOffCourse));
}

// What goes with a cell alone, and what with an ideal source alone.
void CheckSource(Battery source,
                 const std::string& cell_name,
                 const FlyRequest& asked,
                 const PackRequest& pack,
                 const StartRequest& start,
                 const EnsembleOption& ensemble) {
  if (source == Battery::kIdeal && !cell_name.empty()) {
    throw OptionError("options --battery ideal and --cell: give one of them");
  }
  if (source == Battery::kCell && asked.xi) {
    throw OptionError(
        "option --xi is for an ideal source: a cell has its own voltage. Give --battery ideal, or "
        "leave --xi out");
  }
  if (source == Battery::kIdeal && pack.given()) {
    throw OptionError(
        "options --series and --parallel are for cells; an ideal source has the nominal voltage of "
        "the vehicle times --xi");
  }
  if (source == Battery::kIdeal && start.given()) {
    throw OptionError(
        "options --initial-soc and --initial-voltage-V are for a cell; an ideal source has --xi");
  }
  if (source == Battery::kIdeal && ensemble.asked()) {
    throw OptionError("option --ensemble is for a cell; an ideal source has no uncertainty");
  }
  if (source == Battery::kIdeal && asked.ChangesCell()) {
    throw OptionError(
        "options --capacity-Ah, --health and --resistance-factor are for a cell; an ideal source does "
        "not run empty and has no resistance");
  }
  if (source == Battery::kIdeal && asked.setup.ambient_degC) {
    throw OptionError(
        "option --ambient-degC is for a cell; an ideal source has the same voltage in the cold");
  }
}

// The vehicle with what it carries, and the battery with what makes it another one than the cell file's.
std::string WhatFlies(const FlyRequest& asked) {
  const FlightSetup& setup = asked.setup;
  std::string text = setup.vehicle.name;
  if (asked.payload_g > 0.0) text += fmt::format(" with {:g} g more", asked.payload_g);
  if (!setup.cell) {
    return text + fmt::format(" on an ideal source of {:.3f} V",
                              setup.xi * setup.vehicle.nominal_voltage_V);
  }
  text += " on " + setup.cell->name;
  if (asked.capacity_Ah) text += fmt::format(" in a size of {:g} Ah", *asked.capacity_Ah);
  std::vector<std::string> aged;
  if (asked.health != 1.0) aged.push_back(fmt::format("{:g} of its capacity", asked.health));
  if (asked.resistance_factor != 1.0)
    aged.push_back(fmt::format("{:g} times its resistance", asked.resistance_factor));
  if (!aged.empty()) text += fmt::format(" with {}", fmt::join(aged, " and "));
  return text;
}

}  // namespace

cli::ExitCode FlyCommand(cli::CommandLine& line) {
  std::string maneuver_name;
  std::string cell_name;
  std::string output;
  WindOption wind;
  ManeuverRequest request;
  std::map<std::string_view, ManeuverRequest> values;  // of each maneuver
  FlyRequest asked;
  FlightSetup& setup = asked.setup;
  StartRequest start;
  PackRequest pack;
  EnsembleOption ensemble;
  std::optional<Battery> battery;

  std::vector<std::string> names;
  for (const Maneuver& maneuver : Maneuvers()) names.emplace_back(maneuver.name);
  line.Describe(
      "Flies a maneuver: rigid body, motors, battery and flight controller, coupled through the "
      "battery's voltage. Starts hovering. Exit code 1 where the vehicle crashes, the battery runs "
      "empty, or the vehicle loses its place or its altitude or misses a waypoint.",
      "lipoid fly altitude-steps --cell gifi-600mAh-1 --vehicle mambo-coupled -o flight.csv");
  line.Example("lipoid fly altitude-steps --battery ideal --xi 0.8 --gains unaware");
  line.Example("lipoid fly hover --cell cell.json --ensemble 200");
  line.Example(
      "lipoid fly endurance --cell grepow-32Ah-1 --capacity-Ah 5 --series 4 --vehicle f450 "
      "--payload-g 150 --health 0.8");
  line.Argument("MANEUVER", maneuver_name, fmt::format("one of: {}", fmt::join(names, ", ")));
  line.Option("battery",
              battery,
              Names(),
              "an identified cell, or an ideal source of xi times the nominal voltage");
  line.Input("cell",
             cell_name,
             "CELL",
             "a cell file, or the name of a shipped cell (default gifi-600mAh-1)");
  std::string law = setup.controller.law;
  line.Text("controller", law, "NAME", "inversion, or another of `lipoid list controllers`");
  line.Each(asked);
  wind.AddTo(line, setup.wind, "along x, y and down");
  line.Each(start);
  line.Each(pack);
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

  if (line.Given("controller")) {
    if (line.Sets("controller.law"))
      throw OptionError("options --controller and --set controller.law: give one of them");
    setup.controller.law = law;
  }
  if (!setup.estimate && (line.Sets("sensors.") || line.Sets("estimator."))) {
    line.Message(
        "options --set sensors.* and estimator.* change nothing without --estimate: the "
        "controller sees the true state");
  }
  const Maneuver& maneuver = FindManeuver(maneuver_name);
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
      battery.value_or(asked.xi && cell_name.empty() ? Battery::kIdeal : Battery::kCell);
  CheckSource(source, cell_name, asked, pack, start, ensemble);
  if (source == Battery::kCell) {
    if (cell_name.empty()) cell_name = "gifi-600mAh-1";
    setup.cell = LoadCell(line, cell_name);
    pack.ApplyTo(*setup.cell);
    if (setup.ambient_degC)
      setup.cell = KnowingTemperature(line, *setup.cell, cell_name, asked.SizeFactor(*setup.cell));
    setup.initial_soc = start.Soc(*setup.cell, {.ambient_degC = setup.ambient_degC});
  }
  setup.xi = asked.xi.value_or(1.0);
  request.waypoints_file = asked.waypoints.path;
  setup.vehicle = asked.Loaded(LoadVehicle(asked.VehicleName()));
  CheckFlight(setup, maneuver, request, asked.duration_s.has_value());
  setup.gains = GainsFor(asked.gains.path, setup.vehicle, "aware", setup.controller.law);
  setup.seed = line.seed();
  wind.ReadInto(setup.wind);
  if (line.Sets("simulation.drag") && !setup.simulation.drag && Blows(setup.wind)) {
    throw OptionError(
        "option --set simulation.drag=false: wind and gusts act on the vehicle by its drag alone; leave "
        "it out, or --wind and --gusts");
  }
  request.duration_s = asked.duration_s;
  FlightPlan plan = maneuver.plan(request);
  if (asked.duration_s) plan.duration_s = *asked.duration_s;
  const double step_s = asked.LogStep_s(plan.duration_s);
  EnsembleOption::Drawn drawn;
  if (ensemble.asked()) {
    drawn =
        ensemble.Draw(line, *setup.cell, cell_name, start, {.ambient_degC = setup.ambient_degC});
    for (Cell& cell : drawn.cells) cell = asked.Aboard(cell);
  }
  if (setup.cell) {
    const Cell of_file = *setup.cell;
    setup.cell = asked.Aboard(of_file);
    if (const auto doubt = DoubtAboutSize(of_file, asked.SizeFactor(of_file)); !doubt.empty())
      line.Message("{}", doubt);
  }

  const auto hovers = CheckFlightLoops(setup);
  for (const std::string& warning : WarningsBeforeFlight(setup, maneuver, plan, hovers))
    line.Message("{}", warning);
  if (asked.log_step_s && output.empty() && line.report_file().empty())
    line.Message("--log-step-s is of the flight log: name one (-o flight.csv)");
  std::optional<FlightLogWriter> log;
  std::optional<FlightSeries> series;
  FlightRecorder recorder;
  if (!output.empty()) log.emplace(output, setup.vehicle.rotor_count(), setup.Warms());
  if (!line.report_file().empty()) series.emplace(setup.vehicle.rotor_count(), setup.Warms());
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
  line.summary() = FlightToJson(flight);
  line.summary().update(FlownToJson(setup, maneuver, request));
  line.summary()["loops"] = StabilityToJson(hovers);
  line.summary()["messages"] = line.messages();  // but for `doubts` and what is about the log
  if (log) log->Commit();
  if (log && !asked.log_step_s && step_s > kControlStep_s) {
    line.Message("{}: a row each {} s of a long flight; --log-step-s {} writes every control step",
                 output,
                 step_s,
                 kControlStep_s);
  }

  if (series) line.report_series().push_back(series->Take(output));
  PrintFlight(line, maneuver.name, flight);
  if (ensemble.asked()) {
    line.summary()["ensemble"] = std::move(drawn.json);
    line.summary()["ensemble"].update(FlightsToJson(flights));
    PrintEnsemble(line, flight, flights);
  }
  if (setup.gains.name == kPlacedGains) line.Message("{}", PlaceGains(setup.vehicle).Brief());
  line.Message("{}, {} gains{}",
               WhatFlies(asked),
               setup.gains.name,
               setup.controller.compensate ? ", commands compensated for the voltage" : "");
  const auto doubts = FlightDoubts(setup, plan, flight);
  for (const std::string& doubt : doubts) line.Message("{}", doubt);
  line.summary()["doubts"] = doubts;
  if (!flight.reason.empty() && flight.outcome != Outcome::kOffCourse)
    line.Message("{}", flight.reason);
  return flight.outcome == Outcome::kCompleted ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
