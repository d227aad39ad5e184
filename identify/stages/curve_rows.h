#pragma once

/// @file
/// What a curve v_oc(A) is fitted to: rows under load, and which of them a fit is shown.
/// Tests: tests/identify/stages/open_circuit_voltage_fit_test.cc.

#include <cstddef>
#include <span>

namespace lipoid {

/// Rows under load, in the order of time, and the range that the curve is to span.
struct CurveRows {
  std::span<const double> soc;
  std::span<const double> voltage_V;
  double lo = 0.0;
  double hi = 1.0;

  [[nodiscard]] std::size_t size() const { return soc.size(); }
};

/// The rows that a fit is shown: all, or all but every n-th.
struct Share {
  int every = 0;  ///< 0: all rows are shown

  // The held-out rows.
  [[nodiscard]] std::size_t first() const { return static_cast<std::size_t>(every / 2); }
  [[nodiscard]] std::size_t step() const { return static_cast<std::size_t>(every); }

  [[nodiscard]] bool Has(std::size_t row) const { return every == 0 || row % step() != first(); }
};

}  // namespace lipoid
