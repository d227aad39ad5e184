#include "identify/stages/staged_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "identify/fit/cell_of_solution.h"
#include "identify/logs/columns.h"
#include "identify/logs/discharge.h"
#include "identify/logs/segments.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/discharge_time.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// The logs of one kind.
std::vector<const LoadedLog*> OfKind(const std::vector<LoadedLog>& logs, LogKind kind) {
  std::vector<const LoadedLog*> found;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == kind) found.push_back(&log);
  }
  return found;
}

// Runs `check` on every log, side by side, and reports all that fail together.
template <class Check>
void CheckAll(const std::vector<const LoadedLog*>& logs, Check&& check) {
  std::vector<std::vector<Diagnostic>> problems(logs.size());
  ParallelFor(logs.size(),
              [&](std::size_t k) { problems[k] = DiagnosticsOf([&] { check(*logs[k]); }); });
  std::vector<Diagnostic> all;
  for (const auto& some : problems) all.insert(all.end(), some.begin(), some.end());
  if (!all.empty()) throw LoadError(std::move(all));
}

double StartOfDischarge(const CampaignLog& entry) {
  if (entry.initial_soc > 0.0) return entry.initial_soc;
  throw LoadError({entry.file},
                  fmt::format("expected a discharge from a state of charge above 0, found an "
                              "initial_soc of {:g}",
                              entry.initial_soc));
}

class StagedRun {
 public:
  StagedRun(const Campaign& campaign,
            const std::vector<LoadedLog>& logs,
            const StagedOptions& options,
            const StagedGiven& given,
            const StageProgress& progress)
      : campaign_(campaign), logs_(logs), options_(options), given_(given), progress_(progress) {}

  StagedResult Run(const BeforePulses& before_pulses) {
    const auto began = std::chrono::steady_clock::now();
    RunUpToPulses();
    if (before_pulses) before_pulses(result_);
    Tell("pulses", 0.2);
    FitPulseParameters();
    Tell("validation", 0.95);
    MakeCell();
    NameCautions();
    ValidateCell();
    result_.wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return std::move(result_);
  }

  PulseTask Prepare() {
    RunUpToPulses();
    return {.sweep = sweep_->With(result_.cell.open_circuit_voltage),
            .data = result_.start,
            .beta_start_per_sqrt_s = beta_start_,
            .found = std::move(result_)};
  }

 private:
  void RunUpToPulses() {
    Tell("checking the logs", 0.0);
    CheckLogs();
    Tell("discharge times", 0.05);
    FindAlphaAndBeta();
    Tell("open-circuit voltage", 0.1);
    // Neither waits for the other.
    ParallelInvoke([&] { FindOpenCircuitVoltage(); }, [&] { PreparePulses(); });
    if (result_.from_rests)
      result_.done_instead.push_back("no low-rate log: " + InWords(*result_.from_rests));
  }

  void Tell(std::string_view stage, double share) const {
    if (progress_) progress_(stage, share);
  }

  void CheckLogs() {
    CheckCampaign(campaign_, given_.open_circuit_voltage.has_value());
    if (campaign_.OnlyFlights()) {
      RefuseCampaign(
          campaign_,
          "expected logs of the lab, found flights alone, from which only `lipoid identify` "
          "finds what they tell");
    }
    const auto constant = OfKind(logs_, LogKind::kConstantCurrent);
    const auto low_rate = OfKind(logs_, LogKind::kLowRate);
    const auto pulses = OfKind(logs_, LogKind::kPulses);
    std::vector<const LoadedLog*> all = constant;
    all.insert(all.end(), low_rate.begin(), low_rate.end());
    all.insert(all.end(), pulses.begin(), pulses.end());
    discharges_.resize(constant.size());
    pulse_segments_.resize(pulses.size());
    const auto place = [](const auto& of, const LoadedLog& log) {
      return static_cast<std::size_t>(std::find(of.begin(), of.end(), &log) - of.begin());
    };
    if (!low_rate.empty()) low_rate_ = low_rate.front();
    CheckAll(all, [&](const LoadedLog& log) {
      switch (log.entry.kind) {
        case LogKind::kConstantCurrent: {
          const Discharge d = FindDischarge(log.log.record, *campaign_.cutoff_V);
          discharges_[place(constant, log)] = {.file = log.entry.file,
                                               .current_A = d.current_A,
                                               .time_s = d.time_s(),
                                               .initial_soc = StartOfDischarge(log.entry),
                                               .weight = log.entry.weight};
          break;
        }
        case LogKind::kLowRate:
          (void)StartOfDischarge(log.entry);
          if (&log == low_rate_)
            low_rate_discharge_ = FindLowRateDischarge(log.log.record, campaign_.capacity_Ah);
          break;
        case LogKind::kPulses:
          pulse_segments_[place(pulses, log)] = FindPulses(log.log.record);
          break;
        case LogKind::kLowRateCharge:
        case LogKind::kFlight:
        case LogKind::kValidation:
          break;
      }
    });
    for (const auto& segments : pulse_segments_) {
      for (const Segment& segment : segments) {
        if (segment.kind == SegmentKind::kPulse)
          shortest_pulse_s_ = std::min(shortest_pulse_s_, segment.duration_s());
      }
    }
    if (low_rate_ != nullptr) result_.low_rate_charge_C = low_rate_discharge_.charge_C;
    if (low_rate.size() > 1) {
      result_.done_instead.push_back(
          fmt::format("{} low-rate logs were given: v_oc(A) is that of the first, {}",
                      low_rate.size(),
                      low_rate_->entry.file));
    }
  }

  void FindAlphaAndBeta() {
    const int currents = CountDifferentCurrents(discharges_);
    if (currents >= (given_.alpha_C ? 1 : 2)) {
      const std::optional<double> given_beta =
          options_.pulses.diffusion ? given_.parameters.Fixed("beta") : std::optional(kInfinity);
      result_.discharge_times =
          FitDischargeTimes(discharges_, options_.discharge_times, given_.alpha_C, given_beta);
      beta_start_ = result_.discharge_times->beta_start_per_sqrt_s;
      result_.alpha_C = result_.discharge_times->alpha_C;
      result_.alpha_source = given_.alpha_C ? "given" : "discharge-times";
      if (!given_beta && !result_.discharge_times->identifiable) {
        result_.done_instead.push_back(
            fmt::format("beta is not identifiable from the discharge times: {}; stage 3 starts at "
                        "{:.3g} s^-1/2",
                        result_.discharge_times->reason,
                        beta_start_));
      }
      return;
    }
    const std::string found =
        currents == 0 ? "no constant-current log" : "constant currents that do not differ";
    if (given_.alpha_C) {
      result_.alpha_C = *given_.alpha_C;
      result_.alpha_source = "given";
    } else if (low_rate_ != nullptr) {
      result_.alpha_C = result_.low_rate_charge_C / low_rate_->entry.initial_soc;
      result_.alpha_source = "low-rate-charge";
      result_.done_instead.push_back(fmt::format(
          "{}: alpha is the charge of the low-rate log, {:.6g} C, and beta waits for stage 3",
          found,
          result_.alpha_C));
    } else if (const auto charge_C = PulseCharge()) {
      result_.alpha_C = *charge_C;
      result_.alpha_source = "pulse-charge";
      result_.done_instead.push_back(
          fmt::format("{} and no low-rate log: alpha is the charge of the pulses until cut-off, "
                      "{:.4g} Ah ({:.6g} C), and beta waits for stage 3",
                      found,
                      *charge_C / 3600.0,
                      *charge_C));
    } else if (campaign_.capacity_Ah > 0.0) {
      result_.alpha_C = 3600.0 * campaign_.capacity_Ah;
      result_.alpha_source = "nominal-capacity";
      result_.done_instead.push_back(
          fmt::format("{} and no low-rate log: alpha is the nominal capacity, {:.6g} C, and beta "
                      "waits for stage 3; --alpha-C gives a better one",
                      found,
                      result_.alpha_C));
    } else {
      RefuseCampaign(
          campaign_,
          fmt::format(
              "expected a log that gives the capacity (two constant currents, or a low-rate log), {}, or "
              "--alpha-C, found {}",
              campaign_.file.empty() ? "--capacity-Ah" : "capacity_Ah in [cell]",
              found));
    }
    beta_start_ = kTypicalBeta;
  }

  void FindOpenCircuitVoltage() {
    if (given_.open_circuit_voltage) {
      result_.cell.open_circuit_voltage = *given_.open_circuit_voltage;
      return;
    }
    if (low_rate_ == nullptr) {
      result_.from_rests = FindOpenCircuitVoltageFromRests(LogsOfRests(), result_.alpha_C);
      result_.cell.open_circuit_voltage = result_.from_rests->curve;
      return;
    }
    result_.open_circuit_voltage = FitOpenCircuitVoltage(low_rate_->log.record,
                                                         result_.alpha_C,
                                                         low_rate_->entry.initial_soc,
                                                         options_.open_circuit_voltage);
    result_.cell.open_circuit_voltage = result_.open_circuit_voltage->curve;
  }

  // A curve that was given has an axis of its own: there the nominal capacity is the better guess.
  [[nodiscard]] std::optional<double> PulseCharge() const {
    if (given_.open_circuit_voltage || !campaign_.cutoff_V) return std::nullopt;
    return ChargeToCutoff(LogsOfRests(), *campaign_.cutoff_V);
  }

  [[nodiscard]] std::vector<LogOfRests> LogsOfRests() const {
    const auto pulses = OfKind(logs_, LogKind::kPulses);
    std::vector<LogOfRests> found;
    for (std::size_t k = 0; k < pulses.size(); ++k) {
      found.push_back({.record = &pulses[k]->log.record,
                       .segments = &pulse_segments_[k],
                       .initial_soc = pulses[k]->entry.initial_soc});
    }
    return found;
  }

  void PreparePulses() {
    auto fitted = OfKind(logs_, LogKind::kPulses);
    if (fitted.empty()) {
      fitted = OfKind(logs_, LogKind::kConstantCurrent);
      result_.fitted_kind = LogKind::kConstantCurrent;
      result_.done_instead.push_back(
          "no pulses log: stage 3 uses the constant-current logs; without rests beta and the "
          "branches are weak, and the series resistance contains what is faster than the sampling");
    }
    std::vector<SweepLog> sweep_logs;
    std::vector<const Record*> records;
    for (const LoadedLog* log : fitted) {
      sweep_logs.push_back({&log->log.record, log->entry.initial_soc, log->entry.weight});
      records.push_back(&log->log.record);
    }
    const JointSetup setup = {.alpha_C = result_.alpha_C,
                              .diffusion = options_.pulses.diffusion,
                              .terms = options_.pulses.terms,
                              .tail = options_.pulses.tail,
                              .open_circuit_voltage = {}};
    ParallelInvoke([&] { sweep_.emplace(setup, sweep_logs); },
                   [&] { coarse_.emplace(setup, sweep_logs, Condensation::Coarse()); },
                   [&] { result_.start = FindStartValues(records, pulse_segments_); });
  }

  void FitPulseParameters() {
    const VoltageSweep sweep = sweep_->With(result_.cell.open_circuit_voltage);
    const VoltageSweep coarse = coarse_->With(result_.cell.open_circuit_voltage);
    PulseFitStart start{.beta_per_sqrt_s = beta_start_,
                        .hold_beta = true,
                        .data = result_.start,
                        .coarse = &coarse};
    const bool beta_is_free = options_.pulses.diffusion && !given_.parameters.Fixed("beta");
    if (beta_is_free) {
      // For comparison, and where the next one starts: held at a beta that is off, residuals are
      // large, and each further digit of the cost would take two passes over all rows.
      constexpr double kTenDigits = 1e-10;
      LevenbergMarquardtOptions solver = options_.solver;
      solver.function_tolerance = std::max(solver.function_tolerance, kTenDigits);
      result_.pulses_beta_held =
          FitPulses(sweep, start, options_.pulses, solver, given_.parameters);
      start.previous = &result_.pulses_beta_held->parameters;
    }
    Tell("pulses, with beta", 0.5);
    start.hold_beta = false;
    result_.pulses = FitPulses(sweep, start, options_.pulses, options_.solver, given_.parameters);
    result_.converged = result_.pulses.termination == Termination::kConverged;
    Tell("trust", 0.9);
    const bool times_gave_alpha = result_.alpha_source == "discharge-times";
    result_.trust = AssessStaged(
        sweep, result_.pulses, times_gave_alpha ? result_.discharge_times : std::nullopt);
  }

  void MakeCell() {
    Cell& cell = result_.cell;
    cell.name = campaign_.name;
    cell.series = campaign_.series;
    cell.parallel = campaign_.parallel;
    cell.reference_degC = LoadedTemperature_degC(logs_);
    cell.capacity_Ah = campaign_.capacity_Ah > 0.0 && options_.pulses.diffusion
                           ? campaign_.capacity_Ah
                           : result_.alpha_C / 3600.0;
    if (campaign_.cutoff_V) {
      cell.cutoff_V = *campaign_.cutoff_V;
    } else {
      cell.cutoff_V = std::numeric_limits<double>::infinity();
      for (const LoadedLog& log : logs_) {
        cell.cutoff_V = std::min(cell.cutoff_V, FindExtent(log.log.record.voltage_V).least);
      }
      result_.done_instead.push_back(
          fmt::format("no cutoff_V: the cell file takes the lowest voltage of the logs, {:.4g} V",
                      cell.cutoff_V));
    }
    if (options_.pulses.diffusion) {
      cell.diffusion = Cell::Diffusion{
          .alpha_C = result_.alpha_C, .terms = options_.pulses.terms, .tail = options_.pulses.tail};
    }
    PutInto(cell, result_.pulses.solution, 1.0);
  }

  void ValidateCell() {
    const auto held_out = OfKind(logs_, LogKind::kValidation);
    result_.validation.resize(held_out.size());
    ParallelInvoke(
        [&] {
          ParallelFor(held_out.size(), [&](std::size_t k) {
            result_.validation[k] = Validate(result_.cell, *held_out[k]);
          });
        },
        [&] {
          result_.constant_current = ValidateConstantCurrents(result_.cell, logs_, discharges_);
        });
  }

  // docs/theory.md, 7: what the method itself leaves out, said where it matters for this cell.
  void NameCautions() {
    const SweepParameters& p = result_.pulses.parameters;
    auto& say = result_.cautions;
    if (std::string held = given_.HeldInWords(); !held.empty()) say.push_back(std::move(held));
    if (result_.discharge_times && result_.discharge_times->LeaveTheLaw()) {
      say.push_back(fmt::format(
          "the discharge times are {:.2g} % off those of any alpha and beta on average, {:.2g} % at most: the drop over "
          "the resistance ends these discharges, too, where the cut-off lies high. The interval of alpha reaches as "
          "far; the joint method counts the drop (--method joint)",
          result_.discharge_times->errors.mean_error_percent,
          result_.discharge_times->errors.max_error_percent));
    }
    if (result_.low_rate_charge_C > 0.0) {
      const double full = result_.low_rate_charge_C / low_rate_->entry.initial_soc;
      const double ratio = result_.alpha_C / full;
      if (std::abs(ratio - 1.0) > 0.01) {
        say.push_back(
            fmt::format("alpha is {:.4f} of the charge of the low-rate log ({:.6g} C): they should "
                        "measure the same thing",
                        ratio,
                        full));
      }
    }
    if (result_.open_circuit_voltage && options_.pulses.diffusion) {
      // Half-way through the discharge a branch has settled as far as its time constant lets it.
      double resistance = p.series_resistance_Ohm;
      for (std::size_t j = 0; j < p.resistance_Ohm.size(); ++j) {
        resistance += p.resistance_Ohm[j] *
                      -std::expm1(-0.5 * low_rate_discharge_.time_s() / p.time_constant_s[j]);
      }
      const double current_A = result_.open_circuit_voltage->current_A;
      result_.low_rate_offset_V = resistance * current_A;
      say.push_back(
          fmt::format("v_oc(A) is taken as the low-rate voltage, which lies below it by (r_s + sum "
                      "r_j) i = {:.2g} mV and lags by {:.2g} % of the charge",
                      1e3 * result_.low_rate_offset_V,
                      100.0 * SteadyLag(p.beta_per_sqrt_s) * current_A / result_.alpha_C));
    }
    if (result_.pulses.rows_outside_curve > 0) {
      say.push_back(fmt::format(
          "{} at states of charge beyond v_oc(A), which goes on with its end slope there",
          Counted(result_.pulses.rows_outside_curve, "row")));
    }
    for (std::size_t j = 0; j < p.time_constant_s.size(); ++j) {
      const double tau = p.time_constant_s[j];
      const auto name = fmt::format("r_{}", j + 1);
      if (!given_.parameters.Fixed(name) && p.resistance_Ohm[j] <= 1e-3 * p.series_resistance_Ohm) {
        say.push_back(
            fmt::format("branch {} was not found: its resistance went to zero, and its time "
                        "constant is arbitrary",
                        j + 1));
      } else if (tau < result_.start.shortest_s) {
        say.push_back(
            fmt::format("branch {0} is faster than the sampling (tau_{0} = {1:.2g} s, rows every "
                        "{2:.2g} s): it cannot be told from r_s, and c_{0} is arbitrary",
                        j + 1,
                        tau,
                        result_.start.shortest_s));
      } else if (options_.pulses.diffusion) {
        const double slowest = 1.0 / (p.beta_per_sqrt_s * p.beta_per_sqrt_s);
        if (tau > slowest / 3.0 && tau < slowest * 3.0) {
          say.push_back(
              fmt::format("branch {0} (tau_{0} = {1:.3g} s) is as slow as the diffusion (1/beta² = "
                          "{2:.3g} s): the two can stand in for one another",
                          j + 1,
                          tau,
                          slowest));
        }
      }
    }
    if (const auto& diffusion = result_.cell.diffusion; diffusion && diffusion->tail) {
      const double first_neglected_s = diffusion->FirstOfTail_s();
      if (first_neglected_s > shortest_pulse_s_) {
        say.push_back(
            fmt::format("the first diffusion mode left to the tail ({:.2g} s) is slower than the "
                        "shortest pulse ({:.2g} s): raise the number of terms (--set "
                        "pulses.terms=N)",
                        first_neglected_s,
                        shortest_pulse_s_));
      }
    }
    if (result_.fitted_kind == LogKind::kConstantCurrent)
      say.push_back("beta and the branches come from constant-current logs: take them as weak");
    for (const auto& name : result_.pulses.at_bound) {
      if (name.rfind("r_", 0) == 0 && name != "r_s") continue;  // said above: the branch is gone
      say.push_back(fmt::format(
          "{} is at a limit of its range: these logs would be fitted as well or better beyond it",
          name));
    }
  }

  const Campaign& campaign_;
  const std::vector<LoadedLog>& logs_;
  const StagedOptions& options_;
  const StagedGiven& given_;
  const StageProgress& progress_;
  StagedResult result_;
  std::vector<DischargeTime> discharges_;
  const LoadedLog* low_rate_ = nullptr;
  Discharge low_rate_discharge_;
  std::vector<std::vector<Segment>> pulse_segments_;  // of each log of pulses
  std::optional<VoltageSweep> sweep_;                 // all rows, still without v_oc(A)
  std::optional<VoltageSweep> coarse_;                // a coarse view of them
  double beta_start_ = kTypicalBeta;
  double shortest_pulse_s_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::string StagedGiven::HeldInWords() const {
  std::map<std::string, double> held = parameters.fixed;
  if (alpha_C) held["alpha"] = *alpha_C;
  std::vector<std::string> words;
  for (const auto& [name, value] : held)
    words.push_back(fmt::format("{} = {:.6g} {}", name, value, CellParameterUnit(name)));
  return words.empty() ? std::string() : fmt::format("held as given: {}", fmt::join(words, ", "));
}

StagedResult IdentifyStaged(const Campaign& campaign,
                            const std::vector<LoadedLog>& logs,
                            const StagedOptions& options,
                            const StagedGiven& given,
                            const StageProgress& progress,
                            const BeforePulses& before_pulses) {
  return StagedRun(campaign, logs, options, given, progress).Run(before_pulses);
}

PulseTask PreparePulses(const Campaign& campaign,
                        const std::vector<LoadedLog>& logs,
                        const StagedOptions& options,
                        const StagedGiven& given) {
  return StagedRun(campaign, logs, options, given, {}).Prepare();
}

std::string AlphaSourceInWords(std::string_view source) {
  constexpr std::pair<std::string_view, std::string_view> kWords[] = {
      {"discharge-times", "from the discharge times"},
      {"low-rate-charge", "the charge of the low-rate log"},
      {"pulse-charge", "the charge of the pulses"},
      {"nominal-capacity", "the nominal capacity"},
      {"delivered-charge", "what the deepest log delivered"},
      {"rests", "the ends of the rests on the given curve"}};
  for (const auto& [name, words] : kWords) {
    if (name == source) return std::string(words);
  }
  return std::string(source);
}

}  // namespace lipoid
