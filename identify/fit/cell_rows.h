#pragma once

/// @file
/// The cell along a log as the fits see it: the state of charge, and at every point the voltage as
/// a row that is linear in v_oc and the resistances, with exact slopes in beta, tau_j, tau_h, i_0,
/// the activation energies, gamma of the hysteresis and the offset of the current sensor.
///
/// This is the one other statement of (4.46)-(4.51) beside cell_model.h, which simulations step;
/// the two are held against each other row by row. A step costs a row two nodes of every table and
/// the few nodes of a branch whose share has not decayed. Nothing here knows how logs are
/// condensed: joint_sweep.cc walks points, voltage_sweep.cc blocks whose sums are exact. Symbols:
/// docs/joint.md, 1. Tests: tests/identify/joint/joint_sweep_test.cc,
/// tests/identify/stages/voltage_sweep_test.cc.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "identify/fit/mode_step.h"
#include "identify/joint/joint_model.h"
#include "model/battery/cell_model.h"

namespace lipoid {

/// How the slope of v_oc between nodes is taken, where it says what beta does to a voltage.
enum class CurveSlope {
  kOfSegments,  ///< of the straight lines themselves: the derivative of the model
  kSmooth,      ///< of a smooth curve through the nodes: what the straight lines stand for
};

/// How A moves with the unknowns that it depends on.
struct SocSlopes {
  double beta = 0.0;
  double energy = 0.0;  ///< E_d
  double offset = 0.0;  ///< of the current sensor
  double alpha = 0.0;   ///< from which a log that does not start full is counted
};

/// From the start of a stretch of one current to several times within it, all at once, at the reference
/// temperature.
struct SocSpan {
  ModeSteps steps;
  Eigen::VectorXd charge_s;        ///< what delivered charge and diffusion hold back of 1 A by then
  Eigen::VectorXd charge_slope_s;  ///< its slope in beta
};

/// The charge that has left a cell and what diffusion holds back, with slopes in beta, in E_d and in
/// the offset of the sensor.
class SocState {
 public:
  /// At the reference temperature.
  SocState(const JointSetup& setup,
           double alpha_C,
           double beta_per_sqrt_s,
           double delivered_C,
           bool slopes)
      : alpha_C_(alpha_C),
        diffusion_(setup.diffusion && !std::isinf(beta_per_sqrt_s)),
        slopes_(slopes && diffusion_),
        beta_per_sqrt_s_(beta_per_sqrt_s),
        delivered_C_(delivered_C),
        unavailable_C_(Eigen::ArrayXd::Zero(diffusion_ ? setup.terms : 0)),
        slope_C_(unavailable_C_) {
    if (diffusion_ && setup.tail)
      tail_s_ = 2.0 * TailSum(setup.terms) / (beta_per_sqrt_s * beta_per_sqrt_s);
  }

  /// Steps of these lengths, for Step().
  template <class Lengths>
  void SetSteps(const Lengths& lengths_s, ModeSteps& steps) const {
    steps.Resize(unavailable_C_.size(), static_cast<Eigen::Index>(lengths_s.size()));
    for (std::size_t c = 0; c < lengths_s.size(); ++c)
      steps.SetDiffusion(static_cast<Eigen::Index>(c), beta_per_sqrt_s_, lengths_s[c], slopes_);
  }
  /// The same, each step at a temperature of its own; slopes are those in beta at that temperature.
  void SetStepsAt(const std::vector<double>& lengths_s,
                  const std::vector<AtTemperature>& at,
                  double energy_J_per_mol,
                  ModeSteps& steps) const {
    steps.Resize(unavailable_C_.size(), static_cast<Eigen::Index>(lengths_s.size()));
    for (std::size_t c = 0; c < lengths_s.size(); ++c) {
      const double beta = beta_per_sqrt_s_ / std::sqrt(at[c].Factor(energy_J_per_mol));
      steps.SetDiffusion(static_cast<Eigen::Index>(c), beta, lengths_s[c], slopes_);
    }
  }
  /// The same from the start of a stretch to these times, for Reach().
  template <class Times>
  void SetSpan(const Times& times_s, SocSpan& span) const {
    SetSteps(times_s, span.steps);
    span.charge_s = 2.0 * span.steps.gain.colwise().sum();
    span.charge_slope_s = 2.0 * span.steps.gain_slope.colwise().sum();
    for (std::size_t c = 0; c < times_s.size(); ++c)
      span.charge_s[static_cast<Eigen::Index>(c)] += times_s[c] + tail_s_;
    if (slopes_) span.charge_slope_s.array() -= 2.0 * tail_s_ / beta_per_sqrt_s_;
  }
  /// A at those times and, where slopes are asked for, its slopes in beta, while current_A flows: what
  /// Step() to each of them leads to.
  void Reach(const SocSpan& span,
             double current_A,
             Eigen::VectorXd& soc,
             Eigen::VectorXd& slope) const {
    const double per_C = -1.0 / alpha_C_;
    soc.noalias() = span.steps.decay.matrix().transpose() * unavailable_C_.matrix();  // (4.46)
    soc = 2.0 * soc + current_A * span.charge_s;                                      // (4.47)
    soc = (1.0 + per_C * (delivered_C_ + soc.array())).matrix();                      // (4.48)
    if (!slopes_) return;
    slope.noalias() = span.steps.decay.matrix().transpose() * slope_C_.matrix();
    slope.noalias() += span.steps.decay_slope.matrix().transpose() * unavailable_C_.matrix();
    slope = per_C * (2.0 * slope + current_A * span.charge_slope_s);
  }
  /// From here on the cell has this temperature; E_d is its energy.
  void SetTemperature(const AtTemperature& at, double energy_J_per_mol) {
    const double factor = at.Factor(energy_J_per_mol);
    tail_factor_ = factor;
    // beta(T) = beta f^-1/2.
    by_beta_ = 1.0 / std::sqrt(factor);
    by_energy_ = -0.5 * beta_per_sqrt_s_ * by_beta_ * at.inverse_mol_per_J;
    with_energy_ = true;
    tail_by_energy_ = tail_s_ * factor * at.inverse_mol_per_J;
  }
  /// From here on Step() counts the slope in an offset of the sensor, whose slope in the current it
  /// is told.
  void CountOffset() {
    with_offset_ = true;
    offset_slope_C_ = Eigen::ArrayXd::Zero(unavailable_C_.size());
  }
  /// current_A flows for dt_s, whose coefficients are column `at` of the steps.
  void Step(const ModeSteps& steps,
            Eigen::Index at,
            double current_A,
            double dt_s,
            double current_by_offset = 0.0) {
    if (with_offset_) {
      offset_slope_C_ =
          steps.decay.col(at) * offset_slope_C_ + (steps.gain.col(at) * current_by_offset + kAlive);
      delivered_by_offset_s_ += dt_s * current_by_offset;
    }
    if (slopes_ && with_energy_) {
      if (energy_slope_C_.size() == 0) energy_slope_C_ = Eigen::ArrayXd::Zero(slope_C_.size());
      const Eigen::ArrayXd moved =
          steps.decay_slope.col(at) * unavailable_C_ + steps.gain_slope.col(at) * current_A;
      slope_C_ = steps.decay.col(at) * slope_C_ + (by_beta_ * moved + kAlive);
      energy_slope_C_ = steps.decay.col(at) * energy_slope_C_ + (by_energy_ * moved + kAlive);
    } else if (slopes_) {
      slope_C_ = steps.decay.col(at) * slope_C_ + steps.decay_slope.col(at) * unavailable_C_ +
                 (steps.gain_slope.col(at) * current_A + kAlive);
    }
    unavailable_C_ =
        steps.decay.col(at) * unavailable_C_ + (steps.gain.col(at) * current_A + kAlive);  // (4.46)
    delivered_C_ += dt_s * current_A;                                                      // (4.46)
  }
  /// A while current_A flows, and its slope in beta.
  [[nodiscard]] double Soc(double current_A) const {
    const double sigma_C =
        delivered_C_ + 2.0 * unavailable_C_.sum() + tail_factor_ * tail_s_ * current_A;  // (4.47)
    return 1.0 - sigma_C / alpha_C_;                                                     // (4.48)
  }
  [[nodiscard]] double Slope(double current_A) const {
    if (!slopes_) return 0.0;
    const double tail_slope = -2.0 * tail_factor_ * tail_s_ / beta_per_sqrt_s_;
    return -(2.0 * slope_C_.sum() + tail_slope * current_A) / alpha_C_;
  }
  /// The same in E_d; 0 where no temperature was set.
  [[nodiscard]] double EnergySlope(double current_A) const {
    if (!slopes_ || !with_energy_) return 0.0;
    return -(2.0 * energy_slope_C_.sum() + tail_by_energy_ * current_A) / alpha_C_;
  }
  /// The same in the offset of the sensor, in 1/A.
  [[nodiscard]] double OffsetSlope(double current_by_offset) const {
    if (!with_offset_) return 0.0;
    return -(delivered_by_offset_s_ + 2.0 * offset_slope_C_.sum() +
             tail_factor_ * tail_s_ * current_by_offset) /
           alpha_C_;
  }
  [[nodiscard]] bool slopes() const { return slopes_; }

 private:
  double alpha_C_;
  bool diffusion_;
  bool slopes_;
  double beta_per_sqrt_s_;
  double tail_s_ = 0.0;
  double tail_factor_ = 1.0;
  double delivered_C_;
  Eigen::ArrayXd unavailable_C_;
  Eigen::ArrayXd slope_C_;
  bool with_energy_ = false;
  double by_beta_ = 1.0, by_energy_ = 0.0, tail_by_energy_ = 0.0;
  Eigen::ArrayXd energy_slope_C_;
  bool with_offset_ = false;
  double delivered_by_offset_s_ = 0.0;
  Eigen::ArrayXd offset_slope_C_;
};

/// One point of a log: y = sum_e value[e] x[index[e]], with rising indices; y is the measured
/// voltage above the reference curve. Where slopes are asked for, slope[p] is that of the predicted
/// voltage in nonlinear parameter p (RateSlots). It holds until the next point.
struct CellRow {
  int entries;
  const int* index;
  const double* value;
  double y;
  const double* slope;

  /// Measured less predicted voltage.
  [[nodiscard]] double Residual(const double* x) const {
    double residual_V = y;
    for (int e = 0; e < entries; ++e) residual_V -= value[e] * x[index[e]];
    return residual_V;
  }
};

/// Makes the rows of one log, point by point. Structure, setup and x must outlive it.
class CellRows {
  // The low pass of one branch, of the current shared out to the nodes of its resistance.
  struct BranchState {
    std::vector<double> share;  // of each node
    int first = 0, last = -1;   // nodes whose share is not zero
    double slope_tau = 0.0;     // of the voltage, in tau_j
    SocSlopes slope;            // and in what moves the state of charge that r_j is taken at
    double slope_energy = 0.0;  // in E_j

    void Reset(int nodes) {
      share.assign(static_cast<std::size_t>(nodes), 0.0);
      first = 0;
      last = -1;
      slope_tau = slope_energy = 0.0;
      slope = {};
    }
    [[nodiscard]] double Voltage(const double* x) const {
      double sum = 0.0;
      for (int m = first; m <= last; ++m) sum += share[m] * x[m];
      return sum;
    }
    // Of a constant resistance: one node, which is always there.
    void Follow(double decay, double drive) {
      share[0] = decay * share[0] + (drive + kAlive);
      last = 0;
    }
    // Of a table.
    void Decay(double decay) {
      // Shares that are smaller than this, in volts per volt, are zero.
      constexpr double kGone = 1e-13;
      for (int m = first; m <= last; ++m) share[m] *= decay;
      while (first <= last && std::abs(share[first]) < kGone) share[first++] = 0.0;
      while (first <= last && std::abs(share[last]) < kGone) share[last--] = 0.0;
    }
    void Drive(const NodeShare& where, double drive) {
      const int upper = where.lower + 1;
      if (first > last) {
        first = where.lower;
        last = upper;
      } else {
        first = std::min(first, where.lower);
        last = std::max(last, upper);
      }
      share[where.lower] += (1.0 - where.share) * drive;
      share[upper] += where.share * drive;
    }
  };

  // A table of resistances at a point, in the unknowns x of its nodes.
  struct TableAt {
    double value, slope;  // slope in the state of charge; 0 beyond the ends
  };
  static TableAt ValueAt(const double* x, const NodeShare& at, const std::vector<double>& nodes) {
    if (nodes.size() == 1) return {x[0], 0.0};
    const double low = x[at.lower];
    const double high = x[at.lower + 1];
    const bool within = at.share > 0.0 && at.share < 1.0;
    return {(1.0 - at.share) * low + at.share * high,
            within ? (high - low) / (nodes[at.lower + 1] - nodes[at.lower]) : 0.0};
  }

 public:
  /// A step, or a point: the current that flows, its slope in the offset of the sensor, the length of
  /// the step, and the state of charge (at the start of the step, under its current) with its slopes.
  struct At {
    double current_A = 0.0;
    double dt_s = 0.0;  ///< only hysteresis asks
    double soc = 0.0;
    SocSlopes slopes = {};
    double current_by_offset = 0.0;
    /// At a point of a cell whose curve is given, that curve at `soc`.
    OpenCircuitVoltage::ValueAndSlope v_oc = {};
  };

  /// Whether rows may be made as `plain` ones, at half the cost: the curve is given, resistances are
  /// constant, and there is no term beside branches and diffusion.
  [[nodiscard]] static bool Plain(const JointStructure& s) {
    return s.voltage_soc.empty() && s.nodes() == 1 && !s.self_heating && !s.charge_transfer &&
           !s.temperature && s.entropy_soc.empty() && s.hysteresis_soc.empty() &&
           !s.current_offset && !s.free_alpha;
  }

  /// Linear unknowns count in volts at the typical current (JointLayout). Slopes are those at the
  /// unknowns x; none where it is null.
  CellRows(const JointSetup& setup,
           const JointStructure& structure,
           const JointRates& rates,
           double typical_A,
           const double* x,
           CurveSlope curve)
      : setup_(setup),
        structure_(structure),
        layout_(structure),
        slots_(structure),
        rates_(rates),
        x_(x),
        per_A_(1.0 / typical_A),
        of_voltage_(structure.voltage_soc),
        of_resistance_(structure.resistance_soc),
        of_entropy_(structure.entropy_soc),
        of_hysteresis_(structure.hysteresis_soc),
        of_start_(structure.resistance_soc),
        branches_(static_cast<std::size_t>(structure.branches)),
        index_(static_cast<std::size_t>(layout_.size())),
        value_(static_cast<std::size_t>(layout_.size())),
        slope_(static_cast<std::size_t>(slots_.size())),
        branch_factor_(static_cast<std::size_t>(structure.branches), 1.0) {
    for (const double a : structure.voltage_soc)
      reference_V_.push_back(setup.open_circuit_voltage(a));
    for (auto& b : branches_) b.Reset(layout_.nodes());
    if (x != nullptr) FindCurveSlopes(curve);
    axis_C_ = setup.AxisCharge(rates.alpha_C);
    folds_per_C_ = rates.hysteresis_folds / axis_C_;
  }

  /// The log begins relaxed after so much charge: hysteresis starts as CellModel::Relaxed() says.
  void Start(double delivered_C) {
    hysteresis_ = Hysteresis<double>::Start(1.0 - delivered_C / setup_.alpha_C);
  }

  /// Steps of these lengths, for Step().
  template <class Lengths>
  void SetSteps(const Lengths& lengths_s, ModeSteps& steps) const {
    const auto n = static_cast<Eigen::Index>(structure_.branches);
    steps.Set(n + (structure_.self_heating ? 1 : 0), lengths_s, [&](Eigen::Index m, double dt_s) {
      return LowPassStep(m < n ? rates_.time_constant_s[static_cast<std::size_t>(m)]
                               : rates_.heating_time_constant_s,
                         dt_s);
    });
  }

  /// From here on the cell has this temperature. Until it is told, the reference.
  void SetTemperature(const AtTemperature& at) {
    at_ = at;
    series_factor_ = at.Factor(rates_.Series());
    for (std::size_t j = 0; j < branch_factor_.size(); ++j)
      branch_factor_[j] = at.Factor(rates_.Branch(j));
    if (structure_.charge_transfer) transfer_factor_ = at.Factor(rates_.Transfer());
  }

  /// A step of column `at` of the steps.
  template <bool plain = false>
  void Step(const ModeSteps& steps, Eigen::Index at, const At& step) {
    const double current_A = step.current_A;
    const auto decay = steps.decay.col(at);
    const auto gain = steps.gain.col(at);
    const auto decay_slope = steps.decay_slope.col(at);
    const auto gain_slope = steps.gain_slope.col(at);
    const double undisturbed = current_A * per_A_;
    const bool tables = !plain && layout_.nodes() > 1;
    NodeShare where;
    if (tables) {
      where = of_start_(step.soc);
      where.share = std::clamp(where.share, 0.0, 1.0);
    }
    for (int j = 0; j < structure_.branches; ++j) {
      BranchState& b = branches_[static_cast<std::size_t>(j)];
      const double drive =
          plain ? undisturbed : undisturbed * branch_factor_[static_cast<std::size_t>(j)];
      if (x_ != nullptr) {
        const double* x = x_ + layout_.branch(j);
        const TableAt r = ValueAt(x, where, structure_.resistance_soc);
        b.slope_tau = decay[j] * b.slope_tau + decay_slope[j] * b.Voltage(x) +
                      (gain_slope[j] * drive * r.value + kAlive);
        // As what moves the state of charge moves r_j.
        const auto follow = [&](double slope, double by_soc) {
          const double moved = r.slope * by_soc;
          return decay[j] * slope + (gain[j] * drive * moved + kAlive);
        };
        if (!plain && setup_.diffusion) b.slope.beta = follow(b.slope.beta, step.slopes.beta);
        if (!plain && structure_.temperature) {
          if (setup_.diffusion) b.slope.energy = follow(b.slope.energy, step.slopes.energy);
          b.slope_energy = decay[j] * b.slope_energy +
                           (gain[j] * drive * r.value * at_.inverse_mol_per_J + kAlive);
        }
        if (!plain && structure_.current_offset) {
          const double direct =
              step.current_by_offset * per_A_ * branch_factor_[static_cast<std::size_t>(j)];
          b.slope.offset = follow(b.slope.offset, step.slopes.offset) + gain[j] * direct * r.value;
        }
        if (!plain && structure_.free_alpha)
          b.slope.alpha = follow(b.slope.alpha, step.slopes.alpha);
      }
      if (!tables) {
        b.Follow(decay[j], gain[j] * drive);  // (4.50)
      } else {
        b.Decay(decay[j]);
        if (drive != 0.0) b.Drive(where, gain[j] * drive);  // (4.50)
      }
    }
    if (!plain && structure_.self_heating) {
      const int h = structure_.branches;
      const double square_A2 = current_A * current_A;
      thermal_slope_ = decay[h] * thermal_slope_ + decay_slope[h] * thermal_state_A2_ +
                       gain_slope[h] * square_A2;
      thermal_state_A2_ = decay[h] * thermal_state_A2_ + gain[h] * square_A2;
      thermal_by_offset_A_ =
          decay[h] * thermal_by_offset_A_ + gain[h] * 2.0 * current_A * step.current_by_offset;
    }
    if (!plain && layout_.hystereses() > 0 && current_A != 0.0) StepHysteresis(step);
  }

  /// The point at which voltage_V was measured.
  template <bool plain = false>
  CellRow MakeRow(const At& point, double voltage_V) {
    const double current_A = point.current_A;
    const double soc = point.soc;
    int entries = 0;
    const auto put = [&](int at, double a) {
      index_[entries] = at;
      value_[entries++] = a;
    };
    double reference_V = 0.0;
    double slope_V = 0.0;  // of v_oc at this A
    if (!plain && layout_.voltages() > 0) {
      const NodeShare v = of_voltage_(soc);
      const double low_V = reference_V_[v.lower];
      const double high_V = reference_V_[v.lower + 1];
      reference_V = (1.0 - v.share) * low_V + v.share * high_V;
      if (x_ != nullptr) {
        const auto& [low_slope_V, high_slope_V] = curve_slope_V_[v.lower];
        slope_V = (1.0 - v.share) * low_slope_V + v.share * high_slope_V;
      }
      put(v.lower, 1.0 - v.share);
      put(v.lower + 1, v.share);
    } else {
      reference_V = point.v_oc.value_V;  // (4.49)
      slope_V = point.v_oc.slope_V;
    }
    const double i = current_A * per_A_;
    const bool tables = !plain && layout_.nodes() > 1;
    NodeShare r;
    if (i != 0.0 && tables) {
      r = of_resistance_(soc);
      r.share = std::clamp(r.share, 0.0, 1.0);
    }
    const auto put_table = [&](int table, double drop) {
      put(table + r.lower, -(1.0 - r.share) * drop);
      if (tables) put(table + r.lower + 1, -r.share * drop);
      if (x_ == nullptr) return TableAt{0.0, 0.0};
      const TableAt at = ValueAt(x_ + table, r, structure_.resistance_soc);
      slope_V -= at.slope * drop;
      return at;
    };
    TableAt series{0.0, 0.0};
    if (i != 0.0) series = put_table(layout_.series(), series_factor_ * i);
    SocSlopes of_branches;
    double by_current_V = series.value * series_factor_ * per_A_;  // -dv/di, of the offset alone
    double by_offset_V = 0.0;
    double by_alpha_V = 0.0;
    double by_transfer_energy_V = 0.0;
    for (int j = 0; j < structure_.branches; ++j) {
      const BranchState& b = branches_[static_cast<std::size_t>(j)];
      for (int m = b.first; m <= b.last; ++m) put(layout_.branch(j) + m, -b.share[m]);
      if (!plain) {
        of_branches.beta -= b.slope.beta;
        of_branches.energy -= b.slope.energy;
        of_branches.offset -= b.slope.offset;
        of_branches.alpha -= b.slope.alpha;
      }
      slope_[slots_.tau(j)] = -b.slope_tau;
    }
    if (!plain && structure_.charge_transfer) {
      slope_[slots_.transfer()] = 0.0;
      if (i != 0.0) {
        const double i_0 = rates_.charge_transfer_A;
        const double ratio = transfer_factor_ * current_A / i_0;
        const double drop = std::asinh(ratio);
        const double per_A = at_.ratio * per_A_;  // the thermal voltage
        const TableAt at = put_table(layout_.transfer(), i_0 * drop * per_A);
        if (x_ != nullptr) {
          const double root = std::hypot(1.0, ratio);
          slope_[slots_.transfer()] = -at.value * (drop - ratio / root) * per_A;
          by_current_V += at.value * transfer_factor_ / root * per_A;
          by_transfer_energy_V = -at.value * i_0 * ratio / root * at_.inverse_mol_per_J * per_A;
        }
      }
    }
    if (!plain && structure_.self_heating) {
      const double per_A3 = per_A_ * per_A_ * per_A_ * current_A;
      put(layout_.heating(), thermal_state_A2_ * per_A3);
      if (x_ != nullptr) {
        const double rho = x_[layout_.heating()];
        slope_[slots_.heating()] = rho * thermal_slope_ * per_A3;
        by_current_V -= rho * thermal_state_A2_ * per_A_ * per_A_ * per_A_;
        by_offset_V += rho * thermal_by_offset_A_ * per_A3;
      }
    }
    if (!plain && layout_.entropies() > 0) {
      NodeShare e = of_entropy_(soc);
      e.share = std::clamp(e.share, 0.0, 1.0);
      const double above = at_.above_K / kEntropyScale_K;
      put(layout_.entropy() + e.lower, (1.0 - e.share) * above);
      put(layout_.entropy() + e.lower + 1, e.share * above);
      if (x_ != nullptr)
        slope_V += ValueAt(x_ + layout_.entropy(), e, structure_.entropy_soc).slope * above;
    }
    if (!plain && layout_.hystereses() > 0) {
      NodeShare m = of_hysteresis_(soc);
      m.share = std::clamp(m.share, 0.0, 1.0);
      const int table = layout_.hysteresis();
      put(table + m.lower, (1.0 - m.share) * hysteresis_);
      if (layout_.hystereses() > 1) put(table + m.lower + 1, m.share * hysteresis_);
      if (x_ != nullptr) {
        const TableAt half = ValueAt(x_ + table, m, structure_.hysteresis_soc);
        slope_V += half.slope * hysteresis_;
        slope_[slots_.hysteresis()] = half.value * hysteresis_by_folds_;
        by_offset_V += half.value * hysteresis_by_offset_per_A_;
        // The e-folds over a charge are those over A where the axis follows alpha.
        if (setup_.axis_follows_alpha)
          by_alpha_V = -half.value * hysteresis_by_folds_ * folds_per_C_;
      }
    }
    if (!plain && structure_.temperature && x_ != nullptr) {
      // Energies that are one add up.
      for (int k = slots_.diffusion_energy(); k < slots_.hysteresis(); ++k) slope_[k] = 0.0;
      slope_[slots_.series_energy()] -= series.value * series_factor_ * i * at_.inverse_mol_per_J;
      for (int j = 0; j < structure_.branches; ++j)
        slope_[slots_.branch_energy(j)] -= branches_[static_cast<std::size_t>(j)].slope_energy;
      if (structure_.charge_transfer) slope_[slots_.transfer_energy()] += by_transfer_energy_V;
      if (setup_.diffusion)
        slope_[slots_.diffusion_energy()] += of_branches.energy + slope_V * point.slopes.energy;
    }
    if (x_ != nullptr) {
      slope_[slots_.beta()] =
          setup_.diffusion ? of_branches.beta + slope_V * point.slopes.beta : 0.0;  // (4.51)
    }
    if (!plain && structure_.current_offset && x_ != nullptr) {
      slope_[slots_.offset()] = of_branches.offset + slope_V * point.slopes.offset -
                                by_current_V * point.current_by_offset + by_offset_V;
    }
    if (!plain && structure_.free_alpha && x_ != nullptr)
      slope_[slots_.alpha()] = of_branches.alpha + slope_V * point.slopes.alpha + by_alpha_V;
    return {entries, index_.data(), value_.data(), voltage_V - reference_V, slope_.data()};
  }

 private:
  // Hysteresis<double>::After() with its slopes in the folds and in the offset.
  void StepHysteresis(const At& step) {
    const double sign = step.current_A > 0.0 ? 1.0 : -1.0;
    const double charge_C = std::abs(step.current_A) * step.dt_s;
    const double decay = std::exp(-folds_per_C_ * charge_C);
    const double towards = hysteresis_ + sign;
    hysteresis_by_folds_ = decay * (hysteresis_by_folds_ - charge_C / axis_C_ * towards);
    const double charge_by_offset_s = sign * step.current_by_offset * step.dt_s;
    hysteresis_by_offset_per_A_ =
        decay * (hysteresis_by_offset_per_A_ - folds_per_C_ * charge_by_offset_s * towards);
    hysteresis_ = decay * towards - sign;
  }

  // Slopes at both ends of every segment: its own, or those of parabolas through three nodes.
  void FindCurveSlopes(CurveSlope curve) {
    const auto& nodes = structure_.voltage_soc;
    if (nodes.size() < 2) return;
    const std::size_t last = nodes.size() - 1;
    std::vector<double> of_segment;
    for (std::size_t k = 0; k < last; ++k) {
      const double rise_V = reference_V_[k + 1] + x_[k + 1] - reference_V_[k] - x_[k];
      of_segment.push_back(rise_V / (nodes[k + 1] - nodes[k]));
    }
    for (std::size_t k = 0; k < last; ++k) curve_slope_V_.push_back({of_segment[k], of_segment[k]});
    if (curve == CurveSlope::kOfSegments) return;
    for (std::size_t k = 1; k < last; ++k) {
      const double before = nodes[k] - nodes[k - 1];
      const double after = nodes[k + 1] - nodes[k];
      const double slope_V =
          (after * of_segment[k - 1] + before * of_segment[k]) / (before + after);
      curve_slope_V_[k - 1].second = curve_slope_V_[k].first = slope_V;
    }
  }

  const JointSetup& setup_;
  const JointStructure& structure_;
  JointLayout layout_;
  RateSlots slots_;
  const JointRates& rates_;
  const double* x_;
  double per_A_;
  NodeFinder of_voltage_;
  NodeFinder of_resistance_;
  NodeFinder of_entropy_;
  NodeFinder of_hysteresis_;
  NodeFinder of_start_;
  std::vector<double> reference_V_;                       // at the nodes
  std::vector<std::pair<double, double>> curve_slope_V_;  // of v_oc at both ends of a segment
  std::vector<BranchState> branches_;
  double thermal_state_A2_ = 0.0;
  double thermal_slope_ = 0.0;  // in tau_h
  double thermal_by_offset_A_ = 0.0;
  double axis_C_ = 0.0;  // of which A is a share
  double folds_per_C_ = 0.0;
  double hysteresis_ = 0.0;
  double hysteresis_by_folds_ = 0.0;
  double hysteresis_by_offset_per_A_ = 0.0;
  std::vector<int> index_;
  std::vector<double> value_;
  std::vector<double> slope_;
  AtTemperature at_;
  double series_factor_ = 1.0;
  double transfer_factor_ = 1.0;
  std::vector<double> branch_factor_;
};

}  // namespace lipoid
