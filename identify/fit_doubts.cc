#include "identify/fit_doubts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "identify/fit_quality.h"
#include "identify/joint/held_shape.h"
#include "identify/joint/reference_curve.h"
#include "identify/logs/load_campaign.h"
#include "identify/logs/plausibility.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/fit_record.h"

namespace lipoid {
namespace {

// Stage 3 takes as exact what stands in for a log that is not there.
std::string DoubtAboutStandIns(const StagedResult& staged, const Cell& cell) {
  std::vector<std::string> missing;
  const double above_V = cell.open_circuit_voltage.below().value_V - cell.cutoff_V;
  if (staged.alpha_source == "low-rate-charge" && above_V > kReachedCutoff_V) {
    missing.push_back(fmt::format(
        "alpha, {:.4g} Ah, is the charge of a low-rate log that ends {:.2g} V above the cut-off",
        staged.alpha_C / 3600.0,
        above_V));
  }
  if (staged.from_rests) missing.emplace_back("v_oc(A) is that of rests, without a low-rate log");
  if (staged.fitted_kind == LogKind::kConstantCurrent)
    missing.emplace_back("there were discharges for stage 3, and no pulses");
  if (missing.empty()) return "";
  return fmt::format(
      "{}: beta and the branches may lie far outside their intervals, which do not count that; --method joint fits "
      "all logs together",
      fmt::join(missing, ", and "));
}

// Why the cell is no older or younger state of the reference; "" where it may be. With alpha, beta and
// the resistances bent, a short test fits with the file of quite another cell.
std::string DoubtAboutReference(const HeldShape& held, const Identification& found) {
  const QuantityTrust* alpha = FindQuantity(found.trust, "alpha");
  const bool known = alpha != nullptr && std::isfinite(alpha->standard_error);
  const double least_C = known ? alpha->low : found.cell.alpha_C();
  const double most_C = known ? alpha->high : found.cell.alpha_C();
  const double of_charge = found.cell.alpha_C() / held.cell.alpha_C();
  const double of_resistance = TotalResistance(found.cell, 0.5) / TotalResistance(held.cell, 0.5);
  if (least_C <= kMostCapacityOfNew * held.cell.alpha_C() &&
      most_C >= kLeastCapacityOfNew * held.cell.alpha_C() &&
      of_resistance >= kLeastResistanceOfNew && of_resistance <= kMostResistanceOfNew)
    return "";
  return fmt::format(
      "the cell would have {:.2g} times the charge and {:.2g} times the resistance of the reference {}, and no "
      "cell ages so: is that the file of another cell? Then leave --reference out, or give the right one",
      of_charge,
      of_resistance,
      held.source);
}

// A relaxation, or another current, is what beta and the resistances predict; where no log shows either, they are
// what bends the fit to its own logs.
std::string DoubtAboutOneCurrent(const Identification& found, const Campaign& campaign) {
  if (!found.joint || found.joint->setup.held || found.joint->logs.several_currents) return "";
  if (campaign.Count(LogKind::kPulses) > 0) return "";
  return fmt::format(
      "low rates aside, all loads of these logs are of about {:.3g} A, and none rests after a pulse: no log tests beta and "
      "the resistances, whose intervals take the model as right, and a load of another current is an extrapolation; add "
      "pulses, or a discharge at another current",
      found.joint->logs.load_A);
}

std::string DoubtAboutNominalCharge(const Identification& found, const Campaign& campaign) {
  const std::string& source = found.joint ? found.joint->alpha_source : found.staged->alpha_source;
  if (source != "nominal-capacity" || campaign.cutoff_V) return "";
  return fmt::format(
      "no cut-off voltage is given, and alpha is the nominal capacity of {:.4g} Ah: no log tells whether the cell holds "
      "that; give cutoff_V (--cutoff-V), and a log down to it",
      found.cell.alpha_C() / 3600.0);
}

// What discharges at several currents say by how long they last, and what the slow one counts, is one charge. Where the
// drop over the resistance ends the discharges their times say something else.
std::string DoubtAboutTwoCharges(const Identification& found, const std::vector<LoadedLog>& logs) {
  constexpr double kApart = 0.1;  // six campaigns of real cells have 0.056 at most
  if (!found.joint) return "";
  const StagedResult& staged = found.joint->staged;
  const auto slow = std::find_if(logs.begin(), logs.end(), [](const LoadedLog& log) {
    return log.entry.kind == LogKind::kLowRate;
  });
  if (slow == logs.end() || !(staged.low_rate_charge_C > 0.0) || !staged.discharge_times ||
      staged.alpha_source != "discharge-times" || staged.discharge_times->LeaveTheLaw())
    return "";
  const double full_C = staged.low_rate_charge_C / slow->entry.initial_soc;
  if (std::abs(staged.alpha_C / full_C - 1.0) <= kApart) return "";
  return fmt::format(
      "the times of the discharges say that alpha is {:.4g} Ah, and {} counts {:.4g} Ah: they should be one charge; look "
      "whether one of the current sensors is off, or a log began elsewhere than initial_soc says",
      staged.alpha_C / 3600.0,
      slow->entry.file,
      full_C / 3600.0);
}

// Between any two different values of many rows; 0 where that is below `enough`, or values hardly come again.
double LeastStep(const Column& column, double enough) {
  constexpr std::size_t kFewest = 10;
  std::set<double> values;
  double least = std::numeric_limits<double>::infinity();
  for (const double value : column) {
    const auto [at, fresh] = values.insert(value);
    if (!fresh) continue;
    if (at != values.begin()) least = std::min(least, value - *std::prev(at));
    if (const auto next = std::next(at); next != values.end())
      least = std::min(least, *next - value);
    if (least < enough) return 0.0;
  }
  return values.size() < kFewest || column.size() < 2 * values.size() ? 0.0 : least;
}

// Rounding is no noise: it is the same in every run, and slow where the voltage is. Steps of 10 mV leave the intervals
// right, of 20 mV beta was 5 % off where the interval said 1 %.
std::string DoubtAboutResolution(const std::vector<LoadedLog>& logs) {
  constexpr double kCoarse_V = 0.015;
  double coarsest_V = 0.0;
  std::vector<std::string> files;
  for (const LoadedLog& log : logs) {
    if (!TakesPartInLabFit(log.entry.kind)) continue;
    const double least_V = LeastStep(log.log.record.voltage_V, kCoarse_V);
    if (least_V < kCoarse_V) continue;
    coarsest_V = std::max(coarsest_V, least_V);
    files.push_back(log.entry.file);
  }
  if (files.empty()) return "";
  return fmt::format(
      "the voltage of {} comes in steps of {:.3g} mV: beta and the resistances may be off by more than their intervals "
      "say, which take the rounding for noise",
      fmt::join(files, ", "),
      1e3 * coarsest_V);
}

}  // namespace

std::string DoubtAboutInstants(const Cell& cell, double sampling_s) {
  constexpr double kHalf = 0.5;
  constexpr double kAtOnce = 0.1;  // of what is there after a few rows
  constexpr double kFewRows = 5.0;
  const Cell::Branch* fastest = nullptr;
  for (const Cell::Branch& branch : cell.branches) {
    if (fastest == nullptr || branch.time_constant_s < fastest->time_constant_s) fastest = &branch;
  }
  if (fastest == nullptr || fastest->time_constant_s > kFewRows * sampling_s) return "";
  double at_once_Ohm = cell.series_resistance_Ohm(kHalf);
  if (cell.charge_transfer) at_once_Ohm += cell.charge_transfer->resistance_Ohm(kHalf);
  const double soon_Ohm = at_once_Ohm + fastest->resistance_Ohm(kHalf);
  // More than the slower ones have.
  if (at_once_Ohm > kAtOnce * soon_Ohm || 2.0 * soon_Ohm < TotalResistance(cell, kHalf)) return "";
  return fmt::format(
      "of {:.3g} mOhm at half charge only {:.2g} are there at once, and the others come within {:.2g} s, a few rows of "
      "{:.2g} s: a cell drops at once, so the voltage of these logs is averaged, filtered or late, and resistances within "
      "some rows come out too small; give voltages of single instants",
      1e3 * soon_Ohm,
      1e3 * at_once_Ohm,
      fastest->time_constant_s,
      sampling_s);
}

void DoubtTheFit(Identification& found,
                 const Campaign& campaign,
                 const std::vector<LoadedLog>& logs,
                 const IdentifyOptions& options) {
  if (auto doubt = DoubtAboutCutoff(found.cell.cutoff_V); !doubt.empty())
    found.quality.Doubt(std::move(doubt));
  if (!found.converged) {
    const bool cut_short =
        found.joint && found.joint->choice.best.termination == Termination::kMaxIterations;
    found.quality.Doubt(
        std::string("the search ended before it had converged") +
        (cut_short ? ", at its most iterations (joint.iterations_per_variable)" : ""));
  }
  if (found.staged) {
    if (auto doubt = DoubtAboutOneTemperature(logs); !doubt.empty())
      found.quality.Doubt(std::move(doubt));
    if (auto doubt = DoubtAboutStandIns(*found.staged, found.cell); !doubt.empty())
      found.quality.Doubt(std::move(doubt));
  }
  std::vector<std::string> stuck;
  for (const LoadedLog& log : logs) {
    if (TakesPartInLabFit(log.entry.kind) && !log.log.report.stuck_voltage.empty())
      stuck.push_back(log.entry.file);
  }
  if (!stuck.empty()) {
    found.quality.Doubt(fmt::format("the voltage of {} was not measured throughout, as {}",
                                    fmt::join(stuck, ", "),
                                    stuck.size() == 1 ? "its warning says" : "their warnings say"));
  }
  if (found.joint && !found.joint->alpha_doubt.empty())
    found.quality.Doubt(found.joint->alpha_doubt,
                        found.joint->alpha_not_found ? FitGrade::kPoor : FitGrade::kFair);
  if (!found.flights_alone) {
    for (std::string doubt : {DoubtAboutOneCurrent(found, campaign),
                              DoubtAboutNominalCharge(found, campaign),
                              DoubtAboutTwoCharges(found, logs),
                              DoubtAboutResolution(logs),
                              DoubtAboutInstants(found.cell, found.trust.sampling_s)}) {
      if (!doubt.empty()) found.quality.Doubt(std::move(doubt));
    }
  }
  if (const auto& held = options.given.reference) {
    if (const auto doubt = DoubtAboutFit(held->cell); !doubt.empty())
      found.log_notes.push_back(fmt::format("{}: {}", held->source, doubt));
    if (auto doubt = DoubtAboutReference(*held, found); !doubt.empty())
      found.quality.Doubt(std::move(doubt));
    if (const auto& move = found.joint->held_curve; move && move->doubted())
      found.quality.Doubt(DoubtAboutHeldCurve(held->source, *move));
  }
}

}  // namespace lipoid
