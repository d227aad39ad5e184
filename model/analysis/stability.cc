#include "model/analysis/stability.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <unsupported/Eigen/Polynomials>
#include <vector>

#include "model/core/special_values.h"
#include "model/statistics/factorizations.h"
#include "model/vehicle/battery_supply.h"

namespace lipoid {
namespace {

using Complex = std::complex<double>;
using Polynomial = Eigen::VectorXd;  // coefficients by rising powers of s

Polynomial Make(std::initializer_list<double> coefficients) {
  Polynomial p(Eigen::Index(coefficients.size()));
  std::copy(coefficients.begin(), coefficients.end(), p.begin());
  return p;
}

Polynomial Product(const Polynomial& a, const Polynomial& b) {
  Polynomial product = Polynomial::Zero(a.size() + b.size() - 1);
  for (Eigen::Index k = 0; k < a.size(); ++k) product.segment(k, b.size()) += a[k] * b;
  return product;
}

Polynomial Sum(const Polynomial& a, const Polynomial& b) {
  Polynomial sum = Polynomial::Zero(std::max(a.size(), b.size()));
  sum.head(a.size()) += a;
  sum.head(b.size()) += b;
  return sum;
}

// Poles by falling real part. The unit of s is chosen so that first and last coefficient are alike.
Poles Roots(Polynomial p) {
  Eigen::Index degree = p.size() - 1;
  while (degree > 0 && p[degree] == 0.0) --degree;
  p.conservativeResize(degree + 1);
  Poles poles;
  if (degree < 1) return poles;
  if (p[0] == 0.0) {  // a pole at 0, exactly
    poles = Roots(p.tail(degree));
    poles.emplace_back(0.0, 0.0);
  } else {
    const double unit = std::pow(std::abs(p[0] / p[degree]), 1.0 / double(degree));
    double power = 1.0;
    for (Eigen::Index k = 0; k <= degree; ++k, power *= unit) p[k] *= power;
    p /= p[degree];
    for (const Complex& root : RootsOf(p)) poles.push_back(unit * root);
  }
  std::sort(poles.begin(), poles.end(), [](const Complex& a, const Complex& b) {
    return a.real() != b.real() ? a.real() > b.real() : a.imag() < b.imag();
  });
  return poles;
}

// Whether all roots have negative real parts, by Routh's array: found roots are only as near to the axis as
// their largest allows, and slow ones are nearer.
bool IsHurwitz(const Polynomial& p) {
  std::vector<double> a(p.begin(), p.end());  // by falling powers
  while (a.size() > 1 && a.back() == 0.0) a.pop_back();
  std::reverse(a.begin(), a.end());
  for (std::size_t row = 1; row < a.size(); ++row) {
    if (!(a[row] > 0.0)) return false;
    const double ratio = a[row - 1] / a[row];
    for (std::size_t k = row + 1; k + 1 < a.size(); k += 2) a[k] -= ratio * a[k + 1];
  }
  return true;
}

// One axis: s³/(kappa G) and P, both without a factor s where there is no integral gain.
struct Axis {
  Polynomial inertia;  // s³ (lag s + 1)(T/2 s + 1)/kappa
  Polynomial control;  // P
  Polynomial cubed;    // s³

  Axis(const AxisResponse& response, const ErrorGains& gains, double lag_s, double hold_s) {
    const bool integral = gains.integral > 0.0;
    control = integral ? Make({gains.integral, gains.proportional, gains.derivative})
                       : Make({gains.proportional, gains.derivative});
    cubed = integral ? Make({0.0, 0.0, 0.0, 1.0}) : Make({0.0, 0.0, 1.0});
    inertia =
        Product(cubed, Product(Make({1.0, lag_s}), Make({1.0, hold_s}))) * (1.0 / response.kappa);
  }
  [[nodiscard]] Polynomial Characteristic() const { return Sum(inertia, control); }
};

// A loop that is cut somewhere: closed, its poles are the roots of numerator + denominator.
struct OpenLoop {
  Polynomial numerator;
  Polynomial denominator;

  [[nodiscard]] Polynomial Characteristic() const { return Sum(numerator, denominator); }
  [[nodiscard]] Complex At(double omega) const {
    const Complex s(0.0, omega);
    return Eigen::poly_eval(numerator, s) / Eigen::poly_eval(denominator, s);
  }
};

OpenLoop OfAxis(const Axis& axis) { return {axis.control, axis.inertia}; }

OpenLoop OfPosition(const Axis& attitude,
                    const PositionGains& gains,
                    double omega_rad_per_s,
                    double damping) {
  const double square = omega_rad_per_s * omega_rad_per_s;
  const Polynomial filter = Make({square, 2.0 * damping * omega_rad_per_s, 1.0});
  const Polynomial control =
      Make({gains.proportional_rad_per_m, gains.derivative_rad_s_per_m}) * kGravity_m_per_s2;
  return {Product(Sum(attitude.cubed, attitude.control), control) * square,
          Product(Product(Make({0.0, 0.0, 1.0}), attitude.Characteristic()), filter)};
}

// The frequency in between at which a function of it passes zero.
template <class Function>
double Crossing(double low, double high, Function&& f) {
  const bool rising = f(low) < 0.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::sqrt(low * high);
    ((f(middle) < 0.0) == rising ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

void Margins(const OpenLoop& loop, LoopStability& result) {
  constexpr double kSlowest_rad_per_s = 1e-4;
  constexpr double kFastest_rad_per_s = 1e4;
  constexpr double kStep = 1.01;
  result.gain_margin_up = std::numeric_limits<double>::infinity();
  result.gain_margin_down = 0.0;
  result.phase_margin_deg = kNaN;
  const auto excess = [&](double omega) { return std::abs(loop.At(omega)) - 1.0; };
  const auto across = [&](double omega) { return loop.At(omega).imag(); };
  for (double omega = kSlowest_rad_per_s; omega < kFastest_rad_per_s; omega *= kStep) {
    const double next = omega * kStep;
    if ((excess(omega) < 0.0) != (excess(next) < 0.0)) {
      const Complex there = loop.At(Crossing(omega, next, excess));
      const double margin = std::abs(std::arg(-there)) * 180.0 / std::numbers::pi;
      // The least; the first replaces NaN.
      if (!(result.phase_margin_deg <= margin)) result.phase_margin_deg = margin;
    }
    if ((across(omega) < 0.0) != (across(next) < 0.0)) {
      const Complex there = loop.At(Crossing(omega, next, across));
      if (there.real() >= 0.0) continue;
      const double factor = 1.0 / std::abs(there);
      if (factor > 1.0) {
        result.gain_margin_up = std::min(result.gain_margin_up, factor);
      } else {
        result.gain_margin_down = std::max(result.gain_margin_down, factor);
      }
    }
  }
}

LoopStability Judge(std::string_view name, const OpenLoop& flown, const OpenLoop& quasistatic) {
  LoopStability result{};
  result.loop = name;
  result.damping = 1.0;
  result.frequency_rad_per_s = kNaN;
  const Poles poles = Roots(flown.Characteristic());
  result.pole = poles.empty() ? Complex(0.0, 0.0) : poles.front();
  const Poles still = Roots(quasistatic.Characteristic());
  result.quasistatic_per_s = still.empty() ? 0.0 : still.front().real();
  for (const Complex& pole : poles) {
    const double damping = -pole.real() / std::abs(pole);
    if (pole.imag() == 0.0 || damping >= result.damping) continue;
    result.damping = damping;
    result.frequency_rad_per_s = std::abs(pole);
  }
  result.decays = IsHurwitz(flown.Characteristic()) && IsHurwitz(quasistatic.Characteristic());
  if (result.stable()) {
    Margins(flown, result);
  } else {
    result.gain_margin_up = result.gain_margin_down = result.phase_margin_deg = kNaN;
  }
  return result;
}

std::string Times(double xi, std::string_view when) {
  return fmt::format("at xi = {:.3g} ({})", xi, when);
}

// Of the hovers that have this loop, the one at which `measure` is least.
template <class Measure>
std::pair<const HoverStability*, const LoopStability*> Worst(std::span<const HoverStability> hovers,
                                                             std::string_view name,
                                                             Measure&& measure) {
  std::pair<const HoverStability*, const LoopStability*> worst{nullptr, nullptr};
  for (const HoverStability& hover : hovers) {
    for (const LoopStability& loop : hover.loops) {
      if (loop.loop != name) continue;
      if (worst.second == nullptr || measure(loop) < measure(*worst.second))
        worst = {&hover, &loop};
    }
  }
  return worst;
}

std::string Unstable(const HoverStability& hover, const LoopStability& loop) {
  std::string text =
      fmt::format("the {} loop is unstable {}: ", loop.loop, Times(hover.xi, hover.when));
  const double growth_per_s = std::max(loop.pole.real(), loop.quasistatic_per_s);
  if (loop.pole == 0.0 || growth_per_s == 0.0)
    return text + "nothing brings it back, as its K_e is 0";
  if (growth_per_s < 0.0) return text + "its error does not decay";  // by rounding
  text += fmt::format("its error doubles every {:.3g} s", std::numbers::ln2 / growth_per_s);
  if (loop.pole.real() > 0.0 && loop.pole.imag() != 0.0)
    text += fmt::format(", swinging at {:.3g} rad/s", std::abs(loop.pole));
  return text;
}

}  // namespace

bool HoverStability::stable() const {
  return std::all_of(
      loops.begin(), loops.end(), [](const LoopStability& loop) { return loop.stable(); });
}

Growth GrowthOf(const AxisResponse& response, const ErrorGains& gains) {
  const Polynomial p = Axis(response, gains, response.lag_s, 0.5 * kControlStep_s).Characteristic();
  const Complex pole = Roots(p).front();
  Polynomial slope(p.size() - 1);
  for (Eigen::Index k = 1; k < p.size(); ++k) slope[k - 1] = double(k) * p[k];
  // p(s) = 0 with p linear in each gain: ds/dK = -(dp/dK)/p'(s).
  const bool integral = gains.integral > 0.0;
  const Complex per_lowest = -1.0 / Eigen::poly_eval(slope, pole);
  const auto real = [](const Complex& value) { return value.real(); };
  if (integral) {
    return {pole.real(),
            {.proportional = real(per_lowest * pole),
             .integral = real(per_lowest),
             .derivative = real(per_lowest * pole * pole)}};
  }
  // One factor s less; what a first integral gain does to a pole at 0 has no slope.
  return {pole.real(),
          {.proportional = real(per_lowest),
           .integral = pole == 0.0 ? 0.0 : real(per_lowest / pole),
           .derivative = real(per_lowest * pole)}};
}

std::vector<LoopStability> CheckLoops(const Vehicle& vehicle,
                                      const Gains& gains,
                                      const ControllerOptions& controller,
                                      bool motor_lag,
                                      const HoverPoint& hover) {
  const HoverResponse response = ResponseAtHover(vehicle, hover);
  const auto flown = [&](const AxisResponse& axis, const ErrorGains& own) {
    return Axis(axis, own, motor_lag ? axis.lag_s : 0.0, 0.5 * kControlStep_s);
  };
  const auto still = [](const AxisResponse& axis, const ErrorGains& own) {
    return Axis(axis, own, 0.0, 0.0);
  };
  std::vector<LoopStability> loops;
  const auto judge = [&](std::string_view name, const AxisResponse& axis, const ErrorGains& own) {
    loops.push_back(Judge(name, OfAxis(flown(axis, own)), OfAxis(still(axis, own))));
  };
  judge("altitude", response.altitude, gains.altitude);
  judge("attitude", response.pitch, gains.attitude);
  judge("yaw", response.yaw, gains.yaw);
  if (gains.position.proportional_rad_per_m > 0.0 || gains.position.derivative_rad_s_per_m > 0.0) {
    const auto position = [&](const Axis& attitude) {
      return OfPosition(attitude,
                        gains.position,
                        ReferencesOf(gains.references, controller).attitude_rad_per_s,
                        controller.attitude_damping);
    };
    loops.push_back(Judge("position",
                          position(flown(response.pitch, gains.attitude)),
                          position(still(response.pitch, gains.attitude))));
  }
  return loops;
}

std::vector<HoverStability> CheckFlightLoops(const FlightSetup& setup) {
  const Vehicle& vehicle = setup.vehicle;
  const bool compensate = setup.controller.compensate;
  const ControllerOptions controller = FlownController(setup);
  std::vector<HoverStability> hovers;
  const auto check = [&](std::string_view when, const Supply<double>& supply) {
    const double battery_V = HoverTrim(vehicle, supply).battery_V;
    // Commands that are compensated see to it that a voltage which sags is none.
    const HoverPoint hover = compensate ? HoverPoint{{battery_V, 0.0}, battery_V}
                                        : HoverPoint{supply, vehicle.nominal_voltage_V};
    hovers.push_back(
        {when,
         battery_V / vehicle.nominal_voltage_V,
         CheckLoops(vehicle, setup.gains, controller, setup.simulation.motor_lag, hover)});
  };
  if (!setup.cell) {
    const HoverPoint hover = HoverAt(vehicle, setup.xi);
    if (HoverTrim(vehicle, hover.supply).possible()) check("take-off", hover.supply);
    return hovers;
  }
  BatterySupply battery(*setup.cell, setup.initial_soc, setup.ambient_degC);
  const Trim trim = HoverTrim(vehicle, battery, compensate);
  if (!trim.possible()) return hovers;
  const Supply<double> full = battery.Linearize();
  check("take-off", full);
  const double lowest_V = std::max({battery.cutoff_V(), setup.land_below_V, trim.motor_V});
  if (lowest_V >= trim.battery_V) return hovers;
  const double drop_V =
      full.resistance_Ohm * trim.battery_A * trim.battery_V / lowest_V;  // of the same power
  // A battery whose resistance takes more than half of its voltage gives no such power.
  check("lowest voltage allowed",
        drop_V < lowest_V ? Supply<double>{lowest_V + drop_V, full.resistance_Ohm}
                          : Supply<double>{lowest_V, 0.0});
  return hovers;
}

std::vector<std::string> StabilityWarnings(std::span<const HoverStability> hovers) {
  std::vector<std::string> unstable;
  std::vector<std::string> ringing;
  for (const std::string_view name : {"altitude", "attitude", "yaw", "position"}) {
    const auto [fastest_hover, fastest] =
        Worst(hovers, name, [](const LoopStability& loop) -> double {
          return -std::max(loop.pole.real(), loop.quasistatic_per_s);
        });
    if (fastest == nullptr) continue;
    if (!fastest->stable()) {
      unstable.push_back(Unstable(*fastest_hover, *fastest));
      continue;
    }
    const auto [hover, loop] =
        Worst(hovers, name, [](const LoopStability& l) { return l.damping; });
    if (!loop->rings()) continue;
    ringing.push_back(fmt::format("the {} loop rings at {:.3g} rad/s, damping {:.2g}, {}",
                                  name,
                                  loop->frequency_rad_per_s,
                                  loop->damping,
                                  Times(hover->xi, hover->when)));
  }
  unstable.insert(unstable.end(), ringing.begin(), ringing.end());
  return unstable;
}

Json StabilityToJson(std::span<const HoverStability> hovers) {
  Json rows = Json::array();
  for (const HoverStability& hover : hovers) {
    for (const LoopStability& loop : hover.loops) {
      rows.push_back({{"loop", loop.loop},
                      {"when", hover.when},
                      {"xi", hover.xi},
                      {"stable", loop.stable()},
                      {"pole_per_s", {loop.pole.real(), loop.pole.imag()}},
                      {"quasistatic_per_s", loop.quasistatic_per_s},
                      {"frequency_rad_per_s", NumberOrNull(loop.frequency_rad_per_s)},
                      {"damping", loop.damping},
                      {"gain_margin_up", NumberOrNull(loop.gain_margin_up)},
                      {"gain_margin_down", NumberOrNull(loop.gain_margin_down)},
                      {"phase_margin_deg", NumberOrNull(loop.phase_margin_deg)}});
    }
  }
  return rows;
}

}  // namespace lipoid
