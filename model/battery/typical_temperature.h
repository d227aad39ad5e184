#pragma once

/// @file
/// What temperature does to a lithium-ion or lithium-polymer cell of which nothing is known but its
/// capacity: for a first answer to what the cold costs, marked as assumed.
///
/// Energies are rounded from what lipoid identifies of panasonic_18650pf between -20 and 25 degC
/// (docs/joint.md, 8); a series resistance that holds the charge transfer too has that of its edge
/// resistance, 21, 41 and 89 milliohm at 25, 0 and -20 degC. The heat capacity is 1000 J/(kg K), of 18650 cells (H. Maleki et al., J.
/// Electrochem. Soc. 146 (1999) 947), times a mass by 150 Wh/kg at 3.7 V. The thermal resistance is
/// that of a prism of 2000 kg/m³ and a surface of 9 times the two-thirds power of its volume, to
/// air by 15 W/(m² K): a pack in slow air. Tests: tests/model/battery/temperature_test.cc.

#include <string>

#include "model/battery/cell.h"

namespace lipoid {

/// What is measured of the open-circuit voltage of whole cells lies within, -0.6 to 0.6 mV/K.
inline constexpr double kMostEntropy_V_per_K = 0.6e-3;

/// Of one cell.
[[nodiscard]] HeatBalance<double> TypicalHeat(double capacity_Ah, double size_factor = 1.0);

/// The cell with typical temperature dependence about the temperature of its logs, 25 degC where that is not
/// known, marked as assumed. Self-heating, which is another law for the same, goes. The cell knows no temperature yet. A cell that flies
/// `size_factor` times as large (aged_cell.h) gets the heat that is typical of its own size.
[[nodiscard]] Cell WithTypicalTemperature(Cell cell, double size_factor = 1.0);

/// What that assumes of this cell, to be read after its name; empty where it knows temperature.
[[nodiscard]] std::string TypicalTemperatureText(const Cell& cell, double size_factor = 1.0);

}  // namespace lipoid
