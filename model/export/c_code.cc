#include "model/export/c_code.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "model/battery/cell_model.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/significant_digits.h"
#include "model/export/cell_numbers.h"
#include "model/export/folded_branches.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

// The least that rounding may cost in the file's own test: steps in another order and type.
constexpr double kDoubleTolerance_V = 1e-9;
constexpr double kFloatTolerance_V = 1e-5;
constexpr double kFloatMargin = 4.0;  // other compilers, other libm

struct TestRow {
  int steps;
  double dt_s;
  double current_A;
};

// From full to beyond empty with rests and a charge, in short and in long steps; currents of a
// multiple of the capacity in an hour.
std::vector<TestRow> TestRows(const Cell& cell) {
  constexpr double kRates_per_h[] = {0, 2, 10, -1, 5, 14, 0, 8};
  std::vector<TestRow> rows;
  const double per_hour_A = cell.parallel * cell.alpha_C() / 3600.0;
  for (int round = 0; round < 4; ++round) {
    for (const double rate : kRates_per_h) {
      // Printed with few digits and read back, so that file and reference share the number.
      const double current_A = RoundToDigits(rate * per_hour_A, 6);
      rows.push_back({100, 0.005, current_A});
      rows.push_back({9, 2.5, current_A});
    }
  }
  return rows;
}

// The rows of the file's test as a mission of single steps, to learn what float costs there.
ExportMission AsMission(const std::vector<TestRow>& rows) {
  ExportMission mission;
  mission.time_s = {0.0};
  mission.current_A = {0.0};
  for (const TestRow& row : rows) {
    for (int k = 0; k < row.steps; ++k) {
      mission.time_s.push_back(mission.time_s.back() + row.dt_s);
      mission.current_A.push_back(row.current_A);
    }
  }
  return mission;
}

std::string ReferenceRows(const Cell& cell, const std::vector<TestRow>& rows) {
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(1.0);
  std::string text;
  for (const TestRow& row : rows) {
    const double current_A = row.current_A / cell.parallel;
    const auto step = model.MakeStep(row.dt_s);
    for (int k = 0; k < row.steps; ++k) model.Advance(state, current_A, step);
    text += fmt::format("    {{{}, {}, {}, {}, {}}},\n",
                        row.steps,
                        CNumber(row.dt_s),
                        CNumber(row.current_A),
                        CNumber(model.Soc(state, current_A)),
                        CNumber(cell.series * model.Voltage(state, current_A)));
  }
  return text;
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  return text;
}

// What the file's identifiers begin with: those of its law begin with cell and CELL.
std::string Prefix(const ExportRequest& request) {
  const std::string name = Identifier(request.name);
  return Upper(name) == "CELL" ? "lipoid_" + name : name;
}

// As it stands between the quotation marks of an #include.
std::string FileStem(const ExportRequest& request, const std::string& name) {
  const std::string& stem = request.stem.empty() ? name : request.stem;
  const bool fits = std::none_of(stem.begin(), stem.end(), [](unsigned char c) {
    return c < 0x20 || c == 0x7f || c == '"' || c == '\\' || c == '/' || c == '@';
  });
  if (!fits) {
    throw OptionError(fmt::format(
        "the name of a C file cannot hold quotation marks, backslashes, '@' or control characters, "
        "found '{}'; choose another file name",
        ForeignText(stem)));
  }
  return stem;
}

}  // namespace

Exported ExportC(const ExportRequest& request) {
  const std::string version = request.precision == ExportPrecision::kSingle ? "float"
                              : request.target_version.empty()              ? "double"
                                                               : request.target_version;
  if (version != "double" && version != "float") {
    throw OptionError(fmt::format("the target c has the versions double and float, found '{}'",
                                  ForeignText(version)));
  }
  const bool single = version == "float";
  const FoldedCell folded = FoldFastBranches(request.cell);
  const Cell& cell = folded.cell;
  const CellNumbers numbers = NumbersOf(cell);
  const std::string identifier = Identifier(request.name);
  const std::string name = Prefix(request);
  const std::string file = FileStem(request, identifier);
  const std::string upper = Upper(name);

  Exported exported;
  exported.error = MissionError(
      request,
      RunCellLaw(cell, request.mission, single ? LawNumbers::kFloat : LawNumbers::kDouble));
  exported.parameters = {{"alpha", cell.alpha_C(), "C"},
                         {"states", static_cast<double>(numbers.states()), "1"},
                         {"series", static_cast<double>(cell.series), "1"},
                         {"parallel", static_cast<double>(cell.parallel), "1"}};
  exported.notes = folded.notes;
  exported.notes.push_back(fmt::format(
      "Numbers are {}; the law is the cell's own{}, and each step is exact for a current that is "
      "constant over it{}.",
      !single         ? "double"
      : request.whole ? "float"
                      : "float, whose rounding is the error",
      WithoutWhatNoTargetHolds(request),
      ButForTables(cell)));

  if (name != identifier) {
    exported.notes.push_back(
        fmt::format("Its names begin with {}: those of its law begin with cell.", name));
  }

  // What float costs in the file's own test, wherever it may be compiled.
  const auto rows = TestRows(cell);
  const ExportMission test_mission = AsMission(rows);
  const auto in_double = RunCellLaw(cell, test_mission, LawNumbers::kDouble);
  const auto in_float = RunCellLaw(cell, test_mission, LawNumbers::kFloat);
  double float_V = 0.0;
  for (std::size_t k = 0; k < in_float.size(); ++k)
    float_V = std::max(float_V, std::abs(in_float[k] - in_double[k]));

  const std::string comment = Commented(ProvenanceLines(request, exported), "// ");
  const std::string real_step = single ? "0.005f" : "0.005";
  exported.files.push_back({".h",
                            Filled(RuntimeText("c_header.h"),
                                   {{"provenance", comment},
                                    {"name", name},
                                    {"NAME", upper},
                                    {"real_step", real_step},
                                    {"cutoff", fmt::format("{:.6g}", cell.series * cell.cutoff_V)},
                                    {"is_float", single ? "1" : "0"},
                                    {"series", fmt::to_string(cell.series)},
                                    {"parallel", fmt::to_string(cell.parallel)},
                                    {"states", fmt::to_string(numbers.states())}})});
  exported.files.push_back(
      {".c",
       Filled(RuntimeText("c_source.c"),
              {{"provenance", comment},
               {"name", name},
               {"NAME", upper},
               {"file", file},
               {"law", RuntimeText("cell_law")},
               {"numbers", NumbersAsC(numbers)},
               {"test_rows", ReferenceRows(cell, rows)},
               {"float_tolerance",
                CNumber(kFloatMargin * std::max(float_V, cell.series * kFloatTolerance_V))},
               {"double_tolerance", CNumber(cell.series * kDoubleTolerance_V)}})});
  return exported;
}

}  // namespace lipoid
