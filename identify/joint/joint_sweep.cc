#include "identify/joint/joint_sweep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/fit/cell_rows.h"

namespace lipoid {
namespace {

// Walks one log and calls sink(point, row) for every point that has a weight. Slopes are those at
// the unknowns x; none where it is null, and then the trace needs none either.
template <class Sink>
void WalkLog(const JointLogs& logs,
             std::size_t l,
             const JointSetup& setup,
             const JointStructure& structure,
             const SocTrace& soc,
             const JointRates& rates,
             const Eigen::VectorXd* x,
             CurveSlope curve,
             Sink&& sink) {
  const JointLog& log = logs.logs[l];
  const LogTrace& trace = soc.logs[l];
  CellRows rows(
      setup, structure, rates, logs.typical_A, x == nullptr ? nullptr : x->data(), curve);
  ModeSteps steps;
  rows.SetSteps(log.interval_s, steps);
  const bool slopes = !trace.at_slope.empty();
  for (std::size_t k = 0; k < log.size(); ++k) {
    if (k > 0) {
      rows.Step(steps,
                static_cast<Eigen::Index>(log.interval[k]),
                log.step_A[k],
                trace.start[k],
                slopes ? trace.start_slope[k] : 0.0);
    }
    if (!(log.weight[k] > 0.0)) continue;
    sink(k,
         rows.MakeRow(
             log.current_A[k], log.voltage_V[k], trace.at[k], slopes ? trace.at_slope[k] : 0.0));
  }
}

// Calls sink(log, point, row) for every point of every log, in their order.
template <class Sink>
void VisitRows(const JointLogs& logs,
               const JointSetup& setup,
               const JointStructure& structure,
               const SocTrace& soc,
               const JointRates& rates,
               Sink&& sink) {
  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    WalkLog(logs,
            l,
            setup,
            structure,
            soc,
            rates,
            nullptr,
            CurveSlope::kOfSegments,
            [&](std::size_t k, const CellRow& row) { sink(l, k, row); });
  }
}

// One sum per log, side by side, then all of them in the order of the logs: the same bits with any
// number of threads.
template <class Sum, class AddRow>
Sum SumOverLogs(const JointLogs& logs,
                const JointSetup& setup,
                const JointStructure& structure,
                const SocTrace& soc,
                const JointRates& rates,
                const Eigen::VectorXd* x,
                CurveSlope curve,
                const Sum& zero,
                AddRow&& add) {
  std::vector<Sum> sums(logs.logs.size(), zero);
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t l) {
    WalkLog(
        logs, l, setup, structure, soc, rates, x, curve, [&](std::size_t k, const CellRow& row) {
          add(sums[l], logs.logs[l].weight[k], row);
        });
  });
  for (std::size_t l = 1; l < sums.size(); ++l) sums[0].Add(sums[l]);
  return sums.empty() ? zero : std::move(sums[0]);
}

void AddRow(NormalEquations& sum, double w, const CellRow& row) {
  sum.weight += w;
  sum.square += w * row.y * row.y;
  for (int b = 0; b < row.entries; ++b) {
    const double wb = w * row.value[b];
    sum.right[row.index[b]] += wb * row.y;
    double* column = sum.matrix.col(row.index[b]).data();
    for (int a = b; a < row.entries; ++a) column[row.index[a]] += wb * row.value[a];
  }
}

}  // namespace

void NormalEquations::Add(const NormalEquations& other, double sign) {
  matrix += sign * other.matrix;
  right += sign * other.right;
  square += sign * other.square;
  weight += sign * other.weight;
}

double NormalEquations::At(const Eigen::VectorXd& x) const {
  return square - 2.0 * right.dot(x) + x.dot(matrix.selfadjointView<Eigen::Lower>() * x);
}

void SlopeSums::Add(const SlopeSums& other) {
  of_rates += other.of_rates;
  with_residual += other.with_residual;
  with_linear += other.with_linear;
}

SocTrace TraceSoc(const JointLogs& logs,
                  const JointSetup& setup,
                  double beta_per_sqrt_s,
                  bool slopes) {
  SocTrace trace;
  trace.logs.resize(logs.logs.size());
  tbb::parallel_for(std::size_t{0}, logs.logs.size(), [&](std::size_t l) {
    const JointLog& log = logs.logs[l];
    LogTrace& out = trace.logs[l];
    SocState state(setup, beta_per_sqrt_s, log.delivered_C, slopes);
    out.at.resize(log.size());
    out.start.resize(log.size());
    out.at_slope.resize(state.slopes() ? log.size() : 0);
    out.start_slope.resize(state.slopes() ? log.size() : 0);
    ModeSteps steps;
    state.SetSteps(log.interval_s, steps);
    for (std::size_t k = 0; k < log.size(); ++k) {
      const double step_A = k > 0 ? log.step_A[k] : 0.0;
      out.start[k] = state.Soc(step_A);
      if (state.slopes()) out.start_slope[k] = state.Slope(step_A);
      if (k > 0) {
        state.Step(steps,
                   static_cast<Eigen::Index>(log.interval[k]),
                   step_A,
                   log.time_s[k] - log.time_s[k - 1]);
      }
      out.at[k] = state.Soc(log.current_A[k]);
      if (state.slopes()) out.at_slope[k] = state.Slope(log.current_A[k]);
    }
  });
  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    for (std::size_t k = 0; k < logs.logs[l].size(); ++k) {
      if (!(logs.logs[l].weight[k] > 0.0)) continue;
      trace.lowest = std::min(trace.lowest, trace.logs[l].at[k]);
      trace.highest = std::max(trace.highest, trace.logs[l].at[k]);
    }
  }
  return trace;
}

std::vector<NormalEquations> SumGroups(const JointLogs& logs,
                                       const JointSetup& setup,
                                       const JointStructure& structure,
                                       const SocTrace& soc,
                                       const JointRates& rates) {
  const int n = JointLayout(structure).size();
  std::vector<NormalEquations> sums(static_cast<std::size_t>(logs.groups) + 1, NormalEquations(n));
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l, std::size_t k, const CellRow& row) {
    const JointLog& log = logs.logs[l];
    const int group = log.group[k] == JointLog::kAlways ? logs.groups : log.group[k];
    AddRow(sums[static_cast<std::size_t>(group)], log.weight[k], row);
  });
  return sums;
}

NormalEquations SumAll(const JointLogs& logs,
                       const JointSetup& setup,
                       const JointStructure& structure,
                       const SocTrace& soc,
                       const JointRates& rates) {
  const NormalEquations zero(JointLayout(structure).size());
  return SumOverLogs(
      logs, setup, structure, soc, rates, nullptr, CurveSlope::kOfSegments, zero, AddRow);
}

SlopeSums SumSlopes(const JointLogs& logs,
                    const JointSetup& setup,
                    const JointStructure& structure,
                    const SocTrace& soc,
                    const JointRates& rates,
                    const Eigen::VectorXd& x,
                    CurveSlope curve) {
  const int p = RateSlots(structure).size();
  const auto n = static_cast<int>(x.size());
  const SlopeSums zero{Eigen::MatrixXd::Zero(p, p), Eigen::VectorXd::Zero(p),
                       Eigen::MatrixXd::Zero(p, n)};
  const auto add = [&x, p](SlopeSums& sum, double w, const CellRow& row) {
    const Eigen::Map<const Eigen::VectorXd> slope(row.slope, p);
    for (int e = 0; e < row.entries; ++e)
      sum.with_linear.col(row.index[e]) += w * row.value[e] * slope;
    sum.of_rates.noalias() += w * slope * slope.transpose();
    sum.with_residual += w * row.Residual(x.data()) * slope;
  };
  return SumOverLogs(logs, setup, structure, soc, rates, &x, curve, zero, add);
}

std::vector<std::vector<double>> SumErrors(
    const JointLogs& logs,
    const JointSetup& setup,
    const JointStructure& structure,
    const SocTrace& soc,
    const JointRates& rates,
    const std::vector<std::vector<Eigen::VectorXd>>& unknowns) {
  std::vector<std::vector<double>> sums(unknowns.empty() ? 0 : unknowns.front().size(),
                                        std::vector<double>(logs.unit_weight.size(), 0.0));
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l,
                                                                    std::size_t k,
                                                                    const CellRow& row) {
    const JointLog& log = logs.logs[l];
    if (log.group[k] == JointLog::kAlways) return;
    const auto& candidates = unknowns[static_cast<std::size_t>(log.group[k])];
    for (std::size_t s = 0; s < sums.size(); ++s) {
      const double error = candidates[s].size() == 0 ? std::numeric_limits<double>::infinity()
                                                     : row.Residual(candidates[s].data());
      sums[s][static_cast<std::size_t>(log.unit[k])] += log.weight[k] * std::abs(error);
    }
  });
  return sums;
}

std::vector<JointRows> AllRows(const JointLogs& logs,
                               const JointSetup& setup,
                               const JointStructure& structure,
                               const JointRates& rates,
                               const Eigen::VectorXd& x,
                               CurveSlope curve) {
  const SocTrace soc = TraceSoc(logs, setup, rates.beta_per_sqrt_s, true);
  const int p = RateSlots(structure).size();
  std::vector<JointRows> all(logs.logs.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t l) {
    const auto& weight = logs.logs[l].weight;
    const auto count =
        std::count_if(weight.begin(), weight.end(), [](double w) { return w > 0.0; });
    JointRows& rows = all[l];
    rows.residual_V.resize(count);
    rows.sensitivity = Eigen::MatrixXd::Zero(count, p + x.size());
    WalkLog(
        logs, l, setup, structure, soc, rates, &x, curve, [&](std::size_t k, const CellRow& row) {
          const auto r = static_cast<Eigen::Index>(rows.point.size());
          rows.point.push_back(k);
          rows.residual_V[r] = row.Residual(x.data());
          for (int e = 0; e < row.entries; ++e)
            rows.sensitivity(r, p + row.index[e]) = row.value[e];
          for (int j = 0; j < p; ++j) rows.sensitivity(r, j) = row.slope[j];
        });
  });
  return all;
}

}  // namespace lipoid
