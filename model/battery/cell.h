#pragma once

/// @file
/// An identified cell as data: what a cell file holds and what simulations start from.
///
/// The numbers are those of one cell; series and parallel say how many make the pack that is used.
/// Tests: tests/model/battery/cell_file_test.cc.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/battery/cell_model.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/battery/ranges.h"
#include "model/battery/resistance.h"
#include "model/battery/temperature_range.h"
#include "model/core/json.h"

namespace lipoid {

struct Cell {
  struct Diffusion {
    double alpha_C = 0.0;          ///< charge from A = 1 to A = 0 at vanishing rate, > 0
    double beta_per_sqrt_s = 0.0;  ///< in [kLeastBeta_per_sqrt_s, 1]
    int terms = kUsualModes;       ///< M in (4.46), 0 .. 1000
    bool tail = kUsualTail;        ///< quasi-static share of the modes beyond M

    /// The time constant of the first mode beyond M, the slowest of the tail (4.46).
    [[nodiscard]] double FirstOfTail_s() const {
      const double root_rate = beta_per_sqrt_s * (terms + 1);
      return 1.0 / (root_rate * root_rate);
    }
  };
  struct Branch {
    Resistance<double> resistance_Ohm;
    double time_constant_s = 0.0;  ///< tau = r c
    /// Set where the branch is written by its capacitance (only with a constant resistance).
    std::optional<double> capacitance_F;
  };
  using SelfHeating = lipoid::SelfHeating<double>;
  using ChargeTransfer = lipoid::ChargeTransfer<double>;
  using Temperature = TemperatureDependence<double>;
  using Hysteresis = lipoid::Hysteresis<double>;
  /// How far the estimates may be off: what cells are drawn from (cell_ensemble.h). The estimates
  /// less the truth have Student's distribution with this scale matrix, which is the covariance of
  /// the estimates, and these degrees of freedom.
  struct Uncertainty {
    std::vector<std::string> parameters;          ///< names of cell_parameters.h
    std::vector<std::vector<double>> covariance;  ///< rows, in SI units
    double degrees_of_freedom = 0.0;              ///< at least 1; large: normal
    /// The curves over the state of charge were measured over charge: where alpha is another, their
    /// nodes keep their charge (1 - A) alpha.
    bool soc_follows_alpha = false;
  };

  std::string name;
  int series = 1;
  int parallel = 1;
  double capacity_Ah = 0.0;  ///< nominal; the charge of A = 1 -> 0 where there is no diffusion
  double cutoff_V = 0.0;     ///< end of discharge of one cell
  std::optional<Diffusion> diffusion;  ///< none: beta is infinite, A follows the charge alone
  OpenCircuitVoltage open_circuit_voltage;
  bool open_circuit_voltage_assumed = false;  ///< a typical curve, not a measured one
  Resistance<double> series_resistance_Ohm;
  std::vector<Branch> branches;
  std::optional<SelfHeating> self_heating;        ///< none: r_s does not know the current's past
  std::optional<ChargeTransfer> charge_transfer;  ///< none: every drop is proportional
  std::optional<Temperature> temperature;         ///< none: it is the same at every temperature
  bool temperature_assumed = false;               ///< typical energies and heat, not measured ones
  bool heat_assumed = false;  ///< a typical heat balance beside energies that were measured
  std::optional<TemperatureRange> temperature_seen;  ///< none: the file does not say
  /// Of the logs of a cell that knows no temperature; none: not known, or `temperature` says it.
  std::optional<double> reference_degC;
  std::optional<Hysteresis> hysteresis;    ///< none: v_oc does not know the current's past
  std::optional<Uncertainty> uncertainty;  ///< none: nothing is known of it
  /// How it was made, an object (see RunRecord); copies of the cell share it. None: it is not known.
  std::shared_ptr<const Json> run;

  /// Charge from A = 1 to A = 0 at vanishing rate.
  [[nodiscard]] double alpha_C() const {
    return diffusion ? diffusion->alpha_C : 3600.0 * capacity_Ah;
  }
  [[nodiscard]] CellParameters<double> Parameters() const;
  /// One cell of the pack.
  [[nodiscard]] Cell AsOne() const;
};

}  // namespace lipoid
