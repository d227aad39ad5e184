#pragma once

/// @file
/// The question "how long does this vehicle fly on this pack", with what is known only up to a
/// standard error, and its answer: the flight of the estimates, and flights of values drawn from
/// all the uncertainties at once. Tests: tests/model/flight/endurance_request_test.cc.
///
///   EnduranceRequest request{.vehicle = LoadVehicle("mambo-physical"), .cell = LoadCell(file)};
///   const EnduranceAnswer answer = FindEndurance(request);

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "model/battery/aged_cell.h"
#include "model/battery/prediction.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"
#include "model/flight/endurance.h"
#include "model/statistics/uncertain.h"
#include "model/vehicle/level_flight.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

// What the options of a request may be.
inline constexpr Range kPowerFactors{0.01, 100.0};
inline constexpr Range kReserves{0.0, 0.99};
inline constexpr Range kAirspeeds_m_per_s{0.0, 100.0};

enum class CruiseSpeed { kBestRange, kBestEndurance };

constexpr std::array<std::pair<CruiseSpeed, std::string_view>, 2> OptionNames(CruiseSpeed) {
  return {
      {{CruiseSpeed::kBestRange, "best-range"}, {CruiseSpeed::kBestEndurance, "best-endurance"}}};
}

inline constexpr int kUsualEnsemble = 200;

struct EnduranceRequest {
  Vehicle vehicle;
  Cell cell;
  double size_factor = 1.0;  ///< of the cell that flies over that of the cell file (aged_cell.h)
  double initial_soc = 1.0;
  std::optional<double> initial_voltage_V;  ///< of the pack at rest, instead of initial_soc
  Uncertain payload_kg{0.0, 0.0};
  std::optional<Uncertain> ambient_degC;  ///< none: the reference temperature of the cell
  Uncertain health{1.0, 0.0};             ///< capacity left over that of the cell file
  Uncertain resistance_factor{1.0, 0.0};  ///< resistance now over that of the cell file
  Uncertain power_factor{1.0, 0.0};       ///< of the battery's power over that of the model
  Uncertain reserve{0.2, 0.0};            ///< share of the charge left at landing
  std::optional<PowerMission> power;      ///< none: level flight of the vehicle
  bool cruise = false;                    ///< level flight over the ground; else it hovers
  /// Of cruise: none: the best of a kind. Hover: that of the wind.
  std::optional<Uncertain> airspeed_m_per_s;
  CruiseSpeed cruise_speed = CruiseSpeed::kBestRange;
  LevelFlightOptions air;
  EnduranceOptions options;
  int ensemble = kUsualEnsemble;
  std::uint64_t seed = 0;

  /// Whether there is anything to draw.
  [[nodiscard]] bool uncertain() const;
};

/// What is asked beside the quantities and the groups, declared once: options of `lipoid endurance` and
/// keywords of lipoid.endurance(). tests/python/test_options.py holds one against the other.
struct EnduranceChoices {
  InputFile vehicle = {};
  std::optional<double> capacity_Ah = {};
  bool once = false;
  InputFile gains = {};
  int ensemble = kUsualEnsemble;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("vehicle",
      self.vehicle,
      Word{"VEHICLE"},
      "a vehicle file, or the name of a shipped vehicle; not needed where the mission is a power");
    v("capacity_Ah",
      self.capacity_Ah,
      kCapacities_Ah,
      "nominal capacity of a cell of the pack, where it is a larger or a smaller one of the kind in "
      "the cell file: its charge, resistances and heat go with the size");
    v("once", self.once, Names(), "fly the mission of a file once instead of again and again");
    v("gains",
      self.gains,
      Word{"GAINS"},
      "for waypoints: unaware, aware, placed, or a gains file; by default aware for a Mambo and "
      "placed for any other vehicle");
    v("ensemble",
      self.ensemble,
      Range{0, 100000},
      "flights with values drawn from all uncertainties, for the intervals; 0: none");
  }

  /// Size and ensemble into the request, whose cell is there.
  void ApplyTo(EnduranceRequest& request) const;
  /// Whether its mission is flown again, once that is there. OptionError where --once is asked of level
  /// flight.
  void SetRepeats(EnduranceRequest& request) const;
};

/// What a percent sign means behind a quantity, and behind its standard error.
enum class PercentSign {
  kNone,     ///< neither may have one
  kOfValue,  ///< the error is a share of the quantity, which has a unit
  kFactor,   ///< the same of a factor: 110% are 1.1
  kShare     ///< both are hundredths: 80%+-5% are 0.75 to 0.85
};

/// A quantity of a request that may be uncertain and over which a table may be asked for.
struct EnduranceVariable {
  std::string_view name;  ///< with the unit in which it is given
  Range valid;            ///< in that unit
  double unit;            ///< in that of the request
  PercentSign percent;
  std::string_view help;
  Uncertain& (*of)(EnduranceRequest&);  ///< sets an optional one to 0 where it is not there
};

/// The only list of them: options and help of the command, `--over`, keys and messages.
[[nodiscard]] std::span<const EnduranceVariable> EnduranceVariables();

/// OptionError naming all of them.
[[nodiscard]] const EnduranceVariable& FindEnduranceVariable(std::string_view name);

/// The state of charge at which it starts, on this cell.
[[nodiscard]] double StartOf(const EnduranceRequest& request,
                             const Cell& cell,
                             const Surroundings& surroundings);

struct EnduranceAnswer {
  EnduranceResult estimate;
  LevelFlight flight;  ///< of the estimates; default-constructed where the mission is a power
  /// Of the estimates, found by flights on the battery to its end; none where the mission is no cruise.
  std::optional<BestSpeeds> speeds;
  std::vector<EnduranceResult> flights;  ///< of what was drawn; empty where nothing is uncertain
  int moved = 0;                         ///< cells that were drawn out of range
};

using EnduranceProgress = std::function<void(double fraction)>;

/// Flight k of the ensemble depends on the seed and on k alone: not on the number of flights, not
/// on threads. OptionError where the request is none that can be answered: values out of range, a
/// full battery at or below the reserve.
[[nodiscard]] EnduranceAnswer FindEndurance(const EnduranceRequest& request,
                                            const EnduranceProgress& progress = {});

}  // namespace lipoid
