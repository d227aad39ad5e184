#include "identify/health/flight_model.h"

#include <ceres/jet.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "model/battery/record_stepper.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;
using Jet = ceres::Jet<double, U::kCount>;

template <class T>
std::vector<T> As(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

template <class T>
Resistance<T> Scaled(const Resistance<double>& resistance, const T& factor) {
  Resistance<T> scaled;
  scaled.soc = resistance.soc;
  scaled.resistance_Ohm.clear();
  for (const double value_Ohm : resistance.resistance_Ohm)
    scaled.resistance_Ohm.push_back(factor * value_Ohm);
  return scaled;
}

// The reference with the unknowns in it.
template <class T>
CellParameters<T> WithUnknowns(const CellParameters<double>& p, const std::vector<T>& x) {
  using std::exp;
  const T series = exp(x[U::kSeries]);
  const T branches = exp(x[U::kBranches]);
  const T slower = exp(x[U::kTau]);
  CellParameters<T> q;
  q.alpha_C = p.alpha_C * exp(x[U::kCapacity]);
  q.diffusion = p.diffusion;
  q.beta_per_sqrt_s = p.beta_per_sqrt_s * exp(x[U::kBeta]);
  q.terms = p.terms;
  q.tail = p.tail;
  q.series_resistance_Ohm = Scaled(p.series_resistance_Ohm, series);
  for (const auto& branch : p.branches)
    q.branches.push_back(
        {Scaled(branch.resistance_Ohm, branches), slower * branch.time_constant_s});
  q.open_circuit_voltage = p.open_circuit_voltage;
  if (p.self_heating) {
    q.self_heating = SelfHeating<T>{T(p.self_heating->time_constant_s),
                                    series * p.self_heating->resistance_drop_Ohm_per_A2};
  }
  if (p.charge_transfer) {
    q.charge_transfer = ChargeTransfer<T>{T(p.charge_transfer->current_A),
                                          Scaled(p.charge_transfer->resistance_Ohm, series)};
  }
  if (p.temperature) {
    const auto& t = *p.temperature;
    auto& term = q.temperature.emplace();
    term.reference_K = t.reference_K;
    term.series_J_per_mol = T(t.series_J_per_mol);
    term.branches_J_per_mol = As<T>(t.branches_J_per_mol);
    term.diffusion_J_per_mol = T(t.diffusion_J_per_mol);
    term.charge_transfer_J_per_mol = T(t.charge_transfer_J_per_mol);
    if (t.heat) {
      term.heat = HeatBalance<T>{t.heat->heat_capacity_J_per_K * exp(-x[U::kWarming]),
                                 t.heat->thermal_resistance_K_per_W * exp(x[U::kWarming])};
    }
    if (t.entropy) {
      auto& entropy = term.entropy.emplace();
      entropy.soc = t.entropy->soc;
      entropy.slope_V_per_K = As<T>(t.entropy->slope_V_per_K);
      entropy.reversible_heat = t.entropy->reversible_heat;
    }
  }
  if (p.hysteresis) {
    auto& hysteresis = q.hysteresis.emplace();
    hysteresis.folds = T(p.hysteresis->folds);
    hysteresis.soc = p.hysteresis->soc;
    hysteresis.half_V = As<T>(p.hysteresis->half_V);
  }
  return q;
}

template <class T>
typename CellModel<T>::State StartOf(const CellModel<T>& model,
                                     const std::vector<T>& x,
                                     double mean_A,
                                     const Surroundings& among) {
  auto state = model.Relaxed(x[U::kStart]);
  const auto& p = model.parameters();
  const T share_A = x[U::kBefore] * mean_A;
  for (std::size_t m = 0; m < state.unavailable_C.size(); ++m) {
    const auto place = static_cast<double>(m + 1);
    state.unavailable_C[m] =
        share_A / (place * place * p.beta_per_sqrt_s * p.beta_per_sqrt_s);  // (4.46), settled
  }
  for (std::size_t j = 0; j < state.branch_V.size(); ++j)
    state.branch_V[j] = share_A * p.branches[j].resistance_Ohm(x[U::kStart]);
  if (p.temperature) {
    const double reference_degC = p.temperature->reference_K - kZeroCelsius_K;
    const double ambient_degC = among.ambient_degC.value_or(reference_degC);
    const double first_degC = !among.measured_degC.empty()
                                  ? among.measured_degC[0]
                                  : among.initial_degC.value_or(ambient_degC);
    state.temperature_K = T(first_degC + kZeroCelsius_K);
    if (among.measured_degC.empty()) state.ambient_K = T(ambient_degC + kZeroCelsius_K);
  }
  return state;
}

// visit(k, soc, voltage) at every row. Where `flowed_A` has rows, the current of a row is that of its instant alone,
// and since the row before flowed_A flowed and, where there is any, more_A.
template <class T, class Visit>
void Walk(const CellParameters<double>& parameters,
          const std::vector<T>& x,
          const Record& record,
          const FlownCurrent& flown,
          const Surroundings& among,
          const Eigen::VectorXd* more_A,
          Visit&& visit) {
  const CellModel<T> model(WithUnknowns(parameters, x));
  const bool apart = !flown.since_A.empty();
  RecordStepper<T> stepper(
      model, apart ? Hold::kForward : record.hold, StartOf(model, x, flown.mean_A, among));
  const auto corrected = [&](double shown_A) {
    return (T(1.0) + x[U::kScale]) * (T(shown_A) - x[U::kOffset_A]);
  };
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (apart && k > 0) {
      const double more = more_A == nullptr ? 0.0 : (*more_A)[static_cast<Eigen::Index>(k)];
      stepper.SetFlowing(corrected(flown.since_A[k] + more));
    }
    if (among.measured_degC.empty()) {
      stepper.Row(record.time_s[k], corrected(record.current_A[k]));
    } else {
      stepper.Row(record.time_s[k],
                  corrected(record.current_A[k]),
                  T(among.measured_degC[k] + kZeroCelsius_K));
    }
    visit(k, stepper.Soc(), stepper.Voltage());
  }
}

struct CurveShare {
  int lower;
  double upper_share;
};
CurveShare ShareOf(double soc) {
  const double place = std::clamp(soc, 0.0, 1.0) * (kCurveNodes - 1);
  const int lower = std::min(static_cast<int>(place), kCurveNodes - 2);
  return {lower, place - lower};
}

}  // namespace

FlightModel::FlightModel(const ReferenceCell& reference,
                         const Record& record,
                         const Surroundings& among,
                         const Column& flowed_A)
    : reference_(reference), record_(record), among_(among), flown_{flowed_A, 0.0} {
  const ReferenceSpread& spread = reference.spread;
  const double kinks = spread.kinks_V > 0.0 ? spread.kinks_V / spread.curve_V : 0.0;
  Eigen::MatrixXd covariance(kCurveNodes, kCurveNodes);  // in curve_V
  for (int a = 0; a < kCurveNodes; ++a) {
    for (int b = 0; b < kCurveNodes; ++b) {
      const auto over = [apart = (a - b) / (kCurveNodes - 1.0)](double length) {
        return std::exp(-0.5 * apart * apart / (length * length));
      };
      covariance(a, b) = over(spread.curve_length) + kinks * kinks * over(kKinksLength);
    }
    covariance(a, a) += 1e-6;
  }
  curve_ = spread.curve_V * Eigen::MatrixXd(covariance.llt().matrixL());
  double charge_C = 0.0;
  for (std::size_t k = 1; k < record.size(); ++k)
    charge_C += record.current_A[k] * (record.time_s[k] - record.time_s[k - 1]);
  if (record.size() > 1) flown_.mean_A = charge_C / (record.time_s.back() - record.time_s.front());
}

FlightPrediction FlightModel::Predict(const Eigen::VectorXd& unknowns) const {
  std::vector<Jet> x;
  for (int u = 0; u < U::kCount; ++u) x.emplace_back(unknowns[u], u);
  const Eigen::VectorXd nodes_V = curve_ * unknowns.segment(U::kCount, kCurveNodes);
  const auto rows = static_cast<Eigen::Index>(record_.size());
  FlightPrediction out{Eigen::VectorXd(rows), Eigen::MatrixXd(rows, size())};
  Walk(reference_.cell.Parameters(),
       x,
       record_,
       flown_,
       among_,
       nullptr,
       [&](std::size_t row, const Jet& soc, const Jet& voltage_V) {
         const auto k = static_cast<Eigen::Index>(row);
         const auto [lower, share] = ShareOf(soc.a);
         const double rise_V = nodes_V[lower + 1] - nodes_V[lower];
         const bool within = soc.a > 0.0 && soc.a < 1.0;
         out.voltage_V[k] = voltage_V.a + nodes_V[lower] + share * rise_V;
         const double curve_slope_V = within ? rise_V * (kCurveNodes - 1) : 0.0;
         out.slope.row(k).head(U::kCount) = (voltage_V.v + curve_slope_V * soc.v).transpose();
         out.slope.row(k).tail(kCurveNodes) =
             (1.0 - share) * curve_.row(lower) + share * curve_.row(lower + 1);
       });
  return out;
}

Eigen::VectorXd FlightModel::VoltageOf(const Cell& cell,
                                       const Eigen::VectorXd& unknowns,
                                       const Eigen::VectorXd* more_A) const {
  const std::vector<double> x(unknowns.data(), unknowns.data() + U::kCount);
  Eigen::VectorXd voltage_V(static_cast<Eigen::Index>(record_.size()));
  Walk(cell.Parameters(), x, record_, flown_, among_, more_A, [&](std::size_t k, double, double v) {
    voltage_V[static_cast<Eigen::Index>(k)] = v;
  });
  return voltage_V;
}

Eigen::VectorXd FlightModel::VoltageWith(const Eigen::VectorXd& unknowns,
                                         const Eigen::VectorXd& more_A) const {
  return VoltageOf(reference_.cell, unknowns, &more_A);
}

ResistanceAt FlightModel::StepResistance(const Eigen::VectorXd& unknowns,
                                         double soc,
                                         double current_A,
                                         double settle_s) const {
  std::vector<Jet> x;
  for (int u = 0; u < U::kCount; ++u) x.emplace_back(unknowns[u], u);
  const CellModel<Jet> model(WithUnknowns(reference_.cell.Parameters(), x));
  auto rest = model.Relaxed(Jet(soc));
  if (reference_.cell.temperature)
    rest.temperature_K = Jet(reference_.cell.temperature->reference_K);
  const Jet before_V = model.Voltage(rest, Jet(0.0));
  for (std::size_t j = 0; j < rest.branch_V.size(); ++j) {
    const auto& branch = model.parameters().branches[j];
    const double usual_s = reference_.cell.branches[j].time_constant_s;
    if (usual_s > settle_s) continue;
    Jet settled(1.0);  // (4.50)
    if (usual_s > 0.0) settled -= exp(-settle_s / branch.time_constant_s);
    rest.branch_V[j] = settled * branch.resistance_Ohm(Jet(soc)) * current_A;
  }
  const Jet drop_V = before_V - model.Voltage(rest, Jet(current_A));
  ResistanceAt at{drop_V.a / current_A, Eigen::VectorXd::Zero(size())};
  at.slope.head(U::kCount) = drop_V.v / drop_V.a;
  return at;
}

double FlightModel::GrowthOfDrop(const Eigen::VectorXd& unknowns,
                                 double soc,
                                 double current_A,
                                 double held_s) const {
  const std::vector<double> x(unknowns.data(), unknowns.data() + U::kCount);
  const CellModel<double> model(WithUnknowns(reference_.cell.Parameters(), x));
  auto state = model.Relaxed(soc);
  const double rest_V = model.Voltage(state, 0.0);
  const double at_once_V = rest_V - model.Voltage(state, current_A);
  model.Advance(state, current_A, model.MakeStep(held_s));
  return (rest_V - model.Voltage(state, current_A)) / at_once_V - 1.0;
}

}  // namespace lipoid
