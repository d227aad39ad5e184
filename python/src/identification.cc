#include "python/src/identification.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/joint/held_shape.h"
#include "identify/stages/open_circuit_voltage_file.h"
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

struct IdentifyKeywords {
  IdentifyOptions options;

  void Declare(Keywords& keywords) {
    keywords.Option(
        "method", options.method, Names{}, "all logs at once (joint), or stage by stage (staged)");
    std::optional<int> branches;
    DeclareStages(keywords, options.staged, options.given, branches);
    if (const auto reference = keywords.Take(
            "reference",
            "Path | Cell",
            "the same cell at another age: its v_oc(A), time constants and shapes are "
            "held, so that a short test gives its capacity, beta and resistances now")) {
      HeldShape held;
      if (const Cell* const cell = CellBehind(*reference)) {
        held.cell = *cell;
        held.source = held.cell.name;
      } else {
        held.source = PathOf(*reference);
        held.cell = LoadCell(held.source);
      }
      held.cell.series = held.cell.parallel = 1;
      options.given.reference = std::make_shared<const HeldShape>(std::move(held));
    }
    keywords.Words("profile",
                   options.profiled,
                   "hold each of these at values around its estimate and refit the others");
    keywords.Group("solver", options.staged.solver);
    if (branches) options.joint.branches = *branches;
    keywords.Group("joint", options.joint);
  }
};

// The cell, the staged one beside a joint one, and the summary of `lipoid identify`.
nb::tuple IdentifyCampaign(const PythonCampaign& campaign,
                           const nb::dict& given,
                           std::uint64_t seed,
                           int threads,
                           const nb::object& progress) {
  IdentifyKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  CheckIdentifyOptions(made.options);
  const Campaign& described = campaign.campaign();
  CheckCampaign(
      described,
      made.options.given.open_circuit_voltage.has_value() || made.options.given.reference);
  Identification found;
  Json summary;
  Work(
      [&](const Tell& tell) {
        const auto began = std::chrono::steady_clock::now();
        tell("reading logs", 0.0);
        const std::vector<LoadedLog>& logs = campaign.Logs();
        found = Identify(described, logs, made.options, [&](std::string_view stage, double part) {
          tell(stage, 0.1 + 0.85 * part);
        });
        const Json report = IdentificationToJson(found);
        RunRecord run;
        run.command = "lipoid.identify";
        run.seed = seed;
        campaign.AddInputsTo(run);
        AddRunRecord(found, made.options, report, std::move(run));
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
                        found.quality.Sentence());
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

void DeclareStages(Keywords& keywords,
                   StagedOptions& options,
                   StagedGiven& given,
                   std::optional<int>& branches) {
  keywords.Option(
      "alpha-C", given.alpha_C, Range{1e-9, 1e12}, "alpha in coulombs, instead of finding it");
  if (const auto curve =
          keywords.Take("open_circuit_voltage",
                        "Path | Cell",
                        "v_oc(A), instead of finding it: a CSV file with columns soc "
                        "and voltage_V, a cell file, or a cell")) {
    if (const Cell* const cell = CellBehind(*curve)) {
      given.open_circuit_voltage = cell->open_circuit_voltage;
      given.open_circuit_voltage_source = cell->name;
    } else {
      given.open_circuit_voltage_source = PathOf(*curve);
      given.open_circuit_voltage = ReadOpenCircuitVoltageFile(given.open_circuit_voltage_source);
    }
  }
  keywords.Option(
      "branches", branches, Range{0, 5}, "resistor-capacitor branches (pulses.branches)");
  bool no_diffusion = false;
  keywords.Flag(
      "no-diffusion", no_diffusion, "hold beta at infinity: the plain equivalent circuit");
  auto& known = given.parameters;
  keywords.Numbers(
      "fix", known.fixed, "hold parameters at these values: beta, r_s, r_1, c_1, tau_1, ...");
  keywords.Numbers("start", known.start, "values at which the search for parameters begins");
  keywords.Ranges("bounds", known.bounds, "keep parameters within (low, high)");
  if (branches) options.pulses.branches = *branches;
  if (no_diffusion) options.pulses.diffusion = false;
  keywords.Group("discharge_times", options.discharge_times);
  keywords.Group("open_circuit_voltage_fit", options.open_circuit_voltage);
  keywords.Group("pulses", options.pulses);
}

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
        IdentifyKeywords made;
        Keywords keywords(given);
        made.Declare(keywords);
        keywords.Finish();
        CheckIdentifyOptions(made.options);
      },
      nb::arg("options"));
  module.def("describe_identify", [] {
    IdentifyKeywords made;
    Keywords keywords;
    made.Declare(keywords);
    return keywords.Described();
  });
}

}  // namespace lipoid::python
