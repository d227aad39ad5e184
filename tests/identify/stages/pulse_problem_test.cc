#include "identify/stages/pulse_problem.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "model/battery/record_stepper.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using PulseJet = ceres::Jet<double, 6>;

constexpr ParameterScale kScales[] = {ParameterScale::kNatural,
                                      ParameterScale::kTypical,
                                      ParameterScale::kLog,
                                      ParameterScale::kMixed};

// Smooth: differences extrapolate over kinks, also those of the second derivative, as if they were
// not there.
OpenCircuitVoltage CurveOfPolynomial() {
  return OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.8, 0.45, -0.05, 0.08});
}

Record Pulses() {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Record record;
  for (int k = 0; k < 600; ++k) {
    record.time_s.push_back(2.0 * k);
    record.current_A.push_back(k % 150 < 20 ? 3.0 : 0.0);
    record.voltage_V.push_back(4.1 - 2e-4 * k - 0.1 * record.current_A.back() +
                               0.02 * unit(engine));
  }
  return record;
}

JointSetup SmallSetup() {
  return {.alpha_C = 2000.0, .terms = 6, .tail = true, .open_circuit_voltage = CurveOfPolynomial()};
}

// Two branches of which the first is described by its capacitance where those are the unknowns:
// value and gradient of 1/2 ||r||² in natural parameters (beta, r_s, r_1, r_2, then what stands
// beside), by automatic differentiation of the cell itself.
PulseJet CostByJets(const Record& record, const PulseParameters& p) {
  CellParameters<PulseJet> cell;
  const JointSetup setup = SmallSetup();
  cell.alpha_C = PulseJet(setup.alpha_C);
  cell.beta_per_sqrt_s = PulseJet(p.sweep.beta_per_sqrt_s, 0);
  cell.terms = setup.terms;
  cell.tail = setup.tail;
  cell.open_circuit_voltage = setup.open_circuit_voltage;
  cell.series_resistance_Ohm = Resistance<PulseJet>(PulseJet(p.sweep.series_resistance_Ohm, 1));
  for (std::size_t j = 0; j < 2; ++j) {
    const int at = static_cast<int>(j);
    const PulseJet r(p.sweep.resistance_Ohm[j], 2 + at);
    const PulseJet tau = std::isnan(p.capacitance_F[j])
                             ? PulseJet(p.sweep.time_constant_s[j], 4 + at)
                             : r * PulseJet(p.capacitance_F[j], 4 + at);
    cell.branches.push_back({Resistance<PulseJet>(r), tau});
  }
  const CellModel<PulseJet> model(std::move(cell));
  RecordStepper<PulseJet> stepper(model, record.hold, model.Relaxed(PulseJet(1.0)));
  PulseJet cost(0.0);
  for (std::size_t k = 0; k < record.size(); ++k) {
    stepper.Row(record.time_s[k], PulseJet(record.current_A[k]));
    const PulseJet residual = record.voltage_V[k] - stepper.Voltage();
    cost += 0.5 * residual * residual;
  }
  return cost;
}

struct Case {
  bool capacitances;
  ParameterScale scale;
};

template <class Check>
void ForEveryCase(const GivenParameters& known, Check&& check) {
  const Record record = Pulses();
  const VoltageSweep sweep(SmallSetup(), {{.record = &record}});
  for (const bool capacitances : {false, true}) {
    for (const ParameterScale scale : kScales) {
      SCOPED_TRACE(testing::Message()
                   << "capacitances " << capacitances << ", scale " << static_cast<int>(scale));
      const auto unknowns =
          FindPulseUnknowns(sweep.setup(),
                            FindStartValues({&record}),
                            {.branches = 2, .capacitances = capacitances, .scale = scale},
                            known);
      check(record, unknowns, PulseProblem(sweep, unknowns.variables, unknowns.start));
    }
  }
}

double Cost(const PulseProblem& problem, const Eigen::VectorXd& x) {
  return 0.5 * problem.Factor(x, false).rightCols(1).squaredNorm();
}

Eigen::VectorXd Gradient(const PulseProblem& problem, const Eigen::VectorXd& x) {
  const Eigen::MatrixXd factor = problem.Factor(x, true);
  const Eigen::Index n = x.size();
  return factor.leftCols(n).transpose() * factor.col(n);
}

// The sweep keeps ten digits and more; Ridders' differences say themselves how far they can be
// trusted.
TEST(PulseProblem, HasTheGradientThatDifferencesSee) {
  ForEveryCase({}, [](const Record&, const PulseUnknowns&, const PulseProblem& problem) {
    for (const double at : {0.9, 1.3}) {
      Eigen::VectorXd here(problem.size());
      for (int k = 0; k < problem.size(); ++k) {
        const PulseVariable& v = problem.variables()[static_cast<std::size_t>(k)];
        // Around values of a small cell.
        const double p = v.kind == PulseVariable::Kind::kBeta           ? 0.2
                         : v.resistive()                                ? 0.03
                         : v.kind == PulseVariable::Kind::kTimeConstant ? 50.0
                                                                        : 1500.0;
        here[k] = v.ToX(at * p * (v.branch == 1 ? 0.3 : 1.0));
      }
      const Eigen::VectorXd gradient = Gradient(problem, here);
      for (int k = 0; k < problem.size(); ++k) {
        const auto along = [&](double value) {
          Eigen::VectorXd moved = here;
          moved[k] = value;
          return Cost(problem, moved);
        };
        const auto expected =
            test::Ridders(along, here[k], 0.05 * std::max(std::abs(here[k]), 1e-3));
        EXPECT_NEAR(
            gradient[k], expected.value, 10.0 * expected.error + 1e-8 * std::abs(expected.value))
            << problem.variables()[static_cast<std::size_t>(k)].name;
      }
    }
  });
}

// On bounds differences have only one side: automatic differentiation does not mind.
TEST(PulseProblem, HasTheGradientOfTheCellAlsoOnBounds) {
  ForEveryCase({}, [](const Record& record, const PulseUnknowns&, const PulseProblem& problem) {
    for (const bool upper : {false, true}) {
      for (int on = 0; on < problem.size(); ++on) {
        Eigen::VectorXd x = problem.Point(
            {.sweep = {0.3, 0.04, {0.02, 0.05}, {30.0, 200.0}}, .capacitance_F = {1500.0, 4000.0}});
        const double bound = upper ? problem.upper()[on] : problem.lower()[on];
        if (std::abs(bound) > 1e300) continue;
        x[on] = bound;
        const PulseParameters p = problem.Parameters(x);
        // A branch faster than anything has no slope that a finite precision could tell.
        if (p.sweep.time_constant_s[0] < 1e-6 || p.sweep.time_constant_s[1] < 1e-6) continue;
        const PulseJet cost = CostByJets(record, p);
        const Eigen::VectorXd gradient = Gradient(problem, x);
        EXPECT_NEAR(Cost(problem, x), cost.a, 1e-10 * cost.a);
        for (int k = 0; k < problem.size(); ++k) {
          const PulseVariable& v = problem.variables()[static_cast<std::size_t>(k)];
          const int column = v.kind == PulseVariable::Kind::kBeta               ? 0
                             : v.kind == PulseVariable::Kind::kSeriesResistance ? 1
                             : v.kind == PulseVariable::Kind::kResistance
                                 ? 2 + static_cast<int>(v.branch)
                                 : 4 + static_cast<int>(v.branch);
          const double expected = cost.v[column] * v.Slope(Entry(p, v));
          EXPECT_NEAR(gradient[k], expected, 1e-9 * std::abs(expected) + 1e-12 * cost.a)
              << v.name << " with " << problem.variables()[static_cast<std::size_t>(on)].name
              << " on its bound";
        }
      }
    }
  });
}

TEST(PulseProblem, TakesItsPointsBack) {
  ForEveryCase({}, [](const Record&, const PulseUnknowns& unknowns, const PulseProblem& problem) {
    const Eigen::VectorXd x = problem.Point(unknowns.start);
    const Eigen::VectorXd again = problem.Point(problem.Parameters(x));
    EXPECT_LT((again - x).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_TRUE((x.array() >= problem.lower().array()).all());
    EXPECT_TRUE((x.array() <= problem.upper().array()).all());
    // Both ways of naming a branch start from the same cell.
    for (std::size_t j = 0; j < 2; ++j) {
      if (std::isnan(unknowns.start.capacitance_F[j])) continue;
      EXPECT_NEAR(unknowns.start.sweep.time_constant_s[j],
                  unknowns.start.capacitance_F[j] * unknowns.start.sweep.resistance_Ohm[j],
                  1e-9);
    }
  });
}

TEST(PulseProblem, ScalesToOrderOne) {
  ForEveryCase({}, [](const Record&, const PulseUnknowns& unknowns, const PulseProblem& problem) {
    const Eigen::VectorXd x = problem.Point(unknowns.start);
    const bool natural = unknowns.variables[1].unit == 1.0;  // that of r_s is far below one
    if (natural) {
      EXPECT_EQ(x[1], unknowns.start.sweep.series_resistance_Ohm);
    } else {
      EXPECT_LT(x.cwiseAbs().maxCoeff(), 10.0);
    }
  });
}

TEST(PulseProblem, ABranchThatTheUserNamesByItsCapacitanceGoesByIt) {
  const Record record = Pulses();
  const auto unknowns = FindPulseUnknowns(SmallSetup(),
                                          FindStartValues({&record}),
                                          {.branches = 2},
                                          {.bounds = {{"c_2", {10.0, 1e5}}}});
  EXPECT_EQ(unknowns.variables[4].name, "tau_1");  // after beta, r_s, r_1 and r_2
  EXPECT_EQ(unknowns.variables[5].name, "c_2");
  const auto other = FindPulseUnknowns(SmallSetup(),
                                       FindStartValues({&record}),
                                       {.branches = 1, .capacitances = true},
                                       {.fixed = {{"tau_1", 20.0}}});
  EXPECT_EQ(other.variables.back().name, "r_1");  // tau_1 is held, and no c_1 stands in its place
  EXPECT_EQ(other.start.sweep.time_constant_s[0], 20.0);
}

}  // namespace
}  // namespace lipoid
