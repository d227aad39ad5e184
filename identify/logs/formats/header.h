#pragma once

/// @file
/// What a header line says: the name of each column and its unit, however the two are written
/// together.
///
///   time_s   Test Time (s)   U[V]   Voltage / V   Ecell/V   Current#A   test_time_second   Amps
///
/// Tests: tests/identify/logs/log_test.cc.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/formats/layout.h"
#include "model/core/text_cells.h"

namespace lipoid {

struct HeaderName {
  std::string text = {};  ///< as written
  std::size_t column = 1;
  std::string whole = {};  ///< lower case, blanks as '_'
  std::string name = {};   ///< whole without what stands in brackets, after '/' or after '#'
  std::string unit = {};   ///< that, in lower case
  std::string stem =
      {};  ///< name without its last word, where that may be a unit: test_time of test_time_second
  std::string suffix = {};  ///< that word
};

/// The wide brackets of Chinese headers as the usual ones, the one character for degrees Celsius or Fahrenheit as C or
/// F, a micro sign or mu, of UTF-8 or Latin-1, as u.
[[nodiscard]] std::string Narrow(std::string_view text);

[[nodiscard]] HeaderName ParseHeaderName(const TextCell& cell);

/// Place of a name among alternatives, "a|b"; npos where it is none of them, or "".
[[nodiscard]] std::size_t RankIn(std::string_view alternatives, std::string_view name);

/// One column that goes by one of the names of a quantity.
struct HeaderMatch {
  std::size_t field = 0;
  std::size_t rank = 0;        ///< place of its name in the list
  std::string unit = {};       ///< as written, lower case; "" where the header states none
  bool unit_is_wrong = false;  ///< the header states something that is no unit of this quantity
};

/// All columns that match. Wrong units only where nothing matches with a right one.
[[nodiscard]] std::vector<HeaderMatch> FindColumns(std::span<const HeaderName> header,
                                                   Quantity quantity,
                                                   const ColumnNames& names);

/// Every entry ("a|b": any of these; "": nothing) names a column of the header, with or without its
/// unit.
[[nodiscard]] bool Matches(std::span<const HeaderName> header,
                           std::span<const std::string_view> signature);

}  // namespace lipoid
