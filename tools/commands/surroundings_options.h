#pragma once

/// @file
/// How warm a cell is in a prediction, common to the commands that predict: --ambient-degC and
/// --predict-temperature.

#include <optional>

#include "identify/logs/record.h"
#include "model/battery/prediction.h"
#include "tools/cli/command_line.h"

namespace lipoid {

struct SurroundingsOptions {
  std::optional<double> ambient_degC;
  bool predict = false;

  void AddTo(cli::CommandLine& line);
  /// Of a record, which must outlive what is returned.
  [[nodiscard]] Surroundings Of(const Record& record) const;
  /// A message where something is asked of a cell that knows no temperature.
  void TellWhatSaysNothing(cli::CommandLine& line, const Cell& cell) const;
};

}  // namespace lipoid
