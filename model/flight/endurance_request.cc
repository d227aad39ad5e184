#include "model/flight/endurance_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/math/tools/minima.hpp>

#include "model/battery/cell_ensemble.h"
#include "model/battery/ranges.h"
#include "model/battery/rest_voltage.h"
#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "model/core/parallel.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

template <class T>
Uncertain& Of(std::optional<T>& number) {
  return number ? *number : number.emplace();
}

constexpr EnduranceVariable kVariables[] = {
    {"airspeed-m-per-s",
     kAirspeeds_m_per_s,
     1.0,
     PercentSign::kOfValue,
     "speed through the air in m/s: of cruise, or of the wind in which it hovers",
     [](EnduranceRequest& r) -> Uncertain& { return Of(r.airspeed_m_per_s); }},
    {"ambient-degC",
     kAirTemperatures_degC,
     1.0,
     PercentSign::kNone,
     "temperature of the air in degC, from which the battery starts and warms (default the "
     "reference temperature of the cell; a cell file that knows no temperature gets typical "
     "energies and heat, and a message says so)",
     [](EnduranceRequest& r) -> Uncertain& { return Of(r.ambient_degC); }},
    {"health",
     kCapacityShares,
     1.0,
     PercentSign::kShare,
     "capacity left, as a share of that in the cell file (default 1)",
     [](EnduranceRequest& r) -> Uncertain& { return r.health; }},
    {"payload-g",
     Range{kPayloads_kg.lo / kGram_kg, kPayloads_kg.hi / kGram_kg},
     kGram_kg,
     PercentSign::kOfValue,
     "mass in g that the vehicle carries besides its own (default 0)",
     [](EnduranceRequest& r) -> Uncertain& { return r.payload_kg; }},
    {"power-factor",
     kPowerFactors,
     1.0,
     PercentSign::kFactor,
     "power that the battery gives over what the vehicle file says (default 1)",
     [](EnduranceRequest& r) -> Uncertain& { return r.power_factor; }},
    {"reserve",
     kReserves,
     1.0,
     PercentSign::kShare,
     "share of the full battery's charge that is left at landing, 0.2 or 20% (default 0.2)",
     [](EnduranceRequest& r) -> Uncertain& { return r.reserve; }},
    {"resistance-factor",
     kResistanceFactors,
     1.0,
     PercentSign::kFactor,
     "resistance of the aged cell over that in the cell file (default 1)",
     [](EnduranceRequest& r) -> Uncertain& { return r.resistance_factor; }},
};

// One value of each thing that may be uncertain.
struct Values {
  double payload_kg;
  double ambient_degC;
  double health;
  double resistance_factor;
  double power_factor;
  double reserve;
  double airspeed_m_per_s;
};

// Streams of noise from here on are those of the inputs; the cells have the lower ones.
constexpr std::uint32_t kFirstStream = 0x80000000U;

// take(number, range) of each, in the order in which they are drawn.
template <class Take>
Values ValuesOf(const EnduranceRequest& request, Take&& take) {
  return {
      .payload_kg = take(request.payload_kg, kPayloads_kg),
      .ambient_degC = take(request.ambient_degC.value_or(Uncertain{}), kAirTemperatures_degC),
      .health = take(request.health, kCapacityShares),
      .resistance_factor = take(request.resistance_factor, kResistanceFactors),
      .power_factor = take(request.power_factor, kPowerFactors),
      .reserve = take(request.reserve, kReserves),
      .airspeed_m_per_s = take(request.airspeed_m_per_s.value_or(Uncertain{}), kAirspeeds_m_per_s)};
}

Values Estimates(const EnduranceRequest& request) {
  return ValuesOf(request, [](const Uncertain& number, const Range&) { return number.value; });
}

Values Drawn(const EnduranceRequest& request, std::size_t k) {
  NormalNoise normal(request.seed, kFirstStream + static_cast<std::uint32_t>(k));
  return ValuesOf(request, [&](const Uncertain& number, const Range& valid) {
    return number.Draw(normal, valid);
  });
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
    CheckRange("ambient temperature in degC", *request.ambient_degC, kAirTemperatures_degC);
  CheckRange("health", request.health, kCapacityShares);
  CheckRange("resistance factor", request.resistance_factor, kResistanceFactors);
  CheckRange("power factor", request.power_factor, kPowerFactors);
  CheckRange("reserve", request.reserve, kReserves);
  if (request.airspeed_m_per_s)
    CheckRange("airspeed in m/s", *request.airspeed_m_per_s, kAirspeeds_m_per_s);
  constexpr double kShortest_s = 1e-4;
  if (request.options.step_s > 0.0 && request.options.step_s < kShortest_s) {
    throw OptionError(fmt::format("step_s: expected 0 or a step of at least {:g} s, found {:g}",
                                  kShortest_s,
                                  request.options.step_s));
  }
  if (request.ensemble < 0 || request.ensemble == 1) {
    throw OptionError(
        fmt::format("ensemble: expected at least 2 flights, or 0 for no intervals, found {}",
                    request.ensemble));
  }
}

Vehicle Loaded(const EnduranceRequest& request, double payload_kg) {
  Vehicle loaded = request.vehicle;
  loaded.mass_kg += payload_kg;
  return loaded;
}

MissionLeg LegOf(const EnduranceRequest& request,
                 const Vehicle& vehicle,
                 const LevelFlight& flight) {
  const SpeedController& esc = vehicle.esc;
  const double diode_V = esc.synchronous ? 0.0 : esc.diode_V;
  const double motors_A = static_cast<double>(vehicle.rotor_count()) * flight.motor_A;
  return {.power_W = vehicle.avionics_power_W,
          .drive_W = (flight.battery_V + diode_V) * motors_A,
          .diode_V = diode_V,
          .switched_A = esc.SwitchingShare() * motors_A,
          .least_V = flight.battery_V,
          .ground_speed_m_per_s = request.cruise ? flight.airspeed_m_per_s : 0.0};
}

void RequireAdvanceRatio(const EnduranceRequest& request, const LevelFlight& flight) {
  if (flight.advance_ratio <= kLargestAdvanceRatio) return;
  throw OptionError(fmt::format(
      "an airspeed of {:g} m/s is {:.2f} of the speed of the blade tips of {}, beyond the {:g} up to "
      "which momentum theory holds: fly slower",
      flight.airspeed_m_per_s,
      flight.advance_ratio,
      request.vehicle.name,
      kLargestAdvanceRatio));
}

EnduranceSetup SetupOf(const EnduranceRequest& request, const Cell& cell, const Values& values) {
  EnduranceSetup setup;
  setup.cell = Resized(Aged(cell, values.health, values.resistance_factor), request.size_factor);
  if (request.ambient_degC) setup.ambient_degC = values.ambient_degC;
  setup.initial_soc = StartOf(request, cell, {.ambient_degC = setup.ambient_degC});
  setup.reserve = values.reserve;
  setup.options = request.options;
  if (request.power) {
    setup.mission = *request.power;
  } else {
    const Vehicle vehicle = Loaded(request, values.payload_kg);
    const LevelFlight flight = Cruise(vehicle, values.airspeed_m_per_s, request.air);
    setup.mission.legs = {LegOf(request, vehicle, flight)};
  }
  for (MissionLeg& leg : setup.mission.legs) {
    leg.power_W *= values.power_factor;
    leg.drive_W *= values.power_factor;
    leg.switched_A *= values.power_factor;
  }
  return setup;
}

// The speeds at which this battery lasts longest and carries farthest, by flying it at many. Those of
// an ideal source are another thing: a faster flight also leaves more charge behind its cut-off. None
// where it cannot hover.
std::optional<BestSpeeds> SpeedsOnBattery(const EnduranceRequest& request, const Vehicle& vehicle) {
  const double full_V = request.initial_voltage_V.value_or(
      request.cell.series * request.cell.open_circuit_voltage(request.initial_soc));
  const std::optional<BestSpeeds> ideal = FindBestSpeeds(vehicle, full_V, request.air);
  if (!ideal) return std::nullopt;
  const auto setup_at = [&](double speed) {
    Values values = Estimates(request);
    values.airspeed_m_per_s = speed;
    return SetupOf(request, request.cell, values);
  };
  constexpr int kSpeeds = 40;
  std::vector<EnduranceSetup> setups;
  for (int k = 0; k <= kSpeeds; ++k)
    setups.push_back(setup_at(ideal->fastest_m_per_s * k / kSpeeds));
  const std::vector<EnduranceResult> flown = FlyMissions(setups);
  const auto best = [&](auto&& of) {
    const auto most = std::max_element(
        flown.begin(), flown.end(), [&](const auto& a, const auto& b) { return of(a) < of(b); });
    const double at = static_cast<double>(most - flown.begin());
    const double step = ideal->fastest_m_per_s / kSpeeds;
    constexpr int kBits = 16;  // the end of a flight is a time step
    const double speed = boost::math::tools::brent_find_minima(
                             [&](double v) { return -of(FlyMission(setup_at(v))); },
                             std::max(at - 1.0, 0.0) * step,
                             std::min(at + 1.0, double{kSpeeds}) * step,
                             kBits)
                             .first;
    // At the end of the range the search stops short of it.
    return of(FlyMission(setup_at(speed))) < of(*most) ? at * step : speed;
  };
  BestSpeeds speeds = *ideal;
  speeds.endurance = Cruise(vehicle, best([](const auto& r) { return r.time_s; }), request.air);
  speeds.range = Cruise(vehicle, best([](const auto& r) { return r.distance_m; }), request.air);
  double slow = speeds.endurance.airspeed_m_per_s;
  double fast = ideal->fastest_m_per_s;
  const auto lasts = [&](double v) { return FlyMission(setup_at(v)).time_s >= kLasts_s; };
  if (!lasts(fast)) {
    for (int n = 0; n < 20; ++n) {
      const double middle = 0.5 * (slow + fast);
      (lasts(middle) ? slow : fast) = middle;
    }
    speeds.fastest_m_per_s = slow;
  }
  return speeds;
}

}  // namespace

double StartOf(const EnduranceRequest& request,
               const Cell& cell,
               const Surroundings& surroundings) {
  return request.initial_voltage_V
             ? NearestSocAtRest(cell, *request.initial_voltage_V, surroundings)
             : request.initial_soc;
}

std::span<const EnduranceVariable> EnduranceVariables() { return kVariables; }

const EnduranceVariable& FindEnduranceVariable(std::string_view name) {
  return FindNamed("quantity", name, kVariables);
}

void EnduranceChoices::ApplyTo(EnduranceRequest& request) const {
  request.ensemble = ensemble;
  if (capacity_Ah) request.size_factor = *capacity_Ah / request.cell.capacity_Ah;
}

void EnduranceChoices::SetRepeats(EnduranceRequest& request) const {
  if (request.power) {
    request.power->repeats = !once;
  } else if (once) {
    throw OptionError("option --once is for missions of a file; level flight has no end");
  }
}

bool EnduranceRequest::uncertain() const {
  return cell.uncertainty.has_value() || !payload_kg.known() || !health.known() ||
         !resistance_factor.known() || !power_factor.known() || !reserve.known() ||
         (airspeed_m_per_s && !airspeed_m_per_s->known()) ||
         (ambient_degC && !ambient_degC->known());
}

EnduranceAnswer FindEndurance(const EnduranceRequest& asked, const EnduranceProgress& progress) {
  Check(asked);
  EnduranceAnswer answer;
  EnduranceRequest request = asked;
  if (!request.power) {
    const Vehicle vehicle = Loaded(request, request.payload_kg.value);
    if (request.cruise) {
      // One speed for all: it is flown as planned, whatever the battery turns out to be.
      answer.speeds = SpeedsOnBattery(request, vehicle);
      if (!request.airspeed_m_per_s && answer.speeds) {
        const LevelFlight& best = request.cruise_speed == CruiseSpeed::kBestRange
                                      ? answer.speeds->range
                                      : answer.speeds->endurance;
        request.airspeed_m_per_s = Uncertain{best.airspeed_m_per_s, 0.0};
      }
    }
    answer.flight = Cruise(
        vehicle, request.airspeed_m_per_s ? request.airspeed_m_per_s->value : 0.0, request.air);
    RequireAdvanceRatio(request, answer.flight);
  }
  const EnduranceSetup setup = SetupOf(request, request.cell, Estimates(request));
  if (request.vehicle.mass_kg > 0.0) {  // none: a mission of powers says nothing of what takes them
    const Vehicle loaded = Loaded(request, request.payload_kg.value);
    if (const auto doubt = DoubtAboutEnergy(loaded, setup.cell); !doubt.empty())
      throw OptionError(doubt);
  }
  if (!(setup.initial_soc > setup.reserve)) {
    throw OptionError(
        fmt::format("the battery starts at a state of charge of {:.4g}, which is not above the "
                    "reserve of {:.4g}: nothing to fly with. Start with more or keep less",
                    setup.initial_soc,
                    setup.reserve));
  }
  CheckStart(setup.initial_soc);
  answer.estimate = FlyMission(setup);
  if (!request.uncertain() || request.ensemble == 0) return answer;

  CellEnsemble cells;
  if (request.cell.uncertainty) {
    cells = DrawCells(request.cell, request.ensemble, request.seed);
    answer.moved = cells.moved;
  }
  answer.flights.resize(static_cast<std::size_t>(request.ensemble));
  // Groups that fly side by side are the same whatever the number of threads.
  const std::size_t groups = (answer.flights.size() + kMissionsAtOnce - 1) / kMissionsAtOnce;
  std::atomic<std::size_t> flown = 0;
  ParallelFor(groups, [&](std::size_t g) {
    StopIfAsked();
    const std::size_t first = g * kMissionsAtOnce;
    const std::size_t end = std::min(first + kMissionsAtOnce, answer.flights.size());
    std::vector<EnduranceSetup> setups;
    for (std::size_t k = first; k < end; ++k) {
      const Cell& cell = cells.cells.empty() ? request.cell : cells.cells[k];
      setups.push_back(SetupOf(request, cell, Drawn(request, k)));
    }
    const std::vector<EnduranceResult> results = FlyMissions(setups);
    std::copy(results.begin(), results.end(), answer.flights.begin() + std::ptrdiff_t(first));
    if (progress) progress(static_cast<double>(++flown) / static_cast<double>(groups));
  });
  return answer;
}

}  // namespace lipoid
