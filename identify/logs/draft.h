#pragma once

/// @file
/// Drafts a campaign from inspected logs, for a person to read over.
///
/// The cut-off is where most of the constant-current logs end; the capacity is the charge of the
/// slowest discharge; of several low-rate logs the slowest is taken, of equally slow ones the one
/// with the least resistance at its first edge (leads in the sense path show there). Logs that do
/// not fit stand in the text as comments with the reason. Tests: tests/identify/logs/draft_test.cc.

#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/inspection.h"

namespace lipoid {

struct CampaignDraft {
  struct Entry {
    CampaignLog log;
    std::string reason;    ///< why this kind
    std::string left_out;  ///< why it does not take part; empty where it does
  };
  Campaign campaign;           ///< those that take part
  std::vector<Entry> entries;  ///< all that could be read and are of some kind
  std::vector<std::pair<std::string, std::string>> unused;  ///< other files, and why
};

/// Files of a folder that may be logs, sorted by name: no hidden ones, no folders, no texts for
/// people and no campaign or cell files. LoadError where it cannot be read or holds none.
[[nodiscard]] std::vector<std::string> FilesOfFolder(const std::string& folder);

/// `campaign_file` is where the draft will be written: paths are relative to it. `read` is what the
/// user said about the files.
[[nodiscard]] CampaignDraft DraftCampaign(const std::vector<InspectedFile>& files,
                                          const std::string& name,
                                          const std::string& campaign_file,
                                          const ReadOptions& read = {});

[[nodiscard]] std::string DraftToToml(const CampaignDraft& draft);

}  // namespace lipoid
