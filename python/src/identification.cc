#include "python/src/identification.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/identification.h"
#include "identify/identify_request.h"
#include "identify/stages/staged_report.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "python/src/campaign.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

IdentifyRequest RequestOf(Keywords& keywords) {
  IdentifyRequest request;
  keywords.Each(request);
  request.EachGroup(keywords.Groups());
  keywords.Finish();
  return request;
}

// The cell, the staged one beside a joint one, and the summary of `lipoid identify`.
nb::tuple IdentifyCampaign(const PythonCampaign& campaign,
                           const nb::dict& given,
                           std::uint64_t seed,
                           int threads,
                           const nb::object& progress) {
  Keywords keywords(given);
  const IdentifyOptions options = RequestOf(keywords).Resolve();
  const Campaign& described = campaign.campaign();
  CheckCampaign(described,
                options.given.open_circuit_voltage.has_value() || options.given.reference);
  Identification found;
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto began = std::chrono::steady_clock::now();
        tell("reading logs", 0.0);
        const std::vector<LoadedLog>& logs = campaign.Logs();
        found = Identify(described, logs, options, [&](std::string_view stage, double part) {
          tell(stage, 0.1 + 0.85 * part);
        });
        const Json report = IdentificationToJson(found);
        RunRecord run;
        run.command = "lipoid.identify";
        run.seed = seed;
        campaign.AddInputsTo(run);
        AddRunRecord(found, options, report, std::move(run));
        summary = {{"cell", CellToJson(found.cell)}};
        summary.update(report);
        summary["campaign"] = CampaignToJson(described, logs);
        summary["wall_s"] =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      },
      progress,
      threads);
  nb::object staged = nb::none();
  if (found.joint) staged = nb::cast(PythonCell{std::move(found.joint->staged.cell)});
  return nb::make_tuple(PythonCell{std::move(found.cell)},
                        staged,
                        ToPython(summary),
                        found.converged,
                        found.usable(),
                        found.Verdict());
}

nb::object ValidateLog(const PythonCell& cell, const PythonLog& log, double initial_soc) {
  Json json;
  {
    const nb::gil_scoped_release release;
    Record const record = log.Lent().record;
    json = LogErrorsToJson(Validate(cell.cell, record, initial_soc));
    Record one = record;
    DivideByPack(one, cell.cell.series, cell.cell.parallel);
    if (auto doubt = DoubtAboutStart(cell.cell.open_circuit_voltage, one, initial_soc);
        !doubt.empty())
      json["doubt"] = std::move(doubt);
  }
  return ToPython(json);
}

}  // namespace

void AddIdentification(nb::module_& module) {
  module.def("identify",
             &IdentifyCampaign,
             nb::arg("campaign"),
             nb::arg("options"),
             nb::arg("seed"),
             nb::arg("threads"),
             nb::arg("progress").none());
  module.def("validate", &ValidateLog, nb::arg("cell"), nb::arg("log"), nb::arg("initial_soc"));
  module.def(
      "check_identify",
      [](const nb::dict& given) {
        Keywords keywords(given);
        (void)RequestOf(keywords).Resolve();
      },
      nb::arg("options"));
  module.def("describe_identify", [] {
    Keywords keywords;
    (void)RequestOf(keywords);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
