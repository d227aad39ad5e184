#pragma once

/// @file
/// From the errors of a fit to what cells are drawn from.
/// Tests: tests/identify/trust/cell_uncertainty_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/trust/trust.h"
#include "model/battery/cell.h"

namespace lipoid {

/// The parameters of a cell among the quantities, for TrustOptions::drawn: all but capacitances,
/// which follow from the others, and values of tables.
[[nodiscard]] std::vector<NamedCombination> CellParametersAmong(
    const std::vector<TrustedQuantity>& quantities);

/// The degrees of freedom in the middle of the quantities whose error is known, alpha of a few
/// discharge times not counted; 0 where there are none.
[[nodiscard]] double MiddleFreedom(const TrustReport& trust);

struct CellUncertainty {
  std::optional<Cell::Uncertainty> found;  ///< none where nothing varies
  /// Quantities of infinite standard error: cells drawn vary only in what is known of them.
  std::vector<std::string> unknown;
};

/// The covariance of what was to be drawn, with the degrees of freedom that the quantities have in
/// the middle. A quantity `alpha` that is not among what was drawn has an error of its own, which
/// is scaled so that its interval stays. What does not vary is left out, but for tau_j beside a
/// constant r_j, without which the cell would keep the capacitance.
[[nodiscard]] CellUncertainty UncertaintyOf(const TrustReport& trust,
                                            const Cell& cell,
                                            bool soc_follows_alpha);

/// Two parameters more, which vary with no other: heat capacity and thermal resistance follow from
/// measured temperatures, and not from voltages. Nothing where an error is not finite, or where
/// nothing else varies.
void AddPair(Cell::Uncertainty& to,
             const std::string& first,
             const std::string& second,
             double first_variance,
             double second_variance,
             double covariance);

}  // namespace lipoid
