#include "tools/commands/profile_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/cli/text_table.h"

namespace lipoid {
namespace {

using cli::Significant;

constexpr int kColumns = 40;    // of bars
constexpr int kThreshold = 20;  // column at which 95 % end

std::string IntervalText(const Profile& profile) {
  const bool low = std::isfinite(profile.low);
  const bool high = std::isfinite(profile.high);
  if (low && high)
    return fmt::format("95 % from {} to {}", Significant(profile.low), Significant(profile.high));
  const double first = profile.points.front().value;
  const double last = profile.points.back().value;
  if (low) {
    return fmt::format(
        "95 % from {}, no end up to {}", Significant(profile.low), Significant(last));
  }
  if (high) {
    return fmt::format(
        "95 % to {}, no end down to {}", Significant(profile.high), Significant(first));
  }
  return fmt::format("no end from {} to {}", Significant(first), Significant(last));
}

std::string BarText(const Profile& profile, const ProfilePoint& point) {
  if (!std::isfinite(point.cost)) return "the fit failed";
  const double share =
      profile.rise_95 > 0.0 ? (point.cost - profile.least_cost) / profile.rise_95 : 0.0;
  const int length = static_cast<int>(std::min<double>(kColumns, std::round(kThreshold * share)));
  std::string bar(static_cast<std::size_t>(length), '#');
  if (length < kThreshold) {
    bar.append(static_cast<std::size_t>(kThreshold - length), ' ');
    bar += '|';
  }
  if (length == kColumns) bar.back() = '>';
  return bar;
}

}  // namespace

std::string ProfilesText(const std::vector<Profile>& profiles) {
  std::string text;
  for (const Profile& profile : profiles) {
    if (!text.empty()) text += "\n";
    if (profile.points.empty()) {
      text += fmt::format("profile of {}: it has no value, for its branch has no resistance\n",
                          profile.name);
      continue;
    }
    text += fmt::format(
        "profile of {} / {}: {}\n", profile.name, profile.unit, IntervalText(profile));
    for (const ProfilePoint& point : profile.points) {
      text += fmt::format("{} {:>12}  {}\n",
                          point.value == profile.estimate ? "  *" : "   ",
                          Significant(point.value, 5),
                          BarText(profile, point));
    }
    text += fmt::format("   *: the estimate; |: where 95 % end{}\n",
                        profile.rise_of.empty()
                            ? std::string()
                            : fmt::format(", by the errors of {}", profile.rise_of));
  }
  return text;
}

}  // namespace lipoid
