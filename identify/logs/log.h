#pragma once

/// @file
/// Reading a log of any known format into a Record, with a report of what was found and done.
///
/// The format is recognised from the content. The sign of the current is found from the physics or
/// from the cycler's state column. What is dropped is counted. Anything else that is wrong is a
/// LoadError with file:line:column. Formats: identify/logs/formats/formats.h. Tests:
/// tests/identify/logs/.

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/logs/current_sign.h"
#include "identify/logs/record.h"
#include "model/core/errors.h"

namespace lipoid {

/// The largest number that a battery of a flight log may have.
inline constexpr int kMostBatteries = 256;

/// Rows of a log that are kept as they are: 400 MB, 47 hours at 100 rows per second.
inline constexpr std::size_t kMostRowsKept = std::size_t{1} << 24;

/// What the user says about a file instead of leaving it to be found.
struct ReadOptions {
  /// Keys time_s, current_A, voltage_V, temperature_degC: the header's name for that column.
  std::map<std::string, std::string> columns = {};
  /// Units of time, current and voltage, for headers that state none: {"s", "A", "V"}. Empty: as
  /// the header says. An entry that contradicts the header is an error.
  std::vector<std::string> units = {};
  /// "" or "auto": found from the data; "discharge-positive"; "discharge-negative".
  std::string current_sign = {};
  Hold hold = Hold::kBackward;
  /// Only rows of these steps / cycles of a vendor file; empty: all.
  std::vector<int> steps = {};
  std::vector<int> cycles = {};
  /// Only rows with start_s <= time <= end_s, in the time of the file; time then restarts at 0.
  double start_s = -std::numeric_limits<double>::infinity();
  double end_s = std::numeric_limits<double>::infinity();
  /// Take a log without a voltage too: the record's voltage_V is then empty and, unless the states
  /// or current_sign say otherwise, discharge counts as positive. For currents that drive a
  /// simulation.
  bool voltage_optional = false;
  /// Report which step and cycle of the cycler's program each row belongs to (LogReport::labels).
  bool labels = false;
  /// Which battery of a flight log, from 1 as the autopilot names it; 0: there is one.
  int battery = 0;
  /// Added drop of the leads: v_true = v + R i.
  double lead_resistance_Ohm = 0.0;
  /// A table of more rows is thinned while it is read (thinning.h).
  std::size_t most_rows = kMostRowsKept;
  /// Told which share of the file was read, now and then, where its size is known.
  std::function<void(double share)> progress = {};

  [[nodiscard]] bool ChoosesTimes() const { return std::isfinite(start_s) || std::isfinite(end_s); }
  [[nodiscard]] bool ChoosesPart() const {
    return !steps.empty() || !cycles.empty() || ChoosesTimes();
  }
};

/// A stretch of time without rows, far longer than the sampling around it, in which a current may
/// have flowed.
struct Gap {
  std::size_t row = 0;  ///< the row that ends the gap
  double start_s = 0.0;
  double length_s = 0.0;
  double unknown_C =
      0.0;  ///< what the larger of the two currents at its ends would have moved; in a rest the largest of all
  bool recharge = false;  ///< the cell rests as high after it as before unknown_C had left
};

/// From this row on, the rows belong to this step and this cycle of the cycler's program.
struct RowLabel {
  std::size_t row = 0;
  double step = 0.0;
  double cycle = 0.0;
};

/// What an autopilot's log says beside its rows.
struct FlightFacts {
  std::string vehicle;            ///< firmware and hardware; "" where the log does not say
  int battery = 1;                ///< which one was read
  std::vector<int> batteries;     ///< all that the log has
  int cells = 0;                  ///< in series as the autopilot was told; 0: it was not
  double capacity_Ah = 0.0;       ///< as it was told; NaN: it was not
  double voltage_update_s = 0.0;  ///< how often the voltage really changes
  double current_update_s = 0.0;
  std::size_t messages = 0;       ///< of the whole log
  std::size_t skipped_bytes = 0;  ///< of damaged messages
  std::size_t damaged_places = 0;
  bool cut_last_message = false;
};

/// What contradicts what an autopilot was told of its pack, one sentence each. A capacity that is not
/// known is 0 or NaN.
[[nodiscard]] std::vector<std::string> DoubtsAboutPack(const FlightFacts& told,
                                                       int series,
                                                       double capacity_Ah);

/// What was done to a table of more rows than ReadOptions::most_rows (thinning.h).
struct ThinningFacts {
  std::size_t rows_of_log = 0;
  std::size_t rows = 0;       ///< of the record, before spikes were dropped
  std::size_t most_rows = 0;  ///< that would have been kept as they are
  std::size_t group = 1;      ///< rows of the log that one row stands for at most
  double tolerance_A = 0.0;   ///< within which the current of such a group stays
  /// Between neighbouring rows of the log; the median is that of the first most_rows.
  double shortest_s = 0.0;
  double median_s = 0.0;
  double longest_s = 0.0;
  // What was settled by the whole log, for reading its rows once more (all_rows.h).
  bool millivolts = false;
  std::vector<double> spikes_s = {};  ///< times of the rows that were dropped as spikes
};

/// What reading found and did; shown by `lipoid inspect`.
struct LogReport {
  std::string format;                      ///< name in the format table
  std::string current_column;              ///< the header's name for it
  std::size_t rows = 0;                    ///< rows kept; of a thinned log those of the log
  std::size_t dropped_repeated_times = 0;  ///< of repeated time stamps the first row is kept
  std::size_t dropped_unselected = 0;      ///< outside steps, cycles, start_s .. end_s
  std::size_t dropped_cut_last_line = 0;   ///< a last line that the logger did not finish
  std::size_t dropped_spikes = 0;          ///< rows whose voltage or current cannot be (spikes.h)
  std::size_t dropped_unknown = 0;         ///< rows of which an autopilot did not know a value
  std::string current_sign;         ///< "discharge-positive", "discharge-negative", "unsigned"
  std::string current_sign_reason;  ///< one sentence
  bool current_sign_is_of_others = false;  ///< see SignOfOthers
  std::vector<Gap> gaps;
  std::vector<RowLabel> labels;          ///< where asked for; empty where the file has neither
  std::optional<FlightFacts> flight;     ///< of an autopilot's log
  std::optional<ThinningFacts> thinned;  ///< of a table too long to keep every row
  std::vector<std::string> notes;        ///< byte order mark, trailing comma, decimal comma, ...
  /// What a person should look at before believing the log, one sentence each: spikes that were
  /// dropped, times that look like minutes. Every command that reads the log shows them.
  std::vector<std::string> warnings;
  /// Of the warnings that of DoubtAboutStuckVoltage(); "" where there is none.
  std::string stuck_voltage;

  [[nodiscard]] std::size_t dropped_rows() const {
    return dropped_repeated_times + dropped_unselected + dropped_cut_last_line + dropped_spikes +
           dropped_unknown;
  }
};

/// The row of a log before the part that was chosen.
struct RowBefore {
  double time_s = 0.0;            ///< below 0: the part begins at 0
  double current_A = 0.0;         ///< of either sign
  double voltage_V = 0.0;         ///< NaN where the log has none
  double temperature_degC = 0.0;  ///< the same
};

struct Log {
  Record record;
  LogReport report;
  std::optional<RowBefore> before = {};  ///< where steps, cycles or start_s left it out
};

/// What other logs of the same format say of the sign. It settles a log that says too little
/// itself, but none that contradicts itself.
struct SignOfOthers {
  CurrentSign sign = CurrentSign::kUnclear;  ///< unclear where they do not agree
  std::string source;      ///< which logs: "as low_rate.csv", "a.csv is discharge-positive, ..."
  bool same_file = false;  ///< no other log speaks, but the whole of which this log is a part
};

/// A log that says too little about the sign of its current; others of its format may settle it.
class OpenSignError : public LoadError {
 public:
  OpenSignError(SourcePosition position,
                std::string message,
                std::string format,
                std::string current_column)
      : LoadError(std::move(position), std::move(message)),
        format_(std::move(format)),
        current_column_(std::move(current_column)) {}

  [[nodiscard]] const std::string& format() const { return format_; }
  [[nodiscard]] const std::string& current_column() const { return current_column_; }

 private:
  std::string format_;
  std::string current_column_;
};

/// The sign of a part that says too little by itself is that of the whole file.
[[nodiscard]] Log ReadLog(const std::string& file,
                          const ReadOptions& options = {},
                          const SignOfOthers& others = {});

/// The same of text in memory that came from `file`, which only messages name: the table of a file
/// that another reader took apart.
[[nodiscard]] Log ReadLogText(std::string_view text,
                              const std::string& file,
                              const ReadOptions& options = {},
                              const SignOfOthers& others = {});

/// The same of columns that a program hands over: finite numbers in SI units, of equal lengths. Their
/// current may have either sign. Of `options` columns, units, steps and cycles are of files alone.
/// The rows of a LoadError count from 1. What is lent is copied only where something is dropped or
/// turned.
[[nodiscard]] Log TakeLog(Record record, const ReadOptions& options = {});

}  // namespace lipoid
