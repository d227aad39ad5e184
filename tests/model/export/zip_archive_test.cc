#include "model/export/zip_archive.h"

#include <gtest/gtest.h>

#include <fstream>

#include "model/core/atomic_file.h"
#include "tests/support/export_cases.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

TEST(ZipArchive, IsReadBackByPythonWithoutTimes) {
  std::string every_byte;
  for (int k = 0; k < 70000; ++k) every_byte += static_cast<char>(k * 7919 >> 3);
  const auto bytes =
      ZipArchive({{"a/text.txt", "hello\n"}, {"a/b/every.bin", every_byte}, {"e", ""}});
  EXPECT_EQ(bytes,
            ZipArchive({{"a/text.txt", "hello\n"}, {"a/b/every.bin", every_byte}, {"e", ""}}));
  const auto folder = test::FreshFolder("zip");
  WriteFileAtomically(folder + "/x.zip", bytes);
  std::string output;
  ASSERT_EQ(test::RunCommand("cd " + folder +
                                 " && python3 -c 'import zipfile; z = zipfile.ZipFile(\"x.zip\"); "
                                 "assert z.testzip() is None; z.extractall(); "
                                 "print(*[i.filename for i in z.infolist()], "
                                 "{i.date_time for i in z.infolist()})'",
                             output),
            0)
      << output;
  EXPECT_EQ(output, "a/text.txt a/b/every.bin e {(1980, 1, 1, 0, 0, 0)}\n");
  std::ifstream in(folder + "/a/b/every.bin", std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), every_byte);
}

}  // namespace
}  // namespace lipoid
