#pragma once

/// @file
/// What a column can hold and in which units. A unit is found by its usual names, without regard to
/// case. Tests: tests/identify/logs/log_test.cc.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lipoid {

/// A column that a record is made of, or that says which row is which.
enum class Quantity { kTime, kCurrent, kVoltage, kTemperature, kStep, kCycle, kState };
inline constexpr std::size_t kQuantityCount = static_cast<std::size_t>(Quantity::kState) + 1;
/// Those that have units.
inline constexpr Quantity kMeasured[] = {
    Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage, Quantity::kTemperature};

/// "time", "current", ...
[[nodiscard]] std::string_view Name(Quantity quantity);
/// What the user may write: "time_s", "current_A", "voltage_V", "temperature_degC"; "" for the
/// others.
[[nodiscard]] std::string_view Key(Quantity quantity);

/// value in SI = value * multiply / divide + offset. Two factors, because dividing by 1000 is exact
/// where multiplying by 0.001 is not.
struct Unit {
  double multiply = 1.0;
  double divide = 1.0;
  double offset = 0.0;
  bool is_duration = false;  ///< hours:minutes:seconds

  [[nodiscard]] double ToSi(double value) const { return value * multiply / divide + offset; }
  [[nodiscard]] bool IsSi() const { return multiply == 1.0 && divide == 1.0 && offset == 0.0; }
  [[nodiscard]] bool SameScale(const Unit& other) const {
    return multiply == other.multiply && divide == other.divide && offset == other.offset;
  }
};

[[nodiscard]] std::optional<Unit> FindUnit(Quantity quantity, std::string_view name);

/// "s, ms, min, h", for messages.
[[nodiscard]] std::string_view UsualUnits(Quantity quantity);

}  // namespace lipoid
