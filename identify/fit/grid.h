#pragma once

/// @file
/// Where a search of the nonlinear parameters begins: points in equal ratios, and every way to choose
/// some of them in rising order, for branches that differ by their time constants alone.
/// Tests: tests/identify/fit/grid_test.cc.

#include <cmath>
#include <cstddef>
#include <vector>

namespace lipoid {

/// `points` >= 1 values in equal ratios from lower > 0 to upper, ends included; one: the middle.
inline std::vector<double> GeometricGrid(double lower, double upper, int points) {
  std::vector<double> grid;
  for (int k = 0; k < points; ++k) {
    const double share = points == 1 ? 0.5 : static_cast<double>(k) / (points - 1);
    grid.push_back(lower * std::pow(upper / lower, share));
  }
  return grid;
}

/// Every choice of `count` entries of the grid, in the order of the grid; one empty choice for 0.
inline std::vector<std::vector<double>> Choices(const std::vector<double>& grid, int count) {
  std::vector<std::vector<double>> all;
  std::vector<double> chosen;
  const auto choose = [&](auto&& self, std::size_t from) -> void {
    if (static_cast<int>(chosen.size()) == count) {
      all.push_back(chosen);
      return;
    }
    for (std::size_t k = from; k < grid.size(); ++k) {
      chosen.push_back(grid[k]);
      self(self, k + 1);
      chosen.pop_back();
    }
  };
  choose(choose, 0);
  return all;
}

}  // namespace lipoid
