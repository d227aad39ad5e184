#pragma once

namespace lipoid {

// What a clock that adds up steps is off by.
inline constexpr double kRounding_s = 1e-9;

// A battery is empty when its voltage was below cut-off, or its power too little, this long without a break.
inline constexpr double kEmptyAfter_s = 1.0;
inline bool EmptyAfter(double lasted_s) { return lasted_s >= kEmptyAfter_s - kRounding_s; }

}  // namespace lipoid
