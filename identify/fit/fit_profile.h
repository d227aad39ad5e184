#pragma once

/// @file
/// Profiles of the parameters of a fit: each is held at values around its estimate, and everything
/// else is refitted. beta, tau_j, tau_h, i_0; r_s and r_j where they are one number, and then c_j.
/// Tests: tests/identify/stages/staged_profile_test.cc, tests/identify/joint/joint_profile_test.cc.

#include <functional>
#include <string>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/trust/profile.h"

namespace lipoid {

/// What profiles can be had of, and what was given or follows from what was. tau_j and c_j are one
/// unknown seen twice: where either is given, or kept within bounds, the other cannot be held
/// beside it.
struct Profiled {
  std::vector<std::string> free;
  std::vector<std::string> fixed;
  std::vector<std::string> tables;  ///< no single value to hold
};
[[nodiscard]] Profiled ProfiledNames(const JointStructure& structure,
                                     bool diffusion,
                                     bool capacitances,
                                     const GivenParameters& known);

/// What is profiled. References must outlive it.
struct ProfiledFit {
  const Observations& seen;
  const JointSolution& solution;
  GivenParameters known;  ///< what the fit was given
  FitScales scales;
  double typical_Ohm = 0.0;  ///< how far a resistance at zero may go
  /// From a start nearby to the least cost, of a fit with one parameter more held.
  std::function<JointSolution(const JointFit&, JointSolution)> refit;
};

/// `names` are among the free ones.
[[nodiscard]] std::vector<Profile> ProfileFit(const std::vector<std::string>& names,
                                              const ProfiledFit& fit,
                                              const TrustReport& trust);

}  // namespace lipoid
