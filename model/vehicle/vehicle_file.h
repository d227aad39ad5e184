#pragma once

/// @file
/// The vehicle file: TOML, described in docs/formats.md. Tests:
/// tests/model/vehicle/vehicle_file_test.cc.
///
///   name = "mambo-thesis"
///   mass_kg = 0.063
///   inertia_kg_m2 = [5.82857e-5, 7.16914e-5, 1e-4]
///   ...
///   [source]
///   mass_kg = "Table 6.1"

#include <string>
#include <utility>
#include <vector>

#include "model/battery/cell.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

/// Reads a vehicle file strictly: unknown and missing keys, wrong types, values out of range and
/// an inertia that no body has are LoadErrors with line and column, all of one file at once.
[[nodiscard]] Vehicle ParseVehicle(const std::string& text, const std::string& file);

/// Where the numbers of a vehicle are from: key and sentence.
using VehicleSources = std::vector<std::pair<std::string, std::string>>;

/// The file of a vehicle, which ParseVehicle() reads back to the last bit. Numbers at their defaults
/// are left out where a file may leave them out.
[[nodiscard]] std::string VehicleToToml(const Vehicle& vehicle, const VehicleSources& sources);

/// Names of the vehicles that are shipped, sorted.
[[nodiscard]] std::vector<std::string> ShippedVehicleNames();

/// A shipped vehicle by name, else the vehicle file of that name. LoadError names both ways where
/// neither is.
[[nodiscard]] Vehicle LoadVehicle(const std::string& name_or_file);

/// What is doubtful about a pack of so many cells in series for this vehicle, in one sentence; "" where
/// it has as many as the vehicle is made for, or nobody said how many these are.
[[nodiscard]] std::string DoubtAboutPack(const Vehicle& vehicle, int series);

/// What is wrong with a pack that would be heavier than what takes off with it, in one sentence; "" where no
/// energy of its cells says so.
[[nodiscard]] std::string DoubtAboutEnergy(const Vehicle& vehicle, const Cell& cell);

}  // namespace lipoid
