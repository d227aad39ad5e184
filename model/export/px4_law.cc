#include "model/export/px4_law.h"

#include <algorithm>
#include <cmath>

namespace lipoid {

std::vector<double> Px4Voltage(const Px4Battery& battery,
                               const ExportMission& mission,
                               const std::vector<double>& drawn_Ah) {
  std::vector<double> volts(mission.time_s.size());
  for (std::size_t k = 0; k < volts.size(); ++k) {
    const double left = 1.0 - 1000.0 * drawn_Ah[k] / battery.capacity_mAh;
    volts[k] = battery.cells * (battery.empty_V + left * (battery.charged_V - battery.empty_V) -
                                battery.resistance_Ohm * mission.current_A[k]);
  }
  return volts;
}

std::vector<double> Px4StateOfCharge(const Px4Battery& battery,
                                     const ExportMission& mission,
                                     const std::vector<double>& voltage_V) {
  std::vector<double> shown(mission.time_s.size());
  if (shown.empty()) return shown;
  const auto empty_V = static_cast<float>(battery.empty_V);
  const auto span_V = static_cast<float>(battery.charged_V) - empty_V;
  const auto ohm = static_cast<float>(battery.resistance_Ohm);
  const auto capacity_mAh = static_cast<float>(battery.capacity_mAh);
  const auto corrected = [&](std::size_t row, double current_A) {
    // Only a discharge is corrected for its drop.
    const auto amps = static_cast<float>(std::max(current_A, 0.0));
    return static_cast<float>(voltage_V[row] / battery.cells) + ohm * amps;
  };
  const auto by_voltage = [&](float volts) {
    return std::clamp((volts - empty_V) / span_V, 0.0F, 1.0F);
  };
  float low_pass_V = corrected(0, mission.current_A[0]);
  float soc = by_voltage(low_pass_V);
  float discharged_mAh = 0.0F;
  shown[0] = soc;
  for (std::size_t k = 1; k < shown.size(); ++k) {
    const double length_s = mission.time_s[k] - mission.time_s[k - 1];
    const double current_A = mission.FlowBefore_A(k);
    const double updates = std::max(1.0, std::rint(length_s * kPx4Updates_per_s));
    const auto dt_s = static_cast<float>(length_s / updates);
    const float step_mAh = static_cast<float>(current_A) * 1e3F * (dt_s / 3600.0F);
    const float share = dt_s / (dt_s + 1.0F);
    const float volts = corrected(k, current_A);
    for (double n = 0.0; n < updates; n += 1.0) {
      discharged_mAh += step_mAh;
      low_pass_V += share * (volts - low_pass_V);
      const float soc_v = by_voltage(low_pass_V);
      const float weight = 0.03F * (1.0F - soc_v);
      soc = std::max((1.0F - weight) * soc + weight * soc_v - step_mAh / capacity_mAh, 0.0F);
      soc = std::min(std::max(1.0F - discharged_mAh / capacity_mAh, 0.0F), soc);
    }
    shown[k] = soc;
  }
  return shown;
}

}  // namespace lipoid
