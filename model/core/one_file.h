#pragma once

/// @file
/// Whether two paths lead to one file, so that nothing is written over what is read.
/// Tests: tests/model/core/one_file_test.cc, tests/tools/nothing_lost_test.cc.

#include <sys/types.h>

#include <span>
#include <string>
#include <string_view>

namespace lipoid {

/// Two paths lead to one place where they compare equal: links and relative paths are followed. A
/// file that is not there yet is its folder and its name, without regard to case, which a disk may
/// ignore.
struct FilePlace {
  dev_t device = 0;
  ino_t file = 0;
  std::string name;

  friend bool operator==(const FilePlace& a, const FilePlace& b);
};

[[nodiscard]] FilePlace PlaceOfFile(const std::string& path);

[[nodiscard]] bool LeadToOneFile(const std::string& a, const std::string& b);

inline constexpr std::string_view kStandardOutput = "/dev/stdout";

/// A file that is written, and what messages call the option that names it.
struct NamedOutput {
  std::string shown;
  std::string path;
};

/// OptionError where an output is one of these inputs, whatever path leads there. An input that is no
/// file, as the name of a shipped cell, is none.
void RefuseInputs(std::span<const NamedOutput> outputs, std::span<const std::string> inputs);

}  // namespace lipoid
