// lipoid plan, and the trust that lipoid identify prints, end to end. The figures themselves:
// tests/identify/trust/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/json_text.h"
#include "model/core/run_record.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

TEST(Plan, CombinesListsAndRangesIntoRows) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"plan",
                              "gifi-600mAh-1",
                              "--pulse-s",
                              "20:20:60,90",
                              "--rest-s",
                              "600,1800",
                              "--rate-C",
                              "2",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ParseJson(ReadTextFile(folder + "/s.json"), "s.json");
  ASSERT_EQ(summary["rows"].size(), 8U);
  const Json& first = summary["rows"][0];
  const Json& last = summary["rows"][7];
  EXPECT_EQ(first["pulse_s"], 20.0);
  EXPECT_EQ(last["pulse_s"], 90.0);
  EXPECT_EQ(last["rest_s"], 1800.0);
  EXPECT_EQ(first["parameters"][0]["name"], "beta");
  // Less rest, sooner done; longer pulses, beta better known.
  EXPECT_LT(first["duration_s"], summary["rows"][1]["duration_s"]);
  EXPECT_GT(first["parameters"][0]["standard_error"], last["parameters"][0]["standard_error"]);
  EXPECT_NE(run.out.find("hours"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("alpha and v_oc(A) are taken as known"), std::string::npos) << run.out;
}

TEST(Plan, AValueThatStandsTwiceIsRefused) {
  const auto folder = TestFolder();
  for (const std::string option : {"--pulse-s", "--rest-s", "--rate-C", "--sampling-s"}) {
    const auto run = RunLipoid(folder, {"plan", "gifi-600mAh-1", option, "10,20,10"});
    EXPECT_EQ(run.exit_code, 2) << option;
    EXPECT_NE(run.err.find("option " + option + ": 10 stands there twice"), std::string::npos)
        << run.err;
  }
}

// In a column of the table the verdicts took four lines a row.
TEST(Plan, RowsThatLeaveTheSameOpenShareASentence) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder,
                      {"synthesize",
                       "gifi-600mAh-1",
                       "--with",
                       "r_1=0.03,c_1=1500",
                       "--sampling-s",
                       "10",
                       "-o",
                       "logs"})
                .exit_code,
            0);
  const auto run = RunLipoid(folder,
                             {"plan",
                              "logs/truth.json",
                              "--pulse-s",
                              "5,20",
                              "--rest-s",
                              "20,600",
                              "--coloured-noise-V",
                              "0.02"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("\nRows 1, 2, 4: beta, r_1, tau_1, c_1 weak; the others identified.\n"
                         "Row 3: r_1, tau_1, c_1 weak; the others identified.\n"),
            std::string::npos)
      << run.out;
}

// The thesis' branch of 0.24 ms: rows every second cannot see it, and nothing must hang on it.
TEST(Plan, ABranchTooFastForTheRowsCountsWithTheSeriesResistance) {
  const auto folder = TestFolder();
  const auto run =
      RunLipoid(folder, {"plan", "gifi-600mAh-1", "--pulse-s", "10,30", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find("unknown"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("all identified"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("branch 1 is too fast to be seen in rows every 1 s (tau_1 = 0.000241 s): "
                         "its 2.36e-05 Ohm count\n     with r_s"),
            std::string::npos)
      << run.out;
  const Json parameters = ReadJson(folder, "s.json").at("rows")[0].at("parameters");
  ASSERT_EQ(parameters.size(), 2U);  // beta, r_s
  EXPECT_NEAR(parameters[1].at("estimate").get<double>(), 0.1314 + 2.3643e-5, 1e-12);
}

// A plan that takes a real cell for its model promises errors ten times too small.
TEST(Plan, SlowErrorsAreAtLeastWhatTheFitLeftOfTheLogs) {
  const auto folder = TestFolder();
  Json cell = CellToJson(LoadCell("gifi-600mAh-1"));
  cell["run"]["metrics"]["logs"] = {{{"file", "a.csv"}, {"rmse_V_above_10_soc", 0.006}},
                                    {{"file", "b.csv"}, {"rmse_V_above_10_soc", 0.008}},
                                    {{"file", "c.csv"}, {"rmse_V_above_10_soc", nullptr}}};
  WriteFileAtomically(folder + "/cell.json", JsonText(cell));
  const auto plan = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "plan");
    words.insert(words.end(), {"--summary", "s.json"});
    const auto run = RunLipoid(folder, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const Json summary = ReadJson(folder, "s.json");
    const Json& noise = summary.at("noise");
    // The same words, whatever the lines.
    std::string out = run.out;
    std::replace(out.begin(), out.end(), '\n', ' ');
    EXPECT_NE(out.find(noise.at("sentence").get<std::string>()), std::string::npos) << run.out;
    return summary;
  };
  const auto series_error = [](const Json& summary) {
    const Json& parameter = summary.at("rows")[0].at("parameters")[1];
    EXPECT_EQ(parameter.at("name"), "r_s");
    return parameter.at("standard_error").get<double>();
  };
  const Json of_fit = plan({"cell.json"});
  EXPECT_EQ(of_fit.at("noise").at("coloured_from"), "fit");
  EXPECT_NEAR(of_fit.at("noise").at("coloured_V").get<double>(), std::sqrt(5e-5), 1e-12);
  EXPECT_EQ(of_fit.at("noise").at("white_V"), 2e-4);
  const Json assumed = plan({"gifi-600mAh-1"});
  EXPECT_EQ(assumed.at("noise").at("coloured_from"), "assumed");
  EXPECT_EQ(assumed.at("noise").at("coloured_V"), 5e-4);
  EXPECT_GT(series_error(of_fit), 8.0 * series_error(assumed));
  const Json given = plan({"cell.json", "--coloured-noise-V", "0.0005"});
  EXPECT_EQ(given.at("noise").at("coloured_from"), "given");
  EXPECT_EQ(series_error(given), series_error(assumed));
  // What is left from row to row alone is no slow error: 5e-5 V^2 in all.
  cell["run"]["metrics"]["trust"]["residual_correlation"] = {{{"white_V", 0.007}},
                                                             {{"white_V", 0.005}}};
  WriteFileAtomically(folder + "/cell.json", JsonText(cell));
  const Json mixed = plan({"cell.json"});
  EXPECT_EQ(mixed.at("noise").at("coloured_from"), "fit");
  EXPECT_NEAR(mixed.at("noise").at("white_V").get<double>(), std::sqrt(3.7e-5), 1e-12);
  EXPECT_NEAR(mixed.at("noise").at("coloured_V").get<double>(), std::sqrt(1.3e-5), 1e-12);
  EXPECT_LT(series_error(mixed), 0.7 * series_error(of_fit));  // slow errors of half the size
  EXPECT_EQ(plan({"cell.json", "--coloured-noise-V", "0.0005"}).at("noise").at("white_V"), 2e-4);
}

// Terms of the cell that the analysis does not have are none of "every parameter".
TEST(Plan, NamesTheTermsThatItLeavesOut) {
  const auto folder = TestFolder();
  Json cell = CellToJson(LoadCell("gifi-600mAh-1"));
  cell["charge_transfer"] = {{"resistance_Ohm", 0.02}, {"current_A", 0.5}};
  cell["series_resistance_Ohm"] = {{"soc", {0.0, 1.0}}, {"resistance_Ohm", {0.2, 0.13}}};
  WriteFileAtomically(folder + "/cell.json", JsonText(cell));
  const auto run = RunLipoid(folder, {"plan", "cell.json", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  const Json& row = summary.at("rows")[0];
  EXPECT_TRUE(
      row.at("sentence")
          .get<std::string>()
          .ends_with(
              "; the plan says nothing of resistance over the state of charge, charge transfer, which the "
              "cell has"))
      << row.at("sentence");
  EXPECT_NE(run.out.find("charge transfer of the cell is not in the plan"), std::string::npos)
      << run.out;
  EXPECT_TRUE(summary.at("left_out")
                  .back()
                  .get<std::string>()
                  .ends_with("keep to the data sheet of the cell (--rate-C)"))
      << summary.at("left_out");
  // Noise that is assumed leaves no residuals to take it from.
  for (const Json& parameter : row.at("parameters")) {
    EXPECT_TRUE(parameter.at("white_standard_error").is_null()) << parameter;
    EXPECT_GT(parameter.at("standard_error").get<double>(), 0.0);
  }
}

// A pulse that empties the cell, or no rest: identify refuses such logs, and they are no advice.
TEST(Plan, LeavesOutWhatIdentifyWouldRefuse) {
  const auto folder = TestFolder();
  const auto rows = RunLipoid(
      folder, {"plan", "gifi-600mAh-1", "--sampling-s", "5,7,60", "--summary", "rows.json"});
  ASSERT_EQ(rows.exit_code, 0) << rows.err;
  const Json of_rows = ReadJson(folder, "rows.json");
  ASSERT_EQ(of_rows.at("rows").size(), 1U);
  EXPECT_EQ(
      of_rows.at("left_out")[0],
      "expected pulses and rests of whole rows, one every 7 s; take pulses of 28 or 35 s in place "
      "of 30 s, and rests of 1764 or 1771 s in place of 1770 s");
  const auto run = RunLipoid(
      folder, {"plan", "gifi-600mAh-1", "--pulse-s", "100,250,300", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  ASSERT_EQ(summary.at("rows").size(), 2U);
  EXPECT_EQ(summary.at("rows")[1].at("pulse_s"), 250.0);
  EXPECT_EQ(summary.at("left_out")[0],
            "pulses.csv: a pulse of 300 s at 3.6 A empties the cell after 266 s, before any rest, "
            "and identify takes no such log for pulses; take shorter pulses or a lower rate");
  for (const std::vector<std::string>& at :
       {std::vector<std::string>{}, std::vector<std::string>{"--ambient-degC", "25"}}) {
    std::vector<std::string> arguments{
        "plan", "gifi-600mAh-1", "--rest-s", "0", "--sampling-s", "5"};
    arguments.insert(arguments.end(), at.begin(), at.end());
    const auto none = RunLipoid(folder, arguments);
    EXPECT_EQ(none.exit_code, 2);
    EXPECT_NE(none.err.find("expected rests of at least 2 rows between the pulses; "
                            "take rests of at least 10 s"),
              std::string::npos)
        << none.err;
  }
}

TEST(Plan, RefusesWhatIsNoPlan) {
  const auto folder = TestFolder();
  for (const std::string bad : {"0", "1:1", "ten", "1,,2"}) {
    SCOPED_TRACE(bad);
    const auto run = RunLipoid(folder, {"plan", "gifi-600mAh-1", "--pulse-s", bad});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find("--pulse-s"), std::string::npos) << run.err;
  }
  const auto warm = RunLipoid(folder, {"plan", "gifi-600mAh-1", "--ambient-degC", "300"});
  EXPECT_EQ(warm.exit_code, 2);
  EXPECT_NE(warm.err.find("--ambient-degC"), std::string::npos) << warm.err;
  const auto silent = RunLipoid(
      folder, {"plan", "gifi-600mAh-1", "--voltage-noise-V", "0", "--coloured-noise-V", "0"});
  EXPECT_EQ(silent.exit_code, 2);
  EXPECT_NE(silent.err.find("expected one above 0, found 0 V for both"), std::string::npos)
      << silent.err;
  EXPECT_EQ(RunLipoid(folder, {"plan", "gifi-600mAh-1", "--sampling-s", "60"}).exit_code, 2)
      << "a pulse of 30 s every 60 s";
}

TEST(Plan, SaysWhatASecondTemperatureWouldTell) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"plan",
                              "gifi-600mAh-1",
                              "--ambient-degC",
                              "25",
                              "--second-degC",
                              "0,-5",
                              "--sampling-s",
                              "5",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* said : {"+ pulses at",
                           "+ one pulse at",
                           "the same pulses at 0 degC would tell E_d within",
                           "activation energies and heat balance of the cell are typical values"})
    EXPECT_NE(run.out.find(said), std::string::npos) << said << "\n" << run.out;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary["temperature_assumed"], true);
  const Json& rows = summary["rows"];
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_TRUE(rows[0]["second_degC"].is_null());
  EXPECT_EQ(rows[2]["second_degC"], 0.0);
  EXPECT_EQ(rows[2]["second_pulses"], "one");
  EXPECT_EQ(rows[3]["second_pulses"], "all");
  EXPECT_EQ(rows[3]["ambient_degC"], Json::array({25.0}));
  EXPECT_LT(rows[3]["coldest_degC"], -4.9);
  // A cell that knows no temperature, and no option of it: as ever.
  ASSERT_EQ(RunLipoid(folder, {"plan", "gifi-600mAh-1", "--summary", "plain.json"}).exit_code, 0);
  const Json plain = ReadJson(folder, "plain.json");
  EXPECT_FALSE(plain.contains("temperature_assumed"));
  EXPECT_FALSE(plain["rows"][0].contains("ambient_degC"));
}

// The rate is that of what synthesize would write at these temperatures; at -25 degC the cell gives no such pulses.
TEST(Plan, ASecondTemperatureDoesNotChooseTheRate) {
  const auto folder = TestFolder();
  for (const std::vector<std::string>& rate :
       {std::vector<std::string>{}, std::vector<std::string>{"--rate-C", "3"}}) {
    std::vector<std::string> arguments{"plan",
                                       "gifi-600mAh-1",
                                       "--ambient-degC",
                                       "25,0",
                                       "--sampling-s",
                                       "10",
                                       "--summary",
                                       "s.json"};
    arguments.insert(arguments.end(), rate.begin(), rate.end());
    const auto run = RunLipoid(folder, arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json summary = ReadJson(folder, "s.json");
    const Json& rows = summary.at("rows");
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[0].at("rate_C"), 3.0);
    EXPECT_GT(rows[1].at("second_degC"), -25.0);
    EXPECT_EQ(
        summary.at("left_out")[0],
        "pulses_-25degC.csv: the full cell is at its cut-off of 3 V at once, at 1.8 A; take a "
        "lower rate");
  }
}

// What is planned can be synthesized, and is what identify reads.
TEST(Plan, ACampaignOfTwoTemperaturesIsIdentified) {
  const auto folder = TestFolder();
  const auto made = RunLipoid(folder,
                              {"synthesize",
                               "gifi-600mAh-1",
                               "--ambient-degC",
                               "25,0",
                               "--rates-C",
                               "1,2",
                               "--sampling-s",
                               "10",
                               "--voltage-noise-V",
                               "0.0005",
                               "-o",
                               "logs"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.err.find("typical values about 25 degC are assumed"), std::string::npos)
      << made.err;
  const std::string campaign = ReadTextFile(folder + "/logs/campaign.toml");
  EXPECT_NE(campaign.find("file = \"pulses_0degC.csv\""), std::string::npos) << campaign;
  EXPECT_NE(campaign.find("ambient_degC = 0.0"), std::string::npos) << campaign;
  const auto run = RunLipoid(folder,
                             {"identify",
                              "logs/campaign.toml",
                              "--truth",
                              "logs/truth.json",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  ASSERT_LE(run.exit_code, 1) << run.err;
  const Json cell = ReadJson(folder, "cell.json");
  // 20 kJ/mol is what is assumed of a series resistance.
  EXPECT_NEAR(
      cell["temperature"]["activation_energy_J_per_mol"]["series"].get<double>(), 20e3, 1e3);
}

TEST(Plan, IdentifySaysHowFarToBelieveIt) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder,
                      {"synthesize",
                       "gifi-600mAh-1",
                       "--with",
                       "r_1=0.03,c_1=1500",
                       "--rates-C",
                       "1,2,3",
                       "--sampling-s",
                       "2",
                       "--voltage-noise-V",
                       "0.0002",
                       "--seed",
                       "1",
                       "-o",
                       "logs"})
                .exit_code,
            0);
  const auto run = RunLipoid(folder,
                             {"identify",
                              "logs/campaign.toml",
                              "--method",
                              "staged",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("the intervals take alpha and v_oc(A) as exact"), std::string::npos)
      << run.out;
  const Json summary = ParseJson(ReadTextFile(folder + "/s.json"), "s.json");
  std::string names;
  for (const auto& q : summary["parameters"]) {
    names += q["name"].get<std::string>() + " ";
    EXPECT_EQ(q["interval_95"].size(), 2U);
    EXPECT_TRUE(q["with"].is_array());
  }
  EXPECT_EQ(names, "alpha beta r_s r_1 tau_1 c_1 ");
  EXPECT_EQ(summary["parameters"][2]["verdict"], "identified");
  EXPECT_FALSE(summary["trust"]["sentence"].get<std::string>().empty());
  EXPECT_EQ(summary["trust"]["singular_values"].size(), 4U);
  EXPECT_EQ(summary["trust"]["residual_correlation"].size(), 1U);
}

TEST(Plan, SaysWhatIsNotInIt) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"plan", "gifi-600mAh-1", "--temperature-noise-degC", "0.5"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("option --temperature-noise-degC changes nothing here"), std::string::npos)
      << run.err;
}

}  // namespace
}  // namespace lipoid::test
