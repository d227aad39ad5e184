#pragma once

/// @file
/// Flights fitted together with the lab logs of their cell.
///
///   minimize (x - x^)' C^-1 (x - x^)
///            + sum_flights (v - v^(x, y))' S^-1 (v - v^(x, y)) + (y - m)' P^-1 (y - m)
///
/// x are the parameters of the cell, x^ and C what the lab logs say of them: to second order the first term is the
/// cost of the lab logs, so that this is the fit of all logs at once, without reading the lab logs again. y are the
/// unknowns of one flight, of its own: state of charge at the start, scale and offset of the current sensor, lag, how much
/// it warms, and a factor on resistances for a temperature that the lab did not have. S is the covariance of its
/// errors, found as flight_fit.h does. Tests: tests/identify/health/flights_with_lab_test.cc, which solves the
/// problem with the rows of all logs too.

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "identify/health/flight_fit.h"
#include "identify/health/trend.h"
#include "identify/logs/load_campaign.h"
#include "model/core/errors.h"

namespace lipoid {

struct FlightsWithLab {
  struct Flight {
    std::string file;
    WithInterval soc_start;
    WithInterval current_scale;  ///< true over shown
    WithInterval current_offset_A;
    WithInterval lag_s;
    double window_s = 0.0;
    double coherence = 0.0;
    double mean_error_percent = 0.0;  ///< of the rows whose voltage is new
    double max_error_percent = 0.0;
    bool temperature_known = false;
    std::vector<std::string> cautions;
    ColouredNoise noise;  ///< by which it was weighed
  };
  /// A parameter of the cell whose estimate or error the flights change.
  struct Parameter {
    std::string name;
    double by_lab = 0.0;
    double by_lab_error = 0.0;  ///< standard errors
    double estimate = 0.0;
    double error = 0.0;
  };

  bool taken = false;             ///< the cell is that of all logs
  std::string not_taken_because;  ///< a sentence where it is not
  Cell cell;                      ///< that of the lab logs where the flights were not taken
  std::vector<Flight> flights;
  std::vector<Diagnostic> refused;  ///< flights that say nothing
  std::vector<Parameter> parameters;
  /// How far the flights move what the lab logs say, in units of what they may, and how far they may: squared,
  /// and beyond the limit only in one of a thousand flights of the same cell.
  double distance = 0.0;
  double distance_limit = 0.0;
  int directions = 0;  ///< in which the flights say something that the lab logs do not
  bool converged = false;
  /// Of the logs that the lab's cell was fitted to, by that cell and by the one of all logs: the cost. NaN where
  /// nobody asked.
  double lab_mean_error_percent = std::numeric_limits<double>::quiet_NaN();
  double lab_mean_error_with_flights_percent = std::numeric_limits<double>::quiet_NaN();

  /// Principal coordinates of the cell's uncertainty by the lab: F, their values, and their covariance.
  Eigen::MatrixXd moves;
  Eigen::VectorXd coordinates;
  Eigen::MatrixXd coordinate_covariance;
};

/// Flights among the logs, each of one cell. The cell is that of the lab logs with its uncertainty; without one
/// the flights say nothing that would be taken.
[[nodiscard]] FlightsWithLab FitFlightsWithLab(const Cell& cell,
                                               const std::vector<LoadedLog>& logs);

}  // namespace lipoid
