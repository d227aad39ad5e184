#include "model/battery/cell_model.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/battery/record_stepper.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
const double kPi = std::acos(-1.0);

// A straight line: v_oc is affine in A, so that every closed form below holds for the voltage too.
OpenCircuitVoltage StraightCurve() { return OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.25}); }

CellParameters<double> SmallCell() {
  CellParameters<double> cell;
  cell.alpha_C = 1353.6;
  cell.beta_per_sqrt_s = 0.1924;
  cell.series_resistance_Ohm = 0.1314;
  cell.branches = {{0.03, 45.0}, {0.012, 0.7}};
  cell.open_circuit_voltage = StraightCurve();
  return cell;
}

// 200 steps between 3 ms and 20 s.
std::vector<double> IrregularSteps(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> logarithm(std::log(0.003), std::log(20.0));
  std::vector<double> steps(200);
  for (double& step : steps) step = std::exp(logarithm(engine));
  return steps;
}

// Errors of single steps neither grow nor cancel: every mode decays. One rounding of each of 200
// steps.
constexpr double kManySteps = 200 * 4.0 * kEpsilon;

TEST(CellModel, EveryStateFollowsItsClosedFormUnderConstantCurrent) {
  const CellModel<double> model(SmallCell());
  const auto& p = model.parameters();
  for (const double current_A : {3.0, -1.2}) {
    auto state = model.Relaxed(1.0);
    double time_s = 0.0;
    for (const double dt_s : IrregularSteps(1)) {
      model.Advance(state, current_A, model.MakeStep(dt_s));
      time_s += dt_s;
      const double b2 = p.beta_per_sqrt_s * p.beta_per_sqrt_s;
      for (int m = 1; m <= p.terms; ++m) {
        const double rate = b2 * m * m;
        const double expected = current_A * -std::expm1(-rate * time_s) / rate;
        ASSERT_NEAR(state.unavailable_C[m - 1], expected, kManySteps * std::abs(expected))
            << m << " " << time_s;
      }
      ASSERT_NEAR(state.delivered_C, current_A * time_s, kManySteps * std::abs(current_A) * time_s);
      for (std::size_t j = 0; j < p.branches.size(); ++j) {
        const auto& branch = p.branches[j];
        const double expected = -branch.resistance_Ohm.resistance_Ohm[0] * current_A *
                                std::expm1(-time_s / branch.time_constant_s);
        ASSERT_NEAR(state.branch_V[j], expected, kManySteps * std::abs(expected))
            << j << " " << time_s;
      }
    }
  }
}

TEST(CellModel, VoltageIsMadeOfItsParts) {
  const CellModel<double> model(SmallCell());
  auto state = model.Relaxed(0.8);
  model.Advance(state, 3.0, model.MakeStep(100.0));
  const double b2 = 0.1924 * 0.1924;
  double sigma = 0.2 * 1353.6 + 300.0;
  double shares = kPi * kPi / 6.0;
  for (int m = 1; m <= 10; ++m) {
    sigma += 2.0 * 3.0 * -std::expm1(-b2 * m * m * 100.0) / (b2 * m * m);
    shares -= 1.0 / (m * m);
  }
  sigma += 2.0 * 3.0 / b2 * shares;  // the tail
  const double soc = 1.0 - sigma / 1353.6;
  const double drops =
      3.0 * (0.1314 - 0.03 * std::expm1(-100.0 / 45.0) - 0.012 * std::expm1(-100.0 / 0.7));
  EXPECT_NEAR(model.Soc(state, 3.0), soc, 16.0 * kEpsilon);
  EXPECT_NEAR(model.OpenCircuit(state, 3.0), 3.0 + 1.25 * soc, 32.0 * kEpsilon);
  EXPECT_NEAR(model.Voltage(state, 3.0), 3.0 + 1.25 * soc - drops, 32.0 * kEpsilon);
}

TEST(CellModel, RelaxedCellShowsItsOpenCircuitVoltage) {
  const CellModel<double> model(SmallCell());
  for (const double soc : {-0.1, 0.0, 0.25, 1.0, 1.1}) {
    const auto state = model.Relaxed(soc);
    EXPECT_NEAR(model.Soc(state, 0.0), soc, 2.0 * kEpsilon);
    EXPECT_NEAR(model.Voltage(state, 0.0), 3.0 + 1.25 * soc, 8.0 * kEpsilon);
  }
}

TEST(CellModel, ChargeIsNeitherMadeNorLost) {
  const CellModel<double> model(SmallCell());
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> current(-2.0, 4.0);
  auto state = model.Relaxed(1.0);
  long double charge_C = 0.0L;
  for (const double dt_s : IrregularSteps(2)) {
    const double current_A = current(engine);
    model.Advance(state, current_A, model.MakeStep(dt_s));
    charge_C += static_cast<long double>(current_A) * dt_s;
  }
  ASSERT_GT(std::abs(static_cast<double>(charge_C)), 50.0);
  // The partial sums stay below 2000 C; each of 200 additions rounds once.
  EXPECT_NEAR(state.delivered_C, static_cast<double>(charge_C), 200 * 2000.0 * kEpsilon);
  // After a rest of 40 slowest time constants nothing is held back: A counts the charge and no
  // more.
  const double rest_s = 40.0 / (0.1924 * 0.1924);
  model.Advance(state, 0.0, model.MakeStep(rest_s));
  EXPECT_NEAR(
      model.Soc(state, 0.0), 1.0 - static_cast<double>(charge_C) / 1353.6, 200 * 2.0 * kEpsilon);
}

TEST(CellModel, PulseRelaxesWithTheModesOfItsDiffusionAndBranches) {
  const CellModel<double> model(SmallCell());
  auto state = model.Relaxed(1.0);
  const double pulse_s = 30.0;
  model.Advance(state, 3.6, model.MakeStep(pulse_s));
  const double b2 = 0.1924 * 0.1924;
  double last_V = 0.0;
  for (const double rest_s : {0.0, 0.5, 5.0, 50.0, 500.0}) {
    auto rested = state;
    model.Advance(rested, 0.0, model.MakeStep(rest_s));
    double unavailable_C = 0.0;
    for (int m = 1; m <= 10; ++m) {
      const double rate = b2 * m * m;
      unavailable_C += 2.0 * 3.6 * -std::expm1(-rate * pulse_s) / rate * std::exp(-rate * rest_s);
    }
    const double branches_V =
        3.6 * (-0.03 * std::expm1(-pulse_s / 45.0) * std::exp(-rest_s / 45.0) -
               0.012 * std::expm1(-pulse_s / 0.7) * std::exp(-rest_s / 0.7));
    const double expected_V =
        3.0 + 1.25 * (1.0 - (3.6 * pulse_s + unavailable_C) / 1353.6) - branches_V;
    EXPECT_NEAR(model.Voltage(rested, 0.0), expected_V, 64.0 * kEpsilon) << rest_s;
    EXPECT_GT(model.Voltage(rested, 0.0), last_V) << "the voltage recovers";
    last_V = model.Voltage(rested, 0.0);
  }
}

// (4.40): a constant current holds back pi² I/(3 beta²) in the long run.
TEST(CellModel, SteadyUnavailableChargeComesNearerAsTermsGrow) {
  auto cell = SmallCell();
  const double current_A = 0.6;
  const double b2 = 0.1924 * 0.1924;
  const double steady_C = kPi * kPi * current_A / (3.0 * b2);
  const double long_s = 50.0 / b2;  // e^-50 of the slowest mode is left
  for (const int terms : {0, 1, 2, 5, 10, 50, 1000}) {
    cell.terms = terms;
    for (const bool tail : {false, true}) {
      cell.tail = tail;
      const CellModel<double> model(cell);
      auto state = model.Relaxed(1.0);
      model.Advance(state, current_A, model.MakeStep(long_s));
      const double unavailable_C = model.UnavailableCharge(state, current_A);
      if (tail) {
        EXPECT_NEAR(unavailable_C, steady_C, 64.0 * kEpsilon * steady_C) << terms;
      } else {
        // sum_{m > M} 1/m² lies between its integrals 1/(M+1) and 1/M: convergence is only first
        // order.
        const double missing = (steady_C - unavailable_C) / (2.0 * current_A / b2);
        EXPECT_GT(missing, 1.0 / (terms + 1.0)) << terms;
        if (terms > 0) {
          EXPECT_LT(missing, 1.0 / terms) << terms;
        }
        if (terms == 10) {
          EXPECT_NEAR(100.0 * (1.0 - unavailable_C / steady_C), 5.785, 0.0005);  // (4.41)
        }
      }
    }
  }
}

TEST(CellModel, TailSumIsWhatTheTermsLeaveOutOfItsLimit) {
  double sum = 0.0;
  for (int terms = 0; terms <= 1000; ++terms) {
    if (terms > 0) sum += 1.0 / (static_cast<double>(terms) * terms);
    ASSERT_NEAR(TailSum(terms), kPi * kPi / 6.0 - sum, 1000 * kEpsilon) << terms;
  }
}

// With the tail, M = 10 differs from the whole sum by the transients of the modes beyond M alone:
//   2 i/beta² sum_{m>M} e^{-beta² m² t}/m² <= 2 i/beta² TailSum(M) e^{-beta² (M+1)² t},
// and the comparison itself, cut at 1000 terms, by 2 i/beta² TailSum(1000).
TEST(CellModel, TailIsAsGoodAsManyMoreTerms) {
  auto cell = SmallCell();
  const double b2 = cell.beta_per_sqrt_s * cell.beta_per_sqrt_s;
  const double current_A = 3.0;
  cell.terms = 10;
  cell.tail = true;
  const CellModel<double> with_tail(cell);
  cell.tail = false;
  const CellModel<double> without_tail(cell);
  cell.terms = 1000;
  const CellModel<double> many(cell);
  for (const double time_s : {0.05, 0.5, 2.0, 10.0, 300.0}) {
    const auto unavailable = [&](const CellModel<double>& model) {
      auto state = model.Relaxed(1.0);
      model.Advance(state, current_A, model.MakeStep(time_s));
      return model.UnavailableCharge(state, current_A);
    };
    const double scale = 2.0 * current_A / b2;
    const double bound = scale * (TailSum(1000) + TailSum(10) * std::exp(-b2 * 121.0 * time_s));
    // The bound is met with equality once the transients are gone, up to the rounding of 1000
    // terms.
    EXPECT_LE(std::abs(unavailable(with_tail) - unavailable(many)), bound * (1.0 + 1e-10))
        << time_s;
    // Once the first neglected mode has settled the tail is far better than none.
    if (b2 * 121.0 * time_s > 5.0) {
      EXPECT_GT(unavailable(many) - unavailable(without_tail), 10.0 * bound) << time_s;
    }
  }
}

TEST(CellModel, TwoStepsAreTheirSum) {
  const CellModel<double> model(SmallCell());
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    auto twice = model.Relaxed(uniform(engine));
    for (double& mode : twice.unavailable_C) mode = 20.0 * uniform(engine);
    for (double& drop : twice.branch_V) drop = 0.2 * uniform(engine);
    auto once = twice;
    const double current_A = 6.0 * uniform(engine) - 2.0;
    // Sixteenths of a second: their sum is exact, so that only the steps differ.
    const double a = std::ceil(100.0 * uniform(engine)) / 16.0;
    const double b = std::ceil(100.0 * uniform(engine)) / 16.0;
    model.Advance(twice, current_A, model.MakeStep(a));
    model.Advance(twice, current_A, model.MakeStep(b));
    model.Advance(once, current_A, model.MakeStep(a + b));
    // Modes are below 20 C + 4 A/beta² = 130 C; three roundings and that of the exponent (z < 50
    // matters).
    for (std::size_t m = 0; m < once.unavailable_C.size(); ++m) {
      ASSERT_NEAR(twice.unavailable_C[m], once.unavailable_C[m], 16.0 * 130.0 * kEpsilon) << m;
    }
    for (std::size_t j = 0; j < once.branch_V.size(); ++j) {
      ASSERT_NEAR(twice.branch_V[j], once.branch_V[j], 16.0 * kEpsilon) << j;
    }
    ASSERT_NEAR(twice.delivered_C, once.delivered_C, 4.0 * 1400.0 * kEpsilon);
  }
}

TEST(CellModel, WithoutDiffusionTheStateOfChargeCountsChargeAlone) {
  auto cell = SmallCell();
  cell.diffusion = false;
  const CellModel<double> model(cell);
  auto state = model.Relaxed(1.0);
  model.Advance(state, 3.0, model.MakeStep(100.0));
  EXPECT_TRUE(state.unavailable_C.empty());
  EXPECT_EQ(model.UnavailableCharge(state, 3.0), 0.0);
  EXPECT_DOUBLE_EQ(model.Soc(state, 3.0), 1.0 - 300.0 / 1353.6);
}

TEST(CellModel, VeryFastDiffusionIsNone) {
  auto cell = SmallCell();
  cell.beta_per_sqrt_s = 1e6;  // holds back pi²/3e12 C per ampere
  const CellModel<double> fast(cell);
  cell.diffusion = false;
  const CellModel<double> none(cell);
  auto a = fast.Relaxed(1.0);
  auto b = none.Relaxed(1.0);
  fast.Advance(a, 3.0, fast.MakeStep(100.0));
  none.Advance(b, 3.0, none.MakeStep(100.0));
  EXPECT_NEAR(fast.Voltage(a, 3.0), none.Voltage(b, 3.0), 1e-13);
}

TEST(CellModel, BranchWithoutInertiaDropsWithTheCurrentOfTheStep) {
  auto cell = SmallCell();
  cell.branches = {{0.25, 0.0}};
  const CellModel<double> model(cell);
  auto state = model.Relaxed(1.0);
  model.Advance(state, 3.0, model.MakeStep(0.01));
  EXPECT_EQ(state.branch_V[0], 0.75);
  model.Advance(state, 0.0, model.MakeStep(0.01));
  EXPECT_NEAR(state.branch_V[0], 0.0, kAlive);
}

// As tau -> 0 the branch becomes that resistance, without a jump at 0.
TEST(CellModel, FasterAndFasterBranchesApproachTheOneWithoutInertia) {
  auto cell = SmallCell();
  for (const double tau_s : {1e-3, 1e-6, 1e-300}) {
    cell.branches = {{0.25, tau_s}};
    const CellModel<double> model(cell);
    auto state = model.Relaxed(1.0);
    model.Advance(state, 3.0, model.MakeStep(0.05));
    EXPECT_NEAR(state.branch_V[0], 0.75, 8.0 * kEpsilon) << tau_s;
  }
}

TEST(CellModel, StepTakesTheBranchResistanceAtTheChargeWithWhichItStarts) {
  auto cell = SmallCell();
  cell.diffusion = false;
  cell.alpha_C = 1000.0;
  cell.branches = {{Resistance<double>({0.0, 1.0}, {0.5, 0.25}), 10.0}};
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.0, 1.0});
  const CellModel<double> model(cell);
  auto state = model.Relaxed(0.5);
  model.Advance(state, 2.0, model.MakeStep(10.0));  // to A = 0.48
  EXPECT_NEAR(state.branch_V[0], 0.375 * 2.0 * -std::expm1(-1.0), 4.0 * kEpsilon);
  // r_s is taken where the voltage is asked for.
  const double branch_V = state.branch_V[0];
  EXPECT_NEAR(
      model.Voltage(state, 2.0), 3.0 + 1.25 * 0.48 - 0.48 * 2.0 - branch_V, 16.0 * kEpsilon);
}

TEST(CellModel, NaNInIsNaNOut) {
  const CellModel<double> model(SmallCell());
  EXPECT_TRUE(std::isnan(model.Voltage(model.Relaxed(std::nan("")), 1.0)));
}

// Automatic differentiation through a whole record against Ridders' differences, in every parameter
// and in the size of the current. The curve and the table of resistances have no node within reach:
// differences over a kink would not converge.
class CellModelDerivatives : public ::testing::TestWithParam<double> {};

constexpr int kParameters = 7;
const char* const kNames[kParameters] = {"alpha", "beta", "r_s", "r_1", "tau_1", "r_2", "current"};

template <class T>
T LastVoltageOfBranches(const std::vector<T>& x, Hold hold) {
  CellParameters<T> cell;
  cell.alpha_C = x[0];
  cell.beta_per_sqrt_s = x[1];
  cell.series_resistance_Ohm = x[2];
  cell.branches = {{x[3], x[4]}, {Resistance<T>({-1.0, 2.0}, {x[5], T(0.02)}), T(3.0)}};
  cell.open_circuit_voltage =
      OpenCircuitVoltage::Polynomial(-1.0, 2.0, {3.6, 0.5, -0.06, 0.05, -0.02, 0.01});
  const CellModel<T> model(cell);
  RecordStepper<T> stepper(model, hold, model.Relaxed(T(1.0)));
  double time_s = 0.0;
  const double steps_s[] = {0.01, 0.01, 1.0, 10.0, 0.37, 60.0};
  for (int k = 0; k < 40; ++k) {
    stepper.Row(time_s, (k % 3 == 0 ? 1.0 : k % 3 == 1 ? -0.3 : 0.6) * x[6]);
    time_s += steps_s[k % 6];
  }
  return stepper.Voltage();
}

TEST_P(CellModelDerivatives, AreThoseOfRiddersDifferences) {
  using Jet = ceres::Jet<double, kParameters>;
  const std::vector<double> at = {1353.6, GetParam(), 0.13, 0.03, 45.0, 0.05, 1.5};
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    std::vector<Jet> jets;
    for (int k = 0; k < kParameters; ++k) jets.emplace_back(at[k], k);
    const Jet voltage = LastVoltageOfBranches(jets, hold);
    // One definition; Jets divide by multiplying with the inverse, which rounds once more.
    EXPECT_NEAR(voltage.a, LastVoltageOfBranches(at, hold), 16.0 * kEpsilon * voltage.a);
    for (int k = 0; k < kParameters; ++k) {
      const auto f = [&](double x) {
        auto moved = at;
        moved[k] = x;
        return LastVoltageOfBranches(moved, hold);
      };
      const auto difference = test::Ridders(f, at[k], 0.1 * at[k]);
      // Rounding of a 4 V value over a step of 1 % of the parameter, or 1e-8 of the derivative.
      const double tolerance = 1e-8 * std::abs(difference.value) + 1e3 * kEpsilon / at[k];
      EXPECT_NEAR(voltage.v[k], difference.value, tolerance) << kNames[k] << " beta " << GetParam();
      EXPECT_NE(voltage.v[k], 0.0) << kNames[k];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FromSlowToFast,
                         CellModelDerivatives,
                         ::testing::Values(0.05, 0.1924, 0.7, 1.0));

}  // namespace
}  // namespace lipoid
