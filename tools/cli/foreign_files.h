#pragma once

/// @file
/// Files that a command writes though nobody named them, beside -o or in the folder of -o: one that is there
/// already is replaced only where lipoid wrote it. Tests: tests/tools/nothing_lost_test.cc.

#include <string>
#include <vector>

#include "tools/cli/command_line.h"

namespace lipoid::cli {

/// Whether the file begins with the comment of an export.
[[nodiscard]] bool IsExportOfLipoid(const std::string& file);

/// OptionError where one of these, which lipoid did not write and the command would, is there and not
/// empty.
void RefuseToReplace(const CommandLine& line, const std::vector<std::string>& files);

}  // namespace lipoid::cli
