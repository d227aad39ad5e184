#include "identify/joint/joint_sweep.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/fit/mode_step.h"
#include "model/battery/cell_model.h"

namespace lipoid {
namespace {

// y = sum_e value[e] x[index[e]], indices rising; y is counted from the reference. Where slopes are
// asked for, slope[p] is that of the predicted voltage in nonlinear parameter p.
struct Row {
  int entries;
  const int* index;
  const double* value;
  double y;
  const double* slope;
};

// The low pass of one branch, of the current shared out to the nodes of its resistance.
struct BranchState {
  std::vector<double> share;  // of each node
  int first = 0, last = -1;   // nodes whose share is not zero
  double slope_tau = 0.0;     // of the voltage, in tau_j
  double slope_beta = 0.0;    // and in beta, which moves the state of charge that r_j is taken at

  void Reset(int nodes) {
    share.assign(static_cast<std::size_t>(nodes), 0.0);
    first = 0;
    last = -1;
    slope_tau = slope_beta = 0.0;
  }
  [[nodiscard]] double Voltage(const double* x) const {
    double sum = 0.0;
    for (int m = first; m <= last; ++m) sum += share[m] * x[m];
    return sum;
  }
  void Decay(double decay) {
    // Shares that are smaller than this, in volts per volt, are zero.
    constexpr double kGone = 1e-13;
    for (int m = first; m <= last; ++m) share[m] *= decay;  // (4.50)
    while (first <= last && std::abs(share[first]) < kGone) share[first++] = 0.0;
    while (first <= last && std::abs(share[last]) < kGone) share[last--] = 0.0;
  }
  void Drive(const NodeShare& where, int upper, double drive) {
    if (first > last) {
      first = where.lower;
      last = upper;
    } else {
      first = std::min(first, where.lower);
      last = std::max(last, upper);
    }
    share[where.lower] += (1.0 - where.share) * drive;
    if (upper != where.lower) share[upper] += where.share * drive;
  }
};

// A table of resistances at a point, in the unknowns x of its nodes.
struct TableAt {
  double value, slope;  // slope in the state of charge; 0 beyond the ends
};
TableAt At(const double* x, const NodeShare& at, const std::vector<double>& nodes) {
  if (nodes.size() == 1) return {x[0], 0.0};
  const double low = x[at.lower];
  const double high = x[at.lower + 1];
  const bool within = at.share > 0.0 && at.share < 1.0;
  return {(1.0 - at.share) * low + at.share * high,
          within ? (high - low) / (nodes[at.lower + 1] - nodes[at.lower]) : 0.0};
}

// Walks one log and calls sink(point, row) for every point that has a weight. Slopes are those at
// the unknowns x; none where it is null, and then the trace needs none either.
class LogRows {
 public:
  LogRows(const JointLogs& logs,
          const JointSetup& setup,
          const JointStructure& structure,
          const JointRates& rates,
          const Eigen::VectorXd* x,
          CurveSlope curve)
      : setup_(setup),
        structure_(structure),
        layout_(structure),
        slots_(structure),
        rates_(rates),
        x_(x == nullptr ? nullptr : x->data()),
        per_A_(1.0 / logs.typical_A),
        branches_(static_cast<std::size_t>(structure.branches)),
        index_(static_cast<std::size_t>(layout_.size())),
        value_(static_cast<std::size_t>(layout_.size())),
        slope_(static_cast<std::size_t>(slots_.size())) {
    for (const double a : structure.voltage_soc) reference_V_.push_back(setup.reference(a));
    if (x != nullptr) FindCurveSlopes(curve);
  }

  template <class Sink>
  void Run(const JointLog& log, const LogTrace& trace, Sink&& sink) {
    NodeFinder of_voltage(structure_.voltage_soc);
    NodeFinder of_resistance(structure_.resistance_soc);
    NodeFinder of_start(structure_.resistance_soc);
    for (auto& b : branches_) b.Reset(layout_.nodes());
    warmth_A2_ = warmth_slope_ = 0.0;
    const auto n = static_cast<Eigen::Index>(structure_.branches);
    steps_.Set(
        n + (structure_.self_heating ? 1 : 0), log.interval_s, [&](Eigen::Index m, double dt_s) {
          return LowPassStep(m < n ? rates_.time_constant_s[static_cast<std::size_t>(m)]
                                   : rates_.heating_time_constant_s,
                             dt_s);
        });
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) Step(log, trace, k, of_start);
      if (log.weight[k] > 0.0) sink(k, MakeRow(log, trace, k, of_voltage, of_resistance));
    }
  }

 private:
  // Slopes at both ends of every segment: its own, or those of parabolas through three nodes.
  void FindCurveSlopes(CurveSlope curve) {
    const auto& nodes = structure_.voltage_soc;
    if (nodes.size() < 2) return;
    const std::size_t last = nodes.size() - 1;
    std::vector<double> of_segment;
    for (std::size_t k = 0; k < last; ++k) {
      const double rise_V = reference_V_[k + 1] + x_[k + 1] - reference_V_[k] - x_[k];
      of_segment.push_back(rise_V / (nodes[k + 1] - nodes[k]));
    }
    for (std::size_t k = 0; k < last; ++k) curve_slope_V_.push_back({of_segment[k], of_segment[k]});
    if (curve == CurveSlope::kOfSegments) return;
    for (std::size_t k = 1; k < last; ++k) {
      const double before = nodes[k] - nodes[k - 1];
      const double after = nodes[k + 1] - nodes[k];
      const double slope_V = (after * of_segment[k - 1] + before * of_segment[k]) / (before + after);
      curve_slope_V_[k - 1].second = curve_slope_V_[k].first = slope_V;
    }
  }

  void Step(const JointLog& log, const LogTrace& trace, std::size_t k, NodeFinder& of_start) {
    const auto at = static_cast<Eigen::Index>(log.interval[k]);
    const auto decay = steps_.decay.col(at);
    const auto gain = steps_.gain.col(at);
    const auto decay_slope = steps_.decay_slope.col(at);
    const auto gain_slope = steps_.gain_slope.col(at);
    const double current_A = log.step_A[k];
    const double drive = current_A * per_A_;
    NodeShare where;
    if (layout_.nodes() > 1) {
      where = of_start(trace.start[k]);
      where.share = std::clamp(where.share, 0.0, 1.0);
    }
    const int upper = layout_.nodes() == 1 ? 0 : where.lower + 1;
    for (int j = 0; j < structure_.branches; ++j) {
      BranchState& b = branches_[static_cast<std::size_t>(j)];
      if (x_ != nullptr) {
        const double* x = x_ + layout_.branch(j);
        const TableAt r = At(x, where, structure_.resistance_soc);
        b.slope_tau = decay[j] * b.slope_tau + decay_slope[j] * b.Voltage(x) +
                      (gain_slope[j] * drive * r.value + kAlive);
        const double moved = setup_.diffusion ? r.slope * trace.start_slope[k] : 0.0;
        b.slope_beta = decay[j] * b.slope_beta + (gain[j] * drive * moved + kAlive);
      }
      b.Decay(decay[j]);
      if (drive != 0.0) b.Drive(where, upper, gain[j] * drive);  // (4.50)
    }
    if (structure_.self_heating) {
      const int h = structure_.branches;
      const double square_A2 = current_A * current_A;
      warmth_slope_ = decay[h] * warmth_slope_ + decay_slope[h] * warmth_A2_ +
                      gain_slope[h] * square_A2;
      warmth_A2_ = decay[h] * warmth_A2_ + gain[h] * square_A2;
    }
  }

  Row MakeRow(const JointLog& log,
              const LogTrace& trace,
              std::size_t k,
              NodeFinder& of_voltage,
              NodeFinder& of_resistance) {
    int entries = 0;
    const auto put = [&](int at, double a) {
      index_[entries] = at;
      value_[entries++] = a;
    };
    const double a_soc = trace.at[k];
    double reference_V = 0.0;
    double slope_V = 0.0;  // of v_oc at this A
    if (layout_.voltages() > 0) {
      const NodeShare v = of_voltage(a_soc);
      const double low_V = reference_V_[v.lower];
      const double high_V = reference_V_[v.lower + 1];
      reference_V = (1.0 - v.share) * low_V + v.share * high_V;
      if (x_ != nullptr) {
        const auto& [low_slope_V, high_slope_V] = curve_slope_V_[v.lower];
        slope_V = (1.0 - v.share) * low_slope_V + v.share * high_slope_V;
      }
      put(v.lower, 1.0 - v.share);
      put(v.lower + 1, v.share);
    } else {
      const auto point = setup_.reference.Evaluate(a_soc);
      reference_V = point.value_V;
      slope_V = point.slope_V;
    }
    const double i = log.current_A[k] * per_A_;
    NodeShare r;
    if (i != 0.0 && layout_.nodes() > 1) {
      r = of_resistance(a_soc);
      r.share = std::clamp(r.share, 0.0, 1.0);
    }
    const auto put_table = [&](int table, double drop) {
      put(table + r.lower, -(1.0 - r.share) * drop);
      if (layout_.nodes() > 1) put(table + r.lower + 1, -r.share * drop);
      if (x_ == nullptr) return TableAt{0.0, 0.0};
      const TableAt at = At(x_ + table, r, structure_.resistance_soc);
      slope_V -= at.slope * drop;
      return at;
    };
    if (i != 0.0) put_table(layout_.series(), i);
    double slope_beta = 0.0;
    for (int j = 0; j < structure_.branches; ++j) {
      const BranchState& b = branches_[static_cast<std::size_t>(j)];
      for (int m = b.first; m <= b.last; ++m) put(layout_.branch(j) + m, -b.share[m]);
      slope_beta -= b.slope_beta;
      slope_[slots_.tau(j)] = -b.slope_tau;
    }
    if (structure_.charge_transfer) {
      slope_[slots_.transfer()] = 0.0;
      if (i != 0.0) {
        const double i_0 = rates_.charge_transfer_A;
        const double ratio = log.current_A[k] / i_0;
        const TableAt at = put_table(layout_.transfer(), i_0 * std::asinh(ratio) * per_A_);
        slope_[slots_.transfer()] =
            -at.value * (std::asinh(ratio) - ratio / std::hypot(1.0, ratio)) * per_A_;
      }
    }
    if (structure_.self_heating) {
      const double per_A3 = per_A_ * per_A_ * per_A_ * log.current_A[k];
      put(layout_.heating(), warmth_A2_ * per_A3);
      if (x_ != nullptr)
        slope_[slots_.heating()] = x_[layout_.heating()] * warmth_slope_ * per_A3;
    }
    if (x_ != nullptr)
      slope_[slots_.beta()] =
          setup_.diffusion ? slope_beta + slope_V * trace.at_slope[k] : 0.0;  // (4.51)
    return {entries, index_.data(), value_.data(), log.voltage_V[k] - reference_V, slope_.data()};
  }

  const JointSetup& setup_;
  const JointStructure& structure_;
  JointLayout layout_;
  RateSlots slots_;
  const JointRates& rates_;
  const double* x_;
  double per_A_;
  std::vector<double> reference_V_;                        // at the nodes
  std::vector<std::pair<double, double>> curve_slope_V_;  // of v_oc at both ends of a segment
  std::vector<BranchState> branches_;
  double warmth_A2_ = 0.0;
  double warmth_slope_ = 0.0;  // in tau_h
  std::vector<int> index_;
  std::vector<double> value_;
  std::vector<double> slope_;
  ModeSteps steps_;
};

// Calls sink(log, point, row) for every point of every log, in their order.
template <class Sink>
void VisitRows(const JointLogs& logs,
               const JointSetup& setup,
               const JointStructure& structure,
               const SocTrace& soc,
               const JointRates& rates,
               Sink&& sink) {
  LogRows rows(logs, setup, structure, rates, nullptr, CurveSlope::kOfSegments);
  for (std::size_t l = 0; l < logs.logs.size(); ++l)
    rows.Run(logs.logs[l], soc.logs[l], [&](std::size_t k, const Row& row) { sink(l, k, row); });
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
    LogRows rows(logs, setup, structure, rates, x, curve);
    const JointLog& log = logs.logs[l];
    rows.Run(log, soc.logs[l], [&](std::size_t k, const Row& row) {
      add(sums[l], log.weight[k], row);
    });
  });
  for (std::size_t l = 1; l < sums.size(); ++l) sums[0].Add(sums[l]);
  return sums.empty() ? zero : std::move(sums[0]);
}

void AddRow(NormalEquations& sum, double w, const Row& row) {
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
  const bool diffusion = setup.diffusion && std::isfinite(beta_per_sqrt_s);
  const Eigen::Index terms = diffusion ? setup.terms : 0;
  const double tail_s = diffusion && setup.tail
                            ? 2.0 * TailSum(setup.terms) / (beta_per_sqrt_s * beta_per_sqrt_s)
                            : 0.0;
  const double tail_slope = -2.0 * tail_s / beta_per_sqrt_s;
  slopes = slopes && diffusion;
  SocTrace trace;
  trace.logs.resize(logs.logs.size());
  tbb::parallel_for(std::size_t{0}, logs.logs.size(), [&](std::size_t l) {
    const JointLog& log = logs.logs[l];
    LogTrace& out = trace.logs[l];
    out.at.resize(log.size());
    out.start.resize(log.size());
    out.at_slope.resize(slopes ? log.size() : 0);
    out.start_slope.resize(slopes ? log.size() : 0);
    ModeSteps steps;
    steps.Set(terms, log.interval_s, [&](Eigen::Index m, double dt_s) {
      return DiffusionStep(static_cast<int>(m) + 1, beta_per_sqrt_s, dt_s);
    });
    Eigen::ArrayXd unavailable_C = Eigen::ArrayXd::Zero(terms);
    Eigen::ArrayXd slope_C = Eigen::ArrayXd::Zero(terms);
    double delivered_C = log.delivered_C;
    const auto soc = [&](double current_A) {
      const double sigma_C = delivered_C + 2.0 * unavailable_C.sum() + tail_s * current_A;  // (4.47)
      return 1.0 - sigma_C / setup.alpha_C;                                                 // (4.48)
    };
    const auto slope = [&](double current_A) {
      return -(2.0 * slope_C.sum() + tail_slope * current_A) / setup.alpha_C;
    };
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) {
        const double dt_s = log.time_s[k] - log.time_s[k - 1];
        const double current_A = log.step_A[k];
        out.start[k] = soc(current_A);
        if (slopes) out.start_slope[k] = slope(current_A);
        const auto at = static_cast<Eigen::Index>(log.interval[k]);
        if (slopes) {
          slope_C = steps.decay.col(at) * slope_C + steps.decay_slope.col(at) * unavailable_C +
                    (steps.gain_slope.col(at) * current_A + kAlive);
        }
        unavailable_C = steps.decay.col(at) * unavailable_C +
                        (steps.gain.col(at) * current_A + kAlive);  // (4.46)
        delivered_C += dt_s * current_A;                            // (4.46)
      } else {
        out.start[0] = 1.0 - delivered_C / setup.alpha_C;
        if (slopes) out.start_slope[0] = 0.0;
      }
      out.at[k] = soc(log.current_A[k]);
      if (slopes) out.at_slope[k] = slope(log.current_A[k]);
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
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l, std::size_t k, const Row& row) {
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
  const auto add = [&x, p](SlopeSums& sum, double w, const Row& row) {
    const Eigen::Map<const Eigen::VectorXd> slope(row.slope, p);
    double residual_V = row.y;
    for (int e = 0; e < row.entries; ++e) {
      residual_V -= row.value[e] * x[row.index[e]];
      sum.with_linear.col(row.index[e]) += w * row.value[e] * slope;
    }
    sum.of_rates.noalias() += w * slope * slope.transpose();
    sum.with_residual += w * residual_V * slope;
  };
  return SumOverLogs(logs, setup, structure, soc, rates, &x, curve, zero, add);
}

std::vector<double> SumErrors(const JointLogs& logs,
                              const JointSetup& setup,
                              const JointStructure& structure,
                              const SocTrace& soc,
                              const JointRates& rates,
                              const std::vector<std::vector<Eigen::VectorXd>>& unknowns) {
  std::vector<double> sums(unknowns.empty() ? 0 : unknowns.front().size());
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l, std::size_t k, const Row& row) {
    const JointLog& log = logs.logs[l];
    if (log.group[k] == JointLog::kAlways) return;
    const auto& candidates = unknowns[static_cast<std::size_t>(log.group[k])];
    for (std::size_t s = 0; s < sums.size(); ++s) {
      double error = row.y;
      if (candidates[s].size() == 0) {
        error = std::numeric_limits<double>::infinity();
      } else {
        for (int e = 0; e < row.entries; ++e) error -= row.value[e] * candidates[s][row.index[e]];
      }
      sums[s] += log.weight[k] * std::abs(error);
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
    LogRows walk(logs, setup, structure, rates, &x, curve);
    walk.Run(logs.logs[l], soc.logs[l], [&](std::size_t k, const Row& row) {
      const auto r = static_cast<Eigen::Index>(rows.point.size());
      rows.point.push_back(k);
      double residual_V = row.y;
      for (int e = 0; e < row.entries; ++e) {
        residual_V -= row.value[e] * x[row.index[e]];
        rows.sensitivity(r, p + row.index[e]) = row.value[e];
      }
      for (int j = 0; j < p; ++j) rows.sensitivity(r, j) = row.slope[j];
      rows.residual_V[r] = residual_V;
    });
  });
  return all;
}

}  // namespace lipoid
