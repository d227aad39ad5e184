#pragma once

/// @file
/// The flight controller and its estimator as C: the code that flies in the simulator, for a
/// microcontroller. The C is written by hand, once, in model/export/flight_code, and what differs
/// from vehicle to vehicle is a file of constants. Generating it from the templates instead would
/// need a translator of C++ to be trusted; a text of six hundred lines can be read, and a test
/// holds it to the templates digit for digit (double) in flights through every option.
///
///   const auto files = ExportController({.vehicle = LoadVehicle("mambo-coupled"),
///                                        .gains = LoadGains("aware"), .lowest_V = 3.0});
///
/// Tests: tests/model/export/controller_export_test.cc, tests/tools/export_controller_test.cc.

#include <string>
#include <vector>

#include "model/control/estimator.h"
#include "model/control/flight_controller.h"

namespace lipoid {

enum class Precision { kFloat, kDouble };

constexpr std::array<std::pair<Precision, std::string_view>, 2> OptionNames(Precision) {
  return {{{Precision::kFloat, "float"}, {Precision::kDouble, "double"}}};
}

struct ControllerExportRequest {
  Vehicle vehicle;
  Gains gains;
  ControllerOptions controller = {};
  EstimatorOptions estimator = {};
  /// Of the pack, the voltage at which a flight ends: what the motors reach there bounds the
  /// references of the angles, as in the simulator.
  double lowest_V = 0.0;
  Precision precision = Precision::kFloat;
  /// Sentences for the comments: where vehicle, gains and lowest voltage come from. Escaped here.
  std::vector<std::string> origin = {};
};

struct NamedFile {
  std::string name;
  std::string content;
};

/// lipoid_controller.h, lipoid_controller.c, lipoid_numbers.h and lipoid_example.c. OptionError
/// where the control law has no C, and where a number is beyond what the precision holds.
[[nodiscard]] std::vector<NamedFile> ExportController(const ControllerExportRequest& request);

/// The number that chooses the law in the C code. OptionError names those that have one, where it
/// has none.
[[nodiscard]] int LawInC(const ControlLaw& law);

/// The names of these files.
[[nodiscard]] std::vector<std::string> ExportedControllerNames();

}  // namespace lipoid
