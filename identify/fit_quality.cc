#include "identify/fit_quality.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/battery/cell_parameters.h"
#include "model/core/json.h"
#include "model/core/options.h"

namespace lipoid {
namespace {

// The grade is the worst that any quantity gives, and its reasons say which.
class Judgement {
 public:
  explicit Judgement(FitQuality& quality) : quality_(quality) {}

  void Count(FitGrade grade, std::string reason) {
    if (grade == FitGrade::kGood) return;
    if (grade > quality_.grade) {
      quality_.grade = grade;
      quality_.reasons.clear();  // the milder ones do not explain the grade
    }
    if (grade == quality_.grade) quality_.reasons.push_back(std::move(reason));
  }

 private:
  FitQuality& quality_;
};

void CountTimes(const std::vector<ConstantCurrentErrors>& times, Judgement& judgement) {
  const ConstantCurrentErrors* worst = nullptr;
  const auto error = [](const ConstantCurrentErrors& log) {
    return std::isfinite(log.error_percent) ? std::abs(log.error_percent)
                                            : 100.0 * kLongestDischarge;
  };
  for (const auto& log : times) {
    if (log.comes_back) continue;  // its voltages count
    if (worst == nullptr || error(log) > error(*worst)) worst = &log;
  }
  if (worst == nullptr) return;
  judgement.Count(
      GradeOf(error(*worst), kTimeLimits_percent),
      std::isfinite(worst->predicted_s)
          ? fmt::format("at {:.3g} A it predicts {:.4g} s until the cut-off, where {:.4g} s were "
                        "measured",
                        worst->current_A,
                        worst->predicted_s,
                        worst->measured_s)
          : fmt::format("at {:.3g} A it never reaches the cut-off, where {:.4g} s were measured",
                        worst->current_A,
                        worst->measured_s));
}

// alpha is the charge down to the cut-off, by definition.
void CountCutoff(const Cell& cell, Judgement& judgement) {
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  // From there the curve goes on with its slope. v_oc(A) falls ever faster, so that it is down there no later.
  const auto& lowest = curve.below();
  const double above_V = lowest.value_V - cell.cutoff_V;
  if (!(above_V <= kReachedCutoff_V)) return;
  const double soc = above_V > 0.0 && lowest.slope_V > 0.0
                         ? curve.soc_lo() - above_V / lowest.slope_V
                         : std::max(curve.SocAtVoltage(cell.cutoff_V), curve.soc_lo());
  judgement.Count(
      GradeOf(soc, kCutoffLimits),
      fmt::format(
          "v_oc(A) is down to the cut-off of {:.4g} V at a state of charge of {:.2f}, so that "
          "alpha, {:.3g} Ah, is not the charge that these logs show: look at initial_soc and "
          "at where alpha is from",
          cell.cutoff_V,
          soc,
          cell.alpha_C() / 3600.0));
}

void CountDrop(const Cell& cell, Judgement& judgement) {
  constexpr double kHalf = 0.5;
  const double resistance_Ohm = SeriesAndBranches(cell, kHalf);
  const double one_C_A = cell.alpha_C() / 3600.0;
  const double room_V = cell.open_circuit_voltage(kHalf) - cell.cutoff_V;
  judgement.Count(
      GradeOf(one_C_A * resistance_Ohm / std::max(room_V, 1e-3), kDropLimits),
      fmt::format(
          "r_s and the branches have {:.3g} Ohm at half charge, which at 1C takes {:.3g} V of the "
          "{:.3g} V above the cut-off: they stand in for something that these logs do not "
          "tell apart from them",
          resistance_Ohm,
          one_C_A * resistance_Ohm,
          room_V));
}

}  // namespace

FitGrade GradeOf(double value, const GradeLimits& limits) {
  if (value <= limits.good) return FitGrade::kGood;
  return value <= limits.fair ? FitGrade::kFair : FitGrade::kPoor;
}

std::string FitQuality::Sentence(std::string_view what) const {
  std::string text = fmt::format("predicts {} to {:.3g} mV ({:.2g} %): {}",
                                 what,
                                 1e3 * rmse_V,
                                 mean_error_percent,
                                 options_internal::ToText(grade));
  if (!reasons.empty()) text += fmt::format(": {}", fmt::join(reasons, "; "));
  return text;
}

void FitQuality::Doubt(std::string reason, FitGrade at_least) {
  grade = std::max(grade, at_least);
  reasons.push_back(std::move(reason));
}

FitQuality JudgeErrors(double rmse_V, double mean_error_percent) {
  FitQuality quality{.grade = FitGrade::kGood,
                     .rmse_V = rmse_V,
                     .mean_error_percent = mean_error_percent,
                     .reasons = {}};
  Judgement judgement(quality);
  judgement.Count(GradeOf(quality.mean_error_percent, kMeanErrorLimits_percent),
                  fmt::format("a mean error of {:.3g} %; up to {:g} % is good, up to {:g} % fair",
                              quality.mean_error_percent,
                              kMeanErrorLimits_percent.good,
                              kMeanErrorLimits_percent.fair));
  judgement.Count(GradeOf(quality.rmse_V, kRmseLimits_V),
                  fmt::format("{:.4g} mV rms; up to {:g} mV is good, up to {:g} mV fair",
                              1e3 * quality.rmse_V,
                              1e3 * kRmseLimits_V.good,
                              1e3 * kRmseLimits_V.fair));
  return quality;
}

FitQuality JudgeFit(const Cell& cell,
                    const std::vector<LogErrors>& fitted,
                    const std::vector<ConstantCurrentErrors>& times,
                    double moved_C,
                    double nominal_Ah,
                    AlphaOf alpha_of) {
  double squares = 0.0;
  double mean_error_percent = 0.0;
  for (const LogErrors& log : fitted) {
    squares += log.all.rmse * log.all.rmse / static_cast<double>(fitted.size());
    mean_error_percent += log.all.mean_error_percent / static_cast<double>(fitted.size());
  }
  FitQuality quality = JudgeErrors(std::sqrt(squares), mean_error_percent);
  Judgement judgement(quality);
  CountTimes(times, judgement);
  std::vector<Edge> edges;
  for (const LogErrors& log : fitted) edges.insert(edges.end(), log.edges.begin(), log.edges.end());
  quality.edges = GroupEdges(edges);
  if (auto doubt = DoubtAboutEdges(quality.edges); !doubt.empty())
    judgement.Count(FitGrade::kFair, std::move(doubt));
  const double alpha_Ah = cell.alpha_C() / 3600.0;
  if (nominal_Ah > 0.0) {
    judgement.Count(
        GradeOf(std::max(alpha_Ah / nominal_Ah, nominal_Ah / alpha_Ah), kCapacityLimits),
        fmt::format("alpha is {:.3g} Ah for a cell of {:.4g} Ah", alpha_Ah, nominal_Ah));
  }
  judgement.Count(
      GradeOf(moved_C / cell.alpha_C(), kMovedLimits),
      fmt::format("alpha is {:.3g} Ah, less than the {:.3g} Ah below full that a log reaches",
                  alpha_Ah,
                  moved_C / 3600.0));
  const OpenCircuitVoltage& curve = cell.open_circuit_voltage;
  const double empty_V = curve(std::max(0.0, curve.soc_lo()));
  const double full_V = curve(std::min(1.0, curve.soc_hi()));
  const bool possible =
      empty_V >= kLowestOpenCircuit_V && full_V <= kHighestOpenCircuit_V && empty_V < full_V;
  judgement.Count(
      possible ? FitGrade::kGood : FitGrade::kPoor,
      fmt::format("v_oc(A) runs from {:.3g} to {:.3g} V, which no cell does", empty_V, full_V));
  if (possible && alpha_of == AlphaOf::kTheseLogs) {
    CountCutoff(cell, judgement);
    CountDrop(cell, judgement);
  }
  return quality;
}

Json FitQualityToJson(const FitQuality& quality) {
  return {{"grade", options_internal::ToText(quality.grade)},
          {"rmse_V", NumberOrNull(quality.rmse_V)},
          {"mean_error_percent", NumberOrNull(quality.mean_error_percent)},
          {"reasons", quality.reasons}};
}

Json FitToJson(const FitQuality& quality) {
  return {{"verdict", options_internal::ToText(quality.grade)},
          {"mean_error_percent", NumberOrNull(quality.mean_error_percent)},
          {"rmse_V", NumberOrNull(quality.rmse_V)},
          {"reason", fmt::format("{}", fmt::join(quality.reasons, "; "))}};
}

}  // namespace lipoid
