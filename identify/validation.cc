#include "identify/validation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/logs/plausibility.h"
#include "identify/logs/segments.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/prediction.h"
#include "model/battery/rest_voltage.h"
#include "model/core/counted.h"
#include "model/core/special_values.h"

namespace lipoid {

Surroundings SurroundingsOf(const Record& record, const CampaignLog& entry) {
  return {.measured_degC = record.temperature_degC,
          .ambient_degC = entry.ambient_degC,
          .initial_degC = entry.initial_degC};
}

void Validation::Add(const Record& rows, const Surroundings& surroundings) {
  constexpr double kLowSoc = 0.1;
  warms_ = cell_.temperature && cell_.temperature->heat && surroundings.measured_degC.empty() &&
           !rows.temperature_degC.empty();
  const auto compare = [&](std::size_t k, const PredictedRow& row) {
    all_.Add(rows.voltage_V[k], row.voltage_V);
    edges_.Add(rows.time_s[k], rows.current_A[k], rows.voltage_V[k], row.voltage_V, row.soc);
    if (row.soc > kLowSoc) above_.Add(rows.voltage_V[k], row.voltage_V);
    if (!cell_.open_circuit_voltage.InRange(row.soc)) ++outside_;
    if (!warms_) return;
    const double predicted_degC = row.stepper.state().temperature_K - kZeroCelsius_K;
    squares_K2_ += std::pow(predicted_degC - rows.temperature_degC[k], 2);
  };
  predictor_.Rows(rows.time_s, rows.current_A, surroundings, compare);
  rows_ += rows.size();
}

LogErrors Validation::Result() const {
  LogErrors errors{{}, all_.Result(), above_.Result(), outside_};
  errors.edges = edges_.edges();
  if (warms_) errors.temperature_rmse_K = std::sqrt(squares_K2_ / static_cast<double>(rows_));
  return errors;
}

LogErrors Validate(const Cell& cell,
                   const Record& record,
                   double initial_soc,
                   const Surroundings& surroundings) {
  Validation validation(cell, record.hold, initial_soc);
  validation.Add(record, surroundings);
  LogErrors errors = validation.Result();
  errors.file = record.file;
  return errors;
}

LogErrors Validate(const Cell& cell, const LoadedLog& log) {
  const Cell one = cell.AsOne();
  LogErrors errors = Validate(
      one, log.log.record, log.entry.initial_soc, SurroundingsOf(log.log.record, log.entry));
  errors.file = log.entry.file;
  return errors;
}

namespace {

std::string Sentence(const StartDoubt& doubt) {
  if (!doubt.equal_file.empty()) {
    return fmt::format(
        "rests at {:.4g} V before its first load, as {} does, and the one starts at a state of charge of {:g} and the "
        "other at {:g}: one of the two initial_soc is wrong",
        doubt.rest_V,
        doubt.equal_file,
        doubt.given,
        doubt.equal_given);
  }
  if (doubt.soc > 1.0) {
    return fmt::format(
        "rests at {:.4g} V before its first load, and v_oc(A) of a full cell is {:.4g} V: look whether the log that "
        "v_oc comes from started full, or say its initial_soc",
        doubt.rest_V,
        doubt.full_V);
  }
  return fmt::format(
      "rests at {:.4g} V before its first load, where v_oc(A) has a state of charge of {:g}, not "
      "{:g}; if it had rested long enough, say initial_soc {:g}",
      doubt.rest_V,
      doubt.soc,
      doubt.given,
      doubt.soc);
}

}  // namespace

std::optional<double> RestBeforeLoad(const Record& record) {
  if (record.size() < 2 || record.voltage_V.empty()) return std::nullopt;
  const double rest_A = RestThreshold(record);
  std::size_t rows = 0;
  while (rows < record.size() && std::abs(record.current_A[rows]) <= rest_A) ++rows;
  if (rows == 0 || rows == record.size()) return std::nullopt;
  return record.voltage_V[rows - 1];
}

std::optional<StartDoubt> DoubtOfStart(const Cell& one,
                                       const Record& record,
                                       double initial_soc,
                                       const Surroundings& surroundings) {
  constexpr double kSoc = 0.03;
  constexpr double kVoltage_V = 0.02;
  const std::optional<double> rest = RestBeforeLoad(record);
  if (!rest) return std::nullopt;
  const double rest_V = *rest;
  const double full_V = VoltageAtRest(one, 1.0, surroundings);
  // Cells that are charged alike rest within some hundredths of a volt of one another.
  constexpr double kBeyondFull_V = 0.04;
  if (initial_soc == 1.0 && rest_V > full_V + kBeyondFull_V)
    return StartDoubt{record.file, rest_V, kInfinity, initial_soc, full_V};
  const double soc =
      std::round(1e3 * NearestSocAtRest(one, rest_V, surroundings)) / 1e3 + 0.0;  // no -0
  if (std::abs(soc - initial_soc) <= kSoc ||
      std::abs(VoltageAtRest(one, initial_soc, surroundings) - rest_V) <= kVoltage_V)
    return std::nullopt;
  return StartDoubt{record.file, rest_V, soc, initial_soc, full_V};
}

std::string DoubtAboutLoadedStart(const Cell& one, const Record& record, double initial_soc) {
  constexpr double kOff_V = 0.2;  // beyond what a cold cell or an old one adds to its drop
  if (record.size() < 2 || record.voltage_V.empty()) return "";
  const double current_A = record.current_A.front();
  if (std::abs(current_A) <= RestThreshold(record)) return "";
  const double rest_V = one.open_circuit_voltage(initial_soc);
  const double found_V = record.voltage_V.front();
  const double drop_V = current_A * SeriesAndBranches(one, std::clamp(initial_soc, 0.0, 1.0));
  // Of the first row little or all of the drop may be there.
  if (found_V > rest_V + std::min(0.0, -drop_V) - kOff_V &&
      found_V < rest_V + std::max(0.0, -drop_V) + kOff_V)
    return "";
  return fmt::format(
      "begins under load at {:.4g} V, and is taken as a cell at a state of charge of {:g}, which rests at {:.4g} V: "
      "say where it begins (--initial-soc, or --initial-voltage-V), or cut a test that begins at rest out of it "
      "(lipoid inspect shows its segments, lipoid convert has --start-s and --end-s)",
      found_V,
      initial_soc,
      rest_V);
}

std::string DoubtAboutStart(const Cell& pack, const Record& record, double initial_soc) {
  if (record.voltage_V.empty()) return "";
  Record divided;
  const Record* of_one = &record;
  if (pack.series > 1 || pack.parallel > 1) {
    divided = record;
    DivideByPack(divided, pack.series, pack.parallel);
    of_one = &divided;
  }
  const double most_V = FindExtent(of_one->voltage_V).most;
  const int cells = most_V > kMostCell_V
                        ? CellsInSeries(most_V * pack.series)
                        : LoggedSeries(*of_one, pack.open_circuit_voltage, pack.series);
  if (cells != pack.series) {
    return fmt::format(
        "has the voltage of {}, not of {} in series: it does not say where these start, and only its current is used; for "
        "a pack of so many say --series {}",
        Counted(static_cast<std::size_t>(cells), "cell"),
        pack.series,
        cells);
  }
  const Cell one = pack.AsOne();
  const auto at_rest = DoubtOfStart(one, *of_one, initial_soc, SurroundingsOf(*of_one, {}));
  return at_rest ? Sentence(*at_rest) : DoubtAboutLoadedStart(one, *of_one, initial_soc);
}

std::string DoubtsAboutStarts(std::vector<StartDoubt> doubts, std::string_view of_others) {
  constexpr std::size_t kNamed = 5;
  if (doubts.empty()) return "";
  // Beyond full there is no start: another log has bent the curve.
  const auto order = [](const StartDoubt& one) {
    return std::pair(one.soc < 0.0 || one.soc > 1.0, -std::abs(one.soc - one.given));
  };
  std::stable_sort(doubts.begin(), doubts.end(), [&](const auto& a, const auto& b) {
    return order(a) < order(b);
  });
  std::string text = doubts[0].file + " " + Sentence(doubts[0]);
  if (doubts.size() == 1) return text;
  std::vector<std::string> others;
  for (std::size_t k = 1; k < std::min(doubts.size(), 1 + kNamed); ++k)
    others.push_back(
        doubts[k].soc > 1.0
            ? fmt::format("{} (beyond full)", doubts[k].file)
            : fmt::format("{} ({:g}, not {:g})", doubts[k].file, doubts[k].soc, doubts[k].given));
  if (doubts.size() > 1 + kNamed)
    others.push_back(fmt::format("{} more", doubts.size() - 1 - kNamed));
  return fmt::format(
      "{}; the starts of {} are doubtful, too: {}", text, fmt::join(others, ", "), of_others);
}

}  // namespace lipoid
