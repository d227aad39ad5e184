#include "identify/joint/joint_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/fit/grid.h"
#include "identify/optimizers/bobyqa.h"
#include "identify/optimizers/levenberg_marquardt.h"

namespace lipoid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A branch has a time constant of so many sampling intervals at least. A faster one has nearly all
// of its drop in the first row after an edge, where it would stand in for r_s.
constexpr double kShortestTau = 2.0;

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

// Least squares over the logarithms of the rates, with the linear unknowns at their best for each:
// variable projection. The Jacobian is Kaufman's: slopes at fixed linear unknowns, less what the
// free linear unknowns can follow.
class RatesProblem : public LeastSquaresProblem {
 public:
  RatesProblem(const JointFit& fit, const JointSolution& from)
      : fit_(fit), best_(from), last_(from), rates_(fit.Rates(from.structure)) {}

  [[nodiscard]] int size() const override { return static_cast<int>(rates_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) x[k] = std::log(rates_[k].lower);
    return x;
  }
  [[nodiscard]] Eigen::VectorXd upper() const override {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) x[k] = std::log(rates_[k].upper);
    return x;
  }
  [[nodiscard]] Eigen::VectorXd Point(JointRates rates) const {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) {
      x[k] = std::log(
          std::clamp(*rates_[k].entry(rates, rates_[k].index), rates_[k].lower, rates_[k].upper));
    }
    return x;
  }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override {
    const int p = size();
    JointRates rates = best_.rates;
    for (int k = 0; k < p; ++k) {
      // exp(log(bound)) may miss the bound by a rounding.
      *rates_[k].entry(rates, rates_[k].index) =
          std::clamp(std::exp(x[k]), rates_[k].lower, rates_[k].upper);
    }
    ProjectedSlopes slopes;
    last_ = fit_.Solve(
        best_.structure, rates, best_.smoothness, last_.at_zero, jacobian ? &slopes : nullptr);
    const double cost = last_.cost;
    if (cost < best_.cost) best_ = last_;
    if (!std::isfinite(cost)) {
      return Eigen::MatrixXd::Constant(
          p + 1, p + 1, std::numeric_limits<double>::quiet_NaN());
    }
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(p + 1, p + 1);
    const double norm = std::sqrt(std::max(cost, 0.0));
    factor(p, p) = norm;
    if (!jacobian) return factor;
    // The root of [J'J J'r; r'J r'r], from the eigenvectors of J'J, which may be singular.
    Eigen::VectorXd scale(p);
    for (int k = 0; k < p; ++k) scale[k] = *rates_[k].entry(rates, rates_[k].index);
    const Eigen::MatrixXd square = scale.asDiagonal() * slopes.square * scale.asDiagonal();
    const Eigen::VectorXd right = scale.cwiseProduct(slopes.with_residual);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(square);
    const double least = 1e-14 * std::max(eigen.eigenvalues()[p - 1], 0.0);
    double rest = cost;
    for (int k = 0; k < p; ++k) {
      const double value = eigen.eigenvalues()[k];
      if (!(value > least)) continue;
      const double root = std::sqrt(value);
      factor.row(k).head(p) = root * eigen.eigenvectors().col(k).transpose();
      factor(k, p) = eigen.eigenvectors().col(k).dot(right) / root;
      rest -= factor(k, p) * factor(k, p);
    }
    factor(p, p) = std::sqrt(std::max(rest, 0.0));
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(factor);
    return qr.matrixQR().triangularView<Eigen::Upper>();
  }
  [[nodiscard]] const JointSolution& best() const { return best_; }
  [[nodiscard]] const std::vector<JointFit::Rate>& rates() const { return rates_; }

 private:
  const JointFit& fit_;
  mutable JointSolution best_;  // one thread asks
  mutable JointSolution last_;  // its active bounds are the guess for the next
  std::vector<JointFit::Rate> rates_;
};

}  // namespace

void SortBranches(JointSolution& solution) {
  const std::vector<double> taus = solution.rates.time_constant_s;
  const std::size_t n = taus.size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return taus[a] < taus[b]; });
  if (std::is_sorted(order.begin(), order.end()) || solution.x.size() == 0) return;
  const JointLayout layout(solution.structure);
  const JointSolution before = solution;
  for (std::size_t j = 0; j < n; ++j) {
    const int from = layout.branch(static_cast<int>(order[j]));
    const int to = layout.branch(static_cast<int>(j));
    solution.rates.time_constant_s[j] = taus[order[j]];
    solution.x.segment(to, layout.nodes()) = before.x.segment(from, layout.nodes());
    std::copy_n(before.at_zero.begin() + from, layout.nodes(), solution.at_zero.begin() + to);
    const auto name = fmt::format("tau_{}", order[j] + 1);
    for (std::size_t k = 0; k < before.at_bound.size(); ++k) {
      if (before.at_bound[k] == name) solution.at_bound[k] = fmt::format("tau_{}", j + 1);
    }
  }
}

JointFit::JointFit(const JointLogs& logs, const JointSetup& setup, const GivenParameters& known)
    : logs_(logs), setup_(setup), known_(known) {
  // Time constants that logs with steps can show, pulses where there are any.
  double shortest_s = kInfinity;
  double longest_s = 0.0;
  for (const bool pulses : {true, false}) {
    for (const JointLog& log : logs.logs) {
      if ((log.kind == LogKind::kPulses) != pulses) continue;
      shortest_s = std::min(shortest_s, log.shortest_s);
      longest_s = std::max(longest_s, log.longest_s);
    }
    if (std::isfinite(shortest_s)) break;
  }
  shortest_tau_s_ = kShortestTau * shortest_s;
  longest_tau_s_ = std::max(longest_s, 8.0 * shortest_s);
}

JointRates JointFit::Base(const JointStructure& structure) const {
  const auto fixed = [&](const std::string& name, double otherwise) {
    return known_.Fixed(name).value_or(otherwise);
  };
  JointRates rates;
  rates.beta_per_sqrt_s = setup_.diffusion ? fixed("beta", 0.2) : kInfinity;
  for (int j = 1; j <= structure.branches; ++j) {
    rates.time_constant_s.push_back(
        fixed(fmt::format("tau_{}", j), std::sqrt(shortest_tau_s_ * longest_tau_s_)));
  }
  if (structure.self_heating) rates.heating_time_constant_s = fixed("tau_h", 500.0);
  if (structure.charge_transfer) rates.charge_transfer_A = fixed("i_0", 0.15 * logs_.largest_A);
  return rates;
}

std::vector<JointFit::Rate> JointFit::Rates(const JointStructure& structure) const {
  std::vector<Rate> rates;
  const RateSlots slots(structure);
  const auto add = [&](std::string name,
                       double lower,
                       double upper,
                       auto entry,
                       int index,
                       int slot) {
    if (known_.Fixed(name)) return;
    if (const auto bounds = known_.Bounds(name)) {
      lower = std::max(bounds->first, std::numeric_limits<double>::min());
      upper = bounds->second;
    }
    rates.push_back({std::move(name), lower, upper, entry, index, slot});
  };
  if (setup_.diffusion) {
    // Slower than the longest log there is no diffusion to be seen.
    add(
        "beta",
        1e-3,
        1.0,
        [](JointRates& r, int) { return &r.beta_per_sqrt_s; },
        0,
        slots.beta());
  }
  for (int j = 0; j < structure.branches; ++j) {
    add(
        fmt::format("tau_{}", j + 1),
        shortest_tau_s_,
        longest_tau_s_,
        [](JointRates& r, int at) { return &r.time_constant_s[at]; },
        j,
        slots.tau(j));
  }
  if (structure.self_heating) {
    add(
        "tau_h",
        std::max(30.0, 2.0 * shortest_tau_s_),
        1e4,
        [](JointRates& r, int) { return &r.heating_time_constant_s; },
        0,
        slots.heating());
  }
  if (structure.charge_transfer) {
    add(
        "i_0",
        0.01 * logs_.largest_A,
        2.0 * logs_.largest_A,
        [](JointRates& r, int) { return &r.charge_transfer_A; },
        0,
        slots.transfer());
  }
  return rates;
}

Eigen::MatrixXd JointFit::Penalty(const JointStructure& structure, double smoothness) const {
  const JointLayout layout(structure);
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  const double second = smoothness * smoothness * logs_.weight_sum;
  const auto bend = [&](int first, int count) {
    for (int k = first; k + 2 < first + count; ++k) {
      const Eigen::Vector3d d(1.0, -2.0, 1.0);
      penalty.block<3, 3>(k, k) += second * d * d.transpose();
    }
  };
  const auto slope = [&](int first, int count, double weight) {
    for (int k = first; k + 1 < first + count; ++k) {
      const Eigen::Vector2d d(1.0, -1.0);
      penalty.block<2, 2>(k, k) += weight * d * d.transpose();
    }
  };
  bend(0, layout.voltages());
  slope(0, layout.voltages(), 1e-6 * second);  // a curve that no row reaches keeps its shape
  for (int t = 0; t < layout.tables(); ++t) {
    bend(layout.table(t), layout.nodes());
    slope(layout.table(t), layout.nodes(), 0.01 * second);
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
  const double floor = 1e-13 * all.matrix.diagonal().maxCoeff();
  all.matrix.diagonal().array() += floor;
  NormalEquations rises = all;
  TurnToRises(rises, voltages);

  Eigen::VectorXd lower = Eigen::VectorXd::Zero(n);
  std::vector<char> held(static_cast<std::size_t>(n), 0);
  for (int k = 0; k < voltages; ++k) {
    lower[k] = k == 0 ? -kInfinity
                      : -(setup_.reference(structure.voltage_soc[k]) -
                          setup_.reference(structure.voltage_soc[k - 1]));
  }
  const auto hold = [&](const std::string& name, int table) {
    const auto fixed = known_.Fixed(name);
    if (!fixed) return;
    for (int k = table; k < table + layout.nodes(); ++k) {
      held[k] = 1;
      lower[k] = *fixed * logs_.typical_A;
    }
  };
  hold("r_s", layout.series());
  for (int j = 0; j < structure.branches; ++j) hold(fmt::format("r_{}", j + 1), layout.branch(j));

  JointSolution solution;
  solution.structure = structure;
  solution.rates = rates;
  solution.smoothness = smoothness;
  BoundedQuadraticResult best =
      MinimizeBoundedQuadratic(rises.matrix, rises.right, lower, guess, held);
  if (!best.solved) return solution;
  solution.x = std::move(best.x);
  for (int k = 1; k < voltages; ++k) solution.x[k] += solution.x[k - 1];
  solution.at_zero = std::move(best.active);
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
  const SocTrace soc = TraceSoc(logs_, setup_, rates.beta_per_sqrt_s, slopes != nullptr);
  Eigen::MatrixXd information;
  JointSolution solution = SolveSums(structure,
                                     rates,
                                     smoothness,
                                     SumAll(logs_, setup_, structure, soc, rates),
                                     guess,
                                     &information);
  if (slopes == nullptr || solution.x.size() == 0) return solution;

  SlopeSums sums = SumSlopes(logs_, setup_, structure, soc, rates, solution.x, CurveSlope::kSmooth);
  std::vector<int> searched;
  for (const Rate& rate : Rates(structure)) searched.push_back(rate.slot);
  Eigen::MatrixXd with_linear = sums.with_linear(searched, Eigen::all);
  ToRises(with_linear, JointLayout(structure).voltages());
  std::vector<int> free;
  for (std::size_t k = 0; k < solution.at_zero.size(); ++k) {
    if (!solution.at_zero[k]) free.push_back(static_cast<int>(k));
  }
  const Eigen::MatrixXd across = with_linear(Eigen::all, free).transpose();
  const Eigen::LLT<Eigen::MatrixXd> llt(information.selfadjointView<Eigen::Lower>()
                                            .toDenseMatrix()(free, free)
                                            .eval());
  slopes->square = sums.of_rates(searched, searched);
  slopes->square -= across.transpose() * llt.solve(across);
  slopes->with_residual = -sums.with_residual(searched);
  return solution;
}

std::vector<double> JointFit::BetaGrid(const JointStructure& structure,
                                       const JointRates* near) const {
  for (const Rate& rate : Rates(structure)) {
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
  // Two values of tau_h or i_0; one where both are there, for each was found alone before; and none
  // but its own where the neighbour knows it.
  const int values = structure.self_heating && structure.charge_transfer ? 1 : 2;
  std::vector<int> branches;
  double lower_tau_s = shortest_tau_s_;
  double upper_tau_s = longest_tau_s_;
  for (const Rate& rate : Rates(structure)) {
    if (rate.name == "tau_h") {
      auto choices =
          Choices(GeometricGrid(std::max(rate.lower, 100.0), std::min(rate.upper, 2000.0), values), 1);
      if (near != nullptr && std::isfinite(near->heating_time_constant_s))
        choices = {{near->heating_time_constant_s}};
      with(choices, [](JointRates& r, const auto& c) { r.heating_time_constant_s = c[0]; });
    } else if (rate.name == "i_0") {
      auto choices = Choices(GeometricGrid(0.1 * logs_.largest_A, 0.5 * logs_.largest_A, values), 1);
      if (near != nullptr && std::isfinite(near->charge_transfer_A))
        choices = {{near->charge_transfer_A}};
      with(choices, [](JointRates& r, const auto& c) { r.charge_transfer_A = c[0]; });
    } else if (rate.name != "beta") {
      branches.push_back(rate.index);
      lower_tau_s = std::max(lower_tau_s, rate.lower);
      upper_tau_s = std::min(upper_tau_s, rate.upper);
    }
  }
  if (branches.empty()) return grid;
  // Not at the ends: there a branch is one with r_s, or with v_oc.
  const auto count = static_cast<int>(branches.size());
  const double margin = std::pow(upper_tau_s / lower_tau_s, 0.08);
  const auto taus = GeometricGrid(lower_tau_s * margin, upper_tau_s / margin, std::max(6, count + 3));
  // The neighbour's branches stay where they are, and one more is looked for beside them.
  const std::size_t known = near == nullptr ? 0 : near->time_constant_s.size();
  if (known > 0 && known + 1 >= branches.size() && known <= branches.size()) {
    for (JointRates& rates : grid) {
      for (std::size_t j = 0; j < known; ++j)
        rates.time_constant_s[branches[j]] = near->time_constant_s[branches[j]];
    }
    if (known == branches.size()) return grid;
    with(Choices(taus, 1), [&](JointRates& r, const auto& c) {
      r.time_constant_s[branches[known]] = c[0];
    });
    return grid;
  }
  with(Choices(taus, count), [&](JointRates& r, const auto& c) {
    for (int k = 0; k < count; ++k) r.time_constant_s[branches[k]] = c[k];
  });
  return grid;
}

JointSolution JointFit::Search(const JointStructure& structure,
                               double smoothness,
                               const JointSolution* near) const {
  // Fine tables do not move the valleys: these are found with coarse ones.
  const JointStructure coarse = Coarsen(structure);
  const JointRates* from = near == nullptr || near->x.size() == 0 ? nullptr : &near->rates;
  const std::vector<double> betas = BetaGrid(structure, from);
  const std::vector<JointRates> line = RatesGrid(structure, from);
  // One line of the grid per beta, along which active bounds are handed on.
  std::vector<JointSolution> best(betas.size());
  tbb::parallel_for(std::size_t{0}, betas.size(), [&](std::size_t b) {
    const SocTrace soc = TraceSoc(logs_, setup_, betas[b]);
    std::vector<char> guess;
    for (JointRates rates : line) {
      ++evaluations_;
      rates.beta_per_sqrt_s = betas[b];
      JointSolution solution =
          SolveSums(coarse, rates, smoothness, SumAll(logs_, setup_, coarse, soc, rates), guess);
      guess = solution.at_zero;
      if (solution.cost < best[b].cost) best[b] = std::move(solution);
    }
  });
  // The two best are polished: neighbours may lie in different valleys.
  const auto cheaper = [](const auto& a, const auto& b) { return a.cost < b.cost; };
  const std::size_t polished = std::min<std::size_t>(2, best.size());
  const auto end = best.begin() + static_cast<std::ptrdiff_t>(polished);
  std::partial_sort(best.begin(), end, best.end(), cheaper);
  tbb::parallel_for(
      std::size_t{0}, polished, [&](std::size_t k) { best[k] = Approach(std::move(best[k])); });
  JointSolution found = std::move(*std::min_element(best.begin(), end, cheaper));
  if (coarse != structure && found.x.size() > 0)
    found = Approach(Solve(structure, found.rates, smoothness));
  constexpr double kRoughStep = 6e-3;  // of the logarithms of the rates
  return Polish(std::move(found), kRoughStep);
}

// The cost has a kink wherever a row crosses a node of v_oc, and rows of short logs are few: with the
// slope of the segments steps would be as short as the segments, and end in the first small valley.
// The smooth slope leads past them; a direct search, which sees the cost alone, then settles in.
template <class Minimize>
JointSolution JointFit::Descend(JointSolution from, Minimize&& minimize) const {
  const RatesProblem problem(*this, from);
  if (from.x.size() == 0) return from;
  if (problem.size() == 0) {  // what is left is solved exactly
    from.termination = Termination::kConverged;
    from.message = "No rate was to be found.";
    return from;
  }
  const OptimizationSummary summary = minimize(problem, problem.Point(from.rates));
  JointSolution best = problem.best();
  best.termination = summary.termination;
  best.message = summary.message;
  best.at_bound.clear();
  for (const Rate& rate : problem.rates()) {
    JointRates rates = best.rates;
    const double value = *rate.entry(rates, rate.index);
    if (value <= rate.lower * 1.001 || value >= rate.upper / 1.001)
      best.at_bound.push_back(rate.name);
  }
  return best;
}

JointSolution JointFit::Approach(JointSolution from) const {
  constexpr double kStep = 3e-4;  // of the point, whose logarithms are some units
  return Descend(std::move(from), [](const RatesProblem& problem, const Eigen::VectorXd& start) {
    return MinimizeLevenbergMarquardt(
        problem, start, {.step_tolerance = kStep, .max_iterations = 20});
  });
}

JointSolution JointFit::Polish(JointSolution from,
                               double step_tolerance,
                               int iterations_per_variable) const {
  DirectSearchOptions options;
  options.step_tolerance = step_tolerance;
  options.iterations_per_variable = iterations_per_variable;
  return Descend(std::move(from),
                 [&](const RatesProblem& problem, const Eigen::VectorXd& start) {
                   return MinimizeBobyqa(problem, start, options);
                 });
}

LeftOutErrors JointFit::LeaveOut(const JointStructure& structure,
                                 const JointRates& rates,
                                 const std::vector<double>& ladder) const {
  LeftOutErrors best;
  if (!ladder.empty()) best.smoothness = ladder[ladder.size() / 2];
  if (logs_.groups < 2) return best;
  const SocTrace soc = TraceSoc(logs_, setup_, rates.beta_per_sqrt_s);
  const auto sums = SumGroups(logs_, setup_, structure, soc, rates);
  NormalEquations total = sums.back();
  double weight = 0.0;
  for (int g = 0; g < logs_.groups; ++g) {
    total.Add(sums[g]);
    weight += sums[g].weight;
  }
  const auto groups = static_cast<std::size_t>(logs_.groups);
  std::vector<Eigen::VectorXd> whole;
  std::vector<std::vector<char>> guess;  // what holds with all rows mostly holds without some
  for (const double smoothness : ladder) {
    JointSolution solution = SolveSums(
        structure, rates, smoothness, total, guess.empty() ? std::vector<char>{} : guess.back());
    whole.push_back(std::move(solution.x));
    guess.push_back(std::move(solution.at_zero));
  }
  // without[g][s]: the unknowns that the other groups give.
  std::vector<std::vector<Eigen::VectorXd>> without(groups);
  tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t g) {
    NormalEquations rest = total;
    rest.Add(sums[g], -1.0);
    for (std::size_t s = 0; s < ladder.size(); ++s)
      without[g].push_back(SolveSums(structure, rates, ladder[s], rest, guess[s]).x);
  });
  const auto total_of = [&](const std::vector<double>& units) {
    return std::accumulate(units.begin(), units.end(), 0.0) / weight;
  };
  const auto fitted = SumErrors(logs_,
                                setup_,
                                structure,
                                soc,
                                rates,
                                std::vector<std::vector<Eigen::VectorXd>>(groups, whole));
  const auto errors = SumErrors(logs_, setup_, structure, soc, rates, without);
  constexpr double kFitted = 0.368;  // e^-1: the share of rows that a bootstrap leaves out
  std::vector<LeftOutErrors> all;
  for (std::size_t s = 0; s < ladder.size(); ++s) {
    LeftOutErrors& one = all.emplace_back();
    one.smoothness = ladder[s];
    one.fitted_V = total_of(fitted[s]);
    one.left_out_V = total_of(errors[s]);
    one.expected_V = kFitted * one.fitted_V + (1.0 - kFitted) * one.left_out_V;
    for (std::size_t u = 0; u < errors[s].size(); ++u)
      one.unit_V.push_back(kFitted * fitted[s][u] + (1.0 - kFitted) * errors[s][u]);
  }
  double least_V = kInfinity;
  for (const LeftOutErrors& one : all) least_V = std::min(least_V, one.expected_V);
  for (const LeftOutErrors& one : all) {
    if (one.expected_V <= (1.0 + kSmoothnessLoss) * least_V) return one;
  }
  return best;
}

}  // namespace lipoid
