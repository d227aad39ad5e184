#include "model/flight/endurance_request.h"

#include <fmt/format.h>

#include <atomic>

#include "model/battery/aged_cell.h"
#include "model/battery/cell_ensemble.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

// One value of each thing that may be uncertain.
struct Values {
  double payload_kg;
  double ambient_degC;
  double health;
  double resistance_factor;
  double power_factor;
  double reserve;
};

// Streams of noise from here on are those of the inputs; the cells have the lower ones.
constexpr std::uint32_t kFirstStream = 0x80000000U;

Values Estimates(const EnduranceRequest& request) {
  return {.payload_kg = request.payload_kg.value,
          .ambient_degC = request.ambient_degC ? request.ambient_degC->value : 0.0,
          .health = request.health.value,
          .resistance_factor = request.resistance_factor.value,
          .power_factor = request.power_factor.value,
          .reserve = request.reserve.value};
}

Values Drawn(const EnduranceRequest& request, std::size_t k) {
  NormalNoise normal(request.seed, kFirstStream + static_cast<std::uint32_t>(k));
  Values values;
  values.payload_kg = request.payload_kg.Draw(normal, kPayloads_kg);
  values.ambient_degC = request.ambient_degC.value_or(Uncertain{}).Draw(normal, kTemperatures_degC);
  values.health = request.health.Draw(normal, kCapacityShares);
  values.resistance_factor = request.resistance_factor.Draw(normal, kResistanceFactors);
  values.power_factor = request.power_factor.Draw(normal, kPowerFactors);
  values.reserve = request.reserve.Draw(normal, kReserves);
  return values;
}

void CheckRange(std::string_view what, const Uncertain& number, const Range& valid) {
  if (valid.Contains(number.value) && number.standard_error >= 0.0) return;
  throw OptionError(
      fmt::format("{}: expected a number from {:g} to {:g} and a standard error of at "
                  "least 0, found {:g} +- {:g}",
                  what,
                  valid.lo,
                  valid.hi,
                  number.value,
                  number.standard_error));
}

void Check(const EnduranceRequest& request) {
  CheckRange("payload in kg", request.payload_kg, kPayloads_kg);
  if (request.ambient_degC)
    CheckRange("ambient temperature in degC", *request.ambient_degC, kTemperatures_degC);
  CheckRange("health", request.health, kCapacityShares);
  CheckRange("resistance factor", request.resistance_factor, kResistanceFactors);
  CheckRange("power factor", request.power_factor, kPowerFactors);
  CheckRange("reserve", request.reserve, kReserves);
  if (request.ensemble < 0)
    throw OptionError(
        fmt::format("ensemble: expected at least 0 flights, found {}", request.ensemble));
}

double StartOf(const EnduranceRequest& request, const Cell& cell) {
  return request.initial_voltage_V
             ? cell.open_circuit_voltage.SocAtVoltage(*request.initial_voltage_V / cell.series)
             : request.initial_soc;
}

LevelFlight FlightOf(const EnduranceRequest& request, double payload_kg) {
  Vehicle loaded = request.vehicle;
  loaded.mass_kg += payload_kg;
  return Hover(loaded);
}

EnduranceSetup SetupOf(const EnduranceRequest& request, const Cell& cell, const Values& values) {
  EnduranceSetup setup;
  setup.initial_soc = StartOf(request, cell);
  setup.cell = Aged(cell, values.health, values.resistance_factor);
  if (request.ambient_degC) setup.ambient_degC = values.ambient_degC;
  setup.reserve = values.reserve;
  setup.options = request.options;
  if (request.power) {
    setup.mission = *request.power;
  } else {
    const LevelFlight flight = FlightOf(request, values.payload_kg);
    setup.mission.legs = {{.power_W = flight.battery_W, .motor_V = flight.motor_V}};
  }
  for (MissionLeg& leg : setup.mission.legs) leg.power_W *= values.power_factor;
  return setup;
}

}  // namespace

bool EnduranceRequest::uncertain() const {
  return cell.uncertainty.has_value() || !payload_kg.known() || !health.known() ||
         !resistance_factor.known() || !power_factor.known() || !reserve.known() ||
         (ambient_degC && !ambient_degC->known());
}

EnduranceAnswer FindEndurance(const EnduranceRequest& request, const EnduranceProgress& progress) {
  Check(request);
  EnduranceAnswer answer;
  const EnduranceSetup setup = SetupOf(request, request.cell, Estimates(request));
  if (!(setup.initial_soc > setup.reserve)) {
    throw OptionError(
        fmt::format("the battery starts at a state of charge of {:.4g}, which is not above the "
                    "reserve of {:.4g}: nothing to fly with. Start with more or keep less",
                    setup.initial_soc,
                    setup.reserve));
  }
  if (!request.power) answer.flight = FlightOf(request, request.payload_kg.value);
  answer.estimate = FlyMission(setup);
  if (!request.uncertain() || request.ensemble == 0) return answer;

  CellEnsemble cells;
  if (request.cell.uncertainty) {
    cells = DrawCells(request.cell, request.ensemble, request.seed);
    answer.moved = cells.moved;
  }
  answer.flights.resize(static_cast<std::size_t>(request.ensemble));
  std::atomic<std::size_t> flown = 0;
  ParallelFor(answer.flights.size(), [&](std::size_t k) {
    const Cell& cell = cells.cells.empty() ? request.cell : cells.cells[k];
    answer.flights[k] = FlyMission(SetupOf(request, cell, Drawn(request, k)));
    if (progress)
      progress(static_cast<double>(++flown) / static_cast<double>(answer.flights.size()));
  });
  return answer;
}

}  // namespace lipoid
