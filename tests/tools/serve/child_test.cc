#include "tools/serve/child.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>
#include <vector>

#include "tests/support/run_lipoid.h"

namespace lipoid {
namespace {

using Clock = std::chrono::steady_clock;

// A shell stands for lipoid: what it does with its progress and its signals is written here.
ChildPlan Shell(const std::string& folder, const std::string& script) {
  return {.program = "/bin/sh",
          .arguments = {"-c", script},
          .folder = folder,
          .output_file = folder + "/out",
          .message_file = folder + "/err"};
}

std::string Text(const std::string& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

const ChildProgress kNone = [](double, std::string_view) {};

TEST(RunChild, TellsHowItEnded) {
  const auto folder = test::TestFolder();
  const auto end = RunChild(Shell(folder, "pwd; echo bad >&2; exit 3"), {}, kNone);
  EXPECT_EQ(end.exit_code, 3);
  EXPECT_EQ(end.signal, 0);
  EXPECT_FALSE(end.stopped);
  EXPECT_EQ(Text(folder + "/out"), folder + "\n");
  EXPECT_EQ(Text(folder + "/err"), "bad\n");
  EXPECT_EQ(RunChild(Shell(folder, "kill -SEGV $$"), {}, kNone).signal, SIGSEGV);
}

TEST(RunChild, SaysWhereItCannotBeStarted) {
  const auto folder = test::TestFolder();
  ChildPlan plan = Shell(folder, "");
  plan.program = folder + "/nothing";
  EXPECT_THROW((void)RunChild(plan, {}, kNone), std::system_error);
}

TEST(RunChild, HearsOfProgress) {
  const auto folder = test::TestFolder();
  std::vector<std::pair<double, std::string>> heard;
  const auto end = RunChild(
      Shell(folder,
            "echo '0.25 reading logs' >&$LIPOID_PROGRESS_FD\n"
            "printf '0.' >&3; printf '5 fitting\\nno number\\n2 too much\\n' >&3\n"
            "printf '1' >&3; echo >&3"),
      {},
      [&](double fraction, std::string_view doing) { heard.emplace_back(fraction, doing); });
  EXPECT_EQ(end.exit_code, 0);
  const std::vector<std::pair<double, std::string>> expected = {
      {0.25, "reading logs"}, {0.5, "fitting"}, {1.0, ""}};
  EXPECT_EQ(heard, expected);
}

TEST(RunChild, LipoidSaysItsProgress) {
  const auto folder = test::TestFolder();
  ChildPlan plan = Shell(folder, "");
  double last = 0.0;
  std::string what;
  const auto run = test::RunShell(folder, "printf %s \"$LIPOID\"");  // where the built one is
  ASSERT_EQ(run.exit_code, 0);
  plan.program = run.out;
  plan.arguments = {"fly", "hover", "--cell", "gifi-600mAh-1", "--duration", "20", "-o", "f.csv"};
  const auto end = RunChild(plan, {}, [&](double fraction, std::string_view doing) {
    EXPECT_GE(fraction, last);
    last = fraction;
    what = doing;
  });
  EXPECT_EQ(end.exit_code, 0) << Text(plan.message_file);
  EXPECT_EQ(what, "flying");
}

TEST(RunChild, AStopEndsAllThatItStarted) {
  const auto folder = test::TestFolder();
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stop.request_stop();
  });
  const auto began = Clock::now();
  // The grandchild would go on writing.
  const auto end = RunChild(Shell(folder, "(while sleep 0.05; do date >> beats; done) & sleep 60"),
                            stop.get_token(),
                            kNone);
  EXPECT_TRUE(end.stopped);
  EXPECT_EQ(end.signal, SIGTERM);
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(4));
  const std::string beats = Text(folder + "/beats");
  EXPECT_FALSE(beats.empty());
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(Text(folder + "/beats"), beats);
}

TEST(RunChild, WhatDoesNotListenIsKilled) {
  const auto folder = test::TestFolder();
  std::stop_source stop;
  stop.request_stop();
  const auto end = RunChild(
      Shell(folder, "trap '' TERM; while true; do sleep 1; done"), stop.get_token(), kNone);
  EXPECT_TRUE(end.stopped);
  // The stop may come before the trap is set.
  EXPECT_TRUE(end.signal == SIGKILL || end.signal == SIGTERM);
}

TEST(RunChild, InheritsNothingThatIsOpen) {
  const auto folder = test::TestFolder();
  std::ifstream open("/etc/passwd");
  (void)RunChild(Shell(folder, "ls /proc/self/fd"), {}, kNone);
  // Standard ones, the pipe of progress, and what ls itself opens.
  EXPECT_EQ(Text(folder + "/out"), "0\n1\n2\n3\n4\n");
}

}  // namespace
}  // namespace lipoid
