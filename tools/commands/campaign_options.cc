#include "tools/commands/campaign_options.h"

#include <fmt/format.h>

#include "model/core/errors.h"
#include "tools/commands/log_options.h"

namespace lipoid {
namespace {

// The rest voltage before the first row tells where the logs start, once v_oc(A) is known.
double InitialSoc(const StartRequest& start,
                  const CampaignArguments& typed,
                  const std::optional<OpenCircuitVoltage>& curve) {
  if (start.initial_voltage_V && !curve) {
    throw OptionError(
        "option --initial-voltage-V needs v_oc(A): give --open-circuit-voltage FILE too");
  }
  Cell cell;
  cell.series = typed.series;
  if (curve) cell.open_circuit_voltage = *curve;
  return start.Soc(cell);
}

}  // namespace

void CampaignOptions::AddTo(cli::CommandLine& line) {
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
  line.Each(request_);
  line.Each(reading_);
  line.Each(start_);
}

bool CampaignOptions::ByOptions() const {
  return !typed_.constant_current.empty() || !typed_.low_rate.empty() || !typed_.pulses.empty() ||
         !typed_.flight.empty() || !typed_.validation.empty();
}

std::vector<Campaign> CampaignOptions::Campaigns(cli::CommandLine& line,
                                                 const std::vector<std::string>& files,
                                                 const std::optional<OpenCircuitVoltage>& curve,
                                                 std::vector<LoadError>* unreadable) {
  request_.ApplyTo(typed_);
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
  typed_.read = reading_.Resolve();
  std::vector<Campaign> campaigns;
  if (by_options) {
    typed_.initial_soc = InitialSoc(start_, typed_, curve);
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

}  // namespace lipoid
