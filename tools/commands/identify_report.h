#pragma once

/// @file
/// What `lipoid identify` shows to people, and the tables it can add.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/stages/staged_run.h"
#include "model/core/json.h"

namespace lipoid {

/// Stage by stage: what was found, how well, what was done instead, what to know.
[[nodiscard]] std::string IdentifyReport(const Campaign& campaign, const StagedResult& result);

struct TextAndJson {
  std::string text;
  Json json;
};

/// Mean, standard deviation and range of each parameter over several cells.
[[nodiscard]] TextAndJson SpreadOfCells(const std::vector<StagedResult>& results);

/// log,time_s,current_A,voltage_V,fitted_V,residual_V,soc for every row of the logs that stage 3
/// used; `log` counts the logs of the campaign from 1.
void WriteResiduals(const StagedResult& result,
                    const std::vector<LoadedLog>& logs,
                    const std::string& file);

}  // namespace lipoid
