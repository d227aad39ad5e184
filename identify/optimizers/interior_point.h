#pragma once

/// @file
/// A primal-dual interior-point method, from Ipopt: bounds are kept by a barrier that vanishes as
/// it converges, so that a solution on a bound is approached from inside.
///
/// Second derivatives of least squares are Gauss-Newton's, J'J from the triangular factor; of other
/// costs, a limited-memory quasi-Newton matrix. Ipopt's linear solver keeps global state: solves
/// run one at a time in a process.

#include <array>
#include <string_view>
#include <utility>

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

enum class HessianSource { kGaussNewton, kLimitedMemory };

constexpr std::array<std::pair<HessianSource, std::string_view>, 2> OptionNames(HessianSource) {
  return {{{HessianSource::kGaussNewton, "gauss-newton"},
           {HessianSource::kLimitedMemory, "limited-memory"}}};
}

struct InteriorPointOptions : LocalSearchOptions {
  HessianSource hessian = HessianSource::kGaussNewton;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    LocalSearchOptions::Visit(self, v);
    v("hessian",
      self.hessian,
      Names{},
      "Hessian of least squares: Gauss-Newton's, or the limited-memory one, which other costs "
      "always have");
  }
};

/// The problem must have a gradient.
[[nodiscard]] OptimizationSummary MinimizeInteriorPoint(const OptimizationProblem& problem,
                                                        const Eigen::VectorXd& start,
                                                        const InteriorPointOptions& options = {});

}  // namespace lipoid
