#pragma once

/// @file
/// What a person may ask of the stages, declared once: the options of `lipoid identify`, `compare` and
/// `study`, and the keywords of lipoid.identify() and its like.
///
///   StagedRequest request;
///   line.Each(request);       // --alpha-C, --open-circuit-voltage, --branches, --fix ...
///   request.EachGroup([&](std::string_view name, auto& options) { line.Group(name, options); });
///   ...
///   request.Resolve();        // after the options were read: `options` and `given` are complete
///
/// Tests: tests/tools/identify_test.cc, tests/python/test_options.py.

#include <optional>
#include <string>

#include "identify/stages/staged_run.h"
#include "model/battery/cell_source.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

struct StagedRequest {
  StagedOptions options = {};
  StagedGiven given = {};
  CellSource open_circuit_voltage = {};
  std::optional<int> branches = {};
  bool no_diffusion = false;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("alpha_C", self.given.alpha_C, Range{1e-9, 1e12}, "alpha in coulombs, instead of finding it");
    v("open_circuit_voltage",
      self.open_circuit_voltage,
      Word{"FILE"},
      "v_oc(A), instead of finding it: a CSV with columns soc and voltage_V, or a cell file");
    v("branches", self.branches, Range{0, 5}, "number of resistor-capacitor branches");
    v("no_diffusion",
      self.no_diffusion,
      Names(),
      "hold beta at infinity: the plain equivalent circuit");
    v("fix",
      self.given.parameters.fixed,
      Word{"NAME=VALUE"},
      "hold a parameter at a value: beta, r_s, r_1, c_1, tau_1, ...; the joint method of identify "
      "holds tau_1 instead of c_1, and those of a branch only where branches says how many there are");
    v("start",
      self.given.parameters.start,
      Word{"NAME=VALUE"},
      "value at which the search for a parameter begins; the joint method of identify searches a grid "
      "and takes none");
    v("bounds",
      self.given.parameters.bounds,
      Word{"NAME=LOW,HIGH"},
      "keep a parameter between two bounds; the joint method of identify takes those of beta and of "
      "the time constants");
  }

  /// The options of each stage, by name.
  template <class Visitor>
  void EachGroup(Visitor&& v) {
    v("discharge_times", options.discharge_times);
    v("open_circuit_voltage", options.open_circuit_voltage);
    v("pulses", options.pulses);
  }

  /// Reads the file of v_oc(A) and puts all into `options` and `given`. LoadError as
  /// ReadOpenCircuitVoltageFile().
  void Resolve();
};

}  // namespace lipoid
