#include "model/analysis/poles.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "model/control/command_generation.h"
#include "model/core/errors.h"
#include "model/vehicle/motor.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

double Distance(const Poles& a, const Poles& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    largest = std::max(largest, std::abs(a[k] - b[k]));
  }
  return largest;
}

TEST(Poles, ClosedFormAndTheFlightsOwnDerivativeAgree) {
  for (const char* vehicle_name : {"mambo-thesis", "mambo-coupled", "mambo-physical"}) {
    const Vehicle vehicle = LoadVehicle(vehicle_name);
    for (const char* gains_name : {"unaware", "aware"}) {
      const Gains gains = LoadGains(gains_name);
      for (const double xi : {0.7, 0.8, 0.873, 0.95, 1.0}) {
        for (const Loop loop : {Loop::kAltitude, Loop::kAttitude}) {
          const PolesRow row = PolesAt(loop, vehicle, gains, xi);
          EXPECT_LT(Distance(row.closed_form, row.quasistatic), 1e-9)
              << vehicle_name << " " << gains_name << " " << xi;
        }
      }
    }
  }
}

TEST(Poles, KappaIsTheSlopeOfTheThrust) {
  // T/m as a function of u by the motors' own law (5.10), differentiated numerically.
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  for (const double xi : {0.75, 0.9, 1.0}) {
    const auto thrust_per_mass = [&](double u) {
      const double commanded =
          std::sqrt(vehicle.mass_kg * u / (4.0 * vehicle.thrust_coefficient_N_s2));
      const double speed = HeldSpeed(vehicle, xi * HoldingVoltage(vehicle, commanded));
      return 4.0 * vehicle.thrust_coefficient_N_s2 * speed * speed / vehicle.mass_kg;
    };
    // The u that hovers, by bisection.
    double low = 1.0;
    double high = 100.0;
    for (int k = 0; k < 200; ++k) {
      const double middle = 0.5 * (low + high);
      (thrust_per_mass(middle) < kGravity_m_per_s2 ? low : high) = middle;
    }
    const auto slope = test::Ridders(thrust_per_mass, low, 0.1);
    EXPECT_NEAR(Kappa(vehicle, xi), slope.value, 1e-8) << xi;
  }
  EXPECT_NEAR(Kappa(vehicle, 1.0), 1.0, 1e-15);
}

TEST(Poles, KappaKnowsTheLossesOfSpeedControllers) {
  Vehicle lossy = LoadVehicle("f450");
  lossy.esc = {.resistance_Ohm = 0.05};
  Vehicle diodes = lossy;
  diodes.esc.diode_V = 0.7;
  diodes.esc.synchronous = false;
  for (const Vehicle& vehicle : {lossy, diodes}) {
    // The thrust of motors that the commands' duty cycle holds, differentiated numerically.
    const double battery_V = 0.9 * vehicle.nominal_voltage_V;
    const auto thrust_per_mass = [&](double u) {
      const double commanded =
          std::sqrt(vehicle.mass_kg * u / (4.0 * vehicle.thrust_coefficient_N_s2));
      const double duty = DutyCycle(vehicle, commanded, vehicle.nominal_voltage_V);
      double low = 0.0;
      double high = 5000.0;
      for (int k = 0; k < 200; ++k) {
        const double w = 0.5 * (low + high);
        const double torque =
            vehicle.motor_constant_N_m_per_A * MotorCurrent(vehicle, duty, battery_V, w);
        const double load = vehicle.friction_N_m_s * w + vehicle.torque_coefficient_N_m_s2 * w * w;
        (torque > load ? low : high) = w;
      }
      return 4.0 * vehicle.thrust_coefficient_N_s2 * low * low / vehicle.mass_kg;
    };
    double low = 1.0;
    double high = 100.0;
    for (int k = 0; k < 200; ++k) {
      const double middle = 0.5 * (low + high);
      (thrust_per_mass(middle) < kGravity_m_per_s2 ? low : high) = middle;
    }
    EXPECT_NEAR(Kappa(vehicle, 0.9), test::Ridders(thrust_per_mass, low, 0.1).value, 1e-8);
    const Gains gains = LoadGains("aware");
    for (const Loop loop : {Loop::kAltitude, Loop::kAttitude}) {
      const PolesRow row = PolesAt(loop, vehicle, gains, 0.9);

      EXPECT_LT(Distance(row.closed_form, row.quasistatic), 1e-9);
    }
  }
}

TEST(Poles, HoverIsAnEquilibriumOfTheClosedLoop) {
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  for (const bool lag : {false, true}) {
    auto rate = ClosedLoopRateAtHover(vehicle, LoadGains("aware"), HoverAt(vehicle, 0.85), lag);
    rate[16] = 0.0;  // charge leaves
    EXPECT_LT(rate.cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Poles, OfALoopAreAmongThoseOfTheWholeVehicle) {
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  const Gains gains = LoadGains("aware");
  for (const bool lag : {false, true}) {
    const ClosedLoopMatrix matrix = LinearizeClosedLoop(vehicle, gains, HoverAt(vehicle, 0.9), lag);
    const Eigen::EigenSolver<ClosedLoopMatrix> whole(matrix, false);
    for (const Loop loop : {Loop::kAltitude, Loop::kAttitude}) {
      const Poles poles = LoopPoles(loop, matrix, lag);
      EXPECT_EQ(poles.size(), lag ? 4U : 3U);
      for (const auto& pole : poles) {
        // A 21 x 21 problem with eigenvalues at zero that are defective: 1e-6 of its norm.
        EXPECT_LT((whole.eigenvalues().array() - pole).abs().minCoeff(), 1e-6) << pole;
      }
    }
  }
}

// s² + K_edot s + K_e is left: a loop is not called unstable for an integral that nothing reads.
TEST(Poles, WithoutAnIntegralGainTheLoopHasNoPoleOfIt) {
  Gains gains = LoadGains("aware");
  gains.attitude.integral = 0.0;
  const PolesRow row = PolesAt(Loop::kAttitude, LoadVehicle("mambo-thesis"), gains, 1.0);
  EXPECT_EQ(row.closed_form.size(), 2U);
  EXPECT_EQ(row.full.size(), 3U);
  EXPECT_LT(Distance(row.closed_form, row.quasistatic), 1e-9);
  for (const auto& s : row.closed_form) {
    EXPECT_LT(std::abs(s * s + gains.attitude.derivative * s + gains.attitude.proportional), 1e-12);
  }
  EXPECT_LT(row.full.front().real(), -0.01);
}

TEST(Poles, AreThoseOfATwinMadeByDifferences) {
  // The Jacobian's rows against central differences of the closed loop's rate would need its state;
  // the characteristic polynomial with lag has a closed form instead: s³ (tau s + 1) + kappa (...),
  // tau the time constant of a motor about its hover speed.
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  const Gains gains = LoadGains("unaware");
  const double speed =
      std::sqrt(vehicle.mass_kg * kGravity_m_per_s2 / (4.0 * vehicle.thrust_coefficient_N_s2));
  const double rate = (vehicle.speed_slope() / vehicle.armature_resistance_Ohm +
                       2.0 * vehicle.torque_coefficient_N_m_s2 * speed) /
                      vehicle.rotor_inertia_kg_m2;
  for (const double xi : {0.8, 1.0}) {
    const PolesRow row = PolesAt(Loop::kAltitude, vehicle, gains, xi);
    const double k = row.kappa;
    for (const auto& s : row.full) {
      const auto value = s * s * s * (s / rate + 1.0) +
                         k * (gains.altitude.derivative * s * s + gains.altitude.proportional * s +
                              gains.altitude.integral);
      const double scale = std::pow(std::abs(s), 3) + 1.0;
      EXPECT_LT(std::abs(value) / scale, 1e-10) << s;
    }
  }
}

TEST(Poles, WithoutInertiaLagVanishes) {
  Vehicle light = LoadVehicle("mambo-thesis");
  light.rotor_inertia_kg_m2 *= 1e-6;
  const PolesRow row = PolesAt(Loop::kAltitude, light, LoadGains("aware"), 0.9);
  const Poles slow(row.full.begin(), row.full.begin() + 3);
  // 18 ns of lag on poles of 6 rad/s.
  EXPECT_LT(Distance(slow, row.quasistatic), 1e-5);
}

TEST(Poles, PrintedOrderOfTheAwareGainsIsUnstable) {
  const ErrorGains printed{.proportional = 5.03, .integral = 7.87, .derivative = 1.36};
  EXPECT_GT(ClosedFormPoles(printed, 1.0).front().real(), 0.0);
  EXPECT_LT(ClosedFormPoles(LoadGains("aware").altitude, 1.0).front().real(), 0.0);
}

TEST(Poles, NeedsAnIntegralWhereXiIsBelowOne) {
  Gains gains = LoadGains("aware");
  gains.altitude.integral = 0.0;
  const Vehicle vehicle = LoadVehicle("mambo-thesis");
  EXPECT_THROW((void)LinearizeClosedLoop(vehicle, gains, HoverAt(vehicle, 0.9), true),
               PreconditionError);
}

// The gains act on accelerations, so that the number of rotors and their places do not matter.
TEST(Poles, OfAnyLayoutAreThoseOfTheSameMotorsOnAnX) {
  const Gains gains = LoadGains("aware");
  Vehicle vehicle = LoadVehicle("mambo-coupled");
  const PolesRow altitude = PolesAt(Loop::kAltitude, vehicle, gains, 0.9);
  const PolesRow attitude = PolesAt(Loop::kAttitude, vehicle, gains, 0.9);
  for (const auto& [layout, name] : OptionNames(RotorLayout{})) {
    Vehicle other = vehicle;
    other.layout = layout;
    other.mass_kg *= static_cast<double>(other.rotor_count()) / 4.0;  // each motor works as hard
    for (const auto& [loop, row] :
         {std::pair{Loop::kAltitude, altitude}, std::pair{Loop::kAttitude, attitude}}) {
      const PolesRow found = PolesAt(loop, other, gains, 0.9);
      ASSERT_EQ(found.full.size(), row.full.size());
      for (std::size_t k = 0; k < row.full.size(); ++k) {
        // Rounding of an eigenvalue problem with entries of thousands.
        EXPECT_LT(std::abs(found.full[k] - row.full[k]), 1e-9) << name << ", pole " << k;
      }
    }
  }
}

}  // namespace
}  // namespace lipoid
