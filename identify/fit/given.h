#pragma once

/// @file
/// What the user knows of the parameters of a fit: some are held, some start somewhere, some stay
/// within bounds. Every method takes this and every method checks it by the same rules, which are
/// those of the table of parameters (model/battery/cell_parameters.h): what passes makes a cell
/// that a cell file may hold. Tests: tests/identify/fit/given_test.cc.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lipoid {

/// Values by name: beta, r_s, r_1, c_1, tau_1, r_2, ... in SI units; bounds as {low, high}.
struct GivenParameters {
  std::map<std::string, double> fixed = {};
  std::map<std::string, double> start = {};
  std::map<std::string, std::pair<double, double>> bounds = {};

  [[nodiscard]] std::optional<double> Fixed(const std::string& name) const;
  [[nodiscard]] std::optional<double> Start(const std::string& name) const;
  [[nodiscard]] std::optional<std::pair<double, double>> Bounds(const std::string& name) const;
  /// What is fixed lies between that and that; none where the name is free.
  [[nodiscard]] std::optional<std::pair<double, double>> Range(const std::string& name) const;
  [[nodiscard]] bool Mentions(const std::string& name) const;
  /// Whether any branch is mentioned: branches then keep the numbers that the user gave them.
  [[nodiscard]] bool NamesABranch() const;
};

/// The parameters of a fit with so many branches: beta (with diffusion), r_s, r_j, tau_j, c_j.
[[nodiscard]] std::vector<std::string> FitParameterNames(bool diffusion, int branches);

/// Throws OptionError for a name that is not among `names`, a value or bounds outside the range of
/// the parameter, bounds upside down, a held value or a start outside its bounds, a start of what is
/// held, and for tau_j and c_j of one branch together, since either follows from the other.
void CheckGiven(const GivenParameters& given, const std::vector<std::string>& names);

}  // namespace lipoid
