#include "tools/commands/staged_arguments.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "identify/identification.h"
#include "identify/stages/open_circuit_voltage_file.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "tools/cli/assignments.h"

namespace lipoid {
namespace {

// The rest voltage before the first row tells where the logs start, once v_oc(A) is known.
double InitialSoc(const StartOptions& start,
                  const CampaignArguments& typed,
                  const StagedGiven& given) {
  if (start.initial_voltage_V && !given.open_circuit_voltage) {
    throw OptionError(
        "option --initial-voltage-V needs v_oc(A): give --open-circuit-voltage FILE too");
  }
  Cell cell;
  cell.series = typed.series;
  if (given.open_circuit_voltage) cell.open_circuit_voltage = *given.open_circuit_voltage;
  return start.Soc(cell);
}

}  // namespace

void StagedArguments::AddTo(cli::CommandLine& line) {
  line.Inputs("constant-current",
              typed_.constant_current,
              "LOG",
              "discharges at constant current, to cut-off");
  line.Inputs("low-rate", typed_.low_rate, "LOG", "a discharge so slow that it shows v_oc");
  line.Inputs("pulses", typed_.pulses, "LOG", "pulses with rests");
  line.Inputs(
      "flight",
      typed_.flight,
      "LOG",
      "logs of flights: beside lab logs they are fitted with them, each with its own start and sensors; alone they give "
      "v_oc over the range flown, the total resistance and a fast branch");
  line.Inputs("validation", typed_.validation, "LOG", "logs to judge the cell by, not to fit");
  line.Option(
      "cutoff-V", typed_.cutoff_V, Range{0.0, 100.0}, "voltage of one cell that ends a discharge");
  line.Option("capacity-Ah", capacity_Ah_, Range{1e-9, 1e9}, "nominal capacity of one cell");
  line.Text("name", typed_.name, "TEXT", "name of the cell");
  line.Option("series", typed_.series, kPackSizes, "cells in series in the logs");
  line.Option("parallel", typed_.parallel, kPackSizes, "cells in parallel in the logs");
  log_options_.AddTo(line);
  start_options_.AddTo(line);
  line.Option(
      "alpha-C", given.alpha_C, Range{1e-9, 1e12}, "alpha in coulombs, instead of finding it");
  line.Input(
      "open-circuit-voltage",
      curve_file_,
      "FILE",
      "v_oc(A), instead of finding it: a CSV with columns soc and voltage_V, or a cell file");
  line.Option("branches", branches_, Range{0, 5}, "resistor-capacitor branches (pulses.branches)");
  line.Flag("no-diffusion", no_diffusion_, "hold beta at infinity: the plain equivalent circuit");
  line.Texts(
      "fix", fix_, "NAME=VALUE", "hold a parameter at a value: beta, r_s, r_1, c_1, tau_1, ...");
  line.Texts("start", start_, "NAME=VALUE", "value at which the search for a parameter begins");
  line.Texts("bounds", bounds_, "NAME=LOW,HIGH", "keep a parameter between two bounds");
}

void StagedArguments::AddGroupsTo(cli::CommandLine& line) {
  line.Group("discharge_times", options.discharge_times);
  line.Group("open_circuit_voltage", options.open_circuit_voltage);
  line.Group("pulses", options.pulses);
}

bool StagedArguments::ByOptions() const {
  return !typed_.constant_current.empty() || !typed_.low_rate.empty() || !typed_.pulses.empty() ||
         !typed_.flight.empty() || !typed_.validation.empty();
}

std::vector<Campaign> StagedArguments::Campaigns(cli::CommandLine& line,
                                                 const std::vector<std::string>& files,
                                                 std::vector<LoadError>* unreadable) {
  if (branches_) options.pulses.branches = *branches_;
  if (no_diffusion_) options.pulses.diffusion = false;
  if (capacity_Ah_) typed_.capacity_Ah = *capacity_Ah_;
  auto& known = given.parameters;
  for (const auto& [name, value] : ParseAssignments("--fix", fix_)) known.fixed[name] = value;
  for (const auto& [name, value] : ParseAssignments("--start", start_)) known.start[name] = value;
  for (const auto& [name, ends] : ParseRanges("--bounds", bounds_)) known.bounds[name] = ends;

  const bool by_options = ByOptions();
  if (by_options == !files.empty()) {
    throw OptionError(
        by_options
            ? "give either a campaign file or logs by options, not both"
            : "CAMPAIGN is missing: a campaign file, or logs by --constant-current, --low-rate "
              "and --pulses; `lipoid inspect FOLDER --write-campaign FILE` drafts one");
  }
  if (!by_options) {
    for (const char* option : {"columns",
                               "cutoff-V",
                               "capacity-Ah",
                               "name",
                               "series",
                               "parallel",
                               "units",
                               "current-sign",
                               "hold",
                               "initial-soc",
                               "initial-voltage-V"}) {
      if (line.Given(option)) {
        throw OptionError(fmt::format(
            "option --{} goes with logs given by options; in a campaign file it is a key", option));
      }
    }
  }
  typed_.read = log_options_.ToReadOptions();
  if (!curve_file_.empty()) {
    given.open_circuit_voltage = ReadOpenCircuitVoltageFile(curve_file_);
    given.open_circuit_voltage_source = curve_file_;
  }
  std::vector<Campaign> campaigns;
  if (by_options) {
    typed_.initial_soc = InitialSoc(start_options_, typed_, given);
    campaigns.push_back(CampaignFromArguments(typed_));
  } else {
    for (const auto& file : files) {
      try {
        campaigns.push_back(ReadCampaign(file));
      } catch (const LoadError& error) {
        if (unreadable == nullptr) throw;
        unreadable->push_back(error);
      }
    }
  }
  for (Campaign& campaign : campaigns) {
    for (CampaignLog& log : campaign.logs) log.read.most_rows = typed_.read.most_rows;
  }
  line.AddInputs(LogFiles(campaigns));
  return campaigns;
}

Json StagedArguments::ToJson() const { return StagedOptionsToJson(options, given); }

}  // namespace lipoid
