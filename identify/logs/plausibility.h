#pragma once

/// @file
/// Values that cannot be: a unit that was mislabelled or left out shows as a factor of 60, 1000 or
/// 3600. Tests: tests/identify/logs/plausibility_test.cc.

#include <span>
#include <string>
#include <string_view>

#include "identify/logs/columns.h"
#include "identify/logs/record.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/core/errors.h"

namespace lipoid {

/// No pack has more; what was meant has a factor of 1000 less.
inline constexpr double kMostPack_V = 2000.0;

/// Why the temperature of the first row is none of a cell before a test, in one sentence: no test and no flight begins
/// above 60 degC. "" where it may be.
[[nodiscard]] std::string DoubtAboutHotStart(const Record& record);
/// "if these are degrees Fahrenheit (25 degC), say degF in the header".
[[nodiscard]] std::string InFahrenheit(double shown_degC);

/// One cell, from a half cell at rest to a lithium cell under fast charge.
inline constexpr double kMostCell_V = 6.0;

/// No lithium cell is empty above it, whatever its chemistry: LFP, LTO and cells for storage are at less.
inline constexpr double kHighestCutoff_V = 3.5;

/// How many lithium cells in series have this voltage at most, in V: those nearest to 4.2 V each, never above 4.38 V.
[[nodiscard]] int CellsInSeries(double highest_V);
/// The same, or "7 or 8" where one cell more would begin at 3.6 V or above, or one less at 4.38 V or below, and the
/// cells are not full by the one number alone.
[[nodiscard]] std::string CellsInSeriesInWords(double highest_V);

/// Where the columns of a record are named in its file.
struct ColumnPositions {
  SourcePosition time;
  SourcePosition current;
  SourcePosition voltage;
  /// What a person does about a wrong unit.
  std::string_view remedy = "Say so in the header or with `units`";
  /// Each voltage may be one with a mark for thousands: 4.180.
  bool voltage_in_thousands = false;
  /// A person or the format said which is the current and which the voltage: they are not exchanged.
  bool known = false;
};

/// For a record of a cell or of a pack of any size, as ReadLog() returns it. LoadError with advice;
/// returns what makes its currents doubtful, in one sentence: more than 1000 A, which may be mA under
/// a header without a unit. "" where nothing does.
[[nodiscard]] std::string CheckReadable(const Record& record, const ColumnPositions& positions);

/// LoadError for a current alone, which a simulation takes and which says nothing about a cell.
void RefuseWithoutVoltage(const Record& record);

/// What makes the times of a record doubtful, in one sentence; "" where nothing does: rows 1/60 s or
/// 1/3600 s apart, which are whole seconds of a clock in minutes or hours.
[[nodiscard]] std::string DoubtAboutTime(const Record& record);

/// What makes the rows of a record doubtful, in one sentence; "" where nothing does: at nine in ten of its steps
/// of the current, five or more, the voltage moves one row later, or has moved one row before, as where a logger
/// reads one of the two a row late.
[[nodiscard]] std::string DoubtAboutLag(const Record& record);
/// Whether it is the current that is read late: rows that seem at rest are then under load.
[[nodiscard]] bool ReadsCurrentLate(const Record& record);

/// What is wrong with temperatures of these times, half a sentence; "" where each of them may be that
/// of a cell.
[[nodiscard]] std::string ImpossibleTemperature(std::span<const double> time_s,
                                                std::span<const double> temperature_degC);

/// For a record of one cell, after DivideByPack() by that pack. capacity_Ah is the cell's nominal
/// one, 0 where it is not known. Returns the charge that the record moves, none where the capacity is
/// not known. LoadError with advice.
ChargeMoved CheckPlausible(const Record& record,
                           double capacity_Ah,
                           int series = 1,
                           int parallel = 1);

/// In a sentence, that a cut-off is that of no empty cell; "" where it may be.
[[nodiscard]] std::string DoubtAboutCutoff(double cutoff_V);

/// For the same record and the v_oc(A) of its cell: how many cells in series it is of, which are fewer than `series` where
/// every row is far below the empty cell.
[[nodiscard]] int LoggedSeries(const Record& record, const OpenCircuitVoltage& curve, int series);

/// The same as a check: LoadError where every row is so far below the
/// empty cell that the log is one of fewer cells in series than that.
void CheckSeries(const Record& record, const OpenCircuitVoltage& curve, int series);

}  // namespace lipoid
