#include "tests/support/text_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/paths.h"

namespace lipoid::test {

void Write(const std::string& file, std::string_view text) { std::ofstream(file) << text; }

std::string WriteText(const std::string& name, std::string_view text) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string folder = std::string(test->test_suite_name()) + "." + test->name();
  for (char& c : folder) c = c == '/' ? '_' : c;
  const std::filesystem::path path = ScratchPath("text/" + folder);
  std::filesystem::create_directories(path);
  std::string file = (path / name).string();
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

std::string ReadText(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string OnOneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  return line;
}

std::string DocsExample(const std::string& document, const std::string& first_line) {
  const std::string text = ReadText(SourcePath(document));
  std::string example;
  for (auto at = text.find("\n    " + first_line); at != std::string::npos;) {
    const auto end = text.find('\n', at + 1);
    const std::string line = text.substr(at + 1, end - at - 1);
    if (!line.empty() && line.rfind("    ", 0) != 0) break;
    example += (line.empty() ? line : line.substr(4)) + "\n";
    at = end;
  }
  EXPECT_FALSE(example.empty()) << document << ": no example '" << first_line << "'";
  return example;
}

}  // namespace lipoid::test
