#pragma once

/// @file
/// A log of more rows than memory should hold, said in fewer rows while it is read.
///
/// Where nothing happens neighbouring rows become one row, as a slower logger would have written it:
/// its time, voltage and temperature are those of one of them, and its current is their mean over
/// the time for which it flowed, so that the charge between two rows that are left stays as it was. For
/// backward hold that is the last of the rows, for forward hold the first.
///
/// Rows at which something happens stay as they are, with kBeside rows on either side: the current
/// steps by more than tolerance_A, the voltage jumps, the time between rows grows tenfold, or the
/// cycler says another step, cycle or state. A row stands for less time than kShareOfAge of the time
/// since the current last stepped, and for fewer rows than a quarter of those to the next row at
/// which something happens: rows grow apart gradually, and no gap appears that the log does not have.
///
/// tolerance_A is six deviations of the current's noise, or a thousandth of its largest amount. Where
/// that leaves too many rows it doubles, and kShareOfAge with it, until they are few enough.
/// Tests: tests/identify/logs/thinning_test.cc.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/log.h"

namespace lipoid {

/// Takes the rows of a log as they come, and keeps them few.
class Thinning {
 public:
  /// Rows on either side of what happens that stay as they are: more than gaps.h and spikes.h look at.
  static constexpr std::size_t kBeside = 8;
  /// Of the time since the current stepped that one row may stand for.
  static constexpr double kShareOfAge = 1.0 / 64.0;

  /// The rows that were taken; `directions` and `labels` are theirs, or empty. One volt is `volt` in the
  /// units of the record.
  struct Rows {
    Record& record;
    std::vector<std::int8_t>& directions;
    std::vector<RowLabel>& labels;
    double volt = 1.0;
  };

  /// `most_rows` are kept as they are; more become at most half as many.
  Thinning(Hold hold, std::size_t most_rows) : hold_(hold), most_rows_(most_rows) {}

  /// Makes room for so many rows more.
  void MakeRoom(std::size_t more, Rows rows);
  /// After the last row: what is reported, none where every row was kept.
  [[nodiscard]] std::optional<ThinningFacts> Finish(Rows rows);

 private:
  void Begin(const Record& record);
  void Count(const Record& record);
  void ThinTail(Rows rows);
  void Regroup(Rows rows);

  Hold hold_;
  std::size_t most_rows_;
  std::size_t group_ = 1;    // rows of the log that one row may stand for
  std::size_t thinned_ = 0;  // rows of the record that are thinned
  std::size_t dropped_ = 0;  // rows of the log that are not in the record
  double tolerance_A_ = 0.0;
  double share_of_age_ = kShareOfAge;
  double changed_s_ = 0.0;  // when the current last stepped before the rows that are not thinned
  ThinningFacts report_;
};

/// "100000000 rows, more than 16777216 that are kept as they are, were thinned to ...".
[[nodiscard]] std::string ThinningText(const ThinningFacts& thinned);

}  // namespace lipoid
