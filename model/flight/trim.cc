#include "model/flight/trim.h"

#include <algorithm>
#include <cmath>

#include "model/vehicle/level_flight.h"

namespace lipoid {
namespace {

constexpr int kRounds = 50;  // each leaves a hundredth of the difference

}  // namespace

Trim HoverTrim(const Vehicle& vehicle, const Supply<double>& supply, bool compensate) {
  const LevelFlight hover = HoverByCoefficients(vehicle);
  Trim trim;
  trim.speed_rad_per_s = hover.speed_rad_per_s;
  trim.motor_V = hover.motor_V;
  trim.motor_A = hover.motor_A;
  const double open_V = supply.voltage_V;
  trim.battery_V = open_V;
  // Without diodes and switching the power does not depend on v_b, and one round is enough.
  for (int round = 0; round < kRounds; ++round) {
    const double before_V = trim.battery_V;
    // The power is fixed: v_b (E - v_b)/R = P is a quadratic in v_b, whose upper root is the working
    // point.
    const double power_W = BatteryPower(vehicle, hover, before_V);
    const double discriminant = open_V * open_V - 4.0 * supply.resistance_Ohm * power_W;
    trim.power_suffices = discriminant >= 0.0 && open_V > 0.0;
    trim.battery_V = 0.5 * (open_V + std::sqrt(std::max(discriminant, 0.0)));
    trim.duty = PulseVoltage(vehicle, hover, before_V) / trim.battery_V;
    trim.battery_A = trim.power_suffices ? power_W / trim.battery_V
                                         : (open_V - trim.battery_V) / supply.resistance_Ohm;
    if (vehicle.esc.lossless() || trim.battery_V == before_V) break;
  }
  const double assumed_V = compensate ? trim.battery_V : vehicle.nominal_voltage_V;
  trim.commanded_speed_rad_per_s = HeldSpeed(vehicle, trim.duty * assumed_V);
  return trim;
}

Trim HoverTrim(const Vehicle& vehicle, BatterySupply& battery, bool compensate) {
  // The straight line for v_oc(A) depends a little on the current: a fixed point, found in a few
  // rounds because the tail's share of A is small.
  Trim trim = HoverTrim(vehicle, battery.Linearize(), compensate);
  for (int round = 0; round < 8; ++round) {
    const double before = trim.battery_A;
    battery.Expect(trim.battery_A);
    trim = HoverTrim(vehicle, battery.Linearize(), compensate);
    if (trim.battery_A == before) break;
  }
  return trim;
}

double LowestHoverXi(const Vehicle& vehicle) {
  return HoverTrim(vehicle, {vehicle.nominal_voltage_V, 0.0}).duty;
}

}  // namespace lipoid
