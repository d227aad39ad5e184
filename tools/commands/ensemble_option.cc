#include "tools/commands/ensemble_option.h"

#include "model/core/errors.h"
#include "model/statistics/interval_95.h"

namespace lipoid {

void EnsembleOption::AddTo(cli::CommandLine& line, std::string_view what_is_shown) {
  line.Option(
      "ensemble",
      count,
      Range{0, 100000},
      fmt::format("draw so many cells from the uncertainty in the cell file and show {}; 0: none",
                  what_is_shown));
}

EnsembleOption::Drawn EnsembleOption::Draw(cli::CommandLine& line,
                                           const Cell& cell,
                                           const std::string& cell_file,
                                           const StartRequest& start) const {
  if (!cell.uncertainty) {
    throw LoadError({cell_file},
                    "expected the key 'uncertainty' for --ensemble, found none: identify the cell "
                    "again with this version of lipoid, or leave --ensemble out");
  }
  CellEnsemble ensemble = DrawCells(cell, count, line.seed());
  Drawn drawn;
  for (const Cell& one : ensemble.cells) drawn.initial_soc.push_back(start.SocOfDrawn(one));
  drawn.cells = std::move(ensemble.cells);
  drawn.json = {{"cells", count}, {"seed", line.seed()}, {"moved", ensemble.moved}};
  if (count < static_cast<int>(kLeastForQuantiles)) {
    line.Message(
        "of {} cells the interval is that from the lowest to the highest: quantiles take {}",
        count,
        kLeastForQuantiles);
  }
  return drawn;
}

}  // namespace lipoid
