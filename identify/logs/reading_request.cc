#include "identify/logs/reading_request.h"

#include <fmt/ranges.h>

#include <limits>

#include "model/core/errors.h"

namespace lipoid {

ReadOptions ReadingRequest::Resolve() const {
  ReadOptions read;
  read.hold = hold;
  read.columns = columns;
  if (!units.empty() && units.size() != 3) {
    throw OptionError(fmt::format(
        "option --units: expected three, of time, current and voltage (s,A,V), found '{}'",
        fmt::join(units, ",")));
  }
  read.units = units;
  if (!current_sign.empty() && current_sign != "auto" && current_sign != "discharge-positive" &&
      current_sign != "discharge-negative") {
    throw OptionError(
        fmt::format("option --current-sign: expected auto, discharge-positive or "
                    "discharge-negative, found '{}'",
                    current_sign));
  }
  read.current_sign = current_sign;
  read.battery = battery.value_or(0);
  read.most_rows =
      most_rows ? static_cast<std::size_t>(*most_rows) : std::numeric_limits<std::size_t>::max();
  return read;
}

}  // namespace lipoid
