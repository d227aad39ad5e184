#include "identify/trust/profile_report.h"

#include <nlohmann/json.hpp>

namespace lipoid {

Json ProfilesToJson(const std::vector<Profile>& profiles) {
  Json all = Json::array();
  for (const Profile& profile : profiles) {
    Json points = Json::array();
    for (const ProfilePoint& point : profile.points) {
      points.push_back({{"value", point.value},
                        {"cost", NumberOrNull(point.cost)},
                        {"rmse_V", NumberOrNull(point.rmse_V)}});
    }
    all.push_back(
        {{"name", profile.name},
         {"unit", profile.unit},
         {"estimate", NumberOrNull(profile.estimate)},
         {"points", std::move(points)},
         {"interval_95", {NumberOrNull(profile.low), NumberOrNull(profile.high)}},
         {"objective_rise_95", NumberOrNull(profile.rise_95)},
         {"objective_rise_of", profile.rise_of.empty() ? profile.name : profile.rise_of}});
  }
  return all;
}

}  // namespace lipoid
