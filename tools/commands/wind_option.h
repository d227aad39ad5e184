#pragma once

/// @file
/// --wind X[,Y[,Z]].

#include <string>

#include "model/vehicle/wind.h"

namespace lipoid {

/// Reads one to three numbers into the constant wind; nothing where the text is empty. OptionError
/// names the option and the piece that is no number.
void ReadWind(const std::string& option, const std::string& text, WindOptions& wind);

}  // namespace lipoid
