#include "model/control/gains.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>
#include <string>

#include "model/control/flight_controller.h"
#include "model/core/errors.h"
#include "tests/support/text_files.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr std::string_view kText = R"({
  "schema": "lipoid.gains/1",
  "name": "mine",
  "altitude": {"proportional": 1, "integral": 2, "derivative": 3},
  "attitude": {"proportional": 4, "integral": 5, "derivative": 6}
})";

std::string Replaced(std::string_view from, std::string_view to) {
  std::string text(kText);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Refusal(const std::string& text) {
  return test::MessageOf<LoadError>([&] { (void)ParseGains(text, "g.json"); });
}

void ExpectEqual(const ErrorGains& a, const ErrorGains& b) {
  EXPECT_EQ(a.proportional, b.proportional);
  EXPECT_EQ(a.integral, b.integral);
  EXPECT_EQ(a.derivative, b.derivative);
}

// Error dynamics of (3.66) at xi = 1: the largest real part of its poles.
double SlowestPole(const ErrorGains& k) {
  Eigen::Matrix3d matrix;
  matrix << 0, 1, 0, 0, 0, 1, -k.integral, -k.proportional, -k.derivative;
  return matrix.eigenvalues().real().maxCoeff();
}

TEST(Gains, ShippedSetsAreThoseOfTheThesis) {
  EXPECT_EQ(ShippedGainsNames(), (std::vector<std::string>{"aware", "unaware"}));
  const Gains aware = LoadGains("aware");
  // Section 6.3.1 prints [5.03 7.87 1.36] in another order than it says.
  ExpectEqual(aware.altitude, {.proportional = 5.03, .integral = 1.36, .derivative = 7.87});
  ExpectEqual(aware.attitude, {.proportional = 0.99, .integral = 0.07, .derivative = 0.25});
  const Gains unaware = LoadGains("unaware");
  ExpectEqual(unaware.altitude, {.proportional = 0.95, .integral = 0.25, .derivative = 0.54});
  ExpectEqual(unaware.attitude, {.proportional = 0.95, .integral = 0.07, .derivative = 0.12});
}

TEST(Gains, WhatIsNextToNoneIsNone) {
  for (const char* const next : {"5e-324", "1e-300", "1e-13"}) {
    const auto text = Replaced("\"integral\": 2", std::string("\"integral\": ") + next);
    EXPECT_EQ(ParseGains(text, "g.json").altitude.integral, 0.0) << next;
  }
  EXPECT_EQ(
      ParseGains(Replaced("\"integral\": 2", "\"integral\": 1e-9"), "g.json").altitude.integral,
      1e-9);
}

TEST(Gains, ShippedSetsAreStable) {
  for (const auto& name : ShippedGainsNames()) {
    SCOPED_TRACE(name);
    const Gains gains = LoadGains(name);
    EXPECT_EQ(gains.name, name);
    EXPECT_LT(SlowestPole(gains.altitude), 0.0);
    EXPECT_LT(SlowestPole(gains.attitude), 0.0);
    // Three equal poles: eigenvalues of such a matrix are good to a third of the digits.
    EXPECT_NEAR(SlowestPole(gains.yaw), -4.0, 1e-4);
    // K_p = p²/g and K_d = 2 p/g put both poles of X'' = -g (K_p X + K_d X') at -p.
    const double p = 0.5 * 9.81 * gains.position.derivative_rad_s_per_m;
    EXPECT_NEAR(9.81 * gains.position.proportional_rad_per_m, p * p, 1e-12 * p * p);
    EXPECT_GT(p, 0.0);
  }
  // As printed they are not.
  EXPECT_GT(SlowestPole({.proportional = 5.03, .integral = 7.87, .derivative = 1.36}), 0.0);
}

TEST(Gains, AFileHoldsWhatItSaysAndTheRestIsShipped) {
  const Gains gains = ParseGains(std::string(kText), "g.json");
  EXPECT_EQ(gains.name, "mine");
  ExpectEqual(gains.altitude, {.proportional = 1, .integral = 2, .derivative = 3});
  ExpectEqual(gains.attitude, {.proportional = 4, .integral = 5, .derivative = 6});
  const Gains shipped = LoadGains("aware");
  ExpectEqual(gains.yaw, shipped.yaw);
  EXPECT_EQ(gains.position.proportional_rad_per_m, shipped.position.proportional_rad_per_m);
  EXPECT_EQ(gains.position.derivative_rad_s_per_m, shipped.position.derivative_rad_s_per_m);
  EXPECT_EQ(gains.position.tilt_limit_rad, shipped.position.tilt_limit_rad);
}

TEST(Gains, AreReadBackAsTheyWereWritten) {
  Gains gains = LoadGains("unaware");
  gains.yaw = {.proportional = 0.1 + 0.2, .integral = 1e-9, .derivative = 7.0};
  gains.position = {
      .proportional_rad_per_m = 0.3, .derivative_rad_s_per_m = 0.4, .tilt_limit_rad = 0.5};
  const Gains back = ParseGains(GainsToJson(gains).dump(2), "g.json");
  EXPECT_EQ(back.name, gains.name);
  ExpectEqual(back.altitude, gains.altitude);
  ExpectEqual(back.attitude, gains.attitude);
  ExpectEqual(back.yaw, gains.yaw);
  EXPECT_EQ(back.position.proportional_rad_per_m, 0.3);
  EXPECT_EQ(back.position.derivative_rad_s_per_m, 0.4);
  EXPECT_EQ(back.position.tilt_limit_rad, 0.5);
}

TEST(Gains, AreReadStrictly) {
  EXPECT_EQ(Refusal(Replaced("lipoid.gains/1", "lipoid.gains/2")),
            "g.json:2:13: error: /schema: expected \"lipoid.gains/1\", found \"lipoid.gains/2\"");
  EXPECT_EQ(
      Refusal(Replaced("\"integral\": 2", "\"integral\": -2")),
      "g.json:4:47: error: /altitude/integral: expected a number from 0 to 1000000000, found -2");
  EXPECT_NE(Refusal(Replaced("\"integral\": 2", "\"integral\": true")), "(no exception)");
  EXPECT_NE(Refusal(Replaced("\"integral\": 2, ", "")), "(no exception)");
  EXPECT_NE(Refusal(Replaced("\"integral\": 2", "\"integral\": 2, \"more\": 1")), "(no exception)");
  EXPECT_NE(Refusal(Replaced("\"name\"", "\"nam\"")), "(no exception)");
  EXPECT_EQ(Refusal(std::string(kText)), "(no exception)");
}

TEST(Gains, AreLoadedByNameOrFromAFile) {
  EXPECT_EQ(LoadGains(test::WriteText("mine.json", kText)).altitude.derivative, 3.0);
  EXPECT_EQ(
      test::MessageOf<LoadError>([] { (void)LoadGains("awar"); }),
      "awar: error: expected a gains file, placed, or one of the shipped sets (aware, unaware), "
      "found neither. Did you mean 'aware'?");
}

TEST(Gains, TheExampleInTheDocsIsOne) {
  const Gains gains = ParseGains(
      "{\n" + test::DocsExample("docs/formats.md", "  \"schema\": \"lipoid.gains/1\","), "docs");
  EXPECT_EQ(gains.name, "mine");
  EXPECT_EQ(gains.position.tilt_limit_rad, 0.35);
}

TEST(Gains, ReferencesAreThoseOfTheThesisOrOfTheFile) {
  const Gains shipped = LoadGains("aware");
  EXPECT_EQ(shipped.references.attitude_rad_per_s, 100.0);
  Gains gains = shipped;
  gains.references.attitude_rad_per_s = 20.0;
  gains.references.climb_m_per_s = 0.7;
  const Gains read = ParseGains(GainsToJson(gains).dump(), "g.json");
  EXPECT_EQ(read.references.attitude_rad_per_s, 20.0);
  EXPECT_EQ(read.references.climb_m_per_s, 0.7);
  EXPECT_EQ(read.references.yaw_rad_per_s, shipped.references.yaw_rad_per_s);
  // An option that is given wins.
  ControllerOptions options;
  EXPECT_EQ(ReferencesOf(read.references, options).attitude_rad_per_s, 20.0);
  options.attitude_omega_rad_per_s = 50.0;
  EXPECT_EQ(ReferencesOf(read.references, options).attitude_rad_per_s, 50.0);
}

}  // namespace
}  // namespace lipoid
