#include "identify/fit_doubts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::Truth;

std::string ReasonsOf(const Campaign& campaign, const std::vector<LoadedLog>& logs) {
  return fmt::format("{}", fmt::join(Identify(campaign, logs, {}).quality.reasons, "; "));
}

TEST(FitDoubts, GoodLogsHaveNone) {
  const auto logs = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  EXPECT_EQ(ReasonsOf(test::CampaignOf(logs), logs), "");
}

// The curve and beta bend until any one discharge fits; nothing says whether another one would.
TEST(FitDoubts, OneDischargeAndASlowOneTestNothing) {
  const auto all = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  const std::vector<LoadedLog> two{all[1], all[3]};
  EXPECT_NE(ReasonsOf(test::CampaignOf(two), two)
                .find("all loads of these logs are of about 1.8 A, and none rests"),
            std::string::npos);
  const std::vector<LoadedLog> with_pulses{all[3], all[4]};
  EXPECT_EQ(ReasonsOf(test::CampaignOf(with_pulses), with_pulses), "");
}

// To leave the cut-off out does not make the capacity better known.
TEST(FitDoubts, TheNominalCapacityIsTestedByNoLog) {
  auto logs = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  logs.erase(logs.begin(), logs.begin() + 4);
  Record& pulses = logs[0].log.record;
  const std::size_t half = pulses.size() / 2;
  for (auto* column : {&pulses.time_s, &pulses.current_A, &pulses.voltage_V}) column->resize(half);
  Campaign campaign = test::CampaignOf(logs);
  EXPECT_NE(
      ReasonsOf(campaign, logs).find("above where the last slope of v_oc leads to the cut-off"),
      std::string::npos);
  campaign.cutoff_V.reset();
  EXPECT_NE(ReasonsOf(campaign, logs)
                .find("no cut-off voltage is given, and alpha is the nominal capacity of 0.6 Ah"),
            std::string::npos);
}

// Of 14 campaigns whose slow log stops at a quarter of the charge each had beta, r_1, tau_1 and c_1 outside their intervals.
TEST(FitDoubts, ASlowLogThatStopsEarlyCountsNoCapacity) {
  const auto all = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  std::vector<LoadedLog> logs{all[3], all[4]};
  IdentifyOptions staged;
  staged.method = IdentifyMethod::kStaged;
  for (const bool early : {false, true}) {
    if (early) {
      Record& slow = logs[0].log.record;
      const std::size_t rows = 3 * slow.size() / 4;
      for (auto* column : {&slow.time_s, &slow.current_A, &slow.voltage_V}) column->resize(rows);
    }
    const auto reasons = Identify(test::CampaignOf(logs), logs, staged).quality.reasons;
    const auto said = std::any_of(reasons.begin(), reasons.end(), [](const std::string& one) {
      return one.find("Ah, is the charge of a low-rate log that ends") != std::string::npos &&
             one.ends_with("--method joint fits all logs together");
    });
    EXPECT_EQ(said, early) << fmt::format("{}", fmt::join(reasons, "; "));
  }
}

TEST(FitDoubts, TheSlowLogAndTheOthersCountOneCharge) {
  auto logs = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  for (double& current_A : logs[3].log.record.current_A) current_A *= 1.2;
  EXPECT_NE(ReasonsOf(test::CampaignOf(logs), logs).find("they should be one charge"),
            std::string::npos);
}

TEST(FitDoubts, RoundingIsNoNoise) {
  for (const auto& [step_V, doubted] : {std::pair(0.01, false), {0.02, true}}) {
    auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
    for (LoadedLog& log : logs) {
      for (double& voltage_V : log.log.record.voltage_V)
        voltage_V = step_V * std::round(voltage_V / step_V);
    }
    const std::string reasons = ReasonsOf(test::CampaignOf(logs), logs);
    EXPECT_EQ(reasons.find("comes in steps of 20 mV") != std::string::npos, doubted) << reasons;
  }
}

// A filter of 4 s, or means over three rows, of a voltage that is sampled every 2 s.
TEST(FitDoubts, AFilteredVoltageDropsWithinSomeRows) {
  auto logs = test::SyntheticLogs(Truth(), 2.0, 0.0002);
  for (LoadedLog& log : logs) {
    Column& voltage_V = log.log.record.voltage_V;
    const double share = -std::expm1(-(log.log.record.time_s[1] - log.log.record.time_s[0]) / 4.0);
    for (std::size_t k = 1; k < voltage_V.size(); ++k)
      voltage_V[k] = voltage_V[k - 1] + share * (voltage_V[k] - voltage_V[k - 1]);
  }
  const std::string reasons = ReasonsOf(test::CampaignOf(logs), logs);
  EXPECT_NE(reasons.find("averaged, filtered or late"), std::string::npos) << reasons;
}

TEST(FitDoubts, AResistanceThatIsThereAtOnceIsNoFilter) {
  Cell cell = Truth();
  cell.branches[0].time_constant_s = 4.0;
  EXPECT_EQ(DoubtAboutInstants(cell, 2.0), "");
  cell.series_resistance_Ohm = Resistance<double>(0.001);
  EXPECT_NE(DoubtAboutInstants(cell, 2.0), "");
  EXPECT_EQ(DoubtAboutInstants(cell, 0.5), "") << "rows see it rise";
  cell.charge_transfer = Cell::ChargeTransfer{0.5, Resistance<double>(0.05)};
  EXPECT_EQ(DoubtAboutInstants(cell, 2.0), "") << "a charge transfer is at once there";
}

}  // namespace
}  // namespace lipoid
