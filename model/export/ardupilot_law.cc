#include "model/export/ardupilot_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lipoid {
namespace {

struct Row {
  float volts;
  float percent;
};

// Falling: the resting voltage of a cell at a percentage of its capacity.
constexpr std::array<Row, 40> kTable{{
    {4.173F, 100.0F}, {4.112F, 96.15F}, {4.085F, 92.31F}, {4.071F, 88.46F}, {4.039F, 84.62F},
    {3.987F, 80.77F}, {3.943F, 76.92F}, {3.908F, 73.08F}, {3.887F, 69.23F}, {3.854F, 65.38F},
    {3.833F, 61.54F}, {3.801F, 57.69F}, {3.783F, 53.85F}, {3.742F, 50.0F},  {3.715F, 46.15F},
    {3.679F, 42.31F}, {3.636F, 38.46F}, {3.588F, 34.62F}, {3.543F, 30.77F}, {3.503F, 26.92F},
    {3.462F, 23.08F}, {3.379F, 19.23F}, {3.296F, 15.38F}, {3.218F, 11.54F}, {3.165F, 7.69F},
    {3.091F, 3.85F},  {2.977F, 2.0F},   {2.8F, 1.5F},     {2.7F, 1.3F},     {2.5F, 1.2F},
    {2.3F, 1.1F},     {2.1F, 1.0F},     {1.9F, 0.9F},     {1.6F, 0.8F},     {1.3F, 0.7F},
    {1.0F, 0.6F},     {0.6F, 0.4F},     {0.3F, 0.2F},     {0.01F, 0.01F},   {0.001F, 0.001F},
}};

template <class T>
T Resting(T percent) {
  for (std::size_t k = 1; k < kTable.size(); ++k) {
    if (percent >= T(kTable[k].percent)) {
      const T share =
          (percent - T(kTable[k].percent)) / (T(kTable[k - 1].percent) - T(kTable[k].percent));
      return T(kTable[k].volts) + share * (T(kTable[k - 1].volts) - T(kTable[k].volts));
    }
  }
  return T(0.001F);
}

constexpr double kFilter_s = 1.0 / (2.0 * std::numbers::pi * 10.0);

}  // namespace

double ArduPilotRestingVoltage(double percent) { return Resting(percent); }

std::vector<double> ArduPilotTablePercents() {
  std::vector<double> percents;
  for (auto row = kTable.rbegin(); row != kTable.rend(); ++row) percents.push_back(row->percent);
  return percents;
}

std::vector<double> ArduPilotVoltage(const ArduPilotBattery& battery,
                                     const ExportMission& mission,
                                     const std::vector<double>& drawn_Ah) {
  const auto full_V = static_cast<float>(battery.full_V);
  const auto capacity_Ah = static_cast<float>(battery.capacity_Ah);
  const auto resistance_Ohm = static_cast<float>(battery.resistance_Ohm);
  const auto filter_s = static_cast<float>(kFilter_s);
  const auto rest = [&](float remaining_Ah) {
    return Resting(100.0F * remaining_Ah / capacity_Ah) / static_cast<float>(kArduPilotFull_V) *
           full_V;
  };
  std::vector<double> volts(mission.time_s.size());
  if (volts.empty()) return volts;
  auto remaining_Ah = static_cast<float>(battery.capacity_Ah - drawn_Ah.front());
  float v = rest(remaining_Ah);
  volts[0] = v;
  for (std::size_t k = 1; k < volts.size(); ++k) {
    const double dt_s = mission.time_s[k] - mission.time_s[k - 1];
    const double steps = std::max(1.0, std::rint(dt_s * kArduPilotSteps_per_s));
    const auto dt = static_cast<float>(dt_s / steps);
    const auto current_A = static_cast<float>(mission.FlowBefore_A(k));
    const float step_Ah = current_A * dt / 3600.0F;
    const float share = dt / (dt + filter_s);
    for (double n = 0.0; n < steps; n += 1.0) {
      remaining_Ah = std::max(0.0F, remaining_Ah - step_Ah);
      v += share * (rest(remaining_Ah) - current_A * resistance_Ohm - v);
    }
    volts[k] = v;
  }
  return volts;
}

std::vector<double> ArduPilotVoltageSmooth(const ArduPilotBattery& battery,
                                           const ExportMission& mission,
                                           const std::vector<double>& drawn_Ah) {
  const auto rest = [&](double out_Ah) {
    const double percent = 100.0 * std::max(0.0, 1.0 - out_Ah / battery.capacity_Ah);
    return Resting(percent) / kArduPilotFull_V * battery.full_V;
  };
  std::vector<double> volts(mission.time_s.size());
  if (volts.empty()) return volts;
  volts[0] = rest(drawn_Ah[0]);
  for (std::size_t k = 1; k < volts.size(); ++k) {
    const double decay = std::exp(-(mission.time_s[k] - mission.time_s[k - 1]) / kFilter_s);
    const double goal_V = rest(drawn_Ah[k]) - battery.resistance_Ohm * mission.FlowBefore_A(k);
    volts[k] = goal_V + decay * (volts[k - 1] - goal_V);
  }
  return volts;
}

}  // namespace lipoid
