#include "python/src/comparison.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "identify/comparison/comparison_run.h"
#include "identify/studies/studies.h"
#include "python/src/campaign.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

ComparisonRequest ComparisonOf(Keywords& keywords) {
  ComparisonRequest request;
  keywords.Each(request);
  request.EachGroup([groups = keywords.Groups()](std::string_view name, auto& options) {
    groups(name.empty() ? "comparison" : name, options);
  });
  for (const auto& entry : Optimizers()) {
    keywords.Group(entry.name, entry.options(), [&](std::string_view name, std::string_view text) {
      entry.set(request.settings, name, text);
    });
  }
  keywords.Finish();
  return request;
}

nb::object Compare(const PythonCampaign& campaign,
                   const nb::dict& given,
                   std::uint64_t seed,
                   int threads,
                   const nb::object& progress) {
  Keywords keywords(given);
  ComparisonRequest request = ComparisonOf(keywords);
  request.Resolve();
  request.settings.context.seed = seed;
  request.settings.context.threads = 0;
  const Campaign& described = campaign.campaign();
  CheckCampaign(described, request.staged.given.open_circuit_voltage.has_value());
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto& logs = campaign.Logs();
        const auto result = RunComparison(described, logs, request, tell);
        summary = ComparisonRunToJson(described, request, result);
      },
      progress,
      threads);
  return ToPython(summary);
}

StagedRequest StagesOf(Keywords& keywords) {
  StagedRequest request;
  keywords.Each(request);
  request.EachGroup(keywords.Groups());
  keywords.Group("solver", request.options.solver);
  keywords.Finish();
  return request;
}

nb::object RunStudy(const std::string& what,
                    const PythonCampaign& campaign,
                    const nb::dict& given,
                    int threads,
                    const nb::object& progress) {
  Keywords keywords(given);
  StagedRequest request = StagesOf(keywords);
  request.Resolve();
  const Study& study = FindStudy(what);
  Json summary;
  Work(
      [&](const Tell& tell) {
        const StudyInput input{
            campaign.campaign(), campaign.Logs(), request.options, request.given};
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
  module.def("describe_compare", [] {
    Keywords keywords;
    (void)ComparisonOf(keywords);
    return keywords.Described();
  });
  module.def("describe_study", [] {
    Keywords keywords;
    (void)StagesOf(keywords);
    return keywords.Described();
  });
  module.def("optimizer_names", [] {
    nb::list names;
    for (const auto& entry : Optimizers()) names.append(std::string(entry.name));
    return names;
  });
}

}  // namespace lipoid::python
