#include "identify/joint/joint_trust.h"

#include <ceres/jet.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "identify/joint/joint_drawn.h"
#include "model/battery/cell_model.h"

namespace lipoid {
namespace {

// beta, five branches, tau_h and i_0.
constexpr int kMostRates = 8;
using Jet = ceres::Jet<double, kMostRates>;

// The solution as a cell whose rates are variables.
class VariableCell {
 public:
  VariableCell(const JointResult& result, const std::vector<JointFit::Rate>& searched)
      : best_(result.choice.best), layout_(best_.structure), per_A_(1.0 / result.logs.typical_A) {
    const JointSetup& setup = result.setup;
    parameters.alpha_C = Jet(setup.alpha_C);
    parameters.diffusion = setup.diffusion;
    parameters.terms = setup.terms;
    parameters.tail = setup.tail;
    parameters.beta_per_sqrt_s =
        Variable("beta", setup.diffusion ? best_.rates.beta_per_sqrt_s : 1.0, searched);
    parameters.open_circuit_voltage = setup.reference;
    if (layout_.voltages() > 0) {
      std::vector<double> voltage_V;
      for (int k = 0; k < layout_.voltages(); ++k)
        voltage_V.push_back(setup.reference(best_.structure.voltage_soc[k]) + best_.x[k]);
      parameters.open_circuit_voltage =
          OpenCircuitVoltage::Linear(best_.structure.voltage_soc, std::move(voltage_V));
    }
    parameters.series_resistance_Ohm = Table(layout_.series());
    for (int j = 0; j < best_.structure.branches; ++j) {
      parameters.branches.push_back(
          {Table(layout_.branch(j)),
           Variable(fmt::format("tau_{}", j + 1), best_.rates.time_constant_s[j], searched)});
    }
    if (best_.structure.self_heating) {
      parameters.self_heating =
          SelfHeating<Jet>{Variable("tau_h", best_.rates.heating_time_constant_s, searched),
                           Jet(best_.x[layout_.heating()] * per_A_ * per_A_ * per_A_)};
    }
    if (best_.structure.charge_transfer) {
      parameters.charge_transfer = ChargeTransfer<Jet>{
          Variable("i_0", best_.rates.charge_transfer_A, searched), Table(layout_.transfer())};
    }
  }

  CellParameters<Jet> parameters;

 private:
  static Jet Variable(const std::string& name,
                      double value,
                      const std::vector<JointFit::Rate>& searched) {
    for (std::size_t k = 0; k < searched.size(); ++k) {
      if (searched[k].name == name) return Jet(value, static_cast<int>(k));
    }
    return Jet(value);
  }

  [[nodiscard]] Resistance<Jet> Table(int at) const {
    const auto& nodes = best_.structure.resistance_soc;
    if (nodes.size() == 1) return {Jet(best_.x[at] * per_A_)};
    std::vector<Jet> values;
    for (int k = 0; k < layout_.nodes(); ++k) values.emplace_back(best_.x[at + k] * per_A_);
    return {nodes, std::move(values)};
  }

  const JointSolution& best_;
  JointLayout layout_;
  double per_A_;
};

// Sums from column (or entry) k to the last of the voltages: from nodes to rises.
template <class Matrix>
void SuffixSumColumns(Matrix& m, int voltages) {
  for (Eigen::Index k = voltages - 2; k >= 0; --k) m.col(k) += m.col(k + 1);
}

class Assessment {
 public:
  Assessment(const JointResult& result, std::vector<std::string> rates)
      : result_(result),
        best_(result.choice.best),
        layout_(best_.structure),
        rates_(std::move(rates)),
        size_(static_cast<Eigen::Index>(rates_.size()) + layout_.size()) {}

  [[nodiscard]] std::vector<Eigen::Index> Held() const {
    std::vector<Eigen::Index> held;
    for (std::size_t k = 0; k < best_.at_zero.size(); ++k) {
      if (best_.at_zero[k]) held.push_back(Linear(static_cast<int>(k)));
    }
    for (std::size_t k = 0; k < rates_.size(); ++k) {
      if (AtBound(rates_[k])) held.push_back(static_cast<Eigen::Index>(k));
    }
    return held;
  }

  std::vector<TrustedQuantity> Quantities() {
    AddAlpha();
    AddRate("beta", "beta", "s^-1/2", best_.rates.beta_per_sqrt_s);
    AddTable("r_s", layout_.series());
    std::vector<int> order;
    for (int j = 0; j < best_.structure.branches; ++j) order.push_back(j);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      return best_.rates.time_constant_s[a] < best_.rates.time_constant_s[b];
    });
    for (std::size_t place = 0; place < order.size(); ++place) {
      const int j = order[place];
      const double tau_s = best_.rates.time_constant_s[j];
      AddTable(fmt::format("r_{}", place + 1), layout_.branch(j));
      AddRate(fmt::format("tau_{}", j + 1), fmt::format("tau_{}", place + 1), "s", tau_s);
      AddCapacitance(fmt::format("tau_{}", j + 1), fmt::format("c_{}", place + 1), j, tau_s);
    }
    if (best_.structure.charge_transfer) {
      AddTable("r_ct", layout_.transfer());
      AddRate("i_0", "i_0", "A", best_.rates.charge_transfer_A);
    }
    if (layout_.tables() > 1) AddTotal();
    if (best_.structure.self_heating) {
      const double per_A3 = std::pow(result_.logs.typical_A, -3.0);
      TrustedQuantity q = Quantity("rho_h", "Ohm/A^2", best_.x[layout_.heating()] * per_A3, 0.0);
      q.combination[Linear(layout_.heating())] = per_A3;
      q.at_bound = best_.at_zero[static_cast<std::size_t>(layout_.heating())] != 0;
      Add(std::move(q));
      AddRate("tau_h", "tau_h", "s", best_.rates.heating_time_constant_s);
    }
    return std::move(quantities_);
  }

 private:
  [[nodiscard]] Eigen::Index Linear(int unknown) const {
    return static_cast<Eigen::Index>(rates_.size()) + unknown;
  }
  [[nodiscard]] bool AtBound(const std::string& rate) const {
    return std::find(best_.at_bound.begin(), best_.at_bound.end(), rate) != best_.at_bound.end();
  }
  [[nodiscard]] TrustedQuantity Quantity(std::string name,
                                         std::string unit,
                                         double value,
                                         double lower) const {
    TrustedQuantity q;
    q.name = std::move(name);
    q.unit = std::move(unit);
    q.value = value;
    q.lower = lower;
    q.combination = Eigen::VectorXd::Zero(size_);
    return q;
  }
  void Add(TrustedQuantity q) { quantities_.push_back(std::move(q)); }
  [[nodiscard]] Eigen::Index Searched(const std::string& rate) const {
    const auto found = std::find(rates_.begin(), rates_.end(), rate);
    return found == rates_.end() ? -1 : found - rates_.begin();
  }

  void AddRate(const std::string& rate, std::string name, std::string unit, double value) {
    const Eigen::Index at = Searched(rate);
    if (at < 0) return;  // given
    TrustedQuantity q = Quantity(std::move(name), std::move(unit), value, 0.0);
    if (rate == "beta") q.upper = 1.0;
    q.combination[at] = 1.0;
    q.at_bound = AtBound(rate);
    Add(std::move(q));
  }

  void AddTable(const std::string& name, int table) {
    const double per_A = 1.0 / result_.logs.typical_A;
    const auto& nodes = best_.structure.resistance_soc;
    const auto held = [&](int k) {
      return best_.at_zero[static_cast<std::size_t>(table) + static_cast<std::size_t>(k)] != 0;
    };
    if (nodes.size() == 1) {
      if (result_.fixed.count(name) > 0) return;
      TrustedQuantity q = Quantity(name, "Ohm", best_.x[table] * per_A, 0.0);
      q.combination[Linear(table)] = per_A;
      q.at_bound = held(0);
      Add(std::move(q));
      return;
    }
    NodeFinder find(nodes);
    for (const double soc : {0.2, 0.5, 0.8}) {
      if (soc < nodes.front() || soc > nodes.back()) continue;
      const NodeShare at = find(soc);
      const double low = best_.x[table + at.lower];
      const double high = best_.x[table + at.lower + 1];
      TrustedQuantity q = Quantity(fmt::format("{}({:.1f})", name, soc),
                                   "Ohm",
                                   ((1.0 - at.share) * low + at.share * high) * per_A,
                                   0.0);
      q.combination[Linear(table + at.lower)] = (1.0 - at.share) * per_A;
      q.combination[Linear(table + at.lower + 1)] = at.share * per_A;
      q.at_bound = q.value <= 0.0;
      Add(std::move(q));
    }
  }

  // What a small steady current sees at half charge: often known where its parts are not.
  void AddTotal() {
    const double per_A = 1.0 / result_.logs.typical_A;
    const auto& nodes = best_.structure.resistance_soc;
    const NodeShare at = NodeFinder(nodes)(0.5);
    TrustedQuantity q = Quantity("r_total(0.5)", "Ohm", 0.0, 0.0);
    for (int t = 0; t < layout_.tables(); ++t) {
      const int k = layout_.table(t) + at.lower;
      q.combination[Linear(k)] += (1.0 - at.share) * per_A;
      if (nodes.size() > 1) q.combination[Linear(k + 1)] += at.share * per_A;
      q.value += (1.0 - at.share) * best_.x[k] * per_A;
      if (nodes.size() > 1) q.value += at.share * best_.x[k + 1] * per_A;
    }
    Add(std::move(q));
  }

  // c = tau/r, where r is one number.
  void AddCapacitance(const std::string& rate, std::string name, int j, double tau_s) {
    const Eigen::Index at = Searched(rate);
    const double r = best_.x[layout_.branch(j)] / result_.logs.typical_A;
    if (layout_.nodes() != 1 || !(r > 0.0) || at < 0) return;
    TrustedQuantity q = Quantity(std::move(name), "F", tau_s / r, 0.0);
    q.combination[at] = 1.0 / r;
    q.combination[Linear(layout_.branch(j))] = -tau_s / (r * r) / result_.logs.typical_A;
    q.at_bound = AtBound(rate);
    Add(std::move(q));
  }

  // alpha' = alpha (1 - A_0), A_0 where the line through two nodes is the cut-off.
  void AddAlpha() {
    const CutoffPoint& cutoff = result_.cutoff;
    if (!cutoff.found) return;
    TrustedQuantity q = Quantity("alpha", "C", result_.alpha_C, 0.0);
    // Of nodes; of rises the suffix sums of these.
    const double of_lower = -result_.setup.alpha_C * cutoff.per_lower_V;
    const double of_upper = -result_.setup.alpha_C * cutoff.per_upper_V;
    for (std::size_t k = 0; k <= cutoff.upper; ++k) {
      q.combination[Linear(static_cast<int>(k))] = of_upper + (k <= cutoff.lower ? of_lower : 0.0);
    }
    Add(std::move(q));
  }

  const JointResult& result_;
  const JointSolution& best_;
  JointLayout layout_;
  std::vector<std::string> rates_;
  Eigen::Index size_;
  std::vector<TrustedQuantity> quantities_;
};

}  // namespace

JointSensitivities FindSensitivities(const JointResult& result) {
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  JointKnowledge known;
  known.fixed = result.fixed;
  const JointFit fit(result.logs, result.setup, known);
  const auto searched = fit.Rates(best.structure);
  JointSensitivities all;
  for (const auto& rate : searched) all.rates.push_back(rate.name);
  const auto count = static_cast<Eigen::Index>(searched.size());

  const VariableCell cell(result, searched);
  const CellModel<Jet> model(cell.parameters);
  auto rows = LinearRows(result.logs, result.setup, best.structure, best.rates, best.x);
  all.logs.resize(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t l) {
    const JointLog& log = result.logs.logs[l];
    FittedRows& out = all.logs[l];
    const auto n = rows[l].residual_V.size();
    out.residual_V = std::move(rows[l].residual_V);
    out.weight.resize(n);
    out.averaged.resize(n);
    out.sensitivity.resize(n, count + layout.size());
    SuffixSumColumns(rows[l].sensitivity, layout.voltages());
    out.sensitivity.rightCols(layout.size()) = rows[l].sensitivity;

    auto state = model.Relaxed(Jet(1.0 - log.delivered_C / result.setup.alpha_C));
    IntervalCache<CellModel<Jet>::Step> cache;
    Eigen::Index row = 0;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) {
        const double dt_s = log.time_s[k] - log.time_s[k - 1];
        auto& step = cache.Get(dt_s, log.time_s[k], [&](double dt, CellModel<Jet>::Step& made) {
          model.MakeStep(dt, made);
        });
        step.dt_s = dt_s;
        model.Advance(state, Jet(log.step_A[k]), step);
      }
      if (row == n || rows[l].point[static_cast<std::size_t>(row)] != k) continue;
      const Jet voltage = model.Voltage(state, Jet(log.current_A[k]));
      out.time_s.push_back(log.time_s[k]);
      out.weight[row] = log.weight[k];
      out.averaged[row] = log.count[k];
      for (Eigen::Index r = 0; r < count; ++r) out.sensitivity(row, r) = voltage.v[r];
      ++row;
    }
  });
  return all;
}

TrustReport AssessJoint(const JointResult& result, const TrustOptions& options) {
  const JointSensitivities sensitivities = FindSensitivities(result);
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  const auto count = static_cast<Eigen::Index>(sensitivities.rates.size());

  JointKnowledge known;
  const JointFit fit(result.logs, result.setup, known);
  Eigen::MatrixXd nodes = fit.Penalty(best.structure, best.smoothness);
  SuffixSumColumns(nodes, layout.voltages());
  nodes.transposeInPlace();
  SuffixSumColumns(nodes, layout.voltages());
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(count + layout.size(), count + layout.size());
  penalty.bottomRightCorner(layout.size(), layout.size()) = nodes;

  Assessment assessment(result, sensitivities.rates);
  TrustOptions with_held = options;
  const auto held = assessment.Held();
  with_held.held.insert(with_held.held.end(), held.begin(), held.end());
  const auto quantities = assessment.Quantities();
  with_held.drawn = DrawnOfJoint(result, quantities, count);
  return AssessTrust(sensitivities.logs, penalty, quantities, with_held);
}

}  // namespace lipoid
