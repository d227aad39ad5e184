#pragma once

/// @file
/// The unknowns of the joint estimator. Given the few that the model is not linear in,
///
///   beta, tau_1 .. tau_n  [, tau_h, i_0]  [, E_d, E_s, E_1 .. E_n, E_ct]  [, gamma] [, i_off] [, alpha]
///
/// the state of charge A(t) of every log is known, and the voltage is linear in all the others:
///
///   v_b = sum_k V_k phi_k(A) - sum_k R_k psi_k(A) i - sum_j sum_k R_jk L_j[psi_k(A) i]
///         [- sum_k C_k psi_k(A) i_0 asinh(i/i_0)] [+ rho h i]                 (4.51)
///         [+ sum_k S_k chi_k(A) (T - T_ref)] [+ sum_k M_k chi_k(A) h]
///
/// with straight-line nodes phi_k, psi_k (psi constant, phi straight beyond the ends), the low pass
/// L_j of branch j (4.50), and the thermal state h, the low pass of i² by tau_h. A constant
/// resistance is a table of one node. Where temperature takes part, its factors multiply the
/// currents above (model/battery/temperature.h); the temperature itself was measured or is that of
/// the surroundings. Hysteresis adds its own h (model/battery/hysteresis.h). Where the current sensor
/// has an offset, i is what it showed less i_off, in every row in which it does not show exactly 0:
/// such a row is an open circuit. Symbols: docs/joint.md.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "identify/joint/held_shape.h"
#include "model/battery/cell.h"
#include "model/battery/ranges.h"

namespace lipoid {

/// Where on the axis of the fit a state of charge of the cell lies, whose alpha is so many times that
/// of the fit. Both axes agree where the logs start.
struct FitAxis {
  double alpha_ratio = 1.0;
  double start_soc = 1.0;
  double operator()(double soc) const { return start_soc - (start_soc - soc) * alpha_ratio; }
};

/// What does not change while rates are searched.
struct JointSetup {
  double alpha_C = 0.0;
  bool diffusion = true;
  int terms = kUsualModes;
  bool tail = kUsualTail;
  /// The curve itself where it is given; else what the nodes of v_oc(A) are counted from.
  OpenCircuitVoltage open_circuit_voltage;
  /// What steps of the current show between two rows: r_s and a part of the rest. NaN: no step.
  double edge_resistance_Ohm = std::numeric_limits<double>::quiet_NaN();
  /// Time constants may go ten times beyond the longest time at one current.
  bool slow_branches = false;
  /// Time constants may go down to half of the time between two rows.
  bool fast_branches = false;
  /// At which the parameters are those of the cell.
  double reference_K = kUsual_K;
  /// What an earlier cell lends: curves and tables are held over A.
  std::shared_ptr<const HeldShape> held = {};
  /// A is counted from the alpha that is searched, as it must where v_oc(A) is given.
  bool axis_follows_alpha = false;
  /// The charge about which alpha is searched; NaN: alpha_C.
  double search_about_C = std::numeric_limits<double>::quiet_NaN();

  /// The charge of which A is a share.
  [[nodiscard]] double AxisCharge(double searched_C) const {
    return axis_follows_alpha && !std::isnan(searched_C) ? searched_C : alpha_C;
  }
};

/// Which quantities have one activation energy in common.
enum class SharedEnergies { kNone, kAllButSeries, kAll };

/// Which terms there are.
struct JointStructure {
  int branches = 1;
  std::vector<double> resistance_soc{0.5};  ///< nodes of every resistance; one: constant
  std::vector<double> voltage_soc = {};     ///< nodes of v_oc; empty: the curve is given
  bool self_heating = false;
  bool charge_transfer = false;
  bool temperature = false;  ///< every resistance and beta by an energy
  SharedEnergies shared_energies = SharedEnergies::kNone;
  std::vector<double> entropy_soc = {};     ///< nodes of dv_oc/dT; empty: none
  std::vector<double> hysteresis_soc = {};  ///< nodes of M; one: constant; empty: no hysteresis
  bool current_offset = false;              ///< of the sensor that all logs share
  bool free_alpha = false;  ///< the charge at which logs that do not start full begin is searched
  /// How many times as smooth as r_s the branches are over the state of charge.
  double branch_smoothness = 1.0;

  [[nodiscard]] int nodes() const { return static_cast<int>(resistance_soc.size()); }
  friend bool operator==(const JointStructure&, const JointStructure&) = default;
};

/// The unknowns that the voltage is not linear in.
struct JointRates {
  double beta_per_sqrt_s = std::numeric_limits<double>::infinity();  ///< infinite: no diffusion
  std::vector<double> time_constant_s;
  double heating_time_constant_s = std::numeric_limits<double>::quiet_NaN();
  double charge_transfer_A = std::numeric_limits<double>::quiet_NaN();
  /// Activation energies, where temperature takes part.
  double diffusion_J_per_mol = std::numeric_limits<double>::quiet_NaN();
  double series_J_per_mol = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> branch_J_per_mol = {};
  double transfer_J_per_mol = std::numeric_limits<double>::quiet_NaN();
  /// Of all that have none of their own above.
  double shared_J_per_mol = std::numeric_limits<double>::quiet_NaN();
  double hysteresis_folds = std::numeric_limits<double>::quiet_NaN();  ///< over JointSetup::alpha_C
  /// What the sensor shows more than flows; NaN: no such term.
  double current_offset_A = std::numeric_limits<double>::quiet_NaN();
  /// Where it is searched: logs that do not start full begin at (1 - initial_soc) of this charge. NaN:
  /// of JointSetup::alpha_C, which is the unit of A unless a shape is held.
  double alpha_C = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] double Diffusion() const { return OwnOrShared(diffusion_J_per_mol); }
  [[nodiscard]] double Series() const { return OwnOrShared(series_J_per_mol); }
  [[nodiscard]] double Branch(std::size_t j) const {
    return branch_J_per_mol.empty() ? shared_J_per_mol : OwnOrShared(branch_J_per_mol[j]);
  }
  [[nodiscard]] double Transfer() const { return OwnOrShared(transfer_J_per_mol); }
  [[nodiscard]] double OwnOrShared(double own_J_per_mol) const {
    return std::isnan(own_J_per_mol) ? shared_J_per_mol : own_J_per_mol;
  }

  /// The current that flowed where the sensor shows this, and its slope in the offset.
  [[nodiscard]] double Flowing(double shown_A) const {
    return shown_A == 0.0 || std::isnan(current_offset_A) ? shown_A : shown_A - current_offset_A;
  }
  [[nodiscard]] double FlowingSlope(double shown_A) const { return shown_A == 0.0 ? 0.0 : -1.0; }
};

/// The factors of one temperature, with the slopes of their logarithms in the energies, which are
/// the same for all: f = exp(E inverse), 1/T - 1/T_ref over the gas constant.
struct AtTemperature {
  double inverse_mol_per_J = 0.0;
  double ratio = 1.0;    ///< T/T_ref
  double above_K = 0.0;  ///< T - T_ref

  AtTemperature() = default;
  AtTemperature(double temperature_K, double reference_K)
      : inverse_mol_per_J((1.0 / temperature_K - 1.0 / reference_K) / kGasConstant_J_per_mol_K),
        ratio(temperature_K / reference_K),
        above_K(temperature_K - reference_K) {}
  [[nodiscard]] double Factor(double energy_J_per_mol) const {
    return std::exp(energy_J_per_mol * inverse_mol_per_J);
  }
};

/// Where the slope in each nonlinear parameter stands: beta, tau_1 .. tau_n, tau_h, i_0, E_d, E_s,
/// E_1 .. E_n, E_ct, gamma, i_off, alpha. There is always a beta; without diffusion its slope is
/// zero, as is that of E_d. Energies that are one have one slot: the first.
class RateSlots {
 public:
  explicit RateSlots(const JointStructure& structure)
      : branches_(structure.branches),
        heating_(structure.self_heating ? 1 : 0),
        transfer_(structure.charge_transfer ? 1 : 0),
        shared_(structure.shared_energies),
        energies_(!structure.temperature                     ? 0
                  : shared_ == SharedEnergies::kNone         ? 2 + structure.branches + transfer_
                  : shared_ == SharedEnergies::kAllButSeries ? 2
                                                             : 1),
        hysteresis_(structure.hysteresis_soc.empty() ? 0 : 1),
        offset_(structure.current_offset ? 1 : 0),
        alpha_(structure.free_alpha ? 1 : 0) {}

  [[nodiscard]] int beta() const { return 0; }
  [[nodiscard]] int tau(int j) const { return 1 + j; }
  [[nodiscard]] int heating() const { return 1 + branches_; }
  [[nodiscard]] int transfer() const { return 1 + branches_ + heating_; }
  [[nodiscard]] int diffusion_energy() const { return transfer() + transfer_; }
  [[nodiscard]] int series_energy() const {
    return diffusion_energy() + (shared_ == SharedEnergies::kAll ? 0 : 1);
  }
  [[nodiscard]] int branch_energy(int j) const {
    return shared_ == SharedEnergies::kNone ? series_energy() + 1 + j : diffusion_energy();
  }
  [[nodiscard]] int transfer_energy() const { return branch_energy(branches_); }
  [[nodiscard]] int hysteresis() const { return diffusion_energy() + energies_; }
  [[nodiscard]] int offset() const { return hysteresis() + hysteresis_; }
  [[nodiscard]] int alpha() const { return offset() + offset_; }
  [[nodiscard]] int size() const { return alpha() + alpha_; }

 private:
  int branches_, heating_, transfer_;
  SharedEnergies shared_;
  int energies_, hysteresis_, offset_, alpha_;
};

/// Where each linear unknown stands. All are in volts: node voltages as they are, resistances
/// times the typical current, rho times its cube, dv_oc/dT times kEntropyScale_K, M as it is.
inline constexpr double kEntropyScale_K = 10.0;
class JointLayout {
 public:
  explicit JointLayout(const JointStructure& structure)
      : voltages_(static_cast<int>(structure.voltage_soc.size())),
        nodes_(structure.nodes()),
        branches_(structure.branches),
        transfer_(structure.charge_transfer),
        heating_(structure.self_heating),
        entropies_(static_cast<int>(structure.entropy_soc.size())),
        hystereses_(static_cast<int>(structure.hysteresis_soc.size())) {}

  [[nodiscard]] int voltages() const { return voltages_; }
  [[nodiscard]] int nodes() const { return nodes_; }
  [[nodiscard]] int series() const { return voltages_; }
  [[nodiscard]] int branch(int j) const { return voltages_ + (1 + j) * nodes_; }
  [[nodiscard]] int transfer() const { return branch(branches_); }
  [[nodiscard]] int heating() const { return branch(branches_ + (transfer_ ? 1 : 0)); }
  [[nodiscard]] int entropy() const { return heating() + (heating_ ? 1 : 0); }
  [[nodiscard]] int entropies() const { return entropies_; }
  [[nodiscard]] int hysteresis() const { return entropy() + entropies_; }
  [[nodiscard]] int hystereses() const { return hystereses_; }
  [[nodiscard]] int size() const { return hysteresis() + hystereses_; }
  /// Tables of resistances: r_s, r_1 .. r_n and, where it is there, that of the charge transfer.
  [[nodiscard]] int tables() const { return 1 + branches_ + (transfer_ ? 1 : 0); }
  [[nodiscard]] int table(int t) const { return voltages_ + t * nodes_; }

 private:
  int voltages_, nodes_, branches_;
  bool transfer_, heating_;
  int entropies_, hystereses_;
};

/// From columns of node voltages to columns of their rises, x_node[k] = sum_{j <= k} rise[j]: each
/// takes in those of all nodes above it.
template <class Matrix>
void ToRises(Matrix&& columns, int voltages) {
  for (int k = voltages - 2; k >= 0; --k) columns.col(k) += columns.col(k + 1);
}

/// The two nodes between which a state of charge lies, and the share of the upper one. Beyond the
/// ends the share leaves [0, 1].
struct NodeShare {
  int lower = 0;
  double share = 0.0;
};

/// Finds nodes quickly when states of charge come in order, as in a log.
class NodeFinder {
 public:
  explicit NodeFinder(const std::vector<double>& soc) : soc_(soc) {}

  NodeShare operator()(double soc) {
    const int last = static_cast<int>(soc_.size()) - 2;
    if (last < 0) return {};
    while (k_ < last && soc >= soc_[k_ + 1]) ++k_;
    while (k_ > 0 && soc < soc_[k_]) --k_;
    return {k_, (soc - soc_[k_]) / (soc_[k_ + 1] - soc_[k_])};
  }

 private:
  const std::vector<double>& soc_;
  int k_ = 0;
};

}  // namespace lipoid
