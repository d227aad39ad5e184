#include "identify/logs/flight/dataflash.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>

#include "identify/logs/flight/bytes.h"
#include "identify/logs/flight/message_walk.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

constexpr std::string_view kHead("\xA3\x95", 2);
constexpr std::size_t kHeadBytes = 3;
constexpr std::uint8_t kFormatType = 0x80;
constexpr std::size_t kFormatBytes = 89;
constexpr double kMostBatteries = 255.0;  // as many as an instance of one byte can tell

// What a letter of a format means, before hundredths that only the message knows. A text has no number.
struct FieldType {
  char letter;
  std::size_t bytes;
  double (*number)(std::string_view bytes, std::size_t offset) = nullptr;
  double factor = 1.0;
};

constexpr FieldType kFieldTypes[] = {{'b', 1, &DoubleAt<std::int8_t>},
                                     {'B', 1, &DoubleAt<std::uint8_t>},
                                     {'M', 1, &DoubleAt<std::uint8_t>},
                                     {'h', 2, &DoubleAt<std::int16_t>},
                                     {'H', 2, &DoubleAt<std::uint16_t>},
                                     {'c', 2, &DoubleAt<std::int16_t>, 0.01},
                                     {'C', 2, &DoubleAt<std::uint16_t>, 0.01},
                                     {'g', 2, &HalfAt},
                                     {'i', 4, &DoubleAt<std::int32_t>},
                                     {'I', 4, &DoubleAt<std::uint32_t>},
                                     {'e', 4, &DoubleAt<std::int32_t>, 0.01},
                                     {'E', 4, &DoubleAt<std::uint32_t>, 0.01},
                                     {'L', 4, &DoubleAt<std::int32_t>, 1e-7},
                                     {'f', 4, &DoubleAt<float>},
                                     {'n', 4},
                                     {'q', 8, &DoubleAt<std::int64_t>},
                                     {'Q', 8, &DoubleAt<std::uint64_t>},
                                     {'d', 8, &DoubleAt<double>},
                                     {'N', 16},
                                     {'Z', 64},
                                     {'a', 64}};

struct FieldPlace {
  std::size_t offset = 0;
  FieldType type = kFieldTypes[0];
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
    const auto* const type =
        std::find_if(std::begin(kFieldTypes), std::end(kFieldTypes), [&](const FieldType& each) {
          return each.letter == letter;
        });
    if (type == std::end(kFieldTypes) || kHeadBytes + offset + type->bytes > format.bytes) break;
    format.places.emplace(rest.substr(0, end), FieldPlace{offset, *type});
    offset += type->bytes;
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
    if (!place || place->type.number == nullptr) return kNaN;
    return place->type.factor * place->type.number(payload, place->offset);
  }

  // Volts or amperes: integers without a unit of their own are hundredths.
  static double Hundredths(const Format& format, std::string_view payload, std::string_view field) {
    const auto place = format.Find(field);
    const double value = Value(format, payload, field);
    return place && (place->type.letter == 'h' || place->type.letter == 'H') ? 0.01 * value : value;
  }

  // number 0: as the message says, the first where it does not.
  void TakeBattery(const Format& format, std::string_view payload, int number) {
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
    track.current_A.push_back(current_A == -1.0 ? kNaN : current_A);
    track.temperature_degC.push_back(Value(format, payload, "Temp"));
  }

  void TakeParameter(const Format& format, std::string_view payload) {
    const auto name = format.Find("Name");
    if (!name) return;
    // What was set first counts: later ones were changed in flight.
    parameters_.emplace(TextAt(payload, name->offset, name->type.bytes),
                        Value(format, payload, "Value"));
  }

  void TakeText(const Format& format, std::string_view payload) {
    const auto place = format.Find("Message");
    if (!place) return;
    const std::string text = TextAt(payload, place->offset, place->type.bytes);
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
        return found == parameters_.end() ? kNaN : found->second;
      };
      constexpr double kVoltageOnly = 3.0;
      if (parameter("MONITOR") == kVoltageOnly) track.current_A.assign(track.size(), kNaN);
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
