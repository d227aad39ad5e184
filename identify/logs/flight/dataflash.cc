#include "identify/logs/flight/dataflash.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <optional>

#include "identify/logs/flight/bytes.h"
#include "identify/logs/flight/message_walk.h"

namespace lipoid {
namespace {

constexpr std::string_view kHead("\xA3\x95", 2);
constexpr std::size_t kHeadBytes = 3;
constexpr std::uint8_t kFormatType = 0x80;
constexpr std::size_t kFormatBytes = 89;
constexpr double kMostBatteries = 255.0;  // as many as an instance of one byte can tell

std::size_t BytesOf(char letter) {
  switch (letter) {
    case 'b':
    case 'B':
    case 'M':
      return 1;
    case 'h':
    case 'H':
    case 'c':
    case 'C':
    case 'g':
      return 2;
    case 'i':
    case 'I':
    case 'e':
    case 'E':
    case 'L':
    case 'f':
    case 'n':
      return 4;
    case 'q':
    case 'Q':
    case 'd':
      return 8;
    case 'N':
      return 16;
    case 'Z':
    case 'a':
      return 64;
    default:
      return 0;
  }
}

// What the letters mean, before hundredths that only the message knows.
double Number(std::string_view bytes, std::size_t offset, char letter) {
  switch (letter) {
    case 'b':
      return NumberAt<std::int8_t>(bytes, offset);
    case 'B':
    case 'M':
      return NumberAt<std::uint8_t>(bytes, offset);
    case 'h':
      return NumberAt<std::int16_t>(bytes, offset);
    case 'H':
      return NumberAt<std::uint16_t>(bytes, offset);
    case 'i':
      return NumberAt<std::int32_t>(bytes, offset);
    case 'I':
      return NumberAt<std::uint32_t>(bytes, offset);
    case 'q':
      return static_cast<double>(NumberAt<std::int64_t>(bytes, offset));
    case 'Q':
      return static_cast<double>(NumberAt<std::uint64_t>(bytes, offset));
    case 'f':
      return NumberAt<float>(bytes, offset);
    case 'd':
      return NumberAt<double>(bytes, offset);
    case 'g':
      return HalfAt(bytes, offset);
    case 'c':
      return 0.01 * NumberAt<std::int16_t>(bytes, offset);
    case 'C':
      return 0.01 * NumberAt<std::uint16_t>(bytes, offset);
    case 'e':
      return 0.01 * NumberAt<std::int32_t>(bytes, offset);
    case 'E':
      return 0.01 * NumberAt<std::uint32_t>(bytes, offset);
    case 'L':
      return 1e-7 * NumberAt<std::int32_t>(bytes, offset);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

struct FieldPlace {
  std::size_t offset = 0;
  char letter = 'f';
};

struct Format {
  std::string name;
  std::size_t bytes = 0;  // with the head
  std::map<std::string, FieldPlace, std::less<>> places;

  [[nodiscard]] std::optional<FieldPlace> Find(std::string_view field) const {
    const auto found = places.find(field);
    if (found == places.end()) return std::nullopt;
    return found->second;
  }
};

Format ParseFormat(std::string_view payload) {
  Format format;
  format.bytes = static_cast<std::uint8_t>(payload[1]);
  format.name = TextAt(payload, 2, 4);
  const std::string letters = TextAt(payload, 6, 16);
  const std::string names = TextAt(payload, 22, 64);
  std::string_view rest = names;
  std::size_t offset = 0;
  for (const char letter : letters) {
    const auto end = std::min(rest.find(','), rest.size());
    const std::size_t bytes = BytesOf(letter);
    if (bytes == 0 || kHeadBytes + offset + bytes > format.bytes) break;
    format.places.emplace(rest.substr(0, end), FieldPlace{offset, letter});
    offset += bytes;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return format;
}

class DataflashReader {
 public:
  explicit DataflashReader(std::string_view bytes) : bytes_(bytes) {
    formats_[kFormatType] = Format{.name = "FMT", .bytes = kFormatBytes, .places = {}};
  }

  AutopilotLog Read() {
    MessageWalk(*this, bytes_, log_).From(0);
    Finish();
    return std::move(log_);
  }

  [[nodiscard]] std::size_t MessageAt(std::size_t at) const {
    const Format* format = FormatAt(at);
    return format != nullptr && format->bytes <= bytes_.size() - at ? format->bytes : 0;
  }

  [[nodiscard]] bool EndsInside(std::size_t at) const {
    const std::string_view rest = bytes_.substr(at);
    if (rest.size() < kHeadBytes) return kHead.starts_with(rest.substr(0, 2));
    const Format* format = FormatAt(at);
    return format != nullptr && format->bytes > rest.size();
  }

  void Take(std::size_t at, std::size_t size) {
    TakeMessage(static_cast<std::uint8_t>(bytes_[at + 2]),
                bytes_.substr(at + kHeadBytes, size - kHeadBytes));
  }

 private:
  [[nodiscard]] const Format* FormatAt(std::size_t at) const {
    if (at + kHeadBytes > bytes_.size() || bytes_.substr(at, 2) != kHead) return nullptr;
    const Format& format = formats_[static_cast<std::uint8_t>(bytes_[at + 2])];
    return format.bytes > kHeadBytes ? &format : nullptr;
  }

  void TakeMessage(std::uint8_t type, std::string_view payload) {
    if (type == kFormatType) {
      Format format = ParseFormat(payload);
      const auto of = static_cast<std::uint8_t>(payload[0]);
      if (of != kFormatType) formats_[of] = std::move(format);
      return;
    }
    const Format& format = formats_[type];
    if (format.name == "BAT" || format.name == "CURR") TakeBattery(format, payload, 0);
    if (format.name == "BAT2" || format.name == "CUR2") TakeBattery(format, payload, 2);
    if (format.name == "PARM") TakeParameter(format, payload);
    if (format.name == "MSG") TakeText(format, payload);
  }

  static double Value(const Format& format, std::string_view payload, std::string_view field) {
    const auto place = format.Find(field);
    return place ? Number(payload, place->offset, place->letter)
                 : std::numeric_limits<double>::quiet_NaN();
  }

  // Volts or amperes: integers without a unit of their own are hundredths.
  static double Hundredths(const Format& format, std::string_view payload, std::string_view field) {
    const auto place = format.Find(field);
    const double value = Value(format, payload, field);
    return place && (place->letter == 'h' || place->letter == 'H') ? 0.01 * value : value;
  }

  // number 0: as the message says, the first where it does not.
  void TakeBattery(const Format& format, std::string_view payload, int number) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (number == 0) {
      double instance = Value(format, payload, "Inst");
      if (std::isnan(instance)) instance = Value(format, payload, "Instance");
      const bool says = instance >= 0.0 && instance < kMostBatteries;
      number = says ? static_cast<int>(instance) + 1 : 1;
    }
    double time_s = 1e-6 * Value(format, payload, "TimeUS");
    if (std::isnan(time_s)) time_s = 1e-3 * Value(format, payload, "TimeMS");
    if (std::isnan(time_s)) return;
    BatteryTrack& track = batteries_[number];
    track.number = number;
    track.message = format.name;
    track.time_s.push_back(time_s);
    track.voltage_V.push_back(Hundredths(format, payload, "Volt"));
    const double current_A = Hundredths(format, payload, "Curr");
    track.current_A.push_back(current_A == -1.0 ? kNone : current_A);
    track.temperature_degC.push_back(Value(format, payload, "Temp"));
  }

  void TakeParameter(const Format& format, std::string_view payload) {
    const auto name = format.Find("Name");
    if (!name) return;
    // What was set first counts: later ones were changed in flight.
    parameters_.emplace(TextAt(payload, name->offset, BytesOf(name->letter)),
                        Value(format, payload, "Value"));
  }

  void TakeText(const Format& format, std::string_view payload) {
    const auto place = format.Find("Message");
    if (!place) return;
    const std::string text = TextAt(payload, place->offset, BytesOf(place->letter));
    if (firmware_.empty() && (text.starts_with("Ardu") || text.starts_with("APM:")))
      firmware_ = text;
    constexpr std::string_view kFrame = "Frame: ";
    if (frame_.empty() && text.starts_with(kFrame)) frame_ = text.substr(kFrame.size());
  }

  void Finish() {
    for (auto& [key, track] : batteries_) {
      const auto number = key;  // Clang 14 lets no lambda take a structured binding
      const auto parameter = [&](std::string_view name) {
        const auto found = parameters_.find(number == 1 ? fmt::format("BATT_{}", name)
                                                        : fmt::format("BATT{}_{}", number, name));
        return found == parameters_.end() ? std::numeric_limits<double>::quiet_NaN()
                                          : found->second;
      };
      constexpr double kVoltageOnly = 3.0;
      if (parameter("MONITOR") == kVoltageOnly)
        track.current_A.assign(track.size(), std::numeric_limits<double>::quiet_NaN());
      if (const double capacity_mAh = parameter("CAPACITY"); capacity_mAh > 0.0)
        track.capacity_Ah = 1e-3 * capacity_mAh;
      log_.batteries.push_back(std::move(track));
    }
    log_.vehicle = firmware_;
    if (!frame_.empty()) log_.vehicle += (firmware_.empty() ? "frame " : ", frame ") + frame_;
  }

  std::string_view bytes_;
  AutopilotLog log_;
  std::array<Format, 256> formats_;
  std::map<int, BatteryTrack> batteries_;
  std::map<std::string, double> parameters_;
  std::string firmware_;
  std::string frame_;
};

}  // namespace

bool IsDataFlash(std::string_view bytes) {
  // The first message says how messages of its own kind look.
  return bytes.size() >= kHeadBytes && bytes.starts_with(kHead) &&
         static_cast<std::uint8_t>(bytes[2]) == kFormatType;
}

AutopilotLog ReadDataFlash(std::string_view bytes) { return DataflashReader(bytes).Read(); }

}  // namespace lipoid
