#include "python/src/planning.h"

#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "identify/synthesis/synthesize.h"
#include "identify/trust/plan_grid.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/ranges.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

constexpr double kYear_s = 3.2e7;

void Values(Keywords& keywords,
            std::string_view name,
            std::vector<double>& values,
            const Range& valid,
            std::string_view help) {
  const auto given = keywords.Take(name, "float | Sequence[float]", help);
  if (!given) return;
  const std::string shown = PythonName(name);
  values.clear();
  const auto add = [&](nb::handle value) {
    values.push_back(options_internal::ParseDouble(shown, TextOf(shown, value), valid));
  };
  if (nb::hasattr(*given, "__len__") && !nb::isinstance<nb::str>(*given)) {
    for (const nb::handle value : *given) add(value);
    if (values.empty()) throw OptionError("option " + shown + ": expected a number at least");
  } else {
    add(*given);
  }
}

void DeclarePlan(Keywords& keywords, PlanGrid& grid) {
  Values(keywords, "pulse-s", grid.pulse_s, Range{1e-6, kYear_s}, "length of a pulse, s");
  Values(keywords, "rest-s", grid.rest_s, Range{0.0, kYear_s}, "rest after each pulse, s");
  Values(keywords,
         "rate-C",
         grid.rate_C,
         Range{1e-6, 1e4},
         "C-rate of the pulses; by default one that suits the cell");
  Values(keywords, "sampling-s", grid.sampling_s, Range{1e-6, 1e6}, "time between rows, s");
  Values(
      keywords,
      "ambient-degC",
      grid.ambient_degC,
      kTemperatures_degC,
      "temperatures of the surroundings in degC: the whole protocol runs at the first, its pulses at "
      "the others too; all belong to one campaign; by default the reference temperature of a cell "
      "that knows one. A cell that knows none gets typical energies");
  Values(keywords,
         "second-degC",
         grid.second_degC,
         kTemperatures_degC,
         "second temperatures in degC: what the same pulses there, or one pulse, would add to the "
         "campaign; by default 25 degC below the coldest of ambient_degC");
  keywords.Option(
      "voltage-noise-V",
      grid.noise.white_V,
      Range{0.0, 1e3},
      "standard deviation of the voltage's noise that is independent from row to row, V");
  keywords.Option("coloured-noise-V",
                  grid.noise.coloured_V,
                  Range{0.0, 1e3},
                  "standard deviation of slow errors of the voltage, V");
  keywords.Option("correlation-s",
                  grid.noise.correlation_s,
                  Range{1e-6, kYear_s},
                  "time over which these slow errors are correlated, s");
  keywords.Option(
      "temperature-noise-degC",
      grid.noise.temperature_K,
      Range{0.0, 100.0},
      "standard deviation of the thermometer's noise that is independent from row to row, degC");
}

nb::object Plan(const PythonCell& cell, const nb::dict& given, const nb::object& progress) {
  PlanGrid grid;
  Keywords keywords(given);
  DeclarePlan(keywords, grid);
  keywords.Finish();
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto result =
            PlanVariations(cell.cell, grid, [&](double share) { tell("planning", share); });
        summary = PlanGridToJson(cell.cell, grid, result);
      },
      progress);
  return ToPython(summary);
}

void SynthesizeLogs(const PythonCell& truth,
                    nb::handle folder,
                    const nb::dict& given,
                    std::uint64_t seed,
                    const nb::object& progress) {
  SynthesisOptions options;
  Keywords keywords(given);
  keywords.Each(options);
  keywords.Finish();
  Cell cell = truth.cell;
  cell.uncertainty.reset();  // it is the truth now
  if (!options.ambient_degC.empty() && !cell.temperature) cell = WithTypicalTemperature(cell);
  RunRecord run;
  run.command = "lipoid.synthesize";
  run.options = OptionsToJson<Json>(options);
  run.seed = seed;
  const std::string path = PathOf(folder);
  Work(
      [&](const Tell& tell) {
        Synthesize(cell, FindProtocol("thesis"), options, run, path, [&](double share) {
          tell("synthesizing", share);
        });
      },
      progress);
}

PythonCell Changed(const PythonCell& cell, const std::map<std::string, double>& parameters) {
  PythonCell changed = cell;
  for (const auto& [name, value] : parameters) SetCellParameter(changed.cell, name, value);
  if (const auto missing = MissingCellParameter(changed.cell)) throw OptionError(*missing);
  return changed;
}

}  // namespace

void AddPlanning(nb::module_& module) {
  module.def("plan", &Plan, nb::arg("cell"), nb::arg("options"), nb::arg("progress").none());
  module.def("synthesize",
             &SynthesizeLogs,
             nb::arg("cell"),
             nb::arg("folder"),
             nb::arg("options"),
             nb::arg("seed"),
             nb::arg("progress").none());
  module.def("with_parameters", &Changed, nb::arg("cell"), nb::arg("parameters"));
  module.def("describe_plan", [] {
    Keywords keywords;
    PlanGrid grid;
    DeclarePlan(keywords, grid);
    return keywords.Described();
  });
  module.def("describe_synthesize", [] {
    Keywords keywords;
    SynthesisOptions options;
    keywords.Each(options);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
