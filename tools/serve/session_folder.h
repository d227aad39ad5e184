#pragma once

/// @file
/// A folder for as long as the server runs, in the system's folder of temporary files (TMPDIR). Only
/// its owner may look into it (mode 0700). It is removed at the end; what a killed server left behind
/// is removed by the next one: each holds a lock on a file in its folder, which ends with it. Tests:
/// tests/tools/serve_test.py.

#include <string>

namespace lipoid {

class SessionFolder {
 public:
  /// Makes one in the folder of temporary files. OptionError where it cannot.
  SessionFolder();
  ~SessionFolder();
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

  /// Removes the folders of servers that were killed, and says how many. Only those that are this
  /// user's, are no links, and whose lock nobody holds.
  static int Sweep();

 private:
  std::string path_;
  int lock_ = -1;
};

}  // namespace lipoid
