#include "identify/trust/paired_errors.h"

#include <algorithm>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {

double PairedGain::Probability() const {
  if (!(standard_error > 0.0)) return gain > 0.0 ? 1.0 : gain < 0.0 ? 0.0 : 0.5;
  return 0.5 * std::erfc(-gain / (standard_error * std::sqrt(2.0)));
}

namespace {

// z of the signed ranks of these differences; equal sizes share their ranks.
double SignedRanks(std::vector<double> differences) {
  std::sort(differences.begin(), differences.end(), [](double a, double b) {
    return std::abs(a) < std::abs(b);
  });
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t first = 0; first < differences.size();) {
    std::size_t end = first;
    while (end < differences.size() && std::abs(differences[end]) == std::abs(differences[first])) {
      ++end;
    }
    const double rank = 0.5 * static_cast<double>(first + 1 + end);
    for (; first < end; ++first) {
      if (differences[first] == 0.0) continue;
      sum += differences[first] > 0.0 ? rank : -rank;
      squares += rank * rank;
    }
  }
  return squares > 0.0 ? sum / std::sqrt(squares) : 0.0;
}

}  // namespace

PairedGain CompareErrors(const std::vector<double>& simple,
                         const std::vector<double>& rich,
                         const std::vector<double>& weight) {
  Require(simple.size() == rich.size() && rich.size() == weight.size(),
          "errors of the same units, and their weights");
  double total = 0.0;
  double difference = 0.0;
  int units = 0;
  std::vector<double> differences;
  for (std::size_t u = 0; u < weight.size(); ++u) {
    if (!(weight[u] > 0.0)) continue;
    if (!std::isfinite(rich[u])) return {.gain = -kInfinity, .ranks = -kInfinity};
    if (!std::isfinite(simple[u])) return {.gain = kInfinity, .ranks = kInfinity};
    ++units;
    total += weight[u];
    difference += simple[u] - rich[u];
    differences.push_back((simple[u] - rich[u]) / weight[u]);
  }
  if (units == 0) return {.standard_error = kInfinity};
  PairedGain paired{.gain = difference / total,
                    .standard_error = kInfinity,
                    .ranks = SignedRanks(std::move(differences))};
  if (units < 2) return paired;
  double squares = 0.0;
  for (std::size_t u = 0; u < weight.size(); ++u) {
    if (!(weight[u] > 0.0)) continue;
    const double off = simple[u] - rich[u] - weight[u] * paired.gain;
    squares += off * off;
  }
  paired.standard_error = std::sqrt(squares * units / (units - 1.0)) / total;
  return paired;
}

}  // namespace lipoid
