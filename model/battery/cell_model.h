#pragma once

/// @file
/// The complete lithium-polymer cell: Rakhmatov-Vrudhula diffusion, open-circuit voltage, series
/// resistance and n resistor-capacitor branches, stepped by exact zero-order hold.
///
///   sigma_um' = -beta² m² sigma_um + i,  m = 1 .. M          (4.46)
///   sigma_d'  = i                                            (4.46)
///   sigma     = sigma_d + 2 sum_m sigma_um [+ tail]          (4.47)
///   A         = (alpha - sigma)/alpha                        (4.48), a fraction
///   v_oc      = f(A)                                         (4.49)
///   v_cj'     = (r_j(A) i - v_cj)/tau_j,  tau_j = r_j c_j    (4.50)
///   v_b       = v_oc - r_s(A) i - sum_j v_cj                 (4.51)
///
/// and, where the cell has them, two terms beyond the thesis: self-heating lowers r_s
/// (self_heating.h), charge transfer adds a drop (charge_transfer.h).
///
/// The tail replaces the modes beyond M, which are fast, by their steady value
/// 2 i/beta² sum_{m>M} 1/m²: without it 5.8 % of the steady unavailable charge is lost at M = 10
/// (4.41).
///
/// Discharge is i > 0; A is 1 when full and may leave [0, 1]: nothing is clamped. Amperes, volts,
/// seconds and coulombs of one cell: a pack divides before and multiplies after (see prediction.h).
/// T is double, or an automatic-differentiation scalar to differentiate in the parameters, the
/// state or the current. Advance() and Voltage() do not allocate. Where r_j depends on A, a step
/// takes r_j at the A with which it starts. Symbols: docs/notation.md. Tests:
/// tests/model/battery/cell_model_test.cc.

#include <limits>
#include <optional>
#include <vector>

#include "model/battery/charge_transfer.h"
#include "model/battery/exact_hold.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/battery/ranges.h"
#include "model/battery/resistance.h"
#include "model/battery/self_heating.h"

namespace lipoid {

/// sum_{m > terms} 1/m², the share of pi²/6 that M terms leave out (4.41).
[[nodiscard]] double TailSum(int terms);

template <class T>
struct CellParameters {
  struct Branch {
    Resistance<T> resistance_Ohm;
    T time_constant_s;  ///< > 0, or 0: the branch is gone
  };

  T alpha_C = T(1.0);          ///< charge from A = 1 to A = 0 at vanishing rate, > 0
  T beta_per_sqrt_s = T(0.0);  ///< > 0 where diffusion is on
  bool diffusion = true;       ///< false: beta is infinite, A follows the charge alone
  int terms = kUsualModes;     ///< M >= 0
  bool tail = kUsualTail;
  Resistance<T> series_resistance_Ohm;
  std::vector<Branch> branches;
  OpenCircuitVoltage open_circuit_voltage;
  std::optional<SelfHeating<T>> self_heating;
  std::optional<ChargeTransfer<T>> charge_transfer;
};

template <class T>
class CellModel {
 public:
  struct State {
    T delivered_C = T(0.0);        ///< sigma_d
    std::vector<T> unavailable_C;  ///< sigma_um, m = 1 .. M
    std::vector<T> branch_V;       ///< v_cj
    T thermal_state_A2 = T(0.0);   ///< h
  };

  /// What a step of one length needs; computed once per distinct length.
  struct Step {
    double dt_s = -1.0;
    std::vector<HoldCoefficients<T>> diffusion;
    std::vector<HoldCoefficients<T>>
        branch;  ///< gain is per second of tau: multiply by r_j i/tau_j
    HoldCoefficients<T> thermal_state{T(0.0), T(0.0)};  ///< likewise: multiply by i²/tau_h
  };

  explicit CellModel(CellParameters<T> parameters) : p_(std::move(parameters)) {
    if (!p_.diffusion) {
      p_.terms = 0;
      p_.tail = false;
    }
    const T beta_squared = p_.beta_per_sqrt_s * p_.beta_per_sqrt_s;
    if (p_.tail) tail_s_ = 2.0 * TailSum(p_.terms) / beta_squared;
    for (int m = 1; m <= p_.terms; ++m) rate_per_s_.push_back(double(m) * double(m) * beta_squared);
    for (const auto& branch : p_.branches) {
      branches_depend_on_soc_ = branches_depend_on_soc_ || !branch.resistance_Ohm.constant();
    }
  }

  [[nodiscard]] const CellParameters<T>& parameters() const { return p_; }
  /// What the modes beyond M hold back, per ampere: 0 without the tail.
  [[nodiscard]] const T& tail_s() const { return tail_s_; }

  /// Relaxed at this state of charge: all unavailable charges and branch voltages are zero.
  [[nodiscard]] State Relaxed(const T& soc) const {
    return {p_.alpha_C * (T(1.0) - soc),
            std::vector<T>(rate_per_s_.size(), T(0.0)),
            std::vector<T>(p_.branches.size(), T(0.0)),
            T(0.0)};
  }

  /// Coefficients of a step of dt_s >= 0.
  [[nodiscard]] Step MakeStep(double dt_s) const {
    Step step;
    MakeStep(dt_s, step);
    return step;
  }
  void MakeStep(double dt_s, Step& step) const {
    step.dt_s = dt_s;
    step.diffusion.resize(rate_per_s_.size());
    step.branch.resize(p_.branches.size());
    for (std::size_t m = 0; m < rate_per_s_.size(); ++m) {
      step.diffusion[m] = ExactHold(rate_per_s_[m], dt_s);  // (4.46)
    }
    for (std::size_t j = 0; j < p_.branches.size(); ++j) {
      step.branch[j] = ExactHold(T(1.0) / p_.branches[j].time_constant_s, dt_s);  // (4.50)
    }
    if (p_.self_heating)
      step.thermal_state = ExactHold(T(1.0) / p_.self_heating->time_constant_s, dt_s);
  }

  /// The state after `current_A` has flowed for step.dt_s.
  void Advance(State& state, const T& current_A, const Step& step) const {
    if (!p_.branches.empty()) {
      const T soc = branches_depend_on_soc_ ? Soc(state, current_A) : T(1.0);
      for (std::size_t j = 0; j < p_.branches.size(); ++j) {
        const auto& [decay, gain] = step.branch[j];
        // (1 - decay) without cancellation is gain/tau; it is 1 where the branch has no inertia at
        // all.
        const T share = ScalarPart(p_.branches[j].time_constant_s) > 0.0
                            ? T(gain / p_.branches[j].time_constant_s)
                            : T(1.0);
        state.branch_V[j] =
            decay * state.branch_V[j] +
            (share * (p_.branches[j].resistance_Ohm(soc) * current_A) + kAlive);  // (4.50)
      }
    }
    for (std::size_t m = 0; m < rate_per_s_.size(); ++m) {
      state.unavailable_C[m] = step.diffusion[m].decay * state.unavailable_C[m] +
                               (step.diffusion[m].gain * current_A + kAlive);  // (4.46)
    }
    state.delivered_C = state.delivered_C + step.dt_s * current_A;  // (4.46)
    if (p_.self_heating) {
      state.thermal_state_A2 =
          step.thermal_state.decay * state.thermal_state_A2 +
          (step.thermal_state.gain / p_.self_heating->time_constant_s * (current_A * current_A) +
           kAlive);
    }
  }

  /// sigma_u: the charge that diffusion holds back while current_A flows.
  [[nodiscard]] T UnavailableCharge(const State& state, const T& current_A) const {
    T sum(0.0);
    for (const T& mode : state.unavailable_C) sum = sum + mode;
    T unavailable = 2.0 * sum;  // (4.47)
    if (p_.tail) unavailable = unavailable + tail_s_ * current_A;
    return unavailable;
  }

  /// A, a fraction, while current_A flows.
  [[nodiscard]] T Soc(const State& state, const T& current_A) const {
    const T sigma = state.delivered_C + UnavailableCharge(state, current_A);  // (4.47)
    return (p_.alpha_C - sigma) / p_.alpha_C;                                 // (4.48)
  }

  [[nodiscard]] T OpenCircuit(const State& state, const T& current_A) const {
    return p_.open_circuit_voltage(Soc(state, current_A));  // (4.49)
  }

  /// r_s at this A, as the cell's thermal state leaves it.
  [[nodiscard]] T SeriesResistance(const State& state, const T& soc) const {
    const T cold_Ohm = p_.series_resistance_Ohm(soc);
    return p_.self_heating ? p_.self_heating->Warm(cold_Ohm, state.thermal_state_A2) : cold_Ohm;
  }

  /// Terminal voltage v_b while current_A flows.
  [[nodiscard]] T Voltage(const State& state, const T& current_A) const {
    const T soc = Soc(state, current_A);
    T voltage = p_.open_circuit_voltage(soc) - SeriesResistance(state, soc) * current_A;  // (4.51)
    for (const T& drop : state.branch_V) voltage = voltage - drop;
    if (p_.charge_transfer) voltage = voltage - p_.charge_transfer->Drop(soc, current_A);
    return voltage;
  }

 private:
  CellParameters<T> p_;
  std::vector<T> rate_per_s_;  // beta² m²
  T tail_s_ = T(0.0);
  bool branches_depend_on_soc_ = false;
};

}  // namespace lipoid
