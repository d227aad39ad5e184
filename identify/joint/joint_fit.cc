#include "identify/joint/joint_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/fit/bounded_quadratic.h"
#include "identify/fit/grid.h"
#include "identify/optimizers/nlopt_methods.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/core/stop.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

// A branch without resistance follows the current at once: so does one of a nanosecond.
constexpr double kInstant_s = 1e-9;
// A step of the current shows r_s and what the branches and the charge transfer add within one row.
// Where rows cannot tell these apart, a table of r_s would go to zero at one state of charge and far
// beyond any step at another: it stays within these parts of the median step.
constexpr double kLeastOfEdge = 0.15;
constexpr double kMostOfEdge = 2.0;
// Half of what charge and discharge differ by: lithium iron phosphate has 20 mV, silicon 150.
constexpr double kMostHysteresis_V = 0.25;

// A quadratic of node voltages as one of their rises.
void TurnToRises(NormalEquations& sum, int voltages) {
  sum.matrix.triangularView<Eigen::StrictlyUpper>() = sum.matrix.transpose();
  ToRises(sum.matrix, voltages);
  sum.matrix.transposeInPlace();
  ToRises(sum.matrix, voltages);
  ToRises(sum.right.transpose(), voltages);
}

// Every so-manieth node, so that no more than `most` are left.
std::vector<double> Thin(const std::vector<double>& nodes, std::size_t most) {
  if (nodes.size() <= most) return nodes;
  const std::size_t step = (nodes.size() + most - 2) / (most - 1);
  std::vector<double> thin;
  for (std::size_t k = 0; k + 1 < nodes.size(); k += step) thin.push_back(nodes[k]);
  thin.push_back(nodes.back());
  return thin;
}

JointStructure Coarsen(JointStructure structure) {
  structure.resistance_soc = Thin(structure.resistance_soc, 13);
  structure.voltage_soc = Thin(structure.voltage_soc, 40);
  return structure;
}

// The ends of what is searched are where the logs show nothing any more, and a search stops short of them. A bound that
// was given may lie beside what the logs know.
std::vector<std::string> AtBound(const std::vector<JointRate>& searched,
                                 const GivenParameters& known,
                                 JointRates rates) {
  constexpr double kNear = 1.001;
  constexpr double kNearGiven = 1.0 + 1e-6;
  std::vector<std::string> names;
  for (const JointRate& rate : searched) {
    const double value = rate.In(rates);
    const double near = known.Bounds(rate.name) ? kNearGiven : kNear;
    if (value <= rate.lower * near || value >= rate.upper / near) names.push_back(rate.name);
  }
  return names;
}

// The best of the solutions on a grid of rates, the best first, each the bottom of a valley: none is
// cheaper that is one step of the grid away, at most, in each of the rates. What starts on the side of
// a valley ends where its bottom does.
std::vector<JointSolution> BestOf(std::vector<JointSolution> grid,
                                  std::size_t most,
                                  const std::vector<JointRate>& rates) {
  std::stable_sort(
      grid.begin(), grid.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<std::vector<std::ptrdiff_t>> step(grid.size());  // of the grid, in each rate
  for (const JointRate& rate : rates) {
    std::vector<double> values;
    for (JointSolution& solution : grid) values.push_back(rate.In(solution.rates));
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const auto at = std::lower_bound(values.begin(), values.end(), rate.In(grid[k].rates));
      step[k].push_back(at - values.begin());
    }
  }
  const auto neighbours = [&](std::size_t a, std::size_t b) {
    return std::equal(step[a].begin(), step[a].end(), step[b].begin(), [](auto i, auto j) {
      return std::abs(i - j) <= 1;
    });
  };
  std::vector<JointSolution> best;
  for (std::size_t k = 0; k < grid.size() && best.size() < most; ++k) {
    bool bottom = true;
    for (std::size_t cheaper = 0; bottom && cheaper < k; ++cheaper)
      bottom = !neighbours(cheaper, k);
    if (bottom) best.push_back(grid[k]);
  }
  return best;
}

// Least squares over the coordinates of the rates (JointRate), with the linear unknowns at their best for each:
// variable projection. The Jacobian is Kaufman's: slopes at fixed linear unknowns, less what the
// free linear unknowns can follow.
class RatesProblem : public LeastSquaresProblem {
 public:
  RatesProblem(const JointFit& fit, const JointSolution& from)
      : fit_(fit), best_(from), last_(from), rates_(fit.Rates(from.structure)) {}

  [[nodiscard]] int size() const override { return static_cast<int>(rates_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override { return Bound(&JointRate::lower); }
  [[nodiscard]] Eigen::VectorXd upper() const override { return Bound(&JointRate::upper); }
  [[nodiscard]] Eigen::VectorXd Point(JointRates rates) const {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) {
      x[k] =
          rates_[k].Coordinate(std::clamp(rates_[k].In(rates), rates_[k].lower, rates_[k].upper));
    }
    return x;
  }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override {
    const int p = size();
    JointRates rates = best_.rates;
    for (int k = 0; k < p; ++k) {
      // exp(log(bound)) may miss the bound by a rounding.
      rates_[k].In(rates) = std::clamp(rates_[k].Value(x[k]), rates_[k].lower, rates_[k].upper);
    }
    ProjectedSlopes slopes;
    last_ = fit_.Solve(
        best_.structure, rates, best_.smoothness, last_.active, jacobian ? &slopes : nullptr);
    const double cost = last_.cost;
    if (cost < best_.cost) best_ = last_;
    if (!std::isfinite(cost)) {
      return Eigen::MatrixXd::Constant(p + 1, p + 1, std::numeric_limits<double>::quiet_NaN());
    }
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(p + 1, p + 1);
    const double norm = std::sqrt(std::max(cost, 0.0));
    factor(p, p) = norm;
    if (!jacobian) return factor;
    // The root of [J'J J'r; r'J r'r], from the eigenvectors of J'J, which may be singular.
    Eigen::VectorXd scale(p);
    for (int k = 0; k < p; ++k) scale[k] = rates_[k].Slope(rates_[k].In(rates));
    const Eigen::MatrixXd square = scale.asDiagonal() * slopes.square * scale.asDiagonal();
    const Eigen::VectorXd right = scale.cwiseProduct(slopes.with_residual);
    const SymmetricEigen eigen = EigenOfSymmetric(square);
    const double least = 1e-14 * std::max(eigen.values[p - 1], 0.0);
    double rest = cost;
    for (int k = 0; k < p; ++k) {
      const double value = eigen.values[k];
      if (!(value > least)) continue;
      const double root = std::sqrt(value);
      factor.row(k).head(p) = root * eigen.vectors.col(k).transpose();
      factor(k, p) = eigen.vectors.col(k).dot(right) / root;
      rest -= factor(k, p) * factor(k, p);
    }
    factor(p, p) = std::sqrt(std::max(rest, 0.0));
    return TriangularFactor(factor);
  }
  [[nodiscard]] const JointSolution& best() const { return best_; }

 private:
  [[nodiscard]] Eigen::VectorXd Bound(double JointRate::*which) const {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) x[k] = rates_[k].Coordinate(rates_[k].*which);
    return x;
  }

  const JointFit& fit_;
  mutable JointSolution best_;  // one thread asks
  mutable JointSolution last_;  // its active bounds are the guess for the next
  std::vector<JointRate> rates_;
};

}  // namespace

void SortBranches(JointSolution& solution) {
  const std::vector<double> taus = solution.rates.time_constant_s;
  const std::vector<double> energies = solution.rates.branch_J_per_mol;
  const std::size_t n = taus.size();
  if (solution.x.size() == 0) return;
  const JointLayout layout(solution.structure);
  const auto resistance = [&](std::size_t j) {
    return solution.x.segment(layout.branch(static_cast<int>(j)), layout.nodes());
  };
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) {
    const bool a_gone = resistance(a).isZero(0.0);
    const bool b_gone = resistance(b).isZero(0.0);
    return a_gone != b_gone ? b_gone : taus[a] < taus[b];
  });
  const JointSolution before = solution;
  for (std::size_t j = 0; j < n; ++j) {
    const int from = layout.branch(static_cast<int>(order[j]));
    const int to = layout.branch(static_cast<int>(j));
    solution.rates.time_constant_s[j] = taus[order[j]];
    if (!energies.empty()) solution.rates.branch_J_per_mol[j] = energies[order[j]];
    solution.follows[j] = before.follows[order[j]];
    solution.x.segment(to, layout.nodes()) = before.x.segment(from, layout.nodes());
    std::copy_n(before.active.begin() + from, layout.nodes(), solution.active.begin() + to);
    for (const char* symbol : {"tau", "E"}) {
      const auto name = fmt::format("{}_{}", symbol, order[j] + 1);
      for (std::size_t k = 0; k < before.at_bound.size(); ++k) {
        if (before.at_bound[k] == name) solution.at_bound[k] = fmt::format("{}_{}", symbol, j + 1);
      }
    }
  }
}

JointRates JointFit::Base(const JointStructure& structure) const {
  JointRates rates;
  rates.time_constant_s.resize(static_cast<std::size_t>(structure.branches));
  if (structure.temperature && structure.shared_energies == SharedEnergies::kNone)
    rates.branch_J_per_mol.resize(rates.time_constant_s.size());
  for (const JointRate& rate : AllRates(structure, setup_, scales_)) {
    rate.In(rates) = known_.Fixed(rate.name).value_or(known_.Start(rate.name).value_or(rate.start));
  }
  for (int j = 1; j <= structure.branches; ++j) {
    const auto r = known_.Fixed(fmt::format("r_{}", j));
    const auto c = known_.Fixed(fmt::format("c_{}", j));
    if (r && c)
      rates.time_constant_s[static_cast<std::size_t>(j - 1)] = std::max(*r * *c, kInstant_s);
  }
  return rates;
}

std::vector<JointRate> JointFit::Rates(const JointStructure& structure) const {
  std::vector<JointRate> rates = AllRates(structure, setup_, scales_);
  std::erase_if(rates, [&](const JointRate& rate) {
    if (known_.Fixed(rate.name)) return true;
    if (!rate.name.starts_with("tau_") || rate.name == "tau_h") return false;
    return known_.Fixed(fmt::format("r_{}", rate.index + 1)) &&
           known_.Fixed(fmt::format("c_{}", rate.index + 1));
  });
  for (JointRate& rate : rates) {
    const auto bounds = known_.Bounds(rate.name);
    if (!bounds) continue;
    if (bounds->first > 0.0) rate.lower = bounds->first;  // its logarithm is searched
    rate.upper = bounds->second;
    if (rate.upper < rate.lower) {
      throw OptionError(fmt::format(
          "--bounds {}: expected an upper bound of at least {}", rate.name, rate.lower));
    }
  }
  return rates;
}

Eigen::MatrixXd JointFit::Penalty(const JointStructure& structure, double smoothness) const {
  const JointLayout layout(structure);
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  const double second = smoothness * smoothness * scales_.weight_sum;
  const auto bend = [&](int first, int count, double weight) {
    for (int k = first; k + 2 < first + count; ++k) {
      const Eigen::Vector3d d(1.0, -2.0, 1.0);
      penalty.block<3, 3>(k, k) += weight * d * d.transpose();
    }
  };
  const auto slope = [&](int first, int count, double weight) {
    for (int k = first; k + 1 < first + count; ++k) {
      const Eigen::Vector2d d(1.0, -1.0);
      penalty.block<2, 2>(k, k) += weight * d * d.transpose();
    }
  };
  bend(0, layout.voltages(), second);
  slope(0, layout.voltages(), 1e-6 * second);  // a curve that no row reaches keeps its shape
  for (int t = 0; t < layout.tables(); ++t) {
    if (!setup_.held || layout.nodes() == 1) {
      const bool branch = t > 0 && t <= structure.branches;
      const double times = branch ? structure.branch_smoothness : 1.0;
      bend(layout.table(t), layout.nodes(), times * times * second);
      slope(layout.table(t), layout.nodes(), 0.01 * second);
      // Far from every load a resistance goes on as a constant: a slow discharge cannot tell it from
      // v_oc. Under load A is below the state of charge that is counted here.
      constexpr double kFar = 0.05;
      constexpr double kLevel = 1e-7;  // a millivolt costs as much as 0.3 uV in every row
      for (int k = 0; k + 1 < layout.nodes(); ++k) {
        const auto& soc = structure.resistance_soc;
        if (soc[static_cast<std::size_t>(k) + 1] < scales_.lowest_loaded_soc - kFar ||
            soc[static_cast<std::size_t>(k)] > scales_.highest_loaded_soc + kFar)
          slope(layout.table(t) + k, 2, kLevel * scales_.weight_sum);
      }
      continue;
    }
    // The ratio to the shape that is held, in the unit of its mean, goes on as a constant.
    slope(layout.table(t), layout.nodes(), second);
    Eigen::VectorXd ratio(layout.nodes());
    for (int k = 0; k < layout.nodes(); ++k) {
      ratio[k] =
          1.0 / setup_.held->Resistance(t, structure.resistance_soc[static_cast<std::size_t>(k)]);
    }
    ratio /= ratio.mean();
    auto block = penalty.block(layout.table(t), layout.table(t), layout.nodes(), layout.nodes());
    block = (ratio.asDiagonal() * block * ratio.asDiagonal()).eval();
  }
  for (const JointTable& table : OtherTables(structure, scales_.typical_A)) {
    bend(table.first, static_cast<int>(table.soc.size()), second);
    slope(table.first, static_cast<int>(table.soc.size()), 0.01 * second);
  }
  return penalty;
}

JointSolution JointFit::SolveSums(const JointStructure& structure,
                                  const JointRates& rates,
                                  double smoothness,
                                  const NormalEquations& sum,
                                  const std::vector<char>& guess,
                                  Eigen::MatrixXd* information) const {
  const JointLayout layout(structure);
  const int n = layout.size();
  const int voltages = layout.voltages();
  NormalEquations all = sum;
  all.matrix += Penalty(structure, smoothness);
  // What no row and no difference sees stays at the reference, or at zero.
  const double largest = all.matrix.diagonal().maxCoeff();
  const double floor = largest > 0.0 ? 1e-13 * largest : 1.0;
  all.matrix.diagonal().array() += floor;
  NormalEquations rises = all;
  TurnToRises(rises, voltages);

  JointSolution solution;
  Eigen::VectorXd lower = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd upper = Eigen::VectorXd::Constant(n, kInfinity);
  for (int k = 0; k < voltages; ++k) {
    lower[k] = k == 0 ? -kInfinity
                      : -(setup_.open_circuit_voltage(structure.voltage_soc[k]) -
                          setup_.open_circuit_voltage(structure.voltage_soc[k - 1]));
  }
  // Without a bound slow relaxation in the cold, which looks like a lower v_oc, would take its place.
  const double most_entropy_V = kMostEntropy_V_per_K * kEntropyScale_K;
  lower.segment(layout.entropy(), layout.entropies()).setConstant(-most_entropy_V);
  upper.segment(layout.entropy(), layout.entropies()).setConstant(most_entropy_V);
  upper.segment(layout.hysteresis(), layout.hystereses()).setConstant(kMostHysteresis_V);
  if (setup_.held) {
    const Cell& held = setup_.held->cell;
    for (int k = 0; k < layout.entropies(); ++k) {
      const int at = layout.entropy() + k;
      lower[at] = upper[at] =
          (*held.temperature->entropy)(structure.entropy_soc[static_cast<std::size_t>(k)]) *
          kEntropyScale_K;
    }
    for (int k = 0; k < layout.hystereses(); ++k) {
      const int at = layout.hysteresis() + k;
      lower[at] = upper[at] =
          held.hysteresis->Voltage(structure.hysteresis_soc[static_cast<std::size_t>(k)], 1.0);
    }
  }
  const auto bound = [&](const std::string& name, int table, double per_value) {
    const auto ends = known_.Range(name);
    if (!ends) return;
    for (int k = table; k < table + layout.nodes(); ++k) {
      lower[k] = std::max(lower[k], ends->first * per_value);
      upper[k] = std::min(upper[k], ends->second * per_value);
    }
  };
  bound("r_s", layout.series(), scales_.typical_A);
  if (structure.nodes() > 1 && !known_.Range("r_s") && !setup_.held &&
      std::isfinite(setup_.edge_resistance_Ohm)) {
    const double edge = setup_.edge_resistance_Ohm * scales_.typical_A;
    for (int k = layout.series(); k < layout.series() + layout.nodes(); ++k) {
      lower[k] = kLeastOfEdge * edge;
      upper[k] = kMostOfEdge * edge;
    }
  }
  for (int j = 0; j < structure.branches; ++j) {
    const int table = layout.branch(j);
    bound(fmt::format("r_{}", j + 1), table, scales_.typical_A);
    const auto c = known_.Range(fmt::format("c_{}", j + 1));
    if (!c || known_.Fixed(fmt::format("r_{}", j + 1))) continue;
    // r_j = tau_j/c_j.
    const double per_F = rates.time_constant_s[static_cast<std::size_t>(j)] * scales_.typical_A;
    lower[table] = std::max(lower[table], per_F / c->second);
    upper[table] = std::min(upper[table], per_F / c->first);
  }

  solution.structure = structure;
  solution.rates = rates;
  solution.smoothness = smoothness;
  BoundedQuadraticResult best =
      MinimizeBoundedQuadratic(rises.matrix, rises.right, lower, guess, upper);
  if (!best.solved) return solution;
  solution.x = std::move(best.x);
  for (int k = 1; k < voltages; ++k) solution.x[k] += solution.x[k - 1];
  solution.active = std::move(best.active);
  for (int j = 0; j < structure.branches; ++j) {
    const auto c = known_.Range(fmt::format("c_{}", j + 1));
    const auto table = static_cast<std::size_t>(layout.branch(j));
    const double per_F = rates.time_constant_s[static_cast<std::size_t>(j)] * scales_.typical_A;
    const double at =
        solution.active[table] == 2 ? upper[layout.branch(j)] : lower[layout.branch(j)];
    solution.follows.push_back(c && solution.active[table] != 0 &&
                               (at == per_F / c->second || at == per_F / c->first) &&
                               !known_.Fixed(fmt::format("tau_{}", j + 1)));
  }
  solution.cost = all.At(solution.x);
  solution.square = sum.At(solution.x);
  if (information != nullptr) *information = std::move(rises.matrix);
  return solution;
}

JointSolution JointFit::Solve(const JointStructure& structure,
                              const JointRates& rates,
                              double smoothness,
                              const std::vector<char>& guess,
                              ProjectedSlopes* slopes) const {
  ++evaluations_;
  const auto rows = seen_.At(rates, slopes != nullptr);
  const NormalEquations all = rows->Sum(structure, rates);
  Eigen::MatrixXd information;
  JointSolution solution = SolveSums(structure, rates, smoothness, all, guess, &information);
  const std::vector<JointRate> searched = Rates(structure);
  solution.at_bound = AtBound(searched, known_, rates);
  if (slopes == nullptr || solution.x.size() == 0) return solution;

  SlopeSums sums = rows->Slopes(structure, rates, solution.x);
  const JointLayout layout(structure);
  const RateSlots slots(structure);
  for (int j = 0; j < structure.branches; ++j) {
    if (!solution.follows[static_cast<std::size_t>(j)]) continue;
    // The slope of r_j comes with that of tau_j: dr_j/dtau_j = r_j/tau_j.
    const int t = slots.tau(j);
    const int r = layout.branch(j);
    const double rise = solution.x[r] / rates.time_constant_s[static_cast<std::size_t>(j)];
    const Eigen::VectorXd row =
        all.matrix.selfadjointView<Eigen::Lower>() * Eigen::VectorXd::Unit(solution.x.size(), r);
    sums.of_rates.row(t) += rise * sums.with_linear.col(r).transpose();
    sums.of_rates.col(t) += rise * sums.with_linear.col(r);
    sums.of_rates(t, t) += rise * rise * row[r];
    sums.with_residual[t] += rise * sums.right[r];
    sums.with_linear.row(t) += rise * row.transpose();
  }
  std::vector<int> free;
  for (std::size_t k = 0; k < solution.active.size(); ++k) {
    if (!solution.active[k]) free.push_back(static_cast<int>(k));
  }
  const Eigen::MatrixXd part =
      information.selfadjointView<Eigen::Lower>().toDenseMatrix()(free, free);
  if (smoothness == 0.0 && layout.voltages() == 0) Refine(free, part, sums, solution);
  std::vector<int> slot;
  for (const JointRate& rate : searched) slot.push_back(rate.slot);
  Eigen::MatrixXd with_linear = sums.with_linear(slot, Eigen::all);
  ToRises(with_linear, layout.voltages());
  const Eigen::MatrixXd across = with_linear(Eigen::all, free).transpose();
  slopes->square = sums.of_rates(slot, slot);
  slopes->square -= across.transpose() * SolvePositive(part, across);
  slopes->with_residual = -sums.with_residual(slot);
  return solution;
}

// Where nothing smooths and v_oc is given the sums of the residuals themselves have the digits that
// the normal equations lose: a step of iterative refinement, and the cost by those sums. None that
// leads to a negative resistance: of a branch as fast as the rows only the sum with r_s is known.
void JointFit::Refine(const std::vector<int>& free,
                      const Eigen::MatrixXd& part,
                      SlopeSums& sums,
                      JointSolution& solution) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(solution.x.size());
  const Eigen::VectorXd right = sums.right(free);
  step(free) = SolvePositive(part, right);
  const double gain = step.dot(sums.right);
  if (!(gain >= 0.0) || (solution.x + step).minCoeff() < 0.0) return;
  solution.x += step;
  sums.with_residual -= sums.with_linear * step;
  solution.cost = solution.square = std::max(sums.square - gain, 0.0);
}

std::vector<double> JointFit::BetaGrid(const JointStructure& structure,
                                       const JointRates* near) const {
  for (const JointRate& rate : Rates(structure)) {
    if (rate.name != "beta") continue;
    const double lower = std::max(rate.lower, std::min(0.01, rate.upper));
    if (near == nullptr) return GeometricGrid(lower, rate.upper, 9);
    std::vector<double> betas = GeometricGrid(lower, rate.upper, 4);
    betas.push_back(std::clamp(near->beta_per_sqrt_s, rate.lower, rate.upper));
    return betas;
  }
  return {Base(structure).beta_per_sqrt_s};
}

std::vector<JointRates> JointFit::RatesGrid(const JointStructure& structure,
                                            const JointRates* near) const {
  std::vector<JointRates> grid{Base(structure)};
  const auto with = [&](const std::vector<std::vector<double>>& choices, auto&& set) {
    std::vector<JointRates> more;
    for (const JointRates& rates : grid) {
      for (const auto& choice : choices) {
        more.push_back(rates);
        set(more.back(), choice);
      }
    }
    grid = std::move(more);
  };
  std::vector<int> branches;
  double lower_tau_s = scales_.shortest_tau_s;
  double upper_tau_s = scales_.longest_start_tau_s;
  const RateSlots slots(structure);
  for (const JointRate& rate : Rates(structure)) {
    if (rate.slot == slots.beta()) continue;
    if (rate.slot < slots.tau(structure.branches)) {
      branches.push_back(rate.index);
      lower_tau_s = std::max(lower_tau_s, rate.lower);
      upper_tau_s = rate.lower < upper_tau_s ? std::min(upper_tau_s, rate.upper) : rate.upper;
      continue;
    }
    // The neighbour's, where it has it.
    std::vector<double> values = rate.grid;
    JointRates known = near == nullptr ? JointRates{} : *near;
    known.branch_J_per_mol.resize(static_cast<std::size_t>(structure.branches),
                                  std::numeric_limits<double>::quiet_NaN());
    if (std::isfinite(rate.In(known))) values = {rate.In(known)};
    if (values.empty()) continue;
    with(Choices(values, 1), [&](JointRates& r, const auto& c) { rate.In(r) = c[0]; });
  }
  if (branches.empty()) return grid;
  // Not at the ends: there a branch is one with r_s, or with v_oc.
  const auto count = static_cast<int>(branches.size());
  const double margin = std::pow(upper_tau_s / lower_tau_s, 0.08);
  // With v_oc given a point costs little, and valleys that lie close show.
  const int fewest = structure.voltage_soc.empty() ? 8 : 6;
  const auto taus =
      GeometricGrid(lower_tau_s * margin, upper_tau_s / margin, std::max(fewest, count + 3));
  // The neighbour's branches stay where they are, and one more is looked for beside them.
  const std::size_t known = near == nullptr ? 0 : near->time_constant_s.size();
  if (known > 0 && known + 1 >= branches.size() && known <= branches.size()) {
    for (JointRates& rates : grid) {
      for (std::size_t j = 0; j < known; ++j)
        rates.time_constant_s[branches[j]] = near->time_constant_s[branches[j]];
    }
    if (known == branches.size()) return grid;
    with(Choices(taus, 1),
         [&](JointRates& r, const auto& c) { r.time_constant_s[branches[known]] = c[0]; });
    return grid;
  }
  with(Choices(taus, count), [&](JointRates& r, const auto& c) {
    for (int k = 0; k < count; ++k) r.time_constant_s[branches[k]] = c[k];
  });
  return grid;
}

JointSolution JointFit::Search(const JointStructure& structure,
                               double smoothness,
                               const JointSolution* near,
                               int followed) const {
  // Fine tables do not move the valleys: these are found with coarse ones.
  const JointStructure coarse = Coarsen(structure);
  const JointRates* from = near == nullptr || near->x.size() == 0 ? nullptr : &near->rates;
  std::vector<double> betas = BetaGrid(structure, from);
  std::vector<JointRates> line = RatesGrid(structure, from);
  if (!known_.start.empty()) {
    line.push_back(Base(structure));
    if (known_.Start("beta")) betas.push_back(line.back().beta_per_sqrt_s);
  }
  // One line of the grid per beta, along which active bounds are handed on.
  std::vector<std::vector<JointSolution>> lines(betas.size());
  ParallelFor(betas.size(), [&](std::size_t b) {
    JointRates with_beta = line.front();
    with_beta.beta_per_sqrt_s = betas[b];  // energy and offset are those of the whole line
    auto rows = seen_.At(with_beta, false);
    std::vector<char> guess;
    for (JointRates rates : line) {
      StopIfAsked();
      ++evaluations_;
      rates.beta_per_sqrt_s = betas[b];
      if (structure.free_alpha && rates.alpha_C != with_beta.alpha_C) {
        with_beta.alpha_C = rates.alpha_C;
        rows = seen_.At(with_beta, false);
      }
      JointSolution solution =
          SolveSums(coarse, rates, smoothness, rows->Sum(coarse, rates), guess);
      guess = solution.active;
      lines[b].push_back(std::move(solution));
    }
  });
  std::vector<JointSolution> grid;
  for (auto& of_beta : lines) std::move(of_beta.begin(), of_beta.end(), std::back_inserter(grid));
  std::vector<JointSolution> best =
      BestOf(std::move(grid), static_cast<std::size_t>(followed), Rates(structure));
  ParallelFor(best.size(), [&](std::size_t k) { best[k] = Approach(std::move(best[k])); });
  JointSolution found = std::move(*std::min_element(
      best.begin(), best.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; }));
  if (coarse != structure && found.x.size() > 0)
    found = Approach(Solve(structure, found.rates, smoothness));
  constexpr double kRoughStep = 6e-3;  // of the logarithms of the rates
  if (!structure.voltage_soc.empty()) return Polish(std::move(found), kRoughStep);
  // Constants are tables, too: where they cost less, the search of the tables ended in another valley.
  if (structure.nodes() == 1 || setup_.held) return found;
  JointStructure constant = structure;
  constant.resistance_soc = {0.5};
  const JointSolution simple = Search(constant, smoothness, near, followed);
  if (!(simple.cost < found.cost)) return found;
  JointSolution other = Approach(Solve(structure, simple.rates, smoothness));
  return other.cost < found.cost ? other : found;
}

// The cost has a kink wherever a row crosses a node of v_oc, and rows of short logs are few: with the
// slope of the segments steps would be as short as the segments, and end in the first small valley.
// The smooth slope leads past them; a direct search, which sees the cost alone, then settles in.
template <class Minimize>
JointSolution JointFit::Descend(JointSolution from, Minimize&& minimize) const {
  const RatesProblem problem(*this, from);
  if (from.x.size() == 0) return from;
  if (problem.size() == 0) {  // what is left is solved exactly
    ProjectedSlopes none;
    from = Solve(from.structure, from.rates, from.smoothness, from.active, &none);
    from.termination = Termination::kConverged;
    from.message = "No rate was to be found.";
    return from;
  }
  const OptimizationSummary summary = minimize(problem, problem.Point(from.rates));
  JointSolution best = problem.best();
  best.termination = summary.termination;
  best.message = summary.message;
  return best;
}

JointSolution JointFit::Approach(JointSolution from, const LevenbergMarquardtOptions& stop) const {
  from.cost = kInfinity;  // by other sums than those of the steps
  return Descend(std::move(from), [&](const RatesProblem& problem, const Eigen::VectorXd& start) {
    return MinimizeLevenbergMarquardt(problem, start, stop);
  });
}

JointSolution JointFit::Polish(JointSolution from,
                               double step_tolerance,
                               int iterations_per_variable) const {
  DirectSearchOptions options;
  options.step_tolerance = step_tolerance;
  // Activation energies are known far less well than other rates, and their valleys are long.
  constexpr int kMoreOfEnergies = 3;
  options.iterations_per_variable =
      iterations_per_variable * (from.structure.temperature ? kMoreOfEnergies : 1);
  return Descend(std::move(from), [&](const RatesProblem& problem, const Eigen::VectorXd& start) {
    return MinimizeWithNlopt(NloptMethod::kBobyqa, problem, start, options);
  });
}

}  // namespace lipoid
