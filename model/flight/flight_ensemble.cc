#include "model/flight/flight_ensemble.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/statistics/interval_95.h"

namespace lipoid {

std::vector<FlightResult> FlyOnEach(const FlightSetup& setup,
                                    const FlightPlan& plan,
                                    std::span<const Cell> cells,
                                    std::span<const double> initial_soc,
                                    const FlightProgress& progress) {
  Require(initial_soc.size() == cells.size(), "a start for each cell");
  std::vector<FlightResult> flights(cells.size());
  std::atomic<std::size_t> flown = 0;
  ParallelFor(cells.size(), [&](std::size_t k) {
    FlightSetup own = setup;
    own.cell = cells[k];
    own.initial_soc = initial_soc[k];
    flights[k] = Fly(own, plan);
    if (progress) progress(static_cast<double>(++flown) / static_cast<double>(cells.size()));
  });
  return flights;
}

int CountOf(std::span<const FlightResult> flights, Outcome outcome) {
  return static_cast<int>(std::count_if(flights.begin(), flights.end(), [&](const auto& flight) {
    return flight.outcome == outcome;
  }));
}

std::pair<double, double> IntervalOf(std::span<const FlightResult> flights,
                                     double FlightResult::*number) {
  std::vector<double> values;
  for (const FlightResult& flight : flights) {
    if (std::isfinite(flight.*number)) values.push_back(flight.*number);
  }
  return Interval95(values);
}

}  // namespace lipoid
