#include "model/export/cell_tables.h"

#include <fast_float/fast_float.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <vector>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/nearest_name.h"
#include "model/core/special_values.h"
#include "model/core/structured_text.h"
#include "model/core/text_cells.h"
#include "model/export/cell_numbers.h"
#include "model/export/curve_nodes.h"
#include "model/export/export_error.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

constexpr double kLeast = std::numeric_limits<double>::min();
constexpr int kMostBranches = 20;

// The state of charge of every node of any table.
std::vector<double> AllNodes(const Cell& cell, const CurveNodes& curve) {
  std::vector<double> soc = curve.soc;
  const auto add = [&](const Resistance<double>& resistance) {
    soc.insert(soc.end(), resistance.soc.begin(), resistance.soc.end());
  };
  add(cell.series_resistance_Ohm);
  for (const auto& branch : cell.branches) add(branch.resistance_Ohm);
  if (cell.charge_transfer) add(cell.charge_transfer->resistance_Ohm);
  std::sort(soc.begin(), soc.end());
  soc.erase(std::unique(soc.begin(), soc.end()), soc.end());
  return soc;
}

struct Place {
  const std::string& file;
  std::size_t line;
};

[[noreturn]] void Fail(const Place& place, std::size_t column, std::string message) {
  throw LoadError({place.file, place.line, column}, std::move(message));
}

double Number(const Place& place,
              std::size_t column,
              std::string_view name,
              std::string_view text,
              double least,
              double most) {
  double value = 0.0;
  const auto* const end = text.data() + text.size();
  const auto read = fast_float::from_chars(text.data(), end, value);
  if (text.empty() || read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) {
    Fail(place,
         column,
         fmt::format("expected a number for {}, found '{}'", name, ForeignText(text)));
  }
  if (value < least || value > most) {
    const std::string range = least == kLeast     ? "above 0"
                              : most == kInfinity ? fmt::format("of at least {:g}", least)
                                                  : fmt::format("from {:g} to {:g}", least, most);
    Fail(place, column, fmt::format("expected a number {} for {}, found {}", range, name, value));
  }
  return value;
}

int Integer(const Place& place,
            std::size_t column,
            std::string_view name,
            std::string_view text,
            int least,
            int most) {
  const double value = Number(place, column, name, text, least, most);
  if (value != std::floor(value))
    Fail(place, column, fmt::format("expected a whole number for {}, found {}", name, value));
  return static_cast<int>(value);
}

// The numbers that are no tables.
struct Scalars {
  std::optional<double> capacity_Ah, cutoff_V, alpha_C, beta_per_sqrt_s, heating_s, heating_Ohm,
      transfer_A;
  int terms = 10;
  bool tail = true;
  int series = 1;
  int parallel = 1;
  std::optional<std::string> name;
};

using Setter = std::function<void(const Place&, std::size_t, std::string_view, Scalars&)>;

const std::vector<std::pair<std::string, Setter>>& Setters() {
  const auto number = [](std::string key, double least, double most, auto member) {
    return std::pair<std::string, Setter>(
        key, [=](const Place& place, std::size_t column, std::string_view text, Scalars& scalars) {
          scalars.*member = Number(place, column, key, text, least, most);
        });
  };
  const auto integer = [](std::string key, int least, int most, auto member) {
    return std::pair<std::string, Setter>(
        key, [=](const Place& place, std::size_t column, std::string_view text, Scalars& scalars) {
          scalars.*member = Integer(place, column, key, text, least, most);
        });
  };
  static const std::vector<std::pair<std::string, Setter>> setters = {
      {"name",
       [](const Place&, std::size_t, std::string_view text, Scalars& s) {
         s.name = std::string(text);
       }},
      integer("series", 1, 100000, &Scalars::series),
      integer("parallel", 1, 100000, &Scalars::parallel),
      number("capacity_Ah", kLeast, kInfinity, &Scalars::capacity_Ah),
      number("cutoff_V", 0.0, kInfinity, &Scalars::cutoff_V),
      number("alpha_C", kLeast, kInfinity, &Scalars::alpha_C),
      number("beta_per_sqrt_s", kLeast, 1.0, &Scalars::beta_per_sqrt_s),
      integer("terms", 0, 1000, &Scalars::terms),
      {"tail",
       [](const Place& place, std::size_t column, std::string_view text, Scalars& s) {
         if (text != "true" && text != "false") {
           Fail(place,
                column,
                fmt::format("expected true or false for tail, found '{}'", ForeignText(text)));
         }
         s.tail = text == "true";
       }},
      number("self_heating_time_constant_s", kLeast, kInfinity, &Scalars::heating_s),
      number("self_heating_resistance_drop_Ohm_per_A2", 0.0, kInfinity, &Scalars::heating_Ohm),
      number("charge_transfer_current_A", kLeast, kInfinity, &Scalars::transfer_A)};
  return setters;
}

// The columns: of branches as many as are numbered on from 1.
struct Columns {
  std::ptrdiff_t soc = -1;
  std::ptrdiff_t voltage = -1;
  std::ptrdiff_t series = -1;
  std::ptrdiff_t transfer = -1;
  std::vector<std::ptrdiff_t> resistance;
  std::vector<std::ptrdiff_t> time_constant;
};

Columns ReadHeader(const Place& place, const std::vector<TextCell>& fields) {
  Columns columns;
  std::vector<std::pair<std::string, std::ptrdiff_t*>> known = {
      {"soc", &columns.soc},
      {"open_circuit_voltage_V", &columns.voltage},
      {"series_resistance_Ohm", &columns.series},
      {"charge_transfer_resistance_Ohm", &columns.transfer}};
  columns.resistance.assign(kMostBranches, -1);
  columns.time_constant.assign(kMostBranches, -1);
  for (int j = 0; j < kMostBranches; ++j) {
    const auto index = static_cast<std::size_t>(j);
    known.emplace_back(fmt::format("resistance_{}_Ohm", j + 1), &columns.resistance[index]);
    known.emplace_back(fmt::format("time_constant_{}_s", j + 1), &columns.time_constant[index]);
  }
  std::vector<std::string> names;
  for (const auto& [name, column] : known) names.push_back(name);
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& candidate) {
      return candidate.first == fields[k].text;
    });
    if (found == known.end()) {
      Fail(place,
           fields[k].column,
           fmt::format("expected columns soc, open_circuit_voltage_V, series_resistance_Ohm, "
                       "resistance_1_Ohm, time_constant_1_s, ..., charge_transfer_resistance_Ohm, "
                       "found '{}'.{}",
                       ForeignText(fields[k].text),
                       DidYouMean(fields[k].text, names)));
    }
    if (*found->second >= 0)
      Fail(place,
           fields[k].column,
           fmt::format("expected every column once, found {} again", found->first));
    *found->second = static_cast<std::ptrdiff_t>(k);
  }
  const auto require = [&](std::ptrdiff_t column, std::string_view name) {
    if (column < 0) Fail(place, 1, fmt::format("expected a column {}, found none", name));
  };
  require(columns.soc, "soc");
  require(columns.voltage, "open_circuit_voltage_V");
  require(columns.series, "series_resistance_Ohm");
  std::size_t branches = 0;
  while (branches < columns.resistance.size() && columns.resistance[branches] >= 0) ++branches;
  for (std::size_t j = 0; j < columns.resistance.size(); ++j) {
    if (j < branches || columns.time_constant[j] >= 0 || columns.resistance[j] >= 0) {
      require(columns.resistance[j], fmt::format("resistance_{}_Ohm", j + 1));
      require(columns.time_constant[j], fmt::format("time_constant_{}_s", j + 1));
    }
  }
  columns.resistance.resize(branches);
  columns.time_constant.resize(branches);
  return columns;
}

// A table of equal numbers is a constant.
Resistance<double> ResistanceOf(const std::vector<double>& soc, std::vector<double> values) {
  const bool constant =
      std::all_of(values.begin(), values.end(), [&](double r) { return r == values.front(); });
  if (constant) return {values.front()};
  return {soc, std::move(values)};
}

}  // namespace

std::string CellTables(const Cell& cell, const std::string& comment) {
  std::string csv = comment;
  const auto key = [&](std::string_view name, const auto& value) {
    csv += fmt::format("#: {} = {}\n", name, value);
  };
  key("name", ForeignText(cell.name));  // a line break could make a name a row of its own
  key("series", cell.series);
  key("parallel", cell.parallel);
  key("capacity_Ah", cell.capacity_Ah);
  key("cutoff_V", cell.cutoff_V);
  if (cell.diffusion) {
    key("alpha_C", cell.diffusion->alpha_C);
    key("beta_per_sqrt_s", cell.diffusion->beta_per_sqrt_s);
    key("terms", cell.diffusion->terms);
    key("tail", cell.diffusion->tail);
  }
  if (cell.self_heating) {
    key("self_heating_time_constant_s", cell.self_heating->time_constant_s);
    key("self_heating_resistance_drop_Ohm_per_A2", cell.self_heating->resistance_drop_Ohm_per_A2);
  }
  if (cell.charge_transfer) key("charge_transfer_current_A", cell.charge_transfer->current_A);
  csv += "soc,open_circuit_voltage_V,series_resistance_Ohm";
  for (std::size_t j = 1; j <= cell.branches.size(); ++j)
    csv += fmt::format(",resistance_{}_Ohm,time_constant_{}_s", j, j);
  if (cell.charge_transfer) csv += ",charge_transfer_resistance_Ohm";
  csv += '\n';
  const CurveNodes curve = NodesOf(cell.open_circuit_voltage);
  // Between its nodes a linear curve is a straight line anyway; another one is known at all nodes.
  const auto as_lines = OpenCircuitVoltage::Linear(curve.soc, curve.voltage_V);
  for (const double soc : AllNodes(cell, curve)) {
    csv += fmt::format("{},{},{}", soc, as_lines(soc), cell.series_resistance_Ohm(soc));
    for (const auto& branch : cell.branches)
      csv += fmt::format(",{},{}", branch.resistance_Ohm(soc), branch.time_constant_s);
    if (cell.charge_transfer) csv += fmt::format(",{}", cell.charge_transfer->resistance_Ohm(soc));
    csv += '\n';
  }
  return csv;
}

Cell ParseCellTables(const std::string& text,
                     const std::string& file,
                     const TableDefaults& defaults) {
  structured_text::CheckText(text, file);
  Scalars scalars;
  std::optional<Columns> columns;
  std::size_t fields_of_header = 0;
  std::vector<std::vector<double>> values;  // by field
  std::vector<std::string> seen;
  std::vector<TextCell> fields;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    const Place place{file, ++line_number};
    if (line_number == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    if (Trimmed(line).empty()) continue;
    if (line.starts_with("#:")) {
      const std::size_t equals = line.find('=');
      const std::string_view name = Trimmed(line.substr(2, std::min(equals, line.size()) - 2));
      std::vector<std::string> names;
      for (const auto& [known, set] : Setters()) names.push_back(known);
      const auto found = std::find(names.begin(), names.end(), name);
      if (equals == std::string_view::npos || found == names.end())
        Fail(place, 1, UnknownName("number of a cell", name, names));
      if (std::find(seen.begin(), seen.end(), name) != seen.end())
        Fail(place, 1, fmt::format("expected every number once, found {} again", name));
      seen.emplace_back(name);
      const std::string_view value = Trimmed(line.substr(equals + 1));
      const std::size_t column =
          value.empty() ? equals + 2 : static_cast<std::size_t>(value.data() - line.data()) + 1;
      Setters()[static_cast<std::size_t>(found - names.begin())].second(
          place, column, value, scalars);
      continue;
    }
    if (line.front() == '#') continue;
    SplitLine(line, ',', fields);
    if (!columns) {
      columns = ReadHeader(place, fields);
      fields_of_header = fields.size();
      values.resize(fields_of_header);
      continue;
    }
    if (fields.size() != fields_of_header) {
      Fail(place,
           1,
           fmt::format(
               "expected {} fields as in the header, found {}", fields_of_header, fields.size()));
    }
    for (std::size_t k = 0; k < fields.size(); ++k) {
      const auto field = static_cast<std::ptrdiff_t>(k);
      const bool free = field == columns->soc || field == columns->voltage;
      const double value = Number(place,
                                  fields[k].column,
                                  field == columns->soc       ? "soc"
                                  : field == columns->voltage ? "open_circuit_voltage_V"
                                                              : "a resistance or time constant",
                                  fields[k].text,
                                  free ? -kInfinity : 0.0,
                                  kInfinity);
      if (field == columns->soc && !values[k].empty() && !(value > values[k].back())) {
        Fail(place,
             fields[k].column,
             fmt::format("expected a soc above {}, that of the row before, found {}",
                         values[k].back(),
                         value));
      }
      const auto& taus = columns->time_constant;
      if (std::find(taus.begin(), taus.end(), field) != taus.end() && !values[k].empty() &&
          value != values[k].front()) {
        Fail(place,
             fields[k].column,
             fmt::format("expected one time constant for the whole column, {}, found {}",
                         values[k].front(),
                         value));
      }
      values[k].push_back(value);
    }
  }
  if (!columns || values.front().size() < 2) {
    throw LoadError({file},
                    "expected a table of soc,open_circuit_voltage_V,series_resistance_Ohm with at "
                    "least two rows, found none");
  }
  const auto column = [&](std::ptrdiff_t field) { return values[static_cast<std::size_t>(field)]; };
  const std::vector<double> soc = column(columns->soc);
  Cell cell;
  cell.name = scalars.name.value_or(defaults.name);
  cell.series = scalars.series;
  cell.parallel = scalars.parallel;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(soc, column(columns->voltage));
  cell.cutoff_V = scalars.cutoff_V.value_or(
      defaults.cutoff_V.value_or(std::max(0.0, cell.open_circuit_voltage(0.0))));
  auto capacity_Ah = scalars.capacity_Ah ? scalars.capacity_Ah : defaults.capacity_Ah;
  if (!capacity_Ah && scalars.alpha_C) capacity_Ah = *scalars.alpha_C / 3600.0;
  if (!capacity_Ah) {
    throw LoadError({file},
                    "expected a line '#: capacity_Ah = ...', found none; --capacity-Ah gives it");
  }
  cell.capacity_Ah = *capacity_Ah;
  if (scalars.beta_per_sqrt_s) {
    cell.diffusion = Cell::Diffusion{.alpha_C = scalars.alpha_C.value_or(3600.0 * cell.capacity_Ah),
                                     .beta_per_sqrt_s = *scalars.beta_per_sqrt_s,
                                     .terms = scalars.terms,
                                     .tail = scalars.tail};
  } else if (scalars.alpha_C) {
    cell.capacity_Ah = *scalars.alpha_C / 3600.0;
  }
  cell.series_resistance_Ohm = ResistanceOf(soc, column(columns->series));
  for (std::size_t j = 0; j < columns->resistance.size(); ++j) {
    cell.branches.push_back({ResistanceOf(soc, column(columns->resistance[j])),
                             column(columns->time_constant[j]).front(),
                             std::nullopt});
  }
  if (scalars.heating_s || scalars.heating_Ohm) {
    if (!scalars.heating_s || !scalars.heating_Ohm) {
      throw LoadError({file},
                      "expected both self_heating_time_constant_s and "
                      "self_heating_resistance_drop_Ohm_per_A2, found one");
    }
    cell.self_heating = Cell::SelfHeating{.time_constant_s = *scalars.heating_s,
                                          .resistance_drop_Ohm_per_A2 = *scalars.heating_Ohm};
  }
  if (scalars.transfer_A.has_value() != (columns->transfer >= 0)) {
    throw LoadError({file},
                    "expected both charge_transfer_current_A and a column "
                    "charge_transfer_resistance_Ohm, found one");
  }
  if (scalars.transfer_A) {
    cell.charge_transfer =
        Cell::ChargeTransfer{.current_A = *scalars.transfer_A,
                             .resistance_Ohm = ResistanceOf(soc, column(columns->transfer))};
  }
  return cell;
}

Exported ExportTables(const ExportRequest& request) {
  const Cell& cell = request.cell;
  Exported exported;
  const Cell back = ParseCellTables(CellTables(cell, ""), "tables");
  exported.error = MissionError(request, ReferenceOf(back, request.mission).voltage_V);
  exported.parameters = {{"capacity_Ah", cell.capacity_Ah, "Ah"}, {"cutoff_V", cell.cutoff_V, "V"}};
  if (cell.diffusion) {
    exported.parameters.push_back({"alpha_C", cell.diffusion->alpha_C, "C"});
    exported.parameters.push_back({"beta_per_sqrt_s", cell.diffusion->beta_per_sqrt_s, "s^-1/2"});
  }
  if (cell.diffusion)
    exported.cannot_hold.emplace_back(
        "A program that reads the table alone has no diffusion: the lines #: hold its numbers, and "
        "soc is the charge that is available, not the charge that is left. For such a program export "
        "to thevenin, whose tables are fitted without diffusion.");
  exported.notes = {
      "The numbers are those of one cell; between the rows are straight lines, beyond them v_oc goes "
      "on with its end slope and resistances keep their end values.",
      "The error is that of a cell imported from this file by lipoid."};
  constexpr double kStiff_s = 0.01;
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    if (cell.branches[j].time_constant_s < kStiff_s) {
      exported.notes.push_back(fmt::format(
          "Branch {} has a time constant of {:.3g} s: for an explicit solver add its resistance to "
          "the series resistance and leave it out.",
          j + 1,
          cell.branches[j].time_constant_s));
    }
  }
  exported.files = {
      {".csv", CellTables(cell, Commented(ProvenanceLines(request, exported), "# "))}};
  return exported;
}

}  // namespace lipoid
