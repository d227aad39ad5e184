#pragma once

/// @file
/// Outputs are written whole or not at all: to a temporary file beside the target, then renamed.
/// Tests: tests/model/core/atomic_file_test.cc.

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// A file that appears under its name at Commit() and not before; a destroyed, uncommitted one
/// leaves nothing behind. Throws OptionError where the folder is missing or cannot be written, the
/// disk is full, or the target is a folder. A target that is not a regular file (a pipe) is written
/// to directly, and so is /dev/stdout, whatever it leads to; behind a link the file it points to is
/// replaced, not the link.
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

/// A folder that is made where it is missing, with those above it, and unmade again unless Keep()
/// was called. Throws OptionError where it cannot be made.
class NewFolder {
 public:
  explicit NewFolder(const std::string& folder);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void Keep();

 private:
  void Unmake();
  std::vector<std::string> made_;  // deepest last
};

/// Removes what is not committed or kept, and lets nobody begin anew: for a program that is being
/// ended.
void RemoveUncommitted() noexcept;

}  // namespace lipoid
