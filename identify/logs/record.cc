#include "identify/logs/record.h"

#include "model/core/errors.h"

namespace lipoid {

bool HoldTheSameRows(const Record& one, const Record& other) {
  return one.time_s == other.time_s && one.voltage_V == other.voltage_V &&
         one.current_A == other.current_A;
}

void DivideByPack(Record& record, int series, int parallel) {
  Require(series >= 1 && parallel >= 1,
          "series >= 1 and parallel >= 1",
          {{"series", static_cast<double>(series)}, {"parallel", static_cast<double>(parallel)}});
  if (series != 1) {
    for (double& v : record.voltage_V) v /= series;
  }
  if (parallel != 1) {
    for (double& i : record.current_A) i /= parallel;
  }
}

std::vector<double> DeliveredCharge(const Record& record) {
  std::vector<double> charge_C(record.size(), 0.0);
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double current_A = record.current_A[record.hold == Hold::kBackward ? k : k - 1];
    charge_C[k] =
        charge_C[k - 1] + current_A * (record.time_s[k] - record.time_s[k - 1]);  // (4.59)
  }
  return charge_C;
}

}  // namespace lipoid
