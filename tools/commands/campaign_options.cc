#include "tools/commands/campaign_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/core/errors.h"
#include "tools/commands/log_options.h"

namespace lipoid {
namespace {

// The rest voltage before the first row tells where the logs start, once v_oc(A) is known.
double InitialSoc(const StartRequest& start,
                  int series,
                  const std::optional<OpenCircuitVoltage>& curve) {
  if (start.initial_voltage_V && !curve) {
    throw OptionError(
        "option --initial-voltage-V needs v_oc(A): give --open-circuit-voltage FILE too");
  }
  Cell cell;
  cell.series = series;
  if (curve) cell.open_circuit_voltage = *curve;
  return start.Soc(cell);
}

}  // namespace

void CampaignOptions::AddTo(cli::CommandLine& line) {
  line.Inputs("constant-current",
              files_[LogKind::kConstantCurrent],
              "LOG",
              "discharges at constant current, to cut-off");
  line.Inputs(
      "low-rate", files_[LogKind::kLowRate], "LOG", "a discharge so slow that it shows v_oc");
  line.Inputs("pulses", files_[LogKind::kPulses], "LOG", "pulses with rests");
  line.Inputs(
      "flight",
      files_[LogKind::kFlight],
      "LOG",
      "logs of flights: beside lab logs they are fitted with them, each with its own start and sensors; alone they give "
      "v_oc over the range flown, the total resistance and a fast branch");
  line.Inputs(
      "validation", files_[LogKind::kValidation], "LOG", "logs to judge the cell by, not to fit");
  line.Each(request_);
  line.Each(reading_);
  line.Each(start_);
}

bool CampaignOptions::ByOptions() const {
  return std::any_of(
      files_.begin(), files_.end(), [](const auto& each) { return !each.second.empty(); });
}

std::vector<Campaign> CampaignOptions::Campaigns(cli::CommandLine& line,
                                                 const std::vector<std::string>& files,
                                                 const std::optional<OpenCircuitVoltage>& curve,
                                                 std::vector<LoadError>* unreadable) {
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
                               "battery",
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
  const ReadOptions read = reading_.Resolve();
  std::vector<Campaign> campaigns;
  if (by_options) {
    Campaign& campaign = campaigns.emplace_back();
    request_.ApplyTo(campaign);
    const double initial_soc = InitialSoc(start_, campaign.series, curve);
    for (const auto& [kind, logs] : files_) AddLogs(campaign, kind, logs, read, initial_soc);
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
    for (CampaignLog& log : campaign.logs) log.read.most_rows = read.most_rows;
  }
  line.AddInputs(LogFiles(campaigns));
  return campaigns;
}

}  // namespace lipoid
