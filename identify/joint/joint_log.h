#pragma once

/// @file
/// The logs as the joint estimator sees them: the points at which voltages are compared, their
/// weights, and which of them are left out together when structures are validated.
///
/// Long stretches of constant current are said in a few points (condensed_log.h), so that ten
/// million rows cost no more than ten thousand. Errors are reported on all rows all the same.
///
/// A row's weight is 1/(voltage_uncertainty_V² + (charge_uncertainty dv_oc/dA)²): where v_oc is
/// steep, a charge that differs by a thousandth between two discharges of the same cell moves the
/// voltage by more than anything that a resistance does. Each log then counts as much as its weight
/// in the campaign says, whatever the number of its rows.
///
/// Every fifth pulse with the rest behind it, and every fifth of sixty pieces of a discharge, are
/// left out together to see how smooth the tables are, for which the near neighbours count. Structures
/// are compared by what is left out in stretches, a fifth of a discharge each: what disturbed a log for
/// minutes is then not learned from the pieces next to it (h-block cross-validation; Burman, Chow and
/// Nolan 1994). Without a log of low rate and a discharge at another current hardly anything shows what
/// a cell is like there, and the pieces serve. Where there are discharges at kWholeCurrents currents each
/// is left out whole, but for its ends: the others still tell how the voltage goes with the current.
/// Errors of what is left out are compared unit by unit (paired_errors.h): a pulse with its rest, or six
/// neighbouring pieces of a discharge.
/// Tests: tests/identify/joint/joint_log_test.cc.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/arrhenius.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/core/special_values.h"

namespace lipoid {

struct JointWeights {
  double charge_uncertainty = 0.002;  ///< of alpha, between logs of one cell
  double voltage_uncertainty_V = 0.001;
};

/// The steps between points are of few kinds: each once, and of every point which one leads to it.
struct JointSteps {
  std::vector<double> length_s;
  std::vector<double> at_K;  ///< temperature half-way, where that makes kinds
  std::vector<std::uint32_t> to;
};

struct JointLog {
  /// Left out never.
  static constexpr int kAlways = -1;

  std::string file;
  LogKind kind = LogKind::kPulses;
  double initial_soc = 1.0;
  double delivered_C = 0.0;  ///< before the first point: alpha (1 - initial_soc)
  /// One entry per point: the current that flowed since the point before, the current at the point,
  /// what was measured there, the number of rows it stands for (0: only a point on the way), their
  /// weight in the sum of squares, the group of pieces and the stretch in which it is left out, and
  /// the unit in which its error is compared then.
  std::vector<double> time_s;
  std::vector<double> step_A;
  std::vector<double> current_A;
  std::vector<double> voltage_V;
  std::vector<double> temperature_K;  ///< of the cell at the point; empty where it is not known
  std::vector<double> count;
  std::vector<double> weight;
  std::vector<int> group;
  std::vector<int> stretch;
  std::vector<int> unit;
  JointSteps steps;       ///< alike where their lengths are
  JointSteps warm_steps;  ///< where their lengths and temperatures are; empty without temperatures
  double log_weight = 1.0;  ///< as the campaign gives it: the sum of all weights, if v_oc were flat
  std::size_t rows = 0;     ///< of the record
  double noise_V = 0.0;     ///< of a row and what its second differences have; 0: cannot be seen
  double scatter_V = 0.0;   ///< of the rows about the points that stand for several of them, rms
  double shortest_s = 0.0;  ///< between two rows
  double longest_s = 0.0;   ///< at one current

  [[nodiscard]] std::size_t size() const { return time_s.size(); }
  /// Temperature of the step to this point, k > 0.
  [[nodiscard]] double HalfWay_K(std::size_t k) const {
    return 0.5 * (temperature_K[k - 1] + temperature_K[k]);
  }
};

/// Different constant currents from which on discharges are left out whole.
inline constexpr int kWholeCurrents = 4;

/// Which points are left out together: those of one number, 0 .. groups - 1, or kAlways.
struct Grouping {
  std::vector<int> JointLog::*of;
  int groups;
};

struct JointLogs {
  std::vector<JointLog> logs;
  int groups = 0;      ///< of pieces that can be left out
  int stretches = 0;   ///< that can be left out
  bool whole = false;  ///< discharges are left out whole
  /// Structures are compared by stretches that are not the pieces: other logs show what is there.
  bool stretched = false;
  [[nodiscard]] Grouping Pieces() const { return {&JointLog::group, groups}; }
  [[nodiscard]] Grouping Stretches() const { return {&JointLog::stretch, stretches}; }
  /// Weight of each unit.
  std::vector<double> unit_weight;
  double weight_sum = 0.0;  ///< over all logs
  double largest_A = 0.0;
  /// Not all loads are of one current, low rates aside: only such logs show how the voltage goes with
  /// the current.
  bool several_currents = false;
  /// Median current of the points under load, low rates aside; 0 where there are none.
  double load_A = 0.0;
  double noise_V = 0.0;       ///< of a row: of one instrument, so the least that any log shows
  double noise_mean_V = 0.0;  ///< weighted mean size of the noise of what can be left out
  /// Coldest and warmest point; NaN where not every log knows its temperature.
  double coldest_K = std::numeric_limits<double>::quiet_NaN();
  double warmest_K = std::numeric_limits<double>::quiet_NaN();
  /// How far apart the temperatures are at which logs begin: those of chambers.
  double start_span_K = 0.0;
  /// How far apart the mean temperatures of two logs of one kind are at most: only such logs show
  /// v_oc at several temperatures and nothing else that differs.
  double like_span_K = 0.0;
  /// Where resistances are known best: 25 degC where pulses (or all logs, where there are none) were
  /// taken on both sides of it or within 5 degC, else the mean of the nearest of them, in whole degC.
  double told_K = kUsual_K;
  double typical_A = 0.0;  ///< root mean square of the currents under load
  /// Between which states of charge a current of a fifth of that or more flowed; infinite where that is
  /// as far as 0.15 from empty, or from full.
  double lowest_loaded_soc = -kInfinity;
  double highest_loaded_soc = kInfinity;
};

/// The points of the logs, which no alpha moves and which have no weight yet: of all but those of
/// kind validation, or of those of one kind only.
[[nodiscard]] JointLogs MakeJointPoints(const std::vector<LoadedLog>& logs,
                                        std::optional<LogKind> only = {});
/// Weighs the points, again for another alpha, by the slope of `curve` at 1 - charge/alpha.
void Weigh(JointLogs& logs,
           double alpha_C,
           const OpenCircuitVoltage& curve,
           const JointWeights& weights);

/// Both.
[[nodiscard]] JointLogs MakeJointLogs(const std::vector<LoadedLog>& logs,
                                      double alpha_C,
                                      const OpenCircuitVoltage& curve,
                                      const JointWeights& weights,
                                      std::optional<LogKind> only = {});

/// The points of logs that differ from these in their temperatures alone. The range of temperatures and where resistances are
/// told stay those of `logs`.
[[nodiscard]] JointLogs AtTemperaturesOf(const std::vector<LoadedLog>& loaded, JointLogs logs);

/// Whether charge went out and in at low rate: only such logs can disagree by what a sensor adds.
[[nodiscard]] bool BothWays(const JointLogs& logs);

}  // namespace lipoid
