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
/// and, where the cell has them, terms beyond the thesis: self-heating lowers r_s (self_heating.h),
/// charge transfer adds a drop (charge_transfer.h), hysteresis adds a voltage that remembers the
/// direction of the current (hysteresis.h), and all of them may know the temperature of the cell
/// (temperature.h), which is that of the state: measured, or predicted where the surroundings are
/// known. A step takes the temperature with which it starts.
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

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "model/battery/charge_transfer.h"
#include "model/battery/exact_hold.h"
#include "model/battery/hysteresis.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/battery/ranges.h"
#include "model/battery/resistance.h"
#include "model/battery/self_heating.h"
#include "model/battery/temperature.h"

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
  std::optional<TemperatureDependence<T>> temperature;
  std::optional<Hysteresis<T>> hysteresis;
};

template <class T>
class CellModel {
 public:
  struct State {
    T delivered_C = T(0.0);        ///< sigma_d
    std::vector<T> unavailable_C;  ///< sigma_um, m = 1 .. M
    std::vector<T> branch_V;       ///< v_cj
    T thermal_state_A2 = T(0.0);   ///< h
    T hysteresis = T(0.0);         ///< h of hysteresis.h, in [-1, 1]
    /// Of the cell. It stays as it is where the surroundings are not known (NaN) or the cell has no
    /// heat balance.
    T temperature_K = T(kUsual_K);
    T ambient_K = T(std::numeric_limits<double>::quiet_NaN());
  };

  /// What a step of one length needs; computed once per distinct length.
  struct Step {
    double dt_s = -1.0;
    std::vector<HoldCoefficients<T>> diffusion;
    std::vector<HoldCoefficients<T>>
        branch;  ///< gain is per second of tau: multiply by r_j i/tau_j
    HoldCoefficients<T> thermal_state{T(0.0), T(0.0)};  ///< likewise: multiply by i²/tau_h
    /// Where the cell knows temperature: that of the step, and its factor of every r_j.
    T temperature_K = T(0.0);
    std::vector<T> branch_factor;
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
  /// What the modes beyond M hold back, per ampere: 0 without the tail. At the reference
  /// temperature, and at that of a state.
  [[nodiscard]] const T& tail_s() const { return tail_s_; }
  [[nodiscard]] T TailOf(const State& state) const {
    if (!p_.temperature) return tail_s_;
    return tail_s_ * Factor(p_.temperature->diffusion_J_per_mol, state);
  }

  /// Relaxed at this state of charge: all unavailable charges and branch voltages are zero.
  [[nodiscard]] State Relaxed(const T& soc) const {
    State state{.delivered_C = p_.alpha_C * (T(1.0) - soc),
                .unavailable_C = std::vector<T>(rate_per_s_.size(), T(0.0)),
                .branch_V = std::vector<T>(p_.branches.size(), T(0.0))};
    if (p_.hysteresis) state.hysteresis = Hysteresis<T>::Start(soc);
    if (p_.temperature) state.temperature_K = T(p_.temperature->reference_K);
    return state;
  }

  /// Coefficients of a step of dt_s >= 0; of a cell that knows temperature, at its reference.
  [[nodiscard]] Step MakeStep(double dt_s) const {
    Step step;
    MakeStep(dt_s, step);
    return step;
  }
  void MakeStep(double dt_s, Step& step) const {
    if (p_.temperature) return MakeStep(dt_s, T(p_.temperature->reference_K), step);
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
  /// The same of a cell that knows temperature, while it has this one.
  void MakeStep(double dt_s, const T& temperature_K, Step& step) const {
    const TemperatureDependence<T>& term = *p_.temperature;
    step.dt_s = dt_s;
    step.temperature_K = temperature_K;
    step.diffusion.resize(rate_per_s_.size());
    step.branch.resize(p_.branches.size());
    step.branch_factor.resize(p_.branches.size());
    const T slower = term.Factor(term.diffusion_J_per_mol, temperature_K);
    for (std::size_t m = 0; m < rate_per_s_.size(); ++m) {
      step.diffusion[m] = ExactHold(rate_per_s_[m] / slower, dt_s);  // (4.46)
    }
    for (std::size_t j = 0; j < p_.branches.size(); ++j) {
      step.branch_factor[j] = term.Factor(term.branches_J_per_mol[j], temperature_K);
      step.branch[j] = ExactHold(T(1.0) / p_.branches[j].time_constant_s, dt_s);  // (4.50)
    }
  }
  /// Makes `step` one of this length from this state, if it is not.
  void Prepare(Step& step, double dt_s, const State& state) const {
    if (!p_.temperature) {
      if (step.dt_s != dt_s) MakeStep(dt_s, step);
      return;
    }
    // Rates change by up to a tenth per kelvin: by less than a thousandth over this.
    constexpr double kSameTemperature_K = 0.01;
    const double change_K = ScalarPart(state.temperature_K) - ScalarPart(step.temperature_K);
    if (step.dt_s == dt_s && std::abs(change_K) < kSameTemperature_K) return;
    MakeStep(dt_s, state.temperature_K, step);
  }

  /// The state after `current_A` has flowed for step.dt_s, in which the cell hardly warms.
  void Advance(State& state, const T& current_A, const Step& step) const {
    const bool warms = PredictsTemperature(state);
    const T heat_W = warms ? Heat(state, current_A) : T(0.0);
    Move(state, current_A, step);
    if (warms) Warm(state, state.temperature_K, heat_W, current_A, step.dt_s);
  }
  /// The same of a cell that knows temperature, for steps in which it may warm by a kelvin: all of the step is taken at
  /// the temperature half-way. `step` is that of the row before, or of none; `scratch` keeps its memory.
  void AdvanceWarming(
      State& state, const T& current_A, double dt_s, Step& step, State& scratch) const {
    if (!PredictsTemperature(state)) {
      MakeStep(dt_s, state.temperature_K, step);
      return Move(state, current_A, step);
    }
    // The round after it leaves less than a hundredth of this, and brings derivatives, which come a round later than
    // their number.
    constexpr double kNear_K = 1e-6;
    constexpr int kMostRounds = 20;
    scratch = state;
    const T start_K = state.temperature_K;
    Warm(state, start_K, Heat(state, current_A), current_A, dt_s);
    T half_K = 0.5 * (start_K + state.temperature_K);
    double before_K = 0.0;  // half_K of the round before, and what came of it
    double made_K = 0.0;
    double slope = 0.0;
    bool near = false;
    for (int round = 0;; ++round) {
      state = scratch;
      state.temperature_K = half_K;
      MakeStep(dt_s, half_K, step);
      const T heat_W = Heat(state, current_A);
      Move(state, current_A, step);
      Warm(state, start_K, heat_W, current_A, dt_s);
      if (near || round == kMostRounds) return;
      const T makes_K = 0.5 * (start_K + state.temperature_K);
      const double at_K = ScalarPart(half_K);
      near = !(std::abs(ScalarPart(makes_K) - at_K) > kNear_K);
      // A warmer cell makes less heat: the secant, a number even where T has derivatives.
      if (round > 0 && !near)
        slope = std::min((ScalarPart(makes_K) - made_K) / (at_K - before_K), 0.5);
      before_K = at_K;
      made_K = ScalarPart(makes_K);
      half_K = half_K + (makes_K - half_K) / (1.0 - slope);
    }
  }

  /// Heat that the cell releases while current_A flows (temperature.h). What hysteresis takes is
  /// lost as well: over a loop, its area.
  [[nodiscard]] T Heat(const State& state, const T& current_A) const {
    const T soc = (p_.alpha_C - state.delivered_C) / p_.alpha_C;
    const T rest_V = p_.open_circuit_voltage(soc) + EntropicVoltage(state, soc);
    T heat_W = current_A * (rest_V - Voltage(state, current_A));
    const auto* term = p_.temperature ? &p_.temperature->entropy : nullptr;
    if (term != nullptr && *term && (*term)->reversible_heat)
      heat_W = heat_W - current_A * state.temperature_K * (**term)(soc);
    return heat_W;
  }

  /// sigma_u: the charge that diffusion holds back while current_A flows.
  [[nodiscard]] T UnavailableCharge(const State& state, const T& current_A) const {
    T sum(0.0);
    for (const T& mode : state.unavailable_C) sum = sum + mode;
    T unavailable = 2.0 * sum;  // (4.47)
    if (p_.tail) unavailable = unavailable + TailOf(state) * current_A;
    return unavailable;
  }

  /// A, a fraction, while current_A flows.
  [[nodiscard]] T Soc(const State& state, const T& current_A) const {
    const T sigma = state.delivered_C + UnavailableCharge(state, current_A);  // (4.47)
    return (p_.alpha_C - sigma) / p_.alpha_C;                                 // (4.48)
  }

  [[nodiscard]] T OpenCircuit(const State& state, const T& current_A) const {
    return RestCurve(state, Soc(state, current_A));
  }

  /// r_s at this A, as the cell's thermal state and its temperature leave it.
  [[nodiscard]] T SeriesResistance(const State& state, const T& soc) const {
    const T cold_Ohm = p_.series_resistance_Ohm(soc);
    if (p_.temperature) return cold_Ohm * Factor(p_.temperature->series_J_per_mol, state);
    return p_.self_heating ? p_.self_heating->Warm(cold_Ohm, state.thermal_state_A2) : cold_Ohm;
  }

  /// v_ct at this A, of a cell with charge transfer.
  [[nodiscard]] T TransferDrop(const State& state, const T& soc, const T& current_A) const {
    if (!p_.temperature) return p_.charge_transfer->Drop(soc, current_A);
    const T ratio = state.temperature_K * (1.0 / p_.temperature->reference_K);
    return ratio * p_.charge_transfer->Drop(
                       soc, Factor(p_.temperature->charge_transfer_J_per_mol, state) * current_A);
  }
  /// dv_ct/di there.
  [[nodiscard]] double TransferSlope(const State& state,
                                     double soc,
                                     double current_A) const requires std::is_same_v<T, double> {
    if (!p_.temperature) return SlopeOfDrop(*p_.charge_transfer, soc, current_A);
    const double factor = Factor(p_.temperature->charge_transfer_J_per_mol, state);
    return state.temperature_K / p_.temperature->reference_K * factor *
           SlopeOfDrop(*p_.charge_transfer, soc, factor * current_A);
  }

  /// What temperature and hysteresis add to f(A).
  [[nodiscard]] T BesideTheCurve(const State& state, const T& soc) const {
    T added_V = EntropicVoltage(state, soc);
    if (p_.hysteresis) added_V = added_V + p_.hysteresis->Voltage(soc, state.hysteresis);
    return added_V;
  }

  /// Terminal voltage v_b while current_A flows.
  [[nodiscard]] T Voltage(const State& state, const T& current_A) const {
    return Voltage(state, Soc(state, current_A), current_A);
  }
  /// The same where Soc() of this state and current is known already.
  [[nodiscard]] T Voltage(const State& state, const T& soc, const T& current_A) const {
    T voltage = RestCurve(state, soc) - SeriesResistance(state, soc) * current_A;  // (4.51)
    for (const T& drop : state.branch_V) voltage = voltage - drop;
    if (p_.charge_transfer) voltage = voltage - TransferDrop(state, soc, current_A);
    return voltage;
  }

 private:
  // All of a state but its temperature.
  void Move(State& state, const T& current_A, const Step& step) const {
    if (!p_.branches.empty()) {
      const T soc = branches_depend_on_soc_ ? Soc(state, current_A) : T(1.0);
      for (std::size_t j = 0; j < p_.branches.size(); ++j) {
        const auto& [decay, gain] = step.branch[j];
        const T& tau_s = p_.branches[j].time_constant_s;
        T drive_V = p_.branches[j].resistance_Ohm(soc) * current_A;
        if (p_.temperature) drive_V = step.branch_factor[j] * drive_V;
        // (1 - decay) without cancellation is gain/tau; it is 1 where the branch has no inertia at
        // all.
        const T share = ScalarPart(tau_s) > 0.0 ? T(gain / tau_s) : T(1.0);
        state.branch_V[j] = decay * state.branch_V[j] + (share * drive_V + kAlive);  // (4.50)
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
    if (p_.hysteresis) {
      state.hysteresis = p_.hysteresis->After(state.hysteresis, step.dt_s * current_A, p_.alpha_C);
    }
  }
  // From start_K on, by the mean of the heat at both ends, as branches and diffusion take a while to drop theirs.
  void Warm(
      State& state, const T& start_K, const T& heat_W, const T& current_A, double dt_s) const {
    const T mean_W = 0.5 * (heat_W + Heat(state, current_A));
    state.temperature_K = p_.temperature->heat->After(start_K, mean_W, state.ambient_K, dt_s);
  }
  [[nodiscard]] bool PredictsTemperature(const State& state) const {
    return p_.temperature && p_.temperature->heat && !std::isnan(ScalarPart(state.ambient_K));
  }
  [[nodiscard]] T Factor(const T& energy_J_per_mol, const State& state) const {
    return p_.temperature->Factor(energy_J_per_mol, state.temperature_K);
  }
  [[nodiscard]] T EntropicVoltage(const State& state, const T& soc) const {
    if (!p_.temperature || !p_.temperature->entropy) return T(0.0);
    return (state.temperature_K - T(p_.temperature->reference_K)) * (*p_.temperature->entropy)(soc);
  }
  [[nodiscard]] T RestCurve(const State& state, const T& soc) const {
    const T curve_V = p_.open_circuit_voltage(soc);  // (4.49)
    return p_.temperature || p_.hysteresis ? T(curve_V + BesideTheCurve(state, soc)) : curve_V;
  }

  CellParameters<T> p_;
  std::vector<T> rate_per_s_;  // beta² m²
  T tail_s_ = T(0.0);
  bool branches_depend_on_soc_ = false;
};

}  // namespace lipoid
