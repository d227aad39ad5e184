// lipoid endurance: how long a vehicle flies on a pack, and how far that is known.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/export/mission.h"
#include "model/battery/cell_file.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/flight/endurance_report.h"
#include "model/flight/endurance_request.h"
#include "model/statistics/interval_95.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/ambient_option.h"
#include "tools/commands/start_options.h"
#include "tools/commands/uncertain_option.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

constexpr double kGramsPerKilogram = 1000.0;

// Why the flight ended, as a sentence.
std::string Reason(const EnduranceRequest& request, const EnduranceAnswer& answer) {
  const EnduranceResult& result = answer.estimate;
  switch (result.ended_by) {
    case MissionEnd::kReserve:
      return fmt::format(
          "The reserve of {:g} % of the charge was reached: land when the battery "
          "falls to {:.2f} V in flight.",
          100.0 * request.reserve.value,
          result.landing_voltage_V);
    case MissionEnd::kCutOff:
      return fmt::format(
          "The battery was below its cut-off of {:.4g} V for a second, with {:.1f} % "
          "of its charge left.",
          request.cell.series * request.cell.cutoff_V,
          100.0 * result.rest_soc);
    case MissionEnd::kEmpty:
      return fmt::format(
          "The charge that is available at this current was used up, with {:.1f} % "
          "held back by diffusion.",
          100.0 * result.rest_soc);
    case MissionEnd::kMotorVoltage:
      return fmt::format(
          "The motors need {}more than the {:.2f} V that the battery gives under load.{}",
          request.power ? "" : fmt::format("{:.2f} V, ", answer.flight.battery_V),
          result.landing_voltage_V,
          result.time_s == 0.0 ? " The vehicle cannot fly on this pack: give more cells (--series)."
                               : "");
    case MissionEnd::kPower:
      return fmt::format("No current of the battery gives the power of the mission any more{}",
                         result.time_s == 0.0 ? ": give more cells (--series, --parallel)." : ".");
    case MissionEnd::kMissionDone:
      return "The mission was flown to its end.";
    case MissionEnd::kTimeLimit:
      return fmt::format("The battery was not empty after {:g} s; --set longest_s allows more.",
                         request.options.longest_s);
  }
  return "";
}

void PrintAnswer(cli::CommandLine& line,
                 const EnduranceRequest& request,
                 const EnduranceAnswer& answer) {
  const bool intervals = !answer.flights.empty();
  std::vector<cli::TextTable::Column> columns{{"until landing", Align::kLeft}, {"estimate"}};
  if (intervals) columns.insert(columns.end(), {{"95 % from"}, {"to"}});
  cli::TextTable table(columns);
  for (const EnduranceNumber& number : EnduranceNumbers()) {
    const double value = number.of(answer.estimate);
    if (!std::isfinite(value)) continue;
    std::vector<std::string> cells{std::string(number.what), Significant(value)};
    if (intervals) {
      const auto interval = IntervalOf(answer, number);
      cells.push_back(interval ? Significant(interval->first) : "");
      cells.push_back(interval ? Significant(interval->second) : "");
    }
    table.Row(std::move(cells));
  }
  line.Print("{}{}\n", table.Text(), Reason(request, answer));
  if (!answer.speeds) return;
  line.Print(
      "At {:.1f} m/s. It flies longest at {:.1f} m/s, farthest at {:.1f} m/s, and no faster "
      "than {:.1f} m/s.\n",
      answer.flight.airspeed_m_per_s,
      answer.speeds->endurance.airspeed_m_per_s,
      answer.speeds->range.airspeed_m_per_s,
      answer.speeds->fastest_m_per_s);
}

PowerMission MissionOf(const PowerProfile& profile) {
  PowerMission mission;
  for (std::size_t k = 1; k < profile.time_s.size(); ++k) {
    mission.legs.push_back(
        {.duration_s = profile.time_s[k] - profile.time_s[k - 1],
         .power_W = profile.power_W[profile.hold == Hold::kBackward ? k : k - 1]});
  }
  return mission;
}

// Reads hover, cruise or power=FILE.
void SetMission(cli::CommandLine& line, const std::string& text, EnduranceRequest& request) {
  constexpr std::string_view kPower = "power=";
  request.cruise = text == "cruise";
  if (request.cruise || text == "hover") return;
  if (text.starts_with(kPower)) {
    const std::string file = text.substr(kPower.size());
    line.AddInputs({file});
    const ReadPower read = ReadPowerFile(file, {});
    for (const std::string& warning : read.warnings) line.Message("{}", warning);
    request.power = MissionOf(read.profile);
    return;
  }
  throw OptionError(
      fmt::format("option --mission: expected hover, cruise or power=FILE, found '{}'", text));
}

// Reads a speed or the name of one.
void SetAirspeed(const std::string& text, EnduranceRequest& request) {
  if (text.empty()) return;
  for (const auto& [speed, name] : OptionNames(CruiseSpeed{})) {
    if (text != name) continue;
    if (!request.cruise)
      throw OptionError(fmt::format("option --airspeed-m-per-s: {} is for --mission cruise", name));
    request.cruise_speed = speed;
    return;
  }
  request.airspeed_m_per_s = ReadUncertain("airspeed-m-per-s", text, kAirspeeds_m_per_s);
}

}  // namespace

cli::ExitCode EnduranceCommand(cli::CommandLine& line) {
  EnduranceRequest request;
  StartOptions start;
  std::string vehicle_name;
  std::string cell_name;
  std::string mission = "hover";
  std::string airspeed;
  std::string payload_g = "0";
  std::string ambient_degC;
  std::string health = "1";
  std::string resistance_factor = "1";
  std::string power_factor = "1";
  std::string reserve = "0.2";
  bool once = false;
  std::optional<int> series;
  std::optional<int> parallel;

  line.Describe(
      "Says how long a vehicle flies on a pack, what it uses and at which voltage it has to land, "
      "each with the interval that holds 95 % of what the uncertainties allow. The vehicle is in "
      "equilibrium all the time; `lipoid fly endurance` hovers with its flight controller instead "
      "and logs each step. A number X+-SE has a standard error, which widens the intervals.",
      "lipoid endurance --vehicle mambo-physical --cell gifi-600mAh-1");
  line.Example(
      "lipoid endurance --vehicle mambo-physical --cell cell.json --ambient-degC 5 "
      "--health 0.8+-0.05 --power-factor 1+-0.05");
  line.Example("lipoid endurance --cell cell.json --series 4 --mission power=flight.csv");
  line.Input(
      "vehicle",
      vehicle_name,
      "VEHICLE",
      "a vehicle file, or the name of a shipped vehicle; not needed with --mission power=FILE");
  line.RequiredInput("cell", cell_name, "CELL", "a cell file, or the name of a shipped cell");
  line.Option(
      "series", series, kPackSizes, "cells in series of the pack (default as in the cell file)");
  line.Option("parallel",
              parallel,
              kPackSizes,
              "cells in parallel of the pack (default as in the cell file)");
  line.Text("mission",
            mission,
            "M",
            "hover, cruise, or power=FILE: a CSV of time_s,power_W or any log with voltage and "
            "current, which is flown again and again (default hover)");
  line.Text("airspeed-m-per-s",
            airspeed,
            "SPEED",
            "speed through the air in m/s as X or X+-SE: of cruise, or of the wind in which it "
            "hovers; of cruise also best-range or best-endurance (default best-range)");
  line.Flag("once", once, "fly the mission of a file once instead of again and again");
  line.Text("payload-g",
            payload_g,
            kUncertainWord,
            "mass in g that the vehicle carries besides its own (default 0)");
  line.Text("ambient-degC",
            ambient_degC,
            kUncertainWord,
            "temperature of the air in degC, from which the battery starts and warms (default the "
            "reference temperature of the cell; a cell file that knows no temperature gets typical "
            "energies and heat, and a message says so)");
  line.Text("health",
            health,
            kUncertainWord,
            "capacity left, as a share of that in the cell file (default 1)");
  line.Text("resistance-factor",
            resistance_factor,
            kUncertainWord,
            "resistance of the aged cell over that in the cell file (default 1)");
  line.Text("power-factor",
            power_factor,
            kUncertainWord,
            "power that the battery gives over what the vehicle file says (default 1)");
  line.Text("reserve",
            reserve,
            kUncertainWord,
            "share of the full battery's charge that is left at landing, 0.2 or 20% (default 0.2)");
  start.AddTo(line);
  line.Option("ensemble",
              request.ensemble,
              Range{0, 100000},
              "flights with values drawn from all uncertainties, for the intervals; 0: none");
  line.Group("", request.options);
  line.Group("air", request.air);
  if (!line.Parse()) return cli::ExitCode::kDone;

  request.cell = LoadCell(cell_name);
  request.cell.series = series.value_or(request.cell.series);
  request.cell.parallel = parallel.value_or(request.cell.parallel);
  request.initial_soc = start.Soc(request.cell);
  request.initial_voltage_V = start.initial_voltage_V;
  request.payload_kg =
      ReadUncertain("payload-g", payload_g, Range{0.0, kGramsPerKilogram * kPayloads_kg.hi});
  request.payload_kg.value /= kGramsPerKilogram;
  request.payload_kg.standard_error /= kGramsPerKilogram;
  if (!ambient_degC.empty()) {
    request.ambient_degC = ReadUncertain("ambient-degC", ambient_degC, kTemperatures_degC);
    request.cell = KnowingTemperature(line, request.cell, cell_name);
  }
  request.health = ReadUncertain("health", health, kCapacityShares);
  request.resistance_factor =
      ReadUncertain("resistance-factor", resistance_factor, kResistanceFactors);
  request.power_factor = ReadUncertain("power-factor", power_factor, kPowerFactors);
  request.reserve = ReadUncertain("reserve", reserve, kReserves);
  request.seed = line.seed();
  SetMission(line, mission, request);
  SetAirspeed(airspeed, request);
  if (request.power) {
    request.power->repeats = !once;
    if (!vehicle_name.empty() || line.Given("payload-g") || !airspeed.empty()) {
      throw OptionError(
          "options --vehicle, --payload-g and --airspeed-m-per-s: a mission of powers does not ask "
          "what takes them; leave them out");
    }
  } else {
    if (once) throw OptionError("option --once is for missions of a file; level flight has no end");
    if (vehicle_name.empty())
      throw OptionError("option --vehicle: expected a vehicle that is to fly, found none");
    request.vehicle = LoadVehicle(vehicle_name);
  }

  const EnduranceAnswer answer = FindEndurance(
      request, [&](double fraction) { line.progress().Update(fraction, "flying the ensemble"); });
  line.summary() = EnduranceToJson(request, answer);
  line.summary()["mission"] = mission;
  PrintAnswer(line, request, answer);
  if (!request.uncertain()) {
    line.Message(
        "no intervals: {} does not say how uncertain it is, and no value was given as X+-SE",
        cell_name);
  } else if (!answer.flights.empty() && answer.flights.size() < kLeastForQuantiles) {
    line.Message(
        "of {} flights the interval is that from the lowest to the highest: quantiles "
        "take {}",
        answer.flights.size(),
        kLeastForQuantiles);
  }
  if (request.cell.open_circuit_voltage_assumed)
    line.Message("the open-circuit voltage of {} is a typical one, not measured", cell_name);
  return answer.estimate.ended_by == MissionEnd::kTimeLimit ? cli::ExitCode::kIncomplete
                                                            : cli::ExitCode::kDone;
}

}  // namespace lipoid
