#include "python/src/flight.h"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/pack_request.h"
#include "model/analysis/before_flight.h"
#include "model/analysis/placed_gains.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/stop.h"
#include "model/flight/flight_log.h"
#include "model/flight/flight_report.h"
#include "model/flight/fly_request.h"
#include "model/vehicle/vehicle_file.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

struct FlyKeywords {
  FlyRequest asked;
  ManeuverRequest request;
  PackRequest pack;
  StartRequest start;

  void Declare(Keywords& keywords, const Maneuver* maneuver) {
    FlightSetup& setup = asked.setup;
    keywords.Each(asked);
    keywords.Each(pack);
    keywords.Each(start);
    if (const auto values = keywords.Take("maneuver_options",
                                          "Mapping[str, Any]",
                                          "options of the maneuver: {\"side_m\": 2.0}")) {
      if (!nb::isinstance<nb::dict>(*values))
        throw OptionError("option maneuver_options: expected a dictionary");
      for (const auto& [key, value] : nb::cast<nb::dict>(*values)) {
        const auto name = nb::cast<std::string>(nb::str(key));
        request.values[name] = TextOf(name, value);
      }
      if (maneuver != nullptr && maneuver->values != nullptr) (void)maneuver->values(request);
    }
    keywords.Group("wind", setup.wind);
    keywords.Group("controller", setup.controller);
    keywords.Group("simulation", setup.simulation);
    keywords.Group("sensors", setup.sensors);
    keywords.Group("estimator", setup.estimator);
  }
};

nb::tuple FlyManeuver(const std::string& name,
                      const nb::object& cell,
                      const nb::dict& given,
                      std::uint64_t seed,
                      int threads,
                      const nb::object& progress) {
  const Maneuver& maneuver = FindManeuver(name);
  FlyKeywords made;
  Keywords keywords(given);
  made.Declare(keywords, &maneuver);
  keywords.Finish();
  const FlyRequest& asked = made.asked;
  FlightSetup& setup = made.asked.setup;
  if (!cell.is_none()) {
    setup.cell = nb::cast<const PythonCell&>(cell).cell;
    made.pack.ApplyTo(*setup.cell);
    setup.initial_soc = made.start.Soc(*setup.cell, {.ambient_degC = setup.ambient_degC});
  } else if (made.pack.given() || made.start.given() || asked.ChangesCell()) {
    throw OptionError(
        "options series, parallel, initial_soc, initial_voltage_V, capacity_Ah, health and "
        "resistance_factor are for a cell; an ideal source has xi");
  }
  if (setup.cell && asked.xi)
    throw OptionError("option xi is for an ideal source: give cell=None, or leave xi out");
  if (!setup.cell && setup.ambient_degC)
    throw OptionError("option ambient_degC is for a cell; an ideal source has none");
  std::string about_size;
  if (setup.cell) {
    const Cell of_file = *setup.cell;
    const double size = asked.SizeFactor(of_file);
    setup.cell = asked.Aboard(setup.ambient_degC && !of_file.temperature
                                  ? WithTypicalTemperature(of_file, size)
                                  : of_file);
    about_size = DoubtAboutSize(of_file, size);
  }
  setup.xi = asked.xi.value_or(1.0);
  made.request.waypoints_file = asked.waypoints.path;
  setup.vehicle = asked.Loaded(LoadVehicle(asked.VehicleName()));
  CheckFlight(setup, maneuver, made.request, asked.duration_s.has_value());
  setup.gains = GainsFor(asked.gains.path, setup.vehicle, "aware", setup.controller.law);
  setup.seed = seed;
  made.request.duration_s = asked.duration_s;
  FlightPlan plan = maneuver.plan(made.request);
  if (asked.duration_s) plan.duration_s = *asked.duration_s;

  std::vector<std::string> names;
  FlightSample::OfRotors(setup.vehicle.rotor_count(), setup.Warms())
      .Visit([&](const char* column, double) { names.emplace_back(column); });
  std::vector<std::vector<double>> columns(names.size());
  const auto every = std::max(1LL, std::llround(asked.LogStep_s(plan.duration_s) / kControlStep_s));
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto hovers = CheckFlightLoops(setup);
        const FlightResult flight = Fly(
            setup,
            plan,
            [&, k = 0LL](const FlightSample& sample) mutable {
              StopIfAsked();
              if (k++ % every != 0) return;
              std::size_t column = 0;
              sample.Visit([&](const char*, double value) { columns[column++].push_back(value); });
            },
            [&](double share) { tell("flying", share); });
        summary = FlightToJson(flight);
        summary.update(FlownToJson(setup, maneuver, made.request));
        summary["doubts"] = FlightDoubts(setup, plan, flight);
        summary["loops"] = StabilityToJson(hovers);
        auto messages = WarningsBeforeFlight(setup, maneuver, plan, hovers);
        if (!about_size.empty()) messages.insert(messages.begin(), about_size);
        summary["messages"] = messages;
      },
      progress,
      threads);
  nb::dict data;
  for (std::size_t k = 0; k < names.size(); ++k)
    data[names[k].c_str()] = ToArray(std::move(columns[k]));
  return nb::make_tuple(ToPython(summary), data);
}

}  // namespace

void AddFlights(nb::module_& module) {
  module.def("fly",
             &FlyManeuver,
             nb::arg("maneuver"),
             nb::arg("cell").none(),
             nb::arg("options"),
             nb::arg("seed"),
             nb::arg("threads"),
             nb::arg("progress").none());
  module.def("describe_fly", [] {
    FlyKeywords made;
    Keywords keywords;
    made.Declare(keywords, nullptr);
    return keywords.Described();
  });
  module.def("maneuver_names", [] {
    nb::list names;
    for (const Maneuver& maneuver : Maneuvers()) names.append(std::string(maneuver.name));
    return names;
  });
  module.def("vehicle_names", [] {
    nb::list names;
    for (const std::string& name : ShippedVehicleNames()) names.append(name);
    return names;
  });
}

}  // namespace lipoid::python
