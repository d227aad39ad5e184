#pragma once

/// @file
/// A row of a flight log: the state at the start of a control step and what was decided there.
/// Visit() is the only list of its columns; docs/formats.md describes them.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "model/core/csv_writer.h"
#include "model/core/special_values.h"
#include "model/vehicle/allocation.h"

namespace lipoid {

struct FlightSample {
  /// Names the columns of a vehicle of so many rotors, on a cell that warms or one that knows no temperature.
  [[nodiscard]] static FlightSample OfRotors(std::size_t rotors, bool warms) {
    FlightSample sample;
    if (warms) sample.temperature_degC = 0.0;
    for (MotorValues* values : {&sample.speed_rad_per_s, &sample.duty, &sample.current_A}) {
      values->assign(rotors, 0.0);
    }
    return sample;
  }

  double time_s = 0.0;
  Triple<double> position_m{};        ///< x, y, altitude (up)
  Triple<double> velocity_m_per_s{};  ///< along x, y and up
  Triple<double> angles_rad{};
  Triple<double> body_rates_rad_per_s{};
  double altitude_reference_m = 0.0;
  Triple<double> angle_references_rad{};
  Triple<double> position_command_m{};  ///< x, y, altitude (up)
  double altitude_estimate_m = 0.0;
  Triple<double> angle_estimates_rad{};
  // As many as the vehicle has motors; all three alike.
  MotorValues speed_rad_per_s = MotorValues(4, 0.0);
  MotorValues duty = MotorValues(4, 0.0);
  MotorValues current_A = MotorValues(4, 0.0);
  double battery_V = 0.0;
  double battery_A = 0.0;
  double soc = 0.0;                ///< NaN with an ideal source
  double temperature_degC = kNaN;  ///< of the cell; NaN, and no column, where it knows none

  [[nodiscard]] double altitude_m() const { return position_m[2]; }

  /// v(name, value) for every column.
  template <class Visitor>
  void Visit(Visitor&& v) const {
    v("time_s", time_s);
    v("x_m", position_m[0]);
    v("y_m", position_m[1]);
    v("altitude_m", position_m[2]);
    v("velocity_x_m_per_s", velocity_m_per_s[0]);
    v("velocity_y_m_per_s", velocity_m_per_s[1]);
    v("climb_m_per_s", velocity_m_per_s[2]);
    v("roll_rad", angles_rad[0]);
    v("pitch_rad", angles_rad[1]);
    v("yaw_rad", angles_rad[2]);
    v("roll_rate_rad_per_s", body_rates_rad_per_s[0]);
    v("pitch_rate_rad_per_s", body_rates_rad_per_s[1]);
    v("yaw_rate_rad_per_s", body_rates_rad_per_s[2]);
    v("x_command_m", position_command_m[0]);
    v("y_command_m", position_command_m[1]);
    v("altitude_command_m", position_command_m[2]);
    v("altitude_reference_m", altitude_reference_m);
    v("roll_reference_rad", angle_references_rad[0]);
    v("pitch_reference_rad", angle_references_rad[1]);
    v("yaw_reference_rad", angle_references_rad[2]);
    v("altitude_estimate_m", altitude_estimate_m);
    v("roll_estimate_rad", angle_estimates_rad[0]);
    v("pitch_estimate_rad", angle_estimates_rad[1]);
    v("yaw_estimate_rad", angle_estimates_rad[2]);
    constexpr std::array kSpeed{"speed_1_rad_per_s",
                                "speed_2_rad_per_s",
                                "speed_3_rad_per_s",
                                "speed_4_rad_per_s",
                                "speed_5_rad_per_s",
                                "speed_6_rad_per_s",
                                "speed_7_rad_per_s",
                                "speed_8_rad_per_s"};
    constexpr std::array kDuty{
        "duty_1", "duty_2", "duty_3", "duty_4", "duty_5", "duty_6", "duty_7", "duty_8"};
    constexpr std::array kCurrent{"current_1_A",
                                  "current_2_A",
                                  "current_3_A",
                                  "current_4_A",
                                  "current_5_A",
                                  "current_6_A",
                                  "current_7_A",
                                  "current_8_A"};
    static_assert(kSpeed.size() == kMostRotors);
    for (std::size_t i = 0; i < speed_rad_per_s.size(); ++i) v(kSpeed[i], speed_rad_per_s[i]);
    for (std::size_t i = 0; i < duty.size(); ++i) v(kDuty[i], duty[i]);
    for (std::size_t i = 0; i < current_A.size(); ++i) v(kCurrent[i], current_A[i]);
    v("battery_V", battery_V);
    v("battery_A", battery_A);
    v("soc", soc);
    if (!std::isnan(temperature_degC)) v("temperature_degC", temperature_degC);
  }
};

/// A flight log, row by row while the vehicle flies: no flight is too long for the memory. The file
/// appears at Commit(), whole or not at all. OptionError where it cannot be written.
class FlightLogWriter {
 public:
  /// With the columns of FlightSample::OfRotors().
  FlightLogWriter(const std::string& file, std::size_t rotors, bool warms)
      : csv_(file, Header(rotors, warms)) {}
  void Row(const FlightSample& sample) {
    row_.clear();
    sample.Visit([&](const char*, double value) { row_.push_back(value); });
    csv_.RowOf(row_);
  }
  void Commit() { csv_.Commit(); }

 private:
  static std::string Header(std::size_t rotors, bool warms) {
    std::string header;
    FlightSample::OfRotors(rotors, warms).Visit([&](const char* name, double) {
      if (!header.empty()) header += ',';
      header += name;
    });
    return header;
  }

  CsvWriter csv_;
  std::vector<double> row_;
};

}  // namespace lipoid
