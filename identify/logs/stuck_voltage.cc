#include "identify/logs/stuck_voltage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/logs/columns.h"
#include "identify/logs/staircase.h"

namespace lipoid {
namespace {

constexpr std::size_t kFewest = 20;  // rows of a discharge
constexpr double kLonger = 5.0;      // times what a value lasts on average
constexpr double kFlows = 5e-3;      // of the largest current
constexpr double kHeld = 0.02;       // the same: a current that moves less stands
constexpr double kStep = 0.05;       // the same: one that shows a resistance
constexpr double kSeen = 3.0;        // steps of the voltage
constexpr double kJump = 20.0;       // the same
constexpr double kFinest_V = 1e-4;   // no sensor has finer steps that say something

// What the record shows outside the stretches, in Ohm; 0 where no current moves there. A logger may read one of the two
// a row late.
double ResistanceOutside(const Record& record,
                         const std::vector<RowStretch>& stretches,
                         double most_A) {
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  double vi = 0.0;
  double ii = 0.0;
  auto stretch = stretches.begin();
  for (std::size_t k = 1; k + 1 < v.size(); ++k) {
    while (stretch != stretches.end() && stretch->second < k) ++stretch;
    if (stretch != stretches.end() && k >= stretch->first) continue;
    const double di = i[k] - i[k - 1];
    if (std::abs(di) < kStep * most_A) continue;
    vi -= (v[k + 1] - v[k - 1]) * di;
    ii += di * di;
  }
  return ii > 0.0 ? std::max(0.0, vi / ii) : 0.0;
}

// Of the current well inside a stretch.
struct Currents {
  std::size_t flowing = 0;  // rows of a discharge
  double moved_A = 0.0;
  double rises_A = 0.0;  // at most above what it was before
  bool charge = false;
};

Currents CurrentsWithin(const Column& i, const RowStretch& stretch, double most_A) {
  constexpr std::size_t kMargin = 2;  // rows in which either may be a row late
  Currents of;
  Extent extent;
  for (std::size_t k = stretch.first + kMargin; k + kMargin <= stretch.second; ++k) {
    if (i[k] > kFlows * most_A) ++of.flowing;
    if (i[k] < -kFlows * most_A) of.charge = true;
    extent.least = std::min(extent.least, i[k]);
    extent.most = std::max(extent.most, i[k]);
    of.rises_A = std::max(of.rises_A, i[k] - extent.least);
  }
  if (of.flowing > 0) of.moved_A = extent.most - extent.least;
  return of;
}

}  // namespace

std::string DoubtAboutStuckVoltage(const Record& record) {
  const Column& v = record.voltage_V;
  if (v.size() < 2 * kFewest) return "";
  std::size_t values = 0;
  std::vector<RowStretch> stretches;
  const auto rows_of = [](const RowStretch& stretch) { return stretch.second - stretch.first + 1; };
  ForEachStretchOfOneValue(v, [&](const RowStretch& stretch) {
    ++values;
    if (rows_of(stretch) >= kFewest) stretches.push_back(stretch);
  });
  const double usual = static_cast<double>(v.size()) / static_cast<double>(values);
  std::erase_if(stretches, [&](const RowStretch& stretch) {
    return static_cast<double>(rows_of(stretch)) <= kLonger * usual;
  });
  if (stretches.empty() || values == 1) return "";
  const double most_A = LargestMagnitude(record.current_A);
  const double step_V = std::max(StepOf(v), kFinest_V);
  const double resistance_Ohm = ResistanceOutside(record, stretches, most_A);
  std::string first;
  std::size_t others = 0;
  for (const auto& [from, to] : stretches) {
    const Currents current = CurrentsWithin(record.current_A, {from, to}, most_A);
    if (current.charge || current.flowing < kFewest) continue;
    std::string why;
    if (current.rises_A > kHeld * most_A && resistance_Ohm * current.moved_A > kSeen * step_V) {
      why =
          fmt::format("while the current moves by {:.3g} A, which elsewhere moves it by {:.3g} mV",
                      current.moved_A,
                      1e3 * resistance_Ohm * current.moved_A);
    } else if (to + 1 < v.size() && current.moved_A <= kHeld * most_A) {
      const double jump_V = std::abs(v[to + 1] - v[to]);
      const double di = std::abs(record.current_A[to + 1] - record.current_A[to]);
      if (jump_V < kJump * step_V || di > kHeld * most_A) continue;
      why = fmt::format("and then jumps by {:.3g} mV, while the current does not", 1e3 * jump_V);
    }
    if (why.empty()) continue;
    if (!first.empty()) {
      ++others;
      continue;
    }
    first = fmt::format("the voltage shows {:.6g} V from {:.6g} to {:.6g} s, {}",
                        v[from],
                        record.time_s[from],
                        record.time_s[to],
                        why);
  }
  if (first.empty()) return "";
  return fmt::format(
      "{}{}: it was not measured there (a sensor at the end of its range, or one that is not read anew), and these rows "
      "bend what is found, unless a part is read without them (start_s, end_s)",
      first,
      others == 0   ? ""
      : others == 1 ? ", and once more"
                    : fmt::format(", and {} times more", others));
}

}  // namespace lipoid
