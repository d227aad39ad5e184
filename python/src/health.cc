#include "python/src/health.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "identify/health/health.h"
#include "identify/health/health_report.h"
#include "identify/pack_request.h"
#include "model/core/errors.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/log.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

struct HealthKeywords {
  HealthOptions options;
  LoggedPackRequest pack;

  void Declare(Keywords& keywords) {
    keywords.Each(pack);
    keywords.Each(options);
  }
};

// The summary of `lipoid health`, and what it says of the last flight and of all.
nb::tuple Health(const PythonCell& cell,
                 const std::vector<const PythonLog*>& flights,
                 const nb::dict& given) {
  HealthKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  std::vector<Log> logs;
  for (const PythonLog* flight : flights) logs.push_back(flight->Lent());
  made.options.series = SeriesOfPack(logs, made.pack.series);
  made.options.parallel = made.pack.parallel.value_or(1);
  Json summary;
  std::string sentence;
  Work([&](const Tell&) {
    const HealthReport report = AssessHealth(cell.cell, std::move(logs), made.options);
    summary = HealthToJson(report);
    sentence = FirstLines(report).front();
  });
  return nb::make_tuple(ToPython(summary), sentence);
}

}  // namespace

void AddHealth(nb::module_& module) {
  module.def("health", &Health, nb::arg("cell"), nb::arg("flights"), nb::arg("options"));
  module.def("describe_health", [] {
    HealthKeywords made;
    Keywords keywords;
    made.Declare(keywords);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
