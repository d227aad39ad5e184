#pragma once

/// @file
/// Runs the built `lipoid` as a user would.

#include <string>
#include <vector>

#include "model/core/json.h"

namespace lipoid::test {

struct RunResult {
  int exit_code = -1;  ///< 128 + signal where one ended it, as a shell says
  std::string out;
  std::string err;
};

/// A folder of its own for the current test, empty; `lipoid` runs in it.
[[nodiscard]] std::string TestFolder();

/// A log of four rows.
inline constexpr const char* kFourRowLog =
    "time_s,current_A,voltage_V\n0,0,4.1\n1,1,4.0\n2,1,3.9\n3,0,4.0\n";

/// `lipoid arguments...` in the folder, with standard input closed.
[[nodiscard]] RunResult RunLipoid(const std::string& folder,
                                  const std::vector<std::string>& arguments);

/// A shell command in the folder; $LIPOID is the program.
[[nodiscard]] RunResult RunShell(const std::string& folder, const std::string& command);

/// A JSON file in the folder.
[[nodiscard]] Json ReadJson(const std::string& folder, const std::string& file);

/// Writes flown.json into the folder: a shipped cell whose v_oc is known over a part of the charge, as
/// flights alone leave it, and which knows no diffusion.
void WriteFlownCell(const std::string& folder,
                    const std::vector<double>& soc,
                    const std::vector<double>& voltage_V);

/// The names in a folder, sorted.
[[nodiscard]] std::vector<std::string> FilesIn(const std::string& folder);

}  // namespace lipoid::test
