#pragma once

/// @file
/// Two cells side by side, parameter by parameter: a truth and an estimate of it.
/// Tests: tests/model/battery/cell_comparison_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

struct ParameterComparison {
  std::string name;  ///< as on the command line, see cell_parameters.h
  std::string unit;
  std::optional<double> truth;  ///< none where that cell has no such parameter
  std::optional<double> estimate;
  std::optional<double> error_percent;  ///< 100 (estimate - truth)/truth
};

struct CellComparison {
  std::vector<ParameterComparison> parameters;
  /// v_oc after equal charge delivered, over what empties the truth: alpha is a capacity reference
  /// of the soc axis, so that equal soc would compare different states.
  double open_circuit_max_V = 0.0;
  double open_circuit_rms_V = 0.0;
};

/// Branches correspond by the nearest time constant, each once, and have the numbers of the truth.
/// Where both know temperature the truth is that at the reference temperature of the estimate.
[[nodiscard]] CellComparison CompareCells(const Cell& truth, const Cell& estimate);
[[nodiscard]] Json ComparisonToJson(const CellComparison& comparison);

}  // namespace lipoid
