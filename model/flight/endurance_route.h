#pragma once

/// @file
/// A route of waypoints as a mission of powers: flown once by the simulator, with its controller, on
/// the battery that is asked about. Tests: tests/model/flight/endurance_route_test.cc.

#include <string>

#include "model/control/gains.h"
#include "model/flight/endurance_request.h"

namespace lipoid {

/// What the battery gives while the vehicle of the request, with its payload, flies the waypoints of
/// a file: a leg for each control step of 5 ms. The power hardly depends on the battery, so that the
/// route may be repeated on an emptier one. OptionError where the vehicle crashes on its way or misses a
/// waypoint, LoadError for a file that is no list of waypoints.
[[nodiscard]] PowerMission FlyRoute(const EnduranceRequest& request,
                                    const Gains& gains,
                                    const std::string& waypoints_file);

}  // namespace lipoid
