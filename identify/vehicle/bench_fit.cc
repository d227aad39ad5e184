#include "identify/vehicle/bench_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/statistics/factorizations.h"
#include "model/statistics/quantiles.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

// Unknowns: logarithms of what is positive, so that steps are relative; friction and switching as
// shares of a typical size, because they may be nothing.
enum Unknown {
  kThrust,
  kTorque,
  kConstant,
  kResistance,
  kFriction,
  kSwitching,
  kExponent,
  kUnknowns
};
constexpr std::size_t kChannels = 3;  // speed, current, thrust

using Values = std::array<double, kUnknowns>;

struct Scales {
  double friction;    // N m s: the whole torque of the fastest row over its speed
  double resistance;  // Ohm: the whole voltage of the fastest row over its current
  double switching = 0.01;
  std::optional<double> no_load_A_per_V;
  bool constant_given = false;
};

// A resistance that takes less of the voltage than this is none.
constexpr double kLeastDrop = 1e-3;
// One that takes more than half is no motor's: with neither KV nor small errors such an end may be as good.
constexpr double kMostDrop = 0.5;
// Of the logarithm of the exponent where no speed shows it: the tables of docs/vehicles.md have 0.91
// to 1.01.
constexpr double kUsualExponent = 0.05;
// Far beyond any; the search is held within, where its numbers are finite.
constexpr double kFarthestExponent = 3.0;

// A small reading is not measured to a small part of itself.
constexpr double kFloorShare = 0.02;

// The positive root of r k_N w² + (k_e² + r b) w = k_e V, without a difference of near numbers.
template <class T>
T HeldSpeed(const T& k_e, const T& k_N, const T& r, const T& b, const T& pulse_V) {
  using std::sqrt;
  const T slope = k_e * k_e + r * b;
  const T drive = k_e * pulse_V;
  return 2.0 * drive / (slope + sqrt(slope * slope + 4.0 * r * k_N * drive));  // (5.10)
}

template <class T>
T FrictionOf(const T* x, const Scales& scales) {
  using std::exp;
  if (scales.no_load_A_per_V) return exp(2.0 * x[kConstant]) * *scales.no_load_A_per_V;
  return x[kFriction] * scales.friction;
}

struct RowResidual {
  BenchRow row;
  std::array<double, kChannels> weight{};  // of a difference in SI units; 0: no such channel
  Scales scales;

  template <class T>
  bool operator()(const T* x, T* residual) const {
    using std::exp;
    const T k_T = exp(x[kThrust]);
    const T k_N = exp(x[kTorque]);
    const T k_e = exp(x[kConstant]);
    const T r = exp(x[kResistance]);
    const T b = FrictionOf(x, scales);
    const T throttle_duty = exp(exp(x[kExponent]) * std::log(row.throttle));
    const T throttle_speed = HeldSpeed(k_e, k_N, r, b, T(throttle_duty * row.voltage_V));
    residual[0] = weight[0] * (throttle_speed - row.speed_rad_per_s);
    const bool measured = weight[0] > 0.0;
    const T speed = measured ? T(row.speed_rad_per_s) : throttle_speed;
    const T motor_A = (b + k_N * speed) * speed / k_e;
    const T duty = measured ? T((k_e * speed + r * motor_A) / row.voltage_V) : throttle_duty;
    const double switching = row.throttle < 1.0 ? scales.switching : 0.0;
    const T battery_A = (duty + switching * x[kSwitching]) * motor_A;
    residual[1] = weight[1] * (battery_A - row.current_A);
    residual[2] = weight[2] * (k_T * speed * speed - row.thrust_N);
    return true;
  }
};

struct UsualExponent {
  template <class T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = x[kExponent] / kUsualExponent;
    return true;
  }
};

using RowCost = ceres::AutoDiffCostFunction<RowResidual, kChannels, kUnknowns>;

// Where the search starts: the motor constant as it is given or, from the fastest row, four fifths
// of its voltage; the rest from the fastest row alone.
struct Beginning {
  Values x{};
  Scales scales;
};
Beginning Start(const BenchTable& table, const BenchGiven& given) {
  const BenchRow& full =
      *std::max_element(table.rows.begin(), table.rows.end(), [](const auto& a, const auto& b) {
        return a.throttle * a.voltage_V < b.throttle * b.voltage_V;
      });
  const double pulse_V = full.throttle * full.voltage_V;
  const double motor_A = full.current_A / full.throttle;
  double constant = 0.0;
  double speed = full.speed_rad_per_s;
  if (given.motor_constant_N_m_per_A) {
    constant = *given.motor_constant_N_m_per_A;
    if (!table.has_speed) speed = 0.8 * pulse_V / constant;
  } else {
    constant = 0.8 * pulse_V / speed;
  }
  const Scales scales{.friction = constant * motor_A / speed,
                      .resistance = pulse_V / motor_A,
                      .no_load_A_per_V = given.no_load_A_per_V,
                      .constant_given = given.motor_constant_N_m_per_A.has_value()};
  const double drop = std::max(1.0 - constant * speed / pulse_V, 0.05);
  Values x{};
  x[kThrust] = std::log(full.thrust_N / (speed * speed));
  x[kTorque] = std::log(constant * motor_A / (speed * speed));
  x[kConstant] = std::log(constant);
  x[kResistance] = std::log(drop * scales.resistance);
  x[kFriction] = given.no_load_A_per_V ? 0.0 : 0.05;
  x[kSwitching] = given.switching ? 0.5 : 0.0;
  return {x, scales};
}

std::vector<RowResidual> Residuals(const BenchTable& table,
                                   const std::array<double, kChannels>& sigma,
                                   const Scales& scales) {
  std::array<double, kChannels> largest{};
  const auto of = [](const BenchRow& row) {
    return std::array{row.speed_rad_per_s, row.current_A, row.thrust_N};
  };
  for (const BenchRow& row : table.rows) {
    for (std::size_t k = 0; k < kChannels; ++k) largest[k] = std::max(largest[k], of(row)[k]);
  }
  std::vector<RowResidual> residuals;
  for (const BenchRow& row : table.rows) {
    RowResidual residual{row, {}, scales};
    for (std::size_t k = 0; k < kChannels; ++k) {
      if (k == 0 && !table.has_speed) continue;
      residual.weight[k] = 1.0 / (sigma[k] * (of(row)[k] + kFloorShare * largest[k]));
    }
    residuals.push_back(residual);
  }
  return residuals;
}

struct Solved {
  Values x;
  bool converged = false;
  std::string message;
  Eigen::MatrixXd jacobian;  // rows x free unknowns
  Eigen::VectorXd residual;  // weighted
};

// With no step, the slopes at x alone: of what is not held.
Solved Solve(const std::vector<RowResidual>& rows,
             Values x,
             const std::vector<int>& held,
             int most_steps = 500) {
  const Scales& scales = rows.front().scales;
  ceres::Problem problem;
  for (const RowResidual& row : rows) {
    problem.AddResidualBlock(new RowCost(new RowResidual(row)), nullptr, x.data());
  }
  if (rows.front().weight[0] == 0.0) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<UsualExponent, 1, kUnknowns>(new UsualExponent),
        nullptr,
        x.data());
  }
  if (!held.empty()) {
    problem.SetManifold(x.data(), new ceres::SubsetManifold(kUnknowns, held));
  }
  for (const int k : {kFriction, kSwitching}) problem.SetParameterLowerBound(x.data(), k, 0.0);
  problem.SetParameterUpperBound(x.data(), kFriction, kMostFriction);
  problem.SetParameterLowerBound(x.data(), kResistance, std::log(kLeastDrop * scales.resistance));
  if (!scales.constant_given)
    problem.SetParameterUpperBound(x.data(), kResistance, std::log(kMostDrop * scales.resistance));
  problem.SetParameterLowerBound(x.data(), kExponent, -kFarthestExponent);
  problem.SetParameterUpperBound(x.data(), kExponent, kFarthestExponent);
  ceres::Solver::Options options;
  options.max_num_iterations = most_steps;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Solved solved{x, summary.IsSolutionUsable(), summary.message, {}, {}};
  solved.converged = summary.termination_type == ceres::CONVERGENCE;
  std::vector<double> residuals;
  ceres::CRSMatrix matrix;
  problem.Evaluate({}, nullptr, &residuals, nullptr, &matrix);
  solved.residual = Eigen::Map<Eigen::VectorXd>(residuals.data(), Eigen::Index(residuals.size()));
  solved.jacobian = Eigen::MatrixXd::Zero(matrix.num_rows, matrix.num_cols);
  for (int row = 0; row < matrix.num_rows; ++row) {
    for (int at = matrix.rows[std::size_t(row)]; at < matrix.rows[std::size_t(row) + 1]; ++at) {
      solved.jacobian(row, matrix.cols[std::size_t(at)]) = matrix.values[std::size_t(at)];
    }
  }
  return solved;
}

// As many values as unknowns leave nothing from which their errors could be told.
void CheckOperatingPoints(const BenchTable& table, int channels, int unknowns) {
  constexpr double kSame = 0.01;  // relative, of the mean voltage at the motor
  std::vector<double> pulse_V;
  for (const BenchRow& row : table.rows) pulse_V.push_back(row.throttle * row.voltage_V);
  std::sort(pulse_V.begin(), pulse_V.end());
  int points = 1;
  for (double last_V = pulse_V.front(); const double next_V : pulse_V) {
    if (next_V <= (1.0 + kSame) * last_V) continue;
    last_V = next_V;
    ++points;
  }
  const int least = unknowns / channels + 1;
  if (points >= least) return;
  throw OptionError(fmt::format(
      "the bench table has {}, and a fit of {} numbers needs {}: give rows "
      "at other throttles, or leave --bench-table out and say what is known of motor and "
      "propeller",
      Counted(points, "operating point"),
      unknowns,
      least));
}

// Root mean squares of the relative residuals of each channel.
std::array<double, kChannels> Spread(const Solved& solved,
                                     const std::array<double, kChannels>& sigma,
                                     double rows,
                                     double freedom_share) {
  std::array<double, kChannels> spread{};
  for (Eigen::Index k = 0; k < Eigen::Index(rows) * Eigen::Index(kChannels); ++k) {
    spread[std::size_t(k) % kChannels] += solved.residual[k] * solved.residual[k];
  }
  for (std::size_t k = 0; k < kChannels; ++k) {
    spread[k] = sigma[k] * std::sqrt(spread[k] / (rows * freedom_share));
  }
  return spread;
}

// The share of each unknown in directions that change no residual.
Eigen::VectorXd HiddenShares(Eigen::MatrixXd slopes) {
  constexpr double kNone = 1e-9;  // of the steepest direction
  for (Eigen::Index k = 0; k < slopes.cols(); ++k) {
    const double norm = slopes.col(k).norm();
    if (norm > 0.0) slopes.col(k) /= norm;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(slopes, Eigen::ComputeFullV);
  Eigen::VectorXd hidden = Eigen::VectorXd::Zero(slopes.cols());
  for (Eigen::Index k = 0; k < slopes.cols(); ++k) {
    const bool shows = k < svd.singularValues().size() &&
                       svd.singularValues()[k] > kNone * svd.singularValues()[0];
    if (!shows) hidden += svd.matrixV().col(k).cwiseAbs2();
  }
  return hidden;
}

// A motor without resistance is the sign of a motor constant that is not the table's.
void RefuseNoResistance(const BenchTable& table,
                        const BenchGiven& given,
                        const Values& x,
                        const Scales& scales) {
  constexpr double kAtBound = 1e-3;
  if (x[kResistance] > std::log(kLeastDrop * scales.resistance) + kAtBound) return;
  throw OptionError(fmt::format(
      "the bench table leaves nothing for the resistance between battery and motor with "
      "a KV of {:.4g} rpm/V: {}",
      30.0 / std::numbers::pi / std::exp(x[kConstant]),
      !given.motor_constant_N_m_per_A
          ? "give the motor's with --kv-rpm-per-V, which this table does not tell"
      : table.has_speed ? "check --kv-rpm-per-V against the table's speeds and voltages"
                        : "check --kv-rpm-per-V, or give a table with a column of speeds"));
}

// Nor has a motor whose winding takes half of the voltage a KV that a table has told.
void RefuseNoConstant(const Values& x, const Scales& scales) {
  constexpr double kAtBound = 1e-3;
  if (scales.constant_given || x[kResistance] < std::log(kMostDrop * scales.resistance) - kAtBound)
    return;
  throw OptionError(
      "the bench table does not determine KV: its speeds and currents fit a motor as well whose resistance takes "
      "half of the voltage; give --kv-rpm-per-V");
}

// A controller's duty cycle is about its throttle: what is far from that was fitted to other columns.
void RefuseStrangeThrottle(const Values& x) {
  constexpr double kFar = 10.0;
  const double exponent = std::exp(x[kExponent]);
  if (exponent > 1.0 / kFar && exponent < kFar) return;
  throw OptionError(fmt::format(
      "the duty cycle would be the throttle of the bench table to the power of {:.3g}, where speed controllers have "
      "about 1: look whether the columns of throttle, voltage, current and speed hold what their headers say",
      exponent));
}

// No motor turns faster than its KV times the voltage: such speeds are in another unit.
void CheckSpeeds(const BenchTable& table, const BenchGiven& given) {
  constexpr double kMost = 1.5;  // KV as printed is good to a tenth
  for (const BenchRow& row : table.rows) {
    const double induced_V = *given.motor_constant_N_m_per_A * row.speed_rad_per_s;
    if (induced_V <= kMost * row.voltage_V) continue;
    throw OptionError(fmt::format(
        "--bench-table: a row has {:.4g} rad/s at {:.4g} V, for which a motor of this KV would need {:.4g} V: "
        "look whether the unit of the speeds is that of the header, and KV right",
        row.speed_rad_per_s,
        row.voltage_V,
        induced_V));
  }
}

// Nor does a propeller hold one at a tenth of it: such speeds are a thousand times too low, or of another motor.
void CheckSlowSpeeds(const BenchTable& table, const BenchGiven& given) {
  constexpr double kLeast = 0.1;  // of the mean voltage at the motor; 0.5 and more are usual
  double largest = 0.0;
  for (const BenchRow& row : table.rows) {
    largest = std::max(
        largest,
        *given.motor_constant_N_m_per_A * row.speed_rad_per_s / (row.throttle * row.voltage_V));
  }
  if (largest > kLeast) return;
  throw OptionError(fmt::format(
      "--bench-table: its speeds are at most {:.2g} % of what a motor of this KV turns at without load, "
      "and with a propeller more than half is usual: look whether the unit of the speeds is that of the "
      "header, whether they have dots for thousands (5.688 for 5688), and whether KV is right",
      100.0 * largest));
}

// A table of a propeller reaches higher: these are fractions of full throttle under a header of per cent.
void CheckThrottles(const BenchTable& table) {
  constexpr double kNone = 0.015;
  double largest = 0.0;
  for (const BenchRow& row : table.rows) largest = std::max(largest, row.throttle);
  if (largest > kNone) return;
  throw OptionError(fmt::format(
      "--bench-table: the largest throttle is {:.3g} %, at which no propeller is measured: look whether the column "
      "holds fractions (0 .. 1) under a header of per cent",
      100.0 * largest));
}

}  // namespace

std::vector<BenchQuantity> BenchFit::Quantities() const {
  return {thrust_coefficient_N_s2,
          torque_coefficient_N_m_s2,
          motor_constant_N_m_per_A,
          resistance_Ohm,
          friction_N_m_s,
          switching_share,
          throttle_exponent};
}

BenchFit FitBenchTable(const BenchTable& table, const BenchGiven& given) {
  if (!table.has_speed && !given.motor_constant_N_m_per_A) {
    throw OptionError(
        "a bench table without a column of speeds does not say how fast the propeller turns: give "
        "the motor's constant (--kv-rpm-per-V)");
  }
  CheckThrottles(table);
  if (table.has_speed && given.motor_constant_N_m_per_A) {
    CheckSpeeds(table, given);
    CheckSlowSpeeds(table, given);
  }
  Beginning beginning = Start(table, given);
  const Scales& scales = beginning.scales;
  std::vector<int> held;  // first what is given, then what is at its bound
  if (given.motor_constant_N_m_per_A) held.push_back(kConstant);
  if (given.no_load_A_per_V) held.push_back(kFriction);
  // Nothing switches at full throttle, and any power of 1 is 1.
  const bool full_throttle = std::all_of(table.rows.begin(),
                                         table.rows.end(),
                                         [](const BenchRow& row) { return row.throttle == 1.0; });
  const bool switching = given.switching && !full_throttle;
  if (!switching) held.push_back(kSwitching);
  if (full_throttle) held.push_back(kExponent);
  const std::vector<int> known = held;

  const double rows = double(table.rows.size());
  const double channels = table.has_speed ? 3.0 : 2.0;
  // Without speeds the exponent comes with a value of its own.
  const bool usual_exponent = !table.has_speed && !full_throttle;
  const double values = channels * rows + (usual_exponent ? 1.0 : 0.0);
  CheckOperatingPoints(
      table, int(channels), int(kUnknowns) - int(held.size()) - (usual_exponent ? 1 : 0));
  std::array<double, kChannels> sigma{0.01, 0.01, 0.01};
  constexpr double kLeastSigma = 1e-6;  // a table that fits to the last digit
  if (!switching) beginning.x[kSwitching] = 0.0;
  Solved solved{beginning.x, false, {}, {}, {}};
  bool friction_at_most = false;
  double freedom = 1.0;
  constexpr int kRounds = 20;  // of weights that follow the residuals
  for (int round = 0; round < kRounds; ++round) {
    // What lies on its bound is held there from now on; beside the exponent's own value only until other weights, against
    // which that one counts less, may lead away from it.
    if (usual_exponent) {
      held = known;
      friction_at_most = false;
    }
    solved = Solve(Residuals(table, sigma, scales), solved.x, held);
    constexpr double kAtBound = 1e-6;
    for (const int k : {kFriction, kSwitching}) {
      if (std::find(held.begin(), held.end(), k) != held.end()) continue;
      double& x = solved.x[std::size_t(k)];
      const bool most = k == kFriction && x > kMostFriction - kAtBound;
      if (!most && x >= kAtBound) continue;
      x = most ? kMostFriction : 0.0;
      friction_at_most |= most;
      held.push_back(k);
    }
    freedom = std::max(values - double(kUnknowns - int(held.size())), 1.0);
    const auto spread = Spread(solved, sigma, rows, freedom / values);
    double change = 0.0;
    for (std::size_t k = 0; k < kChannels; ++k) {
      if (k == 0 && !table.has_speed) continue;
      const double next = std::max(spread[k], kLeastSigma);
      change = std::max(change, std::abs(std::log(next / sigma[k])));
      sigma[k] = next;
    }
    if (change < 1e-3) break;
  }
  solved = Solve(Residuals(table, sigma, scales), solved.x, held);
  RefuseStrangeThrottle(solved.x);
  RefuseNoResistance(table, given, solved.x, scales);
  RefuseNoConstant(solved.x, scales);

  BenchFit fit;
  fit.has_speed = table.has_speed;
  fit.friction_at_most = friction_at_most;
  fit.full_throttle = full_throttle;
  fit.converged = solved.converged;
  fit.message = solved.message;
  fit.degrees_of_freedom = freedom;
  const auto spread = Spread(solved, sigma, rows, freedom / values);
  fit.speed_rms = table.has_speed ? spread[0] : 0.0;
  fit.current_rms = spread[1];
  fit.thrust_rms = spread[2];

  // What is held at its bound is not known for it: the others are as uncertain as if it were free. The truth is
  // on the inner side, and nearer to the bound than to where the free fit would be.
  const bool bound = held.size() > known.size();
  const Eigen::MatrixXd slopes =
      bound ? Solve(Residuals(table, sigma, scales), solved.x, known, 0).jacobian : solved.jacobian;
  std::vector<Eigen::Index> place(kUnknowns, -1);
  Eigen::Index next = 0;
  for (int k = 0; k < kUnknowns; ++k) {
    if (std::find(known.begin(), known.end(), k) == known.end()) place[std::size_t(k)] = next++;
  }
  const Eigen::MatrixXd information = slopes.transpose() * slopes;
  const Eigen::MatrixXd covariance = PseudoInverse(information);
  // The error of a channel is known from its own residuals alone.
  const double reach = Reach95(std::max(freedom / channels, 1.0));
  const Eigen::VectorXd hidden = HiddenShares(slopes);
  constexpr double kHidden = 0.01;
  const auto error = [&](int k) {
    const Eigen::Index at = place[std::size_t(k)];
    if (at < 0) return 0.0;
    if (hidden[at] > kHidden) return std::numeric_limits<double>::quiet_NaN();
    return std::sqrt(std::max(covariance(at, at), 0.0));
  };
  const auto positive = [&](const char* name, int k) {
    const double estimate = std::exp(solved.x[std::size_t(k)]);
    const double relative = error(k);
    return BenchQuantity{name,
                         estimate,
                         estimate * relative,
                         estimate * std::exp(-reach * relative),
                         estimate * std::exp(reach * relative),
                         place[std::size_t(k)] >= 0};
  };
  const auto linear = [&](const char* name, int k, double scale, bool is_given) {
    const double estimate = scale * solved.x[std::size_t(k)];
    // At its bound it has no error that the slopes could tell.
    const bool at_bound = !is_given && std::find(held.begin(), held.end(), k) != held.end();
    const double deviation = at_bound ? std::numeric_limits<double>::quiet_NaN() : scale * error(k);
    return BenchQuantity{name,
                         estimate,
                         deviation,
                         at_bound ? deviation : std::max(estimate - reach * deviation, 0.0),
                         estimate + reach * deviation,
                         !is_given};
  };
  fit.thrust_coefficient_N_s2 = positive("thrust_coefficient_N_s2", kThrust);
  fit.torque_coefficient_N_m_s2 = positive("torque_coefficient_N_m_s2", kTorque);
  fit.motor_constant_N_m_per_A = positive("motor_constant_N_m_per_A", kConstant);
  fit.resistance_Ohm = positive("armature_resistance_Ohm", kResistance);
  fit.friction_N_m_s =
      linear("friction_N_m_s", kFriction, scales.friction, given.no_load_A_per_V.has_value());
  if (given.no_load_A_per_V) {
    BenchQuantity& b = fit.friction_N_m_s;
    b.estimate = b.low_95 = b.high_95 = FrictionOf(solved.x.data(), scales);
  }
  fit.switching_share = linear("switching_share", kSwitching, scales.switching, !switching);
  fit.throttle_exponent = positive("throttle_exponent", kExponent);
  return fit;
}

}  // namespace lipoid
