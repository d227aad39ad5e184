#include "tests/support/paths.h"

#include <filesystem>

namespace lipoid::test {

std::string SourcePath(const std::string& relative) {
  return std::string(LIPOID_SOURCE_DIR) + "/" + relative;
}

std::string FlightFixture(const std::string& name) {
  return SourcePath("fixtures/flights/" + name);
}

std::string LabDataPath(const std::string& relative) {
  const std::filesystem::path source(LIPOID_SOURCE_DIR);
  for (const auto& folder : {source / "fixtures" / "lab", source / ".." / "shared" / "data"}) {
    if (std::filesystem::exists(folder / relative))
      return (folder / relative).lexically_normal().string();
  }
  return {};
}

std::string ScratchPath(const std::string& relative) {
  return std::string(LIPOID_BINARY_DIR) + "/scratch/" + relative;
}

std::string ExtraPython() {
  const auto path = SourcePath("build/python-extra/bin/python3");
  return std::filesystem::exists(path) ? path : std::string();
}

std::string FreshFolder(const std::string& name) {
  const std::filesystem::path path = ScratchPath(name);
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path.string();
}

}  // namespace lipoid::test
