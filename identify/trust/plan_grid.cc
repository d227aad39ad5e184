#include "identify/trust/plan_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "identify/trust/trust_report.h"
#include "model/core/errors.h"
#include "model/core/stop.h"

namespace lipoid {

PlanGridResult PlanVariations(const Cell& cell,
                              const PlanGrid& grid,
                              const std::function<void(double)>& progress) {
  const auto rates =
      grid.rate_C.empty() ? std::vector<double>{HighestSuitableRate(cell)} : grid.rate_C;
  const std::size_t count =
      grid.pulse_s.size() * grid.rest_s.size() * rates.size() * grid.sampling_s.size();
  if (count > kMostVariations) {
    throw OptionError(fmt::format(
        "{} variations; at most {} at a time, so shorten a list", count, kMostVariations));
  }
  Require(count > 0, "a value in each list");
  const double shortest_s = *std::min_element(grid.sampling_s.begin(), grid.sampling_s.end());
  const Cell seen = AsSampled(cell, shortest_s);
  PlanGridResult result;
  for (const double rate : rates) {
    for (const double pulse : grid.pulse_s) {
      for (const double rest : grid.rest_s) {
        for (const double sampling : grid.sampling_s) {
          StopIfAsked();
          if (progress) {
            progress(static_cast<double>(result.variations.size()) / static_cast<double>(count));
          }
          SynthesisOptions options;
          options.pulse_rate_C = rate;
          options.pulse_s = pulse;
          options.rest_s = rest;
          options.sampling_s = sampling;
          result.variations.push_back(
              {rate, pulse, rest, sampling, PlanExperiment(seen, options, grid.noise)});
        }
      }
    }
  }
  result.left_out = LeftOutOfPlan(cell, shortest_s);
  return result;
}

Json PlanGridToJson(const Cell& cell, const PlanGrid& grid, const PlanGridResult& result) {
  Json rows = Json::array();
  for (const PlannedVariation& one : result.variations) {
    rows.push_back({{"rate_C", one.rate_C},
                    {"current_A", one.plan.current_A},
                    {"pulse_s", one.pulse_s},
                    {"rest_s", one.rest_s},
                    {"sampling_s", one.sampling_s},
                    {"duration_s", one.plan.duration_s},
                    {"rows", one.plan.rows},
                    {"parameters", TrustedParametersToJson(one.plan.trust)},
                    {"sentence", one.plan.trust.sentence}});
  }
  Json json = {{"cell", cell.name}};
  json["noise"] = {{"white_V", grid.noise.white_V},
                   {"coloured_V", grid.noise.coloured_V},
                   {"correlation_s", grid.noise.correlation_s}};
  json["rows"] = std::move(rows);
  json["left_out"] = result.left_out;
  return json;
}

}  // namespace lipoid
