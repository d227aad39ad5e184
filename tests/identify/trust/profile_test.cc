#include "identify/trust/profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "identify/trust/trust_report.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

TrustReport Trust(double estimate, double standard_error, double rise) {
  QuantityTrust q;
  q.name = "p";
  q.estimate = estimate;
  q.standard_error = standard_error;
  q.degrees_of_freedom = 1e4;
  q.objective_rise_95 = rise;
  TrustReport trust;
  trust.quantities = {q};
  return trust;
}

ProfileTask Task(double estimate, Refit cost) {
  return {.name = "p", .unit = "V", .estimate = estimate, .lower = 0.0, .begin = [cost] {
            return cost;
          }};
}

// cost = c + ((p - p0)/s)^2 rises by d at p0 +- s sqrt(d).
TEST(Profile, OfAParabolaHasTheIntervalOfTheClosedForm) {
  constexpr double kEstimate = 7.0;
  constexpr double kWidth = 0.3;
  constexpr double kRise = 3.8415;
  const auto trust = Trust(kEstimate, kWidth, kRise);
  const auto profiles = FindProfiles({Task(kEstimate,
                                           [](double p) {
                                             const double t = (p - kEstimate) / kWidth;
                                             return ProfileCost{5.0 + t * t, 0.1};
                                           })},
                                     trust);
  ASSERT_EQ(profiles.size(), 1U);
  const Profile& profile = profiles[0];
  ASSERT_EQ(profile.points.size(), 21U);
  EXPECT_EQ(profile.points[10].value, kEstimate);
  EXPECT_EQ(profile.least_cost, 5.0);
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(profile.low, kEstimate - kWidth * std::sqrt(kRise), kRounding);
  EXPECT_NEAR(profile.high, kEstimate + kWidth * std::sqrt(kRise), kRounding);
  constexpr double kStudent = 1.9602;  // 10^4 degrees of freedom, 97.5 %: tables
  EXPECT_NEAR(profile.points[20].value - kEstimate, 1.5 * kStudent * kWidth, 1e-4 * kWidth);
}

// The valley of ln p: one end is nearer than the other.
TEST(Profile, FollowsAValleyThatIsNotSymmetric) {
  constexpr double kRise = 0.25;
  const auto trust = Trust(10.0, 20.0, kRise);  // wider than the estimate: equal ratios
  const auto profiles = FindProfiles({Task(10.0,
                                           [](double p) {
                                             const double t = std::log(p / 10.0);
                                             return ProfileCost{t * t, 0.1};
                                           })},
                                     trust);
  const Profile& profile = profiles[0];
  EXPECT_NEAR(profile.points.front().value, 2.0, 1e-12);
  EXPECT_NEAR(profile.points.back().value, 50.0, 1e-12);
  // A straight root between points 17 % apart errs by at most (0.16 / 2)^2 / 2 = 0.3 %.
  EXPECT_NEAR(profile.low / (10.0 * std::exp(-0.5)), 1.0, 0.004);
  EXPECT_NEAR(profile.high / (10.0 * std::exp(0.5)), 1.0, 0.004);
}

TEST(Profile, OfAFlatValleyHasNoEnds) {
  auto trust = Trust(10.0, kInfinity, kNaN);
  QuantityTrust other;
  other.name = "q";
  other.objective_rise_95 = 2.0;
  trust.quantities.push_back(other);
  const auto profiles = FindProfiles({Task(10.0,
                                           [](double) {
                                             return ProfileCost{1.0, 0.1};
                                           })},
                                     trust);
  EXPECT_TRUE(std::isnan(profiles[0].low));
  EXPECT_TRUE(std::isnan(profiles[0].high));
  EXPECT_EQ(profiles[0].rise_95, 2.0);
  EXPECT_EQ(profiles[0].rise_of, "q");
  const Json json = ProfilesToJson(profiles)[0];
  EXPECT_TRUE(json.at("interval_95")[0].is_null());
  EXPECT_TRUE(json.at("interval_95")[1].is_null());
  EXPECT_EQ(json.at("objective_rise_of"), "q");
}

// A fit that stays in its valley: the other one is found from the far end, on the way back.
TEST(Profile, TakesTheBetterOfTwoValleys) {
  const auto near = [](double p) { return std::pow(p - 1.0, 2); };
  const auto far = [](double p) { return 0.02 * std::pow(p - 1.0, 2) + 0.001; };
  auto task = Task(1.0, {});
  task.begin = [&]() -> Refit {
    auto crossed = std::make_shared<bool>(false);
    return [&near, &far, crossed](double p) {
      *crossed = *crossed || p > 1.25;
      return ProfileCost{*crossed ? far(p) : near(p), 0.1};
    };
  };
  const auto profile = FindProfiles({task}, Trust(1.0, 0.1, 0.01))[0];
  for (const auto& point : profile.points)
    EXPECT_NEAR(point.cost, std::min(near(point.value), far(point.value)), 1e-15) << point.value;
}

TEST(Profile, StaysWithinBoundsAndPassesOverFailedFits) {
  auto task = Task(1.0, [](double p) {
    if (p > 1.0 && p < 1.1) return ProfileCost{};
    return ProfileCost{(p - 1.0) * (p - 1.0), 0.1};
  });
  task.lower = 0.95;
  task.upper = 1.0 - 1e-12;  // the estimate lies beyond by a rounding
  const auto trust = Trust(1.0, 0.1, 0.01);
  // A sixth of the side is left, and of its ten points two.
  EXPECT_EQ(ProfileGrid(task, trust).size(), 3U);
  EXPECT_EQ(ProfileGrid(task, trust).front(), 0.95);
  EXPECT_EQ(ProfileGrid(task, trust).back(), 1.0);
  task.lower = 1.0 - 1e-9;  // and nothing of it
  EXPECT_EQ(ProfileGrid(task, trust).size(), 1U);
  task.lower = 0.95;
  task.upper = 2.0;
  const auto profile = FindProfiles({task}, trust)[0];
  EXPECT_TRUE(std::isnan(profile.low));  // the rise at 0.95 is a quarter of what it takes
  EXPECT_NEAR(profile.high, 1.1, 1e-9);  // the root is straight over the gap too
  EXPECT_TRUE(ProfilesToJson({profile})[0].at("points")[3].at("cost").is_null());
}

TEST(Profile, OfAZeroGoesAsFarAsIsTypical) {
  auto task = Task(0.0, [](double p) { return ProfileCost{p, 0.1}; });
  task.typical_reach = 2.0;
  const auto grid = ProfileGrid(task, Trust(0.0, kNaN, kNaN));
  EXPECT_EQ(grid.size(), 11U);
  EXPECT_EQ(grid.front(), 0.0);
  EXPECT_EQ(grid.back(), 3.0);
}

TEST(Profile, NamesThatCannotBeProfiledAreRefused) {
  EXPECT_NO_THROW(CheckProfileNames({"beta"}, {"beta", "r_s"}, {}));
  try {
    CheckProfileNames({"beta", "tau_7"}, {"beta", "r_s"}, {});
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(),
                 "option --profile: no parameter 'tau_7' in this fit; profiles can be had of "
                 "beta, r_s");
  }
}

}  // namespace
}  // namespace lipoid
