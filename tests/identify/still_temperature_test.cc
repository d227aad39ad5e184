#include "identify/still_temperature.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/battery/typical_temperature.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::Truth;

// Logs of the cell that tell the temperature by a column.
std::vector<LoadedLog> Warm(const Cell& cell, double sensor_share) {
  std::vector<LoadedLog> logs = test::SyntheticLogs(Truth(), 5.0, 0.0);
  for (LoadedLog& log : logs) {
    Record& record = log.log.record;
    const auto degC =
        Predict(cell, record.time_s, record.current_A, record.hold, 1.0, {.ambient_degC = 25.0})
            .temperature_degC;
    record.temperature_degC = Column(record.size(), 25.0);
    for (std::size_t k = 0; k < record.size(); ++k)
      record.temperature_degC[k] += sensor_share * (degC[k] - 25.0);
  }
  return logs;
}

TEST(StillTemperature, OfLogsInWhichTheCellWarmsIsSaid) {
  const Cell typical = WithTypicalTemperature(Truth());
  const std::vector<LoadedLog> still = Warm(typical, 0.02);
  const std::string said = DoubtAboutStillTemperatures(Truth(), still);
  EXPECT_TRUE(
      said.starts_with("the temperature hardly moves in logs in which a cell of this size warms ("))
      << said;
  EXPECT_NE(said.find(" K are usual): unless the cell was held at one temperature"),
            std::string::npos);
  for (const LoadedLog& log : still) {
    if (log.entry.kind != LogKind::kLowRate) continue;  // it warms by nothing
    EXPECT_EQ(said.find(log.entry.file), std::string::npos) << said;
  }
  // The same where the fit believed it, and found a cell that does not warm.
  Cell cool = typical;
  cool.temperature->heat->heat_capacity_J_per_K *= 1e3;
  EXPECT_EQ(DoubtAboutStillTemperatures(cool, still), said);
  // A cell that warms by a third of what is typical is none.
  EXPECT_EQ(DoubtAboutStillTemperatures(Truth(), Warm(typical, 0.3)), "");
  std::vector<LoadedLog> none = still;
  for (LoadedLog& log : none) log.log.record.temperature_degC = {};
  EXPECT_EQ(DoubtAboutStillTemperatures(Truth(), none), "");
}

}  // namespace
}  // namespace lipoid
