#pragma once

/// @file
/// The numbers that loggers print, 12.345 and -7, sixteen bytes at a time.
///
/// One comparison of sixteen bytes tells where the decimal mark and the end are, before any digit
/// is read: the next number need not wait for this one. With up to eight digits before and after
/// the mark and fifteen in all, the digits as one whole number and the power of ten are exact
/// doubles, and their quotient is the nearest double (Clinger): the same bits as any correct
/// reader. Whatever looks otherwise, and every machine without SSE2, is left to one. Tests:
/// tests/identify/logs/csv/plain_decimal_test.cc.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace lipoid {

/// Bytes that must be readable from where a number starts.
inline constexpr std::ptrdiff_t kPlainDecimalReach = 32;

#if defined(__SSE2__)

namespace plain_decimal_internal {

// One to eight digits: leading zeros instead of what follows them, then pairs, fours and eights.
inline std::uint64_t Whole(const char* at, int digits) {
  std::uint64_t v;
  std::memcpy(&v, at, sizeof v);
  v = (v ^ 0x3030303030303030) << (64 - 8 * digits);
  v = v * 10 + (v >> 8);
  return ((v & 0x000000FF000000FF) * 0x000F424000000064 +
          ((v >> 16) & 0x000000FF000000FF) * 0x0000271000000001) >>
         32;
}

}  // namespace plain_decimal_internal

/// Where the number at `at` ends, or null where it is no plain one; kPlainDecimalReach bytes must
/// be readable. What follows it is for the caller to judge: an exponent may.
inline const char* ReadPlainDecimal(const char* at, char mark, double& value) {
  static constexpr std::array<std::uint64_t, 9> kPowers = {
      1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
  static constexpr int kMostDigits = 15;
  static constexpr int kMostOfPart = 8;
  using plain_decimal_internal::Whole;
  const bool negative = *at == '-';
  if (negative) ++at;
  const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));
  // Moved so that '0' is the lowest signed byte, digits are the ten lowest.
  const __m128i moved = _mm_add_epi8(bytes, _mm_set1_epi8(static_cast<char>(0x80 - '0')));
  const __m128i other = _mm_cmpgt_epi8(moved, _mm_set1_epi8(static_cast<char>(0x80 + 9)));
  const auto others = static_cast<std::uint32_t>(_mm_movemask_epi8(other)) | 0x10000U;
  const int whole = std::countr_zero(others);
  if (whole == 0 || whole > kMostOfPart) return nullptr;
  std::uint64_t digits = Whole(at, whole);
  double magnitude = static_cast<double>(digits);
  int end = whole;
  if (at[whole] == mark) {
    end = std::countr_zero(others & (others - 1));  // 32 where the number goes on
    const int fraction = end - whole - 1;
    if (fraction == 0 || fraction > kMostOfPart || end > kMostDigits) return nullptr;
    const std::uint64_t power = kPowers[static_cast<std::size_t>(fraction)];
    digits = digits * power + Whole(at + whole + 1, fraction);
    magnitude = static_cast<double>(static_cast<std::int64_t>(digits)) /
                static_cast<double>(static_cast<std::int64_t>(power));
  }
  value = negative ? -magnitude : magnitude;
  return at + end;
}

#else

inline const char* ReadPlainDecimal(const char*, char, double&) { return nullptr; }

#endif

}  // namespace lipoid
