// Nothing is lost: no output replaces an input, what fails leaves what was there, and a file that
// is replaced stays whose it was.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

namespace fs = std::filesystem;

// A campaign of three logs in logs/, a cell, gains, and links to a log.
std::string FolderOfInputs() {
  const auto folder = TestFolder();
  fs::create_directories(folder + "/logs");
  for (const char* const log : {"cc", "low", "pulses"})
    Write(folder + "/logs/" + log + ".csv", kFourRowLog);
  Write(folder + "/c.toml",
        "[cell]\ncutoff_V = 3.0\n"
        "[[log]]\nkind = \"constant-current\"\nfile = \"logs/cc.csv\"\n"
        "[[log]]\nkind = \"low-rate\"\nfile = \"logs/low.csv\"\n"
        "[[log]]\nkind = \"pulses\"\nfile = \"logs/pulses.csv\"\n");
  fs::copy_file(SourcePath("fixtures/cells/gifi-600mAh-1.json"), folder + "/cell.json");
  fs::permissions(folder + "/cell.json", fs::perms::owner_write, fs::perm_options::add);
  Write(folder + "/gains.json", "{}");
  Write(folder + "/frame.parm", "{}");
  Write(folder + "/places.toml", "[[waypoint]]\n");
  fs::create_directories(folder + "/code");
  for (const char* const name : {"lipoid_controller.c", "lipoid_example.c", "lipoid_numbers.h"})
    Write(folder + "/code/" + name, "{}");
  fs::create_symlink("logs/pulses.csv", folder + "/link.csv");
  fs::create_hard_link(folder + "/logs/pulses.csv", folder + "/second-name.csv");
  fs::create_directory_symlink("logs", folder + "/linked");
  return folder;
}

// Every file below a folder with its bytes and when it was written.
std::map<std::string, std::pair<std::string, fs::file_time_type>> Contents(
    const std::string& folder) {
  std::map<std::string, std::pair<std::string, fs::file_time_type>> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && !entry.is_symlink()) {
      all[entry.path().string()] = {ReadTextFile(entry.path().string()), entry.last_write_time()};
    } else {
      all[entry.path().string()] = {};
    }
  }
  return all;
}

TEST(NothingLost, NoOutputReplacesAnInputWhicheverOptionNamesIt) {
  const auto folder = FolderOfInputs();
  const std::string there = folder + "/logs/pulses.csv";
  const std::vector<std::vector<std::string>> all = {
      {"identify", "c.toml", "-o", "c.toml"},
      {"identify", "c.toml", "-o", "./logs/../c.toml"},
      {"identify", "c.toml", "-o", "logs/cc.csv"},
      {"identify", "c.toml", "-o", "new.json", "--residuals", "logs/pulses.csv"},
      {"identify", "c.toml", "-o", "new.json", "--residuals", there},
      {"identify", "c.toml", "-o", "new.json", "--residuals", "link.csv"},
      {"identify", "c.toml", "-o", "new.json", "--residuals", "second-name.csv"},
      {"identify", "c.toml", "-o", "new.json", "--summary", "linked/low.csv"},
      {"identify", "c.toml", "-o", "new.json", "--truth", "cell.json", "--summary", "cell.json"},
      {"identify", "c.toml", "-o", "cell.json", "--truth", "cell.json"},
      {"identify", "c.toml", "-o", "cell.json", "--open-circuit-voltage", "cell.json"},
      {"identify", "--pulses", "logs/pulses.csv", "-o", "link.csv"},
      {"identify",
       "--constant-current",
       "logs/cc.csv",
       "--low-rate",
       "logs/low.csv",
       "--cutoff-V",
       "3",
       "-o",
       "new.json",
       "--summary",
       "logs/low.csv"},
      {"compare", "c.toml", "--csv", "logs/pulses.csv"},
      {"compare", "c.toml", "--summary", "c.toml"},
      {"compare", "c.toml", "--latex", "logs/cc.csv"},
      {"study", "branches", "c.toml", "--latex", "c.toml"},
      {"identify", "c.toml", "-o", "new.json", "--latex", "logs/low.csv"},
      {"validate", "cell.json", "logs/pulses.csv", "--latex", "cell.json"},
      {"study", "branches", "c.toml", "--csv", "linked/pulses.csv"},
      {"study", "branches", "c.toml", "--open-circuit-voltage", "cell.json", "--csv", "cell.json"},
      {"export", "cell.json", "--to", "px4", "-o", "cell.json"},
      {"export", "cell.json", "--to", "px4", "--mission", "logs/cc.csv", "-o", "linked/cc.csv"},
      {"export", "cell.json", "--to", "px4", "--mission", "link.csv", "-o", "logs/pulses.csv"},
      {"export", "cell.json", "--to", "ardupilot", "--into", "gains.json", "-o", "gains.json"},
      {"export", "cell.json", "--to", "ardupilot", "--into", "frame.parm", "-o", "frame.json"},
      {"export", "cell.json", "--to", "px4", "-o", "new.params", "--summary", "cell.json"},
      {"fly", "hover", "--cell", "cell.json", "-o", "cell.json"},
      {"fly", "hover", "--gains", "gains.json", "-o", "gains.json"},
      {"fly", "hover", "--cell", "cell.json", "--report", "cell.json"},
      {"fly", "waypoints", "--waypoints", "places.toml", "-o", "places.toml"},
      {"export-controller", "--gains", "code/lipoid_numbers.h", "-o", "code"},
      {"export-controller", "--vehicle", "code/lipoid_controller.c", "-o", "./code"},
      {"export-controller", "--cell", "code/lipoid_example.c", "-o", "code/"},
      {"export-controller", "--gains", "gains.json", "-o", "code", "--summary", "gains.json"},
      {"sitl", "--cell", "cell.json", "--idle-s", "0.1", "--summary", "cell.json"},
      {"sitl", "--vehicle", "places.toml", "--idle-s", "0.1", "--summary", "places.toml"},
      {"design", "altitude", "--start", "gains.json", "-o", "gains.json"},
      {"poles", "altitude", "--gains", "gains.json", "-o", "gains.json"},
      {"validate", "cell.json", "logs/pulses.csv", "--summary", "logs/pulses.csv"},
      {"validate", "cell.json", "logs/pulses.csv", "--summary", "cell.json"},
      {"validate", "cell.json", "logs/pulses.csv", "--summary=link.csv"},
      {"vehicle", "--bench-table", "logs/cc.csv", "-o", "logs/cc.csv"},
      {"vehicle", "--bench-table", "logs/cc.csv", "-o", "v.toml", "--summary", "logs/cc.csv"},
      {"simulate", "cell.json", "--current", "logs/cc.csv", "-o", "linked/cc.csv"},
      {"convert", "logs/cc.csv", "-o", "logs/cc.csv"},
      {"import", "gains.json", "-o", "gains.json"},
      {"import", "link.csv", "-o", "logs/pulses.csv"},
      {"import", "gains.json", "-o", "new.json", "--summary", "gains.json"},
      {"plan", "cell.json", "--summary", "cell.json"},
      {"plan", "cell.json", "--report", "cell.json"},
      {"poles", "altitude", "--gains", "gains.json", "--report", "gains.json"},
      {"design", "altitude", "--start", "gains.json", "--report", "gains.json"},
      {"compare", "c.toml", "--report", "logs/cc.csv"},
      {"study", "branches", "c.toml", "--report", "link.csv"},
      {"report", "gains.json", "-o", "gains.json"},
      {"inspect", "logs", "--write-campaign", "logs/cc.csv"},
      {"inspect", "logs", "--summary", "link.csv"},
  };
  const auto before = Contents(folder);
  for (const auto& arguments : all) {
    const auto run = RunLipoid(folder, arguments);
    std::string typed;
    for (const auto& word : arguments) typed += word + " ";
    SCOPED_TRACE(typed);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find("is also an input; name another file"), std::string::npos) << run.err;
    EXPECT_EQ(run.out, "");
    ASSERT_EQ(Contents(folder), before);
  }
}

TEST(NothingLost, TwoOutputsAreTwoFiles) {
  const auto folder = FolderOfInputs();
  fs::create_symlink("new.json", folder + "/to-new.json");
  const std::vector<std::vector<std::string>> all = {
      {"identify", "c.toml", "-o", "new.json", "--residuals", "new.json"},
      {"identify", "c.toml", "-o", "new.json", "--summary", "logs/../new.json"},
      {"identify", "c.toml", "-o", "new.json", "--summary", "to-new.json"},
      {"identify", "c.toml", "-o", "new.json", "--summary", "NEW.json"},  // one file on many disks
      {"convert", "logs/cc.csv", "-o", "new.csv", "--summary", "linked/../new.csv"},
      {"inspect", "logs", "--write-campaign", "new.toml", "--summary", "new.toml"},
      {"export-controller", "-o", "code", "--summary", "code/lipoid_numbers.h"},
  };
  const auto before = Contents(folder);
  for (const auto& arguments : all) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments.back();
    EXPECT_NE(run.err.find("is named twice; name two files"), std::string::npos) << run.err;
    ASSERT_EQ(Contents(folder), before) << arguments.back();
  }
  // The second file of this target would have the name of the first.
  const auto second =
      RunLipoid(folder, {"export", "cell.json", "--to", "ardupilot", "-o", "new.parm"});
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("the first file of ardupilot is its .json; give new.json"),
            std::string::npos)
      << second.err;
  EXPECT_EQ(Contents(folder), before);
}

TEST(NothingLost, FilesInAFolderOfOutputsAreOutputs) {
  const auto folder = TestFolder();
  const std::vector<std::string> synthesize{"synthesize",
                                            "gifi-600mAh-1",
                                            "--sampling-s",
                                            "10",
                                            "--pulse-s",
                                            "30",
                                            "--quiet",
                                            "-o",
                                            "logs"};
  ASSERT_EQ(RunLipoid(folder, synthesize).exit_code, 0);
  const auto before = Contents(folder);
  const auto over =
      RunLipoid(folder, {"synthesize", "logs/truth.json", "--sampling-s", "10", "-o", "logs"});
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_NE(over.err.find("option -o: 'logs/truth.json' is also an input"), std::string::npos)
      << over.err;
  EXPECT_EQ(Contents(folder), before);

  // The cell of the campaign goes to cells/c.cell.json, which is its v_oc too.
  fs::create_directories(folder + "/cells");
  fs::copy_file(folder + "/logs/truth.json", folder + "/cells/logs.cell.json");
  const auto curve = RunLipoid(folder,
                               {"identify",
                                "logs/campaign.toml",
                                "-o",
                                "cells",
                                "--open-circuit-voltage",
                                "cells/logs.cell.json"});
  EXPECT_EQ(curve.exit_code, 2);
  EXPECT_NE(curve.err.find("option -o: 'cells/logs.cell.json' is also an input"), std::string::npos)
      << curve.err;
  EXPECT_EQ(ReadTextFile(folder + "/cells/logs.cell.json"),
            ReadTextFile(folder + "/logs/truth.json"));
}

TEST(NothingLost, WhatTheShellMadeOfStandardOutputIsAnOutput) {
  const auto folder = FolderOfInputs();
  const auto before = Contents(folder);
  const auto run = RunShell(folder, "\"$LIPOID\" convert logs/cc.csv -o - >>logs/cc.csv");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("standard output is 'logs/cc.csv', which is also an input"),
            std::string::npos)
      << run.err;
  EXPECT_EQ(Contents(folder), before);
}

// A file that is opened takes the first free number: no message is written into it.
TEST(NothingLost, MessagesAreNotWrittenIntoAFileWhereTheStandardStreamsAreClosed) {
  const auto folder = FolderOfInputs();
  const std::string convert = "\"$LIPOID\" convert logs/cc.csv -o ";
  ASSERT_EQ(RunShell(folder, convert + "whole.csv").exit_code, 0);
  for (const char* const closed : {" >&-", " 2>&-", " >&- 2>&-", " <&- >&- 2>&-"}) {
    ASSERT_EQ(RunShell(folder, convert + "c.csv" + closed).exit_code, 0) << closed;
    EXPECT_EQ(ReadTextFile(folder + "/c.csv"), ReadTextFile(folder + "/whole.csv")) << closed;
  }
}

// Whatever else is wrong, and before the inputs are known: only what is a summary is replaced by
// one.
TEST(NothingLost, TheSummaryOfAFailedCommandReplacesNoInput) {
  const auto folder = FolderOfInputs();
  Write(folder + "/broken.toml",
        "[[log]]\nkind = \"pulses\"\nfile = \"logs/pulses.csv\"\nkind = 1\n");
  const std::vector<std::vector<std::string>> all = {
      {"validate",
       "cell.json",
       "logs/pulses.csv",
       "--no-such-option",
       "--summary",
       "logs/pulses.csv"},
      {"validate", "cell.json", "logs/pulses.csv", "--initial-soc", "x", "--summary", "link.csv"},
      {"validate", "cell.json", "logs/pulses.csv", "--summary", "link.csv", "--help"},
      {"validate", "--summary", "logs/pulses.csv"},
      {"valdate", "cell.json", "--summary", "logs/pulses.csv"},
      {"identify", "broken.toml", "-o", "new.json", "--summary", "logs/pulses.csv"},
      {"identify", "none.toml", "-o", "new.json", "--summary", "gains.json"},
  };
  const auto before = Contents(folder);
  for (const auto& arguments : all) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_TRUE(run.exit_code == 2 || run.exit_code == 3 || arguments.back() == "--help")
        << arguments[1] << run.err;
    ASSERT_EQ(Contents(folder), before) << arguments[1] << run.err;
  }
  // A summary is replaced by that of a later failure, and so is an empty file.
  Write(folder + "/s.json", "");
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(
        RunLipoid(folder, {"validate", "cell.json", "none.csv", "--summary", "s.json"}).exit_code,
        3);
    EXPECT_EQ(ReadJson(folder, "s.json").at("exit_code"), 3);
  }
}

TEST(NothingLost, AFileThatIsReplacedKeepsItsModeItsLinkAndTheOthersTheirFile) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", kFourRowLog);
  const std::vector<std::string> convert{
      "convert", "log.csv", "--current-sign", "discharge-positive", "-o"};
  const auto convert_to = [&](const std::string& file) {
    auto arguments = convert;
    arguments.push_back(file);
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  };
  Write(folder + "/mine.csv", "old");
  ASSERT_EQ(::chmod((folder + "/mine.csv").c_str(), 0600), 0);
  fs::create_symlink("mine.csv", folder + "/link.csv");
  EXPECT_EQ(convert_to("link.csv").find("hard links"), std::string::npos);
  EXPECT_TRUE(fs::is_symlink(folder + "/link.csv"));
  EXPECT_NE(ReadTextFile(folder + "/mine.csv"), "old");
  struct stat status {};
  ASSERT_EQ(::stat((folder + "/mine.csv").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);

  Write(folder + "/one.csv", "old");
  fs::create_hard_link(folder + "/one.csv", folder + "/two.csv");
  EXPECT_NE(convert_to("one.csv").find("'one.csv' had other names (hard links): they keep the old "
                                       "file, this name has the new one"),
            std::string::npos);
  EXPECT_EQ(ReadTextFile(folder + "/two.csv"), "old");
}

TEST(NothingLost, NamesOfAnyLengthThatADiskTakesAreWritten) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", kFourRowLog);
  for (const std::size_t length : {std::size_t{245}, std::size_t{255}}) {
    const std::string name = std::string(length - 4, 'x') + ".csv";
    EXPECT_EQ(RunLipoid(folder,
                        {"convert", "log.csv", "--current-sign", "discharge-positive", "-o", name})
                  .exit_code,
              0);
    EXPECT_TRUE(fs::exists(folder + "/" + name));
  }
}

TEST(NothingLost, SeveralFilesAppearTogetherOrNotAtAll) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", kFourRowLog);
  Write(folder + "/out.csv", "old");
  const std::vector<std::string> arguments{"convert",
                                           "log.csv",
                                           "--current-sign",
                                           "discharge-positive",
                                           "-o",
                                           "out.csv",
                                           "--summary",
                                           "/dev/full"};
  const auto run = RunLipoid(folder, arguments);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("cannot write '/dev/full': No space left on device"), std::string::npos)
      << run.err;
  EXPECT_EQ(ReadTextFile(folder + "/out.csv"), "old");
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"log.csv", "out.csv"}));
  EXPECT_EQ(
      RunLipoid(folder, {"export-controller", "-o", "code", "--summary", "/dev/full"}).exit_code,
      2);
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"log.csv", "out.csv"}));
}

TEST(NothingLost, SignalsAndLimitsLeaveNothingHalf) {
  const auto folder = TestFolder();
  for (const std::string signal : {"INT", "TERM", "HUP", "QUIT", "XCPU"}) {
    const auto run = RunShell(
        folder,
        "ulimit -c 0; timeout --signal=" + signal +
            " 0.4 \"$LIPOID\" fly hover --battery ideal --duration 1e5 --log-step-s 0.005 -o f.csv");
    EXPECT_NE(run.exit_code, 0) << signal;
    EXPECT_EQ(FilesIn(folder), std::vector<std::string>{}) << signal;
  }
  // At most 1 MiB to a file.
  const auto large = RunShell(
      folder, "ulimit -f 1024; \"$LIPOID\" fly hover --duration 60 --log-step-s 0.005 -o f.csv");
  EXPECT_EQ(large.exit_code, 2);
  EXPECT_NE(large.err.find("cannot write 'f.csv': File too large"), std::string::npos) << large.err;
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{});
}

TEST(NothingLost, KilledItLeavesWhatBlocksNoLaterRunAndIsNoLog) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", kFourRowLog);
  const auto killed = RunShell(
      folder,
      "timeout --signal=KILL 0.5 \"$LIPOID\" fly hover --battery ideal --duration 1e5 --log-step-s 0.005 -o f.csv");
  EXPECT_EQ(killed.exit_code, 137);
  // Nothing is left, or a hidden file where the file system has none without a name.
  const auto left = FilesIn(folder);
  ASSERT_LE(left.size(), 2U);
  EXPECT_EQ(left.back(), "log.csv");
  if (left.size() == 2) {
    EXPECT_EQ(left[0][0], '.');
  }
  EXPECT_EQ(RunLipoid(folder, {"fly", "hover", "--duration", "1", "-o", "f.csv"}).exit_code, 0);
  const auto inspected = RunLipoid(
      folder, {"inspect", ".", "--current-sign", "discharge-positive", "--summary", "../s.json"});
  EXPECT_EQ(inspected.out.find("lipoid-"), std::string::npos) << inspected.out;
  EXPECT_EQ(inspected.out.find(".tmp"), std::string::npos) << inspected.out;
}

TEST(NothingLost, AReaderWhoLeavesEarlyIsNoErrorWhereverTheDataGo) {
  const auto folder = TestFolder();
  std::string log = kFourRowLog;
  for (int k = 4; k < 100'000; ++k) log += std::to_string(k) + ",0,4.0\n";
  Write(folder + "/log.csv", log);
  for (const std::string output : {"/dev/stdout", "-", "out.csv", "/dev/fd/1"}) {
    (void)RunShell(
        folder,
        "{ sleep 0.2; \"$LIPOID\" convert log.csv --current-sign discharge-positive -o " + output +
            "; echo $? >code; } | true");
    EXPECT_EQ(ReadTextFile(folder + "/code"), "0\n") << output;
  }
}

TEST(NothingLost, StandardOutputIsTheSameByAllOfItsNames) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", kFourRowLog);
  const auto converted = [&](const std::string& output) {
    const auto run = RunShell(folder,
                              "\"$LIPOID\" convert log.csv --current-sign discharge-positive -o " +
                                  output + " >taken.csv");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ReadTextFile(folder + "/taken.csv");
  };
  const std::string expected = converted("-");
  EXPECT_NE(expected, "");
  for (const std::string output : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"})
    EXPECT_EQ(converted(output), expected) << output;
}

TEST(NothingLost, WhatIsPrintedDoesNotMixWithAFileOnStandardOutput) {
  const auto folder = TestFolder();
  const std::vector<std::string> poles{"poles", "altitude", "--xi", "0.9"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), poles.begin(), poles.end());
    return RunLipoid(folder, more);
  };
  const auto printed = RunLipoid(folder, poles);
  ASSERT_EQ(with({"-o", "rows.csv"}).out, printed.out);
  const auto run = with({"-o", "-"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, ReadTextFile(folder + "/rows.csv"));
  EXPECT_NE(run.err.find(printed.out), std::string::npos) << run.err;
  EXPECT_EQ(with({"-o", "-", "--quiet"}).err, "");
  EXPECT_EQ(Json::parse(with({"--summary", "/dev/stdout"}).out).at("command"), "poles");
  EXPECT_EQ(with({"-o", "-", "--help"}).err, "");
  const auto twice = with({"-o", "-", "--summary", "/dev/fd/1"});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.err.find("--output and --summary: '/dev/stdout' is named twice; name two files"),
            std::string::npos)
      << twice.err;
}

TEST(NothingLost, ADraftKeepsTheCampaignThatWasThere) {
  const auto folder = TestFolder();
  ASSERT_EQ(
      RunLipoid(folder,
                {"synthesize", "gifi-600mAh-1", "--sampling-s", "10", "-o", "logs", "--quiet"})
          .exit_code,
      0);
  const std::vector<std::string> draft{"inspect", "logs", "--write-campaign", "logs/drafted.toml"};
  ASSERT_EQ(RunLipoid(folder, draft).exit_code, 0);
  const std::string drafted = ReadTextFile(folder + "/logs/drafted.toml");
  const auto again = RunLipoid(folder, draft);  // nothing changed: nothing to keep
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(again.err.find("kept as"), std::string::npos) << again.err;
  EXPECT_FALSE(fs::exists(folder + "/logs/drafted.1.toml"));

  Write(folder + "/logs/drafted.toml", drafted + "# by hand\n");
  const auto kept = RunLipoid(folder, draft);
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_NE(kept.err.find("logs/drafted.toml held another campaign, perhaps edited: it is kept as "
                          "logs/drafted.1.toml"),
            std::string::npos)
      << kept.err;
  EXPECT_EQ(ReadTextFile(folder + "/logs/drafted.1.toml"), drafted + "# by hand\n");
  EXPECT_EQ(ReadTextFile(folder + "/logs/drafted.toml"), drafted);
}

// What nobody named, and a person wrote, stays. What lipoid wrote there before is replaced.
TEST(NothingLost, FilesThatNobodyNamedAreReplacedOnlyWhereLipoidWroteThem) {
  struct Writes {
    std::vector<std::string> arguments;  // before -o
    std::string output;
    std::string unnamed;
  };
  const Writes all[] = {
      {{"export", "gifi-600mAh-1", "--to", "ardupilot"}, "frame.json", "frame.parm"},
      {{"export", "gifi-600mAh-1", "--to", "c"}, "pack.h", "pack.c"},
      {{"synthesize", "gifi-600mAh-1", "--sampling-s", "10"}, "logs", "logs/campaign.toml"},
      {{"synthesize", "gifi-600mAh-1", "--sampling-s", "10"}, "logs", "logs/pulses.csv"},
      {{"export-controller"}, "code", "code/lipoid_example.c"}};
  for (const Writes& writes : all) {
    SCOPED_TRACE(writes.unnamed);
    const auto folder = TestFolder();
    std::vector<std::string> arguments = writes.arguments;
    arguments.insert(arguments.end(), {"-o", writes.output});
    const std::string file = folder + "/" + writes.unnamed;
    fs::create_directories(fs::path(file).parent_path());
    Write(file, "by hand\n");
    const auto refused = RunLipoid(folder, arguments);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find(
                  "option -o: '" + writes.unnamed +
                  "' is there already and would be replaced, though lipoid did not write it; "
                  "name another place, or move that file away"),
              std::string::npos)
        << refused.err;
    EXPECT_EQ(ReadTextFile(file), "by hand\n");
    fs::remove(file);
    EXPECT_EQ(RunLipoid(folder, arguments).exit_code, 0);
    EXPECT_NE(ReadTextFile(file), "by hand\n");
    const auto again = RunLipoid(folder, arguments);
    EXPECT_EQ(again.exit_code, 0) << again.err;
  }
}

// A truth.json by which synthesize would know its own folder, but for what stands behind it, beyond the limits
// of every JSON file, or nested like a bomb, is no mark.
TEST(NothingLost, ADamagedMarkIsNone) {
  const std::string mark = R"({"run": {"protocol": "thesis"}})";
  const std::string all[] = {mark + std::string("\0x", 2),
                             mark + std::string(17'000'000, ' '),
                             std::string(10'000, '[') + std::string(10'000, ']'),
                             R"({"run": ["protocol"]})"};
  for (const std::string& truth : all) {
    const auto folder = TestFolder();
    fs::create_directories(folder + "/logs");
    Write(folder + "/logs/truth.json", truth);
    Write(folder + "/logs/pulses.csv", "by hand\n");
    const auto run =
        RunLipoid(folder, {"synthesize", "gifi-600mAh-1", "--sampling-s", "10", "-o", "logs"});
    EXPECT_EQ(run.exit_code, 2) << truth.size();
    EXPECT_NE(run.err.find("is there already and would be replaced"), std::string::npos) << run.err;
    EXPECT_EQ(ReadTextFile(folder + "/logs/pulses.csv"), "by hand\n");
    fs::remove_all(folder + "/logs");
  }
}

TEST(NothingLost, ABatchGoesOnAfterABadCampaign) {
  const auto folder = TestFolder();
  for (const char* const cell : {"gifi-600mAh-1", "gifi-600mAh-2"}) {
    ASSERT_EQ(RunLipoid(folder,
                        {"synthesize",
                         cell,
                         "--with",
                         "r_1=0.03,c_1=1500",
                         "--sampling-s",
                         "10",
                         "--quiet",
                         "-o",
                         cell})
                  .exit_code,
              0);
  }
  Write(folder + "/broken.toml", "this is no campaign\n");
  fs::create_directories(folder + "/logless");
  Write(folder + "/logless/campaign.toml",
        "[cell]\ncutoff_V = 3.0\n[[log]]\nkind = \"pulses\"\nfile = \"none.csv\"\n");
  const auto run = RunLipoid(folder,
                             {"identify",
                              "broken.toml",
                              "gifi-600mAh-1/campaign.toml",
                              "logless/campaign.toml",
                              "gifi-600mAh-2/campaign.toml",
                              "--method",
                              "staged",
                              "-o",
                              "cells",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_EQ(FilesIn(folder + "/cells"),
            (std::vector<std::string>{"gifi-600mAh-1.cell.json", "gifi-600mAh-2.cell.json"}));
  EXPECT_NE(run.out.find("Spread over 2 cells"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("broken.toml:1:"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("none.csv: error: "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("not identified: 2 of 4 campaigns (broken.toml, logless/campaign.toml); "
                         "the cells of the others are written"),
            std::string::npos)
      << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("exit_code"), 3);
  EXPECT_EQ(summary.at("cells").size(), 2U);
  EXPECT_EQ(summary.at("failed").size(), 2U);
}

TEST(NothingLost, ALongFlightIsLoggedThinly) {
  const auto folder = TestFolder();
  const auto rows = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"fly", "endurance", "--battery", "ideal", "-o", "f.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, arguments);
    const std::string text = ReadTextFile(folder + "/f.csv");
    return std::pair(std::count(text.begin(), text.end(), '\n') - 1, run.err);
  };
  const auto [thin, said] = rows({"--duration", "601"});
  EXPECT_EQ(thin, 6010);
  EXPECT_NE(said.find("f.csv: a row each 0.1 s of a long flight; --log-step-s 0.005 writes every "
                      "control step"),
            std::string::npos)
      << said;
  const auto [all, unsaid] = rows({"--duration", "20"});
  EXPECT_EQ(all, 4000);
  EXPECT_EQ(unsaid.find("a row each"), std::string::npos);
  EXPECT_EQ(rows({"--duration", "601", "--log-step-s", "0.5"}).first, 1202);
}

}  // namespace
}  // namespace lipoid::test
