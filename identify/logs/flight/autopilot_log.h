#pragma once

/// @file
/// What the log of an autopilot says of its batteries, and the table of the autopilots' formats.
///
/// Such logs are binary and describe themselves. A log may end inside a message, and bytes of it may
/// be damaged: reading goes on at the next message that holds together, and counts what it passed
/// over. Nothing that a file may hold makes reading throw, but for a beginning that is of no known
/// format. Tests: tests/identify/logs/flight/autopilot_log_test.cc, with values that the autopilots'
/// own programs read (fixtures/flights).

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// One battery, row by row as the autopilot logged it: NaN where it says that it does not know.
struct BatteryTrack {
  int number = 1;              ///< from 1, as the autopilot names it
  std::string message;         ///< the kind of message: "battery_status", "BAT"
  std::vector<double> time_s;  ///< since the autopilot started
  std::vector<double> voltage_V;
  std::vector<double> current_A;  ///< discharge positive, by definition of these formats
  std::vector<double> temperature_degC;
  int cells = 0;  ///< in series, as the autopilot was told; 0: it was not
  double capacity_Ah = std::numeric_limits<double>::quiet_NaN();  ///< as it was told

  [[nodiscard]] std::size_t size() const { return time_s.size(); }
};

struct AutopilotLog {
  std::string vehicle;                  ///< firmware and hardware, as far as the log says
  std::vector<BatteryTrack> batteries;  ///< by number; without rows where only announced
  std::size_t messages = 0;             ///< that hold together
  std::size_t skipped_bytes = 0;        ///< of damaged messages
  std::size_t damaged_places = 0;
  bool cut_last_message = false;  ///< the file ends inside a message
  std::size_t dropouts = 0;       ///< times that the autopilot itself could not log
  double dropped_out_s = 0.0;
};

/// A format of the table.
struct AutopilotFormat {
  std::string_view name;
  std::string_view summary;
  std::string_view battery_message;  ///< what its batteries are called, for messages
  bool (*recognises)(std::string_view bytes);
  AutopilotLog (*read)(std::string_view bytes);
};

/// All formats, sorted by name.
[[nodiscard]] std::span<const AutopilotFormat> AutopilotFormats();

/// The format of a file that begins with these bytes; nullptr where it is none of an autopilot.
[[nodiscard]] const AutopilotFormat* FindAutopilotFormat(std::string_view bytes);

}  // namespace lipoid
