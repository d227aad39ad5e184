#include "identify/health/flight_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "identify/health/flight_problem.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/optimizers/optimizers.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/uncertain_cell.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

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
    const auto p = columns.cols() - 1;
    Eigen::MatrixXd normal = columns.leftCols(p).transpose() * columns.leftCols(p);
    normal.diagonal().array() += 1.0;
    const Eigen::VectorXd score = columns.leftCols(p).transpose() * columns.col(p) + scaled_;
    const Eigen::LLT<Eigen::MatrixXd> factor(normal);
    const double squares =
        columns.col(p).squaredNorm() + scaled_.squaredNorm() - score.dot(factor.solve(score));
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

struct FoundFrom {
  FlightFit fit;
  double minus_log_likelihood =
      std::numeric_limits<double>::infinity();  // marginal, priors included
};

// Where a search begins: the capacity over the reference, and how much noise is believed at first.
// Much of it holds the search near what was known before.
struct Beginning {
  double log_capacity;
  std::array<double, 5> noise;
};
constexpr Beginning kAsKnown{0.0, {0.03, 0.03, 2.0, 0.05, 60.0}};

FoundFrom FitFrom(const Beginning& beginning,
                  const ReferenceCell& reference,
                  const FlightSamples& flight,
                  const FlightModel& model,
                  const SensorSpread& sensors) {
  const Record& record = flight.record;
  FoundFrom found_from;
  FlightFit& fit = found_from.fit;
  fit.duration_s = record.time_s.back() - record.time_s.front();
  fit.charge_C = DeliveredCharge(record).back();
  fit.starts_at_rest = StartsAtRest(record);
  fit.lag_s = flight.lag_s;

  const int p = model.size();
  FlightProblem problem(flight, model, reference.spread, sensors);
  const ReferenceAxes axes(reference);
  problem.SetReferences(axes.count());

  Eigen::VectorXd scaled = Eigen::VectorXd::Zero(problem.size());
  const auto start = [&](int u, double value) { scaled[u] = problem.Scaled(u, value); };
  start(U::kStart, StartGuess(reference, flight));
  start(U::kCapacity, beginning.log_capacity);
  if (flight.edge_resistance_Ohm > 0.0) {
    const auto edge =
        model.StepResistance(problem.Natural(scaled).head(p), 0.5, 0.3 * flight.largest_A);
    const double more = std::log(flight.edge_resistance_Ohm / edge.resistance_Ohm);
    start(U::kSeries, more);
    start(U::kBranches, more);
  }
  Eigen::VectorXd log_noise = NoiseProblem::Log(beginning.noise);
  problem.noise = NoiseProblem::NoiseOf(log_noise);

  Eigen::MatrixXd at_rows;
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    problem.lag_s = fit.lag_s;
    problem.reference_columns = axes.Columns(model, problem.Natural(scaled).head(p));
    LevenbergMarquardtOptions options;
    // Half of a chi-square of some hundreds: what a step of this size moves shows in no interval. A log without
    // noise, as that of a simulated flight, takes several hundred steps to get there.
    options.function_tolerance = 1e-7;
    options.max_iterations = 600;
    OptimizationSummary found = MinimizeLevenbergMarquardt(problem, scaled, options);
    if (round == 0 && reference.spread.log_beta > kHeldSpread) {
      // Of several beginnings the one that leads furthest: diffusion that is too slow empties the
      // cell at once, from where no slope leads back.
      for (const double beta : {0.7, 1.4}) {
        Eigen::VectorXd other = scaled;
        other[U::kBeta] = beta / problem.deviation[U::kBeta];
        const OptimizationSummary again = MinimizeLevenbergMarquardt(problem, other, options);
        if (again.usable() && (!found.usable() || again.cost < found.cost)) found = again;
      }
    }
    if (!found.usable()) break;
    scaled = found.x;
    fit.converged = found.termination == Termination::kConverged;
    at_rows = problem.AtRows(scaled);

    // The lag, with everything else following to first order.
    const double step_s = std::max(0.005, 0.25 * std::min(flight.voltage_update_s, 1.0));
    double best = std::numeric_limits<double>::infinity();
    const double from_s = fit.lag_s;
    for (int k = -12; k <= 12; ++k) {
      const double lag_s = std::clamp(
          from_s + (round == 0 ? 1.0 : 0.25) * k * step_s, -kLargestLag_s, kLargestLag_s);
      Eigen::MatrixXd columns = problem.InWindows(at_rows, lag_s);
      problem.noise.Whiten(flight.time_s, columns);
      const auto n = columns.cols() - 1;
      Eigen::MatrixXd normal = columns.leftCols(n).transpose() * columns.leftCols(n);
      normal.diagonal().array() += 1.0;
      const Eigen::VectorXd score = columns.leftCols(n).transpose() * columns.col(n) + scaled;
      const double cost = columns.col(n).squaredNorm() - score.dot(SolvePositive(normal, score)) +
                          lag_s * lag_s / (sensors.lag_s * sensors.lag_s);
      if (cost < best) {
        best = cost;
        fit.lag_s = lag_s;
      }
    }
    const Eigen::MatrixXd columns = problem.InWindows(at_rows, fit.lag_s);
    const NoiseProblem noise(flight.time_s, columns, scaled);
    OptimizerSettings settings;
    settings.nelder_mead.initial_step = 0.3;
    settings.nelder_mead.step_tolerance = 1e-3;
    settings.nelder_mead.iterations_per_variable = 40;
    log_noise = log_noise.cwiseMax(noise.lower()).cwiseMin(noise.upper());
    const auto likely = FindOptimizer("nelder-mead").Minimize(noise, log_noise, settings);
    if (likely.usable()) {
      log_noise = likely.x;
      found_from.minus_log_likelihood = likely.cost;
    }
    problem.noise = NoiseProblem::NoiseOf(log_noise);
  }
  fit.noise = problem.noise;

  // The normal matrix with the lag among the unknowns.
  const int n = static_cast<int>(scaled.size());
  at_rows = problem.AtRows(scaled);
  Eigen::MatrixXd columns(flight.voltage_V.size(), n + 1);
  columns.leftCols(n) = flight.InWindows(at_rows.leftCols(n), fit.lag_s);
  columns.col(n) = flight.LagSlope(at_rows.col(n), fit.lag_s);
  problem.noise.Whiten(flight.time_s, columns);
  Eigen::MatrixXd normal = columns.transpose() * columns;
  normal.diagonal().head(n).array() += 1.0;
  normal(n, n) += 1.0 / (sensors.lag_s * sensors.lag_s);
  const Eigen::MatrixXd covariance = InverseOfPositive(normal);
  fit.unknowns = problem.Natural(scaled).head(p);
  fit.prior_deviation = problem.deviation.head(p);
  fit.covariance = problem.deviation.head(p).asDiagonal() * covariance.topLeftCorner(p, p) *
                   problem.deviation.head(p).asDiagonal();
  fit.lag_deviation_s = std::sqrt(covariance(n, n));

  fit.voltage_V = at_rows.col(n);
  fit.soc = model.Predict(fit.unknowns).soc;
  const Eigen::VectorXd at_fresh = flight.AtFresh(fit.voltage_V, fit.lag_s);
  for (std::size_t f = 0; f < flight.fresh.size(); ++f) {
    const double measured_V = record.voltage_V[flight.fresh[f]];
    const double error =
        100.0 * std::abs(at_fresh[static_cast<Eigen::Index>(f)] / measured_V - 1.0);
    fit.mean_error_percent += error / static_cast<double>(flight.fresh.size());
    fit.max_error_percent = std::max(fit.max_error_percent, error);
  }
  return found_from;
}

}  // namespace

FlightFit FitFlight(const ReferenceCell& reference,
                    const FlightSamples& flight,
                    const FlightModel& model,
                    const SensorSpread& sensors) {
  FoundFrom found = FitFrom(kAsKnown, reference, flight, model, sensors);
  // A pack that is said to be much too large seems hardly used, and its curve hardly to fall: no slope
  // leads from there to a small one. So a search begins at the pack that this flight nearly empties,
  // too, and the likelier end is taken.
  constexpr double kNearlyEmpty = 0.1;
  constexpr double kMuchSmaller = -0.5;  // a factor of 0.6
  const double used = StartGuess(reference, flight) - kNearlyEmpty;
  if (reference.spread.log_capacity <= kHeldSpread || !(used > 0.0) || !(found.fit.charge_C > 0.0))
    return std::move(found.fit);
  const double small = std::log(found.fit.charge_C / used / reference.cell.alpha_C());
  if (small < kMuchSmaller) {
    const Beginning nearly_empty{std::max(small, kLowestLogCapacity),
                                 {0.005, 0.005, 2.0, 0.005, 60.0}};
    FoundFrom other = FitFrom(nearly_empty, reference, flight, model, sensors);
    constexpr double kClearly = 2.0;  // two searches of one end differ by less
    if (other.fit.converged && other.minus_log_likelihood < found.minus_log_likelihood - kClearly)
      found = std::move(other);
  }
  return std::move(found.fit);
}

}  // namespace lipoid
