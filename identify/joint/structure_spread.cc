#include "identify/joint/structure_spread.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace lipoid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double TableAt(const JointSolution& solution, int table, double soc) {
  const auto& nodes = solution.structure.resistance_soc;
  if (nodes.size() == 1) return solution.x[table];
  NodeShare at = NodeFinder(nodes)(soc);
  at.share = std::clamp(at.share, 0.0, 1.0);
  return (1.0 - at.share) * solution.x[table + at.lower] +
         at.share * solution.x[table + at.lower + 1];
}

double TableMean(const JointSolution& solution, int table) {
  double sum = 0.0;
  for (const double soc : {0.2, 0.5, 0.8}) sum += TableAt(solution, table, soc) / 3.0;
  return sum;
}

// The branch whose time constant is nearest to one of another solution; -1: there is none.
int BranchNear(const JointSolution& solution, double tau_s) {
  const auto& taus_s = solution.rates.time_constant_s;
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int j = 0; j < solution.structure.branches; ++j) {
    const double off = std::abs(std::log(taus_s[static_cast<std::size_t>(j)] / tau_s));
    if (off >= least) continue;
    least = off;
    nearest = j;
  }
  return nearest;
}

}  // namespace

double ValueIn(const JointSolution& solution,
               const std::string& name,
               double typical_A,
               const JointSolution& taken) {
  if (solution.x.size() == 0) return kNaN;
  const JointLayout layout(solution.structure);
  const JointRates& rates = solution.rates;
  if (name == "beta") return rates.beta_per_sqrt_s;
  if (name == "tau_h") return rates.heating_time_constant_s;
  if (name == "i_0") return rates.charge_transfer_A;
  if (name == "rho_h") {
    return solution.structure.self_heating ? solution.x[layout.heating()] / std::pow(typical_A, 3)
                                           : kNaN;
  }
  const std::size_t bracket = name.find('(');
  const std::string what = name.substr(0, bracket);
  const double soc =
      bracket == std::string::npos ? kNaN : std::strtod(name.c_str() + bracket + 1, nullptr);
  const auto ohms = [&](int table) {
    return (std::isnan(soc) ? TableMean(solution, table) : TableAt(solution, table, soc)) /
           typical_A;
  };
  if (what == "r_total") {
    double sum = 0.0;
    for (int t = 0; t < layout.tables(); ++t) sum += ohms(layout.table(t));
    return sum;
  }
  if (what == "r_s") return ohms(layout.series());
  if (what == "r_ct") return solution.structure.charge_transfer ? ohms(layout.transfer()) : kNaN;
  const std::size_t line = what.find('_');
  if (line == std::string::npos) return kNaN;
  const int of_taken = std::atoi(what.c_str() + line + 1) - 1;
  if (of_taken < 0 || of_taken >= taken.structure.branches) return kNaN;
  const int j =
      BranchNear(solution, taken.rates.time_constant_s[static_cast<std::size_t>(of_taken)]);
  if (j < 0) return kNaN;
  const double tau_s = rates.time_constant_s[static_cast<std::size_t>(j)];
  if (what.rfind("tau_", 0) == 0) return tau_s;
  if (what.rfind("r_", 0) == 0) return ohms(layout.branch(j));
  if (what.rfind("c_", 0) == 0) return tau_s / ohms(layout.branch(j));
  return kNaN;
}

double OpenCircuitVoltageIn(const JointSolution& solution,
                            const OpenCircuitVoltage& reference,
                            double soc) {
  const auto& nodes = solution.structure.voltage_soc;
  if (nodes.empty() || solution.x.size() == 0) return kNaN;
  const NodeShare at = NodeFinder(nodes)(soc);
  const auto voltage_V = [&](int k) {
    return reference(nodes[static_cast<std::size_t>(k)]) + solution.x[k];
  };
  return (1.0 - at.share) * voltage_V(at.lower) + at.share * voltage_V(at.lower + 1);
}

Eigen::VectorXd SpreadOverStructures(const JointChoice& choice,
                                     const std::function<double(const JointSolution&)>& value) {
  const double estimate = value(choice.best);
  const auto off = [&](const JointSolution& other, double weight) {
    const double by = std::sqrt(weight) * (value(other) - estimate);
    return std::isfinite(by) ? by : 0.0;
  };
  Eigen::VectorXd spread(static_cast<Eigen::Index>(choice.tried.size()) + 1);
  spread[0] = off(choice.finer, 1.0);
  for (std::size_t m = 0; m < choice.tried.size(); ++m) {
    const TriedStructure& row = choice.tried[m];
    spread[static_cast<Eigen::Index>(m) + 1] = off(row.solution, row.weight);
  }
  return spread;
}

}  // namespace lipoid
