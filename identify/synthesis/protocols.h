#pragma once

/// @file
/// What a lab does to a cell to identify it: the registry of protocols, for logs with a known
/// truth. Tests: tests/identify/synthesis/synthesize_test.cc.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/campaign.h"
#include "model/battery/cell.h"
#include "model/core/options.h"

namespace lipoid {

struct SynthesisOptions {
  /// Constant-current discharges, in multiples of the nominal capacity per hour: "1,2,3". Empty:
  /// 1C, 2C, ... to the highest rate that suits the cell.
  std::string rates_C = {};
  /// The low-rate current empties alpha in so many hours; it is rounded to three digits as a lab
  /// would.
  double low_rate_h = 13.0;
  /// Temperatures of the surroundings: "25,0,-20". The whole protocol runs at the first, its pulses
  /// at the others too. Empty: nobody knows them.
  std::string ambient_degC = {};
  /// 0: the highest rate that suits the cell.
  double pulse_rate_C = 0.0;
  double pulse_s = 30.0;
  double rest_s = 1770.0;
  double sampling_s = 0.01;
  double voltage_noise_V = 0.0;
  double current_noise_A = 0.0;
  double voltage_resolution_V = 0.0;
  Hold hold = Hold::kBackward;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    constexpr double kTiny = 1e-9;
    constexpr double kYear_s = 3.2e7;
    v("rates_C",
      self.rates_C,
      Numbers(),
      "constant-current rates in C, as 1,2,3; empty: 1C, 2C, ... up to what suits the cell");
    v("low_rate_h", self.low_rate_h, Range{0.01, 1e4}, "duration of the low-rate discharge, h");
    v("ambient_degC",
      self.ambient_degC,
      Numbers(),
      "temperatures of the surroundings in degC, as 25,0,-20: the whole protocol runs at the first, "
      "its pulses at the others too; empty: the reference temperature, in no column");
    v("pulse_rate_C",
      self.pulse_rate_C,
      Range{0.0, 1e4},
      "rate of the pulses in C; 0: what suits the cell");
    v("pulse_s", self.pulse_s, Range{kTiny, kYear_s}, "length of a pulse, s");
    v("rest_s", self.rest_s, Range{0.0, kYear_s}, "rest after each pulse, s");
    v("sampling_s",
      self.sampling_s,
      Range{kTiny, 1e6},
      "time between rows, s, with at most nine decimals");
    v("voltage_noise_V",
      self.voltage_noise_V,
      Range{0.0, 1e3},
      "standard deviation of the voltage's noise, V");
    v("current_noise_A",
      self.current_noise_A,
      Range{0.0, 1e6},
      "standard deviation of the current's noise, A");
    v("voltage_resolution_V",
      self.voltage_resolution_V,
      Range{0.0, 1e3},
      "step to which voltages are rounded, V; 0: not rounded");
    v("hold",
      self.hold,
      Names(),
      "whether a row's current holds since the row before or until the next");
  }
};

/// A current of one cell for a while.
struct TestStage {
  double current_A = 0.0;
  double length_s = 0.0;
};

/// One log: a rest row, then the stages over and over until cut-off, or as often as `cycles` says.
struct TestPlan {
  LogKind kind = LogKind::kConstantCurrent;
  std::string file;
  std::vector<TestStage> stages;
  std::optional<double> ambient_degC = {};  ///< none: nobody knows it
  int cycles = 0;                           ///< 0: until cut-off
};

/// The same test at this temperature of the surroundings, under a name that says so.
[[nodiscard]] TestPlan AtAnotherTemperature(TestPlan plan, double ambient_degC);

struct Protocol {
  std::string_view name;
  std::string_view summary;
  std::vector<TestPlan> (*plan)(const Cell& cell, const SynthesisOptions& options);
};

/// Section 4.5.1: constant currents, a low rate, pulses with long rests, 10 ms sampling.
[[nodiscard]] std::vector<TestPlan> ThesisProtocol(const Cell& cell,
                                                   const SynthesisOptions& options);

/// The only list of protocols.
inline constexpr Protocol kProtocols[] = {
    {"thesis",
     "constant currents, a low rate, and pulses with long rests (4.5.1)",
     &ThesisProtocol},
};

/// OptionError that lists the protocols where there is none of that name.
[[nodiscard]] const Protocol& FindProtocol(std::string_view name);

/// The highest whole C-rate, at most 8, at which a full cell drops no more than half a volt at
/// once: 6C for the 600 mAh cells and 8C for the 32 Ah cells of the thesis, as chosen there.
[[nodiscard]] double HighestSuitableRate(const Cell& cell);
/// The same at the coldest of these temperatures.
[[nodiscard]] double HighestSuitableRate(const Cell& cell, const std::vector<double>& ambient_degC);

}  // namespace lipoid
