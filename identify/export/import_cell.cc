#include "identify/export/import_cell.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "identify/export/frame_json.h"
#include "identify/logs/plausibility.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/ranges.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/json.h"
#include "model/core/nearest_name.h"
#include "model/core/special_values.h"
#include "model/core/structured_text.h"
#include "model/core/text_cells.h"
#include "model/export/ardupilot_law.h"
#include "model/export/cell_tables.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

// Of lithium-polymer cells: from a full one of iron phosphate to beyond those of high voltage.
constexpr double kUsualFull_V = 4.2;
constexpr double kLeastFull_V = 3.4;
constexpr double kMostFull_V = 4.6;

constexpr double kLeast = std::numeric_limits<double>::min();

// A cell without diffusion whose whole drop is filtered by one time constant.
Cell FilteredCell(double capacity_Ah, double resistance_Ohm, double time_constant_s) {
  Cell cell;
  cell.capacity_Ah = capacity_Ah;
  cell.branches = {{resistance_Ohm, time_constant_s, std::nullopt}};
  return cell;
}

int LikelySeries(double pack_V) {
  return std::max(1, static_cast<int>(std::lround(pack_V / kUsualFull_V)));
}

void NoteUnused(const std::vector<std::string>& names, ImportedCell& imported) {
  if (names.empty()) return;
  imported.notes.push_back(
      fmt::format("Not used, since a cell file has no place for it: {}.", fmt::join(names, ", ")));
}

// ---- ArduPilot ----

ImportedCell FromFrame(const JsonReader& frame, const ImportOptions& options) {
  ImportedCell imported;
  imported.format = "ardupilot";
  const double full_V = frame.At("maxVoltage").Number(kLeast, kInfinity);
  const JsonReader capacity = frame.At("battCapacityAh");
  const double capacity_Ah = capacity.Number(-kInfinity, kInfinity);
  if (!(capacity_Ah > 0.0))
    capacity.Fail("a capacity above 0 (ArduPilot takes others as a battery without an end)");
  const double resistance_Ohm = frame.At("refBatRes").Number(0.0, kInfinity);
  const int series = options.series.value_or(LikelySeries(full_V));
  if (!options.series) {
    imported.notes.push_back(fmt::format(
        "The pack is taken as {} in series, from maxVoltage {:g} V; --series says another "
        "number.",
        series,
        full_V));
  }
  const int parallel = options.parallel.value_or(1);
  // The drop is behind a low-pass of 10 Hz; that of the resting voltage, which moves far more
  // slowly, is left out.
  Cell& cell = imported.cell;
  cell = FilteredCell(capacity_Ah / parallel,
                      resistance_Ohm * parallel / series,
                      1.0 / (2.0 * std::numbers::pi * 10.0));
  cell.series = series;
  cell.parallel = parallel;
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (const double percent : ArduPilotTablePercents()) {
    soc.push_back(0.01 * percent);
    voltage_V.push_back(ArduPilotRestingVoltage(percent) / kArduPilotFull_V * full_V / series);
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
  // The table falls off a cliff below 2 %.
  constexpr double kCliff = 0.02;
  cell.cutoff_V = options.cutoff_V.value_or(cell.open_circuit_voltage(kCliff));
  if (!options.cutoff_V) {
    imported.notes.push_back(
        fmt::format("A cut-off of {:.4g} V is assumed, where ArduPilot's table begins to fall "
                    "steeply; --cutoff-V says another one.",
                    cell.cutoff_V));
  }
  imported.notes.emplace_back(
      "ArduPilot's low-pass of 10 Hz is a branch in place of the series resistance.");
  return imported;
}

// ---- equivalent circuits ----

// { "soc": [...], "value": [...] }; the second key may have a unit.
std::pair<std::vector<double>, std::vector<double>> ReadTable(const JsonReader& json,
                                                              std::string_view values,
                                                              double least) {
  if (!json.IsObject()) json.Fail(fmt::format("a table of soc and {}", values));
  json.OnlyKeys({"soc", values});
  auto soc = json.At("soc").Increasing(-kInfinity, kInfinity);
  auto numbers = json.At(values).Numbers(least, kInfinity);
  if (soc.size() < 2) json.At("soc").Fail("at least two states of charge");
  if (numbers.size() != soc.size())
    json.At(values).Fail(fmt::format("{} numbers, one for each soc", soc.size()));
  return {std::move(soc), std::move(numbers)};
}

Resistance<double> ReadResistance(const JsonReader& json) {
  if (json.IsNumber()) return {json.Number(0.0, kInfinity)};
  auto [soc, values] = ReadTable(json, "resistance_Ohm", 0.0);
  return {std::move(soc), std::move(values)};
}

// What the two dialects call the same things.
struct Dialect {
  const char* capacity;
  const char* curve;
  const char* resistance;     // with the branch's number
  const char* capacitance;    // likewise
  const char* time_constant;  // likewise, lipoid's own addition
};
constexpr Dialect kThevenin{"capacity", "ocv", "R{}", "C{}", "tau{}"};
constexpr Dialect kPybamm{
    "Cell capacity [A.h]", "Open-circuit voltage [V]", "R{} [Ohm]", "C{} [F]", "tau{} [s]"};

// Keys that a circuit may have and that play no part in a cell at rest and at one temperature.
const std::vector<std::string>& Ignored() {
  static const std::vector<std::string> keys = {"soc0",
                                                "ce",
                                                "mass",
                                                "isothermal",
                                                "Cp",
                                                "T_inf",
                                                "h_therm",
                                                "A_therm",
                                                "Nominal cell capacity [A.h]",
                                                "Initial SoC",
                                                "Current function [A]",
                                                "Upper voltage cut-off [V]",
                                                "Initial temperature [K]",
                                                "Ambient temperature [K]",
                                                "Cell thermal mass [J/K]",
                                                "Cell-jig heat transfer coefficient [W/K]",
                                                "Jig thermal mass [J/K]",
                                                "Jig-air heat transfer coefficient [W/K]",
                                                "Entropic change [V/K]"};
  return keys;
}

ImportedCell FromCircuit(const Json& document,
                         const JsonReader& json,
                         const ImportOptions& options) {
  ImportedCell imported;
  imported.format = "circuit";
  const bool pybamm = document.contains(kPybamm.capacity) || document.contains(kPybamm.curve);
  const Dialect& names = pybamm ? kPybamm : kThevenin;
  constexpr int kMostBranches = 20;
  std::vector<std::string> known = {names.capacity,
                                    names.curve,
                                    "name",
                                    "cutoff_V",
                                    "num_RC_pairs",
                                    "M_hyst",
                                    "gamma",
                                    "Diffusion time constant [s]",
                                    "Lower voltage cut-off [V]"};
  known.insert(known.end(), Ignored().begin(), Ignored().end());
  for (int j = 0; j <= kMostBranches; ++j) {
    known.push_back(fmt::format(fmt::runtime(names.resistance), j));
    if (j == 0) continue;
    known.push_back(fmt::format(fmt::runtime(names.capacitance), j));
    known.push_back(fmt::format(fmt::runtime(names.time_constant), j));
    known.push_back(fmt::format("Element-{} initial overpotential [V]", j));
  }
  std::vector<std::string> ignored;
  for (const auto& [key, value] : document.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      json.At(key).FailWith(UnknownName("key", key, {known.begin(), known.begin() + 9}));
    if (std::find(Ignored().begin(), Ignored().end(), key) != Ignored().end() ||
        key.starts_with("Element-"))
      ignored.push_back(key);
  }
  Cell& cell = imported.cell;
  if (const auto name = json.Find("name")) cell.name = name->Text();
  if (const auto capacity = json.Find(names.capacity)) {
    cell.capacity_Ah = capacity->Number(kLeast, kInfinity);
  } else if (options.capacity_Ah) {
    cell.capacity_Ah = *options.capacity_Ah;
  } else {
    (void)json.At(names.capacity);  // says that it is missing
  }
  auto [soc, voltage_V] = ReadTable(json.At(names.curve), "voltage_V", -kInfinity);
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
  cell.series_resistance_Ohm =
      ReadResistance(json.At(fmt::format(fmt::runtime(names.resistance), 0)));
  for (const auto* const hysteresis : {"M_hyst", "gamma"}) {
    if (const auto found = json.Find(hysteresis);
        found && found->Number(-kInfinity, kInfinity) != 0.0)
      found->Fail("0, since this law of hysteresis is another than a cell file's");
  }
  for (int j = 1; j <= kMostBranches; ++j) {
    const auto resistance = json.Find(fmt::format(fmt::runtime(names.resistance), j));
    const auto capacitance = json.Find(fmt::format(fmt::runtime(names.capacitance), j));
    const auto time_constant = json.Find(fmt::format(fmt::runtime(names.time_constant), j));
    if (!resistance && !capacitance && !time_constant) continue;
    if (static_cast<int>(cell.branches.size()) != j - 1 || !resistance) {
      (capacitance     ? *capacitance
       : time_constant ? *time_constant
                       : *resistance)
          .FailWith(fmt::format(
              "expected branches that are numbered on from 1, each with a resistance, found {}",
              j));
    }
    if (capacitance.has_value() == time_constant.has_value()) {
      resistance->FailWith(fmt::format("expected either {} or {} beside it, found {}",
                                       fmt::format(fmt::runtime(names.capacitance), j),
                                       fmt::format(fmt::runtime(names.time_constant), j),
                                       capacitance ? "both" : "neither"));
    }
    Cell::Branch branch;
    branch.resistance_Ohm = ReadResistance(*resistance);
    if (time_constant) {
      branch.time_constant_s = time_constant->Number(kLeast, kInfinity);
    } else {
      if (!branch.resistance_Ohm.constant()) {
        capacitance->FailWith(
            fmt::format("expected {} beside a table of resistances, found a capacitance",
                        fmt::format(fmt::runtime(names.time_constant), j)));
      }
      branch.capacitance_F = capacitance->Number(kLeast, kInfinity);
      branch.time_constant_s = branch.resistance_Ohm.resistance_Ohm[0] * *branch.capacitance_F;
    }
    cell.branches.push_back(std::move(branch));
  }
  if (const auto pairs = json.Find("num_RC_pairs")) {
    const int said = pairs->Integer(0, kMostBranches);
    const auto there = static_cast<int>(cell.branches.size());
    if (said != there)
      pairs->FailWith(fmt::format(
          "expected the number of the branches that stand here, {}, found {}", there, said));
  }
  if (const auto diffusion = json.Find("Diffusion time constant [s]")) {
    // z_t = z_xx/tau_D over 0 .. 1 is the diffusion of the cell with tau_D = pi²/beta².
    const double beta = std::numbers::pi / std::sqrt(diffusion->Number(kLeast, kInfinity));
    if (beta > 1.0)
      diffusion->Fail("a time constant of at least 9.87 s, where beta is 1 per sqrt s");
    if (beta < kLeastBeta_per_sqrt_s)
      diffusion->Fail("a time constant of at most 9.8e8 s, where beta is 0.0001 per sqrt s");
    cell.diffusion = Cell::Diffusion{.alpha_C = 3600.0 * cell.capacity_Ah, .beta_per_sqrt_s = beta};
  }
  const auto cutoff = json.Find(pybamm ? "Lower voltage cut-off [V]" : "cutoff_V");
  if (cutoff) {
    cell.cutoff_V = cutoff->Number(0.0, kInfinity);
  } else {
    cell.cutoff_V = options.cutoff_V.value_or(std::max(0.0, cell.open_circuit_voltage(0.0)));
    if (!options.cutoff_V) {
      imported.notes.push_back(
          fmt::format("A cut-off of {:.4g} V is assumed, v_oc(0); --cutoff-V says another one.",
                      cell.cutoff_V));
    }
  }
  NoteUnused(ignored, imported);
  return imported;
}

// ---- Gazebo ----

using boost::property_tree::ptree;

// Deep trees would overflow the stack of the parser.
void CheckDepth(const std::string& text, const std::string& file) {
  structured_text::CheckText(text, file);
  std::size_t depth = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::string_view rest = std::string_view(text).substr(at);
    if (rest.starts_with("<!--")) {
      at = std::min(text.find("-->", at), text.size() - 1);
    } else if (rest.starts_with("<![CDATA[")) {
      at = std::min(text.find("]]>", at), text.size() - 1);
    } else if (rest.starts_with("</")) {
      if (depth > 0) --depth;
    } else if (!rest.starts_with("<!") && !rest.starts_with("<?")) {
      const std::size_t end = text.find('>', at);
      if (end != std::string::npos && text[end - 1] != '/') ++depth;
      if (depth > structured_text::kMostDepth) {
        throw LoadError(structured_text::PositionOfByte(file, text, at),
                        fmt::format("expected at most {} elements in one another, found more",
                                    structured_text::kMostDepth));
      }
    }
  }
}

bool IsBattery(const ptree& plugin) {
  const auto has = [&](const char* attribute) {
    const std::string value = LowerCase(plugin.get<std::string>(attribute, ""));
    return value.find("linearbattery") != std::string::npos;
  };
  return has("<xmlattr>.filename") || has("<xmlattr>.name");
}

void FindBatteries(const ptree& tree, std::vector<const ptree*>& found) {
  for (const auto& [name, child] : tree) {
    if (name == "plugin" && IsBattery(child)) {
      found.push_back(&child);
    } else {
      FindBatteries(child, found);
    }
  }
}

// Those that make the law, and those that play no part in it.
constexpr const char* kElements[] = {"battery_name",
                                     "open_circuit_voltage_constant_coef",
                                     "open_circuit_voltage_linear_coef",
                                     "capacity",
                                     "resistance",
                                     "smooth_current_tau"};
constexpr const char* kUnusedElements[] = {"voltage",
                                           "initial_charge",
                                           "power_load",
                                           "start_draining",
                                           "power_draining_topic",
                                           "stop_power_draining_topic",
                                           "enable_recharge",
                                           "charging_time",
                                           "recharge_by_topic",
                                           "fix_issue_225",
                                           "invert_current_sign"};

ImportedCell FromSdf(const std::string& text,
                     const std::string& file,
                     const ImportOptions& options) {
  CheckDepth(text, file);
  ptree tree;
  try {
    std::istringstream stream(text);
    read_xml(stream, tree, boost::property_tree::xml_parser::no_comments);
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw LoadError({file, std::max<std::size_t>(1, error.line()), 1},
                    fmt::format("expected XML, found none: {}", error.message()));
  }
  std::vector<const ptree*> batteries;
  FindBatteries(tree, batteries);
  if (batteries.size() != 1) {
    throw LoadError(
        {file},
        fmt::format("expected one plugin with LinearBatteryPlugin, found {}", batteries.size()));
  }
  const ptree& plugin = *batteries.front();
  // The tree knows no places: that of an element is where its tag stands in the text.
  const std::size_t begin = text.find("<plugin");
  const auto place = [&](const std::string& element) {
    std::size_t at = text.find("<" + element, begin);
    if (at == std::string::npos) at = begin;
    return structured_text::PositionOfByte(file, text, at);
  };
  std::vector<std::string> known(std::begin(kElements), std::end(kElements));
  known.insert(known.end(), std::begin(kUnusedElements), std::end(kUnusedElements));
  std::vector<std::string> unused;
  for (const auto& [name, child] : plugin) {
    if (name == "<xmlattr>" || name == "<xmltext>") continue;
    const auto found = std::find(known.begin(), known.end(), name);
    if (found - known.begin() >= std::ssize(kElements)) unused.push_back(name);
    if (found == known.end())
      throw LoadError(place(name), UnknownName("element of a LinearBatteryPlugin", name, known));
  }
  const auto number =
      [&](const std::string& name, std::optional<double> otherwise, double least, double most) {
        const auto found = plugin.get_optional<std::string>(name);
        if (!found) {
          if (otherwise) return *otherwise;
          throw LoadError(place("plugin"), fmt::format("expected an element {}, found none", name));
        }
        double value = 0.0;
        if (!ParseNumber(Trimmed(*found), '.', value) || !std::isfinite(value) || value < least ||
            value > most) {
          throw LoadError(place(name),
                          fmt::format("expected a number {} for {}, found '{}'",
                                      least == kLeast ? "above 0"
                                      : least == 0.0  ? "of at least 0"
                                      : most == 0.0   ? "of at most 0"
                                                      : "that is finite",
                                      name,
                                      ForeignText(*found)));
        }
        return value;
      };
  const double capacity_Ah = number("capacity", std::nullopt, kLeast, kInfinity);
  const double full_V =
      number("open_circuit_voltage_constant_coef", std::nullopt, kLeast, kInfinity);
  const double fall_V = number("open_circuit_voltage_linear_coef", 0.0, -kInfinity, 0.0);
  const double resistance_Ohm = number("resistance", 0.0, 0.0, kInfinity);
  const double smoothing_s = number("smooth_current_tau", 1.0, kLeast, kInfinity);
  const int series = options.series.value_or(1);
  const int parallel = options.parallel.value_or(1);
  // The smoothed current counts the charge too, which is as if the resistance were smaller.
  const double less_Ohm = -fall_V * smoothing_s / (3600.0 * capacity_Ah);
  if (less_Ohm > resistance_Ohm) {
    throw LoadError(
        place("smooth_current_tau"),
        fmt::format("expected a smoothing whose lag of the charge ({:.3g} Ohm) is below "
                    "the resistance ({:.3g} Ohm), found more: no cell has this law",
                    less_Ohm,
                    resistance_Ohm));
  }
  ImportedCell imported;
  imported.format = "gazebo";
  Cell& cell = imported.cell;
  cell = FilteredCell(
      capacity_Ah / parallel, (resistance_Ohm - less_Ohm) * parallel / series, smoothing_s);
  cell.series = series;
  cell.parallel = parallel;
  cell.name = plugin.get<std::string>("battery_name", "");
  cell.open_circuit_voltage =
      OpenCircuitVoltage::Linear({0.0, 1.0}, {(full_V + fall_V) / series, full_V / series});
  cell.cutoff_V = options.cutoff_V.value_or(std::max(0.0, (full_V + fall_V) / series));
  if (!options.cutoff_V) {
    imported.notes.push_back(fmt::format(
        "A cut-off of {:.4g} V is assumed, that of the empty battery; --cutoff-V says another one.",
        cell.cutoff_V));
  }
  if (!options.series)
    imported.notes.emplace_back("One cell in series is assumed; --series says another number.");
  imported.notes.emplace_back(
      "The plugin smooths the drop and the count of the charge: both are a branch in place of the "
      "series resistance.");
  NoteUnused(unused, imported);
  return imported;
}

// ---- which one ----

// A sentence on a cell whose full voltage is that of another number of cells; "" where it is one's.
std::string DoubtAboutSeries(const ImportedCell& imported) {
  const Cell& cell = imported.cell;
  const double full_V = cell.open_circuit_voltage(1.0);
  if (kLeastFull_V <= full_V && full_V <= kMostFull_V) return "";
  // The numbers of an equivalent circuit and of a table are those of one cell, whatever the pack.
  const bool of_pack = imported.format == "ardupilot" || imported.format == "gazebo";
  const int counted = of_pack ? cell.series : 1;
  const int likely = LikelySeries(full_V * counted);
  return fmt::format("warning: {:.4g} V when full is {} for a lithium-polymer cell{}.",
                     full_V,
                     full_V < kLeastFull_V ? "low" : "high",
                     likely == counted ? ""
                     : of_pack
                         ? fmt::format(": {:.4g} V looks like {} in series (--series {})",
                                       full_V * counted,
                                       likely,
                                       likely)
                         : fmt::format(": the file looks like one of {} in series; give voltages "
                                       "and resistances of one cell",
                                       likely));
}

// OptionError for a number that the file has itself.
void RefuseSecond(const char* option,
                  std::optional<double> given,
                  double own,
                  const std::string& file) {
  if (!given || *given == own) return;
  throw OptionError(fmt::format(
      "option {}: it is for a file without such a number, and {} has {:.6g}; leave the option out",
      option,
      file,
      own));
}

void CheckBattery(const Cell& cell, const std::string& file) {
  constexpr double kMost_soc = 2.0;
  if (cell.open_circuit_voltage.soc_hi() > kMost_soc) {
    throw LoadError(
        {file},
        fmt::format(
            "expected states of charge from 0 to 1, found {:.4g}, which looks like per cent",
            cell.open_circuit_voltage.soc_hi()));
  }
  const double full_V = cell.open_circuit_voltage(1.0);
  if (full_V > kMostPack_V) {
    throw LoadError(
        {file},
        fmt::format("expected voltages in V, found a v_oc(1) of {:.4g}, which looks like mV",
                    full_V));
  }
  constexpr double kLeastCell_V = 1.0;  // NiMH has 1.3 V
  constexpr double kMostCell_V = 5.0;
  if (full_V < kLeastCell_V || (cell.series > 1 && full_V > kMostCell_V)) {
    throw LoadError(
        {file},
        fmt::format(
            "expected {} in series that have 1 to 5 V each when full, found {:.4g} V; is --series right?",
            Counted(static_cast<std::size_t>(cell.series), "cell"),
            full_V));
  }
  if (!(std::isfinite(full_V) && full_V > cell.cutoff_V)) {
    throw LoadError({file},
                    fmt::format("expected a battery, found one whose v_oc(1) of {:.4g} V is not "
                                "above its cut-off of {:.4g} V (--cutoff-V)",
                                full_V,
                                cell.cutoff_V));
  }
  const double resistance_Ohm = SeriesAndBranches(cell, 0.5);
  const double rate_A = cell.alpha_C() / 3600.0;  // 1C
  if (!(rate_A * resistance_Ohm < full_V)) {
    throw LoadError(
        {file},
        fmt::format(
            "expected a capacity in Ah and resistances in Ohm, found {:.4g} Ah and {:.4g} Ohm: at 1C "
            "they would take {:.4g} V of {:.4g} V; is the capacity in mAh, or a resistance in mOhm?",
            rate_A * cell.parallel,
            resistance_Ohm * cell.series / cell.parallel,
            rate_A * resistance_Ohm * cell.series,
            full_V * cell.series));
  }
}

}  // namespace

ImportedCell ImportCell(const std::string& text,
                        const std::string& file,
                        const ImportOptions& options) {
  structured_text::CheckText(text, file);
  std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos &&
      std::string_view(text).substr(first).starts_with("\xEF\xBB\xBF"))
    first = text.find_first_not_of(" \t\r\n", first + 3);
  if (first == std::string::npos)
    throw LoadError({file}, "expected a battery of another program, found nothing");
  ImportedCell imported;
  // A frame model may have any text before its brace; a table has none.
  const bool has_table_header = text.find("open_circuit_voltage_V") != std::string::npos;
  if (text[first] != '<' && !has_table_header && text.find("maxVoltage") == std::string::npos &&
      HasProvenance(text)) {
    throw LoadError(
        {file},
        "this is a cell that lipoid exported to a program whose files it does not read; use the "
        "cell file that its first lines name, which holds more");
  }
  if (text[first] == '<') {
    imported = FromSdf(text, file, options);
  } else if (!has_table_header && text.find('{') != std::string::npos) {
    const std::string json = text[first] == '{' && text.find('#') == std::string::npos
                                 ? text
                                 : FrameWithoutComments(text, file);
    const Json document = ParseJson(json, file);
    const JsonReader reader(document, file, json);
    if (!reader.IsObject()) reader.Fail("an object: a frame of ArduPilot or an equivalent circuit");
    const bool frame = document.contains("maxVoltage") || document.contains("battCapacityAh") ||
                       document.contains("refBatRes");
    if (document.contains("schema"))
      reader.At("schema").FailWith("this is a cell file of lipoid already; use it as it is");
    imported = frame ? FromFrame(reader, options) : FromCircuit(document, reader, options);
  } else {
    imported.format = "tables";
    imported.cell = ParseCellTables(
        text, file, {.capacity_Ah = options.capacity_Ah, .cutoff_V = options.cutoff_V});
  }
  if (options.series) imported.cell.series = *options.series;
  if (options.parallel) imported.cell.parallel = *options.parallel;
  if (!options.name.empty()) {
    imported.cell.name = options.name;
  } else if (imported.cell.name.empty()) {
    imported.cell.name = std::filesystem::path(file).stem().string();
  }
  RefuseSecond("--capacity-Ah", options.capacity_Ah, imported.cell.capacity_Ah, file);
  RefuseSecond("--cutoff-V", options.cutoff_V, imported.cell.cutoff_V, file);
  CheckBattery(imported.cell, file);
  if (std::string doubt = DoubtAboutSeries(imported); !doubt.empty())
    imported.notes.insert(imported.notes.begin(), std::move(doubt));
  return imported;
}

}  // namespace lipoid
