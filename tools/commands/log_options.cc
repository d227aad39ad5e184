#include "tools/commands/log_options.h"

#include <atomic>
#include <cstddef>
#include <nlohmann/json.hpp>

namespace lipoid {

namespace {

// Of what commands do with logs that they read.
constexpr double kShareOfReading = 0.2;

}  // namespace

std::vector<std::string> LogFiles(const std::vector<Campaign>& campaigns) {
  std::vector<std::string> files;
  for (const Campaign& campaign : campaigns) {
    for (const CampaignLog& log : campaign.logs) files.push_back(log.path);
  }
  return files;
}

std::vector<LoadedLog> LoadLogs(cli::CommandLine& line,
                                const Campaign& campaign,
                                const std::function<double(double)>& share_of_bar) {
  // A bar that grows with all the logs: each counts alike.
  Campaign told = campaign;
  std::vector<std::atomic<double>> shares(told.logs.size());
  for (std::size_t k = 0; k < told.logs.size(); ++k) {
    told.logs[k].read.progress = [&, k](double share) {
      shares[k] = share;
      double sum = 0.0;
      for (const auto& each : shares) sum += each;
      const double all = kShareOfReading * sum / static_cast<double>(shares.size());
      line.progress().Update(share_of_bar ? share_of_bar(all) : all, "reading logs");
    };
  }
  std::vector<LoadedLog> logs = LoadCampaign(told);
  for (LoadedLog& log : logs) log.entry.read.progress = {};  // of this call alone
  for (const std::string& note : NotesOnLogs(logs)) line.Message("{}", note);
  return logs;
}

}  // namespace lipoid
