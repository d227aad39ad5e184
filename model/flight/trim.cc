#include "model/flight/trim.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

constexpr int kRounds = 50;  // each leaves a hundredth of the difference

}  // namespace

Trim HoverTrim(const Vehicle& vehicle, const Supply<double>& supply, bool compensate) {
  Trim trim;
  trim.speed_rad_per_s =
      std::sqrt(vehicle.mass_kg * kGravity_m_per_s2 / vehicle.total_thrust_coefficient_N_s2());
  trim.motor_V = HoldingVoltage(vehicle, trim.speed_rad_per_s);
  trim.motor_A = HoldingCurrent(vehicle, trim.speed_rad_per_s);
  const double rotors = double(vehicle.rotor_count());
  const SpeedController& esc = vehicle.esc;
  const double open_V = supply.voltage_V;
  const double driven_V = trim.motor_V + esc.resistance_Ohm * trim.motor_A;
  trim.battery_V = open_V;
  // Of D v_b - (1 - D) V_d = driven_V; without diodes D v_b does not depend on v_b, and one round is
  // enough.
  for (int round = 0; round < kRounds; ++round) {
    const double before_V = trim.battery_V;
    const double pulse_V = esc.synchronous
                               ? driven_V
                               : (driven_V + esc.diode_V) * (before_V / (before_V + esc.diode_V));
    const double switched_V = pulse_V < before_V ? esc.SwitchingShare() * before_V : 0.0;
    // The power is fixed: v_b (E - v_b)/R = P is a quadratic in v_b, whose upper root is the working
    // point.
    const double power_W =
        rotors * (pulse_V + switched_V) * trim.motor_A + vehicle.avionics_power_W;
    const double discriminant = open_V * open_V - 4.0 * supply.resistance_Ohm * power_W;
    trim.power_suffices = discriminant >= 0.0 && open_V > 0.0;
    trim.battery_V = 0.5 * (open_V + std::sqrt(std::max(discriminant, 0.0)));
    trim.duty = pulse_V / trim.battery_V;
    trim.battery_A = rotors * (trim.duty + switched_V / trim.battery_V) * trim.motor_A;  // (3.11)
    if (vehicle.avionics_power_W > 0.0) trim.battery_A += vehicle.avionics_power_W / trim.battery_V;
    if (esc.lossless() || trim.battery_V == before_V) break;
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

}  // namespace lipoid
