#pragma once

/// @file
/// Ranges and defaults of what several files, options and fits say of a cell, once.

#include "model/core/options.h"

namespace lipoid {

/// Diffusion modes, M in (4.46).
inline constexpr Range kModeNumbers{0.0, 1000.0};
inline constexpr int kUsualModes = 10;
/// Whether the modes beyond M count by their steady value; the thesis leaves them out.
inline constexpr bool kUsualTail = true;

/// Of beta: the slowest mode then takes three years. With less the tail alone passes any charge.
inline constexpr double kLeastBeta_per_sqrt_s = 1e-4;

/// Temperatures of a cell and of its surroundings.
inline constexpr Range kTemperatures_degC{-60.0, 150.0};
/// Of the air that something flies in: 77 is degF.
inline constexpr Range kAirTemperatures_degC{-60.0, 60.0};
/// Of a resistance, or of a rate.
inline constexpr Range kActivationEnergies_J_per_mol{0.0, 2e5};

/// The size of any number of a cell file in its unit, far beyond any cell: what is computed from
/// several of them stays finite.
inline constexpr double kMostOfACell = 1e12;
/// Of an open-circuit voltage, of a module that is taken for a cell.
inline constexpr double kMostOpenCircuit_V = 1e3;
/// Of a capacitance, a time constant over a resistance that may be next to nothing.
inline constexpr double kMostCapacitance_F = 1e30;

/// Cells in series or in parallel.
inline constexpr Range kPackSizes{1.0, 100000.0};

/// State of charge of the first row. It may pass 0 and 1: alpha of a cell file that was fitted to
/// other logs may be smaller than the charge that this cell holds.
inline constexpr Range kInitialSocs{-0.5, 1.5};

}  // namespace lipoid
