#pragma once

/// @file
/// What the page of `lipoid identify` draws beside the summary. Tests:
/// tests/tools/pages/identify_test.py.

#include <cstddef>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/cell.h"
#include "tools/report/report.h"

namespace lipoid {

/// Of one campaign, the n-th of a summary with `cells`, of `campaigns` that share the page:
///
///   log          each log in the order of the campaign: measured, predicted_V by the cell and,
///                where there is one, staged_V by the staged cell
///   low-rate     rows of each low-rate log: soc, voltage_V as measured, and open_circuit_V, the
///                same with the drops that the cell predicts taken away
///   rests        the same of the last row of each rest of the other logs
///   staged-curve v_oc(A) of the staged cell, where there is one: soc, voltage_V
[[nodiscard]] std::vector<Series> IdentifySeries(const Cell& found,
                                                 const Cell* staged,
                                                 const std::vector<LoadedLog>& logs,
                                                 std::size_t n,
                                                 std::size_t campaigns);

}  // namespace lipoid
