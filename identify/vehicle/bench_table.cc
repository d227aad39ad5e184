#include "identify/vehicle/bench_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/text_cells.h"

namespace lipoid {
namespace {

constexpr double kStandardGravity_m_per_s2 = 9.80665;  // of the kilogram-force
constexpr double kPerRpm_rad_per_s = std::numbers::pi / 30.0;

struct Unit {
  std::string_view name;
  double factor = 0.0;
  double offset = 0.0;  // subtracted first
};

struct Column {
  std::string_view what;
  std::array<std::string_view, 3> begins;  // what a header's name begins with, in lower case
  std::array<Unit, 11> units;              // "": a header without a unit; of factor 0 none
  double BenchRow::*member;
  std::string_view expected;
  bool required;
};

constexpr Column kColumns[] = {
    {"throttle",
     {"throttle", "duty", "throttle"},
     {{{"%", 0.01}, {"us", 1e-3, 1000.0}, {"", 1.0}, {"percent", 0.01}, {"µs", 1e-3, 1000.0}}},
     &BenchRow::throttle,
     "%, us, or no unit for a fraction",
     true},
    {"voltage",
     {"volt", "battery voltage", "voltage"},
     {{{"v", 1.0}, {"mv", 1e-3}, {"volt", 1.0}, {"volts", 1.0}}},
     &BenchRow::voltage_V,
     "V or mV",
     true},
    {"current",
     {"current", "battery current", "amp"},
     {{{"a", 1.0}, {"ma", 1e-3}, {"amp", 1.0}, {"amps", 1.0}, {"ampere", 1.0}}},
     &BenchRow::current_A,
     "A or mA",
     true},
    {"thrust",
     {"thrust", "pull", "force"},
     {{{"g", 1e-3 * kStandardGravity_m_per_s2},
       {"n", 1.0},
       {"kg", kStandardGravity_m_per_s2},
       {"gf", 1e-3 * kStandardGravity_m_per_s2},
       {"kgf", kStandardGravity_m_per_s2}}},
     &BenchRow::thrust_N,
     "g, kg or N",
     true},
    {"speed",
     {"rpm", "speed", "rotation speed"},
     {{{"", kPerRpm_rad_per_s},
       {"rpm", kPerRpm_rad_per_s},
       {"rad/s", 1.0},
       {"1/min", kPerRpm_rad_per_s},
       {"rev/min", kPerRpm_rad_per_s},
       {"r/min", kPerRpm_rad_per_s},
       {"u/min", kPerRpm_rad_per_s},
       {"krpm", 1e3 * kPerRpm_rad_per_s},
       {"hz", 60.0 * kPerRpm_rad_per_s},
       {"rps", 60.0 * kPerRpm_rad_per_s},
       {"rad_per_s", 1.0}}},
     &BenchRow::speed_rad_per_s,
     "rpm, krpm, Hz or rad/s",
     false},
};

// "Thrust (g)", "Thrust [g]", "Thrust / g", "thrust_g": name and unit.
struct Header {
  std::string name;
  std::string unit;
};
Header Split(std::string_view cell) {
  const std::string text = LowerCase(Trimmed(cell));
  for (const auto& [open, close] : {std::pair{'(', ')'}, {'[', ']'}, {'/', '\0'}, {'_', '\0'}}) {
    const auto at = text.find(open);
    if (at == std::string::npos || at == 0) continue;
    const auto end = close == '\0' ? text.size() : std::min(text.find(close, at), text.size());
    const std::string_view view(text);
    return {std::string(Trimmed(view.substr(0, at))),
            std::string(Trimmed(view.substr(at + 1, end - at - 1)))};
  }
  return {text, ""};
}

struct Found {
  std::size_t field;
  Unit unit;
};

bool BeginsLike(const Column& column, const std::string& name) {
  return std::any_of(column.begins.begin(), column.begins.end(), [&](auto begin) {
    return name.starts_with(begin);
  });
}

bool Has(const std::string& name, std::string_view part) {
  return name.find(part) != std::string::npos;
}

// No more than that word, in one or many.
bool IsCalled(const Column& column, const std::string& name) {
  return name == column.what || name == fmt::format("{}s", column.what) ||
         std::find(column.begins.begin(), column.begins.end(), name) != column.begins.end();
}

// "Motor Optical Speed (RPM)", "Prop RPM", "krpm": a speed, and not of the air.
bool NamesASpeed(const std::string& name) {
  return (Has(name, "rpm") || Has(name, "speed")) && !Has(name, "air") && !Has(name, "wind");
}

std::optional<Found> Find(const Column& column,
                          const std::vector<TextCell>& header,
                          const std::string& file,
                          std::size_t line) {
  const auto any = [&](auto&& named) {
    return std::any_of(header.begin(), header.end(), [&](const TextCell& cell) {
      return named(column, Split(cell.text).name);
    });
  };
  // "Current (A)" before "Current limit (A)", and "Thrust efficiency (g/W)" is none.
  const bool called = any(IsCalled);
  const bool begins = any(BeginsLike);
  const TextCell* electrical = nullptr;  // of a speed, refused where there is no other
  for (std::size_t field = 0; field < header.size(); ++field) {
    Header found = Split(header[field].text);
    const bool named = called ? IsCalled(column, found.name)
                       : begins
                           ? BeginsLike(column, found.name)
                           : column.member == &BenchRow::speed_rad_per_s && NamesASpeed(found.name);
    if (!named) continue;
    if (Has(found.name, "erpm") || Has(found.name, "electrical")) {
      if (electrical == nullptr) electrical = &header[field];
      continue;
    }
    if (found.unit.empty() && found.name == "krpm") found.unit = found.name;
    for (const Unit& unit : column.units) {
      if (unit.factor != 0.0 && unit.name == found.unit) return Found{field, unit};
    }
    // A speed that is that of the air is no column of ours.
    constexpr std::string_view kOfAir[] = {"m/s", "km/h", "kn", "kt", "mph", "ft/s", "m_per_s"};
    if (std::find(std::begin(kOfAir), std::end(kOfAir), found.unit) != std::end(kOfAir)) continue;
    throw LoadError({file, line, header[field].column},
                    fmt::format("{}: expected the unit {}, found '{}'",
                                column.what,
                                column.expected,
                                header[field].text));
  }
  if (electrical != nullptr) {
    throw LoadError(
        {file, line, electrical->column},
        fmt::format(
            "speed: expected that of the propeller, found '{}', electrical revolutions: divide "
            "them by the pairs of poles of the motor, and call the column rpm",
            electrical->text));
  }
  return {};
}

char DelimiterOf(std::string_view line) {
  constexpr std::string_view kDelimiters = ",;\t";
  return *std::max_element(kDelimiters.begin(), kDelimiters.end(), [&](char a, char b) {
    return std::count(line.begin(), line.end(), a) < std::count(line.begin(), line.end(), b);
  });
}

void CheckRow(const BenchRow& row, bool has_speed, const std::string& file, std::size_t line) {
  const auto refuse = [&](std::string_view expected, double found) {
    throw LoadError({file, line, 1}, fmt::format("expected {}, found {:.6g}", expected, found));
  };
  if (!(row.throttle > 0.0 && row.throttle <= 1.0)) {
    refuse("a throttle above 0 and at most 100 %, as a fraction", row.throttle);
  }
  if (!(row.voltage_V > 0.0 && row.voltage_V < 1e4)) refuse("a voltage above 0 V", row.voltage_V);
  if (!(row.current_A > 0.0 && row.current_A < 1e5)) refuse("a current above 0 A", row.current_A);
  if (!(row.thrust_N > 0.0 && row.thrust_N < 1e6)) refuse("a thrust above 0 N", row.thrust_N);
  if (has_speed && !(row.speed_rad_per_s > 0.0 && row.speed_rad_per_s < 1e5)) {
    refuse("a speed above 0 and below 1e5 rad/s", row.speed_rad_per_s);
  }
}

// Of more power comes more thrust, whatever the voltage. Half as much is a slip of the pen, or a dot for thousands.
void RefuseFallingThrust(const std::vector<BenchRow>& rows,
                         const std::vector<std::size_t>& lines,
                         const std::string& file) {
  constexpr double kMore = 1.1;
  constexpr double kLess = 0.5;
  constexpr double kDot = 0.01;
  for (std::size_t b = 0; b < rows.size(); ++b) {
    for (std::size_t a = 0; a < rows.size(); ++a) {
      const double more = rows[b].voltage_V * rows[b].current_A;
      const double less = rows[a].voltage_V * rows[a].current_A;
      if (more < kMore * less || rows[b].thrust_N > kLess * rows[a].thrust_N) continue;
      throw LoadError(
          {file, lines[b], 1},
          fmt::format(
              "expected a thrust that grows with the power, found {:.4g} N at {:.4g} W, and {:.4g} N at "
              "{:.4g} W in line {}: {}",
              rows[b].thrust_N,
              more,
              rows[a].thrust_N,
              less,
              lines[a],
              rows[b].thrust_N < kDot * rows[a].thrust_N
                  ? "is that a dot for thousands (1.040 for 1040)?"
                  : "one of the two is not what was measured"));
    }
  }
}

// Of a motor that pulls more, the current grows and the battery's voltage falls. Of rows at several
// voltages, some pair does as a motor does.
void RefuseExchanged(const std::vector<BenchRow>& rows, const std::string& file) {
  constexpr double kMore = 1.1;
  bool any = false;
  for (const BenchRow& a : rows) {
    for (const BenchRow& b : rows) {
      if (b.thrust_N < kMore * a.thrust_N) continue;
      any = true;
      if (b.voltage_V <= a.voltage_V || b.current_A > kMore * a.current_A) return;
    }
  }
  if (!any) return;
  const auto [least, most] =
      std::minmax_element(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
        return a.thrust_N < b.thrust_N;
      });
  throw LoadError(
      NoFile(file),
      fmt::format(
          "expected a current that grows with the thrust, found {:.4g} A at {:.4g} N and "
          "{:.4g} A at {:.4g} N while the voltage rises from {:.4g} to {:.4g} V: voltage and "
          "current look exchanged; correct the header",
          least->current_A,
          least->thrust_N,
          most->current_A,
          most->thrust_N,
          least->voltage_V,
          most->voltage_V));
}

}  // namespace

BenchTable ParseBenchTable(const std::string& text, const std::string& file) {
  BenchTable table;
  std::array<std::optional<Found>, std::size(kColumns)> found;
  std::vector<TextCell> cells;
  std::size_t fields = 0;
  char delimiter = ',';
  std::size_t line = 0;
  std::vector<std::size_t> lines;  // of the rows
  std::size_t standing = 0;
  std::size_t copies = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view view = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++line;
    if (line == 1 && view.starts_with("\xEF\xBB\xBF")) view.remove_prefix(3);
    if (Trimmed(view).empty() || Trimmed(view).starts_with('#')) continue;
    if (fields == 0) delimiter = DelimiterOf(view);
    SplitLine(view, delimiter, cells);
    if (fields == 0) {
      fields = cells.size();
      for (std::size_t k = 0; k < std::size(kColumns); ++k) {
        found[k] = Find(kColumns[k], cells, file, line);
        if (!found[k] && kColumns[k].required) {
          throw LoadError({file, line, 1},
                          fmt::format("expected a column of the {} in {}, found the columns {}",
                                      kColumns[k].what,
                                      kColumns[k].expected,
                                      std::string(Trimmed(view))));
        }
      }
      table.has_speed = found.back().has_value();
      continue;
    }
    if (cells.size() != fields) {
      throw LoadError(
          {file, line, 1},
          fmt::format("expected {} fields as in the header, found {}", fields, cells.size()));
    }
    BenchRow row;
    for (std::size_t k = 0; k < std::size(kColumns); ++k) {
      if (!found[k]) continue;
      const TextCell& cell = cells[found[k]->field];
      double value = 0.0;
      std::string_view number = Trimmed(cell.text);
      const bool percent = number.ends_with('%');
      if (percent) number.remove_suffix(1);
      const bool read = ParseNumber(Trimmed(number), '.', value) ||
                        (delimiter != ',' && ParseNumber(Trimmed(number), ',', value));
      if (!read || !std::isfinite(value)) {
        throw LoadError(
            {file, line, cell.column},
            fmt::format("{}: expected a number, found '{}'", kColumns[k].what, cell.text));
      }
      row.*kColumns[k].member = (value - found[k]->unit.offset) * found[k]->unit.factor;
      if (percent && found[k]->unit.name.empty()) row.*kColumns[k].member *= 0.01;
    }
    if (row.throttle >= 0.0 && row.thrust_N == 0.0 && row.speed_rad_per_s == 0.0) {
      ++standing;
      continue;
    }
    CheckRow(row, table.has_speed, file, line);
    if (std::find(table.rows.begin(), table.rows.end(), row) != table.rows.end()) {
      ++copies;
      continue;
    }
    table.rows.push_back(row);
    lines.push_back(line);
  }
  const auto remark = [&](std::size_t rows, std::string_view what) {
    if (rows == 0) return;
    table.remarks.push_back(fmt::format("{} of {} {}", Counted(rows, "row"), file, what));
  };
  remark(standing, "left out: no thrust, the propeller stands");
  remark(
      copies,
      "left out: the same numbers in every column as a row before, a copy of which says nothing new");
  constexpr std::size_t kFewestRows = 4;
  if (table.rows.size() < kFewestRows) {
    throw LoadError(NoFile(file),
                    fmt::format("expected at least {} rows of a bench table, found {}",
                                kFewestRows,
                                table.rows.size()));
  }
  RefuseExchanged(table.rows, file);
  RefuseFallingThrust(table.rows, lines, file);
  return table;
}

BenchTable ReadBenchTable(const std::string& file) {
  return ParseBenchTable(ReadTextFile(file), file);
}

}  // namespace lipoid
