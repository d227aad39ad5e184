#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/stages/curve_forms.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"

namespace lipoid {
namespace {

// Node positions that share out the length of the curve. Its length is measured on averages over
// equal shares of charge: noise would make a dense log as long as one likes.
std::vector<double> PlaceNodes(const CurveRows& rows, int count) {
  const double lo = rows.lo;
  const double hi = rows.hi;
  if (!(hi > lo)) return {lo, hi};  // an alpha beside which nothing was delivered
  const auto bins = static_cast<std::size_t>(
      std::clamp<std::size_t>(rows.size() / 4, 2, 10 * static_cast<std::size_t>(count)));
  std::vector<double> sum(bins, 0.0);
  std::vector<double> members(bins, 0.0);
  const double bins_per_soc = static_cast<double>(bins) / (hi - lo);
  // Neighbours mostly share a bin: they are summed before they are added to it.
  std::size_t open = 0;
  double open_V = 0.0;
  double open_members = 0.0;
  const auto close = [&](std::size_t next) {
    sum[open] += open_V;
    members[open] += open_members;
    open = next;
    open_V = open_members = 0.0;
  };
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto bin =
        std::min(bins - 1, static_cast<std::size_t>((rows.soc[k] - lo) * bins_per_soc));
    if (bin != open) close(bin);
    open_V += rows.voltage_V[k];
    open_members += 1.0;
  }
  close(0);
  const double width = (hi - lo) / static_cast<double>(bins);
  std::vector<double> at;
  std::vector<double> level;
  for (std::size_t b = 0; b < bins; ++b) {
    if (members[b] == 0.0) continue;
    at.push_back(lo + (static_cast<double>(b) + 0.5) * width);
    level.push_back(sum[b] / members[b]);
  }
  if (at.size() < 2) return {lo, hi};  // all rows stand together
  const auto [lowest, highest] = std::minmax_element(level.begin(), level.end());
  const double scale = *highest > *lowest ? (hi - lo) / (*highest - *lowest) : 0.0;
  std::vector<double> length(at.size(), 0.0);
  for (std::size_t b = 1; b < at.size(); ++b) {
    length[b] = length[b - 1] + (at[b] - at[b - 1]) + scale * std::abs(level[b] - level[b - 1]);
  }
  std::vector<double> nodes{lo};
  std::size_t b = 1;
  for (int k = 1; k + 1 < count; ++k) {
    const double wanted = length.back() * k / (count - 1);
    while (b + 1 < length.size() && length[b] < wanted) ++b;
    const double share = (wanted - length[b - 1]) / (length[b] - length[b - 1]);
    const double soc = at[b - 1] + share * (at[b] - at[b - 1]);
    if (soc > nodes.back() + 1e-9 * (hi - lo) && soc < hi) nodes.push_back(soc);
  }
  nodes.push_back(hi);
  return nodes;
}

// Rows of the interval above one node, before they are added.
struct Interval {
  double lower_lower = 0.0, lower_upper = 0.0, upper_upper = 0.0;
  double lower_V = 0.0, upper_V = 0.0, rows = 0.0;
};

void Add(NodeSums& sums, std::size_t j, const Interval& interval) {
  sums.diagonal[j] += interval.lower_lower;
  sums.diagonal[j + 1] += interval.upper_upper;
  sums.beside[j] += interval.lower_upper;
  sums.right[j] += interval.lower_V;
  sums.right[j + 1] += interval.upper_V;
  sums.rows[j] += interval.rows;
}

// Of every step-th row. In pieces of a fixed size, joined in order: the same bits with any number
// of threads.
NodeSums SumRows(const std::vector<double>& nodes,
                 const CurveRows& rows,
                 std::size_t from,
                 std::size_t step) {
  constexpr std::size_t kPiece = 1 << 16;
  const std::size_t n = nodes.size();
  const std::size_t count = from < rows.size() ? (rows.size() - from - 1) / step + 1 : 0;
  const double middle_V = 0.5 * (rows.voltage_V.front() + rows.voltage_V.back());
  std::vector<double> inverse(n - 1);
  for (std::size_t j = 0; j + 1 < n; ++j) inverse[j] = 1.0 / (nodes[j + 1] - nodes[j]);
  std::vector<NodeSums> pieces((count + kPiece - 1) / kPiece, NodeSums(n));
  StopIfAsked();
  ParallelFor(pieces.size(), [&](std::size_t p) {
    NodeSums& sums = pieces[p];
    std::size_t j = n - 2;
    Interval open;
    const std::size_t end = std::min(count, (p + 1) * kPiece);
    for (std::size_t m = p * kPiece; m < end; ++m) {
      const std::size_t k = from + m * step;
      const double soc = rows.soc[k];
      if ((j > 0 && soc < nodes[j]) || (j + 2 < n && soc >= nodes[j + 1])) {
        Add(sums, j, open);
        open = {};
        while (j > 0 && soc < nodes[j]) --j;
        while (j + 2 < n && soc >= nodes[j + 1]) ++j;
      }
      const double upper = (soc - nodes[j]) * inverse[j];
      const double lower = 1.0 - upper;
      const double v = rows.voltage_V[k] - middle_V;
      open.lower_lower += lower * lower;
      open.upper_upper += upper * upper;
      open.lower_upper += lower * upper;
      open.lower_V += lower * v;
      open.upper_V += upper * v;
      open.rows += 1.0;
    }
    Add(sums, j, open);
  });
  NodeSums all(n);
  for (const NodeSums& piece : pieces) all.Add(piece, 1.0);
  all.middle_V = middle_V;
  return all;
}

NodeSums SumShare(const std::vector<double>& nodes, const CurveRows& rows, const Share& share) {
  NodeSums sums = SumRows(nodes, rows, 0, 1);
  if (share.every > 0) sums.Add(SumRows(nodes, rows, share.first(), share.step()), -1.0);
  return sums;
}

// Values at the nodes. Nodes between which no row lies leave the system singular: they are dropped,
// and fewer than four are none.
std::vector<double> FitNodes(std::vector<double>& nodes,
                             NodeSums sums,
                             const CurveRows& rows,
                             const Share& shown) {
  while (nodes.size() >= 4) {
    std::vector<double> kept{nodes.front()};
    for (std::size_t k = 1; k + 1 < nodes.size(); ++k) {
      if (sums.rows[k - 1] > 0.0 && sums.rows[k] > 0.0) kept.push_back(nodes[k]);
    }
    kept.push_back(nodes.back());
    if (kept.size() == nodes.size()) return sums.Solve();
    nodes = std::move(kept);
    sums = SumShare(nodes, rows, shown);
  }
  nodes.clear();
  return {};
}

// Few rows are joined as they are. Rising states of charge; the row nearest the full end is carried
// on to where the log started, along the slope of its neighbours.
void TakeRows(const CurveRows& rows,
              const Share& share,
              std::vector<double>& nodes,
              std::vector<double>& values) {
  std::vector<std::pair<double, double>> taken;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (share.Has(k)) taken.emplace_back(rows.soc[k], rows.voltage_V[k]);
  }
  std::sort(taken.begin(), taken.end());
  for (const auto& [soc, voltage_V] : taken) {
    if (!nodes.empty() && !(soc > nodes.back())) continue;
    nodes.push_back(soc);
    values.push_back(voltage_V);
  }
  const std::size_t n = nodes.size();
  if (nodes.back() < rows.hi && n > 1) {
    const std::size_t neighbour = n - 1 - std::min<std::size_t>(n - 1, 10);
    const double slope = (values.back() - values[neighbour]) / (nodes.back() - nodes[neighbour]);
    values.push_back(values.back() + slope * (rows.hi - nodes.back()));
    nodes.push_back(rows.hi);
  }
}

}  // namespace

void NodeSums::Add(const NodeSums& other, double factor) {
  middle_V = other.middle_V;
  for (std::size_t k = 0; k < diagonal.size(); ++k) {
    diagonal[k] += factor * other.diagonal[k];
    beside[k] += factor * other.beside[k];
    right[k] += factor * other.right[k];
    rows[k] += factor * other.rows[k];
  }
}

// Thomas' elimination; the matrix is positive definite because every interval holds a row.
std::vector<double> NodeSums::Solve() const {
  const std::size_t n = diagonal.size();
  auto pivot = diagonal;
  auto value = right;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double factor = beside[k] / pivot[k];
    pivot[k + 1] -= factor * beside[k];
    value[k + 1] -= factor * value[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    value[k] = (value[k] - (k + 1 < n ? beside[k] * value[k + 1] : 0.0)) / pivot[k];
  }
  for (double& v : value) v += middle_V;
  return value;
}

NodeTask MakeNodeTask(const CurveRows& rows, int count, const Share& judged) {
  std::vector<double> nodes = PlaceNodes(rows, count);
  NodeSums all = SumRows(nodes, rows, 0, 1);
  NodeSums left_out = SumRows(nodes, rows, judged.first(), judged.step());
  return {std::move(nodes), std::move(all), std::move(left_out)};
}

CurveNodes FitOnNodes(const NodeTask& task, const CurveRows& rows, const Share& shown) {
  CurveNodes curve{.soc = task.nodes, .voltage_V = {}};
  if (!curve.soc.empty()) {
    NodeSums sums = task.all;
    if (shown.every > 0) sums.Add(task.left_out, -1.0);
    curve.voltage_V = FitNodes(curve.soc, std::move(sums), rows, shown);
  }
  if (curve.soc.empty()) TakeRows(rows, shown, curve.soc, curve.voltage_V);
  return curve;
}

void MakeMonotone(std::vector<double>& values) {
  struct Pool {
    double mean;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (const double v : values) {
    pools.push_back({v, 1});
    while (pools.size() > 1 && pools[pools.size() - 2].mean > pools.back().mean) {
      const Pool last = pools.back();
      pools.pop_back();
      Pool& into = pools.back();
      const auto count = into.count + last.count;
      into.mean +=
          (last.mean - into.mean) * static_cast<double>(last.count) / static_cast<double>(count);
      into.count = count;
    }
  }
  std::size_t k = 0;
  for (const Pool& pool : pools) {
    for (std::size_t member = 0; member < pool.count; ++member) values[k++] = pool.mean;
  }
}

}  // namespace lipoid
