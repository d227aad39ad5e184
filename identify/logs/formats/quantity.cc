#include "identify/logs/formats/quantity.h"

#include "identify/logs/formats/header.h"
#include "model/core/text_cells.h"

namespace lipoid {
namespace {

struct UnitRow {
  Quantity quantity;
  std::string_view names;  // as RankIn() takes them
  Unit unit = {};
};

// All names in lower case; a micro sign is a u, and other bytes than ASCII are gone (a degree sign has too
// many spellings).
constexpr UnitRow kUnitRows[] = {
    {Quantity::kTime,
     "s|sec|secs|second|seconds|sek|sekunde|sekunden|seconde|secondes|segundo|segundos|secondi"},
    {Quantity::kTime, "ms|msec|millisecond|milliseconds", {.divide = 1000}},
    {Quantity::kTime, "us|microsecond|microseconds", {.divide = 1e6}},
    {Quantity::kTime, "min|mins|minute|minutes|minuten|minuto|minutos|minuti", {.multiply = 60}},
    {Quantity::kTime,
     "h|hr|hrs|hour|hours|std|stunde|stunden|heure|heures|hora|horas|ore",
     {.multiply = 3600}},
    {Quantity::kTime, "d|day|days", {.multiply = 86400}},
    {Quantity::kCurrent, "a|amp|amps|ampere|amperes|amperios|amperio"},
    {Quantity::kCurrent,
     "ma|mamps|mamp|milliamp|milliamps|milliampere|milliamperes",
     {.divide = 1000}},
    {Quantity::kCurrent, "ua|microampere|microamperes", {.divide = 1e6}},
    {Quantity::kVoltage, "v|volt|volts|voltios|voltio"},
    {Quantity::kVoltage, "mv|millivolt|millivolts", {.divide = 1000}},
    {Quantity::kVoltage, "uv|microvolt|microvolts", {.divide = 1e6}},
    {Quantity::kTemperature, "c|degc|deg_c|deg c|celsius|degree_celsius"},
    {Quantity::kTemperature,
     "f|degf|deg_f|deg f|fahrenheit|degree_fahrenheit",
     {.multiply = 5.0, .divide = 9.0, .offset = -160.0 / 9.0}},
    {Quantity::kTemperature, "k|kelvin", {.offset = -273.15}},
};

struct Words {
  std::string_view name, key, units;
};

const Words& WordsOf(Quantity quantity) {
  static constexpr std::array<Words, kQuantityCount> kWords{
      {{"time", "time_s", "s, ms, min, h"},
       {"current", "current_A", "A, mA"},
       {"voltage", "voltage_V", "V, mV"},
       {"temperature", "temperature_degC", "degC, degF, K"},
       {"step", "", ""},
       {"cycle", "", ""},
       {"state", "", ""}}};
  return kWords[static_cast<std::size_t>(quantity)];
}

}  // namespace

std::string_view Name(Quantity quantity) { return WordsOf(quantity).name; }
std::string_view Key(Quantity quantity) { return WordsOf(quantity).key; }
std::string_view UsualUnits(Quantity quantity) { return WordsOf(quantity).units; }

std::optional<Unit> FindUnit(Quantity quantity, std::string_view name) {
  std::string ascii;
  for (const char c : LowerCase(Narrow(name))) {
    if (static_cast<unsigned char>(c) < 0x80) ascii += c;
  }
  const std::string_view plain = Trimmed(ascii);  // a blank may stand behind the degree sign
  if (quantity == Quantity::kTime && plain.find("hh:mm:ss") != plain.npos) {
    return Unit{.is_duration = true};
  }
  for (const UnitRow& row : kUnitRows) {
    if (row.quantity == quantity && RankIn(row.names, plain) != plain.npos) return row.unit;
  }
  return std::nullopt;
}

}  // namespace lipoid
