#include "identify/joint/joint_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/fit/cell_rows.h"
#include "identify/logs/columns.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"

namespace lipoid {
namespace {

// A branch has a time constant of so many sampling intervals at least. A faster one has nearly all
// of its drop in the first row after an edge, where it would stand in for r_s.
constexpr double kShortestTau = 2.0;

// Where branches may be fast, of so much of one: what is left of such a branch after a row is an eighth.
constexpr double kFastestTau = 0.5;

// And of the longest segment at most, or, where branches may be slow, of so many times that: such a
// branch still bends by a twentieth within it, and many segments may tell what one does not. It may
// also stand in for v_oc and for hysteresis: nothing is let there that does not ask for it.
constexpr double kSlowestTau = 10.0;

// Walks one log and calls sink(point, row) for every point that has a weight. Slopes are those at
// the unknowns x; none where it is null, and then the trace needs none either.
template <class Sink>
void WalkLog(
    const AtRates& sweep, std::size_t l, const Eigen::VectorXd* x, CurveSlope curve, Sink&& sink) {
  const JointLogs& logs = sweep.logs;
  const JointSetup& setup = sweep.setup;
  const JointStructure& structure = sweep.structure;
  const JointRates& rates = sweep.rates;
  const JointLog& log = logs.logs[l];
  const LogTrace& trace = sweep.soc.logs[l];
  CellRows rows(setup, structure, rates, logs.typical_A, x == nullptr ? nullptr : x->data(), curve);
  ModeSteps steps;
  rows.SetSteps(log.steps.length_s, steps);
  rows.Start(log.delivered_C);
  const auto at = [&](double shown_A,
                      double dt_s,
                      const std::vector<double>& of,
                      const std::vector<SocSlopes>& slopes,
                      std::size_t k) {
    return CellRows::At{.current_A = rates.Flowing(shown_A),
                        .dt_s = dt_s,
                        .soc = of[k],
                        .slopes = slopes.empty() ? SocSlopes{} : slopes[k],
                        .current_by_offset = rates.FlowingSlope(shown_A)};
  };
  const bool warm = structure.temperature && !log.temperature_K.empty();
  for (std::size_t k = 0; k < log.size(); ++k) {
    const bool warms = warm && k > 0 && log.temperature_K[k] != log.temperature_K[k - 1];
    if (warms) rows.SetTemperature({log.HalfWay_K(k), setup.reference_K});
    if (k > 0) {
      const double dt_s = log.time_s[k] - log.time_s[k - 1];
      rows.Step(steps,
                static_cast<Eigen::Index>(log.steps.to[k]),
                at(log.step_A[k], dt_s, trace.start, trace.start_slopes, k));
    }
    if (warms || (warm && k == 0)) rows.SetTemperature({log.temperature_K[k], setup.reference_K});
    if (!(log.weight[k] > 0.0)) continue;
    CellRows::At point = at(log.current_A[k], 0.0, trace.at, trace.at_slopes, k);
    if (structure.voltage_soc.empty()) point.v_oc = setup.open_circuit_voltage.Evaluate(point.soc);
    sink(k, rows.MakeRow(point, log.voltage_V[k]));
  }
}

// Calls sink(log, point, row) for every point of every log: logs side by side, the points of one in their
// order. Groups and units belong to one log each.
template <class Sink>
void VisitRows(const AtRates& sweep, Sink&& sink) {
  StopIfAsked();
  ParallelFor(sweep.logs.logs.size(), [&](std::size_t l) {
    WalkLog(sweep, l, nullptr, CurveSlope::kOfSegments, [&](std::size_t k, const CellRow& row) {
      sink(l, k, row);
    });
  });
}

// One sum per log, side by side, then all of them in the order of the logs: the same bits with any
// number of threads.
template <class Sum, class AddRow>
Sum SumOverLogs(const AtRates& sweep, const Eigen::VectorXd* x, const Sum& zero, AddRow&& add) {
  const std::vector<JointLog>& logs = sweep.logs.logs;
  std::vector<Sum> sums(logs.size(), zero);
  StopIfAsked();
  ParallelFor(sums.size(), [&](std::size_t l) {
    WalkLog(sweep, l, x, CurveSlope::kSmooth, [&](std::size_t k, const CellRow& row) {
      add(sums[l], logs[l].weight[k], row);
    });
  });
  for (std::size_t l = 1; l < sums.size(); ++l) sums[0].Add(sums[l]);
  return sums.empty() ? zero : std::move(sums[0]);
}

}  // namespace

SocTrace TraceSoc(const JointLogs& logs,
                  const JointSetup& setup,
                  const JointRates& rates,
                  bool slopes) {
  SocTrace trace;
  trace.logs.resize(logs.logs.size());
  StopIfAsked();
  ParallelFor(logs.logs.size(), [&](std::size_t l) {
    const JointLog& log = logs.logs[l];
    LogTrace& out = trace.logs[l];
    const double energy_J_per_mol = rates.Diffusion();
    const bool warm = std::isfinite(energy_J_per_mol) && !log.temperature_K.empty();
    const bool with_alpha = std::isfinite(rates.alpha_C);
    const bool with_offset = std::isfinite(rates.current_offset_A);
    const double spent = log.delivered_C / setup.alpha_C;
    const double axis_C = setup.AxisCharge(rates.alpha_C);
    SocState state(setup,
                   axis_C,
                   rates.beta_per_sqrt_s,
                   with_alpha ? spent * rates.alpha_C : log.delivered_C,
                   slopes);
    if (slopes && with_offset) state.CountOffset();
    const bool moves = state.slopes() || (slopes && (with_alpha || with_offset));
    out.at.resize(log.size());
    out.start.resize(log.size());
    out.at_slopes.resize(moves ? log.size() : 0);
    out.start_slopes.resize(moves ? log.size() : 0);
    const JointSteps& kinds = warm ? log.warm_steps : log.steps;
    ModeSteps steps;
    if (warm) {
      std::vector<AtTemperature> at;
      for (const double temperature_K : kinds.at_K)
        at.emplace_back(temperature_K, setup.reference_K);
      state.SetStepsAt(kinds.length_s, at, energy_J_per_mol, steps);
      state.SetTemperature({log.temperature_K[0], setup.reference_K}, energy_J_per_mol);
    } else {
      state.SetSteps(kinds.length_s, steps);
    }
    const auto slopes_at = [&](double shown_A) {
      const double current_A = rates.Flowing(shown_A);
      // A = A_0 - charge/alpha where the axis follows alpha; else only A_0 moves.
      const double by_alpha = !with_alpha ? 0.0
                              : setup.axis_follows_alpha
                                  ? (1.0 - spent - state.Soc(current_A)) / axis_C
                                  : -spent / axis_C;
      return SocSlopes{.beta = state.Slope(current_A),
                       .energy = warm ? state.EnergySlope(current_A) : 0.0,
                       .offset = state.OffsetSlope(rates.FlowingSlope(shown_A)),
                       .alpha = by_alpha};
    };
    for (std::size_t k = 0; k < log.size(); ++k) {
      const double step_A = k > 0 ? log.step_A[k] : 0.0;
      const bool warms = warm && k > 0 && log.temperature_K[k] != log.temperature_K[k - 1];
      if (warms) state.SetTemperature({log.HalfWay_K(k), setup.reference_K}, energy_J_per_mol);
      out.start[k] = state.Soc(rates.Flowing(step_A));
      if (moves) out.start_slopes[k] = slopes_at(step_A);
      if (k > 0) {
        state.Step(steps,
                   static_cast<Eigen::Index>(kinds.to[k]),
                   rates.Flowing(step_A),
                   log.time_s[k] - log.time_s[k - 1],
                   rates.FlowingSlope(step_A));
      }
      if (warms) state.SetTemperature({log.temperature_K[k], setup.reference_K}, energy_J_per_mol);
      out.at[k] = state.Soc(rates.Flowing(log.current_A[k]));
      if (moves) out.at_slopes[k] = slopes_at(log.current_A[k]);
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

std::vector<NormalEquations> SumGroups(const AtRates& sweep, const Grouping& by) {
  const JointLogs& logs = sweep.logs;
  const int n = JointLayout(sweep.structure).size();
  const auto groups = static_cast<std::size_t>(by.groups);
  std::vector<NormalEquations> sums(groups + logs.logs.size(), NormalEquations(n));
  VisitRows(sweep, [&](std::size_t l, std::size_t k, const CellRow& row) {
    const JointLog& log = logs.logs[l];
    const int of = (log.*by.of)[k];
    const std::size_t group = of == JointLog::kAlways ? groups + l : static_cast<std::size_t>(of);
    sums[group].Add(log.weight[k], row);
  });
  for (std::size_t l = 1; l < logs.logs.size(); ++l) sums[groups].Add(sums[groups + l]);
  sums.resize(groups + 1);
  return sums;
}

namespace {

// Mean size of errors that scatter about their mean: of rows of which a point is the mean (a folded
// normal distribution).
double MeanSize(double mean, double scatter) {
  if (!(scatter > 0.0)) return std::abs(mean);
  constexpr double kRootTwoOverPi = 0.7978845608028654;
  const double off = mean / scatter;
  return scatter * kRootTwoOverPi * std::exp(-0.5 * off * off) +
         mean * std::erf(off * 0.7071067811865475);
}

}  // namespace

std::vector<std::vector<double>> SumErrors(
    const AtRates& sweep,
    const Grouping& by,
    const std::vector<std::vector<Eigen::VectorXd>>& unknowns,
    ErrorSize size,
    std::vector<double>* always) {
  const JointLogs& logs = sweep.logs;
  std::vector<std::vector<double>> sums(unknowns.empty() ? 0 : unknowns.front().size(),
                                        std::vector<double>(logs.unit_weight.size(), 0.0));
  VisitRows(sweep, [&](std::size_t l, std::size_t k, const CellRow& row) {
    const JointLog& log = logs.logs[l];
    const int group = (log.*by.of)[k];
    const bool stays = group == JointLog::kAlways;
    if (stays && always == nullptr) return;
    const auto& candidates = unknowns[stays ? 0 : static_cast<std::size_t>(group)];
    const bool of_rows = size == ErrorSize::kPercentOfRows;
    const double factor = of_rows ? 100.0 * log.count[k] / log.voltage_V[k] : log.weight[k];
    const double scatter_V =
        of_rows && log.count[k] > 1.0 ? log.scatter_V * std::sqrt(1.0 - 1.0 / log.count[k]) : 0.0;
    for (std::size_t s = 0; s < sums.size(); ++s) {
      const double error = candidates[s].size() == 0 ? std::numeric_limits<double>::infinity()
                                                     : row.Residual(candidates[s].data());
      (stays ? (*always)[l] : sums[s][static_cast<std::size_t>(log.unit[k])]) +=
          factor * MeanSize(error, scatter_V);
    }
  });
  return sums;
}

namespace {

class PointsAtBeta : public Observations::AtBeta {
 public:
  PointsAtBeta(const JointLogs& logs, const JointSetup& setup, const JointRates& rates, bool slopes)
      : logs_(logs), setup_(setup), soc_(TraceSoc(logs, setup, rates, slopes)) {}

  [[nodiscard]] NormalEquations Sum(const JointStructure& structure,
                                    const JointRates& rates) const override {
    const NormalEquations zero(JointLayout(structure).size());
    return SumOverLogs(
        {logs_, setup_, structure, soc_, rates}, nullptr, zero, [](auto& sum, double w, auto& row) {
          sum.Add(w, row);
        });
  }
  [[nodiscard]] SlopeSums Slopes(const JointStructure& structure,
                                 const JointRates& rates,
                                 const Eigen::VectorXd& x) const override {
    const SlopeSums zero(RateSlots(structure).size(), x.size());
    return SumOverLogs(
        {logs_, setup_, structure, soc_, rates}, &x, zero, [&](auto& sum, double w, auto& row) {
          sum.Add(w, row, x.data());
        });
  }

 private:
  const JointLogs& logs_;
  const JointSetup& setup_;
  SocTrace soc_;
};

}  // namespace

JointObservations::JointObservations(const JointLogs& logs, const JointSetup& setup)
    : logs_(logs), setup_(setup) {
  scales_.typical_A = logs.typical_A;
  scales_.largest_A = logs.largest_A;
  scales_.weight_sum = logs.weight_sum;
  scales_.lowest_loaded_soc = logs.lowest_loaded_soc;
  scales_.highest_loaded_soc = logs.highest_loaded_soc;
  scales_.slowest_A = logs.largest_A;
  for (const JointLog& log : logs.logs)
    scales_.slowest_A = std::min(scales_.slowest_A, LargestMagnitude(log.current_A));
  // Time constants that logs with steps can show, pulses where there are any.
  double shortest_s = std::numeric_limits<double>::infinity();
  double longest_s = 0.0;
  for (const bool pulses : {true, false}) {
    for (const JointLog& log : logs.logs) {
      if ((log.kind == LogKind::kPulses) != pulses) continue;
      shortest_s = std::min(shortest_s, log.shortest_s);
      longest_s = std::max(longest_s, log.longest_s);
    }
    if (std::isfinite(shortest_s)) break;
  }
  scales_.shortest_tau_s = (setup.fast_branches ? kFastestTau : kShortestTau) * shortest_s;
  scales_.longest_start_tau_s = std::max(longest_s, 8.0 * shortest_s);
  scales_.longest_tau_s = (setup.slow_branches ? kSlowestTau : 1.0) * scales_.longest_start_tau_s;
}

std::unique_ptr<Observations::AtBeta> JointObservations::At(const JointRates& rates,
                                                            bool slopes) const {
  return std::make_unique<PointsAtBeta>(logs_, setup_, rates, slopes);
}

std::vector<FittedRows> JointObservations::Rows(const JointStructure& structure,
                                                const JointRates& rates,
                                                const Eigen::VectorXd& x,
                                                CurveSlope curve) const {
  const SocTrace soc = TraceSoc(logs_, setup_, rates, true);
  const int p = RateSlots(structure).size();
  std::vector<FittedRows> all(logs_.logs.size());
  StopIfAsked();
  ParallelFor(all.size(), [&](std::size_t l) {
    const JointLog& log = logs_.logs[l];
    const auto count =
        std::count_if(log.weight.begin(), log.weight.end(), [](double w) { return w > 0.0; });
    FittedRows& rows = all[l];
    rows.residual_V.resize(count);
    rows.weight.resize(count);
    rows.averaged.resize(count);
    rows.sensitivity = Eigen::MatrixXd::Zero(count, p + x.size());
    WalkLog({logs_, setup_, structure, soc, rates},
            l,
            &x,
            curve,
            [&](std::size_t k, const CellRow& row) {
              const auto r = static_cast<Eigen::Index>(rows.time_s.size());
              rows.time_s.push_back(log.time_s[k]);
              rows.residual_V[r] = row.Residual(x.data());
              rows.weight[r] = log.weight[k];
              rows.averaged[r] = log.count[k];
              for (int e = 0; e < row.entries; ++e)
                rows.sensitivity(r, p + row.index[e]) = row.value[e];
              for (int j = 0; j < p; ++j) rows.sensitivity(r, j) = row.slope[j];
            });
  });
  return all;
}

}  // namespace lipoid
