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

ConstantCurrentErrors ErrorsOf(const Cell& one,
                               const LoadedLog& log,
                               const DischargeTime& measured) {
  ConstantCurrentErrors errors{.voltage = Validate(one, log),
                               .current_A = measured.current_A,
                               .measured_s = measured.time_s};
  // The measured temperature ends with the log; the discharge that is predicted need not.
  Surroundings surroundings = SurroundingsOf(log.log.record, log.entry);
  if (!surroundings.measured_degC.empty()) {
    const double start_degC = surroundings.measured_degC.front();
    surroundings = {.ambient_degC = surroundings.ambient_degC.value_or(start_degC),
                    .initial_degC = start_degC};
  }
  const auto predicted_s = TimeToCutoff(one,
                                        measured.current_A,
                                        log.entry.initial_soc,
                                        kLongestDischarge * measured.time_s,
                                        surroundings);
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
