#include "identify/joint/joint_terms.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/fit/grid.h"

namespace lipoid {
namespace {

// Activation energies, in J/mol: where they are searched, and where a search begins. The last are in
// the middle of what is measured of lithium cells (docs/joint.md, "Temperature").
constexpr double kLeastEnergy = 1e3;
constexpr double kMostEnergy = 150e3;
constexpr double kStartOfSeries = 15e3;
constexpr double kStartOfOthers = 40e3;
// From a loop that takes half of the charge to turn to one that takes a thousandth.
constexpr double kLeastFolds = 2.0;
constexpr double kMostFolds = 1000.0;
// The offset of a sensor, of the slowest current: more is no offset.
constexpr double kMostOffset = 0.2;
// By how much the charge from which logs begin may differ from what was assumed.
constexpr double kAlphaReach = 1.5;
constexpr double kAlphaGrid = 1.35;
constexpr int kAlphas = 7;
// An aged cell may have lost most of it.
constexpr double kAgedReach = 4.0;
constexpr double kAgedGrid = 2.5;
// Charges are known a hundred times as well as time constants, and so is an offset.
constexpr double kFine = 0.01;

}  // namespace

const std::vector<JointTerm>& JointTerms() {
  static const std::vector<JointTerm> kTerms{
      {"self_heating", "self-heating", [](const auto& s) { return s.self_heating; }},
      {"charge_transfer", "charge transfer", [](const auto& s) { return s.charge_transfer; }},
      {"temperature", "temperature", [](const auto& s) { return s.temperature; }},
      {"entropy", "entropy", [](const auto& s) { return !s.entropy_soc.empty(); }},
      {"hysteresis", "hysteresis", [](const auto& s) { return !s.hysteresis_soc.empty(); }},
      {"current_offset", "offset of the current", [](const auto& s) { return s.current_offset; }},
  };
  return kTerms;
}

std::vector<JointTable> OtherTables(const JointStructure& structure, double typical_A) {
  const JointLayout layout(structure);
  std::vector<JointTable> tables;
  if (!structure.entropy_soc.empty())
    tables.push_back({"", "V/K", layout.entropy(), structure.entropy_soc, 1.0 / kEntropyScale_K});
  if (!structure.hysteresis_soc.empty())
    tables.push_back({"M", "V", layout.hysteresis(), structure.hysteresis_soc, 1.0});
  if (structure.self_heating) {
    tables.push_back({"rho_h", "Ohm/A^2", layout.heating(), {0.5}, std::pow(typical_A, -3.0)});
  }
  return tables;
}

std::vector<std::string> SharedEnergyNames(const JointStructure& structure, bool diffusion) {
  std::vector<std::string> names;
  if (!structure.temperature || structure.shared_energies == SharedEnergies::kNone) return names;
  if (diffusion) names.emplace_back("E_d");
  if (structure.shared_energies == SharedEnergies::kAll) names.emplace_back("E_s");
  for (int j = 0; j < structure.branches; ++j) names.push_back(fmt::format("E_{}", j + 1));
  if (structure.charge_transfer) names.emplace_back("E_ct");
  return names;
}

std::vector<JointRate> AllRates(const JointStructure& structure,
                                const JointSetup& setup,
                                const FitScales& scales) {
  std::vector<JointRate> rates;
  const RateSlots slots(structure);
  if (setup.diffusion) {
    // Slower than the longest log there is no diffusion to be seen.
    rates.push_back({.name = "beta",
                     .lower = scales.least_beta_per_sqrt_s,
                     .upper = 1.0,
                     .entry = [](JointRates& r, int) { return &r.beta_per_sqrt_s; },
                     .slot = slots.beta(),
                     .start = 0.2});
  }
  for (int j = 0; j < structure.branches; ++j) {
    rates.push_back(
        {.name = fmt::format("tau_{}", j + 1),
         .lower = scales.shortest_tau_s,
         .upper = scales.longest_tau_s,
         .entry = [](JointRates& r,
                     int at) { return &r.time_constant_s[static_cast<std::size_t>(at)]; },
         .index = j,
         .slot = slots.tau(j),
         .start = std::sqrt(scales.shortest_tau_s * scales.longest_start_tau_s)});
  }
  // Two values of tau_h or i_0; one where both are there, for each was found alone before.
  const int values = structure.self_heating && structure.charge_transfer ? 1 : 2;
  if (structure.self_heating) {
    const double lower_s = std::max(30.0, 2.0 * scales.shortest_tau_s);
    constexpr double kUpper_s = 1e4;
    rates.push_back(
        {.name = "tau_h",
         .lower = lower_s,
         .upper = kUpper_s,
         .entry = [](JointRates& r, int) { return &r.heating_time_constant_s; },
         .slot = slots.heating(),
         .start = 500.0,
         .grid = GeometricGrid(std::max(lower_s, 100.0), std::min(kUpper_s, 2000.0), values)});
  }
  if (structure.charge_transfer) {
    rates.push_back(
        {.name = "i_0",
         .lower = 0.01 * scales.largest_A,
         .upper = 2.0 * scales.largest_A,
         .entry = [](JointRates& r, int) { return &r.charge_transfer_A; },
         .slot = slots.transfer(),
         .start = 0.15 * scales.largest_A,
         .grid = GeometricGrid(0.1 * scales.largest_A, 0.5 * scales.largest_A, values)});
  }
  if (structure.temperature) {
    // Energies have one valley.
    const auto add = [&](std::string name, auto entry, int index, int slot, double start) {
      rates.push_back({.name = std::move(name),
                       .lower = kLeastEnergy,
                       .upper = kMostEnergy,
                       .entry = entry,
                       .index = index,
                       .slot = slot,
                       .start = start});
    };
    const auto shared = SharedEnergyNames(structure, setup.diffusion);
    const bool own = shared.empty();
    if (!own) {
      add(
          "E",
          [](JointRates& r, int) { return &r.shared_J_per_mol; },
          0,
          slots.diffusion_energy(),
          kStartOfOthers);
      rates.back().means = shared;
    }
    if (own && setup.diffusion) {
      add(
          "E_d",
          [](JointRates& r, int) { return &r.diffusion_J_per_mol; },
          0,
          slots.diffusion_energy(),
          kStartOfOthers);
    }
    if (structure.shared_energies != SharedEnergies::kAll) {
      add(
          "E_s",
          [](JointRates& r, int) { return &r.series_J_per_mol; },
          0,
          slots.series_energy(),
          kStartOfSeries);
    }
    for (int j = 0; own && j < structure.branches; ++j) {
      add(
          fmt::format("E_{}", j + 1),
          [](JointRates& r, int at) { return &r.branch_J_per_mol[static_cast<std::size_t>(at)]; },
          j,
          slots.branch_energy(j),
          kStartOfOthers);
    }
    if (own && structure.charge_transfer) {
      add(
          "E_ct",
          [](JointRates& r, int) { return &r.transfer_J_per_mol; },
          0,
          slots.transfer_energy(),
          kStartOfOthers);
    }
  }
  if (!structure.hysteresis_soc.empty()) {
    rates.push_back({.name = "gamma",
                     .lower = kLeastFolds,
                     .upper = kMostFolds,
                     .entry = [](JointRates& r, int) { return &r.hysteresis_folds; },
                     .slot = slots.hysteresis(),
                     .start = 50.0,
                     .grid = GeometricGrid(15.0, 150.0, 2)});
  }
  if (structure.current_offset) {
    const double most_A = kMostOffset * scales.slowest_A;
    rates.push_back({.name = "i_off",
                     .lower = -most_A,
                     .upper = most_A,
                     .entry = [](JointRates& r, int) { return &r.current_offset_A; },
                     .slot = slots.offset(),
                     .start = 0.0,
                     .logarithm = false,
                     .unit = kFine * scales.slowest_A});
  }
  if (structure.free_alpha) {
    const double about_C = std::isnan(setup.search_about_C) ? setup.alpha_C : setup.search_about_C;
    rates.push_back({.name = "alpha",
                     .lower = about_C / (setup.held ? kAgedReach : kAlphaReach),
                     .upper = about_C * kAlphaReach,
                     .entry = [](JointRates& r, int) { return &r.alpha_C; },
                     .slot = slots.alpha(),
                     .start = setup.alpha_C,
                     .unit = kFine,
                     .origin = about_C,
                     .grid = GeometricGrid(setup.alpha_C / (setup.held ? kAgedGrid : kAlphaGrid),
                                           setup.alpha_C * kAlphaGrid,
                                           setup.held ? 2 * kAlphas : kAlphas)});
  }
  return rates;
}

}  // namespace lipoid
