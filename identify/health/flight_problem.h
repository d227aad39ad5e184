#pragma once

/// @file
/// One flight as a least-squares problem at one lag and one noise: the residuals of its windows, whitened, and
/// what was known before. Parameters are the unknowns of flight_model.h in units of their deviation before the
/// flight, from their mean before it, and then the coordinates of the reference's own uncertainty
/// (uncertain_cell.h), each in units of its standard deviation. Tests:
/// tests/identify/health/coverage_test.cc, tests/identify/health/flights_with_lab_test.cc.

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "identify/health/coloured_noise.h"
#include "identify/health/flight_model.h"
#include "identify/health/flight_samples.h"
#include "identify/health/trend.h"
#include "identify/optimizers/least_squares.h"

namespace lipoid {

class UncertainCell;

/// What is known of the sensors before a flight, as standard deviations.
struct SensorSpread {
  double current_scale = 0.06;  ///< true over shown current, less 1: uniform within 10 %
  double offset_share = 0.01;   ///< of the largest current
  double least_offset_A = 0.05;
  double lag_s = 0.5;

  [[nodiscard]] double OffsetOf(double largest_A) const {
    return std::max(least_offset_A, offset_share * largest_A);
  }
};

/// Between these the logarithm of the capacity over that of the reference is searched.
inline constexpr double kLowestLogCapacity = -3.0;
inline constexpr double kHighestLogCapacity = 1.5;

/// And between these the state of charge of the start.
inline constexpr double kLeastStart_soc = -0.05;
inline constexpr double kMostStart_soc = 1.05;
/// The interval of a state of charge, which ends there: no pack is emptier or fuller.
[[nodiscard]] WithInterval WithinPack(WithInterval soc);

/// Degrees of freedom of what a flight says: its errors are weighed by noise that is itself
/// estimated, from few independent slow errors.
inline constexpr double kFlightFreedom = 12.0;

/// What a flight begins with: a rest that is long enough to leave nothing of an earlier current, a shorter
/// one, or a load.
enum class FlightStart { kRested, kIdle, kLoaded };
[[nodiscard]] FlightStart StartOfFlight(const Record& record);

/// Mean voltage of the rest; none where the flight does not begin rested.
[[nodiscard]] std::optional<double> RestVoltage(const Record& record);

/// How the voltage at every row moves with each column of `moves`, which are steps of the vectors of
/// `around` from `at`.
[[nodiscard]] Eigen::MatrixXd ColumnsOf(const UncertainCell& around,
                                        const Eigen::VectorXd& at,
                                        const Eigen::MatrixXd& moves,
                                        const FlightModel& model,
                                        const Eigen::VectorXd& unknowns);

class FlightProblem final : public LeastSquaresProblem {
 public:
  /// Both outlive the problem. The reference columns are those of its caller; there are none at first.
  FlightProblem(const FlightSamples& flight,
                const FlightModel& model,
                const ReferenceSpread& spread,
                const SensorSpread& sensors);

  Eigen::VectorXd mean, deviation, low, high;  ///< of all parameters, before the flight
  Eigen::MatrixXd reference_columns;           ///< at rows
  Eigen::VectorXd reference_at;  ///< coordinates of the reference that the model has; empty: zero
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
  /// An unknown's parameter for a value, no further from its mean than a flight could have told before.
  [[nodiscard]] double Scaled(int unknown, double value) const;
  /// Sets how many coordinates the reference has.
  void SetReferences(Eigen::Index count);

  /// The slopes in the scaled parameters and the predicted voltage: columns [J v] at the rows.
  [[nodiscard]] Eigen::MatrixXd AtRows(const Eigen::VectorXd& scaled) const;
  /// The same in the windows, with the residuals, predicted less measured, in the place of the voltage.
  [[nodiscard]] Eigen::MatrixXd InWindows(const Eigen::MatrixXd& at_rows, double lag) const;
  /// From the columns at the rows the whitened slopes in the scaled parameters and, last, in the lag.
  [[nodiscard]] Eigen::MatrixXd WithLag(const Eigen::MatrixXd& at_rows) const;
  /// The columns in the windows, whitened. Not finite where the parameters are none of a cell.
  [[nodiscard]] Eigen::MatrixXd Whitened(const Eigen::VectorXd& scaled) const;
  /// Of the whitened residuals and of what was known before.
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& scaled, bool jacobian) const override;

 private:
  const FlightSamples& flight_;
  const FlightModel& model_;
};

}  // namespace lipoid
