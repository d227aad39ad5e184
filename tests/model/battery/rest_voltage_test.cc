#include "model/battery/rest_voltage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/core/errors.h"
#include "tests/support/charge_counter.h"
#include "tests/support/constants.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::ChargeCounter;
using test::kEpsilon;

TEST(RestVoltage, GivesTheChargeAtWhichAPackRests) {
  Cell pack = ChargeCounter();
  pack.series = 2;
  EXPECT_NEAR(SocAtRestVoltage(pack, 7.5), 0.75, 4.0 * kEpsilon);
  EXPECT_EQ(
      test::MessageOf<OptionError>([&] { (void)SocAtRestVoltage(pack, 3.7); }),
      "initial voltage: expected one that v_oc(A) of the pack of 2 cells in series has, 6 .. 8 V, found 3.7 V, "
      "which is that of one of them: give 7.4");
}

TEST(RestVoltage, OfHysteresisIsThatWithWhichAPredictionBegins) {
  Cell pack = ChargeCounter();
  pack.series = 2;
  pack.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.02}};
  const double soc = SocAtRestVoltage(pack, 7.5);
  const std::vector<double> time_s{0.0, 1.0};
  const std::vector<double> current_A{0.0, 0.0};
  EXPECT_NEAR(Predict(pack, time_s, current_A, Hold::kBackward, soc).voltage_V[0], 7.5, 1e-12);
  EXPECT_NEAR(std::abs(soc - 0.75), 0.02, 1e-12);
  EXPECT_EQ(NearestSocAtRest(pack, 7.5), soc);
}

// Full it rests on the branch of charge, 4.02 V, and just below on that of discharge, 3.98 V.
TEST(RestVoltage, OfHysteresisReachesAFullPack) {
  Cell pack = ChargeCounter();
  pack.series = 2;
  pack.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.02}};
  EXPECT_EQ(SocAtRestVoltage(pack, 8.04), 1.0);
  EXPECT_EQ(SocAtRestVoltage(pack, 8.02), 1.0);
  const double discharged = SocAtRestVoltage(pack, 7.97);
  EXPECT_LT(discharged, 1.0);
  EXPECT_NEAR(discharged, 1.0, 1e-12);
  EXPECT_NEAR(SocAtRestVoltage(pack, 7.94), 0.99, 1e-12);
  EXPECT_EQ(NearestSocAtRest(pack, 8.5), 1.0);
  EXPECT_EQ(
      test::MessageOf<OptionError>([&] { (void)SocAtRestVoltage(pack, 8.05); }),
      "initial voltage: expected one that v_oc(A) of the pack of 2 cells in series has, 5.96 .. 8.04 V, found 8.05 V");
}

// v_oc is 3 V + A volts at 25 degC, and 1 mV/K less in the cold: 2.98 V + A volts at 5 degC.
TEST(RestVoltage, IsThatAtTheTemperatureOfTheCell) {
  Cell pack = ChargeCounter();
  pack.series = 2;
  Cell::Temperature& term = pack.temperature.emplace();
  term.entropy.emplace().slope_V_per_K = {1e-3};
  EXPECT_NEAR(SocAtRestVoltage(pack, 7.5), 0.75, 1e-12);
  EXPECT_NEAR(SocAtRestVoltage(pack, 7.5, {.ambient_degC = 5.0}), 0.77, 1e-12);
  const std::vector<double> measured_degC{5.0, 10.0};
  EXPECT_NEAR(NearestSocAtRest(pack, 7.5, {.measured_degC = measured_degC}), 0.77, 1e-12);
  EXPECT_NEAR(NearestSocAtRest(pack, 8.0, {.ambient_degC = 5.0}), 1.0, 1e-12);
  const auto too_high = [&] { (void)SocAtRestVoltage(pack, 8.0, {.ambient_degC = 5.0}); };
  EXPECT_EQ(
      test::MessageOf<OptionError>(too_high),
      "initial voltage: expected one that v_oc(A) of the pack of 2 cells in series has, 5.96 .. 7.96 V, found 8 V");
}

}  // namespace
}  // namespace lipoid
