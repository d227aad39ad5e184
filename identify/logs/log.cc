#include "identify/logs/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <system_error>
#include <utility>

#include "identify/logs/collector.h"
#include "identify/logs/columns.h"
#include "identify/logs/csv/table_reader.h"
#include "identify/logs/csv/text_source.h"
#include "identify/logs/flight/autopilot_log.h"
#include "identify/logs/flight/flight_log.h"
#include "identify/logs/formats/formats.h"
#include "identify/logs/gaps.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/spikes.h"
#include "identify/logs/stuck_voltage.h"
#include "model/core/counted.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// A flight log is held as a whole while it is read.
constexpr std::size_t kMostFlightBytes = std::size_t{1} << 31;

void CheckOptions(const ReadOptions& options) {
  for (const auto& [key, name] : options.columns) {
    const bool known = key == Key(Quantity::kTime) || key == Key(Quantity::kCurrent) ||
                       key == Key(Quantity::kVoltage) || key == Key(Quantity::kTemperature);
    if (!known) {
      throw OptionError(fmt::format(
          "columns: expected time_s, current_A, voltage_V or temperature_degC, found '{}'", key));
    }
  }
  static constexpr std::array kOrder = {Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage};
  if (!options.units.empty() && options.units.size() != kOrder.size()) {
    throw OptionError(
        fmt::format("units: expected three, of time, current and voltage (s,A,V), found {}",
                    options.units.size()));
  }
  for (std::size_t k = 0; k < options.units.size(); ++k) {
    if (FindUnit(kOrder[k], options.units[k])) continue;
    throw OptionError(
        fmt::format("units: expected a unit of {} ({}), found '{}'; the order is time, current, "
                    "voltage, as in s,A,V",
                    Name(kOrder[k]),
                    UsualUnits(kOrder[k]),
                    options.units[k]));
  }
  const auto& sign = options.current_sign;
  if (!sign.empty() && sign != "auto" && sign != "discharge-positive" &&
      sign != "discharge-negative") {
    throw OptionError(fmt::format(
        "current_sign: expected auto, discharge-positive or discharge-negative, found '{}'", sign));
  }
  if (!(options.start_s <= options.end_s)) {
    throw OptionError(fmt::format(
        "start_s: expected no later than end_s, found {} and {}", options.start_s, options.end_s));
  }
  if (!std::isfinite(options.lead_resistance_Ohm)) {
    throw OptionError(fmt::format("lead_resistance_Ohm: expected a finite number, found {}",
                                  options.lead_resistance_Ohm));
  }
}

// Volts under one name in either of two units: no cell lies between 10 V and 100 mV read as V.
void SettleMillivolts(Record& record,
                      const SourcePosition& position,
                      std::optional<ThinningFacts>& thinned,
                      std::vector<std::string>& notes) {
  constexpr double kMost_V = 10.0;
  const double largest = LargestMagnitude(record.voltage_V);
  if (largest <= kMost_V) return;
  if (largest < kLeast_mV) {
    throw LoadError(position,
                    fmt::format("expected voltages of a cell in V or mV, found {:.4g} at most, "
                                "which could be either; say `units` (--units s,mA,mV)",
                                largest));
  }
  for (double& v : record.voltage_V) v /= 1000.0;
  if (thinned) thinned->millivolts = true;
  notes.emplace_back("the voltages are in mV, by their size");
}

constexpr std::string_view kOneDirection =
    "read a part in which the cell is only charged or only discharged (start_s and end_s, steps or cycles in a "
    "campaign; lipoid convert --start-s --end-s, --steps or --cycles), or export the current with its sign or "
    "with a column of states";

// Makes discharge positive.
void SettleSign(Log& log,
                const std::vector<std::int8_t>& directions,
                const ReadOptions& options,
                const SignOfOthers& others,
                const SourcePosition& position,
                bool format_defines) {
  Record& record = log.record;
  LogReport& report = log.report;
  const SignFinding states = FindSignFromStates(record, directions);
  const bool has_states =
      std::any_of(directions.begin(), directions.end(), [](auto d) { return d != 0; });
  SignFinding found;
  if (!options.current_sign.empty() && options.current_sign != "auto") {
    if (states.sign == CurrentSign::kUnsigned && has_states) {
      throw LoadError(
          position,
          fmt::format(
              "expected a current with a sign because of current_sign = \"{}\", found none: {}; "
              "leave the option out",
              options.current_sign,
              states.reason));
    }
    found = {options.current_sign == "discharge-positive" ? CurrentSign::kDischargePositive
                                                          : CurrentSign::kDischargeNegative,
             "given by the option current_sign"};
    if (HasNoSign(record)) {
      report.warnings.push_back(fmt::format(
          "the current never changes its sign while the voltage rises and falls under it: the "
          "column holds no sign; {}",
          kOneDirection));
    }
  } else if (format_defines) {
    found = {CurrentSign::kDischargePositive,
             fmt::format("discharge is positive in {} logs", report.format)};
  } else {
    found = states;
    if (found.sign == CurrentSign::kUnclear && !has_states && !record.voltage_V.empty()) {
      found = FindSignFromPhysics(record);
      if (found.sign != CurrentSign::kUnclear) {
        found.reason = (found.sign == CurrentSign::kDischargePositive ? "discharge is positive: "
                                                                      : "discharge is negative: ") +
                       found.reason;
      }
    }
  }
  if (found.sign == CurrentSign::kUnclear && record.voltage_V.empty()) {
    found = {CurrentSign::kDischargePositive,
             "there is no voltage to tell; discharge is taken as positive"};
    const double charge_C = CountCharge(record).charge_C;
    if (charge_C < 0.0) {
      report.warnings.push_back(
          fmt::format("there is no voltage to tell the sign of the current; discharge is taken as "
                      "positive, and so {:.4g} Ah are charged: if they leave the cell, say "
                      "`current_sign` (--current-sign discharge-negative)",
                      -charge_C / 3600.0));
    }
  }
  if (found.sign == CurrentSign::kUnclear && !found.contradictory &&
      others.sign != CurrentSign::kUnclear) {
    found = {others.sign,
             fmt::format("discharge is {} as in {}; by itself this {} does not settle it: {}",
                         others.sign == CurrentSign::kDischargePositive ? "positive" : "negative",
                         others.source,
                         others.same_file ? "part" : "log",
                         found.reason)};
    report.current_sign_is_of_others = !others.same_file;
  }
  if (found.sign == CurrentSign::kUnclear) {
    const std::string remedy = HasNoSign(record)
                                   ? fmt::format("no option gives it one: {}", kOneDirection)
                                   : fmt::format(
                                         "say `current_sign` (--current-sign discharge-positive or "
                                         "discharge-negative), or read {} of the log",
                                         options.ChoosesPart() ? "another part" : "a part");
    std::string message = fmt::format(
        "expected a current whose sign the data settle, found that {}{}; {}",
        found.reason,
        found.contradictory || others.source.empty() ? "" : ", and that " + others.source,
        remedy);
    if (found.contradictory) throw LoadError(position, std::move(message));
    throw OpenSignError(position, std::move(message), report.format, report.current_column);
  }
  if (found.sign == CurrentSign::kDischargeNegative) {
    for (double& i : record.current_A) i = 0.0 - i;  // never -0
  }
  if (found.sign == CurrentSign::kUnsigned) {
    for (std::size_t k = 0; k < directions.size(); ++k)
      record.current_A[k] = std::abs(record.current_A[k]) * directions[k];
  }
  // What the states say must not fly in the face of the voltage.
  if ((options.current_sign.empty() || options.current_sign == "auto") &&
      !record.voltage_V.empty()) {
    if (states.sign != CurrentSign::kUnclear &&
        FindSignFromPhysics(record).sign == CurrentSign::kDischargeNegative) {
      throw LoadError(position,
                      fmt::format("expected the voltage to fall while charge leaves, found the "
                                  "opposite although {}; say `current_sign` (--current-sign)",
                                  states.reason));
    }
  }
  report.current_sign = found.sign == CurrentSign::kDischargePositive   ? "discharge-positive"
                        : found.sign == CurrentSign::kDischargeNegative ? "discharge-negative"
                                                                        : "unsigned";
  report.current_sign_reason = found.reason;
}

// A column in kelvin, or what a logger writes for a sensor that is not there, is no temperature of a cell.
void DropImpossibleTemperatures(Log& log) {
  Column& temperature_degC = log.record.temperature_degC;
  const std::string impossible =
      ImpossibleTemperature(std::as_const(log.record.time_s), std::as_const(temperature_degC));
  if (impossible.empty()) return;
  log.report.warnings.push_back(
      fmt::format("temperature left out: {}; what needs it goes on without", impossible));
  temperature_degC.clear();
}

// A reading that failed in between is a hole; one from which the sensor does not come back is no temperature of the
// cell from there on. Of a thinned log the rows are too far apart to tell.
void DropFailedTemperatures(Log& log) {
  Column& temperature_degC = log.record.temperature_degC;
  if (temperature_degC.empty() || log.report.thinned) return;
  const Column& time_s = std::as_const(log.record.time_s);
  const FailedTemperatures failed = FindFailedTemperatures(time_s, std::as_const(temperature_degC));
  if (failed.no_way_back) {
    const std::size_t row = *failed.no_way_back;
    log.report.warnings.push_back(fmt::format(
        "temperature left out: it jumps from {:.4g} to {:.4g} degC at {:.10g} s, which no cell does, and does not come "
        "back; what needs it goes on without",
        std::as_const(temperature_degC)[row - 1],
        std::as_const(temperature_degC)[row],
        time_s[row]));
    temperature_degC.clear();
  } else if (!failed.rows.empty()) {
    const std::size_t first = failed.rows.front();
    log.report.warnings.push_back(fmt::format(
        "{} of temperatures that no cell has, the first {:.4g} degC at {:.10g} s: there and back at once",
        Counted(failed.rows.size(), "row"),
        std::as_const(temperature_degC)[first],
        time_s[first]));
    for (const std::size_t row : failed.rows) temperature_degC[row] = kNaN;
    SettleHoles(log.record.time_s, temperature_degC, true, log.report.warnings);
  }
}

// What one of the two columns has at `spikes`, which no other row has.
std::string SpikesText(const Record& record, const std::vector<std::size_t>& spikes, bool current) {
  const Column& values = current ? record.current_A : record.voltage_V;
  const double largest =
      values[*std::max_element(spikes.begin(), spikes.end(), [&](std::size_t a, std::size_t b) {
        return std::abs(values[a]) < std::abs(values[b]);
      })];
  const std::string what = current ? "current" : "voltage";
  const std::string unit = current ? "A" : "V";
  const char* const still = current ? ", which the voltage does not follow" : "";
  return spikes.size() == 1
             ? fmt::format(
                   "1 row dropped: a {} of {:.4g} {} at {:.10g} s, far outside "
                   "the range of all other rows{}",
                   what,
                   largest,
                   unit,
                   record.time_s[spikes[0]],
                   still)
             : fmt::format(
                   "{} rows dropped: {}s up to {:.4g} {}, the first at {:.10g} s, each "
                   "far outside the range of all other rows{}",
                   spikes.size(),
                   what,
                   largest,
                   unit,
                   record.time_s[spikes[0]],
                   still);
}

void DropRowsOfSpikes(Log& log,
                      std::vector<std::int8_t>& directions,
                      const std::vector<std::size_t>& spikes,
                      bool current) {
  if (spikes.empty()) return;
  Record& record = log.record;
  log.report.warnings.push_back(SpikesText(record, spikes, current));
  if (log.report.thinned) {
    for (const std::size_t row : spikes)
      log.report.thinned->spikes_s.push_back(std::as_const(record.time_s)[row]);
  }
  DropRows(record, spikes);
  DropRows(directions, spikes);
  log.report.dropped_spikes += spikes.size();
  log.report.rows -= spikes.size();
}

// Before the cell is put in and after it is taken out there is nothing to fit.
void DropRowsWithoutCell(Log& log, std::vector<std::int8_t>& directions) {
  Record& record = log.record;
  const RowsWithoutCell found = FindRowsWithoutCell(record);
  const std::size_t size = record.size();
  const auto say = [&](std::size_t rows, std::size_t outer, std::size_t inner, bool at_end) {
    if (rows == 0) return;
    const std::string seen =
        fmt::format("{:.4g} V at rest {} {:.10g} s beside {:.4g} V, as where {}",
                    std::as_const(record.voltage_V)[outer],
                    at_end ? "from" : "up to",
                    std::as_const(record.time_s)[outer],
                    std::as_const(record.voltage_V)[inner],
                    at_end ? "the cell is taken out before the logger stops"
                           : "the logger starts without the cell");
    log.report.warnings.push_back(log.report.thinned
                                      ? fmt::format("{}; {} = {:.10g} leaves these rows out",
                                                    seen,
                                                    at_end ? "end_s" : "start_s",
                                                    std::as_const(record.time_s)[inner])
                                      : fmt::format("{} dropped at the {}: {}",
                                                    Counted(rows, "row"),
                                                    at_end ? "end" : "start",
                                                    seen));
  };
  say(found.first, found.first - 1, found.first, false);
  say(found.last, size - found.last, size - found.last - 1, true);
  if (log.report.thinned) return;
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < size; ++k) {
    if (k < found.first || k >= size - found.last) rows.push_back(k);
  }
  if (rows.empty()) return;
  DropRows(record, rows);
  DropRows(directions, rows);
  log.report.dropped_spikes += rows.size();
  log.report.rows -= rows.size();
}

// A reading that failed would be fitted like any other. A small spike of the current shows once a larger
// one is gone.
void DropSpikes(Log& log, std::vector<std::int8_t>& directions) {
  DropRowsWithoutCell(log, directions);
  DropRowsOfSpikes(log, directions, FindSpikes(log.record), false);
  constexpr int kSizes = 3;
  for (int n = 0; n < kSizes; ++n) {
    const std::vector<std::size_t> spikes = FindCurrentSpikes(log.record);
    if (spikes.empty()) return;
    DropRowsOfSpikes(log, directions, spikes, true);
  }
}

void AddNotes(const TextSource& source,
              const LogPlan& plan,
              const TableReader& reader,
              const Collector& collector,
              LogReport& report) {
  const auto note = [&](bool applies, std::string text) {
    if (applies) report.notes.push_back(std::move(text));
  };
  note(!source.compression().empty(), "unpacked by " + source.compression());
  note(source.had_byte_order_mark(), "byte order mark skipped");
  note(reader.trailing_delimiter(), "a delimiter at the end of lines skipped");
  note(reader.decimal_comma(), "numbers have a decimal comma");
  note(reader.blank_lines() > 0, Counted(reader.blank_lines(), "blank line") + " skipped");
  note(reader.comment_lines() > 0, Counted(reader.comment_lines(), "comment line") + " skipped");
  note(plan.header_line > 1, Counted(plan.header_line - 1, "line") + " before the header skipped");
  note(reader.last_line_has_no_end(), "the last line has no line end and was taken as complete");
  note(plan.clock_restarts_with_step,
       "the clock starts anew with each step; the steps were joined");
  note(collector.unix_clock(), "times are counted from the first row");
  if (const auto order = reader.found_date_order()) {
    note(true,
         *order == DateOrder::kShortYearFirst
             ? "dates such as 21/04/03 are read with the year first, as they say themselves"
             : fmt::format(
                   "dates such as 03/04/2021 are read with the {} first, as they say themselves",
                   *order == DateOrder::kMonthFirst ? "month" : "day"));
  }
}

// The same for every table, once its numbers are columns: what cannot be, spikes, sign.
void SettleTable(Log& log,
                 std::vector<std::int8_t>& directions,
                 const ReadOptions& options,
                 const SignOfOthers& others,
                 const ColumnPositions& positions,
                 bool discharge_is_positive) {
  if (auto doubt = CheckReadable(log.record, positions); !doubt.empty())
    log.report.warnings.push_back(std::move(doubt));
  // Where only the current is wanted, a wrong voltage is no reason to lose its row.
  if (!options.voltage_optional) DropSpikes(log, directions);
  SettleSign(log, directions, options, others, positions.current, discharge_is_positive);
}

// The same for every log: leads, gaps, what is doubtful.
void FinishLog(Log& log, const ReadOptions& options) {
  if (!log.report.flight) log.report.stuck_voltage = DoubtAboutStuckVoltage(log.record);
  if (options.lead_resistance_Ohm != 0.0) {
    for (std::size_t k = 0; k < log.record.voltage_V.size(); ++k) {
      log.record.voltage_V[k] += options.lead_resistance_Ohm * log.record.current_A[k];
    }
  }
  DropImpossibleTemperatures(log);
  DropFailedTemperatures(log);
  // Many loggers write the row in which a step changes twice; a clock that is coarser than the rows
  // costs most of them.
  constexpr double kManyRepeated = 0.1;
  const std::size_t repeated = log.report.dropped_repeated_times;
  const std::size_t rows = log.report.rows + repeated;
  if (static_cast<double>(repeated) > kManyRepeated * static_cast<double>(rows)) {
    log.report.warnings.push_back(
        fmt::format("{} of {} have the time of the row before and were left out: {}",
                    repeated,
                    Counted(rows, "row"),
                    log.report.flight
                        ? "the file may hold one flight twice"
                        : "the clock is coarser than the rows; export the times with more digits"));
  }
  log.report.gaps = FindGaps(log.record);
  if (!log.report.flight && log.report.current_sign != "unsigned") {
    for (const Gap& recharge : FindUnseenRecharges(log.record)) {
      const auto same = [&](const Gap& gap) { return gap.row == recharge.row; };
      std::erase_if(log.report.gaps, same);
      log.report.gaps.push_back(recharge);
    }
    std::sort(log.report.gaps.begin(), log.report.gaps.end(), [](const Gap& a, const Gap& b) {
      return a.row < b.row;
    });
  }
  if (const auto& gaps = log.report.gaps; !gaps.empty()) {
    const bool recharge =
        std::any_of(gaps.begin(), gaps.end(), [](const Gap& gap) { return gap.recharge; });
    log.report.warnings.push_back(GapsText(gaps) + (recharge ? "" : " unseen") + GapsHint(gaps));
  }
  if (log.report.flight) return;
  for (const std::string& doubt :
       {DoubtAboutTime(log.record), DoubtAboutLag(log.record), log.report.stuck_voltage}) {
    if (!doubt.empty()) log.report.warnings.push_back(doubt);
  }
}

Log ReadTable(TextSource& source, const ReadOptions& options, const SignOfOthers& others) {
  const LogPlan plan = PlanReading(source, options);
  TableReader reader(source, plan.table);
  Collector collector(source, plan, options, reader);
  reader.ForEachBlock([&](TableBlock& block) { collector.Take(block); });
  Log log = collector.Finish();
  log.report.format = plan.layout->name;
  if (const auto& current = plan.Of(Quantity::kCurrent)) {
    log.report.current_column = current->header_text;
  }
  log.report.notes = plan.notes;
  log.report.warnings.insert(
      log.report.warnings.begin(), plan.warnings.begin(), plan.warnings.end());
  AddNotes(source, plan, reader, collector, log.report);

  const auto position = [&](Quantity quantity) {
    const auto& column = plan.Of(quantity);
    return SourcePosition{source.file(), plan.header_line, column ? column->header_column : 1};
  };
  if (plan.volts_or_millivolts)
    SettleMillivolts(
        log.record, position(Quantity::kVoltage), log.report.thinned, log.report.notes);
  if (log.before && plan.volts_or_millivolts && log.before->voltage_V >= kLeast_mV)
    log.before->voltage_V /= 1000.0;
  SettleTable(
      log,
      collector.directions(),
      options,
      others,
      {.time = position(Quantity::kTime),
       .current = position(Quantity::kCurrent),
       .voltage = position(Quantity::kVoltage),
       .voltage_in_thousands =
           plan.Of(Quantity::kVoltage) && plan.Of(Quantity::kVoltage)->in_thousands,
       .known = plan.layout->discharge_is_positive ||
                (options.columns.contains("current_A") && options.columns.contains("voltage_V"))},
      plan.layout->discharge_is_positive);
  return log;
}

// The whole of an autopilot's log: what it says of one battery is a small part of it.
Log ReadFlight(TextSource& source, const AutopilotFormat& format, const ReadOptions& options) {
  Log log = FlightLog(source.file(), format, format.read(source.Rest(kMostFlightBytes)), options);
  std::vector<std::int8_t> none;  // directions: the sign is that of the format
  if (!options.voltage_optional) DropSpikes(log, none);
  return log;
}

Log ReadSource(TextSource& source, const ReadOptions& options, const SignOfOthers& others) {
  const AutopilotFormat* format = FindAutopilotFormat(source.head());
  if (format == nullptr && options.battery > 0) {
    throw LoadError({source.file()},
                    "expected a flight log because of the option battery, found a table; leave it "
                    "out");
  }
  Log log =
      format != nullptr ? ReadFlight(source, *format, options) : ReadTable(source, options, others);
  FinishLog(log, options);
  return log;
}

// Where in the columns of a program something is: rows count from 1.
void CheckColumns(const Record& record, bool voltage_optional) {
  const std::size_t rows = record.size();
  const auto check = [&](const Column& column,
                         const char* name,
                         bool may_be_absent,
                         bool may_have_holes = false) {
    if (may_be_absent && column.empty()) return;
    if (column.size() != rows) {
      throw LoadError(
          {record.file},
          fmt::format("expected columns of equal lengths, found {} rows of time_s and {} "
                      "of {}",
                      rows,
                      column.size(),
                      name));
    }
    if (std::isfinite(Sum(column))) return;
    for (std::size_t k = 0; k < rows; ++k) {
      if (std::isfinite(column[k]) || (may_have_holes && std::isnan(column[k]))) continue;
      throw LoadError(
          {record.file, k + 1, 1},
          fmt::format("expected a finite number in {}, found {}; drop this row", name, column[k]));
    }
  };
  if (rows == 0) throw LoadError({record.file}, "expected rows, found empty columns");
  check(record.time_s, "time_s", false);
  check(record.current_A, "current_A", false);
  check(record.voltage_V, "voltage_V", voltage_optional);
  check(record.temperature_degC, "temperature_degC", true, true);
}

// As a file is read: rows outside start_s .. end_s and those with a repeated time are left out.
void TakeRows(Log& log, const ReadOptions& options) {
  Record& record = log.record;
  const Column& time_s = std::as_const(record).time_s;
  std::vector<std::size_t> dropped;
  std::optional<std::size_t> last_before;
  const bool unix_clock = time_s.front() > kUnixClock_s;
  const double clock_s = unix_clock ? time_s.front() : 0.0;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    const double t_s = time_s[k] - clock_s;
    const bool selected = t_s >= options.start_s && t_s <= options.end_s;
    const bool after = k == 0 || time_s[k] > time_s[k - 1];
    if (k > 0 && time_s[k] < time_s[k - 1]) {
      throw LoadError({record.file, k + 1, 1},
                      fmt::format("expected time to increase, found {:.10g} s after {:.10g} s",
                                  time_s[k],
                                  time_s[k - 1]));
    }
    if (t_s < options.start_s) last_before = k;
    if (selected && after) continue;
    ++(selected ? log.report.dropped_repeated_times : log.report.dropped_unselected);
    dropped.push_back(k);
  }
  if (dropped.size() == time_s.size()) {
    throw LoadError({record.file},
                    "expected rows within start_s and end_s, found none" +
                        TimesOfLog(time_s.front() - clock_s, time_s.back() - clock_s));
  }
  if (last_before) {
    const auto value = [&](const Column& column) {
      return column.empty() ? kNaN : column[*last_before];
    };
    log.before = {time_s[*last_before],
                  value(record.current_A),
                  value(record.voltage_V),
                  value(record.temperature_degC)};
  }
  DropRows(record, dropped);
  const double first_s = time_s.front();
  if (log.before) log.before->time_s -= first_s;
  const double start_s = options.ChoosesTimes() ? first_s : clock_s;
  if (start_s != 0.0) {
    for (double& t : record.time_s) t -= start_s;
  }
  if (unix_clock) log.report.notes.emplace_back("times are counted from the first row");
  log.report.rows = record.size();
}

// read(options, others). A part may hold no edge of the current; its file does.
template <class Read>
Log ReadWithSignOfWhole(const ReadOptions& options, const SignOfOthers& others, const Read& read) {
  if (!options.ChoosesPart()) return read(options, others);
  try {
    return read(options, others);
  } catch (const OpenSignError&) {
    ReadOptions all = options;
    all.steps.clear();
    all.cycles.clear();
    all.start_s = -std::numeric_limits<double>::infinity();
    all.end_s = std::numeric_limits<double>::infinity();
    SignOfOthers whole{.source = "the whole log", .same_file = true};
    try {
      const std::string sign = read(all, {}).report.current_sign;
      if (sign == "discharge-positive") whole.sign = CurrentSign::kDischargePositive;
      if (sign == "discharge-negative") whole.sign = CurrentSign::kDischargeNegative;
    } catch (const LoadError&) {
      // What is wrong with the rest of the file is no fault of the part.
    }
    if (whole.sign == CurrentSign::kUnclear) throw;
    return read(options, whole);
  }
}

Log TakeColumns(Record record, const ReadOptions& options, const SignOfOthers& others) {
  Log log;
  log.record = std::move(record);
  log.record.hold = options.hold;
  log.report.format = "columns";
  log.report.current_column = "current_A";
  TakeRows(log, options);
  // In place, so that a log without such a column is not copied.
  const Column& temperature_degC = std::as_const(log.record).temperature_degC;
  if (std::isnan(Sum(temperature_degC))) {
    SettleHoles(log.record.time_s, log.record.temperature_degC, true, log.report.warnings);
  }
  const SourcePosition position{log.record.file};
  std::vector<std::int8_t> directions;
  SettleTable(log,
              directions,
              options,
              others,
              {.time = position,
               .current = position,
               .voltage = position,
               .remedy = "Columns of a program are in V, A and s: convert them"},
              false);
  FinishLog(log, options);
  return log;
}

}  // namespace

std::vector<std::string> DoubtsAboutPack(const FlightFacts& told, int series, double capacity_Ah) {
  constexpr double kAnother = 1.5;  // a pack that was renamed, or an option in another unit
  std::vector<std::string> doubts;
  if (told.cells > 0 && told.cells != series) {
    doubts.push_back(fmt::format(
        "`series` is {}, and the autopilot was told {}: look which of the two the pack has",
        series,
        told.cells));
  }
  if (capacity_Ah > 0.0 && told.capacity_Ah > 0.0 &&
      std::max(capacity_Ah / told.capacity_Ah, told.capacity_Ah / capacity_Ah) > kAnother) {
    doubts.push_back(fmt::format(
        "the capacity is {:.4g} Ah, and the autopilot was told {:.4g} Ah: look which of the two the "
        "pack has",
        capacity_Ah,
        told.capacity_Ah));
  }
  return doubts;
}

Log ReadLog(const std::string& file, const ReadOptions& options, const SignOfOthers& others) {
  CheckOptions(options);
  const auto read = [&](const ReadOptions& what, const SignOfOthers& said) {
    TextSource source(file);
    return ReadSource(source, what, said);
  };
  // A pipe is read once.
  if (std::error_code none; !std::filesystem::is_regular_file(file, none))
    return read(options, others);
  return ReadWithSignOfWhole(options, others, read);
}

Log ReadLogText(std::string_view text,
                const std::string& file,
                const ReadOptions& options,
                const SignOfOthers& others) {
  CheckOptions(options);
  return ReadWithSignOfWhole(
      options, others, [&](const ReadOptions& what, const SignOfOthers& said) {
        TextSource source(file, text);
        return ReadSource(source, what, said);
      });
}

Log TakeLog(Record record, const ReadOptions& options) {
  CheckOptions(options);
  CheckColumns(record, options.voltage_optional);
  if (!options.ChoosesPart()) return TakeColumns(std::move(record), options, {});
  return ReadWithSignOfWhole(options, {}, [&](const ReadOptions& what, const SignOfOthers& said) {
    return TakeColumns(record, what, said);
  });
}

}  // namespace lipoid
