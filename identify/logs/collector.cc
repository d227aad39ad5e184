#include "identify/logs/collector.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "model/core/counted.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// A column of 10^7 rows is 20,000 small pages, and touching each for the first time is a fifth of
// the time that reading takes. Only a hint: where the system has no large pages nothing changes.
void PreferHugePages(void* begin, std::size_t bytes) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  std::size_t room = bytes;
  void* const first = std::align(kPage, kPage, begin, room);
  if (first != nullptr) ::madvise(first, room / kPage * kPage, MADV_HUGEPAGE);
}

// A hole that a straight line may bridge: a few rows, or a short time.
constexpr std::size_t kMostBridgedRows = 3;
constexpr double kLongestBridge_s = 60.0;

// Fills the rows without a number between rows that have one; at an end the nearest stands for them.
// Returns how many there were, 0 where a hole is too large: then nothing changes.
std::size_t BridgeHoles(const Column& time_s, Column& values) {
  const std::size_t size = values.size();
  std::vector<double> filled = values.ToVector();
  std::size_t rows = 0;
  for (std::size_t first = 0; first < size; ++first) {
    if (!std::isnan(filled[first])) continue;
    std::size_t next = first;
    while (next < size && std::isnan(filled[next])) ++next;
    const bool begins = first == 0;
    const bool ends = next == size;
    if (begins && ends) return 0;
    const std::size_t from = begins ? 0 : first - 1;
    const std::size_t to = ends ? size - 1 : next;
    const double length_s = time_s[to] - time_s[from];
    if (next - first > kMostBridgedRows && length_s > kLongestBridge_s) return 0;
    for (std::size_t k = first; k < next; ++k) {
      const double share = (time_s[k] - time_s[from]) / length_s;
      filled[k] = begins ? filled[next]
                  : ends ? filled[from]
                         : filled[from] + share * (filled[next] - filled[from]);
    }
    rows += next - first;
    first = next;
  }
  values = std::move(filled);
  return rows;
}

// Of '1,000' after 999 that was read as 1.
bool IsThousandAfter(std::string_view text, double last_s) {
  const auto mark = text.find_first_of(".,");
  if (mark == text.npos || text.size() - mark - 1 != 3) return false;
  std::string whole(text);
  whole.erase(mark, 1);
  double value_s = 0.0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value_s);
  return error == std::errc() && end == whole.data() + whole.size() && value_s > last_s;
}

}  // namespace

void SettleHoles(const Column& time_s,
                 Column& temperature_degC,
                 bool may_bridge,
                 std::vector<std::string>& warnings) {
  const std::size_t rows = may_bridge ? BridgeHoles(time_s, temperature_degC) : 0;
  if (rows > 0) {
    warnings.push_back(fmt::format(
        "{} without a temperature, which is taken from a straight line between the rows around",
        Counted(rows, "row")));
    return;
  }
  temperature_degC = {};
  warnings.emplace_back(
      "temperature left out, for some rows hold no number: what needs it goes on without");
}

std::string TimesOfLog(double first_s, double last_s) {
  return fmt::format(" (times of the log: {:.10g} to {:.10g} s)", first_s, last_s);
}

Collector::Collector(const TextSource& source,
                     const LogPlan& plan,
                     const ReadOptions& options,
                     TableReader& reader)
    : source_(source),
      plan_(plan),
      options_(options),
      reader_(reader),
      bytes_left_(static_cast<double>(source.size())),
      thinning_(plan.layout->hold.value_or(options.hold), options.most_rows) {
  log_.record.file = source.file();
  log_.record.hold = plan.layout->hold.value_or(options.hold);
  has_labels_ = options.labels && (plan.Of(Quantity::kStep) || plan.Of(Quantity::kCycle));
}

void Collector::Take(TableBlock& block) {
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
  thinning_.MakeRoom(block.rows, {log_.record, directions_, log_.report.labels, Volt()});
  Reserve(block);
  if (options_.ChoosesPart() || has_labels_ || plan_.clock_restarts_with_step ||
      unix_start_s_ != 0.0 || !Increases(block)) {
    TakeRowByRow(block);
  } else {
    TakeAll(block);
  }
  bytes_left_ -= static_cast<double>(block.bytes);
}

Log Collector::Finish() {
  if (rows_seen_ == 0) {
    throw LoadError({source_.file(), plan_.header_line, 1},
                    reader_.cut_last_lines() > 0
                        ? "expected rows below the header, found only one that is cut off"
                        : "expected rows below the header, found none");
  }
  if (log_.record.size() == 0) FailUnselected();
  log_.report.thinned = thinning_.Finish({log_.record, directions_, log_.report.labels, Volt()});
  if (drops_temperature_) {
    SettleHoles(log_.record.time_s,
                log_.record.temperature_degC,
                !log_.report.thinned,
                log_.report.warnings);
  }
  if (options_.ChoosesPart() && log_.record.time_s.front() != 0.0) {
    const double start_s = log_.record.time_s.front();
    for (double& t : log_.record.time_s) t -= start_s;
    if (log_.before) log_.before->time_s -= start_s;
  }
  log_.report.rows = log_.report.thinned ? log_.report.thinned->rows_of_log : log_.record.size();
  log_.report.dropped_cut_last_line = reader_.cut_last_lines();
  return std::move(log_);
}

// One volt in the units of the record: they may turn out to be millivolts (SettleMillivolts).
double Collector::Volt() const {
  const auto& voltage_V = log_.record.voltage_V;
  return plan_.volts_or_millivolts && !voltage_V.empty() && voltage_V.front() >= kLeast_mV ? 1e3
                                                                                           : 1.0;
}

double* Collector::Column(TableBlock& block, Quantity quantity) const {
  const auto& column = plan_.Of(quantity);
  return column ? block.columns[column->column].get() : nullptr;
}

void Collector::ToSi(TableBlock& block, Quantity quantity) const {
  const auto& column = plan_.Of(quantity);
  if (!column || column->unit.IsSi()) return;
  double* values = block.columns[column->column].get();
  for (std::size_t k = 0; k < block.rows; ++k) values[k] = column->unit.ToSi(values[k]);
}

Record Collector::HandOn() {
  hands_on_ = true;
  Record next;
  next.file = log_.record.file;
  next.hold = log_.record.hold;
  return std::exchange(log_.record, std::move(next));
}

// Vectors that doubled would hold the log twice for a moment.
void Collector::Reserve(const TableBlock& block) {
  if (hands_on_) return;
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

bool Collector::Increases(TableBlock& block) const {
  const double* time_s = Column(block, Quantity::kTime);
  if (!(time_s[0] > last_s_)) return false;
  bool increases = true;
  for (std::size_t k = 1; k < block.rows; ++k) increases &= time_s[k] > time_s[k - 1];
  return increases;
}

void Collector::TakeAll(TableBlock& block) {
  Record& record = log_.record;
  const auto append = [&](lipoid::Column& to, const double* from) {
    to.append(from, from + block.rows);
  };
  append(record.time_s, Column(block, Quantity::kTime));
  last_s_ = Column(block, Quantity::kTime)[block.rows - 1];
  append(record.current_A, Column(block, Quantity::kCurrent));
  if (const double* voltage = Column(block, Quantity::kVoltage)) append(record.voltage_V, voltage);
  if (const double* temperature = Column(block, Quantity::kTemperature)) {
    append(record.temperature_degC, temperature);
    for (std::size_t k = 0; k < block.rows; ++k) drops_temperature_ |= std::isnan(temperature[k]);
  }
  if (const double* state = Column(block, Quantity::kState)) {
    for (std::size_t k = 0; k < block.rows; ++k)
      directions_.push_back(static_cast<std::int8_t>(state[k]));
  }
}

void Collector::TakeRowByRow(TableBlock& block) {
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
      if (record.size() == 0)
        log_.before = {t_s,
                       current_A[k],
                       voltage_V ? voltage_V[k] : kNaN,
                       temperature_degC ? temperature_degC[k] : kNaN};
      continue;
    }
    if (!(t_s > last_s_)) {
      if (t_s < last_s_) FailBackwards(k, last_s_ - t_s);
      ++log_.report.dropped_repeated_times;
      continue;
    }
    if (has_labels_) Label(record.size(), step ? step[k] : 0.0, cycle ? cycle[k] : 0.0);
    record.time_s.push_back(t_s);
    last_s_ = t_s;
    record.current_A.push_back(current_A[k]);
    if (voltage_V) record.voltage_V.push_back(voltage_V[k]);
    if (temperature_degC) {
      record.temperature_degC.push_back(temperature_degC[k]);
      drops_temperature_ |= std::isnan(temperature_degC[k]);
    }
    if (state) directions_.push_back(static_cast<std::int8_t>(state[k]));
  }
}

void Collector::Label(std::size_t row, double step, double cycle) {
  auto& labels = log_.report.labels;
  if (!labels.empty() && labels.back().step == step && labels.back().cycle == cycle) return;
  labels.push_back({.row = row, .step = step, .cycle = cycle});
}

// The clock of the test, from one that starts anew with each step: a step begins where the one
// before it ended.
double Collector::JoinedTime(std::size_t row,
                             double clock_s,
                             const double* step,
                             const double* cycle) {
  const std::pair label(step ? step[row] : 0.0, cycle ? cycle[row] : 0.0);
  if (rows_joined_++ > 0) {
    if (label != last_label_) {
      step_start_s_ = last_joined_s_;
    } else if (clock_s < last_clock_s_) {
      FailBackwards(row, last_clock_s_ - clock_s);
    }
  }
  last_label_ = label;
  last_clock_s_ = clock_s;
  last_joined_s_ = step_start_s_ + clock_s;
  return last_joined_s_;
}

bool Collector::IsSelected(double t_s, double step, double cycle) {
  const auto holds = [](const std::vector<int>& wanted, double value) {
    return wanted.empty() ||
           std::any_of(wanted.begin(), wanted.end(), [&](int w) { return w == value; });
  };
  if (!options_.steps.empty()) steps_seen_.insert(step);
  if (!options_.cycles.empty()) cycles_seen_.insert(cycle);
  first_seen_s_ = std::min(first_seen_s_, t_s);
  last_seen_s_ = std::max(last_seen_s_, t_s);
  return holds(options_.steps, step) && holds(options_.cycles, cycle) && t_s >= options_.start_s &&
         t_s <= options_.end_s;
}

void Collector::FailBackwards(std::size_t row, double fell_s) const {
  struct Clock {
    double fall_s;
    const char* hint;
  };
  constexpr Clock kClocks[] = {
      {86400.0, "if a clock without a date passed midnight, export the date with the time; "},
      {43200.0, "if a clock of twelve hours began anew, export times of 24 hours; "},
      {3600.0,
       "if the clock was put back at the end of summer time, export the time since the start; "}};
  constexpr double kLongestRow_s = 600.0;
  std::string hint;
  for (const Clock& clock : kClocks) {
    if (fell_s <= clock.fall_s && fell_s >= clock.fall_s - kLongestRow_s) hint = clock.hint;
  }
  const std::size_t column = plan_.Of(Quantity::kTime)->column;
  if (IsThousandAfter(reader_.TextOf(row, column), last_s_))
    hint = "if the mark in it is one for thousands, export numbers without; ";
  const std::string last =
      std::isinf(last_s_) ? std::string() : fmt::format(" after {:.10g} s", last_s_);
  throw LoadError(
      reader_.PositionOf(row, column),
      fmt::format(
          "expected time to increase, found '{}'{}; {}if the clock starts anew with each step or "
          "cycle, pick some with `steps` or `cycles`, or name a column that runs on with "
          "`columns = {{time_s = \"...\"}}`; logs that were joined are read one by one",
          reader_.TextOf(row, column),
          last,
          hint));
}

void Collector::FailUnselected() const {
  const auto seen = [](const std::set<double>& values) {
    constexpr std::size_t kMost = 20;
    std::vector<double> some(
        values.begin(),
        std::next(values.begin(), static_cast<std::ptrdiff_t>(std::min(kMost, values.size()))));
    return fmt::format("{}{}", fmt::join(some, ", "), values.size() > kMost ? ", ..." : "");
  };
  std::string found;
  if (!options_.steps.empty()) found += fmt::format(" (steps of the file: {})", seen(steps_seen_));
  if (!options_.cycles.empty())
    found += fmt::format(" (cycles of the file: {})", seen(cycles_seen_));
  if (options_.ChoosesTimes()) found += TimesOfLog(first_seen_s_, last_seen_s_);
  throw LoadError(
      {source_.file(), plan_.header_line, 1},
      fmt::format("expected rows within steps, cycles, start_s and end_s as given, found none{}",
                  found));
}

}  // namespace lipoid
