#pragma once

/// @file
/// Members that the Visit of a struct of options (model/core/options.h) may declare beside numbers,
/// names and texts. Each has one form on the command line and one in Python:
///
///   std::vector<double>, with a Range     --pulse-s 10,20:10:60      pulse_s=[10, 20, 30]
///   std::map<std::string, double>         --fix beta=0.2,r_s=0.1     fix={"beta": 0.2, "r_s": 0.1}
///   std::map<std::string, Ends>           --bounds beta=0.1,0.5      bounds={"beta": (0.1, 0.5)}
///   std::map<std::string, std::string>    --columns time_s=Zeit      columns={"time_s": "Zeit"}
///   std::vector<std::string>, with a Word --profile beta,r_s         profile=["beta", "r_s"]
///   InputFile, with a Word                --gains FILE               gains="aware.json"
///
/// They are read by CommandLine::Each() (tools/cli/command_line.h) and Keywords::Each()
/// (python/src/keywords.h), so that name, range, default and words stand once.

#include <string>
#include <string_view>
#include <utility>

namespace lipoid {

/// What stands for the value in help, where no range and no list of names says it: "FILE", "TEXT".
struct Word {
  std::string_view text;
  bool several = false;  ///< whether several words may follow the option
};

/// The low and the high end of an interval.
using Ends = std::pair<double, double>;

/// The path of a file that is read.
struct InputFile {
  std::string path = {};
};

}  // namespace lipoid
