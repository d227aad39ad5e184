#include "identify/export/mission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "identify/logs/csv/text_source.h"
#include "identify/validation.h"
#include "model/battery/arrhenius.h"
#include "model/battery/prediction.h"
#include "model/battery/time_to_cutoff.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/text_cells.h"
#include "model/export/export_error.h"

namespace lipoid {
namespace {

// Where decimals may have commas, semicolons separate.
char SeparatorOf(std::string_view line) {
  return line.find(';') == std::string_view::npos ? ',' : ';';
}

// The fields of the first line that is neither blank nor a comment, in lower case.
std::vector<std::string> HeaderOf(std::string_view text) {
  std::vector<TextCell> cells;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line[0] == '#') continue;
    SplitLine(line, SeparatorOf(line), cells);
    std::vector<std::string> names;
    for (const auto& cell : cells) names.push_back(LowerCase(cell.text));
    return names;
  }
  return {};
}

bool Has(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::size_t FieldOf(const std::vector<std::string>& names, std::string_view name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

bool HasPower(const std::vector<std::string>& names) {
  return Has(names, "time_s") && Has(names, "power_w") && !Has(names, "current_a");
}

// A log, which may have been meant as a power over time under another header.
Log ReadLogOfPower(const std::string& file,
                   const ReadOptions& options,
                   const std::vector<std::string>& names) {
  try {
    return ReadLog(file, options);
  } catch (const LoadError& error) {
    if (std::none_of(names.begin(), names.end(), [](const std::string& name) {
          return name.find("power") != std::string::npos;
        }))
      throw;
    const Diagnostic& first = error.diagnostics().front();
    throw LoadError(
        first.position,
        first.message + "; a power over time has the columns time_s,power_W, in these units");
  }
}

// The rows of time_s,power_W.
PowerProfile ReadPowerRows(const std::string& file, Hold hold) {
  TextSource source(file);
  PowerProfile profile;
  profile.hold = hold;
  std::vector<std::string> names;
  std::vector<TextCell> cells;
  char separator = ',';
  std::size_t line = 0;
  for (std::string_view piece = source.NextPiece(1); !piece.empty();
       piece = source.NextPiece(line + 1)) {
    while (!piece.empty()) {
      const auto end = std::min(piece.find(source.line_end()), piece.size());
      const std::string_view raw = piece.substr(0, end);
      piece.remove_prefix(std::min(end + 1, piece.size()));
      ++line;
      const std::string_view content = Trimmed(raw);
      if (content.empty() || content[0] == '#') continue;
      if (names.empty()) {
        names = HeaderOf(content);
        separator = SeparatorOf(content);
        continue;
      }
      SplitLine(raw, separator, cells);
      const auto number = [&](std::string_view name, std::string_view shown) {
        const std::size_t field = FieldOf(names, name);
        if (field >= cells.size()) {
          throw LoadError(
              {file, line, raw.size() + 1},
              fmt::format("expected a number for {}, found the end of the line", shown));
        }
        double value = 0.0;
        const bool comma =
            separator == ';' && cells[field].text.find(',') != std::string_view::npos;
        if (!ParseNumber(cells[field].text, comma ? ',' : '.', value) || !std::isfinite(value)) {
          throw LoadError(
              {file, line, cells[field].column},
              fmt::format(
                  "expected a number for {}, found '{}'", shown, ForeignText(cells[field].text)));
        }
        return value;
      };
      const double time_s = number("time_s", "time_s");
      if (!profile.time_s.empty() && !(time_s > profile.time_s.back())) {
        throw LoadError(
            {file, line, cells[FieldOf(names, "time_s")].column},
            fmt::format("expected a time after {} s, found {} s", profile.time_s.back(), time_s));
      }
      profile.time_s.push_back(time_s);
      profile.power_W.push_back(number("power_w", "power_W"));
    }
  }
  return profile;
}

// The current of one cell that gives this power at the end of a step; none where that is below the
// cut-off.
std::optional<double> CurrentOfPower(const CellModel<double>& model,
                                     const CellModel<double>::State& before,
                                     const CellModel<double>::Step& step,
                                     bool moves,
                                     double power_W,
                                     double cutoff_V,
                                     double largest_A) {
  if (power_W == 0.0) return 0.0;
  CellModel<double>::State after = before;
  const auto voltage = [&](double current_A) {
    if (!moves) return model.Voltage(before, current_A);
    after = before;
    model.Advance(after, current_A, step);
    return model.Voltage(after, current_A);
  };
  // i v(i) rises from 0 while v is above the cut-off; in charge it rises without end.
  double low = power_W > 0.0 ? 0.0 : -largest_A;
  double high = power_W > 0.0 ? largest_A : 0.0;
  if (power_W > 0.0) {
    // The largest current is where the cut-off is reached: v falls with i.
    if (voltage(high) < cutoff_V) {
      double inside = 0.0;
      if (voltage(inside) < cutoff_V) return std::nullopt;
      double outside = high;
      for (int n = 0; n < 200 && outside - inside > 1e-15 * outside; ++n) {
        const double middle = 0.5 * (inside + outside);
        (voltage(middle) < cutoff_V ? outside : inside) = middle;
      }
      high = inside;
    }
    if (high * voltage(high) < power_W) return std::nullopt;
  } else if (low * voltage(low) > power_W) {
    return std::nullopt;
  }
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (middle * voltage(middle) < power_W ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Removes the steps from the first one below the cut-off on.
void CutAtCutoff(const Cell& cell, ExportMission& mission) {
  // A cell at its cut-off is not yet below it.
  constexpr double kRounding_V = 1e-9;
  const auto prediction = ReferenceOf(cell, mission);
  const double least_V = cell.series * (cell.cutoff_V - kRounding_V);
  const auto& volts = prediction.voltage_V;
  const auto below =
      std::find_if(volts.begin(), volts.end(), [&](double v) { return !(v >= least_V); });
  const auto rows = static_cast<std::size_t>(below - volts.begin());
  mission.time_s.resize(rows);
  mission.current_A.resize(rows);
  if (!mission.temperature_degC.empty()) mission.temperature_degC.resize(rows);
}

// How many steps lead from one row to the next.
double StepsBetween(double begin_s, double end_s) {
  return std::max(1.0, std::round((end_s - begin_s) / kMissionStep_s));
}

// The end of one of these steps; of the last exactly that of the row.
double EndOfStep(double begin_s, double end_s, double step, double steps) {
  return step == steps ? end_s : begin_s + (end_s - begin_s) * step / steps;
}

void RequireLength(const std::vector<double>& time_s, const std::string& file) {
  const double duration_s = time_s.empty() ? 0.0 : time_s.back() - time_s.front();
  double steps = std::min(1.0, static_cast<double>(time_s.size()));
  for (std::size_t k = 1; k < time_s.size(); ++k) steps += StepsBetween(time_s[k - 1], time_s[k]);
  if (steps <= static_cast<double>(kMostSteps) && duration_s <= kLongestMission_s) return;
  throw LoadError(
      {file},
      fmt::format("expected a mission of at most {} steps and {:g} days, since a simulator's steps "
                  "are walked through, found {:g} steps over {:.3g} days; give a part of it",
                  kMostSteps,
                  kLongestMission_s / 86400.0,
                  steps,
                  duration_s / 86400.0));
}

void Append(ExportMission& mission, double duration_s, double current_A) {
  const double begin_s = mission.time_s.back();
  const auto rows = static_cast<int>(std::lround(duration_s / kDefaultRow_s));
  for (int k = 1; k <= rows; ++k) {
    mission.time_s.push_back(begin_s + k * duration_s / rows);
    mission.current_A.push_back(current_A);
  }
}

// Without what lies beyond the cut-off; LoadError where too little is left.
ReadMission AboveCutoff(const Cell& cell,
                        const std::string& file,
                        const std::vector<double>& time_s,
                        ReadMission read) {
  CutAtCutoff(cell, read.mission);
  const auto& steps = read.mission.time_s;
  read.rows_of_file = time_s.size();
  read.rows_beyond_cutoff = static_cast<std::size_t>(std::count_if(
      time_s.begin(), time_s.end(), [&](double t) { return steps.empty() || t > steps.back(); }));
  if (read.rows_beyond_cutoff > 0) {
    read.warnings.push_back(
        fmt::format("the cell reaches its cut-off of {:.4g} V; {} of {} left out",
                    cell.series * cell.cutoff_V,
                    read.rows_beyond_cutoff,
                    Counted(read.rows_of_file, "row")));
  }
  const std::string found = fmt::format(
      "{} of {} rows{}",
      read.rows_of_file - read.rows_beyond_cutoff,
      read.rows_of_file,
      read.rows_beyond_cutoff > 0
          ? "; the current or the power may be too much for this pack (--series, --parallel)"
          : "");
  if (steps.size() < kLeastSteps) {
    throw LoadError(
        {file},
        fmt::format(
            "expected a mission of at least {} rows, or of {:g} s where rows lie farther apart, in "
            "which the cell stays above its cut-off of {:.4g} V, found {:.3g} s in {}",
            kLeastSteps,
            static_cast<double>(kLeastSteps) * kMissionStep_s,
            cell.series * cell.cutoff_V,
            steps.empty() ? 0.0 : steps.back() - steps.front(),
            found));
  }
  const auto& current_A = read.mission.current_A;
  if (std::none_of(current_A.begin() + 1, current_A.end(), [](double i) { return i > 0.0; })) {
    throw LoadError({file},
                    "expected a mission that discharges the cell, found no current above 0" +
                        (read.rows_beyond_cutoff > 0
                             ? fmt::format(" in what stays above its cut-off of {:.4g} V, {}",
                                           cell.series * cell.cutoff_V,
                                           found)
                             : ""));
  }
  return read;
}

double RoundedDown(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return std::floor(value / unit) * unit;
}

}  // namespace

double DefaultCurrent_A(const Cell& cell) {
  // Less at most than what the charge alone allows; the time falls with the current.
  double high_A = 2.0 * cell.parallel * cell.alpha_C() / kDefaultEmpty_s;
  double low_A = 0.0;
  for (int n = 0; n < 60; ++n) {
    const double middle_A = 0.5 * (low_A + high_A);
    const auto lasts_s = TimeToCutoff(cell, middle_A, 1.0, 2.0 * kDefaultEmpty_s);
    (lasts_s && *lasts_s < kDefaultEmpty_s ? high_A : low_A) = middle_A;
  }
  return low_A > 0.0 ? RoundedDown(low_A) : 0.0;
}

ExportMission DefaultMission(const Cell& cell) {
  const double current_A = DefaultCurrent_A(cell);
  Require(current_A > 0.0,
          "a full cell lasts at some current",
          {{"v_oc(1)", cell.open_circuit_voltage(1.0)}, {"cutoff_V", cell.cutoff_V}});
  ExportMission mission;
  mission.time_s = {0.0};
  mission.current_A = {0.0};
  Append(mission, kDefaultRests_s[0], 0.0);
  Append(mission, 0.5 * kDefaultEmpty_s, current_A);
  Append(mission, kDefaultRests_s[1], 0.0);
  Append(mission, 0.5 * kDefaultEmpty_s, 0.5 * current_A);
  Append(mission, kDefaultRests_s[2], 0.0);
  mission.name = fmt::format(
      "default ({:g} s at {:.4g} A and {:g} s at {:.4g} A, rests of {:g}, "
      "{:g} and {:g} s)",
      0.5 * kDefaultEmpty_s,
      current_A,
      0.5 * kDefaultEmpty_s,
      0.5 * current_A,
      kDefaultRests_s[0],
      kDefaultRests_s[1],
      kDefaultRests_s[2]);
  return mission;
}

ExportMission MissionOf(const Record& record, std::string name, double initial_soc) {
  ExportMission mission;
  mission.name = std::move(name);
  mission.initial_soc = initial_soc;
  const bool backward =
      record.hold == Hold::kBackward;  // else what holds until a row belongs to it
  for (std::size_t k = 0; k < record.size(); ++k) {
    const std::size_t before = k > 0 ? k - 1 : k;
    const double current_A = record.current_A[backward ? k : before];
    const double begin_s = record.time_s[before];
    const double steps = StepsBetween(begin_s, record.time_s[k]);
    for (double step = 1.0; step <= steps; step += 1.0) {
      mission.time_s.push_back(EndOfStep(begin_s, record.time_s[k], step, steps));
      mission.current_A.push_back(current_A);
      if (record.temperature_degC.empty()) continue;
      const double begin_degC = record.temperature_degC[before];
      mission.temperature_degC.push_back(begin_degC +
                                         (record.temperature_degC[k] - begin_degC) * step / steps);
    }
  }
  return mission;
}

ExportMission MissionOf(const Cell& cell,
                        const PowerProfile& power,
                        std::string name,
                        double initial_soc) {
  ExportMission mission;
  mission.name = std::move(name);
  mission.initial_soc = initial_soc;
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(initial_soc);
  const double cells = static_cast<double>(cell.series) * cell.parallel;
  // More than any cell gives: it would be empty in a second.
  const double largest_A = cell.alpha_C();
  CellModel<double>::Step step;
  for (std::size_t k = 0; k < power.time_s.size(); ++k) {
    const bool backward = power.hold == Hold::kBackward;
    const double power_W = power.power_W[backward || k == 0 ? k : k - 1] / cells;
    const double begin_s = k > 0 ? power.time_s[k - 1] : power.time_s[k];
    const double steps = StepsBetween(begin_s, power.time_s[k]);
    for (double one = 1.0; one <= steps; one += 1.0) {
      const double time_s = EndOfStep(begin_s, power.time_s[k], one, steps);
      const double dt_s = k > 0 ? time_s - mission.time_s.back() : 0.0;
      model.Prepare(step, dt_s, state);
      const auto current_A =
          CurrentOfPower(model, state, step, k > 0, power_W, cell.cutoff_V, largest_A);
      if (!current_A) return mission;
      if (k > 0) model.Advance(state, *current_A, step);
      mission.time_s.push_back(time_s);
      mission.current_A.push_back(*current_A * cell.parallel);
    }
  }
  return mission;
}

ReadPower ReadPowerFile(const std::string& file, const ReadOptions& options) {
  const std::vector<std::string> names = HeaderOf(TextSource(file).head());
  ReadPower read;
  if (HasPower(names)) {
    read.profile = ReadPowerRows(file, options.hold);
  } else {
    const Log log = ReadLogOfPower(file, options, names);
    read.warnings = log.report.warnings;
    read.profile = {.time_s = log.record.time_s.ToVector(), .power_W = {}, .hold = log.record.hold};
    const auto current_A = log.record.current_A.ToVector();
    const auto voltage_V = log.record.voltage_V.ToVector();
    for (std::size_t k = 0; k < current_A.size(); ++k)
      read.profile.power_W.push_back(current_A[k] * voltage_V[k]);
  }
  RequireLength(read.profile.time_s, file);
  if (read.profile.time_s.size() < 2) {
    throw LoadError({file},
                    fmt::format("expected a power over time of at least 2 rows, found {}",
                                read.profile.time_s.size()));
  }
  return read;
}

ReadMission MissionOfLog(const Cell& cell, const Log& log, const StartRequest& start) {
  const std::string& file = log.record.file;
  const std::vector<double> time_s = log.record.time_s.ToVector();
  RequireLength(time_s, file);
  Surroundings surroundings;
  if (cell.temperature) surroundings.measured_degC = log.record.temperature_degC;
  const double initial_soc = start.Soc(cell, surroundings);
  ReadMission read;
  read.mission = MissionOf(log.record, file, initial_soc);
  if (!cell.temperature) read.mission.temperature_degC.clear();
  if (std::string doubt = DoubtAboutStart(cell, log.record, initial_soc); !doubt.empty())
    read.warnings.push_back(std::move(doubt));
  if (const auto& warmth_degC = read.mission.temperature_degC; !warmth_degC.empty()) {
    const auto [coldest, warmest] = std::minmax_element(warmth_degC.begin(), warmth_degC.end());
    read.warnings.push_back(fmt::format(
        "the cell has the temperature of the log, {:.3g} to {:.3g} degC (the cell file's reference is "
        "{:g} degC): what is fitted and compared is the cell as it is there",
        *coldest,
        *warmest,
        CelsiusOf(cell.temperature->reference_K)));
  }
  return AboveCutoff(cell, file, time_s, std::move(read));
}

ReadMission ReadMissionFile(const Cell& cell,
                            const std::string& file,
                            const ReadOptions& options,
                            const StartRequest& start) {
  const std::vector<std::string> names = HeaderOf(TextSource(file).head());
  if (!HasPower(names)) {
    ReadOptions how = options;
    how.voltage_optional = true;
    const Log log = ReadLogOfPower(file, how, names);
    ReadMission read = MissionOfLog(cell, log, start);
    read.warnings.insert(
        read.warnings.begin(), log.report.warnings.begin(), log.report.warnings.end());
    return read;
  }
  const PowerProfile profile = ReadPowerRows(file, options.hold);
  RequireLength(profile.time_s, file);
  ReadMission read;
  read.mission = MissionOf(cell, profile, file, start.Soc(cell));
  return AboveCutoff(cell, file, profile.time_s, std::move(read));
}

}  // namespace lipoid
