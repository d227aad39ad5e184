#include "identify/joint/joint_trust.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "identify/joint/joint_drawn.h"
#include "identify/joint/structure_spread.h"

namespace lipoid {
namespace {

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
    for (int j = 0; j < best_.structure.branches; ++j) {
      const double tau_s = best_.rates.time_constant_s[j];
      const auto tau = fmt::format("tau_{}", j + 1);
      AddTable(fmt::format("r_{}", j + 1), layout_.branch(j));
      AddRate(tau, tau, "s", tau_s);
      AddCapacitance(tau, fmt::format("c_{}", j + 1), j, tau_s);
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
  void Add(TrustedQuantity q) {
    if (q.name != "alpha") {
      q.added_spread = SpreadOverStructures(result_.choice, [&](const JointSolution& solution) {
        return ValueIn(solution, q.name, result_.logs.typical_A, best_);
      });
    }
    quantities_.push_back(std::move(q));
  }
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
    // A curve that lies higher there reaches the cut-off later.
    q.added_spread = SpreadOverStructures(result_.choice, [&](const JointSolution& solution) {
      return (of_lower + of_upper) *
             OpenCircuitVoltageIn(solution, result_.setup.reference, cutoff.soc);
    });
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
  GivenParameters known;
  known.fixed = result.fixed;
  const JointFit fit(result.logs, result.setup, known);
  const auto searched = fit.Rates(best.structure);
  JointSensitivities all;
  for (const auto& rate : searched) all.rates.push_back(rate.name);
  std::vector<int> columns;
  for (const auto& rate : searched) columns.push_back(rate.slot);
  const int slots = RateSlots(best.structure).size();
  for (int k = 0; k < layout.size(); ++k) columns.push_back(slots + k);
  auto rows = AllRows(result.logs, result.setup, best.structure, best.rates, best.x);
  all.logs.resize(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t l) {
    const JointLog& log = result.logs.logs[l];
    FittedRows& out = all.logs[l];
    const auto n = rows[l].residual_V.size();
    out.residual_V = std::move(rows[l].residual_V);
    out.sensitivity = rows[l].sensitivity(Eigen::all, columns);
    ToRises(out.sensitivity.rightCols(layout.size()), layout.voltages());
    out.weight.resize(n);
    out.averaged.resize(n);
    for (Eigen::Index row = 0; row < n; ++row) {
      const std::size_t k = rows[l].point[static_cast<std::size_t>(row)];
      out.time_s.push_back(log.time_s[k]);
      out.weight[row] = log.weight[k];
      out.averaged[row] = log.count[k];
    }
  });
  return all;
}

TrustReport AssessJoint(const JointResult& result, const TrustOptions& options) {
  const JointSensitivities sensitivities = FindSensitivities(result);
  const JointSolution& best = result.choice.best;
  const JointLayout layout(best.structure);
  const auto count = static_cast<Eigen::Index>(sensitivities.rates.size());

  GivenParameters known;
  const JointFit fit(result.logs, result.setup, known);
  Eigen::MatrixXd nodes = fit.Penalty(best.structure, best.smoothness);
  ToRises(nodes, layout.voltages());
  nodes.transposeInPlace();
  ToRises(nodes, layout.voltages());
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
