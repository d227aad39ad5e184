#pragma once

/// @file
/// Logs of flights on a pack whose truth is known, as autopilots write them: a cell flown through
/// hover, climbs and gusts in steps of 20 ms, then sampled, delayed, quantised and repeated. For tests
/// of what flights say of a pack.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "identify/logs/log.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/battery/typical_temperature.h"

namespace lipoid::test {

/// How an autopilot samples.
struct FlightRecorder {
  double row_s = 0.2;
  double voltage_update_s = 0.2;
  double current_update_s = 0.2;
  double voltage_step_V = 0.01;  ///< of the pack
  double current_step_A = 0.01;
  double voltage_noise_V = 0.01;
  double current_noise_A = 0.0;
  double lag_s = 0.1;                  ///< of the voltage after the current
  double scale = 1.0;                  ///< true over shown current
  double offset_A = 0.0;               ///< shown where none flows
  double temperature_step_degC = 0.0;  ///< of a thermometer at the cell; 0: there is none
};

inline FlightRecorder LikePx4() { return {}; }
/// A smart battery behind ArduPilot: rows of 10 Hz that repeat its values.
inline FlightRecorder LikeArduPilot() {
  return {.row_s = 0.1, .voltage_update_s = 0.8, .voltage_noise_V = 0.005, .lag_s = 0.4};
}

struct FlightPlan {
  double start_soc = 1.0;
  double charge_share = 0.6;  ///< of the capacity, to land with
  double hover_rate_per_h = 6.0;
  double rest_before_s = 8.0;
  double rest_after_s = 5.0;
  double idle_A = 0.3;
  double unrest = 1.0;  ///< of climbs and gusts: 0 is a hover in still air
  std::uint64_t seed = 1;
};

struct SyntheticFlight {
  Log log;  ///< of the pack
  double end_soc = 0.0;
  double largest_A = 0.0;
};

/// A pack of 4 cells of 5 Ah in series: what a lab would have identified of such a cell when new.
inline Cell NewFlightCell() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.name = "new pack";
  cell.open_circuit_voltage_assumed = false;
  cell.capacity_Ah = 5.0;
  cell.diffusion->alpha_C = 5.0 * 3600.0;
  cell.diffusion->beta_per_sqrt_s = 0.25;
  cell.series_resistance_Ohm = 0.004;
  cell.branches = {{Resistance<double>(0.0015), 20.0, {}}};
  return cell;
}

/// The charge of a cell from full, in C.
inline SyntheticFlight FlyAndLog(const Cell& truth,
                                 int series,
                                 const FlightPlan& plan,
                                 const FlightRecorder& recorder,
                                 const std::string& name) {
  constexpr double kStep_s = 0.02;
  std::mt19937_64 engine(plan.seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double hover_A = plan.hover_rate_per_h * truth.alpha_C() / 3600.0;
  const double enough_C = plan.charge_share * truth.alpha_C();
  std::vector<double> time_s{0.0}, current_A{plan.idle_A};
  double charge_C = 0.0, gust = 0.0, climb = 0.0, until_s = 0.0;
  double landed_s = -1.0;
  while (true) {
    const double t = time_s.back() + kStep_s;
    double i = plan.idle_A;
    if (t > plan.rest_before_s && landed_s < 0.0) {
      if (t > until_s) {  // another leg
        until_s = t + 3.0 + 12.0 * uniform(engine);
        climb = uniform(engine) < 0.3 ? 0.4 + 0.4 * uniform(engine) : 0.3 * (uniform(engine) - 0.5);
      }
      const double keep = std::exp(-kStep_s / 0.7);
      gust = keep * gust + 0.15 * std::sqrt(1.0 - keep * keep) * normal(engine);
      i = hover_A * std::clamp(1.0 + plan.unrest * (climb + gust), 0.2, 2.5);
    }
    charge_C += kStep_s * i;
    if (landed_s < 0.0 && charge_C > enough_C) landed_s = t;
    time_s.push_back(t);
    current_A.push_back(i);
    if (landed_s >= 0.0 && t > landed_s + plan.rest_after_s) break;
  }
  Cell one = truth;
  one.series = one.parallel = 1;
  const Surroundings among{.measured_degC = {}, .ambient_degC = 25.0, .initial_degC = {}};
  const Prediction truth_of =
      Predict(one, time_s, current_A, Hold::kBackward, plan.start_soc, among);
  const auto& predicted = truth_of.voltage_V;

  SyntheticFlight flight;
  flight.end_soc = plan.start_soc - charge_C / truth.alpha_C();
  Record& record = flight.log.record;
  record.file = name;
  const auto round = [](double value, double step) { return step * std::round(value / step); };
  double next_voltage_s = recorder.lag_s, next_current_s = 0.0, voltage_V = 0.0, shown_A = 0.0;
  double next_row_s = recorder.lag_s + 1.0;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    const double t = time_s[k] + 1e-9;  // past the rounding of the steps
    flight.largest_A = std::max(flight.largest_A, current_A[k]);
    if (t >= next_current_s) {
      const double noise_A =
          recorder.current_noise_A > 0.0 ? recorder.current_noise_A * normal(engine) : 0.0;
      shown_A = round(current_A[k] / recorder.scale + recorder.offset_A + noise_A,
                      recorder.current_step_A);
      next_current_s += recorder.current_update_s;
    }
    if (t >= next_voltage_s) {
      const auto late = static_cast<std::size_t>(std::lround((t - recorder.lag_s) / kStep_s));
      voltage_V = round(series * predicted[late] + recorder.voltage_noise_V * normal(engine),
                        recorder.voltage_step_V);
      next_voltage_s += recorder.voltage_update_s;
    }
    if (t >= next_row_s) {
      record.time_s.push_back(time_s[k]);
      record.current_A.push_back(shown_A);
      record.voltage_V.push_back(voltage_V);
      if (recorder.temperature_step_degC > 0.0)
        record.temperature_degC.push_back(
            round(truth_of.temperature_degC[k], recorder.temperature_step_degC));
      next_row_s += recorder.row_s;
    }
  }
  return flight;
}

}  // namespace lipoid::test
