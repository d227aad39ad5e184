#include "identify/health/flight_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "identify/health/flight_problem.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/optimizers/optimizers.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

// J'J + 1, J'r + x and r'r + x'x of columns [J r] and of what was believed of the unknowns x before: one product
// of the columns with themselves.
struct NormalOf {
  Eigen::MatrixXd matrix;  // the lower triangle
  Eigen::VectorXd score;
  double squares = 0.0;

  NormalOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& scaled)
      : matrix(Eigen::MatrixXd::Zero(columns.cols(), columns.cols())) {
    matrix.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
    const Eigen::Index p = columns.cols() - 1;
    score = matrix.row(p).head(p).transpose() + scaled;
    squares = matrix(p, p) + scaled.squaredNorm();
    matrix.conservativeResize(p, p);
    matrix.diagonal().array() += 1.0;
  }
};

// Minus the logarithm of the marginal likelihood of the noise whose logarithms are searched.
class NoiseProblem final : public OptimizationProblem {
 public:
  // columns are [J r] at the windows, `scaled` where they were taken.
  NoiseProblem(const std::vector<double>& time_s,
               const Eigen::MatrixXd& columns,
               const Eigen::VectorXd& scaled)
      : time_s_(time_s), columns_(columns), scaled_(scaled) {
    // From the resolution of the fastest window to the length of the flight.
    const double length_s = std::max(20.0, time_s.back() - time_s.front());
    const double step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size());
    low_ = Log({1e-4, 1e-5, 2.0 * step_s, 1e-5, 8.0});
    high_ = Log({0.5, 0.5, std::max(8.0, 4.0 * step_s), 0.5, std::max(10.0, 0.5 * length_s)});
  }
  [[nodiscard]] int size() const override { return 5; }
  [[nodiscard]] Eigen::VectorXd lower() const override { return low_; }
  [[nodiscard]] Eigen::VectorXd upper() const override { return high_; }
  [[nodiscard]] bool has_gradient() const override { return false; }
  double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd&) const override { return Cost(x); }
  [[nodiscard]] double Cost(const Eigen::VectorXd& x) const override {
    Eigen::MatrixXd columns = columns_;
    const double log_determinant = NoiseOf(x).Whiten(time_s_, columns);
    const NormalOf normal(columns, scaled_);
    const Eigen::LLT<Eigen::MatrixXd> factor(normal.matrix);
    const double squares = normal.squares - normal.score.dot(factor.solve(normal.score));
    const double log_normal = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
    return 0.5 * (squares + log_determinant + log_normal);
  }
  static ColouredNoise NoiseOf(const Eigen::VectorXd& x) {
    return {std::exp(x[0]), {{std::exp(x[1]), std::exp(x[2])}, {std::exp(x[3]), std::exp(x[4])}}};
  }
  static Eigen::VectorXd Log(const std::array<double, 5>& values) {
    Eigen::VectorXd x(5);
    for (int k = 0; k < 5; ++k) x[k] = std::log(values[static_cast<std::size_t>(k)]);
    return x;
  }

 private:
  const std::vector<double>& time_s_;
  const Eigen::MatrixXd& columns_;
  const Eigen::VectorXd& scaled_;
  Eigen::VectorXd low_, high_;
};

// The coordinates of what the reference itself is not certain of, but for the capacity, which has an unknown of its
// own.
class ReferenceAxes {
 public:
  explicit ReferenceAxes(const ReferenceCell& reference) {
    if (!reference.cell.uncertainty) return;
    Cell cell = reference.cell;
    const bool held = reference.spread.log_capacity <= kHeldSpread;
    cell.uncertainty = UncertaintyAmong(cell, [&](const std::string& name) {
      return (held || name != "alpha") && CellParameter(cell, name).has_value();
    });
    if (cell.uncertainty->parameters.empty()) return;
    around_.emplace(cell);
    constexpr double kOfNote = 1e-3;  // one flight tells no more
    moves_ = PrincipalMoves(*around_, kOfNote);
  }
  [[nodiscard]] Eigen::Index count() const { return moves_.cols(); }
  [[nodiscard]] Eigen::MatrixXd Columns(const FlightModel& model,
                                        const Eigen::VectorXd& unknowns) const {
    if (!around_) return {};
    return ColumnsOf(*around_, around_->estimate(), moves_, model, unknowns);
  }

 private:
  std::optional<UncertainCell> around_;
  Eigen::MatrixXd moves_;
};

// Where a flight starts, by its first voltage with the drop of its current put back.
double StartGuess(const ReferenceCell& reference, const FlightSamples& flight) {
  const Record& record = flight.record;
  const double rest_V =
      record.voltage_V.front() + flight.edge_resistance_Ohm * record.current_A.front();
  return std::clamp(reference.cell.open_circuit_voltage.SocAtVoltage(rest_V), 0.05, 1.0);
}

// Where a search begins: the capacity over the reference, and how much noise is believed at first.
// Much of it holds the search near what was known before.
struct Beginning {
  double log_capacity;
  std::array<double, 5> noise;
};
constexpr Beginning kAsKnown{0.0, {0.03, 0.03, 2.0, 0.05, 60.0}};

// Where a search is, or ended.
struct SearchEnd {
  Eigen::VectorXd scaled;
  Eigen::VectorXd log_noise;
  double lag_s = 0.0;
  bool converged = false;
  double cost = kInfinity;                  // of the last search, at its noise
  double minus_log_likelihood = kInfinity;  // marginal, priors included
};

// Two searches of one end differ by less, in the logarithm of the likelihood.
constexpr double kClearly = 2.0;

class FlightSearch {
 public:
  FlightSearch(const ReferenceCell& reference,
               const FlightSamples& flight,
               const FlightModel& model,
               const SensorSpread& sensors)
      : reference_(reference),
        flight_(flight),
        model_(model),
        sensors_(sensors),
        problem_(flight, model, reference.spread, sensors),
        axes_(reference) {
    constexpr int kModes = 32;  // of a walk, all but two thirds of a per cent of its variance
    modes_A_ = flight.unresolved.Modes(kModes);
    problem_.SetReferences(axes_.count() + modes_A_.cols());
    // Half of a chi-square of some hundreds: what a step of this size moves shows in no interval. A log without
    // noise, as that of a simulated flight, takes several hundred steps to get there.
    options_.function_tolerance = 1e-7;
    options_.max_iterations = 600;
  }

  [[nodiscard]] SearchEnd From(const Beginning& beginning) {
    constexpr int kRounds = 4;
    SearchEnd at = Start(beginning);
    for (int round = 0; round < kRounds; ++round) {
      if (!Round(at, round == 0)) break;
    }
    return at;
  }

  // The ends of searches from where `from` was found, and from a smaller pack, with errors believed that are so
  // large that the search leaves where it is.
  [[nodiscard]] std::vector<SearchEnd> Again(const SearchEnd& from) {
    constexpr double kLarger = 10.0;  // than the errors that were found
    constexpr int kRounds = 3;
    std::vector<SearchEnd> ends;
    for (const double capacity : {1.0, 0.75}) {
      SearchEnd at = from;
      at.scaled[U::kCapacity] = problem_.Scaled(
          U::kCapacity, problem_.Natural(from.scaled)[U::kCapacity] + std::log(capacity));
      for (const int deviation : {0, 1, 3}) at.log_noise[deviation] += std::log(kLarger);
      int round = 0;
      while (round < kRounds && Round(at, false)) ++round;
      if (round == kRounds && at.converged) ends.push_back(std::move(at));
    }
    return ends;
  }

  [[nodiscard]] FlightFit Fit(const SearchEnd& end);
  [[nodiscard]] Eigen::VectorXd Unknowns(const SearchEnd& end) const {
    return problem_.Natural(end.scaled).head(model_.size());
  }

 private:
  [[nodiscard]] SearchEnd Start(const Beginning& beginning);
  // The lag and the noise that `at` has, for the problem.
  void Prepare(const SearchEnd& at) {
    problem_.lag_s = at.lag_s;
    problem_.noise = NoiseProblem::NoiseOf(at.log_noise);
    problem_.reference_columns = Columns(Unknowns(at));
  }
  // How the voltage at the rows moves with the axes of the reference and the modes of the current.
  [[nodiscard]] Eigen::MatrixXd Columns(const Eigen::VectorXd& unknowns) const;
  bool Minimize(SearchEnd& at) const;
  // With several beginnings of the diffusion at first.
  bool Round(SearchEnd& at, bool first);
  void LookForLag(const Eigen::MatrixXd& at_rows, double reach, SearchEnd& at) const;
  void EstimateNoise(const Eigen::MatrixXd& at_rows, SearchEnd& at) const;

  const ReferenceCell& reference_;
  const FlightSamples& flight_;
  const FlightModel& model_;
  const SensorSpread& sensors_;
  FlightProblem problem_;
  ReferenceAxes axes_;
  Eigen::MatrixXd modes_A_;
  LevenbergMarquardtOptions options_;
};

Eigen::MatrixXd FlightSearch::Columns(const Eigen::VectorXd& unknowns) const {
  const auto rows = static_cast<Eigen::Index>(flight_.record.size());
  Eigen::MatrixXd columns(rows, axes_.count() + modes_A_.cols());
  if (axes_.count() > 0) columns.leftCols(axes_.count()) = axes_.Columns(model_, unknowns);
  ParallelFor(static_cast<std::size_t>(modes_A_.cols()), [&](std::size_t mode) {
    const auto m = static_cast<Eigen::Index>(mode);
    columns.col(axes_.count() + m) = 0.5 * (model_.VoltageWith(unknowns, modes_A_.col(m)) -
                                            model_.VoltageWith(unknowns, -modes_A_.col(m)));
  });
  return columns;
}

SearchEnd FlightSearch::Start(const Beginning& beginning) {
  SearchEnd at;
  at.lag_s = flight_.lag_s;
  at.log_noise = NoiseProblem::Log(beginning.noise);
  at.scaled = Eigen::VectorXd::Zero(problem_.size());
  const auto start = [&](int u, double value) { at.scaled[u] = problem_.Scaled(u, value); };
  start(U::kStart, StartGuess(reference_, flight_));
  start(U::kCapacity, beginning.log_capacity);
  if (flight_.edge_resistance_Ohm > 0.0) {
    const auto edge =
        model_.StepResistance(Unknowns(at), 0.5, 0.3 * flight_.largest_A, flight_.settle_s());
    const double more = std::log(flight_.edge_resistance_Ohm / edge.resistance_Ohm);
    start(U::kSeries, more);
    start(U::kBranches, more);
  }
  return at;
}

bool FlightSearch::Minimize(SearchEnd& at) const {
  const OptimizationSummary found = MinimizeLevenbergMarquardt(problem_, at.scaled, options_);
  if (!found.usable()) return false;
  at.scaled = found.x;
  at.cost = found.cost;
  at.converged = found.termination == Termination::kConverged;
  return true;
}

bool FlightSearch::Round(SearchEnd& at, bool first) {
  Prepare(at);
  const SearchEnd from = at;
  bool found = Minimize(at);
  if (first && reference_.spread.log_beta > kHeldSpread) {
    // Of several beginnings the one that leads furthest: diffusion that is too slow empties the
    // cell at once, from where no slope leads back.
    for (const double log_beta : {0.7, 1.4}) {
      SearchEnd other = from;
      other.scaled[U::kBeta] = log_beta / problem_.deviation[U::kBeta];
      if (!Minimize(other) || (found && other.cost >= at.cost)) continue;
      at = other;
      found = true;
    }
  }
  if (!found) return false;
  const Eigen::MatrixXd at_rows = problem_.AtRows(at.scaled);
  LookForLag(at_rows, first ? 1.0 : 0.25, at);
  EstimateNoise(at_rows, at);
  return true;
}

// The lag, with everything else following to first order.
void FlightSearch::LookForLag(const Eigen::MatrixXd& at_rows, double reach, SearchEnd& at) const {
  const double step_s = std::max(0.005, 0.25 * std::min(flight_.voltage_update_s, 1.0));
  double best = kInfinity;
  const double from_s = at.lag_s;
  for (int k = -12; k <= 12; ++k) {
    const double lag_s = std::clamp(from_s + reach * k * step_s, -kLargestLag_s, kLargestLag_s);
    Eigen::MatrixXd columns = problem_.InWindows(at_rows, lag_s);
    problem_.noise.Whiten(flight_.time_s, columns);
    const NormalOf normal(columns, at.scaled);
    const double cost = normal.squares -
                        normal.score.dot(SolvePositive(normal.matrix, normal.score)) +
                        lag_s * lag_s / (sensors_.lag_s * sensors_.lag_s);
    if (cost < best) {
      best = cost;
      at.lag_s = lag_s;
    }
  }
}

void FlightSearch::EstimateNoise(const Eigen::MatrixXd& at_rows, SearchEnd& at) const {
  const Eigen::MatrixXd columns = problem_.InWindows(at_rows, at.lag_s);
  const NoiseProblem noise(flight_.time_s, columns, at.scaled);
  OptimizerSettings settings;
  settings.nelder_mead.initial_step = 0.3;
  settings.nelder_mead.step_tolerance = 1e-3;
  settings.nelder_mead.iterations_per_variable = 40;
  at.log_noise = at.log_noise.cwiseMax(noise.lower()).cwiseMin(noise.upper());
  const auto likely = FindOptimizer("nelder-mead").Minimize(noise, at.log_noise, settings);
  if (!likely.usable()) return;
  at.log_noise = likely.x;
  at.minus_log_likelihood = likely.cost;
}

FlightFit FlightSearch::Fit(const SearchEnd& end) {
  const Record& record = flight_.record;
  const int p = model_.size();
  FlightFit fit;
  fit.converged = end.converged;
  fit.duration_s = record.time_s.back() - record.time_s.front();
  fit.charge_C = DeliveredCharge(record).back();
  fit.start = StartOfFlight(record);
  fit.lag_s = end.lag_s;
  Prepare(end);
  fit.noise = problem_.noise;

  // The normal matrix with the lag among the unknowns.
  const int n = static_cast<int>(end.scaled.size());
  const Eigen::MatrixXd at_rows = problem_.AtRows(end.scaled);
  const Eigen::MatrixXd columns = problem_.WithLag(at_rows);
  Eigen::MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().head(n).array() += 1.0;
  normal(n, n) += 1.0 / (sensors_.lag_s * sensors_.lag_s);
  const Eigen::MatrixXd covariance = InverseOfPositive(normal);
  fit.unknowns = Unknowns(end);
  fit.covariance = problem_.deviation.head(p).asDiagonal() * covariance.topLeftCorner(p, p) *
                   problem_.deviation.head(p).asDiagonal();
  fit.lag_deviation_s = std::sqrt(covariance(n, n));
  fit.uncounted_with = Eigen::VectorXd::Zero(p);
  if (const Column& flowed_A = flight_.unresolved.flowed_A; !flowed_A.empty()) {
    const Eigen::Index modes = modes_A_.cols();
    Eigen::VectorXd of_modes_C = Eigen::VectorXd::Zero(modes);
    fit.uncounted_C = -fit.charge_C;
    for (std::size_t k = 1; k < record.size(); ++k) {
      const double dt_s = record.time_s[k] - record.time_s[k - 1];
      fit.uncounted_C += dt_s * flowed_A[k];
      of_modes_C += dt_s * modes_A_.row(static_cast<Eigen::Index>(k)).transpose();
    }
    const Eigen::VectorXd with = covariance.middleCols(n - modes, modes) * of_modes_C;
    fit.uncounted_C += of_modes_C.dot(end.scaled.tail(modes));
    fit.uncounted_variance_C2 = of_modes_C.dot(with.segment(n - modes, modes));
    fit.uncounted_with = problem_.deviation.head(p).cwiseProduct(with.head(p));
  }

  fit.voltage_V = at_rows.col(n);
  const auto errors = flight_.ErrorsOf(fit.voltage_V, fit.lag_s);
  fit.mean_error_percent = errors.mean_percent;
  fit.max_error_percent = errors.max_percent;
  return fit;
}

// Where another end is nearly as likely, the truth may be there: its distance counts by its probability.
void WidenTo(const std::vector<SearchEnd>& ends,
             const SearchEnd& found,
             const FlightSearch& search,
             FlightFit& fit) {
  double most = 0.0;
  double other = 0.0;
  Eigen::VectorXd away = Eigen::VectorXd::Zero(fit.unknowns.size());
  for (const SearchEnd& end : ends) {
    const double less_likely = end.minus_log_likelihood - found.minus_log_likelihood;
    const double share = 1.0 / (1.0 + std::exp(less_likely));
    const Eigen::VectorXd apart = search.Unknowns(end) - fit.unknowns;
    const double weight =
        share * apart[U::kCapacity] * apart[U::kCapacity];  // what a short flight is asked first
    if (!(weight > most)) continue;
    most = weight;
    away = std::sqrt(share) * apart;
    other = fit.unknowns[U::kCapacity] + apart[U::kCapacity];
  }
  constexpr double kWorthSaying = 1.25;
  const double before = fit.covariance(U::kCapacity, U::kCapacity);
  fit.covariance += away * away.transpose();
  const double after = fit.covariance(U::kCapacity, U::kCapacity);
  if (after > kWorthSaying * kWorthSaying * before) fit.nearly_as_likely = other;
}

// What was believed of the capacity and what the flight says exclude one another.
void FindAgainstBelief(const std::vector<SearchEnd>& ends,
                       const SearchEnd& found,
                       const FlightSearch& search,
                       double spread,
                       FlightFit& fit) {
  constexpr double kFar = 2.0;   // of what was believed
  constexpr double kMuch = 3.0;  // in the logarithm of the likelihood
  const auto by_voltages = [&](const SearchEnd& end) {
    const double off = search.Unknowns(end)[U::kCapacity] / spread;
    return end.minus_log_likelihood - 0.5 * off * off;
  };
  double least = by_voltages(found) - kMuch;
  for (const SearchEnd& end : ends) {
    const double log_capacity = search.Unknowns(end)[U::kCapacity];
    if (!end.converged || std::abs(log_capacity) <= kFar * spread || by_voltages(end) >= least)
      continue;
    least = by_voltages(end);
    fit.against_belief = log_capacity;
  }
}

}  // namespace

FlightFit FitFlight(const ReferenceCell& reference,
                    const FlightSamples& flight,
                    const FlightModel& model,
                    const SensorSpread& sensors) {
  FlightSearch search(reference, flight, model, sensors);
  SearchEnd found = search.From(kAsKnown);
  if (reference.spread.log_capacity <= kHeldSpread) return search.Fit(found);
  const auto take_clearly_likelier = [&](const SearchEnd& other) {
    if (other.converged && other.minus_log_likelihood < found.minus_log_likelihood - kClearly)
      found = other;
  };
  // A pack that is said to be much too large seems hardly used, and its curve hardly to fall: no slope
  // leads from there to a small one. So a search begins at the pack that this flight nearly empties,
  // too, and the likelier end is taken.
  constexpr double kNearlyEmpty = 0.1;
  constexpr double kMuchSmaller = -0.5;  // a factor of 0.6
  std::vector<SearchEnd> others;
  const double used = StartGuess(reference, flight) - kNearlyEmpty;
  const double charge_C = DeliveredCharge(flight.record).back();
  if (used > 0.0 && charge_C > 0.0) {
    const double small = std::log(charge_C / used / reference.cell.alpha_C());
    if (small < kMuchSmaller) {
      others.push_back(
          search.From({std::max(small, kLowestLogCapacity), {0.005, 0.005, 2.0, 0.005, 60.0}}));
      take_clearly_likelier(others.back());
    }
  }
  // v_oc(A) has kinks, to which a short flight of little noise fits in many places: each is the end of
  // searches that begin with this little noise. With more of it they begin as if most of the kinks were none.
  std::vector<SearchEnd> ends = search.Again(found);
  const SearchEnd first = found;
  for (const SearchEnd& other : ends) take_clearly_likelier(other);
  ends.push_back(first);
  FlightFit fit = search.Fit(found);
  WidenTo(ends, found, search, fit);
  others.insert(others.end(), ends.begin(), ends.end());
  FindAgainstBelief(others, found, search, reference.spread.log_capacity, fit);
  return fit;
}

FittedFlight FitAsFlowed(const ReferenceCell& reference,
                         FlightSamples& flight,
                         const Surroundings& among,
                         const SensorSpread& sensors) {
  constexpr double kLeft = 0.5;
  const auto fit_with = [&](const FlightSamples& samples) {
    FittedFlight fitted{
        std::make_unique<FlightModel>(reference, flight.record, among, samples.unresolved.flowed_A),
        {}};
    fitted.fit = FitFlight(reference, samples, *fitted.model, sensors);
    return fitted;
  };
  FittedFlight fitted = fit_with(flight);
  if (!flight.unresolved.any()) return fitted;
  FlightSamples means = flight;
  means.unresolved = {};
  FittedFlight held = fit_with(means);
  if (!(held.fit.mean_error_percent < kLeft * fitted.fit.mean_error_percent)) return fitted;
  flight.unresolved = {};
  return held;
}

}  // namespace lipoid
