// How should v_oc(A) be written? The forms of Tables 4.1-4.3 and their kin, (4.59) fitted to the
// low-rate log: errors (4.57), (4.58) on the rows that the fit saw, as in the thesis, and on rows
// that were left out. A is counted with the charge of the log itself: alpha would only stretch the
// axis.

#include <fmt/format.h>

#include <chrono>

#include "identify/logs/discharge.h"
#include "identify/studies/study.h"
#include "model/battery/error_metrics.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

struct Form {
  std::string name;
  OcvFitOptions options;
};

// The thesis compares degree 9, seven harmonics and straight lines; the others show which way
// errors go.
std::vector<Form> Forms(const OcvFitOptions& options) {
  std::vector<Form> forms;
  const auto add = [&](std::string_view words,
                       OcvMethod method,
                       int OcvFitOptions::*size,
                       std::initializer_list<int> sizes) {
    for (const int value : sizes) {
      OcvFitOptions form = options;
      form.method = method;
      form.*size = value;
      form.interpolate_up_to = 0;  // nodes as many as the row says, however few rows there are
      forms.push_back({fmt::format(fmt::runtime(words), value), form});
    }
  };
  using Of = OcvFitOptions;
  add("linear, {} nodes", OcvMethod::kLinear, &Of::knots, {25, 50, 100, 200, 400});
  add("monotone cubic, {} nodes", OcvMethod::kMonotoneCubic, &Of::knots, {25, 50, 100, 200});
  add("polynomial, degree {}", OcvMethod::kPolynomial, &Of::degree, {3, 5, 7, 9, 12, 15, 20});
  add("Fourier, {} harmonics", OcvMethod::kFourier, &Of::harmonics, {3, 5, 7, 9, 12});
  return forms;
}

// What is said of pulses, of alpha, or of the curve itself changes no form of the curve.
void RefuseWhatSaysNothing(const StudyInput& input) {
  const auto refuse = [](bool given, std::string_view option) {
    if (given)
      throw OptionError(
          fmt::format("option {}: it says nothing of the forms of v_oc(A); leave it out", option));
  };
  const StagedGiven& given = input.given;
  refuse(given.open_circuit_voltage.has_value(), "--open-circuit-voltage");
  refuse(given.alpha_C.has_value(), "--alpha-C");
  refuse(!given.parameters.fixed.empty(), "--fix");
  refuse(!given.parameters.start.empty(), "--start");
  refuse(!given.parameters.bounds.empty(), "--bounds");
  refuse(!input.options.pulses.diffusion, "--no-diffusion");
  refuse(input.options.pulses.branches != PulseFitOptions().branches, "--branches");
}

const LoadedLog& LowRateLog(const StudyInput& input) {
  for (const LoadedLog& log : input.logs) {
    if (log.entry.kind == LogKind::kLowRate) return log;
  }
  throw LoadError({input.campaign.file}, "expected a low-rate log for v_oc(A), found none");
}

// Numbers that the curve is made of; the frequency of a Fourier series is one of them.
std::size_t CountParameters(const OpenCircuitVoltage& curve) {
  if (!curve.soc().empty()) return curve.soc().size();
  const std::size_t frequency = curve.sine_V().empty() ? 0 : 1;
  return curve.coefficients_V().size() + curve.sine_V().size() + frequency;
}

// The rows under load, as in the fit.
ErrorMetrics ErrorsInFit(const OpenCircuitVoltage& curve,
                         const Record& record,
                         double alpha_C,
                         double initial_soc) {
  const auto charge_C = DeliveredCharge(record);
  const double rest_A = RestThreshold(record);
  ErrorAccumulator errors;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record.current_A[k] <= rest_A) continue;
    errors.Add(record.voltage_V[k], curve(initial_soc - charge_C[k] / alpha_C));  // (4.59)
  }
  return errors.Result();
}

}  // namespace

StudyResult StudyOcv(const StudyInput& input, const StudyProgress& progress) {
  RefuseWhatSaysNothing(input);
  const LoadedLog& log = LowRateLog(input);
  const Record& record = log.log.record;
  const double soc = log.entry.initial_soc;
  const double alpha_C = FindLowRateDischarge(record, input.campaign.capacity_Ah).charge_C / soc;

  StudyResult result;
  result.columns = {{"form", "v_oc(A)"},
                    {"parameters", "parameters"},
                    {"wall_s", "time / s", 1.0, 3},
                    {"mean_error_percent", "mean / %", 1.0, 3},
                    {"max_error_percent", "max / %", 1.0, 3},
                    {"rmse_V", "rmse / mV", 1e3, 4},
                    {"left_out_mean_error_percent", "held out: mean / %", 1.0, 3},
                    {"left_out_max_error_percent", "max / %", 1.0, 3},
                    {"left_out_rmse_V", "rmse / mV", 1e3, 4}};
  const auto forms = Forms(input.options.open_circuit_voltage);
  for (std::size_t k = 0; k < forms.size(); ++k) {
    progress(forms[k].name, static_cast<double>(k) / static_cast<double>(forms.size()));
    const auto began = std::chrono::steady_clock::now();
    const OcvFitResult fit = FitOpenCircuitVoltage(record, alpha_C, soc, forms[k].options);
    const double wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    const ErrorMetrics errors = ErrorsInFit(fit.curve, record, alpha_C, soc);
    result.rows.push_back({{"form", forms[k].name},
                           {"method", options_internal::ToText(forms[k].options.method)},
                           {"parameters", CountParameters(fit.curve)},
                           {"wall_s", wall_s},
                           {"mean_error_percent", errors.mean_error_percent},
                           {"max_error_percent", errors.max_error_percent},
                           {"rmse_V", errors.rmse},
                           {"left_out_mean_error_percent", fit.errors.mean_error_percent},
                           {"left_out_max_error_percent", fit.errors.max_error_percent},
                           {"left_out_rmse_V", fit.errors.rmse}});
  }
  result.facts = {
      {"file", log.entry.file}, {"charge_C", alpha_C * soc}, {"data_rows", record.size()}};
  result.remarks.emplace_back(
      "held-out rows of the fit judge it; the time is that of two fits, without them and with all");
  return result;
}

}  // namespace lipoid
