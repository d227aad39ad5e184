#include "identify/joint/joint_fit.h"

#include <gtest/gtest.h>

#include "identify/joint/joint_choice.h"
#include "model/battery/cell_file.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::Truth;

// What a fit needs, from logs of a cell with its own capacity reference.
struct Bench {
  explicit Bench(const Cell& cell, const std::vector<LoadedLog>& made) : truth(cell) {
    setup = {.alpha_C = cell.alpha_C(),
             .diffusion = true,
             .terms = 10,
             .tail = true,
             .open_circuit_voltage = OpenCircuitVoltage::Linear({-0.1, 1.0}, {3.0, 4.2})};
    logs = MakeJointLogs(made, setup.alpha_C, setup.open_circuit_voltage, {});
    structure.voltage_soc = VoltageNodes(0);
  }
  [[nodiscard]] double Ohm(const JointSolution& s, int at) const {
    return s.x[at] / logs.typical_A;
  }

  Cell truth;
  JointSetup setup;
  JointLogs logs;
  GivenParameters known;
  JointStructure structure;
};

// Rows stay as they are and nodes of v_oc lie on those of the truth: only the pull of smoothness
// and the search's tolerance are left.
constexpr double kExact = 1e-4;

TEST(JointFit, FindsTheTruthFromItsGrid) {
  const Bench bench(Truth(), test::SyntheticLogs(Truth(), 5.0));
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  const JointSolution found = fit.Polish(fit.Search(bench.structure, 1e-4), 1e-6);
  const JointLayout layout(found.structure);
  EXPECT_NEAR(found.rates.beta_per_sqrt_s, 0.1924, kExact * 0.1924);
  EXPECT_NEAR(found.rates.time_constant_s[0], 45.0, 10.0 * kExact * 45.0);
  EXPECT_NEAR(bench.Ohm(found, layout.series()), 0.1314, kExact * 0.1314);
  EXPECT_NEAR(bench.Ohm(found, layout.branch(0)), 0.03, 10.0 * kExact * 0.03);
  EXPECT_TRUE(found.at_bound.empty());
}

// 4,000 s, where no current and no rest lasts longer than 1,770 s: looked for below, found above,
// also where a person says that it is there.
TEST(JointFit, FindsABranchThatIsSlowerThanEverySegment) {
  Cell slow = Truth();
  constexpr double kTau_s = 4000.0;
  slow.branches = {{Resistance<double>(0.03), kTau_s, kTau_s / 0.03}};
  Bench bench(slow, test::SyntheticLogs(slow, 5.0));
  bench.setup.slow_branches = true;
  const JointObservations seen(bench.logs, bench.setup);
  ASSERT_LT(seen.scales().longest_start_tau_s, 0.5 * kTau_s);
  const auto find = [&](const GivenParameters& known) {
    const JointFit fit(seen, known);
    return fit.Polish(fit.Search(bench.structure, 1e-4), 1e-6);
  };
  for (const GivenParameters& known :
       {GivenParameters(), GivenParameters{.bounds = {{"tau_1", {2500.0, 6000.0}}}}}) {
    const JointSolution found = find(known);
    // So slow a branch looks much like the curve, whose smoothness pulls at it: by 0.3 %. The end
    // of the segments would be 56 % off.
    EXPECT_NEAR(found.rates.time_constant_s[0], kTau_s, 0.005 * kTau_s);
    EXPECT_NEAR(bench.Ohm(found, JointLayout(found.structure).branch(0)), 0.03, 0.005 * 0.03);
    EXPECT_TRUE(found.at_bound.empty());
  }
}

TEST(JointFit, ResistancesAreNotNegativeAndTheCurveDoesNotFall) {
  // Noise of 20 mV on few rows asks for both.
  const Bench bench(Truth(), test::SyntheticLogs(Truth(), 60.0, 0.02));
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  JointStructure structure = bench.structure;
  structure.resistance_soc = ResistanceNodes(34);
  const JointSolution found = fit.Search(structure, 1e-6);
  const JointLayout layout(structure);
  ASSERT_EQ(found.x.size(), layout.size());
  EXPECT_GE(found.x.tail(layout.size() - layout.voltages()).minCoeff(), 0.0);
  EXPECT_EQ(found.x.tail(layout.size() - layout.voltages()).minCoeff(), 0.0);
  double before_V = -1.0;
  for (int k = 0; k < layout.voltages(); ++k) {
    const double v = bench.setup.open_circuit_voltage(structure.voltage_soc[k]) + found.x[k];
    EXPECT_GE(v, before_V - 1e-12);
    before_V = v;
  }
}

// The same noise with what steps of the current show: a table of r_s keeps within 0.15 and 2 times
// that, a constant one is free, and what the user says comes first.
TEST(JointFit, ATableOfTheSeriesResistanceKeepsToWhatStepsShow) {
  Bench bench(Truth(), test::SyntheticLogs(Truth(), 60.0, 0.02));
  constexpr double kEdge_Ohm = 0.15;
  bench.setup.edge_resistance_Ohm = kEdge_Ohm;
  JointStructure structure = bench.structure;
  structure.resistance_soc = ResistanceNodes(34);
  const auto series = [&](const GivenParameters& known, const JointStructure& of) {
    const JointObservations seen(bench.logs, bench.setup);
    const JointSolution found = JointFit(seen, known).Search(of, 1e-6);
    const JointLayout layout(of);
    const Eigen::VectorXd ohm =
        found.x.segment(layout.series(), layout.nodes()) / bench.logs.typical_A;
    return std::pair(ohm.minCoeff(), ohm.maxCoeff());
  };
  constexpr double kRounding = 1e-12;
  const auto [least, most] = series({}, structure);
  EXPECT_NEAR(least, 0.15 * kEdge_Ohm, kRounding);  // the noise pulls it there
  EXPECT_LE(most, 2.0 * kEdge_Ohm + kRounding);
  GivenParameters said;
  said.bounds["r_s"] = {0.01, 1.0};
  EXPECT_NEAR(series(said, structure).first, 0.01, kRounding);
  bench.setup.edge_resistance_Ohm = 10.0;
  EXPECT_LT(series({}, bench.structure).second, 0.15 * 10.0);
}

TEST(JointFit, HoldsWhatIsKnown) {
  Bench bench(Truth(), test::SyntheticLogs(Truth(), 5.0));
  bench.known.fixed = {{"beta", 0.25}, {"tau_1", 30.0}, {"r_s", 0.12}};
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  const JointSolution found = fit.Search(bench.structure, 1e-4);
  EXPECT_EQ(found.rates.beta_per_sqrt_s, 0.25);
  EXPECT_EQ(found.rates.time_constant_s[0], 30.0);
  EXPECT_DOUBLE_EQ(bench.Ohm(found, JointLayout(found.structure).series()), 0.12);
  bench.known = {.bounds = {{"tau_1", {60.0, 80.0}}}};
  const JointObservations bounded_seen(bench.logs, bench.setup);
  const JointFit bounded(bounded_seen, bench.known);
  const JointSolution at_bound = bounded.Search(bench.structure, 1e-4);
  EXPECT_NEAR(at_bound.rates.time_constant_s[0], 60.0, 1e-6);
  EXPECT_EQ(at_bound.at_bound, std::vector<std::string>{"tau_1"});
  // So does a solution with other tables at the same rates.
  JointStructure finer = bench.structure;
  finer.resistance_soc = ResistanceNodes(6);
  EXPECT_EQ(bounded.Solve(finer, at_bound.rates, 1e-4).at_bound, at_bound.at_bound);
}

TEST(JointFit, SaysWhetherThePolishCameToItsEnd) {
  Bench bench(Truth(), test::SyntheticLogs(Truth(), 5.0));
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  const JointSolution rough = fit.Search(bench.structure, 1e-4);
  EXPECT_EQ(rough.termination, Termination::kConverged) << rough.message;
  EXPECT_EQ(fit.Polish(rough, kFineStep).termination, Termination::kConverged);
  const JointSolution cut = fit.Polish(rough, 1e-9, 3);
  EXPECT_EQ(cut.termination, Termination::kMaxIterations) << cut.message;
  EXPECT_LE(cut.cost, rough.cost);
  // Without a rate to find there is nothing to polish.
  bench.known.fixed = {{"beta", 0.25}, {"tau_1", 30.0}};
  const JointObservations held_seen(bench.logs, bench.setup);
  const JointFit held(held_seen, bench.known);
  EXPECT_EQ(held.Search(bench.structure, 1e-4).termination, Termination::kConverged);
}

TEST(JointFit, LeavesOutNothingWhereThereIsOnlyOneGroup) {
  auto made = test::SyntheticLogs(Truth(), 5.0);
  made.erase(made.begin(), made.begin() + 3);
  made.erase(made.begin() + 1);  // the low rate alone
  const Bench bench(Truth(), made);
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  const auto errors = LeaveOut(fit, bench.logs, bench.structure, fit.Base(bench.structure), {1e-3});
  EXPECT_TRUE(std::isnan(errors.left_out_V));
  EXPECT_EQ(errors.smoothness, 1e-3);
}

// Rows left out of a fit with little freedom are predicted as well as those in it.
TEST(JointFit, ErrorsOfRowsLeftOutAreThoseOfTheNoise) {
  constexpr double kNoise_V = 0.001;
  // A second between rows: some seventy unknowns follow little of so many.
  const Bench bench(Truth(), test::SyntheticLogs(Truth(), 1.0, kNoise_V));
  const JointObservations fit_seen(bench.logs, bench.setup);
  const JointFit fit(fit_seen, bench.known);
  const JointSolution found = fit.Search(bench.structure, 1e-3);
  const auto errors = LeaveOut(fit, bench.logs, bench.structure, found.rates, {1e-3});
  EXPECT_GT(errors.left_out_V, errors.fitted_V);
  EXPECT_LT(errors.left_out_V, 1.05 * errors.fitted_V);
  // Seventy unknowns take their share of some thousand points; blocks average over noise.
  EXPECT_NEAR(errors.fitted_V, bench.logs.noise_mean_V, 0.1 * bench.logs.noise_mean_V);
}

}  // namespace
}  // namespace lipoid
