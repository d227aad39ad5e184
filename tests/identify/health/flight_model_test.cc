#include "identify/health/flight_model.h"

#include <gtest/gtest.h>

#include "tests/support/ridders.h"
#include "tests/support/synthetic_flight.h"

namespace lipoid::test {
namespace {

using U = FlightUnknowns;

struct Case {
  ReferenceCell reference = MakeReference(NewFlightCell(), 1, {});
  Record record;
  Surroundings among;

  Case() {
    FlightPlan plan;
    plan.charge_share = 0.2;
    record = FlyAndLog(WithTypicalTemperature(NewFlightCell()), 1, plan, LikePx4(), "f").log.record;
  }
};

// At the reference's own values it is the prediction that everything else uses.
TEST(FlightModel, WithoutChangesIsThePrediction) {
  const Case c;
  const FlightModel model(c.reference, c.record, c.among);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size());
  x[U::kStart] = 0.97;
  const auto found = model.Predict(x);
  const auto expected =
      Predict(c.reference.cell, c.record.time_s, c.record.current_A, Hold::kBackward, 0.97);
  constexpr double kRounding_V = 1e-12;
  for (std::size_t k = 0; k < c.record.size(); ++k)
    ASSERT_NEAR(found.voltage_V[static_cast<Eigen::Index>(k)], expected.voltage_V[k], kRounding_V);
}

TEST(FlightModel, SlopesAreThoseOfThePrediction) {
  const Case c;
  const FlightModel model(c.reference, c.record, c.among);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size());
  x[U::kStart] = 0.963;
  x[U::kCapacity] = -0.1;
  x[U::kSeries] = 0.2;
  x[U::kScale] = 0.03;
  x[U::kOffset_A] = 0.1;
  x[U::kBefore] = 0.2;
  x[U::kCount + 8] = 0.5;
  const auto at = model.Predict(x);
  for (const std::size_t row : {std::size_t{3}, c.record.size() / 2, c.record.size() - 1}) {
    const auto k = static_cast<Eigen::Index>(row);
    for (int u = 0; u < model.size(); ++u) {
      const auto voltage_V = [&](double value) {
        Eigen::VectorXd moved = x;
        moved[u] = value;
        return model.Predict(moved).voltage_V[k];
      };
      const auto slope = Ridders(voltage_V, x[u], 1e-5);  // passes no node of v_oc(A)
      EXPECT_NEAR(at.slope(k, u), slope.value, 1e-7 + 10.0 * slope.error)
          << "row " << row << " unknown " << u;
    }
  }
}

// A log that starts under load starts as the same load would have left the cell that began relaxed
// ten minutes earlier.
TEST(FlightModel, StartsAsAfterALongLoad) {
  constexpr double kLoad_A = 10.0;
  constexpr int kBefore_s = 600;
  ReferenceCell reference = MakeReference(NewFlightCell(), 1, {});
  reference.cell.temperature.reset();
  Record late;
  std::vector<double> time_s{0.0};
  std::vector<double> current_A{0.0};
  for (int k = 1; k <= kBefore_s + 60; ++k) {
    time_s.push_back(k);
    current_A.push_back(kLoad_A);
    if (k < kBefore_s) continue;
    late.time_s.push_back(k);
    late.current_A.push_back(kLoad_A);
    late.voltage_V.push_back(0.0);
  }
  constexpr double kStart = 0.95;
  const auto whole = Predict(reference.cell, time_s, current_A, Hold::kBackward, kStart);
  const FlightModel model(reference, late, {});
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size());
  x[U::kStart] = kStart - kBefore_s * kLoad_A / reference.cell.alpha_C();
  x[U::kBefore] = 1.0;
  const auto found = model.Predict(x);
  // exp(-beta² 600 s) and exp(-600 s/tau) are below 1e-12.
  for (std::size_t k = 0; k < late.size(); ++k)
    EXPECT_NEAR(
        found.voltage_V[static_cast<Eigen::Index>(k)], whole.voltage_V[kBefore_s + k], 1e-9);
}

// Voltage is linear in what the series resistance adds.
TEST(FlightModel, StepResistanceIsWhatAStepShows) {
  const Case c;
  const FlightModel model(c.reference, c.record, c.among);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size());
  const double once_Ohm = model.StepResistance(x, 0.6, 30.0, 0.0).resistance_Ohm;
  x[U::kSeries] = std::log(2.0);
  const auto twice = model.StepResistance(x, 0.6, 30.0, 0.0);
  EXPECT_NEAR(twice.resistance_Ohm - once_Ohm, c.reference.cell.series_resistance_Ohm(0.6), 1e-12);
  EXPECT_NEAR(twice.slope[U::kSeries],
              2.0 * c.reference.cell.series_resistance_Ohm(0.6) / twice.resistance_Ohm,
              1e-12);
}

// r (1 - exp(-t/tau)) of each branch that is no slower than t, and its slopes; none of a slower one.
TEST(FlightModel, BranchesThatSettleAreAPartOfTheStep) {
  Case c;
  constexpr double kFast_s = 0.05;
  constexpr double kFast_Ohm = 0.002;
  c.reference.cell.branches = {{Resistance<double>(kFast_Ohm), kFast_s, {}},
                               {Resistance<double>(0.003), 30.0, {}}};
  if (auto& term = c.reference.cell.temperature) term->branches_J_per_mol = {2e4, 2e4};
  const FlightModel model(c.reference, c.record, c.among);
  const Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size());
  const double at_once_Ohm = model.StepResistance(x, 0.6, 30.0, 0.0).resistance_Ohm;
  constexpr double kSettle_s = 0.1;
  const auto settled = model.StepResistance(x, 0.6, 30.0, kSettle_s);
  const double left = std::exp(-kSettle_s / kFast_s);
  EXPECT_NEAR(settled.resistance_Ohm - at_once_Ohm, kFast_Ohm * (1.0 - left), 1e-12);
  EXPECT_NEAR(
      settled.slope[U::kBranches] * settled.resistance_Ohm, kFast_Ohm * (1.0 - left), 1e-12);
  EXPECT_NEAR(settled.slope[U::kTau] * settled.resistance_Ohm,
              -kFast_Ohm * left * kSettle_s / kFast_s,
              1e-12);
  // A current that flows on makes diffusion and slow branches follow.
  EXPECT_GT(model.GrowthOfDrop(x, 0.6, 30.0, 1.0), kFast_Ohm / at_once_Ohm);
}

}  // namespace
}  // namespace lipoid::test
