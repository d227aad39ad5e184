#include "model/flight/endurance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/core/errors.h"
#include "model/flight/endurance_lanes.h"
#include "model/flight/flight_clock.h"
#include "model/vehicle/battery_supply.h"

namespace lipoid {
namespace {

// What flows back counts as nothing.
double MeanPower(const PowerMission& mission) {
  double time_s = 0.0;
  double energy_J = 0.0;
  for (const MissionLeg& leg : mission.legs) {
    const double duration_s = std::isfinite(leg.duration_s) ? leg.duration_s : 1.0;
    time_s += duration_s;
    energy_J += duration_s * std::max(0.0, leg.power_W + leg.drive_W);
  }
  return energy_J / time_s;
}

// A share of the time that the charge lasts at half of it, at the mission's mean power.
double StepFor(const EnduranceSetup& setup, double mean_W) {
  constexpr double kShortest_s = 0.005;
  constexpr double kLongest_s = 10.0;
  constexpr double kSteps = 50'000.0;
  const double battery_J = setup.cell.series * setup.cell.parallel * setup.cell.alpha_C() *
                           setup.cell.open_circuit_voltage(0.5);
  if (!(mean_W > 0.0)) return kLongest_s;
  return std::clamp(battery_J / mean_W / kSteps, kShortest_s, kLongest_s);
}

// A change of A for which the tangent of v_oc(A) stands: packs that fly move A by less at once.
constexpr double kFar_soc = 0.1;

class Mission {
 public:
  explicit Mission(const EnduranceSetup& setup)
      : setup_(setup), battery_(setup.cell, setup.initial_soc, setup.ambient_degC) {
    warms_ = setup.cell.temperature.has_value();
    if (warms_) result_.hottest_degC = battery_.temperature_degC();
    result_.minimum_voltage_V = std::numeric_limits<double>::infinity();
    result_.mission_power_W = MeanPower(setup.mission);
    step_s_ =
        setup.options.step_s > 0.0 ? setup.options.step_s : StepFor(setup, result_.mission_power_W);
  }

  // What the flight begins with; ends it where it cannot begin.
  void Begin() {
    const MissionLeg& first = setup_.mission.legs.front();
    Draw(first);
    result_.initial_voltage_V = voltage_V_;
    result_.initial_current_A = current_A_;
    if (battery_.rest_soc() <= setup_.reserve) {
      Finish(MissionEnd::kReserve, first);
    } else if (!EmptyAfter(first.duration_s)) {
      // What is shorter does not end a flight later either.
    } else if (!suffices_) {
      NoteLack(first, 0.0);
      Finish(MissionEnd::kPower, first);
      // Nothing was flown.
      result_.minimum_voltage_V = result_.peak_current_A = std::numeric_limits<double>::quiet_NaN();
    } else if (voltage_V_ < first.least_V) {
      Finish(MissionEnd::kMotorVoltage, first);
    }
  }
  [[nodiscard]] bool ended() const { return ended_; }
  // Whether the load moves A at once by more than a tangent holds for.
  [[nodiscard]] bool far() const { return far_; }
  [[nodiscard]] double step_s() const { return step_s_; }

  // Goes on where lanes stopped, within a first leg without end.
  void Continue(MissionState state) {
    battery_.Continue(std::move(state.cell), state.cell_A);
    before_A_ = state.before_A;
    steps_flown_ = static_cast<double>(state.steps);
    result_.charge_C = state.charge_C;
    result_.energy_J = state.energy_J;
    result_.minimum_voltage_V = state.minimum_voltage_V;
    result_.peak_current_A = state.peak_current_A;
    result_.distance_m = setup_.mission.legs.front().ground_speed_m_per_s * steps_flown_ * step_s_;
  }

  EnduranceResult Run() {
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
      far_ = battery_.SocMovedBy(current_A_) > kFar_soc;
      if (once && far_) return Climb(leg);
      if (once || std::abs(current_A_ - last_A) < kNear_A) return;
      last_A = current_A_;
      battery_.Expect(current_A_);
      supply = battery_.Linearize();
    }
    if (far_) Climb(leg);
  }

  // As Draw(), where the current moves A so far that the tangent of the curve says nothing of where
  // it lands: that of an empty battery is steep, and would promise more than a full one gives. From
  // no current upwards, each current is what the load draws at the voltage under the one before. A
  // voltage falls with its current, so that this ends at the lowest current that gives the power,
  // or, where there is none, beyond the current of the most power.
  void Climb(const MissionLeg& leg) {
    constexpr double kNear = 1e-12;
    constexpr int kRounds = 1000;
    const auto voltage_under = [&](double pack_A) {
      battery_.Expect(pack_A);
      const Supply<double> supply = battery_.Linearize();
      return supply.voltage_V - supply.resistance_Ohm * pack_A;
    };
    suffices_ = false;
    current_A_ = 0.0;
    voltage_V_ = voltage_under(0.0);
    double most_W = 0.0;
    double at_A = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      const double at_V = voltage_under(at_A);
      if (!(at_V > 0.0)) break;
      if (at_A < 0.0 || at_A * at_V >= most_W) {
        most_W = std::max(0.0, at_A * at_V);
        current_A_ = at_A;
        voltage_V_ = at_V;
      }
      const double wanted_A =
          (leg.power_W + leg.drive_W * (at_V / (at_V + leg.diode_V))) / at_V + leg.switched_A;
      suffices_ = std::abs(wanted_A - at_A) <= kNear * std::abs(wanted_A);
      if (suffices_) break;
      at_A = wanted_A;
    }
    battery_.Expect(current_A_);
  }

  void FlyLeg(const MissionLeg& leg) {
    const bool endless = !std::isfinite(leg.duration_s);
    const double steps = endless ? std::numeric_limits<double>::infinity()
                                 : std::max(1.0, std::ceil(leg.duration_s / step_s_ - kRounding_s));
    const double dt_s = endless ? step_s_ : leg.duration_s / steps;
    const double begin_s = result_.time_s;
    // The current of another leg says nothing of how this one's changes.
    if (steps_flown_ == 0.0) before_A_ = std::numeric_limits<double>::quiet_NaN();
    for (double k = std::exchange(steps_flown_, 0.0); k < steps && !ended_; k += 1.0) {
      result_.time_s = begin_s + k * dt_s;
      if (result_.time_s >= setup_.options.longest_s) return Finish(MissionEnd::kTimeLimit, leg);
      Step(leg, dt_s);
      if (!ended_) result_.time_s = begin_s + (k + 1.0) * dt_s;
    }
  }

  void Step(const MissionLeg& leg, double dt_s) {
    Draw(leg);
    result_.minimum_voltage_V = std::min(result_.minimum_voltage_V, voltage_V_);
    result_.peak_current_A = std::max(result_.peak_current_A, current_A_);
    const double begin_A = current_A_;
    const double mean_A =
        suffices_ && std::isfinite(before_A_) ? begin_A + 0.5 * (begin_A - before_A_) : begin_A;
    before_A_ = begin_A;
    const double spare_C = (battery_.rest_soc() - setup_.reserve) * battery_.capacity_C();
    const bool at_reserve = mean_A * dt_s >= spare_C && mean_A > 0.0;
    if (at_reserve) dt_s = std::max(spare_C / mean_A, 1e-12);
    NoteLack(leg, dt_s);
    battery_.Advance(mean_A * dt_s, dt_s);
    result_.charge_C += mean_A * dt_s;
    result_.distance_m += leg.ground_speed_m_per_s * dt_s;
    result_.energy_J += voltage_V_ * begin_A * dt_s;
    if (warms_) result_.hottest_degC = std::max(result_.hottest_degC, battery_.temperature_degC());
    below_motors_s_ = voltage_V_ < leg.least_V ? below_motors_s_ + dt_s : 0.0;
    below_cutoff_s_ = voltage_V_ < battery_.cutoff_V() ? below_cutoff_s_ + dt_s : 0.0;
    constexpr double kMore = 0.05;  // than full, or than the pack began with
    const double fullest = std::max(1.0, setup_.initial_soc) + kMore;
    std::optional<MissionEnd> end;
    if (mean_A < 0.0 && battery_.rest_soc() > fullest) {
      end = MissionEnd::kFull;
    } else if (at_reserve) {
      end = MissionEnd::kReserve;
    } else if (EmptyAfter(without_power_s_) || (!suffices_ && battery_.soc() <= 0.0)) {
      end = MissionEnd::kPower;
    } else if (battery_.soc() <= 0.0) {
      end = MissionEnd::kEmpty;
    } else if (EmptyAfter(below_motors_s_)) {
      end = MissionEnd::kMotorVoltage;
    } else if (EmptyAfter(below_cutoff_s_)) {
      end = MissionEnd::kCutOff;
    }
    if (!end) return;
    result_.time_s += dt_s;
    Finish(*end, leg);
  }

  // Of a step that begins now, after Draw().
  void NoteLack(const MissionLeg& leg, double dt_s) {
    if (suffices_) {
      without_power_s_ = 0.0;
      return;
    }
    if (without_power_s_ == 0.0)
      lack_ = {result_.time_s, leg.power_W + leg.drive_W, voltage_V_ * current_A_};
    if (!result_.lack) result_.lack = lack_;
    without_power_s_ += dt_s;
    result_.lack_s += dt_s;
  }

  void Finish(MissionEnd end, const MissionLeg& leg) {
    ended_ = true;
    result_.ended_by = end;
    if (end == MissionEnd::kPower) result_.lack = lack_;
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
  bool far_ = false;
  double step_s_ = 0.0;
  double steps_flown_ = 0.0;                                    // of the leg, by lanes
  double before_A_ = std::numeric_limits<double>::quiet_NaN();  // at the beginning of the last step
  double voltage_V_ = 0.0;
  double current_A_ = 0.0;
  double without_power_s_ = 0.0;
  PowerLack lack_;  // the last one
  double below_motors_s_ = 0.0;
  double below_cutoff_s_ = 0.0;
  EnduranceResult result_;
};

void CheckSetup(const EnduranceSetup& setup) {
  const auto lasts = [](const MissionLeg& leg) {
    return leg.duration_s > 0.0 && std::isfinite(leg.power_W + leg.drive_W) && leg.diode_V >= 0.0 &&
           leg.switched_A >= 0.0;
  };
  const auto& legs = setup.mission.legs;
  Require(!legs.empty() && std::all_of(legs.begin(), legs.end(), lasts),
          "a mission of legs that last, each with a finite load");
  Require(setup.options.step_s >= 0.0 && setup.reserve < 1.0,
          "a step of at least 0 and a reserve below 1",
          {{"step_s", setup.options.step_s}, {"reserve", setup.reserve}});
}

// Modes and branches: of flights side by side as many in each.
bool AreAlike(const Cell& a, const Cell& b) {
  const auto terms = [](const Cell& cell) { return cell.diffusion ? cell.diffusion->terms : 0; };
  return terms(a) == terms(b) && a.branches.size() == b.branches.size();
}

}  // namespace

EnduranceResult FlyMission(const EnduranceSetup& setup) {
  CheckSetup(setup);
  Mission mission(setup);
  mission.Begin();
  return mission.Run();
}

std::vector<EnduranceResult> FlyMissions(std::span<const EnduranceSetup> setups) {
  std::vector<EnduranceResult> results(setups.size());
  for (std::size_t from = 0; from < setups.size(); from += kLanes) {
    const auto group = setups.subspan(from, std::min(kLanes, setups.size() - from));
    std::vector<Mission> missions;
    missions.reserve(group.size());
    std::vector<std::size_t> flown;  // side by side
    std::vector<const EnduranceSetup*> beside;
    std::vector<double> step_s;
    for (std::size_t k = 0; k < group.size(); ++k) {
      const EnduranceSetup& setup = group[k];
      CheckSetup(setup);
      missions.emplace_back(setup).Begin();
      if (missions[k].ended() || missions[k].far() || !FitsLanes(setup)) continue;
      if (!beside.empty() && !AreAlike(setup.cell, beside.front()->cell)) continue;
      flown.push_back(k);
      beside.push_back(&setup);
      step_s.push_back(missions[k].step_s());
    }
    if (!flown.empty()) {
      std::vector<MissionState> states = FlyLanes(beside, step_s);
      for (std::size_t n = 0; n < flown.size(); ++n)
        missions[flown[n]].Continue(std::move(states[n]));
    }
    for (std::size_t k = 0; k < group.size(); ++k) results[from + k] = missions[k].Run();
  }
  return results;
}

}  // namespace lipoid
