#include "identify/joint/steady_current.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

constexpr double kWavering_Ohm = 0.1;

struct WaveringNoise {
  double flowing_A = 0.0;   // the voltage follows it
  double measured_A = 0.0;  // it does not
  double voltage_V = 0.0;
};

// Ten pulses of 2 A and 60 s, each followed by a rest of 240 s.
double LevelAt(std::size_t k) { return k % 300 >= 240 ? 2.0 : 0.0; }

std::vector<LoadedLog> WaveringPulses(const WaveringNoise& noise) {
  NormalNoise normal(7, 0);
  std::vector<double> time_s;
  std::vector<double> current_A;
  std::vector<double> voltage_V;
  for (std::size_t k = 0; k < 3000; ++k) {
    const double flows_A = LevelAt(k) + noise.flowing_A * normal();
    time_s.push_back(static_cast<double>(k));
    current_A.push_back(flows_A + noise.measured_A * normal());
    voltage_V.push_back(4.0 - 1e-5 * static_cast<double>(k) - kWavering_Ohm * flows_A +
                        noise.voltage_V * normal());
  }
  LoadedLog log;
  log.entry.file = "pulses.csv";
  log.entry.kind = LogKind::kPulses;
  log.log.record.time_s = std::move(time_s);
  log.log.record.current_A = std::move(current_A);
  log.log.record.voltage_V = std::move(voltage_V);
  return {log};
}

TEST(SteadyCurrent, OfAnInstrumentThatIsNoisyIsTheMeanOfEveryLevel) {
  const std::vector<LoadedLog> recorded = WaveringPulses({.measured_A = 0.02, .voltage_V = 1e-3});
  const auto steady = TakeOutCurrentNoise(recorded);
  ASSERT_TRUE(steady);
  EXPECT_EQ(steady->files, std::vector<std::string>{"pulses.csv"});
  // Some 2,900 second differences tell a deviation to 2 %.
  EXPECT_NEAR(steady->noise_A, 0.02, 0.0015);
  EXPECT_NE(steady->Said().find("the current of pulses.csv wavers by 0.02"), std::string::npos)
      << steady->Said();
  const Record& record = steady->logs[0].log.record;
  for (std::size_t k = 0; k < record.size(); ++k) {
    // The mean of 60 rows is known to 2.6 mA; four of these.
    ASSERT_NEAR(record.current_A[k], LevelAt(k), 0.0105) << k;
  }
  // No charge is lost.
  EXPECT_NEAR(DeliveredCharge(record).back(), DeliveredCharge(recorded[0].log.record).back(), 1e-9);
}

TEST(SteadyCurrent, IsNotTakenWhereTheVoltageFollows) {
  EXPECT_FALSE(TakeOutCurrentNoise(WaveringPulses({.flowing_A = 0.02, .voltage_V = 1e-4})));
}

TEST(SteadyCurrent, IsNotTakenWhereItsNoiseDoesNotMatter) {
  // 0.2 mV beside 1 mV.
  EXPECT_FALSE(TakeOutCurrentNoise(WaveringPulses({.measured_A = 0.002, .voltage_V = 1e-3})));
  EXPECT_FALSE(TakeOutCurrentNoise(WaveringPulses({.voltage_V = 1e-3})));
}

TEST(SteadyCurrent, LeavesADriveCycleAndValidationAlone) {
  std::vector<LoadedLog> logs = WaveringPulses({.measured_A = 0.02, .voltage_V = 1e-3});
  LoadedLog drive = logs[0];
  std::vector<double> current_A;
  for (std::size_t k = 0; k < drive.log.record.size(); ++k)
    current_A.push_back(1.0 + std::sin(0.05 * static_cast<double>(k)));
  drive.log.record.current_A = std::move(current_A);
  logs.push_back(drive);
  logs.push_back(logs[0]);
  logs.back().entry.kind = LogKind::kValidation;
  const auto steady = TakeOutCurrentNoise(logs);
  ASSERT_TRUE(steady);
  EXPECT_EQ(steady->files.size(), 1U);
  for (const std::size_t which : {1, 2}) {
    for (std::size_t k = 0; k < drive.log.record.size(); ++k)
      ASSERT_EQ(steady->logs[which].log.record.current_A[k], logs[which].log.record.current_A[k]);
  }
}

}  // namespace
}  // namespace lipoid
