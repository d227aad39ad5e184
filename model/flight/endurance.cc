#include "model/flight/endurance.h"

#include <algorithm>
#include <cmath>

#include "model/core/errors.h"
#include "model/vehicle/battery_supply.h"

namespace lipoid {
namespace {

constexpr double kEmptyAfter_s = 1.0;  // below cut-off, as in Fly
constexpr double kRounding_s = 1e-9;

class Mission {
 public:
  explicit Mission(const EnduranceSetup& setup)
      : setup_(setup), battery_(setup.cell, setup.initial_soc, setup.ambient_degC) {
    warms_ = setup.cell.temperature.has_value();
    if (warms_) result_.hottest_degC = battery_.temperature_degC();
    result_.minimum_voltage_V = std::numeric_limits<double>::infinity();
  }

  EnduranceResult Run() {
    Draw(setup_.mission.legs.front());
    result_.initial_voltage_V = voltage_V_;
    result_.initial_current_A = current_A_;
    if (battery_.rest_soc() <= setup_.reserve) {
      Finish(MissionEnd::kReserve, setup_.mission.legs.front());
    } else if (!suffices_) {
      Finish(MissionEnd::kPower, setup_.mission.legs.front());
    } else if (voltage_V_ < setup_.mission.legs.front().least_V) {
      Finish(MissionEnd::kMotorVoltage, setup_.mission.legs.front());
    }
    while (!ended_) {
      for (const MissionLeg& leg : setup_.mission.legs) {
        FlyLeg(leg);
        if (ended_) break;
      }
      if (ended_) break;
      ++result_.rounds;
      if (!setup_.mission.repeats) Finish(MissionEnd::kMissionDone, setup_.mission.legs.back());
    }
    return result_;
  }

 private:
  // What flows under the leg's load.
  void Draw(const MissionLeg& leg) {
    constexpr double kNear_A = 1e-9;
    // Where the drop bends, the tangent is moved to where the current lands; with diodes the power
    // follows the voltage.
    const bool once = !battery_.bends() && leg.diode_V == 0.0;
    double power_W = leg.power_W + leg.drive_W;
    Supply<double> supply = battery_.Linearize();
    if (leg.diode_V > 0.0 && !(voltage_V_ > 0.0)) voltage_V_ = supply.voltage_V;
    double last_A = std::numeric_limits<double>::quiet_NaN();
    for (int round = 0; round < 20; ++round) {
      if (leg.diode_V > 0.0)
        power_W = leg.power_W + leg.drive_W * (voltage_V_ / (voltage_V_ + leg.diode_V));
      const double open_V = supply.voltage_V - supply.resistance_Ohm * leg.switched_A;
      const double discriminant = open_V * open_V - 4.0 * supply.resistance_Ohm * power_W;
      suffices_ = discriminant >= 0.0 && open_V > 0.0;
      voltage_V_ = 0.5 * (open_V + std::sqrt(std::max(discriminant, 0.0)));
      current_A_ = suffices_ ? power_W / voltage_V_ + leg.switched_A
                             : std::max(0.0, voltage_V_ / supply.resistance_Ohm);
      if (once || std::abs(current_A_ - last_A) < kNear_A) return;
      last_A = current_A_;
      battery_.Expect(current_A_);
      supply = battery_.Linearize();
    }
  }

  void FlyLeg(const MissionLeg& leg) {
    const bool endless = !std::isfinite(leg.duration_s);
    const double steps =
        endless ? std::numeric_limits<double>::infinity()
                : std::max(1.0, std::ceil(leg.duration_s / setup_.options.step_s - kRounding_s));
    const double dt_s = endless ? setup_.options.step_s : leg.duration_s / steps;
    const double begin_s = result_.time_s;
    for (double k = 0.0; k < steps && !ended_; k += 1.0) {
      Step(leg, dt_s);
      if (!ended_) result_.time_s = begin_s + (k + 1.0) * dt_s;
      if (!ended_ && result_.time_s >= setup_.options.longest_s)
        Finish(MissionEnd::kTimeLimit, leg);
    }
  }

  void Step(const MissionLeg& leg, double dt_s) {
    Draw(leg);
    result_.minimum_voltage_V = std::min(result_.minimum_voltage_V, voltage_V_);
    result_.peak_current_A = std::max(result_.peak_current_A, current_A_);
    const double spare_C = (battery_.rest_soc() - setup_.reserve) * battery_.capacity_C();
    const bool at_reserve = current_A_ * dt_s >= spare_C && current_A_ > 0.0;
    if (at_reserve) dt_s = std::max(spare_C / current_A_, 1e-12);
    battery_.Advance(current_A_ * dt_s, dt_s);
    result_.charge_C += current_A_ * dt_s;
    result_.distance_m += leg.ground_speed_m_per_s * dt_s;
    result_.energy_J += voltage_V_ * current_A_ * dt_s;
    if (warms_) result_.hottest_degC = std::max(result_.hottest_degC, battery_.temperature_degC());
    without_power_s_ = suffices_ ? 0.0 : without_power_s_ + dt_s;
    below_motors_s_ = voltage_V_ < leg.least_V ? below_motors_s_ + dt_s : 0.0;
    below_cutoff_s_ = voltage_V_ < battery_.cutoff_V() ? below_cutoff_s_ + dt_s : 0.0;
    const auto lasted = [](double time_s) { return time_s >= kEmptyAfter_s - kRounding_s; };
    std::optional<MissionEnd> end;
    if (at_reserve) {
      end = MissionEnd::kReserve;
    } else if (battery_.soc() <= 0.0) {
      end = MissionEnd::kEmpty;
    } else if (lasted(without_power_s_)) {
      end = MissionEnd::kPower;
    } else if (lasted(below_motors_s_)) {
      end = MissionEnd::kMotorVoltage;
    } else if (lasted(below_cutoff_s_)) {
      end = MissionEnd::kCutOff;
    }
    if (!end) return;
    result_.time_s += dt_s;
    Finish(*end, leg);
  }

  void Finish(MissionEnd end, const MissionLeg& leg) {
    ended_ = true;
    result_.ended_by = end;
    result_.soc = battery_.soc();
    result_.rest_soc = battery_.rest_soc();
    result_.landing_rest_voltage_V = battery_.rest_voltage_V();
    Draw(leg);
    result_.landing_voltage_V = voltage_V_;
    result_.minimum_voltage_V = std::min(result_.minimum_voltage_V, voltage_V_);
  }

  const EnduranceSetup& setup_;
  BatterySupply battery_;
  bool warms_ = false;
  bool ended_ = false;
  bool suffices_ = true;
  double voltage_V_ = 0.0;
  double current_A_ = 0.0;
  double without_power_s_ = 0.0;
  double below_motors_s_ = 0.0;
  double below_cutoff_s_ = 0.0;
  EnduranceResult result_;
};

}  // namespace

EnduranceResult FlyMission(const EnduranceSetup& setup) {
  Require(!setup.mission.legs.empty() && std::all_of(setup.mission.legs.begin(),
                                                     setup.mission.legs.end(),
                                                     [](const MissionLeg& leg) {
                                                       return leg.duration_s > 0.0 &&
                                                              std::isfinite(leg.power_W);
                                                     }),
          "a mission of legs that last, each with a finite load");
  Require(setup.options.step_s > 0.0 && setup.reserve < 1.0,
          "a step above 0 and a reserve below 1",
          {{"step_s", setup.options.step_s}, {"reserve", setup.reserve}});
  return Mission(setup).Run();
}

}  // namespace lipoid
