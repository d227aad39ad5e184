#pragma once

/// @file
/// The terms that a structure may have, each with its words, and the nonlinear unknowns of a
/// structure, each with its name, its range and where its search begins. Whoever reports, profiles or
/// searches asks here, and knows no term by name. Tests: tests/identify/joint/joint_terms_test.cc.

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "identify/fit/observations.h"
#include "identify/joint/joint_model.h"

namespace lipoid {

struct JointTerm {
  std::string_view key;    ///< in --summary
  std::string_view words;  ///< in the table of what was tried
  bool (*present)(const JointStructure&);
};

/// In the order in which they are reported.
[[nodiscard]] const std::vector<JointTerm>& JointTerms();

/// A nonlinear unknown. It is searched within its bounds, in a coordinate of which steps of one size
/// matter as much as those of any other: its logarithm, or the value itself, in some unit.
struct JointRate {
  std::string name;
  double lower, upper;
  double* (*entry)(JointRates&, int);
  int index = 0;  ///< among those of its kind
  int slot = 0;   ///< in RateSlots
  double start;
  bool logarithm = true;
  double unit = 1.0;
  /// Of a logarithm the value at the coordinate 0: searches take a step as small beside the size of all coordinates,
  /// which one of a small unit and far from 0 would make large.
  double origin = 1.0;
  /// Where a search begins of whose neighbour it is not known; empty: at the start alone.
  std::vector<double> grid = {};
  /// The parameters of the cell that it is; empty: the one of its name.
  std::vector<std::string> means = {};

  [[nodiscard]] double& In(JointRates& rates) const { return *entry(rates, index); }
  [[nodiscard]] double Coordinate(double value) const {
    return (logarithm ? std::log(value / origin) : value) / unit;
  }
  [[nodiscard]] double Value(double coordinate) const {
    return logarithm ? origin * std::exp(coordinate * unit) : coordinate * unit;
  }
  /// Slope of the value in the coordinate.
  [[nodiscard]] double Slope(double value) const { return logarithm ? value * unit : unit; }
};

/// Linear unknowns beside v_oc and the resistances: one number, or one for each node over the state of
/// charge. They are smoothed and reported as they stand here.
struct JointTable {
  std::string name;  ///< of the cell's parameter; empty: not reported
  std::string unit;
  int first = 0;            ///< in JointLayout
  std::vector<double> soc;  ///< nodes; one: a number
  double scale = 1.0;       ///< the parameter for each volt of an unknown
};
[[nodiscard]] std::vector<JointTable> OtherTables(const JointStructure& structure,
                                                  double typical_A);

/// The activation energies that such a structure has, E_d, E_s, E_1 .. E_n, E_ct, and of these the ones
/// that are one number.
[[nodiscard]] std::vector<std::string> SharedEnergyNames(const JointStructure& structure,
                                                         bool diffusion);

/// All of a structure, in the order of RateSlots; of a setup without diffusion neither beta nor E_d.
[[nodiscard]] std::vector<JointRate> AllRates(const JointStructure& structure,
                                              const JointSetup& setup,
                                              const FitScales& scales);

}  // namespace lipoid
