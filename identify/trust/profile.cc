#include "identify/trust/profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

constexpr double kBeyondInterval = 1.5;
constexpr double kUnknownFactor = 5.0;

// The value at which the root of the rise crosses that of the threshold, going outward from the
// least point. NaN where it never does.
double Crossing(const Profile& profile, std::size_t least, int direction) {
  const auto root = [&](const ProfilePoint& point) {
    return std::sqrt(std::max(0.0, point.cost - profile.least_cost));
  };
  const double wanted = std::sqrt(profile.rise_95);
  const ProfilePoint* inner = &profile.points[least];
  const auto size = static_cast<std::ptrdiff_t>(profile.points.size());
  for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(least) + direction; k >= 0 && k < size;
       k += direction) {
    const ProfilePoint& outer = profile.points[static_cast<std::size_t>(k)];
    if (!std::isfinite(outer.cost)) continue;
    if (root(outer) >= wanted) {
      const double share = (wanted - root(*inner)) / (root(outer) - root(*inner));
      return inner->value + share * (outer.value - inner->value);
    }
    inner = &outer;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

// The better of two fits; one that failed is none.
void Keep(ProfileCost& best, const ProfileCost& other) {
  if (std::isfinite(other.cost) && !(best.cost <= other.cost)) best = other;
}

}  // namespace

std::vector<double> ProfileGrid(const ProfileTask& task, const TrustReport& trust) {
  const double estimate = task.estimate;
  const QuantityTrust* quantity = FindQuantity(trust, task.name);
  double reach = quantity != nullptr ? Reach95(*quantity) : task.typical_reach;
  if (!std::isfinite(reach) && estimate == 0.0) reach = task.typical_reach;
  const double half_width = kBeyondInterval * reach;
  const bool linear = std::isfinite(half_width) && (half_width < estimate || estimate == 0.0);
  const double from = linear ? estimate - half_width : estimate / kUnknownFactor;
  const double to = linear ? estimate + half_width : estimate * kUnknownFactor;

  std::vector<double> grid{estimate};
  // As dense where a bound cuts a side short. An estimate at a bound, or beyond by a rounding, has nothing there.
  const auto towards = [&](double whole, double end) {
    if (end == estimate || !std::isfinite(end)) return;
    const double left = linear ? (end - estimate) / (whole - estimate)
                               : std::log(end / estimate) / std::log(whole / estimate);
    constexpr double kRounding = 1e-6;
    const auto points = static_cast<int>(std::ceil(kProfilePointsPerSide * (left - kRounding)));
    for (int k = 1; k <= points; ++k) {
      const double share = static_cast<double>(k) / points;
      grid.push_back(k == points ? end
                     : linear    ? estimate + share * (end - estimate)
                                 : estimate * std::pow(end / estimate, share));
    }
  };
  towards(from, std::min(estimate, std::max(from, task.lower)));
  towards(to, std::max(estimate, std::min(to, task.upper)));
  std::sort(grid.begin(), grid.end());
  return grid;
}

void FindProfileInterval(Profile& profile, const TrustReport& trust) {
  const QuantityTrust* own = FindQuantity(trust, profile.name);
  if (own != nullptr && std::isfinite(own->objective_rise_95)) {
    profile.rise_95 = own->objective_rise_95;
  } else {
    // The most that any other parameter needs: what is not known should not look narrow.
    for (const QuantityTrust& other : trust.quantities) {
      if (!std::isfinite(other.objective_rise_95)) continue;
      if (profile.rise_95 >= other.objective_rise_95) continue;
      profile.rise_95 = other.objective_rise_95;
      profile.rise_of = other.name;
    }
  }
  std::size_t least = profile.points.size();
  for (std::size_t k = 0; k < profile.points.size(); ++k) {
    const double cost = profile.points[k].cost;
    if (!std::isfinite(cost) || profile.least_cost <= cost) continue;
    profile.least_cost = cost;
    least = k;
  }
  if (least == profile.points.size() || !(profile.rise_95 > 0.0)) return;
  profile.low = Crossing(profile, least, -1);
  profile.high = Crossing(profile, least, 1);
}

std::vector<Profile> FindProfiles(const std::vector<ProfileTask>& tasks, const TrustReport& trust) {
  std::vector<Profile> profiles(tasks.size());
  std::vector<std::size_t> centre(tasks.size(), 0);
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const ProfileTask& task = tasks[t];
    profiles[t].name = task.name;
    profiles[t].unit = task.unit;
    profiles[t].estimate = task.estimate;
    if (!std::isfinite(task.estimate)) {
      profiles[t].none_because = "it has no value, for its branch has no resistance";
      continue;
    }
    for (const double value : ProfileGrid(task, trust)) {
      if (value < task.estimate) ++centre[t];
      profiles[t].points.push_back({.value = value});
    }
  }
  // Two walks each: away from the estimate to one end, then across to the other. So a point is
  // refitted from either side, and the better valley counts.
  std::vector<std::vector<ProfileCost>> found(2 * tasks.size());
  ParallelFor(found.size(), [&](std::size_t walk) {
    const std::size_t t = walk / 2;
    const auto& points = profiles[t].points;
    if (points.empty()) return;
    const bool upward = walk % 2 == 0;
    const Refit refit = tasks[t].begin();
    found[walk].resize(points.size());
    const auto visit = [&](std::size_t k) { Keep(found[walk][k], refit(points[k].value)); };
    const std::size_t size = points.size();
    for (std::size_t k = centre[t]; upward && k < size; ++k) visit(k);
    for (std::size_t k = upward ? size - 1 : centre[t] + 1; k-- > 0;) visit(k);
    for (std::size_t k = 1; !upward && k < size; ++k) visit(k);
  });
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    for (std::size_t k = 0; k < profiles[t].points.size(); ++k) {
      Keep(found[2 * t][k], found[2 * t + 1][k]);
      profiles[t].points[k].cost = found[2 * t][k].cost;
      profiles[t].points[k].rmse_V = found[2 * t][k].rmse_V;
    }
  }
  for (Profile& profile : profiles) FindProfileInterval(profile, trust);
  return profiles;
}

void CheckProfileNames(const std::vector<std::string>& names,
                       const std::vector<std::string>& available,
                       const std::vector<std::string>& fixed) {
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const std::string& name : names) {
    if (has(available, name)) continue;
    throw OptionError(fmt::format(
        "option --profile: {}; {}",
        has(fixed, name) ? fmt::format("'{}' is given, or follows from what is", name)
                         : fmt::format("no parameter '{}' in this fit", name),
        available.empty() ? std::string("every parameter was given")
                          : fmt::format("profiles can be had of {}", fmt::join(available, ", "))));
  }
}

}  // namespace lipoid
