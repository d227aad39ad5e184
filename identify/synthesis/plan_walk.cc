#include "identify/synthesis/plan_walk.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "identify/logs/discharge.h"

namespace lipoid {
namespace {

// The lengths of whole rows next to one that is none, as "pulses of 28 or 35 s in place of 30 s"; ""
// where it is one.
std::string WholeRowsInPlaceOf(const TestStage& stage, const DecimalStep& sampling) {
  const double length_s = stage.length_s;
  const auto rows = sampling.Count(length_s);
  const double nearest_s = sampling.Times(rows);
  if (std::abs(nearest_s - length_s) <= 1e-9 && (rows > 0 || length_s == 0.0)) return "";
  const auto below = nearest_s > length_s ? rows - 1 : rows;
  return fmt::format("{} of {}{} s in place of {} s",
                     stage.current_A == 0.0 ? "rests" : "pulses",
                     below > 0 ? fmt::format("{} or ", sampling.Times(below)) : "",
                     sampling.Times(below + 1),
                     length_s);
}

}  // namespace

std::string WhyNoPulses(const Cell& cell, const TestPlan& plan, const DecimalStep& sampling) {
  std::vector<std::string> lengths;
  for (const auto& stage : plan.stages) {
    if (auto fits = WholeRowsInPlaceOf(stage, sampling); !fits.empty())
      lengths.push_back(std::move(fits));
  }
  if (!lengths.empty()) {
    return fmt::format("expected pulses and rests of whole rows, one every {} s; take {}",
                       sampling.Times(1),
                       fmt::join(lengths, ", and "));
  }
  const double rest_s = sampling.Times(static_cast<std::int64_t>(kRestRows));
  const bool rests = std::any_of(plan.stages.begin(), plan.stages.end(), [&](const auto& stage) {
    return stage.current_A == 0.0 && stage.length_s >= rest_s;
  });
  if (!rests) {
    return fmt::format(
        "expected rests of at least {} rows between the pulses; take rests of at least {} s",
        kRestRows,
        rest_s);
  }
  constexpr std::int64_t kMostRows = 100'000'000;
  const TestStage& pulse = plan.stages[0];
  TestPlan first = plan;
  first.stages = {pulse, {0.0, rest_s}};
  first.cycles = 1;
  double end_s = 0.0;
  WalkPlan(cell, first, sampling, Hold::kBackward, kMostRows, [&](const WalkedRow& row) {
    end_s = row.time_s;
  });
  if (end_s >= sampling.Times(sampling.Count(pulse.length_s + rest_s))) return "";
  return fmt::format(
      "{}: a pulse of {:g} s at {:.4g} A empties the cell after {:g} s, before any rest, and "
      "identify takes no such log for pulses; take shorter pulses or a lower rate",
      plan.file,
      pulse.length_s,
      pulse.current_A,
      end_s);
}

}  // namespace lipoid
