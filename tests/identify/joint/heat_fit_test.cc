#include "identify/joint/heat_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/prediction.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

Cell WarmingCell(double slope_V_per_K) {
  Cell cell = test::Truth();
  Cell::Temperature& term = cell.temperature.emplace();
  term.series_J_per_mol = 18e3;
  term.branches_J_per_mol = {45e3};
  term.diffusion_J_per_mol = 30e3;
  term.heat = HeatBalance<double>{15.0, 20.0};
  term.entropy = EntropySlope<double>{{}, {slope_V_per_K}};
  return cell;
}

// Every current that the lab tries, at three ambient temperatures, a row each second.
std::vector<LoadedLog> LogsOf(const Cell& cell) {
  std::vector<LoadedLog> logs;
  for (const double ambient_degC : {25.0, 10.0, 0.0}) {
    auto log = test::AsLog(LogKind::kPulses,
                           test::SimulateLog(
                               cell,
                               1.0,
                               3000.0,
                               [](double t) { return std::fmod(t, 900.0) < 300.0 ? 2.0 : 0.0; },
                               "a"));
    Record& r = log.log.record;
    const Prediction at =
        Predict(cell, r.time_s, r.current_A, r.hold, 1.0, {.ambient_degC = ambient_degC});
    r.voltage_V = at.voltage_V;
    r.temperature_degC = at.temperature_degC;
    logs.push_back(std::move(log));
  }
  return logs;
}

// The heat balance of a cell that is known but for it.
std::optional<HeatFit> FitTo(Cell cell, const std::vector<LoadedLog>& logs) {
  cell.temperature->heat.reset();
  return FitHeat(cell, logs);
}

void ExpectTheTruth(const HeatFit& fit) {
  EXPECT_NEAR(fit.balance.heat_capacity_J_per_K, 15.0, 0.1);
  EXPECT_NEAR(fit.balance.thermal_resistance_K_per_W, 20.0, 0.1);
}

TEST(HeatFit, FindsWhatTheCellWasGiven) {
  for (const double slope_V_per_K : {0.0, 3e-4}) {
    const Cell truth = WarmingCell(slope_V_per_K);
    const auto fit = FitTo(truth, LogsOf(truth));
    ASSERT_TRUE(fit);
    ExpectTheTruth(*fit);
    EXPECT_LT(fit->rmse_K, 0.05);
    EXPECT_GT(fit->largest_rise_K, kLeastRise_K);
    EXPECT_LT(fit->heat_capacity_standard_error_J_per_K, 0.1);
    EXPECT_TRUE(fit->reversible);
  }
}

// A cell that rests at 0 degC in surroundings that are said to be at 25 rests in other ones.
TEST(HeatFit, SurroundingsThatARestContradictsAreThoseOfTheRest) {
  const Cell truth = WarmingCell(0.0);
  auto logs = LogsOf(truth);
  for (LoadedLog& log : logs) {
    log.entry.ambient_degC = 25.0;
    log.ambient_doubted = log.log.record.temperature_degC.front() < 20.0;
  }
  const auto fit = FitTo(truth, logs);
  ASSERT_TRUE(fit);
  ExpectTheTruth(*fit);
}

TEST(HeatFit, ASlopeThatIsNoEntropyReleasesNoHeat) {
  // What slow relaxation in the cold looks like.
  const auto fit = FitTo(WarmingCell(6e-4), LogsOf(WarmingCell(0.0)));
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->reversible);
  EXPECT_GT(fit->rmse_reversible_K, 2.0 * fit->rmse_K);
}

// What a plan promises is what fits scatter by.
TEST(HeatFit, APlanKnowsTheScatterOfItsEstimates) {
  const Cell cell = WarmingCell(0.0);
  const auto clean = LogsOf(cell);
  constexpr double kNoise_K = 0.1;
  const auto plan = PlanHeat(cell, clean, kNoise_K);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->balance.heat_capacity_J_per_K, 15.0);
  const auto undisturbed = FitHeat(cell, clean);
  constexpr int kSeeds = 60;
  double capacities = 0.0;
  double resistances = 0.0;
  double products = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    NormalNoise normal(seed, 0);
    auto logs = clean;
    for (LoadedLog& log : logs) {
      for (double& t_degC : log.log.record.temperature_degC) t_degC += kNoise_K * normal();
      log.entry.ambient_degC = std::round(log.log.record.temperature_degC.front());
    }
    const auto found = FitHeat(cell, logs)->balance;
    const double capacity =
        found.heat_capacity_J_per_K - undisturbed->balance.heat_capacity_J_per_K;
    const double resistance =
        found.thermal_resistance_K_per_W - undisturbed->balance.thermal_resistance_K_per_W;
    capacities += capacity * capacity / kSeeds;
    resistances += resistance * resistance / kSeeds;
    products += capacity * resistance / kSeeds;
  }
  // A standard deviation of 60 estimates is known to 1/sqrt(120) = 9 %: three of that.
  EXPECT_NEAR(std::sqrt(capacities) / plan->heat_capacity_standard_error_J_per_K, 1.0, 0.27);
  EXPECT_NEAR(std::sqrt(resistances) / plan->thermal_resistance_standard_error_K_per_W, 1.0, 0.27);
  // Correlations of 60 pairs to 1/sqrt(60) = 0.13.
  const double planned = plan->covariance_s / (plan->heat_capacity_standard_error_J_per_K *
                                               plan->thermal_resistance_standard_error_K_per_W);
  EXPECT_NEAR(products / std::sqrt(capacities * resistances), planned, 0.39);
  EXPECT_FALSE(PlanHeat(test::Truth(), clean, kNoise_K));
}

TEST(HeatFit, NoneWhereNothingWarms) {
  auto logs = LogsOf(WarmingCell(0.0));
  const Cell cell = WarmingCell(0.0);
  for (LoadedLog& log : logs) log.log.record.temperature_degC = Column(log.log.record.size(), 20.0);
  EXPECT_FALSE(FitHeat(cell, logs));
  for (LoadedLog& log : logs) log.log.record.temperature_degC.clear();
  EXPECT_FALSE(FitHeat(cell, logs));
}

}  // namespace
}  // namespace lipoid
