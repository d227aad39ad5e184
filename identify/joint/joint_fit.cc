#include "identify/joint/joint_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/optimizers/bobyqa.h"
#include "identify/trust/paired_errors.h"

namespace lipoid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A branch has a time constant of so many sampling intervals at least. A faster one has nearly all
// of its drop in the first row after an edge, where it would stand in for r_s.
constexpr double kShortestTau = 2.0;

// From node voltages to their rises, x_node[k] = sum_{j <= k} rise[j]: of a quadratic.
void ToRises(NormalEquations& sum, int voltages) {
  const Eigen::Index n = sum.right.size();
  for (Eigen::Index c = 0; c < n; ++c) {
    for (Eigen::Index r = c + 1; r < n; ++r) sum.matrix(c, r) = sum.matrix(r, c);
  }
  for (Eigen::Index k = voltages - 2; k >= 0; --k) sum.matrix.row(k) += sum.matrix.row(k + 1);
  for (Eigen::Index k = voltages - 2; k >= 0; --k) sum.matrix.col(k) += sum.matrix.col(k + 1);
  for (Eigen::Index k = voltages - 2; k >= 0; --k) sum.right[k] += sum.right[k + 1];
}

// Points of a geometric grid, ends included.
std::vector<double> Geometric(double lower, double upper, int points) {
  std::vector<double> grid;
  for (int k = 0; k < points; ++k) {
    grid.push_back(points == 1 ? std::sqrt(lower * upper)
                               : lower * std::pow(upper / lower, double(k) / (points - 1)));
  }
  return grid;
}

// Every choice of `count` out of the grid, in rising order.
std::vector<std::vector<double>> Choices(const std::vector<double>& grid, int count) {
  std::vector<std::vector<double>> all;
  std::vector<double> chosen;
  const auto choose = [&](auto&& self, std::size_t from) -> void {
    if (static_cast<int>(chosen.size()) == count) {
      all.push_back(chosen);
      return;
    }
    for (std::size_t k = from; k < grid.size(); ++k) {
      chosen.push_back(grid[k]);
      self(self, k + 1);
      chosen.pop_back();
    }
  };
  choose(choose, 0);
  return all;
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

// The cost over the logarithms of the rates that are searched.
class RatesProblem : public OptimizationProblem {
 public:
  RatesProblem(const JointFit& fit, const JointSolution& from)
      : fit_(fit), best_(from), rates_(fit.Rates(from.structure)) {}

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
  [[nodiscard]] bool has_gradient() const override { return false; }
  [[nodiscard]] double Cost(const Eigen::VectorXd& x) const override {
    JointRates rates = best_.rates;
    for (int k = 0; k < size(); ++k) {
      // exp(log(bound)) may miss the bound by a rounding.
      *rates_[k].entry(rates, rates_[k].index) =
          std::clamp(std::exp(x[k]), rates_[k].lower, rates_[k].upper);
    }
    JointSolution solution = fit_.Solve(best_.structure, rates, best_.smoothness, best_.at_zero);
    const double cost = solution.cost;
    if (cost < best_.cost) best_ = std::move(solution);
    return cost;
  }
  double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const override {
    gradient.setConstant(size(), std::numeric_limits<double>::quiet_NaN());
    return Cost(x);
  }
  [[nodiscard]] const JointSolution& best() const { return best_; }
  [[nodiscard]] const std::vector<JointFit::Rate>& rates() const { return rates_; }

 private:
  const JointFit& fit_;
  mutable JointSolution best_;  // one thread asks
  std::vector<JointFit::Rate> rates_;
};

}  // namespace

JointFit::JointFit(const JointLogs& logs, const JointSetup& setup, const JointKnowledge& known)
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
    const auto found = known_.fixed.find(name);
    return found == known_.fixed.end() ? otherwise : found->second;
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
  const auto add = [&](std::string name, double lower, double upper, auto entry, int index) {
    if (known_.fixed.count(name) > 0) return;
    if (const auto found = known_.bounds.find(name); found != known_.bounds.end()) {
      lower = std::max(found->second.first, std::numeric_limits<double>::min());
      upper = found->second.second;
    }
    rates.push_back({std::move(name), lower, upper, entry, index});
  };
  if (setup_.diffusion) {
    // Slower than the longest log there is no diffusion to be seen.
    add(
        "beta", 1e-3, 1.0, [](JointRates& r, int) { return &r.beta_per_sqrt_s; }, 0);
  }
  for (int j = 0; j < structure.branches; ++j) {
    add(
        fmt::format("tau_{}", j + 1),
        shortest_tau_s_,
        longest_tau_s_,
        [](JointRates& r, int at) { return &r.time_constant_s[at]; },
        j);
  }
  if (structure.self_heating) {
    add(
        "tau_h",
        std::max(30.0, 2.0 * shortest_tau_s_),
        1e4,
        [](JointRates& r, int) { return &r.heating_time_constant_s; },
        0);
  }
  if (structure.charge_transfer) {
    add(
        "i_0",
        0.01 * logs_.largest_A,
        2.0 * logs_.largest_A,
        [](JointRates& r, int) { return &r.charge_transfer_A; },
        0);
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
                                  const std::vector<char>& guess) const {
  const JointLayout layout(structure);
  const int n = layout.size();
  const int voltages = layout.voltages();
  NormalEquations all = sum;
  all.matrix += Penalty(structure, smoothness);
  // What no row and no difference sees stays at the reference, or at zero.
  const double floor = 1e-13 * all.matrix.diagonal().maxCoeff();
  all.matrix.diagonal().array() += floor;
  NormalEquations rises = all;
  ToRises(rises, voltages);

  Eigen::VectorXd lower = Eigen::VectorXd::Zero(n);
  std::vector<char> held(static_cast<std::size_t>(n), 0);
  for (int k = 0; k < voltages; ++k) {
    lower[k] = k == 0 ? -kInfinity
                      : -(setup_.reference(structure.voltage_soc[k]) -
                          setup_.reference(structure.voltage_soc[k - 1]));
  }
  const auto hold = [&](const std::string& name, int table) {
    const auto found = known_.fixed.find(name);
    if (found == known_.fixed.end()) return;
    for (int k = table; k < table + layout.nodes(); ++k) {
      held[k] = 1;
      lower[k] = found->second * logs_.typical_A;
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
  return solution;
}

JointSolution JointFit::Solve(const JointStructure& structure,
                              const JointRates& rates,
                              double smoothness,
                              const std::vector<char>& guess) const {
  ++evaluations_;
  const SocTrace soc = TraceSoc(logs_, setup_, rates.beta_per_sqrt_s);
  return SolveSums(
      structure, rates, smoothness, SumAll(logs_, setup_, structure, soc, rates), guess);
}

std::vector<double> JointFit::BetaGrid(const JointStructure& structure) const {
  for (const Rate& rate : Rates(structure)) {
    if (rate.name != "beta") continue;
    constexpr int kBetas = 9;
    return Geometric(std::max(rate.lower, std::min(0.01, rate.upper)), rate.upper, kBetas);
  }
  return {Base(structure).beta_per_sqrt_s};
}

std::vector<JointRates> JointFit::RatesGrid(const JointStructure& structure) const {
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
  // Two values of tau_h or i_0; one where both are there, for each was found alone before.
  const int values = structure.self_heating && structure.charge_transfer ? 1 : 2;
  std::vector<int> branches;
  double lower_tau_s = shortest_tau_s_;
  double upper_tau_s = longest_tau_s_;
  for (const Rate& rate : Rates(structure)) {
    if (rate.name == "tau_h") {
      with(Choices(Geometric(std::max(rate.lower, 100.0), std::min(rate.upper, 2000.0), values), 1),
           [](JointRates& r, const auto& c) { r.heating_time_constant_s = c[0]; });
    } else if (rate.name == "i_0") {
      with(Choices(Geometric(0.1 * logs_.largest_A, 0.5 * logs_.largest_A, values), 1),
           [](JointRates& r, const auto& c) { r.charge_transfer_A = c[0]; });
    } else if (rate.name != "beta") {
      branches.push_back(rate.index);
      lower_tau_s = std::max(lower_tau_s, rate.lower);
      upper_tau_s = std::min(upper_tau_s, rate.upper);
    }
  }
  if (!branches.empty()) {
    const int count = static_cast<int>(branches.size());
    // Not at the ends: there a branch is one with r_s, or with v_oc.
    const double margin = std::pow(upper_tau_s / lower_tau_s, 0.08);
    const auto taus = Geometric(lower_tau_s * margin, upper_tau_s / margin, std::max(6, count + 3));
    with(Choices(taus, count), [&](JointRates& r, const auto& c) {
      for (int k = 0; k < count; ++k) r.time_constant_s[branches[k]] = c[k];
    });
  }
  return grid;
}

JointSolution JointFit::Search(const JointStructure& structure,
                               double smoothness,
                               const JointSolution* near) const {
  // Fine tables do not move the valleys: these are found with coarse ones.
  const JointStructure coarse = Coarsen(structure);
  const std::vector<double> betas = BetaGrid(structure);
  const std::vector<JointRates> line = RatesGrid(structure);
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
  if (near != nullptr && near->structure.branches == structure.branches) {
    JointRates rates = near->rates;
    const JointRates base = Base(structure);
    if (std::isnan(rates.heating_time_constant_s))
      rates.heating_time_constant_s = base.heating_time_constant_s;
    if (std::isnan(rates.charge_transfer_A)) rates.charge_transfer_A = base.charge_transfer_A;
    best.push_back(Solve(coarse, rates, smoothness));
  }
  // The two best are polished: neighbours may lie in different valleys.
  const auto cheaper = [](const auto& a, const auto& b) { return a.cost < b.cost; };
  const std::size_t polished = std::min<std::size_t>(2, best.size());
  const auto end = best.begin() + static_cast<std::ptrdiff_t>(polished);
  std::partial_sort(best.begin(), end, best.end(), cheaper);
  constexpr double kRoughStep = 3e-3;  // of the logarithms of the rates
  tbb::parallel_for(std::size_t{0}, polished, [&](std::size_t k) {
    best[k] = Polish(std::move(best[k]), kRoughStep);
  });
  JointSolution found = std::move(*std::min_element(best.begin(), end, cheaper));
  if (coarse == structure || found.x.size() == 0) return found;
  return Polish(Solve(structure, found.rates, smoothness), 2.0 * kRoughStep);
}

JointSolution JointFit::Polish(JointSolution from,
                               double step_tolerance,
                               int iterations_per_variable) const {
  const RatesProblem problem(*this, from);
  if (from.x.size() == 0) return from;
  if (problem.size() == 0) {  // what is left is solved exactly
    from.termination = Termination::kConverged;
    from.message = "No rate was to be found.";
    return from;
  }
  DirectSearchOptions options;
  options.step_tolerance = step_tolerance;
  options.iterations_per_variable = iterations_per_variable;
  const Eigen::VectorXd start = problem.Point(from.rates);
  const OptimizationSummary summary = MinimizeBobyqa(problem, start, options);
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
  std::vector<LeftOutErrors> all;
  for (std::size_t s = 0; s < ladder.size(); ++s) {
    all.push_back({.smoothness = ladder[s],
                   .fitted_V = total_of(fitted[s]),
                   .left_out_V = total_of(errors[s]),
                   .unit_V = errors[s]});
  }
  const LeftOutErrors& least =
      *std::min_element(all.begin(), all.end(), [](const LeftOutErrors& a, const LeftOutErrors& b) {
        return a.left_out_V < b.left_out_V;
      });
  for (const LeftOutErrors& one : all) {
    if (!CompareErrors(one.unit_V, least.unit_V, logs_.unit_weight).AskedFor()) return one;
  }
  return best;
}

}  // namespace lipoid
