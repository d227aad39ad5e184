#include "identify/stages/pulse_problem.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "identify/stages/discharge_times.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

using Kind = PulseVariable::Kind;

// A branch of r_j = 0 follows the current at once: so does one of a nanosecond.
constexpr double kLeastTau_s = 1e-9;

}  // namespace

double PulseVariable::ToX(double p) const { return logarithmic ? std::log(p / unit) : p / unit; }
double PulseVariable::FromX(double x) const { return logarithmic ? unit * std::exp(x) : unit * x; }

double& Entry(PulseParameters& p, const PulseVariable& v) {
  switch (v.kind) {
    case Kind::kBeta:
      return p.sweep.beta_per_sqrt_s;
    case Kind::kSeriesResistance:
      return p.sweep.series_resistance_Ohm;
    case Kind::kResistance:
      return p.sweep.resistance_Ohm[v.branch];
    case Kind::kTimeConstant:
      return p.sweep.time_constant_s[v.branch];
    case Kind::kCapacitance:
      break;
  }
  return p.capacitance_F[v.branch];
}
double Entry(const PulseParameters& p, const PulseVariable& v) {
  return Entry(const_cast<PulseParameters&>(p), v);
}

void FollowCapacitances(PulseParameters& p) {
  for (std::size_t j = 0; j < p.capacitance_F.size(); ++j) {
    if (std::isnan(p.capacitance_F[j])) continue;
    p.sweep.time_constant_s[j] =
        std::max(p.sweep.resistance_Ohm[j] * p.capacitance_F[j], kLeastTau_s);
  }
}

double PulseScales::TimeConstant(int j, int branches) const {
  const double spread = j - 0.5 * (branches - 1);
  return std::clamp(relaxation_s * std::pow(5.0, spread), shortest_tau_s, longest_tau_s);
}

PulseScales FindPulseScales(const StartValues& data, double alpha_C) {
  PulseScales scales{};
  scales.series_resistance_Ohm = data.series_resistance_Ohm > 0.0
                                     ? data.series_resistance_Ohm
                                     : 36.0 / alpha_C;  // 10 mOhm for 1 Ah, and in proportion
  scales.recovery_Ohm =
      data.relaxation_Ohm > 0.0 ? data.relaxation_Ohm : 0.3 * scales.series_resistance_Ohm;
  scales.relaxation_s =
      data.relaxation_s > 0.0 ? data.relaxation_s : std::sqrt(data.shortest_s * data.longest_s);
  scales.shortest_tau_s = 0.1 * data.shortest_s;
  scales.longest_tau_s = 10.0 * data.longest_s;
  return scales;
}

PulseUnknowns FindPulseUnknowns(const JointSetup& setup,
                                const StartValues& data,
                                const PulseProblemOptions& options,
                                const GivenParameters& known) {
  CheckGiven(known, FitParameterNames(setup.diffusion, options.branches));
  PulseUnknowns unknowns;
  const PulseScales scales = FindPulseScales(data, setup.alpha_C);
  const double series = scales.series_resistance_Ohm;
  const auto n = static_cast<std::size_t>(options.branches);
  const double share_Ohm = n > 0 ? 0.5 * scales.recovery_Ohm / static_cast<double>(n) : 0.0;

  PulseParameters& start = unknowns.start;
  start.sweep.beta_per_sqrt_s = setup.diffusion ? options.beta_start_per_sqrt_s : 0.0;
  start.sweep.series_resistance_Ohm = series;
  start.sweep.resistance_Ohm.assign(n, share_Ohm);
  start.capacitance_F.assign(n, kNaN);
  for (int j = 0; j < options.branches; ++j)
    start.sweep.time_constant_s.push_back(scales.TimeConstant(j, options.branches));

  const auto add = [&](PulseVariable v) {
    double& entry = Entry(start, v);
    if (const auto fixed = known.Fixed(v.name)) {
      entry = *fixed;
      return;
    }
    if (const auto begin = known.Start(v.name)) entry = *begin;
    v.logarithmic = options.scale == ParameterScale::kLog ||
                    (options.scale == ParameterScale::kMixed && !v.resistive());
    // A logarithm never reaches 0: far below what any log could show stands for it.
    if (v.logarithmic && v.lower == 0.0) v.lower = 1e-6 * v.unit;
    if (const auto bounds = known.Bounds(v.name)) {
      v.lower = v.logarithmic ? std::max(bounds->first, v.lower) : bounds->first;
      v.upper = bounds->second;
      if (v.lower > v.upper) {
        throw OptionError(
            fmt::format("--bounds {}: expected an upper bound of at least {}", v.name, v.lower));
      }
    }
    if (options.scale == ParameterScale::kNatural) v.unit = 1.0;
    entry = std::clamp(entry, v.lower, v.upper);
    unknowns.variables.push_back(std::move(v));
  };
  if (setup.diffusion) {
    add({"beta",
         Kind::kBeta,
         0,
         false,
         options.scale == ParameterScale::kMixed ? 1.0 : options.beta_start_per_sqrt_s,
         kLeastBeta_per_sqrt_s,  // stands for the 0 of (4.61)
         kLargestBeta});
  }
  add({"r_s", Kind::kSeriesResistance, 0, false, series});
  for (std::size_t j = 0; j < n; ++j) {
    add({fmt::format("r_{}", j + 1), Kind::kResistance, j, false, series});
  }
  for (std::size_t j = 0; j < n; ++j) {
    const auto c = fmt::format("c_{}", j + 1);
    const auto tau = fmt::format("tau_{}", j + 1);
    const bool by_capacitance = known.Mentions(c) || (options.capacitances && !known.Mentions(tau));
    if (by_capacitance) {
      // The time constants of the start, whatever the resistance is held at.
      const double r = std::max(start.sweep.resistance_Ohm[j], 1e-6 * series);
      start.capacitance_F[j] = start.sweep.time_constant_s[j] / r;
      add({c,
           Kind::kCapacitance,
           j,
           false,
           scales.relaxation_s / std::max(share_Ohm, 1e-6 * series)});
    } else {
      add({tau,
           Kind::kTimeConstant,
           j,
           false,
           scales.relaxation_s,
           scales.shortest_tau_s,
           scales.longest_tau_s});
    }
  }
  FollowCapacitances(start);
  return unknowns;
}

PulseParameters PulseProblem::Parameters(const Eigen::VectorXd& x) const {
  PulseParameters p = base_;
  for (int k = 0; k < size(); ++k) {
    const PulseVariable& v = variables_[static_cast<std::size_t>(k)];
    Entry(p, v) = std::clamp(v.FromX(x[k]), v.lower, v.upper);
  }
  FollowCapacitances(p);
  return p;
}

Eigen::VectorXd PulseProblem::Point(const PulseParameters& p) const {
  Eigen::VectorXd x(size());
  for (int k = 0; k < size(); ++k) {
    const PulseVariable& v = variables_[static_cast<std::size_t>(k)];
    x[k] = v.ToX(std::clamp(Entry(p, v), v.lower, v.upper));
  }
  return x;
}

Eigen::VectorXd PulseProblem::Bound(double PulseVariable::*which) const {
  Eigen::VectorXd bound(size());
  for (int k = 0; k < size(); ++k) {
    const PulseVariable& v = variables_[static_cast<std::size_t>(k)];
    bound[k] = std::isfinite(v.*which) ? v.ToX(v.*which) : std::numeric_limits<double>::max();
  }
  return bound;
}

// The rows of the sweep's factor, of which only the columns of the free parameters are kept, are
// few: triangular again after one small QR.
Eigen::MatrixXd PulseProblem::Factor(const Eigen::VectorXd& x, bool jacobian) const {
  const PulseParameters p = Parameters(x);
  const Eigen::MatrixXd all = sweep_.Factor(p.sweep, jacobian);
  const auto n = static_cast<Eigen::Index>(p.capacitance_F.size());
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(all.rows(), size() + 1);
  for (int k = 0; jacobian && k < size(); ++k) {
    const PulseVariable& v = variables_[static_cast<std::size_t>(k)];
    const auto j = static_cast<Eigen::Index>(v.branch);
    auto column = kept.col(k);
    switch (v.kind) {
      case Kind::kBeta:
        column = all.col(0);
        break;
      case Kind::kSeriesResistance:
        column = all.col(1);
        break;
      case Kind::kResistance:
        column = all.col(2 + j);
        // With c_j held the time constant moves too: dtau_j/dr_j = c_j.
        if (!std::isnan(p.capacitance_F[v.branch]))
          column += p.capacitance_F[v.branch] * all.col(2 + n + j);
        break;
      case Kind::kTimeConstant:
        column = all.col(2 + n + j);
        break;
      case Kind::kCapacitance:
        column = p.sweep.resistance_Ohm[v.branch] * all.col(2 + n + j);
        break;
    }
    column *= v.Slope(Entry(p, v));
  }
  kept.col(size()) = all.rightCols(1);
  if (!kept.allFinite()) return Eigen::MatrixXd::Constant(size() + 1, size() + 1, kNaN);
  return TriangularFactor(kept);
}

}  // namespace lipoid
