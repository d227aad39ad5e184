#include "model/core/significant_digits.h"

#include <fmt/format.h>

#include <charconv>

namespace lipoid {

double RoundToDigits(double x, int digits) {
  const auto text = fmt::format("{:.{}e}", x, digits - 1);
  std::from_chars(text.data(), text.data() + text.size(), x);
  return x;
}

}  // namespace lipoid
