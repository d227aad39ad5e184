#include "identify/health/refuse_flight.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/logs/flight/flight_log.h"
#include "model/core/errors.h"

namespace lipoid {

void RefuseIdleFlight(const Record& record, double capacity_Ah) {
  constexpr double kShortest_s = 20.0;
  constexpr double kLeastCharge = 0.01;  // of the capacity
  constexpr double kLeastRate_per_h = 0.5;
  const SourcePosition position{record.file};
  if (record.voltage_V.empty() || record.size() < 2)
    throw LoadError(position,
                    "expected a flight with voltage and current, found less than two rows");
  const double length_s = record.time_s.back() - record.time_s.front();
  if (length_s < kShortest_s) {
    throw LoadError(
        position,
        fmt::format("expected a flight of at least {:g} s, found {:.3g} s: too short to "
                    "say anything of the pack",
                    kShortest_s,
                    length_s));
  }
  double largest_A = 0.0;
  for (const double i : record.current_A) largest_A = std::max(largest_A, i);
  const double charge_Ah = DeliveredCharge(record).back() / 3600.0;
  if (largest_A < kLeastRate_per_h * capacity_Ah || charge_Ah < kLeastCharge * capacity_Ah) {
    throw LoadError(
        position,
        fmt::format(
            "expected a flight that takes at least {:.3g} A and {:.3g} Ah from this pack of "
            "{:.3g} Ah, found {:.3g} A at most and {:.3g} Ah: too idle to say anything of "
            "the pack",
            kLeastRate_per_h * capacity_Ah,
            kLeastCharge * capacity_Ah,
            capacity_Ah,
            largest_A,
            charge_Ah));
  }
  RefuseFlatVoltage(position, record);
  const double rows_s = length_s / static_cast<double>(record.size());
  constexpr double kSlowest_s = 5.0;
  if (rows_s > kSlowest_s) {
    throw LoadError(
        position,
        fmt::format("expected rows at most {:g} s apart, found one each {:.3g} s: loads "
                    "of a flight change faster",
                    kSlowest_s,
                    rows_s));
  }
}

}  // namespace lipoid
