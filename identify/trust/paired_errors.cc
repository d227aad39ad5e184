#include "identify/trust/paired_errors.h"

#include <cmath>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {

double PairedGain::Probability() const {
  if (!(standard_error > 0.0)) return gain > 0.0 ? 1.0 : gain < 0.0 ? 0.0 : 0.5;
  return 0.5 * std::erfc(-gain / (standard_error * std::sqrt(2.0)));
}

PairedGain CompareErrors(const std::vector<double>& simple,
                         const std::vector<double>& rich,
                         const std::vector<double>& weight) {
  Require(simple.size() == rich.size() && rich.size() == weight.size(),
          "errors of the same units, and their weights");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double total = 0.0;
  double difference = 0.0;
  int units = 0;
  for (std::size_t u = 0; u < weight.size(); ++u) {
    if (!(weight[u] > 0.0)) continue;
    if (!std::isfinite(rich[u])) return {.gain = -kInfinity};
    if (!std::isfinite(simple[u])) return {.gain = kInfinity};
    ++units;
    total += weight[u];
    difference += simple[u] - rich[u];
  }
  if (units == 0) return {.standard_error = kInfinity};
  PairedGain paired{.gain = difference / total, .standard_error = kInfinity};
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
