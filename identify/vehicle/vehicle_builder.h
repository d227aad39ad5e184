#pragma once

/// @file
/// A vehicle from what its builder knows: weights and sizes, what is printed on motor and propeller,
/// a bench table. Every number of the vehicle comes with a sentence on where it is from; what is
/// assumed says so. docs/vehicles.md has the assumptions and their sources. Tests:
/// tests/identify/vehicle/vehicle_builder_test.cc.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "identify/vehicle/bench_fit.h"
#include "model/flight/trim.h"
#include "model/vehicle/vehicle.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {

/// In the units of builders. What is absent is found from the rest, or assumed.
struct BuilderNumbers {
  std::string name;
  double mass_g = 0.0;  ///< taking off, without payload
  double payload_g = 0.0;
  double frame_mm = 0.0;  ///< from motor to motor across the frame
  int series_cells = 0;
  RotorLayout layout = RotorLayout::kQuadX;
  Turning front_right_turns = Turning::kClockwise;
  std::optional<double> lower_rotor_thrust_ratio;
  std::optional<std::array<double, 3>> inertia_kg_m2;
  double avionics_W = 0.0;
  std::optional<double> drag_N_s_per_m;

  std::optional<double> kv_rpm_per_V;
  std::optional<double> winding_resistance_Ohm;  ///< between two of the three wires
  std::optional<double> no_load_A;
  double no_load_V = 10.0;  ///< at which no_load_A was measured
  std::optional<double> rotor_inertia_kg_m2;
  std::optional<double> propeller_g;

  double propeller_in = 0.0;  ///< diameter
  std::optional<double> pitch_in;
  int blades = 2;
  std::optional<double> thrust_coefficient;  ///< C_T = T/(rho n² D⁴)
  std::optional<double> power_coefficient;   ///< C_P = P/(rho n³ D⁵)

  SpeedController esc;
  std::string bench_name;  ///< of the bench table, for the sources
};

struct VehicleDraft {
  Vehicle vehicle;
  VehicleSources sources;
  Trim hover;                     ///< at 3.7 V a cell, behind no resistance
  double thrust_to_weight = 0.0;  ///< at full throttle there
  double hover_power_W = 0.0;
  std::vector<std::string> assumed;  ///< keys of the vehicle file
  std::vector<std::string>
      cautions;  ///< what can hardly be meant, or does not fit in the bench table
};

/// The coefficients of a propeller of which only diameter, pitch and blades are known: blade element
/// and momentum theory of a blade of constant pitch,
///
///   C = s (theta + a_0 - sqrt(C/2)),   theta = pitch/(pi D),   C = 4 C_T/pi³
///
/// with theta no more than that of half a diameter, beyond which blades stall at rest, s, proportional
/// to the root of the blades, and a_0 those of a measured two-blade propeller, and C_P by a
/// typical figure of merit, which falls as 1/pitch where the blades stall.
struct PropellerCoefficients {
  double thrust = 0.0;
  double power = 0.0;
};
[[nodiscard]] PropellerCoefficients TypicalPropeller(double pitch_over_diameter, int blades);

/// Current without load over the voltage that turns the motor then: I_0/(V_0 - R I_0). OptionError
/// where the winding would take all of it.
[[nodiscard]] double NoLoadConductance(const BuilderNumbers& numbers);

/// OptionError where a number is missing, or where no such vehicle can be: propellers that overlap,
/// propellers that outweigh the vehicle or have no pitch, a figure of merit above 1, less thrust than
/// weight, a winding of more resistance than the bench table has, switching without its frequency.
[[nodiscard]] VehicleDraft BuildVehicle(const BuilderNumbers& numbers,
                                        const std::optional<BenchFit>& bench);

}  // namespace lipoid
