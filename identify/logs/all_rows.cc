#include "identify/logs/all_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <vector>

#include "identify/logs/collector.h"
#include "identify/logs/csv/table_reader.h"
#include "identify/logs/csv/text_source.h"
#include "identify/logs/formats/formats.h"

namespace lipoid {
namespace {

// Makes the rows of a block what the whole log, read before, says that they are.
class Settled {
 public:
  Settled(const Log& log, const ReadOptions& options)
      : log_(log), options_(options), facts_(*log.report.thinned) {}

  void Apply(Record& rows, std::vector<std::int8_t>& directions) {
    if (rows.size() == 0) return;
    if (options_.ChoosesPart() && rows_ == 0) start_s_ = rows.time_s.front();
    rows_ += rows.size();
    if (start_s_ != 0.0) {
      for (double& t : rows.time_s) t -= start_s_;
    }
    if (log_.record.temperature_degC.empty()) rows.temperature_degC.clear();
    if (facts_.millivolts) {
      for (double& v : rows.voltage_V) v /= 1000.0;
    }
    DropSpikes(rows, directions);
    if (log_.report.current_sign == "discharge-negative") {
      for (double& i : rows.current_A) i = 0.0 - i;  // never -0
    } else if (log_.report.current_sign == "unsigned") {
      for (std::size_t k = 0; k < directions.size(); ++k)
        rows.current_A[k] = std::abs(rows.current_A[k]) * directions[k];
    }
    if (options_.lead_resistance_Ohm != 0.0) {
      for (std::size_t k = 0; k < rows.voltage_V.size(); ++k)
        rows.voltage_V[k] += options_.lead_resistance_Ohm * rows.current_A[k];
    }
  }

  [[nodiscard]] std::size_t rows() const { return rows_; }

 private:
  void DropSpikes(Record& rows, std::vector<std::int8_t>& directions) {
    const Column& t = rows.time_s;
    std::vector<std::size_t> spikes;
    for (; spike_ < facts_.spikes_s.size() && facts_.spikes_s[spike_] <= t.back(); ++spike_) {
      const auto at = std::lower_bound(t.begin(), t.end(), facts_.spikes_s[spike_]);
      spikes.push_back(static_cast<std::size_t>(at - t.begin()));
    }
    DropRows(rows, spikes);
    DropRows(directions, spikes);
  }

  const Log& log_;
  const ReadOptions& options_;
  const ThinningFacts& facts_;
  double start_s_ = 0.0;  // the first row chosen, from which time is counted
  std::size_t rows_ = 0;  // spikes included
  std::size_t spike_ = 0;
};

}  // namespace

void ForEachBlockOfRows(Log& log,
                        const ReadOptions& options,
                        const std::function<void(Record& rows)>& take) {
  if (!log.report.thinned) {
    take(log.record);
    return;
  }
  const std::string& file = log.record.file;
  if (std::error_code none; !std::filesystem::is_regular_file(file, none)) {
    throw LoadError(
        {file},
        fmt::format("expected a file, as a log of more than {} rows is read twice, found a pipe or "
                    "device; write it to a file first, or keep all of its {} rows (--most-rows)",
                    log.report.thinned->most_rows,
                    log.report.thinned->rows_of_log));
  }
  ReadOptions every = options;
  every.labels = false;
  every.most_rows = std::numeric_limits<std::size_t>::max();
  TextSource source(file);
  const LogPlan plan = PlanReading(source, every);
  TableReader reader(source, plan.table);
  Collector collector(source, plan, every, reader);
  static_cast<void>(collector.HandOn());
  Settled settled(log, options);
  reader.ForEachBlock([&](TableBlock& block) {
    collector.Take(block);
    Record rows = collector.HandOn();
    settled.Apply(rows, collector.directions());
    collector.directions().clear();
    if (rows.size() > 0) take(rows);
  });
  if (settled.rows() == log.report.thinned->rows_of_log) return;
  throw LoadError(
      {file},
      fmt::format("expected the {} rows that the first reading found, found {}: the file "
                  "changed while it was read",
                  log.report.thinned->rows_of_log,
                  settled.rows()));
}

}  // namespace lipoid
