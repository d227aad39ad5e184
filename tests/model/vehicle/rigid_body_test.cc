#include "model/vehicle/rigid_body.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

using Jet = ceres::Jet<double, 1>;
using test::AsEigen;
using test::RandomAngles;
using test::RandomTriple;

using test::kDrawSeed;
using test::kEpsilon;
using test::kPoseDraws;
// A handful of sines, products and sums of numbers of order 1.
constexpr double kRoundingOfRotation = 16.0 * kEpsilon;
// The same beside secants of up to 1/cos(1.4) = 6, squared.
constexpr double kRoundingNearPole = 36.0 * kRoundingOfRotation;

// Angles that move at these rates: the derivative of everything made from them is its change per
// second.
Triple<Jet> Moving(const Triple<double>& angles, const Triple<double>& rates) {
  Triple<Jet> moving;
  for (std::size_t k = 0; k < 3; ++k) {
    moving[k] = Jet(angles[k]);
    moving[k].v[0] = rates[k];
  }
  return moving;
}

TEST(RigidBody, RotationIsTheProductOfTheElementaryOnes) {
  std::mt19937 engine(kDrawSeed);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto angles = RandomAngles(engine);
    const auto vector = RandomTriple(engine, 1.0);
    // (3.2), as printed.
    const double sx = std::sin(angles[0]), cx = std::cos(angles[0]);
    const double sy = std::sin(angles[1]), cy = std::cos(angles[1]);
    const double sz = std::sin(angles[2]), cz = std::cos(angles[2]);
    Eigen::Matrix3d x, y, z;
    z << cz, -sz, 0, sz, cz, 0, 0, 0, 1;
    y << cy, 0, sy, 0, 1, 0, -sy, 0, cy;
    x << 1, 0, 0, 0, cx, -sx, 0, sx, cx;
    const Eigen::Matrix3d rotation = z * y * x;
    ASSERT_LT((rotation - test::Rotation(angles)).norm(), kRoundingOfRotation);

    const Attitude<double> attitude(angles);
    const auto inertial = attitude.ToInertial(vector);
    ASSERT_LT((AsEigen(inertial) - rotation * AsEigen(vector)).norm(), kRoundingOfRotation);
    ASSERT_LT((AsEigen(attitude.ToBody(vector)) - rotation.transpose() * AsEigen(vector)).norm(),
              kRoundingOfRotation);
    ASSERT_LT((AsEigen(attitude.Down()) - rotation.col(2)).norm(), kRoundingOfRotation);
    // Orthonormal: there and back, and as long as before.
    ASSERT_LT((AsEigen(attitude.ToBody(inertial)) - AsEigen(vector)).norm(), kRoundingOfRotation);
    ASSERT_NEAR(AsEigen(inertial).norm(), AsEigen(vector).norm(), kRoundingOfRotation);
  }
}

// What makes Omega a rate of turn: R' = R [Omega]x, whatever S looks like.
TEST(RigidBody, AngleRatesTurnTheRotationAtTheBodyRates) {
  std::mt19937 engine(kDrawSeed);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto angles = RandomAngles(engine);
    const auto rates = RandomTriple(engine, 1.0);
    const auto moving = Moving(angles, Attitude<double>(angles).AngleRates(rates));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Triple<Jet> unit{Jet(0.0), Jet(0.0), Jet(0.0)};
      unit[axis] = Jet(1.0);
      const auto column = Attitude<Jet>(moving).ToInertial(unit);
      const Eigen::Vector3d change(column[0].v[0], column[1].v[0], column[2].v[0]);
      const Eigen::Vector3d turned =
          test::Rotation(angles) * AsEigen(rates).cross(Eigen::Vector3d::Unit(int(axis)));
      ASSERT_LT((change - turned).norm(), kRoundingNearPole) << "axis " << axis;
    }
  }
}

TEST(RigidBody, AngleRatesAreTheMatrixOfTheThesis) {
  std::mt19937 engine(kDrawSeed);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto angles = RandomAngles(engine);
    const auto rates = RandomTriple(engine, 1.0);
    const double s = std::sin(angles[0]), c = std::cos(angles[0]);
    const double tan = std::tan(angles[1]), sec = 1.0 / std::cos(angles[1]);
    Eigen::Matrix3d matrix;
    matrix << 1, s * tan, c * tan, 0, c, -s, 0, s * sec, c * sec;  // (3.8)
    const Attitude<double> attitude(angles);
    const auto angle_rates = attitude.AngleRates(rates);
    ASSERT_LT((AsEigen(angle_rates) - matrix * AsEigen(rates)).norm(), kRoundingNearPole);
    ASSERT_LT((AsEigen(attitude.BodyRates(angle_rates)) - AsEigen(rates)).norm(),
              kRoundingNearPole);
  }
}

TEST(RigidBody, DriftIsTheChangeOfTheMatrixAtConstantBodyRates) {
  std::mt19937 engine(kDrawSeed);
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto angles = RandomAngles(engine);
    const auto rates = RandomTriple(engine, 3.0);
    const Attitude<double> attitude(angles);
    const auto moving = Moving(angles, attitude.AngleRates(rates));
    const auto rate =
        Attitude<Jet>(moving).AngleRates({Jet(rates[0]), Jet(rates[1]), Jet(rates[2])});
    const auto drift = attitude.AngleRateDrift(rates);
    // Up to 9 sec² = 311 rad/s².
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(drift[k], rate[k].v[0], 9.0 * kRoundingNearPole) << "angle " << k;
    }
  }
}

TEST(RigidBody, GyroscopicTorqueIsTheCrossProduct) {
  std::mt19937 engine(kDrawSeed);
  const std::array<double, 3> inertia{1.0, 2.0, 2.5};
  for (int draw = 0; draw < kPoseDraws; ++draw) {
    const auto rates = RandomTriple(engine, 1.0);
    const auto other = RandomTriple(engine, 1.0);
    const Eigen::Vector3d w = AsEigen(rates);
    ASSERT_LT((AsEigen(Cross(rates, other)) - w.cross(AsEigen(other))).norm(), kRoundingOfRotation);
    ASSERT_LT((AsEigen(GyroscopicTorque(inertia, rates)) -
               w.cross(AsEigen(inertia).cwiseProduct(w).eval()))
                  .norm(),
              kRoundingOfRotation);
  }
}

}  // namespace
}  // namespace lipoid
