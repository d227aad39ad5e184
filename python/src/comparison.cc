#include "python/src/comparison.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "identify/comparison/comparison_run.h"
#include "identify/studies/studies.h"
#include "python/src/campaign.h"
#include "python/src/convert.h"
#include "python/src/identification.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

struct CompareKeywords {
  ComparisonRequest request;

  void Declare(Keywords& keywords) {
    std::vector<std::string> names = ThesisOptimizers();
    keywords.Words("optimizers", names, "which, or \"all\"; not given: the seven of the thesis");
    request.optimizers = FindOptimizers(names);
    keywords.Option(
        "starts", request.starts, Range{0, 100000}, "random starts of each, besides the data's");
    keywords.Flag("time-constants", request.time_constants, "tau_j as unknowns, instead of c_j");
    keywords.Group("comparison", request.options);
    std::optional<int> branches;
    DeclareStages(keywords, request.staged, request.given, branches);
    for (const auto& entry : Optimizers()) {
      keywords.Group(
          entry.name, entry.options(), [&](std::string_view name, std::string_view text) {
            entry.set(request.settings, name, text);
          });
    }
  }
};

nb::object Compare(const PythonCampaign& campaign,
                   const nb::dict& given,
                   std::uint64_t seed,
                   int threads,
                   const nb::object& progress) {
  CompareKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  made.request.settings.context.seed = seed;
  made.request.settings.context.threads = 0;
  const Campaign& described = campaign.campaign();
  CheckCampaign(described, made.request.given.open_circuit_voltage.has_value());
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto& logs = campaign.Logs();
        const auto result = RunComparison(described, logs, made.request, tell);
        summary = ComparisonRunToJson(described, made.request, result);
      },
      progress,
      threads);
  return ToPython(summary);
}

struct StudyKeywords {
  StagedOptions options;
  StagedGiven given;

  void Declare(Keywords& keywords) {
    std::optional<int> branches;
    DeclareStages(keywords, options, given, branches);
    keywords.Group("solver", options.solver);
  }
};

nb::object RunStudy(const std::string& what,
                    const PythonCampaign& campaign,
                    const nb::dict& given,
                    int threads,
                    const nb::object& progress) {
  StudyKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  const Study& study = FindStudy(what);
  Json summary;
  Work(
      [&](const Tell& tell) {
        const StudyInput input{campaign.campaign(), campaign.Logs(), made.options, made.given};
        const StudyResult result = study.run(input, tell);
        summary = {{"study", study.name}};
        summary.update(result.facts);
        summary["rows"] = result.rows;
        summary["remarks"] = result.remarks;
      },
      progress,
      threads);
  return ToPython(summary);
}

template <class Made>
nb::list Describe() {
  Made made;
  Keywords keywords;
  made.Declare(keywords);
  return keywords.Described();
}

}  // namespace

void AddComparison(nb::module_& module) {
  module.def("compare",
             &Compare,
             nb::arg("campaign"),
             nb::arg("options"),
             nb::arg("seed"),
             nb::arg("threads"),
             nb::arg("progress").none());
  module.def("study",
             &RunStudy,
             nb::arg("what"),
             nb::arg("campaign"),
             nb::arg("options"),
             nb::arg("threads"),
             nb::arg("progress").none());
  module.def("describe_compare", &Describe<CompareKeywords>);
  module.def("describe_study", &Describe<StudyKeywords>);
  module.def("optimizer_names", [] {
    nb::list names;
    for (const auto& entry : Optimizers()) names.append(std::string(entry.name));
    return names;
  });
}

}  // namespace lipoid::python
