#include "identify/joint/joint_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <numeric>

#include "identify/fit/cell_of_solution.h"
#include "identify/joint/joint_request.h"
#include "identify/joint/predicted_temperature.h"
#include "identify/joint/steady_current.h"
#include "identify/joint/structure_spread.h"
#include "identify/logs/discharge.h"
#include "identify/logs/segments.h"
#include "identify/validation.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/charge_axis.h"
#include "model/battery/typical_temperature.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// A state of charge over the axis of another alpha.
double RescaledSoc(double soc, double alpha_C, double to_C) {
  return 1.0 - (1.0 - soc) * alpha_C / to_C;
}

// v_oc(A) over the same.
OpenCircuitVoltage Rescaled(const OpenCircuitVoltage& curve, double alpha_C, double to_C) {
  constexpr int kSamples = 400;
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (int k = 0; k <= kSamples; ++k) {
    const double a = curve.soc_lo() + (curve.soc_hi() - curve.soc_lo()) * k / double(kSamples);
    soc.push_back(RescaledSoc(a, alpha_C, to_C));
    voltage_V.push_back(curve(a));
  }
  return OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
}

// A cell that is held diffuses, or does not.
StagedOptions KeepingTo(const HeldShape* held, StagedOptions options) {
  if (held != nullptr) options.pulses.diffusion = held->cell.diffusion.has_value();
  return options;
}

// From full to the end of the low-rate log; 0 without one.
double LowRateCharge(const StagedResult& staged, const std::vector<LoadedLog>& logs) {
  const auto low_rate = std::find_if(logs.begin(), logs.end(), [](const LoadedLog& log) {
    return log.entry.kind == LogKind::kLowRate;
  });
  return low_rate == logs.end() ? 0.0 : staged.low_rate_charge_C / low_rate->entry.initial_soc;
}

// A fit by another alpha is better, and not only by what smoothness and nodes make of it.
constexpr double kClearlyBetter = 0.9;

// The limit of beta at which diffusion is as good as none; at the other, it is slower than the logs.
constexpr double kShowsNone_per_sqrt_s = 0.5;

// A capacity that the last slope of v_oc leads to, from one that the logs moved.
bool IsNear(double alpha_C, double from_C) {
  return alpha_C > 0.5 * from_C && alpha_C < 2.0 * from_C;
}

// How long current flows, and in how many rows.
std::pair<double, double> UnderLoad(const Record& record) {
  double loaded_s = 0.0;
  double rows = 0.0;
  for (std::size_t k = 1; k < record.size(); ++k) {
    if (record.current_A[k] == 0.0) continue;
    loaded_s += record.time_s[k] - record.time_s[k - 1];
    ++rows;
  }
  return {loaded_s, rows};
}

// The rms error of all rows that were fitted.
double ErrorOfRows_V(const JointResult& result) {
  double squares = 0.0;
  double rows = 0.0;
  for (const LogErrors& log : result.fitted) {
    squares += static_cast<double>(log.all.rows) * log.all.rmse * log.all.rmse;
    rows += static_cast<double>(log.all.rows);
  }
  return std::sqrt(squares / rows);
}

class JointRun {
 public:
  JointRun(const Campaign& campaign,
           const std::vector<LoadedLog>& logs,
           const StagedOptions& staged_options,
           const JointOptions& options,
           const StagedGiven& given,
           const StageProgress& progress,
           const PredictedTemperatures* warm)
      : campaign_(campaign),
        recorded_(logs),
        logs_(warm != nullptr ? warm->logs : logs),
        warm_(warm),
        staged_options_(KeepingTo(given.reference.get(), staged_options)),
        options_(options),
        given_(given),
        progress_(progress),
        known_(given.parameters) {
    CheckJointRequest(given, options, staged_options.pulses.diffusion);
    if (given.reference) Hold(given.reference);
  }

  JointResult Run() {
    const auto began = std::chrono::steady_clock::now();
    StagedGiven for_staged = given_;
    for_staged.parameters = {};  // structures differ: what is held here need not be there
    curve_given_ = given_.open_circuit_voltage.has_value() || given_.reference;
    if (given_.reference) {  // for the staged run, too
      for_staged.open_circuit_voltage = given_.reference->cell.open_circuit_voltage;
      if (!for_staged.alpha_C) for_staged.alpha_C = given_.reference->cell.alpha_C();
    }
    result_.fixed = known_.fixed;
    result_.bounds = known_.bounds;
    starts_alike_ = CommonStart(logs_).has_value();
    result_.start_soc = CommonStart(logs_).value_or(1.0);
    for (const LoadedLog& log : logs_) {
      const std::vector<double> delivered_C = DeliveredCharge(log.log.record);
      deepest_C_.push_back(
          delivered_C.empty() ? 0.0 : *std::max_element(delivered_C.begin(), delivered_C.end()));
      FindLeastAlpha(log, delivered_C);
    }
    FitBesideTheStaged(for_staged);
    if (HasOffset()) {
      result_.least_alpha_C = 0.0;
      for (const LoadedLog& log : logs_) {
        const LoadedLog flowing = AsFlowing(log);
        FindLeastAlpha(flowing, DeliveredCharge(flowing.log.record));
      }
    }
    MakeCell();
    DoubtAlpha();
    result_.held_curve = MoveOfHeldCurve(result_);
    Judge();
    NameCautions();
    result_.wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return std::move(result_);
  }

 private:
  // The terms of the cell that is held, and its rates; only beta, alpha and resistances are left.
  void Hold(const std::shared_ptr<const HeldShape>& held) {
    const Cell& cell = held->cell;
    const auto presence = [](bool is) { return is ? Presence::kOn : Presence::kOff; };
    const bool warm =
        cell.temperature && std::all_of(logs_.begin(), logs_.end(), [](const auto& log) {
          return log.entry.kind == LogKind::kValidation || log.entry.ambient_degC ||
                 !log.log.record.temperature_degC.empty();
        });
    options_.branches = static_cast<int>(cell.branches.size());
    options_.self_heating = presence(cell.self_heating.has_value());
    options_.charge_transfer = presence(cell.charge_transfer.has_value());
    options_.temperature = presence(warm);
    options_.entropy = presence(warm && cell.temperature->entropy);
    options_.hysteresis = presence(cell.hysteresis.has_value());
    options_.current_offset = Presence::kOff;
    for (const auto& [name, value] : held->Rates()) {
      if (warm || !name.starts_with("E_")) known_.fixed.try_emplace(name, value);
    }
    result_.setup.held = held;
    result_.setup.axis_follows_alpha = true;
    if (cell.temperature) result_.setup.reference_K = cell.temperature->reference_K;
  }

  void Tell(std::string_view stage, double share) const {
    if (progress_) progress_(stage, share);
  }

  // The joint fit needs alpha and v_oc(A) of the staged run; its pulses are fitted side by side.
  void FitBesideTheStaged(const StagedGiven& for_staged) {
    tbb::task_group joint;
    std::exception_ptr failed;
    StagedResult staged;
    try {
      staged = IdentifyStaged(
          campaign_,
          logs_,
          staged_options_,
          for_staged,
          [&](auto stage, double share) {
            constexpr double kBeforePulses = 0.2;
            if (share < kBeforePulses) Tell(stage, share);
          },
          [&](const StagedResult& before) {
            result_.staged = before;
            joint.run([this] {
              FindAlpha();
              Fit();
            });
          });
    } catch (...) {
      failed = std::current_exception();
    }
    joint.wait();
    if (failed) std::rethrow_exception(failed);
    StopIfAsked();
    result_.staged = std::move(staged);
  }

  // A log that charges may rest above v_oc, and says nothing.
  void FindLeastAlpha(const LoadedLog& log, const std::vector<double>& delivered_C) {
    const Record& record = log.log.record;
    if (log.entry.kind == LogKind::kValidation || !campaign_.cutoff_V ||
        log.entry.initial_soc != result_.start_soc)
      return;
    if (std::any_of(
            record.current_A.begin(), record.current_A.end(), [](double i) { return i < 0.0; }))
      return;
    for (std::size_t k = 0; k < delivered_C.size(); ++k) {
      const double least_C = delivered_C[k] / result_.start_soc;
      if (record.voltage_V[k] < *campaign_.cutoff_V || least_C <= result_.least_alpha_C) continue;
      result_.least_alpha_C = least_C;
      file_of_least_alpha_ = log.entry.file;
    }
  }

  // What a log delivers cannot be more than all.
  void DoubtAlpha() {
    constexpr double kMore = 1.01;  // errors of counting
    const double alpha_C = result_.cell.alpha_C();
    result_.alpha_not_found = result_.choice.best.AtBound("alpha") && !known_.Bounds("alpha");
    if (result_.alpha_not_found) {
      result_.alpha_doubt = fmt::format(
          "no charge was found by which these logs agree, and alpha, {:.4g} Ah, is only where the search for it ends: "
          "look whether every initial_soc is a share of this cell's own charge",
          alpha_C / 3600.0);
    }
    if (result_.alpha_doubt.empty()) DoubtStarts(alpha_C);
    if (!result_.alpha_doubt.empty() || result_.least_alpha_C <= kMore * alpha_C) return;
    result_.alpha_doubt = fmt::format(
        "alpha is {:.4g} Ah, and {} takes {:.4g} Ah out of {} above the cut-off: look whether every initial_soc is "
        "a share of this cell's own charge{}",
        alpha_C / 3600.0,
        file_of_least_alpha_,
        result_.least_alpha_C * result_.start_soc / 3600.0,
        result_.start_soc == 1.0 ? "a full cell" : "the cell",
        given_.alpha_C ? ", and alpha, which was given, right" : "");
  }

  // Logs that start at different states of charge fix alpha by them. So does the end of v_oc(A): it is at the cut-off
  // where A = 0. Real cells whose logs all start full, which are not asked here, had 0.000 to 0.006 of alpha left.
  void DoubtStarts(double alpha_C) {
    constexpr double kLeft = 0.004;
    constexpr double kReached = 0.02;  // beyond, the line down to the cut-off is a guess
    if (starts_alike_ || !free_alpha_ || !campaign_.cutoff_V || !AtOneTemperature()) return;
    const CutoffPoint cutoff = Cutoff(result_.choice.best);
    const double lowest_soc = result_.cell.open_circuit_voltage.soc_lo();
    if (!cutoff.found || !(cutoff.soc > kLeft) || lowest_soc - cutoff.soc > kReached) return;
    const double down_to_it_C = (1.0 - cutoff.soc) * alpha_C;
    std::vector<std::string> starts;
    for (const LoadedLog& log : logs_) {
      const double given = log.entry.initial_soc;
      if (log.entry.kind == LogKind::kValidation || given == 1.0) continue;
      starts.push_back(fmt::format("{:.4f} for {} in place of {:g}",
                                   1.0 - (1.0 - given) * alpha_C / down_to_it_C,
                                   log.entry.file,
                                   given));
    }
    result_.alpha_doubt = fmt::format(
        "by the initial_soc of these logs alpha is {:.4g} Ah, and v_oc(A) is down to the cut-off of {:.4g} V with "
        "{:.2g} % of that left: a full cell gives {:.4g} Ah down to it, which would make initial_soc {}, unless the "
        "others began less than full",
        alpha_C / 3600.0,
        *campaign_.cutoff_V,
        100.0 * cutoff.soc,
        down_to_it_C / 3600.0,
        fmt::join(starts, ", "));
  }

  // What leaves the logs from their start down to the cut-off is this share of alpha.
  [[nodiscard]] double AlphaTo(const CutoffPoint& cutoff, double alpha_C) const {
    return alpha_C * (result_.start_soc - cutoff.soc) / result_.start_soc;
  }

  void Prepare(double alpha_C) {
    const StagedResult& staged = result_.staged;
    JointSetup& setup = result_.setup;
    setup.alpha_C = alpha_C;
    setup.diffusion = diffusion_;
    setup.terms = staged_options_.pulses.terms;
    setup.tail = staged_options_.pulses.tail;
    setup.edge_resistance_Ohm = staged.start.series_resistance_Ohm;
    setup.open_circuit_voltage = staged.cell.open_circuit_voltage;
    if (!curve_given_) {
      setup.open_circuit_voltage =
          AtNodes(Rescaled(setup.open_circuit_voltage, staged.alpha_C, alpha_C),
                  OnAxis(VoltageNodes(options_.voltage_nodes), LowestSoc(alpha_C)));
    }
    // alpha is searched, and the points stay.
    if (result_.logs.logs.empty()) result_.logs = MakeJointPoints(logs_);
    Weigh(result_.logs,
          alpha_C,
          CurveOfWeights(alpha_C),
          {.charge_uncertainty = options_.charge_uncertainty,
           .voltage_uncertainty_V = options_.voltage_uncertainty_V});
  }

  // A row counts by the slope of the curve at its charge. Below what the low-rate log saw the curve of the staged
  // run goes on straight, and that of the rough fit knows the slope: full weight on a steep curve between few
  // nodes bends resistances and beta by many of their errors. Of a short end the rough slopes are mostly noise,
  // and logs of several temperatures need more than a rough fit.
  [[nodiscard]] OpenCircuitVoltage CurveOfWeights(double alpha_C) const {
    const OpenCircuitVoltage& curve = result_.setup.open_circuit_voltage;
    const auto& slow = result_.staged.open_circuit_voltage;
    constexpr double kMuchUnseen = 0.1;
    if (curve_given_ || !slow || !rough_curve_) return curve;
    if (result_.logs.warmest_K - result_.logs.coldest_K >= kLeastSpan_K) return curve;
    const double seen = RescaledSoc(slow->curve.soc_lo(), result_.staged.alpha_C, alpha_C);
    const std::vector<double>& soc = curve.soc();
    if (seen - soc.front() < kMuchUnseen) return curve;
    std::vector<double> voltage_V = curve.voltage_V();
    const auto rough = [&](double a) {
      return (*rough_curve_)(RescaledSoc(a, alpha_C, rough_alpha_C_));
    };
    for (std::size_t k = soc.size() - 1; k-- > 0;) {
      if (soc[k] < seen)
        voltage_V[k] = voltage_V[k + 1] - std::max(0.0, rough(soc[k + 1]) - rough(soc[k]));
    }
    return OpenCircuitVoltage::Linear(soc, std::move(voltage_V));
  }

  // Where the charge of the logs ends.
  [[nodiscard]] double LowestSoc(double alpha_C) const {
    double most_C = 0.0;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      if (logs_[l].entry.kind == LogKind::kValidation || logs_[l].log.record.size() == 0) continue;
      most_C = std::max(most_C, alpha_C * (1.0 - logs_[l].entry.initial_soc) + deepest_C_[l]);
    }
    return 1.0 - most_C / alpha_C;
  }

  [[nodiscard]] std::vector<double> CurveNodes() const {
    return curve_given_ ? std::vector<double>{} : result_.setup.open_circuit_voltage.soc();
  }

  // What the search for alpha fits: enough to bring the logs together, and no more.
  [[nodiscard]] JointStructure RoughStructure(double alpha_C) const {
    JointStructure structure;
    structure.free_alpha = free_alpha_;
    if (given_.reference) {
      structure.branches = options_.branches;
      structure.resistance_soc = given_.reference->ResistanceNodes();
      structure.charge_transfer = options_.charge_transfer == Presence::kOn;
      return structure;
    }
    structure.branches = options_.branches >= 0 ? options_.branches : 1;
    structure.resistance_soc =
        OnAxis(ResistanceNodes(options_.resistance_nodes > 0 ? options_.resistance_nodes
                               : result_.logs.groups >= 2    ? 13
                                                             : 1),
               LowestSoc(alpha_C));
    structure.voltage_soc = CurveNodes();
    // Charge that a sensor counts too little on the way out and too much on the way in is no charge of the cell.
    structure.current_offset =
        options_.current_offset == Presence::kOn ||
        (options_.current_offset == Presence::kAuto && BothWays(result_.logs));
    structure.temperature = result_.logs.warmest_K - result_.logs.coldest_K >= kLeastSpan_K &&
                            options_.temperature != Presence::kOff;
    return structure;
  }

  // A fit about that alpha, near another one if there was one.
  [[nodiscard]] JointSolution RoughFit(double alpha_C, const JointSolution& near) {
    Prepare(alpha_C);
    const JointObservations seen(result_.logs, result_.setup);
    return JointFit(seen, known_)
        .Search(RoughStructure(alpha_C), 1e-3, near.x.size() > 0 ? &near : nullptr);
  }

  [[nodiscard]] double RmseOf(const JointSolution& solution) const {
    return std::sqrt(std::max(solution.square, 0.0) / result_.logs.weight_sum);
  }

  void KeepRoughCurve(double alpha_C) {
    const std::vector<double>& soc = rough_.structure.voltage_soc;
    if (rough_.x.size() == 0 || soc.empty()) return;
    std::vector<double> voltage_V;
    for (const double a : soc)
      voltage_V.push_back(OpenCircuitVoltageIn(rough_, result_.setup.open_circuit_voltage, a));
    rough_curve_ = OpenCircuitVoltage::Linear(soc, std::move(voltage_V));
    rough_alpha_C_ = alpha_C;
  }

  // A label says little of the charge, and far from it other charges seem to fit: each range of a search, and
  // those on both sides of it, which overlap.
  [[nodiscard]] double BestOfAllRanges(double label_C) {
    double best_C = label_C;
    double least_V = kInfinity;
    for (const double factor : {1.0, 0.5, 2.0, 0.25, 4.0}) {
      Tell("alpha", 0.2);
      result_.setup.search_about_C = factor * label_C;
      const JointSolution rough = RoughFit(factor * label_C, {});
      if (rough.x.size() == 0) continue;
      const double rmse_V = RmseOf(rough);
      if (rmse_V >= least_V) continue;
      least_V = rmse_V;
      best_C = rough.rates.alpha_C;
    }
    return best_C;
  }

  // v_oc(A) is given over the whole charge, or held: alpha is an unknown of the fit itself, what
  // brings the logs onto that curve. Weights and axis want one that is near.
  void FindAlphaOfCurve(double alpha_C) {
    result_.setup.axis_follows_alpha = free_alpha_ = true;
    result_.alpha_source = "least-squares";
    if (!given_.reference) {
      if (source_of_start_ == "nominal-capacity" || source_of_start_ == "delivered-charge")
        alpha_C = BestOfAllRanges(alpha_C);
      result_.setup.search_about_C = alpha_C;
    }
    for (int pass = 0; pass < 2; ++pass) {
      Tell("alpha", 0.2 + 0.05 * pass);
      const JointSolution rough = RoughFit(alpha_C, {});
      if (rough.x.size() == 0) break;
      alpha_C = rough.rates.alpha_C;
    }
    Prepare(alpha_C);
  }

  // The charge of the low-rate log, or else alpha of the staged run; what a log delivers is more than
  // that of a slow discharge that was stopped.
  [[nodiscard]] double ChargeOfLogs() {
    double charge_C = LowRateCharge(result_.staged, logs_);
    source_of_start_ = charge_C > 0.0 ? "low-rate-charge" : result_.staged.alpha_source;
    if (!(charge_C > 0.0)) charge_C = result_.staged.alpha_C;
    const double delivered_C = (1.0 - LowestSoc(charge_C)) * charge_C;
    constexpr double kStopped = 1.2;
    if (delivered_C > kStopped * charge_C) {
      source_of_start_ = "delivered-charge";
      charge_C = delivered_C;
    }
    return charge_C;
  }

  // Whether the last slope of v_oc would have to say too much of alpha.
  [[nodiscard]] bool HardlySeen(double alpha_C) const {
    constexpr double kMostUnseen = 0.2;
    return LowestSoc(alpha_C) > kMostUnseen;
  }

  // alpha with which v_oc(0) is the cut-off, by a first fit.
  void FindAlpha() {
    const StagedResult& staged = result_.staged;
    if (given_.alpha_C || (!curve_given_ && !campaign_.cutoff_V)) {
      Prepare(staged.alpha_C);
      result_.alpha_source = staged.alpha_source;
      return;
    }
    if (given_.reference) return FindAlphaOfCurve(given_.reference->cell.alpha_C());
    double alpha_C = ChargeOfLogs();
    if (curve_given_) return FindAlphaOfCurve(alpha_C);
    result_.alpha_source = "cut-off";
    // Twice: the nodes move with the capacity reference, and where they lie matters a little.
    const double charge_C = alpha_C;
    const auto search = [&] {
      rough_ = RoughFit(alpha_C, rough_);
      KeepRoughCurve(alpha_C);
      return RmseOf(rough_);
    };
    for (int pass = 0; pass < 2; ++pass) {
      Tell("alpha", 0.2 + 0.05 * pass);
      search();
      if (rough_.x.size() == 0) return;
      const double next_C = AlphaTo(Cutoff(rough_), alpha_C);
      if (!IsNear(next_C, alpha_C)) return;
      const double change = std::abs(next_C / alpha_C - 1.0);
      alpha_C = next_C;
      if (change < 1e-5) break;
    }
    // Where logs say at which state of charge they start, alpha is no mere reference: it moves them
    // against one another, and one that fits clearly better is taken.
    if (!starts_alike_) {
      const double cutoff_C = alpha_C;
      const double rmse_of_cutoff_V = search();
      free_alpha_ = true;
      // From the charge of the low-rate log; again where alpha moved, since the nodes lie where the
      // logs went by the alpha before.
      result_.setup.search_about_C = alpha_C = charge_C;
      constexpr int kMostPasses = 5;
      constexpr double kSettled = 1e-3;
      double least_V = kInfinity;
      JointSolution best;
      for (int pass = 0; pass < kMostPasses; ++pass) {
        const double rmse_V = search();
        if (rough_.x.size() == 0) break;
        const double change = std::abs(rough_.rates.alpha_C / alpha_C - 1.0);
        alpha_C = rough_.rates.alpha_C;
        // With so simple a structure a pass may end in a worse valley than the one before. Of several temperatures
        // the last one is kept: which of them is best goes with the order of the logs.
        if (rmse_V < least_V || !AtOneTemperature()) {
          best = rough_;
          least_V = rmse_V;
        }
        if (change < kSettled) break;
      }
      if (best.x.size() > 0 && least_V < kClearlyBetter * rmse_of_cutoff_V) {
        rough_ = std::move(best);
        alpha_C = rough_.rates.alpha_C;
        result_.alpha_source = "least-squares";
      } else {
        alpha_C = cutoff_C;
        free_alpha_ = false;
      }
    }
    if (!free_alpha_ && HardlySeen(alpha_C)) TakeKnownCharge(alpha_C, charge_C);
    Prepare(result_.alpha_doubt.empty() ? alpha_C : result_.alpha_C);
  }

  // Not the alpha of the last slope, but the charge of the logs, or the nominal one where that is more
  // than what was delivered.
  void TakeKnownCharge(double of_slope_C, double of_logs_C) {
    result_.alpha_source = source_of_start_;
    result_.alpha_C = of_logs_C;
    const double nominal_C = 3600.0 * campaign_.capacity_Ah;
    if (source_of_start_ == "delivered-charge" && nominal_C > of_logs_C) {
      result_.alpha_source = "nominal-capacity";
      result_.alpha_C = nominal_C;
    }
    result_.alpha_doubt = fmt::format(
        "the logs end {:.0f} % of the charge above where the last slope of v_oc leads to the cut-off: alpha is "
        "taken as {:.4g} Ah ({}), and a log down to the cut-off would tell",
        100.0 * LowestSoc(of_slope_C),
        result_.alpha_C / 3600.0,
        AlphaSourceInWords(result_.alpha_source));
  }

  // Where the solution's v_oc reaches the cut-off.
  [[nodiscard]] CutoffPoint Cutoff(const JointSolution& solution) const {
    return CutoffOf(solution, result_.logs, result_.setup, *campaign_.cutoff_V);
  }

  // Of the chambers that the logs began in.
  [[nodiscard]] bool AtOneTemperature() const {
    return !(result_.logs.start_span_K >= kLeastSpan_K);
  }

  void ChooseAll() {
    // The offset of a sensor is seen by what it does to alpha: the two are looked for together. So is what temperature
    // does, where the chambers had several: a full cell holds less in the cold, which no start says.
    const bool apart =
        !result_.setup.axis_follows_alpha && !rough_.structure.current_offset && AtOneTemperature();
    if (free_alpha_ && apart) return ChooseBesideAlpha();
    ChooseAtAlpha();
  }

  // What a structure lacks another charge makes up for, and richer ones that are looked for beside it stay in that
  // valley. So the structure is chosen with alpha held, then alpha is set free, and so on until it stays.
  void ChooseBesideAlpha() {
    constexpr int kMostPasses = 3;
    constexpr double kStays = 0.005;
    constexpr double kClearlyWorse = 1.1;
    struct Pass {
      double alpha_C;
      bool diffusion, slow_branches, fast_branches;
      std::vector<std::string> cautions;
      JointChoice choice;
    };
    const std::vector<std::string> said = result_.cautions;
    std::optional<Pass> before;
    const auto prepare = [&](double alpha_C, bool diffusion, bool slow, bool fast) {
      diffusion_ = diffusion;
      Prepare(alpha_C);
      result_.setup.slow_branches = slow;
      result_.setup.fast_branches = fast;
    };
    double alpha_C = source_of_start_ == "low-rate-charge" ? result_.setup.search_about_C
                                                           : result_.setup.alpha_C;
    for (int pass = 0; pass < kMostPasses; ++pass) {
      result_.cautions = said;
      prepare(alpha_C, staged_options_.pulses.diffusion, false, false);
      free_alpha_ = false;
      ChooseAtAlpha();
      free_alpha_ = true;
      JointChoice& choice = result_.choice;
      if (choice.best.x.size() > 0) SetAlphaFree();
      if (before &&
          !(choice.errors.expected_V < kClearlyWorse * before->choice.errors.expected_V)) {
        prepare(before->alpha_C, before->diffusion, before->slow_branches, before->fast_branches);
        result_.cautions = std::move(before->cautions);
        choice = std::move(before->choice);
        return;
      }
      const double found_C = choice.best.rates.alpha_C;
      if (!(std::abs(found_C / alpha_C - 1.0) > kStays) || pass + 1 == kMostPasses) return;
      before = Pass{alpha_C,
                    diffusion_,
                    result_.setup.slow_branches,
                    result_.setup.fast_branches,
                    std::move(result_.cautions),
                    std::move(choice)};
      alpha_C = found_C;
    }
  }

  // In every structure that was tried: their spread is a part of its interval.
  void SetAlphaFree() {
    const JointObservations seen(result_.logs, result_.setup);
    const JointFit fit(seen, known_);
    std::vector<JointSolution*> held{&result_.choice.best};
    for (TriedStructure& tried : result_.choice.tried) held.push_back(&tried.solution);
    ParallelFor(held.size(), [&](std::size_t k) {
      JointSolution& solution = *held[k];
      if (solution.x.size() == 0) return;
      JointStructure structure = solution.structure;
      structure.free_alpha = true;
      JointRates rates = solution.rates;
      rates.alpha_C = result_.setup.alpha_C;
      solution = fit.Approach(fit.Solve(structure, rates, solution.smoothness));
    });
    result_.evaluations += fit.evaluations();
  }

  // A structure, and how slow and fast its branches may be.
  void ChooseAtAlpha() {
    Choose(0.3, 0.3);
    if (ShowsNoDiffusion()) ChooseWithoutDiffusion();
    if (WantsSlower()) ChooseAmong(&JointSetup::slow_branches);
    if (WantsFaster()) ChooseAmong(&JointSetup::fast_branches);
  }

  // On a given curve branches slower than a rest, with tables of resistances, can stand in for a wrong alpha.
  // The voltage at the end of a rest is measured, and its state of charge follows from the curve alone. The fit
  // keeps its alpha where the two agree, for it knows what a rest that has not settled still has before it.
  bool TakeAlphaOfRests() {
    constexpr double kVague = 0.05;
    constexpr double kWorthTelling = 0.02;
    constexpr double kErrors = 2.0;
    const JointSolution& best = result_.choice.best;
    if (!free_alpha_ || !result_.setup.axis_follows_alpha || best.x.size() == 0) return false;
    if (known_.Fixed("alpha") || known_.Bounds("alpha")) return false;
    std::vector<std::vector<Segment>> segments;
    std::vector<LogOfRests> rested;
    segments.reserve(logs_.size());
    for (const LoadedLog& log : logs_) {
      if (log.entry.kind != LogKind::kPulses) continue;
      segments.push_back(FindPulses(log.log.record));
      rested.push_back({.record = &log.log.record,
                        .segments = &segments.back(),
                        .initial_soc = log.entry.initial_soc});
    }
    const auto rests = FindAlphaOfRests(rested, result_.setup.open_circuit_voltage);
    if (!rests || rests->error_C > kVague * rests->alpha_C) return false;
    const double fitted_C = best.rates.alpha_C;
    if (std::abs(fitted_C - rests->alpha_C) <=
        std::max(kErrors * rests->error_C, kWorthTelling * rests->alpha_C))
      return false;
    result_.alpha_of_rests = rests;
    result_.alpha_source = "rests";
    free_alpha_ = false;
    diffusion_ = staged_options_.pulses.diffusion;
    result_.setup.axis_follows_alpha = given_.reference != nullptr;
    result_.setup.slow_branches = result_.setup.fast_branches = false;
    Prepare(rests->alpha_C);
    result_.cautions = {fmt::format(
        "alpha is {:.4g} Ah, by which the ends of {} rests lie on the given v_oc(A), to {:.2g} Ah: left to the fit of "
        "all rows it would be {:.4g} Ah, which these rests contradict. beta and the resistances take this alpha as "
        "exact; --alpha-C gives another one",
        rests->alpha_C / 3600.0,
        rests->rests,
        rests->error_C / 3600.0,
        fitted_C / 3600.0)};
    return true;
  }

  void Fit() {
    ChooseAll();
    if (TakeAlphaOfRests()) ChooseAll();
    WithTask(0.3, 0.6, [&](const ChoiceTask& task) {
      result_.choice = FinishChoice(task, std::move(result_.choice));
    });
    if (result_.choice.best.x.size() == 0) {
      RefuseCampaign(campaign_,
                     "expected logs from which v_oc(A) and a resistance follow, found none that "
                     "determine them");
    }
    if (result_.alpha_source == "cut-off" && result_.choice.errors.smoothness <= kNoSmoothness)
      FitInItsOwnGauge();
    JointSolution& best = result_.choice.best;
    if (!known_.NamesABranch()) SortBranches(best);
    result_.rmse_V = RmseOf(best);
    result_.converged = best.termination == Termination::kConverged;
  }

  // Progress goes from `began` on by `share`.
  template <class Work>
  void WithTask(double began, double share, Work&& work) {
    const JointObservations seen(result_.logs, result_.setup);
    const JointFit fit(seen, known_);
    work(ChoiceTask{
        .fit = fit,
        .logs = result_.logs,
        .voltage_soc = CurveNodes(),
        .lowest_soc = LowestSoc(result_.setup.alpha_C),
        .options = options_,
        .free_alpha = free_alpha_,
        .near = &rough_,
        .progress = [&](double done) { Tell("all logs at once", began + share * done); }});
    result_.evaluations += fit.evaluations();
  }

  void Choose(double began, double share, const JointChoice* before = nullptr) {
    WithTask(began, share, [&](const ChoiceTask& task) {
      result_.choice = ChooseStructure(task, before);
    });
  }

  // A branch stands at a limit of its time constant, and nobody has said that it must.
  template <class At>
  [[nodiscard]] bool StandsAtLimit(At&& at) const {
    const JointSolution& best = result_.choice.best;
    return std::any_of(best.at_bound.begin(), best.at_bound.end(), [&](const std::string& name) {
      const auto tau = FindCellParameter(name);
      if (!tau || tau->kind->symbol != "tau" || known_.Bounds(name)) return false;
      return at(best.rates.time_constant_s[tau->branch]);
    });
  }
  [[nodiscard]] bool WantsSlower() const {
    return StandsAtLimit([&](double tau_s) { return tau_s > 0.5 * result_.choice.longest_tau_s; });
  }
  [[nodiscard]] bool WantsFaster() const {
    return StandsAtLimit(
        [&](double tau_s) { return tau_s < 1.01 * result_.choice.shortest_tau_s; });
  }

  // Left-out rows decide whether branches may be slower than the logs' segments, or faster than two rows.
  void ChooseAmong(bool JointSetup::*let_in) {
    JointChoice before = std::move(result_.choice);
    result_.setup.*let_in = true;
    Choose(0.6, 0.3, &before);
    if (!(result_.choice.errors.expected_V < before.errors.expected_V)) {
      result_.setup.*let_in = false;
      result_.choice = std::move(before);
      return;
    }
    const bool slower = let_in == &JointSetup::slow_branches;
    result_.cautions.push_back(fmt::format(
        "a branch stood at {:.6g} s, {}: time constants {} {:.6g} s were let in, since left-out rows are predicted "
        "better so (to {:.4g} mV, not {:.4g} mV)",
        slower ? before.longest_tau_s : before.shortest_tau_s,
        slower ? "the longest time at one current" : "twice the time between rows",
        slower ? "of up to" : "from",
        slower ? result_.choice.longest_tau_s : result_.choice.shortest_tau_s,
        1e3 * result_.choice.errors.expected_V,
        1e3 * before.errors.expected_V));
  }

  // Diffusion as fast as beta may be is a resistance that follows the slope of v_oc, and nobody has
  // said what beta is. What is fast in the warm need not be in the cold.
  [[nodiscard]] bool ShowsNoDiffusion() const {
    const JointSolution& best = result_.choice.best;
    if (!result_.setup.diffusion || given_.reference || known_.Bounds("beta") ||
        best.structure.temperature || result_.logs.groups < 2)
      return false;
    return best.AtBound("beta") && best.rates.beta_per_sqrt_s > kShowsNone_per_sqrt_s;
  }

  // From the beginning: tables and branches may follow what diffusion at its limit gets wrong.
  void ChooseWithoutDiffusion() {
    JointChoice with = std::move(result_.choice);
    result_.setup.diffusion = diffusion_ = false;
    Choose(0.45, 0.15);
    if (IsAskedFor(with.errors, result_.choice.errors, result_.logs)) {
      result_.setup.diffusion = diffusion_ = true;
      result_.choice = std::move(with);
      return;
    }
    result_.cautions.push_back(fmt::format(
        "these logs show no diffusion: beta went to its limit of {:.3g} s^-1/2, and without it left-out rows are "
        "predicted to {:.4g} mV, with it to {:.4g} mV; the cell has its capacity alone (--bounds beta=LOW,HIGH "
        "keeps diffusion)",
        with.best.rates.beta_per_sqrt_s,
        1e3 * result_.choice.errors.expected_V,
        1e3 * with.errors.expected_V));
  }

  // The first capacity reference was rough. Where the model is right to within the noise, kinks of
  // v_oc a part in a hundred thousand off the nodes would be the largest error left.
  void FitInItsOwnGauge() {
    JointSolution& best = result_.choice.best;
    const CutoffPoint cutoff = Cutoff(best);
    if (!cutoff.found || best.structure.voltage_soc != CurveNodes()) return;
    const double alpha_C = AlphaTo(cutoff, result_.setup.alpha_C);
    if (!IsNear(alpha_C, result_.setup.alpha_C)) return;
    Prepare(alpha_C);
    best.structure.voltage_soc = CurveNodes();
    const JointObservations seen(result_.logs, result_.setup);
    const JointFit fit(seen, known_);
    JointSolution again = fit.Polish(fit.Solve(best.structure, best.rates, best.smoothness),
                                     kFineStep,
                                     options_.iterations_per_variable);
    if (again.x.size() > 0) best = std::move(again);
  }

  void MakeCell() {
    const JointSolution& best = result_.choice.best;
    const JointSetup& setup = result_.setup;
    const SocTrace soc = TraceSoc(result_.logs, setup, best.rates);
    // What is held reaches as far as it did.
    const ReachedSoc reached =
        setup.held ? ReachedSoc{} : ReachedSoc{.lowest = soc.lowest, .highest = soc.highest};
    Cell& cell = result_.cell;
    cell = result_.staged.cell;  // name, pack, cut-off
    if (!curve_given_)
      cell.open_circuit_voltage = CurveOf(best, setup.open_circuit_voltage, reached);
    PutInto(cell, best, result_.logs.typical_A, reached);
    if (cell.temperature) {
      cell.temperature->reference_K = setup.reference_K;
      result_.heat.reset();
    }
    // Logs that start alike are the same with any capacity reference: the last word on alpha costs
    // nothing.
    double alpha_C = setup.alpha_C;
    if (result_.alpha_source == "cut-off") {
      const CutoffPoint cutoff = Cutoff(best);
      const double at_cutoff_C = AlphaTo(cutoff, alpha_C);
      if (IsNear(at_cutoff_C, alpha_C)) {
        result_.cutoff = cutoff;
        alpha_C = at_cutoff_C;
      } else {
        result_.alpha_source = source_of_start_;
        result_.cautions.push_back(fmt::format(
            "v_oc(A) of these logs does not lead to the cut-off of {:.4g} V within twice "
            "their charge: alpha is {:.4g} Ah, as the first stage has it ({}). Look whether "
            "the cut-off is that of one cell, and `series` right",
            *campaign_.cutoff_V,
            alpha_C / 3600.0,
            result_.alpha_source));
      }
    } else if (free_alpha_) {
      alpha_C = best.rates.alpha_C;
    }
    if (setup.axis_follows_alpha) {
      // Every curve is over A already.
    } else if ((starts_alike_ || free_alpha_) && alpha_C != setup.alpha_C) {
      MoveChargeAxis(cell, result_.start_soc, setup.alpha_C / alpha_C);
    } else {
      alpha_C = setup.alpha_C;
    }
    result_.alpha_C = alpha_C;
    if (setup.diffusion) {
      cell.diffusion = Cell::Diffusion{.alpha_C = alpha_C,
                                       .beta_per_sqrt_s = best.rates.beta_per_sqrt_s,
                                       .terms = setup.terms,
                                       .tail = setup.tail};
    } else {
      cell.diffusion.reset();
      cell.capacity_Ah = alpha_C / 3600.0;
    }
    if (cell.temperature || (setup.held && setup.held->cell.temperature))
      cell.reference_degC.reset();
    SayWhereSeen(cell);
    if (setup.held && setup.held->cell.temperature) {
      // What these logs do not show is as it was.
      if (!cell.temperature) cell.temperature = setup.held->cell.temperature;
      cell.temperature->heat = setup.held->cell.temperature->heat;
      cell.heat_assumed = setup.held->cell.heat_assumed;
      if (cell.temperature->entropy)
        cell.temperature->entropy = setup.held->cell.temperature->entropy;
      return;
    }
    if (!cell.temperature) return;
    result_.heat = FitHeat(cell, logs_);
    if (!result_.heat) {
      if (warm_ != nullptr && warm_->assumed) AssumeHeat(warm_->by, cell);
      return;
    }
    cell.temperature->heat = result_.heat->balance;
    if (cell.temperature->entropy)
      cell.temperature->entropy->reversible_heat = result_.heat->reversible;
  }

  // The logs' own temperatures, and those that a cell that is held was seen at.
  void SayWhereSeen(Cell& cell) const {
    const Cell* held = result_.setup.held ? &result_.setup.held->cell : nullptr;
    cell.temperature_seen.reset();
    if (std::isnan(result_.logs.coldest_K)) return;
    TemperatureRange seen{.coldest_degC = result_.logs.coldest_K - kZeroCelsius_K,
                          .warmest_degC = result_.logs.warmest_K - kZeroCelsius_K};
    if (held != nullptr && held->temperature && !held->temperature_seen) return;
    if (held != nullptr && held->temperature_seen) {
      seen.coldest_degC = std::min(seen.coldest_degC, held->temperature_seen->coldest_degC);
      seen.warmest_degC = std::max(seen.warmest_degC, held->temperature_seen->warmest_degC);
    }
    cell.temperature_seen = seen;
  }

  [[nodiscard]] bool HasOffset() const { return result_.choice.best.structure.current_offset; }
  // By the currents that flowed, where the sensor was found to have an offset.
  [[nodiscard]] LoadedLog AsFlowing(LoadedLog log) const {
    for (double& current_A : log.log.record.current_A)
      current_A = result_.choice.best.rates.Flowing(current_A);
    return log;
  }
  [[nodiscard]] LogErrors ValidateAsFlowing(const LoadedLog& log) const {
    return Validate(result_.cell, HasOffset() ? AsFlowing(log) : log);
  }

  // Every log by the cell itself, on all of its rows; and by the staged cell beside it. Where no thermometer
  // told, the cell is as warm as it says itself, which is what a user of its file gets.
  void Judge() {
    Tell("validation", 0.92);
    std::vector<LogErrors> joint(recorded_.size());
    std::vector<LogErrors> before(recorded_.size());
    ParallelFor(2 * recorded_.size(), [&](std::size_t task) {
      const LoadedLog& log = recorded_[task / 2];
      const bool by_joint = task % 2 == 0;
      if (!by_joint && log.entry.kind == LogKind::kValidation) return;
      (by_joint ? joint : before)[task / 2] =
          by_joint ? ValidateAsFlowing(log) : Validate(result_.staged.cell, log);
    });
    for (std::size_t l = 0; l < recorded_.size(); ++l) {
      if (recorded_[l].entry.kind == LogKind::kValidation) {
        result_.validation.push_back(std::move(joint[l]));
      } else {
        result_.fitted.push_back(std::move(joint[l]));
        result_.fitted_staged.push_back(std::move(before[l]));
      }
    }
    if (campaign_.cutoff_V)
      result_.constant_current = ValidateConstantCurrents(result_.cell, recorded_);
  }

  // What a --fix says is not as in the reference.
  [[nodiscard]] std::vector<std::string> HeldNames(const HeldShape& held) const {
    std::vector<std::string> names = held.Names();
    std::erase_if(names, [&](const auto& name) { return given_.parameters.Fixed(name); });
    return names;
  }

  [[nodiscard]] std::vector<std::string> FittedBesideAReference(const HeldShape& held) const {
    std::vector<std::string> fitted;
    if (free_alpha_) fitted.emplace_back("alpha");
    if (result_.setup.diffusion && !known_.Fixed("beta")) fitted.emplace_back("beta");
    for (const std::string& name : CellResistanceNames(held.cell)) {
      if (!known_.Fixed(name)) fitted.push_back(name);
    }
    if (held.cell.self_heating) fitted.emplace_back("rho_h");
    return fitted;
  }

  void NameCautions() {
    auto& say = result_.cautions;
    const JointSolution& best = result_.choice.best;
    if (std::string held = given_.HeldInWords(); !held.empty()) say.push_back(std::move(held));
    if (!result_.choice.reason.empty()) say.push_back(result_.choice.reason);
    if (const auto& held = result_.setup.held) {
      say.push_back(fmt::format(
          "held as in {}: {}, and the shapes of the resistances over A where these logs "
          "say nothing; fitted: {}",
          held->source,
          fmt::join(HeldNames(*held), ", "),
          fmt::join(FittedBesideAReference(*held), ", ")));
      say.push_back(fmt::format(
          "that {} is this very cell is an assumption: these logs would show another one only where they reach, "
          "above a state of charge of {:.2f}",
          held->source,
          LowestSoc(result_.alpha_C)));
    }
    for (const auto& name : best.at_bound) {
      say.push_back(
          name == "beta" && given_.parameters.Bounds("beta")
              ? fmt::format(
                    "beta is at the limit that --bounds gives it, {:.6g} s^-1/2: these logs would be fitted as well "
                    "or better beyond it",
                    best.rates.beta_per_sqrt_s)
          : name == "beta"
              ? fmt::format(
                    "beta is at its limit, {:.3g} s^-1/2: these logs show no diffusion apart "
                    "from the branches",
                    best.rates.beta_per_sqrt_s)
              : fmt::format("{} is at a limit of its range: these logs would be fitted as well or "
                            "better beyond it",
                            name));
    }
    const bool looked_for = best.structure.charge_transfer || best.structure.self_heating;
    if (!result_.logs.several_currents && !looked_for && !given_.reference) {
      say.push_back(fmt::format(
          "low rates aside, all loads of these logs are of about {:.3g} A: charge transfer and "
          "self-heating, which only several currents show, are not looked for, a load of another "
          "current is an extrapolation, and nothing here tests whether the model is right: the intervals take it as "
          "right",
          result_.logs.load_A));
    }
    if (!result_.alpha_doubt.empty()) say.push_back(result_.alpha_doubt);
    NameStartsThatAlphaRestsOn();
    NameSensorThatAlphaRestsOn();
    NameStartOfAHeldCurve();
    NameModesInTheTail();
    NameSmoothBranches();
    NameWhereNoLoadWas();
    NameTemperatureCautions();
    if (best.structure.current_offset) {
      say.push_back(fmt::format(
          "the current sensor shows {:.4g} mA more than flows: charge out and charge in do not agree "
          "otherwise. The errors are those of the corrected currents; the offset is the sensor's, "
          "and the cell file does not hold it",
          1e3 * best.rates.current_offset_A));
    }
    constexpr double kWorthSaying_V = 0.02;
    if (result_.cutoff.extrapolated) {
      const double lowest_V =
          result_.cell.open_circuit_voltage(result_.cell.open_circuit_voltage.soc_lo());
      if (lowest_V > *campaign_.cutoff_V + kWorthSaying_V) {
        say.push_back(fmt::format(
            "v_oc was seen down to {:.3g} V only: alpha follows from its last slope to {:.3g} V",
            lowest_V,
            *campaign_.cutoff_V));
      }
    }
    for (std::size_t j = 0; j < result_.cell.branches.size(); ++j) {
      const auto& r = result_.cell.branches[j].resistance_Ohm.resistance_Ohm;
      const auto& r_s = result_.cell.series_resistance_Ohm.resistance_Ohm;
      if (*std::max_element(r.begin(), r.end()) <=
          kNotFound * *std::max_element(r_s.begin(), r_s.end())) {
        say.push_back(fmt::format(
            "branch {} was not found: its resistance went to zero, and its time constant means "
            "nothing",
            j + 1));
      }
    }
  }

  // A log that starts at A_0 after the charge q has A_0 = 1 - q/alpha: dalpha/dA_0 = alpha/(1 - A_0).
  void NameStartsThatAlphaRestsOn() {
    if (result_.start_soc < 1.0 && result_.alpha_source == "cut-off") {
      result_.cautions.push_back(fmt::format(
          "every log starts at initial_soc = {0:.6g}, which is taken as exact: alpha is the charge from "
          "there to the cut-off over {0:.6g}, and a start that is off by 0.01 would change it by {1:.2g} %",
          result_.start_soc,
          1.0 / result_.start_soc));
    }
    if (!free_alpha_ || result_.setup.axis_follows_alpha) return;
    constexpr double kStep = 0.01;
    constexpr std::size_t kNamed = 5;
    std::vector<std::pair<double, std::string>> starts;  // the change of alpha in %, and the file
    for (const LoadedLog& log : logs_) {
      if (log.entry.kind == LogKind::kValidation || log.entry.initial_soc == 1.0) continue;
      starts.emplace_back(std::abs(100.0 * kStep / (1.0 - log.entry.initial_soc)), log.entry.file);
    }
    std::stable_sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) {
      return a.first > b.first;
    });
    std::vector<std::string> words;
    for (const auto& [change_percent, file] : starts) {
      if (words.size() == kNamed) {
        words.push_back(fmt::format("{} more", starts.size() - kNamed));
        break;
      }
      words.push_back(fmt::format("{} ({:.2g} %)", file, change_percent));
    }
    result_.cautions.push_back(fmt::format(
        "alpha rests on the initial_soc of these logs, which is taken as exact; by that log alone, a start "
        "that is off by {:g} would change alpha by the figure in brackets: {}",
        kStep,
        fmt::join(words, ", ")));
  }

  // What a slow discharge counts of a current that does not flow, no other discharge shows.
  void NameSensorThatAlphaRestsOn() {
    constexpr double kOffset = 1e-3;  // of the largest current: what current sensors are sold with
    constexpr double kWorthSaying = 0.01;
    constexpr double kShows = 0.003;
    if (given_.alpha_C || given_.reference || HasOffset()) return;
    if (std::any_of(logs_.begin(), logs_.end(), [](const LoadedLog& log) {
          return log.entry.kind == LogKind::kLowRateCharge;
        }))
      return;
    std::size_t deepest = logs_.size();
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      if (logs_[l].entry.kind == LogKind::kValidation) continue;
      if (deepest == logs_.size() || deepest_C_[l] > deepest_C_[deepest]) deepest = l;
    }
    if (deepest == logs_.size() || !(deepest_C_[deepest] > 0.0)) return;
    const double loaded_s = UnderLoad(logs_[deepest].log.record).first;
    const double per_A = loaded_s / deepest_C_[deepest];
    if (kOffset * result_.logs.largest_A * per_A < kWorthSaying) return;
    std::string at_rest;
    if (const double rest_A = CurrentAtRest(); std::abs(rest_A) * per_A > kShows) {
      at_rest = fmt::format(
          ". At rest it shows {:.2g} mA: if none flows there, alpha is {:.2g} % off, and time constants and "
          "resistances are off, too; take that out of the column of the current",
          1e3 * rest_A,
          100.0 * std::abs(rest_A) * per_A);
    }
    result_.cautions.push_back(fmt::format(
        "alpha takes the zero of the current sensor as exact: each mA of an offset would change it by {:.2g} % "
        "over the {:.3g} h of {}; a slow charge (low-rate-charge) would show it{}",
        0.1 * per_A,
        loaded_s / 3600.0,
        logs_[deepest].entry.file,
        at_rest));
  }

  // What the sensor shows in rests of a minute or more, where they agree on it; else 0.
  [[nodiscard]] double CurrentAtRest() const {
    constexpr double kShortest_s = 60.0;
    constexpr std::size_t kFewest = 3;
    constexpr double kAgree = 0.2;  // standard deviation of the rests over their mean
    std::vector<double> rests_A;
    for (const LoadedLog& log : logs_) {
      if (log.entry.kind == LogKind::kValidation) continue;
      for (const Segment& segment : FindSegments(log.log.record)) {
        if (segment.kind == SegmentKind::kRest && segment.duration_s() >= kShortest_s)
          rests_A.push_back(segment.current_A);
      }
    }
    if (rests_A.size() < kFewest) return 0.0;
    const auto n = static_cast<double>(rests_A.size());
    const double mean_A = std::accumulate(rests_A.begin(), rests_A.end(), 0.0) / n;
    double squares = 0.0;
    for (const double rest_A : rests_A) squares += (rest_A - mean_A) * (rest_A - mean_A);
    return std::sqrt(squares / (n - 1.0)) < kAgree * std::abs(mean_A) ? mean_A : 0.0;
  }

  // A curve that is held tells where logs end, and alpha is what they took out until there: from a start
  // that is lower by d it is less by d over the share of the charge that they took.
  void NameStartOfAHeldCurve() {
    if (!result_.setup.axis_follows_alpha || !starts_alike_) return;
    constexpr double kStep = 0.01;
    constexpr double kWorthSaying = 0.015;
    const double deepest_C = *std::max_element(deepest_C_.begin(), deepest_C_.end());
    const double change = kStep * result_.alpha_C / deepest_C;
    if (!(change > kWorthSaying)) return;
    result_.cautions.push_back(fmt::format(
        "alpha takes the start of these logs as exact, and they take out {:.2g} of the charge: a start that is lower "
        "by {:g} would be {:.2g} % less alpha",
        deepest_C / result_.alpha_C,
        kStep,
        100.0 * change));
  }

  // Beyond M of them modes count by their steady value, which is a resistance: rows must be no faster,
  // nor may a question be.
  void NameModesInTheTail() {
    const auto& diffusion = result_.cell.diffusion;
    if (!diffusion || !diffusion->tail) return;
    const double slowest_s = diffusion->FirstOfTail_s();
    double rows_s = kInfinity;  // between two rows under load, on average
    for (const LoadedLog& log : logs_) {
      const LogKind kind = log.entry.kind;
      if (kind != LogKind::kPulses && kind != LogKind::kConstantCurrent) continue;
      const auto [loaded_s, rows] = UnderLoad(log.log.record);
      rows_s = std::min(rows_s, loaded_s / std::max(rows, 1.0));
    }
    constexpr double kFirstAnswer_s = 1.0;  // of the resistances at half charge
    const bool seen = slowest_s > rows_s;
    if (!seen && !(slowest_s > kFirstAnswer_s)) return;
    constexpr double kMostTerms = 100.0;
    const double within_s = std::min(rows_s, kFirstAnswer_s);
    const double wanted = std::ceil(1.0 / (diffusion->beta_per_sqrt_s * std::sqrt(0.5 * within_s)));
    result_.cautions.push_back(fmt::format(
        "diffusion is counted in {} modes, and the next, of {:.2g} s, is slower than {}: what is left of it stands "
        "in {}, and is counted in the intervals; --set pulses.terms={} would tell",
        diffusion->terms,
        slowest_s,
        seen ? fmt::format("the rows, every {:.2g} s", rows_s)
             : "the resistance after 1 s asks for, though not than the rows",
        seen ? "r_s and in a fast branch" : "r_s, and makes that resistance too large",
        std::min(wanted, kMostTerms)));
  }

  void NameSmoothBranches() {
    const double times = result_.choice.best.structure.branch_smoothness;
    if (times <= 1.0) return;
    result_.cautions.push_back(fmt::format(
        "the resistances of the branches are held {:g} times as smooth over the state of charge as r_s: "
        "freer ones go up and down from node to node, as no cell's do",
        times));
  }

  void NameWhereNoLoadWas() {
    const JointLogs& logs = result_.logs;
    if (result_.choice.best.structure.nodes() == 1) return;
    if (!std::isfinite(logs.lowest_loaded_soc) && !std::isfinite(logs.highest_loaded_soc)) return;
    result_.cautions.push_back(fmt::format(
        "loads were between {:.2f} and {:.2f} of the charge: beyond, resistances are taken to {}, and neither they "
        "nor their intervals are seen",
        std::max(logs.lowest_loaded_soc, 0.0),
        std::min(logs.highest_loaded_soc, 1.0),
        result_.setup.held ? "have changed as they have there" : "go on as they are there"));
  }

  // One log without a temperature is enough to leave it out.
  void NameLogsWithoutTemperature() {
    std::vector<std::string> silent;
    bool any = false;
    for (const LoadedLog& log : logs_) {
      if (log.entry.kind == LogKind::kValidation) continue;
      const bool tells = log.entry.ambient_degC || !log.log.record.temperature_degC.empty();
      if (!tells) silent.push_back(log.entry.file);
      any = any || tells;
    }
    const Cell* held = result_.setup.held ? &result_.setup.held->cell : nullptr;
    const bool held_knows = held != nullptr && held->temperature;
    if (silent.empty() || (!any && !held_knows)) return;
    const std::string files =
        fmt::format("{} {}", fmt::join(silent, ", "), silent.size() == 1 ? "tells" : "tell");
    if (held_knows) {
      result_.cautions.push_back(fmt::format(
          "{} no temperature, and all logs are taken to be at the {:.3g} degC of the reference: ambient_degC says which "
          "it was",
          files,
          held->temperature->reference_K - kZeroCelsius_K));
    } else if (options_.temperature != Presence::kOff) {
      result_.cautions.push_back(fmt::format(
          "temperature takes no part, for {} none: ambient_degC says which it was", files));
    }
  }

  // A chamber that did not keep its temperature, or a fan that came on, is no property of the cell.
  void NameDoubtfulHeat() {
    constexpr double kHardlyKnown = 0.5;   // relative standard error
    constexpr double kUnexplained = 0.15;  // of the rise; logs of a chamber have 0.02 to 0.1
    if (!result_.heat) return;
    const HeatFit& heat = *result_.heat;
    const double c_th = heat.balance.heat_capacity_J_per_K;
    const double r_th = heat.balance.thermal_resistance_K_per_W;
    const bool unknown = heat.heat_capacity_standard_error_J_per_K > kHardlyKnown * c_th ||
                         heat.thermal_resistance_standard_error_K_per_W > kHardlyKnown * r_th;
    if (!unknown && heat.rmse_K < kUnexplained * heat.largest_rise_K) return;
    result_.cautions.push_back(fmt::format(
        "the heat balance is not to be believed, {:.3g} +- {:.2g} J/K and {:.3g} +- {:.2g} K/W: it explains the measured "
        "temperatures to {:.2g} degC of a rise by {:.2g}. Did the air keep to one temperature in each log (ambient_degC, "
        "else the first row)? Where a log has no temperature_degC (--ambient-degC) the predicted temperature is as far off",
        c_th,
        heat.heat_capacity_standard_error_J_per_K,
        r_th,
        heat.thermal_resistance_standard_error_K_per_W,
        heat.rmse_K,
        heat.largest_rise_K));
  }

  // No cell has so much: something else that goes with the temperature is in it.
  void NameEntropyAtItsLimit() {
    constexpr double kAlmost = 0.999;
    const JointSolution& best = result_.choice.best;
    const JointLayout layout(best.structure);
    std::vector<std::string> at;
    for (int k = 0; k < layout.entropies(); ++k) {
      if (std::abs(best.x[layout.entropy() + k]) > kAlmost * kMostEntropy_V_per_K * kEntropyScale_K)
        at.push_back(
            fmt::format("{:.2g}", best.structure.entropy_soc[static_cast<std::size_t>(k)]));
    }
    if (at.empty()) return;
    result_.cautions.push_back(fmt::format(
        "dv_oc/dT stands at its limit of {:g} mV/K at A = {}, more than entropy makes: it stands in for something that "
        "the model lacks, and v_oc at temperatures that no log has is not to be believed (--set joint.entropy=off leaves "
        "it out)",
        1e3 * kMostEntropy_V_per_K,
        fmt::join(at, ", ")));
  }

  void NameTemperatureCautions() {
    auto& say = result_.cautions;
    const JointLogs& logs = result_.logs;
    NameLogsWithoutTemperature();
    if (result_.choice.best.structure.temperature) {
      if (logs.start_span_K < kLeastSpan_K && !result_.setup.held) {
        say.push_back(fmt::format(
            "all logs begin within {:.2g} degC of one another: the activation energies rest on how the cell warms "
            "by itself, which goes with the current and with time, as other things do; pulses from a chamber that "
            "is {:g} degC colder or warmer would tell them",
            logs.start_span_K,
            kLeastSpan_K));
      }
      if (result_.heat && !result_.heat->reversible) {
        say.push_back(fmt::format(
            "dv_oc/dT holds more than entropy: measured temperatures are explained to {:.2f} degC "
            "without its heat, and to {:.2f} degC with it; relaxation slower than the rests may look "
            "like it",
            result_.heat->rmse_K,
            result_.heat->rmse_reversible_K));
      }
      NameDoubtfulHeat();
      NameEntropyAtItsLimit();
      const bool predicted = result_.cell.temperature && result_.cell.temperature->heat;
      if (predicted || !TellTemperature(logs_)) return;
      say.push_back(
          fmt::format("no log shows the cell {:g} degC warmer than its start by its own heat: its "
                      "temperature is not predicted, and follows the surroundings",
                      kLeastRise_K));
      return;
    }
    if (std::isnan(logs.coldest_K) || options_.temperature == Presence::kOff) return;
    const double coldest_degC = logs.coldest_K - kZeroCelsius_K;
    const double warmest_degC = logs.warmest_K - kZeroCelsius_K;
    if (warmest_degC - coldest_degC < kLeastSpan_K) {
      say.push_back(fmt::format(
          "activation energies are not identifiable: the logs lie between {:.1f} and {:.1f} degC, "
          "and telling what temperature does takes {:g} degC",
          coldest_degC,
          warmest_degC,
          kLeastSpan_K));
    } else {
      say.push_back(fmt::format(
          "the logs lie between {:.1f} and {:.1f} degC, but parameters that change with "
          "temperature do not predict held-out rows better",
          coldest_degC,
          warmest_degC));
    }
  }

  const Campaign& campaign_;
  const std::vector<LoadedLog>& recorded_;
  const std::vector<LoadedLog>& logs_;  // with the temperatures that are predicted
  const PredictedTemperatures* warm_;   // by an earlier pass; may be none
  StagedOptions staged_options_;
  JointOptions options_;
  const StagedGiven& given_;
  const StageProgress& progress_;
  GivenParameters known_;
  bool diffusion_ = staged_options_.pulses.diffusion;
  bool curve_given_ = false;
  bool starts_alike_ = true;       // all logs, at start_soc of the result
  bool free_alpha_ = false;        // alpha is one of the unknowns
  std::string source_of_start_;    // of the alpha from which that of the cut-off is looked for
  std::vector<double> deepest_C_;  // charge that has left each log at most
  std::string file_of_least_alpha_;
  JointSolution rough_;                            // of the search for alpha
  std::optional<OpenCircuitVoltage> rough_curve_;  // its v_oc(A), by an alpha of
  double rough_alpha_C_ = 0.0;
  JointResult result_;
};

// The structure that was taken, near its rates, in logs that differ in their temperatures.
JointSolution RefitTo(const std::vector<LoadedLog>& logs,
                      const JointResult& taken,
                      GivenParameters known) {
  const JointLogs points = AtTemperaturesOf(logs, taken.logs);
  const JointObservations seen(points, taken.setup);
  known.fixed = taken.fixed;
  const JointFit fit(seen, known);
  const JointSolution& best = taken.choice.best;
  return fit.Approach(fit.Solve(best.structure, best.rates, best.smoothness));
}

}  // namespace

JointResult IdentifyJoint(const Campaign& campaign,
                          const std::vector<LoadedLog>& recorded,
                          const StagedOptions& staged_options,
                          const JointOptions& options,
                          const StagedGiven& given,
                          const StageProgress& progress) {
  const std::optional<SteadyCurrents> steady = TakeOutCurrentNoise(recorded);
  const std::vector<LoadedLog>& logs = steady ? steady->logs : recorded;
  const auto run = [&](const PredictedTemperatures* warm) {
    return JointRun(campaign, logs, staged_options, options, given, progress, warm).Run();
  };
  JointResult taken = run(nullptr);
  // The better the cell, the better the temperature that it predicts.
  constexpr int kMostPasses = 3;
  constexpr double kSettled = 0.95;
  std::optional<PredictedTemperatures> warmth;  // that was taken, or else the first that was not
  std::string said;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    auto warm = PredictTemperatures(taken.cell, logs);
    if (!warm) break;
    JointResult next = run(&*warm);
    const double error_V = ErrorOfRows_V(next);
    const double before_V = ErrorOfRows_V(taken);
    next.wall_s += taken.wall_s;
    if (error_V < before_V) {
      said = warm->Predicted();
      taken = std::move(next);
      warmth = std::move(warm);
    } else {
      taken.wall_s = next.wall_s;
      if (!warmth) {
        said = warm->NotTaken();
        warmth = std::move(warm);
      }
    }
    if (!(error_V < kSettled * before_V)) break;
  }
  if (warmth) {
    taken.cautions.push_back(std::move(said));
    if (warmth->assumed)
      taken.choice.half_as_warm = RefitTo(warmth->HalfAsWarm(), taken, given.parameters);
  }
  if (steady) {
    taken.cautions.push_back(steady->Said());
    taken.counting_C = steady->counting_C;
  }
  return taken;
}

std::optional<OpenCircuitVoltage> LowRateCurve(const StagedResult& staged,
                                               const std::vector<LoadedLog>& logs) {
  const double charge_C = LowRateCharge(staged, logs);
  if (!staged.open_circuit_voltage || !(charge_C > 0.0)) return std::nullopt;
  return Rescaled(staged.cell.open_circuit_voltage, staged.alpha_C, charge_C);
}

}  // namespace lipoid
