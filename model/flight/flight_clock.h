#pragma once

namespace lipoid {

// What a clock that adds up steps is off by.
inline constexpr double kRounding_s = 1e-9;

// A battery whose voltage was below cut-off this long without a break is empty.
inline constexpr double kEmptyAfter_s = 1.0;
inline bool EmptyAfter(double below_cutoff_s) {
  return below_cutoff_s >= kEmptyAfter_s - kRounding_s;
}

}  // namespace lipoid
