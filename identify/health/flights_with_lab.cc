#include "identify/health/flights_with_lab.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "identify/health/flight_problem.h"
#include "identify/logs/plausibility.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/parallel.h"
#include "model/statistics/factorizations.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

// One of so many flights of the same cell is further from what its lab logs say.
constexpr double kOneOf = 1000.0;
// The share of its variance that a direction must lose before the flights are said to speak of it.
constexpr double kSpoken = 0.02;

// Of the variance of a single parameter: combinations that the lab knows better stay as they are.
constexpr double kKnown = 1e-6;

// A flight on the cell at one point of its coordinates.
struct OnCell {
  std::unique_ptr<ReferenceCell> reference;  // the model knows where it is
  std::unique_ptr<FlightModel> model;
  std::unique_ptr<FlightProblem> problem;
};

struct Flying {
  std::string file;
  FlightSamples samples;
  Surroundings among;
  bool temperature_known = false;
  FlightFit alone;  // against the cell of the lab

  // With slopes in the coordinates of the cell about the unknowns, where there are any.
  [[nodiscard]] OnCell On(const UncertainCell& around,
                          const Eigen::MatrixXd& moves,
                          const Eigen::VectorXd& coordinates,
                          const Eigen::VectorXd* unknowns) const {
    Eigen::VectorXd x = around.estimate() + moves * coordinates;
    around.MoveIntoRange(x);
    OnCell on;
    on.reference = std::make_unique<ReferenceCell>(SameCell(around.At(x), temperature_known));
    on.model = std::make_unique<FlightModel>(
        *on.reference, samples.record, among, samples.unresolved.flowed_A);
    on.problem =
        std::make_unique<FlightProblem>(samples, *on.model, on.reference->spread, SensorSpread());
    on.problem->SetReferences(moves.cols());
    on.problem->reference_at = coordinates;
    on.problem->lag_s = alone.lag_s;
    on.problem->noise = alone.noise;
    on.problem->reference_columns =
        unknowns != nullptr
            ? ColumnsOf(around, x, moves, *on.model, *unknowns)
            : Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(samples.record.size()), moves.cols());
    return on;
  }
};

// The coordinates of the cell, then the unknowns of each flight.
class AllFlights final : public LeastSquaresProblem {
 public:
  AllFlights(const std::vector<Flying>& flying,
             const UncertainCell& around,
             const Eigen::MatrixXd& moves)
      : flying_(flying), around_(around), moves_(moves), coordinates_(moves.cols()) {
    for (const Flying& one : flying)
      first_.push_back(one.On(around, moves, Eigen::VectorXd::Zero(coordinates_), nullptr));
  }

  [[nodiscard]] Eigen::Index Unknowns() const { return first_.front().model->size(); }
  // Of one flight, on the cell of the lab: what scales its unknowns is the same on any other.
  [[nodiscard]] const FlightProblem& Scale(std::size_t flight) const {
    return *first_[flight].problem;
  }
  [[nodiscard]] Eigen::VectorXd UnknownsOf(std::size_t flight,
                                           const Eigen::VectorXd& scaled) const {
    return Scale(flight).Natural(Of(flight, scaled)).head(Unknowns());
  }
  // One flight on the cell that belongs to the parameters.
  [[nodiscard]] OnCell On(std::size_t flight, const Eigen::VectorXd& scaled, bool slopes) const {
    const Eigen::VectorXd unknowns = UnknownsOf(flight, scaled);
    return flying_[flight].On(
        around_, moves_, scaled.head(coordinates_), slopes ? &unknowns : nullptr);
  }
  [[nodiscard]] Eigen::Index First(std::size_t flight) const {
    return coordinates_ + static_cast<Eigen::Index>(flight) * Unknowns();
  }
  [[nodiscard]] int size() const override { return static_cast<int>(First(flying_.size())); }
  [[nodiscard]] Eigen::VectorXd lower() const override {
    return Gather([](const FlightProblem& one) { return one.lower(); });
  }
  [[nodiscard]] Eigen::VectorXd upper() const override {
    return Gather([](const FlightProblem& one) { return one.upper(); });
  }
  // The parameters of one flight.
  [[nodiscard]] Eigen::VectorXd Of(std::size_t flight, const Eigen::VectorXd& scaled) const {
    Eigen::VectorXd own(Unknowns() + coordinates_);
    own << scaled.segment(First(flight), Unknowns()), scaled.head(coordinates_);
    return own;
  }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& scaled,
                                       bool jacobian) const override {
    const Eigen::Index own = Unknowns() + coordinates_ + 1;
    std::vector<Eigen::MatrixXd> of(flying_.size());
    ParallelFor(flying_.size(), [&](std::size_t f) {
      const Eigen::MatrixXd columns = On(f, scaled, jacobian).problem->Whitened(Of(f, scaled));
      if (!columns.allFinite()) {
        of[f] = Eigen::MatrixXd::Constant(own, own, std::numeric_limits<double>::quiet_NaN());
      } else if (!jacobian) {
        of[f] = Eigen::MatrixXd::Zero(own, own);
        of[f](0, own - 1) = columns.col(own - 1).norm();
      } else {
        of[f] = Eigen::MatrixXd::Zero(own, own);
        of[f].topRows(std::min(columns.rows(), own)) = TriangularFactor(columns);
      }
    });
    const Eigen::Index n = size();
    Eigen::MatrixXd all =
        Eigen::MatrixXd::Zero(n + own * static_cast<Eigen::Index>(flying_.size()), n + 1);
    all.topLeftCorner(n, n).setIdentity();  // what was known before
    all.topRightCorner(n, 1) = scaled;
    for (std::size_t f = 0; f < flying_.size(); ++f) {
      const Eigen::Index row = n + own * static_cast<Eigen::Index>(f);
      all.block(row, First(f), own, Unknowns()) = of[f].leftCols(Unknowns());
      all.block(row, 0, own, coordinates_) = of[f].middleCols(Unknowns(), coordinates_);
      all.block(row, n, own, 1) = of[f].rightCols(1);
    }
    if (!jacobian) {
      Eigen::MatrixXd last = Eigen::MatrixXd::Zero(n + 1, 1);
      last(n, 0) = all.col(n).norm();
      return last;
    }
    return TriangularFactor(all);
  }

  // Of all parameters and, after them, of the lag of each flight.
  [[nodiscard]] Eigen::MatrixXd Covariance(const Eigen::VectorXd& scaled) const {
    const Eigen::Index n = size();
    const auto flights = static_cast<Eigen::Index>(flying_.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n + flights, n + flights);
    normal.diagonal().head(n).setOnes();
    for (std::size_t f = 0; f < flying_.size(); ++f) {
      const OnCell on = On(f, scaled, true);
      const Eigen::Index own = Unknowns() + coordinates_;
      const Eigen::MatrixXd columns = on.problem->WithLag(on.problem->AtRows(Of(f, scaled)));
      Eigen::VectorXi place(own + 1);
      for (Eigen::Index k = 0; k < Unknowns(); ++k) place[k] = static_cast<int>(First(f) + k);
      for (Eigen::Index k = 0; k < coordinates_; ++k) place[Unknowns() + k] = static_cast<int>(k);
      place[own] = static_cast<int>(n + static_cast<Eigen::Index>(f));
      normal(place, place) += columns.transpose() * columns;
      const double lag_s = SensorSpread().lag_s;
      normal(place[own], place[own]) += 1.0 / (lag_s * lag_s);
    }
    return InverseOfPositive(normal);
  }

 private:
  template <class Get>
  [[nodiscard]] Eigen::VectorXd Gather(Get&& get) const {
    Eigen::VectorXd all(size());
    all.head(coordinates_) = get(Scale(0)).tail(coordinates_);
    for (std::size_t f = 0; f < flying_.size(); ++f)
      all.segment(First(f), Unknowns()) = get(Scale(f)).head(Unknowns());
    return all;
  }

  const std::vector<Flying>& flying_;
  const UncertainCell& around_;
  const Eigen::MatrixXd& moves_;
  Eigen::Index coordinates_;
  std::vector<OnCell> first_;
};

WithInterval Symmetric(double value, double variance, double freedom) {
  const double reach = Reach95(freedom) * std::sqrt(std::max(variance, 0.0));
  return {value, value - reach, value + reach, {}};
}

std::vector<Flying> Prepare(const Cell& cell,
                            const std::vector<LoadedLog>& logs,
                            std::vector<Diagnostic>& refused) {
  std::vector<Flying> flying;
  for (const LoadedLog& loaded : logs) {
    if (loaded.entry.kind != LogKind::kFlight) continue;
    const auto wrong = DiagnosticsOf([&] {
      RefuseIdleFlight(loaded.log.record, cell.alpha_C() / 3600.0);
      CheckPlausible(loaded.log.record, cell.alpha_C() / 3600.0);
    });
    refused.insert(refused.end(), wrong.begin(), wrong.end());
    if (!wrong.empty()) continue;
    Flying& one = flying.emplace_back();
    one.file = loaded.entry.file;
    one.samples = SampleFlight(loaded.log);
    one.among = {.measured_degC = one.samples.record.temperature_degC,
                 .ambient_degC = loaded.entry.ambient_degC,
                 .initial_degC = loaded.entry.initial_degC};
    const bool from_rest = StartOfFlight(one.samples.record) != FlightStart::kLoaded;
    one.temperature_known = !one.among.measured_degC.empty() || one.among.initial_degC ||
                            (one.among.ambient_degC && from_rest);
  }
  ParallelFor(flying.size(), [&](std::size_t f) {
    Flying& one = flying[f];
    const ReferenceCell reference = SameCell(cell, one.temperature_known);
    one.alone = FitAsFlowed(reference, one.samples, one.among, SensorSpread()).fit;
    if (!one.samples.unresolved.any()) return;
    // Here what flowed between values of the current beside their mean is left to the noise.
    for (double& deviation_A : one.samples.unresolved.deviation_A) deviation_A = 0.0;
    const FlightModel model(
        reference, one.samples.record, one.among, one.samples.unresolved.flowed_A);
    one.alone = FitFlight(reference, one.samples, model, SensorSpread());
  });
  return flying;
}

// How far the coordinates are from those of the lab, over how far they may be, in the directions of which the
// flights speak.
void Measure(FlightsWithLab& found, double freedom) {
  const SymmetricEigen eigen = EigenOfSymmetric(found.coordinate_covariance);
  for (Eigen::Index e = 0; e < eigen.values.size(); ++e) {
    const double told = 1.0 - eigen.values[e];
    if (told < kSpoken) continue;
    const double along = eigen.vectors.col(e).dot(found.coordinates);
    found.distance += along * along / told;
    ++found.directions;
  }
  if (found.directions == 0) return;
  found.distance_limit = found.directions * FisherPassed(found.directions, freedom, 1.0 / kOneOf);
}

}  // namespace

FlightsWithLab FitFlightsWithLab(const Cell& cell, const std::vector<LoadedLog>& logs) {
  FlightsWithLab found;
  found.cell = cell;
  if (!cell.uncertainty) {
    found.not_taken_because =
        "the lab logs say nothing of how uncertain their cell is, so that flights cannot be weighed "
        "against them";
    return found;
  }
  Cell one = cell.AsOne();
  one.uncertainty = UncertaintyAmong(one, [](const std::string&) { return true; });
  const UncertainCell around(one);
  // In flight a cell warms, also one of which the lab logs do not say how that changes it.
  Cell warming = SameCell(one, true).cell;
  // The heat balance stands in for a self-heating of the lab, whose parameters no flight moves.
  warming.self_heating = one.self_heating;
  const UncertainCell in_flight(warming);
  found.moves = PrincipalMoves(around, kKnown);
  std::vector<Flying> flying = Prepare(one, logs, found.refused);
  if (flying.empty()) {
    found.not_taken_because = "none of the flights is long and busy enough to say anything";
    return found;
  }

  const Eigen::Index coordinates = found.moves.cols();
  const AllFlights problem(flying, in_flight, found.moves);
  Eigen::VectorXd from = Eigen::VectorXd::Zero(problem.size());
  for (std::size_t f = 0; f < flying.size(); ++f) {
    for (int u = 0; u < static_cast<int>(problem.Unknowns()); ++u)
      from[problem.First(f) + u] = problem.Scale(f).Scaled(u, flying[f].alone.unknowns[u]);
  }
  LevenbergMarquardtOptions options;
  options.function_tolerance = 1e-9;
  options.max_iterations = 100;
  const OptimizationSummary best = MinimizeLevenbergMarquardt(problem, from, options);
  if (!best.usable()) {
    found.not_taken_because = "the fit of the flights with the lab logs failed: " + best.message;
    return found;
  }
  found.converged = best.termination == Termination::kConverged;
  const Eigen::VectorXd& scaled = best.x;

  const Eigen::MatrixXd covariance = problem.Covariance(scaled);
  found.coordinates = scaled.head(coordinates);
  found.coordinate_covariance = covariance.topLeftCorner(coordinates, coordinates);
  const double freedom = std::min(kFlightFreedom, around.degrees_of_freedom());
  for (std::size_t f = 0; f < flying.size(); ++f) {
    const Flying& one_flying = flying[f];
    FlightsWithLab::Flight& flight = found.flights.emplace_back();
    const Eigen::VectorXd& deviation = problem.Scale(f).deviation;
    const Eigen::VectorXd own = problem.UnknownsOf(f, scaled);
    const auto with = [&](int u) {
      const Eigen::Index k = problem.First(f) + u;
      return Symmetric(own[u], covariance(k, k) * deviation[u] * deviation[u], freedom);
    };
    flight.file = one_flying.file;
    flight.soc_start = WithinPack(with(U::kStart));
    flight.current_scale = with(U::kScale);
    for (double* value :
         {&flight.current_scale.value, &flight.current_scale.low, &flight.current_scale.high})
      *value += 1.0;
    flight.current_offset_A = with(U::kOffset_A);
    const Eigen::Index lag = problem.size() + static_cast<Eigen::Index>(f);
    flight.lag_s = Symmetric(one_flying.alone.lag_s, covariance(lag, lag), freedom);
    flight.window_s = one_flying.samples.window_s;
    flight.coherence = one_flying.samples.coherence;
    flight.temperature_known = one_flying.temperature_known;
    flight.noise = one_flying.alone.noise;
    const Eigen::MatrixXd at_rows =
        problem.On(f, scaled, false).problem->AtRows(problem.Of(f, scaled));
    const auto errors = one_flying.samples.ErrorsOf(at_rows.rightCols(1), one_flying.alone.lag_s);
    flight.mean_error_percent = errors.mean_percent;
    flight.max_error_percent = errors.max_percent;
    flight.cautions = one_flying.samples.Said();
    if (!one_flying.samples.doubt.empty()) flight.cautions.push_back(one_flying.samples.doubt);
    if (!flight.temperature_known) {
      flight.cautions.emplace_back(
          "the temperature is not known (ambient_degC; of a flight that starts under load initial_degC): the flight "
          "says little of resistances");
    }
  }
  Measure(found, freedom);
  if (found.distance > found.distance_limit) {
    found.not_taken_because = fmt::format(
        "the flights contradict the lab logs: they would move the cell by {:.3g} in a measure that stays below "
        "{:.3g} in 999 of 1000 flights on the same cell, so the pack has aged or is another; `health` says "
        "what has become of it",
        found.distance,
        found.distance_limit);
    return found;
  }
  if (!found.converged) {
    found.not_taken_because = "the fit of the flights with the lab logs did not converge";
    return found;
  }
  Eigen::VectorXd x = around.estimate() + found.moves * found.coordinates;
  around.MoveIntoRange(x);
  const Eigen::MatrixXd less =
      found.moves *
      (Eigen::MatrixXd::Identity(coordinates, coordinates) - found.coordinate_covariance) *
      found.moves.transpose();
  Cell moved = around.At(x);
  moved.series = cell.series;
  moved.parallel = cell.parallel;
  moved.run = cell.run;
  moved.uncertainty = around.WithCovariance(x, around.covariance() - less);
  moved.uncertainty->degrees_of_freedom = freedom;
  for (std::size_t k = 0; k < around.names().size(); ++k) {
    const auto error = [k](const Cell::Uncertainty& of) {
      return std::sqrt(std::max(of.covariance[k][k], 0.0));
    };
    const std::string& name = around.names()[k];
    found.parameters.push_back({name,
                                CellParameter(cell, name).value_or(0.0),
                                error(*cell.uncertainty),
                                CellParameter(moved, name).value_or(0.0),
                                error(*moved.uncertainty)});
  }
  found.cell = std::move(moved);
  found.taken = true;
  return found;
}

}  // namespace lipoid
