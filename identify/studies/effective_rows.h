#pragma once

/// @file
/// How many independent rows correlated residuals are worth.
///
///   N_e = N / tau,   tau = 1 + 2 sum_k rho(k)
///
/// with rho the autocorrelation at a lag of k rows. The sum ends by the initial positive sequence:
/// pairs rho(2m) + rho(2m+1), which are positive for a reversible process, are added until one is
/// not; what follows is noise (C. J. Geyer, Statistical Science 7 (1992) 473, section 3.3). Long
/// series are first averaged over equal blocks, which leaves the variance of their mean, and with
/// it N_e, as it is. Tests: tests/identify/studies/effective_rows_test.cc.

#include <vector>

namespace lipoid {

/// Of the residuals of one or several logs, each correlated only with itself. At least 1, at most
/// the number of rows.
[[nodiscard]] double EffectiveRows(const std::vector<std::vector<double>>& residuals);

}  // namespace lipoid
