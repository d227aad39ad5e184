// The interface by bytes written out here. Through the network, and flown: tests/tools/sitl_test.py.
#include "model/flight/ardupilot_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "model/battery/cell_file.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

// Little-endian, by hand.
std::string Frame(unsigned magic,
                  unsigned rate_Hz,
                  std::uint32_t count,
                  const std::vector<unsigned>& pwm,
                  std::size_t channels = 16) {
  std::string bytes;
  const auto put = [&](std::uint32_t value, int size) {
    for (int k = 0; k < size; ++k) bytes += static_cast<char>((value >> (8 * k)) & 0xffU);
  };
  put(magic, 2);
  put(rate_Hz, 2);
  put(count, 4);
  for (std::size_t k = 0; k < channels; ++k) put(k < pwm.size() ? pwm[k] : 0U, 2);
  return bytes;
}

TEST(ArduPilotJson, ChannelsAreTheMotorsOfTheQuadX) {
  // Front right, back left, front left, back right there; clockwise from front right here.
  const auto frame = ParseServoFrame(Frame(18458, 400, 7, {1100, 1200, 1300, 1400}));
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->rate_Hz, 400);
  EXPECT_EQ(frame->count, 7U);
  EXPECT_EQ(frame->duty, (PerMotor<double>{0.1, 0.4, 0.2, 0.3}));
  const auto large =
      ParseServoFrame(Frame(29569, 65535, 0xfffffffeU, {1100, 1200, 1300, 1400}, 32));
  ASSERT_TRUE(large.has_value());
  EXPECT_EQ(large->rate_Hz, 65535);
  EXPECT_EQ(large->count, 0xfffffffeU);
  EXPECT_EQ(large->duty, frame->duty);
}

TEST(ArduPilotJson, PulseWidthsBeyondTheirRangeAreItsEnds) {
  const auto frame = ParseServoFrame(Frame(18458, 400, 0, {0, 65535, 2000, 1000}));
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->duty, (PerMotor<double>{0.0, 0.0, 1.0, 1.0}));
}

TEST(ArduPilotJson, WhatIsNoFrameIsNone) {
  const std::string good = Frame(18458, 400, 1, {1500});
  for (std::size_t size = 0; size < 100; ++size) {
    std::string cut = good + std::string(60, '\0');
    cut.resize(size);
    EXPECT_EQ(ParseServoFrame(cut).has_value(), size == good.size()) << size;
  }
  EXPECT_FALSE(ParseServoFrame(Frame(29569, 400, 1, {1500})));
  EXPECT_FALSE(ParseServoFrame(Frame(18458, 400, 1, {1500}, 32)));
  EXPECT_FALSE(ParseServoFrame(Frame(18458, 0, 1, {1500})));
  EXPECT_FALSE(ParseServoFrame(Frame(0x1a48, 400, 1, {1500})));  // the bytes exchanged
  std::mt19937 engine(5);
  std::string noise(40, '\0');
  int taken = 0;
  for (int k = 0; k < 20'000; ++k) {
    for (char& c : noise) c = static_cast<char>(engine());
    taken += ParseServoFrame(noise).has_value() ? 1 : 0;
  }
  EXPECT_LT(taken, 10);  // one of 65536 has the magic
}

TEST(ArduPilotJson, TheLineIsWhatTheInterfaceAsksFor) {
  LiveState state;
  state.time_s = 12.0025;
  state.position_m = {1.5, -2.5, -3.25};
  state.velocity_m_per_s = {0.5, 1e-7, -0.125};
  state.angles_rad = {0.1, -0.2, 3.0};
  state.body_rates_rad_per_s = {0.01, 0.02, -0.03};
  state.specific_force_m_per_s2 = {0.0, 0.0, -9.81};
  state.wind_m_per_s = {3.0, 0.0, -0.5};
  state.battery_V = 11.1;
  state.battery_A = 14.25;
  EXPECT_EQ(
      JsonLine(state, false),
      "\n{\"timestamp\":12.002500000,\"imu\":{\"gyro\":[0.01,0.02,-0.03],\"accel_body\":[0,0,"
      "-9.81]},\"position\":[1.5,-2.5,-3.25],\"attitude\":[0.1,-0.2,3],\"velocity\":[0.5,1e-07,"
      "-0.125],\"battery\":{\"voltage\":11.1,\"current\":14.25}}\n");
  const auto json = nlohmann::json::parse(JsonLine(state, true));
  EXPECT_EQ(json.at("velocity_wind").at(2), -0.5);
}

TEST(ArduPilotJson, EachNewFrameIsAStepAndARepeatedOneIsNot) {
  const auto plant = MakeLivePlant(
      {.vehicle = ForArduCopter(LoadVehicle("mambo-coupled")), .cell = LoadCell("gifi-600mAh-1")});
  ArduPilotPhysics physics(*plant);
  const auto answer = [&](std::uint32_t count, unsigned rate_Hz = 400) {
    const auto text = physics.Answer(Frame(18458, rate_Hz, count, {1700, 1700, 1700, 1700}));
    EXPECT_TRUE(text.has_value());
    return std::string(text.value_or(""));
  };
  // The autopilot ran before: the first count is whatever it is.
  const std::string first = answer(1000);
  EXPECT_EQ(answer(1000), first);
  EXPECT_DOUBLE_EQ(plant->state().time_s, 0.0025);
  (void)answer(1001);
  EXPECT_DOUBLE_EQ(plant->state().time_s, 0.005);
  (void)answer(1010, 1000);
  EXPECT_DOUBLE_EQ(plant->state().time_s, 0.006);
  EXPECT_EQ(physics.counts().missed, 8U);
  EXPECT_FALSE(physics.Answer("no frame").has_value());
  int told = 0;
  physics.OnRestart([&] {
    ++told;
    EXPECT_DOUBLE_EQ(plant->state().time_s, 0.006);
  });
  EXPECT_EQ(answer(0), first);  // the same first step again
  EXPECT_EQ(told, 1);
  EXPECT_EQ(physics.counts().packets, 6U);
  EXPECT_EQ(physics.counts().frames, 4U);
  EXPECT_EQ(physics.counts().repeated, 1U);
  EXPECT_EQ(physics.counts().malformed, 1U);
  EXPECT_EQ(physics.counts().restarts, 1U);
}

TEST(ArduPilotJson, WhereTheFlightIsOverThereIsNoAnswer) {
  const auto plant = MakeLivePlant(
      {.vehicle = ForArduCopter(LoadVehicle("mambo-physical")), .cell = LoadCell("gifi-600mAh-1")});
  ArduPilotPhysics physics(*plant);
  bool over = false;
  for (std::uint32_t k = 0; k < 2000 && !over; ++k) {
    over = !physics.Answer(Frame(18458, 400, k, {2000, 1000, 2000, 1000})).has_value();
  }
  EXPECT_TRUE(over);
  EXPECT_TRUE(plant->report().over.has_value());
}

}  // namespace
}  // namespace lipoid
