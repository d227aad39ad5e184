#pragma once

/// @file
/// Particle swarm, from pagmo (pso_gen): every particle is drawn to the best point it has seen and
/// to the best that its neighbours have. The thesis adapts an inertia in [0.1, 1]; pagmo has no
/// such rule, and a constant constriction factor (Clerc and Kennedy) stands in its place, from the
/// middle of that range. A particle that meets a bound stops there.

#include "identify/optimizers/global_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct ParticleSwarmOptions : PopulationOptions {
  double constriction = 0.55;
  double own_attraction = 2.05;
  double social_attraction = 2.05;
  int neighbours = 50;
  double maximum_velocity = 0.5;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    PopulationOptions::Visit(self, v);
    v("constriction",
      self.constriction,
      Range{0.0, 1.0},
      "factor on the velocity, in place of an adaptive inertia");
    v("own_attraction",
      self.own_attraction,
      Range{0.0, 4.0},
      "attraction to the best point that the particle has seen");
    v("social_attraction",
      self.social_attraction,
      Range{0.0, 4.0},
      "attraction to the best point that its neighbours have seen");
    v("neighbours",
      self.neighbours,
      Range{2.0, 1e6},
      "number of neighbours of a particle on a ring");
    v("maximum_velocity",
      self.maximum_velocity,
      Range{1e-6, 1.0},
      "largest velocity, as a share of the width of the box per iteration");
  }
};

/// Every parameter needs a finite box. Defined in pagmo_adapter.cc.
[[nodiscard]] OptimizationSummary MinimizeParticleSwarm(const OptimizationProblem& problem,
                                                        const Eigen::VectorXd& start,
                                                        const ParticleSwarmOptions& options = {},
                                                        const SearchContext& context = {});

}  // namespace lipoid
