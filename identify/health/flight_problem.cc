#include "identify/health/flight_problem.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

}  // namespace

WithInterval WithinPack(WithInterval soc) {
  soc.low = std::min(soc.value, std::max(soc.low, kLeastStart_soc));
  soc.high = std::max(soc.value, std::min(soc.high, kMostStart_soc));
  return soc;
}

FlightStart StartOfFlight(const Record& record) {
  constexpr double kRested_s = 3.0;
  const double rest_A = std::max(RestThreshold(record), 0.0);
  const double idle_A = std::max(rest_A, 0.05 * LargestMagnitude(record.current_A));
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record.time_s[k] - record.time_s.front() > kRested_s) return FlightStart::kRested;
    if (std::abs(record.current_A[k]) > idle_A)
      return k > 0 ? FlightStart::kIdle : FlightStart::kLoaded;
  }
  return FlightStart::kIdle;
}

std::optional<double> RestVoltage(const Record& record) {
  constexpr double kRest_s = 2.0;
  if (StartOfFlight(record) != FlightStart::kRested) return std::nullopt;
  double sum_V = 0.0;
  double rows = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record.time_s[k] - record.time_s.front() > kRest_s) break;
    sum_V += record.voltage_V[k];
    rows += 1.0;
  }
  return sum_V / rows;
}

Eigen::MatrixXd ColumnsOf(const UncertainCell& around,
                          const Eigen::VectorXd& at,
                          const Eigen::MatrixXd& moves,
                          const FlightModel& model,
                          const Eigen::VectorXd& unknowns) {
  // Of a standard deviation, so small that next to no row passes a kink of v_oc(A) on the way: such
  // rows would seem to tell the capacity from the scale of the current.
  constexpr double kStep = 1e-3;
  std::vector<Eigen::VectorXd> slopes(static_cast<std::size_t>(moves.cols()));
  ParallelFor(slopes.size(), [&](std::size_t e) {
    const auto voltage_V = [&](double step) {
      Cell cell = around.At(at + step * moves.col(static_cast<Eigen::Index>(e)));
      if (cell.temperature) cell.self_heating.reset();  // whose parameters the flight does not show
      return model.VoltageOf(cell, unknowns);
    };
    slopes[e] = (voltage_V(kStep) - voltage_V(-kStep)) / (2.0 * kStep);
  });
  Eigen::MatrixXd columns;
  if (!slopes.empty()) columns.resize(slopes.front().size(), moves.cols());
  for (Eigen::Index e = 0; e < columns.cols(); ++e)
    columns.col(e) = slopes[static_cast<std::size_t>(e)];
  return columns;
}

FlightProblem::FlightProblem(const FlightSamples& flight,
                             const FlightModel& model,
                             const ReferenceSpread& spread,
                             const SensorSpread& sensors)
    : mean(Eigen::VectorXd::Zero(model.size())),
      deviation(Eigen::VectorXd::Ones(model.size())),
      low(Eigen::VectorXd::Constant(model.size(), -8.0)),
      high(Eigen::VectorXd::Constant(model.size(), 8.0)),
      flight_(flight),
      model_(model) {
  const auto set = [&](int u, double mean_of, double deviation_of, double low_of, double high_of) {
    mean[u] = mean_of;
    deviation[u] = deviation_of;
    low[u] = low_of;
    high[u] = high_of;
  };
  // What a flight starts with is hardly known before; a pack is not fuller than full.
  set(U::kStart, 0.8, 0.5, kLeastStart_soc, kMostStart_soc);
  set(U::kCapacity, 0.0, spread.log_capacity, kLowestLogCapacity, kHighestLogCapacity);
  set(U::kSeries, 0.0, spread.log_series, -5.0, 4.0);
  set(U::kBranches, 0.0, spread.log_branches, -5.0, 4.0);
  set(U::kBeta, 0.0, spread.log_beta, -2.0, 2.0);
  set(U::kTau, 0.0, spread.log_time_constants, -3.0, 3.0);
  set(U::kWarming, 0.0, spread.log_warming, -3.0, 2.0);
  set(U::kScale, 0.0, sensors.current_scale, -0.5, 0.5);
  set(U::kOffset_A,
      0.0,
      sensors.OffsetOf(flight.largest_A),
      -0.1 * flight.largest_A - 1.0,
      0.1 * flight.largest_A + 1.0);
  switch (StartOfFlight(flight.record)) {
    case FlightStart::kRested:  // nothing is left of an earlier current
      set(U::kBefore, 0.0, kHeldSpread, -kHeldSpread, kHeldSpread);
      break;
    case FlightStart::kIdle:  // most often nothing, unless it landed just before
      set(U::kBefore, 0.0, 0.4, 0.0, 1.5);
      break;
    case FlightStart::kLoaded:
      set(U::kBefore, 0.6, 0.4, 0.0, 1.5);
      break;
  }
}

double FlightProblem::Scaled(int unknown, double value) const {
  constexpr double kFarthest = 8.0;
  const double within = std::clamp(value, low[unknown], high[unknown]);
  return std::clamp((within - mean[unknown]) / deviation[unknown], -kFarthest, kFarthest);
}

void FlightProblem::SetReferences(Eigen::Index count) {
  const auto grow = [&](Eigen::VectorXd& v, double value) {
    v.conservativeResize(model_.size() + count);
    v.tail(count).setConstant(value);
  };
  grow(mean, 0.0);
  grow(deviation, 1.0);
  grow(low, -8.0);
  grow(high, 8.0);
}

Eigen::MatrixXd FlightProblem::AtRows(const Eigen::VectorXd& scaled) const {
  const FlightPrediction at = model_.Predict(Natural(scaled).head(model_.size()));
  Eigen::MatrixXd columns(at.slope.rows(), size() + 1);
  columns.leftCols(model_.size()) = at.slope * deviation.head(model_.size()).asDiagonal();
  columns.col(size()) = at.voltage_V;
  const Eigen::Index more = size() - model_.size();
  if (more == 0) return columns;
  columns.middleCols(model_.size(), more) = reference_columns;
  Eigen::VectorXd from = scaled.tail(more);
  if (reference_at.size() > 0) from -= reference_at;
  columns.col(size()) += reference_columns * from;
  return columns;
}

Eigen::MatrixXd FlightProblem::InWindows(const Eigen::MatrixXd& at_rows, double lag) const {
  Eigen::MatrixXd columns = flight_.InWindows(at_rows, lag);
  columns.col(columns.cols() - 1) -= flight_.voltage_V;
  return columns;
}

Eigen::MatrixXd FlightProblem::WithLag(const Eigen::MatrixXd& at_rows) const {
  Eigen::MatrixXd columns = flight_.InWindows(at_rows, lag_s);
  columns.col(size()) = flight_.LagSlope(at_rows.col(size()), lag_s);
  noise.Whiten(flight_.time_s, columns);
  return columns;
}

Eigen::MatrixXd FlightProblem::Whitened(const Eigen::VectorXd& scaled) const {
  Eigen::MatrixXd columns = InWindows(AtRows(scaled), lag_s);
  if (columns.allFinite()) noise.Whiten(flight_.time_s, columns);
  return columns;
}

Eigen::MatrixXd FlightProblem::Factor(const Eigen::VectorXd& scaled, bool jacobian) const {
  const Eigen::MatrixXd columns = Whitened(scaled);
  if (!columns.allFinite()) return Eigen::MatrixXd::Constant(size() + 1, size() + 1, kNaN);
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
  return TriangularFactor(all);
}

}  // namespace lipoid
