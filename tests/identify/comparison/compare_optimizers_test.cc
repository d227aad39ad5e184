#include "identify/comparison/compare_optimizers.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "identify/comparison/comparison_report.h"
#include "model/battery/cell_model.h"
#include "model/battery/record_stepper.h"

namespace lipoid {
namespace {

constexpr double kBeta = 0.15, kSeries = 0.05, kBranch = 0.03, kCapacitance = 900.0;
constexpr double kNoise_V = 1e-3;

// Pulses of a cell with one branch (27 s), predicted by the cell model itself, with noise.
class CompareOptimizersTest : public testing::Test {
 protected:
  void SetUp() override {
    CellParameters<double> cell;
    cell.alpha_C = setup_.alpha_C;
    cell.beta_per_sqrt_s = kBeta;
    cell.terms = setup_.terms;
    cell.tail = setup_.tail;
    cell.open_circuit_voltage = setup_.open_circuit_voltage;
    cell.series_resistance_Ohm = Resistance<double>(kSeries);
    cell.branches.push_back({Resistance<double>(kBranch), kBranch * kCapacitance});
    const CellModel<double> model(std::move(cell));
    RecordStepper<double> stepper(model, record_.hold, model.Relaxed(1.0));
    std::mt19937 engine(5);
    std::normal_distribution<double> normal;
    for (int k = 0; k < 900; ++k) {
      record_.time_s.push_back(2.0 * k);
      record_.current_A.push_back(k % 150 > 0 && k % 150 < 25 ? 4.0 : 0.0);
      stepper.Row(record_.time_s.back(), record_.current_A.back());
      record_.voltage_V.push_back(stepper.Voltage() + kNoise_V * normal(engine));
    }
  }

  [[nodiscard]] Comparison Run(const std::vector<std::string>& names,
                               int starts,
                               const ComparisonOptions& options = {},
                               const GivenParameters& known = {}) const {
    const VoltageSweep sweep(setup_, {{.record = &record_}});
    const PulseUnknowns unknowns = FindPulseUnknowns(
        setup_,
        FindStartValues({&record_}),
        {.beta_start_per_sqrt_s = 0.3, .capacitances = true, .scale = options.scaling},
        known);
    std::vector<const OptimizerEntry*> optimizers;
    for (const auto& name : names) optimizers.push_back(&FindOptimizer(name));
    OptimizerSettings settings;
    settings.context.seed = 11;
    settings.context.threads = 0;
    return CompareOptimizers(sweep, unknowns, optimizers, settings, starts, options);
  }

  JointSetup setup_{
      .alpha_C = 2500.0,
      .terms = 6,
      .tail = true,
      .open_circuit_voltage = OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.6, 0.5, -0.2, 0.3})};
  Record record_;
};

std::vector<std::string> EveryName() {
  std::vector<std::string> names;
  for (const auto& entry : Optimizers()) names.emplace_back(entry.name);
  return names;
}

TEST_F(CompareOptimizersTest, EveryOptimizerFindsTheCellFromTheDatasStart) {
  const auto comparison = Run(EveryName(), 0);
  ASSERT_EQ(comparison.results.size(), Optimizers().size());
  for (const auto& r : comparison.results) {
    SCOPED_TRACE(r.optimizer + ": " + r.summary.message);
    EXPECT_TRUE(r.summary.usable());
    EXPECT_GE(r.gap, 0.0);
    EXPECT_LT(r.gap, 1e-3);
    EXPECT_EQ(r.starts, 1);
    EXPECT_EQ(r.successes, 1);
    EXPECT_GT(r.time_to_target_s, 0.0);
    EXPECT_LE(r.time_to_target_s, r.summary.wall_s);
    EXPECT_LE(r.evaluations_to_target, r.summary.evaluations);
    // 900 rows of 1 mV: the noise that is left is within 3 sqrt(1/1800) of it.
    EXPECT_NEAR(r.errors.metrics.rmse, kNoise_V, 0.07 * kNoise_V);
    EXPECT_NEAR(r.summary.cost,
                0.5 * 900.0 * r.errors.metrics.rmse * r.errors.metrics.rmse,
                1e-9 * r.summary.cost);
    // A relative gap of 1e-3 is a voltage of 0.03 noises: what that lets the parameters move.
    EXPECT_NEAR(r.parameters.sweep.series_resistance_Ohm, kSeries, 0.02 * kSeries);
    EXPECT_NEAR(r.parameters.sweep.beta_per_sqrt_s, kBeta, 0.1 * kBeta);
  }
}

TEST_F(CompareOptimizersTest, TheBestOfManyStartsIsNoWorseThanAnyRun) {
  const auto comparison = Run({"levenberg-marquardt", "sqp", "bobyqa"}, 8);
  for (const auto& r : comparison.results) {
    EXPECT_EQ(r.starts, 8);
    EXPECT_GE(r.successes, 0);
    EXPECT_LE(r.successes, 8);
    EXPECT_LE(comparison.best_cost, r.best_cost);
    EXPECT_LE(r.best_cost, r.summary.cost);
    EXPECT_EQ(std::isfinite(r.time_to_target_s), r.successes > 0);
  }
  EXPECT_GT(comparison.results[0].success_rate(), 0.2) << "of Levenberg-Marquardt";
}

// The report with what belongs to the machine taken out.
std::string WithoutTimes(const Comparison& comparison) {
  Json json = ComparisonToJson(comparison, true);
  for (auto& result : json.at("results")) {
    result.erase("wall_s");
    result.erase("time_to_target_s");
    for (const char* list : {"improvements", "reached"}) {
      for (auto& each : result.at(list)) each.erase("wall_s");
    }
  }
  return json.dump();
}

TEST_F(CompareOptimizersTest, GivesTheSameBytesForAnyNumberOfThreads) {
  std::string first;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto text = WithoutTimes(Run(
        {"interior-point", "levenberg-marquardt", "particle-swarm", "cma-es", "nelder-mead"}, 3));
    if (first.empty()) first = text;
    EXPECT_EQ(text, first) << threads << " threads";
  }
  EXPECT_GT(first.size(), 3000U);
}

TEST_F(CompareOptimizersTest, BoxesWhatHasNoBoundAndKeepsWhatTheUserBounds) {
  const auto comparison = Run({"cma-es"}, 4, {.decades = 1.0}, {.bounds = {{"r_1", {0.0, 0.025}}}});
  for (std::size_t k = 0; k < comparison.variables.size(); ++k) {
    const auto& v = comparison.variables[k];
    const double start = Entry(comparison.start, v);
    SCOPED_TRACE(v.name);
    if (v.name == "r_1") {
      EXPECT_EQ(comparison.boxed[k].upper, 0.025);
    } else if (v.name == "beta") {
      EXPECT_EQ(comparison.boxed[k].upper, 1.0);
    } else {
      EXPECT_TRUE(std::isinf(v.upper));
      EXPECT_NEAR(comparison.boxed[k].upper, 10.0 * start, 1e-12 * start);
    }
  }
  // The truth, 0.03, lies beyond the bound.
  EXPECT_NEAR(comparison.results[0].parameters.sweep.resistance_Ohm[0], 0.025, 1e-6);
  EXPECT_EQ(comparison.results[0].at_bound, std::vector<std::string>{"r_1"});
}

TEST_F(CompareOptimizersTest, MovesWhatTheScalingSays) {
  double cost = 0.0;
  for (const auto scaling : {ParameterScale::kTypical, ParameterScale::kLog}) {
    const auto comparison = Run({"levenberg-marquardt"}, 0, {.scaling = scaling});
    EXPECT_EQ(comparison.variables[0].logarithmic, scaling == ParameterScale::kLog);
    if (cost > 0.0) {
      EXPECT_NEAR(comparison.best_cost, cost, 1e-6 * cost);
    }
    cost = comparison.best_cost;
  }
  const auto natural = Run({"levenberg-marquardt"}, 0, {.scaling = ParameterScale::kNatural});
  for (const auto& v : natural.variables) EXPECT_EQ(v.unit, 1.0);
}

TEST_F(CompareOptimizersTest, WritesOneLinePerOptimizerAndStart) {
  const auto comparison = Run({"sqp", "levenberg-marquardt"}, 2);
  const std::string csv = ComparisonToCsv(comparison, "my\ncampaign", true);
  const auto header = csv.find('\n') + 1;
  EXPECT_EQ(
      csv.find("optimizer,start,seed,cost_V2,gap_percent,reached,iterations,evaluations,"
               "gradient_evaluations,wall_s,termination,reason,beta,r_s,r_1,c_1,tau_1\nsqp,0,"),
      header)
      << csv;
  EXPECT_NE(csv.find("compare my\\ncampaign: one row"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2 + 2 * 3);
  // What the rows count is what the table sums up.
  for (const auto& result : comparison.results) {
    int successes = 0;
    for (const auto& run : comparison.runs) {
      if (run.optimizer != result.optimizer) continue;
      if (run.start > 0 && run.reached) ++successes;
      EXPECT_GE(run.gap, 0.0);
    }
    EXPECT_EQ(successes, result.successes) << result.optimizer;
  }
}

}  // namespace
}  // namespace lipoid
