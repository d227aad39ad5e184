#pragma once

/// @file
/// Records with known steps, for tests: steps of current, sampled anyhow, with or without noise.

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid::test {

/// As the most rows to keep of a log: none is left out.
inline constexpr std::size_t kEveryRow = std::size_t{1} << 40;

struct CurrentStep {
  double duration_s = 0.0;
  double current_A = 0.0;
  double sampling_s = 1.0;
};

/// Row 0 is a stamp at time 0 that opens the first step. With backward hold each step's rows close
/// its intervals; with forward hold they open them, and one row at rest ends the record. The
/// voltage is 3.7 V less 0.05 V per ampere.
inline Record RecordOfSteps(const std::vector<CurrentStep>& steps,
                            Hold hold = Hold::kBackward,
                            double noise_A = 0.0,
                            unsigned seed = 1) {
  Record record;
  record.file = "synthetic.csv";
  record.hold = hold;
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  const auto add = [&](double time_s, double current_A) {
    record.time_s.push_back(time_s);
    record.current_A.push_back(current_A + (noise_A > 0.0 ? noise_A * normal(engine) : 0.0));
    record.voltage_V.push_back(3.7 - 0.05 * current_A);
  };
  double start_s = 0.0;
  if (hold == Hold::kBackward) add(0.0, 0.0);
  for (const CurrentStep& step : steps) {
    const auto rows = static_cast<int>(std::lround(step.duration_s / step.sampling_s));
    for (int k = 0; k < rows; ++k) {
      add(start_s + (hold == Hold::kBackward ? k + 1 : k) * step.sampling_s, step.current_A);
    }
    start_s += step.duration_s;
  }
  if (hold == Hold::kForward) add(start_s, 0.0);
  return record;
}

inline void AddWhiteNoise(Record& record, double noise_V, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  for (double& v : record.voltage_V) v += noise_V * normal(engine);
}

}  // namespace lipoid::test
