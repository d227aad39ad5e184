#include "identify/logs/load_campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/formats/quantity.h"
#include "identify/logs/gaps.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/read_logs.h"
#include "identify/logs/segments.h"
#include "identify/logs/staircase.h"
#include "identify/logs/thermometer_noise.h"
#include "identify/logs/thinning.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {

namespace {

// Where there is a discharge, some log moves a good part of the nominal capacity, in the cold, at a high rate
// or stopped early, too: a wrong unit makes it a 60th. The pulses of a published test (Samsung INR21700-30T) move
// 0.6 % of the cell's charge: the limit without a discharge is half of that.
constexpr double kLeastBesideDischarge = 0.05;
constexpr double kLeastOfAnyLog = 0.003;

[[noreturn]] void Refuse(const Campaign& campaign,
                         const SourcePosition& position,
                         std::string_view option,
                         std::string_view key,
                         const std::string& message) {
  if (!position.file.empty()) throw LoadError(position, fmt::format("{}: {}", key, message));
  RefuseCampaign(campaign,
                 campaign.file.empty() ? fmt::format("option --{}: {}", option, message)
                                       : fmt::format("{}: {}", key, message));
}

// A capacity in mAh, or times in minutes under a header of seconds, are off by a factor of 60 or
// 1000.
void CheckCapacity(const Campaign& campaign,
                   const std::vector<LoadedLog>& logs,
                   const std::vector<ChargeMoved>& moved) {
  if (!(campaign.capacity_Ah > 0.0)) return;
  double most_Ah = 0.0;
  double least = 0.0;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const LoadedLog& log = logs[k];
    if (log.entry.kind == LogKind::kValidation) continue;
    const bool discharge =
        log.entry.kind == LogKind::kConstantCurrent || log.entry.kind == LogKind::kLowRate;
    most_Ah = std::max(most_Ah, moved[k].range_C() / 3600.0);
    least = std::max(
        least, discharge && log.entry.initial_soc >= 0.9 ? kLeastBesideDischarge : kLeastOfAnyLog);
  }
  if (most_Ah >= least * campaign.capacity_Ah) return;
  Refuse(
      campaign,
      campaign.capacity_position,
      "capacity-Ah",
      "capacity_Ah",
      fmt::format(
          "expected logs that move the charge of a cell of {:.6g} Ah, found {:.3g} Ah at most; is "
          "the capacity in mAh, or are times in minutes or currents in another unit than their "
          "headers say? A discharge that was stopped early is of kind \"validation\"",
          campaign.capacity_Ah,
          most_Ah));
}

// v_oc(A) would have to be followed upwards to it.
void CheckCutoff(const Campaign& campaign, const std::vector<LoadedLog>& logs) {
  if (!campaign.cutoff_V) return;
  double highest_V = 0.0;
  for (const LoadedLog& log : logs) {
    const auto& voltage_V = log.log.record.voltage_V;
    if (!TakesPartInLabFit(log.entry.kind) || voltage_V.empty()) continue;
    // Most logs begin above it, and long ones need not be read again.
    highest_V = std::max(
        highest_V,
        voltage_V.front() > *campaign.cutoff_V ? voltage_V.front() : FindExtent(voltage_V).most);
  }
  if (highest_V == 0.0 || highest_V > *campaign.cutoff_V) return;
  Refuse(
      campaign,
      campaign.cutoff_position,
      "cutoff-V",
      "cutoff_V",
      fmt::format("expected a voltage that a discharge ends at, found {:.4g} V, and no log of this "
                  "cell is above {:.4g} V; the cut-off is that of one cell",
                  *campaign.cutoff_V,
                  highest_V));
}

// No lithium cell takes so much more than its capacity: a sensor turned round does.
void RefuseOverfull(const Campaign& campaign,
                    const CampaignLog& entry,
                    const Record& record,
                    const ChargeMoved& moved) {
  constexpr double kMostBeyondFull = 0.3;  // of the capacity
  if (entry.kind != LogKind::kPulses || !(campaign.capacity_Ah > 0.0)) return;
  const double charged_Ah = -moved.least_C / 3600.0;
  const double beyond = entry.initial_soc + charged_Ah / campaign.capacity_Ah - 1.0;
  if (beyond <= kMostBeyondFull) return;
  if (entry.initial_soc > 1.0 + kMostBeyondFull) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected pulses of a cell that is full at most, found a start at a state of charge "
            "of {:.4g}; say where the log starts (`initial_soc`)",
            entry.initial_soc));
  }
  throw LoadError(
      {record.file},
      fmt::format(
          "expected pulses of a cell that is full at most, found {:.3g} Ah of charging from a "
          "state of charge of {:.4g} of {:.4g} Ah on; turn the current round (`current_sign`), "
          "or say where the log starts (`initial_soc`)",
          charged_Ah,
          entry.initial_soc,
          campaign.capacity_Ah));
}

// Charge leaves a log that is said to be a charge, or enters one that is said to be a discharge: under the
// wrong kind it would be fitted as none, or not at all. Of a log that does both a part is wanted, as is said
// where its rows are taken.
void RefuseOtherWay(const CampaignLog& entry, const Record& record) {
  constexpr double kLeastShare = 0.5;  // of what left on the way, and did not come back
  const bool charge = entry.kind == LogKind::kLowRateCharge;
  if (!charge && entry.kind != LogKind::kLowRate) return;
  const ChargeMoved moved = CountCharge(record);
  const double wrong_C = charge ? moved.charge_C : -moved.charge_C;
  const double farthest_C = charge ? moved.most_C : -moved.least_C;
  const double right_C = charge ? -moved.least_C : moved.most_C;
  if (!(wrong_C > kLeastShare * farthest_C) || right_C > kLeastShare * moved.range_C()) return;
  throw LoadError(
      {record.file},
      fmt::format(
          "expected a slow {0}, as kind \"{1}\" says, found {2:.4g} Ah that flow {3}; a slow "
          "{4} is of kind \"{5}\", and of a {0} turn the current round (`current_sign`)",
          charge ? "charge" : "discharge",
          charge ? "low-rate-charge" : "low-rate",
          wrong_C / 3600.0,
          charge ? "out" : "in",
          charge ? "discharge" : "charge",
          charge ? "low-rate" : "low-rate-charge"));
}

// A cell that rests has the temperature of its surroundings, unless it was just put there; where nobody said
// what that is, no test begins on a hot cell. "" where nothing is odd.
std::string DoubtAboutTemperature(const CampaignLog& entry, const Record& record) {
  constexpr double kMostOff_K = 15.0;
  constexpr double kSame_K = 2.0;
  const auto& temperature_degC = record.temperature_degC;
  if (entry.initial_degC || temperature_degC.empty()) return "";
  const double first_degC = temperature_degC.front();
  const double converted_degC = FindUnit(Quantity::kTemperature, "degF")->ToSi(first_degC);
  if (!entry.ambient_degC) return DoubtAboutHotStart(record);
  if (std::abs(first_degC - *entry.ambient_degC) <= kMostOff_K ||
      std::abs(record.current_A.front()) > RestThreshold(record))
    return "";
  const bool fahrenheit = std::abs(converted_degC - *entry.ambient_degC) <= kSame_K;
  return fmt::format(
      "the cell rests at {:.4g} degC in the first row, and ambient_degC is {:.4g}: {}; where the cell "
      "was warmed or cooled before the test, say initial_degC",
      first_degC,
      *entry.ambient_degC,
      fahrenheit ? InFahrenheit(first_degC) : "look which of the two is right");
}

// A thermometer that wavers, or of whole degrees, moves resistances to and fro by more than the voltage is off, and a
// fit finds terms that follow it, or are deaf to it.
void SmoothTemperature(Log& log) {
  constexpr double kCoarse_K = 0.4;
  Record& record = log.record;
  const auto& shown = record.temperature_degC;
  constexpr double kNoisy_K = 0.02;
  constexpr double kMostNoise_K = 1.0;  // more is of rows that are too far apart to tell
  if (const double noise_K = ThermometerNoise(shown);
      noise_K >= kNoisy_K && noise_K <= kMostNoise_K) {
    record.temperature_degC = WithoutThermometerNoise(record.time_s, shown, noise_K);
    log.report.warnings.push_back(fmt::format(
        "its temperature wavers by {:.2g} degC from row to row, and the course of the rows around each is taken",
        noise_K));
    return;
  }
  const double step_K = StepOf(shown);
  if (!(step_K >= kCoarse_K) || std::isinf(step_K)) return;
  std::size_t kept = 0;  // rows that show what the one before did
  for (std::size_t k = 1; k < shown.size(); ++k) kept += shown[k] == shown[k - 1] ? 1 : 0;
  if (2 * kept < shown.size()) return;
  record.temperature_degC = WithoutSteps(record.time_s, record.temperature_degC);
  log.report.warnings.push_back(fmt::format(
      "its temperature is in steps of {:.2g} degC, and is taken to go straight from one to the next",
      step_K));
}

// A log is taken to begin at its first row, from rest. Of one that begins under load, what flowed before that row
// is not counted, and the drops that it left are not there: beta follows the first rows of a discharge. Where a part
// was cut out of a log at its first loaded row, the row of the rest before it is put back. What is to be said where
// that cannot be; "" where nothing is odd.
std::string BeginAtRest(Log& log) {
  constexpr double kMostLonger = 1.5;    // the interval before the first row over the one after it
  constexpr double kOtherVoltage = 2.0;  // no edge changes a voltage so much: such a row failed
  constexpr double kWorthSaying = 3e-4;  // of the charge of the log
  Record& record = log.record;
  if (record.size() < 2 || log.report.thinned) return "";
  const double first_A = std::as_const(record).current_A[0];
  if (first_A == 0.0) return "";  // most logs, of which nothing more is asked
  const double rest_A = RestThreshold(record);
  if (std::abs(first_A) <= rest_A) return "";
  const auto& time_s = std::as_const(record).time_s;
  const double interval_s = time_s[1] - time_s[0];
  const bool rested = log.before && std::abs(log.before->current_A) <= rest_A;
  const double change = rested ? log.before->voltage_V / std::as_const(record).voltage_V[0] : kNaN;
  if (rested && -log.before->time_s <= kMostLonger * interval_s && change < kOtherVoltage &&
      change > 1.0 / kOtherVoltage) {
    const auto put_before = [](Column& column, double value) {
      if (column.empty()) return;
      std::vector<double> rows{std::isnan(value) ? column.front() : value};
      rows.insert(rows.end(), std::as_const(column).begin(), std::as_const(column).end());
      column = std::move(rows);
    };
    const double before_s = -log.before->time_s;
    for (double& t : record.time_s) t += before_s;
    put_before(record.time_s, 0.0);
    put_before(record.current_A, 0.0);
    put_before(record.voltage_V, log.before->voltage_V);
    put_before(record.temperature_degC, log.before->temperature_degC);
    for (Gap& gap : log.report.gaps) {
      ++gap.row;
      gap.start_s += before_s;
    }
    return "";
  }
  const double share = std::abs(first_A) * interval_s / CountCharge(record).range_C();
  if (!(share > kWorthSaying) || std::isinf(share)) return "";
  return fmt::format(
      "it begins under load ({:.3g} A), and the cell is taken as rested until its first row: one row more under "
      "load is {:.2g} % of its charge{}",
      first_A,
      100.0 * share,
      !log.before ? std::string("; begin it with a row of the rest")
      : rested    ? fmt::format("; the rest before it ends {:.3g} s earlier", -log.before->time_s)
                  : std::string("; the row before it is under load, too"));
}

// A log of the pack becomes one of a cell. `moved` becomes the charge that it moves.
LoadedLog OneOfCell(const Campaign& campaign,
                    const CampaignLog& entry,
                    Log log,
                    ChargeMoved& moved) {
  RefuseWithoutVoltage(log.record);
  RefuseUnknownCharge(log.record, log.report.gaps, campaign.capacity_Ah * campaign.parallel);
  // Nobody said how large the pack of a flight is, but the autopilot.
  const int told = log.report.flight ? log.report.flight->cells : 0;
  const bool pack =
      campaign.series == 1 && told > 1 && CellsInSeries(FindExtent(log.record.voltage_V).most) > 1;
  const int series = pack ? told : campaign.series;
  if (pack) {
    log.report.warnings.push_back(fmt::format(
        "the voltage is divided by the {} cells in series that the autopilot was told; `series` says otherwise",
        told));
  }
  if (entry.kind != LogKind::kFlight) {
    if (auto doubt = BeginAtRest(log); !doubt.empty())
      log.report.warnings.push_back(std::move(doubt));
  }
  DivideByPack(log.record, series, campaign.parallel);
  moved = CheckPlausible(log.record, campaign.capacity_Ah, series, campaign.parallel);
  RefuseOverfull(campaign, entry, log.record, moved);
  RefuseOtherWay(entry, log.record);
  SmoothTemperature(log);
  auto doubt = DoubtAboutTemperature(entry, log.record);
  const bool doubted = !doubt.empty();
  if (doubted) log.report.warnings.push_back(std::move(doubt));
  LoadedLog loaded;
  loaded.entry = entry;
  loaded.log = std::move(log);
  loaded.ambient_doubted = doubted && entry.ambient_degC;
  return loaded;
}

// Under two names; one file may stand under several kinds, and so may one log that is in memory.
bool AreCopies(const LoadedLog& a, const LoadedLog& b) {
  const bool may_be =
      a.entry.path != b.entry.path || (a.entry.path.empty() && a.entry.kind == b.entry.kind);
  return may_be && HoldTheSameRows(a.log.record, b.log.record);
}

}  // namespace

std::vector<LoadedLog> LoadCampaign(const Campaign& campaign) {
  std::vector<LoadedLog> logs(campaign.logs.size());
  std::vector<ChargeMoved> moved(logs.size());
  std::vector<LogToRead> files;
  files.reserve(campaign.logs.size());
  for (const CampaignLog& entry : campaign.logs) files.push_back({entry.path, entry.read});
  const auto problems = ReadLogs(files, [&](std::size_t k, Log log) {
    logs[k] = OneOfCell(campaign, campaign.logs[k], std::move(log), moved[k]);
  });
  // In the order of the campaign, whatever the threads did. A file that stands in several places
  // speaks once; where several are bad, each has one line.
  std::set<std::string> bad;
  std::vector<Diagnostic> first;
  std::vector<Diagnostic> all;
  for (std::size_t k = 0; k < problems.size(); ++k) {
    if (problems[k].empty() || !bad.insert(campaign.logs[k].path).second) continue;
    first.push_back(problems[k].front());
    all.insert(all.end(), problems[k].begin(), problems[k].end());
  }
  if (!bad.empty()) throw LoadError(bad.size() == 1 ? all : first);
  CheckCapacity(campaign, logs, moved);
  CheckCutoff(campaign, logs);
  return logs;
}

std::vector<LoadedLog> TakeLogs(const Campaign& campaign, std::vector<Log> logs) {
  Require(logs.size() == campaign.logs.size(), "one log for each entry of the campaign");
  std::vector<LoadedLog> taken;
  taken.reserve(logs.size());
  std::vector<ChargeMoved> moved(logs.size());
  for (std::size_t k = 0; k < logs.size(); ++k)
    taken.push_back(OneOfCell(campaign, campaign.logs[k], std::move(logs[k]), moved[k]));
  CheckCapacity(campaign, taken, moved);
  CheckCutoff(campaign, taken);
  return taken;
}

bool AllStartFull(const std::vector<LoadedLog>& logs) {
  return std::all_of(
      logs.begin(), logs.end(), [](const LoadedLog& log) { return log.entry.initial_soc == 1.0; });
}

std::optional<double> CommonStart(const std::vector<LoadedLog>& logs) {
  std::optional<double> start;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kValidation) continue;
    if (start && *start != log.entry.initial_soc) return std::nullopt;
    start = log.entry.initial_soc;
  }
  return start;
}

double StartTemperature(const LoadedLog& log) {
  const auto& measured = log.log.record.temperature_degC;
  if (!measured.empty()) return measured.front();
  return log.entry.initial_degC ? *log.entry.initial_degC : log.entry.ambient_degC.value_or(kNaN);
}

std::optional<double> LoadedTemperature_degC(const std::vector<LoadedLog>& logs) {
  const auto pulses = [](const LoadedLog& log) { return log.entry.kind == LogKind::kPulses; };
  const bool any_pulses = std::any_of(logs.begin(), logs.end(), pulses);
  double charge_C = 0.0;
  double sum = 0.0;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kValidation || (any_pulses && !pulses(log))) continue;
    const Record& record = log.log.record;
    if (record.temperature_degC.empty() && !log.entry.ambient_degC) return std::nullopt;
    for (std::size_t k = 1; k < record.size(); ++k) {
      const double moved_C = std::abs(0.5 * (record.current_A[k - 1] + record.current_A[k]) *
                                      (record.time_s[k] - record.time_s[k - 1]));
      const double at_degC =
          record.temperature_degC.empty() ? *log.entry.ambient_degC : record.temperature_degC[k];
      charge_C += moved_C;
      sum += moved_C * at_degC;
    }
  }
  const double mean_degC = std::round(10.0 * sum / charge_C) / 10.0;  // no thermometer knows more
  return std::isnan(mean_degC) ? std::nullopt : std::optional(mean_degC);
}

std::string DoubtAboutOneTemperature(const std::vector<LoadedLog>& logs) {
  double coldest_degC = kInfinity;
  double warmest_degC = -kInfinity;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kValidation) continue;
    const double start_degC = StartTemperature(log);
    coldest_degC = std::fmin(coldest_degC, start_degC);
    warmest_degC = std::fmax(warmest_degC, start_degC);
  }
  if (!(warmest_degC - coldest_degC > kLeastSpan_K)) return "";
  return fmt::format(
      "the logs begin between {:.3g} and {:.3g} degC, and the staged method makes of them one cell that knows no "
      "temperature: fit the logs of one temperature, or all by identify --method joint",
      coldest_degC,
      warmest_degC);
}

std::vector<std::string> NotesOnLogs(const std::vector<LoadedLog>& logs) {
  std::vector<std::string> notes;
  const auto add = [&](std::string note) {  // a file may stand in several places
    if (std::find(notes.begin(), notes.end(), note) == notes.end())
      notes.push_back(std::move(note));
  };
  std::map<std::pair<std::string, std::string>, const LoadedLog*> first;  // by format and column
  for (const LoadedLog& loaded : logs) {
    const LogReport& report = loaded.log.report;
    for (const std::string& warning : report.warnings)
      add(fmt::format("{}: {}", loaded.entry.file, warning));
    if (report.thinned)
      add(fmt::format("{}: {}", loaded.entry.file, ThinningText(*report.thinned)));
    if (report.current_sign_is_of_others)
      add(fmt::format("{}: {}", loaded.entry.file, report.current_sign_reason));
    if (report.current_sign == "unsigned") continue;
    const auto [found, is_new] = first.insert({{report.format, report.current_column}, &loaded});
    const LogReport& other = found->second->log.report;
    if (is_new || other.current_sign == report.current_sign) continue;
    add(
        fmt::format("{} is {} and {} is {}, although both have one format: look whether one is "
                    "turned, and say `current_sign` of that one",
                    found->second->entry.file,
                    other.current_sign,
                    loaded.entry.file,
                    report.current_sign));
  }
  const auto held_out = [](const LoadedLog& log) { return log.entry.kind == LogKind::kValidation; };
  for (auto log = logs.begin(); log != logs.end(); ++log) {
    const auto same = std::find_if(
        logs.begin(), log, [&](const LoadedLog& other) { return AreCopies(other, *log); });
    if (same == log) continue;
    add(fmt::format(
        "{} holds the same rows as {}, {}: leave one of the two out, or look whether one "
        "was copied by mistake",
        log->entry.file,
        same->entry.file,
        held_out(*same) == held_out(*log) ? "which therefore count twice"
                                          : "and so does not test the fit, which has seen them"));
  }
  return notes;
}

}  // namespace lipoid
