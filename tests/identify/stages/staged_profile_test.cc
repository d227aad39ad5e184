#include "identify/stages/staged_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "identify/stages/staged_trust.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/pulse_record.h"

namespace lipoid {
namespace {

// Eight pulses of 60 s with 900 s of rest, once a second, under 0.2 mV of white noise.
Record NoisyPulseRecord(double branch_Ohm) {
  Record record = test::PulseRecord(branch_Ohm);
  NormalNoise normal(5, 0);
  for (double& voltage_V : record.voltage_V) voltage_V += 2e-4 * normal();
  return record;
}

// A fit, and how its parameters are profiled.
struct Fitted {
  explicit Fitted(double branch_Ohm, GivenParameters knowledge = {})
      : record(NoisyPulseRecord(branch_Ohm)),
        given(std::move(knowledge)),
        sweep({.alpha_C = cell.alpha_C(), .open_circuit_voltage = cell.open_circuit_voltage},
              {{.record = &record}}),
        data(FindStartValues({&record})),
        fit(FitPulses(sweep, {.data = data}, {}, {}, given)),
        trust(AssessStaged(sweep, fit, std::nullopt)) {}

  [[nodiscard]] std::vector<Profile> Profiles(const std::vector<std::string>& names) const {
    return ProfileStaged(names, sweep, data, fit, trust, {}, {}, given);
  }

  Cell cell = LoadCell("gifi-600mAh-1");
  Record record;
  GivenParameters given;
  VoltageSweep sweep;
  StartValues data;
  PulseFitResult fit;
  TrustReport trust;
};

std::size_t LeastPoint(const Profile& profile) {
  std::size_t least = 0;
  for (std::size_t k = 0; k < profile.points.size(); ++k) {
    if (profile.points[k].cost < profile.points[least].cost) least = k;
  }
  return least;
}

// The model is nearly linear over these short intervals: profile and standard error agree, though
// one comes from refits and the other from sensitivities.
TEST(StagedProfile, AgreesWithTheStandardErrorWhereTheModelIsNearlyLinear) {
  const Fitted fitted(0.03);
  const auto profiles = fitted.Profiles({"beta", "r_s", "r_1", "tau_1", "c_1"});
  ASSERT_EQ(profiles.size(), 5U);
  for (const Profile& profile : profiles) {
    SCOPED_TRACE(profile.name);
    const QuantityTrust& wald = *FindQuantity(fitted.trust, profile.name);
    EXPECT_EQ(profile.estimate, wald.estimate);
    EXPECT_EQ(profile.unit, wald.unit);
    ASSERT_EQ(profile.points.size(), 21U);
    EXPECT_EQ(LeastPoint(profile), 10U);
    // The refit at the estimate is the fit.
    EXPECT_NEAR(profile.points[10].rmse_V, fitted.fit.errors.rmse, 1e-12);
    constexpr double kCurvature = 0.15;
    EXPECT_NEAR((wald.estimate - profile.low) / (wald.estimate - wald.low), 1.0, kCurvature);
    EXPECT_NEAR((profile.high - wald.estimate) / (wald.high - wald.estimate), 1.0, kCurvature);
    // Others are refitted: one step of the grid costs what the curvature of the profile says, and
    // not the much more that the parameter alone would.
    EXPECT_NEAR(
        (profile.points[20].cost - profile.least_cost) / profile.rise_95, 1.5 * 1.5, 0.3 * 2.25);
  }
}

// The thesis' situation. Whatever its time constant, a branch that is not there does not help.
TEST(StagedProfile, OfABranchThatIsNotThereIsFlat) {
  const Fitted fitted(0.0, {.fixed = {{"r_1", 0.0}}});
  const Profile tau = fitted.Profiles({"tau_1"})[0];
  ASSERT_GE(tau.points.size(), 11U);
  EXPECT_GE(tau.points.back().value, 2.0 * tau.points.front().value);
  for (const auto& point : tau.points) EXPECT_NEAR(point.cost / tau.least_cost, 1.0, 1e-9);
  EXPECT_TRUE(std::isnan(tau.low));
  EXPECT_TRUE(std::isnan(tau.high));
}

// The same where r_1 is free to be found: noise may leave it a trace, but nothing with ends.
TEST(StagedProfile, OfABranchThatWasNotFoundHasNoEnds) {
  const Fitted fitted(0.0);
  const auto profiles = fitted.Profiles({"tau_1", "r_1", "c_1"});
  EXPECT_TRUE(std::isnan(profiles[0].low) || std::isnan(profiles[0].high));
  EXPECT_TRUE(std::isnan(profiles[1].low));  // zero is as good as any
}

// Names that were given, or follow from what was.
TEST(StagedProfile, RefusesWhatIsHeld) {
  const GivenParameters given{.fixed = {{"tau_1", 25.0}}};
  EXPECT_NO_THROW(CheckStagedProfile({"beta", "r_1"}, {}, given));
  for (const char* name : {"tau_1", "c_1"}) {
    try {
      CheckStagedProfile({name}, {}, given);
      FAIL() << name;
    } catch (const OptionError& error) {
      EXPECT_EQ(std::string(error.what()),
                std::string("option --profile: '") + name +
                    "' is given, or follows from what is; profiles can be had of beta, r_s, r_1");
    }
  }
  EXPECT_THROW(CheckStagedProfile({"r_2"}, {}, {}), OptionError);
  EXPECT_THROW(CheckStagedProfile({"alpha"}, {}, {}), OptionError);
  EXPECT_THROW(CheckStagedProfile({"beta"}, {.diffusion = false}, {}), OptionError);
}

}  // namespace
}  // namespace lipoid
