#include "identify/logs/load_campaign.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>

#include "identify/logs/plausibility.h"
#include "model/core/errors.h"

namespace lipoid {

std::vector<LoadedLog> LoadCampaign(const Campaign& campaign) {
  std::vector<LoadedLog> logs(campaign.logs.size());
  std::vector<std::vector<Diagnostic>> problems(campaign.logs.size());
  // The largest first, so that none of them ends alone.
  std::vector<std::uintmax_t> size(logs.size());
  std::vector<std::size_t> order(logs.size());
  for (std::size_t k = 0; k < logs.size(); ++k) {
    std::error_code unreadable;  // said when it is read
    size[k] = std::filesystem::file_size(campaign.logs[k].path, unreadable);
    if (unreadable) size[k] = 0;
    order[k] = k;
  }
  std::stable_sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(std::size_t{0}, logs.size(), [&](std::size_t) {
    const std::size_t k = order[next++];
    try {
      logs[k].entry = campaign.logs[k];
      logs[k].log = ReadLog(campaign.logs[k].path, campaign.logs[k].read);
      DivideByPack(logs[k].log.record, campaign.series, campaign.parallel);
      CheckPlausible(logs[k].log.record, campaign.capacity_Ah);
    } catch (const LoadError& error) {
      problems[k] = error.diagnostics();
    }
  });
  // In the order of the campaign, whatever the threads did. A file that stands in several places
  // speaks once; where several are bad, each has one line.
  std::set<std::string> bad;
  std::vector<Diagnostic> first;
  std::vector<Diagnostic> all;
  for (std::size_t k = 0; k < problems.size(); ++k) {
    if (problems[k].empty() || !bad.insert(campaign.logs[k].path).second) continue;
    first.push_back(problems[k].front());
    all.insert(all.end(), problems[k].begin(), problems[k].end());
  }
  if (!bad.empty()) throw LoadError(bad.size() == 1 ? all : first);
  return logs;
}

}  // namespace lipoid
