#pragma once

/// @file
/// Where a log starts, common to the commands that predict: --initial-soc or --initial-voltage-V.

#include <optional>

#include "model/battery/cell.h"
#include "tools/cli/command_line.h"

namespace lipoid {

struct StartOptions {
  std::optional<double> initial_soc;
  std::optional<double> initial_voltage_V;

  void AddTo(cli::CommandLine& line);
  /// The state of charge of the first row; 1 where nothing was said. OptionError where both were,
  /// or where the cell never rests at that voltage.
  [[nodiscard]] double Soc(const Cell& cell) const;
  /// The same of a cell drawn from one for which Soc() was right: where its v_oc ends before the
  /// voltage, the end.
  [[nodiscard]] double SocOfDrawn(const Cell& cell) const;
};

}  // namespace lipoid
