// The first hour of a new user: logs that are not what they seem, cells asked for more than they can
// do. Each is said, in the first line or in the exit code.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "identify/logs/campaign.h"
#include "model/battery/cell_file.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

using Columns = std::vector<std::string>;

// The lab's logs of a shipped cell in logs/, sampled every second.
std::string FolderWithNoisyLogs() {
  auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"synthesize",
                              "gifi-600mAh-1",
                              "--with",
                              "r_1=0.03,c_1=1500",
                              "--sampling-s",
                              "1",
                              "--rates-C",
                              "1,3,6",
                              "--voltage-noise-V",
                              "0.0005",
                              "--seed",
                              "1",
                              "--quiet",
                              "-o",
                              "logs"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return folder;
}

// Writes the rows of a log again, each as `change` makes it; empty: left out.
void Rewrite(const std::string& file,
             const std::string& to,
             const std::function<std::string(double, double, double)>& change,
             const std::string& header = "time_s,current_A,voltage_V") {
  std::istringstream lines(ReadTextFile(file));
  std::ofstream out(to);
  out << header << "\n";
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string t, i, v;
    std::getline(cells, t, ',');
    std::getline(cells, i, ',');
    std::getline(cells, v, ',');
    out << change(std::stod(t), std::stod(i), std::stod(v));
  }
}

std::string Row(double t, double i, double v) {
  std::ostringstream row;
  row.precision(12);
  row << t << "," << i << "," << v << "\n";
  return row.str();
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

TEST(FirstHour, TheFirstLineOfAFitIsItsVerdict) {
  const auto folder = FolderWithNoisyLogs();
  const auto run = RunLipoid(
      folder, {"identify", "logs/campaign.toml", "-o", "cell.json", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(FirstLine(run.out).find("gifi-600mAh-1 predicts its own logs to "), 0U)
      << FirstLine(run.out);
  EXPECT_TRUE(FirstLine(run.out).ends_with(": good")) << FirstLine(run.out);
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("method"), "joint");  // the default
  EXPECT_EQ(summary.at("verdict").at("grade"), "good");
  EXPECT_LT(summary.at("verdict").at("rmse_V").get<double>(), 0.002);
  EXPECT_EQ(summary.at("verdict").at("reasons").size(), 0U);
  EXPECT_EQ(LoadCell(folder + "/cell.json").run->at("metrics").at("verdict").at("grade"), "good");
}

// The times of one log in minutes under a header of seconds: its charge is a sixtieth.
TEST(FirstHour, AnAbsurdFitDoesNotEndAsDone) {
  const auto folder = FolderWithNoisyLogs();
  for (const char* log : {"cc_1C.csv", "cc_3C.csv", "cc_6C.csv"}) {
    Rewrite(folder + "/logs/" + log, folder + "/" + log, [](double t, double i, double v) {
      return Row(t / 60.0, i, v);
    });
  }
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "--constant-current",
                              "cc_1C.csv",
                              "cc_3C.csv",
                              "cc_6C.csv",
                              "--low-rate",
                              "logs/low_rate.csv",
                              "--pulses",
                              "logs/pulses.csv",
                              "--cutoff-V",
                              "3.0",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(FirstLine(run.out).find(": poor: "), std::string::npos) << FirstLine(run.out);
  EXPECT_NE(run.err.find("rows are 1/60 s apart, as whole seconds are on a clock in min"),
            std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find("the cell does not describe its own logs"), std::string::npos) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("verdict").at("grade"), "poor");
  EXPECT_EQ(ReadJson(folder, "s.json").at("exit_code"), 1);
}

TEST(FirstHour, ACapacityInMilliampereHoursIsRefused) {
  const auto folder = FolderWithNoisyLogs();
  auto text = ReadTextFile(folder + "/logs/campaign.toml");
  const auto at = text.find("capacity_Ah = 0.6");
  ASSERT_NE(at, std::string::npos) << text;
  text.replace(at, std::string("capacity_Ah = 0.6").size(), "capacity_Ah = 600.0");
  std::ofstream(folder + "/logs/milli.toml") << text;
  const auto run = RunLipoid(folder, {"identify", "logs/milli.toml", "-o", "cell.json"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("found 0.375 Ah at most; is the capacity in mAh"), std::string::npos)
      << run.err;
}

TEST(FirstHour, AGapIsRefusedAndDrafted) {
  const auto folder = FolderWithNoisyLogs();
  Rewrite(folder + "/logs/pulses.csv", folder + "/gap.csv", [](double t, double i, double v) {
    return t > 1805.0 && t < 2225.0 ? "" : Row(t, i, v);
  });
  const auto inspected = RunLipoid(folder, {"inspect", "gap.csv"});
  EXPECT_NE(inspected.out.find("Ah may have flowed unseen"), std::string::npos) << inspected.out;
  const auto run = RunLipoid(folder, {"validate", "gifi-600mAh-1", "gap.csv"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("expected rows wherever a current flows, found a gap of"),
            std::string::npos)
      << run.err;
}

TEST(FirstHour, APackIsDraftedAsOneAndIdentifies) {
  const auto folder = FolderWithNoisyLogs();
  for (const char* log : {"cc_1C.csv", "cc_3C.csv", "cc_6C.csv", "low_rate.csv", "pulses.csv"}) {
    std::filesystem::create_directories(folder + "/pack");
    Rewrite(folder + "/logs/" + log, folder + "/pack/" + log, [](double t, double i, double v) {
      return Row(t, i, 3.0 * v);
    });
  }
  const auto drafted =
      RunLipoid(folder, {"inspect", "pack", "--write-campaign", "pack/campaign.toml"});
  ASSERT_EQ(drafted.exit_code, 0) << drafted.err;
  EXPECT_NE(drafted.out.find("3 cells in series, by the voltage"), std::string::npos);
  const Campaign campaign = ReadCampaign(folder + "/pack/campaign.toml");
  EXPECT_EQ(campaign.series, 3);
  EXPECT_EQ(campaign.cutoff_V, 3.0);
  EXPECT_EQ(campaign.logs.size(), 5U);
  const auto run = RunLipoid(folder, {"identify", "pack/campaign.toml", "-o", "pack.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Cell cell = LoadCell(folder + "/pack.json");
  EXPECT_EQ(cell.series, 3);
  EXPECT_NEAR(cell.series_resistance_Ohm(0.5), 0.1314, 0.01);
  // One cell of it, by --series.
  const auto one = RunLipoid(folder, {"validate", "pack.json", "logs/pulses.csv", "--series", "1"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
}

// Beside them lie a text and a table that are no logs.
TEST(FirstHour, DischargesThatWereStoppedEarlyMakeNoCellThatIsEmptyHalfWay) {
  const auto folder = FolderWithNoisyLogs();
  std::filesystem::create_directories(folder + "/part");
  for (const auto& [log, end_s] :
       {std::pair("cc_1C.csv", 1200.0), {"cc_3C.csv", 300.0}, {"pulses.csv", 12000.0}}) {
    Rewrite(folder + "/logs/" + log,
            folder + "/part/" + log,
            [end = end_s](double t, double i, double v) { return t > end ? "" : Row(t, i, v); });
  }
  std::ofstream(folder + "/part/README") << "What was done, and when\n";
  std::ofstream(folder + "/part/ocv.csv") << "soc,voltage_V\n0,3.0\n0.5,3.8\n1,4.2\n";
  const auto drafted = RunLipoid(folder, {"inspect", "part", "--write-campaign", "part.toml"});
  EXPECT_EQ(drafted.exit_code, 0) << drafted.err;
  EXPECT_NE(drafted.err.find("part.toml: 1 log, 2 left out, 2 not used"), std::string::npos)
      << drafted.err;
  EXPECT_NE(drafted.err.find("read it over and give capacity_Ah and cutoff_V, which no log shows"),
            std::string::npos)
      << drafted.err;
  EXPECT_FALSE(ReadCampaign(folder + "/part.toml").cutoff_V);
  EXPECT_EQ(RunLipoid(folder, {"inspect", "part", "part/README"}).exit_code, 3);

  const auto run = RunLipoid(folder,
                             {"identify",
                              "--constant-current",
                              "part/cc_3C.csv",
                              "--pulses",
                              "part/pulses.csv",
                              "--cutoff-V",
                              "3.53",
                              "-o",
                              "own.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("no lithium cell is empty at 3.53 V"), std::string::npos) << run.out;
}

TEST(FirstHour, ALogThatDoesNotStartFullIsSeen) {
  const auto folder = FolderWithNoisyLogs();
  Rewrite(folder + "/logs/pulses.csv", folder + "/half.csv", [](double t, double i, double v) {
    return t < 9000.0 ? "" : Row(t - 9000.0, i, v);
  });
  const auto run = RunLipoid(folder, {"validate", "gifi-600mAh-1", "half.csv"});
  EXPECT_NE(run.err.find("before its first load, where v_oc(A) has a state of charge of "),
            std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find("(--initial-soc)"), std::string::npos) << run.err;
}

TEST(FirstHour, ColumnsCanBeNamedWhereverLogsAreRead) {
  const auto folder = FolderWithNoisyLogs();
  Rewrite(
      folder + "/logs/pulses.csv",
      folder + "/odd.csv",
      [](double t, double i, double v) { return Row(t, i, v); },
      "x_s,y_A,z_V");
  const Columns names{"--columns", "time_s=x_s", "current_A=y_A", "voltage_V=z_V"};
  const auto with_names = [&](Columns arguments) {
    arguments.insert(arguments.end(), names.begin(), names.end());
    return RunLipoid(folder, arguments);
  };
  EXPECT_EQ(RunLipoid(folder, {"inspect", "odd.csv"}).exit_code, 3);
  EXPECT_EQ(with_names({"inspect", "odd.csv"}).exit_code, 0);
  EXPECT_EQ(with_names({"validate", "gifi-600mAh-1", "odd.csv"}).exit_code, 0);
  EXPECT_EQ(
      with_names({"simulate", "gifi-600mAh-1", "--current", "odd.csv", "-o", "p.csv"}).exit_code,
      0);
  EXPECT_EQ(with_names({"convert", "odd.csv", "-o", "c.csv"}).exit_code, 0);
}

// Rows of one second fall through 3 V by some millivolts; rows of a hundredth tell where.
TEST(FirstHour, TheCutOffIsReachedBetweenRows) {
  const auto folder = TestFolder();
  const auto cutoff_s = [&](double step_s, double from_s) {
    std::ofstream log(folder + "/one.csv");
    log << "time_s,current_A\n0,1\n";
    for (int k = 1; from_s + step_s * k < 1400.0; ++k) log << from_s + step_s * k << ",1\n";
    log.close();
    const auto run = RunLipoid(folder,
                               {"simulate",
                                "gifi-600mAh-1",
                                "--current",
                                "one.csv",
                                "-o",
                                "p.csv",
                                "--summary",
                                "s.json"});
    EXPECT_EQ(run.exit_code, 1) << run.err;
    return ReadJson(folder, "s.json").at("logs")[0].at("cutoff_s").get<double>();
  };
  constexpr double kCurved_s = 0.02;  // what a straight line over one second misses
  EXPECT_NEAR(cutoff_s(1.0, 0.0), cutoff_s(0.01, 1200.0), kCurved_s);
}

TEST(FirstHour, ASimulationEndsAtTheCutOff) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/much.csv") << "time_s,current_A\n0,0\n1,100\n2,100\n3,100\n";
  const auto run = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "much.csv", "-o", "p.csv", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("the cell reaches its cut-off of 3 V at 1 s under 100 A: the 1 of 4 rows "
                         "above it, within 5 mV, were written"),
            std::string::npos)
      << run.err;
  const Json log = ReadJson(folder, "s.json").at("logs")[0];
  EXPECT_EQ(log.at("rows"), 1);
  EXPECT_EQ(log.at("rows_of_current"), 4);
  EXPECT_EQ(log.at("cutoff_s"), 1.0);
  EXPECT_GT(log.at("minimum_voltage_V").get<double>(), 4.0);
  const auto all = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "much.csv", "--beyond-cutoff", "-o", "all.csv"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
}

// The band counts the rows that are written: under 100 A it would be volts wide.
TEST(FirstHour, TheBandOfASimulationEndsAtTheCutOffToo) {
  const auto folder = FolderWithNoisyLogs();
  ASSERT_EQ(
      RunLipoid(folder, {"identify", "logs/campaign.toml", "--quiet", "-o", "cell.json"}).exit_code,
      0);
  std::ofstream(folder + "/much.csv") << "time_s,current_A\n0,0\n1,0.5\n2,0.5\n3,100\n4,100\n";
  const auto run = RunLipoid(folder,
                             {"simulate",
                              "cell.json",
                              "--current",
                              "much.csv",
                              "--ensemble",
                              "50",
                              "-o",
                              "p.csv",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("logs")[0].at("rows"), 3);
  EXPECT_LT(summary.at("ensemble").at("band_max_V").get<double>(), 0.02);
}

TEST(FirstHour, AGapInACurrentIsSaid) {
  const auto folder = TestFolder();
  std::ofstream file(folder + "/gap.csv");
  file << "time_s,current_A\n";
  for (int k = 0; k < 40; ++k) file << (k < 20 ? k : k + 100) << ",0.5\n";
  file.close();
  const auto run =
      RunLipoid(folder, {"simulate", "gifi-600mAh-1", "--current", "gap.csv", "-o", "p.csv"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("gap.csv: a gap of 101 s after 19 s, in which up to 0.014 Ah may have "
                         "flowed unseen"),
            std::string::npos)
      << run.err;
}

TEST(FirstHour, ALandingVoltageOfOneCellIsRefused) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"fly",
                              "hover",
                              "--vehicle",
                              "racer-5in",
                              "--series",
                              "4",
                              "--parallel",
                              "4",
                              "--land-below-V",
                              "3.5"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(
      run.err.find("option --land-below-V: 3.5 V is not above the 12 V at which the pack of 4 "
                   "cells is empty and the flight ends; 3.5 V a cell are 14 V"),
      std::string::npos)
      << run.err;
}

TEST(FirstHour, ALandingVoltageAboveTheFullPackIsRefused) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"fly", "hover", "--duration", "1", "--land-below-V", "20"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("option --land-below-V: 20 V is not below the "), std::string::npos)
      << run.err;
}

}  // namespace
}  // namespace lipoid::test
