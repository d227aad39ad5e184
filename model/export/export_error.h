#pragma once

/// @file
/// How far a target's law is from the cell over a mission: what every export states. Both are
/// looked at in the rows of the mission, each row once. Tests:
/// tests/model/export/export_error_test.cc.

#include <span>
#include <vector>

#include "model/battery/prediction.h"
#include "model/export/exported.h"

namespace lipoid {

/// The cell itself over a mission.
[[nodiscard]] Prediction ReferenceOf(const Cell& cell, const ExportMission& mission);
/// The cell of a request with all that it knows.
[[nodiscard]] Prediction ReferenceOf(const ExportRequest& request);

/// One voltage of the pack for each row. A voltage that is not finite makes the error NaN.
[[nodiscard]] ExportError VoltageError(const Prediction& cell,
                                       const ExportMission& mission,
                                       std::span<const double> voltage_V);

/// One state of charge for each row, a fraction.
[[nodiscard]] ExportChargeError ChargeError(const Prediction& cell,
                                            const ExportMission& mission,
                                            std::span<const double> soc);

/// The charge in Ah that has left the pack at each row since it was full, initial_soc included:
/// what a target knows that counts charge alone.
[[nodiscard]] std::vector<double> ChargeDrawn_Ah(const Cell& cell, const ExportMission& mission);

/// The numbers of a cell that a user would type into another program: its nominal capacity, the
/// ends of its voltage, its series resistance when full. Of one cell.
struct NaiveNumbers {
  double full_V = 0.0;
  double empty_V = 0.0;
  double capacity_Ah = 0.0;
  double resistance_Ohm = 0.0;
};

[[nodiscard]] NaiveNumbers NaiveNumbersOf(const Cell& cell);

/// alpha in Ah, of one cell: what it delivers from full to empty at vanishing rate.
[[nodiscard]] double UsableCapacity_Ah(const Cell& cell);

}  // namespace lipoid
