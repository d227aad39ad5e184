#include "identify/stages/open_circuit_voltage_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <memory>
#include <span>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "identify/stages/row_factor.h"
#include "model/battery/error_metrics.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Rows under load, in the order of time, and the range that the curve is to span.
struct Points {
  std::span<const double> soc;
  std::span<const double> voltage_V;
  double lo = 0.0;
  double hi = 1.0;

  [[nodiscard]] std::size_t size() const { return soc.size(); }
};

// The rows that a fit is shown: all, or all but every n-th.
struct Share {
  int every = 0;  // 0: all rows are shown

  // The held-out rows.
  [[nodiscard]] std::size_t first() const { return static_cast<std::size_t>(every / 2); }
  [[nodiscard]] std::size_t step() const { return static_cast<std::size_t>(every); }

  [[nodiscard]] bool Has(std::size_t row) const { return every == 0 || row % step() != first(); }
};

// Node positions that share out the length of the curve. Its length is measured on averages over
// equal shares of charge: noise would make a dense log as long as one likes.
std::vector<double> PlaceNodes(const Points& points, int count) {
  const double lo = points.lo;
  const double hi = points.hi;
  if (!(hi > lo)) return {lo, hi};  // an alpha beside which nothing was delivered
  const auto bins = static_cast<std::size_t>(
      std::clamp<std::size_t>(points.size() / 4, 2, 10 * static_cast<std::size_t>(count)));
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
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto bin =
        std::min(bins - 1, static_cast<std::size_t>((points.soc[k] - lo) * bins_per_soc));
    if (bin != open) close(bin);
    open_V += points.voltage_V[k];
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

// Least squares over the values at the nodes, straight lines between them: a tridiagonal system,
// summed over rows.
struct NodeSums {
  double middle_V = 0.0;  // what the sums are taken about: near zero squares keep more digits
  std::vector<double> diagonal, beside, right;  // entry k of beside couples k and k+1
  std::vector<double> rows;                     // in the interval above each node

  explicit NodeSums(std::size_t nodes)
      : diagonal(nodes, 0.0), beside(nodes, 0.0), right(nodes, 0.0), rows(nodes, 0.0) {}

  // Rows of the interval above one node, before they are added.
  struct Interval {
    double lower_lower = 0.0, lower_upper = 0.0, upper_upper = 0.0;
    double lower_V = 0.0, upper_V = 0.0, rows = 0.0;
  };

  void Add(std::size_t j, const Interval& interval) {
    diagonal[j] += interval.lower_lower;
    diagonal[j + 1] += interval.upper_upper;
    beside[j] += interval.lower_upper;
    right[j] += interval.lower_V;
    right[j + 1] += interval.upper_V;
    rows[j] += interval.rows;
  }

  void Add(const NodeSums& other, double factor) {
    middle_V = other.middle_V;
    for (std::size_t k = 0; k < diagonal.size(); ++k) {
      diagonal[k] += factor * other.diagonal[k];
      beside[k] += factor * other.beside[k];
      right[k] += factor * other.right[k];
      rows[k] += factor * other.rows[k];
    }
  }

  // Thomas' elimination; the matrix is positive definite because every interval holds a row.
  [[nodiscard]] std::vector<double> Solve() const {
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
};

// Of every step-th row. In pieces of a fixed size, joined in order: the same bits with any number
// of threads.
NodeSums SumRows(const std::vector<double>& nodes,
                 const Points& points,
                 std::size_t from,
                 std::size_t step) {
  constexpr std::size_t kPiece = 1 << 16;
  const std::size_t n = nodes.size();
  const std::size_t count = from < points.size() ? (points.size() - from - 1) / step + 1 : 0;
  const double middle_V = 0.5 * (points.voltage_V.front() + points.voltage_V.back());
  std::vector<double> inverse(n - 1);
  for (std::size_t j = 0; j + 1 < n; ++j) inverse[j] = 1.0 / (nodes[j + 1] - nodes[j]);
  std::vector<NodeSums> pieces((count + kPiece - 1) / kPiece, NodeSums(n));
  StopIfAsked();
  ParallelFor(pieces.size(), [&](std::size_t p) {
    NodeSums& sums = pieces[p];
    std::size_t j = n - 2;
    NodeSums::Interval open;
    const std::size_t end = std::min(count, (p + 1) * kPiece);
    for (std::size_t m = p * kPiece; m < end; ++m) {
      const std::size_t k = from + m * step;
      const double soc = points.soc[k];
      if ((j > 0 && soc < nodes[j]) || (j + 2 < n && soc >= nodes[j + 1])) {
        sums.Add(j, open);
        open = {};
        while (j > 0 && soc < nodes[j]) --j;
        while (j + 2 < n && soc >= nodes[j + 1]) ++j;
      }
      const double upper = (soc - nodes[j]) * inverse[j];
      const double lower = 1.0 - upper;
      const double v = points.voltage_V[k] - middle_V;
      open.lower_lower += lower * lower;
      open.upper_upper += upper * upper;
      open.lower_upper += lower * upper;
      open.lower_V += lower * v;
      open.upper_V += upper * v;
      open.rows += 1.0;
    }
    sums.Add(j, open);
  });
  NodeSums all(n);
  for (const NodeSums& piece : pieces) all.Add(piece, 1.0);
  all.middle_V = middle_V;
  return all;
}

NodeSums SumShare(const std::vector<double>& nodes, const Points& points, const Share& share) {
  NodeSums sums = SumRows(nodes, points, 0, 1);
  if (share.every > 0) sums.Add(SumRows(nodes, points, share.first(), share.step()), -1.0);
  return sums;
}

// Nodes with the sums of every row and of those to be left out: either fit follows from them.
struct NodeTask {
  std::vector<double> nodes;
  NodeSums all{0};
  NodeSums left_out{0};

  [[nodiscard]] NodeSums Sums(const Share& shown) const {
    NodeSums sums = all;
    if (shown.every > 0) sums.Add(left_out, -1.0);
    return sums;
  }
};

NodeTask MakeNodeTask(std::vector<double> nodes, const Points& points, const Share& judged) {
  NodeSums all = SumRows(nodes, points, 0, 1);
  NodeSums left_out = SumRows(nodes, points, judged.first(), judged.step());
  return {std::move(nodes), std::move(all), std::move(left_out)};
}

// Values at the nodes. Nodes between which no row lies leave the system singular: they are dropped,
// and fewer than four are none.
std::vector<double> FitNodes(std::vector<double>& nodes,
                             NodeSums sums,
                             const Points& points,
                             const Share& shown) {
  while (nodes.size() >= 4) {
    std::vector<double> kept{nodes.front()};
    for (std::size_t k = 1; k + 1 < nodes.size(); ++k) {
      if (sums.rows[k - 1] > 0.0 && sums.rows[k] > 0.0) kept.push_back(nodes[k]);
    }
    kept.push_back(nodes.back());
    if (kept.size() == nodes.size()) return sums.Solve();
    nodes = std::move(kept);
    sums = SumShare(nodes, points, shown);
  }
  nodes.clear();
  return {};
}

// Few rows are joined as they are. Rising states of charge; the row nearest the full end is carried
// on to where the log started, along the slope of its neighbours.
void TakeRows(const Points& points,
              const Share& share,
              std::vector<double>& nodes,
              std::vector<double>& values) {
  std::vector<std::pair<double, double>> rows;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (share.Has(k)) rows.emplace_back(points.soc[k], points.voltage_V[k]);
  }
  std::sort(rows.begin(), rows.end());
  for (const auto& [soc, voltage_V] : rows) {
    if (!nodes.empty() && !(soc > nodes.back())) continue;
    nodes.push_back(soc);
    values.push_back(voltage_V);
  }
  const std::size_t n = nodes.size();
  if (nodes.back() < points.hi && n > 1) {
    const std::size_t neighbour = n - 1 - std::min<std::size_t>(n - 1, 10);
    const double slope = (values.back() - values[neighbour]) / (nodes.back() - nodes[neighbour]);
    values.push_back(values.back() + slope * (points.hi - nodes.back()));
    nodes.push_back(points.hi);
  }
}

// The nearest values that do not fall with soc (pool adjacent violators): noise must not make a
// curve that is to be monotone go back.
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

// The mean of neighbouring rows, and how many there were. A smooth curve of a few dozen
// coefficients is straight to 1e-6 V over a ten-thousandth of its range, so nothing is lost and
// millions of rows are few.
struct WeightedPoint {
  double soc, voltage_V, weight;
};

std::vector<WeightedPoint> Compress(const Points& points, const Share& share) {
  constexpr std::size_t kMost = 10000;
  const std::size_t group = std::max<std::size_t>(1, points.size() / kMost);
  std::vector<WeightedPoint> means;
  for (std::size_t first = 0; first < points.size(); first += group) {
    WeightedPoint sum{0.0, 0.0, 0.0};
    for (std::size_t k = first; k < std::min(points.size(), first + group); ++k) {
      if (!share.Has(k)) continue;
      sum.soc += points.soc[k];
      sum.voltage_V += points.voltage_V[k];
      sum.weight += 1.0;
    }
    if (sum.weight > 0.0)
      means.push_back({sum.soc / sum.weight, sum.voltage_V / sum.weight, sum.weight});
  }
  return means;
}

// Least squares over the coefficients of `columns` basis functions; norm receives ||residual||.
template <class Basis>
Eigen::VectorXd FitBasis(const std::vector<WeightedPoint>& points,
                         int columns,
                         Basis&& basis,
                         double* norm) {
  RowFactor rows(columns + 1);
  Eigen::VectorXd values(columns);
  for (const WeightedPoint& point : points) {
    basis(point.soc, values);
    const double weight = std::sqrt(point.weight);
    double* row = rows.NextRow();
    for (int j = 0; j < columns; ++j) row[j * rows.stride()] = weight * values[j];
    row[columns * rows.stride()] = weight * point.voltage_V;
    rows.Push();
  }
  const Eigen::MatrixXd factor = rows.Factor();
  // Harmonics over less than a period are nearly dependent: the smallest solution is the tame one.
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-12);
  solver.compute(factor.topLeftCorner(columns, columns));
  const Eigen::VectorXd right = factor.topRightCorner(columns, 1);
  Eigen::VectorXd solution = solver.solve(right);
  if (norm != nullptr) {
    *norm = std::hypot((factor.topLeftCorner(columns, columns) * solution - right).norm(),
                       factor(columns, columns));
  }
  return solution;
}

OpenCircuitVoltage FitPolynomial(const std::vector<WeightedPoint>& points,
                                 int degree,
                                 double lo,
                                 double hi) {
  const auto chebyshev = [&](double soc, Eigen::VectorXd& t) {
    const double x = (2.0 * soc - lo - hi) / (hi - lo);
    t[0] = 1.0;
    t[1] = x;
    for (int k = 2; k <= degree; ++k) t[k] = 2.0 * x * t[k - 1] - t[k - 2];
  };
  const Eigen::VectorXd c = FitBasis(points, degree + 1, chebyshev, nullptr);
  return OpenCircuitVoltage::Polynomial(lo, hi, {c.begin(), c.end()});
}

// The frequency is the only nonlinear unknown: a grid finds its valley, Brent's method the bottom.
OpenCircuitVoltage FitFourier(const std::vector<WeightedPoint>& points,
                              int harmonics,
                              double lo,
                              double hi) {
  const int columns = 2 * harmonics + 1;
  const auto solve = [&](double frequency, double* norm) {
    const auto basis = [&](double soc, Eigen::VectorXd& values) {
      values[0] = 1.0;
      const double c1 = std::cos(frequency * soc);
      const double s1 = std::sin(frequency * soc);
      double c = 1.0;
      double s = 0.0;
      for (int k = 1; k <= harmonics; ++k) {
        const double next = c * c1 - s * s1;
        s = s * c1 + c * s1;
        c = next;
        values[Eigen::Index{2} * k - 1] = c;
        values[Eigen::Index{2} * k] = s;
      }
    };
    return FitBasis(points, columns, basis, norm);
  };
  const auto cost = [&](double frequency) {
    double norm = 0.0;
    static_cast<void>(solve(frequency, &norm));
    return norm;
  };
  constexpr double kPi = 3.14159265358979323846;
  constexpr int kGrid = 12;
  const double least = 0.5 * kPi / (hi - lo);  // a quarter of a period over the range
  const double most = 2.0 * kPi / (hi - lo);   // one period
  const double step = (most - least) / kGrid;
  int best = 0;
  double best_cost = cost(least);
  for (int k = 1; k <= kGrid; ++k) {
    const double here = cost(least + k * step);
    if (here < best_cost) {
      best_cost = here;
      best = k;
    }
  }
  const auto [frequency, unused] =
      boost::math::tools::brent_find_minima(cost,
                                            std::max(least, least + (best - 1) * step),
                                            std::min(most, least + (best + 1) * step),
                                            16);
  static_cast<void>(unused);
  const Eigen::VectorXd solution = solve(frequency, nullptr);
  std::vector<double> cosine{solution[0]};
  std::vector<double> sine;
  for (int k = 1; k <= harmonics; ++k) {
    cosine.push_back(solution[Eigen::Index{2} * k - 1]);
    sine.push_back(solution[Eigen::Index{2} * k]);
  }
  return OpenCircuitVoltage::Fourier(lo, hi, frequency, std::move(cosine), std::move(sine));
}

bool HasNodes(const Points& points, const OcvFitOptions& options) {
  const bool joins =
      options.method == OcvMethod::kLinear || options.method == OcvMethod::kMonotoneCubic;
  return joins && points.size() > static_cast<std::size_t>(options.interpolate_up_to);
}

OpenCircuitVoltage FitCurve(const Points& points,
                            const Share& share,
                            const NodeTask& task,
                            const OcvFitOptions& options) {
  switch (options.method) {
    case OcvMethod::kPolynomial:
      return FitPolynomial(Compress(points, share), options.degree, points.lo, points.hi);
    case OcvMethod::kFourier:
      return FitFourier(Compress(points, share), options.harmonics, points.lo, points.hi);
    case OcvMethod::kLinear:
    case OcvMethod::kMonotoneCubic:
      break;
  }
  std::vector<double> nodes = task.nodes;
  std::vector<double> values;
  if (!nodes.empty()) values = FitNodes(nodes, task.Sums(share), points, share);
  if (nodes.empty()) TakeRows(points, share, nodes, values);
  if (options.method == OcvMethod::kLinear) {
    return OpenCircuitVoltage::Linear(std::move(nodes), std::move(values));
  }
  MakeMonotone(values);
  return OpenCircuitVoltage::MonotoneCubic(std::move(nodes), std::move(values));
}

// The state of charge of every row, by counting.
struct ChargeCount {
  std::unique_ptr<double[]> soc;
  double most_C = 0.0;  // that left at any time
};

// In pieces, side by side, once it is known what left before each.
ChargeCount CountedSoc(const Record& record, double alpha_C, double initial_soc) {
  constexpr std::size_t kPiece = 1 << 16;
  ChargeCount counted{std::make_unique_for_overwrite<double[]>(record.size())};
  if (record.size() > 0) counted.soc[0] = initial_soc;
  if (record.size() < 2) return counted;
  const std::size_t last = record.size() - 1;
  const std::size_t pieces = (last + kPiece - 1) / kPiece;
  std::vector<ChargeMoved> moved(pieces);
  const auto end = [&](std::size_t p) { return std::min(last, (p + 1) * kPiece); };
  ParallelFor(pieces, [&](std::size_t p) { moved[p] = CountCharge(record, p * kPiece, end(p)); });
  std::vector<ChargeMoved> before(pieces);
  for (std::size_t p = 1; p < pieces; ++p) {
    before[p] = before[p - 1];
    before[p].Append(moved[p - 1]);
  }
  const std::size_t back = record.hold == Hold::kBackward ? 0 : 1;
  ParallelFor(pieces, [&](std::size_t p) {
    double charge_C = before[p].charge_C;
    for (std::size_t k = p * kPiece + 1; k <= end(p); ++k) {
      charge_C += record.current_A[k - back] * (record.time_s[k] - record.time_s[k - 1]);
      counted.soc[k] = initial_soc - charge_C / alpha_C;  // (4.59)
    }
  });
  before.back().Append(moved.back());
  counted.most_C = before.back().most_C;
  return counted;
}

struct RowsUnderLoad {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t count = 0;  // less than end - first where rests stand between them
};

RowsUnderLoad FindRowsUnderLoad(const Record& record, double rest_A) {
  const auto loaded = [&](double current_A) { return current_A > rest_A; };
  const auto& current_A = record.current_A;
  const auto first = std::find_if(current_A.begin(), current_A.end(), loaded);
  const auto end = std::find_if(current_A.rbegin(), current_A.rend(), loaded).base();
  if (first == current_A.end()) return {};
  return {.first = static_cast<std::size_t>(first - current_A.begin()),
          .end = static_cast<std::size_t>(end - current_A.begin()),
          .count = static_cast<std::size_t>(std::count_if(first, end, loaded))};
}

}  // namespace

OcvFitResult FitOpenCircuitVoltage(const Record& record,
                                   double alpha_C,
                                   double initial_soc,
                                   const OcvFitOptions& options) {
  Require(alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", alpha_C}});
  const double rest_A = RestThreshold(record);
  OcvFitResult result;
  ChargeCount counted = CountedSoc(record, alpha_C, initial_soc);
  result.charge_C = counted.most_C;
  const RowsUnderLoad loaded = FindRowsUnderLoad(record, rest_A);
  Points points;
  std::vector<double> gathered_V;
  if (loaded.count == loaded.end - loaded.first) {
    points.soc = {counted.soc.get() + loaded.first, loaded.count};
    points.voltage_V = std::span(record.voltage_V).subspan(loaded.first, loaded.count);
  } else {  // rests stand between them
    gathered_V.reserve(loaded.count);
    for (std::size_t k = loaded.first; k < loaded.end; ++k) {
      if (record.current_A[k] <= rest_A) continue;
      counted.soc[gathered_V.size()] = counted.soc[k];
      gathered_V.push_back(record.voltage_V[k]);
    }
    points.soc = {counted.soc.get(), gathered_V.size()};
    points.voltage_V = gathered_V;
  }
  const std::size_t coefficients = options.method == OcvMethod::kPolynomial ? options.degree + 1
                                   : options.method == OcvMethod::kFourier
                                       ? 2 * options.harmonics + 1
                                       : 4;
  if (points.size() < 3 * coefficients) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected at least {} rows under load for this open-circuit voltage curve, found {}",
            3 * coefficients,
            points.size()));
  }

  // The curve reaches up to where the log started, a row above the first one under load.
  const Extent reached = FindExtent(points.soc);
  points.lo = reached.least;
  points.hi = std::max(initial_soc, reached.most);

  const Share shown{options.leave_out_every};
  NodeTask task;
  if (HasNodes(points, options)) {
    const int count =
        std::clamp(options.knots, 4, std::max(4, static_cast<int>(points.size() / 3)));
    task = MakeNodeTask(PlaceNodes(points, count), points, shown);
  }
  const OpenCircuitVoltage judged = FitCurve(points, shown, task, options);
  ErrorAccumulator errors;
  for (std::size_t k = shown.first(); k < points.size();
       k += std::max<std::size_t>(shown.step(), 1))
    errors.Add(points.voltage_V[k], judged(points.soc[k]));
  result.mean_error_percent = errors.Result().mean_error_percent;
  result.max_error_percent = errors.Result().max_error_percent;
  result.rmse_V = errors.Result().rmse;
  result.curve = FitCurve(points, {}, task, options);
  result.rows = points.size();
  // The median load, of rows enough.
  constexpr std::size_t kSamples = 1 << 16;
  std::vector<double> loads;
  const std::size_t stride = points.size() / kSamples + 1;
  loads.reserve(points.size() / stride + 1);
  for (std::size_t k = loaded.first; k < loaded.end; k += stride) {
    if (record.current_A[k] > rest_A) loads.push_back(record.current_A[k]);
  }
  result.current_A = UpperMedian(std::move(loads));
  result.soc_lo = result.curve.soc_lo();
  result.soc_hi = result.curve.soc_hi();
  return result;
}

}  // namespace lipoid
