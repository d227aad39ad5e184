// lipoid simulate and lipoid validate, end to end, on logs whose truth is known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

// The synthesized discharge of a shipped cell at 2C in logs/, sampled every second.
std::string FolderWithLogs(const std::vector<std::string>& more = {}) {
  auto folder = TestFolder();
  std::vector<std::string> arguments{"synthesize",
                                     "gifi-600mAh-1",
                                     "--sampling-s",
                                     "1",
                                     "--rates-C",
                                     "2",
                                     "--quiet",
                                     "-o",
                                     "logs"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto run = RunLipoid(folder, arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return folder;
}

// The numbers of a CSV below its header.
std::vector<std::vector<double>> Numbers(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

TEST(Simulate, GivesTheSynthesizedVoltagesBackToTheLastDigit) {
  const auto folder = FolderWithLogs();
  const auto run = RunLipoid(folder,
                             {"simulate",
                              "gifi-600mAh-1",
                              "--current",
                              "logs/pulses.csv",
                              "-o",
                              "p.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto text = ReadTextFile(folder + "/p.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')), "time_s,current_A,voltage_V,open_circuit_V,soc");
  const auto predicted = Numbers(text);
  const auto measured = Numbers(ReadTextFile(folder + "/logs/pulses.csv"));
  ASSERT_EQ(predicted.size(), measured.size());
  const Cell cell = LoadCell("gifi-600mAh-1");
  for (std::size_t k = 0; k < measured.size(); ++k) {
    for (std::size_t column = 0; column < 3; ++column)
      ASSERT_EQ(predicted[k][column], measured[k][column]) << k;
    ASSERT_EQ(predicted[k][3], cell.open_circuit_voltage(predicted[k][4])) << k;
  }
  const auto summary = ReadJson(folder, "s.json").at("logs").at(0);
  EXPECT_EQ(summary.at("rows"), measured.size());
  EXPECT_EQ(summary.at("initial_soc"), 1.0);
  EXPECT_EQ(summary.at("final_soc"), predicted.back()[4]);
  EXPECT_EQ(summary.at("minimum_voltage_V"), measured.back()[2]);  // cut-off ends the log
}

TEST(Simulate, ACurrentAloneIsEnoughAndDischargeIsPositive) {
  const auto folder = TestFolder();
  ASSERT_EQ(
      RunShell(folder, "printf 'time_s,current_A\\n0,0\\n10,0.6\\n20,0.6\\n' >i.csv").exit_code, 0);
  const auto run = RunLipoid(
      folder, {"simulate", "gifi-600mAh-1", "--current", "i.csv", "-o", "p.csv", "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  const auto rows = Numbers(ReadTextFile(folder + "/p.csv"));
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0][4], 1.0);
  EXPECT_LT(rows[1][4], 1.0);
  EXPECT_LT(rows[2][2], rows[1][2]);
  EXPECT_LT(rows[1][2], 4.2);
}

TEST(Simulate, StartsWhereItIsTold) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunShell(folder, "printf 'time_s,current_A\\n0,0\\n10,0\\n' >i.csv").exit_code, 0);
  const auto simulate = [&](const std::string& option, const std::string& value) {
    const auto run = RunLipoid(folder,
                               {"simulate",
                                "gifi-600mAh-1",
                                "--current",
                                "i.csv",
                                "-o",
                                "p.csv",
                                "--quiet",
                                option,
                                value});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Numbers(ReadTextFile(folder + "/p.csv")).back();
  };
  EXPECT_EQ(simulate("--initial-soc", "0.5")[2], 3.82);  // a node of the curve
  EXPECT_NEAR(simulate("--initial-voltage-V", "3.82")[4], 0.5, 1e-12);
}

TEST(Simulate, RefusesWhatItCannotUseAndWritesNothing) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunShell(folder, "printf 'time_s,current_A\\n0,0\\n10,0\\n' >i.csv").exit_code, 0);
  const auto refused = [&](std::vector<std::string> more, const std::string& err) {
    std::vector<std::string> arguments{"simulate", "gifi-600mAh-1", "--current", "i.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 2) << err;
    EXPECT_EQ(run.err, "lipoid simulate: error: " + err + "\nTry 'lipoid simulate --help'.\n");
    EXPECT_EQ(FilesIn(folder), std::vector<std::string>{"i.csv"});
  };
  refused({},
          "option -o, --output CSV is missing: time_s, current_A, voltage_V, open_circuit_V, soc");
  refused({"-o", "p.csv", "--initial-soc", "1", "--initial-voltage-V", "4"},
          "options --initial-soc and --initial-voltage-V: give one of them");
  refused({"-o", "p.csv", "--initial-voltage-V", "5"},
          "initial voltage: expected one that v_oc(A) of the cell has, 3 .. 4.2 V, found 5 V");
  refused({"-o", "p.csv", "--units", "s,A"},
          "option --units: expected three, of time, current and voltage (s,A,V), found 's,A'");
  refused(
      {"-o", "p.csv", "--current-sign", "up"},
      "option --current-sign: expected auto, discharge-positive or discharge-negative, found 'up'");
  refused({"-o", "p.csv", "--hold", "sideways"},
          "option --hold: expected one of backward, forward, found 'sideways'");
  refused({"-o", "i.csv"}, "option -o, --output: 'i.csv' is also an input; name another file");
  // One name for two files: the summary still says why, and is not the prediction.
  const auto run = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "i.csv", "-o", "p.csv", "--summary", "p.csv"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(ReadJson(folder, "p.csv").at("error").at("message"),
            "options -o, --output and --summary: 'p.csv' is named twice; name two files");
}

TEST(Validate, FindsNoErrorInLogsOfTheSameCell) {
  const auto folder = FolderWithLogs();
  const auto run = RunLipoid(folder,
                             {"validate",
                              "logs/truth.json",
                              "logs/cc_2C.csv",
                              "logs/low_rate.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto logs = ReadJson(folder, "s.json").at("logs");
  ASSERT_EQ(logs.size(), 2U);
  EXPECT_EQ(logs[0].at("file"), "logs/cc_2C.csv");
  for (const auto& log : logs) {
    for (const char* key : {"mean_error_percent",
                            "max_error_percent",
                            "rmse_V",
                            "mean_error_percent_above_10_soc",
                            "rmse_V_above_10_soc"}) {
      EXPECT_EQ(log.at(key), 0.0) << key;
    }
  }
  EXPECT_NE(run.out.find("logs/low_rate.csv"), std::string::npos);
}

TEST(Validate, TheErrorIsTheOneThatWasPutIn) {
  // The cell has 10 mOhm more than the truth: 1.2 A makes 12 mV everywhere but in the row at rest.
  const auto folder = FolderWithLogs();
  auto cell = ReadJson(folder, "logs/truth.json");
  cell["series_resistance_Ohm"] = 0.1414;
  WriteFileAtomically(folder + "/other.json", cell.dump());
  const auto run =
      RunLipoid(folder, {"validate", "other.json", "logs/cc_2C.csv", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto log = ReadJson(folder, "s.json").at("logs").at(0);
  const auto rows = Numbers(ReadTextFile(folder + "/logs/cc_2C.csv"));
  const double n = static_cast<double>(rows.size());
  double percent = 0.0;
  for (const auto& row : rows) percent += row[1] > 0.0 ? 100.0 * 0.012 / row[2] : 0.0;
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(log.at("rmse_V"), 0.012 * std::sqrt((n - 1.0) / n), kRounding);
  EXPECT_NEAR(log.at("mean_error_percent"), percent / n, kRounding);
  EXPECT_NEAR(log.at("max_error_percent"), 100.0 * 0.012 / rows.back()[2], kRounding);
}

TEST(Validate, APackIsJudgedByItsCell) {
  const auto folder = FolderWithLogs({"--series", "4", "--parallel", "2"});
  auto cell = ReadJson(folder, "logs/truth.json");
  cell["series_resistance_Ohm"] = 0.1414;
  WriteFileAtomically(folder + "/other.json", cell.dump());
  const auto run =
      RunLipoid(folder, {"validate", "other.json", "logs/cc_2C.csv", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NEAR(ReadJson(folder, "s.json").at("logs").at(0).at("rmse_V"), 0.012, 1e-5);
}

TEST(Validate, EveryBadLogIsNamedAndTheSummaryHasThem) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunShell(folder, "printf 'time_s,current_A,voltage_V\\n0,0,4.2\\n1,x,4.1\\n' >a.csv")
                .exit_code,
            0);
  const auto run =
      RunLipoid(folder, {"validate", "gifi-600mAh-1", "a.csv", "none.csv", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(run.out, "");
  const auto error = ReadJson(folder, "s.json").at("error");
  EXPECT_EQ(error.at("kind"), "bad-input");
  ASSERT_EQ(error.at("diagnostics").size(), 2U) << error.dump(2);
  EXPECT_EQ(error.at("diagnostics")[0].at("file"), "a.csv");
  EXPECT_EQ(error.at("diagnostics")[0].at("line"), 3);
  EXPECT_EQ(error.at("diagnostics")[0].at("column"), 3);
  EXPECT_EQ(error.at("diagnostics")[1].at("file"), "none.csv");
}

}  // namespace
}  // namespace lipoid::test
