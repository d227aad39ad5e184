#pragma once

/// @file
/// The best numbers that a target's law can hold: least squares of its voltage against the cell's,
/// within bounds that keep the numbers physical, by the optimizers of identify/optimizers. Nothing
/// is random: the same request gives the same bits. Tests:
/// tests/identify/export/projection_test.cc.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "identify/optimizers/summary.h"

namespace lipoid {

struct FreeParameter {
  std::string name;
  double lower = 0.0;
  double upper = 0.0;
  double scale = 1.0;  ///< a change of this size matters; > 0
};

/// The law's voltages, one for each row, at these parameters.
using ProjectedLaw = std::function<std::vector<double>(const std::vector<double>& parameters)>;

struct Projection {
  std::vector<double> parameters;
  Termination termination = Termination::kNotRun;
  std::string message;
  std::vector<std::string> at_bound;  ///< names of the parameters that stand at one
};

/// The best of the local searches from all starts, at least one, each with as many numbers as there
/// are parameters. Where no start has a finite error the termination is kFailure.
[[nodiscard]] Projection Project(const ProjectedLaw& law,
                                 std::span<const double> voltage_V,
                                 const std::vector<FreeParameter>& parameters,
                                 const std::vector<std::vector<double>>& starts);

}  // namespace lipoid
