#pragma once

/// @file
/// The files of one run of a command: which it reads, and which it writes. Nothing is lost: an
/// output that is the same file as an input or as another output, whatever path leads there, is
/// refused before anything is touched, and outputs appear together or not at all (FileSet in
/// model/core/atomic_file.h). Tests: tests/tools/nothing_lost_test.cc.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "model/core/atomic_file.h"
#include "model/core/json.h"
#include "model/core/one_file.h"

namespace lipoid::cli {

class RunFiles {
 public:
  /// Files that are read. Those that are not there are no inputs.
  void AddInput(const std::string& path) { inputs_.push_back(path); }
  /// A file that is written, for the option shown ("-o"); `path` as OutputPath() returns it.
  void AddOutput(std::string_view shown, const std::string& path) {
    outputs_.push_back({std::string(shown), path});
  }
  [[nodiscard]] const std::vector<std::string>& inputs() const { return inputs_; }

  /// Several of them that show only while the command runs, checked at once: OptionError where one is
  /// an input or another output, or cannot be written. A folder that is not there may be made later.
  void AddOutputs(std::string_view shown, const std::vector<std::string>& paths);

  /// Whether one of the files that are written is standard output.
  [[nodiscard]] bool WriteToStandardOutput() const;
  /// OptionError where an output is an input or another output.
  void CheckNothingIsLost() const;
  /// OptionError where an input is none of those that the run record of a summary names.
  void CheckInputsOf(const Json& summary) const;
  /// OptionError where an output cannot be written. Leaves no trace.
  void CheckOutputsAreWritable() const;

  /// SHA-256 of inputs that somebody knows anyway, in their order: they are not read again.
  void AddHashes(const std::vector<std::string>& files, const std::vector<std::string>& sha256);
  /// The inputs that are files, each once, with their SHA-256: `inputs` of a run record.
  [[nodiscard]] Json InputsToJson() const;

  /// What was written so far appears. Returns the names that were one of several of their file
  /// (hard links): the others keep the old file.
  [[nodiscard]] std::vector<std::string> Commit();

 private:
  std::vector<std::string> inputs_;
  std::vector<NamedOutput> outputs_;
  std::map<std::string, std::string> sha256_;
  FileSet written_;
};

/// OptionError unless the file can be written: its folder is there and takes files. Leaves no
/// trace.
void CheckWritable(const std::string& file);

/// "-" means standard output, and so do the names that it has as descriptor 1.
[[nodiscard]] std::string OutputPath(const std::string& text);

}  // namespace lipoid::cli
