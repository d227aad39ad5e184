#include "model/vehicle/allocation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

using test::kDrawSeed;
using test::kEpsilon;
using test::kPoseDraws;

PerMotor<double> RandomSquares(std::mt19937& engine, double hover_squared) {
  std::uniform_real_distribution<double> share(0.0, 2.0);
  PerMotor<double> squares;
  for (double& s : squares) s = share(engine) * hover_squared;
  return squares;
}

// Each propeller pushes up at its own place; the moment of four forces about the centre of mass is
// what geometry says. The motors' own moments about z follow the printed signs.
TEST(Allocation, WrenchIsThatOfFourForcesAtTheirArms) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  std::mt19937 engine(kDrawSeed);
  const double side = v.arm_m * std::sin(std::numbers::pi / 4.0);
  // x forward, y to the right: front right, back right, back left, front left.
  const Eigen::Vector3d arms[4] = {
      {side, side, 0}, {-side, side, 0}, {-side, -side, 0}, {side, -side, 0}};
  const double spin[4] = {-1, 1, -1, 1};
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto squares = RandomSquares(engine, 3.9e6);
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    double thrust = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double force = v.thrust_coefficient_N_s2 * squares[i];
      thrust += force;
      torque += arms[i].cross(Eigen::Vector3d(0, 0, -force));
      torque[2] += spin[i] * v.torque_coefficient_N_m_s2 * squares[i];
    }
    const auto wrench = WrenchOf(v, squares);
    ASSERT_NEAR(wrench.thrust_N, thrust, 8.0 * kEpsilon * thrust);
    // Differences of four terms of up to side * thrust.
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(wrench.torque_N_m[k], torque[int(k)], 8.0 * kEpsilon * side * thrust);
    }
  }
}

TEST(Allocation, RoundTripGivesTheSpeedsBack) {
  const Vehicle v = LoadVehicle("mambo-physical");
  std::mt19937 engine(kDrawSeed);
  const double hover_squared = std::pow(test::HoverSpeed(v), 2);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto squares = RandomSquares(engine, hover_squared);
    const auto back = SquaredSpeedsOf(v, WrenchOf(v, squares));
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_NEAR(back[i], squares[i], 32.0 * kEpsilon * hover_squared) << "motor " << i + 1;
    }
  }
}

TEST(Allocation, EachMomentAloneNeedsNoThrustAndNoOtherMoment) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Wrench<double> wrench{{0.0, 0.0, 0.0}, 0.6};
    wrench.torque_N_m[axis] = 1e-4;
    const auto squares = SquaredSpeedsOf(v, wrench);
    const auto back = WrenchOf(v, squares);
    EXPECT_NEAR(back.thrust_N, 0.6, 8.0 * kEpsilon);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(back.torque_N_m[k], k == axis ? 1e-4 : 0.0, 8.0 * kEpsilon * 0.6 * v.arm_m);
    }
    // Two motors give what the other two take.
    int faster = 0;
    for (const double s : squares) faster += s > 0.25 * 0.6 / v.thrust_coefficient_N_s2 ? 1 : 0;
    EXPECT_EQ(faster, 2) << "axis " << axis;
  }
}

// Turned by a quarter to the right, every motor stands where its neighbour stood: what was roll is
// pitch then, thrust stays, and yaw changes its sign because neighbours spin against each other.
TEST(Allocation, AQuarterTurnMovesEveryMotorToItsNeighbour) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  std::mt19937 engine(kDrawSeed);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto s = RandomSquares(engine, 1.0);
    const auto here = WrenchOf(v, s);
    const auto turned = WrenchOf(v, PerMotor<double>{s[3], s[0], s[1], s[2]});
    const double rounding = 8.0 * kEpsilon * here.thrust_N;
    ASSERT_NEAR(turned.thrust_N, here.thrust_N, rounding);
    ASSERT_NEAR(turned.torque_N_m[0], -here.torque_N_m[1], rounding * v.arm_m);
    ASSERT_NEAR(turned.torque_N_m[1], here.torque_N_m[0], rounding * v.arm_m);
    ASSERT_NEAR(turned.torque_N_m[2], -here.torque_N_m[2], rounding * v.arm_m);
  }
}

// Propellers that turn the other way push alike and twist against.
TEST(Allocation, MotorsThatTurnTheOtherWayChangeTheSignOfYawAlone) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  Vehicle other = v;
  other.front_right_turns = Turning::kCounterClockwise;
  std::mt19937 engine(kDrawSeed);
  const auto squares = RandomSquares(engine, 3.9e6);
  const auto here = WrenchOf(v, squares);
  const auto there = WrenchOf(other, squares);
  EXPECT_EQ(there.thrust_N, here.thrust_N);
  EXPECT_EQ(there.torque_N_m[0], here.torque_N_m[0]);
  EXPECT_EQ(there.torque_N_m[1], here.torque_N_m[1]);
  EXPECT_EQ(there.torque_N_m[2], -here.torque_N_m[2]);
  EXPECT_NE(there.torque_N_m[2], 0.0);
  const auto back = SquaredSpeedsOf(other, there);
  const auto back_here = SquaredSpeedsOf(v, here);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(back[i], back_here[i]) << i;
}

TEST(Allocation, WhatNoMotorCanDoComesOutNegative) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  const auto squares = SquaredSpeedsOf(v, Wrench<double>{{0.0, 0.0, 0.0}, -1.0});
  for (const double s : squares) EXPECT_LT(s, 0.0);
}

// Layouts of any number of rotors, coaxial pairs with lower rotors that push less.
Vehicle WithLayout(RotorLayout layout) {
  Vehicle v = LoadVehicle("mambo-physical");
  v.layout = layout;
  if (layout == RotorLayout::kY6 || layout == RotorLayout::kX8) v.lower_rotor_thrust_ratio = 0.8;
  return v;
}

constexpr RotorLayout kLayouts[] = {RotorLayout::kQuadX,
                                    RotorLayout::kQuadPlus,
                                    RotorLayout::kHexaX,
                                    RotorLayout::kHexaPlus,
                                    RotorLayout::kOctoX,
                                    RotorLayout::kOctoPlus,
                                    RotorLayout::kY6,
                                    RotorLayout::kX8};

// Effectiveness by geometry: forces at their arms, and the reaction of each propeller's drag, which
// turns the body against the propeller. z points down, so that clockwise from above is positive.
Eigen::MatrixXd Effectiveness(const Vehicle& v) {
  const auto rotors = RotorsOf(v.layout);
  Eigen::MatrixXd b(4, Eigen::Index(rotors.size()));
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const Rotor& rotor = rotors[i];
    const double force =
        (rotor.lower ? v.lower_rotor_thrust_ratio : 1.0) * v.thrust_coefficient_N_s2;
    const Eigen::Vector3d arm(v.arm_m * rotor.ahead, v.arm_m * rotor.right, 0.0);
    Eigen::Vector3d torque = arm.cross(Eigen::Vector3d(0.0, 0.0, -force));
    const bool clockwise = (rotor.turning > 0.0) == (v.front_right_turns == Turning::kClockwise);
    torque[2] += (clockwise ? -1.0 : 1.0) * v.torque_coefficient_N_m_s2;
    b.col(Eigen::Index(i)) << torque, force;
  }
  return b;
}

template <std::size_t R>
void CheckAllocation(const Vehicle& v) {
  const Eigen::MatrixXd b = Effectiveness(v);
  ASSERT_EQ(b.cols(), Eigen::Index(R));
  const Eigen::MatrixXd inverse = b.completeOrthogonalDecomposition().pseudoInverse();
  const double weight_N = v.mass_kg * kGravity_m_per_s2;
  const double hover_squared = weight_N / v.total_thrust_coefficient_N_s2();
  std::mt19937 engine(kDrawSeed);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    Eigen::Vector4d wanted(share(engine) * 0.1 * v.arm_m * weight_N,
                           share(engine) * 0.1 * v.arm_m * weight_N,
                           share(engine) * 1e-3 * v.arm_m * weight_N,
                           weight_N * (1.0 + 0.3 * share(engine)));
    const auto squares =
        SquaredSpeedsOf<R>(v, Wrench<double>{{wanted[0], wanted[1], wanted[2]}, wanted[3]});
    const auto s = test::AsEigen(squares);
    const Eigen::Vector4d given = b * s;
    const auto wrench = WrenchOf<double, R>(v, squares);
    // Sums of R terms, of which each may be as large as weight times arm.
    const double rounding = 64.0 * kEpsilon * weight_N;
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(given[k], wanted[k], rounding * v.arm_m) << k;
      ASSERT_NEAR(wrench.torque_N_m[std::size_t(k)], wanted[k], rounding * v.arm_m) << k;
    }
    ASSERT_NEAR(given[3], wanted[3], rounding);
    ASSERT_NEAR(wrench.thrust_N, wanted[3], rounding);
    if (v.lower_rotor_thrust_ratio == 1.0) {
      const Eigen::VectorXd least = inverse * wanted;
      ASSERT_LT((least - s).cwiseAbs().maxCoeff(), 256.0 * kEpsilon * hover_squared);
    }
  }
  for (const double square : SquaredSpeedsOf<R>(v, Wrench<double>{{0.0, 0.0, 0.0}, weight_N})) {
    EXPECT_NEAR(square, hover_squared, 8.0 * kEpsilon * hover_squared);
  }
}

TEST(Allocation, EveryLayoutGivesTheWrenchThatIsWantedWithTheLeastSquares) {
  for (const RotorLayout layout : kLayouts) {
    for (const Turning turning : {Turning::kClockwise, Turning::kCounterClockwise}) {
      SCOPED_TRACE(OptionNames(RotorLayout{})[std::size_t(layout)].second);
      Vehicle v = WithLayout(layout);
      v.front_right_turns = turning;
      if (v.rotor_count() == 4) CheckAllocation<4>(v);
      if (v.rotor_count() == 6) CheckAllocation<6>(v);
      if (v.rotor_count() == 8) CheckAllocation<8>(v);
    }
  }
}

// Any change of the squares that leaves the wrench makes the sum of f_i s_i² larger.
TEST(Allocation, CoaxialPairsShareSoThatTheWeightedSquaresAreLeast) {
  for (const RotorLayout layout : {RotorLayout::kY6, RotorLayout::kX8}) {
    const Vehicle v = WithLayout(layout);
    const Eigen::MatrixXd b = Effectiveness(v);
    std::vector<double> squares(v.rotor_count());
    Allocate<double>(v, Wrench<double>{{0.01, -0.02, 1e-4}, 0.6}, squares);
    const Eigen::MatrixXd rest = b.fullPivLu().kernel();  // what no wrench sees
    ASSERT_EQ(rest.cols(), b.cols() - 4);
    for (Eigen::Index j = 0; j < rest.cols(); ++j) {
      double slope = 0.0;
      double size = 0.0;
      for (std::size_t i = 0; i < squares.size(); ++i) {
        const double term =
            (RotorsOf(layout)[i].lower ? 0.8 : 1.0) * squares[i] * rest(Eigen::Index(i), j);
        slope += term;
        size += std::abs(term);
      }
      EXPECT_LT(std::abs(slope), 1e-12 * size) << j;
    }
  }
}

TEST(Allocation, TheEquivalentQuadrotorWorksItsMotorsAsHard) {
  for (const RotorLayout layout : kLayouts) {
    const Vehicle v = WithLayout(layout);
    const Vehicle quad = EquivalentQuadrotor(v);
    const auto hardest = [](const Vehicle& of, int axis, double acceleration) {
      std::vector<double> squares(of.rotor_count());
      Wrench<double> wrench{};
      if (axis < 3) {
        wrench.torque_N_m[std::size_t(axis)] = of.inertia_kg_m2[std::size_t(axis)] * acceleration;
      } else {
        wrench.thrust_N = of.mass_kg * acceleration;
      }
      Allocate<double>(of, wrench, squares);
      double most = 0.0;
      for (const double s : squares) most = std::max(most, std::abs(s));
      return most;
    };
    for (int axis = 0; axis < 4; ++axis) {
      const double of_vehicle = hardest(v, axis, 1.0);
      EXPECT_NEAR(hardest(quad, axis, 1.0), of_vehicle, 16.0 * kEpsilon * of_vehicle)
          << OptionNames(RotorLayout{})[std::size_t(layout)].second << ", axis " << axis;
    }
  }
}

}  // namespace
}  // namespace lipoid
