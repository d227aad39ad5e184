#pragma once

/// @file
/// Small text files for tests.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "tests/support/paths.h"

namespace lipoid::test {

/// Writes the text, byte for byte, to a file of that name in a folder of the current test.
inline std::string WriteText(const std::string& name, std::string_view text) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string folder = std::string(test->test_suite_name()) + "." + test->name();
  for (char& c : folder) c = c == '/' ? '_' : c;
  const auto path = std::filesystem::path(LIPOID_BINARY_DIR) / "scratch" / "text" / folder;
  std::filesystem::create_directories(path);
  std::string file = (path / name).string();
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

inline std::string ReadText(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace lipoid::test
