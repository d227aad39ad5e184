#include "model/core/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

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

unsigned Mode(const std::string& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0) << file;
  return status.st_mode & 07777U;
}

TEST(AtomicFile, ALinkToNothingYetIsFollowed) {
  const auto folder = test::FreshFolder("AtomicFile.Dangling");
  fs::create_directory(folder + "/there");
  fs::create_symlink("there/second", folder + "/first");
  fs::create_symlink("real.txt", folder + "/there/second");
  WriteFileAtomically(folder + "/first", "new");
  EXPECT_TRUE(fs::is_symlink(folder + "/first"));
  EXPECT_TRUE(fs::is_symlink(folder + "/there/second"));
  EXPECT_EQ(ReadTextFile(folder + "/there/real.txt"), "new");
}

TEST(AtomicFile, KeepsTheModeOfTheFileItReplacesAndTheMaskOfANewOne) {
  const auto folder = test::FreshFolder("AtomicFile.Mode");
  for (const unsigned mode : {0600U, 0640U, 0755U, 0664U}) {
    const auto file = folder + "/a.txt";
    WriteFileAtomically(file, "old");
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
    WriteFileAtomically(file, "new");
    EXPECT_EQ(Mode(file), mode);
    EXPECT_EQ(ReadTextFile(file), "new");
  }
  const mode_t before = ::umask(027);
  WriteFileAtomically(folder + "/b.txt", "new");
  ::umask(before);
  EXPECT_EQ(Mode(folder + "/b.txt"), 0640U);
}

TEST(AtomicFile, KeepsTheOwnerWhereThatIsAllowed) {
  if (::geteuid() != 0) GTEST_SKIP() << "skipped: only root gives files away";
  const auto folder = test::FreshFolder("AtomicFile.Owner");
  const auto file = folder + "/a.txt";
  WriteFileAtomically(file, "old");
  constexpr uid_t kSomeone = 4711;
  ASSERT_EQ(::chown(file.c_str(), kSomeone, kSomeone), 0);
  WriteFileAtomically(file, "new");
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, kSomeone);
  EXPECT_EQ(status.st_gid, kSomeone);
}

TEST(AtomicFile, OfSeveralNamesOnlyTheOneGivenGetsTheNewFile) {
  const auto folder = test::FreshFolder("AtomicFile.HardLinks");
  WriteFileAtomically(folder + "/a.txt", "old");
  fs::create_hard_link(folder + "/a.txt", folder + "/b.txt");
  WriteFileAtomically(folder + "/c.txt", "old");
  FileSet set;
  WriteFileAtomically(folder + "/a.txt", "new");
  WriteFileAtomically(folder + "/c.txt", "new");
  set.Commit();
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "new");
  EXPECT_EQ(ReadTextFile(folder + "/b.txt"), "old");
  EXPECT_EQ(set.replaced_one_name_of(), std::vector<std::string>{folder + "/a.txt"});
}

TEST(AtomicFile, WritesWhateverTheNameThatADiskTakes) {
  const auto folder = test::FreshFolder("AtomicFile.LongName");
  for (const std::size_t length : {std::size_t{245}, std::size_t{255}}) {
    const auto file = folder + "/" + std::string(length, 'x');
    WriteFileAtomically(file, "new");
    EXPECT_EQ(ReadTextFile(file), "new");
  }
  const auto file = folder + "/" + std::string(256, 'x');
  EXPECT_EQ(OptionErrorOf(file), "cannot write '" + file + "': File name too long");
}

TEST(AtomicFile, HasNoNameWhereNoneIsNeeded) {
  const auto folder = test::FreshFolder("AtomicFile.Nameless");
  const int possible = ::open(folder.c_str(), O_WRONLY | O_TMPFILE, 0600);
  if (possible < 0) GTEST_SKIP() << "this file system has no files without a name";
  ::close(possible);
  AtomicFile file(folder + "/a.txt");
  file.Write("half");
  EXPECT_EQ(FileCount(folder), 0U);
  file.Write(" and half");
  file.Commit();
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "half and half");
}

// As kill -9 leaves them: in the way of nobody, whatever their process was called.
TEST(AtomicFile, TemporariesLeftBehindDoNotBlock) {
  const auto folder = test::FreshFolder("AtomicFile.LeftBehind");
  const auto file = folder + "/a.txt";
  std::ofstream(file + "." + std::to_string(::getpid()) + ".tmp") << "left";
  {
    AtomicFile open(file);
    WriteFileAtomically(file, "meanwhile");
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      EXPECT_TRUE(name[0] == '.' || name.starts_with("a.txt")) << name;
    }
    open.Write("last");
    open.Commit();
  }
  EXPECT_EQ(ReadTextFile(file), "last");
  EXPECT_EQ(FileCount(folder), 2U);
}

TEST(AtomicFile, WhatAKilledProgramLeftGoesWithTheNextThatWritesThere) {
  const auto folder = test::FreshFolder("AtomicFile.Killed");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    // More files wait than there may be without a name: the others have hidden ones.
    FileSet files;
    for (int k = 0; k < 70; ++k) WriteFileAtomically(folder + "/" + std::to_string(k), "x");
    (void)::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const std::size_t left = FileCount(folder);
  ASSERT_GE(left, 6U);
  // The same names, but of a process that runs, of another machine, and of nobody.
  const std::string one = fs::directory_iterator(folder)->path().filename().string();
  const std::string dead = "-" + std::to_string(child) + "-";
  ASSERT_NE(one.find(dead), std::string::npos) << one;
  std::string runs = one;
  runs.replace(one.find(dead), dead.size(), "-" + std::to_string(::getpid()) + "-");
  std::string elsewhere = one;
  elsewhere[8] = one[8] == '0' ? '1' : '0';
  for (const std::string& name : {runs, elsewhere, std::string(".lipoid-mine.tmp")})
    std::ofstream(folder + "/" + name) << "kept";
  WriteFileAtomically(folder + "/a.txt", "new");
  EXPECT_EQ(FileCount(folder), 4U);
  for (const std::string& name : {runs, elsewhere, std::string(".lipoid-mine.tmp")})
    EXPECT_EQ(ReadTextFile(folder + "/" + name), "kept");
}

TEST(AtomicFile, AReaderOfAPipeWhoLeavesEarlyHadEnough) {
  const auto folder = test::FreshFolder("AtomicFile.Pipe");
  const auto pipe = folder + "/pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::FILE* const reader = std::fopen(pipe.c_str(), "r+");
  ASSERT_NE(reader, nullptr);
  AtomicFile file(pipe);
  std::fclose(reader);
  EXPECT_NO_THROW(file.Write(std::string(1'000'000, 'x')));
  EXPECT_NO_THROW(file.Write("more"));
  EXPECT_NO_THROW(file.Commit());
  std::signal(SIGPIPE, before);
}

TEST(FileSet, AllAppearTogetherAtItsCommit) {
  const auto folder = test::FreshFolder("FileSet.Together");
  WriteFileAtomically(folder + "/a.txt", "old");
  FileSet set;
  WriteFileAtomically(folder + "/a.txt", "new a");
  {
    FileSet inner;
    NewFolder made(folder + "/sub");
    WriteFileAtomically(folder + "/sub/b.txt", "new b");
    inner.Commit();
    made.Keep();
  }
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "old");
  EXPECT_FALSE(fs::exists(folder + "/sub/b.txt"));
  set.Commit();
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "new a");
  EXPECT_EQ(ReadTextFile(folder + "/sub/b.txt"), "new b");
  EXPECT_EQ(FileCount(folder), 2U);
  EXPECT_EQ(FileCount(folder + "/sub"), 1U);
}

TEST(FileSet, DestroyedItLeavesWhatWasThere) {
  const auto folder = test::FreshFolder("FileSet.Destroyed");
  WriteFileAtomically(folder + "/a.txt", "old");
  {
    FileSet set;
    NewFolder made(folder + "/sub");
    WriteFileAtomically(folder + "/a.txt", "new");
    WriteFileAtomically(folder + "/sub/b.txt", "new");
    made.Keep();
  }
  EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "old");
  EXPECT_EQ(FileCount(folder), 1U);
}

// The third name becomes a folder while the files wait: the first two go back.
TEST(FileSet, WhereOneCannotAppearTheOldOnesAreBack) {
  const auto folder = test::FreshFolder("FileSet.Back");
  WriteFileAtomically(folder + "/a.txt", "old");
  {
    FileSet set;
    for (const char* const name : {"/a.txt", "/b.txt", "/c.txt", "/d.txt"})
      WriteFileAtomically(folder + name, "new");
    fs::create_directories(folder + "/c.txt/sub");
    EXPECT_EQ(test::MessageOf<OptionError>([&] { set.Commit(); }),
              "cannot write '" + folder + "/c.txt': Is a directory");
    EXPECT_EQ(ReadTextFile(folder + "/a.txt"), "old");
    EXPECT_FALSE(fs::exists(folder + "/b.txt"));
  }
  EXPECT_EQ(FileCount(folder), 2U);
}

TEST(KeepCopy, TakesTheFirstFreeNameAndTheMode) {
  const auto folder = test::FreshFolder("KeepCopy.Name");
  const auto file = folder + "/campaign.toml";
  WriteFileAtomically(file, "first");
  ::chmod(file.c_str(), 0600);
  EXPECT_EQ(KeepCopy(file), folder + "/campaign.1.toml");
  WriteFileAtomically(file, "second");
  EXPECT_EQ(KeepCopy(file), folder + "/campaign.2.toml");
  EXPECT_EQ(ReadTextFile(folder + "/campaign.1.toml"), "first");
  EXPECT_EQ(ReadTextFile(folder + "/campaign.2.toml"), "second");
  EXPECT_EQ(Mode(folder + "/campaign.2.toml"), 0600U);
}

TEST(AtomicFile, SaysWhyItCannotBeWritten) {
  const auto folder = test::FreshFolder("AtomicFile.Why");
  EXPECT_EQ(
      OptionErrorOf(folder + "/none/a.txt"),
      "cannot write '" + folder + "/none/a.txt': No such file or directory; make its folder first");
  EXPECT_EQ(OptionErrorOf(folder), "cannot write '" + folder + "': expected the name of a file");
  EXPECT_EQ(OptionErrorOf(""), "cannot write '': expected the name of a file");
  fs::create_symlink("loop", folder + "/loop");
  EXPECT_EQ(OptionErrorOf(folder + "/loop"),
            "cannot write '" + folder + "/loop': Too many levels of symbolic links");
  EXPECT_EQ(OptionErrorOf("/dev/full"), "cannot write '/dev/full': No space left on device");
}

}  // namespace
}  // namespace lipoid
