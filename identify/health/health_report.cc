#include "identify/health/health_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/stages/staged_report.h"
#include "identify/trust/trust_report.h"

namespace lipoid {
namespace {

Json IntervalOf(const WithInterval& value) {
  if (!value.known()) return nullptr;
  return {NumberOrNull(value.low), NumberOrNull(value.high)};
}

Json ValueOf(const WithInterval& value) {
  return value.known() ? NumberOrNull(value.value) : Json(nullptr);
}

Json Because(const WithInterval& value) {
  return value.known() ? Json(nullptr) : Json(value.unknown_because);
}

Json FlightToJson(const FlightHealth& flight) {
  const std::string doubt = DoubtAbout(flight);
  return {{"file", flight.file},
          {"duration_s", flight.duration_s},
          {"charge_Ah", flight.charge_Ah},
          {"soc_start", ValueOf(flight.soc_start)},
          {"soc_start_interval_95", IntervalOf(flight.soc_start)},
          {"soc_end", ValueOf(flight.soc_end)},
          {"soc_end_interval_95", IntervalOf(flight.soc_end)},
          {"capacity_Ah", ValueOf(flight.capacity_Ah)},
          {"capacity_interval_95", IntervalOf(flight.capacity_Ah)},
          {"counted_capacity_Ah", ValueOf(flight.counted_capacity_Ah)},
          {"counted_capacity_interval_95", IntervalOf(flight.counted_capacity_Ah)},
          {"capacity_unknown_because", Because(flight.capacity_Ah)},
          {"resistance_Ohm", ValueOf(flight.resistance_Ohm)},
          {"resistance_interval_95", IntervalOf(flight.resistance_Ohm)},
          {"new_resistance_Ohm", NumberOrNull(flight.new_resistance_Ohm)},
          {"counted_resistance_Ohm", ValueOf(flight.counted_resistance_Ohm)},
          {"counted_resistance_interval_95", IntervalOf(flight.counted_resistance_Ohm)},
          {"resistance_unknown_because", Because(flight.resistance_Ohm)},
          {"temperature_known", flight.temperature_known},
          {"converged", flight.converged},
          {"current_scale", ValueOf(flight.current_scale)},
          {"current_scale_interval_95", IntervalOf(flight.current_scale)},
          {"current_offset_A", ValueOf(flight.current_offset_A)},
          {"current_offset_interval_95", IntervalOf(flight.current_offset_A)},
          {"lag_s", ValueOf(flight.lag_s)},
          {"lag_interval_95", IntervalOf(flight.lag_s)},
          {"window_s", flight.window_s},
          {"coherence", NumberOrNull(flight.coherence)},
          {"mean_error_percent", NumberOrNull(flight.mean_error_percent)},
          {"max_error_percent", NumberOrNull(flight.max_error_percent)},
          {"doubted_because", doubt.empty() ? Json(nullptr) : Json(doubt)},
          {"same_rows_as", flight.same_rows_as.empty() ? Json(nullptr) : Json(flight.same_rows_as)},
          {"cautions", flight.cautions}};
}

Json TrendToJson(const std::optional<HealthTrend>& trend) {
  if (!trend) return nullptr;
  return {{"flights", trend->flights},
          {"first", NumberOrNull(trend->first.value)},
          {"first_interval_95", IntervalOf(trend->first)},
          {"last", NumberOrNull(trend->last.value)},
          {"last_interval_95", IntervalOf(trend->last)},
          {"change_percent", NumberOrNull(trend->change_percent.value)},
          {"change_percent_interval_95", IntervalOf(trend->change_percent)},
          {"per_flight_percent", NumberOrNull(trend->per_flight_percent.value)},
          {"per_flight_percent_interval_95", IntervalOf(trend->per_flight_percent)}};
}

std::string OneQuantity(
    const char* name, const WithInterval& value, double factor, const char* unit, double when_new) {
  if (!value.known()) return fmt::format("{} not known: {}", name, value.unknown_because);
  std::string text = fmt::format("{} {:.3g} {}", name, factor * value.value, unit);
  if (std::isfinite(when_new))
    text += fmt::format(" ({:.0f} % of new)", 100.0 * value.value / when_new);
  text +=
      fmt::format(", 95 % from {:.3g} to {:.3g} {}", factor * value.low, factor * value.high, unit);
  return text;
}

std::string OneTrend(const char* name, const std::optional<HealthTrend>& trend) {
  if (!trend) return "";
  const WithInterval& change = trend->change_percent;
  const auto shown = [](double percent) {
    return 0.1 * std::round(10.0 * percent) + 0.0;  // never -0
  };
  return fmt::format("{} changed by {:+.1f} % over {} flights, 95 % from {:+.1f} to {:+.1f} %",
                     name,
                     shown(change.value),
                     trend->flights,
                     shown(change.low),
                     shown(change.high));
}

}  // namespace

Json HealthToJson(const HealthReport& report) {
  Json flights = Json::array();
  for (const FlightHealth& flight : report.flights) flights.push_back(FlightToJson(flight));
  Json refused = Json::array();
  for (const Diagnostic& diagnostic : report.refused)
    refused.push_back({{"file", diagnostic.position.file}, {"reason", diagnostic.message}});
  Json trend = nullptr;
  if (report.capacity_trend || report.resistance_trend) {
    trend = {{"counted_capacity_Ah", TrendToJson(report.capacity_trend)},
             {"counted_resistance_Ohm", TrendToJson(report.resistance_trend)}};
  }
  return {{"reference",
           {{"name", report.reference},
            {"typical", report.typical},
            {"capacity_Ah", NumberOrNull(report.new_capacity_Ah)},
            {"resistance_Ohm", NumberOrNull(report.flights.back().new_resistance_Ohm)},
            {"reference_degC", report.reference_degC},
            {"activation_energy_J_per_mol", report.activation_energy_J_per_mol},
            {"temperature_assumed", report.temperature_assumed}}},
          {"sentences", FirstLines(report)},
          {"flights", std::move(flights)},
          {"refused", std::move(refused)},
          {"trend", std::move(trend)}};
}

Json FlightsAloneToJson(const FlightsAlone& found) {
  Json flights = Json::array();
  for (const auto& flight : found.flights) {
    Json row = LogErrorsToJson(flight.errors);
    row["initial_soc"] = flight.initial_soc;
    row["start_found"] = flight.start_found;
    row["lag_s"] = flight.lag_s;
    row["window_s"] = flight.window_s;
    row["coherence"] = NumberOrNull(flight.coherence);
    flights.push_back(std::move(row));
  }
  return {{"method", "flights"},
          {"converged", found.converged},
          {"flights",
           {{"fitted", std::move(flights)},
            {"averaged", found.Averaged()},
            {"lowest_soc", found.lowest_soc},
            {"highest_soc", found.highest_soc},
            {"total_resistance_Ohm", found.total_resistance_Ohm},
            {"cautions", found.cautions}}},
          {"parameters", TrustedParametersToJson(found.trust)},
          {"trust", TrustToJson(found.trust)}};
}

std::string DoubtAbout(const FlightHealth& flight) {
  if (!flight.doubted_because.empty() || flight.converged) return flight.doubted_because;
  return "the search did not converge: these numbers are where it stopped; give a flight that begins at rest "
         "and takes half of the charge";
}

bool IsDoubted(const HealthReport& report) {
  return std::any_of(report.flights.begin(), report.flights.end(), [](const FlightHealth& flight) {
    return !DoubtAbout(flight).empty();
  });
}

std::string HealthSentence(const HealthReport& report, const FlightHealth& flight) {
  constexpr double kMilli = 1e3;
  const std::string doubt = DoubtAbout(flight);
  const bool says_nothing = !flight.capacity_Ah.known() && !flight.resistance_Ohm.known();
  if (!doubt.empty() && says_nothing) return doubt;
  std::string text;
  if (!doubt.empty())
    text = fmt::format("{}{} By the fit: ", doubt, doubt.ends_with('?') ? "" : ".");
  text += OneQuantity("capacity", flight.capacity_Ah, 1.0, "Ah", report.new_capacity_Ah);
  text += "; ";
  text +=
      OneQuantity("resistance", flight.resistance_Ohm, kMilli, "mOhm", flight.new_resistance_Ohm);
  return text;
}

std::vector<std::string> FirstLines(const HealthReport& report) {
  std::vector<std::string> lines;
  std::vector<std::string> doubted;
  std::vector<std::string> stopped;
  for (const FlightHealth& flight : report.flights) {
    if (DoubtAbout(flight).empty()) continue;
    (flight.doubted_because.empty() ? stopped : doubted).push_back(flight.file);
  }
  const auto of_all = [&](const std::vector<std::string>& files) {
    return fmt::format("{} of {} flights", files.size(), report.flights.size());
  };
  if (!doubted.empty() && report.flights.size() > 1) {
    lines.push_back(fmt::format("{} {} no sense against {}: {}",
                                of_all(doubted),
                                doubted.size() == 1 ? "makes" : "make",
                                report.reference,
                                fmt::join(doubted, ", ")));
  }
  if (!stopped.empty() && report.flights.size() > 1) {
    lines.push_back(fmt::format(
        "the search did not converge for {}: {}", of_all(stopped), fmt::join(stopped, ", ")));
  }
  if (std::string trend = TrendSentence(report); !trend.empty()) lines.push_back(std::move(trend));
  const FlightHealth& last = report.flights.back();
  lines.push_back((report.flights.size() > 1 ? last.file + ": " : "") +
                  HealthSentence(report, last));
  return lines;
}

std::vector<std::string> FilesWithReasons(const std::vector<Diagnostic>& refused) {
  std::vector<std::string> sentences;
  for (const Diagnostic& one : refused)
    sentences.push_back(fmt::format("{}: {}", one.position.file, one.message));
  return sentences;
}

std::string TemperatureSentence(const HealthReport& report) {
  if (std::none_of(report.flights.begin(), report.flights.end(), [](const FlightHealth& flight) {
        return flight.temperature_known && flight.resistance_Ohm.known();
      }))
    return "";
  return fmt::format(
      "The resistance is that at {:g} degC, by the temperature of the flight and an activation energy of {:g} "
      "kJ/mol{}.",
      report.reference_degC,
      1e-3 * report.activation_energy_J_per_mol,
      report.temperature_assumed
          ? fmt::format(", a typical value that is assumed: {} knows no temperature",
                        report.reference)
          : fmt::format(", that of {}", report.reference));
}

std::string TrendSentence(const HealthReport& report) {
  std::string text = OneTrend("capacity", report.capacity_trend);
  const std::string resistance = OneTrend("resistance", report.resistance_trend);
  if (!text.empty() && !resistance.empty()) text += "; ";
  return text + resistance;
}

}  // namespace lipoid
