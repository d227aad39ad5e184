#include "model/flight/endurance_report.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "model/battery/cell_ensemble.h"
#include "model/battery/curve_range.h"
#include "model/battery/temperature_range.h"
#include "model/statistics/interval_95.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

constexpr double kSecondsPerHour = 3600.0;

constexpr EnduranceNumber kNumbers[] = {
    {"minutes", "flight time / min", [](const EnduranceResult& r) { return r.time_s / 60.0; }},
    {"charge_Ah",
     "charge used / Ah",
     [](const EnduranceResult& r) { return r.charge_C / kSecondsPerHour; }},
    {"energy_Wh",
     "energy used / Wh",
     [](const EnduranceResult& r) { return r.energy_J / kSecondsPerHour; }},
    {"landing_voltage_V",
     "voltage at landing, under load / V",
     [](const EnduranceResult& r) { return r.landing_voltage_V; }},
    {"landing_rest_voltage_V",
     "voltage after landing, rested / V",
     [](const EnduranceResult& r) { return r.landing_rest_voltage_V; }},
    {"minimum_voltage_V",
     "lowest voltage / V",
     [](const EnduranceResult& r) { return r.minimum_voltage_V; }},
    {"peak_current_A",
     "highest current / A",
     [](const EnduranceResult& r) { return r.peak_current_A; }},
    {"remaining_soc",
     "share of the charge left",
     [](const EnduranceResult& r) { return r.rest_soc; }},
    {"range_km",
     "way over the ground / km",
     [](const EnduranceResult& r) {
       return r.distance_m > 0.0 ? 1e-3 * r.distance_m : std::numeric_limits<double>::quiet_NaN();
     }},
    {"hottest_degC",
     "hottest cell / degC",
     [](const EnduranceResult& r) { return r.hottest_degC; }},
};

Json UncertainToJson(const Uncertain& number) {
  return {{"value", number.value}, {"standard_error", number.standard_error}};
}

Json EndsToJson(const std::vector<EnduranceResult>& flights) {
  Json ends = Json::object();
  for (const EnduranceResult& flight : flights) {
    Json& count = ends[options_internal::ToText(flight.ended_by)];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  return ends;
}

Json LevelFlightToJson(const LevelFlight& flight) {
  return {{"airspeed_m_per_s", flight.airspeed_m_per_s},
          {"tilt_rad", flight.tilt_rad},
          {"thrust_N", flight.thrust_N},
          {"rotor_speed_rad_per_s", flight.speed_rad_per_s},
          {"motor_V", flight.motor_V},
          {"motor_A", flight.motor_A},
          {"least_battery_V", flight.battery_V},
          {"shaft_W", flight.shaft_W},
          {"induced_W", NumberOrNull(flight.induced_W)},
          {"profile_W", NumberOrNull(flight.profile_W)},
          {"parasite_W", flight.parasite_W},
          {"advance_ratio", flight.advance_ratio},
          {"figure_of_merit", NumberOrNull(flight.figure_of_merit)}};
}

Json SpeedsToJson(const BestSpeeds& speeds) {
  return {{"best_endurance_m_per_s", speeds.endurance.airspeed_m_per_s},
          {"best_range_m_per_s", speeds.range.airspeed_m_per_s},
          {"fastest_m_per_s", speeds.fastest_m_per_s}};
}

// What a volt of the rested pack is worth near this state of charge.
double ChargePerVolt(const Cell& cell, double soc) {
  constexpr double kBeside = 0.05;
  const auto& curve = cell.open_circuit_voltage;
  return 2.0 * kBeside / (cell.series * (curve(soc + kBeside) - curve(soc - kBeside)));
}

// When to land. Where the load varies, or a cold pack warms, the voltage under load was as low before, and
// where the curve is flat what is printed stands for much of the charge.
std::string LandWhen(const EnduranceRequest& request, const EnduranceResult& result) {
  constexpr double kHalfDigit_V = 0.005;
  constexpr double kMostOfRounding = 0.02;
  constexpr double kMostBefore = 0.01;
  const double per_V = ChargePerVolt(request.cell, result.rest_soc);
  const double before_V = result.landing_voltage_V - result.minimum_voltage_V;
  const bool fine = kHalfDigit_V * per_V <= kMostOfRounding;
  if (fine && before_V * per_V <= kMostBefore)
    return fmt::format("land when the battery falls to {:.2f} V in flight.",
                       result.landing_voltage_V);
  if (!fine) {
    return fmt::format(
        "land when {:.0f} mAh are used; the pack then rests at {:.3f} V. The voltage in flight does not tell it: "
        "0.01 V are {:.0f} % of the charge there.",
        1e3 * result.charge_C / kSecondsPerHour,
        result.landing_rest_voltage_V,
        std::min(100.0, 100.0 * 2.0 * kHalfDigit_V * per_V));
  }
  return fmt::format(
      "land when {:.0f} mAh are used; the pack then rests at {:.2f} V. The voltage in flight does not tell it: "
      "{:.2f} V at the end, and down to {:.2f} V before.",
      1e3 * result.charge_C / kSecondsPerHour,
      result.landing_rest_voltage_V,
      result.landing_voltage_V,
      result.minimum_voltage_V);
}

// Why the flight ended, as a sentence.
std::string Reason(const EnduranceRequest& request, const EnduranceAnswer& answer) {
  const EnduranceResult& result = answer.estimate;
  switch (result.ended_by) {
    case MissionEnd::kReserve:
      return fmt::format("The reserve of {:g} % of the charge was reached: {}",
                         100.0 * request.reserve.value,
                         LandWhen(request, result));
    case MissionEnd::kCutOff:
      return fmt::format(
          "The battery was below its cut-off of {:.4g} V for a second, with {:.1f} % "
          "of its charge left.",
          request.cell.series * request.cell.cutoff_V,
          100.0 * result.rest_soc);
    case MissionEnd::kEmpty:
      return fmt::format(
          "The charge that is available at this current was used up, with {:.1f} % "
          "held back by diffusion.",
          100.0 * result.rest_soc);
    case MissionEnd::kMotorVoltage: {
      const auto volts = [](double voltage_V, int digits) {
        return fmt::format("{:.{}f} V", voltage_V, digits);
      };
      constexpr int kMostDigits = 6;
      const double needed_V = answer.flight.battery_V;
      const double given_V = result.landing_voltage_V;
      int digits = 2;  // as many as tell the two apart
      while (digits < kMostDigits && volts(needed_V, digits) == volts(given_V, digits)) ++digits;
      return fmt::format("The motors need {}more than the {} that the battery gives under load.",
                         request.power ? "" : volts(needed_V, digits) + ", ",
                         volts(given_V, digits));
    }
    case MissionEnd::kPower:
      return fmt::format(
          "The pack cannot give the {:.4g} W that the mission takes at {:.6g} s: {:.4g} W is the most that any "
          "of its currents gives.",
          result.lack->power_W,
          result.lack->since_s,
          result.lack->most_W);
    case MissionEnd::kMissionDone:
      return "The mission was flown to its end.";
    case MissionEnd::kFull:
      return fmt::format(
          "The powers of the mission charge the pack beyond full, to {:.3g} of its charge: negative "
          "power is power that flows back.",
          result.rest_soc);
    case MissionEnd::kTimeLimit:
      return fmt::format("The battery was not empty after {:g} s; --set longest_s allows more.",
                         request.options.longest_s);
  }
  return "";
}

// Peaks that did not end the flight; "": none.
std::string PassedOver(const EnduranceResult& result) {
  if (!result.lack || result.ended_by == MissionEnd::kPower) return "";
  return fmt::format(
      "The pack cannot give the {:.4g} W that the mission takes at {:.6g} s, {:.4g} W at most. Such peaks last "
      "{:.3g} s in all; none ended the flight, because each is shorter than a second, and what the pack cannot "
      "give is not counted as used.",
      result.lack->power_W,
      result.lack->since_s,
      result.lack->most_W,
      result.lack_s);
}

Json LackToJson(const EnduranceResult& result) {
  if (!result.lack) return nullptr;
  return {{"since_s", result.lack->since_s},
          {"power_W", result.lack->power_W},
          {"most_W", NumberOrNull(result.lack->most_W)},
          {"total_s", result.lack_s}};
}

// Draws that stop at the ends of their ranges may all lie on one side of the estimate; "": they do not.
std::string OutsideInterval(const EnduranceAnswer& answer) {
  const EnduranceNumber& minutes = kNumbers[0];
  const double estimate = minutes.of(answer.estimate);
  const auto interval = IntervalOf(answer, minutes);
  if (!interval || (interval->first <= estimate && estimate <= interval->second)) return "";
  return fmt::format(
      "the interval of the flight time, {:.4g} to {:.4g} min, leaves out the estimate of {:.4g} min: the "
      "uncertainties are so wide that what is drawn from them is not like the cell; identify it with more "
      "logs, or give smaller standard errors",
      interval->first,
      interval->second,
      estimate);
}

}  // namespace

std::span<const EnduranceNumber> EnduranceNumbers() { return kNumbers; }

std::optional<std::pair<double, double>> IntervalOf(const EnduranceAnswer& answer,
                                                    const EnduranceNumber& number) {
  std::vector<double> values;
  for (const EnduranceResult& flight : answer.flights) {
    const double value = number.of(flight);
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return std::nullopt;
  return Interval95(values);
}

Json EnduranceNumbersToJson(const EnduranceAnswer& answer) {
  Json json = Json::object();
  for (const EnduranceNumber& number : kNumbers) {
    const std::string key(number.key);
    json[key] = NumberOrNull(number.of(answer.estimate));
    const auto interval = IntervalOf(answer, number);
    json[key + "_interval_95"] =
        interval ? Json({interval->first, interval->second}) : Json(nullptr);
  }
  json["ended_by"] = options_internal::ToText(answer.estimate.ended_by);
  return json;
}

std::vector<std::string> EnduranceSentences(const EnduranceRequest& request,
                                            const EnduranceAnswer& answer) {
  std::vector<std::string> sentences;
  if (!IsFlight(answer.estimate)) {
    sentences.push_back(fmt::format(
        "This pack cannot carry this mission: the flight ends after {:.2g} s. Give more cells "
        "(--series, --parallel) or a fuller pack, or take less payload or power{}.",
        answer.estimate.time_s,
        request.airspeed_m_per_s
            ? ", or fly slower (--airspeed-m-per-s; --mission cruise says how fast this vehicle flies at most)"
            : ""));
  }
  sentences.push_back(Reason(request, answer));
  if (std::string peaks = PassedOver(answer.estimate); !peaks.empty())
    sentences.push_back(std::move(peaks));
  if (answer.speeds) {
    sentences.push_back(
        fmt::format("At {:.1f} m/s. It flies longest at {:.1f} m/s, farthest at {:.1f} m/s, and no "
                    "faster than {:.1f} m/s.",
                    answer.flight.airspeed_m_per_s,
                    answer.speeds->endurance.airspeed_m_per_s,
                    answer.speeds->range.airspeed_m_per_s,
                    answer.speeds->fastest_m_per_s));
  }
  return sentences;
}

namespace {

// A value that is drawn beyond its range is put to the end of it; where many are, the interval is one of the range.
std::string DoubtAboutDraws(const EnduranceVariable& variable, const Uncertain& number) {
  constexpr double kMany = 0.05;
  if (number.known()) return "";
  const Range valid{variable.valid.lo * variable.unit, variable.valid.hi * variable.unit};
  const auto beyond = [&](double by) {
    return 0.5 * std::erfc(by / number.standard_error / std::numbers::sqrt2);
  };
  const double share = beyond(number.value - valid.lo) + beyond(valid.hi - number.value);
  if (!(share > kMany)) return "";
  return fmt::format(
      "{:.0f} % of the values of {} drawn lie beyond {:g} to {:g}, and are put to the ends of that range: the "
      "intervals are those of what is left; give a smaller standard error",
      100.0 * share,
      variable.name,
      variable.valid.lo,
      variable.valid.hi);
}

}  // namespace

std::vector<std::string> EnduranceDoubts(const EnduranceRequest& request,
                                         const EnduranceAnswer& answer) {
  std::vector<std::string> doubts;
  const auto add = [&](std::string doubt) {
    if (!doubt.empty()) doubts.push_back(std::move(doubt));
  };
  add(DoubtAboutPack(request.vehicle, request.cell.series));
  add(DoubtAboutSize(request.cell, request.size_factor));
  if (request.uncertain()) {
    const std::string few = DoubtAboutFew(answer.flights.size(), "flights");
    add(few.empty() ? OutsideInterval(answer) : few);
  } else {
    add(fmt::format(
        "no intervals: {} does not say how uncertain it is, and no value was given as X+-SE",
        request.cell.name));
  }
  EnduranceRequest asked = request;
  for (const EnduranceVariable& variable : EnduranceVariables())
    add(DoubtAboutDraws(variable, variable.of(asked)));
  if (request.ambient_degC) {
    const double degC = request.ambient_degC->value;
    add(DoubtAboutTemperature(request.cell, degC, degC));
  }
  if (request.power) {
    for (const std::string& doubt : request.power->doubts) add(doubt);
    if (request.power->repeats && request.power->way_back_m > 0.0 && answer.estimate.rounds > 0) {
      add(fmt::format(
          "the route ends {:.4g} m from where it begins, and each of its {} rounds begins there all the same: the "
          "way back costs nothing here. Let it end where it begins, or fly it once",
          request.power->way_back_m,
          answer.estimate.rounds + 1));
    }
  }
  add(DoubtAboutCurve(request.cell, answer.estimate.soc, request.initial_soc));
  add(DoubtAboutMoved(static_cast<std::size_t>(answer.moved), answer.flights.size()));
  if (request.cell.open_circuit_voltage_assumed) {
    add(fmt::format("the open-circuit voltage of {} is a typical one, not measured",
                    request.cell.name));
  }
  return doubts;
}

Json EnduranceToJson(const EnduranceRequest& request, const EnduranceAnswer& answer) {
  Json json = EnduranceNumbersToJson(answer);
  const EnduranceResult& estimate = answer.estimate;
  json["carries_mission"] = IsFlight(estimate);
  json["rounds"] = estimate.rounds;
  json["power_lack"] = LackToJson(estimate);
  json["initial_voltage_V"] = estimate.initial_voltage_V;
  json["initial_current_A"] = estimate.initial_current_A;
  json["initial_power_W"] = estimate.initial_voltage_V * estimate.initial_current_A;
  json["level_flight"] = request.power ? Json(nullptr) : LevelFlightToJson(answer.flight);
  json["speeds"] = answer.speeds ? SpeedsToJson(*answer.speeds) : Json(nullptr);
  json["ensemble"] = answer.flights.empty()
                         ? Json(nullptr)
                         : Json({{"flights", answer.flights.size()},
                                 {"seed", request.seed},
                                 {"cells_drawn", request.cell.uncertainty.has_value()},
                                 {"moved", answer.moved},
                                 {"ended_by", EndsToJson(answer.flights)}});
  json["vehicle"] = request.power ? Json(nullptr) : Json(request.vehicle.name);
  json["cell"] = request.cell.name;
  json["capacity_Ah"] = request.size_factor * request.cell.capacity_Ah;
  json["alpha_Ah"] = request.size_factor * request.cell.alpha_C() / 3600.0;
  json["series"] = request.cell.series;
  json["parallel"] = request.cell.parallel;
  json["cutoff_V"] = request.cell.series * request.cell.cutoff_V;
  json["temperature_assumed"] = request.cell.temperature_assumed;
  json["payload_kg"] = UncertainToJson(request.payload_kg);
  json["ambient_degC"] =
      request.ambient_degC ? UncertainToJson(*request.ambient_degC) : Json(nullptr);
  json["health"] = UncertainToJson(request.health);
  json["resistance_factor"] = UncertainToJson(request.resistance_factor);
  json["power_factor"] = UncertainToJson(request.power_factor);
  json["airspeed_m_per_s"] =
      request.airspeed_m_per_s ? UncertainToJson(*request.airspeed_m_per_s) : Json(nullptr);
  json["reserve"] = UncertainToJson(request.reserve);
  json["sentences"] = EnduranceSentences(request, answer);
  json["messages"] = EnduranceDoubts(request, answer);
  return json;
}

}  // namespace lipoid
