#pragma once

/// @file
/// How far the voltage falls after a step of the current, as a log shows it and as a cell predicts it.
///
///   R(t) = (v_b(before) - v_b(t after the step)) / (i(after) - i(before))
///
/// after 1, 10 and 30 s: what a pulse test measures. The error of a fit over all rows hardly sees it,
/// for few rows lie near an edge. Both are taken at the same rows, so that sampling and hold are the
/// same for both. Tests: tests/identify/trust/edges_test.cc.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "model/core/json.h"

namespace lipoid {

/// Times after a step, in s.
inline constexpr std::array<double, 3> kAfterEdge_s{1.0, 10.0, 30.0};

/// One step, at one of those times after it.
struct Edge {
  double soc = 0.0;      ///< of the cell before the step
  double after_s = 0.0;  ///< of kAfterEdge_s; the row is within a third of it
  double measured_Ohm = 0.0;
  double predicted_Ohm = 0.0;
  std::size_t step = 0;  ///< of the log
};

/// Finds the steps between levels that are held, as rows come. Of a log of any length it keeps at most
/// kMostEdges, of steps that are evenly spread: every third one, or ninth, and so on.
inline constexpr std::size_t kMostEdges = 30'000;
class EdgeFinder {
 public:
  /// A row of a log, of a cell or of its pack, discharge positive. `soc` is that of the cell.
  void Add(double time_s, double current_A, double measured_V, double predicted_V, double soc);

  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }

 private:
  struct Row {
    double time_s = 0.0;
    double measured_V = 0.0;
    double predicted_V = 0.0;
    double soc = 0.0;
  };

  void TakeAfter(const Row& row);
  void Thin();

  std::vector<Edge> edges_;
  double largest_A_ = 0.0;
  double level_A_ = 0.0;
  std::optional<Row> last_;  // none before the first
  double began_s_ = 0.0;
  double held_since_s_ = 0.0;
  std::size_t step_ = 0;       // how many there were
  std::size_t every_ = 1;      // of them is kept
  std::optional<Row> before_;  // of the step to this level; none: the level before was not held
  double before_A_ = 0.0;
  std::size_t next_ = 0;  // of kAfterEdge_s
};

/// What edges at like times and states of charge show: medians.
struct EdgeGroup {
  double after_s = 0.0;
  double low_soc = 0.0;
  double high_soc = 0.0;
  std::size_t edges = 0;
  double measured_Ohm = 0.0;
  double predicted_Ohm = 0.0;
  double ratio = 0.0;  ///< of predicted over measured, the median of the edges' own
};

/// By time, then by thirds of the charge above 10 %; groups of fewer than kLeastEdges say nothing.
inline constexpr std::size_t kLeastEdges = 3;
[[nodiscard]] std::vector<EdgeGroup> GroupEdges(const std::vector<Edge>& edges);

/// The group that is furthest off by more than kEdgeLimit (fit_quality.h), as a reason why a fit is no
/// better than fair; "" where none is.
[[nodiscard]] std::string DoubtAboutEdges(const std::vector<EdgeGroup>& groups);

/// The key `edges` of `lipoid identify --summary`.
[[nodiscard]] Json EdgesToJson(const std::vector<EdgeGroup>& groups);

}  // namespace lipoid
