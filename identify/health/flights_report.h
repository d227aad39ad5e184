#pragma once

/// @file
/// What flights do to what the lab logs say of a cell, in its report. Keys: docs/flight-logs.md. Tests:
/// tests/identify/health/flights_report_test.cc.

#include <string>

#include "identify/health/flights_with_lab.h"
#include "identify/trust/trust.h"
#include "model/core/json.h"

namespace lipoid {

/// The quantities and the pulse resistances of a report on the lab's cell become those of the lab logs and the
/// flights together: each moves, and loses of its variance, what the flights say of it to first order. What a cell
/// does not have by that name stays.
void MoveTrust(const Cell& by_lab, const FlightsWithLab& flights, TrustReport& trust);

/// A quantity of a report by its name: a parameter of the cell, r_s(0.5) of a table at a state of charge, or r_total(0.5).
/// None where the cell has no such.
[[nodiscard]] std::optional<double> CellQuantity(const Cell& cell, const std::string& name);

[[nodiscard]] Json FlightsWithLabToJson(const FlightsWithLab& found);

/// A few lines: whether the flights were taken, what they add and what they cost.
[[nodiscard]] std::string FlightsWithLabText(const FlightsWithLab& found);

}  // namespace lipoid
