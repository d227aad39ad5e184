#include "identify/trust/experiment_plan.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string_view>

#include "identify/stages/pulse_fit.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

Cell TestCell() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion->beta_per_sqrt_s = 0.12;
  cell.series_resistance_Ohm = 0.08;
  cell.branches.assign(1, {});
  cell.branches[0].resistance_Ohm = 0.03;
  cell.branches[0].time_constant_s = 25.0;
  return cell;
}

const QuantityTrust& Of(const TrustReport& trust, const std::string& name) {
  for (const auto& q : trust.quantities) {
    if (q.name == name) return q;
  }
  throw std::out_of_range(name);
}

// The promise of a plan: what it predicts is what fits of such logs scatter by.
TEST(ExperimentPlan, PredictsTheSpreadOfEstimates) {
  const Cell cell = TestCell();
  SynthesisOptions options;
  options.pulse_rate_C = 4.0;
  options.pulse_s = 60.0;
  options.rest_s = 540.0;
  options.sampling_s = 1.0;
  const PlannedNoise noise{.white_V = 2e-4, .coloured_V = 5e-4, .correlation_s = 100.0};
  const auto plan = PlanExperiment(cell, options, noise);

  Record record;
  for (std::size_t k = 0; k < plan.rows; ++k) {
    record.time_s.push_back(static_cast<double>(k));
    record.current_A.push_back(k > 0 && (k - 1) % 600 < 60 ? plan.current_A : 0.0);
  }
  const auto clean = Predict(cell, record.time_s, record.current_A).voltage_V;
  EXPECT_GE(clean.back(), cell.cutoff_V) << "the plan ends where the cell does";
  const JointSetup setup{.alpha_C = cell.alpha_C(),
                         .open_circuit_voltage = cell.open_circuit_voltage};
  const char* const names[] = {"beta", "r_s", "r_1", "tau_1"};
  const Eigen::Array4d truth{0.12, 0.08, 0.03, 25.0};
  constexpr int kSeeds = 150;
  Eigen::Array4d squares = Eigen::Array4d::Zero();
  const double kept = std::exp(-1.0 / noise.correlation_s);
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    NormalNoise normal(seed, 0);
    double state = normal();
    record.voltage_V = clean;
    for (double& voltage_V : record.voltage_V) {
      voltage_V += noise.white_V * normal() + noise.coloured_V * state;
      state = kept * state + std::sqrt(1.0 - kept * kept) * normal();
    }
    const VoltageSweep sweep(setup, {{.record = &record}});
    // From the truth: which start is used is not the matter here.
    GivenParameters start;
    for (int k = 0; k < 4; ++k) start.start[names[k]] = truth[k];
    const auto fit =
        FitPulses(sweep, {.data = FindStartValues({&record})}, {.starts = 1}, {}, start);
    const auto& p = fit.parameters;
    const Eigen::Array4d found{
        p.beta_per_sqrt_s, p.series_resistance_Ohm, p.resistance_Ohm[0], p.time_constant_s[0]};
    squares += (found - truth).square();
  }
  for (int k = 0; k < 4; ++k) {
    // A standard deviation of 150 estimates is itself known to 1/sqrt(300) = 6 %.
    EXPECT_NEAR(Of(plan.trust, names[k]).standard_error / std::sqrt(squares[k] / kSeeds), 1.0, 0.15)
        << names[k];
  }
}

// The row below the cut-off carried nine tenths of what told beta, and sampling ten times slower
// seemed eight times better. What is left of that is least squares, which let the steep end count.
TEST(ExperimentPlan, ARowBelowTheCutoffTellsNothing) {
  const Cell cell = AsSampled(LoadCell("gifi-600mAh-1"), 1.0);
  SynthesisOptions options;
  const auto error_of_beta = [&](double sampling_s) {
    options.sampling_s = sampling_s;
    const Record record =
        RecordOfPlan(cell, ThesisProtocol(cell, options).back(), SamplingOf(options));
    EXPECT_GE(record.voltage_V.back(), cell.cutoff_V) << sampling_s;
    return Of(PlanExperiment(cell, options, {}).trust, "beta").standard_error;
  };
  EXPECT_GT(error_of_beta(10.0), 0.5 * error_of_beta(1.0));
}

TEST(ExperimentPlan, ErrorsGrowWithTheNoiseAndFallWithTheRate) {
  const Cell cell = TestCell();
  SynthesisOptions options;
  options.sampling_s = 1.0;
  options.pulse_rate_C = 2.0;
  const auto one = PlanExperiment(cell, options, {});
  const auto noisy = PlanExperiment(cell, options, {.white_V = 4e-4, .coloured_V = 1e-3});
  options.pulse_rate_C = 4.0;
  const auto strong = PlanExperiment(cell, options, {});
  for (const char* name : {"beta", "r_s", "r_1", "tau_1"}) {
    EXPECT_NEAR(
        Of(noisy.trust, name).standard_error / Of(one.trust, name).standard_error, 2.0, 1e-9);
    // beta is told by the steep end of the charge, into which a lower rate reaches further.
    if (std::string_view(name) == "beta") continue;
    EXPECT_LT(Of(strong.trust, name).standard_error, Of(one.trust, name).standard_error) << name;
  }
  EXPECT_GT(one.duration_s, 3600.0);
}

TEST(ExperimentPlan, SaysWhatDoesNotFitTogether) {
  SynthesisOptions options;
  const auto refused = [&](double sampling_s) {
    options.sampling_s = sampling_s;
    return PlanExperiment(TestCell(), options, {}).refused;
  };
  EXPECT_EQ(
      refused(7.0),
      "expected pulses and rests of whole rows, one every 7 s; take pulses of 28 or 35 s in place "
      "of 30 s, and rests of 1764 or 1771 s in place of 1770 s");
  EXPECT_EQ(
      refused(60.0),
      "expected pulses and rests of whole rows, one every 60 s; take pulses of 60 s in place of "
      "30 s, and rests of 1740 or 1800 s in place of 1770 s");
  EXPECT_EQ(refused(0.3), "");
  EXPECT_THROW((void)refused(1.0 / 3.0), OptionError);
  Cell cell = TestCell();
  EXPECT_EQ(LeftOutOfPlan(cell, 1.0).size(), 1U);
  cell.charge_transfer.emplace();
  EXPECT_EQ(LeftOutOfPlan(cell, 1.0).size(), 2U);
  cell.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.02}};
  EXPECT_EQ(LeftOutOfPlan(cell, 1.0).back(), "hysteresis of the cell is not in the plan");
}

}  // namespace
}  // namespace lipoid
