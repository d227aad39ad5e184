#pragma once

/// @file
/// A prediction whose state of charge goes where no curve was measured, or where no cell can go. Tests:
/// tests/python/test_cell.py.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>

#include "model/battery/open_circuit_voltage.h"
#include "model/core/counted.h"

namespace lipoid {

/// How far the state of charge of a prediction goes.
class PredictedSoc {
 public:
  /// The next row of one current.
  void Row(const OpenCircuitVoltage& curve, double soc) {
    if (rows_++ == 0) full_ = std::max(1.0, soc);
    if (!curve.InRange(soc)) ++outside_;
    if (soc > full_ + kMore) overfull_ = std::max(overfull_, soc);
  }
  /// What another current reached.
  void Append(const PredictedSoc& other) {
    outside_ += other.outside_;
    overfull_ = std::max(overfull_, other.overfull_);
  }

  /// Rows outside of v_oc(A).
  [[nodiscard]] std::size_t outside() const { return outside_; }
  /// Whether a current charges a cell to more than any holds, and the most to which.
  [[nodiscard]] bool is_overfull() const { return overfull_ > 0.0; }
  [[nodiscard]] double overfull() const { return overfull_; }

  /// One sentence; empty where all rows lie on the curve.
  [[nodiscard]] std::string DoubtAboutCurve() const {
    if (outside_ == 0) return "";
    return fmt::format(
        "{} outside the soc that v_oc(A) was made for: it goes on with its end slope there",
        Counted(outside_, "row"));
  }

 private:
  static constexpr double kMore = 0.1;  // than full, or than the cell began with

  std::size_t rows_ = 0;
  std::size_t outside_ = 0;
  double full_ = 1.0;
  double overfull_ = -std::numeric_limits<double>::infinity();
};

}  // namespace lipoid
