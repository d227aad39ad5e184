#pragma once

/// @file
/// A zip archive in memory, the same bytes for the same files: no times, no names of users.
/// Tests: tests/model/export/zip_archive_test.cc.

#include <string>
#include <vector>

namespace lipoid {

struct ZipEntry {
  std::string name;  ///< with '/' between folders
  std::string content;
};

/// The archive's bytes. std::runtime_error where libzip fails.
[[nodiscard]] std::string ZipArchive(const std::vector<ZipEntry>& entries);

}  // namespace lipoid
