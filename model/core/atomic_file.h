#pragma once

/// @file
/// Outputs are written whole or not at all: to a temporary file beside the target, then renamed.
/// Tests: tests/model/core/atomic_file_test.cc.

#include <cstdio>
#include <string>
#include <string_view>

namespace lipoid {

/// A file that appears under its name at Commit() and not before; a destroyed, uncommitted one leaves
/// nothing behind. Throws OptionError where the folder is missing or cannot be written, the disk is full,
/// or the target is a folder. A target that is not a regular file (a pipe) is written to directly, and so is
/// /dev/stdout, whatever it leads to; behind a link the file it points to is replaced, not the link.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(std::string_view bytes);
  void Commit();

 private:
  [[noreturn]] void Fail(std::string_view what);

  std::string path_;
  std::string temporary_;
  std::FILE* file_ = nullptr;
};

/// The whole file at once.
void WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace lipoid
