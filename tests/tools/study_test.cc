// lipoid study, end to end. What the studies find: tests/identify/studies/.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "model/core/run_record.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

// Logs of a cell with one branch, below the folder.
void SynthesizeNoisyLogs(const std::string& folder) {
  const auto run = RunLipoid(folder,
                             {"synthesize",
                              "gifi-600mAh-1",
                              "--with",
                              "r_1=0.03,c_1=1500",
                              "--sampling-s",
                              "2",
                              "--voltage-noise-V",
                              "0.0005",
                              "--seed",
                              "1",
                              "--quiet",
                              "-o",
                              "logs"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// Logs by options are those of a campaign file, as with identify and compare.
TEST(Study, TakesLogsByOptions) {
  const auto folder = TestFolder();
  SynthesizeNoisyLogs(folder);
  const auto rows = [&](std::vector<std::string> logs) {
    logs.insert(logs.begin(), {"study", "branches"});
    logs.insert(logs.end(), {"--alpha-C", "1353.6", "--summary", "s.json"});
    const auto run = RunLipoid(folder, logs);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    Json table = ReadJson(folder, "s.json").at("rows");
    for (Json& row : table) row.erase("wall_s");
    return table;
  };
  std::vector<std::string> by_options{"--constant-current"};
  for (int rate = 1; rate <= 6; ++rate)
    by_options.push_back("logs/cc_" + std::to_string(rate) + "C.csv");
  by_options.insert(by_options.end(),
                    {"--low-rate",
                     "logs/low_rate.csv",
                     "--pulses",
                     "logs/pulses.csv",
                     "--cutoff-V",
                     "3",
                     "--capacity-Ah",
                     "0.6",
                     "--units",
                     "s,A,V"});
  EXPECT_EQ(rows(by_options), rows({"logs/campaign.toml"}));
  const auto none = RunLipoid(folder, {"study", "ocv"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("CAMPAIGN is missing"), std::string::npos) << none.err;
}

TEST(Study, BranchesPrintsATableAndRecommendsTheCellsOwn) {
  const auto folder = TestFolder();
  SynthesizeNoisyLogs(folder);
  const auto run = RunLipoid(folder,
                             {"study",
                              "branches",
                              "logs/campaign.toml",
                              "--alpha-C",
                              "1353.6",
                              "--open-circuit-voltage",
                              "logs/truth.json",
                              "--summary",
                              "s.json",
                              "--csv",
                              "t.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("rmse / mV"), std::string::npos) << run.out;
  // One row for 0 to 5 branches below a header that may take two lines.
  std::istringstream lines(run.out);
  int rows = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find_first_not_of(' ');
    if (first != std::string::npos && line[first] >= '0' && line[first] <= '9') ++rows;
  }
  EXPECT_EQ(rows, 6) << run.out;
  EXPECT_NE(run.err.find("1 branch is recommended"), std::string::npos) << run.err;

  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("study"), "branches");
  EXPECT_EQ(summary.at("recommended_branches"), 1);
  ASSERT_EQ(summary.at("rows").size(), 6U);
  // Of r_s and branches as fast as the rows only the sum is known, and none is negative for it.
  for (const auto& row : summary.at("rows")) {
    for (const auto& [name, value] : row.at("parameters").items()) {
      if (value.is_number()) {
        EXPECT_GE(value.get<double>(), 0.0) << name;
      }
    }
  }

  const auto csv = ReadTextFile(folder + "/t.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "branches,wall_s,mean_error_percent,max_error_percent,rmse_V,free_parameters,"
            "information_criterion,recommended,at_bound");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
}

TEST(Study, OcvAndTermsGiveRows) {
  const auto folder = TestFolder();
  SynthesizeNoisyLogs(folder);
  for (const char* what : {"ocv", "terms"}) {
    const auto run = RunLipoid(
        folder, {"study", what, "logs/campaign.toml", "--summary", "s.json", "--csv", "t.csv"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto summary = ReadJson(folder, "s.json");
    const auto rows = summary.at("rows").size();
    EXPECT_GE(rows, 16U);
    const auto csv = ReadTextFile(folder + "/t.csv");
    const auto lines = static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n'));
    EXPECT_EQ(lines, rows + 1);
    // A line each below the header, which may need several.
    const auto table = static_cast<std::size_t>(std::count(run.out.begin(), run.out.end(), '\n'));
    EXPECT_GE(table, rows + 1);
    EXPECT_LE(table, rows + 4);
    for (const auto& row : summary.at("rows")) {
      EXPECT_GT(row.at("rmse_V").get<double>(), 0.0);
      EXPECT_GT(row.at("wall_s").get<double>(), 0.0);
    }
  }
}

TEST(Study, SaysThatAParameterThatIsHeldIsOffByNothing) {
  const auto folder = TestFolder();
  SynthesizeNoisyLogs(folder);
  const auto run =
      RunLipoid(folder, {"study", "terms", "logs/campaign.toml", "--fix", "beta=0.19"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE((run.out + run.err).find("beta is held at 0.19 s^-1/2 in every fit"), std::string::npos)
      << run.out << run.err;
}

// As `lipoid identify --method staged` does.
TEST(Study, FitsThatDidNotConvergeEndWithOne) {
  const auto folder = TestFolder();
  SynthesizeNoisyLogs(folder);
  for (const char* what : {"branches", "terms"}) {
    const auto study = [&](const char* iterations) {
      return RunLipoid(folder,
                       {"study",
                        what,
                        "logs/campaign.toml",
                        "--set",
                        std::string("solver.max_iterations=") + iterations,
                        "--summary",
                        "s.json"});
    };
    const auto stopped = study("1");
    EXPECT_EQ(stopped.exit_code, 1);
    EXPECT_NE(stopped.err.find("not converged: "), std::string::npos) << stopped.err;
    EXPECT_EQ(ReadJson(folder, "s.json").at("converged"), false);
    EXPECT_EQ(ReadJson(folder, "s.json").at("rows")[1].at("termination"), "max-iterations");
    const auto whole = study("200");
    EXPECT_EQ(whole.exit_code, 0) << whole.err;
    EXPECT_EQ(whole.err.find("not converged"), std::string::npos) << whole.err;
    EXPECT_EQ(ReadJson(folder, "s.json").at("converged"), true);
    EXPECT_EQ(ReadJson(folder, "s.json").at("rows")[1].at("termination"), "converged");
  }
}

TEST(Study, AnUnknownStudyIsAUsageErrorThatListsTheKnown) {
  const auto run = RunLipoid(TestFolder(), {"study", "branch", "campaign.toml"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.out, "");
  EXPECT_NE(run.err.find("unknown study 'branch'. Did you mean 'branches'? Known: branches, ocv, "
                         "terms"),
            std::string::npos)
      << run.err;
}

TEST(Study, AMissingCampaignIsBadInput) {
  const auto run = RunLipoid(TestFolder(), {"study", "ocv", "none.toml"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("none.toml"), std::string::npos) << run.err;
}

TEST(Study, HelpSaysWhatEachIsAndShowsAnExample) {
  const auto run = RunLipoid(TestFolder(), {"study", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  for (const char* text : {"branches:", "ocv:", "terms:", "lipoid study branches campaign.toml"})
    EXPECT_NE(run.out.find(text), std::string::npos) << text;
}

}  // namespace
}  // namespace lipoid::test
