#include "identify/logs/columns.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

constexpr std::size_t kRowsOfFold = std::size_t{1} << 16;

// Rows [first, end) as four runs that lie behind one another, taken in turn.
template <class State, class Step>
State FoldPiece(std::size_t first, std::size_t end, const Step& step) {
  const std::size_t run = (end - first) / 4;
  State a;
  State b;
  State c;
  State d;
  for (std::size_t k = first; k < first + run; ++k) {
    step(a, k);
    step(b, k + run);
    step(c, k + 2 * run);
    step(d, k + 3 * run);
  }
  for (std::size_t k = first + 4 * run; k < end; ++k) step(d, k);
  a.Append(b);
  a.Append(c);
  a.Append(d);
  return a;
}

// A State begins as that of no rows; step(state, k) takes row k into it; Append() joins in order.
template <class State, class Step>
State Fold(std::size_t first, std::size_t end, const Step& step) {
  if (end - first <= kRowsOfFold) return FoldPiece<State>(first, end, step);
  std::vector<State> pieces((end - first + kRowsOfFold - 1) / kRowsOfFold);
  ParallelFor(pieces.size(), [&](std::size_t p) {
    const std::size_t begin = first + p * kRowsOfFold;
    pieces[p] = FoldPiece<State>(begin, std::min(end, begin + kRowsOfFold), step);
  });
  State all;
  for (const State& piece : pieces) all.Append(piece);
  return all;
}

struct ExtentState : Extent {
  void Take(double x) {
    least = std::min(least, x);
    most = std::max(most, x);
  }
  void Append(const ExtentState& next) {
    least = std::min(least, next.least);
    most = std::max(most, next.most);
  }
};

struct Total {
  double sum = 0.0;
  void Append(const Total& next) { sum += next.sum; }
};

}  // namespace

Extent FindExtent(std::span<const double> values) {
  return Fold<ExtentState>(
      0, values.size(), [&](ExtentState& state, std::size_t k) { state.Take(values[k]); });
}

double LargestMagnitude(std::span<const double> values) { return FindExtent(values).Magnitude(); }

double Sum(std::span<const double> values) {
  return Fold<Total>(0, values.size(), [&](Total& total, std::size_t k) { total.sum += values[k]; })
      .sum;
}

double ShortestInterval(std::span<const double> time_s) {
  if (time_s.size() < 2) return std::numeric_limits<double>::infinity();
  return Fold<ExtentState>(
             1,
             time_s.size(),
             [&](ExtentState& state, std::size_t k) { state.Take(time_s[k] - time_s[k - 1]); })
      .least;
}

void ChargeMoved::Append(const ChargeMoved& next) {
  least_C = std::min(least_C, charge_C + next.least_C);
  most_C = std::max(most_C, charge_C + next.most_C);
  charge_C += next.charge_C;
}

ChargeMoved CountCharge(const Record& record, std::size_t from, std::size_t to) {
  Require(from <= to && to < record.size(),
          "from <= to < size",
          {{"from", static_cast<double>(from)}, {"to", static_cast<double>(to)}});
  const double* time_s = record.time_s.data();
  const double* current_A = record.current_A.data();
  const std::size_t before = record.hold == Hold::kBackward ? 0 : 1;
  return Fold<ChargeMoved>(from + 1, to + 1, [=](ChargeMoved& moved, std::size_t k) {
    moved.charge_C += current_A[k - before] * (time_s[k] - time_s[k - 1]);  // (4.59)
    moved.least_C = std::min(moved.least_C, moved.charge_C);
    moved.most_C = std::max(moved.most_C, moved.charge_C);
  });
}

}  // namespace lipoid
