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
                                           const StartRequest& start,
                                           const Surroundings& surroundings) const {
  if (count == 1) {
    throw OptionError(
        "option --ensemble: expected at least 2 cells, found 1, which has no interval; 200 place its "
        "ends well, and 0 draws none");
  }
  if (!cell.uncertainty) {
    throw LoadError({cell_file},
                    "expected the key 'uncertainty' for --ensemble, found none: identify the cell "
                    "again with this version of lipoid, or leave --ensemble out");
  }
  CellEnsemble ensemble = DrawCells(cell, count, line.seed());
  Drawn drawn;
  for (const Cell& one : ensemble.cells)
    drawn.initial_soc.push_back(start.SocOfDrawn(one, surroundings));
  drawn.cells = std::move(ensemble.cells);
  drawn.json = {{"cells", count}, {"seed", line.seed()}, {"moved", ensemble.moved}};
  const auto moved = static_cast<std::size_t>(ensemble.moved);
  if (const auto doubt = DoubtAboutMoved(moved, drawn.cells.size()); !doubt.empty())
    line.Message("{}", doubt);
  if (const auto doubt = DoubtAboutFew(drawn.cells.size(), "cells"); !doubt.empty())
    line.Message("{}", doubt);
  return drawn;
}

}  // namespace lipoid
