#include "model/flight/endurance_report.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/statistics/interval_95.h"

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

Json EnduranceToJson(const EnduranceRequest& request, const EnduranceAnswer& answer) {
  Json json = EnduranceNumbersToJson(answer);
  const EnduranceResult& estimate = answer.estimate;
  json["carries_mission"] = IsFlight(estimate);
  json["rounds"] = estimate.rounds;
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
  return json;
}

}  // namespace lipoid
