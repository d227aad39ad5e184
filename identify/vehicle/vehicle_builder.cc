#include "identify/vehicle/vehicle_builder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/core/errors.h"
#include "model/core/significant_digits.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAirDensity_kg_per_m3 = 1.225;  // at sea level and 15 degC
constexpr double kMetresPerInch = 0.0254;
constexpr double kFull_V = 4.2;    // of a lithium-polymer cell
constexpr double kMiddle_V = 3.7;  // half charged, under a hover's load

// APC Slow Flyer 10 x 4.7, mean of 16 static points from 2377 to 6528 rpm in the UIUC propeller
// database (Brandt and Selig): C_T = 0.1185, C_P = 0.048. With a lift that ends at -4 degrees of the
// cambered blade, s follows from it.
constexpr double kZeroLift_rad = 0.07;
constexpr double kMeasuredThrust = 0.1185;
constexpr double kMeasuredPitch = 0.47;
// At rest a blade of more pitch than this stalls: it lifts no more, and its force is normal to the
// chord, so that the torque for a thrust grows with the pitch. With it, and the root of the blades,
// racer-5in's 5 x 4 with three blades has C_T = 0.145 and a figure of merit of 0.41, as measured.
constexpr double kStallPitch = 0.5;  // over the diameter
// Between 0.62 and 0.68 on the propellers of docs/vehicles.md.
constexpr double kTypicalMerit = 0.65;

// Of m l²: between the Parrot Mambo's (0.24, 0.30, 0.41) and those of larger airframes.
constexpr std::array kTypicalInertia{0.25, 0.25, 0.45};
// 8.5 g at 10 inch, as plastic propellers weigh, in proportion to the area.
constexpr double kTypicalPropeller_g_per_in2 = 0.085;
// At equal speed, from the 22 % more power that coaxial pairs were measured to need for the same
// thrust: 1.22^(-2/3) = 0.875 of the thrust for the same power, all of the loss in the lower rotor.
constexpr double kTypicalLowerRotor = 0.75;
// Rotor drag of quadrotors is 0.3 to 0.5 per second of the mass.
constexpr double kTypicalDrag_per_s = 0.3;

double TypicalMerit(double pitch_over_diameter) {
  return kTypicalMerit * std::min(1.0, kStallPitch / pitch_over_diameter);
}

double ToThrustCoefficient(double c_t, double diameter_m) {
  return c_t * kAirDensity_kg_per_m3 * std::pow(diameter_m, 4) / (4.0 * kPi * kPi);
}
double ToTorqueCoefficient(double c_p, double diameter_m) {
  return c_p * kAirDensity_kg_per_m3 * std::pow(diameter_m, 5) / (8.0 * kPi * kPi * kPi);
}

// Assumptions and fits are not known to more digits.
double Rounded(double value) { return RoundToDigits(value, 5); }

class Draft {
 public:
  Draft(const BuilderNumbers& numbers, const std::optional<BenchFit>& bench)
      : n_(numbers), bench_(bench) {}

  VehicleDraft Make() {
    Body();
    Propeller();
    Motor();
    Controllers();
    CheckPropeller();
    if (bench_) CheckBench();
    Hover();
    CheckSizes();
    return std::move(draft_);
  }

 private:
  void From(std::string_view key, std::string text) {
    if (text.starts_with("assumed")) draft_.assumed.emplace_back(key);
    draft_.sources.emplace_back(key, std::move(text));
  }

  void Body() {
    Vehicle& v = draft_.vehicle;
    v.name = n_.name;
    v.mass_kg = 1e-3 * (n_.mass_g + n_.payload_g);
    From("mass_kg",
         n_.payload_g > 0.0
             ? fmt::format("given: {} g and {} g of payload", n_.mass_g, n_.payload_g)
             : fmt::format("given: {} g", n_.mass_g));
    v.arm_m = 0.5e-3 * n_.frame_mm;
    From("arm_m", fmt::format("given: half of {} mm from motor to motor", n_.frame_mm));
    v.layout = n_.layout;
    v.front_right_turns = n_.front_right_turns;
    const double ml2 = v.mass_kg * v.arm_m * v.arm_m;
    for (std::size_t k = 0; k < 3; ++k) {
      v.inertia_kg_m2[k] = Rounded(kTypicalInertia[k] * ml2);
    }
    if (n_.inertia_kg_m2) {
      v.inertia_kg_m2 = *n_.inertia_kg_m2;
      From("inertia_kg_m2", "given");
    } else {
      From("inertia_kg_m2",
           "assumed: 0.25, 0.25 and 0.45 of mass times arm squared, as small multirotors have");
    }
    if (RotorsOf(v.layout)[1].lower) {
      v.lower_rotor_thrust_ratio = n_.lower_rotor_thrust_ratio.value_or(kTypicalLowerRotor);
      From("lower_rotor_thrust_ratio",
           n_.lower_rotor_thrust_ratio
               ? "given"
               : "assumed: coaxial pairs were measured to need 22 % more power than rotors apart "
                 "(Leishman, Principles of Helicopter Aerodynamics, 2.16)");
    } else if (n_.lower_rotor_thrust_ratio) {
      throw OptionError(
          "option --lower-rotor-thrust-ratio: the layout has no lower rotors; leave "
          "it out, or give --layout y6 or x8");
    }
    v.avionics_power_W = n_.avionics_W;
    From("avionics_power_W", n_.avionics_W > 0.0 ? "given" : "assumed: none");
    v.linear_drag_N_s_per_m = n_.drag_N_s_per_m.value_or(Rounded(kTypicalDrag_per_s * v.mass_kg));
    From("linear_drag_N_s_per_m",
         n_.drag_N_s_per_m
             ? "given"
             : "assumed: 0.3 per second of the mass; rotor drag of quadrotors is 0.3 to 0.5 "
               "(Faessler, Franchi and Scaramuzza, 2018)");
    v.series_cells = n_.series_cells;
    From("series_cells", "given");
    v.nominal_voltage_V = Rounded(kFull_V * n_.series_cells);
    From("nominal_voltage_V", fmt::format("{} full cells of {} V", n_.series_cells, kFull_V));
  }

  void Propeller() {
    Vehicle& v = draft_.vehicle;
    const double diameter_m = kMetresPerInch * n_.propeller_in;
    v.propeller_diameter_m = diameter_m;
    From("propeller_diameter_m", fmt::format("given: {} inch", n_.propeller_in));
    if (bench_) {
      v.thrust_coefficient_N_s2 = Rounded(bench_->thrust_coefficient_N_s2.estimate);
      v.torque_coefficient_N_m_s2 = Rounded(bench_->torque_coefficient_N_m_s2.estimate);
      From("thrust_coefficient_N_s2", Fitted(bench_->thrust_coefficient_N_s2));
      From("torque_coefficient_N_m_s2", Fitted(bench_->torque_coefficient_N_m_s2));
      return;
    }
    if (n_.thrust_coefficient.has_value() != n_.power_coefficient.has_value()) {
      throw OptionError(
          "options --thrust-coefficient and --power-coefficient: give both, or "
          "--pitch-in for typical ones");
    }
    if (!n_.thrust_coefficient && !n_.pitch_in) {
      throw OptionError(
          "nothing says what the propeller does: give --bench-table, or "
          "--thrust-coefficient and --power-coefficient, or --pitch-in");
    }
    if (!n_.thrust_coefficient) CheckPitch(*n_.pitch_in);
    const PropellerCoefficients c =
        n_.thrust_coefficient ? PropellerCoefficients{*n_.thrust_coefficient, *n_.power_coefficient}
                              : TypicalPropeller(*n_.pitch_in / n_.propeller_in, n_.blades);
    v.thrust_coefficient_N_s2 = ToThrustCoefficient(c.thrust, diameter_m);
    v.torque_coefficient_N_m_s2 = ToTorqueCoefficient(c.power, diameter_m);
    const std::string air = fmt::format("in air of {} kg/m³", kAirDensity_kg_per_m3);
    if (n_.thrust_coefficient) {
      From("thrust_coefficient_N_s2", fmt::format("C_T = {} given, {}", c.thrust, air));
      From("torque_coefficient_N_m_s2", fmt::format("C_P = {} given, {}", c.power, air));
      return;
    }
    From("thrust_coefficient_N_s2",
         fmt::format("assumed: C_T = {:.4f} by blade element theory from a pitch of {} inch and {} "
                     "blades, scaled to a measured propeller (APC 10 x 4.7, UIUC), {}",
                     c.thrust,
                     *n_.pitch_in,
                     n_.blades,
                     air));
    From("torque_coefficient_N_m_s2",
         fmt::format("assumed: C_P = {:.4f} by a figure of merit of {:.3g}, typical of such "
                     "propellers, {}",
                     c.power,
                     TypicalMerit(*n_.pitch_in / n_.propeller_in),
                     air));
  }

  void CheckPitch(double pitch_in) {
    if (pitch_in == 0.0) {
      throw OptionError(
          "option --pitch-in: a propeller without pitch is a flat plate; give the second of the "
          "two numbers on the propeller, or its coefficients");
    }
    constexpr Range kUsual{0.2, 1.5};
    constexpr Range kPossible{0.05, 3.0};
    const double ratio = pitch_in / n_.propeller_in;
    if (!kPossible.Contains(ratio)) {
      throw OptionError(fmt::format(
          "option --pitch-in: expected a pitch of {:g} to {:g} diameters of the propeller, found {:.3g}: --pitch-in "
          "and --propeller-in are in inch of 25.4 mm",
          kPossible.lo,
          kPossible.hi,
          ratio));
    }
    constexpr double kWell = 0.6;  // the least pitch over diameter that is far into the stall
    if (n_.blades > 2 || ratio > kWell) {
      draft_.cautions.push_back(fmt::format(
          "thrust and power of a propeller of {} blades and a pitch of {:.3g} diameters may be "
          "off by 40 %: beyond 2 blades, and beyond a pitch of {:g} diameters, where blades stall at "
          "rest, give --bench-table or coefficients",
          n_.blades,
          ratio,
          kWell));
    }
    if (kUsual.Contains(ratio)) return;
    draft_.cautions.push_back(fmt::format(
        "a pitch of {:g} inch is {:.3g} diameters of the propeller, where {:g} to {:g} are usual: "
        "--pitch-in and --propeller-in are in inch of 25.4 mm",
        pitch_in,
        ratio,
        kUsual.lo,
        kUsual.hi));
  }

  void Motor() {
    Vehicle& v = draft_.vehicle;
    if (bench_ && bench_->motor_constant_N_m_per_A.fitted) {
      v.motor_constant_N_m_per_A = Rounded(bench_->motor_constant_N_m_per_A.estimate);
      From("motor_constant_N_m_per_A", Fitted(bench_->motor_constant_N_m_per_A));
    } else {
      if (!n_.kv_rpm_per_V)
        throw OptionError("the motor's constant is missing: give --kv-rpm-per-V");
      v.motor_constant_N_m_per_A = 60.0 / (2.0 * kPi * *n_.kv_rpm_per_V);
      From("motor_constant_N_m_per_A",
           fmt::format("60/(2 pi KV) with KV = {} rpm/V given", *n_.kv_rpm_per_V));
    }
    if (bench_) {
      TakeResistance();
    } else {
      if (!n_.winding_resistance_Ohm) {
        throw OptionError(
            "the motor's resistance is missing: give --winding-resistance-Ohm, "
            "between two of its three wires, or --bench-table");
      }
      v.armature_resistance_Ohm = *n_.winding_resistance_Ohm;
      From("armature_resistance_Ohm",
           "given, between two of the three wires: two phases carry the current at a time");
    }
    if (bench_ && bench_->friction_N_m_s.fitted) {
      v.friction_N_m_s = Rounded(bench_->friction_N_m_s.estimate);
      From("friction_N_m_s", Fitted(bench_->friction_N_m_s));
    } else if (n_.no_load_A) {
      // b of k_e I_0 = b omega_0
      v.friction_N_m_s =
          v.motor_constant_N_m_per_A * v.motor_constant_N_m_per_A * NoLoadConductance(n_);
      From("friction_N_m_s",
           fmt::format("given: {} A without load at {} V", *n_.no_load_A, n_.no_load_V));
    } else {
      From("friction_N_m_s", "assumed: none, because no current without load is given");
    }
    if (n_.rotor_inertia_kg_m2 && n_.propeller_g) {
      throw OptionError(
          "option --propeller-g: it says how heavy the rotor is to turn, which "
          "--rotor-inertia-kg-m2 says already; leave one of the two out");
    }
    if (n_.rotor_inertia_kg_m2) {
      v.rotor_inertia_kg_m2 = *n_.rotor_inertia_kg_m2;
      From("rotor_inertia_kg_m2", "given");
    } else {
      const double propeller_g =
          n_.propeller_g.value_or(kTypicalPropeller_g_per_in2 * n_.propeller_in * n_.propeller_in);
      RefuseHeavyPropellers(propeller_g);
      v.rotor_inertia_kg_m2 =
          Rounded(1e-3 * propeller_g * v.propeller_diameter_m * v.propeller_diameter_m / 12.0);
      From("rotor_inertia_kg_m2",
           fmt::format("{}: a uniform rod of the propeller's {:.3g} g and diameter",
                       n_.propeller_g ? "derived" : "assumed",
                       propeller_g));
    }
  }

  void RefuseHeavyPropellers(double propeller_g) const {
    const double all_g = propeller_g * static_cast<double>(draft_.vehicle.rotor_count());
    if (all_g < n_.mass_g) return;
    throw OptionError(fmt::format(
        "the propellers would outweigh the vehicle: {} of {:.4g} g{} are {:.4g} g, and --mass-g is "
        "{:g} g with them. Check --mass-g and --propeller-g, both in g",
        draft_.vehicle.rotor_count(),
        propeller_g,
        n_.propeller_g ? "" : " (assumed from their diameter)",
        all_g,
        n_.mass_g));
  }

  // The table sees winding and controller in series.
  void TakeResistance() {
    Vehicle& v = draft_.vehicle;
    const BenchQuantity& r = bench_->resistance_Ohm;
    if (n_.esc.resistance_Ohm > 0.0) {
      throw OptionError(fmt::format(
          "option --esc-resistance-mOhm: the fit to {} finds winding and controller together, "
          "which would count it twice; leave it out, or give --winding-resistance-Ohm instead, "
          "which leaves the rest to the controller",
          n_.bench_name));
    }
    const double rest = r.estimate - n_.winding_resistance_Ohm.value_or(r.estimate);
    if (rest < 0.0 && !(*n_.winding_resistance_Ohm <= r.high_95)) {
      throw OptionError(fmt::format(
          "option --winding-resistance-Ohm: {:g} Ohm are more than the {:.3g} Ohm that the fit to "
          "{} finds for winding and controller together; leave the option out, or give the resistance "
          "between two of the three wires",
          *n_.winding_resistance_Ohm,
          r.estimate,
          n_.bench_name));
    }
    if (!n_.winding_resistance_Ohm || rest <= 0.0) {
      v.armature_resistance_Ohm = Rounded(r.estimate);
      From("armature_resistance_Ohm", Fitted(r) + "; winding, controller and commutation together");
      return;
    }
    v.armature_resistance_Ohm = *n_.winding_resistance_Ohm;
    v.esc.resistance_Ohm = Rounded(rest);
    From("armature_resistance_Ohm", "given, between two of the three wires");
    From("esc_resistance_Ohm",
         fmt::format("what the fit to {} finds in series ({:.3g} +- {:.2g} Ohm) less the winding: "
                     "transistors and commutation",
                     n_.bench_name,
                     r.estimate,
                     r.standard_error));
  }

  void Controllers() {
    Vehicle& v = draft_.vehicle;
    v.pwm_range = {1000.0, 2000.0};
    From("pwm_range", "assumed: pulse widths of 1000 to 2000 us, in whole microseconds");
    const double fitted_resistance = v.esc.resistance_Ohm;
    v.esc = n_.esc;
    if (fitted_resistance > 0.0) {
      v.esc.resistance_Ohm = fitted_resistance;
    } else if (n_.esc.resistance_Ohm > 0.0) {
      From("esc_resistance_Ohm", "given");
    }
    if (bench_ && bench_->switching_share.fitted && !(bench_->switching_share.estimate > 0.0)) {
      v.esc.switching_frequency_Hz = 0.0;
      draft_.cautions.push_back(fmt::format(
          "{} shows no losses by switching, so that --esc-pwm-kHz changes nothing", n_.bench_name));
    } else if (bench_ && bench_->switching_share.fitted) {
      v.esc.switching_time_s =
          Rounded(bench_->switching_share.estimate / n_.esc.switching_frequency_Hz);
      From("esc_switching_time_s",
           Fitted(bench_->switching_share) + ", as a share of the motor's current");
      From("esc_switching_frequency_Hz", "given");
    } else if (bench_ && bench_->full_throttle && n_.esc.switching_frequency_Hz > 0.0 &&
               n_.esc.switching_time_s == 0.0) {
      throw OptionError(fmt::format(
          "option --esc-pwm-kHz: {} has rows at full throttle alone, where nothing switches, and does not "
          "show the losses by switching; give --esc-switching-ns too, or leave --esc-pwm-kHz out",
          n_.bench_name));
    } else if ((n_.esc.switching_time_s > 0.0) != (n_.esc.switching_frequency_Hz > 0.0)) {
      throw OptionError(fmt::format(
          "option --{}: the losses by switching are the product of time and frequency, and there "
          "is no {}; give --{} too, or leave both out",
          n_.esc.switching_time_s > 0.0 ? "esc-switching-ns" : "esc-pwm-kHz",
          n_.esc.switching_time_s > 0.0 ? "frequency" : "time",
          n_.esc.switching_time_s > 0.0 ? "esc-pwm-kHz" : "esc-switching-ns"));
    } else if (n_.esc.SwitchingShare() > 0.0) {
      From("esc_switching_time_s", "given");
      From("esc_switching_frequency_Hz", "given");
    }
    if (v.esc.lossless()) draft_.assumed.emplace_back("esc_resistance_Ohm");
  }

  void CheckPropeller() {
    const Vehicle& v = draft_.vehicle;
    const auto rotors = RotorsOf(v.layout);
    double nearest_m = 2.0 * v.arm_m;
    for (std::size_t i = 1; i < rotors.size(); ++i) {
      const double apart = v.arm_m * std::hypot(rotors[i].ahead - rotors[0].ahead,
                                                rotors[i].right - rotors[0].right);
      if (apart > 1e-9) nearest_m = std::min(nearest_m, apart);
    }
    if (v.propeller_diameter_m >= nearest_m) {
      throw OptionError(fmt::format(
          "the propellers would touch: {} inch are {:.0f} mm, and neighbouring motors of a {} of "
          "{} mm are {:.0f} mm apart. Give a smaller --propeller-in or a larger --frame-mm",
          n_.propeller_in,
          1e3 * v.propeller_diameter_m,
          OptionNames(RotorLayout{})[std::size_t(v.layout)].second,
          n_.frame_mm,
          1e3 * nearest_m));
    }
    // P = T^(3/2)/sqrt(2 rho A) is the least power that a thrust takes.
    const double area_m2 = 0.25 * kPi * v.propeller_diameter_m * v.propeller_diameter_m;
    const double merit = std::pow(v.thrust_coefficient_N_s2, 1.5) /
                         std::sqrt(2.0 * kAirDensity_kg_per_m3 * area_m2) /
                         v.torque_coefficient_N_m_s2;
    if (merit > 1.0) {
      throw OptionError(fmt::format(
          "the propeller's figure of merit would be {:.2f}, and none is above 1: it would give more "
          "thrust than momentum theory allows for its power. Check {}",
          merit,
          !bench_ ? "--thrust-coefficient and --power-coefficient"
          : n_.kv_rpm_per_V
              ? "--propeller-in and --kv-rpm-per-V against the bench table, and the units in its header"
              : "--propeller-in against the bench table and the units in its header; the table may not "
                "determine KV: give --kv-rpm-per-V"));
    }
    constexpr double kPoorest = 0.25;  // the poorest that are sold have 0.4 on a bench
    if (bench_ && merit < kPoorest) {
      draft_.cautions.push_back(fmt::format(
          "the propeller's figure of merit would be {:.2g}, where 0.4 to 0.75 are usual: does {} have its currents "
          "or thrusts in another unit, or the current of all motors?",
          merit,
          n_.bench_name));
    }
  }

  void CheckBench() {
    constexpr double kPoor = 0.05;  // relative
    const double worst = std::max({bench_->speed_rms, bench_->current_rms, bench_->thrust_rms});
    if (worst > kPoor) {
      draft_.cautions.push_back(fmt::format(
          "the fit is off by {:.2g} % on the mean ({}current {:.2g} %, thrust {:.2g} %): {}",
          100.0 * worst,
          bench_->has_speed ? fmt::format("speed {:.2g} %, ", 100.0 * bench_->speed_rms) : "",
          100.0 * bench_->current_rms,
          100.0 * bench_->thrust_rms,
          bench_->has_speed
              ? fmt::format("one motor with one propeller explains {} no better", n_.bench_name)
              : fmt::format("the throttle of {} may not be the duty cycle, and the thrust "
                            "coefficient, the speed and the resistance then hold the difference; a "
                            "column of speeds would tell",
                            n_.bench_name)));
    }
    const BenchQuantity& n = bench_->throttle_exponent;
    constexpr double kNoDuty = 0.02;
    if (n.fitted && std::abs(n.estimate - 1.0) > kNoDuty && (n.low_95 > 1.0 || n.high_95 < 1.0)) {
      draft_.cautions.push_back(fmt::format(
          "the throttle of {} is not the duty cycle: the duty cycle is the throttle to the power of "
          "{:.3g} (95 % between {:.3g} and {:.3g}); the numbers of the vehicle file are those "
          "at the duty cycle",
          n_.bench_name,
          n.estimate,
          n.low_95,
          n.high_95));
    }
    if (bench_->friction_at_most) {
      draft_.cautions.push_back(fmt::format(
          "the fit to {} would give the friction more than {:.0f} % of the torque of its fastest "
          "row, which no motor has, and it is held there: give --no-load-A",
          n_.bench_name,
          100.0 * kMostFriction));
    }
    constexpr double kMostSwitching = 0.03;  // of the current: a microsecond at 30 kHz
    if (bench_->switching_share.estimate > kMostSwitching) {
      draft_.cautions.push_back(fmt::format(
          "the losses by switching would be {:.2g} % of the current, more than any controller has: "
          "they hold what the model lacks",
          100.0 * bench_->switching_share.estimate));
    }
  }

  void Hover() {
    const Vehicle& v = draft_.vehicle;
    const double voltage_V = kMiddle_V * n_.series_cells;
    const double fastest = HeldSpeed(WithControllers(v), voltage_V);
    const double weight_N = v.mass_kg * kGravity_m_per_s2;
    const double most_N = v.total_thrust_coefficient_N_s2() * fastest * fastest;
    draft_.thrust_to_weight = most_N / weight_N;
    if (draft_.thrust_to_weight <= 1.0) {
      constexpr double kLeastStall_A = 1.0;  // the smallest motors that lift a vehicle take several
      throw OptionError(fmt::format(
          "this vehicle cannot hover: at {:.3g} V ({} cells of {} V) its {} rotors give at most "
          "{:.3g} N, and it weighs {:.3g} N. {}",
          voltage_V,
          n_.series_cells,
          kMiddle_V,
          v.rotor_count(),
          most_N,
          weight_N,
          voltage_V < v.armature_resistance_Ohm * kLeastStall_A
              ? fmt::format(
                    "Its motors would take {:.2g} A when they are held: is --winding-resistance-Ohm in mOhm?",
                    voltage_V / v.armature_resistance_Ohm)
          : !bench_ || draft_.cautions.empty()
              ? "Give more cells, larger propellers, another KV or less mass"
              : fmt::format("First see to this: {}", fmt::join(draft_.cautions, "; "))));
    }
    draft_.hover = HoverTrim(v, Supply<double>{voltage_V, 0.0});
    draft_.hover_power_W = draft_.hover.battery_V * draft_.hover.battery_A;
  }

  // What is given where the vehicle's own size says about what it is.
  void CheckGivenSizes() {
    const Vehicle& v = draft_.vehicle;
    const auto caution = [this](std::string_view option,
                                double value,
                                std::string_view unit,
                                double usual,
                                std::string_view of,
                                Range factors) {
      const double factor = value / usual;
      if (factors.Contains(factor)) return;
      draft_.cautions.push_back(fmt::format("--{} {:g} is {:.2g} times {}, {:.2g} {}: it is in {}",
                                            option,
                                            value,
                                            factor,
                                            of,
                                            usual,
                                            unit,
                                            unit));
    };
    if (n_.inertia_kg_m2) {
      // Most of the mass lies within the motors.
      const double ml2 = v.mass_kg * v.arm_m * v.arm_m;
      caution("inertia-kg-m2",
              *std::max_element(v.inertia_kg_m2.begin(), v.inertia_kg_m2.end()),
              "kg m²",
              ml2,
              "mass times arm squared",
              {0.03, 2.0});
    }
    if (n_.rotor_inertia_kg_m2) {
      const double propeller_kg =
          1e-3 * kTypicalPropeller_g_per_in2 * n_.propeller_in * n_.propeller_in;
      caution("rotor-inertia-kg-m2",
              v.rotor_inertia_kg_m2,
              "kg m²",
              propeller_kg * v.propeller_diameter_m * v.propeller_diameter_m / 12.0,
              "that of a typical propeller of its diameter",
              {0.02, 50.0});
    }
    if (n_.drag_N_s_per_m) {
      caution("drag-N-s-per-m",
              v.linear_drag_N_s_per_m,
              "N s/m",
              kTypicalDrag_per_s * v.mass_kg,
              "0.3 per second of the mass",
              {0.0, 30.0});
    }
  }

  // Numbers that can be, and are hardly meant.
  void CheckSizes() {
    const Vehicle& v = draft_.vehicle;
    const Trim& hover = draft_.hover;
    constexpr double kMostThrust = 20.0;  // over the weight; racers have up to 15
    if (draft_.thrust_to_weight > kMostThrust) {
      draft_.cautions.push_back(fmt::format(
          "the largest thrust is {:.4g} times the weight, and no multirotor has more than {:g} "
          "times: check --mass-g (in g), --series, --kv-rpm-per-V and --propeller-in (in inch)",
          draft_.thrust_to_weight,
          kMostThrust));
    }
    CheckGivenSizes();
    constexpr double kLeastEfficiency = 0.3;
    const double efficiency = v.torque_coefficient_N_m_s2 * std::pow(hover.speed_rad_per_s, 3) /
                              (hover.duty * hover.battery_V * hover.motor_A);
    if (efficiency < kLeastEfficiency) {
      draft_.cautions.push_back(fmt::format(
          "in the hover the motors turn {:.2g} % of their power into that of the propellers, where "
          "60 to 85 % are usual: check {}--kv-rpm-per-V against the propeller",
          100.0 * efficiency,
          bench_ ? "" : "--winding-resistance-Ohm (in Ohm, not mOhm), --no-load-A, and "));
    }
    const double motors_W = draft_.hover_power_W - v.avionics_power_W;
    if (v.avionics_power_W > motors_W) {
      draft_.cautions.push_back(fmt::format(
          "--avionics-W {:g} is more than the {:.3g} W that the motors take in the hover: it is in "
          "W, and is the power of everything but the motors",
          v.avionics_power_W,
          motors_W));
    }
  }

  [[nodiscard]] std::string Fitted(const BenchQuantity& quantity) const {
    if (!(quantity.standard_error > 0.0)) {
      return fmt::format("fitted to {}: at its bound", n_.bench_name);
    }
    return fmt::format("fitted to {}: 95 % between {:.4g} and {:.4g}",
                       n_.bench_name,
                       quantity.low_95,
                       quantity.high_95);
  }

  const BuilderNumbers& n_;
  const std::optional<BenchFit>& bench_;
  VehicleDraft draft_;
};

}  // namespace

PropellerCoefficients TypicalPropeller(double pitch_over_diameter, int blades) {
  constexpr double kTo = 4.0 / (kPi * kPi * kPi);  // from C_T to C
  const double measured = kTo * kMeasuredThrust;
  const double slope = std::sqrt(0.5 * blades) * measured /
                       (kMeasuredPitch / kPi + kZeroLift_rad - std::sqrt(0.5 * measured));
  // With q = sqrt(C/2): 2 q² + slope q - slope (theta + a_0) = 0.
  const double angle = std::min(pitch_over_diameter, kStallPitch) / kPi + kZeroLift_rad;
  const double q = (std::sqrt(slope * slope + 8.0 * slope * angle) - slope) / 4.0;
  const double thrust = 2.0 * q * q / kTo;
  return {thrust, std::pow(thrust, 1.5) * std::sqrt(2.0 / kPi) / TypicalMerit(pitch_over_diameter)};
}

double NoLoadConductance(const BuilderNumbers& numbers) {
  const double winding_Ohm = numbers.winding_resistance_Ohm.value_or(0.0);
  const double rest_V = numbers.no_load_V - winding_Ohm * *numbers.no_load_A;
  if (rest_V > 0.0) return *numbers.no_load_A / rest_V;
  throw OptionError(
      fmt::format("--no-load-A {} through --winding-resistance-Ohm {} takes more than the {} V of "
                  "--no-load-V: one of the three is wrong",
                  *numbers.no_load_A,
                  winding_Ohm,
                  numbers.no_load_V));
}

VehicleDraft BuildVehicle(const BuilderNumbers& numbers, const std::optional<BenchFit>& bench) {
  return Draft(numbers, bench).Make();
}

}  // namespace lipoid
