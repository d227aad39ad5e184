#include "model/battery/open_circuit_voltage.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "model/core/errors.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::kEpsilon;

const std::vector<double> kSoc = {
    0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
const std::vector<double> kVoltage_V = {
    3.0, 3.3, 3.45, 3.6, 3.7, 3.74, 3.77, 3.82, 3.87, 3.95, 4.02, 4.11, 4.2};

OpenCircuitVoltage NinthDegree() {
  return OpenCircuitVoltage::Polynomial(
      0.01, 0.99, {3.75, 0.45, -0.06, 0.08, -0.03, 0.02, -0.015, 0.008, -0.004, 0.002});
}

OpenCircuitVoltage SevenHarmonics() {
  return OpenCircuitVoltage::Fourier(0.0,
                                     1.0,
                                     2.7,
                                     {3.8, -0.2, 0.05, -0.02, 0.01, 0.005, -0.002, 0.001},
                                     {0.15, 0.04, -0.03, 0.01, -0.004, 0.002, -0.001});
}

struct Form {
  std::string name;
  std::function<OpenCircuitVoltage()> make;
};
void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

class EveryForm : public ::testing::TestWithParam<Form> {};

TEST_P(EveryForm, IsContinuous) {
  const auto curve = GetParam().make();
  // Slopes stay below 20 V: over 1e-9 the voltage moves 2e-8 V at most, a jump at a node would be
  // seen.
  for (int k = -200; k <= 1200; ++k) {
    const double soc = 0.001 * k;
    EXPECT_NEAR(curve(soc + 1e-9), curve(soc - 1e-9), 4e-8) << soc;
  }
}

TEST_P(EveryForm, SlopeIsThatOfRiddersDifferences) {
  const auto curve = GetParam().make();
  std::mt19937 engine(8);
  std::uniform_real_distribution<double> uniform(-0.2, 1.2);
  int tried = 0;
  while (tried < 300) {
    const double soc = uniform(engine);
    // Differences over a node see two pieces, and so they do over the ends.
    const auto near = [&](double node) { return std::abs(soc - node) < 2e-3; };
    if (near(curve.soc_lo()) || near(curve.soc_hi()) ||
        std::any_of(curve.soc().begin(), curve.soc().end(), near)) {
      continue;
    }
    ++tried;
    const auto difference = test::Ridders([&](double x) { return curve(x); }, soc, 1e-3);
    // 4 V * eps over a step of 1e-3, and the method's own 1e-9.
    EXPECT_NEAR(
        curve.Evaluate(soc).slope_V, difference.value, 1e-9 * std::abs(difference.value) + 1e-11)
        << soc;
  }
}

TEST_P(EveryForm, ContinuesWithItsEndSlopes) {
  const auto curve = GetParam().make();
  for (const double beyond : {0.01, 0.3, 5.0}) {
    const auto lowest = curve.Evaluate(curve.soc_lo());
    const auto below = curve.Evaluate(curve.soc_lo() - beyond);
    EXPECT_NEAR(below.value_V, lowest.value_V - beyond * lowest.slope_V, 1e-13 * (1.0 + beyond));
    EXPECT_EQ(below.slope_V, lowest.slope_V);
    const auto highest = curve.Evaluate(curve.soc_hi());
    const auto above = curve.Evaluate(curve.soc_hi() + beyond);
    EXPECT_NEAR(above.value_V, highest.value_V + beyond * highest.slope_V, 1e-13 * (1.0 + beyond));
    EXPECT_EQ(above.slope_V, highest.slope_V);
    EXPECT_FALSE(curve.InRange(curve.soc_lo() - beyond));
    EXPECT_FALSE(curve.InRange(curve.soc_hi() + beyond));
  }
  EXPECT_TRUE(curve.InRange(curve.soc_lo()));
  EXPECT_TRUE(curve.InRange(curve.soc_hi()));
}

TEST_P(EveryForm, CarriesDerivativesByTheChainRule) {
  const auto curve = GetParam().make();
  using Jet = ceres::Jet<double, 2>;
  for (const double soc : {-0.1, 0.03, 0.55, 1.1}) {
    Jet x(soc);
    x.v << 2.0, -3.0;
    const Jet voltage = curve(x);
    const auto plain = curve.Evaluate(soc);
    EXPECT_EQ(voltage.a, plain.value_V);
    EXPECT_EQ(voltage.v[0], plain.slope_V * 2.0);
    EXPECT_EQ(voltage.v[1], plain.slope_V * -3.0);
  }
}

TEST_P(EveryForm, SocAtVoltageIsTheInverse) {
  const auto curve = GetParam().make();
  const double lowest_V = curve(curve.soc_lo());
  const double highest_V = curve(curve.soc_hi());
  for (int k = 1; k < 50; ++k) {
    const double wanted_V = lowest_V + (highest_V - lowest_V) * k / 50.0;
    const double soc = curve.SocAtVoltage(wanted_V);
    // The neighbouring double is already above: one rounding of A times the slope (20 V), and of
    // the value.
    EXPECT_NEAR(curve(soc), wanted_V, 30.0 * kEpsilon) << wanted_V;
    // No higher A in range has this voltage.
    for (double higher = soc + 1e-9; higher < curve.soc_hi(); higher += 0.001) {
      ASSERT_GT(curve(higher), wanted_V - 16.0 * kEpsilon) << wanted_V << " " << higher;
    }
  }
  EXPECT_EQ(curve.SocAtVoltage(highest_V + 1.0), curve.soc_hi());
  EXPECT_EQ(curve.SocAtVoltage(highest_V), curve.soc_hi());
  EXPECT_EQ(curve.SocAtVoltage(lowest_V - 1.0), curve.soc_lo());
}

TEST_P(EveryForm, GivesNaNForNaN) {
  EXPECT_TRUE(std::isnan(GetParam().make()(std::numeric_limits<double>::quiet_NaN())));
}

INSTANTIATE_TEST_SUITE_P(
    OpenCircuitVoltage,
    EveryForm,
    ::testing::Values(Form{"linear", [] { return OpenCircuitVoltage::Linear(kSoc, kVoltage_V); }},
                      Form{"monotone_cubic",
                           [] { return OpenCircuitVoltage::MonotoneCubic(kSoc, kVoltage_V); }},
                      Form{"polynomial", NinthDegree},
                      Form{"fourier", SevenHarmonics}),
    [](const auto& test) { return test.param.name; });

TEST(OpenCircuitVoltage, LinearHitsItsNodesAndHalvesItsIntervals) {
  const auto curve = OpenCircuitVoltage::Linear(kSoc, kVoltage_V);
  for (std::size_t k = 0; k < kSoc.size(); ++k) EXPECT_EQ(curve(kSoc[k]), kVoltage_V[k]) << k;
  for (std::size_t k = 0; k + 1 < kSoc.size(); ++k) {
    EXPECT_NEAR(curve(0.5 * (kSoc[k] + kSoc[k + 1])),
                0.5 * (kVoltage_V[k] + kVoltage_V[k + 1]),
                4.0 * 4.2 * kEpsilon)
        << k;
  }
}

// Half a million crowded, uneven nodes: every piece is found through the table of buckets.
TEST(OpenCircuitVoltage, FindsItsPieceAmongManyUnevenNodes) {
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> logarithm(std::log(1e-9), std::log(1e-3));
  std::vector<double> soc = {-0.07};
  std::vector<double> voltage_V = {3.0};
  while (soc.back() < 1.02) {
    soc.push_back(soc.back() + std::exp(logarithm(engine)));
    voltage_V.push_back(3.0 + 0.1 * static_cast<double>(engine() % 1000) / 1000.0);
  }
  const auto curve = OpenCircuitVoltage::Linear(soc, voltage_V);
  for (std::size_t k = 0; k < soc.size(); ++k) ASSERT_EQ(curve(soc[k]), voltage_V[k]) << k;
  for (std::size_t k = 0; k + 1 < soc.size(); ++k) {
    const double middle = 0.5 * (soc[k] + soc[k + 1]);
    if (!(middle > soc[k] && middle < soc[k + 1])) continue;
    const double share = (middle - soc[k]) / (soc[k + 1] - soc[k]);
    ASSERT_NEAR(curve(middle), voltage_V[k] + share * (voltage_V[k + 1] - voltage_V[k]), 1e-14)
        << k;
  }
}

TEST(OpenCircuitVoltage, MonotoneCubicHitsItsNodesAndStaysMonotone) {
  std::mt19937 engine(10);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<double> soc = {0.0};
    std::vector<double> voltage_V = {3.0};
    for (int k = 0; k < 12; ++k) {
      soc.push_back(soc.back() + 0.001 + uniform(engine));
      // Plateaus, gentle and steep rises.
      voltage_V.push_back(voltage_V.back() + (k % 4 == 1 ? 0.0 : std::pow(uniform(engine), 4.0)));
    }
    const auto curve = OpenCircuitVoltage::MonotoneCubic(soc, voltage_V);
    for (std::size_t k = 0; k < soc.size(); ++k) ASSERT_EQ(curve(soc[k]), voltage_V[k]);
    double before_V = voltage_V.front();
    for (int k = 0; k <= 4000; ++k) {
      const auto at = curve.Evaluate(soc.back() * k / 4000.0);
      ASSERT_GE(at.value_V, before_V - 16.0 * kEpsilon) << "trial " << trial << ", " << k;
      ASSERT_GE(at.slope_V, -1e-12) << "trial " << trial << ", " << k;
      before_V = at.value_V;
    }
  }
}

TEST(OpenCircuitVoltage, MonotoneCubicHasTheSlopesOfPchip) {
  // By hand from the rule of Fritsch and Butland with the three-point ends, h = 1:
  //   chords 1, 2, 0, -1: inner slopes 2/(1/1 + 1/2) = 4/3, 0, 0;
  //   first (3*1 - 2)/2 = 1/2; last (3*(-1) - 0)/2 = -3/2.
  const auto curve = OpenCircuitVoltage::MonotoneCubic({0, 1, 2, 3, 4}, {0, 1, 3, 3, 2});
  const double slopes[] = {0.5, 4.0 / 3.0, 0.0, 0.0, -1.5};
  for (int k = 0; k < 5; ++k)
    EXPECT_NEAR(curve.Evaluate(k).slope_V, slopes[k], 8.0 * kEpsilon) << k;
  // An end that the parabola would turn around is flat; one that it would overshoot is three
  // chords.
  EXPECT_EQ(OpenCircuitVoltage::MonotoneCubic({0, 1, 2, 3}, {0, 1, 5, 6}).Evaluate(0.0).slope_V,
            0.0);
  EXPECT_EQ(OpenCircuitVoltage::MonotoneCubic({0, 1, 2, 3}, {0, 1, -9, -9}).Evaluate(0.0).slope_V,
            3.0);
}

// Its cubic is exact for straight lines, and nodes on a smooth curve give fourth order.
TEST(OpenCircuitVoltage, MonotoneCubicReproducesALine) {
  const auto curve =
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.1, 0.5, 0.7, 1.0}, {3.0, 3.1, 3.5, 3.7, 4.0});
  for (int k = 0; k <= 100; ++k) EXPECT_NEAR(curve(0.01 * k), 3.0 + 0.01 * k, 16.0 * kEpsilon) << k;
}

// T_k(x) = cos(k arccos x), summed term by term.
TEST(OpenCircuitVoltage, PolynomialIsTheChebyshevSeries) {
  const auto curve = NinthDegree();
  const auto& coefficients_V = curve.coefficients_V();
  for (int j = 0; j <= 200; ++j) {
    const double soc = 0.01 + 0.98 * j / 200.0;
    const double x = std::clamp((2.0 * soc - 0.01 - 0.99) / (0.99 - 0.01), -1.0, 1.0);
    double sum_V = 0.0;
    for (std::size_t k = 0; k < coefficients_V.size(); ++k) {
      sum_V += coefficients_V[k] * std::cos(static_cast<double>(k) * std::acos(x));
    }
    // arccos loses half of the digits of 1 - |x|: k² times one rounding of x.
    EXPECT_NEAR(curve(soc), sum_V, 100.0 * kEpsilon) << soc;
  }
}

TEST(OpenCircuitVoltage, PolynomialOfDegreeZeroAndOne) {
  const auto flat = OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.7});
  EXPECT_EQ(flat(0.3), 3.7);
  EXPECT_EQ(flat.Evaluate(-2.0).slope_V, 0.0);
  const auto line = OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.5, 0.5});  // 3 + A
  EXPECT_EQ(line(0.25), 3.25);
  EXPECT_EQ(line.Evaluate(0.25).slope_V, 1.0);
}

TEST(OpenCircuitVoltage, FourierIsItsSumOfHarmonics) {
  const auto curve =
      OpenCircuitVoltage::Fourier(0.0, 1.0, 2.0, {3.75, -0.25, 0.125}, {0.5, -0.0625});
  for (int j = 0; j <= 20; ++j) {
    const double soc = 0.05 * j;
    const double expected_V = 3.75 - 0.25 * std::cos(2.0 * soc) + 0.5 * std::sin(2.0 * soc) +
                              0.125 * std::cos(4.0 * soc) - 0.0625 * std::sin(4.0 * soc);
    EXPECT_NEAR(curve(soc), expected_V, 8.0 * 4.0 * kEpsilon) << soc;
  }
}

TEST(OpenCircuitVoltage, SocAtVoltageOfADippingCurveIsTheHighest) {
  const auto curve =
      OpenCircuitVoltage::Linear({0.0, 0.25, 0.5, 0.75, 1.0}, {3.0, 3.5, 3.25, 3.5, 4.0});
  EXPECT_NEAR(curve.SocAtVoltage(3.375), 0.625, kEpsilon);  // not 0.1875, not 0.375
  EXPECT_NEAR(curve.SocAtVoltage(3.125), 0.0625, kEpsilon);
}

TEST(OpenCircuitVoltage, SocAtVoltageOnAPlateauIsItsUpperEnd) {
  const auto curve = OpenCircuitVoltage::Linear({0.0, 0.25, 0.75, 1.0}, {3.0, 3.5, 3.5, 4.0});
  EXPECT_NEAR(curve.SocAtVoltage(3.5), 0.75, kEpsilon);
}

// A cell whose curve ends flat empties all the same.
TEST(OpenCircuitVoltage, AFlatEndGoesOnWithTheNextChordThatRises) {
  const auto curve =
      OpenCircuitVoltage::Linear({0.0, 0.1, 0.2, 0.3, 1.0, 1.1}, {3.2, 3.2, 3.2, 3.3, 4.2, 4.2});
  EXPECT_DOUBLE_EQ(curve(0.1), 3.2);
  EXPECT_DOUBLE_EQ(curve(-0.1), 3.1);  // 1 V per unit, as between 0.2 and 0.3
  EXPECT_NEAR(curve.Evaluate(-0.1).slope_V, 1.0, 1e-12);
  EXPECT_NEAR(curve(1.2), 4.2 + 0.1 * 0.9 / 0.7, 1e-12);
  const auto source = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.0, 4.0});
  EXPECT_EQ(source(-1.0), 4.0);
}

TEST(OpenCircuitVoltage, DefaultIsNoCurve) {
  const OpenCircuitVoltage none;
  for (const double soc : {-1.0, 0.0, 0.5, 1.0, 2.0}) EXPECT_TRUE(std::isnan(none(soc))) << soc;
}

TEST(OpenCircuitVoltage, RefusesNodesThatMakeNoCurve) {
  using Curve = OpenCircuitVoltage;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)Curve::Linear({0.0}, {3.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Linear({0.0, 1.0}, {3.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Linear({0.0, 0.0}, {3.0, 4.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Linear({1.0, 0.0}, {3.0, 4.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Linear({0.0, nan}, {3.0, 4.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Linear({0.0, 1.0}, {3.0, nan}), PreconditionError);
  EXPECT_THROW((void)Curve::MonotoneCubic({0.0, 0.5, 1.0}, {3.0, 3.5, 4.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Polynomial(1.0, 0.0, {3.0}), PreconditionError);
  EXPECT_THROW((void)Curve::Polynomial(0.0, 1.0, {}), PreconditionError);
  EXPECT_THROW((void)Curve::Fourier(0.0, 1.0, 1.0, {3.0}, {0.1}), PreconditionError);
  EXPECT_THROW((void)Curve::Fourier(0.0, 0.0, 1.0, {3.0}, {}), PreconditionError);
}

}  // namespace
}  // namespace lipoid
