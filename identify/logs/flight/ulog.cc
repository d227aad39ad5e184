#include "identify/logs/flight/ulog.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "identify/logs/flight/bytes.h"
#include "identify/logs/flight/message_walk.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

constexpr std::string_view kMagic("ULog\x01\x12\x35", 7);
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kMessageHeaderBytes = 3;
constexpr std::string_view kTypes = "BFIMPQARDLCSO";
constexpr std::string_view kSync("\x2F\x73\x13\x20\x25\x0C\xBB\x12", 8);
constexpr std::string_view kTopic = "battery_status";

// No message nests formats deeper, and none is longer than its size can say.
constexpr int kMostNesting = 8;
constexpr std::size_t kMostBytes = 1 << 16;

struct BasicType {
  std::string_view name;
  std::size_t bytes;
  double (*number)(std::string_view bytes, std::size_t offset);
};

constexpr BasicType kBasicTypes[] = {{"int8_t", 1, &DoubleAt<std::int8_t>},
                                     {"uint8_t", 1, &DoubleAt<std::uint8_t>},
                                     {"int16_t", 2, &DoubleAt<std::int16_t>},
                                     {"uint16_t", 2, &DoubleAt<std::uint16_t>},
                                     {"int32_t", 4, &DoubleAt<std::int32_t>},
                                     {"uint32_t", 4, &DoubleAt<std::uint32_t>},
                                     {"int64_t", 8, &DoubleAt<std::int64_t>},
                                     {"uint64_t", 8, &DoubleAt<std::uint64_t>},
                                     {"float", 4, &DoubleAt<float>},
                                     {"double", 8, &DoubleAt<double>},
                                     {"bool", 1, &DoubleAt<std::uint8_t>},
                                     {"char", 1, &DoubleAt<std::uint8_t>}};

const BasicType* FindBasicType(std::string_view name) {
  for (const BasicType& type : kBasicTypes) {
    if (type.name == name) return &type;
  }
  return nullptr;
}

// "float[14] voltage_cell_v" in pieces.
struct Declaration {
  std::string_view type;
  std::string_view name;
  std::size_t count = 1;
};

std::optional<Declaration> ParseDeclaration(std::string_view text) {
  const auto blank = text.find(' ');
  if (blank == text.npos) return std::nullopt;
  Declaration field{text.substr(0, blank), text.substr(blank + 1)};
  if (const auto bracket = field.type.find('['); bracket != field.type.npos) {
    std::size_t count = 0;
    for (const char c : field.type.substr(bracket + 1)) {
      if (c < '0' || c > '9' || count > kMostBytes) break;
      count = 10 * count + static_cast<std::size_t>(c - '0');
    }
    if (count == 0) return std::nullopt;
    field.count = count;
    field.type = field.type.substr(0, bracket);
  }
  return field;
}

// Where a number stands in the data of a message.
struct Place {
  std::size_t offset = 0;
  BasicType type = kBasicTypes[0];
};

// How many cells in series a number says; 0 where it can say none.
int CellsOf(double number) {
  constexpr double kMost = 1000.0;
  return number >= 1.0 && number <= kMost ? static_cast<int>(number) : 0;
}

class UlogReader {
 public:
  explicit UlogReader(std::string_view bytes) : bytes_(bytes) {}

  AutopilotLog Read() {
    MessageWalk(*this, bytes_, log_).From(kHeaderBytes);
    Finish();
    return std::move(log_);
  }

  // The bytes of the message that begins here with its header; 0 where none can.
  [[nodiscard]] std::size_t MessageAt(std::size_t at) const {
    if (at + kMessageHeaderBytes > bytes_.size()) return 0;
    const std::size_t size = NumberAt<std::uint16_t>(bytes_, at);
    const char type = bytes_[at + 2];
    if (size == 0 || kTypes.find(type) == kTypes.npos) return 0;
    if (size > bytes_.size() - at - kMessageHeaderBytes) return 0;
    const std::string_view payload = bytes_.substr(at + kMessageHeaderBytes, size);
    const bool holds = type == 'D'
                           ? size >= 2 && (names_.empty() ||  // ahead of the first subscription
                                           names_.contains(NumberAt<std::uint16_t>(payload, 0)))
                       : type == 'A' ? size > 3
                       : type == 'S' ? payload == kSync
                       : type == 'O' ? size == 2
                       : type == 'L' ? size >= 9
                                     : true;
    return holds ? kMessageHeaderBytes + size : 0;
  }

  // Whether a message may begin here whose end the file no longer holds.
  [[nodiscard]] bool EndsInside(std::size_t at) const {
    if (at + kMessageHeaderBytes > bytes_.size()) return true;
    return kTypes.find(bytes_[at + 2]) != kTypes.npos &&
           NumberAt<std::uint16_t>(bytes_, at) > bytes_.size() - at - kMessageHeaderBytes;
  }

  void Take(std::size_t at, std::size_t size) {
    TakeMessage(bytes_[at + 2],
                bytes_.substr(at + kMessageHeaderBytes, size - kMessageHeaderBytes));
  }

 private:
  void TakeMessage(char type, std::string_view payload) {
    if (type == 'F') {
      const auto colon = payload.find(':');
      if (colon != payload.npos)
        formats_.emplace(payload.substr(0, colon), payload.substr(colon + 1));
    } else if (type == 'I' || type == 'P') {
      TakeValue(type, payload);
    } else if (type == 'A') {
      const auto id = NumberAt<std::uint16_t>(payload, 1);
      const std::string_view name = payload.substr(3);
      names_[id] = name;
      if (name == kTopic) Subscribe(id, static_cast<std::uint8_t>(payload[0]));
    } else if (type == 'D') {
      TakeData(NumberAt<std::uint16_t>(payload, 0), payload.substr(2));
    } else if (type == 'O') {
      ++log_.dropouts;
      log_.dropped_out_s += 1e-3 * NumberAt<std::uint16_t>(payload, 0);
    }
  }

  void TakeValue(char message, std::string_view payload) {
    const std::size_t length = static_cast<std::uint8_t>(payload[0]);
    if (1 + length > payload.size()) return;
    const auto key = ParseDeclaration(payload.substr(1, length));
    const std::string_view value = payload.substr(1 + length);
    if (!key) return;
    if (key->type == "char") {
      if (message == 'I') texts_.emplace(key->name, value);
      return;
    }
    const BasicType* type = FindBasicType(key->type);
    if (type == nullptr || value.size() < type->bytes) return;
    // What was set first counts: later ones were changed in flight.
    (message == 'I' ? information_ : parameters_).emplace(key->name, type->number(value, 0));
  }

  // Bytes of a type with all that it nests; nullopt where it cannot be.
  [[nodiscard]] std::optional<std::size_t> BytesOf(std::string_view type, int depth) const {
    if (const BasicType* basic = FindBasicType(type)) return basic->bytes;
    const auto format = formats_.find(type);
    if (format == formats_.end() || depth == kMostNesting) return std::nullopt;
    std::size_t total = 0;
    for (std::string_view rest = format->second; !rest.empty();) {
      const auto end = std::min(rest.find(';'), rest.size());
      const auto field = ParseDeclaration(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (!field) continue;
      const auto each = BytesOf(field->type, depth + 1);
      if (!each || *each * field->count > kMostBytes) return std::nullopt;
      total += *each * field->count;
      if (total > kMostBytes) return std::nullopt;
    }
    if (total == 0) return std::nullopt;  // else empty formats in one another never end
    return total;
  }

  // The places of the basic fields of a format.
  [[nodiscard]] std::map<std::string_view, Place> PlacesOf(std::string_view name) const {
    std::map<std::string_view, Place> places;
    const auto format = formats_.find(name);
    if (format == formats_.end()) return places;
    std::size_t offset = 0;
    for (std::string_view rest = format->second; !rest.empty();) {
      const auto end = std::min(rest.find(';'), rest.size());
      const auto field = ParseDeclaration(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (!field) continue;
      const auto each = BytesOf(field->type, 0);
      if (!each) break;  // what comes after it cannot be found
      if (const BasicType* type = FindBasicType(field->type); type && field->count > 0)
        places.emplace(field->name, Place{offset, *type});
      offset += *each * field->count;
      if (offset > kMostBytes) break;
    }
    return places;
  }

  struct Battery {
    BatteryTrack track;
    std::optional<Place> time_us, voltage_V, current_A, temperature_degC, cells;
  };

  void Subscribe(std::uint16_t id, int multi_id) {
    if (batteries_.contains(id)) return;  // its rows stay
    if (places_.empty()) places_ = PlacesOf(kTopic);
    const auto place = [&](std::string_view name) -> std::optional<Place> {
      const auto found = places_.find(name);
      if (found == places_.end()) return std::nullopt;
      return found->second;
    };
    Battery battery;
    battery.track.number = multi_id + 1;
    battery.track.message = kTopic;
    battery.time_us = place("timestamp");
    battery.voltage_V = place("voltage_v");
    battery.current_A = place("current_a");
    battery.temperature_degC = place("temperature");
    battery.cells = place("cell_count");
    batteries_.emplace(id, std::move(battery));
  }

  void TakeData(std::uint16_t id, std::string_view data) {
    const auto found = batteries_.find(id);
    if (found == batteries_.end()) return;
    Battery& battery = found->second;
    const auto number = [&](const std::optional<Place>& place) {
      if (!place || place->offset + place->type.bytes > data.size()) return kNaN;
      return place->type.number(data, place->offset);
    };
    const double time_us = number(battery.time_us);
    if (std::isnan(time_us)) return;
    BatteryTrack& track = battery.track;
    const double current_A = number(battery.current_A);
    track.time_s.push_back(1e-6 * time_us);
    track.voltage_V.push_back(number(battery.voltage_V));
    track.current_A.push_back(current_A == -1.0 ? kNaN : current_A);
    track.temperature_degC.push_back(number(battery.temperature_degC));
    if (const int cells = CellsOf(number(battery.cells)); cells > 0) track.cells = cells;
  }

  void Finish() {
    for (auto& [id, battery] : batteries_) {
      BatteryTrack& track = battery.track;
      const auto parameter = [&](std::string_view name) {
        for (const std::string& key :
             {fmt::format("BAT{}_{}", track.number, name), fmt::format("BAT_{}", name)}) {
          const auto found = parameters_.find(key);
          if (found != parameters_.end() && found->second > 0.0) return found->second;
          if (track.number > 1) break;  // BAT_ without a number is the first
        }
        return kNaN;
      };
      if (track.cells == 0) track.cells = CellsOf(parameter("N_CELLS"));
      track.capacity_Ah = 1e-3 * parameter("CAPACITY");  // mAh
      log_.batteries.push_back(std::move(track));
    }
    std::stable_sort(log_.batteries.begin(),
                     log_.batteries.end(),
                     [](const auto& a, const auto& b) { return a.number < b.number; });
    NameVehicle();
  }

  void NameVehicle() {
    const auto text = [&](std::string_view key) -> std::string {
      const auto found = texts_.find(key);
      return found == texts_.end() ? "" : std::string(found->second);
    };
    std::string name = text("sys_name");
    if (const auto release = information_.find("ver_sw_release");
        release != information_.end() && release->second >= 0.0 && release->second < 4294967296.0) {
      const auto number = static_cast<std::uint32_t>(release->second);
      name += fmt::format(" {}.{}.{}", number >> 24, number >> 16 & 0xff, number >> 8 & 0xff);
    }
    if (const std::string hardware = text("ver_hw"); !hardware.empty())
      name += (name.empty() ? "" : " on ") + hardware;
    log_.vehicle = std::move(name);
  }

  std::string_view bytes_;
  AutopilotLog log_;
  std::map<std::string_view, std::string_view> formats_;
  std::map<std::string_view, Place> places_;  // of a battery's numbers, once its format is known
  std::map<std::uint16_t, std::string_view> names_;
  std::map<std::uint16_t, Battery> batteries_;
  std::map<std::string_view, std::string_view> texts_;
  std::map<std::string, double, std::less<>> information_;
  std::map<std::string, double, std::less<>> parameters_;
};

}  // namespace

bool IsULog(std::string_view bytes) { return bytes.starts_with(kMagic); }

AutopilotLog ReadULog(std::string_view bytes) { return UlogReader(bytes).Read(); }

}  // namespace lipoid
