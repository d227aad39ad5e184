#pragma once

/// @file
/// A cell as the C code of the exports takes it (runtime/cell_law.h), that code run inside lipoid,
/// and how far a target is from the cell over a mission. Tests:
/// tests/model/export/cell_numbers_test.cc.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/export/exported.h"

namespace lipoid {

/// Fields, order and meaning of cell_numbers in cell_law.h.
struct CellNumbers {
  double alpha_C = 0.0;
  double tail_s = 0.0;
  std::vector<double> rate_per_s;
  std::vector<double> time_constant_s;
  std::vector<Resistance<double>> branch;
  Resistance<double> series;
  std::optional<SelfHeating<double>> self_heating;
  std::optional<ChargeTransfer<double>> charge_transfer;
  int curve = 0;
  std::vector<double> soc;
  std::vector<double> piece_V;
  std::vector<double> cosine_V;
  std::vector<double> sine_V;
  double frequency_rad = 0.0;
  std::array<double, 2> end_V{};
  std::array<double, 2> end_slope_V{};

  [[nodiscard]] std::size_t states() const {
    return 1 + rate_per_s.size() + branch.size() + (self_heating ? 1 : 0);
  }
};

/// Numbers that are not finite, or a capacity that is not positive, break a precondition.
[[nodiscard]] CellNumbers NumbersOf(const Cell& cell);

/// C source: the tables and `static const cell_numbers cell_of_file`, each number as
/// CELL_NUMBER(1.25).
[[nodiscard]] std::string NumbersAsC(const CellNumbers& numbers);

/// The same as little-endian doubles, which the library inside an FMU reads (runtime/fmu_cell.h).
[[nodiscard]] std::string NumbersAsBytes(const CellNumbers& numbers);

[[nodiscard]] std::string NumberAsBytes(double value);

/// A number that C reads as a floating-point constant and that gives the same double.
[[nodiscard]] std::string CNumber(double value);

/// A text of model/export/runtime, by its file's name without the last extension; it is part of the
/// library.
[[nodiscard]] std::string_view RuntimeText(std::string_view name);

/// The text with every @key@ replaced.
[[nodiscard]] std::string Filled(
    std::string_view text,
    std::initializer_list<std::pair<std::string_view, std::string_view>> values);

/// An identifier that C, Python and SPICE take: letters, digits and underscores of the name, with a
/// letter first, at most 63 of them.
[[nodiscard]] std::string Identifier(std::string_view name);

enum class LawNumbers { kDouble, kFloat };

/// Terminal voltage of the pack at every row by cell_law.h, a row in so many steps: a step takes
/// the resistance of a branch at the state of charge at its beginning, so that many of them are
/// what a solver of differential equations finds.
[[nodiscard]] std::vector<double> RunCellLaw(const Cell& cell,
                                             const ExportMission& mission,
                                             LawNumbers numbers,
                                             int steps_of_row = 1);

/// How far these voltages of the pack are from those of the request's cell.
[[nodiscard]] ExportError MissionError(const ExportRequest& request,
                                       std::span<const double> voltage_V);

}  // namespace lipoid
