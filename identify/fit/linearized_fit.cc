#include "identify/fit/linearized_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/battery/cell_parameters.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

// Fills in the quantities of a fit whose rows are there.
class Quantities {
 public:
  Quantities(LinearizedFit& fit,
             const JointSolution& solution,
             const GivenParameters& known,
             const std::vector<JointRate>& searched,
             const FitScales& scales,
             const FitAxis& axis)
      : fit_(fit),
        solution_(solution),
        known_(known),
        searched_(searched),
        layout_(solution.structure),
        scales_(scales),
        axis_(axis) {}

  void Fill() {
    AddRate("beta", solution_.rates.beta_per_sqrt_s);
    AddTable("r_s", layout_.series());
    for (int j = 0; j < solution_.structure.branches; ++j) {
      AddTable(fmt::format("r_{}", j + 1), layout_.branch(j));
      AddRate(fmt::format("tau_{}", j + 1), solution_.rates.time_constant_s[j]);
      AddCapacitance(j);
    }
    if (solution_.structure.charge_transfer) {
      AddTable("r_ct", layout_.transfer());
      AddRate("i_0", solution_.rates.charge_transfer_A);
    }
    AddOtherRates();
    for (const JointTable& table : OtherTables(solution_.structure, scales_.typical_A)) {
      if (!table.name.empty()) AddOther(table);
    }
    if (solution_.structure.self_heating) AddRate("tau_h", solution_.rates.heating_time_constant_s);
  }

 private:
  [[nodiscard]] bool Active(int unknown) const {
    return solution_.active[static_cast<std::size_t>(unknown)] != 0;
  }
  /// -1: it was given.
  [[nodiscard]] Eigen::Index Searched(const std::string& rate) const {
    const auto found = std::find(fit_.rates.begin(), fit_.rates.end(), rate);
    return found == fit_.rates.end() ? -1 : found - fit_.rates.begin();
  }
  [[nodiscard]] bool Follows(int j) const { return solution_.follows[static_cast<std::size_t>(j)]; }

  // Far from every load a resistance goes on by assumption, and so would its interval.
  [[nodiscard]] bool Loaded(double soc) const {
    constexpr double kFar = 0.05;
    return soc >= scales_.lowest_loaded_soc - kFar && soc <= scales_.highest_loaded_soc + kFar;
  }

  void AddRate(const std::string& rate, double value) { AddRate(rate, rate, value, 1.0); }
  // The parameter of this name, which is that rate.
  void AddRate(const std::string& name, const std::string& rate, double value, double scale) {
    const Eigen::Index at = Searched(rate);
    if (at < 0) return;
    // The offset is the sensor's, and no cell has it.
    const std::string unit(name == "i_off" ? "A" : CellParameterUnit(name));
    TrustedQuantity q = fit_.Quantity(name, unit, scale * value);
    if (name == "beta") q.upper = 1.0;
    if (name == "i_off") q.lower = -std::numeric_limits<double>::infinity();
    q.combination[at] = scale;
    q.at_bound = solution_.AtBound(rate);
    fit_.quantities.push_back(std::move(q));
  }

  // Those that stand beside no linear unknown.
  void AddOtherRates() {
    const RateSlots slots(solution_.structure);
    JointRates rates = solution_.rates;
    for (const JointRate& rate : searched_) {
      if (rate.slot < slots.diffusion_energy()) continue;
      // The e-folds of hysteresis are counted over the alpha of the cell.
      for (const std::string& name :
           rate.means.empty() ? std::vector<std::string>{rate.name} : rate.means) {
        AddRate(name, rate.name, rate.In(rates), rate.name == "gamma" ? axis_.alpha_ratio : 1.0);
      }
    }
  }

  void AddOther(const JointTable& table) {
    const auto add = [&](std::string name, const NodeShare& at) {
      const int k = table.first + at.lower;
      TrustedQuantity q = fit_.Quantity(
          std::move(name), table.unit, solution_.x[k] * (1.0 - at.share) * table.scale);
      q.combination[fit_.Linear(k)] = (1.0 - at.share) * table.scale;
      q.at_bound = Active(k);
      if (at.share > 0.0) {
        q.value += solution_.x[k + 1] * at.share * table.scale;
        q.combination[fit_.Linear(k + 1)] = at.share * table.scale;
        q.at_bound = q.at_bound && Active(k + 1);
      }
      fit_.quantities.push_back(std::move(q));
    };
    const auto& nodes = table.soc;
    if (nodes.size() == 1) return add(table.name, {});
    NodeFinder find(nodes);
    for (const double soc : {0.2, 0.5, 0.8}) {
      const double on_axis = axis_(soc);
      if (on_axis >= nodes.front() && on_axis <= nodes.back())
        add(fmt::format("{}({:.1f})", table.name, soc), find(on_axis));
    }
  }

  void AddTable(const std::string& name, int table) {
    if (known_.Fixed(name)) return;
    const double per_A = 1.0 / scales_.typical_A;
    const auto& nodes = solution_.structure.resistance_soc;
    if (nodes.size() == 1) {
      TrustedQuantity q = fit_.Quantity(name, "Ohm", solution_.x[table] * per_A);
      q.combination[fit_.Linear(table)] = per_A;
      q.at_bound = Active(table);
      for (int j = 0; j < solution_.structure.branches; ++j) {
        const auto tau = Searched(fmt::format("tau_{}", j + 1));
        if (table != layout_.branch(j) || !Follows(j) || tau < 0) continue;
        q.combination.setZero();  // r_j = tau_j/c_j
        q.combination[tau] = q.value / solution_.rates.time_constant_s[j];
        q.at_bound = false;
      }
      fit_.quantities.push_back(std::move(q));
      return;
    }
    NodeFinder find(nodes);
    for (const double soc : {0.2, 0.5, 0.8}) {
      const double on_axis = axis_(soc);
      if (on_axis < nodes.front() || on_axis > nodes.back() || !Loaded(on_axis)) continue;
      const NodeShare at = find(on_axis);
      const double low = solution_.x[table + at.lower];
      const double high = solution_.x[table + at.lower + 1];
      TrustedQuantity q = fit_.Quantity(fmt::format("{}({:.1f})", name, soc),
                                        "Ohm",
                                        ((1.0 - at.share) * low + at.share * high) * per_A);
      q.combination[fit_.Linear(table + at.lower)] = (1.0 - at.share) * per_A;
      q.combination[fit_.Linear(table + at.lower + 1)] = at.share * per_A;
      q.at_bound = q.value <= 0.0;
      fit_.quantities.push_back(std::move(q));
    }
  }

  // c = tau/r, where r is one number.
  void AddCapacitance(int j) {
    const auto name = fmt::format("c_{}", j + 1);
    const auto rate = fmt::format("tau_{}", j + 1);
    const double tau_s = solution_.rates.time_constant_s[j];
    const double r = solution_.x[layout_.branch(j)] / scales_.typical_A;
    const Eigen::Index at = Searched(rate);
    const bool r_held = known_.Fixed(fmt::format("r_{}", j + 1)).has_value();
    if (layout_.nodes() != 1 || !(r > 0.0) || known_.Fixed(name) || (at < 0 && r_held)) return;
    TrustedQuantity q = fit_.Quantity(name, "F", tau_s / r);
    q.at_bound = Follows(j);
    if (!q.at_bound) {
      if (at >= 0) q.combination[at] = 1.0 / r;
      q.combination[fit_.Linear(layout_.branch(j))] = -tau_s / (r * r) / scales_.typical_A;
    }
    fit_.quantities.push_back(std::move(q));
  }

  LinearizedFit& fit_;
  const JointSolution& solution_;
  const GivenParameters& known_;
  const std::vector<JointRate>& searched_;
  JointLayout layout_;
  const FitScales& scales_;
  FitAxis axis_;
};

}  // namespace

TrustedQuantity LinearizedFit::Quantity(std::string name, std::string unit, double value) const {
  TrustedQuantity q;
  q.name = std::move(name);
  q.unit = std::move(unit);
  q.value = value;
  q.lower = 0.0;
  q.combination = Eigen::VectorXd::Zero(penalty.rows());
  return q;
}

Eigen::MatrixXd LinearizedFit::Project(Eigen::MatrixXd sensitivity,
                                       const JointSolution& solution) const {
  const JointLayout layout(solution.structure);
  const RateSlots all(solution.structure);
  for (int j = 0; j < solution.structure.branches; ++j) {
    if (!solution.follows[static_cast<std::size_t>(j)]) continue;
    // r_j moves with tau_j.
    const int r = layout.branch(j);
    const double rise = solution.x[r] / solution.rates.time_constant_s[j];
    sensitivity.col(all.tau(j)) += rise * sensitivity.col(all.size() + r);
  }
  Eigen::MatrixXd projected(sensitivity.rows(), Linear(layout.size()));
  projected.leftCols(Linear(0)) = sensitivity(Eigen::all, slots);
  projected.rightCols(layout.size()) = sensitivity.rightCols(layout.size());
  ToRises(projected.rightCols(layout.size()), layout.voltages());
  return projected;
}

LinearizedFit Linearize(const Observations& seen,
                        const JointSolution& solution,
                        const GivenParameters& known,
                        const FitAxis& axis) {
  const JointLayout layout(solution.structure);
  const JointFit fit(seen, known);
  LinearizedFit all;
  const std::vector<JointRate> searched = fit.Rates(solution.structure);
  for (const JointRate& rate : searched) {
    all.rates.push_back(rate.name);
    all.slots.push_back(rate.slot);
    if (solution.AtBound(rate.name)) all.held.push_back(all.Linear(0) - 1);
  }
  for (int k = 0; k < layout.size(); ++k) {
    if (solution.active[static_cast<std::size_t>(k)]) all.held.push_back(all.Linear(k));
  }
  all.logs = seen.Rows(solution.structure, solution.rates, solution.x);
  for (FittedRows& log : all.logs)
    log.sensitivity = all.Project(std::move(log.sensitivity), solution);
  Eigen::MatrixXd nodes = fit.Penalty(solution.structure, solution.smoothness);
  ToRises(nodes, layout.voltages());
  nodes.transposeInPlace();
  ToRises(nodes, layout.voltages());
  all.penalty = Eigen::MatrixXd::Zero(all.Linear(layout.size()), all.Linear(layout.size()));
  all.penalty.bottomRightCorner(layout.size(), layout.size()) = nodes;
  Quantities(all, solution, known, searched, seen.scales(), axis).Fill();
  // What was ruled out is in no interval.
  for (TrustedQuantity& q : all.quantities) {
    const auto bounds = known.Bounds(q.name.substr(0, q.name.find('(')));
    if (!bounds) continue;
    q.lower = std::max(q.lower, std::min(bounds->first, q.value));
    q.upper = std::min(q.upper, std::max(bounds->second, q.value));
  }
  return all;
}

Eigen::MatrixXd StepsOf(Eigen::MatrixXd square,
                        Eigen::MatrixXd right,
                        const std::vector<Eigen::Index>& held) {
  for (const Eigen::Index k : held) {
    square.row(k).setZero();
    square.col(k).setZero();
    right.row(k).setZero();
  }
  // In units in which each unknown carries as much as another.
  Eigen::VectorXd unit = square.diagonal();
  for (double& u : unit) u = u > 0.0 ? 1.0 / std::sqrt(u) : 0.0;
  const Eigen::MatrixXd scaled = unit.asDiagonal() * square * unit.asDiagonal();
  Eigen::MatrixXd steps(right.rows(), right.cols());
  for (Eigen::Index k = 0; k < right.cols(); ++k) {
    steps.col(k) = unit.cwiseProduct(ShortestLeastSquares(scaled, unit.cwiseProduct(right.col(k))));
  }
  return steps;
}

}  // namespace lipoid
