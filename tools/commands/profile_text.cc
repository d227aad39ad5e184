#include "tools/commands/profile_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/cli/text_table.h"

namespace lipoid {
namespace {

using cli::Significant;

constexpr int kBarColumns = 40;  // of bars
constexpr int kThreshold = 20;   // column at which 95 % end

// As many digits as it takes to tell the points apart.
int Digits(const Profile& profile) {
  double digits = 5.0;
  for (std::size_t k = 1; k < profile.points.size(); ++k) {
    const double value = profile.points[k].value;
    const double step = value - profile.points[k - 1].value;
    if (step > 0.0) digits = std::max(digits, std::ceil(std::log10(std::abs(value) / step)) + 1.0);
  }
  return static_cast<int>(std::min(digits, 9.0));
}

std::string IntervalText(const Profile& profile) {
  const auto text = [digits = Digits(profile)](double value) { return Significant(value, digits); };
  const bool low = std::isfinite(profile.low);
  const bool high = std::isfinite(profile.high);
  if (low && high) return fmt::format("95 % from {} to {}", text(profile.low), text(profile.high));
  const double first = profile.points.front().value;
  const double last = profile.points.back().value;
  if (low) {
    return fmt::format("95 % from {}, no end up to {}", text(profile.low), text(last));
  }
  if (high) {
    return fmt::format("95 % to {}, no end down to {}", text(profile.high), text(first));
  }
  return fmt::format("no end from {} to {}", text(first), text(last));
}

std::string BarText(const Profile& profile, const ProfilePoint& point) {
  if (!std::isfinite(point.cost)) return "the fit failed";
  const double share =
      profile.rise_95 > 0.0 ? (point.cost - profile.least_cost) / profile.rise_95 : 0.0;
  const int length =
      static_cast<int>(std::min<double>(kBarColumns, std::round(kThreshold * share)));
  std::string bar(static_cast<std::size_t>(length), '#');
  if (length < kThreshold) {
    bar.append(static_cast<std::size_t>(kThreshold - length), ' ');
    bar += '|';
  }
  if (length == kBarColumns) bar.back() = '>';
  return bar;
}

}  // namespace

std::string ProfilesText(const std::vector<Profile>& profiles) {
  std::string text;
  for (const Profile& profile : profiles) {
    if (!text.empty()) text += "\n";
    if (profile.points.empty()) {
      text += fmt::format("profile of {}: {}\n", profile.name, profile.none_because);
      continue;
    }
    text +=
        fmt::format("profile of {} / {}: {}\n", profile.name, profile.unit, IntervalText(profile));
    const int digits = Digits(profile);
    for (const ProfilePoint& point : profile.points) {
      text += fmt::format("{} {:>13}  {}\n",
                          point.value == profile.estimate ? "  *" : "   ",
                          Significant(point.value, digits),
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
