#pragma once

/// @file
/// Stage 1: alpha and beta from the times that constant currents last, (4.53).
///
///   L(k) = A_0 alpha/I(k) - pi²/(3 beta²),   beta in [0, 1],   A_0 = 1 in the thesis
///
/// is linear in alpha and the lag c = pi²/(3 beta²): the least squares has a closed form. The exact
/// form solves (4.37) for every L instead, which matters when beta² L is not large.
///
/// beta is not identifiable from the times when one standard error of c is as large as c itself, or
/// when the delivered charge does not fall with the current. That is a result: the bound that the
/// times do imply and the value from which stage 3 starts are stated. Tests:
/// tests/identify/stages/discharge_times_test.cc.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/error_metrics.h"
#include "model/core/options.h"

namespace lipoid {

enum class DischargeForm { kSteady, kExact };
constexpr std::array<std::pair<DischargeForm, std::string_view>, 2> OptionNames(DischargeForm) {
  return {{{DischargeForm::kSteady, "steady"}, {DischargeForm::kExact, "exact"}}};
}

enum class TimeWeighting { kSeconds, kRelative };
constexpr std::array<std::pair<TimeWeighting, std::string_view>, 2> OptionNames(TimeWeighting) {
  return {{{TimeWeighting::kSeconds, "seconds"}, {TimeWeighting::kRelative, "relative"}}};
}

struct DischargeTimesOptions {
  DischargeForm form = DischargeForm::kSteady;
  TimeWeighting weighting = TimeWeighting::kSeconds;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("form",
      self.form,
      Names{},
      "equation of the discharge time: (4.53) in closed form (steady), or (4.37) at finite times "
      "(exact)");
    v("weighting",
      self.weighting,
      Names{},
      "whether errors of discharge times count in seconds or relative to each time");
  }
};

/// One constant-current discharge: the current is its charge divided by its time.
struct DischargeTime {
  std::string file;
  double current_A = 0.0;
  double time_s = 0.0;
  double initial_soc = 1.0;  ///< > 0, A_0 of a cell at rest
  double weight = 1.0;       ///< > 0, of the square of its error

  /// A cell that begins with A_0 alpha lasts as long as a full one at this current.
  [[nodiscard]] double of_full_A() const { return current_A / initial_soc; }
};

struct DischargeTimesResult {
  struct Row {
    std::string file;
    double current_A;
    double measured_s;
    double predicted_s;
    double error_percent;  ///< (4.56)
  };

  double alpha_C = std::numeric_limits<double>::quiet_NaN();
  double beta_per_sqrt_s = std::numeric_limits<double>::quiet_NaN();
  /// NaN where there are as many unknowns as times.
  double alpha_standard_error_C = std::numeric_limits<double>::quiet_NaN();
  double beta_standard_error_per_sqrt_s = std::numeric_limits<double>::quiet_NaN();
  int degrees_of_freedom = 0;  ///< times more than unknowns
  bool identifiable = false;
  std::string reason;  ///< why beta is not identifiable; empty where it is
  /// 95 %: beta is at least this. 0 where the times imply none.
  double beta_lower_bound_per_sqrt_s = 0.0;
  /// From where stage 3 starts: beta, or a value at or above the bound.
  double beta_start_per_sqrt_s = std::numeric_limits<double>::quiet_NaN();
  std::vector<Row> rows;
  ErrorMetrics errors;  ///< of the times

  /// Whether the times leave the law of (4.53) by more than measurements do: it knows no drop over the
  /// resistance, which ends discharges to a high cut-off before diffusion does.
  [[nodiscard]] bool LeaveTheLaw() const {
    constexpr double kMost_percent = 3.0;
    return errors.mean_error_percent > kMost_percent;
  }
};

/// From where stage 3 starts when nothing is known of beta: Tables 4.8-4.13 give 0.18 to 0.21.
inline constexpr double kTypicalBeta = 0.2;
inline constexpr double kLargestBeta = 1.0;  ///< (4.53)

/// Two currents that differ by more than this share are different.
inline constexpr double kCurrentTolerance = 0.02;
[[nodiscard]] int CountDifferentCurrents(const std::vector<DischargeTime>& discharges);

/// At least two different currents (PreconditionError otherwise), or one where alpha is given.
/// A beta that is given is held; infinity: there is no diffusion.
[[nodiscard]] DischargeTimesResult FitDischargeTimes(
    const std::vector<DischargeTime>& discharges,
    const DischargeTimesOptions& options = {},
    std::optional<double> given_alpha_C = std::nullopt,
    std::optional<double> given_beta_per_sqrt_s = std::nullopt);

}  // namespace lipoid
