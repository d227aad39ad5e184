#include "model/flight/ardupilot_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lipoid {
namespace {

constexpr std::size_t kHeaderBytes = 8;
constexpr double kOff_us = 1000.0;
constexpr double kSpan_us = 1000.0;

// Which channel is motor 1 to 4 of lipoid: front right, back right, back left, front left.
constexpr std::array<std::size_t, 4> kChannelOfMotor{0, 3, 1, 2};

std::uint32_t LittleEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < count; ++k) {
    value |= std::uint32_t{static_cast<unsigned char>(bytes[at + k])} << (8 * k);
  }
  return value;
}

void Append(std::string& line, std::string_view key, const Triple<double>& v) {
  // Compact: ArduPilot's reader looks for the bracket right after the colon.
  fmt::format_to(std::back_inserter(line), "\"{}\":[{:.9g},{:.9g},{:.9g}]", key, v[0], v[1], v[2]);
}

}  // namespace

std::optional<ServoFrame> ParseServoFrame(std::string_view datagram) {
  if (datagram.size() < kHeaderBytes) return std::nullopt;
  const std::uint32_t magic = LittleEndian(datagram, 0, 2);
  std::size_t channels = 0;
  if (magic == kJsonMagic) channels = 16;
  if (magic == kJsonMagic32) channels = 32;
  if (channels == 0 || datagram.size() != kHeaderBytes + 2 * channels) return std::nullopt;
  ServoFrame frame;
  frame.rate_Hz = static_cast<std::uint16_t>(LittleEndian(datagram, 2, 2));
  frame.count = LittleEndian(datagram, 4, 4);
  if (frame.rate_Hz == 0) return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {
    const double pwm_us = LittleEndian(datagram, kHeaderBytes + 2 * kChannelOfMotor[i], 2);
    frame.duty[i] = std::clamp((pwm_us - kOff_us) / kSpan_us, 0.0, 1.0);
  }
  return frame;
}

std::string JsonLine(const LiveState& state, bool wind) {
  std::string line;
  line.reserve(512);
  fmt::format_to(std::back_inserter(line), "\n{{\"timestamp\":{:.9f},\"imu\":{{", state.time_s);
  Append(line, "gyro", state.body_rates_rad_per_s);
  line += ',';
  Append(line, "accel_body", state.specific_force_m_per_s2);
  line += "},";
  Append(line, "position", state.position_m);
  line += ',';
  Append(line, "attitude", state.angles_rad);
  line += ',';
  Append(line, "velocity", state.velocity_m_per_s);
  if (wind) {
    line += ',';
    Append(line, "velocity_wind", state.wind_m_per_s);
  }
  fmt::format_to(std::back_inserter(line),
                 ",\"battery\":{{\"voltage\":{:.9g},\"current\":{:.9g}}}}}\n",
                 state.battery_V,
                 state.battery_A);
  return line;
}

Vehicle ForArduCopter(Vehicle vehicle) {
  vehicle.front_right_turns = Turning::kCounterClockwise;
  return vehicle;
}

std::optional<std::string_view> ArduPilotPhysics::Answer(std::string_view datagram) {
  ++counts_.packets;
  const auto frame = ParseServoFrame(datagram);
  if (!frame) {
    ++counts_.malformed;
    return std::nullopt;
  }
  if (last_count_ && frame->count == *last_count_) {
    ++counts_.repeated;
    return answer_;
  }
  if (last_count_ && frame->count < *last_count_) {
    ++counts_.restarts;
    if (on_restart_) on_restart_();
    plant_.Reset();
  } else if (last_count_) {
    counts_.missed += frame->count - *last_count_ - 1;
  }
  last_count_ = frame->count;
  ++counts_.frames;
  plant_.Advance(frame->duty, 1.0 / frame->rate_Hz);
  if (plant_.report().over) return std::nullopt;
  answer_ = JsonLine(plant_.state(), wind_);
  return answer_;
}

}  // namespace lipoid
