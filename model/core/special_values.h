#pragma once

#include <limits>

namespace lipoid {

// No bound, no end; and what is not known.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace lipoid
