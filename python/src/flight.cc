#include "python/src/flight.h"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/analysis/placed_gains.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/stop.h"
#include "model/flight/flight_log.h"
#include "model/flight/flight_report.h"
#include "model/vehicle/vehicle_file.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

struct FlyKeywords {
  FlightSetup setup;
  ManeuverRequest request;
  std::string vehicle = "mambo-coupled";
  std::string gains;
  std::optional<double> duration_s;
  double log_step_s = kControlStep_s;

  void Declare(Keywords& keywords, const Maneuver* maneuver) {
    if (const auto file =
            keywords.Take("vehicle", "Path", "a vehicle file, or the name of a shipped vehicle"))
      vehicle = PathOf(*file);
    if (const auto file = keywords.Take(
            "gains",
            "Path",
            "\"unaware\", \"aware\", \"placed\" by the lag of the vehicle's motors, or a gains file"))
      gains = PathOf(*file);
    keywords.Flag("compensate",
                  setup.controller.compensate,
                  "whether commands use the measured voltage (5.52)");
    keywords.Flag("estimate",
                  setup.estimate,
                  "whether the controller sees noisy sensors through the estimator");
    keywords.Option(
        "xi", setup.xi, Range{0.01, 2.0}, "of an ideal source: voltage over the nominal");
    keywords.Option(
        "initial-soc", setup.initial_soc, kInitialSocs, "state of charge of the cell at the start");
    keywords.Option("duration",
                    duration_s,
                    Range{kControlStep_s, 1e6},
                    "duration of the flight, s; by default that of the maneuver");
    keywords.Option("land-below-V",
                    setup.land_below_V,
                    Range{0.0, 1e4},
                    "land when the battery has been below this voltage for a second, V; 0: never");
    keywords.Option(
        "log-step-s", log_step_s, Range{kControlStep_s, 1e4}, "seconds between rows of the data");
    if (const auto file =
            keywords.Take("waypoints", "Path", "file of places for the maneuver waypoints"))
      request.waypoints_file = PathOf(*file);
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
  made.vehicle = cell.is_none() ? "mambo-thesis" : "mambo-coupled";
  Keywords keywords(given);
  made.Declare(keywords, &maneuver);
  keywords.Finish();
  FlightSetup& setup = made.setup;
  if (!cell.is_none()) setup.cell = nb::cast<const PythonCell&>(cell).cell;
  setup.vehicle = LoadVehicle(made.vehicle);
  CheckFlight(setup, maneuver, made.request, made.duration_s.has_value());
  setup.gains = GainsFor(made.gains, setup.vehicle, "aware", setup.controller.law);
  setup.seed = seed;
  FlightPlan plan = maneuver.plan(made.request);
  if (made.duration_s) plan.duration_s = *made.duration_s;

  std::vector<std::string> names;
  FlightSample::OfRotors(setup.vehicle.rotor_count()).Visit([&](const char* column, double) {
    names.emplace_back(column);
  });
  std::vector<std::vector<double>> columns(names.size());
  const auto every = std::max(1LL, std::llround(made.log_step_s / kControlStep_s));
  Json summary;
  Work(
      [&](const Tell& tell) {
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
