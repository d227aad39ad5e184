#pragma once

/// @file
/// --ensemble N, common to the commands that predict: cells drawn from the uncertainty of the one
/// that is given.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "identify/pack_request.h"
#include "model/battery/cell_ensemble.h"
#include "tools/cli/command_line.h"

namespace lipoid {

struct EnsembleOption {
  int count = 0;  ///< 0: none is asked for

  void AddTo(cli::CommandLine& line, std::string_view what_is_shown);
  [[nodiscard]] bool asked() const { return count > 0; }

  /// Cells, each with the state of charge at its start among these surroundings. LoadError, naming the
  /// cell file, where the cell does not say how uncertain it is; OptionError of one cell alone.
  struct Drawn {
    std::vector<Cell> cells;
    std::vector<double> initial_soc;
    Json json;  ///< cells, seed, moved
  };
  [[nodiscard]] Drawn Draw(cli::CommandLine& line,
                           const Cell& cell,
                           const std::string& cell_file,
                           const StartRequest& start,
                           const Surroundings& surroundings = {}) const;
};

}  // namespace lipoid
