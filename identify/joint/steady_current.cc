#include "identify/joint/steady_current.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/constancy.h"
#include "identify/logs/segments.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Rows that are looked at: they tell the noise to a per cent, and hold many pulses.
constexpr std::size_t kEnoughRows = std::size_t{1} << 16;
// A row farther than this from its level is not of it.
constexpr double kFarthest = 6.0;

// Second differences within levels, which drift and slope leave alone: sums of squares and products.
struct LevelNoise {
  double rows = 0.0;
  double current = 0.0;
  double voltage = 0.0;
  double both = 0.0;
  std::vector<double> step_Ohm;  // from the last row of a level to the first of the next

  // Of rows whose neighbours are independent: the squares 1, 4 and 1.
  [[nodiscard]] double Deviation(double squares) const { return std::sqrt(squares / (6.0 * rows)); }
};

Record FirstRows(const Record& record) {
  if (record.size() <= kEnoughRows) return record;
  Record first;
  first.hold = record.hold;
  const auto part = [](const Column& all) {
    return Column(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kEnoughRows));
  };
  first.time_s = part(record.time_s);
  first.current_A = part(record.current_A);
  first.voltage_V = part(record.voltage_V);
  return first;
}

LevelNoise MeasureNoise(const Record& record) {
  constexpr double kLargeStep = 0.3;  // of the largest current
  LevelNoise noise;
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  const double least_step_A = kLargeStep * LargestMagnitude(i);
  const double row_noise_A = RowNoise({i.data(), i.size()}, 0, i.size() - 1);
  double before_A = 0.0;
  bool after_level = false;
  for (const Segment& segment : FindSegments(record)) {
    const bool level = segment.kind != SegmentKind::kVarying;
    const double step_A = segment.current_A - before_A;
    if (level && after_level && std::abs(step_A) > least_step_A)
      noise.step_Ohm.push_back((v[segment.first - 1] - v[segment.first]) / step_A);
    before_A = segment.current_A;
    after_level = level;
    if (!level) continue;
    const auto of_level = [&](std::size_t k) {
      return std::abs(i[k] - segment.current_A) <= kFarthest * row_noise_A;
    };
    for (std::size_t k = segment.first + 1; k < segment.last; ++k) {
      if (!of_level(k - 1) || !of_level(k) || !of_level(k + 1)) continue;
      const double bend_A = i[k - 1] - 2.0 * i[k] + i[k + 1];
      const double bend_V = v[k - 1] - 2.0 * v[k] + v[k + 1];
      ++noise.rows;
      noise.current += bend_A * bend_A;
      noise.voltage += bend_V * bend_V;
      noise.both += bend_A * bend_V;
    }
  }
  return noise;
}

// Whether the voltage would show this noise, and does not.
bool IsOfTheInstrument(const LevelNoise& noise, double step_Ohm) {
  constexpr double kMatters = 0.3;       // of the noise of the voltage
  constexpr double kMostFollowed = 0.5;  // of the noise, by the voltage
  constexpr double kFewest = 100.0;
  if (!(noise.rows >= kFewest) || !(noise.current > 0.0)) return false;
  const double current_A = noise.Deviation(noise.current);
  const double voltage_V = noise.Deviation(noise.voltage);
  if (!(current_A * step_Ohm > kMatters * voltage_V)) return false;
  const double followed = -noise.both / noise.current / step_Ohm;
  const double deviation = voltage_V / (current_A * step_Ohm * std::sqrt(noise.rows));
  return followed + 3.0 * deviation < kMostFollowed;
}

// The charge of a level stays.
void TakeMeans(Record& record, double noise_A) {
  std::vector<double> current_A(record.current_A.begin(), record.current_A.end());
  for (const Segment& segment : FindSegments(record)) {
    if (segment.kind == SegmentKind::kVarying) continue;
    double charge_C = 0.0;
    double duration_s = 0.0;
    std::vector<std::size_t> rows;
    for (std::size_t k = segment.first; k <= segment.last; ++k) {
      if (std::abs(current_A[k] - segment.current_A) > kFarthest * noise_A) continue;
      const double row_s = RowDuration(record, k);
      charge_C += row_s * current_A[k];
      duration_s += row_s;
      rows.push_back(k);
    }
    if (!(duration_s > 0.0)) continue;
    for (const std::size_t k : rows) current_A[k] = charge_C / duration_s;
  }
  record.current_A = std::move(current_A);
}

double RootOfSquaredDurations(const Record& record) {
  double squares = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k)
    squares += RowDuration(record, k) * RowDuration(record, k);
  return std::sqrt(squares);
}

bool TakesPart(const LoadedLog& log) {
  return log.entry.kind != LogKind::kValidation && log.log.record.size() > 2;
}

}  // namespace

std::string SteadyCurrents::Said() const {
  return fmt::format(
      "the current of {} wavers by {:.2g} A from row to row, and the voltage does not follow: that is noise of the "
      "measurement, and within each level the mean of it is taken to have flowed",
      fmt::join(files, ", "),
      noise_A);
}

std::optional<SteadyCurrents> TakeOutCurrentNoise(const std::vector<LoadedLog>& logs) {
  std::vector<LevelNoise> noise(logs.size());
  std::vector<double> step_Ohm;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!TakesPart(logs[k])) continue;
    noise[k] = MeasureNoise(FirstRows(logs[k].log.record));
    step_Ohm.insert(step_Ohm.end(), noise[k].step_Ohm.begin(), noise[k].step_Ohm.end());
  }
  if (step_Ohm.empty()) return std::nullopt;
  const double of_steps_Ohm = Median(std::move(step_Ohm));
  SteadyCurrents steady;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!IsOfTheInstrument(noise[k], of_steps_Ohm)) continue;
    if (steady.files.empty()) steady.logs = logs;
    const double noise_A = noise[k].Deviation(noise[k].current);
    TakeMeans(steady.logs[k].log.record, noise_A);
    steady.files.push_back(logs[k].entry.file);
    steady.noise_A = std::max(steady.noise_A, noise_A);
    steady.counting_C =
        std::max(steady.counting_C, noise_A * RootOfSquaredDurations(logs[k].log.record));
  }
  if (steady.files.empty()) return std::nullopt;
  return steady;
}

}  // namespace lipoid
