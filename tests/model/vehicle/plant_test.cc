#include "model/vehicle/plant.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using State = PlantState<double>;
using test::AsEigen;

using test::kEpsilon;
constexpr PlantOptions kAir{.motor_lag = true, .drag = false, .ground = false};

void Set(State& x, std::size_t first, const Triple<double>& values) {
  for (std::size_t k = 0; k < 3; ++k) x[first + k] = values[k];
}

// Hovering at the speed that carries the weight, with a supply and its duty.
State HoverState(const Vehicle& v) {
  State x{};
  for (std::size_t i = 0; i < 4; ++i) x[plant::kSpeeds + i] = test::HoverSpeed(v);
  return x;
}

TEST(Plant, FreeFallIsAParabola) {
  const Plant plant(LoadVehicle("mambo-thesis"), kAir);
  State x{};
  Set(x, plant::kVelocity, {1.0, -2.0, -3.0});
  test::Fly(plant, {}, x, 0.01, 200);
  // A polynomial of second degree: RK4 makes no error but rounding, 200 times.
  constexpr double kRounding = 200.0 * 20.0 * kEpsilon;
  EXPECT_NEAR(x[plant::kPosition], 2.0, kRounding);
  EXPECT_NEAR(x[plant::kPosition + 1], -4.0, kRounding);
  EXPECT_NEAR(x[plant::kPosition + 2], -3.0 * 2.0 + 0.5 * 9.81 * 4.0, kRounding);
  EXPECT_NEAR(x[plant::kVelocity + 2], -3.0 + 9.81 * 2.0, kRounding);
}

// m v' = m g - c (v - wind): e^{-c t/m}, towards the wind and m g/c below it.
TEST(Plant, DragPullsTowardsTheAir) {
  PlantOptions options = kAir;
  options.drag = true;
  const Vehicle v = LoadVehicle("mambo-thesis");
  const Plant plant(v, options);
  State x{};
  Set(x, plant::kVelocity, {1.0, 0.0, 0.0});
  const PlantInputs<double> in{.duty = {}, .supply = {}, .wind_m_per_s = {-2.0, 3.0, 0.5}};
  test::Fly(plant, in, x, 0.01, 500);
  const double left = std::exp(-v.linear_drag_N_s_per_m / v.mass_kg * 5.0);
  const double fall = 9.81 * v.mass_kg / v.linear_drag_N_s_per_m;
  constexpr double kStepError = 1e-9;  // (0.01 * 0.32)^4, times 30 m/s
  EXPECT_NEAR(x[plant::kVelocity], -2.0 + 3.0 * left, kStepError);
  EXPECT_NEAR(x[plant::kVelocity + 1], 3.0 - 3.0 * left, kStepError);
  EXPECT_NEAR(x[plant::kVelocity + 2], (0.5 + fall) * (1.0 - left), kStepError);
}

// Without a torque a body keeps its angular momentum in inertial axes and its energy, however
// wildly it tumbles: here about the axis in the middle, which is unstable.
TEST(Plant, ATorqueFreeBodyKeepsItsMomentumAndEnergy) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  const Plant plant(v, kAir);
  const Eigen::Vector3d inertia = AsEigen(v.inertia_kg_m2);
  const auto momentum = [&](const State& x) -> Eigen::Vector3d {
    return test::Rotation(TripleAt(x, plant::kAngles)) *
           inertia.cwiseProduct(AsEigen(TripleAt(x, plant::kRates)));
  };
  const auto energy = [&](const State& x) {
    const Eigen::Vector3d w = AsEigen(TripleAt(x, plant::kRates));
    return 0.5 * w.dot(inertia.cwiseProduct(w));
  };
  State x{};
  Set(x, plant::kAngles, {1.5, 0.1, 1.0});  // on its side: it turns about the vertical
  Set(x, plant::kRates, {0.05, 6.0, 0.04});
  const Eigen::Vector3d before = momentum(x);
  const double energy_before = energy(x);
  double most_other = 0.0;
  for (int k = 0; k < 3000; ++k) {
    test::Fly(plant, {}, x, 1e-3, 1);
    most_other = std::max(most_other, std::abs(x[plant::kRates + 2]));
    if (std::abs(x[plant::kAngles + 1]) > 1.4) break;  // the angles end, not the body
  }
  EXPECT_GT(most_other, 0.5);  // it did tumble
  // RK4 at 1 ms and rates of 6 rad/s, where the secant multiplies them by up to 6.
  EXPECT_LT((momentum(x) - before).norm(), 1e-9 * before.norm());
  EXPECT_NEAR(energy(x), energy_before, 1e-12 * energy_before);
}

// A symmetric body: its axis of symmetry goes round the momentum, seen from the body at
// (J_z - J_x)/J_x r.
TEST(Plant, ASymmetricTopPrecesses) {
  Vehicle v = LoadVehicle("mambo-thesis");
  v.inertia_kg_m2 = {6e-5, 6e-5, 1e-4};
  const Plant plant(v, kAir);
  State x{};
  Set(x, plant::kRates, {0.5, 0.0, 4.0});
  test::Fly(plant, {}, x, 1e-3, 1000);
  const double turn = (1e-4 - 6e-5) / 6e-5 * 4.0 * 1.0;
  EXPECT_NEAR(x[plant::kRates], 0.5 * std::cos(turn), 1e-12);
  EXPECT_NEAR(x[plant::kRates + 1], 0.5 * std::sin(turn), 1e-12);
  EXPECT_NEAR(x[plant::kRates + 2], 4.0, 1e-12);
}

// Vehicles of other layouts, and controllers that lose: tests/model/flight/trim_test.cc.
TEST(Plant, HoverIsAnEquilibrium) {
  for (const char* name : {"mambo-thesis", "mambo-coupled", "mambo-physical"}) {
    SCOPED_TRACE(name);
    const Vehicle v = LoadVehicle(name);
    const double volts = HoldingVoltage(v, test::HoverSpeed(v));
    PlantInputs<double> in;
    in.supply = {3.9, 0.0};
    in.duty.fill(volts / 3.9);
    for (const bool lag : {true, false}) {
      const Plant plant(v, {.motor_lag = lag, .drag = true, .ground = true});
      State x = HoverState(v);
      Set(x, plant::kPosition, {3.0, 4.0, -1.0});
      x[plant::kAngles + 2] = 2.0;
      State dx{};
      plant.Derivative(x, in, dx);
      // Against g, and against what the motor's torque alone would do.
      const double spin_up = v.motor_constant_N_m_per_A * HoldingCurrent(v, test::HoverSpeed(v)) /
                             v.rotor_inertia_kg_m2;
      for (std::size_t k = 0; k < plant::kCharge; ++k) {
        EXPECT_NEAR(dx[k], 0.0, 64.0 * kEpsilon * (k < plant::kSpeeds ? 9.81 : spin_up)) << k;
      }
      EXPECT_NEAR(
          dx[plant::kCharge], 4.0 * volts / 3.9 * HoldingCurrent(v, test::HoverSpeed(v)), 1e-13);
    }
  }
}

// Pushed alike in every heading, it flies alike in every heading.
TEST(Plant, NoHeadingIsSpecial) {
  PlantOptions options = kAir;
  options.drag = true;
  const Vehicle v = LoadVehicle("mambo-physical");
  const Plant plant(v, options);
  const auto flight = [&](double heading) {
    const Eigen::Matrix3d turn = test::Rotation({0.0, 0.0, heading});
    State x = HoverState(v);
    Set(x, plant::kAngles, {0.1, -0.2, 0.3 + heading});
    const Eigen::Vector3d velocity = turn * Eigen::Vector3d(1.0, 2.0, -1.0);
    Set(x, plant::kVelocity, {velocity[0], velocity[1], velocity[2]});
    const Eigen::Vector3d wind = turn * Eigen::Vector3d(2.0, -1.0, 0.0);
    const PlantInputs<double> in{.duty = {0.50, 0.51, 0.52, 0.505},
                                 .supply = {4.0, 0.1},
                                 .wind_m_per_s = {wind[0], wind[1], wind[2]}};
    test::Fly(plant, in, x, 0.005, 60);
    // Back into the heading it started in.
    const Eigen::Vector3d position = turn.transpose() * AsEigen(TripleAt(x, plant::kPosition));
    Set(x, plant::kPosition, {position[0], position[1], position[2]});
    const Eigen::Vector3d moved = turn.transpose() * AsEigen(TripleAt(x, plant::kVelocity));
    Set(x, plant::kVelocity, {moved[0], moved[1], moved[2]});
    x[plant::kAngles + 2] -= heading;
    return x;
  };
  const State north = flight(0.0);
  EXPECT_GT(std::abs(north[plant::kAngles]), 0.15);  // something happened
  for (const double heading : {0.5, 1.57, -2.5}) {
    const State other = flight(heading);
    for (std::size_t k = 0; k < north.size(); ++k) {
      EXPECT_NEAR(other[k], north[k], 1e-11 * std::max(1.0, std::abs(north[k])))
          << "heading " << heading << ", state " << k;
    }
  }
}

// A vehicle and its mirror image: left motors for right ones, both spins reversed.
TEST(Plant, TheMirrorImageFliesTheMirrorImage) {
  const Vehicle v = LoadVehicle("mambo-physical");
  const Plant plant(v, kAir);
  State x = HoverState(v);
  State mirrored = HoverState(v);
  PlantInputs<double> in{.duty = {0.50, 0.47, 0.52, 0.46}, .supply = {4.0, 0.1}};
  PlantInputs<double> mirrored_in = in;
  // Front right with front left, back right with back left.
  mirrored_in.duty = {in.duty[3], in.duty[2], in.duty[1], in.duty[0]};
  test::Fly(plant, in, x, 0.005, 40);
  test::Fly(plant, mirrored_in, mirrored, 0.005, 40);
  EXPECT_GT(std::abs(x[plant::kAngles]), 0.01);
  EXPECT_GT(std::abs(x[plant::kAngles + 2]), 1e-3);
  for (const std::size_t same : {plant::kPosition, plant::kPosition + 2, plant::kAngles + 1}) {
    EXPECT_NEAR(mirrored[same], x[same], 1e-12) << same;
  }
  for (const std::size_t other : {plant::kPosition + 1, plant::kAngles, plant::kAngles + 2}) {
    EXPECT_NEAR(mirrored[other], -x[other], 1e-12) << other;
  }
}

// A lively flight of 0.2 s, from which the order of the integrator shows.
PlantInputs<double> LivelyInputs(double resistance_Ohm) {
  return {.duty = {0.62, 0.55, 0.58, 0.60},
          .supply = {4.0, resistance_Ohm},
          .wind_m_per_s = {1.0, -2.0, 0.5}};
}
State LivelyStart(const Vehicle& v) {
  State x = HoverState(v);
  Set(x, plant::kAngles, {0.2, -0.3, 0.5});
  Set(x, plant::kRates, {1.0, 2.0, -1.5});
  Set(x, plant::kVelocity, {1.0, -1.0, 0.5});
  return x;
}

TEST(Plant, RungeKuttaIsOfFourthOrderInTheStep) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const Plant plant(v, {.motor_lag = true, .drag = true, .ground = false});
  const auto end = [&](int steps) {
    State x = LivelyStart(v);
    test::Fly(plant, LivelyInputs(0.0), x, 0.2 / steps, steps);
    return x;
  };
  const State exact = end(2560);
  const auto error = [&](int steps) {
    const State x = end(steps);
    double sum = 0.0;
    for (std::size_t k = 0; k < plant::kSpeeds; ++k) sum += std::pow(x[k] - exact[k], 2);
    return std::sqrt(sum);
  };
  const double coarse = error(40);
  const double medium = error(80);
  const double fine = error(160);
  EXPECT_GT(fine, 1e-11);  // well above rounding
  // 16 at vanishing step; the term of the next order adds 10 % at 5 ms and half of that at half.
  EXPECT_NEAR(std::log2(coarse / medium), 4.0, 0.12);
  EXPECT_NEAR(std::log2(medium / fine), 4.0, 0.06);
}

// With inductance the currents are states that lag by l_a/r_a behind (3.9): as l_a vanishes, the
// difference vanishes in proportion.
TEST(Plant, ASmallInductanceTendsToNone) {
  Vehicle v = LoadVehicle("mambo-coupled");
  constexpr double kTime_s = 0.02;
  constexpr double kStep_s = 5e-6;  // a quarter of the shorter l_a/r_a
  constexpr int kSteps = 4000;
  const auto in = LivelyInputs(0.13);
  State none = LivelyStart(v);
  const Plant plain(v, kAir);
  test::Fly(plain, in, none, kTime_s / 40, 40);
  const auto currents = plain.ElectricalAt(LivelyStart(v), in).current_A;
  const auto end = [&](double inductance_H) {
    v.armature_inductance_H = inductance_H;
    const Plant plant(v, kAir);
    PlantState<double, plant::kStatesWithInductance> x{};
    const State start = LivelyStart(v);
    std::copy(start.begin(), start.end(), x.begin());
    std::copy(currents.begin(), currents.end(), x.begin() + plant::kCurrents);
    test::Fly(plant, in, x, kStep_s, kSteps);
    return x;
  };
  const auto larger = end(4e-5);
  const auto smaller = end(2e-5);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t k = plant::kSpeeds + i;
    // The lag is 40 us beside a rotor of 40 ms: 1e-3 of the change of some 100 rad/s.
    EXPECT_LT(std::abs(smaller[k] - none[k]), 0.5) << "motor " << i + 1;
    EXPECT_NEAR((larger[k] - none[k]) / (smaller[k] - none[k]), 2.0, 0.02) << "motor " << i + 1;
  }
  EXPECT_NEAR((larger[plant::kCharge] - none[plant::kCharge]) /
                  (smaller[plant::kCharge] - none[plant::kCharge]),
              2.0,
              0.02);
  // And the battery's side of the loop holds with states too.
  const auto e = Plant(v, kAir).ElectricalAt(smaller, in);
  EXPECT_NEAR(e.battery_V, 4.0 - 0.13 * e.battery_A, 1e-14);
  EXPECT_NEAR(e.battery_V, plain.ElectricalAt(none, in).battery_V, 1e-3);
}

// Every joule is accounted for: what the cell's voltage gives goes into its own resistance, the
// windings, friction, the air and the rotors; what the propellers do to the body goes into its
// motion, its height and drag. Powers are integrated as further states.
TEST(Plant, EnergyIsBalanced) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const Plant plant(v, {.motor_lag = true, .drag = true, .ground = false});
  const auto in = LivelyInputs(0.13);
  constexpr std::size_t kChemical = plant::kStates;  // what the source gives
  constexpr std::size_t kHeat = kChemical + 1;       // of the battery and the windings
  constexpr std::size_t kFriction = kHeat + 1;       // of the bearings
  constexpr std::size_t kAirDrag = kFriction + 1;    // of the propellers
  constexpr std::size_t kLift = kAirDrag + 1;        // thrust and moments on the body
  constexpr std::size_t kWind = kLift + 1;           // drag on the body
  constexpr std::size_t kBattery = kWind + 1;        // charge, by another way
  using Extended = std::array<double, kBattery + 1>;

  const auto derivative = [&](const Extended& at, Extended& change) {
    State x;
    std::copy_n(at.begin(), x.size(), x.begin());
    State dx;
    plant.Derivative(x, in, dx);
    std::copy(dx.begin(), dx.end(), change.begin());
    // Everything from the equations of the parts, in Eigen, not from the plant's own.
    const Eigen::Vector4d w = AsEigen(MotorsAt<4>(x, plant::kSpeeds));
    const double volts = LoopVoltage(v, in.supply, in.duty, MotorsAt<4>(x, plant::kSpeeds));
    const Eigen::Vector4d amperes =
        (volts * AsEigen(in.duty) - v.motor_constant_N_m_per_A * w) / v.armature_resistance_Ohm;
    const double battery_A = (in.supply.voltage_V - volts) / in.supply.resistance_Ohm;
    const Eigen::Vector3d rates = AsEigen(TripleAt(x, plant::kRates));
    const Eigen::Vector3d velocity = AsEigen(TripleAt(x, plant::kVelocity));
    const Eigen::Vector3d up = -test::Rotation(TripleAt(x, plant::kAngles)).col(2);
    const double side = v.arm_m / std::numbers::sqrt2;
    const Eigen::Vector4d thrust = v.thrust_coefficient_N_s2 * w.cwiseAbs2();
    const Eigen::Vector4d twist = v.torque_coefficient_N_m_s2 * w.cwiseAbs2();
    const Eigen::Vector3d moment(side * (-thrust[0] - thrust[1] + thrust[2] + thrust[3]),
                                 side * (thrust[0] - thrust[1] - thrust[2] + thrust[3]),
                                 -twist[0] + twist[1] - twist[2] + twist[3]);
    change[kChemical] = in.supply.voltage_V * battery_A;
    change[kHeat] = in.supply.resistance_Ohm * battery_A * battery_A +
                    v.armature_resistance_Ohm * amperes.squaredNorm();
    change[kFriction] = v.friction_N_m_s * w.squaredNorm();
    change[kAirDrag] = twist.dot(w);
    change[kLift] = thrust.sum() * up.dot(velocity) + moment.dot(rates);
    change[kWind] = -v.linear_drag_N_s_per_m * velocity.dot(velocity - AsEigen(in.wind_m_per_s));
    change[kBattery] = battery_A;
  };
  const auto rotors = [&](const Extended& x) {
    return 0.5 * v.rotor_inertia_kg_m2 *
           Eigen::Map<const Eigen::Vector4d>(&x[plant::kSpeeds]).squaredNorm();
  };
  const auto body = [&](const Extended& x) {
    const Eigen::Map<const Eigen::Vector3d> velocity(&x[plant::kVelocity]);
    const Eigen::Map<const Eigen::Vector3d> rates(&x[plant::kRates]);
    return 0.5 * v.mass_kg * velocity.squaredNorm() +
           0.5 * rates.dot(AsEigen(v.inertia_kg_m2).cwiseProduct(rates)) -
           v.mass_kg * kGravity_m_per_s2 * x[plant::kPosition + 2];
  };
  Extended x{};
  const State start = LivelyStart(v);
  std::copy(start.begin(), start.end(), x.begin());
  const Extended before = x;
  test::RungeKutta4(derivative, x, 5e-4, 400);

  EXPECT_GT(x[kChemical], 1.0);  // some 3 J in 0.2 s
  EXPECT_GT(std::abs(x[kLift]), 0.01);
  constexpr double kStepError = 1e-9;  // RK4 at 0.5 ms beside 40 ms, in joules
  EXPECT_NEAR(
      x[kChemical], x[kHeat] + x[kFriction] + x[kAirDrag] + rotors(x) - rotors(before), kStepError);
  EXPECT_NEAR(x[kLift] + x[kWind], body(x) - body(before), kStepError);
  EXPECT_NEAR(x[kBattery], x[plant::kCharge], kStepError);
}

// Motors at their equilibrium are the motors with lag once they have settled, currents and all.
TEST(Plant, MotorsWithoutLagAreThoseThatHaveSettled) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  const PlantInputs<double> in{.duty = {0.5, 0.6, 0.7, 0.8}, .supply = {4.1, 0.0}};
  State x = HoverState(v);
  test::Fly(Plant(v, kAir), in, x, 1e-3, 1500);
  const auto settled = Plant(v, kAir).ElectricalAt(x, in);
  const auto at_once =
      Plant(v, {.motor_lag = false, .drag = false, .ground = false}).ElectricalAt(State{}, in);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(at_once.speed_rad_per_s[i], settled.speed_rad_per_s[i], 1e-8);
    EXPECT_NEAR(at_once.current_A[i], settled.current_A[i], 1e-10);
  }
  EXPECT_EQ(at_once.battery_V, 4.1);
  EXPECT_NEAR(at_once.battery_A, settled.battery_A, 1e-10);
  EXPECT_LT(std::abs(x[plant::kSpeeds] - HeldSpeed(v, 0.5 * 4.1)), 1e-8);
}

TEST(Plant, CanBeDifferentiatedInStateAndDuty) {
  constexpr int kUnknowns = int(plant::kStates) + 4;
  using Jet = ceres::Jet<double, kUnknowns>;
  const Vehicle v = LoadVehicle("mambo-coupled");
  const Plant plant(v, {.motor_lag = true, .drag = true, .ground = true});
  State x = LivelyStart(v);
  Set(x, plant::kPosition, {0.1, 0.2, 0.001});  // with feet in the ground
  const auto in = LivelyInputs(0.13);
  PlantState<Jet> jets;
  PlantInputs<Jet> jet_in;
  for (int k = 0; k < int(plant::kStates); ++k) jets[std::size_t(k)] = Jet(x[std::size_t(k)], k);
  for (int i = 0; i < 4; ++i) {
    jet_in.duty[std::size_t(i)] = Jet(in.duty[std::size_t(i)], int(plant::kStates) + i);
  }
  jet_in.supply = {Jet(in.supply.voltage_V), Jet(in.supply.resistance_Ohm)};
  jet_in.wind_m_per_s = in.wind_m_per_s;
  PlantState<Jet> slopes;
  plant.Derivative(jets, jet_in, slopes);
  State plain;
  plant.Derivative(x, in, plain);
  EXPECT_GT(std::abs(plain[plant::kVelocity + 2]), 20.0);  // the ground pushes
  for (std::size_t row = 0; row < plant::kStates; ++row) {
    ASSERT_NEAR(slopes[row].a, plain[row], 1e-13 * std::max(1.0, std::abs(plain[row]))) << row;
    for (std::size_t column = 0; column < kUnknowns; ++column) {
      const auto f = [&](double value) {
        State at = x;
        auto given = in;
        (column < plant::kStates ? at[column] : given.duty[column - plant::kStates]) = value;
        State dx;
        plant.Derivative(at, given, dx);
        return dx[row];
      };
      const double here = column < plant::kStates ? x[column] : in.duty[column - plant::kStates];
      const double step = column >= plant::kSpeeds && column < plant::kCharge ? 20.0 : 1e-4;
      const auto numeric = test::Ridders(f, here, step);
      const double slope = slopes[row].v[int(column)];
      // Differences of numbers as large as the derivative itself, over the step.
      const double rounding = 1e-12 * std::max(1.0, std::abs(plain[row])) / step;
      EXPECT_NEAR(slope, numeric.value, 1e-7 * std::abs(slope) + 10 * numeric.error + rounding)
          << "d(" << row << ")/d(" << column << ")";
    }
  }
}

}  // namespace
}  // namespace lipoid
