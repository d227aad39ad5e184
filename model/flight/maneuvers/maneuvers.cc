#include "model/flight/maneuvers/maneuvers.h"

#include "model/core/errors.h"
#include "model/core/nearest_name.h"

namespace lipoid {

const std::vector<Maneuver>& Maneuvers() {
  static const std::vector<Maneuver> all{
      {"hover", "stay at 1.1 m for 50 s", "section 6.1.5's height", &HoverPlan},
      {"altitude-steps",
       "0.4 m up and down between 1.1 m and 1.5 m, five times",
       "Fig 6.7, read off the picture",
       &AltitudeStepsPlan},
      {"attitude-doublets",
       "pitch by 4 degrees forward and back, 1.5 m each way, five times",
       "Fig 6.9, read off the picture",
       &AttitudeDoubletsPlan},
      {"square",
       "a square of 1.5 m at 1 m, counter-clockwise, a corner every 5 s",
       "Fig 6.11; the thesis gives no times",
       &SquarePlan},
      {"endurance",
       "hover at 1.1 m until the battery is empty",
       "ours",
       &EndurancePlan,
       /*until_empty=*/true},
      {"waypoints",
       "from place to place as a file says",
       "the user's file",
       &WaypointsPlan,
       /*until_empty=*/false,
       /*needs_file=*/true},
  };
  return all;
}

const Maneuver& FindManeuver(std::string_view name) {
  std::vector<std::string> known;
  for (const Maneuver& maneuver : Maneuvers()) {
    if (maneuver.name == name) return maneuver;
    known.emplace_back(maneuver.name);
  }
  throw OptionError(UnknownName("maneuver", name, known));
}

}  // namespace lipoid
