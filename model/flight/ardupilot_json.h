#pragma once

/// @file
/// ArduPilot's JSON interface to physics, without the network: datagrams in, lines of JSON out, in
/// lock step. The autopilot sends, little-endian,
///
///   uint16 magic (18458; 29569 with 32 channels), uint16 frame_rate in Hz, uint32 frame_count,
///   uint16 pwm[16 or 32] in microseconds
///
/// and each new frame moves the plant on by 1/frame_rate; the answer is the state then. A frame
/// that comes again, because the answer was lost, gets the same answer and moves nothing. A count
/// that jumps ahead is one step, and what is missing is counted: the autopilot's clock is the
/// timestamp of the answers. A count that falls means that the autopilot was started anew: the
/// plant is reset.
///
/// The first four channels are the motors of ArduCopter's quad X: front right, back left, front
/// left, back right; 1000 is off, 2000 is full. Front right must turn counter-clockwise there, with
/// back left: ForArduCopter() makes a vehicle of which that is true. Frames are the interface's and
/// lipoid's alike: north, east, down and ahead, right, down. Source: the readme of
/// libraries/SITL/examples/JSON in ArduPilot. Tests: tests/model/flight/ardupilot_json_test.cc.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "model/flight/live_plant.h"

namespace lipoid {

inline constexpr std::uint16_t kJsonMagic = 18458;
inline constexpr std::uint16_t kJsonMagic32 = 29569;
inline constexpr std::uint16_t kArduPilotPort = 9002;

struct ServoFrame {
  std::uint16_t rate_Hz = 0;
  std::uint32_t count = 0;
  PerMotor<double> duty{};  ///< in lipoid's order of motors
};

/// None where the datagram is none of the interface's: another length or magic, a rate of 0.
[[nodiscard]] std::optional<ServoFrame> ParseServoFrame(std::string_view datagram);

/// The line for a state, with the line feeds around it.
[[nodiscard]] std::string JsonLine(const LiveState& state, bool wind);

/// The vehicle with motors that turn as ArduCopter's quad X has them.
[[nodiscard]] Vehicle ForArduCopter(Vehicle vehicle);

class ArduPilotPhysics {
 public:
  struct Counts {
    std::uint64_t packets = 0;    ///< all datagrams
    std::uint64_t malformed = 0;  ///< of them not understood, and not answered
    std::uint64_t frames = 0;     ///< that moved the plant
    std::uint64_t repeated = 0;   ///< answered once more
    std::uint64_t missed = 0;     ///< counts that were skipped
    std::uint64_t restarts = 0;
  };

  /// The plant outlives it. `wind`: whether the answers say the wind.
  explicit ArduPilotPhysics(LivePlant& plant, bool wind = false) : plant_(plant), wind_(wind) {}

  /// Called before the plant is reset.
  void OnRestart(std::function<void()> call) { on_restart_ = std::move(call); }

  /// The answer to a datagram; none where there is none to give. Valid until the next call.
  [[nodiscard]] std::optional<std::string_view> Answer(std::string_view datagram);

  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  LivePlant& plant_;
  bool wind_;
  Counts counts_;
  std::function<void()> on_restart_;
  std::optional<std::uint32_t> last_count_;
  std::string answer_;
};

}  // namespace lipoid
