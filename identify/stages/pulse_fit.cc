#include "identify/stages/pulse_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastBeta = 1e-4;  // stands for the 0 of (4.61): 1/beta² is then three years
constexpr double kLargestBeta = 1.0;
// Closer than this to a bound, in units of the parameter, no data would tell the difference.
constexpr double kTouching = 1e-6;

// One parameter as the solver sees it: x = p/unit, or log(p/unit).
struct Variable {
  std::string name;
  int column = 0;  // of the sweep's Jacobian
  bool logarithmic = false;
  double unit = 1.0;
  double lower = 0.0;  // of p
  double upper = kInfinity;

  [[nodiscard]] double ToX(double p) const { return logarithmic ? std::log(p / unit) : p / unit; }
  [[nodiscard]] double FromX(double x) const { return logarithmic ? unit * std::exp(x) : unit * x; }
  /// dp/dx.
  [[nodiscard]] double Slope(double p) const { return logarithmic ? p : unit; }
};

double& Entry(SweepParameters& p, int column) {
  const auto n = static_cast<int>(p.time_constant_s.size());
  if (column == 0) return p.beta_per_sqrt_s;
  if (column == 1) return p.series_resistance_Ohm;
  if (column < 2 + n) return p.resistance_Ohm[static_cast<std::size_t>(column - 2)];
  return p.time_constant_s[static_cast<std::size_t>(column - 2 - n)];
}
double Entry(const SweepParameters& p, int column) {
  return Entry(const_cast<SweepParameters&>(p), column);
}

class PulseProblem : public LeastSquaresProblem {
 public:
  PulseProblem(const VoltageSweep& sweep, std::vector<Variable> variables, SweepParameters base)
      : sweep_(sweep), variables_(std::move(variables)), base_(std::move(base)) {}

  [[nodiscard]] int size() const override { return static_cast<int>(variables_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override { return Bound(&Variable::lower); }
  [[nodiscard]] Eigen::VectorXd upper() const override { return Bound(&Variable::upper); }

  [[nodiscard]] SweepParameters Parameters(const Eigen::VectorXd& x) const {
    SweepParameters p = base_;
    for (int k = 0; k < size(); ++k) {
      const Variable& v = variables_[static_cast<std::size_t>(k)];
      Entry(p, v.column) = std::clamp(v.FromX(x[k]), v.lower, v.upper);
    }
    return p;
  }
  [[nodiscard]] Eigen::VectorXd Point(const SweepParameters& p) const {
    Eigen::VectorXd x(size());
    for (int k = 0; k < size(); ++k) {
      const Variable& v = variables_[static_cast<std::size_t>(k)];
      x[k] = v.ToX(std::clamp(Entry(p, v.column), v.lower, v.upper));
    }
    return x;
  }

  // The rows of the sweep's factor, of which only the columns of the free parameters are kept, are
  // few: triangular again after one small QR.
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override {
    const SweepParameters p = Parameters(x);
    const Eigen::MatrixXd all = sweep_.Factor(p, jacobian);
    Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(all.rows(), size() + 1);
    for (int k = 0; jacobian && k < size(); ++k) {
      const Variable& v = variables_[static_cast<std::size_t>(k)];
      kept.col(k) = all.col(v.column) * v.Slope(Entry(p, v.column));
    }
    kept.col(size()) = all.rightCols(1);
    if (!kept.allFinite()) return Eigen::MatrixXd::Constant(size() + 1, size() + 1, std::nan(""));
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(kept);
    return qr.matrixQR().topRows(size() + 1).triangularView<Eigen::Upper>();
  }

 private:
  [[nodiscard]] Eigen::VectorXd Bound(double Variable::*which) const {
    Eigen::VectorXd bound(size());
    for (int k = 0; k < size(); ++k) {
      const Variable& v = variables_[static_cast<std::size_t>(k)];
      bound[k] = std::isfinite(v.*which) ? v.ToX(v.*which) : std::numeric_limits<double>::max();
    }
    return bound;
  }

  const VoltageSweep& sweep_;
  std::vector<Variable> variables_;
  SweepParameters base_;
};

// What the user knows, checked, with capacitances turned into time constants.
class Knowledge {
 public:
  Knowledge(const PulseFitKnowledge& given, int branches, bool diffusion)
      : given_(given), branches_(branches), diffusion_(diffusion) {
    for (const auto& [name, value] : given.fixed) CheckValue("fix", name, value);
    for (const auto& [name, value] : given.start) CheckValue("start", name, value);
    for (const auto& [name, range] : given.bounds) CheckBounds(name, range);
    for (int j = 1; j <= branches; ++j) {
      TurnIntoTimeConstant(j, given_.fixed);
      TurnIntoTimeConstant(j, given_.start);
    }
  }

  [[nodiscard]] std::vector<std::string> Names() const {
    std::vector<std::string> names;
    if (diffusion_) names.emplace_back("beta");
    names.emplace_back("r_s");
    for (const char* prefix : {"r", "tau", "c"}) {
      for (int j = 1; j <= branches_; ++j) names.push_back(fmt::format("{}_{}", prefix, j));
    }
    return names;
  }
  [[nodiscard]] std::optional<double> Fixed(const std::string& name) const {
    return Find(given_.fixed, name);
  }
  [[nodiscard]] std::optional<double> Start(const std::string& name) const {
    return Find(given_.start, name);
  }
  void Apply(Variable& v) const {
    const auto found = given_.bounds.find(v.name);
    if (found == given_.bounds.end()) return;
    v.lower = v.logarithmic ? std::max(found->second.first, v.lower) : found->second.first;
    v.upper = found->second.second;
    if (v.lower > v.upper) {
      throw OptionError(
          fmt::format("--bounds {}: expected an upper bound of at least {}", v.name, v.lower));
    }
  }

 private:
  void CheckName(std::string_view option, const std::string& name) const {
    const auto names = Names();
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    throw OptionError(fmt::format(
        "--{}: no parameter '{}' in this fit; there are {}", option, name, fmt::join(names, ", ")));
  }

  void CheckValue(std::string_view option, const std::string& name, double value) const {
    CheckName(option, name);
    const bool resistance = name[0] == 'r';
    const bool valid = std::isfinite(value) && (resistance ? value >= 0.0 : value > 0.0) &&
                       (name != "beta" || value <= kLargestBeta);
    if (!valid) {
      throw OptionError(fmt::format("--{} {}={}: expected a number {}",
                                    option,
                                    name,
                                    value,
                                    resistance       ? "of at least 0"
                                    : name == "beta" ? "above 0 and at most 1"
                                                     : "above 0"));
    }
  }

  void CheckBounds(const std::string& name, const std::pair<double, double>& range) const {
    const auto& [low, high] = range;
    CheckName("bounds", name);
    if (name[0] == 'c') {
      throw OptionError(
          fmt::format("--bounds {0}: this solver moves time constants; bound tau_{1} = r_{1} c_{1}",
                      name,
                      name.substr(2)));
    }
    if (!(low >= 0.0 && low <= high) || (name == "beta" && high > kLargestBeta)) {
      throw OptionError(fmt::format("--bounds {}={},{}: expected 0 <= low <= high{}",
                                    name,
                                    low,
                                    high,
                                    name == "beta" ? " <= 1" : ""));
    }
    const auto fixed = given_.fixed.find(name);
    if (fixed != given_.fixed.end() && !(fixed->second >= low && fixed->second <= high)) {
      throw OptionError(fmt::format(
          "--fix {0}={1} lies outside --bounds {0}={2},{3}", name, fixed->second, low, high));
    }
  }

  // c_j means something to the sweep only with the r_j that stands beside it, or that is fixed.
  void TurnIntoTimeConstant(int j, std::map<std::string, double>& known) const {
    const auto r = fmt::format("r_{}", j);
    const auto c = fmt::format("c_{}", j);
    const auto tau = fmt::format("tau_{}", j);
    if (!known.count(c)) return;
    if (known.count(tau)) throw OptionError(fmt::format("give either {} or {}, not both", c, tau));
    const auto resistance = known.count(r) ? Find(known, r) : Find(given_.fixed, r);
    if (!resistance || *resistance == 0.0) {
      throw OptionError(fmt::format(
          "{0} is known to this fit only together with {1}: give {1} too, or tau_{2} instead",
          c,
          r,
          j));
    }
    known[tau] = *resistance * known.at(c);
  }

  static std::optional<double> Find(const std::map<std::string, double>& map,
                                    const std::string& name) {
    const auto found = map.find(name);
    if (found == map.end()) return std::nullopt;
    return found->second;
  }

  PulseFitKnowledge given_;
  int branches_;
  bool diffusion_;
};

// min ||b + A y|| with lower <= y: few unknowns, so every set of those at their bound is tried.
Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a,
                                        const Eigen::VectorXd& b,
                                        double* norm) {
  const auto n = static_cast<int>(a.cols());
  Eigen::VectorXd best = Eigen::VectorXd::Zero(n);
  *norm = b.norm();
  for (unsigned free = 1; free < (1U << n); ++free) {
    std::vector<int> columns;
    for (int k = 0; k < n; ++k) {
      if (free & (1U << k)) columns.push_back(k);
    }
    Eigen::MatrixXd part(a.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k)
      part.col(static_cast<Eigen::Index>(k)) = a.col(columns[k]);
    const Eigen::VectorXd y = part.colPivHouseholderQr().solve(-b);
    const double here = (part * y + b).norm();
    if (y.minCoeff() < 0.0 || !(here < *norm)) continue;
    *norm = here;
    best.setZero();
    for (std::size_t k = 0; k < columns.size(); ++k)
      best[columns[k]] = y[static_cast<Eigen::Index>(k)];
  }
  return best;
}

std::vector<double> LogGrid(double low, double high, int count) {
  std::vector<double> grid;
  grid.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k)
    grid.push_back(low * std::pow(high / low, count > 1 ? double(k) / (count - 1) : 0.5));
  return grid;
}

// Every way to choose `count` entries of the grid, rising.
std::vector<std::vector<double>> Choices(const std::vector<double>& grid, int count) {
  std::vector<std::vector<double>> all{{}};
  for (int chosen = 0; chosen < count; ++chosen) {
    std::vector<std::vector<double>> longer;
    for (const auto& choice : all) {
      for (const double value : grid) {
        if (!choice.empty() && value <= choice.back()) continue;
        longer.push_back(choice);
        longer.back().push_back(value);
      }
    }
    all = std::move(longer);
  }
  return all;
}

struct Candidate {
  SweepParameters parameters;
  double cost = kInfinity;
};

// For every (beta, tau_j) of a grid the best r_s, r_j follow by linear least squares.
std::vector<Candidate> SearchStarts(const VoltageSweep& thinned,
                                    const std::vector<double>& betas,
                                    const std::vector<std::vector<double>>& time_constants,
                                    const std::vector<Variable>& variables,
                                    const SweepParameters& base) {
  std::vector<int> linear;  // columns of the free resistances
  for (const Variable& v : variables) {
    if (!v.logarithmic) linear.push_back(v.column);
  }
  std::vector<Candidate> candidates;
  for (const double beta : betas) {
    for (const auto& taus : time_constants) {
      SweepParameters p = base;
      p.beta_per_sqrt_s = beta;
      p.time_constant_s = taus;
      for (const int column : linear) Entry(p, column) = 0.0;
      const Eigen::MatrixXd factor = thinned.Factor(p, true);
      if (!factor.allFinite()) continue;
      Eigen::MatrixXd design(factor.rows(), static_cast<Eigen::Index>(linear.size()));
      for (std::size_t k = 0; k < linear.size(); ++k)
        design.col(static_cast<Eigen::Index>(k)) = factor.col(linear[k]);
      Candidate candidate;
      const Eigen::VectorXd y =
          NonNegativeLeastSquares(design, factor.rightCols(1), &candidate.cost);
      for (std::size_t k = 0; k < linear.size(); ++k)
        Entry(p, linear[k]) = y[static_cast<Eigen::Index>(k)];
      candidate.parameters = std::move(p);
      candidates.push_back(std::move(candidate));
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.cost < b.cost;
  });
  return candidates;
}

// A resistance that starts at zero leaves its time constant without a gradient.
void LiftZeroResistances(SweepParameters& p, const std::vector<Variable>& variables) {
  for (const Variable& v : variables) {
    if (v.logarithmic) continue;
    double& r = Entry(p, v.column);
    r = std::clamp(std::max(r, 0.01 * v.unit), v.lower, v.upper);
  }
}

}  // namespace

ErrorMetrics SweepErrors(const VoltageSweep& sweep,
                         const SweepParameters& parameters,
                         std::size_t* rows_outside_curve) {
  const SweepSetup& setup = sweep.setup();
  CellParameters<double> cell;
  cell.alpha_C = setup.alpha_C;
  cell.beta_per_sqrt_s = parameters.beta_per_sqrt_s;
  cell.diffusion = setup.diffusion;
  cell.terms = setup.terms;
  cell.tail = setup.tail;
  cell.open_circuit_voltage = setup.open_circuit_voltage;
  cell.series_resistance_Ohm = parameters.series_resistance_Ohm;
  for (std::size_t j = 0; j < parameters.time_constant_s.size(); ++j) {
    cell.branches.push_back(
        {Resistance<double>(parameters.resistance_Ohm[j]), parameters.time_constant_s[j]});
  }
  const CellModel<double> model(std::move(cell));
  ErrorAccumulator errors;
  std::size_t outside = 0;
  for (const SweepLog& log : sweep.logs()) {
    RecordStepper<double> stepper(model, log.record->hold, model.Relaxed(log.initial_soc));
    for (std::size_t k = 0; k < log.record->size(); ++k) {
      stepper.Row(log.record->time_s[k], log.record->current_A[k]);
      errors.Add(log.record->voltage_V[k], stepper.Voltage());
      if (!setup.open_circuit_voltage.InRange(stepper.Soc())) ++outside;
    }
  }
  if (rows_outside_curve != nullptr) *rows_outside_curve = outside;
  return errors.Result();
}

PulseFitResult FitPulses(const VoltageSweep& sweep,
                         const PulseFitStart& start,
                         const PulseFitOptions& options,
                         const LevenbergMarquardtOptions& solver,
                         const PulseFitKnowledge& given) {
  const auto began = std::chrono::steady_clock::now();
  const int n = options.branches;
  const bool diffusion = sweep.setup().diffusion;
  const Knowledge knowledge(given, n, diffusion);
  const StartValues& data = start.data;

  // Start values, read off the data or typical where it shows none.
  const double series = data.series_resistance_Ohm > 0.0
                            ? data.series_resistance_Ohm
                            : 36.0 / sweep.setup().alpha_C;  // 10 mOhm for 1 Ah, and in proportion
  const double relaxation =
      data.relaxation_s > 0.0 ? data.relaxation_s : std::sqrt(data.shortest_s * data.longest_s);
  const double recovery = data.relaxation_Ohm > 0.0 ? data.relaxation_Ohm : 0.3 * series;
  const double shortest_tau = 0.1 * data.shortest_s;
  const double longest_tau = 10.0 * data.longest_s;

  PulseFitResult result;
  SweepParameters base;
  base.beta_per_sqrt_s = diffusion ? start.beta_per_sqrt_s : 0.0;
  base.series_resistance_Ohm = series;
  for (int j = 0; j < n; ++j) {
    base.resistance_Ohm.push_back(0.5 * recovery / n);
    // Spread over the decades around what relaxes most.
    base.time_constant_s.push_back(
        std::clamp(relaxation * std::pow(5.0, j - 0.5 * (n - 1)), shortest_tau, longest_tau));
  }

  std::vector<Variable> variables;
  const auto add = [&](Variable v) {
    double& entry = Entry(base, v.column);
    if (const auto fixed = knowledge.Fixed(v.name)) {
      entry = *fixed;
      result.fixed.push_back(v.name);
      return;
    }
    knowledge.Apply(v);
    if (const auto known = knowledge.Start(v.name)) entry = *known;
    entry = std::clamp(entry, v.lower, v.upper);
    variables.push_back(std::move(v));
  };
  if (diffusion) {
    if (start.hold_beta && !knowledge.Fixed("beta")) {
      result.fixed.push_back("beta");
    } else {
      add({"beta", 0, true, 1.0, kLeastBeta, kLargestBeta});
    }
  }
  add({"r_s", 1, false, series});
  for (int j = 0; j < n; ++j) add({fmt::format("r_{}", j + 1), 2 + j, false, series});
  for (int j = 0; j < n; ++j) {
    add({fmt::format("tau_{}", j + 1), 2 + n + j, true, relaxation, shortest_tau, longest_tau});
  }
  const auto free_named = [&](const std::string& name) {
    return std::any_of(
        variables.begin(), variables.end(), [&](const Variable& v) { return v.name == name; });
  };

  // Many starts on a thinned log.
  std::vector<ThinnedRecord> thinned_records;
  std::vector<SweepLog> thinned_logs;
  thinned_records.reserve(sweep.logs().size());
  for (const SweepLog& log : sweep.logs()) {
    thinned_records.push_back(Thin(*log.record, static_cast<std::size_t>(options.thinned_rows)));
    thinned_logs.push_back({&thinned_records.back().record,
                            log.initial_soc,
                            log.weight,
                            thinned_records.back().row_weight});
  }
  const VoltageSweep thinned(sweep.setup(), std::move(thinned_logs));
  std::vector<double> betas{base.beta_per_sqrt_s};
  if (free_named("beta")) {
    for (const double beta : LogGrid(0.03, 1.0, 7)) betas.push_back(beta);
  }
  bool all_taus_free = true;
  for (int j = 1; j <= n; ++j)
    all_taus_free = all_taus_free && free_named(fmt::format("tau_{}", j));
  std::vector<std::vector<double>> choices{base.time_constant_s};
  if (n > 0 && all_taus_free) {
    const auto grid = LogGrid(
        2.0 * data.shortest_s, std::max(data.longest_s, 4.0 * data.shortest_s), n <= 2 ? 8 : 6);
    for (auto& choice : Choices(grid, n)) choices.push_back(std::move(choice));
  }
  auto candidates = SearchStarts(thinned, betas, choices, variables, base);
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(options.starts)));
  candidates.push_back({base, 0.0});
  if (start.previous != nullptr) {
    SweepParameters previous = *start.previous;
    candidates.push_back({previous, 0.0});
  }

  SweepParameters best = base;
  double best_cost = kInfinity;
  const PulseProblem quick(thinned, variables, base);
  for (auto& candidate : candidates) {
    LiftZeroResistances(candidate.parameters, variables);
    if (variables.empty()) break;
    const auto fit = MinimizeLevenbergMarquardt(quick, quick.Point(candidate.parameters), solver);
    ++result.starts;
    if (fit.usable() && fit.cost < best_cost) {
      best_cost = fit.cost;
      best = quick.Parameters(fit.x);
    }
  }

  // All rows decide.
  const auto fit_all_rows = [&] {
    const PulseProblem problem(sweep, variables, base);
    if (variables.empty()) {
      result.parameters = base;
      result.summary.termination = Termination::kConverged;
      result.summary.message = "Every parameter was given.";
      return;
    }
    result.summary = MinimizeLevenbergMarquardt(problem, problem.Point(best), solver);
    result.parameters = problem.Parameters(result.summary.x);
    result.evaluations += result.summary.evaluations;
  };
  fit_all_rows();

  // A branch that has no inertia left is a part of r_s, and one without resistance has no time
  // constant: either way it is gone. What it carried goes to r_s, and the rest is fitted without
  // it.
  std::vector<bool> gone(static_cast<std::size_t>(n), false);
  best = result.parameters;
  for (int j = 0; j < n; ++j) {
    const auto r = fmt::format("r_{}", j + 1);
    const auto tau = fmt::format("tau_{}", j + 1);
    if (!free_named(r) || !free_named(tau)) continue;
    const auto at = static_cast<std::size_t>(j);
    const bool instant = free_named("r_s") &&
                         result.parameters.time_constant_s[at] <= shortest_tau * (1.0 + kTouching);
    if (!instant && result.parameters.resistance_Ohm[at] > kTouching * series) continue;
    if (instant) best.series_resistance_Ohm += best.resistance_Ohm[at];
    best.resistance_Ohm[at] = 0.0;
    std::erase_if(variables, [&](const Variable& v) { return v.name == r || v.name == tau; });
    gone[at] = true;
  }
  if (std::find(gone.begin(), gone.end(), true) != gone.end()) {
    base = best;
    fit_all_rows();
  }

  std::vector<bool> touches(static_cast<std::size_t>(VoltageSweep::Columns(n)), false);
  for (const Variable& v : variables) {
    double& p = Entry(result.parameters, v.column);
    const double lower_slack = v.logarithmic ? std::log(p / v.lower) : (p - v.lower) / v.unit;
    const double upper_slack = !std::isfinite(v.upper) ? kInfinity
                               : v.logarithmic         ? std::log(v.upper / p)
                                                       : (v.upper - p) / v.unit;
    if (lower_slack >= kTouching && upper_slack >= kTouching) continue;
    p = lower_slack < kTouching ? v.lower : v.upper;
    touches[static_cast<std::size_t>(v.column)] = true;
  }
  for (int j = 0; j < n; ++j) {
    if (gone[static_cast<std::size_t>(j)]) touches[2 + static_cast<std::size_t>(j)] = true;
  }

  // Branches come in any order: by rising time constant, those that are gone last, unless the user
  // named one.
  const auto names_a_branch = [](const auto& map) {
    return std::any_of(map.begin(), map.end(), [](const auto& entry) {
      return entry.first != "beta" && entry.first != "r_s";
    });
  };
  std::vector<std::size_t> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (!names_a_branch(given.fixed) && !names_a_branch(given.bounds) &&
      !names_a_branch(given.start)) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      if (gone[a] != gone[b]) return static_cast<bool>(gone[b]);
      return result.parameters.time_constant_s[a] < result.parameters.time_constant_s[b];
    });
  }
  const SweepParameters found = result.parameters;
  if (touches[0]) result.at_bound.emplace_back("beta");
  if (touches[1]) result.at_bound.emplace_back("r_s");
  for (std::size_t j = 0; j < order.size(); ++j) {
    result.parameters.resistance_Ohm[j] = found.resistance_Ohm[order[j]];
    result.parameters.time_constant_s[j] = found.time_constant_s[order[j]];
    if (touches[2 + order[j]]) result.at_bound.push_back(fmt::format("r_{}", j + 1));
    if (touches[2 + order.size() + order[j]])
      result.at_bound.push_back(fmt::format("tau_{}", j + 1));
  }
  result.errors = SweepErrors(sweep, result.parameters, &result.rows_outside_curve);
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

}  // namespace lipoid
