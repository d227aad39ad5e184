#pragma once

/// @file
/// One verdict on a fit: does the cell describe the logs that it was made from?
///
/// A fit can converge and still be absurd: a wrong cut-off, exchanged columns or a capacity in other
/// units leave parameters that predict nothing. All thresholds stand here.
/// Tests: tests/identify/fit_quality_test.cc.

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/constant_current_validation.h"
#include "identify/validation.h"
#include "model/battery/cell.h"
#include "model/core/json.h"

namespace lipoid {

enum class FitGrade { kGood, kFair, kPoor };
constexpr std::array<std::pair<FitGrade, std::string_view>, 3> OptionNames(FitGrade) {
  return {{{FitGrade::kGood, "good"}, {FitGrade::kFair, "fair"}, {FitGrade::kPoor, "poor"}}};
}

/// A quantity up to `good` is good, up to `fair` fair, beyond it poor.
struct GradeLimits {
  double good;
  double fair;
};
/// Mean error (4.57) of the voltage of the fitted logs, in %.
inline constexpr GradeLimits kMeanErrorLimits_percent{1.0, 3.0};
/// Root mean square of the same, in V.
inline constexpr GradeLimits kRmseLimits_V{0.05, 0.15};
/// Error of the time until cut-off of a constant current, in %, the worst of the logs.
inline constexpr GradeLimits kTimeLimits_percent{10.0, 35.0};
/// alpha over the nominal capacity, or its inverse.
inline constexpr GradeLimits kCapacityLimits{1.75, 3.0};
/// The charge that the logs move over alpha: a cell cannot give more than it holds.
inline constexpr GradeLimits kMovedLimits{1.1, 1.3};
/// The state of charge at which v_oc(A) is the cut-off, where it should be 0.
inline constexpr GradeLimits kCutoffLimits{0.1, 0.3};
/// A curve whose last row is at most so much above the cut-off, in V, is down there.
inline constexpr double kReachedCutoff_V = 0.15;
/// What all resistances take at half charge and 1C over what v_oc there is above the cut-off: a cell
/// that loses more of it cannot be discharged in an hour.
inline constexpr GradeLimits kDropLimits{1.0, 4.0};
/// How far the fall of the voltage after a step of the current may be from that of the logs
/// (trust/edges.h), as a share.
inline constexpr double kEdgeLimit = 0.2;
/// A lithium-polymer cell at rest, in V; v_oc(A) beyond these is no cell's.
inline constexpr double kLowestOpenCircuit_V = 1.0;
inline constexpr double kHighestOpenCircuit_V = 5.0;

/// NaN is poor.
[[nodiscard]] FitGrade GradeOf(double value, const GradeLimits& limits);

struct FitQuality {
  FitGrade grade = FitGrade::kPoor;
  double rmse_V = 0.0;                ///< over the fitted logs, each with the same weight
  double mean_error_percent = 0.0;    ///< the same
  std::vector<std::string> reasons;   ///< why it is no better; empty where it is good
  std::vector<EdgeGroup> edges = {};  ///< of all fitted logs together

  /// Better becomes this for the reason; worse keeps its own.
  void Doubt(std::string reason, FitGrade at_least = FitGrade::kFair);

  /// "predicts its own logs to 8.7 mV (0.19 %): good"
  [[nodiscard]] std::string Sentence(std::string_view what = "its own logs") const;
};

/// By these two alone: what is known of a fit whose cell nobody asks about.
[[nodiscard]] FitQuality JudgeErrors(double rmse_V, double mean_error_percent);

/// Where the alpha of a cell is from: only that of the logs must be their charge down to the cut-off.
enum class AlphaOf { kTheseLogs, kElsewhere };

/// `fitted` are the logs that took part, by the cell; `times` those of constant currents;
/// moved_C is the most charge that left the cell in any log after its start at full charge;
/// nominal_Ah is 0 where it is not known.
[[nodiscard]] FitQuality JudgeFit(const Cell& cell,
                                  const std::vector<LogErrors>& fitted,
                                  const std::vector<ConstantCurrentErrors>& times,
                                  double moved_C,
                                  double nominal_Ah,
                                  AlphaOf alpha_of = AlphaOf::kTheseLogs);

/// The key `verdict` of a summary, with the reasons as a list.
[[nodiscard]] Json FitQualityToJson(const FitQuality& quality);

/// The key `fit`, the same with one reason: verdict, mean_error_percent, rmse_V, reason.
[[nodiscard]] Json FitToJson(const FitQuality& quality);

}  // namespace lipoid
