#include "python/src/endurance.h"

#include <nanobind/stl/string.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "identify/pack_request.h"
#include "model/analysis/placed_gains.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/options.h"
#include "model/flight/endurance_report.h"
#include "model/flight/endurance_request.h"
#include "model/flight/endurance_route.h"
#include "model/vehicle/vehicle_file.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

enum class Mission { kHover, kCruise };

constexpr std::array<std::pair<Mission, std::string_view>, 2> OptionNames(Mission) {
  return {{{Mission::kHover, "hover"}, {Mission::kCruise, "cruise"}}};
}

// A number, or a pair of it and its standard error, in the unit of the option.
std::optional<Uncertain> Value(Keywords& keywords, const EnduranceVariable& variable) {
  const auto given =
      keywords.Take(variable.name, "float | str | tuple[float, float]", variable.help);
  if (!given) return std::nullopt;
  const std::string shown = PythonName(variable.name);
  const auto number = [&](nb::handle one, const Range& range) {
    return options_internal::ParseShare(shown, TextOf(shown, one), range);
  };
  if (!nb::isinstance<nb::tuple>(*given)) return Uncertain{number(*given, variable.valid), 0.0};
  const auto pair = nb::cast<nb::tuple>(*given);
  if (pair.size() != 2)
    throw OptionError("option " + shown + ": expected a number, or it and its standard error");
  return Uncertain{number(pair[0], variable.valid), number(pair[1], Range{.lo = 0.0})};
}

struct EnduranceKeywords {
  EnduranceRequest request;
  EnduranceChoices choices;
  PackRequest pack;
  StartRequest start;
  std::optional<std::string> waypoints;

  void Declare(Keywords& keywords) {
    keywords.Each(choices);
    keywords.Each(pack);
    Mission mission = Mission::kHover;
    keywords.Option("mission", mission, Names{}, "level flight at a place, or at a speed");
    request.cruise = mission == Mission::kCruise;
    if (const auto power = keywords.Take("power",
                                         "tuple[Any, Any]",
                                         "instead of a vehicle: times in s, and the power in W "
                                         "that the battery gives since the time before")) {
      TakePower(*power);
    }
    for (const EnduranceVariable& variable : EnduranceVariables()) {
      if (const auto value = Value(keywords, variable)) {
        variable.of(request) = {variable.unit * value->value,
                                variable.unit * value->standard_error};
      }
    }
    keywords.Option("cruise-speed",
                    request.cruise_speed,
                    Names{},
                    "of a cruise whose airspeed is not given: the one of best range or endurance");
    if (const auto file =
            keywords.Take("waypoints", "Path", "a file of waypoints, which is flown instead"))
      waypoints = PathOf(*file);
    keywords.Each(start);
    keywords.Group("flight", request.options);
    keywords.Group("air", request.air);
  }

  void TakePower(const nb::object& pair) {
    if (!nb::isinstance<nb::tuple>(pair) || nb::len(pair) != 2)
      throw OptionError("option power: expected a tuple of times and powers");
    // As of a log: dates and durations are seconds, and what is no number is an error.
    const auto column = nb::module_::import_("lipoid._log").attr("column");
    const auto time_s = nb::cast<Input>(column(pair[0], "time_s"));
    const auto power_W = nb::cast<Input>(column(pair[1], "power_W"));
    if (time_s.shape(0) != power_W.shape(0) || time_s.shape(0) < 2)
      throw OptionError("option power: expected as many powers as times, at least two");
    PowerMission& mission = request.power.emplace();
    for (std::size_t k = 1; k < time_s.shape(0); ++k) {
      const double duration_s = time_s.data()[k] - time_s.data()[k - 1];
      if (!(duration_s > 0.0) || !std::isfinite(duration_s) || !std::isfinite(power_W.data()[k]))
        throw OptionError("option power: expected rising times that are finite, and finite powers");
      mission.legs.push_back({.duration_s = duration_s, .power_W = power_W.data()[k]});
    }
  }
};

// OptionError for what the mission would leave out, in the words of `lipoid endurance`.
void RefuseWhatIsNotFlown(const Keywords& given, const EnduranceKeywords& made) {
  const EnduranceRequest& request = made.request;
  const bool flies = !made.choices.vehicle.path.empty();
  if (request.power.has_value() == flies)
    throw OptionError(fmt::format("expected option vehicle or option power, found {}",
                                  flies ? "both" : "neither"));
  if (request.power && (given.Has("payload_g") || given.Has("airspeed_m_per_s"))) {
    throw OptionError(
        "options payload_g and airspeed_m_per_s: a mission of powers does not ask what takes them; "
        "leave them out");
  }
  const bool of_a_file = request.power || made.waypoints;
  if (request.power && made.waypoints)
    throw OptionError("options power and waypoints: give one of them");
  if (of_a_file && request.cruise)
    throw OptionError("option mission: cruise is level flight; leave waypoints and power out");
  if (of_a_file && request.air != LevelFlightOptions{}) {
    throw OptionError(
        "option air: it is for hover and cruise; a route is flown by lipoid.fly, in still air of "
        "1.225 kg/m³, and powers are those that are given");
  }
  if (given.Has("gains") && !made.waypoints) {
    throw OptionError(
        "option gains: it is for waypoints; hover and cruise are equilibria, which no controller "
        "changes, and powers are those that are given");
  }
  if (given.Has("cruise_speed") && !request.cruise)
    throw OptionError("option cruise_speed: it is for the mission cruise");
  if (given.Has("cruise_speed") && request.airspeed_m_per_s)
    throw OptionError("options cruise_speed and airspeed_m_per_s: give one of them");
  if (made.waypoints && (!request.payload_kg.known() || request.airspeed_m_per_s))
    throw OptionError(
        "option waypoints: expected a vehicle, a payload that is known, and no airspeed_m_per_s");
}

// As --mission names it.
std::string MissionOf(const EnduranceKeywords& made) {
  if (made.waypoints) return "waypoints=" + *made.waypoints;
  if (made.request.power) return "power";
  return made.request.cruise ? "cruise" : "hover";
}

nb::object Endurance(const PythonCell& cell,
                     const nb::dict& given,
                     std::uint64_t seed,
                     int threads,
                     const nb::object& progress) {
  EnduranceKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  EnduranceRequest& request = made.request;
  request.cell = cell.cell;
  made.pack.ApplyTo(request.cell);
  const EnduranceChoices& choices = made.choices;
  choices.ApplyTo(request);
  Surroundings among;
  if (request.ambient_degC) among.ambient_degC = request.ambient_degC->value;
  request.initial_soc = made.start.Soc(request.cell, among);
  request.initial_voltage_V = made.start.initial_voltage_V;
  if (request.ambient_degC && !request.cell.temperature)
    request.cell = WithTypicalTemperature(request.cell, request.size_factor);
  RefuseWhatIsNotFlown(keywords, made);
  const bool flies = !request.power;
  const std::string mission = MissionOf(made);
  if (flies) request.vehicle = LoadVehicle(choices.vehicle.path);
  request.seed = seed;
  Json summary;
  Work(
      [&](const Tell& tell) {
        if (made.waypoints)
          request.power = FlyRoute(
              request, GainsFor(choices.gains.path, request.vehicle, "aware"), *made.waypoints);
        choices.SetRepeats(request);
        const EnduranceAnswer answer =
            FindEndurance(request, [&](double share) { tell("flying the ensemble", share); });
        summary = EnduranceToJson(request, answer);
        summary["mission"] = mission;
        if (flies) summary["vehicle"] = request.vehicle.name;
      },
      progress,
      threads);
  return ToPython(summary);
}

}  // namespace

void AddEndurance(nb::module_& module) {
  module.def("endurance",
             &Endurance,
             nb::arg("cell"),
             nb::arg("options"),
             nb::arg("seed"),
             nb::arg("threads"),
             nb::arg("progress").none());
  module.def("describe_endurance", [] {
    EnduranceKeywords made;
    Keywords keywords;
    made.Declare(keywords);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
