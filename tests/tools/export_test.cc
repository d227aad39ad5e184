// lipoid export, as a user runs it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/core/json.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

TEST(ExportCommand, WritesTheFilesAndPrintsWhatTheirCommentsSay) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"export",
                              "gifi-600mAh-1",
                              "--to",
                              "ardupilot",
                              "--series",
                              "3",
                              "-o",
                              "frame.json",
                              "--summary",
                              "s.json",
                              "--latex",
                              "t.tex"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(FilesIn(folder),
            (std::vector<std::string>{"frame.json", "frame.parm", "s.json", "t.tex"}));
  EXPECT_NE(ReadTextFile(folder + "/t.tex").find("maxVoltage & "), std::string::npos);
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary["target"], "ardupilot");
  EXPECT_EQ(summary["target_version"], "any");
  EXPECT_EQ(summary["files"], (std::vector<std::string>{"frame.json", "frame.parm"}));
  EXPECT_LT(summary["rmse_V"].get<double>(), 0.5 * summary["naive"]["rmse_V"].get<double>());
  EXPECT_GT(summary["max_error_V"].get<double>(), summary["rmse_V"].get<double>());
  EXPECT_NEAR(summary["parameters"]["maxVoltage"].get<double>(), 12.6, 0.26);
  EXPECT_EQ(summary["mission"].get<std::string>().rfind("default (", 0), 0U);
  const auto first = run.out.substr(0, run.out.find('\n'));
  EXPECT_NE(first.find("ardupilot (projected): "), std::string::npos) << first;
  EXPECT_NE(first.find(" mV rms"), std::string::npos) << first;
  const std::string frame = ReadTextFile(folder + "/frame.json");
  // The comments of the file, line by line, are in what was printed.
  for (const auto* const sentence : {"SHA-256 of the cell file: ",
                                     "Numbers read off the cell file would give",
                                     "What this law cannot hold:",
                                     "Volts, Ah and ohms of the pack of 3 in series"}) {
    EXPECT_NE(run.out.find(sentence), std::string::npos) << sentence;
    EXPECT_NE(frame.find(sentence), std::string::npos) << sentence;
  }
}

// Fitted over the flat end slope of a v_oc of which a part is known, ArduPilot's battery had six times
// the capacity.
TEST(ExportCommand, FitsNothingWhereTheVoltageIsNotKnown) {
  const auto folder = TestFolder();
  WriteFlownCell(folder, {0.85, 0.9, 1.0}, {4.045, 4.05, 4.14});
  const std::string said = "v_oc of flown is known between 0.85 and 1 of the charge";
  const auto refused =
      RunLipoid(folder, {"export", "flown.json", "--to", "ardupilot", "-o", "frame.json"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find(said), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--mission LOG"), std::string::npos) << refused.err;
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"flown.json"}));

  std::string flight = "time_s,current_A,voltage_V\n";
  for (int k = 0; k < 100; ++k) flight += fmt::format("{},{},4\n", k, k / 10 % 2 == 0 ? 0 : 5);
  Write(folder + "/flight.csv", flight);
  const auto run = RunLipoid(folder,
                             {"export",
                              "flown.json",
                              "--to",
                              "ardupilot",
                              "-o",
                              "frame.json",
                              "--mission",
                              "flight.csv",
                              "--current-sign",
                              "discharge-positive",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NEAR(ReadJson(folder, "s.json")["parameters"]["battCapacityAh"].get<double>(),
              ReadJson(folder, "flown.json")["capacity_Ah"].get<double>(),
              1e-6);  // a float
  EXPECT_NE(run.out.find(said), std::string::npos) << run.out;
  EXPECT_NE(ReadTextFile(folder + "/frame.parm").find("BATT_CAPACITY 600"), std::string::npos);

  // The cell's own law is written as it is, and the file says how far it is known.
  const auto exact = RunLipoid(
      folder, {"export", "flown.json", "--to", "c", "-o", "cell.h", "--summary", "c.json"});
  ASSERT_EQ(exact.exit_code, 0) << exact.err;
  EXPECT_NE(ReadTextFile(folder + "/cell.h").find("v_oc of flown is known"), std::string::npos);
  EXPECT_NE(ReadJson(folder, "c.json")["notes"].dump().find(said), std::string::npos);
}

// An error of 30 mV is none that an exact law has.
TEST(ExportCommand, CallsNoLawExactThatLacksWhatTheCellHas) {
  const auto folder = TestFolder();
  Json cell = Json::parse(ReadTextFile(SourcePath("fixtures/cells/gifi-600mAh-1.json")));
  Write(folder + "/plain.json", cell.dump());
  cell["hysteresis"] = {{"folds", 30.0}, {"half_V", 0.03}};
  Write(folder + "/both.json", cell.dump());
  const auto first = [&](const std::string& file) {
    const auto run = RunLipoid(folder, {"export", file, "--to", "c", "-o", "pack.h"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out.substr(0, run.out.find('\n'));
  };
  EXPECT_EQ(first("plain.json").find("c (exact): 0.000 mV rms"), 0U) << first("plain.json");
  EXPECT_EQ(first("both.json").find("c (the cell's own law without its hysteresis): "), 0U)
      << first("both.json");
  EXPECT_NE(
      ReadTextFile(folder + "/pack.h").find("the law is the cell's own without its hysteresis"),
      std::string::npos);
  // A diffusion that ends early is none that PyBaMM's element can have.
  cell.erase("hysteresis");
  cell["diffusion"]["tail"] = false;
  Write(folder + "/early.json", cell.dump());
  for (const auto& [file, kind] : {std::pair{"plain.json", "exact"},
                                   {"both.json", "incomplete"},
                                   {"early.json", "incomplete"}}) {
    const auto run =
        RunLipoid(folder, {"export", file, "--to", "pybamm", "-o", "p.py", "--summary", "s.json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(ReadJson(folder, "s.json").at("kind"), kind) << file;
  }
  const std::string early = ReadTextFile(folder + "/p.py");
  EXPECT_EQ(early.find("the error is that of the mesh"), std::string::npos);
  EXPECT_NE(early.find("what the mesh adds to the error of what it cannot hold"),
            std::string::npos);
}

TEST(ExportCommand, ReachesWhatIsKnownOfASortie) {
  const auto folder = TestFolder();
  const std::string sortie = SourcePath("fixtures/missions/sortie.csv");
  struct Known {
    std::vector<std::string> to;
    double rmse_mV;
    double max_mV;
    double naive_mV;
  };
  // Found by an independent program with the same laws; 3 % for its other arithmetic.
  const std::vector<Known> all = {{{"ardupilot"}, 17.9, 75.0, 0.0},
                                  {{"px4"}, 21.9, 100.0, 0.0},
                                  {{"gazebo"}, 21.8, 110.0, 76.0},
                                  {{"thevenin", "--branches", "1"}, 3.7, 22.0, 139.0},
                                  {{"thevenin", "--branches", "2"}, 3.1, 9.5, 139.0}};
  for (const auto& known : all) {
    std::vector<std::string> arguments = {
        "export", "gifi-600mAh-1", "--mission", sortie, "-o", "o", "--summary", "s.json", "--to"};
    arguments.insert(arguments.end(), known.to.begin(), known.to.end());
    const auto run = RunLipoid(folder, arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json summary = ReadJson(folder, "s.json");
    EXPECT_LE(1e3 * summary["rmse_V"].get<double>(), 1.03 * known.rmse_mV) << known.to[0];
    EXPECT_LE(1e3 * summary["max_error_V"].get<double>(), 1.03 * known.max_mV) << known.to[0];
    if (known.naive_mV > 0.0) {
      EXPECT_NEAR(
          1e3 * summary["naive"]["rmse_V"].get<double>(), known.naive_mV, 0.03 * known.naive_mV);
    }
  }
}

TEST(ExportCommand, WarnsOfAnErrorAboveTheLimit) {
  const auto folder = TestFolder();
  const auto warned = RunLipoid(
      folder, {"export", "gifi-600mAh-1", "--to", "px4", "--error-limit-mV", "1", "-o", "p"});
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_NE(
      warned.err.find("is more than 1 mV for each: px4 cannot hold this cell over this mission"),
      std::string::npos)
      << warned.err;
  const auto silent = RunLipoid(
      folder, {"export", "gifi-600mAh-1", "--to", "px4", "--error-limit-mV", "50", "-o", "p"});
  EXPECT_EQ(silent.err.find("warning"), std::string::npos) << silent.err;
}

TEST(ExportCommand, MergesIntoAFrameWhichStays) {
  const auto folder = TestFolder();
  const std::string frame = "{ \"mass\": 2, # kg\n \"maxVoltage\": 1 }";
  Write(folder + "/mine.json", frame);
  const auto run = RunLipoid(
      folder,
      {"export", "gifi-600mAh-1", "--to", "ardupilot", "--into", "mine.json", "-o", "merged.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadTextFile(folder + "/mine.json"), frame);
  const std::string merged = ReadTextFile(folder + "/merged.json");
  EXPECT_NE(merged.find("\"mass\": 2, # kg\n \"maxVoltage\": 4.1"), std::string::npos) << merged;
}

TEST(ExportCommand, FliesAndExportsOverTheFlight) {
  const auto folder = TestFolder();
  ASSERT_EQ(
      RunLipoid(folder, {"fly", "altitude-steps", "--cell", "gifi-600mAh-1", "-o", "flight.csv"})
          .exit_code,
      0);
  const auto run = RunLipoid(folder,
                             {"export",
                              "gifi-600mAh-1",
                              "--to",
                              "gazebo",
                              "--mission",
                              "flight.csv",
                              "-o",
                              "b.sdf",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary["mission"], "flight.csv");
  EXPECT_LT(summary["rmse_V"].get<double>(), 0.03);
}

TEST(ExportCommand, SaysWhatIsWrong) {
  const auto folder = TestFolder();
  const std::string cell = ReadTextFile(SourcePath("fixtures/cells/gifi-600mAh-1.json"));
  std::string dead = cell;
  dead.replace(dead.find("\"cutoff_V\": 3.0"), 15, "\"cutoff_V\": 4.5");
  Write(folder + "/dead.json", dead);
  Write(folder + "/log.csv", "time_s,current_A\n0,0\n1,1\n");
  Write(folder + "/frame.json", "[1]");
  struct Wrong {
    std::vector<std::string> arguments;
    int exit_code;
    std::string message;
  };
  const std::vector<Wrong> all = {
      {{"c", "--to", "ardupilto"}, 2, "unknown target 'ardupilto'. Did you mean 'ardupilot'"},
      {{"c", "--to", "px4", "--into", "frame.json"},
       2,
       "option --into: px4 does not take it; ardupilot does"},
      {{"c", "--to", "gazebo", "--branches", "1"}, 2, "option --branches: gazebo does not take it"},
      {{"c", "--to", "gazebo", "--target-version", "harmonica"},
       2,
       "option --target-version: expected one of harmonic, fortress, garden, ionic, jetty, found "
       "'harmonica'"},
      {{"c", "--to", "px4", "--target-version", "1"},
       2,
       "option --target-version: px4 has no versions that differ; leave it out"},
      {{"c", "--to", "px4", "--initial-soc", "0.5"},
       2,
       "options --initial-soc and --initial-voltage-V are of a --mission: the default one starts "
       "full"},
      {{"c", "--to", "px4", "--mission", "log.csv"},
       3,
       "log.csv:1:1: error: expected a mission of at least 10 rows"},
      {{"c", "--to", "ardupilot", "--into", "frame.json"},
       3,
       "frame.json:1:1: error: expected a frame model of ArduPilot, which begins with '{'"},
      {{"dead.json", "--to", "px4"},
       3,
       "dead.json:1:1: error: expected a battery, found one that is below its cut-off of 4.5 V when "
       "full: v_oc(1) is 4.2 V"},
      {{"nowhere.json", "--to", "px4"}, 3, "nowhere.json: error"}};
  for (const auto& wrong : all) {
    std::vector<std::string> arguments = {"export"};
    for (const auto& word : wrong.arguments)
      arguments.push_back(word == "c" ? "gifi-600mAh-1" : word);
    arguments.insert(arguments.end(), {"-o", "new.json"});
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, wrong.exit_code) << run.err;
    EXPECT_NE(run.err.find(wrong.message), std::string::npos) << run.err << "\n" << wrong.message;
    EXPECT_FALSE(std::filesystem::exists(folder + "/new.json")) << wrong.message;
  }
  // Before, a second file stood in /dev.
  for (const char* output : {"-", "/dev/null"}) {
    const auto piped =
        RunLipoid(folder, {"export", "gifi-600mAh-1", "--to", "ardupilot", "-o", output});
    EXPECT_EQ(piped.exit_code, 2);
    EXPECT_NE(piped.err.find("option -o: ardupilot writes 2 files; name the first one"),
              std::string::npos)
        << piped.err;
  }
  const auto second = RunLipoid(folder, {"export", "gifi-600mAh-1", "--to", "c", "-o", "cell.c"});
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("option -o: the first file of c is its .h; give cell.h"),
            std::string::npos)
      << second.err;
  const auto odd = RunLipoid(folder, {"export", "gifi-600mAh-1", "--to", "c", "-o", "cell.txt"});
  EXPECT_EQ(odd.exit_code, 0);
  EXPECT_NE(odd.err.find("cell.txt: a file for c usually ends in .h"), std::string::npos)
      << odd.err;
}

TEST(ImportCommand, WhatWasExportedSimulatesAlike) {
  const auto folder = TestFolder();
  Write(folder + "/log.csv", "time_s,current_A\n0,0\n100,1\n300,0.5\n400,0\n");
  ASSERT_EQ(
      RunLipoid(folder, {"export", "gifi-600mAh-2", "--to", "tables", "-o", "t.csv"}).exit_code, 0);
  const auto imported =
      RunLipoid(folder, {"import", "t.csv", "-o", "back.json", "--summary", "s.json"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary["format"], "tables");
  EXPECT_EQ(summary["cell"]["name"], "gifi-600mAh-2");
  EXPECT_EQ(summary["cell"]["run"]["inputs"][0]["file"], "t.csv") << summary["cell"]["run"].dump();
  for (const auto& [cell, output] : {std::pair{"gifi-600mAh-2", "a.csv"}, {"back.json", "b.csv"}}) {
    ASSERT_EQ(RunLipoid(folder, {"simulate", cell, "--current", "log.csv", "-o", output}).exit_code,
              0);
  }
  EXPECT_EQ(ReadTextFile(folder + "/a.csv"), ReadTextFile(folder + "/b.csv"));
}

TEST(ImportCommand, RefusesAndWritesNothing) {
  const auto folder = TestFolder();
  Write(folder + "/frame.json",
        "{\n\"maxVoltage\": 12.6, \"battCapacityAh\": 0, \"refBatRes\": 0}");
  const auto run = RunLipoid(folder, {"import", "frame.json", "-o", "c.json"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("frame.json:2:39: error: /battCapacityAh: expected a capacity above 0"),
            std::string::npos)
      << run.err;
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{"frame.json"});
}

TEST(ExportCommand, TargetsAreListed) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"list", "targets", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("ardupilot"), std::string::npos);
  const Json targets = ReadJson(folder, "s.json")["targets"];
  ASSERT_GE(targets.size(), 5U);
  for (const auto& target : targets) EXPECT_FALSE(target["summary"].get<std::string>().empty());
}

}  // namespace
}  // namespace lipoid::test
