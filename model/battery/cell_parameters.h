#pragma once

/// @file
/// The table of parameters: the one place that knows what a parameter is called, its unit, its range
/// and where it stands in a cell. Names are those of the command line: alpha, beta, r_s, r_1, c_1,
/// tau_1, r_2, ... in SI units (C, s^-1/2, Ohm, F, s), and, of the two terms beyond the thesis,
/// tau_h (s), rho_h (Ohm/A²), i_0 (A), r_ct (Ohm), the activation energies E_s, E_d, E_1, ..., E_ct
/// (J/mol), the heat capacity C_th (J/K), the thermal resistance R_th (K/W), the slope dv_dT of v_oc
/// (V/K), and of hysteresis gamma and M (V). A new parameter is a new row in the source file.
/// Tests: tests/model/battery/cell_parameters_test.cc.

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

/// What is true of a parameter in every cell.
struct CellParameterKind {
  std::string_view symbol;    ///< "beta"; of a branch without its number: "tau"
  std::string_view unit;      ///< "s"
  std::string_view expected;  ///< its range in words: "a time constant above 0 s"
  bool of_branch = false;     ///< the name has the number of a branch behind it
  bool zero = false;          ///< the value may be 0; it is never less
  double upper = std::numeric_limits<double>::infinity();  ///< the largest value it may have
  bool any_sign = false;                                   ///< the value may be less than 0
  double lower = 0.0;                                      ///< the least, where that is above 0

  /// Finite and within the range.
  [[nodiscard]] bool Holds(double value) const;
};

/// A name of the table: its kind, and the branch it belongs to, counted from 0.
struct CellParameterName {
  const CellParameterKind* kind = nullptr;
  std::size_t branch = 0;
};

/// None for a name that no cell has.
[[nodiscard]] std::optional<CellParameterName> FindCellParameter(std::string_view name);

/// A quantity as reports name it, "r_s(0.5)": its name, and the state of charge where it has one.
struct QuantityName {
  std::string name;
  std::optional<double> soc;
};
[[nodiscard]] QuantityName SplitQuantity(std::string_view quantity);

/// The names this cell has, in the order above. A table of resistances has no name: of such a
/// branch there is only tau_j. Its nodes are parameters as the others are (V for v_oc), where it
/// says so below, counted from 0 as the lists of the cell file: r_s[0], r_s[1], ..., r_1[0], ...,
/// r_ct[0], ..., dv_dT[0], ..., M[0], ... and, where v_oc(A) is linear or monotone-cubic, v_oc[0].
[[nodiscard]] std::vector<std::string> CellParameterNames(const Cell& cell);

/// The resistances this cell has, constant or not: r_s, r_1, ..., r_ct.
[[nodiscard]] std::vector<std::string> CellResistanceNames(const Cell& cell);

/// The resistance of that name; null where the cell has none.
[[nodiscard]] const Resistance<double>* CellResistance(const Cell& cell, std::string_view name);

/// r_s and r_1 .. r_n at a state of charge, in Ohm: the drop of a lasting current over that current, without
/// a charge transfer, which is not linear in it.
[[nodiscard]] double SeriesAndBranches(const Cell& cell, double soc);
/// r_total, the same with r_ct where there is one: what a small current sees.
[[nodiscard]] double TotalResistance(const Cell& cell, double soc);

/// The value, or none where the cell has no such parameter or node.
[[nodiscard]] std::optional<double> CellParameter(const Cell& cell, std::string_view name);

/// Changes one parameter; r_j of the branch after the last adds a branch, to be completed by c_j or
/// tau_j; tau_h or rho_h, i_0 or r_ct, C_th or R_th, gamma or M add their term, to be completed by the
/// other of the two. With
/// r_j given, a branch keeps what it was written with: its capacitance or its time constant.
/// A node changes its table alone: OptionError where there is none. OptionError names the
/// parameters there are, or the range.
void SetCellParameter(Cell& cell, std::string_view name, double value);

/// Changes several, one after the other, which make a whole cell. OptionError moreover for a name
/// that stands twice, for c_j beside tau_j of one branch, since either follows from the other and
/// r_j, and for what MissingCellParameter() misses.
void SetCellParameters(Cell& cell, const std::vector<std::pair<std::string, double>>& values);

/// What SetCellParameter() began and did not complete, "r_2 needs c_2 or tau_2 beside it"; none
/// where the cell is whole.
[[nodiscard]] std::optional<std::string> MissingCellParameter(const Cell& cell);

/// "C", "s^-1/2", "Ohm", ... of a name above, or of a node's.
[[nodiscard]] std::string_view CellParameterUnit(std::string_view name);

}  // namespace lipoid
