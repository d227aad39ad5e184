#include "model/control/gains.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "model/core/nearest_name.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {
namespace {

constexpr double kLargest = 1e9;

// The thesis prints no yaw and no position gains. Yaw: three real poles at 4 rad/s. Position: both
// poles of X'' = -g (K_p X + K_d X') at 3 rad/s. Slower ones, near the 1 rad/s at which the thesis'
// attitude gains ring, are unstable as soon as xi < 1 leaves a part of each tilt to the feedback
// (docs/theory.md).
constexpr ErrorGains kYaw{.proportional = 48.0, .integral = 64.0, .derivative = 12.0};
constexpr PositionGains kPosition{.proportional_rad_per_m = 9.0 / kGravity_m_per_s2,
                                  .derivative_rad_s_per_m = 6.0 / kGravity_m_per_s2};

// Sections 6.2 and 6.3; the order of the aware altitude gains is corrected (docs/corrections.md).
const std::array<Gains, 2>& Shipped() {
  static const std::array<Gains, 2> sets{{
      {.name = "aware",
       .altitude = {.proportional = 5.03, .integral = 1.36, .derivative = 7.87},
       .attitude = {.proportional = 0.99, .integral = 0.07, .derivative = 0.25},
       .yaw = kYaw,
       .position = kPosition},
      {.name = "unaware",
       .altitude = {.proportional = 0.95, .integral = 0.25, .derivative = 0.54},
       .attitude = {.proportional = 0.95, .integral = 0.07, .derivative = 0.12},
       .yaw = kYaw,
       .position = kPosition},
  }};
  return sets;
}

// What is next to none is none: the state of an integral that holds a hover goes with the inverse of its gain.
double ReadGain(const JsonReader& json) {
  constexpr double kLeast = 1e-12;
  const double gain = json.Number(0.0, kLargest);
  return gain < kLeast ? 0.0 : gain;
}

ErrorGains ReadErrorGains(const JsonReader& json) {
  json.OnlyKeys({"proportional", "integral", "derivative"});
  return {.proportional = ReadGain(json.At("proportional")),
          .integral = ReadGain(json.At("integral")),
          .derivative = ReadGain(json.At("derivative"))};
}

Json ErrorGainsToJson(const ErrorGains& gains) {
  return {{"proportional", gains.proportional},
          {"integral", gains.integral},
          {"derivative", gains.derivative}};
}

constexpr std::array<std::pair<std::string_view, double References::*>, 7> kReferences{{
    {"altitude_rad_per_s", &References::altitude_rad_per_s},
    {"attitude_rad_per_s", &References::attitude_rad_per_s},
    {"yaw_rad_per_s", &References::yaw_rad_per_s},
    {"position_rad_per_s", &References::position_rad_per_s},
    {"climb_m_per_s", &References::climb_m_per_s},
    {"descent_m_per_s", &References::descent_m_per_s},
    {"speed_m_per_s", &References::speed_m_per_s},
}};

Json ReferencesToJson(const References& references) {
  Json json = Json::object();
  for (const auto& [key, member] : kReferences) json[std::string(key)] = references.*member;
  return json;
}

}  // namespace

std::vector<std::string> ShippedGainsNames() { return NamesOf(Shipped()); }

Gains ParseGains(const std::string& text, const std::string& file) {
  const Json document = ParseJson(text, file);
  const JsonReader json(document, file, text);
  json.OnlyKeys({"schema", "name", "altitude", "attitude", "yaw", "position", "references", "run"});
  if (json.At("schema").Text() != kGainsSchema) {
    json.At("schema").Fail(fmt::format("\"{}\"", kGainsSchema));
  }
  Gains gains{.name = json.At("name").Text(),
              .altitude = ReadErrorGains(json.At("altitude")),
              .attitude = ReadErrorGains(json.At("attitude")),
              .yaw = kYaw,
              .position = kPosition};
  if (const auto yaw = json.Find("yaw")) gains.yaw = ReadErrorGains(*yaw);
  if (const auto position = json.Find("position")) {
    position->OnlyKeys({"proportional", "derivative", "tilt_limit_rad"});
    gains.position.proportional_rad_per_m = ReadGain(position->At("proportional"));
    gains.position.derivative_rad_s_per_m = ReadGain(position->At("derivative"));
    if (const auto limit = position->Find("tilt_limit_rad")) {
      gains.position.tilt_limit_rad = limit->Number(0.0, 1.5);
    }
  }
  if (const auto references = json.Find("references")) {
    references->OnlyKeys({"altitude_rad_per_s",
                          "attitude_rad_per_s",
                          "yaw_rad_per_s",
                          "position_rad_per_s",
                          "climb_m_per_s",
                          "descent_m_per_s",
                          "speed_m_per_s"});
    for (const auto& [key, member] : kReferences) {
      if (const auto found = references->Find(std::string(key)))
        gains.references.*member = found->Number(0.01, 1e4);
    }
  }
  return gains;
}

Json GainsToJson(const Gains& gains) {
  return {{"schema", kGainsSchema},
          {"name", gains.name},
          {"altitude", ErrorGainsToJson(gains.altitude)},
          {"attitude", ErrorGainsToJson(gains.attitude)},
          {"yaw", ErrorGainsToJson(gains.yaw)},
          {"position",
           {{"proportional", gains.position.proportional_rad_per_m},
            {"derivative", gains.position.derivative_rad_s_per_m},
            {"tilt_limit_rad", gains.position.tilt_limit_rad}}},
          {"references", ReferencesToJson(gains.references)}};
}

Gains LoadGains(const std::string& name_or_file) {
  for (const Gains& gains : Shipped()) {
    if (gains.name == name_or_file) return gains;
  }
  return ParseGains(
      ReadTextFileOr(
          name_or_file, "a gains file, placed, or one of the shipped sets", ShippedGainsNames()),
      name_or_file);
}

}  // namespace lipoid
