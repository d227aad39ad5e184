// lipoid endurance: how long a vehicle flies on a pack, and how far that is known.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/export/mission.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "model/analysis/placed_gains.h"
#include "model/battery/curve_range.h"
#include "model/battery/temperature_range.h"
#include "model/core/errors.h"
#include "model/flight/endurance_report.h"
#include "model/flight/endurance_request.h"
#include "model/flight/endurance_route.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/number_range.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/ambient_option.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/uncertain_option.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

void PrintAnswer(cli::CommandLine& line,
                 const std::vector<std::string>& sentences,
                 const EnduranceAnswer& answer) {
  // That the pack cannot fly comes before its numbers.
  auto sentence = sentences.begin();
  if (!IsFlight(answer.estimate)) line.Print("{}", cli::Wrapped(*sentence++ + "\n\n"));
  const bool intervals = !answer.flights.empty();
  std::vector<cli::TextTable::Column> columns{{"until landing", Align::kLeft}, {"estimate"}};
  if (intervals) columns.insert(columns.end(), {{"95 % from"}, {"to"}});
  cli::TextTable table(columns, "Endurance.");
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
  line.Print("{}", table.Text());
  for (; sentence != sentences.end(); ++sentence) line.Print("{}\n", *sentence);
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

// Reads hover, cruise, waypoints=FILE or power=FILE. Vehicle and quantities are set already.
void SetMission(cli::CommandLine& line,
                const std::string& text,
                const std::string& gains,
                const ReadingRequest& reading,
                EnduranceRequest& request) {
  constexpr std::string_view kPower = "power=";
  constexpr std::string_view kRoute = "waypoints=";
  if (request.cruise || text == "hover") return;
  if (text == kRoute || text == kPower)
    throw OptionError(fmt::format("option --mission: expected {}FILE, found no file", text));
  if (text.starts_with(kRoute)) {
    const std::string file = text.substr(kRoute.size());
    line.AddInputs({file});
    if (!request.payload_kg.known() || request.airspeed_m_per_s) {
      throw OptionError(
          "options --payload-g X+-SE and --airspeed-m-per-s: a route is flown once, with a payload "
          "that is known and at the speeds of its controller; leave the standard error and the speed "
          "out");
    }
    request.power = FlyRoute(request, GainsFor(gains, request.vehicle, "aware"), file);
    return;
  }
  if (text.starts_with(kPower)) {
    const std::string file = text.substr(kPower.size());
    line.AddInputs({file});
    const ReadPower read = ReadPowerFile(file, reading.Resolve());
    for (const std::string& warning : read.warnings) line.Message("{}", warning);
    request.power = MissionOf(read.profile);
    return;
  }
  throw OptionError(
      fmt::format("option --mission: expected hover, cruise, waypoints=FILE or power=FILE, found "
                  "'{}'",
                  text));
}

// Reads a quantity; of the airspeed also the name of one.
void SetQuantity(const EnduranceVariable& variable,
                 const std::string& text,
                 EnduranceRequest& request) {
  if (text.empty()) return;
  const bool airspeed = variable.name == "airspeed-m-per-s";
  for (const auto& [speed, name] : OptionNames(CruiseSpeed{})) {
    if (!airspeed || text != name) continue;
    if (!request.cruise)
      throw OptionError(fmt::format("option --airspeed-m-per-s: {} is for --mission cruise", name));
    request.cruise_speed = speed;
    return;
  }
  const Uncertain given = ReadUncertain(variable, text);
  variable.of(request) = {variable.unit * given.value, variable.unit * given.standard_error};
}

// NAME=FIRST:STEP:LAST
struct Over {
  const EnduranceVariable* variable = nullptr;
  std::vector<double> values;  // in the unit of the option
};

Over ReadOver(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    throw OptionError(fmt::format(
        "option --over: expected NAME=FIRST:STEP:LAST, such as payload-g=0:100:500, found '{}'",
        text));
  }
  Over over;
  over.variable = &FindEnduranceVariable(text.substr(0, equals));
  over.values =
      ReadRange("over " + text.substr(0, equals), text.substr(equals + 1), over.variable->valid);
  constexpr std::size_t kMost = 1000;
  if (over.values.size() > kMost)
    throw OptionError(fmt::format(
        "option --over: expected at most {} rows, found {}", kMost, over.values.size()));
  return over;
}

// The table of --over; its rows for the summary.
Json PrintOver(cli::CommandLine& line, const EnduranceRequest& request, const Over& over) {
  const bool intervals = request.uncertain();
  std::vector<cli::TextTable::Column> columns{{std::string(over.variable->name)}, {"minutes"}};
  if (intervals) columns.insert(columns.end(), {{"95 % from"}, {"to"}});
  columns.insert(columns.end(), {{"landing / V"}, {"rested / V"}, {"ended by", Align::kLeft}});
  cli::TextTable table(columns, fmt::format("Endurance over {}.", over.variable->name));
  Json rows = Json::array();
  for (std::size_t k = 0; k < over.values.size(); ++k) {
    line.progress().Update(static_cast<double>(k) / static_cast<double>(over.values.size()),
                           "flying the table");
    EnduranceRequest row = request;
    over.variable->of(row).value = over.variable->unit * over.values[k];
    const EnduranceAnswer answer = FindEndurance(row);
    const auto interval = IntervalOf(answer, EnduranceNumbers().front());
    std::vector<std::string> cells{fmt::format("{:g}", over.values[k]),
                                   Significant(answer.estimate.time_s / 60.0)};
    if (intervals) {
      cells.push_back(interval ? Significant(interval->first) : "");
      cells.push_back(interval ? Significant(interval->second) : "");
    }
    cells.insert(cells.end(),
                 {Significant(answer.estimate.landing_voltage_V),
                  Significant(answer.estimate.landing_rest_voltage_V),
                  options_internal::ToText(answer.estimate.ended_by)});
    table.Row(std::move(cells));
    Json numbers = EnduranceNumbersToJson(answer);
    numbers["value"] = over.values[k];
    rows.push_back(std::move(numbers));
  }
  line.Print("\n{}", table.Text());
  return {{"name", over.variable->name}, {"rows", std::move(rows)}};
}

// What a row of --over goes beyond and the estimate does not.
void TellWhatRowsExtrapolate(cli::CommandLine& line,
                             const EnduranceRequest& request,
                             const EnduranceAnswer& answer) {
  if (!KnowsCurve(request.cell, answer.estimate.soc, request.initial_soc)) return;
  double lowest_soc = 1.0;
  for (const Json& row : line.summary()["over"]["rows"])
    lowest_soc = std::min(lowest_soc, row["remaining_soc"].get<double>());
  if (const auto doubt = DoubtAboutCurve(request.cell, lowest_soc, request.initial_soc);
      !doubt.empty())
    line.Message("{}", doubt);
}

}  // namespace

cli::ExitCode EnduranceCommand(cli::CommandLine& line) {
  EnduranceRequest request;
  StartRequest start;
  EnduranceChoices choices;
  std::string cell_name;
  std::string mission = "hover";
  std::string over_text;
  std::vector<std::string> quantities(EnduranceVariables().size());
  PackRequest pack;
  ReadingRequest reading;  // of a log of powers

  line.Describe(
      "Says how long a vehicle flies on a pack, what it uses and at which voltage it has to land, "
      "each with the interval that holds 95 % of what the uncertainties allow. The vehicle is in "
      "equilibrium all the time; `lipoid fly endurance` hovers with its flight controller instead "
      "and logs each step. A number X+-SE has a standard error, which widens the intervals.",
      "lipoid endurance --vehicle mambo-physical --cell gifi-600mAh-1");
  line.Example(
      "lipoid endurance --vehicle mambo-physical --cell cell.json --ambient-degC 5 "
      "--health 0.8+-0.05 --power-factor 1+-0.05");
  line.Example(
      "lipoid endurance --vehicle mambo-physical --cell gifi-600mAh-1 --over payload-g=0:2:10");
  line.Example("lipoid endurance --cell cell.json --series 4 --mission power=flight.csv");
  line.Each(choices);
  line.RequiredInput("cell", cell_name, "CELL", "a cell file, or the name of a shipped cell");
  line.Each(pack);
  line.Text("mission",
            mission,
            "M",
            "hover; cruise; waypoints=FILE, a route as of `lipoid fly waypoints`; or power=FILE, a "
            "CSV of time_s,power_W or any log with voltage and current");
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const EnduranceVariable& variable = EnduranceVariables()[k];
    const bool airspeed = variable.name == "airspeed-m-per-s";
    line.Text(
        variable.name,
        quantities[k],
        kUncertainWord,
        std::string(variable.help) +
            (airspeed ? "; of cruise also best-range or best-endurance (default best-range)" : ""));
  }
  line.Text("over",
            over_text,
            "NAME=FIRST:STEP:LAST",
            "a table over one of the quantities above, such as payload-g=0:100:500");
  line.Each(start);
  line.Each(reading);
  line.Group("", request.options);
  line.Group("air", request.air);
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  request.cell = LoadCell(line, cell_name);
  pack.ApplyTo(request.cell);
  const std::string& vehicle_name = choices.vehicle.path;
  choices.ApplyTo(request);
  request.cruise = mission == "cruise";
  for (std::size_t k = 0; k < quantities.size(); ++k)
    SetQuantity(EnduranceVariables()[k], quantities[k], request);
  std::optional<Over> over;
  if (!over_text.empty()) over = ReadOver(over_text);
  if (request.ambient_degC || (over && over->variable->name == "ambient-degC"))
    request.cell = KnowingTemperature(line, request.cell, cell_name, request.size_factor);
  Surroundings among;
  if (request.ambient_degC) among.ambient_degC = request.ambient_degC->value;
  request.initial_soc = start.Soc(request.cell, among);
  request.initial_voltage_V = start.initial_voltage_V;
  request.seed = line.seed();
  if (!vehicle_name.empty()) request.vehicle = LoadVehicle(vehicle_name);
  const bool flies_on_air = mission == "hover" || request.cruise;
  if (!flies_on_air && request.air != LevelFlightOptions{}) {
    throw OptionError(
        "options --set air.*: they are for --mission hover and cruise; a route is flown by `lipoid fly`, "
        "in still air of 1.225 kg/m³, and powers are those of the file");
  }
  LevelFlightOptions of_density;
  of_density.air_density_kg_per_m3 = request.air.air_density_kg_per_m3;
  if (mission == "hover" && !request.airspeed_m_per_s && request.air != of_density) {
    line.Message(
        "options --set air.*, but for air.air_density_kg_per_m3, change nothing in a hover without "
        "--airspeed-m-per-s: its power is that of the vehicle file");
  }
  if (line.Given("gains") && !mission.starts_with("waypoints=")) {
    throw OptionError(
        "option --gains: it is for --mission waypoints=FILE; hover and cruise are equilibria, which no "
        "controller changes");
  }
  constexpr std::array<std::string_view, 6> kOfReading{
      "columns", "units", "battery", "most-rows", "current-sign", "hold"};
  for (const std::string_view name : kOfReading) {
    if (line.Given(name) && !mission.starts_with("power=")) {
      throw OptionError(fmt::format(
          "option --{}: it says how a log is read, and only --mission power=FILE reads one", name));
    }
  }
  if (mission.starts_with("power=")) {
    for (const char* const option : {"vehicle", "payload-g", "airspeed-m-per-s"}) {
      if (!line.Given(option)) continue;
      throw OptionError(fmt::format(
          "option --{}: a mission of powers does not ask what takes them; leave it out", option));
    }
  } else if (vehicle_name.empty()) {
    throw OptionError("option --vehicle: expected a vehicle that is to fly, found none");
  }
  SetMission(line, mission, choices.gains.path, reading, request);
  choices.SetRepeats(request);
  if (request.power && over &&
      (over->variable->name == "payload-g" || over->variable->name == "airspeed-m-per-s")) {
    throw OptionError(fmt::format(
        "option --over: a table flies the mission of a file once, so that {} cannot stand in it; give "
        "each a run of its own{}",
        over->variable->name,
        mission.starts_with("power=") ? "" : fmt::format(", with --{}", over->variable->name)));
  }

  const EnduranceAnswer answer = FindEndurance(
      request, [&](double fraction) { line.progress().Update(fraction, "flying the ensemble"); });
  line.summary() = EnduranceToJson(request, answer);
  line.summary()["mission"] = mission;
  if (!vehicle_name.empty()) line.summary()["vehicle"] = request.vehicle.name;
  PrintAnswer(line, EnduranceSentences(request, answer), answer);
  line.summary()["over"] = over ? PrintOver(line, request, *over) : Json(nullptr);
  if (over && over->variable->name == "ambient-degC") {
    const auto [coldest, warmest] = std::minmax_element(over->values.begin(), over->values.end());
    if (const auto doubt = DoubtAboutTemperature(request.cell, *coldest, *warmest); !doubt.empty())
      line.Message("{}", doubt);
  }
  for (const std::string& doubt : EnduranceDoubts(request, answer)) line.Message("{}", doubt);
  if (over) TellWhatRowsExtrapolate(line, request, answer);
  line.summary()["messages"] = line.messages();
  const MissionEnd end = answer.estimate.ended_by;
  const bool answered =
      IsFlight(answer.estimate) && end != MissionEnd::kTimeLimit && end != MissionEnd::kFull;
  return answered ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
