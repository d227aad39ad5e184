#include "python/src/report.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "model/core/atomic_file.h"
#include "model/core/one_file.h"
#include "python/src/campaign.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/work.h"
#include "tools/report/flight_series.h"
#include "tools/report/identify_series.h"
#include "tools/report/report.h"

namespace lipoid::python {
namespace {

// A result with its samples, on its way to a page.
struct Shown {
  ReportResult result;
};

// `summary` as JSON text, with the command that it is of.
ReportResult ResultOf(const std::string& summary) { return {Json::parse(summary), {}, {}, ""}; }

Shown ShownSummary(const std::string& summary) { return {ResultOf(summary)}; }

Shown ShownIdentification(const std::string& summary,
                          const PythonCampaign& campaign,
                          const PythonCell& cell,
                          const PythonCell* staged) {
  Shown shown{ResultOf(summary)};
  Work([&](const Tell&) {
    shown.result.series = IdentifySeries(
        cell.cell, staged != nullptr ? &staged->cell : nullptr, campaign.Logs(), 0, 1);
  });
  return shown;
}

Shown ShownFlight(const std::string& summary, const nb::dict& columns) {
  Shown shown{ResultOf(summary)};
  Series series{.kind = "flight", .name = ""};
  for (const auto& [key, value] : columns) {
    const auto name = nb::cast<std::string>(key);
    if (!IsShownOfFlight(name)) continue;
    const auto numbers = SpanOf(nb::cast<Input>(value));
    series.rows = numbers.size();
    series.columns.push_back({name, {numbers.begin(), numbers.end()}});
  }
  shown.result.series.push_back(std::move(series));
  return shown;
}

void WriteReport(const std::vector<const Shown*>& several, const nb::object& path) {
  const std::string file = PathOf(path);
  std::vector<ReportResult> results;
  for (const Shown* shown : several) results.push_back(shown->result);
  const WithoutLock unlocked;
  WriteFileAtomically(file, ReportPage(results));
}

}  // namespace

void AddReports(nb::module_& module) {
  nb::class_<Shown>(module, "Shown");
  module.def("shown_summary", &ShownSummary, nb::arg("summary"));
  module.def("shown_identification",
             &ShownIdentification,
             nb::arg("summary"),
             nb::arg("campaign"),
             nb::arg("cell"),
             nb::arg("staged").none());
  module.def("shown_flight", &ShownFlight, nb::arg("summary"), nb::arg("columns"));
  module.def("write_report", &WriteReport, nb::arg("results"), nb::arg("file"));
  module.def("can_report", &CanReport);
  module.def(
      "refuse_inputs",
      [](const std::string& name, nb::handle output, const nb::list& inputs) {
        RefuseInputs(std::vector<NamedOutput>{{name, PathOf(output)}}, PathsOf(inputs));
      },
      nb::arg("name"),
      nb::arg("output"),
      nb::arg("inputs"));
}

}  // namespace lipoid::python
