// lipoid inspect, end to end. What it finds: tests/identify/logs/.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "identify/logs/campaign.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

// A 1C discharge of an hour with a row every 60 s, with a repeated time stamp.
void WriteDischarge(const std::string& file) {
  std::ofstream out(file);
  out << "time_s,current_A,voltage_V\n0,0,4.2\n";
  for (int k = 1; k <= 60; ++k) {
    out << 60 * k << ",2," << 4.1 - 0.018 * k << "\n";
    if (k == 30) out << 60 * k << ",2,3.5\n";
  }
}

// Two seconds of a discharge were drafted as a cell of 56 uAh.
TEST(Inspect, DraftsNoCellOfAPieceOfALog) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/piece.csv")
      << "time_s,voltage_V,current_A\n0,3.7,0.1\n1,3.6,0.1\n2,3.5,0.1\n";
  const auto run = RunLipoid(folder, {"inspect", "piece.csv", "--write-campaign", "c.toml"});
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(
      run.err.find(
          "option --write-campaign: every log is left out, and none is written: piece.csv lasts 2 s, "
          "in which no cell is emptied: it is a piece of a log"),
      std::string::npos)
      << run.err;
  EXPECT_FALSE(std::ifstream(folder + "/c.toml").good());
}

TEST(Inspect, SaysInAPaperWhichLogATableIsOf) {
  const auto folder = TestFolder();
  WriteDischarge(folder + "/a.csv");
  WriteDischarge(folder + "/b.csv");
  const auto run = RunLipoid(folder, {"inspect", "a.csv", "b.csv", "--latex", "t.tex", "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string paper = ReadTextFile(folder + "/t.tex");
  for (const std::string caption :
       {"a.csv: Segments of the log.", "b.csv: Segments of the log.", "The logs."})
    EXPECT_NE(paper.find("\\caption{" + caption + "}"), std::string::npos) << paper;
}

TEST(Inspect, SummaryHasTheKeysOfTheDesign) {
  const auto folder = TestFolder();
  WriteDischarge(folder + "/cc.csv");
  const auto run = RunLipoid(folder, {"inspect", "cc.csv", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  ASSERT_EQ(summary.at("files").size(), 1U);
  const auto& file = summary.at("files")[0];
  EXPECT_EQ(file.at("file"), "cc.csv");
  EXPECT_EQ(file.at("rows"), 61);
  EXPECT_EQ(file.at("duration_s"), 3600.0);
  EXPECT_EQ(file.at("current_sign"), "discharge-positive");
  EXPECT_EQ(file.at("dropped_rows"), 1);
  EXPECT_EQ(file.at("suggested_kind"), "constant-current");
  ASSERT_EQ(file.at("segments").size(), 2U);
  EXPECT_EQ(file.at("segments")[0].at("kind"), "rest");
  EXPECT_EQ(file.at("segments")[1].at("kind"), "constant-current");
  EXPECT_EQ(file.at("segments")[1].at("start_s"), 0.0);
  EXPECT_EQ(file.at("segments")[1].at("charge_C"), 7200.0);
  EXPECT_NE(run.out.find("constant-current: one discharge of 2 Ah at 2 A, 1 C of its own charge"),
            std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("1 row with a repeated time stamp"), std::string::npos) << run.out;
}

// As BEEP writes tests of Arbin: convert read them, and inspect asked for a number.
TEST(Inspect, ReadsALogWhoseStepsAreNotCounted) {
  const auto folder = TestFolder();
  std::ofstream log(folder + "/a.csv");
  log << "Test_Time(s),Step_Index,Cycle_Index,Current(A),Voltage(V)\n0,,,0,4.2\n";
  for (int k = 1; k <= 60; ++k) log << 60 * k << ",,,-2," << 4.1 - 0.018 * k << "\n";
  log.close();
  const auto run = RunLipoid(folder, {"inspect", "a.csv", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("files")[0].at("rows"), 61);
}

TEST(Inspect, SaysWhichLogSettledTheSignOfAnother) {
  const auto folder = TestFolder();
  WriteDischarge(folder + "/cc.csv");
  std::ofstream(folder + "/rest.csv") << "time_s,current_A,voltage_V\n0,0,4.2\n1,0,4.2\n2,0,4.2\n";
  const auto run = RunLipoid(folder, {"inspect", "rest.csv", "cc.csv", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto files = ReadJson(folder, "s.json").at("files");
  EXPECT_EQ(files[0].at("current_sign"), "discharge-positive");
  EXPECT_EQ(files[0].at("current_sign_is_of_others"), true);
  EXPECT_EQ(files[1].at("current_sign_is_of_others"), false);
  EXPECT_NE(OnOneLine(run.out).find(
                "discharge is positive as in cc.csv, of the same format; by itself this "
                "log does not settle it: no current flows"),
            std::string::npos)
      << run.out;
  const auto alone = RunLipoid(folder, {"inspect", "rest.csv"});
  EXPECT_EQ(alone.exit_code, 3);
  EXPECT_NE(alone.err.find("say `current_sign`"), std::string::npos) << alone.err;
}

TEST(Inspect, GoesOnAfterABadFileAndSaysSoInTheExitCode) {
  const auto folder = TestFolder();
  WriteDischarge(folder + "/cc.csv");
  std::ofstream(folder + "/bad.csv") << "time_s,current_A,voltage_V\n0,0,4.2\n1,abc,4.1\n";
  const auto run = RunLipoid(
      folder, {"inspect", "bad.csv", "cc.csv", "missing.csv", "--summary", "s.json", "--quiet"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(run.err.find("bad.csv:3:3: error: "), 0U) << run.err;
  EXPECT_NE(run.err.find("\nmissing.csv: error: "), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("constant-current: one discharge"), std::string::npos) << run.out;
  const auto files = ReadJson(folder, "s.json").at("files");
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].at("error").get<std::string>().find("bad.csv:3:3: error: "), 0U);
  EXPECT_EQ(files[1].at("rows"), 61);
}

TEST(Inspect, OneBadFileIsAnErrorLikeAnyOther) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"inspect", "missing.csv", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(ReadJson(folder, "s.json").at("error").at("diagnostics")[0].at("file"), "missing.csv");
}

TEST(Inspect, DraftsACampaignThatReads) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder,
                      {"synthesize", "gifi-600mAh-1", "--sampling-s", "1", "-o", "logs", "--quiet"})
                .exit_code,
            0);
  const auto run =
      RunLipoid(folder, {"inspect", "logs", "--write-campaign", "drafted.toml", "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto drafted = ReadCampaign(folder + "/drafted.toml");
  const auto written = ReadCampaign(folder + "/logs/campaign.toml");
  EXPECT_EQ(drafted.name, "logs");
  EXPECT_EQ(drafted.cutoff_V, written.cutoff_V);
  EXPECT_EQ(drafted.Count(LogKind::kConstantCurrent), 6U);
  EXPECT_EQ(drafted.Count(LogKind::kLowRate), 1U);
  EXPECT_EQ(drafted.Count(LogKind::kPulses), 1U);
  EXPECT_EQ(drafted.logs[0].path, folder + "/logs/cc_1C.csv");
}

TEST(Inspect, RefusesToDraftFromNothing) {
  const auto folder = TestFolder();
  std::string charge = "time_s,current_A,voltage_V\n";
  for (int k = 0; k < 600; ++k)
    charge += fmt::format("{},{},{:.4f}\n", k, k < 20 ? 0.0 : -2.0, k < 20 ? 3.5 : 3.6 + 0.001 * k);
  std::ofstream(folder + "/charge.csv") << charge;
  const auto run = RunLipoid(folder, {"inspect", "charge.csv", "--write-campaign", "c.toml"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find("only charging"), std::string::npos)
      << "what is in the log is said all the same: " << run.out;
  EXPECT_NE(
      run.err.find("lipoid inspect: error: option --write-campaign: none of the logs is of a kind "
                   "that a campaign takes, and none is written\n"),
      std::string::npos)
      << run.err;
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{"charge.csv"});
}

TEST(Inspect, OfEveryRealLogSucceeds) {
  const auto nissan = LabDataPath("nissan_leaf_33ah");
  LIPOID_SKIP_WITHOUT(nissan);
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"inspect",
                              nissan,
                              LabDataPath("dmegc_inr18650_26_r1"),
                              LabDataPath("lg_m50_5ah"),
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("files").size(), 16U);
  for (const auto& file : summary.at("files")) {
    EXPECT_EQ(file.at("current_sign"), "discharge-positive") << file.at("file");
    EXPECT_FALSE(file.at("suggested_kind").is_null()) << file.at("file");
  }
}

// The highest voltage of this flight on eight cells is that of seven full ones.
TEST(Inspect, TakesTheCellsThatTheAutopilotWasTold) {
  const std::string folder = TestFolder();
  const std::string log = SourcePath("fixtures/flights/quadrotor_local.ulg");
  const auto run = RunLipoid(folder, {"inspect", log, "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json inspection = ReadJson(folder, "s.json").at("files").at(0);
  EXPECT_EQ(inspection.at("flight").at("cells"), 8);
  EXPECT_EQ(inspection.at("series"), 8);
}

}  // namespace
}  // namespace lipoid::test
