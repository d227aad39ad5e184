#include "model/core/atomic_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

std::size_t FileCount(const std::string& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string OptionErrorOf(const std::string& path) {
  try {
    WriteFileAtomically(path, "text");
  } catch (const OptionError& error) {
    return error.what();
  }
  return "no error";
}

TEST(AtomicFile, AppearsAtCommitAndNotBefore) {
  const auto folder = test::FreshFolder("AtomicFile.Appears");
  AtomicFile file(folder + "/a.txt");
  file.Write("one ");
  file.Write("two");
  EXPECT_FALSE(fs::exists(folder + "/a.txt"));
  file.Commit();
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "one two");
  EXPECT_EQ(FileCount(folder), 1U);
}

TEST(AtomicFile, WithoutCommitTheOldFileStaysAndNothingIsLeft) {
  const auto folder = test::FreshFolder("AtomicFile.Without");
  WriteFileAtomically(folder + "/a.txt", "old");
  { AtomicFile(folder + "/a.txt").Write("new"); }
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "old");
  EXPECT_EQ(FileCount(folder), 1U);
}

TEST(AtomicFile, ReplacesTheOldFileAsAWholeAndKeepsEveryByte) {
  const auto folder = test::FreshFolder("AtomicFile.Replaces");
  WriteFileAtomically(folder + "/a.txt", std::string(100'000, 'x'));
  const std::string bytes("a\0b\r\n\xFF", 6);
  WriteFileAtomically(folder + "/a.txt", bytes);
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), bytes);
}

TEST(AtomicFile, ALinkStaysALink) {
  const auto folder = test::FreshFolder("AtomicFile.Link");
  WriteFileAtomically(folder + "/real.txt", "old");
  fs::create_symlink("real.txt", folder + "/link.txt");
  WriteFileAtomically(folder + "/link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder + "/link.txt"));
  EXPECT_EQ(ReadTextFile(folder + "/real.txt"), "new");
}

TEST(AtomicFile, SaysWhyItCannotBeWritten) {
  const auto folder = test::FreshFolder("AtomicFile.Why");
  EXPECT_EQ(OptionErrorOf(folder + "/none/a.txt"),
            "cannot write '" + folder + "/none/a.txt': No such file or directory");
  EXPECT_EQ(OptionErrorOf(folder), "cannot write '" + folder + "': expected the name of a file");
  EXPECT_EQ(OptionErrorOf(""), "cannot write '': expected the name of a file");
  EXPECT_EQ(OptionErrorOf("/dev/full"), "cannot write '/dev/full': No space left on device");
}

}  // namespace
}  // namespace lipoid
