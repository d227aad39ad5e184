#pragma once

/// @file
/// Takes the blocks of a table into a record in SI units: row by row where something must be left out.
/// Rows with a repeated time are dropped and counted, and so are those outside of what was chosen.
/// More rows than memory should hold are thinned (thinning.h). A short hole in the temperature is
/// bridged, a longer one leaves the column out. Tests: tests/identify/logs/log_test.cc.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "identify/logs/csv/table_reader.h"
#include "identify/logs/csv/text_source.h"
#include "identify/logs/formats/formats.h"
#include "identify/logs/log.h"
#include "identify/logs/thinning.h"

namespace lipoid {

/// Later than any test began and earlier than any clock of today: seconds since 1970.
inline constexpr double kUnixClock_s = 1e8;

/// Fills the rows of a column of temperatures that hold no number by straight lines between the rows
/// around, where they are few or short; otherwise the column is left out. Either is a warning.
void SettleHoles(const Column& time_s,
                 Column& temperature_degC,
                 bool may_bridge,
                 std::vector<std::string>& warnings);

/// Volts under one name in either of two units: none of a cell is below it in mV.
inline constexpr double kLeast_mV = 100.0;

/// " (times of the log: 0 to 10 s)", for a message that start_s and end_s leave no row.
[[nodiscard]] std::string TimesOfLog(double first_s, double last_s);

class Collector {
 public:
  Collector(const TextSource& source,
            const LogPlan& plan,
            const ReadOptions& options,
            TableReader& reader);

  /// LoadError where the time goes back.
  void Take(TableBlock& block);

  /// All that was taken. LoadError where nothing was.
  [[nodiscard]] Log Finish();

  /// The rows taken since the last call, of a collector that keeps no row longer; from its first
  /// call, before the first block, on.
  [[nodiscard]] Record HandOn();
  [[nodiscard]] std::vector<std::int8_t>& directions() { return directions_; }
  [[nodiscard]] bool unix_clock() const { return unix_start_s_ != 0.0; }

 private:
  [[nodiscard]] double Volt() const;
  double* Column(TableBlock& block, Quantity quantity) const;
  void ToSi(TableBlock& block, Quantity quantity) const;
  void Reserve(const TableBlock& block);
  bool Increases(TableBlock& block) const;
  void TakeAll(TableBlock& block);
  void TakeRowByRow(TableBlock& block);
  void Label(std::size_t row, double step, double cycle);
  double JoinedTime(std::size_t row, double clock_s, const double* step, const double* cycle);
  bool IsSelected(double t_s, double step, double cycle);
  [[noreturn]] void FailBackwards(std::size_t row, double fell_s) const;
  [[noreturn]] void FailUnselected() const;

  const TextSource& source_;
  const LogPlan& plan_;
  const ReadOptions& options_;
  TableReader& reader_;
  Log log_;
  std::vector<std::int8_t> directions_;
  double bytes_left_;
  Thinning thinning_;
  std::size_t rows_seen_ = 0;
  bool has_labels_ = false;
  bool clock_is_set_ = false;
  bool drops_temperature_ = false;
  bool hands_on_ = false;                                     // rows are not kept
  double last_s_ = -std::numeric_limits<double>::infinity();  // of the row taken last
  double unix_start_s_ = 0.0;
  std::size_t rows_joined_ = 0;
  std::pair<double, double> last_label_;
  double last_clock_s_ = 0.0;
  double last_joined_s_ = 0.0;
  double step_start_s_ = 0.0;
  std::set<double> steps_seen_;
  std::set<double> cycles_seen_;
  double first_seen_s_ = std::numeric_limits<double>::infinity();
  double last_seen_s_ = -std::numeric_limits<double>::infinity();
};

}  // namespace lipoid
