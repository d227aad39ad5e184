// lipoid simulate and lipoid validate, end to end, on logs whose truth is known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "model/battery/cell_file.h"
#include "model/battery/typical_temperature.h"
#include "model/core/atomic_file.h"
#include "model/core/json_text.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

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

// Without a voltage nothing tells the sign. What charges a full cell further is said to, first by the
// reader, then by the result and the exit code.
TEST(Simulate, SaysThatACellWouldHoldMoreThanItCan) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/in.csv", "time_s,current_A\n0,0\n1200,-0.3\n2400,-0.3\n");
  const std::vector<std::string> arguments{
      "simulate", "gifi-600mAh-1", "--current", "in.csv", "-o", "p.csv"};
  const auto run = RunLipoid(folder, arguments);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(
      run.err.find("in.csv: there is no voltage to tell the sign of the current; discharge is "
                   "taken as positive, and so 0.2 Ah are charged"),
      std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find("the log charges the cell to a soc of "), std::string::npos) << run.err;
  auto turned = arguments;
  turned.insert(turned.end(), {"--current-sign", "discharge-negative"});
  const auto discharged = RunLipoid(folder, turned);
  EXPECT_EQ(discharged.exit_code, 0) << discharged.err;
}

// A cell file that was fitted to other logs may hold less than this cell, which then begins beyond full.
TEST(Simulate, ACellThatBeginsBeyondFullIsNotChargedByItsLog) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/in.csv", "time_s,current_A\n0,0\n600,0.3\n1200,0.3\n");
  const auto run = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "in.csv", "--initial-soc", "1.3", "-o", "p.csv"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

// A sensor that is not there, kelvin, and a row without a number: the column is left out, and it is said.
TEST(Validate, SaysWhereATemperatureIsNone) {
  const auto folder = TestFolder();
  const std::pair<const char*, const char*> cases[] = {
      {"-300", "temperature left out: -300 degC at 0 s is not within -60 to 150; what"},
      {"298.15",
       "temperature left out: 298.15 degC at 0 s is not within -60 to 150, but the whole column "
       "would be in kelvin; what"},
      {"", "temperature left out, for some rows hold no number: what"}};
  for (const auto& [degC, expected] : cases) {
    std::string text = "time_s,current_A,voltage_V,temperature_degC\n";
    for (int k = 0; k < 60; ++k) {
      text += fmt::format("{},{},{},{}\n", 10 * k, k == 0 ? 0.0 : 0.6, 4.15 - 0.003 * k, degC);
    }
    WriteFileAtomically(folder + "/in.csv", text);
    const auto run = RunLipoid(folder, {"validate", "gifi-600mAh-1", "in.csv"});
    EXPECT_NE(run.err.find(expected), std::string::npos) << run.err;
  }
}

// The cell file says three in series, the log is one of a single cell.
TEST(Validate, AsksWhetherTheLogIsOneOfASingleCell) {
  const auto folder = FolderWithLogs();
  Json pack = CellToJson(LoadCell("gifi-600mAh-1"));
  pack["series"] = 3;
  WriteFileAtomically(folder + "/pack.json", JsonText(pack));
  const auto run = RunLipoid(folder, {"validate", "pack.json", "logs/cc_2C.csv"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("is this log one of a single cell? Then say `series` = 1 (--series 1)"),
            std::string::npos)
      << run.err;
  const auto one = RunLipoid(folder, {"validate", "pack.json", "logs/cc_2C.csv", "--series", "1"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
}

// mA under a header of A: 600 A from a cell of 0.6 Ah.
TEST(Validate, RefusesWhatNoCellOfThisSizeDoes) {
  const auto folder = TestFolder();
  std::string text = "time_s,current_A,voltage_V\n";
  for (int k = 0; k < 60; ++k) {
    text += fmt::format("{},{},{}\n", 10 * k, k == 0 ? 0 : 600, 4.15 - 0.003 * k);
  }
  WriteFileAtomically(folder + "/in.csv", text);
  const auto run = RunLipoid(folder, {"validate", "gifi-600mAh-1", "in.csv"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("in.csv"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("mA"), std::string::npos) << run.err;
}

TEST(Validate, SaysThatACellKnowsNoTemperature) {
  const auto folder = FolderWithLogs();
  const auto run =
      RunLipoid(folder, {"validate", "gifi-600mAh-1", "logs/cc_2C.csv", "--ambient-degC", "-40"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("--ambient-degC: the cell file knows no temperature"), std::string::npos)
      << run.err;
  const auto first =
      RunLipoid(folder, {"validate", "gifi-600mAh-1", "logs/cc_2C.csv", "--initial-degC", "40"});
  EXPECT_NE(first.err.find("--initial-degC: the cell file knows no temperature"), std::string::npos)
      << first.err;
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
  refused(
      {},
      "option -o, --output CSV is missing: time_s, current_A, voltage_V, open_circuit_V, soc; "
      "temperature_degC of a cell that knows temperature; with --ensemble voltage_low_V and voltage_high_V");
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
  // One name for two files: neither is written.
  const auto run = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "i.csv", "-o", "p.csv", "--summary", "p.csv"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("options -o, --output and --summary: 'p.csv' is named twice; name two "
                         "files"),
            std::string::npos)
      << run.err;
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{"i.csv"});
}

// cell.json, whose r_s alone is uncertain, by 4 mOhm, and i.csv: half an hour of rests and pulses.
std::string FolderWithUncertainCellAndCurrent() {
  auto folder = TestFolder();
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty = Cell::Uncertainty{
      .parameters = {"r_s"}, .covariance = {{1.6e-5}}, .degrees_of_freedom = 10.0};
  WriteCellFile(cell, folder + "/cell.json");
  std::string text = "time_s,current_A\n";
  for (int k = 0; k < 360; ++k) text += fmt::format("{},{}\n", 5 * k, k % 3 == 0 ? 0.0 : 0.6);
  WriteFileAtomically(folder + "/i.csv", text);
  return folder;
}

TEST(Simulate, AnEnsembleAddsTheBandOfEachRow) {
  const auto folder = FolderWithUncertainCellAndCurrent();
  const auto simulate = [&](const std::string& output, std::vector<std::string> more) {
    std::vector<std::string> arguments{"simulate",
                                       "cell.json",
                                       "--current",
                                       "i.csv",
                                       "--summary",
                                       "s.json",
                                       "--initial-soc",
                                       "0.9",
                                       "-o",
                                       output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunLipoid(folder, arguments);
  };
  auto run = simulate("band.csv", {"--ensemble", "400", "--seed", "3"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto text = ReadTextFile(folder + "/band.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "time_s,current_A,voltage_V,open_circuit_V,soc,voltage_low_V,voltage_high_V");
  // The quantile of Student's t with 10 degrees of freedom, and the chance of one out of 400
  // numbers: sqrt(p (1 - p)/N)/0.0297 = 0.26 standard errors, four of them.
  constexpr double kError_V = 0.004 * 0.6;
  double sum_V = 0.0;
  double most_V = 0.0;
  const auto rows = Numbers(text);
  ASSERT_EQ(rows.size(), 360U);
  for (const auto& row : rows) {
    const double drop_V = row[1] > 0.0 ? kError_V : 0.0;
    ASSERT_NEAR(row[5], row[2] - 2.2281 * drop_V, 1.05 * drop_V + 1e-12);
    ASSERT_NEAR(row[6], row[2] + 2.2281 * drop_V, 1.05 * drop_V + 1e-12);
    sum_V += row[6] - row[5];
    most_V = std::max(most_V, row[6] - row[5]);
  }
  const auto ensemble = ReadJson(folder, "s.json").at("ensemble");
  EXPECT_EQ(ensemble.at("cells"), 400);
  EXPECT_EQ(ensemble.at("seed"), 3);
  EXPECT_EQ(ensemble.at("moved"), 0);
  EXPECT_EQ(ensemble.at("rows_outside_band"), 0);
  EXPECT_EQ(run.err.find("moved to the nearest"), std::string::npos) << run.err;
  EXPECT_NEAR(ensemble.at("band_mean_V").get<double>(), sum_V / 360.0, 1e-12);
  EXPECT_NEAR(ensemble.at("band_max_V").get<double>(), most_V, 1e-12);
  EXPECT_NE(run.err.find("95 % of 400 cells lie within a band of"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("quantiles take"), std::string::npos) << run.err;

  // The same seed, the same band, whatever the threads; without the option nothing is added.
  ASSERT_EQ(simulate("again.csv", {"--ensemble", "400", "--seed", "3", "--threads", "1"}).exit_code,
            0);
  EXPECT_EQ(ReadTextFile(folder + "/again.csv"), text);
  ASSERT_EQ(simulate("plain.csv", {}).exit_code, 0);
  EXPECT_FALSE(ReadJson(folder, "s.json").contains("ensemble"));
  const auto plain = Numbers(ReadTextFile(folder + "/plain.csv"));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ASSERT_EQ(plain[k].size(), 5U);
    ASSERT_EQ(plain[k][2], rows[k][2]);
  }

  run = simulate("few.csv", {"--ensemble", "10"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("of 10 cells the interval is that from the lowest to the highest, which "
                         "may leave out the estimate: quantiles take 39"),
            std::string::npos)
      << run.err;
}

// v_oc is known: each cell that is drawn starts where its own curve has the voltage.
TEST(Simulate, AnEnsembleStartsAtTheVoltageThatWasMeasured) {
  const auto folder = TestFolder();
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty = Cell::Uncertainty{
      .parameters = {"v_oc[7]"}, .covariance = {{1e-4}}, .degrees_of_freedom = 1e7};
  WriteCellFile(cell, folder + "/cell.json");
  WriteFileAtomically(folder + "/i.csv", "time_s,current_A\n0,0\n10,0\n");
  const auto run = RunLipoid(folder,
                             {"simulate",
                              "cell.json",
                              "--current",
                              "i.csv",
                              "--initial-voltage-V",
                              "3.82",
                              "--ensemble",
                              "50",
                              "-o",
                              "p.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const auto& row : Numbers(ReadTextFile(folder + "/p.csv"))) {
    EXPECT_NEAR(row[5], 3.82, 1e-9);
    EXPECT_NEAR(row[6], 3.82, 1e-9);
  }
}

TEST(Simulate, AnEnsembleNeedsACellThatSaysHowUncertainItIs) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/i.csv", "time_s,current_A\n0,0\n10,0\n");
  const auto error = [&](const std::string& count) {
    const auto run = RunLipoid(
        folder,
        {"simulate", "gifi-600mAh-1", "--current", "i.csv", "--ensemble", count, "-o", "p.csv"});
    return std::to_string(run.exit_code) + " " + run.err.substr(0, run.err.find('\n'));
  };
  EXPECT_EQ(
      error("100"),
      "3 gifi-600mAh-1:1:1: error: expected the key 'uncertainty' for --ensemble, found none: "
      "identify the cell again with this version of lipoid, or leave --ensemble out");
  EXPECT_EQ(error("-1").substr(0, 2), "2 ");
  EXPECT_EQ(FilesIn(folder), std::vector<std::string>{"i.csv"});
}

// A file of a shipped cell that knows temperature, and warms.
void WriteColdCell(const std::string& folder) {
  Cell cell = LoadCell("gifi-600mAh-1");
  Cell::Temperature& term = cell.temperature.emplace();
  term.series_J_per_mol = 20e3;
  term.branches_J_per_mol.assign(cell.branches.size(), 40e3);
  term.diffusion_J_per_mol = 40e3;
  term.heat = HeatBalance<double>{15.0, 20.0};
  WriteCellFile(cell, folder + "/cold.json");
}

TEST(Simulate, ACellInTheColdWarmsAndEndsEarlier) {
  const auto folder = FolderWithLogs();
  WriteColdCell(folder);
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"simulate",
                                       "cold.json",
                                       "--current",
                                       "logs/cc_2C.csv",
                                       "-o",
                                       "p.csv",
                                       "--summary",
                                       "s.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunLipoid(folder, arguments);
  };
  ASSERT_EQ(run({}).exit_code, 0);
  const auto warm = ReadTextFile(folder + "/p.csv");
  EXPECT_EQ(warm.find("time_s,current_A,voltage_V,open_circuit_V,soc,temperature_degC\n"), 0U);
  const auto warm_rows = Numbers(warm);
  EXPECT_NEAR(warm_rows[0][5], 25.0, 1e-9);
  EXPECT_GT(warm_rows.back()[5], 25.5);
  EXPECT_EQ(run({"--ambient-degC", "-15"}).exit_code, 1) << "it ends before the current does";
  const auto cold_rows = Numbers(ReadTextFile(folder + "/p.csv"));
  EXPECT_NEAR(cold_rows[0][5], -15.0, 1e-9);
  EXPECT_GT(cold_rows.back()[5], -14.0);
  EXPECT_LT(cold_rows.size(), warm_rows.size());
  EXPECT_LT(cold_rows[100][2], warm_rows[100][2] - 0.1);
  EXPECT_EQ(run({"--ambient-degC", "-300"}).exit_code, 2);
  EXPECT_NE(
      run({"--initial-degC", "20"}).err.find("is predicted in surroundings of 25 degC; --ambient"),
      std::string::npos);
  // A pack that was kept warm until it flies in the cold.
  (void)run({"--ambient-degC", "-15", "--initial-degC", "20"});
  const auto kept_warm_rows = Numbers(ReadTextFile(folder + "/p.csv"));
  EXPECT_NEAR(kept_warm_rows[0][5], 20.0, 1e-9);
  EXPECT_GT(kept_warm_rows[100][2], cold_rows[100][2] + 0.1);
  EXPECT_LT(kept_warm_rows.back()[5], 20.0);
  EXPECT_EQ(run({"--initial-degC", "-300"}).exit_code, 2);
}

TEST(Validate, TakesTheMeasuredTemperatureOrPredictsIt) {
  const auto folder = FolderWithLogs();
  WriteColdCell(folder);
  const auto simulated = RunLipoid(folder,
                                   {"simulate",
                                    "cold.json",
                                    "--current",
                                    "logs/cc_2C.csv",
                                    "--ambient-degC",
                                    "0",
                                    "--beyond-cutoff",
                                    "-o",
                                    "measured.csv"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto errors = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "validate", "cold.json", "measured.csv", "--summary", "s.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(ReadTextFile(folder + "/s.json"))["logs"][0];
  };
  // CSV keeps every digit.
  const Json measured = errors({});
  EXPECT_LT(measured["rmse_V"].get<double>(), 1e-9);
  EXPECT_FALSE(measured.contains("temperature_rmse_K"));
  const Json predicted = errors({"--predict-temperature"});
  EXPECT_LT(predicted["rmse_V"].get<double>(), 1e-9);
  EXPECT_LT(predicted["temperature_rmse_K"].get<double>(), 1e-9);
  const Json warmer = errors({"--predict-temperature", "--ambient-degC", "10"});
  EXPECT_GT(warmer["rmse_V"].get<double>(), 1e-3);
  const Json from_warmer = errors({"--predict-temperature", "--initial-degC", "10"});
  EXPECT_GT(from_warmer["rmse_V"].get<double>(), 1e-3);
  EXPECT_LT(from_warmer["rmse_V"].get<double>(), warmer["rmse_V"].get<double>())
      << "it cools to the 0 degC of the log's first row";
  // Where the log has it, that is what counts, and it is said.
  const auto both =
      RunLipoid(folder, {"validate", "cold.json", "measured.csv", "--initial-degC", "10"});
  EXPECT_NE(both.err.find("used in place of --initial-degC"), std::string::npos) << both.err;
  EXPECT_EQ(errors({"--initial-degC", "10"})["rmse_V"], measured["rmse_V"]);
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

// A current that ends where the cut-off is reached is written whole, and it is said.
TEST(Simulate, SaysThatTheLastRowLiesBelowTheCutOff) {
  const auto folder = TestFolder();
  // 0.376 Ah at 0.6 A last 2250 s less what diffusion holds back.
  std::string text = "time_s,current_A\n0,0\n";
  for (int t = 60; t <= 2100; t += 60) text += fmt::format("{},0.6\n", t);
  WriteFileAtomically(folder + "/in.csv", text);
  const auto whole =
      RunLipoid(folder, {"simulate", "gifi-600mAh-1", "--current", "in.csv", "-o", "p.csv"});
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_EQ(whole.err.find("below the cut-off"), std::string::npos) << whole.err;
  double before_V = Numbers(ReadTextFile(folder + "/p.csv")).back()[2];
  for (int t = 2110; before_V > 3.0; t += 10) {
    text += fmt::format("{},0.6\n", t);
    WriteFileAtomically(folder + "/in.csv", text);
    const auto run =
        RunLipoid(folder, {"simulate", "gifi-600mAh-1", "--current", "in.csv", "-o", "p.csv"});
    before_V = Numbers(ReadTextFile(folder + "/p.csv")).back()[2];
    EXPECT_EQ(run.err.find("the last row, ") != std::string::npos, before_V < 2.995) << run.err;
    if (before_V > 3.0) continue;
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }
}

TEST(Validate, ALogGivenTwiceIsNamedWithoutAnOptionThatIsNot) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/a.csv", "time_s,current_A,voltage_V\n0,0,4.1\n10,0.6,4.0\n");
  const auto run = RunLipoid(folder, {"validate", "gifi-600mAh-1", "a.csv", "a.csv"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("error: 'a.csv' is given twice; name each log once"), std::string::npos)
      << run.err;
}

// A cell that was identified in the warm says nothing of the cold, whatever its energies.
TEST(Simulate, SaysWhereItGoesBeyondTheTemperaturesThatWereSeen) {
  const auto folder = TestFolder();
  Json cell = CellToJson(WithTypicalTemperature(LoadCell("gifi-600mAh-1")));
  cell["temperature"].erase("assumed");
  cell["temperature"]["seen_degC"] = {10.0, 40.0};
  WriteFileAtomically(folder + "/cell.json", JsonText(cell));
  WriteText(folder + "/current.csv", "time_s,current_A\n0,0\n1,1\n2,1\n");
  WriteText(folder + "/cold.csv", "time_s,current_A,temperature_degC\n0,0,-8\n1,1,-8\n2,1,-7\n");
  const std::string doubt = "was identified from logs between 10 and 40 degC: at ";
  const auto says = [&](const std::vector<std::string>& words) {
    const auto run = RunLipoid(folder, words);
    std::string text = run.err;
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text.find(doubt) != std::string::npos;
  };
  EXPECT_FALSE(says(
      {"simulate", "cell.json", "--current", "current.csv", "-o", "p.csv", "--ambient-degC", "6"}));
  EXPECT_TRUE(says({"simulate",
                    "cell.json",
                    "--current",
                    "current.csv",
                    "-o",
                    "p.csv",
                    "--ambient-degC",
                    "-10"}));
  EXPECT_TRUE(says({"simulate", "cell.json", "--current", "cold.csv", "-o", "p.csv"}));
  WriteText(folder + "/log.csv", "time_s,current_A,voltage_V\n0,0,4.2\n1,1,4\n2,1,3.9\n3,1,3.9\n");
  EXPECT_TRUE(says({"validate", "cell.json", "log.csv", "--ambient-degC", "77"}));
  EXPECT_FALSE(says({"validate", "cell.json", "log.csv", "--ambient-degC", "20"}));
  std::ofstream(folder + "/other.csv")
      << "time_s,current_A,voltage_V\n0,0,4.2\n1,1,3.9\n2,1,3.8\n3,1,3.8\n";
  const auto both =
      RunLipoid(folder, {"validate", "cell.json", "log.csv", "other.csv", "--ambient-degC", "77"});
  EXPECT_NE(both.err.find(doubt), std::string::npos) << both.err;
  EXPECT_EQ(both.err.find(doubt), both.err.rfind(doubt)) << "of all logs once: " << both.err;
  EXPECT_TRUE(
      says({"fly", "hover", "--cell", "cell.json", "--duration", "1", "--ambient-degC", "-10"}));
  EXPECT_FALSE(says({"fly", "hover", "--cell", "cell.json", "--duration", "1"}));
  EXPECT_TRUE(says({"endurance",
                    "--vehicle",
                    "mambo-physical",
                    "--cell",
                    "cell.json",
                    "--ambient-degC",
                    "-10"}));
  const std::vector<std::string> table{
      "endurance", "--vehicle", "mambo-physical", "--cell", "cell.json", "--over"};
  const auto over = [&](const char* range) {
    auto words = table;
    words.emplace_back(range);
    return says(words);
  };
  EXPECT_TRUE(over("ambient-degC=-20:20:20"));
  EXPECT_FALSE(over("ambient-degC=10:10:20"));
}

// A cell without temperature, and a log 0.3 V off that was measured in the cold or in a room.
TEST(Validate, SaysWhereTheTemperatureMayBeWhyACellIsOff) {
  const auto folder = TestFolder();
  const auto said = [&](const std::string& cell, int degC) {
    std::ofstream log(folder + "/log.csv");
    log << "time_s,current_A,voltage_V,temperature_degC\n0,0,4.2," << degC << "\n";
    for (int k = 1; k <= 300; ++k) log << k << ",1," << 3.7 - 1e-3 * k << "," << degC << "\n";
    log.close();
    const auto run = RunLipoid(folder, {"validate", cell, "log.csv"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  };
  const std::string off =
      "degC on average, and the cell file knows no temperature (key `temperature`): ";
  const std::string told =
      ", that may be why the prediction is off; identify the cell from logs of both";
  const std::string cold = said("gifi-600mAh-1", -10);
  EXPECT_NE(
      cold.find("log.csv: it was -10 " + off + "if the cell was identified at another one" + told),
      std::string::npos)
      << cold;
  EXPECT_EQ(said("gifi-600mAh-1", 20).find(off), std::string::npos);
  Json cell = Json::parse(CellText("gifi-600mAh-1"));
  cell["reference_degC"] = 0.5;
  WriteText(folder + "/cold.json", cell.dump());
  EXPECT_EQ(said("cold.json", -5).find(off), std::string::npos);
  const std::string warm = said("cold.json", 20);
  // A cell that would know what temperature does, and is told none.
  Json knowing = CellToJson(WithTypicalTemperature(LoadCell("gifi-600mAh-1")));
  WriteText(folder + "/knowing.json", JsonText(knowing));
  std::ofstream(folder + "/silent.csv")
      << "time_s,current_A,voltage_V\n0,0,4.2\n1,1,3.3\n2,1,3.2\n3,1,3.1\n";
  const auto silent = RunLipoid(folder, {"validate", "knowing.json", "silent.csv"});
  EXPECT_NE(silent.err.find("silent.csv: it tells no temperature, and is predicted at 25 degC; "
                            "--ambient-degC says which it was"),
            std::string::npos)
      << silent.err;
  const auto simulated =
      RunLipoid(folder, {"simulate", "knowing.json", "--current", "silent.csv", "-o", "p.csv"});
  EXPECT_NE(
      simulated.err.find("silent.csv: it tells no temperature, and is predicted at 25 degC; "),
      std::string::npos)
      << simulated.err;
  EXPECT_NE(warm.find(off + "it was identified at 0.5 degC, and that may be why"),
            std::string::npos)
      << warm;
}

// Rest asks nothing of a cell, wherever it is; the sentence of a cut-off that is reached would be wrong.
TEST(Simulate, SaysThatTheCellBeginsBelowItsCutoff) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunShell(folder, "printf 'time_s,current_A\\n0,0\\n10,0\\n20,0.6\\n' >i.csv").exit_code,
            0);
  const auto run = RunLipoid(
      folder,
      {"simulate", "gifi-600mAh-1", "--current", "i.csv", "--initial-soc", "-0.2", "-o", "p.csv"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(
      run.err.find(
          "the cell is below its cut-off of 3 V before any current flows: 2 of 3 rows, at rest, "
          "were written"),
      std::string::npos)
      << run.err;
}

// The result is rows, and --latex is for tables.
TEST(Simulate, WritesNoTablesWhereThereAreNone) {
  const auto folder = FolderWithLogs();
  const auto run = RunLipoid(folder,
                             {"simulate",
                              "gifi-600mAh-1",
                              "--current",
                              "logs/cc_2C.csv",
                              "-o",
                              "p.csv",
                              "--latex",
                              "t.tex"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("t.tex: not written, for this result has no table"), std::string::npos)
      << run.err;
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"logs", "p.csv"}));
}

}  // namespace
}  // namespace lipoid::test
