// The equivalent circuit that follows a cell best.
#include "identify/export/circuit_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/export/mission.h"
#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

// A cell without diffusion is such a circuit itself, with capacity_Ah for its charge.
Cell CircuitCell() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion.reset();
  cell.capacity_Ah = 0.4;
  cell.series_resistance_Ohm = 0.1;
  cell.branches = {{0.03, 6.0, std::nullopt}, {0.02, 60.0, std::nullopt}};
  return cell;
}

ExportRequest WithDefaultMission(const Cell& cell) {
  ExportRequest request;
  request.cell = cell;
  request.mission = DefaultMission(cell);
  return request;
}

TEST(CircuitFit, FindsTheCircuitThatTheCellIs) {
  const SingleCell one(WithDefaultMission(CircuitCell()));
  const auto fitted = FitCircuit(one, 2);
  ASSERT_NE(fitted.projection.termination, Termination::kFailure) << fitted.projection.message;
  const auto error =
      VoltageError(one.reference,
                   one.mission,
                   EquivalentCircuitVoltage(fitted.circuit, one.mission, one.drawn_Ah));
  // Neighbouring nodes are drawn together, which does not disturb equal ones.
  EXPECT_LT(error.rmse_V, 1e-6);
  EXPECT_NEAR(fitted.circuit.branches[0].time_constant_s, 6.0, 0.01);
  EXPECT_NEAR(fitted.circuit.branches[1].time_constant_s, 60.0, 0.1);
  for (const double ohm : fitted.circuit.series_Ohm) EXPECT_NEAR(ohm, 0.1, 1e-4);
  for (const double ohm : fitted.circuit.branches[0].resistance_Ohm) EXPECT_NEAR(ohm, 0.03, 3e-4);
}

TEST(CircuitFit, MoreBranchesAreNeverWorse) {
  const SingleCell one(WithDefaultMission(LoadCell("grepow-32Ah-1")));
  double before_V = HUGE_VAL;
  for (int branches = 0; branches <= 2; ++branches) {
    const auto fitted = FitCircuit(one, branches);
    const auto error =
        VoltageError(one.reference,
                     one.mission,
                     EquivalentCircuitVoltage(fitted.circuit, one.mission, one.drawn_Ah));
    EXPECT_LT(error.rmse_V, before_V) << branches;
    before_V = error.rmse_V;
    for (const auto& branch : fitted.circuit.branches) {
      EXPECT_GE(branch.time_constant_s, kShortestTimeConstant_s);
      for (const double ohm : branch.resistance_Ohm) EXPECT_GT(ohm, 0.0);
    }
  }
}

TEST(CircuitFit, NaiveNumbersLeaveOutABranchThatIsNextToNothing) {
  EXPECT_TRUE(NaiveCircuit(LoadCell("gifi-600mAh-1"), 2).branches.empty());
  const auto naive = NaiveCircuit(CircuitCell(), 1);
  ASSERT_EQ(naive.branches.size(), 1U);
  EXPECT_EQ(naive.branches[0].time_constant_s, 6.0);
  EXPECT_EQ(naive.capacity_Ah, 0.4);
}

}  // namespace
}  // namespace lipoid
