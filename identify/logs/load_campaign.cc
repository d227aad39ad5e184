#include "identify/logs/load_campaign.h"

#include <tbb/parallel_for.h>

#include <exception>

#include "model/core/errors.h"

namespace lipoid {

std::vector<LoadedLog> LoadCampaign(const Campaign& campaign) {
  std::vector<LoadedLog> logs(campaign.logs.size());
  std::vector<std::exception_ptr> failures(campaign.logs.size());
  tbb::parallel_for(std::size_t{0}, logs.size(), [&](std::size_t k) {
    try {
      logs[k].entry = campaign.logs[k];
      logs[k].log = ReadLog(campaign.logs[k].path, campaign.logs[k].read);
      DivideByPack(logs[k].log.record, campaign.series, campaign.parallel);
    } catch (...) {
      failures[k] = std::current_exception();
    }
  });
  // In the order of the campaign, whatever the threads did. LoadError drops what is said twice.
  std::vector<Diagnostic> diagnostics;
  for (const auto& failure : failures) {
    if (!failure) continue;
    try {
      std::rethrow_exception(failure);
    } catch (const LoadError& error) {
      diagnostics.insert(diagnostics.end(), error.diagnostics().begin(), error.diagnostics().end());
    }
  }
  if (!diagnostics.empty()) throw LoadError(std::move(diagnostics));
  return logs;
}

}  // namespace lipoid
