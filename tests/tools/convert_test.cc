// lipoid convert, end to end. What is read from which format: tests/identify/logs/.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

TEST(Convert, WritesPlainCsvAndSaysWhatItDid) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"convert",
                              SourcePath("fixtures/logs/maccor/days.041"),
                              "-o",
                              "out.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadText(folder + "/out.csv"),
            "time_s,current_A,voltage_V\n0,0,4\n36,0,4\n72,2,3.9\n108,2,3.89\n144,2,3.88\n180,2,3."
            "87\n216,0,3.96\n"
            "252,0,3.97\n288,-1,4.02\n324,-1,4.025\n360,-1,4.03\n396,0,3.985\n");
  const auto file = ReadJson(folder, "s.json").at("files").at(0);
  EXPECT_EQ(file.at("format"), "maccor");
  EXPECT_EQ(file.at("output"), "out.csv");
  EXPECT_EQ(file.at("output_format"), "csv");
  EXPECT_EQ(file.at("rows"), 12);
  EXPECT_EQ(file.at("duration_s"), 396.0);
  EXPECT_EQ(file.at("current_sign"), "unsigned");
  EXPECT_EQ(file.at("dropped_rows"), 0);
}

TEST(Convert, WritesBdfByNameAndReadsItBack) {
  const auto folder = TestFolder();
  const auto there = RunLipoid(
      folder, {"convert", SourcePath("fixtures/logs/novonix/uhpc.csv"), "-o", "a.bdf.csv"});
  ASSERT_EQ(there.exit_code, 0) << there.err;
  EXPECT_TRUE(ReadText(folder + "/a.bdf.csv")
                  .starts_with("Test Time / s,Current / A,Voltage / V,Temperature T1 / degC\n"));
  const auto back = RunLipoid(folder, {"convert", "a.bdf.csv", "-o", "b.csv"});
  ASSERT_EQ(back.exit_code, 0) << back.err;
  const auto direct =
      RunLipoid(folder, {"convert", SourcePath("fixtures/logs/novonix/uhpc.csv"), "-o", "c.csv"});
  ASSERT_EQ(direct.exit_code, 0) << direct.err;
  EXPECT_EQ(ReadText(folder + "/b.csv"), ReadText(folder + "/c.csv"));
}

// A smart battery's voltage lags its current, so that the rows alone do not tell the sign that the autopilot's format
// defines.
TEST(Convert, WritesTheSignThatTheRowsDoNotTell) {
  const auto folder = TestFolder();
  const std::string log = SourcePath("fixtures/flights/log171.bin");
  for (const std::string name : {"l.csv", "l.bdf.csv"}) {
    ASSERT_EQ(RunLipoid(folder, {"convert", log, "-o", name}).exit_code, 0);
    const auto read = RunLipoid(folder, {"inspect", name, "--summary", "s.json"});
    ASSERT_EQ(read.exit_code, 0) << name << read.err;
    const auto file = ReadJson(folder, "s.json").at("files").at(0);
    EXPECT_EQ(file.at("current_sign"),
              name == "l.csv" ? "discharge-positive" : "discharge-negative");
  }
}

TEST(Convert, APartHasTheSignOfItsLogAndTheRowsAroundItAreOutside) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"convert",
                              SourcePath("fixtures/lab/dmegc_inr18650_26_r1/cc_1c.csv"),
                              "--start-s",
                              "100",
                              "--end-s",
                              "200",
                              "-o",
                              "out.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("11 rows kept, but not 340 rows outside the chosen part; "
                         "discharge-positive (discharge is positive as in the whole log; by itself "
                         "this part does not settle it: "),
            std::string::npos)
      << run.err;
}

TEST(Convert, NothingIsWrittenUnderTheNameOfAPackedFile) {
  const auto folder = TestFolder();
  const std::string log = SourcePath("fixtures/logs/maccor/days.041");
  const auto run = RunLipoid(folder, {"convert", log, "-o", "x.csv.gz"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("option --output: 'x.csv.gz' is the name of a packed file, and what is "
                         "written is not packed; leave out .gz and pack it afterwards"),
            std::string::npos)
      << run.err;
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{});
}

TEST(Convert, TakesUnitsStepsAndSpans) {
  const auto folder = TestFolder();
  const std::string log = SourcePath("fixtures/logs/plain-csv/no_units.csv");
  EXPECT_EQ(RunLipoid(folder, {"convert", log, "-o", "out.csv"}).exit_code, 3);
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{}) << "nothing is written";
  const auto run = RunLipoid(
      folder,
      {"convert", log, "--units", "s,A,V", "--start-s", "36", "--end-s", "108", "-o", "out.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadText(folder + "/out.csv"),
            "time_s,current_A,voltage_V\n0,0,4\n36,2,3.9\n72,2,3.89\n");
  const auto steps = RunLipoid(folder,
                               {"convert",
                                SourcePath("fixtures/logs/bitrode/header.csv"),
                                "--steps",
                                "1,2",
                                "-o",
                                "steps.csv"});
  ASSERT_EQ(steps.exit_code, 0) << steps.err;
  EXPECT_EQ(
      ReadText(folder + "/steps.csv"),
      "time_s,current_A,voltage_V\n0,0,4\n36,0,4\n72,2,3.9\n108,2,3.89\n144,2,3.88\n180,2,3.87\n");
}

TEST(Convert, RefusesWithTheRightExitCode) {
  const auto folder = TestFolder();
  const std::string log = SourcePath("fixtures/logs/plain-csv/si.csv");
  EXPECT_EQ(RunLipoid(folder, {"convert", "none.csv", "-o", "out.csv"}).exit_code, 3);
  EXPECT_EQ(RunLipoid(folder, {"convert", log}).exit_code, 2);
  EXPECT_EQ(RunLipoid(folder, {"convert", log, "--current-sign", "up", "-o", "out.csv"}).exit_code,
            2);
  EXPECT_EQ(RunLipoid(folder, {"convert", log, "--steps", "x", "-o", "out.csv"}).exit_code, 2);
  EXPECT_EQ(RunLipoid(folder, {"convert", log, "--columns", "zeit", "-o", "out.csv"}).exit_code, 2);
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{});
}

}  // namespace
}  // namespace lipoid::test
