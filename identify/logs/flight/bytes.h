#pragma once

/// @file
/// Numbers within the bytes of a log, little-endian as both autopilots write them.
/// Tests: tests/identify/logs/flight/autopilot_log_test.cc.

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

namespace lipoid {

static_assert(std::endian::native == std::endian::little, "the logs are little-endian");

/// The number at an offset; a caller checks that the bytes are there.
template <class T>
[[nodiscard]] T NumberAt(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// The same as a double, for tables of types.
template <class T>
[[nodiscard]] double DoubleAt(std::string_view bytes, std::size_t offset) {
  return static_cast<double>(NumberAt<T>(bytes, offset));
}

/// A text of fixed width, up to its first zero byte.
[[nodiscard]] inline std::string TextAt(std::string_view bytes,
                                        std::size_t offset,
                                        std::size_t width) {
  const std::string_view field = bytes.substr(offset, width);
  return std::string(field.substr(0, field.find('\0')));
}

/// An IEEE 754 number of 16 bits.
[[nodiscard]] inline double HalfAt(std::string_view bytes, std::size_t offset) {
  const auto bits = NumberAt<std::uint16_t>(bytes, offset);
  const int exponent = (bits >> 10) & 0x1f;
  const int fraction = bits & 0x3ff;
  const double sign = bits & 0x8000 ? -1.0 : 1.0;
  if (exponent == 0x1f)
    return fraction ? std::numeric_limits<double>::quiet_NaN()
                    : sign * std::numeric_limits<double>::infinity();
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  return sign * std::ldexp(1024 + fraction, exponent - 25);
}

}  // namespace lipoid
