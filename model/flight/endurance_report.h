#pragma once

/// @file
/// An endurance as JSON: `lipoid endurance --summary` (docs/formats.md). Tests:
/// tests/tools/endurance_test.cc.

#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "model/core/json.h"
#include "model/flight/endurance_request.h"

namespace lipoid {

/// A number of a flight that has an interval, in the unit of its key.
struct EnduranceNumber {
  std::string_view key;
  std::string_view what;  ///< for people
  double (*of)(const EnduranceResult&);
};

[[nodiscard]] std::span<const EnduranceNumber> EnduranceNumbers();

/// Where 95 % of the flights drawn lie; none where nothing was drawn, or the number is unknown.
[[nodiscard]] std::optional<std::pair<double, double>> IntervalOf(const EnduranceAnswer& answer,
                                                                  const EnduranceNumber& number);

/// The numbers alone, each with its interval, and why it ended: a row of a table.
[[nodiscard]] Json EnduranceNumbersToJson(const EnduranceAnswer& answer);

/// minutes, minutes_interval_95, charge_Ah, ...; ended_by, initial, ensemble.
[[nodiscard]] Json EnduranceToJson(const EnduranceRequest& request, const EnduranceAnswer& answer);

}  // namespace lipoid
