#include "model/vehicle/rotor_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace lipoid {
namespace {

class RotorLayouts : public testing::TestWithParam<RotorLayout> {};

// "quad-x" is no name of a test, "quad_x" is.
std::string NameOf(const testing::TestParamInfo<RotorLayout>& info) {
  std::string name(OptionNames(RotorLayout{})[std::size_t(info.param)].second);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

constexpr double kRoundingOfCosines = 8 * 2.3e-16;  // of eight cosines added up

TEST_P(RotorLayouts, AreBalanced) {
  double ahead = 0.0;
  double right = 0.0;
  double turning = 0.0;
  for (const Rotor& rotor : RotorsOf(GetParam())) {
    EXPECT_NEAR(std::hypot(rotor.ahead, rotor.right), 1.0, kRoundingOfCosines);
    EXPECT_EQ(std::abs(rotor.turning), 1.0);
    ahead += rotor.ahead;
    right += rotor.right;
    turning += rotor.turning;
  }
  // Equal thrust of all neither tilts nor turns the vehicle.
  EXPECT_NEAR(ahead, 0.0, kRoundingOfCosines);
  EXPECT_NEAR(right, 0.0, kRoundingOfCosines);
  EXPECT_EQ(turning, 0.0);
  EXPECT_EQ(RotorsOf(GetParam())[0].turning, 1.0);
}

TEST_P(RotorLayouts, MirrorThemselvesAboutTheNose) {
  const auto rotors = RotorsOf(GetParam());
  for (const Rotor& rotor : rotors) {
    bool mirrored = false;
    for (const Rotor& other : rotors) {
      mirrored = mirrored || (other.ahead == rotor.ahead && other.right == -rotor.right &&
                              other.lower == rotor.lower);
    }
    EXPECT_TRUE(mirrored) << rotor.ahead << " ahead, " << rotor.right << " right";
  }
}

TEST_P(RotorLayouts, LowerRotorsTurnAgainstTheUpperOneOfTheirArm) {
  const auto rotors = RotorsOf(GetParam());
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    if (!rotors[i].lower) continue;
    ASSERT_GT(i, 0u);
    EXPECT_FALSE(rotors[i - 1].lower);
    EXPECT_EQ(rotors[i - 1].ahead, rotors[i].ahead);
    EXPECT_EQ(rotors[i - 1].right, rotors[i].right);
    EXPECT_EQ(rotors[i - 1].turning, -rotors[i].turning);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         RotorLayouts,
                         testing::Values(RotorLayout::kQuadX,
                                         RotorLayout::kQuadPlus,
                                         RotorLayout::kHexaX,
                                         RotorLayout::kHexaPlus,
                                         RotorLayout::kOctoX,
                                         RotorLayout::kOctoPlus,
                                         RotorLayout::kY6,
                                         RotorLayout::kX8),
                         NameOf);

TEST(RotorLayout, HasTheRotorsOfItsName) {
  for (const auto& [layout, name] : OptionNames(RotorLayout{})) {
    const std::size_t count = name.starts_with("quad")                          ? 4
                              : name.starts_with("hexa") || name.ends_with("6") ? 6
                                                                                : 8;
    EXPECT_EQ(RotorsOf(layout).size(), count) << name;
  }
}

TEST(RotorLayout, QuadXIsTheOneOfTheThesis) {
  // Front right, back right, back left, front left.
  const auto rotors = RotorsOf(RotorLayout::kQuadX);
  const double ahead[] = {1, -1, -1, 1};
  const double right[] = {1, 1, -1, -1};
  const double turning[] = {1, -1, 1, -1};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rotors[i].ahead, ahead[i] * std::sqrt(0.5));
    EXPECT_EQ(rotors[i].right, right[i] * std::sqrt(0.5));
    EXPECT_EQ(rotors[i].turning, turning[i]);
  }
}

TEST(RotorLayout, PlusPutsTheFirstAhead) {
  for (const RotorLayout layout :
       {RotorLayout::kQuadPlus, RotorLayout::kHexaPlus, RotorLayout::kOctoPlus}) {
    EXPECT_EQ(RotorsOf(layout)[0].ahead, 1.0);
    EXPECT_EQ(RotorsOf(layout)[0].right, 0.0);
    EXPECT_GT(RotorsOf(layout)[1].right, 0.0);  // clockwise seen from above
  }
}

}  // namespace
}  // namespace lipoid
