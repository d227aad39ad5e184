#pragma once

/// @file
/// Outputs are written whole or not at all: to a temporary file beside the target, then renamed.
/// Several files appear together:
///
///   FileSet files;
///   WriteCellFile(cell, "cell.json");    // is complete on the disk, under another name
///   WriteFileAtomically("s.json", text);
///   files.Commit();                      // now both are there, or an exception and neither
///
/// Tests: tests/model/core/atomic_file_test.cc.

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// A file that appears under its name at Commit() and not before; a destroyed, uncommitted one
/// leaves nothing behind. Throws OptionError where the folder is missing or cannot be written, the
/// disk is full, or the target is a folder or may not be written.
///
/// A file that is replaced keeps its mode and, where that is allowed, its owner. Behind a link the
/// file is replaced that it points to, there or not yet, and not the link. Of a file with several
/// hard links only this name gets the new file. A target that is not a regular file (a pipe) is
/// written to directly, and so are /dev/stdout and /dev/fd/N, whatever they lead to; a reader of a
/// pipe who leaves early had enough, and what is written after that goes nowhere.
///
/// The temporary is hidden (".lipoid-....tmp"), and its name is free. What a killed program left
/// behind is in nobody's way, and goes when the next one on this machine writes into the folder.
class AtomicFile {
 public:
  /// Mode and owner are those of `model`, where it is a file; not given: of the file replaced.
  explicit AtomicFile(std::string path, const std::string& model = "");
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(std::string_view bytes);
  /// Where a FileSet is there, the file waits for it.
  void Commit();

 private:
  void Open(const std::string& model);
  [[noreturn]] void Fail(std::string_view what);

  std::string path_;    // as given, for messages
  std::string target_;  // behind links
  std::string temporary_;
  std::FILE* file_ = nullptr;
  bool has_other_names_ = false;
  bool reader_left_ = false;
};

/// The whole file at once.
void WriteFileAtomically(const std::string& path, std::string_view bytes);

/// While one is there, files and folders that are committed wait for its Commit(), from all
/// threads; destroyed, it removes those that wait. One that begins within another hands over to
/// that.
class FileSet {
 public:
  FileSet();
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// All of those that wait appear under their names. OptionError where one cannot: then all names
  /// lead to what they led to before. May be called again.
  void Commit();

  /// What Commit() replaced under one name of several (hard links): the others keep the old file.
  [[nodiscard]] const std::vector<std::string>& replaced_one_name_of() const {
    return one_name_of_;
  }

 private:
  friend class AtomicFile;
  friend class NewFolder;
  struct Waiting {
    std::string temporary;
    std::string target;
    std::string path;
    bool has_other_names = false;
  };
  static void Publish(const std::vector<Waiting>& files);

  FileSet* outer_;
  std::vector<Waiting> files_;
  std::vector<std::string> folders_;
  std::vector<std::string> one_name_of_;
};

/// Where a chain of links ends, whether something is there or not.
[[nodiscard]] std::string BehindLinks(const std::string& path);

/// A copy of the file beside it, with its mode, under the first free name (campaign.1.toml,
/// campaign.2.toml), which is returned. OptionError where it cannot be written, LoadError where the
/// file cannot be read.
[[nodiscard]] std::string KeepCopy(const std::string& path);

/// A folder that is made where it is missing, with those above it, and unmade again unless Keep()
/// was called. Throws OptionError where it cannot be made.
class NewFolder {
 public:
  explicit NewFolder(const std::string& folder);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// Where a FileSet is there, it stays when that is committed.
  void Keep();

 private:
  std::vector<std::string> made_;  // deepest last
};

/// Removes what is not committed or kept, and lets nobody begin anew: for a program that is being
/// ended.
void RemoveUncommitted() noexcept;

}  // namespace lipoid
