#pragma once

/// @file
/// The health of a pack as JSON and as a sentence. Keys: docs/flight-logs.md. Tests:
/// tests/identify/health/health_report_test.cc, tests/tools/health_test.cc.

#include <string>
#include <vector>

#include "identify/health/flights_alone.h"
#include "identify/health/health.h"
#include "model/core/json.h"

namespace lipoid {

[[nodiscard]] Json HealthToJson(const HealthReport& report);

/// The keys of `lipoid identify --summary` of flights alone.
[[nodiscard]] Json FlightsAloneToJson(const FlightsAlone& found);

/// Why the flight's numbers are in doubt: it makes no sense against the reference, or the search did not
/// converge; "" where they are not.
[[nodiscard]] std::string DoubtAbout(const FlightHealth& flight);
/// Whether those of any flight are: exit code 1.
[[nodiscard]] bool IsDoubted(const HealthReport& report);

/// "capacity 1.21 Ah (81 % of new), 95 % from 1.15 to 1.27 Ah; resistance ...", of one flight.
[[nodiscard]] std::string HealthSentence(const HealthReport& report, const FlightHealth& flight);

/// What is to be read first: which flights are in doubt, the trend, and what the last flight says.
[[nodiscard]] std::vector<std::string> FirstLines(const HealthReport& report);

/// "flight.bin: why", of each that was refused.
[[nodiscard]] std::vector<std::string> FilesWithReasons(const std::vector<Diagnostic>& refused);

/// "The resistance is that at 25 degC, by ...", where the temperature of a flight is known; else "".
[[nodiscard]] std::string TemperatureSentence(const HealthReport& report);

/// "capacity fell by 30 % over 60 flights, 95 % from 28 to 32 %"; "" where there is no trend.
[[nodiscard]] std::string TrendSentence(const HealthReport& report);

}  // namespace lipoid
