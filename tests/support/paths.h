#pragma once

/// @file
/// Where tests find files: the project's own, the lab logs beside the project, and a folder to
/// write to.

#include <filesystem>
#include <string>

namespace lipoid::test {

/// A file of the project, "fixtures/cells/x.json".
inline std::string SourcePath(const std::string& relative) {
  return std::string(LIPOID_SOURCE_DIR) + "/" + relative;
}

/// A real lab log beside the project, or "" where that folder is absent: then skip and say so.
inline std::string LabDataPath(const std::string& relative) {
  const auto path = std::filesystem::path(LIPOID_SOURCE_DIR) / ".." / "shared" / "data" / relative;
  return std::filesystem::exists(path) ? path.lexically_normal().string() : std::string();
}

/// An empty folder for one test, made anew at each call.
inline std::string FreshFolder(const std::string& name) {
  const auto path = std::filesystem::path(LIPOID_BINARY_DIR) / "scratch" / name;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path.string();
}

}  // namespace lipoid::test

/// Skips a test, and says so, where the real lab logs are absent.
#define LIPOID_SKIP_WITHOUT(path) \
  if ((path).empty())             \
  GTEST_SKIP() << "skipped: the real lab logs (../shared/data) are not beside the project"
