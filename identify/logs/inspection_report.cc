#include "identify/logs/inspection_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "model/core/counted.h"
#include "model/core/options.h"

namespace lipoid {
namespace {

Json ToJson(const Spread& spread) {
  return {{"least", spread.least}, {"median", spread.median}, {"largest", spread.largest}};
}

Json ToJson(const FlightFacts& flight) {
  return {{"vehicle", flight.vehicle},
          {"battery", flight.battery},
          {"batteries", flight.batteries},
          {"cells", flight.cells > 0 ? Json(flight.cells) : Json(nullptr)},
          {"capacity_Ah", NumberOrNull(flight.capacity_Ah)},
          {"voltage_update_s", flight.voltage_update_s},
          {"current_update_s", flight.current_update_s},
          {"messages", flight.messages},
          {"skipped_bytes", flight.skipped_bytes},
          {"damaged_places", flight.damaged_places},
          {"cut_last_message", flight.cut_last_message}};
}

}  // namespace

Json ReadingToJson(const LogReport& report) {
  Json gaps = Json::array();
  for (const Gap& gap : report.gaps) {
    gaps.push_back({{"row", gap.row},
                    {"start_s", gap.start_s},
                    {"length_s", gap.length_s},
                    {"unknown_C", gap.unknown_C}});
  }
  return {{"dropped_rows", report.dropped_rows()},
          {"dropped_repeated_times", report.dropped_repeated_times},
          {"dropped_unselected", report.dropped_unselected},
          {"dropped_cut_last_line", report.dropped_cut_last_line},
          {"dropped_spikes", report.dropped_spikes},
          {"dropped_unknown", report.dropped_unknown},
          {"gaps", std::move(gaps)},
          {"warnings", report.warnings},
          {"notes", report.notes}};
}

std::string DroppedText(const LogReport& report) {
  std::vector<std::string> parts;
  const auto add = [&](std::size_t rows, std::string_view why) {
    if (rows > 0) parts.push_back(fmt::format("{} {}", Counted(rows, "row"), why));
  };
  add(report.dropped_repeated_times, "with a repeated time stamp");
  add(report.dropped_unselected, "outside the chosen part");
  add(report.dropped_cut_last_line, "cut short at the end");
  add(report.dropped_spikes, "with a voltage or a current that cannot be");
  add(report.dropped_unknown, "whose voltage or current the autopilot did not know");
  return fmt::format("{}", fmt::join(parts, ", "));
}

Json InspectionToJson(const Inspection& log) {
  Json segments = Json::array();
  for (const Segment& segment : log.segments) {
    segments.push_back({{"kind", options_internal::ToText(segment.kind)},
                        {"first_row", segment.first},
                        {"last_row", segment.last},
                        {"start_s", segment.start_s},
                        {"end_s", segment.end_s},
                        {"current_A", segment.current_A},
                        {"charge_C", segment.charge_C}});
  }
  Json json = {{"file", log.file},
               {"format", log.report.format},
               {"rows", log.report.rows},
               {"duration_s", log.duration_s},
               {"sampling_s", ToJson(log.sampling_s)},
               {"current_sign", log.report.current_sign},
               {"current_sign_reason", log.report.current_sign_reason},
               {"current_sign_is_of_others", log.report.current_sign_is_of_others},
               {"current_A", ToJson(log.current_A)},
               {"voltage_V", log.voltage_V ? ToJson(*log.voltage_V) : Json(nullptr)},
               {"charge_out_C", log.charge_out_C},
               {"charge_in_C", log.charge_in_C},
               {"segments", std::move(segments)},
               {"suggested_kind", nullptr},
               {"suggested_kind_reason", log.suggestion.reason}};
  json.update(ReadingToJson(log.report));
  if (log.report.thinned) {
    const ThinningFacts& thinned = *log.report.thinned;
    json["thinned"] = {{"rows", thinned.rows},
                       {"most_rows", thinned.most_rows},
                       {"group", thinned.group},
                       {"tolerance_A", thinned.tolerance_A}};
  }
  if (log.report.flight) json["flight"] = ToJson(*log.report.flight);
  if (log.temperature_degC) json["temperature_degC"] = ToJson(*log.temperature_degC);
  if (log.suggestion.kind) json["suggested_kind"] = options_internal::ToText(*log.suggestion.kind);
  json["start_voltage_V"] = NumberOrNull(log.start_voltage_V);
  json["series"] = CellsInSeries(log);
  json["parts"] = Json::array();
  for (const Inspection& part : log.parts) {
    json["parts"].push_back(
        {{"start_s", part.part_start_s},
         {"end_s", part.part_end_s},
         {"charge_out_C", part.charge_out_C},
         {"start_voltage_V", NumberOrNull(part.start_voltage_V)},
         {"suggested_kind",
          part.suggestion.kind ? Json(options_internal::ToText(*part.suggestion.kind))
                               : Json(nullptr)}});
  }
  return json;
}

}  // namespace lipoid
