#include "identify/trust/plan_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "identify/trust/campaign_plan.h"
#include "identify/trust/trust_report.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/stop.h"

namespace lipoid {

namespace {

std::string Within(const QuantityTrust& quantity) {
  return fmt::format("{:.2g} %", 100.0 * Reach95(quantity) / std::abs(quantity.estimate));
}

// The same experiment twice would be two rows of one.
void RefuseCopies(const char* name, const std::vector<double>& values) {
  for (auto value = values.begin(); value != values.end(); ++value) {
    if (std::find(values.begin(), value, *value) == value) continue;
    std::string option = name;
    std::replace(option.begin(), option.end(), '_', '-');
    throw OptionError(fmt::format("option --{}: {} stands there twice", option, *value));
  }
}

// What the second temperature tells, against the same campaign without.
std::string WhatItAdds(const PlannedVariation& with, const PlannedVariation& without) {
  std::vector<std::string> gains;
  for (const QuantityTrust& after : with.plan.trust.quantities) {
    if (!OfTemperature(after.name) || !std::isfinite(after.standard_error)) continue;
    const QuantityTrust* before = FindQuantity(without.plan.trust, after.name);
    const bool known = before != nullptr && std::isfinite(before->standard_error);
    gains.push_back(fmt::format("{} within {}{}",
                                after.name,
                                Within(after),
                                known ? fmt::format(" ({} without)", Within(*before)) : ""));
  }
  const std::string what =
      fmt::format("{} at {:g} degC",
                  with.second == SecondPulses::kOne ? "one pulse" : "the same pulses",
                  with.second_degC);
  if (gains.empty())
    return fmt::format("{} would tell no activation energy; {}", what, with.plan.trust.sentence);
  return fmt::format(
      "{} would tell {} (95 %); {}", what, fmt::join(gains, ", "), with.plan.trust.sentence);
}

// Root mean square over the logs of a number of the run record that each of them has.
std::optional<double> RootMeanSquare(const Cell& cell, const char* logs, const char* key) {
  if (!cell.run) return std::nullopt;
  const Json::json_pointer place(logs);
  if (!cell.run->contains(place) || !cell.run->at(place).is_array()) return std::nullopt;
  double sum = 0.0;
  int count = 0;
  for (const Json& log : cell.run->at(place)) {
    if (!log.is_object()) continue;
    const auto value = log.find(key);
    if (value == log.end() || !value->is_number()) continue;
    sum += value->get<double>() * value->get<double>();
    ++count;
  }
  const double rms = std::sqrt(sum / count);
  return std::isfinite(rms) ? std::optional(rms) : std::nullopt;
}

// What the fit left of the logs: slow where the next rows have it, too, else the noise of single rows.
struct LeftByFit {
  double white_V = 0.0;
  double slow_V = 0.0;
};

LeftByFit ErrorsOfFit(const Cell& cell) {
  // Above a tenth of the charge: near empty a cell is steep, and there no pulse tells much.
  const double all_V = RootMeanSquare(cell, "/metrics/logs", "rmse_V_above_10_soc").value_or(0.0);
  const double white_V = std::min(
      all_V, RootMeanSquare(cell, "/metrics/trust/residual_correlation", "white_V").value_or(0.0));
  return {.white_V = white_V, .slow_V = std::sqrt(all_V * all_V - white_V * white_V)};
}

class Variations {
 public:
  Variations(const Cell& cell, const PlanGrid& grid, const std::function<void(double)>& progress)
      : grid_(grid), progress_(progress), ambients_degC_(grid.ambient_degC) {
    result_.noise = grid.noise;
    if (grid.coloured_noise_V) {
      result_.noise.coloured_V = *grid.coloured_noise_V;
      result_.slow_errors = SlowErrors::kGiven;
    } else {
      const LeftByFit left = ErrorsOfFit(cell);
      result_.white_of_fit = left.white_V > result_.noise.white_V;
      if (result_.white_of_fit) result_.noise.white_V = left.white_V;
      if (left.slow_V > result_.noise.coloured_V) {
        result_.noise.coloured_V = left.slow_V;
        result_.slow_errors = SlowErrors::kOfFit;
      }
    }
    result_.temperature =
        cell.temperature || !grid.ambient_degC.empty() || !grid.second_degC.empty();
    const bool assume = result_.temperature && !cell.temperature;
    cell_ = assume ? WithTypicalTemperature(cell) : cell;
    result_.temperature_assumed = result_.temperature && cell_.temperature_assumed;
    if (!result_.temperature) return;
    if (ambients_degC_.empty())
      ambients_degC_.push_back(cell_.temperature->reference_K - kZeroCelsius_K);
    seconds_degC_ = grid.second_degC;
    if (!seconds_degC_.empty()) return;
    const double coldest_degC = *std::min_element(ambients_degC_.begin(), ambients_degC_.end());
    for (const double below_K : kSecondBelow_K) seconds_degC_.push_back(coldest_degC - below_K);
  }

  PlanGridResult Run() {
    PlanGrid::Visit(grid_, [](const char* name, const auto& value, const auto&, const char*) {
      if constexpr (std::is_same_v<decltype(value), const std::vector<double>&>)
        RefuseCopies(name, value);
    });
    if (!(result_.noise.white_V > 0.0) && !(result_.noise.coloured_V > 0.0)) {
      throw OptionError(
          "options voltage_noise_V and coloured_noise_V: expected one above 0, found 0 V for both: without noise "
          "every experiment tells everything");
    }
    const double shortest_s = *std::min_element(grid_.sampling_s.begin(), grid_.sampling_s.end());
    const Cell seen = AsSampled(cell_, shortest_s);
    // As `lipoid synthesize` chooses it of the temperatures that were asked for; the second temperature that is
    // proposed follows it.
    auto asked_degC = ambients_degC_;
    asked_degC.insert(asked_degC.end(), grid_.second_degC.begin(), grid_.second_degC.end());
    const auto rates = grid_.rate_C.empty()
                           ? std::vector<double>{HighestSuitableRate(cell_, asked_degC)}
                           : grid_.rate_C;
    const std::size_t seconds =
        std::min(seconds_degC_.size(), std::max(grid_.second_degC.size(), std::size_t{1}));
    count_ = grid_.pulse_s.size() * grid_.rest_s.size() * rates.size() * grid_.sampling_s.size() *
             (1 + 2 * seconds);
    if (count_ > kMostVariations) {
      throw OptionError(fmt::format(
          "{} variations; at most {} at a time, so shorten a list", count_, kMostVariations));
    }
    Require(count_ > 0, "a value in each list");
    for (const double rate : rates) {
      for (const double pulse : grid_.pulse_s) {
        for (const double rest : grid_.rest_s) {
          for (const double sampling : grid_.sampling_s) {
            SynthesisOptions options;
            options.pulse_rate_C = rate;
            options.pulse_s = pulse;
            options.rest_s = rest;
            options.sampling_s = sampling;
            Add(seen, options);
          }
        }
      }
    }
    if (result_.variations.empty()) throw OptionError(refused_.front());
    result_.left_out = result_.temperature ? LeftOutOfCampaign(cell_, shortest_s)
                                           : LeftOutOfPlan(cell_, shortest_s);
    result_.left_out.insert(result_.left_out.begin(), refused_.begin(), refused_.end());
    if (grid_.rate_C.empty()) {
      result_.left_out.push_back(fmt::format(
          "the largest current that the cell may carry is not in its file: pulses of {:g}C ({:.3g} A) are chosen "
          "by the voltage alone; keep to the data sheet of the cell (--rate-C)",
          rates.front(),
          result_.variations.front().plan.current_A));
    }
    result_.terms_left_out = TermsLeftOut(cell_, !result_.temperature);
    if (result_.terms_left_out.empty()) return std::move(result_);
    for (PlannedVariation& one : result_.variations)
      one.plan.trust.sentence += fmt::format("; the plan says nothing of {}, which the cell has",
                                             fmt::join(result_.terms_left_out, ", "));
    return std::move(result_);
  }

 private:
  // None of an experiment that identify would refuse: it is no advice.
  PlannedVariation* Push(const SynthesisOptions& options, PlannedExperiment plan) {
    if (!plan.refused.empty()) {
      if (std::find(refused_.begin(), refused_.end(), plan.refused) == refused_.end())
        refused_.push_back(std::move(plan.refused));
      return nullptr;
    }
    result_.variations.push_back({options.pulse_rate_C,
                                  options.pulse_s,
                                  options.rest_s,
                                  options.sampling_s,
                                  std::move(plan),
                                  ambients_degC_});
    return &result_.variations.back();
  }

  void Tell() const {
    StopIfAsked();
    if (progress_)
      progress_(static_cast<double>(result_.variations.size()) / static_cast<double>(count_));
  }

  void Add(const Cell& seen, SynthesisOptions options) {
    Tell();
    if (!result_.temperature) {
      Push(options, PlanExperiment(seen, options, result_.noise));
      return;
    }
    const DecimalStep sampling = SamplingOf(options);
    options.ambient_degC = fmt::format("{}", fmt::join(ambients_degC_, ","));
    const std::vector<TestPlan> tests = ThesisProtocol(seen, options);
    const std::size_t first = result_.variations.size();
    if (Push(options, PlanCampaign(seen, tests, sampling, result_.noise)) == nullptr) return;
    const auto pulses = std::find_if(
        tests.begin(), tests.end(), [](const auto& test) { return test.kind == LogKind::kPulses; });
    for (const double second_degC : seconds_degC_) {
      const std::size_t before = result_.variations.size();
      for (const SecondPulses how : {SecondPulses::kAll, SecondPulses::kOne}) {
        Tell();
        std::vector<TestPlan> more = tests;
        more.push_back(AtAnotherTemperature(*pulses, second_degC));
        if (how == SecondPulses::kOne) more.back().cycles = 1;
        PlannedVariation* with = Push(options, PlanAddition(seen, more, sampling));
        if (with == nullptr) continue;
        with->second = how;
        with->second_degC = second_degC;
        with->plan.trust.sentence = WhatItAdds(*with, result_.variations[first]);
      }
      if (grid_.second_degC.empty() && result_.variations.size() > before) return;
    }
  }

  // A second temperature at which the cell gives no such pulses is left out.
  PlannedExperiment PlanAddition(const Cell& seen,
                                 const std::vector<TestPlan>& tests,
                                 const DecimalStep& sampling) const {
    try {
      return PlanCampaign(seen, tests, sampling, result_.noise);
    } catch (const OptionError& error) {
      PlannedExperiment none;
      none.refused = error.what();
      return none;
    }
  }

  const PlanGrid& grid_;
  const std::function<void(double)>& progress_;
  Cell cell_;
  std::vector<double> ambients_degC_;
  std::vector<double> seconds_degC_;
  std::size_t count_ = 0;
  std::vector<std::string> refused_;  // why an experiment is none
  PlanGridResult result_;
};

}  // namespace

PlanGridResult PlanVariations(const Cell& cell,
                              const PlanGrid& grid,
                              const std::function<void(double)>& progress) {
  return Variations(cell, grid, progress).Run();
}

std::string NoiseSentence(const PlanGridResult& result) {
  const PlannedNoise& noise = result.noise;
  std::string source;
  switch (result.slow_errors) {
    case SlowErrors::kGiven:
      break;
    case SlowErrors::kOfFit:
      source = ", which is what the fit left of the logs of this cell above 10 % of the charge";
      break;
    case SlowErrors::kAssumed:
      source =
          ", those of a good instrument: the file of this cell does not say that a model describes it worse, "
          "and most real cells are described to some millivolts (--coloured-noise-V)";
      break;
  }
  return fmt::format(
      "Assumed: noise of {:.3g} mV in each row{}, and slow errors of {:.3g} mV over {:g} s{}.",
      1e3 * noise.white_V,
      result.white_of_fit ? " (of the logs of this cell)" : "",
      1e3 * noise.coloured_V,
      noise.correlation_s,
      source);
}

Json PlanGridToJson(const Cell& cell, const PlanGridResult& result) {
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
    if (!result.temperature) continue;
    Json& row = rows.back();
    row["ambient_degC"] = one.ambient_degC;
    row["coldest_degC"] = one.plan.coldest_degC;
    row["warmest_degC"] = one.plan.warmest_degC;
    const bool more = one.second != SecondPulses::kNone;
    row["second_degC"] = more ? Json(one.second_degC) : Json();
    row["second_pulses"] = !more ? Json() : Json(one.second == SecondPulses::kOne ? "one" : "all");
  }
  Json json = {{"cell", cell.name}};
  json["noise"] = {{"white_V", result.noise.white_V},
                   {"coloured_V", result.noise.coloured_V},
                   {"coloured_from", options_internal::ToText(result.slow_errors)},
                   {"correlation_s", result.noise.correlation_s},
                   {"sentence", NoiseSentence(result)}};
  if (result.temperature) {
    json["noise"]["temperature_K"] = result.noise.temperature_K;
    json["temperature_assumed"] = result.temperature_assumed;
  }
  json["rows"] = std::move(rows);
  json["left_out"] = result.left_out;
  return json;
}

}  // namespace lipoid
