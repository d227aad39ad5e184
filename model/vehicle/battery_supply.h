#pragma once

/// @file
/// What supplies the motors in flight: the identified cell, or an ideal source whose voltage is
/// imposed. Tests: tests/model/vehicle/battery_supply_test.cc.

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/battery/cell.h"
#include "model/vehicle/powertrain.h"

namespace lipoid {

/// A cell, or a pack of equal ones, as a voltage behind a resistance, moved by exact steps.
///
/// The tail of the diffusion sum makes A depend on the current at once. Over one step v_oc(A) is
/// its straight line at the A of the last current: exact on one segment of a linear table. So is
/// the drop of charge transfer its tangent at the last current; the slope of a drop falls as the
/// current grows, so that the voltage of another current lies above the tangent's, to second order
/// in their difference. Does not allocate after construction.
class BatterySupply {
 public:
  /// Relaxed at this state of charge, and as warm as its surroundings: without ambient_degC, as the
  /// reference of the cell.
  BatterySupply(const Cell& cell, double initial_soc, std::optional<double> ambient_degC = {})
      : model_(cell.Parameters()),
        state_(model_.Relaxed(initial_soc)),
        step_(model_.MakeStep(0.0)),
        series_(cell.series),
        parallel_(cell.parallel),
        cutoff_V_(cell.cutoff_V) {
    if (ambient_degC) state_.temperature_K = *ambient_degC + kZeroCelsius_K;
    state_.ambient_K = state_.temperature_K;
  }

  /// Voltage and resistance of the whole pack while a current near the last one flows.
  [[nodiscard]] Supply<double> Linearize() const {
    const auto& p = model_.parameters();
    const double relaxed_soc = model_.Soc(state_, 0.0);  // without the tail's share
    const double soc = model_.Soc(state_, last_A_);
    const auto curve = p.open_circuit_voltage.Evaluate(soc);
    // A curve that falls with A would give the tail a negative resistance: it is taken as flat.
    const double slope_V = std::max(curve.slope_V, 0.0);
    double voltage_V = curve.value_V + slope_V * (relaxed_soc - soc);
    if (p.temperature || p.hysteresis) voltage_V += model_.BesideTheCurve(state_, soc);
    for (const double drop : state_.branch_V) voltage_V -= drop;
    double resistance_Ohm =
        model_.SeriesResistance(state_, soc) + slope_V * model_.TailOf(state_) / p.alpha_C;
    if (p.charge_transfer) {
      const double slope_Ohm = model_.TransferSlope(state_, soc, last_A_);
      voltage_V -= model_.TransferDrop(state_, soc, last_A_) - slope_Ohm * last_A_;
      resistance_Ohm += slope_Ohm;
    }
    return {series_ * voltage_V, series_ * resistance_Ohm / parallel_};
  }

  /// `charge_C` of the pack has left during dt_s > 0; its mean current is what the cell sees.
  void Advance(double charge_C, double dt_s) {
    model_.Prepare(step_, dt_s, state_);
    last_A_ = charge_C / (dt_s * parallel_);
    model_.Advance(state_, last_A_, step_);
  }

  [[nodiscard]] double temperature_degC() const { return state_.temperature_K - kZeroCelsius_K; }
  /// A, a fraction, under the last current.
  [[nodiscard]] double soc() const { return model_.Soc(state_, last_A_); }
  /// A once the cell has rested, which is the share of its charge that is left.
  [[nodiscard]] double rest_soc() const {
    const double alpha_C = model_.parameters().alpha_C;
    return (alpha_C - state_.delivered_C) / alpha_C;
  }
  /// Of the pack once it has rested, at the temperature that it has now.
  [[nodiscard]] double rest_voltage_V() const {
    auto rested = state_;
    std::fill(rested.unavailable_C.begin(), rested.unavailable_C.end(), 0.0);
    return series_ * model_.OpenCircuit(rested, 0.0);
  }
  /// Goes on from another state of a cell, in which this current of one cell was the last.
  void Continue(CellModel<double>::State state, double cell_A) {
    const double ambient_K = state_.ambient_K;
    state_ = std::move(state);
    state_.ambient_K = ambient_K;
    last_A_ = cell_A;
  }
  /// Charge of the pack from A = 1 to A = 0 at vanishing rate.
  [[nodiscard]] double capacity_C() const { return parallel_ * model_.parameters().alpha_C; }
  [[nodiscard]] double cutoff_V() const { return series_ * cutoff_V_; }
  [[nodiscard]] double parallel() const { return parallel_; }

  /// Whether the drop is no straight line in the current, or read from a table: then a current that
  /// jumps wants Expect().
  [[nodiscard]] bool bends() const {
    const auto& p = model_.parameters();
    return p.charge_transfer.has_value() || !p.series_resistance_Ohm.constant();
  }

  /// How far A moves at once when the current changes from the last one to this.
  [[nodiscard]] double SocMovedBy(double pack_current_A) const {
    return std::abs(model_.Soc(state_, pack_current_A / parallel_) - soc());
  }

  /// The current at which v_oc(A) and charge transfer are taken as straight lines until the next
  /// Advance().
  void Expect(double pack_current_A) { last_A_ = pack_current_A / parallel_; }

 private:
  CellModel<double> model_;
  CellModel<double>::State state_;
  CellModel<double>::Step step_;
  double series_;
  double parallel_;
  double cutoff_V_;
  double last_A_ = 0.0;
};

}  // namespace lipoid
