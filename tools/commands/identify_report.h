#pragma once

/// @file
/// What `lipoid identify` shows to people, and the tables it can add.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "identify/identification.h"
#include "identify/logs/load_campaign.h"
#include "identify/stages/staged_run.h"
#include "model/battery/cell_comparison.h"
#include "model/core/json.h"

namespace lipoid {

/// Stage by stage: what was found, how well, what was done instead, what to know.
[[nodiscard]] std::string IdentifyReport(const StagedResult& result, bool verbose);

/// How the cell predicts logs: one table each, nothing where there are none.
[[nodiscard]] std::string ValidationText(const std::vector<LogErrors>& logs);
[[nodiscard]] std::string ConstantCurrentText(const std::vector<ConstantCurrentErrors>& logs);

/// Truth against estimate.
[[nodiscard]] std::string TruthTable(const CellComparison& comparison);

struct TextAndJson {
  std::string text;
  Json json;
};

/// Mean, standard deviation and range of each parameter over several cells, and of their errors.
[[nodiscard]] TextAndJson SpreadOfCells(const std::vector<Cell>& cells,
                                        const std::string& error_name,
                                        const std::vector<double>& errors_percent);

/// log,time_s,current_A,voltage_V,fitted_V,residual_V,soc for every row of the logs that were fitted, with
/// the current as it was measured; `log` counts the logs of the campaign from 1.
void WriteResiduals(const Identification& found,
                    const std::vector<LoadedLog>& logs,
                    const std::string& file);

}  // namespace lipoid
