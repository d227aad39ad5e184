#pragma once

/// @file
/// Constant wind with Dryden gusts, MIL-F-8785C in its form for low altitude (below 1000 ft).
///
/// With h the altitude in feet and W20 the wind speed 20 ft above the ground,
///
///   L_w = h,       L_u = L_v = h/(0.177 + 0.000823 h)^1.2      (feet)
///   sigma_w = 0.1 W20,   sigma_u = sigma_v = sigma_w/(0.177 + 0.000823 h)^0.4
///
///   Phi_u  = 2 sigma² L/(pi V)   1/(1 + (L w/V)²)               over w > 0
///   Phi_v  =   sigma² L/(pi V)   (1 + 3 (L w/V)²)/(1 + (L w/V)²)²,  Phi_w likewise
///
/// so that, with a = V/L, the autocorrelations are sigma² e^{-a tau} along the wind and
/// sigma² e^{-a tau} (1 - a tau/2) across it. Each component is a linear process of white noise,
/// stepped exactly: its statistics do not depend on the step, and it starts stationary. h is held
/// within 10 and 1000 ft. Below an airspeed of sigma_u the eddies turn over sooner than they are
/// carried past: V is at least that, so gusts at a standstill change too. u blows along the
/// horizontal mean wind (along X where there is none), w along Z. Tests:
/// tests/model/vehicle/wind_test.cc.

#include <array>
#include <cstdint>

#include "model/core/options.h"
#include "model/statistics/normal_noise.h"
#include "model/vehicle/rigid_body.h"

namespace lipoid {

struct WindOptions {
  static constexpr Range kSpeedRange{-60.0, 60.0};
  double wind_x_m_per_s = 0.0;
  double wind_y_m_per_s = 0.0;
  double wind_z_m_per_s = 0.0;
  double gusts_m_per_s = 0.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("wind_x_m_per_s", self.wind_x_m_per_s, kSpeedRange, "constant speed of the air along x, m/s");
    v("wind_y_m_per_s", self.wind_y_m_per_s, kSpeedRange, "constant speed of the air along y, m/s");
    v("wind_z_m_per_s",
      self.wind_z_m_per_s,
      kSpeedRange,
      "constant speed of the air downwards, m/s");
    v("gusts_m_per_s",
      self.gusts_m_per_s,
      Range{0.0, 60.0},
      "Dryden gusts, given by the wind speed at 20 ft in m/s: 7.7 light, 15.4 moderate, 23.2 "
      "severe");
  }
};

/// Lengths and intensities at one altitude.
struct DrydenParameters {
  double horizontal_length_m;
  double vertical_length_m;
  double horizontal_sigma_m_per_s;
  double vertical_sigma_m_per_s;
};
[[nodiscard]] DrydenParameters DrydenAt(double altitude_m, double wind_at_20ft_m_per_s);

/// One component of unit variance as a function of theta, the way in lengths L.
class DrydenAlong {
 public:
  void Start(NormalNoise& noise) { state_ = noise(); }
  double Step(double theta, NormalNoise& noise);

 private:
  double state_ = 0.0;
};

/// The same across: second order, two states of unit variance.
class DrydenAcross {
 public:
  void Start(NormalNoise& noise);
  double Step(double theta, NormalNoise& noise);

 private:
  void Discretize(double theta);

  double theta_ = -1.0;             // of the coefficients below
  double decay_ = 1.0;              // e^{-theta}
  double couple_ = 0.0;             // share of the first state in the second
  std::array<double, 3> spread_{};  // Cholesky factor of the noise of a step
  std::array<double, 2> state_{};
};

class Wind {
 public:
  /// step_s > 0; the control step by default.
  Wind(const WindOptions& options, std::uint64_t seed, double step_s = 0.005);

  /// Wind in inertial axes during the coming step at this altitude (positive up) and this speed
  /// against the mean wind.
  Triple<double> Step(double altitude_m, double airspeed_m_per_s);

  [[nodiscard]] const Triple<double>& mean_m_per_s() const { return mean_m_per_s_; }

 private:
  Triple<double> mean_m_per_s_;
  double wind_at_20ft_m_per_s_;
  double step_s_;
  double along_x_ = 1.0;  // direction of u
  double along_y_ = 0.0;
  NormalNoise noise_;
  DrydenAlong along_;
  DrydenAcross across_;
  DrydenAcross vertical_;
};

}  // namespace lipoid
