#include "identify/logs/log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/csv/table_reader.h"
#include "identify/logs/csv/text_source.h"
#include "identify/logs/flight/autopilot_log.h"
#include "identify/logs/flight/flight_log.h"
#include "identify/logs/formats/formats.h"
#include "identify/logs/gaps.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/spikes.h"
#include "identify/logs/thinning.h"

namespace lipoid {
namespace {

// Later than any test began and earlier than any clock of today: seconds since 1970.
constexpr double kUnixClock_s = 1e8;

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
    throw OptionError(fmt::format("units: expected a unit of {} ({}), found '{}'",
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

// A column of 10^7 rows is 20,000 small pages, and touching each for the first time is a fifth of
// the time that reading takes. Only a hint: where the system has no large pages nothing changes.
void PreferHugePages(void* begin, std::size_t bytes) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  std::size_t room = bytes;
  void* const first = std::align(kPage, kPage, begin, room);
  if (first != nullptr) ::madvise(first, room / kPage * kPage, MADV_HUGEPAGE);
}

// Volts under one name in either of two units: what no cell exceeds in V, and none is below in mV.
constexpr double kMost_V = 10.0;
constexpr double kLeast_mV = 100.0;

// Takes the blocks of a table into a record, row by row where something must be left out.
class Collector {
 public:
  Collector(const TextSource& source,
            const LogPlan& plan,
            const ReadOptions& options,
            TableReader& reader)
      : source_(source),
        plan_(plan),
        options_(options),
        reader_(reader),
        bytes_left_(static_cast<double>(source.size())),
        thinning_(options.hold, options.most_rows) {
    log_.record.file = source.file();
    log_.record.hold = options.hold;
    selects_rows_ = !options.steps.empty() || !options.cycles.empty();
    has_labels_ = options.labels && (plan.Of(Quantity::kStep) || plan.Of(Quantity::kCycle));
    selects_times_ = std::isfinite(options.start_s) || std::isfinite(options.end_s);
  }

  void Take(TableBlock& block) {
    if (block.rows == 0) return;
    rows_seen_ += block.rows;
    if (options_.progress && source_.share_read() > 0.0) options_.progress(source_.share_read());
    ToSi(block, Quantity::kTime);
    ToSi(block, Quantity::kCurrent);
    ToSi(block, Quantity::kVoltage);
    ToSi(block, Quantity::kTemperature);
    if (!clock_is_set_) {
      clock_is_set_ = true;
      const double first_s = Column(block, Quantity::kTime)[0];
      if (first_s > kUnixClock_s) unix_start_s_ = first_s;
    }
    thinning_.MakeRoom(block.rows, log_.record, directions_, log_.report.labels, Volt());
    Reserve(block);
    if (selects_rows_ || selects_times_ || has_labels_ || plan_.clock_restarts_with_step ||
        unix_start_s_ != 0.0 || !Increases(block)) {
      TakeRowByRow(block);
    } else {
      TakeAll(block);
    }
    bytes_left_ -= static_cast<double>(block.bytes);
  }

  Log Finish() {
    if (rows_seen_ == 0) {
      throw LoadError({source_.file(), plan_.header_line, 1},
                      reader_.cut_last_lines() > 0
                          ? "expected rows below the header, found only one that is cut off"
                          : "expected rows below the header, found none");
    }
    if (log_.record.size() == 0) FailUnselected();
    log_.report.thinned = thinning_.Finish(log_.record, directions_, log_.report.labels, Volt());
    if (drops_temperature_) log_.record.temperature_degC.clear();
    if ((selects_rows_ || selects_times_) && log_.record.time_s.front() != 0.0) {
      const double start_s = log_.record.time_s.front();
      for (double& t : log_.record.time_s) t -= start_s;
    }
    log_.report.rows = log_.report.thinned ? log_.report.thinned->rows_of_log : log_.record.size();
    log_.report.dropped_cut_last_line = reader_.cut_last_lines();
    return std::move(log_);
  }

  [[nodiscard]] std::vector<std::int8_t>& directions() { return directions_; }
  [[nodiscard]] bool drops_temperature() const { return drops_temperature_; }
  [[nodiscard]] bool unix_clock() const { return unix_start_s_ != 0.0; }

 private:
  // One volt in the units of the record: they may turn out to be millivolts (SettleMillivolts).
  [[nodiscard]] double Volt() const {
    const auto& voltage_V = log_.record.voltage_V;
    return plan_.volts_or_millivolts && !voltage_V.empty() && voltage_V.front() >= kLeast_mV ? 1e3
                                                                                             : 1.0;
  }

  double* Column(TableBlock& block, Quantity quantity) const {
    const auto& column = plan_.Of(quantity);
    return column ? block.columns[column->column].get() : nullptr;
  }

  void ToSi(TableBlock& block, Quantity quantity) const {
    const auto& column = plan_.Of(quantity);
    if (!column || column->unit.IsSi()) return;
    double* values = block.columns[column->column].get();
    for (std::size_t k = 0; k < block.rows; ++k) values[k] = column->unit.ToSi(values[k]);
  }

  // Vectors that doubled would hold the log twice for a moment.
  void Reserve(const TableBlock& block) {
    const std::size_t needed = log_.record.size() + block.rows;
    if (needed <= log_.record.time_s.capacity()) return;
    constexpr double kMargin = 1.02;
    const double still = std::max(bytes_left_ / static_cast<double>(block.bytes), 1.0) *
                         static_cast<double>(block.rows);
    const auto capacity = std::max(
        std::min(std::max(log_.record.size() + static_cast<std::size_t>(kMargin * still) + 16,
                          bytes_left_ > 0.0 ? needed : needed + log_.record.size()),
                 options_.most_rows),
        needed);
    for (auto* column : {&log_.record.time_s, &log_.record.current_A, &log_.record.voltage_V}) {
      column->reserve(capacity);
      PreferHugePages(column->begin(), capacity * sizeof(double));
    }
    if (plan_.Of(Quantity::kTemperature)) log_.record.temperature_degC.reserve(capacity);
    if (plan_.Of(Quantity::kState)) directions_.reserve(capacity);
  }

  bool Increases(TableBlock& block) const {
    const double* time_s = Column(block, Quantity::kTime);
    if (log_.record.size() > 0 && !(time_s[0] > log_.record.time_s.back())) return false;
    bool increases = true;
    for (std::size_t k = 1; k < block.rows; ++k) increases &= time_s[k] > time_s[k - 1];
    return increases;
  }

  void TakeAll(TableBlock& block) {
    Record& record = log_.record;
    const auto append = [&](lipoid::Column& to, const double* from) {
      to.append(from, from + block.rows);
    };
    append(record.time_s, Column(block, Quantity::kTime));
    append(record.current_A, Column(block, Quantity::kCurrent));
    if (const double* voltage = Column(block, Quantity::kVoltage))
      append(record.voltage_V, voltage);
    if (const double* temperature = Column(block, Quantity::kTemperature)) {
      append(record.temperature_degC, temperature);
      for (std::size_t k = 0; k < block.rows; ++k) drops_temperature_ |= std::isnan(temperature[k]);
    }
    if (const double* state = Column(block, Quantity::kState)) {
      for (std::size_t k = 0; k < block.rows; ++k)
        directions_.push_back(static_cast<std::int8_t>(state[k]));
    }
  }

  void TakeRowByRow(TableBlock& block) {
    Record& record = log_.record;
    const double* time_s = Column(block, Quantity::kTime);
    const double* current_A = Column(block, Quantity::kCurrent);
    const double* voltage_V = Column(block, Quantity::kVoltage);
    const double* temperature_degC = Column(block, Quantity::kTemperature);
    const double* state = Column(block, Quantity::kState);
    const double* step = Column(block, Quantity::kStep);
    const double* cycle = Column(block, Quantity::kCycle);
    for (std::size_t k = 0; k < block.rows; ++k) {
      double t_s = time_s[k] - unix_start_s_;
      if (plan_.clock_restarts_with_step) t_s = JoinedTime(k, t_s, step, cycle);
      if (!IsSelected(t_s, step ? step[k] : 0.0, cycle ? cycle[k] : 0.0)) {
        ++log_.report.dropped_unselected;
        continue;
      }
      if (record.size() > 0 && !(t_s > record.time_s.back())) {
        if (t_s < record.time_s.back()) FailBackwards(k);
        ++log_.report.dropped_repeated_times;
        continue;
      }
      if (has_labels_) Label(record.size(), step ? step[k] : 0.0, cycle ? cycle[k] : 0.0);
      record.time_s.push_back(t_s);
      record.current_A.push_back(current_A[k]);
      if (voltage_V) record.voltage_V.push_back(voltage_V[k]);
      if (temperature_degC) {
        record.temperature_degC.push_back(temperature_degC[k]);
        drops_temperature_ |= std::isnan(temperature_degC[k]);
      }
      if (state) directions_.push_back(static_cast<std::int8_t>(state[k]));
    }
  }

  void Label(std::size_t row, double step, double cycle) {
    auto& labels = log_.report.labels;
    if (!labels.empty() && labels.back().step == step && labels.back().cycle == cycle) return;
    labels.push_back({.row = row, .step = step, .cycle = cycle});
  }

  // The clock of the test, from one that starts anew with each step: a step begins where the one
  // before it ended.
  double JoinedTime(std::size_t row, double clock_s, const double* step, const double* cycle) {
    const std::pair label(step ? step[row] : 0.0, cycle ? cycle[row] : 0.0);
    if (rows_joined_++ > 0) {
      if (label != last_label_) {
        step_start_s_ = last_joined_s_;
      } else if (clock_s < last_clock_s_) {
        FailBackwards(row);
      }
    }
    last_label_ = label;
    last_clock_s_ = clock_s;
    last_joined_s_ = step_start_s_ + clock_s;
    return last_joined_s_;
  }

  bool IsSelected(double t_s, double step, double cycle) {
    const auto holds = [](const std::vector<int>& wanted, double value) {
      return wanted.empty() ||
             std::any_of(wanted.begin(), wanted.end(), [&](int w) { return w == value; });
    };
    if (!options_.steps.empty()) steps_seen_.insert(step);
    if (!options_.cycles.empty()) cycles_seen_.insert(cycle);
    return holds(options_.steps, step) && holds(options_.cycles, cycle) &&
           t_s >= options_.start_s && t_s <= options_.end_s;
  }

  [[noreturn]] void FailBackwards(std::size_t row) const {
    const std::size_t column = plan_.Of(Quantity::kTime)->column;
    const std::string last = log_.record.size() == 0
                                 ? std::string()
                                 : fmt::format(" after {:.10g} s", log_.record.time_s.back());
    throw LoadError(
        reader_.PositionOf(row, column),
        fmt::format(
            "expected time to increase, found '{}'{}; if the clock starts anew with each step or "
            "cycle, pick some with `steps` or `cycles`, or name a column that runs on with "
            "`columns = {{time_s = \"...\"}}`",
            reader_.TextOf(row, column),
            last));
  }

  [[noreturn]] void FailUnselected() const {
    const auto seen = [](const std::set<double>& values) {
      constexpr std::size_t kMost = 20;
      std::vector<double> some(
          values.begin(),
          std::next(values.begin(), static_cast<std::ptrdiff_t>(std::min(kMost, values.size()))));
      return fmt::format("{}{}", fmt::join(some, ", "), values.size() > kMost ? ", ..." : "");
    };
    std::string found;
    if (!options_.steps.empty())
      found += fmt::format(" (steps of the file: {})", seen(steps_seen_));
    if (!options_.cycles.empty())
      found += fmt::format(" (cycles of the file: {})", seen(cycles_seen_));
    throw LoadError(
        {source_.file(), plan_.header_line, 1},
        fmt::format("expected rows within steps, cycles, start_s and end_s as given, found none{}",
                    found));
  }

  const TextSource& source_;
  const LogPlan& plan_;
  const ReadOptions& options_;
  TableReader& reader_;
  Log log_;
  std::vector<std::int8_t> directions_;
  double bytes_left_;
  Thinning thinning_;
  std::size_t rows_seen_ = 0;
  bool selects_rows_ = false;
  bool selects_times_ = false;
  bool has_labels_ = false;
  bool clock_is_set_ = false;
  bool drops_temperature_ = false;
  double unix_start_s_ = 0.0;
  std::size_t rows_joined_ = 0;
  std::pair<double, double> last_label_;
  double last_clock_s_ = 0.0;
  double last_joined_s_ = 0.0;
  double step_start_s_ = 0.0;
  std::set<double> steps_seen_;
  std::set<double> cycles_seen_;
};

// Volts under one name in either of two units: no cell lies between 10 V and 100 mV read as V.
void SettleMillivolts(Record& record,
                      const SourcePosition& position,
                      std::optional<ThinningFacts>& thinned,
                      std::vector<std::string>& notes) {
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
  SignFinding found;
  if (!options.current_sign.empty() && options.current_sign != "auto") {
    if (states.sign == CurrentSign::kUnsigned && record.size() > 0 &&
        std::any_of(directions.begin(), directions.end(), [](auto d) { return d != 0; })) {
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
  } else if (format_defines) {
    found = {CurrentSign::kDischargePositive,
             fmt::format("discharge is positive in {} logs", report.format)};
  } else {
    found = states;
    const bool has_states =
        std::any_of(directions.begin(), directions.end(), [](auto d) { return d != 0; });
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
  }
  if (found.sign == CurrentSign::kUnclear && !found.contradictory &&
      others.sign != CurrentSign::kUnclear) {
    found = {others.sign,
             fmt::format("discharge is {} as in {}; by itself this log does not settle it: {}",
                         others.sign == CurrentSign::kDischargePositive ? "positive" : "negative",
                         others.source,
                         found.reason)};
    report.current_sign_is_of_others = true;
  }
  if (found.sign == CurrentSign::kUnclear) {
    std::string message = fmt::format(
        "expected a current whose sign the data settle, found that {}{}; say `current_sign` "
        "(--current-sign discharge-positive or discharge-negative), or read a part of the log",
        found.reason,
        found.contradictory || others.source.empty() ? "" : ", and that " + others.source);
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

// A reading that failed would be fitted like any other.
void DropSpikes(Log& log, std::vector<std::int8_t>& directions) {
  const std::vector<std::size_t> spikes = FindSpikes(log.record);
  if (spikes.empty()) return;
  Record& record = log.record;
  const double largest_V = record.voltage_V[*std::max_element(
      spikes.begin(), spikes.end(), [&](std::size_t a, std::size_t b) {
        return std::abs(record.voltage_V[a]) < std::abs(record.voltage_V[b]);
      })];
  log.report.warnings.push_back(
      spikes.size() == 1
          ? fmt::format("1 row dropped: a voltage of {:.4g} V at {:.10g} s, far outside "
                        "the range of all other rows",
                        largest_V,
                        record.time_s[spikes[0]])
          : fmt::format("{} rows dropped: voltages up to {:.4g} V, the first at {:.10g} s, each "
                        "far outside the range of all other rows",
                        spikes.size(),
                        largest_V,
                        record.time_s[spikes[0]]));
  if (log.report.thinned) {
    for (const std::size_t row : spikes)
      log.report.thinned->spikes_s.push_back(std::as_const(record.time_s)[row]);
  }
  const auto drop = [&](auto& column) {
    if (column.empty()) return;
    std::size_t next = 0;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < column.size(); ++k) {
      if (next < spikes.size() && spikes[next] == k) {
        ++next;
      } else {
        column[kept++] = column[k];
      }
    }
    column.resize(kept);
  };
  drop(record.time_s);
  drop(record.current_A);
  drop(record.voltage_V);
  drop(record.temperature_degC);
  drop(directions);
  log.report.dropped_spikes = spikes.size();
  log.report.rows -= spikes.size();
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
  note(reader.blank_lines() > 0, fmt::format("{} blank lines skipped", reader.blank_lines()));
  note(reader.comment_lines() > 0, fmt::format("{} comment lines skipped", reader.comment_lines()));
  note(plan.header_line > 1,
       fmt::format("{} lines before the header skipped", plan.header_line - 1));
  note(reader.last_line_has_no_end(), "the last line has no line end and was taken as complete");
  note(plan.clock_restarts_with_step,
       "the clock starts anew with each step; the steps were joined");
  note(collector.unix_clock(), "times are counted from the first row");
  note(collector.drops_temperature(), "temperature left out: some cells hold no number");
}

}  // namespace

OpenSignError::OpenSignError(SourcePosition position,
                             std::string message,
                             std::string format,
                             std::string current_column)
    : LoadError(std::move(position), std::move(message)),
      format_(std::move(format)),
      current_column_(std::move(current_column)) {}

namespace {

// What columns and header cells say where a message points to them.
using PositionOf = std::function<SourcePosition(Quantity)>;

// The same for every table, once its numbers are columns: what cannot be, spikes, sign.
void SettleTable(Log& log,
                 std::vector<std::int8_t>& directions,
                 const ReadOptions& options,
                 const SignOfOthers& others,
                 const PositionOf& position,
                 bool discharge_is_positive) {
  CheckReadable(
      log.record,
      {position(Quantity::kTime), position(Quantity::kCurrent), position(Quantity::kVoltage)});
  // Where only the current is wanted, a wrong voltage is no reason to lose its row.
  if (!options.voltage_optional) DropSpikes(log, directions);
  SettleSign(log, directions, options, others, position(Quantity::kCurrent), discharge_is_positive);
}

// The same for every log: leads, gaps, what is doubtful.
void FinishLog(Log& log, const ReadOptions& options) {
  if (options.lead_resistance_Ohm != 0.0) {
    for (std::size_t k = 0; k < log.record.voltage_V.size(); ++k) {
      log.record.voltage_V[k] += options.lead_resistance_Ohm * log.record.current_A[k];
    }
  }
  log.report.gaps = FindGaps(log.record);
  if (!log.report.gaps.empty())
    log.report.warnings.push_back(GapsText(log.report.gaps) + " unseen");
  if (auto doubt = log.report.flight ? "" : DoubtAboutTime(log.record); !doubt.empty())
    log.report.warnings.push_back(std::move(doubt));
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
  AddNotes(source, plan, reader, collector, log.report);

  const auto position = [&](Quantity quantity) {
    const auto& column = plan.Of(quantity);
    return SourcePosition{source.file(), plan.header_line, column ? column->header_column : 1};
  };
  if (plan.volts_or_millivolts)
    SettleMillivolts(
        log.record, position(Quantity::kVoltage), log.report.thinned, log.report.notes);
  SettleTable(
      log, collector.directions(), options, others, position, plan.layout->discharge_is_positive);
  return log;
}

// The whole of an autopilot's log: what it says of one battery is a small part of it.
Log ReadFlight(TextSource& source, const AutopilotFormat& format, const ReadOptions& options) {
  return FlightLog(source.file(), format, format.read(source.Rest(kMostFlightBytes)), options);
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
  const auto check = [&](const Column& column, const char* name, bool may_be_absent) {
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
      if (std::isfinite(column[k])) continue;
      throw LoadError(
          {record.file, k + 1, 1},
          fmt::format("expected a finite number in {}, found {}; drop this row", name, column[k]));
    }
  };
  if (rows == 0) throw LoadError({record.file}, "expected rows, found empty columns");
  check(record.time_s, "time_s", false);
  check(record.current_A, "current_A", false);
  check(record.voltage_V, "voltage_V", voltage_optional);
  check(record.temperature_degC, "temperature_degC", true);
}

// As a file is read: rows outside start_s .. end_s and those with a repeated time are left out.
void TakeRows(Log& log, const ReadOptions& options) {
  Record& record = log.record;
  const Column& time_s = std::as_const(record).time_s;
  std::vector<std::size_t> kept;
  bool all = true;
  const bool unix_clock = time_s.front() > kUnixClock_s;
  const double clock_s = unix_clock ? time_s.front() : 0.0;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    const bool selected =
        time_s[k] - clock_s >= options.start_s && time_s[k] - clock_s <= options.end_s;
    const bool after = k == 0 || time_s[k] > time_s[k - 1];
    if (k > 0 && time_s[k] < time_s[k - 1]) {
      throw LoadError({record.file, k + 1, 1},
                      fmt::format("expected time to increase, found {:.10g} s after {:.10g} s",
                                  time_s[k],
                                  time_s[k - 1]));
    }
    if (!selected) ++log.report.dropped_unselected;
    if (selected && !after) ++log.report.dropped_repeated_times;
    if (selected && after) {
      if (!all) kept.push_back(k);
      continue;
    }
    if (all) {
      for (std::size_t before = 0; before < k; ++before) kept.push_back(before);
    }
    all = false;
  }
  if (!all) {
    if (kept.empty())
      throw LoadError({record.file}, "expected rows within start_s and end_s, found none");
    const auto keep = [&](Column& column) {
      if (column.empty()) return;
      std::vector<double> some;
      some.reserve(kept.size());
      for (const std::size_t k : kept) some.push_back(std::as_const(column)[k]);
      column = std::move(some);
    };
    keep(record.time_s);
    keep(record.current_A);
    keep(record.voltage_V);
    keep(record.temperature_degC);
  }
  const bool chosen = std::isfinite(options.start_s) || std::isfinite(options.end_s);
  const double start_s = chosen ? std::as_const(record.time_s).front() : clock_s;
  if (start_s != 0.0 && (chosen || unix_clock)) {
    for (double& t : record.time_s) t -= start_s;
  }
  if (unix_clock) log.report.notes.emplace_back("times are counted from the first row");
  log.report.rows = record.size();
}

}  // namespace

Log ReadLog(const std::string& file, const ReadOptions& options, const SignOfOthers& others) {
  CheckOptions(options);
  TextSource source(file);
  return ReadSource(source, options, others);
}

Log ReadLogText(std::string_view text,
                const std::string& file,
                const ReadOptions& options,
                const SignOfOthers& others) {
  CheckOptions(options);
  TextSource source(file, text);
  return ReadSource(source, options, others);
}

Log TakeLog(Record record, const ReadOptions& options) {
  CheckOptions(options);
  CheckColumns(record, options.voltage_optional);
  Log log;
  log.record = std::move(record);
  log.record.hold = options.hold;
  log.report.format = "columns";
  log.report.current_column = "current_A";
  TakeRows(log, options);
  const auto position = [&](Quantity) { return SourcePosition{log.record.file}; };
  std::vector<std::int8_t> directions;
  SettleTable(log, directions, options, {}, position, false);
  FinishLog(log, options);
  return log;
}

}  // namespace lipoid
