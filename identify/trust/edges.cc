#include "identify/trust/edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/fit_quality.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

constexpr double kHeld_s = 5.0;        // a level before a step
constexpr double kSameLevel = 0.03;    // of the largest current
constexpr double kLeastStep = 0.2;     // of the same
constexpr double kLeastFall_V = 0.01;  // below it a resolution of millivolts is a tenth
constexpr double kNear = 1.0 / 3.0;    // a row stands for a time that is so near

}  // namespace

void EdgeFinder::TakeAfter(const Row& row) {
  const double step_A = level_A_ - before_A_;
  const double after_s = row.time_s - before_->time_s;
  while (next_ < kAfterEdge_s.size() && after_s >= (1.0 - kNear) * kAfterEdge_s[next_]) {
    const double wanted_s = kAfterEdge_s[next_++];
    if (after_s > (1.0 + kNear) * wanted_s) continue;
    const double measured_V = before_->measured_V - row.measured_V;
    const double predicted_V = before_->predicted_V - row.predicted_V;
    // What does not fall by a step of the load tells no resistance: rows out of their order, or noise.
    if (!(measured_V / step_A > 0.0) || std::abs(measured_V) < kLeastFall_V) continue;
    edges_.push_back({before_->soc, wanted_s, measured_V / step_A, predicted_V / step_A, step_});
  }
  if (edges_.size() > kMostEdges) Thin();
}

void EdgeFinder::Thin() {
  every_ *= 3;  // odd: of pulses, switching on and switching off stay
  std::erase_if(edges_, [&](const Edge& edge) { return edge.step % every_ != 0; });
}

void EdgeFinder::Add(
    double time_s, double current_A, double measured_V, double predicted_V, double soc) {
  const Row row{time_s, measured_V, predicted_V, soc};
  const double largest_before_A = largest_A_;
  largest_A_ = std::max(largest_A_, std::abs(current_A));
  if (!last_) {
    level_A_ = current_A;
    held_since_s_ = began_s_ = time_s;
  } else if (std::abs(current_A - level_A_) > kSameLevel * largest_A_) {
    before_.reset();
    // What seemed a step of a rest was noise: nothing was known to be larger.
    if (largest_before_A <= kSameLevel * largest_A_) held_since_s_ = began_s_;
    const bool held = last_->time_s - held_since_s_ >= kHeld_s;
    if (held && std::abs(current_A - level_A_) >= kLeastStep * largest_A_ &&
        ++step_ % every_ == 0) {
      before_ = last_;
      before_A_ = level_A_;
      next_ = 0;
    }
    level_A_ = current_A;
    held_since_s_ = last_->time_s;
  }
  if (before_ && next_ < kAfterEdge_s.size()) TakeAfter(row);
  last_ = row;
}

std::vector<EdgeGroup> GroupEdges(const std::vector<Edge>& edges) {
  constexpr std::array<double, 4> kParts{0.1, 0.4, 0.7, 1.0};
  std::vector<EdgeGroup> groups;
  for (const double after_s : kAfterEdge_s) {
    for (std::size_t k = 0; k + 1 < kParts.size(); ++k) {
      std::vector<double> measured_Ohm;
      std::vector<double> predicted_Ohm;
      std::vector<double> ratios;
      const bool last = k + 2 == kParts.size();
      for (const Edge& edge : edges) {
        if (edge.after_s != after_s || edge.soc < kParts[k]) continue;
        if (!last && edge.soc >= kParts[k + 1]) continue;
        measured_Ohm.push_back(edge.measured_Ohm);
        predicted_Ohm.push_back(edge.predicted_Ohm);
        ratios.push_back(edge.predicted_Ohm / edge.measured_Ohm);
      }
      if (ratios.size() < kLeastEdges) continue;
      groups.push_back({.after_s = after_s,
                        .low_soc = kParts[k],
                        .high_soc = kParts[k + 1],
                        .edges = ratios.size(),
                        .measured_Ohm = Median(measured_Ohm),
                        .predicted_Ohm = Median(predicted_Ohm),
                        .ratio = Median(ratios)});
    }
  }
  return groups;
}

std::string DoubtAboutEdges(const std::vector<EdgeGroup>& groups) {
  const auto off = [](const EdgeGroup& group) { return std::abs(group.ratio - 1.0); };
  const auto worst = std::max_element(
      groups.begin(), groups.end(), [&](const auto& a, const auto& b) { return off(a) < off(b); });
  if (worst == groups.end() || !(off(*worst) > kEdgeLimit)) return "";
  return fmt::format(
      "{:g} s after steps of the current the logs show {:.3g} mOhm and this cell {:.3g} ({:+.0f} % step by step, in the "
      "median of {} steps between {:g} and {:g} % of the charge)",
      worst->after_s,
      1e3 * worst->measured_Ohm,
      1e3 * worst->predicted_Ohm,
      100.0 * (worst->ratio - 1.0),
      worst->edges,
      100.0 * worst->low_soc,
      100.0 * worst->high_soc);
}

Json EdgesToJson(const std::vector<EdgeGroup>& groups) {
  Json rows = Json::array();
  for (const EdgeGroup& group : groups) {
    rows.push_back({{"after_s", group.after_s},
                    {"soc", {group.low_soc, group.high_soc}},
                    {"edges", group.edges},
                    {"measured_Ohm", NumberOrNull(group.measured_Ohm)},
                    {"cell_Ohm", NumberOrNull(group.predicted_Ohm)},
                    {"ratio", NumberOrNull(group.ratio)}});
  }
  return rows;
}

}  // namespace lipoid
