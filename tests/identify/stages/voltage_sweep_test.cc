#include "identify/stages/voltage_sweep.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "identify/joint/joint_fit.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

// Both sides are exact sums in double precision over at most 2000 rows of recurrences with decay <=
// 1: rounding adds up to 2000 * 2.2e-16 of a column's norm at worst, and the QR adds its own.
// Measured: 1e-13.
constexpr double kTolerance = 1e-11;

// Products with a column that is zero, or nothing beside the others (kAlive).
constexpr double kNothing = 1e-150;

using SweepJet = ceres::Jet<double, 8>;  // beta, r_s, and three branches

OpenCircuitVoltage CurveOfCubic() {
  return OpenCircuitVoltage::MonotoneCubic({-0.1, 0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0},
                                           {2.6, 3.0, 3.45, 3.6, 3.74, 3.82, 3.95, 4.11, 4.2});
}

// Levels that hold for a while, discharge and charge, with noise; stamps at 10 ms, 1 s, 60 s or at
// random.
Record RandomRecord(unsigned seed, Hold hold, std::size_t rows) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Record record;
  record.hold = hold;
  double time_s = 5000.0 * unit(engine);
  double step_s = 1.0;
  double level_A = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    if (engine() % 40 == 0) level_A = engine() % 3 == 0 ? 0.0 : 3.0 * unit(engine) - 0.8;
    const auto kind = engine() % 200;
    if (kind < 3) step_s = kind == 0 ? 0.01 : kind == 1 ? 1.0 : 60.0;
    time_s += kind == 199 ? 90.0 * unit(engine) + 1e-3 : step_s;
    record.time_s.push_back(time_s);
    record.current_A.push_back(level_A + 0.01 * unit(engine));
    record.voltage_V.push_back(3.7 + 0.3 * unit(engine));
  }
  return record;
}

SweepLog LogOf(const Record& record, double initial_soc = 1.0, double weight = 1.0) {
  return {.record = &record, .initial_soc = initial_soc, .weight = weight};
}

// [J r] row by row, by automatic differentiation of the cell itself.
Eigen::MatrixXd DenseRows(const JointSetup& setup, const SweepLog& log, const SweepParameters& p) {
  const auto branches = static_cast<int>(p.time_constant_s.size());
  const int columns = VoltageSweep::Columns(branches);
  CellParameters<SweepJet> cell;
  cell.alpha_C = SweepJet(setup.alpha_C);
  cell.beta_per_sqrt_s = SweepJet(p.beta_per_sqrt_s, 0);
  cell.diffusion = setup.diffusion;
  cell.terms = setup.terms;
  cell.tail = setup.tail;
  cell.open_circuit_voltage = setup.open_circuit_voltage;
  cell.series_resistance_Ohm = Resistance<SweepJet>(SweepJet(p.series_resistance_Ohm, 1));
  for (int j = 0; j < branches; ++j) {
    const auto at = static_cast<std::size_t>(j);
    cell.branches.push_back({Resistance<SweepJet>(SweepJet(p.resistance_Ohm[at], 2 + j)),
                             SweepJet(p.time_constant_s[at], 2 + branches + j)});
  }
  const CellModel<SweepJet> model(std::move(cell));
  RecordStepper<SweepJet> stepper(
      model, log.record->hold, model.Relaxed(SweepJet(log.initial_soc)));
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(log.record->size()), columns + 1);
  for (std::size_t k = 0; k < log.record->size(); ++k) {
    stepper.Row(log.record->time_s[k], SweepJet(log.record->current_A[k]));
    const SweepJet residual = log.record->voltage_V[k] - stepper.Voltage();
    const double weight = std::sqrt(log.weight);
    const auto row = static_cast<Eigen::Index>(k);
    rows.row(row).head(columns) = weight * residual.v.head(columns).transpose();
    rows(row, columns) = weight * residual.a;
  }
  return rows;
}

// Cost, gradient J'r and J'J at once: every entry of [J r]'[J r], relative to the norms of its
// columns.
void ExpectSameProducts(const VoltageSweep& sweep, const SweepParameters& p) {
  const int columns = VoltageSweep::Columns(static_cast<int>(p.time_constant_s.size())) + 1;
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(columns, columns);
  for (const SweepLog& log : sweep.logs()) {
    const Eigen::MatrixXd rows = DenseRows(sweep.setup(), log, p);
    expected += rows.transpose() * rows;
  }
  const Eigen::MatrixXd factor = sweep.Factor(p, true);
  ASSERT_EQ(factor.rows(), columns);
  ASSERT_EQ(factor.cols(), columns);
  EXPECT_TRUE(factor.isUpperTriangular(0.0));
  const Eigen::MatrixXd products = factor.transpose() * factor;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR(products(i, j), expected(i, j), kTolerance * scale + kNothing)
          << "columns " << i << " and " << j;
    }
  }
  ASSERT_GT(expected(columns - 1, columns - 1), 0.0);

  const Eigen::MatrixXd norm = sweep.Factor(p, false);
  ASSERT_EQ(norm.rows(), columns);
  EXPECT_NEAR(norm(columns - 1, columns - 1),
              std::sqrt(expected(columns - 1, columns - 1)),
              kTolerance * std::sqrt(expected(columns - 1, columns - 1)));
  EXPECT_EQ(norm.leftCols(columns - 1).cwiseAbs().maxCoeff(), 0.0);
}

SweepParameters Parameters(int branches) {
  SweepParameters p{.beta_per_sqrt_s = 0.21,
                    .series_resistance_Ohm = 0.05,
                    .resistance_Ohm = {},
                    .time_constant_s = {}};
  const double r[] = {0.03, 0.012, 0.08};
  const double tau[] = {45.0, 0.7, 900.0};
  for (int j = 0; j < branches; ++j) {
    p.resistance_Ohm.push_back(r[j]);
    p.time_constant_s.push_back(tau[j]);
  }
  return p;
}

JointSetup MakeSetup(int terms = 10, bool tail = true, bool diffusion = true) {
  return {.alpha_C = 9000.0,
          .diffusion = diffusion,
          .terms = terms,
          .tail = tail,
          .open_circuit_voltage = CurveOfCubic()};
}

TEST(VoltageSweep, HasTheJacobianOfTheCell) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const Record record = RandomRecord(1, hold, 2000);
    for (const int terms : {0, 1, 3, 10, 40}) {
      for (const bool tail : {true, false}) {
        for (const int branches : {0, 1, 2, 3}) {
          SCOPED_TRACE(testing::Message()
                       << (hold == Hold::kBackward ? "backward" : "forward") << ", " << terms
                       << " terms, tail " << tail << ", " << branches << " branches");
          const VoltageSweep sweep(MakeSetup(terms, tail), {LogOf(record)});
          ExpectSameProducts(sweep, Parameters(branches));
        }
      }
    }
  }
}

TEST(VoltageSweep, WorksWithoutDiffusion) {
  const Record record = RandomRecord(2, Hold::kBackward, 1500);
  const VoltageSweep sweep(MakeSetup(10, true, false), {LogOf(record)});
  ExpectSameProducts(sweep, Parameters(2));
  EXPECT_EQ(sweep.setup().terms, 0);
  EXPECT_FALSE(sweep.setup().tail);
  EXPECT_EQ(sweep.Factor(Parameters(2), true).col(0).cwiseAbs().maxCoeff(),
            0.0);  // nothing depends on beta
}

TEST(VoltageSweep, TakesEveryKindOfCurve) {
  const Record record = RandomRecord(3, Hold::kBackward, 1500);
  for (const auto& curve :
       {OpenCircuitVoltage::Linear({0.0, 0.1, 0.5, 1.0}, {3.0, 3.5, 3.8, 4.2}),
        OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.7, 0.5, 0.02, 0.03}),
        OpenCircuitVoltage::Fourier(0.0, 1.0, 2.0, {3.7, -0.2, 0.01}, {0.3, 0.02})}) {
    JointSetup setup = MakeSetup();
    setup.open_circuit_voltage = curve;
    ExpectSameProducts(VoltageSweep(setup, {LogOf(record)}), Parameters(1));
  }
}

// Where solvers end up: branches without resistance or without inertia, and the ends of beta and
// tau.
TEST(VoltageSweep, HoldsAtTheBounds) {
  const Record record = RandomRecord(4, Hold::kForward, 2000);
  const VoltageSweep sweep(MakeSetup(), {LogOf(record)});
  SweepParameters p = Parameters(2);
  const auto with = [&](double beta, double r, double tau) {
    SCOPED_TRACE(testing::Message() << "beta " << beta << ", r " << r << ", tau " << tau);
    p.beta_per_sqrt_s = beta;
    p.resistance_Ohm[0] = r;
    p.time_constant_s[0] = tau;
    ExpectSameProducts(sweep, p);
  };
  with(1.0, 0.03, 45.0);
  with(1e-4, 0.03, 45.0);
  with(0.2, 0.0, 45.0);
  with(0.2, 0.03, 1e-3);
  with(0.2, 0.03, 1e8);
  // e^{-10^5}: the cell's own derivative is what rounding leaves of it, the sweep's is nothing.
  p.time_constant_s[0] = 1e-7;
  const Eigen::MatrixXd factor = sweep.Factor(p, true);
  EXPECT_LT(factor.col(4).cwiseAbs().maxCoeff(), kNothing);
  EXPECT_GT(factor.col(2).norm(), 1.0);
  p.series_resistance_Ohm = 0.0;
  with(1.0, 0.0, 1e-3);
  p.time_constant_s[1] = p.time_constant_s[0] = 3.0;  // two branches that are the same
  p.resistance_Ohm[1] = p.resistance_Ohm[0] = 0.01;
  ExpectSameProducts(sweep, p);
}

TEST(VoltageSweep, WeighsLogsAndStartsWhereEachLogSays) {
  const Record first = RandomRecord(5, Hold::kBackward, 700);
  const Record second = RandomRecord(6, Hold::kForward, 1100);
  const Record third = RandomRecord(7, Hold::kBackward, 3);
  const VoltageSweep sweep(MakeSetup(),
                           {LogOf(first, 1.0, 3.0), LogOf(second, 0.6, 0.2), LogOf(third, 0.05)});
  EXPECT_EQ(sweep.rows(), 1803U);
  ExpectSameProducts(sweep, Parameters(1));
  ExpectSameProducts(sweep, Parameters(3));
}

TEST(VoltageSweep, RepeatedLogsCountAsWeights) {
  // A weight of 4 on a log is the square of twice the factor, to the bit.
  const Record record = RandomRecord(8, Hold::kBackward, 500);
  const VoltageSweep once(MakeSetup(), {LogOf(record)});
  const VoltageSweep by_log(MakeSetup(), {LogOf(record, 1.0, 4.0)});
  const Eigen::MatrixXd twice = 2.0 * once.Factor(Parameters(2), true);
  EXPECT_EQ(by_log.Factor(Parameters(2), true), twice);
}

TEST(VoltageSweep, GivesTheSameBitsWithAnyNumberOfThreads) {
  std::vector<Record> records;
  std::vector<SweepLog> logs;
  for (unsigned seed = 10; seed < 16; ++seed)
    records.push_back(RandomRecord(seed, Hold::kBackward, std::size_t{400} * (seed - 8)));
  for (const Record& record : records) logs.push_back(LogOf(record));
  const VoltageSweep sweep(MakeSetup(), std::move(logs));
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return sweep.Factor(Parameters(2), true);
  };
  const Eigen::MatrixXd alone = run(1);
  for (int repeat = 0; repeat < 5; ++repeat) EXPECT_EQ(run(2), alone);
  EXPECT_EQ(run(4), alone);
}

TEST(VoltageSweep, IsNotFiniteWhereTheModelHasNoValue) {
  const Record record = RandomRecord(9, Hold::kBackward, 300);
  const VoltageSweep sweep(MakeSetup(), {LogOf(record)});
  SweepParameters p = Parameters(1);
  p.beta_per_sqrt_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(sweep.Factor(p, true).allFinite());
  EXPECT_FALSE(sweep.Factor(p, false).allFinite());
  JointSetup no_curve = MakeSetup();
  no_curve.open_circuit_voltage = OpenCircuitVoltage();
  const VoltageSweep without(no_curve, {LogOf(record)});
  EXPECT_FALSE(without.Factor(Parameters(1), true).allFinite());
}

TEST(VoltageSweep, OfNoRowsIsZero) {
  const Record empty;
  const VoltageSweep sweep(MakeSetup(), {LogOf(empty)});
  EXPECT_EQ(sweep.rows(), 0U);
  EXPECT_EQ(sweep.Factor(Parameters(1), true), Eigen::MatrixXd::Zero(5, 5));
  EXPECT_EQ(VoltageSweep(MakeSetup(), {}).Factor(Parameters(1), true), Eigen::MatrixXd::Zero(5, 5));
}

TEST(VoltageSweep, RefusesWhatHasNoMeaning) {
  const Record record = RandomRecord(1, Hold::kBackward, 10);
  JointSetup flat = MakeSetup();
  flat.alpha_C = 0.0;
  EXPECT_THROW(VoltageSweep(flat, {LogOf(record)}), PreconditionError);
  EXPECT_THROW(VoltageSweep(MakeSetup(), {SweepLog{}}), PreconditionError);
  SweepParameters p = Parameters(2);
  p.resistance_Ohm.pop_back();
  EXPECT_THROW(static_cast<void>(VoltageSweep(MakeSetup(), {LogOf(record)}).Factor(p, true)),
               PreconditionError);
}

// Means of rows that nothing happened between; all together they are the sums of the rows' own.
TEST(VoltageSweep, MeansAddUpToTheRows) {
  const SweepParameters p{.beta_per_sqrt_s = 0.15,
                          .series_resistance_Ohm = 0.05,
                          .resistance_Ohm = {0.03},
                          .time_constant_s = {40.0}};
  // Columns of Rows() among those of the Jacobian: beta, tau_1, r_s, r_1.
  const std::vector<Eigen::Index> order{0, 3, 1, 2};
  const JointSolution at = SolutionOf(p);
  const auto means = [&](const VoltageSweep& sweep, std::size_t most) {
    return sweep.Means(at.structure, at.rates, at.x, most)[0];
  };
  const JointSetup setup{.alpha_C = 2000.0, .open_circuit_voltage = CurveOfCubic()};
  // Steps of exactly constant current at 1 s, which condense, and a random log, which does not.
  Record steps;
  for (int k = 0; k <= 3000; ++k) {
    steps.time_s.push_back(k);
    steps.current_A.push_back(k > 0 && (k - 1) % 1000 < 300 ? 1.5 : 0.0);
    steps.voltage_V.push_back(3.8 + 0.1 * std::sin(0.01 * k) + 0.01 * std::cos(37.0 * k));
  }
  const Record noisy = RandomRecord(3, Hold::kBackward, 1500);
  for (const Record* record : std::initializer_list<const Record*>{&steps, &noisy}) {
    const VoltageSweep sweep(setup, {LogOf(*record, 1.0, 0.25)});
    const Eigen::MatrixXd dense = DenseRows(sweep.setup(), LogOf(*record), p);  // [dr/dp r]
    for (const std::size_t most : {std::size_t{100000}, std::size_t{400}, std::size_t{20}}) {
      SCOPED_TRACE(most);
      const FittedRows rows = means(sweep, most);
      EXPECT_LE(rows.time_s.size(), std::max(most, record->size()));
      if (most < 100) {
        EXPECT_LE(rows.time_s.size(), most);
      }
      EXPECT_EQ(std::adjacent_find(rows.time_s.begin(), rows.time_s.end(), std::greater_equal<>()),
                rows.time_s.end())
          << "times rise";
      EXPECT_NEAR(rows.averaged.sum(), static_cast<double>(record->size()), 1e-6);
      EXPECT_LT((rows.weight - 0.25 * rows.averaged).norm(), kTolerance);
      const Eigen::VectorXd sums = rows.sensitivity.transpose() * rows.averaged;
      for (Eigen::Index k = 0; k < sums.size(); ++k) {
        const auto column = dense.col(order[static_cast<std::size_t>(k)]);
        EXPECT_NEAR(sums[k], -column.sum(), 1e-9 * column.cwiseAbs().sum()) << k;
      }
      EXPECT_NEAR(rows.residual_V.dot(rows.averaged), dense.rightCols(1).sum(), 1e-7);
    }
    // What the means say of the parameters is what the rows say.
    const FittedRows rows = means(sweep, 400);
    const Eigen::MatrixXd information =
        rows.sensitivity.transpose() * rows.averaged.asDiagonal() * rows.sensitivity;
    const Eigen::MatrixXd columns = dense(Eigen::all, order);
    const Eigen::MatrixXd all = columns.transpose() * columns;
    if (record != &steps) continue;
    for (Eigen::Index k = 0; k < 4; ++k) EXPECT_NEAR(information(k, k) / all(k, k), 1.0, 0.01) << k;
  }
}

}  // namespace
}  // namespace lipoid
