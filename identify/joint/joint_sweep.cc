#include "identify/joint/joint_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/battery/cell_model.h"

namespace lipoid {
namespace {

// Decays and gains of the modes of one kind, remembered for the intervals that come again and
// again.
struct Decays {
  std::vector<HoldCoefficients<double>> of;
};

class Modes {
 public:
  explicit Modes(std::vector<double> rate_per_s) : rate_per_s_(std::move(rate_per_s)) {}

  const std::vector<HoldCoefficients<double>>& Step(double dt_s, double time_s) {
    return cache_
        .Get(dt_s,
             time_s,
             [this](double dt, Decays& made) {
               made.of.resize(rate_per_s_.size());
               for (std::size_t m = 0; m < rate_per_s_.size(); ++m)
                 made.of[m] = ExactHold(rate_per_s_[m], dt);
             })
        .of;
  }

 private:
  std::vector<double> rate_per_s_;
  IntervalCache<Decays> cache_;
};

// y = sum_e value[e] x[index[e]], indices rising; y is counted from the reference.
struct Row {
  int entries;
  const int* index;
  const double* value;
  double y;
};

// Calls sink(log, point, row) for every point that has a weight.
template <class Sink>
void VisitRows(const JointLogs& logs,
               const JointSetup& setup,
               const JointStructure& structure,
               const SocTrace& soc,
               const JointRates& rates,
               Sink&& sink) {
  const JointLayout layout(structure);
  const int n = layout.size();
  const int nodes = layout.nodes();
  const bool one_node = nodes == 1;
  std::vector<double> reference_V;  // at the nodes
  for (const double a : structure.voltage_soc) reference_V.push_back(setup.reference(a));
  std::vector<double> rate_per_s;
  for (const double tau : rates.time_constant_s) rate_per_s.push_back(1.0 / tau);
  if (structure.self_heating) rate_per_s.push_back(1.0 / rates.heating_time_constant_s);
  Modes modes(rate_per_s);

  const double per_A = 1.0 / logs.typical_A;
  const double per_A3 = per_A * per_A * per_A;
  const int branches = structure.branches;
  // Shares of a branch that are smaller than this, in volts per volt, are zero.
  constexpr double kGone = 1e-13;
  struct Share {
    std::vector<double> value;  // of each node
    int first = 0, last = -1;   // nodes that are not zero
  };
  std::vector<Share> branch(static_cast<std::size_t>(branches));
  std::vector<int> index(static_cast<std::size_t>(n));
  std::vector<double> value(static_cast<std::size_t>(n));

  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    const JointLog& log = logs.logs[l];
    NodeFinder of_voltage(structure.voltage_soc);
    NodeFinder of_resistance(structure.resistance_soc);
    NodeFinder of_start(structure.resistance_soc);
    for (auto& b : branch) {
      b.value.assign(static_cast<std::size_t>(nodes), 0.0);
      b.first = 0;
      b.last = -1;
    }
    double warmth_A2 = 0.0;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) {
        const double dt_s = log.time_s[k] - log.time_s[k - 1];
        const auto& step = modes.Step(dt_s, log.time_s[k]);
        const double drive = log.step_A[k] * per_A;
        NodeShare where;
        if (!one_node) {
          where = of_start(soc.start[l][k]);
          where.share = std::clamp(where.share, 0.0, 1.0);
        }
        for (int j = 0; j < branches; ++j) {
          Share& b = branch[j];
          for (int m = b.first; m <= b.last; ++m) b.value[m] *= step[j].decay;  // (4.50)
          while (b.first <= b.last && std::abs(b.value[b.first]) < kGone) b.value[b.first++] = 0.0;
          while (b.first <= b.last && std::abs(b.value[b.last]) < kGone) b.value[b.last--] = 0.0;
          if (drive == 0.0) continue;
          const double gain = step[j].gain * rate_per_s[j] * drive;
          const int upper = one_node ? 0 : where.lower + 1;
          if (b.first > b.last) {
            b.first = where.lower;
            b.last = upper;
          } else {
            b.first = std::min(b.first, where.lower);
            b.last = std::max(b.last, upper);
          }
          b.value[where.lower] += (1.0 - where.share) * gain;
          if (!one_node) b.value[upper] += where.share * gain;
        }
        if (structure.self_heating) {
          const auto& [decay, gain] = step[branches];
          warmth_A2 =
              decay * warmth_A2 + gain * rate_per_s[branches] * log.step_A[k] * log.step_A[k];
        }
      }
      const double w = log.weight[k];
      if (!(w > 0.0)) continue;

      // The row: y = a'x.
      int entries = 0;
      const auto put = [&](int at, double a) {
        index[entries] = at;
        value[entries++] = a;
      };
      const double a_soc = soc.at[l][k];
      double reference = 0.0;
      if (layout.voltages() > 0) {
        const NodeShare v = of_voltage(a_soc);
        reference = (1.0 - v.share) * reference_V[v.lower] + v.share * reference_V[v.lower + 1];
        put(v.lower, 1.0 - v.share);
        put(v.lower + 1, v.share);
      } else {
        reference = setup.reference(a_soc);
      }
      const double y = log.voltage_V[k] - reference;
      const double i = log.current_A[k] * per_A;
      NodeShare r;
      if (i != 0.0 && !one_node) {
        r = of_resistance(a_soc);
        r.share = std::clamp(r.share, 0.0, 1.0);
      }
      const auto put_table = [&](int table, double drop) {
        put(table + r.lower, -(1.0 - r.share) * drop);
        if (!one_node) put(table + r.lower + 1, -r.share * drop);
      };
      if (i != 0.0) put_table(layout.series(), i);
      for (int j = 0; j < branches; ++j) {
        const Share& b = branch[j];
        for (int m = b.first; m <= b.last; ++m) put(layout.branch(j) + m, -b.value[m]);
      }
      if (structure.charge_transfer && i != 0.0) {
        const double i_0 = rates.charge_transfer_A;
        put_table(layout.transfer(), i_0 * std::asinh(log.current_A[k] / i_0) * per_A);
      }
      if (structure.self_heating) put(layout.heating(), warmth_A2 * log.current_A[k] * per_A3);

      sink(l, k, Row{entries, index.data(), value.data(), y});
    }
  }
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

SocTrace TraceSoc(const JointLogs& logs, const JointSetup& setup, double beta_per_sqrt_s) {
  const bool diffusion = setup.diffusion && std::isfinite(beta_per_sqrt_s);
  const int terms = diffusion ? setup.terms : 0;
  std::vector<double> rate_per_s;
  for (int m = 1; m <= terms; ++m)
    rate_per_s.push_back(double(m) * double(m) * beta_per_sqrt_s * beta_per_sqrt_s);
  const double tail_s =
      diffusion && setup.tail ? 2.0 * TailSum(terms) / (beta_per_sqrt_s * beta_per_sqrt_s) : 0.0;
  SocTrace trace;
  trace.at.resize(logs.logs.size());
  trace.start.resize(logs.logs.size());
  Modes modes(rate_per_s);
  std::vector<double> unavailable_C(rate_per_s.size());
  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    const JointLog& log = logs.logs[l];
    auto& at = trace.at[l];
    auto& start = trace.start[l];
    at.resize(log.size());
    start.resize(log.size());
    std::fill(unavailable_C.begin(), unavailable_C.end(), 0.0);
    double delivered_C = log.delivered_C;
    double held_C = 0.0;  // 2 sum_m sigma_um
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) {
        const double dt_s = log.time_s[k] - log.time_s[k - 1];
        start[k] = 1.0 - (delivered_C + held_C + tail_s * log.step_A[k]) / setup.alpha_C;
        const auto& step = modes.Step(dt_s, log.time_s[k]);
        held_C = 0.0;
        for (std::size_t m = 0; m < step.size(); ++m) {
          unavailable_C[m] =
              step[m].decay * unavailable_C[m] + (step[m].gain * log.step_A[k] + kAlive);  // (4.46)
          held_C += unavailable_C[m];
        }
        held_C *= 2.0;
        delivered_C += dt_s * log.step_A[k];  // (4.46)
      } else {
        start[0] = 1.0 - delivered_C / setup.alpha_C;
      }
      at[k] = 1.0 - (delivered_C + held_C + tail_s * log.current_A[k]) / setup.alpha_C;  // (4.48)
      if (log.weight[k] > 0.0) {
        trace.lowest = std::min(trace.lowest, at[k]);
        trace.highest = std::max(trace.highest, at[k]);
      }
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
  NormalEquations sum(JointLayout(structure).size());
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l, std::size_t k, const Row& row) {
    AddRow(sum, logs.logs[l].weight[k], row);
  });
  return sum;
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
      sums[s][static_cast<std::size_t>(log.unit[k])] += log.weight[k] * std::abs(error);
    }
  });
  return sums;
}

std::vector<JointRows> LinearRows(const JointLogs& logs,
                                  const JointSetup& setup,
                                  const JointStructure& structure,
                                  const JointRates& rates,
                                  const Eigen::VectorXd& x) {
  const SocTrace soc = TraceSoc(logs, setup, rates.beta_per_sqrt_s);
  std::vector<JointRows> all(logs.logs.size());
  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    const auto& weight = logs.logs[l].weight;
    const auto rows = std::count_if(weight.begin(), weight.end(), [](double w) { return w > 0.0; });
    all[l].residual_V.resize(rows);
    all[l].sensitivity = Eigen::MatrixXd::Zero(rows, x.size());
  }
  VisitRows(logs, setup, structure, soc, rates, [&](std::size_t l, std::size_t k, const Row& row) {
    JointRows& rows = all[l];
    const auto r = static_cast<Eigen::Index>(rows.point.size());
    rows.point.push_back(k);
    double residual_V = row.y;
    for (int e = 0; e < row.entries; ++e) {
      residual_V -= row.value[e] * x[row.index[e]];
      rows.sensitivity(r, row.index[e]) = row.value[e];
    }
    rows.residual_V[r] = residual_V;
  });
  return all;
}

}  // namespace lipoid
