#include "identify/identification.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/constant_current_validation.h"
#include "identify/exchanged_temperatures.h"
#include "identify/fit_doubts.h"
#include "identify/health/flights_report.h"
#include "identify/health/health_report.h"
#include "identify/joint/held_shape.h"
#include "identify/joint/joint_drawn.h"
#include "identify/joint/joint_profile.h"
#include "identify/joint/joint_report.h"
#include "identify/joint/joint_request.h"
#include "identify/joint/joint_trust.h"
#include "identify/logs/columns.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/unlike_discharges.h"
#include "identify/stages/staged_profile.h"
#include "identify/stages/staged_report.h"
#include "identify/still_temperature.h"
#include "identify/trust/cell_uncertainty.h"
#include "identify/trust/trust_report.h"
#include "identify/validation.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/fit_record.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

void AddUncertainty(Identification& found, bool soc_follows_alpha) {
  CellUncertainty uncertainty = UncertaintyOf(found.trust, found.cell, soc_follows_alpha);
  found.cell.uncertainty = std::move(uncertainty.found);
  found.not_drawn = std::move(uncertainty.unknown);
}

// By held-out rows of the logs that a solution was fitted to, with what was given held.
ExpectedError ExpectErrorOf(const JointLogs& logs,
                            const JointSetup& setup,
                            const GivenParameters& given,
                            const JointSolution& solution,
                            const TrustReport& trust) {
  const JointObservations seen(logs, setup);
  return ExpectError(JointFit(seen, given), logs, solution, trust);
}

Identification IdentifyByStages(const Campaign& campaign,
                                const std::vector<LoadedLog>& logs,
                                const IdentifyOptions& options,
                                const StageProgress& progress) {
  Identification found;
  found.staged = IdentifyStaged(campaign, logs, options.staged, options.given, progress);
  found.cell = found.staged->cell;
  found.converged = found.staged->converged;
  found.trust = found.staged->trust;
  {
    const JointSetup setup{.alpha_C = found.staged->alpha_C,
                           .diffusion = options.staged.pulses.diffusion,
                           .terms = options.staged.pulses.terms,
                           .tail = options.staged.pulses.tail,
                           .open_circuit_voltage = found.cell.open_circuit_voltage};
    const JointLogs points = MakeJointLogs(logs,
                                           setup.alpha_C,
                                           setup.open_circuit_voltage,
                                           {.charge_uncertainty = 0.0},
                                           found.staged->fitted_kind);
    JointSolution solution = found.staged->pulses.solution;
    solution.x *= points.typical_A;
    found.expected_error =
        ExpectErrorOf(points, setup, options.given.parameters, solution, found.trust);
  }
  const bool curve_found = found.staged->open_circuit_voltage || found.staged->from_rests;
  AddUncertainty(found, curve_found && AllStartFull(logs));
  if (options.profiled.empty()) return found;
  if (progress) progress("profiles", 0.97);
  const PulseTask task = PreparePulses(campaign, logs, options.staged, options.given);
  found.profiles = ProfileStaged(options.profiled,
                                 task.sweep,
                                 task.data,
                                 found.staged->pulses,
                                 found.trust,
                                 options.staged.pulses,
                                 options.staged.solver,
                                 options.given.parameters);
  return found;
}

Identification IdentifyAllAtOnce(const Campaign& campaign,
                                 const std::vector<LoadedLog>& logs,
                                 const IdentifyOptions& options,
                                 const StageProgress& progress) {
  Identification found;
  found.joint =
      IdentifyJoint(campaign, logs, options.staged, options.joint, options.given, progress);
  found.cell = found.joint->cell;
  found.converged = found.joint->converged;
  found.trust = AssessJoint(*found.joint);
  found.expected_error = ExpectErrorOf(found.joint->logs,
                                       found.joint->setup,
                                       options.given.parameters,
                                       found.joint->choice.best,
                                       found.trust);
  AddUncertainty(found, SocFollowsAlpha(*found.joint));
  if (const auto& heat = found.joint->heat; heat && found.cell.uncertainty) {
    AddPair(*found.cell.uncertainty,
            "C_th",
            "R_th",
            std::pow(heat->heat_capacity_standard_error_J_per_K, 2),
            std::pow(heat->thermal_resistance_standard_error_K_per_W, 2),
            heat->covariance_s);
  }
  if (options.profiled.empty()) return found;
  if (progress) progress("profiles", 0.97);
  found.profiles =
      ProfileJoint(options.profiled, *found.joint, found.trust, options.given.parameters.bounds);
  return found;
}

Identification IdentifyByFlights(const Campaign& campaign,
                                 const std::vector<LoadedLog>& logs,
                                 const IdentifyOptions& options) {
  if (!options.profiled.empty())
    throw OptionError("--profile needs lab logs: flights alone have no profiles");
  Identification found;
  found.flights_alone = IdentifyFlightsAlone(campaign, logs);
  const FlightsAlone& flights = *found.flights_alone;
  found.cell = flights.cell;
  found.converged = flights.converged;
  found.trust = flights.trust;
  AddUncertainty(found, false);
  return found;
}

// Flights beside lab logs, against the cell that those gave.
void AssessFlights(Identification& found, const std::vector<LoadedLog>& logs) {
  std::vector<Log> flights;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kFlight) continue;
    flights.push_back(log.log);
    flights.back().record.file = log.entry.file;
    flights.back().report.flight.reset();  // of the pack; the record is of one cell
  }
  if (!flights.empty())
    found.health = AssessHealth(found.cell, std::move(flights), HealthOptions());
}

double MeanError(const std::vector<LogErrors>& logs) {
  double sum = 0.0;
  for (const LogErrors& log : logs) sum += log.all.mean_error_percent;
  return sum / static_cast<double>(logs.size());
}

// Why a flight is of another cell than the lab logs, by its health against theirs; "" where it is not. The
// capacity is held in the common fit, which a pack of another size would bend.
std::string OfAnotherCell(const FlightHealth& flight) {
  constexpr double kMost = 4.0 / 3.0;  // a third more or less
  if (!flight.doubted_because.empty())
    return "against the cell of the lab logs it makes no sense, as its health says; it is of another cell, or "
           "--series and --parallel are wrong";
  const double reach = Reach95(kFlightFreedom) * flight.log_capacity_deviation;
  if (std::abs(flight.log_capacity) - reach <= std::log(kMost)) return "";
  return fmt::format(
      "it fits a pack of {:.2g} times the capacity of the cell of the lab logs; it is of another cell, or "
      "--series and --parallel are wrong",
      std::exp(flight.log_capacity));
}

// The cell becomes that of the lab logs and the flights together, and with it all that is said of it.
void TakeFlights(Identification& found, const std::vector<LoadedLog>& logs) {
  std::vector<LoadedLog> of_the_cell = logs;
  std::vector<Diagnostic> of_others;
  for (const FlightHealth& flight : found.health->flights) {
    const std::string why = OfAnotherCell(flight);
    if (why.empty()) continue;
    of_others.push_back({{flight.file}, why});
    std::erase_if(of_the_cell, [&](const LoadedLog& log) {
      return log.entry.kind == LogKind::kFlight && log.entry.file == flight.file;
    });
  }
  found.flights_with_lab = FitFlightsWithLab(found.cell, of_the_cell);
  FlightsWithLab& flights = *found.flights_with_lab;
  if (!of_others.empty() && flights.flights.empty()) {
    flights.not_taken_because =
        fmt::format("{}: {}", of_others.front().position.file, of_others.front().message);
  }
  flights.refused.insert(flights.refused.end(), of_others.begin(), of_others.end());
  const auto errors_of = [&](const Cell& of, bool validation) {
    Cell one = of.AsOne();
    const std::vector<LogKind> kinds =
        validation ? std::vector{LogKind::kValidation} : found.fitted_kinds();
    std::vector<LogErrors> errors;
    for (const LoadedLog& log : logs) {
      if (std::find(kinds.begin(), kinds.end(), log.entry.kind) != kinds.end())
        errors.push_back(Validate(one, log));
    }
    return errors;
  };
  flights.lab_mean_error_percent = MeanError(errors_of(found.cell, false));
  if (!flights.taken) return;
  auto fitted = errors_of(flights.cell, false);
  flights.lab_mean_error_with_flights_percent = MeanError(fitted);
  MoveTrust(found.cell, flights, found.trust);
  found.cell = flights.cell;
  if (found.joint) {
    found.joint->cell = flights.cell;
    found.joint->fitted = std::move(fitted);
    found.joint->validation = errors_of(flights.cell, true);
    found.joint->constant_current = ValidateConstantCurrents(flights.cell, logs);
  } else {
    found.staged->cell = flights.cell;
    found.staged->trust = found.trust;
    found.staged->validation = errors_of(flights.cell, true);
    found.staged->constant_current = ValidateConstantCurrents(flights.cell, logs);
  }
}

FitQuality QualityOf(const Identification& found,
                     const Campaign& campaign,
                     const std::vector<LoadedLog>& logs) {
  if (found.flights_alone) {
    std::vector<LogErrors> fitted;
    for (const auto& flight : found.flights_alone->flights) {
      fitted.push_back(flight.errors);
      fitted.back().edges.clear();  // voltage and current of an autopilot are not of one moment
    }
    const double moved_C = (1.0 - found.flights_alone->lowest_soc) * found.cell.alpha_C();
    FitQuality quality =
        JudgeFit(found.cell, fitted, {}, moved_C, campaign.capacity_Ah, AlphaOf::kElsewhere);
    for (const std::string& doubt : found.flights_alone->doubts) quality.Doubt(doubt);
    return quality;
  }
  double moved_C = 0.0;
  for (const LoadedLog& log : logs) {
    const Record& record = log.log.record;
    const double started_C = (1.0 - log.entry.initial_soc) * found.cell.alpha_C();
    moved_C = std::max(moved_C, started_C + CountCharge(record).most_C);
  }
  if (found.joint) {
    return JudgeFit(found.cell,
                    found.joint->fitted,
                    found.joint->constant_current,
                    moved_C,
                    campaign.capacity_Ah);
  }
  return JudgeFit(found.cell,
                  {LogErrors{"", found.staged->pulses.errors, {}, 0}},
                  found.staged->constant_current,
                  moved_C,
                  campaign.capacity_Ah);
}

// The first line is of the logs that were fitted. Where others are described far worse it says too much.
// Discharges from elsewhere than full are not compared.
std::vector<FullDischarge> FullDischarges(const Identification& found,
                                          const std::vector<LoadedLog>& logs) {
  std::vector<FullDischarge> full;
  if (found.flights_alone) return full;
  const auto& times = found.joint ? found.joint->constant_current : found.staged->constant_current;
  for (const ConstantCurrentErrors& time : times) {
    const auto log = std::find_if(logs.begin(), logs.end(), [&](const LoadedLog& one) {
      return one.entry.file == time.voltage.file;
    });
    if (log == logs.end() || log->entry.initial_soc != 1.0) continue;
    full.push_back({.file = time.voltage.file,
                    .current_A = time.current_A,
                    .charge_C = time.current_A * time.measured_s,
                    .start_degC = StartTemperature(*log)});
  }
  for (const LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kLowRate || log.entry.initial_soc != 1.0) continue;
    const auto slow = WholeDischarge(log.log.record);
    if (!slow || slow->end_voltage_V > found.cell.cutoff_V + CutoffTolerance(*slow)) continue;
    full.push_back({.file = log.entry.file,
                    .current_A = slow->current_A,
                    .charge_C = slow->charge_C,
                    .start_degC = StartTemperature(log)});
  }
  return full;
}

void NoteOnOtherLogs(Identification& found) {
  constexpr double kFarWorse = 5.0;
  constexpr double kWorthSaying_percent = 2.0;
  if (found.flights_alone) return;
  const double own_percent = found.mean_error_percent();
  const double other_percent =
      MeanError(found.joint ? found.joint->validation : found.staged->validation);
  if (other_percent > std::max(kFarWorse * own_percent, kWorthSaying_percent)) {
    found.log_notes.push_back(fmt::format(
        "the validation logs are predicted to {:.2g} %, {:.2g} times worse than the logs of "
        "the fit: are they of this cell, in this state, from the start that is given?",
        other_percent,
        other_percent / own_percent));
  }
}

void NoteOnToldTemperatures(Identification& found, const std::vector<LoadedLog>& logs) {
  constexpr double kSame_K = 2.0;
  if (found.cell.temperature) return;
  std::vector<std::string> files;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kValidation) continue;
    const auto told_degC = log.entry.initial_degC ? log.entry.initial_degC : log.entry.ambient_degC;
    const auto found_degC = found.cell.reference_degC;
    if (told_degC && !(found_degC && std::abs(*told_degC - *found_degC) <= kSame_K))
      files.push_back(log.entry.file);
  }
  if (files.empty()) return;
  found.log_notes.push_back(
      fmt::format("{}: ambient_degC and initial_degC say nothing of a validation log here, for the "
                  "cell that was found knows no temperature and predicts the same at any",
                  fmt::join(files, ", ")));
}

}  // namespace

std::string Identification::Verdict() const {
  if (flights_alone) return fmt::format("{} ({})", quality.Sentence(), flights_alone->Averaged());
  const std::string part = fitted_part();
  return part.empty() ? quality.Sentence() : fmt::format("{} ({} alone)", quality.Sentence(), part);
}

std::string Identification::fitted_part() const {
  if (!staged) return "";
  return staged->fitted_kind == LogKind::kPulses ? "pulses" : "discharges";
}

std::vector<LogKind> Identification::fitted_kinds() const {
  if (flights_alone) return {LogKind::kFlight};
  if (staged) return {staged->fitted_kind};
  return {LogKind::kConstantCurrent, LogKind::kLowRate, LogKind::kLowRateCharge, LogKind::kPulses};
}

double Identification::mean_error_percent() const {
  if (staged) return staged->pulses.errors.mean_error_percent;
  if (joint) return MeanError(joint->fitted);
  double sum = 0.0;
  for (const auto& flight : flights_alone->flights) sum += flight.errors.all.mean_error_percent;
  return sum / static_cast<double>(flights_alone->flights.size());
}

Json StagedOptionsToJson(const StagedOptions& options, const StagedGiven& given) {
  Json json = {{"discharge_times", OptionsToJson<Json>(options.discharge_times)},
               {"open_circuit_voltage", OptionsToJson<Json>(options.open_circuit_voltage)},
               {"pulses", OptionsToJson<Json>(options.pulses)}};
  Json known = Json::object();
  if (given.alpha_C) known["alpha_C"] = *given.alpha_C;
  if (given.open_circuit_voltage) {
    known["open_circuit_voltage"] = given.open_circuit_voltage_source;
  }
  if (given.reference) known["reference"] = given.reference->source;
  if (!given.parameters.fixed.empty()) known["fix"] = given.parameters.fixed;
  if (!given.parameters.start.empty()) known["start"] = given.parameters.start;
  if (!given.parameters.bounds.empty()) known["bounds"] = given.parameters.bounds;
  json["given"] = std::move(known);
  return json;
}

Json IdentifyOptionsToJson(const IdentifyOptions& options) {
  Json json = {{"method", options_internal::ToText(options.method)}};
  json.update(StagedOptionsToJson(options.staged, options.given));
  json["solver"] = OptionsToJson<Json>(options.staged.solver);
  if (options.method == IdentifyMethod::kJoint) json["joint"] = OptionsToJson<Json>(options.joint);
  if (!options.profiled.empty()) json["profile"] = options.profiled;
  return json;
}

Json CampaignToJson(const Campaign& campaign, const std::vector<LoadedLog>& logs) {
  Json rows = Json::array();
  for (const LoadedLog& log : logs) {
    const Record& record = log.log.record;
    const double duration_s =
        record.size() == 0 ? 0.0 : record.time_s.back() - record.time_s.front();
    rows.push_back({{"file", log.entry.file},
                    {"kind", options_internal::ToText(log.entry.kind)},
                    {"rows", record.size()},
                    {"duration_s", duration_s},
                    {"initial_soc", log.entry.initial_soc},
                    {"warnings", log.log.report.warnings}});
  }
  return {{"file", campaign.file},
          {"name", campaign.name},
          {"capacity_Ah", campaign.capacity_Ah > 0.0 ? Json(campaign.capacity_Ah) : Json(nullptr)},
          {"cutoff_V", campaign.cutoff_V ? Json(*campaign.cutoff_V) : Json(nullptr)},
          {"series", campaign.series},
          {"parallel", campaign.parallel},
          {"logs", std::move(rows)}};
}

void AddRunRecord(Identification& found,
                  const IdentifyOptions& options,
                  Json report,
                  RunRecord run) {
  run.options = IdentifyOptionsToJson(options);
  run.metrics = std::move(report);
  Json made = run.ToJson();
  made["converged"] = found.converged;
  found.cell.run = std::make_shared<const Json>(std::move(made));
}

void CheckIdentifyOptions(const IdentifyOptions& options) {
  if (options.method == IdentifyMethod::kJoint) {
    const bool diffusion = options.staged.pulses.diffusion;
    CheckJointRequest(options.given, options.joint, diffusion);
    CheckJointProfile(options.profiled, options.given, options.joint, diffusion);
    if (options.given.reference && options.given.open_circuit_voltage) {
      throw OptionError(
          "--reference and --open-circuit-voltage: v_oc(A) is that of the reference; leave one out");
    }
  } else {
    if (options.given.reference)
      throw OptionError("--reference needs --method joint: the staged method holds no shapes");
    const PulseFitOptions& pulses = options.staged.pulses;
    CheckGiven(options.given.parameters, FitParameterNames(pulses.diffusion, pulses.branches));
    CheckStagedProfile(options.profiled, options.staged.pulses, options.given.parameters);
  }
}

Identification Identify(const Campaign& campaign,
                        const std::vector<LoadedLog>& logs,
                        const IdentifyOptions& options,
                        const StageProgress& progress) {
  CheckIdentifyOptions(options);
  const auto by_method = [&](const Campaign& of, const std::vector<LoadedLog>& from) {
    return options.method == IdentifyMethod::kJoint ? IdentifyAllAtOnce(of, from, options, progress)
                                                    : IdentifyByStages(of, from, options, progress);
  };
  Identification found;
  if (campaign.OnlyFlights()) {
    found = IdentifyByFlights(campaign, logs, options);
  } else if (campaign.Count(LogKind::kFlight) == 0) {
    found = by_method(campaign, logs);
  } else {
    Campaign of_lab = campaign;
    std::erase_if(of_lab.logs, [](const auto& log) { return log.kind == LogKind::kFlight; });
    std::vector<LoadedLog> lab = logs;
    std::erase_if(lab, [](const auto& log) { return log.entry.kind == LogKind::kFlight; });
    found = by_method(of_lab, lab);
    AssessFlights(found, logs);
    TakeFlights(found, logs);
  }
  found.log_notes = NotesOnLogs(logs);
  const auto of_low_rate = found.joint ? LowRateCurve(found.joint->staged, logs) : std::nullopt;
  Cell one = found.cell.AsOne();
  if (of_low_rate) one.open_circuit_voltage = *of_low_rate;
  for (const LoadedLog& log : logs) {
    if (found.staged && log.entry.kind == LogKind::kLowRateCharge)
      found.log_notes.push_back(fmt::format(
          "{}: the staged method does not use a slow charge; --method joint does", log.entry.file));
  }
  std::vector<StartDoubt> starts;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kFlight) continue;  // starts anywhere
    auto doubt = DoubtOfStart(
        one, log.log.record, log.entry.initial_soc, SurroundingsOf(log.log.record, log.entry));
    if (!doubt) continue;
    doubt->file = log.entry.file;
    // It may be the start of another log that is wrong, by which v_oc(A) was bent.
    const auto equal = std::find_if(logs.begin(), logs.end(), [&](const LoadedLog& other) {
      constexpr double kSame_V = 0.01;
      constexpr double kOther = 0.03;
      const std::optional<double> rest_V = RestBeforeLoad(other.log.record);
      return other.entry.kind != LogKind::kFlight && rest_V &&
             std::abs(*rest_V - doubt->rest_V) <= kSame_V &&
             std::abs(other.entry.initial_soc - doubt->given) > kOther;
    });
    if (equal != logs.end()) {
      doubt->equal_file = equal->entry.file;
      doubt->equal_given = equal->entry.initial_soc;
    }
    starts.push_back(std::move(*doubt));
  }
  // Where a logger reads the current a row late, what seems at rest is under load.
  if (!starts.empty() && std::any_of(logs.begin(), logs.end(), [](const LoadedLog& log) {
        return ReadsCurrentLate(log.log.record);
      }))
    starts.clear();
  if (auto doubts = DoubtsAboutStarts(
          std::move(starts), "one wrong start bends v_oc(A) for all, so mend the first one first");
      !doubts.empty())
    found.log_notes.push_back(std::move(doubts));
  found.quality = QualityOf(found, campaign, logs);
  DoubtTheFit(found, campaign, logs, options);
  NoteOnOtherLogs(found);
  NoteOnToldTemperatures(found, logs);
  if (auto doubt = DoubtAboutStillTemperatures(found.cell, logs); !doubt.empty())
    found.log_notes.push_back(std::move(doubt));
  if (found.joint) {
    if (auto doubt = DoubtAboutExchangedTemperatures(found.joint->fitted, logs); !doubt.empty())
      found.log_notes.push_back(std::move(doubt));
  }
  if (auto doubt = DoubtAboutDischarges(FullDischarges(found, logs)); !doubt.empty())
    found.log_notes.push_back(std::move(doubt));
  return found;
}

Json IdentificationToJson(const Identification& found) {
  Json json = found.flights_alone ? FlightsAloneToJson(*found.flights_alone)
              : found.joint       ? JointToJson(*found.joint, found.trust)
                                  : StagedToJson(*found.staged);
  if (found.flights_with_lab)
    json["flights_with_lab"] = FlightsWithLabToJson(*found.flights_with_lab);
  if (found.health) json["health"] = HealthToJson(*found.health);
  json["verdict"] = FitQualityToJson(found.quality);
  json["fit"] = FitToJson(found.quality);
  json["not_drawn"] = found.not_drawn;
  json["expected_error_percent"] = NumberOrNull(found.expected_error.percent);
  json["expected_error_interval_95"] = {NumberOrNull(found.expected_error.low_percent),
                                        NumberOrNull(found.expected_error.high_percent)};
  json["resistance"] = PulseResistancesToJson(found.trust);
  if (found.joint) json["edges"] = EdgesToJson(found.quality.edges);
  if (!found.profiles.empty()) json["profiles"] = ProfilesToJson(found.profiles);
  if (!found.log_notes.empty()) json["log_notes"] = found.log_notes;
  return json;
}

}  // namespace lipoid
