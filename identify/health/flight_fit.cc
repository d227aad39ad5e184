#include "identify/health/flight_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/logs/segments.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/optimizers/optimizers.h"
#include "model/battery/cell_parameters.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

// How the voltage at every row moves with what the reference itself is not certain of, each
// coordinate in units of its standard deviation.
Eigen::MatrixXd ReferenceColumns(const ReferenceCell& reference,
                                 const FlightModel& model,
                                 const Eigen::VectorXd& unknowns,
                                 Eigen::Index rows) {
  const auto& uncertainty = reference.cell.uncertainty;
  if (!uncertainty) return Eigen::MatrixXd(rows, 0);
  // The capacity and what multiplies a whole resistance have unknowns of their own.
  std::vector<std::size_t> taken;
  for (std::size_t k = 0; k < uncertainty->parameters.size(); ++k) {
    if (uncertainty->parameters[k] != "alpha") taken.push_back(k);
  }
  const auto n = static_cast<Eigen::Index>(taken.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      covariance(a, b) =
          uncertainty
              ->covariance[taken[static_cast<std::size_t>(a)]][taken[static_cast<std::size_t>(b)]];
    }
  }
  const Eigen::VectorXd unit =
      covariance.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      unit.cwiseInverse().asDiagonal() * covariance * unit.cwiseInverse().asDiagonal());
  Eigen::MatrixXd columns(rows, 0);
  for (Eigen::Index e = n - 1; e >= 0; --e) {
    constexpr double kOfNote = 1e-3;
    if (solver.eigenvalues()[e] < kOfNote) break;
    const Eigen::VectorXd move =
        (std::sqrt(solver.eigenvalues()[e]) * unit).cwiseProduct(solver.eigenvectors().col(e));
    // A tenth of a standard deviation either way keeps what must be positive positive.
    constexpr double kStep = 0.1;
    Cell up = reference.cell;
    Cell down = reference.cell;
    for (Eigen::Index a = 0; a < n; ++a) {
      const std::string& name = uncertainty->parameters[taken[static_cast<std::size_t>(a)]];
      const auto value = CellParameter(reference.cell, name);
      if (!value) continue;
      const double step = name.rfind("v_oc", 0) == 0
                              ? kStep * move[a]
                              : std::clamp(kStep * move[a], -0.5 * *value, 0.5 * *value);
      SetCellParameter(up, name, *value + step);
      SetCellParameter(down, name, *value - step);
    }
    columns.conservativeResize(rows, columns.cols() + 1);
    columns.col(columns.cols() - 1) =
        (model.VoltageOf(up, unknowns) - model.VoltageOf(down, unknowns)) / (2.0 * kStep);
  }
  return columns;
}

// The problem at one lag and one noise. Parameters are in units of their deviation before the
// flight, from their mean before it.
class FlightProblem final : public LeastSquaresProblem {
 public:
  FlightProblem(const FlightSamples& flight, const FlightModel& model)
      : flight_(flight), model_(model) {}

  Eigen::VectorXd mean, deviation, low, high;
  Eigen::MatrixXd reference_columns;  // at rows
  double lag_s = 0.0;
  ColouredNoise noise;

  [[nodiscard]] int size() const override { return static_cast<int>(mean.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override {
    return (low - mean).cwiseQuotient(deviation);
  }
  [[nodiscard]] Eigen::VectorXd upper() const override {
    return (high - mean).cwiseQuotient(deviation);
  }
  [[nodiscard]] Eigen::VectorXd Natural(const Eigen::VectorXd& scaled) const {
    return mean + deviation.cwiseProduct(scaled);
  }
  // The slopes in the scaled parameters and the residuals, measured less predicted, with their
  // sign turned: columns [J r] at the rows.
  [[nodiscard]] Eigen::MatrixXd AtRows(const Eigen::VectorXd& scaled) const {
    const FlightPrediction at = model_.Predict(Natural(scaled).head(model_.size()));
    Eigen::MatrixXd columns(at.slope.rows(), size() + 1);
    columns.leftCols(model_.size()) = at.slope * deviation.head(model_.size()).asDiagonal();
    const Eigen::Index more = size() - model_.size();
    columns.middleCols(model_.size(), more) = reference_columns;
    columns.col(size()) = at.voltage_V;
    if (more > 0) columns.col(size()) += reference_columns * scaled.tail(more);
    return columns;
  }
  [[nodiscard]] Eigen::MatrixXd InWindows(const Eigen::MatrixXd& at_rows, double lag) const {
    Eigen::MatrixXd columns = flight_.InWindows(at_rows, lag);
    columns.col(columns.cols() - 1) -= flight_.voltage_V;
    return columns;
  }
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& scaled,
                                       bool jacobian) const override {
    Eigen::MatrixXd columns = InWindows(AtRows(scaled), lag_s);
    if (!columns.allFinite())
      return Eigen::MatrixXd::Constant(
          size() + 1, size() + 1, std::numeric_limits<double>::quiet_NaN());
    noise.Whiten(flight_.time_s, columns);
    const auto n = columns.rows();
    Eigen::MatrixXd all(n + size(), size() + 1);
    all.topRows(n) = columns;
    all.bottomLeftCorner(size(), size()).setIdentity();
    all.bottomRightCorner(size(), 1) = scaled;
    if (!jacobian) {
      Eigen::MatrixXd last = Eigen::MatrixXd::Zero(size() + 1, 1);
      last(size(), 0) = all.col(size()).norm();
      return last;
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(all);
    return qr.matrixQR().topRows(size() + 1).triangularView<Eigen::Upper>();
  }

 private:
  const FlightSamples& flight_;
  const FlightModel& model_;
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

// Where a flight starts, by its first voltage with the drop of its current put back.
double StartGuess(const ReferenceCell& reference, const FlightSamples& flight) {
  const Record& record = flight.record;
  const double rest_V =
      record.voltage_V.front() + flight.edge_resistance_Ohm * record.current_A.front();
  return std::clamp(reference.cell.open_circuit_voltage.SocAtVoltage(rest_V), 0.05, 1.0);
}

bool StartsAtRest(const Record& record) {
  constexpr double kRested_s = 3.0;
  const double rest_A = std::max(RestThreshold(record), 0.0);
  double largest_A = 0.0;
  for (const double i : record.current_A) largest_A = std::max(largest_A, std::abs(i));
  const double idle_A = std::max(rest_A, 0.05 * largest_A);
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record.time_s[k] - record.time_s.front() > kRested_s) return true;
    if (std::abs(record.current_A[k]) > idle_A) return false;
  }
  return false;
}

}  // namespace

FlightFit FitFlight(const ReferenceCell& reference,
                    const FlightSamples& flight,
                    const FlightModel& model,
                    const SensorSpread& sensors) {
  const Record& record = flight.record;
  FlightFit fit;
  fit.duration_s = record.time_s.back() - record.time_s.front();
  fit.charge_C = DeliveredCharge(record).back();
  fit.starts_at_rest = StartsAtRest(record);
  fit.lag_s = flight.lag_s;

  FlightProblem problem(flight, model);
  const int p = model.size();
  problem.mean = Eigen::VectorXd::Zero(p);
  problem.deviation = Eigen::VectorXd::Ones(p);
  problem.low = Eigen::VectorXd::Constant(p, -8.0);
  problem.high = Eigen::VectorXd::Constant(p, 8.0);
  const auto set = [&](int u, double mean, double deviation, double low, double high) {
    problem.mean[u] = mean;
    problem.deviation[u] = deviation;
    problem.low[u] = low;
    problem.high[u] = high;
  };
  const ReferenceSpread& spread = reference.spread;
  // What a flight starts with is hardly known before; a pack is not fuller than full.
  set(U::kStart, 0.8, 0.5, -0.05, 1.05);
  set(U::kCapacity, 0.0, spread.log_capacity, -3.0, 1.5);
  set(U::kSeries, 0.0, spread.log_series, -5.0, 4.0);
  set(U::kBranches, 0.0, spread.log_branches, -5.0, 4.0);
  set(U::kBeta, 0.0, spread.log_beta, -2.0, 2.0);
  set(U::kTau, 0.0, spread.log_time_constants, -3.0, 3.0);
  set(U::kWarming, 0.0, spread.log_warming, -3.0, 2.0);
  set(U::kScale, 0.0, sensors.current_scale, -0.5, 0.5);
  set(U::kOffset_A,
      0.0,
      std::max(sensors.least_offset_A, sensors.offset_share * flight.largest_A),
      -0.1 * flight.largest_A - 1.0,
      0.1 * flight.largest_A + 1.0);
  if (fit.starts_at_rest) {
    constexpr double kHeld = 1e-6;  // relaxed: nothing is left of an earlier current
    set(U::kBefore, 0.0, kHeld, -kHeld, kHeld);
  } else {
    set(U::kBefore, 0.6, 0.4, 0.0, 1.5);
  }

  Eigen::VectorXd scaled = Eigen::VectorXd::Zero(p);
  const auto start = [&](int u, double value) {
    scaled[u] = (std::clamp(value, problem.low[u], problem.high[u]) - problem.mean[u]) /
                problem.deviation[u];
  };
  start(U::kStart, StartGuess(reference, flight));
  if (flight.edge_resistance_Ohm > 0.0) {
    const auto edge = model.StepResistance(problem.Natural(scaled), 0.5, 0.3 * flight.largest_A);
    const double more = std::log(flight.edge_resistance_Ohm / edge.resistance_Ohm);
    start(U::kSeries, more);
    start(U::kBranches, more);
  }
  // Much noise at first: what was known before holds the search near it.
  Eigen::VectorXd log_noise = NoiseProblem::Log({0.03, 0.03, 2.0, 0.05, 60.0});
  problem.noise = NoiseProblem::NoiseOf(log_noise);

  Eigen::MatrixXd at_rows;
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    problem.lag_s = fit.lag_s;
    problem.reference_columns = ReferenceColumns(reference,
                                                 model,
                                                 problem.Natural(scaled).head(p),
                                                 static_cast<Eigen::Index>(record.size()));
    if (const auto more = problem.reference_columns.cols(); round == 0 && more > 0) {
      const auto grow = [&](Eigen::VectorXd& v, double value) {
        v.conservativeResize(p + more);
        v.tail(more).setConstant(value);
      };
      grow(problem.mean, 0.0);
      grow(problem.deviation, 1.0);
      grow(problem.low, -8.0);
      grow(problem.high, 8.0);
      grow(scaled, 0.0);
    } else if (more != scaled.size() - p) {
      problem.reference_columns.conservativeResize(Eigen::NoChange, scaled.size() - p);
    }
    LevenbergMarquardtOptions options;
    options.function_tolerance = 1e-9;
    options.max_iterations = 60;
    OptimizationSummary found = MinimizeLevenbergMarquardt(problem, scaled, options);
    if (round == 0) {
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
      const double cost = columns.col(n).squaredNorm() - score.dot(normal.llt().solve(score)) +
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
    if (likely.usable()) log_noise = likely.x;
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
  const Eigen::MatrixXd covariance = normal.llt().solve(Eigen::MatrixXd::Identity(n + 1, n + 1));
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
  return fit;
}

}  // namespace lipoid
