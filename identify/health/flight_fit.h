#pragma once

/// @file
/// The unknowns of one flight, by least squares that knows how its errors are correlated and what
/// was known before.
///
///   minimize (v - v^(x))' S^-1 (v - v^(x)) + (x - m)' P^-1 (x - m)
///
/// v are the voltages of the windows of flight_samples.h, m and P what the reference and its spread
/// say before the flight. S is the covariance of the errors, white and two processes of
/// coloured_noise.h whose deviations and time constants make the voltages most likely, with the
/// unknowns integrated out (the marginal likelihood, to second order). What is to be believed of x is
/// then the inverse of the normal matrix. The lag of the voltage is searched over a grid, because the
/// cost has as many minima in it as the current has edges. Tests:
/// tests/identify/health/coverage_test.cc.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "identify/health/coloured_noise.h"
#include "identify/health/flight_model.h"
#include "identify/health/flight_problem.h"
#include "identify/health/flight_samples.h"

namespace lipoid {

struct FlightFit {
  bool converged = false;
  Eigen::VectorXd unknowns;    ///< those of flight_model.h
  Eigen::MatrixXd covariance;  ///< of them
  /// ln of the capacity of another end of the search, over the reference's, where that end is nearly as likely
  /// and widens the error of the capacity by a quarter or more.
  std::optional<double> nearly_as_likely;
  /// The same of an end that the voltages take for far likelier, and only what was believed of the capacity does not.
  std::optional<double> against_belief;
  /// What flowed between the values of the current more than they show (unresolved_current.h), its variance, and its
  /// covariance with the unknowns.
  double uncounted_C = 0.0;
  double uncounted_variance_C2 = 0.0;
  Eigen::VectorXd uncounted_with;
  double lag_s = 0.0;
  double lag_deviation_s = 0.0;
  ColouredNoise noise;
  FlightStart start = FlightStart::kLoaded;
  Eigen::VectorXd voltage_V;        ///< predicted, at every row
  double mean_error_percent = 0.0;  ///< of the rows whose voltage is new
  double max_error_percent = 0.0;
  double charge_C = 0.0;  ///< from the first row to the last, as shown
  double duration_s = 0.0;
};

/// What flowed is taken to be what flight.unresolved says, where it says any; the model knows the same.
[[nodiscard]] FlightFit FitFlight(const ReferenceCell& reference,
                                  const FlightSamples& flight,
                                  const FlightModel& model,
                                  const SensorSpread& sensors);

struct FittedFlight {
  std::unique_ptr<FlightModel> model;  ///< of flight.record
  FlightFit fit;
};
/// The same, unless the values of the current are means, which change as much as instants do that nobody followed, and
/// each of which is what flowed: so taken they leave less than half of the error. Takes `unresolved` out of the flight
/// in that case.
[[nodiscard]] FittedFlight FitAsFlowed(const ReferenceCell& reference,
                                       FlightSamples& flight,
                                       const Surroundings& among,
                                       const SensorSpread& sensors);

}  // namespace lipoid
