#include "python/src/planning.h"

#include <nanobind/stl/string.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "identify/pack_request.h"
#include "identify/synthesis/synthesize.h"
#include "identify/trust/plan_grid.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/ranges.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/one_file.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

nb::object Plan(const PythonCell& cell, const nb::dict& given, const nb::object& progress) {
  PlanGrid grid;
  Keywords keywords(given);
  keywords.Each(grid);
  keywords.Finish();
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto result =
            PlanVariations(cell.cell, grid, [&](double share) { tell("planning", share); });
        summary = PlanGridToJson(cell.cell, result);
      },
      progress);
  return ToPython(summary);
}

void SynthesizeLogs(const PythonCell& truth,
                    nb::handle folder,
                    const nb::dict& given,
                    std::uint64_t seed,
                    const nb::object& progress,
                    const nb::list& inputs) {
  SynthesisOptions options;
  PackRequest pack;
  Keywords keywords(given);
  keywords.Each(pack);
  keywords.Each(options);
  keywords.Finish();
  Cell cell = truth.cell;
  pack.ApplyTo(cell);
  cell.uncertainty.reset();  // it is the truth now
  if (!options.ambient_degC.empty() && !cell.temperature) cell = WithTypicalTemperature(cell);
  RunRecord run;
  run.command = "lipoid.synthesize";
  run.options = OptionsToJson<Json>(options);
  run.seed = seed;
  const std::string path = PathOf(folder);
  const Protocol& protocol = FindProtocol("thesis");
  std::vector<NamedOutput> outputs;
  for (const std::string& name : SynthesizedNames(cell, protocol, options))
    outputs.push_back({"folder", (std::filesystem::path(path) / name).string()});
  RefuseInputs(outputs, PathsOf(inputs));
  Work(
      [&](const Tell& tell) {
        Synthesize(
            cell, protocol, options, run, path, [&](double share) { tell("synthesizing", share); });
      },
      progress);
}

// What of a cell is changed before logs are made of it.
struct ChangeRequest {
  std::map<std::string, double> parameters = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("parameters", self.parameters, Word{"NAME=VALUE"}, "parameters of the truth, by name");
  }
};

PythonCell Changed(const PythonCell& cell, const nb::dict& given) {
  ChangeRequest request;
  Keywords keywords(given);
  keywords.Each(request);
  keywords.Finish();
  PythonCell changed = cell;
  SetCellParameters(changed.cell, {request.parameters.begin(), request.parameters.end()});
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
             nb::arg("progress").none(),
             nb::arg("inputs"));
  module.def("with_parameters", &Changed, nb::arg("cell"), nb::arg("options"));
  module.def("describe_plan", [] {
    Keywords keywords;
    PlanGrid grid;
    keywords.Each(grid);
    return keywords.Described();
  });
  module.def("describe_synthesize", [] {
    Keywords keywords;
    SynthesisOptions options;
    PackRequest pack;
    keywords.Each(pack);
    keywords.Each(options);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
