#pragma once

/// @file
/// What a whole campaign at several temperatures would tell of a cell: the standard errors of the
/// joint fit (identify/joint/joint_trust.h) of logs that are simulated, at the truth, under noise that
/// is assumed. v_oc(A), alpha and every table are unknown, as they are there; the structure is taken
/// as known. Heat capacity and thermal resistance as they follow from the thermometer
/// (identify/joint/heat_fit.h).
///
/// Where the temperatures lie within kLeastSpan_K the joint fit knows no temperature: then activation
/// energies and the heat balance are not identifiable, and the other quantities are those at the
/// temperature of the logs. docs/verdicts.md, "Before the lab is booked".
/// Tests: tests/identify/trust/campaign_plan_test.cc.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/trust/experiment_plan.h"

namespace lipoid {

/// The logs that these tests would give of a cell that knows temperature, without noise. Each plan
/// has its ambient temperature.
[[nodiscard]] std::vector<LoadedLog> PlannedLogs(const Cell& cell,
                                                 const std::vector<TestPlan>& plans,
                                                 const DecimalStep& sampling);

/// All tests one after the other. OptionError where they do not suit the cell.
[[nodiscard]] PlannedExperiment PlanCampaign(const Cell& cell,
                                             const std::vector<TestPlan>& plans,
                                             const DecimalStep& sampling,
                                             const PlannedNoise& noise);

/// Whether this is the name of what only several temperatures tell: an activation energy, or a number
/// of the heat balance.
[[nodiscard]] bool OfTemperature(const std::string& name);

/// What of a cell that knows temperature such a plan leaves out, in words.
[[nodiscard]] std::vector<std::string> LeftOutOfCampaign(const Cell& cell, double sampling_s);

}  // namespace lipoid
