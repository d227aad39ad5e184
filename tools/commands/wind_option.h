#pragma once

/// @file
/// --wind X[,Y[,Z]] and --gusts.

#include <string>

#include "model/vehicle/wind.h"
#include "tools/cli/command_line.h"

namespace lipoid {

struct WindOption {
  std::string text;

  /// The gusts are read into `wind`.
  void AddTo(cli::CommandLine& line, WindOptions& wind, const std::string& directions);
  /// Reads one to three numbers into the constant wind; nothing where the text is empty. OptionError
  /// names the piece that is no number.
  void ReadInto(WindOptions& wind) const;
};

}  // namespace lipoid
