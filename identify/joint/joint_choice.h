#pragma once

/// @file
/// How many nodes, how many branches, which terms: chosen by what they say of held-out rows.
///
/// The way goes from simple to rich. A richer structure is taken where it predicts better by kGain,
/// or where it predicts better at all and fits better by kBetterFit; so that neither noise nor a
/// single odd piece of a log decides. Where the simple one fits as well as the noise lets it,
/// nothing is. How sure the choice is stands beside it (paired_errors.h), and counts in the
/// intervals (structure_spread.h). Tests: tests/identify/joint/joint_choice_test.cc.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/joint/leave_out.h"
#include "identify/trust/paired_errors.h"
#include "model/core/options.h"

namespace lipoid {

/// A branch of less than this share of r_s was not found.
inline constexpr double kNotFound = 1e-3;

enum class Presence { kAuto, kOn, kOff };
constexpr std::array<std::pair<Presence, std::string_view>, 3> OptionNames(Presence) {
  return {{{Presence::kAuto, "auto"}, {Presence::kOn, "on"}, {Presence::kOff, "off"}}};
}

struct JointOptions {
  int branches = -1;
  int most_branches = 2;
  int resistance_nodes = 0;
  int voltage_nodes = 0;
  Presence self_heating = Presence::kAuto;
  Presence charge_transfer = Presence::kAuto;
  Presence temperature = Presence::kAuto;
  Presence entropy = Presence::kAuto;
  Presence hysteresis = Presence::kAuto;
  Presence current_offset = Presence::kAuto;
  double smoothness = 0.0;
  double charge_uncertainty = 0.002;
  double voltage_uncertainty_V = 0.001;
  int iterations_per_variable = kPolishIterationsPerVariable;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("branches",
      self.branches,
      Range{-1.0, 5.0},
      "number of resistor-capacitor branches; -1: automatic");
    v("most_branches",
      self.most_branches,
      Range{0.0, 5.0},
      "largest number of branches that is tried where their number is automatic; one more where "
      "temperature takes part");
    v("resistance_nodes",
      self.resistance_nodes,
      Range{0.0, 100.0},
      "number of nodes of every resistance over the state of charge; 0: automatic; 1: constant");
    v("voltage_nodes",
      self.voltage_nodes,
      Range{0.0, 1000.0},
      "number of nodes of v_oc(A); 0: automatic");
    v("self_heating",
      self.self_heating,
      Names{},
      "whether the series resistance falls as the current heats the cell (a low pass of i²)");
    v("charge_transfer",
      self.charge_transfer,
      Names{},
      "whether a charge-transfer drop that grows as asinh(i/i_0) is added");
    v("temperature",
      self.temperature,
      Names{},
      "whether resistances and diffusion change with the temperature of the logs by Arrhenius' law; "
      "on: also where the temperatures of the logs are within 10 degC");
    v("entropy",
      self.entropy,
      Names{},
      "whether v_oc changes with the temperature, where temperature takes part");
    v("hysteresis",
      self.hysteresis,
      Names{},
      "whether v_oc is higher after charging than after discharging; tried where a log charges the "
      "cell by 5 % of its capacity");
    v("current_offset",
      self.current_offset,
      Names{},
      "whether the current sensor of all logs has an offset; tried where there is a log of kind "
      "low-rate and one of kind low-rate-charge");
    v("smoothness",
      self.smoothness,
      Range{0.0, 1e3},
      "weight of the tables' second differences; 0: automatic");
    v("charge_uncertainty",
      self.charge_uncertainty,
      Range{0.0, 1.0},
      "share of alpha by which the charge of repeated discharges differs; rows where v_oc is steep "
      "weigh less by it");
    v("voltage_uncertainty_V",
      self.voltage_uncertainty_V,
      Range{1e-9, 1e3},
      "standard error of a voltage that no parameter can explain, V, added to that by "
      "charge_uncertainty");
    v("iterations_per_variable",
      self.iterations_per_variable,
      Range{0.0, 1e6},
      "largest number of evaluations of the final search, per nonlinear parameter (beta, tau_j, "
      "i_0)");
  }
};

/// A row of the table of what was tried.
struct TriedStructure {
  std::string what;  ///< "13 nodes, 2 branches, self-heating"
  JointSolution solution = {};
  LeftOutErrors errors = {};
  /// Against what was taken when this was tried.
  PairedGain gain = {.standard_error = std::numeric_limits<double>::quiet_NaN()};
  /// Share in the spread of the parameters over structures that are nearly as good: in proportion
  /// to the probability that this one predicts better than the one taken, whose own is a half.
  double weight = 0.0;
  bool taken = false;
};

/// Where nothing is known better.
inline constexpr double kTypicalSmoothness = 1e-3;

/// Of a fit that is within the noise of a row: the data decide alone.
inline constexpr double kNoSmoothness = 1e-6;

struct JointChoice {
  JointSolution best;
  LeftOutErrors errors;
  std::vector<TriedStructure> tried;
  std::size_t taken = 0;        ///< of these
  double shortest_tau_s = 0.0;  ///< from which on time constants were searched
  double longest_tau_s = 0.0;   ///< and up to which
  /// The best structure with a node more between any two of every table, refitted: what straight
  /// lines and smoothness do to the parameters shows in the difference. Empty where there are no
  /// tables.
  JointSolution finer;
  /// The best structure refitted to logs that warmed half as much, where their warming was assumed
  /// (predicted_temperature.h).
  JointSolution half_as_warm;
  std::string reason;  ///< where nothing could be compared, or what decided is an extrapolation
};

/// All of it must outlive the choice.
struct ChoiceTask {
  const JointFit& fit;
  const JointLogs& logs;
  std::vector<double> voltage_soc;  ///< nodes of v_oc; none where the curve is given
  double lowest_soc = 0.0;          ///< where the charge of the logs ends
  const JointOptions& options;
  /// The charge from which logs that do not start full are counted is searched, too.
  bool free_alpha = false;
  /// Of the search for alpha, near which the first structure is looked for if it is like it.
  const JointSolution* near = nullptr;
  std::function<void(double)> progress = {};  ///< gets the share done
};

/// Whether a richer structure predicts left-out rows so much better that it is taken (docs/joint.md, 4).
[[nodiscard]] bool IsAskedFor(const LeftOutErrors& rich,
                              const LeftOutErrors& simple,
                              const JointLogs& logs);

/// A choice, not yet finished. Of one made `before`, by a fit whose time constants had a lower limit,
/// what that limit did not touch is not searched again.
[[nodiscard]] JointChoice ChooseStructure(const ChoiceTask& task,
                                          const JointChoice* before = nullptr);
/// The best structure is polished; how sure the choice is, and the finer structure, are found.
[[nodiscard]] JointChoice FinishChoice(const ChoiceTask& task, JointChoice choice);

/// Nodes over the state of charge, denser where cells bend: `count` of them as nearly as the ladder
/// has it.
[[nodiscard]] std::vector<double> ResistanceNodes(int count);
[[nodiscard]] std::vector<double> VoltageNodes(int count);
[[nodiscard]] std::vector<double> EntropyNodes();
/// Nodes for [0, 1], stretched to [lowest_soc, 1] where that is another range: they shall lie where
/// the logs went, whatever alpha makes of it.
[[nodiscard]] std::vector<double> OnAxis(std::vector<double> nodes, double lowest_soc);

/// A curve at nodes, made to rise: what the bounds of the fit start from.
[[nodiscard]] OpenCircuitVoltage AtNodes(const OpenCircuitVoltage& curve,
                                         const std::vector<double>& soc);

}  // namespace lipoid
