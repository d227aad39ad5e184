#include "model/battery/cell_ensemble.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "model/battery/uncertain_cell.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"
#include "model/statistics/normal_noise.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

// With more degrees of freedom Student's distribution is the normal one to within 1e-6.
constexpr double kNormalFrom = 1e6;

// The cell, and whether it had to be moved.
std::pair<Cell, bool> Draw(const UncertainCell& around, std::uint64_t seed, std::uint32_t k) {
  const double freedom = around.degrees_of_freedom();
  NormalNoise normal(seed, k);
  Eigen::VectorXd z(around.factor().cols());
  for (double& one : z) one = normal();
  if (freedom < kNormalFrom) {
    // A normal number says which quantile of chi².
    const double above = 0.5 * std::erfc(normal() / std::sqrt(2.0));
    z *= std::sqrt(freedom / ChiSquaredPassed(freedom, above));
  }
  Eigen::VectorXd x = around.estimate() + around.factor() * z;
  const bool moved = around.MoveIntoRange(x);
  return {around.At(x), moved};
}

}  // namespace

CellEnsemble DrawCells(const Cell& cell, int count, std::uint64_t seed) {
  Require(count >= 0, "count >= 0", {{"count", count}});
  const UncertainCell around(cell);
  CellEnsemble ensemble;
  ensemble.cells.resize(static_cast<std::size_t>(count));
  std::vector<char> moved(ensemble.cells.size());
  ParallelFor(ensemble.cells.size(), [&](std::size_t k) {
    StopIfAsked();
    auto drawn = Draw(around, seed, static_cast<std::uint32_t>(k));
    ensemble.cells[k] = std::move(drawn.first);
    moved[k] = drawn.second ? 1 : 0;
  });
  ensemble.moved = static_cast<int>(std::count(moved.begin(), moved.end(), 1));
  return ensemble;
}

std::string DoubtAboutMoved(std::size_t moved, std::size_t cells) {
  if (2 * moved <= cells) return "";
  return fmt::format(
      "{} of {} cells were drawn with what no cell has (a negative resistance, beta above 1, v_oc "
      "that falls as charge comes in) and moved to the nearest that one may have: the interval of "
      "what hangs on these lies on one side of the estimate, and may leave it out",
      moved,
      cells);
}

}  // namespace lipoid
