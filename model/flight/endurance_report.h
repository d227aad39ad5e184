#pragma once

/// @file
/// An endurance as JSON: `lipoid endurance --summary` (docs/formats.md). Tests:
/// tests/tools/endurance_test.cc.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// What the numbers mean: why the flight ended, and which speeds the vehicle has. Of a pack that
/// cannot carry the mission the first sentence says so.
[[nodiscard]] std::vector<std::string> EnduranceSentences(const EnduranceRequest& request,
                                                          const EnduranceAnswer& answer);

/// What the numbers rest on that a reader should know, a sentence each: a pack that the vehicle is
/// not made for, no or few intervals, cells moved, an open-circuit voltage that is assumed.
[[nodiscard]] std::vector<std::string> EnduranceDoubts(const EnduranceRequest& request,
                                                       const EnduranceAnswer& answer);

/// minutes, minutes_interval_95, charge_Ah, ...; ended_by, initial, ensemble; its sentences and,
/// as messages, its doubts.
[[nodiscard]] Json EnduranceToJson(const EnduranceRequest& request, const EnduranceAnswer& answer);

}  // namespace lipoid
