#include "identify/constant_current_validation.h"

#include "identify/logs/discharge.h"
#include "model/battery/time_to_cutoff.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

DischargeTime DischargeOf(const LoadedLog& log, double cutoff_V) {
  const Discharge found = FindDischarge(log.log.record, cutoff_V);
  return {log.entry.file, found.current_A, found.time_s(), log.entry.initial_soc};
}

bool ComesBack(const Record& record, double cutoff_V) {
  constexpr double kSameLoad = 0.9;
  const Discharge found = FindDischarge(record, cutoff_V);
  for (std::size_t k = found.last + 1; k < record.size(); ++k) {
    if (record.current_A[k] < kSameLoad * found.current_A) return false;
    if (record.voltage_V[k] > cutoff_V + found.nearness_V()) return true;
  }
  return false;
}

// The same as TimeToCutoff() at the temperatures that were measured, the last of which lasts.
std::optional<double> TimeToCutoffAsMeasured(const Cell& one,
                                             const LoadedLog& log,
                                             const DischargeTime& measured,
                                             double longest_s) {
  constexpr double kRows = 2000.0;  // of the discharge; between them lines are straight enough
  if (!(measured.time_s > 0.0)) return std::nullopt;
  const Record& record = log.log.record;
  const double start_s = FindDischarge(record, one.cutoff_V).start_s;
  const double step_s = measured.time_s / kRows;
  const auto count = static_cast<std::size_t>(longest_s / step_s) + 1;
  Column time_s(count), current_A(count, measured.current_A), degC(count);
  std::size_t row = 0;
  for (std::size_t k = 0; k < count; ++k) {
    time_s[k] = static_cast<double>(k) * step_s;
    const double at_s = start_s + time_s[k];
    while (row + 1 < record.size() && record.time_s[row + 1] < at_s) ++row;
    degC[k] = record.temperature_degC[row];
    if (row + 1 == record.size() || at_s <= record.time_s[row]) continue;
    const double share =
        (at_s - record.time_s[row]) / (record.time_s[row + 1] - record.time_s[row]);
    degC[k] += share * (record.temperature_degC[row + 1] - degC[k]);
  }
  const Prediction predicted = Predict(
      one, time_s, current_A, Hold::kBackward, log.entry.initial_soc, {.measured_degC = degC});
  const auto& voltage_V = predicted.voltage_V;
  for (std::size_t k = 0; k < count; ++k) {
    if (!(voltage_V[k] <= one.cutoff_V)) continue;
    if (k == 0) return 0.0;
    const double share = (voltage_V[k - 1] - one.cutoff_V) / (voltage_V[k - 1] - voltage_V[k]);
    return time_s[k - 1] + share * step_s;
  }
  return std::nullopt;
}

ConstantCurrentErrors ErrorsOf(const Cell& one,
                               const LoadedLog& log,
                               const DischargeTime& measured) {
  ConstantCurrentErrors errors{.voltage = Validate(one, log),
                               .current_A = measured.current_A,
                               .measured_s = measured.time_s};
  const double longest_s = kLongestDischarge * measured.time_s;
  const auto predicted_s = one.temperature && !log.log.record.temperature_degC.empty()
                               ? TimeToCutoffAsMeasured(one, log, measured, longest_s)
                               : TimeToCutoff(one,
                                              measured.current_A,
                                              log.entry.initial_soc,
                                              longest_s,
                                              {.ambient_degC = log.entry.ambient_degC,
                                               .initial_degC = log.entry.initial_degC});
  if (predicted_s) {
    ErrorAccumulator time;
    time.Add(measured.time_s, *predicted_s);
    errors.predicted_s = *predicted_s;
    errors.error_percent = time.Result().mean_error_percent;
  }
  constexpr double kOff_percent = 1.0;
  if (!(errors.error_percent <= kOff_percent))
    errors.comes_back = ComesBack(log.log.record, one.cutoff_V);
  return errors;
}

}  // namespace

std::vector<ConstantCurrentErrors> ValidateConstantCurrents(
    const Cell& cell,
    const std::vector<LoadedLog>& logs,
    const std::vector<DischargeTime>& measured) {
  std::vector<const LoadedLog*> constant;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kConstantCurrent) constant.push_back(&log);
  }
  Require(measured.empty() || measured.size() == constant.size(),
          "a discharge for each constant-current log",
          {{"discharges", static_cast<double>(measured.size())},
           {"logs", static_cast<double>(constant.size())}});
  Cell one = cell.AsOne();  // the records are those of one cell
  std::vector<ConstantCurrentErrors> errors(constant.size());
  ParallelFor(constant.size(), [&](std::size_t k) {
    const LoadedLog& log = *constant[k];
    errors[k] =
        ErrorsOf(one, log, measured.empty() ? DischargeOf(log, cell.cutoff_V) : measured[k]);
  });
  return errors;
}

}  // namespace lipoid
