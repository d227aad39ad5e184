// lipoid._core: what C++ knows. The package around it (python/lipoid) makes it at home in Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "model/core/nearest_name.h"
#include "model/core/run_record.h"
#include "python/src/campaign.h"
#include "python/src/cell.h"
#include "python/src/comparison.h"
#include "python/src/endurance.h"
#include "python/src/errors.h"
#include "python/src/export.h"
#include "python/src/flight.h"
#include "python/src/health.h"
#include "python/src/identification.h"
#include "python/src/log.h"
#include "python/src/planning.h"
#include "python/src/report.h"
#include "python/src/work.h"

NB_MODULE(_core, module) {
#ifdef NDEBUG
  // What Python has not let go of when it ends is of no interest to those who use the package.
  nanobind::set_leak_warnings(false);
#endif
  using namespace lipoid::python;
  AddErrors(module);
  AddLogs(module);
  AddCampaigns(module);
  AddCells(module);
  AddIdentification(module);
  AddComparison(module);
  AddPlanning(module);
  AddFlights(module);
  AddEndurance(module);
  AddHealth(module);
  AddExport(module);
  AddReports(module);
  module.def("unknown_name",
             &lipoid::UnknownName,
             nanobind::arg("what"),
             nanobind::arg("typed"),
             nanobind::arg("known"));
  module.def("stop_all_work", &StopAllWork);
  module.def("end_work", &EndWork);
  module.attr("version") = lipoid::Version();
  module.attr("commit") = lipoid::GitCommit();
}
