#include "identify/gains/reduced_loops.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/analysis/placed_gains.h"
#include "model/control/gains.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

std::vector<FlightSample> FlyWhole(const LoopTask& task, const Gains& gains) {
  FlightSetup setup;
  setup.vehicle = task.vehicle;
  setup.xi = task.xi;
  setup.gains = gains;
  setup.controller = task.controller;
  setup.controller.pwm = Pwm::kContinuous;
  setup.simulation.motor_lag = task.motor_lag;
  setup.simulation.ground = false;
  std::vector<FlightSample> samples;
  (void)Fly(setup, task.plan, [&](const FlightSample& s) { samples.push_back(s); });
  return samples;
}

LoopTask Task(double xi, FlightPlan plan, bool lag, bool saturate) {
  LoopTask task;
  task.vehicle = LoadVehicle("mambo-thesis");
  task.xi = xi;
  task.plan = std::move(plan);
  task.motor_lag = lag;
  task.controller.saturate = saturate;
  return task;
}

// Sums of four equal motors against one motor times four: rounding, amplified by seconds of a loop
// that rings.
constexpr double kRoundingOfLoops = 1e-10;

TEST(ReducedLoops, TheAltitudeIsThatOfTheWholeFlight) {
  for (const char* name : {"unaware", "aware"}) {
    const Gains gains = LoadGains(name);
    for (const double xi : {0.8, 0.9, 1.0}) {
      for (const bool lag : {false, true}) {
        for (const bool saturate : {false, true}) {
          const LoopTask task = Task(xi, AltitudeSteps().plan({}), lag, saturate);
          const auto whole = FlyWhole(task, gains);
          std::vector<double> errors;
          RunAltitudeLoop(
              task, SampledCommands(task.plan), gains.altitude, [&](std::size_t, double e) {
                errors.push_back(e);
              });
          ASSERT_EQ(errors.size(), whole.size());
          double largest = 0.0;
          for (std::size_t k = 0; k < errors.size(); ++k) {
            // e_Z = Z_ref - Z with z down is altitude less reference.
            ASSERT_NEAR(
                errors[k], whole[k].altitude_m() - whole[k].altitude_reference_m, kRoundingOfLoops)
                << name << " " << xi << " " << lag << saturate << " at " << k;
            largest = std::max(largest, std::abs(errors[k]));
          }
          if (xi < 1.0 || lag) {
            EXPECT_GT(largest, 1e-3);
          }
        }
      }
    }
  }
}

TEST(ReducedLoops, ThePitchIsThatOfTheWholeFlight) {
  for (const char* name : {"unaware", "aware"}) {
    const Gains gains = LoadGains(name);
    for (const double xi : {0.85, 1.0}) {
      for (const bool lag : {false, true}) {
        LoopTask task = Task(xi, AttitudeDoublets().plan({}), lag, true);
        task.controller.law = lag ? "pid" : "inversion";
        const auto whole = FlyWhole(task, gains);
        std::vector<double> errors;
        RunPitchLoop(task,
                     SampledCommands(task.plan),
                     gains.altitude,
                     gains.attitude,
                     [&](std::size_t, double e) { errors.push_back(e); });
        ASSERT_EQ(errors.size(), whole.size());
        double largest = 0.0;
        for (std::size_t k = 0; k < errors.size(); ++k) {
          ASSERT_NEAR(errors[k],
                      whole[k].angle_references_rad[1] - whole[k].angles_rad[1],
                      kRoundingOfLoops)
              << name << " " << xi << " " << lag << " at " << k;
          largest = std::max(largest, std::abs(errors[k]));
        }
        if (xi < 1.0 || lag) {
          EXPECT_GT(largest, 1e-3);
        }
      }
    }
  }
}

// Sines of arms and shares of thrust round, which starts a roll that the loops amplify for 50 s; taking
// all rotors as those of a quadrotor was off by 5e-3.
constexpr double kRoundingOfArms = 1e-6;

TEST(ReducedLoops, OfSixAndEightRotorsAreThoseOfTheWholeFlight) {
  for (const RotorLayout layout : {RotorLayout::kHexaX,
                                   RotorLayout::kHexaPlus,
                                   RotorLayout::kOctoX,
                                   RotorLayout::kOctoPlus,
                                   RotorLayout::kY6,
                                   RotorLayout::kX8}) {
    for (const double xi : {0.85, 1.0}) {
      LoopTask task = Task(xi, AttitudeDoublets().plan({}), true, true);
      task.vehicle = LoadVehicle("hexacopter");
      task.vehicle.mass_kg *= static_cast<double>(RotorsOf(layout).size()) / 6.0;
      task.vehicle.layout = layout;
      if (layout == RotorLayout::kY6 || layout == RotorLayout::kX8)
        task.vehicle.lower_rotor_thrust_ratio = 0.75;
      const Gains gains = GainsFor("", task.vehicle, "aware");
      task.references = gains.references;
      const auto whole = FlyWhole(task, gains);
      double largest = 0.0;
      double apart = 0.0;
      RunPitchLoop(task,
                   SampledCommands(task.plan),
                   gains.altitude,
                   gains.attitude,
                   [&](std::size_t k, double e) {
                     const double flown = whole[k].angle_references_rad[1] - whole[k].angles_rad[1];
                     largest = std::max(largest, std::abs(flown));
                     apart = std::max(apart, std::abs(e - flown));
                   });
      EXPECT_GT(largest, 1e-3);
      EXPECT_LT(apart, kRoundingOfArms) << task.vehicle.rotor_count() << " rotors at xi " << xi;
    }
  }
}

// Speed controllers: transistors in series with the motors, and diodes through which no current flows
// back.
TEST(ReducedLoops, WithSpeedControllersAreThoseOfTheWholeFlight) {
  const Gains gains = LoadGains("aware");
  for (const bool synchronous : {true, false}) {
    for (const bool lag : {false, true}) {
      LoopTask task = Task(0.95, AltitudeSteps().plan({}), lag, true);
      task.vehicle.esc.resistance_Ohm = 0.1;
      task.vehicle.esc.synchronous = synchronous;
      if (!synchronous) task.vehicle.esc.diode_V = 0.1;
      const auto climb = FlyWhole(task, gains);
      RunAltitudeLoop(
          task, SampledCommands(task.plan), gains.altitude, [&](std::size_t k, double e) {
            ASSERT_NEAR(e, climb[k].altitude_m() - climb[k].altitude_reference_m, kRoundingOfLoops)
                << synchronous << lag << " at " << k;
          });
      task.plan = AttitudeDoublets().plan({});
      const auto pitch = FlyWhole(task, gains);
      RunPitchLoop(task,
                   SampledCommands(task.plan),
                   gains.altitude,
                   gains.attitude,
                   [&](std::size_t k, double e) {
                     ASSERT_NEAR(e,
                                 pitch[k].angle_references_rad[1] - pitch[k].angles_rad[1],
                                 kRoundingOfLoops)
                         << synchronous << lag << " at " << k;
                   });
    }
  }
}

TEST(ReducedLoops, WithoutIntegralGainHoverIsHeldAllTheSame) {
  const LoopTask task =
      Task(0.85, {.commands = {{0.0, {.altitude_m = 1.0}}}, .duration_s = 5.0}, true, true);
  const ErrorGains gains{.proportional = 1.0, .integral = 0.0, .derivative = 1.0};
  RunAltitudeLoop(task, SampledCommands(task.plan), gains, [](std::size_t, double e) {
    ASSERT_NEAR(e, 0.0, 1e-9);
  });
}

}  // namespace
}  // namespace lipoid
