#include "identify/logs/formats/quantity.h"

#include "identify/logs/csv/cells.h"

namespace lipoid {
namespace {

struct UnitRow {
  Quantity quantity;
  Unit unit;
};

constexpr UnitRow Row(Quantity quantity,
                      std::string_view name,
                      double multiply = 1.0,
                      double divide = 1.0) {
  return {quantity, {.name = name, .multiply = multiply, .divide = divide}};
}

constexpr UnitRow Fahrenheit(std::string_view name) {
  return {Quantity::kTemperature,
          {.name = name, .multiply = 5.0, .divide = 9.0, .offset = -160.0 / 9.0}};
}

constexpr auto T = Quantity::kTime;
constexpr auto I = Quantity::kCurrent;
constexpr auto V = Quantity::kVoltage;
constexpr auto C = Quantity::kTemperature;

// All names in lower case; other than ASCII bytes are gone (a degree or micro sign has too many
// spellings).
constexpr UnitRow kUnits[] = {
    Row(T, "s"),
    Row(T, "sec"),
    Row(T, "secs"),
    Row(T, "second"),
    Row(T, "seconds"),
    Row(T, "ms", 1, 1000),
    Row(T, "msec", 1, 1000),
    Row(T, "millisecond", 1, 1000),
    Row(T, "milliseconds", 1, 1000),
    Row(T, "us", 1, 1e6),
    Row(T, "microsecond", 1, 1e6),
    Row(T, "microseconds", 1, 1e6),
    Row(T, "min", 60),
    Row(T, "mins", 60),
    Row(T, "minute", 60),
    Row(T, "minutes", 60),
    Row(T, "h", 3600),
    Row(T, "hr", 3600),
    Row(T, "hrs", 3600),
    Row(T, "hour", 3600),
    Row(T, "hours", 3600),
    Row(T, "sek"),
    Row(T, "sekunde"),
    Row(T, "sekunden"),
    Row(T, "seconde"),
    Row(T, "secondes"),
    Row(T, "segundo"),
    Row(T, "segundos"),
    Row(T, "secondi"),
    Row(T, "minuten", 60),
    Row(T, "minuto", 60),
    Row(T, "minutos", 60),
    Row(T, "minuti", 60),
    Row(T, "std", 3600),
    Row(T, "stunde", 3600),
    Row(T, "stunden", 3600),
    Row(T, "heure", 3600),
    Row(T, "heures", 3600),
    Row(T, "hora", 3600),
    Row(T, "horas", 3600),
    Row(T, "ore", 3600),
    Row(T, "d", 86400),
    Row(T, "day", 86400),
    Row(T, "days", 86400),
    Row(I, "a"),
    Row(I, "amp"),
    Row(I, "amps"),
    Row(I, "ampere"),
    Row(I, "amperes"),
    Row(I, "amperios"),
    Row(I, "amperio"),
    Row(I, "ma", 1, 1000),
    Row(I, "mamps", 1, 1000),
    Row(I, "mamp", 1, 1000),
    Row(I, "milliamp", 1, 1000),
    Row(I, "milliamps", 1, 1000),
    Row(I, "milliampere", 1, 1000),
    Row(I, "milliamperes", 1, 1000),
    Row(I, "ua", 1, 1e6),
    Row(I, "microampere", 1, 1e6),
    Row(I, "microamperes", 1, 1e6),
    Row(V, "v"),
    Row(V, "volt"),
    Row(V, "volts"),
    Row(V, "voltios"),
    Row(V, "voltio"),
    Row(V, "mv", 1, 1000),
    Row(V, "millivolt", 1, 1000),
    Row(V, "millivolts", 1, 1000),
    Row(C, "c"),
    Row(C, "degc"),
    Row(C, "deg_c"),
    Row(C, "deg c"),
    Row(C, "celsius"),
    Row(C, "degree_celsius"),
    Fahrenheit("f"),
    Fahrenheit("degf"),
    Fahrenheit("deg_f"),
    Fahrenheit("deg f"),
    Fahrenheit("fahrenheit"),
    Fahrenheit("degree_fahrenheit"),
    {C, {.name = "k", .offset = -273.15}},
    {C, {.name = "kelvin", .offset = -273.15}},
};

}  // namespace

std::string_view Name(Quantity quantity) {
  constexpr std::array<std::string_view, kQuantityCount> kNames{
      "time", "current", "voltage", "temperature", "step", "cycle", "state"};
  return kNames[static_cast<std::size_t>(quantity)];
}

std::string_view Key(Quantity quantity) {
  constexpr std::array<std::string_view, kQuantityCount> kKeys{
      "time_s", "current_A", "voltage_V", "temperature_degC", "", "", ""};
  return kKeys[static_cast<std::size_t>(quantity)];
}

std::optional<Unit> FindUnit(Quantity quantity, std::string_view name) {
  std::string ascii;
  for (const char c : LowerCase(name)) {
    if (static_cast<unsigned char>(c) < 0x80) ascii += c;
  }
  const std::string_view plain = Trimmed(ascii);  // a blank may stand behind the degree sign
  if (quantity == Quantity::kTime && plain.find("hh:mm:ss") != plain.npos) {
    return Unit{.name = "hh:mm:ss", .is_duration = true};
  }
  for (const UnitRow& row : kUnits) {
    if (row.quantity == quantity && row.unit.name == plain) return row.unit;
  }
  return std::nullopt;
}

std::string_view UsualUnits(Quantity quantity) {
  constexpr std::array<std::string_view, kQuantityCount> kUsual{
      "s, ms, min, h", "A, mA", "V, mV", "degC, degF, K", "", "", ""};
  return kUsual[static_cast<std::size_t>(quantity)];
}

}  // namespace lipoid
