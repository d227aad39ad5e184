#include "identify/stages/voltage_sweep.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "identify/fit/mode_step.h"
#include "identify/logs/columns.h"
#include "identify/stages/row_factor.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

// All modes of the cell side by side, so that a step of them runs in vector registers.
using Modes = Eigen::ArrayXd;

// The modes of a cell with these parameters: sigma_um for m = 1 .. M with slopes in beta, then
// v_cj/r_j with slopes in tau_j.
class ModeRates {
 public:
  ModeRates(const SweepSetup& setup, const SweepParameters& p)
      : terms_(setup.terms),
        beta_(p.beta_per_sqrt_s),
        tau_s_(Eigen::Map<const Modes>(p.time_constant_s.data(),
                                       static_cast<Eigen::Index>(p.time_constant_s.size()))) {}

  [[nodiscard]] Eigen::Index terms() const { return terms_; }
  [[nodiscard]] Eigen::Index branches() const { return tau_s_.size(); }
  [[nodiscard]] Eigen::Index modes() const { return terms_ + tau_s_.size(); }

  [[nodiscard]] ModeStep Step(Eigen::Index mode, double dt_s) const {
    if (mode < terms_) return DiffusionStep(static_cast<int>(mode) + 1, beta_, dt_s);
    return LowPassStep(tau_s_[mode - terms_], dt_s);
  }

 private:
  Eigen::Index terms_;
  double beta_;
  Modes tau_s_;
};

struct StepCoefficients {
  Modes decay, gain, decay_slope, gain_slope;

  void Set(const ModeRates& rates, double dt_s) {
    for (Modes* v : {&decay, &gain, &decay_slope, &gain_slope}) v->resize(rates.modes());
    for (Eigen::Index mode = 0; mode < rates.modes(); ++mode) {
      const ModeStep step = rates.Step(mode, dt_s);
      decay[mode] = step.decay;
      gain[mode] = step.gain;
      decay_slope[mode] = step.decay_slope;
      gain_slope[mode] = step.gain_slope;
    }
  }
};

// The modes and their slopes at one time, with the charge that has left.
struct ModeState {
  Modes value, slope;
  double delivered_C;

  void Step(const StepCoefficients& step, double current_A, double dt_s, bool slopes) {
    if (slopes) {
      slope =
          step.decay * slope + step.decay_slope * value + (step.gain_slope * current_A + kAlive);
    }
    value = step.decay * value + (step.gain * current_A + kAlive);
    delivered_C += dt_s * current_A;
  }
};

// What the modes make of the nodes of a block: rows are nodes. Of the diffusion modes only the sum
// is wanted, so its drive is summed already.
struct BlockCoefficients {
  Eigen::MatrixXd decay, decay_slope;  // nodes x modes
  Eigen::MatrixXd drive, drive_slope;  // nodes x (1 + branches): sum over m, then each branch
  StepCoefficients whole;              // to the last row

  void Set(const ModeRates& rates, const BlockShape& shape) {
    const Eigen::Index nodes = shape.nodes();
    decay.resize(nodes, rates.modes());
    decay_slope.resize(nodes, rates.modes());
    drive = Eigen::MatrixXd::Zero(nodes, 1 + rates.branches());
    drive_slope = drive;
    for (Eigen::Index mode = 0; mode < rates.modes(); ++mode) {
      const Eigen::Index group = mode < rates.terms() ? 0 : 1 + mode - rates.terms();
      for (Eigen::Index j = 0; j < nodes; ++j) {
        const ModeStep step = rates.Step(mode, shape.node_s[j]);
        decay(j, mode) = step.decay;
        decay_slope(j, mode) = step.decay_slope;
        drive(j, group) += step.gain;
        drive_slope(j, group) += step.gain_slope;
      }
    }
    whole.Set(rates, shape.duration_s());
  }
};

// Sum of the diffusion modes, then every branch, at the nodes of a block.
struct NodeStates {
  Eigen::MatrixXd value, slope;  // nodes x (1 + branches)

  void Set(const BlockCoefficients& c,
           const ModeState& state,
           Eigen::Index terms,
           double current_A,
           bool slopes) {
    const Eigen::Index branches = c.drive.cols() - 1;
    value.noalias() = current_A * c.drive;
    value.col(0).noalias() += c.decay.leftCols(terms) * state.value.head(terms).matrix();
    for (Eigen::Index j = 0; j < branches; ++j)
      value.col(1 + j) += c.decay.col(terms + j) * state.value[terms + j];
    if (!slopes) return;
    slope.noalias() = current_A * c.drive_slope;
    slope.col(0).noalias() += c.decay.leftCols(terms) * state.slope.head(terms).matrix();
    slope.col(0).noalias() += c.decay_slope.leftCols(terms) * state.value.head(terms).matrix();
    for (Eigen::Index j = 0; j < branches; ++j) {
      slope.col(1 + j) += c.decay.col(terms + j) * state.slope[terms + j] +
                          c.decay_slope.col(terms + j) * state.value[terms + j];
    }
  }
};

// One log swept with one set of parameters. What becomes of rows and blocks is the visitor's:
//   Row(k, sigma_C, sigma_slope, branch values, branch slopes)
//   Block(piece, shape, sigma at the nodes, ...) -> false: it wants the rows instead
class LogSweep {
 public:
  LogSweep(const SweepSetup& setup,
           const CondensedLog& log,
           double initial_soc,
           const SweepParameters& p)
      : log_(log),
        rates_(setup, p),
        tail_s_(setup.tail ? 2.0 * TailSum(setup.terms) / (p.beta_per_sqrt_s * p.beta_per_sqrt_s)
                           : 0.0),
        tail_slope_(setup.tail ? -2.0 * tail_s_ / p.beta_per_sqrt_s : 0.0),
        delivered_C_(setup.alpha_C * (1.0 - initial_soc)) {}

  template <class Visitor>
  void Run(bool slopes, Visitor&& visitor) {
    const Record& record = log_.record();
    const Eigen::Index terms = rates_.terms();
    ModeState state{Modes::Zero(rates_.modes()), Modes::Zero(rates_.modes()), delivered_C_};
    std::vector<BlockCoefficients> blocks(log_.shapes().size());
    for (std::size_t k = 0; k < blocks.size(); ++k) blocks[k].Set(rates_, log_.shapes()[k]);
    IntervalCache<StepCoefficients> cache;
    const auto make = [&](double dt_s, StepCoefficients& step) { step.Set(rates_, dt_s); };
    const bool backward = record.hold == Hold::kBackward;
    NodeStates nodes;
    Eigen::VectorXd sigma_C, sigma_slope;

    const auto row = [&](std::size_t k) {
      const double current_A = record.current_A[k];
      if (k > 0) {
        const double dt_s = record.time_s[k] - record.time_s[k - 1];
        state.Step(cache.Get(dt_s, record.time_s[k], make),
                   backward ? current_A : record.current_A[k - 1],
                   dt_s,
                   slopes);
      }
      const double sigma =
          state.delivered_C + 2.0 * state.value.head(terms).sum() + tail_s_ * current_A;  // (4.47)
      const double slope =
          slopes ? 2.0 * state.slope.head(terms).sum() + tail_slope_ * current_A : 0.0;
      visitor.Row(k, sigma, slope, state.value.data() + terms, state.slope.data() + terms);
    };
    for (const CondensedPiece& piece : log_.pieces()) {
      if (!piece.plain()) {
        const BlockShape& shape = log_.shapes()[piece.shape];
        const BlockCoefficients& block = blocks[piece.shape];
        const double current_A = piece.current_A;
        nodes.Set(block, state, terms, current_A, slopes);
        sigma_C = (state.delivered_C + tail_s_ * current_A + current_A * shape.node_s.array() +
                   2.0 * nodes.value.col(0).array());  // (4.47)
        if (slopes) sigma_slope = 2.0 * nodes.slope.col(0).array() + tail_slope_ * current_A;
        if (visitor.Block(piece, shape, sigma_C, sigma_slope, nodes.value, nodes.slope)) {
          state.Step(block.whole, current_A, piece.duration_s, slopes);
          continue;
        }
      }
      for (std::size_t k = piece.first; k < piece.first + piece.rows; ++k) row(k);
    }
  }

 private:
  const CondensedLog& log_;
  ModeRates rates_;
  double tail_s_;
  double tail_slope_;
  double delivered_C_;
};

// Does v_oc(A) have one formula where a block's A lies? Its ends reach a little beyond the nodes.
bool CrossesKnot(const OpenCircuitVoltage& curve, const Eigen::VectorXd& sigma_C, double alpha_C) {
  const double reach = 0.1 * (sigma_C.maxCoeff() - sigma_C.minCoeff());
  const double low = 1.0 - (sigma_C.maxCoeff() + reach) / alpha_C;
  const double high = 1.0 - (sigma_C.minCoeff() - reach) / alpha_C;
  return curve.Formula(low) != curve.Formula(high);
}

// Adds up the rows of [J r].
class FactorVisitor {
 public:
  FactorVisitor(const SweepSetup& setup,
                const CondensedLog& log,
                const SweepParameters& p,
                double weight,
                bool knots_matter,
                bool jacobian)
      : setup_(setup),
        log_(log),
        record_(log.record()),
        p_(p),
        branches_(static_cast<Eigen::Index>(p.time_constant_s.size())),
        weight_(std::sqrt(weight)),
        inverse_alpha_(1.0 / setup.alpha_C),
        knots_matter_(knots_matter),
        jacobian_(jacobian),
        factor_(VoltageSweep::Columns(static_cast<int>(branches_)) + 1) {}

  void Row(std::size_t k,
           double sigma_C,
           double sigma_slope,
           const double* branch,
           const double* branch_slope) {
    Point(record_.voltage_V[k],
          record_.current_A[k],
          weight_,
          sigma_C,
          sigma_slope,
          branch,
          branch_slope,
          1);
  }

  bool Block(const CondensedPiece& piece,
             const BlockShape& shape,
             const Eigen::VectorXd& sigma_C,
             const Eigen::VectorXd& sigma_slope,
             const Eigen::MatrixXd& value,
             const Eigen::MatrixXd& slope) {
    if (knots_matter_ && CrossesKnot(setup_.open_circuit_voltage, sigma_C, setup_.alpha_C))
      return false;
    const double* voltage_V = log_.node_voltage_V(piece);
    const Eigen::Index nodes = shape.nodes();
    for (Eigen::Index j = 0; j < nodes; ++j) {
      Point(voltage_V[j],
            piece.current_A,
            weight_ * std::sqrt(shape.weight[j]),
            sigma_C[j],
            jacobian_ ? sigma_slope[j] : 0.0,
            value.data() + nodes + j,
            slope.data() + nodes + j,
            nodes);
    }
    remainder_ += piece.remainder;
    return true;
  }

  [[nodiscard]] Eigen::MatrixXd Result() {
    const double remainder = weight_ * weight_ * remainder_;
    const Eigen::Index last = VoltageSweep::Columns(static_cast<int>(branches_));
    if (!jacobian_) {
      Eigen::MatrixXd norm = Eigen::MatrixXd::Zero(last + 1, last + 1);
      norm(last, last) = std::sqrt(sum_of_squares_ + remainder);
      return norm;
    }
    // What no polynomial of a block can change stands in the residual alone.
    double* row = factor_.NextRow();
    for (Eigen::Index k = 0; k < last; ++k) row[k * factor_.stride()] = 0.0;
    row[last * factor_.stride()] = std::sqrt(remainder);
    factor_.Push();
    return factor_.Factor();
  }

 private:
  void Point(double measured_V,
             double current_A,
             double weight,
             double sigma_C,
             double sigma_slope,
             const double* branch,
             const double* branch_slope,
             Eigen::Index step) {
    const double soc = (setup_.alpha_C - sigma_C) * inverse_alpha_;       // (4.48)
    const auto open_circuit = setup_.open_circuit_voltage.Evaluate(soc);  // (4.49)
    double voltage = open_circuit.value_V - p_.series_resistance_Ohm * current_A;
    for (Eigen::Index j = 0; j < branches_; ++j)
      voltage -= p_.resistance_Ohm[static_cast<std::size_t>(j)] * branch[j * step];  // (4.51)
    const double residual = measured_V - voltage;                                    // (4.61)
    if (!jacobian_) {
      sum_of_squares_ += weight * weight * residual * residual;
      return;
    }
    // d(residual)/d(parameter) = -d(voltage)/d(parameter).
    double* row = factor_.NextRow();
    const auto stride = factor_.stride();
    row[0] = weight * open_circuit.slope_V * sigma_slope * inverse_alpha_;
    row[stride] = weight * current_A;
    for (Eigen::Index j = 0; j < branches_; ++j) {
      row[(2 + j) * stride] = weight * branch[j * step];
      row[(2 + branches_ + j) * stride] =
          weight * p_.resistance_Ohm[static_cast<std::size_t>(j)] * branch_slope[j * step];
    }
    row[(2 + 2 * branches_) * stride] = weight * residual;
    factor_.Push();
  }

  const SweepSetup& setup_;
  const CondensedLog& log_;
  const Record& record_;
  const SweepParameters& p_;
  Eigen::Index branches_;
  double weight_;
  double inverse_alpha_;
  bool knots_matter_;
  bool jacobian_;
  RowFactor factor_;
  double sum_of_squares_ = 0.0;
  double remainder_ = 0.0;
};

// Compares every row with its prediction.
class ErrorVisitor {
 public:
  ErrorVisitor(const SweepSetup& setup,
               const CondensedLog& log,
               const SweepParameters& p,
               ErrorAccumulator& errors)
      : setup_(setup), record_(log.record()), p_(p), errors_(errors) {}

  void Row(std::size_t k, double sigma_C, double, const double* branch, const double*) {
    double polarization_V = p_.series_resistance_Ohm * record_.current_A[k];
    for (std::size_t j = 0; j < p_.resistance_Ohm.size(); ++j)
      polarization_V += p_.resistance_Ohm[j] * branch[j];
    Add(k, sigma_C, polarization_V);
  }

  // sigma and the polarization are polynomials, and so is the voltage where no knot is crossed.
  bool Block(const CondensedPiece& piece,
             const BlockShape& shape,
             const Eigen::VectorXd& sigma_C,
             const Eigen::VectorXd&,
             const Eigen::MatrixXd& value,
             const Eigen::MatrixXd&) {
    const Eigen::Index nodes = shape.nodes();
    const Eigen::MatrixXd to_coefficients = shape.at_nodes * shape.weight.asDiagonal();
    Eigen::VectorXd polarization_V =
        Eigen::VectorXd::Constant(nodes, p_.series_resistance_Ohm * piece.current_A);
    for (std::size_t j = 0; j < p_.resistance_Ohm.size(); ++j)
      polarization_V += p_.resistance_Ohm[j] * value.col(1 + static_cast<Eigen::Index>(j));
    if (CrossesKnot(setup_.open_circuit_voltage, sigma_C, setup_.alpha_C)) {
      const Eigen::VectorXd sigma_rows_C = shape.basis * (to_coefficients * sigma_C);
      rows_ = shape.basis * (to_coefficients * polarization_V);
      for (std::size_t k = 0; k < piece.rows; ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        Add(piece.first + k, sigma_rows_C[row], rows_[row]);
      }
      return true;
    }
    Eigen::VectorXd voltage_V(nodes);
    for (Eigen::Index j = 0; j < nodes; ++j)
      voltage_V[j] =
          setup_.open_circuit_voltage.Evaluate(Soc(sigma_C[j])).value_V - polarization_V[j];
    rows_.noalias() = shape.basis * (to_coefficients * voltage_V);
    const double* measured_V = record_.voltage_V.data() + piece.first;
    for (std::size_t k = 0; k < piece.rows; ++k)
      errors_.Add(measured_V[k], rows_[static_cast<Eigen::Index>(k)]);
    if (!setup_.open_circuit_voltage.InRange(Soc(sigma_C[0]))) outside_ += piece.rows;
    return true;
  }

  [[nodiscard]] std::size_t outside() const { return outside_; }

 private:
  [[nodiscard]] double Soc(double sigma_C) const {
    return (setup_.alpha_C - sigma_C) / setup_.alpha_C;  // (4.48)
  }

  void Add(std::size_t k, double sigma_C, double polarization_V) {
    const double soc = Soc(sigma_C);
    const double open_circuit_V = setup_.open_circuit_voltage.Evaluate(soc).value_V;
    errors_.Add(record_.voltage_V[k], open_circuit_V - polarization_V);  // (4.51)
    if (!setup_.open_circuit_voltage.InRange(soc)) ++outside_;
  }

  const SweepSetup& setup_;
  const Record& record_;
  const SweepParameters& p_;
  ErrorAccumulator& errors_;
  Eigen::VectorXd rows_;
  std::size_t outside_ = 0;
};

// Gathers means of rows for VoltageSweep::Means().
class MeansVisitor {
 public:
  MeansVisitor(const SweepSetup& setup,
               const CondensedLog& log,
               const SweepParameters& p,
               bool each_row)
      : setup_(setup),
        log_(log),
        record_(log.record()),
        p_(p),
        growth_(each_row ? 0.0 : kGrowth),
        branches_(static_cast<Eigen::Index>(p.time_constant_s.size())),
        columns_(VoltageSweep::Columns(static_cast<int>(branches_))) {
    tolerance_A_ = kSameCurrent * LargestMagnitude(record_.current_A);
  }

  void Row(std::size_t k,
           double sigma_C,
           double sigma_slope,
           const double* branch,
           const double* branch_slope) {
    const double time_s = record_.time_s[k];
    Begin(time_s, time_s, record_.current_A[k]);
    Point(record_.voltage_V[k],
          record_.current_A[k],
          1.0,
          sigma_C,
          sigma_slope,
          branch,
          branch_slope,
          1);
    time_sum_ += time_s - first_s_;
  }

  bool Block(const CondensedPiece& piece,
             const BlockShape& shape,
             const Eigen::VectorXd& sigma_C,
             const Eigen::VectorXd& sigma_slope,
             const Eigen::MatrixXd& value,
             const Eigen::MatrixXd& slope) {
    if (CrossesKnot(setup_.open_circuit_voltage, sigma_C, setup_.alpha_C)) return false;
    const double before_s = piece.first > 0 ? record_.time_s[piece.first - 1] : record_.time_s[0];
    Begin(before_s, before_s + piece.duration_s, piece.current_A);
    // The quadrature of the block: sums over its rows are sums over its nodes.
    const double* voltage_V = log_.node_voltage_V(piece);
    const Eigen::Index nodes = shape.nodes();
    for (Eigen::Index j = 0; j < nodes; ++j) {
      Point(voltage_V[j],
            piece.current_A,
            shape.weight[j],
            sigma_C[j],
            sigma_slope[j],
            value.data() + nodes + j,
            slope.data() + nodes + j,
            nodes);
    }
    time_sum_ +=
        (before_s - first_s_) * static_cast<double>(piece.rows) + shape.weight.dot(shape.node_s);
    return true;
  }

  // At most so many, if need be over steps of the current.
  [[nodiscard]] FittedRows Result(double weight, std::size_t most) {
    Close();
    bool within_phases = true;
    while (means_.size() > std::max<std::size_t>(most, 2)) {
      const std::size_t before = means_.size();
      Join(within_phases);
      within_phases = within_phases && means_.size() < before;
    }
    FittedRows rows;
    const auto n = static_cast<Eigen::Index>(means_.size());
    rows.residual_V.resize(n);
    rows.averaged.resize(n);
    rows.sensitivity.resize(n, columns_);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Mean& mean = means_[static_cast<std::size_t>(k)];
      rows.time_s.push_back(mean.time_s);
      rows.averaged[k] = mean.rows;
      rows.residual_V[k] = mean.sum[columns_] / mean.rows;
      rows.sensitivity.row(k) = mean.sum.head(columns_).transpose() / mean.rows;
    }
    rows.weight = weight * rows.averaged;
    return rows;
  }

 private:
  // A mean is so much shorter than the time since the current changed: what a mode does in it is
  // a line, to a part in a thousand of its amplitude.
  static constexpr double kGrowth = 0.05;
  // Currents that differ by less, of the largest, are the same phase.
  static constexpr double kSameCurrent = 0.01;

  struct Mean {
    double time_s = 0.0;
    double rows = 0.0;
    std::size_t phase = 0;
    Eigen::VectorXd sum;  // of sensitivities and residual
  };

  // The next point spans these times.
  void Begin(double from_s, double to_s, double current_A) {
    const bool changed = phase_ == 0 || std::abs(current_A - phase_A_) > tolerance_A_;
    if (changed || to_s - first_s_ > growth_ * (to_s - phase_start_s_)) Close();
    if (changed) {
      ++phase_;
      phase_A_ = current_A;
      phase_start_s_ = from_s;
    }
    if (open_.rows == 0.0) first_s_ = from_s;
  }

  void Point(double measured_V,
             double current_A,
             double rows,
             double sigma_C,
             double sigma_slope,
             const double* branch,
             const double* branch_slope,
             Eigen::Index step) {
    const double soc = (setup_.alpha_C - sigma_C) / setup_.alpha_C;       // (4.48)
    const auto open_circuit = setup_.open_circuit_voltage.Evaluate(soc);  // (4.49)
    double voltage = open_circuit.value_V - p_.series_resistance_Ohm * current_A;
    if (open_.rows == 0.0) open_.sum.setZero(columns_ + 1);
    Eigen::VectorXd& sum = open_.sum;
    sum[0] -= rows * open_circuit.slope_V * sigma_slope / setup_.alpha_C;
    sum[1] -= rows * current_A;
    for (Eigen::Index j = 0; j < branches_; ++j) {
      const double resistance = p_.resistance_Ohm[static_cast<std::size_t>(j)];
      voltage -= resistance * branch[j * step];  // (4.51)
      sum[2 + j] -= rows * branch[j * step];
      sum[2 + branches_ + j] -= rows * resistance * branch_slope[j * step];
    }
    sum[columns_] += rows * (measured_V - voltage);  // (4.61)
    open_.rows += rows;
  }

  void Close() {
    if (open_.rows == 0.0) return;
    open_.time_s = first_s_ + time_sum_ / open_.rows;
    open_.phase = phase_;
    means_.push_back(std::move(open_));
    open_ = {};
    time_sum_ = 0.0;
  }

  // Joins neighbours two by two, those of one phase only or all.
  void Join(bool within_phases) {
    std::vector<Mean> joined;
    for (std::size_t k = 0; k < means_.size(); ++k) {
      Mean& mean = means_[k];
      if (k + 1 < means_.size() && (!within_phases || means_[k + 1].phase == mean.phase)) {
        const Mean& next = means_[++k];
        mean.time_s = (mean.rows * mean.time_s + next.rows * next.time_s) / (mean.rows + next.rows);
        mean.rows += next.rows;
        mean.sum += next.sum;
        mean.phase = next.phase;
      }
      joined.push_back(std::move(mean));
    }
    means_ = std::move(joined);
  }

  const SweepSetup& setup_;
  const CondensedLog& log_;
  const Record& record_;
  const SweepParameters& p_;
  double growth_;
  Eigen::Index branches_;
  Eigen::Index columns_;
  double tolerance_A_ = 0.0;
  std::size_t phase_ = 0;
  double phase_A_ = 0.0;
  double phase_start_s_ = 0.0;
  double first_s_ = 0.0;
  double time_sum_ = 0.0;  // since first_s_
  Mean open_;
  std::vector<Mean> means_;
};

}  // namespace

VoltageSweep::VoltageSweep(SweepSetup setup, std::vector<SweepLog> logs, const Condensation& how)
    : setup_(std::move(setup)), logs_(std::move(logs)), how_(how) {
  Require(setup_.alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", setup_.alpha_C}});
  if (!setup_.diffusion) {
    setup_.terms = 0;
    setup_.tail = false;
  }
  auto condensed = std::make_shared<std::vector<CondensedLog>>();
  for (const SweepLog& log : logs_) {
    Require(log.record != nullptr, "a record");
    condensed->emplace_back(*log.record, how);
  }
  condensed_ = std::move(condensed);
}

VoltageSweep VoltageSweep::With(OpenCircuitVoltage curve) const {
  VoltageSweep other = *this;
  other.setup_.open_circuit_voltage = std::move(curve);
  return other;
}

std::size_t VoltageSweep::rows() const {
  std::size_t sum = 0;
  for (const SweepLog& log : logs_) sum += log.record->size();
  return sum;
}

std::size_t VoltageSweep::points() const {
  std::size_t sum = 0;
  for (const CondensedLog& log : *condensed_) sum += log.points();
  return sum;
}

Eigen::MatrixXd VoltageSweep::Factor(const SweepParameters& parameters, bool jacobian) const {
  const auto branches = static_cast<int>(parameters.time_constant_s.size());
  Require(parameters.resistance_Ohm.size() == parameters.time_constant_s.size(),
          "as many resistances as time constants");
  const int columns = Columns(branches) + 1;
  std::vector<Eigen::MatrixXd> factors(logs_.size());
  tbb::parallel_for(std::size_t{0}, logs_.size(), [&](std::size_t k) {
    FactorVisitor visitor(
        setup_, (*condensed_)[k], parameters, logs_[k].weight, !how_.coarse, jacobian);
    LogSweep(setup_, (*condensed_)[k], logs_[k].initial_soc, parameters).Run(jacobian, visitor);
    factors[k] = visitor.Result();
  });
  if (factors.size() == 1) return factors[0];
  // Joined in the order of the logs, whatever the threads did.
  RowFactor all(columns);
  for (const auto& factor : factors) {
    for (Eigen::Index row = 0; row < factor.rows(); ++row) {
      double* next = all.NextRow();
      for (Eigen::Index j = 0; j < columns; ++j) next[j * all.stride()] = factor(row, j);
      all.Push();
    }
  }
  Eigen::MatrixXd factor = all.Factor();
  if (!jacobian)
    factor(columns - 1, columns - 1) = std::abs(factor(columns - 1, columns - 1));  // a norm
  return factor;
}

SweepErrors VoltageSweep::Errors(const SweepParameters& parameters) const {
  Require(!how_.coarse, "a sweep that is not coarse");
  SweepErrors result;
  ErrorAccumulator errors;
  for (std::size_t k = 0; k < logs_.size(); ++k) {
    ErrorVisitor visitor(setup_, (*condensed_)[k], parameters, errors);
    LogSweep(setup_, (*condensed_)[k], logs_[k].initial_soc, parameters).Run(false, visitor);
    result.rows_outside_curve += visitor.outside();
  }
  result.metrics = errors.Result();
  return result;
}

std::vector<FittedRows> VoltageSweep::Means(const SweepParameters& parameters,
                                            std::size_t most) const {
  Require(!how_.coarse, "a sweep that is not coarse");
  std::vector<FittedRows> means(logs_.size());
  const std::size_t all = rows();
  tbb::parallel_for(std::size_t{0}, logs_.size(), [&](std::size_t k) {
    const CondensedLog& log = (*condensed_)[k];
    MeansVisitor visitor(setup_, log, parameters, all <= most);
    LogSweep(setup_, log, logs_[k].initial_soc, parameters).Run(true, visitor);
    const double share = static_cast<double>(log.record().size()) / static_cast<double>(all);
    means[k] = visitor.Result(logs_[k].weight,
                              static_cast<std::size_t>(share * static_cast<double>(most)));
  });
  return means;
}

}  // namespace lipoid
