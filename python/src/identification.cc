#include "python/src/identification.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "identify/fit_quality.h"
#include "identify/identification.h"
#include "identify/identify_request.h"
#include "identify/logs/gaps.h"
#include "identify/logs/plausibility.h"
#include "identify/pack_request.h"
#include "identify/stages/staged_report.h"
#include "identify/surroundings_request.h"
#include "identify/trust/edges.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/core/stop.h"
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

// Of a cell that is as many as cell.pack() says, where the command line has options.
std::string OfPack(const std::string& message) {
  static const std::regex given("`(series|parallel)` = ([0-9]+) \\(--(series|parallel) [0-9]+\\)");
  static const std::regex named("`(series|parallel)`");
  return std::regex_replace(
      std::regex_replace(message, given, "cell.pack($1=$2)"), named, "$1 of cell.pack()");
}

// One log of the pack, as that of one cell.
LogErrors ErrorsOf(const Cell& pack,
                   const Log& of_pack,
                   const StartRequest& start,
                   const SurroundingsRequest& surroundings,
                   std::string& doubt) {
  Record record = of_pack.record;
  if (record.voltage_V.empty())
    throw LoadError({record.file}, "expected a voltage to compare with, found none");
  RefuseUnknownCharge(record, of_pack.report.gaps, pack.capacity_Ah * pack.parallel);
  const Cell one = pack.AsOne();
  DivideByPack(record, pack.series, pack.parallel);
  try {
    (void)CheckPlausible(record, one.capacity_Ah, pack.series, pack.parallel);
    CheckSeries(record, one.open_circuit_voltage, pack.series);
  } catch (const LoadError& error) {
    std::vector<Diagnostic> wrong = error.diagnostics();
    for (Diagnostic& each : wrong) each.message = OfPack(each.message);
    throw LoadError(std::move(wrong));
  }
  const Surroundings among = surroundings.Of(record);
  const double initial_soc = start.Soc(pack, among);
  doubt = DoubtAboutStart(one, record, initial_soc);
  return Validate(one, record, initial_soc, among);
}

// What `lipoid validate` says of logs: of each, and of all together.
nb::tuple ValidateLogs(const PythonCell& pack, const nb::list& logs, const nb::dict& given) {
  StartRequest start;
  SurroundingsRequest surroundings;
  Keywords keywords(given);
  keywords.Each(start);
  keywords.Each(surroundings);
  keywords.Finish();
  std::vector<Log> lent;
  for (const nb::handle log : logs) lent.push_back(nb::cast<const PythonLog&>(log).Lent());
  Json rows = Json::array();
  Json verdict;
  {
    std::vector<LogErrors> all;
    Work([&](const Tell&) {
      for (const Log& log : lent) {
        StopIfAsked();
        std::string doubt;
        all.push_back(ErrorsOf(pack.cell, log, start, surroundings, doubt));
        rows.push_back(LogErrorsToJson(all.back()));
        if (!doubt.empty()) rows.back()["doubt"] = std::move(doubt);
      }
    });
    const FitQuality quality = JudgeFit(pack.cell.AsOne(), all, {}, 0.0, 0.0, AlphaOf::kElsewhere);
    verdict = {{"fit", FitToJson(quality)}, {"edges", EdgesToJson(quality.edges)}};
  }
  return nb::make_tuple(ToPython(rows), ToPython(verdict));
}

// Of each log that took part in a fit, or of those of one kind: its kind, the log, and the voltage and
// state of charge that the cell predicts where and as warm as the log was.
nb::list PredictLogs(const PythonCell& pack,
                     const PythonCampaign& campaign,
                     const std::optional<std::string>& only) {
  nb::list all;
  const Cell one = pack.cell.AsOne();
  const std::vector<LoadedLog>* logs = nullptr;
  {
    const WithoutLock unlocked;
    logs = &campaign.Logs();
  }
  for (const LoadedLog& log : *logs) {
    const std::string kind = options_internal::ToText(log.entry.kind);
    if (log.entry.kind == LogKind::kValidation || (only && *only != kind)) continue;
    Prediction predicted;
    {
      const WithoutLock unlocked;
      const Record& record = log.log.record;
      predicted = Predict(one,
                          record.time_s,
                          record.current_A,
                          record.hold,
                          log.entry.initial_soc,
                          SurroundingsOf(record, log.entry));
    }
    all.append(nb::make_tuple(kind,
                              PythonLog{std::make_shared<const Log>(log.log)},
                              ToArray(std::move(predicted.voltage_V)),
                              ToArray(std::move(predicted.soc))));
  }
  return all;
}

// Errors of each log that took part in a fit, with its kind.
nb::list ErrorsOfLogs(const PythonCell& pack, const PythonCampaign& campaign) {
  Json rows = Json::array();
  {
    const WithoutLock unlocked;
    const Cell one = pack.cell.AsOne();
    for (const LoadedLog& log : campaign.Logs()) {
      if (log.entry.kind == LogKind::kValidation) continue;
      Json row = {{"kind", options_internal::ToText(log.entry.kind)}};
      row.update(LogErrorsToJson(Validate(one, log)));
      rows.push_back(std::move(row));
    }
  }
  return nb::cast<nb::list>(ToPython(rows));
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
  module.def("validate", &ValidateLogs, nb::arg("cell"), nb::arg("logs"), nb::arg("options"));
  module.def(
      "predict_logs", &PredictLogs, nb::arg("cell"), nb::arg("campaign"), nb::arg("only").none());
  module.def("errors_of_logs", &ErrorsOfLogs, nb::arg("cell"), nb::arg("campaign"));
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
