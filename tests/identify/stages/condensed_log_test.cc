#include "identify/stages/condensed_log.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "identify/stages/voltage_sweep.h"
#include "model/core/errors.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

std::vector<double> Even(int rows, double interval_s) {
  std::vector<double> offset_s;
  for (int k = 1; k <= rows; ++k) offset_s.push_back(interval_s * k);
  return offset_s;
}

std::vector<double> Uneven(int rows) {
  std::mt19937 engine(7);
  std::vector<double> offset_s;
  double at = 0.0;
  for (int k = 0; k < rows; ++k)
    offset_s.push_back(at += 0.1 + static_cast<double>(engine() % 1000) * 1e-3);
  return offset_s;
}

// What the header says of polynomials. Rounding of sums over up to 4096 rows.
TEST(BlockShape, ReplacesRowsByNodesForPolynomials) {
  for (const auto& offset_s :
       {Even(4, 10.0), Even(32, 0.01), Even(64, 1.0), Even(4096, 0.01), Uneven(50), Uneven(9)}) {
    for (const int nodes : {1, 3, 4, 8}) {
      if (nodes > static_cast<int>(offset_s.size())) continue;
      SCOPED_TRACE(testing::Message() << offset_s.size() << " rows, " << nodes << " nodes");
      const BlockShape shape = MakeBlockShape(offset_s, nodes);
      const auto rows = static_cast<Eigen::Index>(offset_s.size());
      EXPECT_EQ(shape.duration_s(), offset_s.back());
      EXPECT_NEAR(shape.weight.sum(), static_cast<double>(rows), 1e-12 * static_cast<double>(rows));
      EXPECT_GT(shape.weight.minCoeff(), 0.0);
      EXPECT_GE(shape.node_s[0], offset_s.front() - 1e-12);
      EXPECT_LE(shape.node_s[nodes - 1], offset_s.back() + 1e-12);
      EXPECT_LT((shape.basis.transpose() * shape.basis - Eigen::MatrixXd::Identity(nodes, nodes))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-12);
      // The quadrature: exact up to degree 2 nodes - 1.
      const double scale = offset_s.back();
      for (int degree = 0; degree < 2 * nodes; ++degree) {
        double sum = 0.0;
        for (const double s : offset_s) sum += std::pow(s / scale, degree);
        double quadrature = 0.0;
        for (Eigen::Index j = 0; j < nodes; ++j)
          quadrature += shape.weight[j] * std::pow(shape.node_s[j] / scale, degree);
        EXPECT_NEAR(quadrature, sum, 1e-11 * sum) << "degree " << degree;
      }
      // sum_k (v_k - p(t_k))² for random v and p.
      std::mt19937 engine(11);
      std::normal_distribution<double> normal;
      Eigen::VectorXd v(rows);
      for (double& value : v) value = normal(engine);
      const Eigen::VectorXd c = shape.basis.transpose() * v;
      const Eigen::VectorXd y = shape.at_nodes.transpose() * c;
      const double remainder = (v - shape.basis * c).squaredNorm();
      for (int repeat = 0; repeat < 3; ++repeat) {
        std::vector<double> p;
        for (int k = 0; k < nodes; ++k) p.push_back(normal(engine));
        const auto at = [&](double s) {
          double value = 0.0;
          for (const double coefficient : p) value = value * (s / scale) + coefficient;
          return value;
        };
        double all = 0.0;
        for (Eigen::Index k = 0; k < rows; ++k)
          all += std::pow(v[k] - at(offset_s[static_cast<std::size_t>(k)]), 2);
        double few = remainder;
        for (Eigen::Index j = 0; j < nodes; ++j)
          few += shape.weight[j] * std::pow(y[j] - at(shape.node_s[j]), 2);
        EXPECT_NEAR(few, all, 1e-11 * all);
      }
    }
  }
  EXPECT_THROW(static_cast<void>(MakeBlockShape(Even(3, 1.0), 4)), PreconditionError);
  EXPECT_THROW(static_cast<void>(MakeBlockShape(Even(3, 1.0), 0)), PreconditionError);
}

JointSetup SetupWith(OpenCircuitVoltage curve) {
  return {.alpha_C = 1353.6, .terms = 10, .tail = true, .open_circuit_voltage = std::move(curve)};
}

OpenCircuitVoltage Curve(OcvMethod method) {
  std::vector<double> soc;
  std::vector<double> voltage_V;
  const int last = method == OcvMethod::kMonotoneCubic ? 12 : 200;
  for (int k = 0; k <= last; ++k) {
    const double a = 0.02 + 0.98 * k / last;
    soc.push_back(a);
    voltage_V.push_back(3.7 + 0.4 * a - 0.6 * std::exp(-30.0 * a));
  }
  switch (method) {
    case OcvMethod::kLinear:
      return OpenCircuitVoltage::Linear(soc, voltage_V);
    case OcvMethod::kMonotoneCubic:
      return OpenCircuitVoltage::MonotoneCubic(soc, voltage_V);
    case OcvMethod::kPolynomial:
      return OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.8, 0.45, -0.05, 0.08, -0.02});
    case OcvMethod::kFourier:
      break;
  }
  return OpenCircuitVoltage::Fourier(0.0, 1.0, 3.0, {3.8, -0.2, 0.05}, {0.2, -0.03});
}

// The lab's pulses in small: 10 ms, a load, a charge and rests, noise on the voltage.
Record Pulses(Hold hold, double interval_s = 0.01, double noise_V = 1e-3) {
  std::vector<test::CurrentStep> steps = {{5.0, 0.0, interval_s}};
  for (int k = 0; k < 4; ++k) {
    steps.push_back({30.0, 3.6, interval_s});
    steps.push_back({200.0, 0.0, interval_s});
    steps.push_back({8.0, -1.5, interval_s});
    steps.push_back({60.0, 0.0, 2.0 * interval_s});
  }
  Record record = test::RecordOfSteps(steps, hold);
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  record.voltage_V.clear();
  double charge_C = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    charge_C += k == 0 ? 0.0 : record.current_A[k] * (record.time_s[k] - record.time_s[k - 1]);
    record.voltage_V.push_back(4.1 - 4e-4 * charge_C - 0.15 * record.current_A[k] +
                               noise_V * normal(engine));
  }
  return record;
}

constexpr SweepParameters kNoParameters{};

SweepParameters Parameters(double beta, int branches) {
  SweepParameters p = kNoParameters;
  p.beta_per_sqrt_s = beta;
  p.series_resistance_Ohm = 0.1314;
  const double r[] = {0.03, 0.012, 0.004};
  const double tau[] = {45.0, 0.9, 2e-4};
  for (int j = 0; j < branches; ++j) {
    p.resistance_Ohm.push_back(r[j]);
    p.time_constant_s.push_back(tau[j]);
  }
  return p;
}

// Every sum of the condensed log is that of all rows. The modes contribute 1e-12 of 0.1 V
// (condensed_log.h) and rounding; measured: 3e-12.
TEST(CondensedLog, HasTheSumsOfAllRows) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const Record record = Pulses(hold);
    for (const OcvMethod method : {OcvMethod::kLinear,
                                   OcvMethod::kMonotoneCubic,
                                   OcvMethod::kPolynomial,
                                   OcvMethod::kFourier}) {
      const VoltageSweep all(SetupWith(Curve(method)), {{.record = &record}}, Condensation::None());
      const VoltageSweep few(SetupWith(Curve(method)), {{.record = &record}});
      EXPECT_LT(few.points(), record.size() / 4);
      EXPECT_EQ(few.rows(), record.size());
      for (const double beta : {0.02, 0.19, 1.0}) {
        for (const int branches : {0, 1, 3}) {
          SCOPED_TRACE(testing::Message() << "method " << static_cast<int>(method) << ", beta "
                                          << beta << ", " << branches << " branches");
          const SweepParameters p = Parameters(beta, branches);
          const Eigen::MatrixXd expected_factor = all.Factor(p, true);
          const Eigen::MatrixXd factor = few.Factor(p, true);
          const Eigen::Index last = factor.rows() - 1;
          const Eigen::MatrixXd expected = expected_factor.transpose() * expected_factor;
          const Eigen::MatrixXd products = factor.transpose() * factor;
          for (Eigen::Index i = 0; i < products.rows(); ++i) {
            for (Eigen::Index j = 0; j <= i; ++j) {
              EXPECT_NEAR(products(i, j),
                          expected(i, j),
                          1e-10 * std::sqrt(expected(i, i) * expected(j, j)) + 1e-150)
                  << i << ", " << j;
            }
          }
          EXPECT_NEAR(few.Factor(p, false)(last, last),
                      all.Factor(p, false)(last, last),
                      1e-10 * all.Factor(p, false)(last, last));
          const SweepErrors errors = few.Errors(p);
          const SweepErrors expected_errors = all.Errors(p);
          EXPECT_EQ(errors.metrics.rows, record.size());
          EXPECT_EQ(errors.rows_outside_curve, expected_errors.rows_outside_curve);
          EXPECT_NEAR(errors.metrics.rmse, expected_errors.metrics.rmse, 1e-11);
          EXPECT_NEAR(
              errors.metrics.mean_error_percent, expected_errors.metrics.mean_error_percent, 1e-9);
          EXPECT_NEAR(
              errors.metrics.max_error_percent, expected_errors.metrics.max_error_percent, 1e-9);
        }
      }
    }
  }
}

TEST(CondensedLog, KeepsEveryRowAndTheCharge) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    for (const double noise_A : {0.0, 2e-4, 0.03}) {
      Record record = Pulses(hold, 0.02);
      for (double& i : record.current_A) i += noise_A * normal(engine);
      for (const Condensation& how :
           {Condensation::None(), Condensation::Exact(), Condensation::Coarse()}) {
        const CondensedLog log(record, how);
        std::size_t next = 0;
        double charge_C = 0.0;
        for (const CondensedPiece& piece : log.pieces()) {
          ASSERT_EQ(piece.first, next);
          next += piece.rows;
          if (!piece.plain()) {
            charge_C += piece.current_A * piece.duration_s;
            continue;
          }
          for (std::size_t k = std::max<std::size_t>(piece.first, 1); k < next; ++k) {
            charge_C += record.current_A[hold == Hold::kBackward ? k : k - 1] *
                        (record.time_s[k] - record.time_s[k - 1]);
          }
        }
        EXPECT_EQ(next, record.size());
        EXPECT_NEAR(charge_C, DeliveredCharge(record).back(), 1e-9);
        // Noise makes every row another current: nothing is exact then but the rows, and the coarse
        // view sees through it.
        if (how.coarse) {
          EXPECT_LT(log.points(), 1500U) << noise_A;
        } else if (noise_A > 0.0) {
          EXPECT_EQ(log.points(), record.size());
        }
      }
    }
  }
}

// The coarse view is for comparing: its cost must rank starts as all rows do. Where residuals are
// as large as those of poor starts it is within a percent.
TEST(CondensedLog, TheCoarseViewRanksAsAllRowsDo) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  for (const double noise_A : {0.0, 0.03}) {
    Record record = Pulses(Hold::kBackward);
    for (double& i : record.current_A) i += noise_A * normal(engine);
    const VoltageSweep all(SetupWith(Curve(OcvMethod::kLinear)), {{.record = &record}});
    const VoltageSweep few(
        SetupWith(Curve(OcvMethod::kLinear)), {{.record = &record}}, Condensation::Coarse());
    for (const double beta : {0.03, 0.1, 0.2, 0.5, 1.0}) {
      const SweepParameters p = Parameters(beta, 1);
      const Eigen::Index last = VoltageSweep::Columns(1);
      const double expected = all.Factor(p, false)(last, last);
      const double cost = few.Factor(p, false)(last, last);
      EXPECT_NEAR(cost, expected, 0.01 * expected) << beta;
    }
    EXPECT_THROW(static_cast<void>(few.Errors(Parameters(0.2, 1))), PreconditionError);
  }
}

TEST(CondensedLog, TakesWhatIsShort) {
  const Record empty;
  EXPECT_EQ(CondensedLog(empty, Condensation::Exact()).points(), 0U);
  Record one;
  one.time_s = {1.0};
  one.current_A = {0.5};
  one.voltage_V = {3.7};
  for (const Condensation& how :
       {Condensation::None(), Condensation::Exact(), Condensation::Coarse()}) {
    EXPECT_EQ(CondensedLog(one, how).points(), 1U);
  }
}

}  // namespace
}  // namespace lipoid
