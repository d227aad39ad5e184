#include "model/export/gazebo_law.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

struct Steps {
  double count;
  double dt_s;
  double share;  // dt/tau, at most 1
};

Steps StepsOf(const GazeboBattery& battery, double length_s) {
  const double count = std::max(1.0, std::rint(length_s / kGazeboStep_s));
  const double dt_s = length_s / count;
  return {count, dt_s, dt_s / std::max(battery.smoothing_s, dt_s)};
}

double VoltageOf(const GazeboBattery& battery, double drawn_Ah, double smooth_A) {
  return battery.constant_V + battery.linear_V * drawn_Ah / battery.capacity_Ah -
         battery.resistance_Ohm * smooth_A;
}

}  // namespace

std::vector<double> GazeboVoltage(const GazeboBattery& battery,
                                  const ExportMission& mission,
                                  const std::vector<double>& drawn_Ah) {
  std::vector<double> volts(mission.time_s.size());
  if (volts.empty()) return volts;
  double smooth_A = 0.0;
  double out_Ah = drawn_Ah.front();
  volts[0] = VoltageOf(battery, out_Ah, smooth_A);
  // Rows are evenly spaced, but for the rounding of their times: one power serves them all.
  constexpr double kSameLength = 1e-9;
  Steps steps = {};
  double length_s = -1.0;
  double left = 0.0;
  for (std::size_t k = 1; k < volts.size(); ++k) {
    const double current_A = mission.FlowBefore_A(k);
    const double row_s = mission.time_s[k] - mission.time_s[k - 1];
    if (!(std::abs(row_s - length_s) <= kSameLength * row_s)) {
      length_s = row_s;
      steps = StepsOf(battery, length_s);
      // A geometric series: all steps of a row at once.
      left = steps.share < 1.0 ? std::exp(steps.count * std::log1p(-steps.share)) : 0.0;
    }
    const double lag_A = smooth_A - current_A;
    out_Ah += steps.dt_s *
              (steps.count * current_A + lag_A * (1.0 - steps.share) * (1.0 - left) / steps.share) /
              3600.0;
    smooth_A = current_A + lag_A * left;
    volts[k] = VoltageOf(battery, out_Ah, smooth_A);
  }
  return volts;
}

std::vector<double> GazeboVoltageUnderPower(const GazeboBattery& battery,
                                            const ExportMission& mission,
                                            const std::vector<double>& power_W,
                                            const std::vector<double>& drawn_Ah) {
  std::vector<double> volts(mission.time_s.size());
  if (volts.empty()) return volts;
  double smooth_A = 0.0;
  double out_Ah = drawn_Ah.front();
  double v = VoltageOf(battery, out_Ah, smooth_A);
  volts[0] = v;
  for (std::size_t k = 1; k < volts.size(); ++k) {
    const Steps steps = StepsOf(battery, mission.time_s[k] - mission.time_s[k - 1]);
    for (double n = 0.0; n < steps.count; n += 1.0) {
      smooth_A += steps.share * (power_W[k] / v - smooth_A);
      out_Ah += steps.dt_s * smooth_A / 3600.0;
      v = VoltageOf(battery, out_Ah, smooth_A);
    }
    volts[k] = v;
  }
  return volts;
}

}  // namespace lipoid
