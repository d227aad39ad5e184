#include "model/export/controller_export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "generated/flight_code.h"
#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "model/export/cell_numbers.h"
#include "model/export/provenance.h"
#include "model/flight/coupling.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

// Lines of constants; refuses what the precision cannot hold.
class Numbers {
 public:
  explicit Numbers(Precision precision) : precision_(precision) {}

  void Section(std::string_view what) { text_ += fmt::format("\n/* {} */\n", what); }
  void Flag(std::string_view name, bool value, std::string_view what) {
    text_ += fmt::format("#define LIPOID_{} {} /* {} */\n", name, value ? 1 : 0, what);
  }
  void Count(std::string_view name, int value, std::string_view what) {
    text_ += fmt::format("#define LIPOID_{} {} /* {} */\n", name, value, what);
  }
  void Real(std::string_view name, double value, std::string_view what) {
    Check(name, value);
    const std::string number = CNumber(value);
    text_ += fmt::format(
        "#define LIPOID_{} {} /* {} */\n", name, value < 0.0 ? "(" + number + ")" : number, what);
  }
  // A bound that may be absent.
  void Bound(std::string_view name, double value, std::string_view what) {
    if (value < std::numeric_limits<double>::infinity()) return Real(name, value, what);
    text_ += fmt::format("#define LIPOID_{} HUGE_VAL /* none; {} */\n", name, what);
  }
  // A number that the code computes on the way.
  void Check(std::string_view name, double value) const {
    const double most = precision_ == Precision::kFloat ? double(std::numeric_limits<float>::max())
                                                        : std::numeric_limits<double>::max();
    const double least = precision_ == Precision::kFloat ? double(std::numeric_limits<float>::min())
                                                         : std::numeric_limits<double>::min();
    const double size = std::abs(value);
    if (value == 0.0 || (size >= least && size <= most)) return;
    throw OptionError(fmt::format(
        "the controller cannot be exported: {} would be {:g}, and {} holds {:.3g} to {:.3g}{}",
        name,
        value,
        precision_ == Precision::kFloat ? "a float" : "a double",
        least,
        most,
        precision_ == Precision::kFloat ? ". Give --precision double, or another vehicle"
                                        : ". Give another vehicle"));
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  Precision precision_;
  std::string text_;
};

void WriteReference(Numbers& numbers, std::string_view name, const ReferenceModel& model) {
  numbers.Real(fmt::format("{}_PER_GAP", name), model.per_gap(), "1/s^2, acceleration of a gap");
  numbers.Real(fmt::format("{}_PER_RATE", name), model.per_rate(), "1/s, and of the rate");
  numbers.Bound(fmt::format("{}_LIMIT", name), model.limit(), "bound of the acceleration");
  numbers.Bound(
      fmt::format("{}_REACH", name), model.far(), "gap from which the bound brakes in time");
}

void WriteErrorGains(Numbers& numbers, std::string_view name, const ErrorGains& gains) {
  numbers.Real(fmt::format("{}_PROPORTIONAL", name), gains.proportional, "1/s^2, K_e");
  numbers.Real(fmt::format("{}_INTEGRAL", name), gains.integral, "1/s^3, K_eI");
  numbers.Real(fmt::format("{}_DERIVATIVE", name), gains.derivative, "1/s, K_edot");
}

void WriteVehicle(Numbers& numbers, const Vehicle& v) {
  numbers.Section("The vehicle.");
  numbers.Real("GRAVITY_M_PER_S2", kGravity_m_per_s2, "m/s^2");
  numbers.Real("MASS_KG", v.mass_kg, "kg");
  const auto& j = v.inertia_kg_m2;
  numbers.Real("INERTIA_X_KG_M2", j[0], "kg m^2");
  numbers.Real("INERTIA_Y_KG_M2", j[1], "kg m^2");
  numbers.Real("INERTIA_Z_KG_M2", j[2], "kg m^2");
  numbers.Real("INERTIA_Z_LESS_Y_KG_M2", j[2] - j[1], "their differences, rounded once");
  numbers.Real("INERTIA_X_LESS_Z_KG_M2", j[0] - j[2], "kg m^2");
  numbers.Real("INERTIA_Y_LESS_X_KG_M2", j[1] - j[0], "kg m^2");
  numbers.Real(
      "THRUST_COEFFICIENT_N_S2", v.thrust_coefficient_N_s2, "N s^2, thrust over square of rad/s");
  // As SquaredSpeedsOf() of model/vehicle/allocation.h has them.
  const double per_thrust = 0.25 / v.thrust_coefficient_N_s2;
  numbers.Real("SQUARE_PER_THRUST", per_thrust, "1/(4 k_T)");
  numbers.Real("SQUARE_PER_TILT", per_thrust / v.lever_m(), "1/(4 k_T l_x)");
  numbers.Real(
      "SQUARE_PER_YAW", 0.25 / v.yaw_coefficient_N_m_s2(), "1/(4 k_N), sign of the turning");
  numbers.Real("HOVER_SPEED_RAD_PER_S",
               std::sqrt(v.mass_kg * kGravity_m_per_s2 / (4.0 * v.thrust_coefficient_N_s2)),
               "rad/s");
  // As HoldingVoltage() and HeldSpeed() of model/vehicle/motor.h have them.
  numbers.Real("SPEED_SLOPE", v.speed_slope(), "k_e^2 + r_a b");
  numbers.Real("SPEED_SQUARE", v.armature_resistance_Ohm * v.torque_coefficient_N_m_s2, "r_a k_N");
  numbers.Real("PER_MOTOR_CONSTANT", 1.0 / v.motor_constant_N_m_per_A, "1/k_e");
  numbers.Real("GAMMA_RAD_PER_S", v.gamma_rad_per_s(), "rad/s, (k_e^2 + r_a b)/(r_a k_N)");
  numbers.Real(
      "DRIVE_PER_V",
      v.motor_constant_N_m_per_A / (v.armature_resistance_Ohm * v.torque_coefficient_N_m_s2),
      "k_e/(r_a k_N)");
  numbers.Real("NOMINAL_VOLTAGE_V", v.nominal_voltage_V, "V, what commands reckon with");
  numbers.Real("PWM_LOW", v.pwm_range[0], "of the hardware at duty 0");
  numbers.Real("PWM_SPAN", v.pwm_range[1] - v.pwm_range[0], "and how many to duty 1");
  numbers.Check("the square of GAMMA_RAD_PER_S", v.gamma_rad_per_s() * v.gamma_rad_per_s());
}

void WriteController(Numbers& numbers, const ControllerExportRequest& request) {
  const ControllerOptions& options = request.controller;
  const int law = LawInC(FindControlLaw(options.law));
  FlightController controller(request.vehicle, request.gains, options);
  const double highest_speed = HeldSpeed(request.vehicle, request.lowest_V);
  controller.Reset({}, highest_speed, highest_speed);  // for the bounds; the state does not matter

  numbers.Section("The controller.");
  numbers.Count("LAW", law, "0: dynamic inversion, 1: PID on each axis");
  numbers.Flag("COMPENSATE", options.compensate, "1: commands use the measured voltage, (5.52)");
  numbers.Flag("SATURATE", options.saturate, "1: duty cycles stay in [0, 1]");
  numbers.Flag("PWM_ROUNDS", options.pwm != Pwm::kContinuous, "1: pulse widths are whole numbers");
  numbers.Flag("PWM_CARRIES", options.pwm == Pwm::kCarried, "1: and their remainder is carried on");
  WriteErrorGains(numbers, "ALTITUDE", request.gains.altitude);
  WriteErrorGains(numbers, "ATTITUDE", request.gains.attitude);
  WriteErrorGains(numbers, "YAW", request.gains.yaw);
  const PositionGains& position = request.gains.position;
  numbers.Real("POSITION_PROPORTIONAL_RAD_PER_M", position.proportional_rad_per_m, "rad/m");
  numbers.Real("POSITION_DERIVATIVE_RAD_S_PER_M", position.derivative_rad_s_per_m, "rad s/m");
  numbers.Real("TILT_LIMIT_RAD", position.tilt_limit_rad, "rad, of each commanded angle");
  numbers.Real("POSITION_REACH_M",
               controller.position_reach_m(),
               "m, a gap that is cut to it keeps the speed");
  numbers.Real("CLIMB_REACH_M", controller.altitude_reach().climb_m, "m, the same upwards");
  numbers.Real("DESCENT_REACH_M", controller.altitude_reach().descent_m, "m, and downwards");
  WriteReference(numbers, "DOWN", controller.down_reference());
  WriteReference(numbers, "ROLL", controller.angle_reference(0));
  WriteReference(numbers, "PITCH", controller.angle_reference(1));
  WriteReference(numbers, "YAW", controller.angle_reference(2));
  WriteReference(numbers, "POSITION", controller.position_reference());
  numbers.Bound("YAW_TORQUE_LIMIT_N_M", controller.yaw_limit_N_m(), "N m");
  numbers.Real("MOTOR_LAG_SHARE",
               controller.motor_lag_share(),
               "of a gap that the speeds of the motors close in a step");
}

void WriteEstimator(Numbers& numbers, const EstimatorOptions& options) {
  numbers.Section("The estimator.");
  numbers.Count("CALIBRATION_SAMPLES",
                options.calibrate ? options.calibration_samples : 0,
                "readings at rest, 5 ms apart");
  numbers.Real("ACCELEROMETER_RANGE_M_PER_S2", kAccelerometerRange_m_per_s2, "m/s^2");
  numbers.Real("GYRO_RANGE_RAD_PER_S", kGyroRange_rad_per_s, "rad/s");
  numbers.Real("FLOW_RANGE_M_PER_S", kFlowRange_m_per_s, "m/s");
  numbers.Real("SONAR_FLOOR_M", kSonarFloor_m, "m, what the sonar says where it is lower");
  numbers.Real("ACCELEROMETER_WEIGHT", options.accelerometer_weight, "of the tilt, per step");
  numbers.Real("GRAVITY_BAND_M_PER_S2",
               options.gravity_band_m_per_s2,
               "m/s^2, while the force is this near to g");
  numbers.Real("ALTITUDE_Q_M2_PER_S2", options.altitude_q_m2_per_s2, "m^2/s^2 per step");
  numbers.Real("ALTITUDE_R_M2", options.altitude_r_m2, "m^2");
  numbers.Real("SONAR_GATE_M", options.sonar_gate_m, "m");
  numbers.Real("PRESSURE_GATE_M", options.pressure_gate_m, "m");
  numbers.Real("REACQUIRE_S", options.reacquire_s, "s without a height, then one is believed");
  numbers.Real("VELOCITY_Q_M2_PER_S2", options.velocity_q_m2_per_s2, "m^2/s^2 per step");
  numbers.Real("VELOCITY_R_M2_PER_S2", options.velocity_r_m2_per_s2, "m^2/s^2");
  numbers.Real("LEAST_UPRIGHT", kLeastUpright, "cosine of the tilt up to which the flow is used");
  numbers.Real("GIMBAL_LOCK_RAD", kGimbalLock_rad, "rad, of pitch");
  numbers.Real("TURN_RAD", 2.0 * std::numbers::pi, "rad");
}

std::string NumbersFile(const ControllerExportRequest& request) {
  Numbers numbers(request.precision);
  WriteVehicle(numbers, request.vehicle);
  WriteController(numbers, request);
  WriteEstimator(numbers, request.estimator);
  numbers.Section("For lipoid_example.c alone.");
  numbers.Real("EXAMPLE_BATTERY_V", request.vehicle.nominal_voltage_V, "V");

  std::vector<std::string> lines{
      "lipoid_numbers.h: the vehicle, the gains and the options of lipoid_controller.c.",
      fmt::format("Made by lipoid {}.", Version()),
      fmt::format("Vehicle: {}.", HarmlessInComment(request.vehicle.name)),
      fmt::format("Front right and back left turn {}, seen from above; the others the other way.",
                  options_internal::ToText(request.vehicle.front_right_turns)),
      fmt::format("Gains: {}.", HarmlessInComment(request.gains.name)),
      fmt::format("Controller: {}.", HarmlessInComment(request.controller.law)),
      fmt::format("Bounds of the references are those at {} V.", request.lowest_V)};
  for (const std::string& line : request.origin) lines.push_back(HarmlessInComment(line));
  std::string text = "/*\n" + Commented(lines, " * ") + " */\n";
  text += "#ifndef LIPOID_NUMBERS_H\n#define LIPOID_NUMBERS_H\n\n";
  text += "/* 1: double, 0: float. */\n#ifndef LIPOID_DOUBLE\n";
  text += fmt::format("#define LIPOID_DOUBLE {}\n#endif\n",
                      request.precision == Precision::kDouble ? 1 : 0);
  return text + numbers.text() + "\n#endif\n";
}

constexpr std::string_view kNumbersName = "lipoid_numbers.h";

}  // namespace

int LawInC(const ControlLaw& law) {
  if (law.in_c) return *law.in_c;
  std::vector<std::string_view> known;
  for (const ControlLaw& other : ControlLaws()) {
    if (other.in_c) known.push_back(other.name);
  }
  throw OptionError(
      fmt::format("the controller {} cannot be exported: it has no C code. Those that have: {}",
                  law.name,
                  fmt::join(known, ", ")));
}

std::vector<NamedFile> ExportController(const ControllerExportRequest& request) {
  Require(request.lowest_V > 0.0, "lowest_V > 0", {{"lowest_V", request.lowest_V}});
  RequireQuadX(request.vehicle, "the exported controller");
  std::vector<NamedFile> files;
  for (const auto& code : kFlightCode)
    files.push_back({std::string(code.name), std::string(code.text)});
  files.push_back({std::string(kNumbersName), NumbersFile(request)});
  return files;
}

std::vector<std::string> ExportedControllerNames() {
  std::vector<std::string> names;
  for (const auto& code : kFlightCode) names.emplace_back(code.name);
  names.emplace_back(kNumbersName);
  return names;
}

}  // namespace lipoid
