#include "model/flight/trim.h"

#include <algorithm>
#include <cmath>

namespace lipoid {

Trim HoverTrim(const Vehicle& vehicle, const Supply<double>& supply, bool compensate) {
  Trim trim;
  trim.speed_rad_per_s =
      std::sqrt(vehicle.mass_kg * kGravity_m_per_s2 / (4.0 * vehicle.thrust_coefficient_N_s2));
  trim.motor_V = HoldingVoltage(vehicle, trim.speed_rad_per_s);
  trim.motor_A = HoldingCurrent(vehicle, trim.speed_rad_per_s);
  // The power 4 D v_b i is fixed: v_b (E - v_b)/R = 4 D v_b i is a quadratic in v_b, whose upper
  // root is the working point.
  const double open_V = supply.voltage_V;
  const double power_W = 4.0 * trim.motor_V * trim.motor_A;
  const double discriminant = open_V * open_V - 4.0 * supply.resistance_Ohm * power_W;
  trim.power_suffices = discriminant >= 0.0 && open_V > 0.0;
  trim.battery_V = 0.5 * (open_V + std::sqrt(std::max(discriminant, 0.0)));
  trim.duty = trim.motor_V / trim.battery_V;
  trim.battery_A = 4.0 * trim.duty * trim.motor_A;  // (3.11)
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

}  // namespace lipoid
