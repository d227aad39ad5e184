#pragma once

/// @file
/// Profile likelihood: one parameter is held at each value of a grid and all others are refitted.
///
/// The least cost that is left, over the value, shows what an interval of +- so many standard
/// errors cannot: a valley that is flat to one side, or has no end. Where the cost rises above its
/// least by QuantityTrust::objective_rise_95 the 95 % interval ends. That rise knows of the
/// correlation of the residuals; for a parabola the profile and the interval of the standard error
/// are the same. docs/verdicts.md. Tests: tests/identify/trust/profile_test.cc.

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "identify/trust/trust.h"

namespace lipoid {

/// What is left when all other parameters are refitted.
struct ProfileCost {
  double cost = std::numeric_limits<double>::quiet_NaN();    ///< NaN: the fit failed
  double rmse_V = std::numeric_limits<double>::quiet_NaN();  ///< rows weighted as in the cost
};

struct ProfilePoint {
  double value = 0.0;
  double cost = 0.0;
  double rmse_V = 0.0;
};

struct Profile {
  std::string name;
  std::string unit;
  double estimate = 0.0;
  std::vector<ProfilePoint> points;  ///< rising
  std::string none_because;          ///< in a sentence, where there are no points
  double rise_95 = std::numeric_limits<double>::quiet_NaN();  ///< of the cost, where 95 % end
  std::string rise_of;  ///< the parameter whose rise was taken, where its own is not known
  double least_cost = std::numeric_limits<double>::quiet_NaN();  ///< of the points
  double low = std::numeric_limits<double>::quiet_NaN();         ///< NaN: not within the grid
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// The refit at a value; each call may start from where the last one ended.
using Refit = std::function<ProfileCost(double value)>;

/// One parameter, and how to refit the others.
struct ProfileTask {
  std::string name;
  std::string unit;
  double estimate = 0.0;
  double lower = 0.0;  ///< the grid stays within
  double upper = std::numeric_limits<double>::infinity();
  /// Of the estimate, where it is known otherwise than by its trust: for what stands at zero.
  double typical_reach = std::numeric_limits<double>::quiet_NaN();
  /// A refit that starts at the estimate. Two are made: each goes to one end first, then across.
  std::function<Refit()> begin;
};

inline constexpr int kProfilePointsPerSide = 10;

/// Rising values around the estimate, which is one of them: half as far again as the 95 % interval,
/// some three standard errors. Where that is unknown or wider than the estimate itself
/// from a fifth to five times it, in equal ratios; around zero as far as `typical_reach`. Fewer where a bound is nearer.
[[nodiscard]] std::vector<double> ProfileGrid(const ProfileTask& task, const TrustReport& trust);

/// Sets rise_95, least_cost and the ends of the interval, from the points. Between points the root
/// of the rise is taken as straight, which is exact for a parabola.
void FindProfileInterval(Profile& profile, const TrustReport& trust);

/// Side by side; the same whatever the number of threads.
[[nodiscard]] std::vector<Profile> FindProfiles(const std::vector<ProfileTask>& tasks,
                                                const TrustReport& trust);

/// Throws OptionError, listing what can be profiled, where one of the names cannot.
void CheckProfileNames(const std::vector<std::string>& names,
                       const std::vector<std::string>& available,
                       const std::vector<std::string>& fixed);

}  // namespace lipoid
