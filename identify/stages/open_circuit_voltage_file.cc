#include "identify/stages/open_circuit_voltage_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/logs/plausibility.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/structured_text.h"
#include "model/core/text_cells.h"

namespace lipoid {
namespace {

struct Row {
  double soc, voltage_V;
  std::size_t line;
};

// A state of charge above this is a percentage; nothing is that far above full.
constexpr double kLargestSoc = 2.0;

OpenCircuitVoltage ParseTable(const std::string& text, const std::string& file) {
  std::vector<Row> rows;
  std::vector<TextCell> cells;
  std::ptrdiff_t soc_field = -1;
  std::ptrdiff_t voltage_field = -1;
  std::size_t line = 0;
  for (std::size_t from = 0; from < text.size();) {
    const auto to = std::min(text.find('\n', from), text.size());
    const std::string_view content = Trimmed(std::string_view(text).substr(from, to - from));
    from = to + 1;
    ++line;
    if (content.empty() || content[0] == '#') continue;
    SplitLine(content, ',', cells);
    if (soc_field < 0) {
      for (std::size_t k = 0; k < cells.size(); ++k) {
        const auto name = LowerCase(cells[k].text);
        if (name == "soc") soc_field = static_cast<std::ptrdiff_t>(k);
        if (name == "voltage_v") voltage_field = static_cast<std::ptrdiff_t>(k);
      }
      if (soc_field < 0 || voltage_field < 0) {
        throw LoadError({file, line, 1},
                        fmt::format("expected the header 'soc,voltage_V', found '{}'", content));
      }
      continue;
    }
    const auto number = [&](std::ptrdiff_t field, const char* name) {
      const auto index = static_cast<std::size_t>(field);
      if (index >= cells.size()) {
        throw LoadError({file, line, content.size() + 1},
                        fmt::format("expected {}, found the end of the line", name));
      }
      double value = 0.0;
      if (!ParseNumber(cells[index].text, '.', value) || !std::isfinite(value)) {
        throw LoadError(
            {file, line, cells[index].column},
            fmt::format("expected a number for {}, found '{}'", name, cells[index].text));
      }
      return value;
    };
    const Row row{number(soc_field, "soc"), number(voltage_field, "voltage_V"), line};
    if (row.soc > kLargestSoc) {
      throw LoadError(
          {file, line, 1},
          fmt::format("expected soc as a fraction, 1 when full, found {} (a percentage?)",
                      row.soc));
    }
    rows.push_back(row);
  }
  if (rows.size() < 2) {
    throw LoadError(
        {file},
        fmt::format("expected at least two rows of soc and voltage_V, found {}", rows.size()));
  }
  std::stable_sort(
      rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.soc < b.soc; });
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (const Row& row : rows) {
    if (!soc.empty() && row.soc == soc.back()) {
      throw LoadError({file, row.line, 1},
                      fmt::format("expected every soc once, found {} again", row.soc));
    }
    soc.push_back(row.soc);
    voltage_V.push_back(row.voltage_V);
  }
  return OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
}

// A curve in mV, or of a pack, says of no log where it starts.
OpenCircuitVoltage OfOneCell(OpenCircuitVoltage curve, const std::string& file) {
  constexpr double kLeast_mV = 1000.0;  // at full charge
  const double full_V = curve(std::min(1.0, curve.soc_hi()));
  if (full_V <= kMostCell_V) return curve;
  const int cells = CellsInSeries(full_V);
  const std::string why =
      full_V >= kLeast_mV
          ? "are these mV? Divide them by 1000"
          : fmt::format("is it that of {} cells in series? Divide it by {}", cells, cells);
  throw LoadError(
      {file},
      fmt::format(
          "expected v_oc(A) of one cell in V, found {:.4g} V at full charge; {}", full_V, why));
}

}  // namespace

OpenCircuitVoltage ReadOpenCircuitVoltageFile(const std::string& file) {
  const std::string text = ReadTextFile(file);
  structured_text::CheckText(text, file);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos)
    throw LoadError({file}, "expected soc,voltage_V rows or a cell file, found nothing");
  return OfOneCell(
      text[first] == '{' ? ParseCell(text, file).open_circuit_voltage : ParseTable(text, file),
      file);
}

}  // namespace lipoid
