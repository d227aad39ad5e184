#pragma once

/// @file
/// What flights say of a cell of which no lab log is there: v_oc(A) over the range that was flown,
/// the total resistance, and one fast branch. Not more: of one current profile that never rests long,
/// diffusion and slow branches are not to be told from the curve, nor the capacity from the scale of
/// the current sensor. The state of charge is counted from where each log is said to start, by the
/// capacity that is given. Of several flights that begin at rest not every one has to say where it starts: its voltage then shows it, on
/// the curve of the others.
///
/// The rows are those of flight_samples.h: averaged over windows, with the lag of the voltage put
/// back. The fit is the joint one (identify/joint/joint_fit.h) with its structure held. Tests:
/// tests/identify/health/flights_alone_test.cc.

#include <string>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/joint/joint_log.h"
#include "identify/logs/load_campaign.h"
#include "identify/trust/trust.h"
#include "identify/validation.h"

namespace lipoid {

struct FlightsAlone {
  struct Flight {
    std::string file;
    double initial_soc = 1.0;
    bool start_found = false;  ///< by the voltage at rest, on the curve of the other flights
    double lag_s = 0.0;
    double window_s = 0.0;
    double coherence = 0.0;
    LogErrors errors;  ///< of the averaged rows
  };

  Cell cell;
  bool converged = false;
  TrustReport trust;
  std::vector<Flight> flights;
  double lowest_soc = 0.0;  ///< of the range that was flown, as counted
  double highest_soc = 1.0;
  double total_resistance_Ohm = 0.0;
  /// Of what the errors are: "of means over 3.2 s, with the lag of the voltage put back".
  [[nodiscard]] std::string Averaged() const;
  std::vector<std::string> doubts;  ///< why the pack that was given is none of these flights
  std::vector<std::string> cautions;
  JointLogs logs;  ///< as the fit saw them
  JointSetup setup;
  JointSolution solution;
};

/// Cut-off of a cell of which the campaign tells none.
inline constexpr double kUsualCutoff_V = 3.0;

/// Logs of kind flight, each of one cell; campaign.capacity_Ah > 0. LoadError for logs that are too
/// short or too idle.
[[nodiscard]] FlightsAlone IdentifyFlightsAlone(const Campaign& campaign,
                                                const std::vector<LoadedLog>& logs);

}  // namespace lipoid
