#pragma once

/// @file
/// The voltage of a cell along a flight, with exact slopes in what a flight is asked.
///
/// The cell is that of cell_model.h; its parameters and the measured current become functions of the
/// unknowns below, and automatic differentiation carries their slopes. The curve v_oc(A) may be off
/// by a smooth function of A, a Gaussian process at kCurveNodes nodes with straight lines between
/// them; its coordinates, and those of the reference's own uncertainty, follow the unknowns, each in
/// units of its standard deviation. Tests: tests/identify/health/flight_model_test.cc.

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "identify/health/reference_cell.h"
#include "identify/logs/record.h"
#include "model/battery/prediction.h"

namespace lipoid {

/// What is unknown of one flight.
struct FlightUnknowns {
  enum : int {
    kStart,     ///< state of charge at the first row
    kCapacity,  ///< logarithm of alpha over the reference's
    kSeries,    ///< of r_s and r_ct
    kBranches,  ///< of every r_j
    kBeta,      ///< of beta
    kTau,       ///< of every tau_j
    kScale,     ///< true current over shown current, less 1
    kOffset_A,  ///< shown current where none flows
    kWarming,   ///< logarithm of the temperature rise over the reference's, by the same heat
    kBefore,    ///< share of the settled drops of the mean current that is there at the first row
    kCount
  };
};

inline constexpr int kCurveNodes = 11;  ///< at A = 0, 0.1, ..., 1

struct FlightPrediction {
  Eigen::VectorXd voltage_V;  ///< at every row
  Eigen::MatrixXd slope;      ///< rows x (FlightUnknowns::kCount + kCurveNodes)
};

struct ResistanceAt {
  double resistance_Ohm = 0.0;
  Eigen::VectorXd slope;  ///< of its logarithm, in the unknowns
};

/// What flowed since the row before, at each row, where that is not as the rows say; and on average.
struct FlownCurrent {
  Column since_A;
  double mean_A = 0.0;
};

class FlightModel {
 public:
  /// The record is that of one cell and outlives the model. Where flowed_A has rows it is what flowed since the row
  /// before, and the current of the record that of the instant (unresolved_current.h).
  FlightModel(const ReferenceCell& reference,
              const Record& record,
              const Surroundings& among,
              const Column& flowed_A = {});

  [[nodiscard]] int size() const { return FlightUnknowns::kCount + kCurveNodes; }
  [[nodiscard]] FlightPrediction Predict(const Eigen::VectorXd& unknowns) const;

  /// The voltage of another cell, say one with other parameters, at these unknowns.
  [[nodiscard]] Eigen::VectorXd VoltageOf(const Cell& cell,
                                          const Eigen::VectorXd& unknowns,
                                          const Eigen::VectorXd* more_A = nullptr) const;

  /// The voltage where more_A flowed besides, on average, since the row before, of a model that was given flowed_A.
  [[nodiscard]] Eigen::VectorXd VoltageWith(const Eigen::VectorXd& unknowns,
                                            const Eigen::VectorXd& more_A) const;

  /// What a step from rest to current_A shows after settle_s, over the current, of which branches that are no slower than
  /// that are a part and slower ones and diffusion are not: at 25 degC where the
  /// temperature of the flight is known, else at the reference temperature, where it is taken to begin.
  [[nodiscard]] ResistanceAt StepResistance(const Eigen::VectorXd& unknowns,
                                            double soc,
                                            double current_A,
                                            double settle_s) const;

  /// How much larger that drop is where current_A has flowed for held_s, as a share of it.
  [[nodiscard]] double GrowthOfDrop(const Eigen::VectorXd& unknowns,
                                    double soc,
                                    double current_A,
                                    double held_s) const;

 private:
  const ReferenceCell& reference_;
  const Record& record_;
  Surroundings among_;
  FlownCurrent flown_;
  Eigen::MatrixXd curve_;  // node voltages of unit coordinates: nodes x coordinates
};

}  // namespace lipoid
