#include "model/vehicle/allocation.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

constexpr unsigned kSeed = 20261120;
constexpr int kDraws = 200;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

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
  std::mt19937 engine(kSeed);
  const double side = v.arm_m * std::sin(std::numbers::pi / 4.0);
  // x forward, y to the right: front right, back right, back left, front left.
  const Eigen::Vector3d arms[4] = {
      {side, side, 0}, {-side, side, 0}, {-side, -side, 0}, {side, -side, 0}};
  const double spin[4] = {-1, 1, -1, 1};
  for (int draw = 0; draw < kDraws; ++draw) {
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
  std::mt19937 engine(kSeed);
  const double hover_squared = std::pow(test::HoverSpeed(v), 2);
  for (int draw = 0; draw < kDraws; ++draw) {
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
  std::mt19937 engine(kSeed);
  for (int draw = 0; draw < kDraws; ++draw) {
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
  std::mt19937 engine(kSeed);
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

}  // namespace
}  // namespace lipoid
