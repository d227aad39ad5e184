#include "tools/commands/log_options.h"

#include <fmt/format.h>

#include "model/core/errors.h"
#include "tools/commands/split.h"

namespace lipoid {

void LogOptions::AddTo(cli::CommandLine& line) {
  line.Text(
      "units", units, "s,A,V", "units of time, current and voltage where the header states none");
  line.Text("current-sign",
            current_sign,
            "SIGN",
            "discharge-positive or discharge-negative, where it cannot be found from the data");
  line.Option("hold",
              hold,
              Names(),
              "whether a row's current holds since the row before or until the next");
}

ReadOptions LogOptions::ToReadOptions() const {
  ReadOptions read;
  read.hold = hold;
  if (!units.empty()) {
    read.units = SplitAt(units, ',');
    if (read.units.size() != 3) {
      throw OptionError(fmt::format(
          "option --units: expected three, of time, current and voltage (s,A,V), found '{}'",
          units));
    }
  }
  if (!current_sign.empty() && current_sign != "auto" && current_sign != "discharge-positive" &&
      current_sign != "discharge-negative") {
    throw OptionError(
        fmt::format("option --current-sign: expected auto, discharge-positive or "
                    "discharge-negative, found '{}'",
                    current_sign));
  }
  read.current_sign = current_sign;
  return read;
}

std::vector<LoadedLog> LoadLogs(cli::CommandLine& line, const Campaign& campaign) {
  std::vector<LoadedLog> logs = LoadCampaign(campaign);
  for (const std::string& note : NotesOnLogs(logs)) line.Message("{}", note);
  return logs;
}

}  // namespace lipoid
