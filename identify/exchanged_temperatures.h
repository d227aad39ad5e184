#pragma once

/// @file
/// Logs whose temperatures stand for one another: a cell has more resistance in the cold. Tests:
/// tests/identify/exchanged_temperatures_test.cc.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/validation.h"

namespace lipoid {

/// In a sentence, of two logs of a cell the one that is colder by 8 K and more and shows clearly less resistance at every
/// state of charge and time that both show; "" of none. `errors` are those of these logs, by name.
[[nodiscard]] std::string DoubtAboutExchangedTemperatures(const std::vector<LogErrors>& errors,
                                                          const std::vector<LoadedLog>& logs);

}  // namespace lipoid
