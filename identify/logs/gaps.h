#pragma once

/// @file
/// Stretches of time without rows in which a current may have flowed: the charge that left in them
/// is not known. Tests: tests/identify/logs/gaps_test.cc.

#include <string>
#include <vector>

#include "identify/logs/log.h"

namespace lipoid {

/// The charge that is not known may be this part of the capacity; more makes the state of charge
/// after the gap a guess.
inline constexpr double kMostUnknownCharge = 2e-3;

/// Intervals longer than ten times the usual one on either side, or by an hour than those around, which are all
/// alike (a clock that was put forward), with a load at one end or both.
///
/// Between two rows at rest it is one where the voltage moves against the relaxation from the last load by
/// more than half a per cent and than noise, and the largest current may have flowed in it.
///
/// None of these is a gap: any other long interval between two rows at rest; the change of a logger to
/// another rate at a new step, where the interval fits one of its sides; and, in a log that keeps a
/// row when something changes, a long interval over which nothing changed. Rows without a voltage
/// count too.
[[nodiscard]] std::vector<Gap> FindGaps(const Record& record);

/// Recharges that no row shows, as between two tests that stand in one file: within a rest, of three rows on either
/// side, the voltage jumps by 2.5 % from one row to the next, to where it rested (within 1.2 %) before a tenth of
/// the charge that the record moves had left. Discharge is positive. None without voltages.
[[nodiscard]] std::vector<Gap> FindUnseenRecharges(const Record& record);

/// "a gap of 30 s after 100 s, in which up to 0.0167 Ah may have flowed"; of several the one with the
/// most charge, and the charge of all. At least one.
[[nodiscard]] std::string GapsText(const std::vector<Gap>& gaps);
/// What may have made the largest of them, in brackets; "" where nothing is likely.
[[nodiscard]] std::string GapsHint(const std::vector<Gap>& gaps);

/// LoadError where the gaps of a record may hold more than this share of
/// capacity_Ah, that of all cells in parallel (0: of the charge that the record moves). It says which part can be read instead.
void RefuseUnknownCharge(const Record& record,
                         const std::vector<Gap>& gaps,
                         double capacity_Ah,
                         double most_share = kMostUnknownCharge);

}  // namespace lipoid
