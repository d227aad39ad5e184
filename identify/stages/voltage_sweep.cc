#include "identify/stages/voltage_sweep.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "identify/stages/row_factor.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

// Decay and gain of a mode over one step, with their slopes in the mode's parameter.
struct ModeStep {
  double decay, gain, decay_slope, gain_slope;
};

// A value and its derivative in one parameter: all that ExactHold needs to differentiate itself.
struct Dual {
  double a = 0.0;
  double d = 0.0;

  explicit Dual(double value) : a(value) {}
  Dual(double value, double slope) : a(value), d(slope) {}
  friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.d + y.d}; }
  friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.d - y.d}; }
  friend Dual operator*(double s, const Dual& x) { return {s * x.a, s * x.d}; }
};

ModeStep MakeModeStep(const Dual& rate_per_s, double dt_s) {
  const auto hold = ExactHold(rate_per_s, dt_s);
  return {hold.decay.a, hold.gain.a, hold.decay.d, hold.gain.d};
}

// All modes of the cell side by side, so that a step of them runs in vector registers.
using Modes = Eigen::ArrayXd;

struct StepCoefficients {
  Modes decay, gain, decay_slope, gain_slope;

  void Resize(Eigen::Index modes) {
    for (Modes* v : {&decay, &gain, &decay_slope, &gain_slope}) v->resize(modes);
  }
  void Set(Eigen::Index mode, const ModeStep& step) {
    decay[mode] = step.decay;
    gain[mode] = step.gain;
    decay_slope[mode] = step.decay_slope;
    gain_slope[mode] = step.gain_slope;
  }
};

}  // namespace

VoltageSweep::VoltageSweep(SweepSetup setup, std::vector<SweepLog> logs)
    : setup_(std::move(setup)), logs_(std::move(logs)) {
  Require(setup_.alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", setup_.alpha_C}});
  for (const SweepLog& log : logs_) {
    Require(log.record != nullptr &&
                (log.row_weight.empty() || log.row_weight.size() == log.record->size()),
            "a record, and a weight for every row or none");
  }
  if (!setup_.diffusion) {
    setup_.terms = 0;
    setup_.tail = false;
  }
}

std::size_t VoltageSweep::rows() const {
  std::size_t sum = 0;
  for (const SweepLog& log : logs_) sum += log.record->size();
  return sum;
}

Eigen::MatrixXd VoltageSweep::Factor(const SweepParameters& parameters, bool jacobian) const {
  const auto branches = static_cast<int>(parameters.time_constant_s.size());
  Require(parameters.resistance_Ohm.size() == parameters.time_constant_s.size(),
          "as many resistances as time constants");
  const int columns = Columns(branches) + 1;
  std::vector<Eigen::MatrixXd> factors(logs_.size());
  tbb::parallel_for(std::size_t{0}, logs_.size(), [&](std::size_t k) {
    factors[k] = LogFactor(logs_[k], parameters, jacobian);
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

Eigen::MatrixXd VoltageSweep::LogFactor(const SweepLog& log,
                                        const SweepParameters& p,
                                        bool jacobian) const {
  const Record& record = *log.record;
  const Eigen::Index terms = setup_.terms;
  const auto branches = static_cast<Eigen::Index>(p.time_constant_s.size());
  const Eigen::Index modes = terms + branches;
  const double beta = p.beta_per_sqrt_s;
  const int columns = Columns(static_cast<int>(branches)) + 1;

  // sigma_um for m = 1 .. M with slopes in beta, then v_cj/r_j with slopes in tau_j.
  Modes state = Modes::Zero(modes);
  Modes slope = Modes::Zero(modes);
  const Modes inverse_tau = Eigen::Map<const Modes>(p.time_constant_s.data(), branches).inverse();
  const Eigen::Map<const Modes> resistance_Ohm(p.resistance_Ohm.data(), branches);

  IntervalCache<StepCoefficients> cache;
  const auto make = [&](double dt_s, StepCoefficients& step) {
    step.Resize(modes);
    for (Eigen::Index m = 0; m < terms; ++m) {
      const double mm = static_cast<double>((m + 1) * (m + 1));
      step.Set(m, MakeModeStep(Dual(mm * beta * beta, 2.0 * mm * beta), dt_s));  // (4.46)
    }
    for (Eigen::Index j = 0; j < branches; ++j) {
      // Of unit resistance: (v_cj/r_j)+ = decay v_cj/r_j + (gain/tau) i, (4.50).
      ModeStep mode = MakeModeStep(Dual(inverse_tau[j], -inverse_tau[j] * inverse_tau[j]), dt_s);
      mode.gain_slope = (mode.gain_slope - mode.gain * inverse_tau[j]) * inverse_tau[j];
      mode.gain *= inverse_tau[j];
      step.Set(terms + j, mode);
    }
  };

  const double tail_s = setup_.tail ? 2.0 * TailSum(setup_.terms) / (beta * beta) : 0.0;
  const double tail_slope = setup_.tail ? -2.0 * tail_s / beta : 0.0;
  const double inverse_alpha = 1.0 / setup_.alpha_C;
  const bool backward = record.hold == Hold::kBackward;
  const double log_weight = std::sqrt(log.weight);

  RowFactor factor(columns);
  double sum_of_squares = 0.0;
  double delivered_C = setup_.alpha_C * (1.0 - log.initial_soc);
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double current_A = record.current_A[k];
    if (k > 0) {
      const double held_A = backward ? current_A : record.current_A[k - 1];
      const double dt_s = record.time_s[k] - record.time_s[k - 1];
      const StepCoefficients& step = cache.Get(dt_s, record.time_s[k], make);
      if (jacobian)
        slope = step.decay * slope + step.decay_slope * state + (step.gain_slope * held_A + kAlive);
      state = step.decay * state + (step.gain * held_A + kAlive);
      delivered_C += dt_s * held_A;
    }
    const double sigma =
        delivered_C + 2.0 * state.head(terms).sum() + tail_s * current_A;  // (4.47)
    const double soc = (setup_.alpha_C - sigma) * inverse_alpha;           // (4.48)
    const auto open_circuit = setup_.open_circuit_voltage.Evaluate(soc);   // (4.49)
    const double voltage = open_circuit.value_V - p.series_resistance_Ohm * current_A -
                           (resistance_Ohm * state.tail(branches)).sum();  // (4.51)
    const double residual = record.voltage_V[k] - voltage;                 // (4.61)

    const double weight =
        log.row_weight.empty() ? log_weight : log_weight * std::sqrt(log.row_weight[k]);
    if (!jacobian) {
      sum_of_squares += weight * weight * residual * residual;
      continue;
    }
    const double sigma_slope = 2.0 * slope.head(terms).sum() + tail_slope * current_A;
    // d(residual)/d(parameter) = -d(voltage)/d(parameter).
    double* row = factor.NextRow();
    const auto stride = factor.stride();
    row[0] = weight * open_circuit.slope_V * sigma_slope * inverse_alpha;
    row[stride] = weight * current_A;
    for (Eigen::Index j = 0; j < branches; ++j) {
      row[(2 + j) * stride] = weight * state[terms + j];
      row[(2 + branches + j) * stride] = weight * resistance_Ohm[j] * slope[terms + j];
    }
    row[(columns - 1) * stride] = weight * residual;
    factor.Push();
  }
  if (jacobian) return factor.Factor();
  Eigen::MatrixXd norm = Eigen::MatrixXd::Zero(columns, columns);
  norm(columns - 1, columns - 1) = std::sqrt(sum_of_squares);
  return norm;
}

}  // namespace lipoid
