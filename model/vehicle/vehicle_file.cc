#include "model/vehicle/vehicle_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "generated/shipped_vehicles.h"
#include "model/core/counted.h"
#include "model/core/json.h"
#include "model/core/nearest_name.h"
#include "model/core/options.h"
#include "model/core/toml_reader.h"

namespace lipoid {
namespace {

constexpr auto kKeys = std::to_array<std::string_view>({"name",
                                                        "summary",
                                                        "mass_kg",
                                                        "inertia_kg_m2",
                                                        "arm_m",
                                                        "layout",
                                                        "front_right_turns",
                                                        "thrust_coefficient_N_s2",
                                                        "torque_coefficient_N_m_s2",
                                                        "lower_rotor_thrust_ratio",
                                                        "propeller_diameter_m",
                                                        "motor_constant_N_m_per_A",
                                                        "armature_resistance_Ohm",
                                                        "armature_inductance_H",
                                                        "friction_N_m_s",
                                                        "rotor_inertia_kg_m2",
                                                        "nominal_voltage_V",
                                                        "series_cells",
                                                        "pwm_range",
                                                        "esc_resistance_Ohm",
                                                        "esc_switching_time_s",
                                                        "esc_switching_frequency_Hz",
                                                        "esc_rectification",
                                                        "esc_diode_V",
                                                        "avionics_power_W",
                                                        "linear_drag_N_s_per_m",
                                                        "source"});

// A number of the file: where it goes, and what it must be. The ranges hold whatever may ever fly, from insects to
// what carries people, with decades to spare: beyond them arithmetic overflows, or a unit is another.
struct NumberKey {
  std::string_view key;
  double Vehicle::*member;
  double lo;
  double hi;
  std::string_view what;
  std::string_view unit;
  bool required;

  [[nodiscard]] std::string Expected() const {
    return fmt::format("{} from {:g} to {:g} {}", what, lo, hi, unit);
  }
};

constexpr NumberKey kNumbers[] = {
    {"mass_kg", &Vehicle::mass_kg, 1e-5, 1e5, "a mass", "kg", true},
    {"arm_m", &Vehicle::arm_m, 1e-4, 100.0, "a length", "m", true},
    {"thrust_coefficient_N_s2",
     &Vehicle::thrust_coefficient_N_s2,
     1e-13,
     1.0,
     "a thrust per square of rad/s",
     "N s²",
     true},
    {"torque_coefficient_N_m_s2",
     &Vehicle::torque_coefficient_N_m_s2,
     1e-16,
     1.0,
     "a torque per square of rad/s",
     "N m s²",
     true},
    {"motor_constant_N_m_per_A",
     &Vehicle::motor_constant_N_m_per_A,
     1e-6,
     100.0,
     "a motor constant",
     "N m/A",
     true},
    {"armature_resistance_Ohm",
     &Vehicle::armature_resistance_Ohm,
     1e-6,
     1e4,
     "a resistance",
     "Ohm",
     true},
    {"armature_inductance_H",
     &Vehicle::armature_inductance_H,
     0.0,
     1.0,
     "an inductance",
     "H",
     false},
    {"friction_N_m_s", &Vehicle::friction_N_m_s, 0.0, 1.0, "a friction", "N m s", true},
    {"rotor_inertia_kg_m2",
     &Vehicle::rotor_inertia_kg_m2,
     1e-13,
     100.0,
     "a moment of inertia",
     "kg m²",
     true},
    {"nominal_voltage_V", &Vehicle::nominal_voltage_V, 0.1, 1e4, "a voltage", "V", true},
    {"propeller_diameter_m", &Vehicle::propeller_diameter_m, 1e-4, 100.0, "a diameter", "m", false},
    {"avionics_power_W", &Vehicle::avionics_power_W, 0.0, 1e6, "a power", "W", false},
    {"linear_drag_N_s_per_m", &Vehicle::linear_drag_N_s_per_m, 0.0, 1e5, "a drag", "N s/m", false},
};

void ReadInertia(const TomlReader& reader, Vehicle& vehicle) {
  auto& j = vehicle.inertia_kg_m2;
  if (!reader.Numbers(
          "inertia_kg_m2", 1e-13, 1e7, "the moments J_x, J_y, J_z from 1e-13 to 1e+07 kg m²", j)) {
    return;
  }
  constexpr std::string_view kAxes = "xyz";
  constexpr double kRounding = 1e-12;  // a flat body's largest is the sum, in decimals
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = k == 0 ? 1 : 0;
    const std::size_t b = k == 2 ? 1 : 2;
    if (j[k] <= (j[a] + j[b]) * (1.0 + kRounding)) continue;
    reader.Problem(reader.At(reader.Find("inertia_kg_m2")->source()),
                   fmt::format("inertia_kg_m2: expected moments of a body that can be, each at "
                               "most the sum of the other two, found J_{} = {} above J_{} + J_{} "
                               "= {:.6g}",
                               kAxes[k],
                               j[k],
                               kAxes[a],
                               kAxes[b],
                               j[a] + j[b]));
  }
}

// Integers, because the hardware takes one between them, (6.1).
void ReadPwmRange(const TomlReader& reader, Vehicle& vehicle) {
  constexpr std::string_view kExpected = "the integers of D = 0 and D = 1, [10, 500]";
  auto range = vehicle.pwm_range;
  if (!reader.Numbers("pwm_range", 0.0, 1e9, kExpected, range)) return;
  if (range[0] != std::floor(range[0]) || range[1] != std::floor(range[1]) ||
      !(range[0] < range[1])) {
    reader.Problem(reader.At(reader.Find("pwm_range")->source()),
                   fmt::format("pwm_range: expected {}, the first below the second, found [{}, {}]",
                               kExpected,
                               range[0],
                               range[1]));
    return;
  }
  vehicle.pwm_range = range;
}

enum class Rectification { kSynchronous, kDiode };

constexpr std::array<std::pair<Rectification, std::string_view>, 2> OptionNames(Rectification) {
  return {{{Rectification::kSynchronous, "synchronous"}, {Rectification::kDiode, "diode"}}};
}

void ReadSpeedController(const TomlReader& reader, SpeedController& esc) {
  reader.Number(
      "esc_resistance_Ohm", 0.0, 1e4, "a resistance from 0 to 10000 Ohm", esc.resistance_Ohm);
  reader.Number(
      "esc_switching_time_s", 0.0, 1e-3, "a time from 0 to 0.001 s", esc.switching_time_s);
  reader.Number("esc_switching_frequency_Hz",
                0.0,
                1e6,
                "a frequency from 0 to 1000000 Hz",
                esc.switching_frequency_Hz);
  // A transistor that still switches when it has to switch back never conducts.
  if (const double share = esc.switching_time_s * esc.switching_frequency_Hz; share > 0.5) {
    reader.Problem(reader.At(reader.Find("esc_switching_time_s")->source()),
                   fmt::format("esc_switching_time_s: expected at most half a period of "
                               "esc_switching_frequency_Hz, found {:.3g} of one",
                               share));
  }
  Rectification rectification = Rectification::kSynchronous;
  reader.Choice("esc_rectification", rectification);
  esc.synchronous = rectification == Rectification::kSynchronous;
  if (!reader.Number("esc_diode_V", 0.0, 5.0, "a voltage from 0 to 5 V", esc.diode_V)) return;
  if (esc.synchronous && esc.diode_V > 0.0) {
    reader.Problem(reader.At(reader.Find("esc_diode_V")->source()),
                   fmt::format("esc_diode_V: expected 0 V where esc_rectification is synchronous, "
                               "because the current then flows through transistors, found {}",
                               esc.diode_V));
  }
}

// The second of a pair may lose thrust to the first; alone no rotor does.
void ReadRotors(const TomlReader& reader, Vehicle& vehicle) {
  reader.Choice("layout", vehicle.layout);
  reader.Choice("front_right_turns", vehicle.front_right_turns);
  if (!reader.Number("lower_rotor_thrust_ratio",
                     0.01,
                     1.0,
                     "a ratio from 0.01 to 1",
                     vehicle.lower_rotor_thrust_ratio)) {
    return;
  }
  for (const Rotor& rotor : RotorsOf(vehicle.layout)) {
    if (rotor.lower) return;
  }
  reader.Problem(reader.At(reader.Find("lower_rotor_thrust_ratio")->source()),
                 "lower_rotor_thrust_ratio: expected a layout of coaxial pairs, y6 or x8; this "
                 "layout has no lower rotors");
}

// The origins of the numbers are for people: only their keys are checked.
void ReadSource(const TomlReader& reader,
                const std::string& file,
                std::vector<Diagnostic>& problems) {
  const toml::node* node = reader.Find("source");
  if (node == nullptr) return;
  const auto* table = node->as_table();
  if (table == nullptr) return reader.Expected(*node, "source", "a table [source]");
  const TomlReader source(*table, file, problems);
  source.OnlyKeys(std::span(kKeys).subspan(2, kKeys.size() - 3));  // the numbers
  std::string ignored;
  for (const auto& [key, value] : *table) source.Text(key.str(), ignored);
}

}  // namespace

Vehicle ParseVehicle(const std::string& text, const std::string& file) {
  const toml::table document = ParseToml(text, file, "a vehicle");
  std::vector<Diagnostic> problems;
  const TomlReader reader(document, file, problems);
  reader.OnlyKeys(kKeys);
  Vehicle vehicle;
  reader.Text("name", vehicle.name);
  reader.Text("summary", vehicle.summary);
  ReadInertia(reader, vehicle);
  std::vector<std::string_view> missing;
  const auto require = [&](std::string_view key) {
    if (reader.Find(key) == nullptr) missing.push_back(key);
  };
  require("name");
  require("inertia_kg_m2");
  for (const NumberKey& number : kNumbers) {
    if (number.required) require(number.key);
    reader.Number(number.key, number.lo, number.hi, number.Expected(), vehicle.*number.member);
  }
  if (!missing.empty()) {
    reader.Problem({file},
                   fmt::format("expected the {} {}, found none",
                               missing.size() == 1 ? "key" : "keys",
                               fmt::join(missing, ", ")));
  }
  ReadPwmRange(reader, vehicle);
  ReadRotors(reader, vehicle);
  reader.Integer("series_cells", 1, 1000, vehicle.series_cells);
  ReadSpeedController(reader, vehicle.esc);
  ReadSource(reader, file, problems);
  ThrowProblems(std::move(problems));
  return vehicle;
}

std::string VehicleToToml(const Vehicle& v, const VehicleSources& sources) {
  const Vehicle defaults;
  std::string text = fmt::format("name = {}\n", TomlText(v.name));
  const auto line = [&](std::string_view key, const std::string& value) {
    text += fmt::format("{} = {}\n", key, value);
  };
  if (!v.summary.empty()) line("summary", TomlText(v.summary));
  text += '\n';
  if (v.layout != defaults.layout) {
    line("layout", fmt::format("\"{}\"", options_internal::ToText(v.layout)));
  }
  if (v.front_right_turns != defaults.front_right_turns) {
    line("front_right_turns", fmt::format("\"{}\"", options_internal::ToText(v.front_right_turns)));
  }
  if (v.lower_rotor_thrust_ratio != 1.0) {
    line("lower_rotor_thrust_ratio", TomlFloat(v.lower_rotor_thrust_ratio));
  }
  line("inertia_kg_m2",
       fmt::format("[{}, {}, {}]",
                   TomlFloat(v.inertia_kg_m2[0]),
                   TomlFloat(v.inertia_kg_m2[1]),
                   TomlFloat(v.inertia_kg_m2[2])));
  for (const NumberKey& number : kNumbers) {
    const double value = v.*number.member;
    if (number.required || value != defaults.*number.member) line(number.key, TomlFloat(value));
  }
  if (v.series_cells > 0) line("series_cells", fmt::format("{}", v.series_cells));
  if (v.pwm_range != defaults.pwm_range) {
    line("pwm_range", fmt::format("[{:.0f}, {:.0f}]", v.pwm_range[0], v.pwm_range[1]));
  }
  const SpeedController& esc = v.esc;
  if (esc.resistance_Ohm > 0.0) line("esc_resistance_Ohm", TomlFloat(esc.resistance_Ohm));
  if (esc.switching_time_s > 0.0) line("esc_switching_time_s", TomlFloat(esc.switching_time_s));
  if (esc.switching_frequency_Hz > 0.0) {
    line("esc_switching_frequency_Hz", TomlFloat(esc.switching_frequency_Hz));
  }
  if (!esc.synchronous) line("esc_rectification", "\"diode\"");
  if (esc.diode_V > 0.0) line("esc_diode_V", TomlFloat(esc.diode_V));
  if (!sources.empty()) text += "\n[source]\n";
  for (const auto& [key, from] : sources) line(key, TomlText(from));
  return text;
}

std::vector<std::string> ShippedVehicleNames() { return NamesOf(kShippedVehicles); }

Vehicle LoadVehicle(const std::string& name_or_file) {
  for (const auto& shipped : kShippedVehicles) {
    if (shipped.name == name_or_file) return ParseVehicle(std::string(shipped.text), name_or_file);
  }
  return ParseVehicle(
      ReadTextFileOr(
          name_or_file, "a vehicle file or one of the shipped vehicles", ShippedVehicleNames()),
      name_or_file);
}

std::string DoubtAboutPack(const Vehicle& vehicle, int series) {
  if (vehicle.series_cells == 0 || vehicle.series_cells == series) return "";
  return fmt::format(
      "{} is made for {} in series, and this pack has {}: {}",
      vehicle.name,
      Counted(vehicle.series_cells, "cell"),
      series,
      series < vehicle.series_cells
          ? fmt::format("it has less thrust; give --series {}", vehicle.series_cells)
          : "motors and speed controllers see more voltage than they are made for, and "
            "the mass is that with the vehicle's own battery");
}

std::string DoubtAboutEnergy(const Vehicle& vehicle, const Cell& cell) {
  constexpr double kMost_Wh_per_kg =
      300.0;  // of the lightest lithium cells; packs that fly have half
  const double energy_Wh =
      cell.series * cell.parallel * cell.alpha_C() / 3600.0 * cell.open_circuit_voltage(0.5);
  if (energy_Wh <= kMost_Wh_per_kg * vehicle.mass_kg) return "";
  return fmt::format(
      "a pack of {:.4g} Wh has at least {:.3g} kg, more than the {:.3g} kg of {} with its pack: is the capacity in "
      "mAh, where Ah are expected? Else give the number of cells, or the vehicle, that fit it; "
      "--capacity-Ah takes another size of such a cell",
      energy_Wh,
      energy_Wh / kMost_Wh_per_kg,
      vehicle.mass_kg,
      vehicle.name);
}

}  // namespace lipoid
