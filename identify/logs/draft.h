#pragma once

/// @file
/// Drafts a campaign from inspected logs, for a person to read over.
///
/// A file that holds several tests is cut into them (parts.h). A pack is known by its voltage. The
/// cut-off is where most of the constant-current logs that end empty end; the capacity is the charge of the
/// slowest such discharge; of several low-rate logs the slowest is taken, of equally slow ones the one
/// with the least resistance at its first edge (leads in the sense path show there). A log
/// that rests below the others before its first load starts at a state of charge that is read from
/// the low-rate log. Logs that do not fit stand in the text as comments with the reason. Tests: tests/identify/logs/draft_test.cc.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/inspection.h"

namespace lipoid {

struct CampaignDraft {
  struct Entry {
    CampaignLog log;
    std::string reason;                ///< why this kind
    std::vector<std::string> remarks;  ///< what a person should look at
    std::string left_out;              ///< why it does not take part; empty where it does
  };
  Campaign campaign;           ///< those that take part
  std::vector<Entry> entries;  ///< all that could be read and are of some kind
  std::vector<std::pair<std::string, std::string>> unused;  ///< other files, and why
  std::vector<std::string> remarks;                         ///< on the cell
};

/// What a person says of all files.
struct DraftOptions {
  ReadOptions read = {};
  std::optional<int> series = {};  ///< else found from the voltages
  int parallel = 1;
  std::optional<double> cutoff_V = {};  ///< of one cell; else found from the ends of the discharges
};

/// Endings of the names of files that are no logs: texts for people, campaign and cell files.
[[nodiscard]] std::vector<std::string> EndingsOfNoLogs();

/// Files of a folder that may be logs, sorted by name: no hidden ones, no folders, none of these
/// endings. LoadError where it cannot be read or holds none.
[[nodiscard]] std::vector<std::string> FilesOfFolder(const std::string& folder);

/// `campaign_file` is where the draft will be written: paths are relative to it.
[[nodiscard]] CampaignDraft DraftCampaign(const std::vector<InspectedFile>& files,
                                          const std::string& name,
                                          const std::string& campaign_file,
                                          const DraftOptions& options = {});

[[nodiscard]] std::string DraftToToml(const CampaignDraft& draft);

}  // namespace lipoid
