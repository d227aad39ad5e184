#include "identify/logs/load_campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "identify/logs/plausibility.h"
#include "identify/logs/read_logs.h"
#include "model/core/errors.h"

namespace lipoid {

std::vector<LoadedLog> LoadCampaign(const Campaign& campaign) {
  std::vector<LoadedLog> logs(campaign.logs.size());
  std::vector<LogToRead> files;
  files.reserve(campaign.logs.size());
  for (const CampaignLog& entry : campaign.logs) files.push_back({entry.path, entry.read});
  const auto problems = ReadLogs(files, [&](std::size_t k, Log log) {
    DivideByPack(log.record, campaign.series, campaign.parallel);
    CheckPlausible(log.record, campaign.capacity_Ah);
    logs[k] = {campaign.logs[k], std::move(log)};
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

std::vector<std::string> NotesOnLogs(const std::vector<LoadedLog>& logs) {
  std::vector<std::string> notes;
  const auto add = [&](std::string note) {  // a file may stand in several places
    if (std::find(notes.begin(), notes.end(), note) == notes.end())
      notes.push_back(std::move(note));
  };
  std::map<std::pair<std::string, std::string>, const LoadedLog*> first;  // by format and column
  for (const LoadedLog& loaded : logs) {
    const LogReport& report = loaded.log.report;
    if (report.current_sign_is_of_others)
      add(fmt::format("{}: {}", loaded.entry.file, report.current_sign_reason));
    if (report.current_sign == "unsigned") continue;
    const auto [found, is_new] = first.insert({{report.format, report.current_column}, &loaded});
    const LogReport& other = found->second->log.report;
    if (is_new || other.current_sign == report.current_sign) continue;
    add(fmt::format("{} is {} and {} is {}, although both have one format: look whether one is "
                    "turned, and say `current_sign` of that one",
                    found->second->entry.file,
                    other.current_sign,
                    loaded.entry.file,
                    report.current_sign));
  }
  return notes;
}

}  // namespace lipoid
