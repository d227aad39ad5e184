// lipoid identify, end to end: synthesized logs whose truth is known, several cells, every refusal.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

// The lab's logs of a shipped cell with a branch that can be seen, sampled every second, in logs/.
void SynthesizeLogs(const std::string& folder,
                    const std::string& cell,
                    const std::string& to,
                    const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{
      "synthesize", cell, "--with", "r_1=0.03,c_1=1500", "--sampling-s", "1", "--quiet", "-o", to};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto run = RunLipoid(folder, arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

std::size_t Lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

// Logs without noise, printed so that they read back to the same bits: only the solver's tolerance
// is left.
TEST(Identify, RecoversEveryParameterOfASynthesizedCell) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "logs/campaign.toml",
                              "-o",
                              "cell.json",
                              "--alpha-C",
                              "1353.6",
                              "--open-circuit-voltage",
                              "logs/truth.json",
                              "--truth",
                              "logs/truth.json",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Cell cell = LoadCell(folder + "/cell.json");
  constexpr double kRelative = 1e-6;
  EXPECT_EQ(cell.diffusion->alpha_C, 1353.6);
  EXPECT_NEAR(cell.diffusion->beta_per_sqrt_s / 0.1924, 1.0, kRelative);
  EXPECT_NEAR(cell.series_resistance_Ohm.resistance_Ohm[0] / 0.1314, 1.0, kRelative);
  EXPECT_NEAR(cell.branches.at(0).resistance_Ohm.resistance_Ohm[0] / 0.03, 1.0, kRelative);
  EXPECT_NEAR(*cell.branches.at(0).capacitance_F / 1500.0, 1.0, kRelative);
  EXPECT_NE(run.out.find("Truth against estimate"), std::string::npos);
  EXPECT_NE(run.out.find("Cell file: cell.json"), std::string::npos);

  // The run record says what it was made from.
  EXPECT_TRUE(cell.run->at("converged").get<bool>());
  ASSERT_EQ(cell.run->at("inputs")[0].at("file"), "logs/campaign.toml");
  EXPECT_EQ(cell.run->at("inputs")[0].at("sha256").get<std::string>().size(), 64U);
  const Json summary = ReadJson(folder, "s.json");
  for (const char* key : {"cell", "stages", "validation", "constant_current", "wall_s"})
    EXPECT_TRUE(summary.contains(key)) << key;
  EXPECT_EQ(summary.at("stages").at("pulses").at("termination"), "converged");
}

// The name of a cell is text from elsewhere, which must not write the first line; and what comes next can be pasted.
TEST(Identify, ANameWritesNoLineOfItsOwnAndAPathCanBePasted) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  std::string campaign = ReadText(folder + "/logs/campaign.toml");
  const auto name = campaign.find("name = ");
  campaign.replace(name, campaign.find('\n', name) - name, R"(name = "A predicts\nB")");
  WriteFileAtomically(folder + "/logs/campaign.toml", campaign);
  const auto run = RunLipoid(
      folder, {"identify", "--method", "staged", "logs/campaign.toml", "-o", "my cell.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find(R"(A predicts\nB predicts its own logs)"), 0U) << run.out;
  EXPECT_NE(run.out.find("Next: lipoid validate 'my cell.json' LOG..."), std::string::npos)
      << run.out;
  const auto again = RunLipoid(folder, {"validate", "my cell.json", "logs/pulses.csv"});
  EXPECT_EQ(again.out.find("A predicts\nB"), std::string::npos) << again.out;
}

// A charge transfer that is dropped again leaves a second branch behind it, of next to no resistance, which gains a
// little by what the modes of diffusion leave out. It is none.
TEST(Identify, JointFindsTheTruthsOneBranchWhereASecondHasNoResistance) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder,
                      {"synthesize",
                       "grepow-32Ah-1",
                       "--with",
                       "r_1=0.0005,c_1=60000",
                       "--rates-C",
                       "1,2,3,4,5,6,7,8",
                       "--voltage-noise-V",
                       "0.0002",
                       "--voltage-resolution-V",
                       "0.00001",
                       "--seed",
                       "1",
                       "--quiet",
                       "-o",
                       "logs"})
                .exit_code,
            0);
  const auto run = RunLipoid(folder, {"identify", "logs/campaign.toml", "-o", "cell.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json cell = ReadJson(folder, "cell.json");
  ASSERT_EQ(cell.at("branches").size(), 1U);
  EXPECT_NEAR(cell.at("branches").at(0).at("resistance_Ohm").get<double>(), 5e-4, 1e-7);
}

// All logs at once: no capacity and no curve is given, and the noise is all that is left.
TEST(Identify, JointFindsTheTruthAndSaysHowFarToBelieveIt) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder,
                 "gifi-600mAh-1",
                 "logs",
                 {"--voltage-noise-V", "0.0002", "--seed", "5", "--rates-C", "1,3,6"});
  const auto run = RunLipoid(folder,
                             {"identify",
                              "logs/campaign.toml",
                              "--verbose",
                              "--method",
                              "joint",
                              "-o",
                              "cell.json",
                              "--truth",
                              "logs/truth.json",
                              "--residuals",
                              "residuals.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("method"), "joint");
  for (const char* key : {"cell",
                          "joint",
                          "logs",
                          "parameters",
                          "trust",
                          "constant_current",
                          "validation",
                          "stages",
                          "staged",
                          "truth",
                          "wall_s"})
    EXPECT_TRUE(summary.contains(key)) << key;
  const std::vector<std::pair<std::string, double>> truths{
      {"alpha", 1353.6}, {"beta", 0.1924}, {"r_s", 0.1314}, {"r_1", 0.03}, {"tau_1", 45.0}};
  for (const auto& [name, truth] : truths) {
    bool found = false;
    for (const Json& parameter : summary.at("parameters")) {
      if (parameter.at("name") != name) continue;
      found = true;
      EXPECT_EQ(parameter.at("verdict"), "identified") << name;
      EXPECT_NEAR(parameter.at("estimate").get<double>(), truth, 0.01 * truth) << name;
      // Four standard errors: one seed out of ten thousand is further away.
      EXPECT_NEAR(parameter.at("estimate").get<double>(),
                  truth,
                  4.0 * parameter.at("standard_error").get<double>())
          << name;
    }
    EXPECT_TRUE(found) << name;
  }
  const Cell cell = LoadCell(folder + "/cell.json");
  EXPECT_EQ(cell.run->at("options").at("method"), "joint");
  EXPECT_NE(run.out.find("constant resistances, 1 branch"), std::string::npos);
  // Every row of every log that took part, and a header.
  std::size_t rows = 1;
  for (const Json& log : summary.at("logs")) rows += log.at("rows").get<std::size_t>();
  EXPECT_EQ(Lines(ReadTextFile(folder + "/residuals.csv")), rows);
  // The same bits with any number of threads.
  for (const char* threads : {"1", "2"}) {
    ASSERT_EQ(RunLipoid(folder,
                        {"identify",
                         "logs/campaign.toml",
                         "--method",
                         "joint",
                         "--threads",
                         threads,
                         "-o",
                         "again.json"})
                  .exit_code,
              0);
    Cell again = LoadCell(folder + "/again.json");
    again.run = cell.run;
    EXPECT_EQ(CellToJson(again).dump(), CellToJson(cell).dump()) << threads << " threads";
  }
  // What cells can be drawn from: the parameters of the report and the nodes of v_oc.
  ASSERT_TRUE(cell.uncertainty.has_value());
  for (const Json& parameter : summary.at("parameters")) {
    const auto& names = cell.uncertainty->parameters;
    const auto at = std::find(names.begin(), names.end(), parameter.at("name"));
    if (parameter.at("name") == "c_1" || parameter.at("name") == "r_total(0.5)") continue;
    ASSERT_NE(at, names.end()) << parameter.at("name");
    const auto k = static_cast<std::size_t>(at - names.begin());
    const double error = std::sqrt(cell.uncertainty->covariance[k][k]);
    // Two ways to the same covariance, through inverses of a badly conditioned matrix.
    EXPECT_NEAR(error / parameter.at("standard_error").get<double>(), 1.0, 1e-3) << *at;
  }
  EXPECT_TRUE(summary.at("not_drawn").empty());
  const auto simulate = RunLipoid(folder,
                                  {"simulate",
                                   "cell.json",
                                   "--current",
                                   "logs/cc_3C.csv",
                                   "--ensemble",
                                   "100",
                                   "--summary",
                                   "band.json",
                                   "-o",
                                   "band.csv"});
  ASSERT_EQ(simulate.exit_code, 0) << simulate.err;
  // 0.2 mV of noise in some ten thousand rows: the band is narrow, and there is one.
  const Json ensemble = ReadJson(folder, "band.json").at("ensemble");
  const double band_V = ensemble.at("band_mean_V").get<double>();
  EXPECT_GT(band_V, 1e-6);
  EXPECT_LT(band_V, 1e-3);
  // The cell file is one like any other.
  const auto validate = RunLipoid(folder, {"validate", "cell.json", "logs/pulses.csv"});
  EXPECT_EQ(validate.exit_code, 0) << validate.err;
}

TEST(Identify, ProfilesParametersOnRequest) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs", {"--voltage-noise-V", "0.0002", "--seed", "5"});
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "logs/campaign.toml",
                              "-o",
                              "cell.json",
                              "--profile",
                              "r_s,tau_1",
                              "--profile",
                              "beta",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  const Json& profiles = summary.at("profiles");
  ASSERT_EQ(profiles.size(), 3U);
  const std::vector<std::string> names{"r_s", "tau_1", "beta"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    SCOPED_TRACE(names[k]);
    const Json& profile = profiles[k];
    EXPECT_EQ(profile.at("name"), names[k]);
    for (const Json& parameter : summary.at("parameters")) {
      if (parameter.at("name") != names[k]) continue;
      EXPECT_EQ(profile.at("estimate"), parameter.at("estimate"));
      EXPECT_EQ(profile.at("unit"), parameter.at("unit"));
    }
    const Json& points = profile.at("points");
    ASSERT_GE(points.size(), 11U);
    // No point is better than the fit, and the fit is one of them.
    double least_V = points[0].at("rmse_V").get<double>();
    for (std::size_t n = 1; n < points.size(); ++n) {
      EXPECT_GT(points[n].at("value").get<double>(), points[n - 1].at("value").get<double>());
      EXPECT_GT(points[n].at("cost").get<double>(), 0.0);
      least_V = std::min(least_V, points[n].at("rmse_V").get<double>());
    }
    EXPECT_NEAR(least_V, summary.at("stages").at("pulses").at("rmse_V").get<double>(), 1e-9);
    const Json& interval = profile.at("interval_95");
    ASSERT_EQ(interval.size(), 2U);
    EXPECT_LT(interval[0].get<double>(), profile.at("estimate").get<double>());
    EXPECT_GT(interval[1].get<double>(), profile.at("estimate").get<double>());
    EXPECT_NE(run.out.find("profile of " + names[k] + " / "), std::string::npos);
  }
  // A line of the plot has at most 60 columns.
  std::istringstream lines(run.out.substr(run.out.find("profile of r_s")));
  std::size_t bars = 0;
  for (std::string text; std::getline(lines, text);) {
    if (text.find("  ##") == std::string::npos) continue;
    ++bars;
    EXPECT_LE(text.size(), 60U) << text;
  }
  EXPECT_GE(bars, 20U);
  EXPECT_EQ(LoadCell(folder + "/cell.json").run->at("options").at("profile").size(), 3U);

  const auto joint = RunLipoid(folder,
                               {"identify",
                                "logs/campaign.toml",
                                "--method",
                                "joint",
                                "-o",
                                "joint.json",
                                "--profile",
                                "tau_1",
                                "--summary",
                                "j.json"});
  ASSERT_EQ(joint.exit_code, 0) << joint.err;
  const Json tau = ReadJson(folder, "j.json").at("profiles").at(0);
  EXPECT_EQ(tau.at("name"), "tau_1");
  // The truth, to ten times the interval: one of the noise's seeds may miss it.
  const double width_s =
      tau.at("interval_95")[1].get<double>() - tau.at("interval_95")[0].get<double>();
  EXPECT_GT(width_s, 0.0);
  EXPECT_NEAR(tau.at("estimate").get<double>(), 45.0, 10.0 * width_s);
  EXPECT_NE(joint.out.find("profile of tau_1 / s: 95 % from "), std::string::npos);

  const std::vector<std::pair<std::vector<std::string>, std::string>> refused{
      {{"--profile", "tau_2"},
       "option --profile: no parameter 'tau_2' in this fit; profiles can be had of beta, r_s, r_1, "
       "tau_1, c_1"},
      {{"--profile", "beta", "--fix", "beta=0.2"},
       "option --profile: 'beta' is given, or follows from what is; profiles can be had of r_s, "
       "r_1, tau_1, c_1"},
      {{"--profile", "c_1", "--method", "joint"}, "profile tau_1 instead of c_1"},
      {{"--profile", "beta,"}, "option --profile: expected NAME,..., found 'beta,'"}};
  for (const auto& [options, message] : refused) {
    std::vector<std::string> arguments{"identify", "logs/campaign.toml", "-o", "other.json"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    if (options.back() != "joint") arguments.insert(arguments.end(), {"--method", "staged"});
    const auto bad = RunLipoid(folder, arguments);
    EXPECT_EQ(bad.exit_code, 2);
    EXPECT_NE(bad.err.find(message), std::string::npos) << bad.err;
  }
}

TEST(Identify, ErrorsAreThoseThatValidateFindsAndThatTheResidualsShow) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs", {"--voltage-noise-V", "0.001", "--seed", "3"});
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "logs/campaign.toml",
                              "-o",
                              "cell.json",
                              "--residuals",
                              "r.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json pulses = ReadJson(folder, "s.json").at("stages").at("pulses");
  const auto validate =
      RunLipoid(folder, {"validate", "cell.json", "logs/pulses.csv", "--summary", "v.json"});
  ASSERT_EQ(validate.exit_code, 0) << validate.err;
  const Json validated = ReadJson(folder, "v.json");
  const Json log = validated.at("logs")[0];
  // One log: the judgement of all of them is that of this one.
  EXPECT_EQ(validated.at("fit").at("verdict"), "good");
  EXPECT_EQ(validated.at("fit").at("rmse_V"), log.at("rmse_V"));
  EXPECT_EQ(validated.at("fit").at("mean_error_percent"), log.at("mean_error_percent"));
  EXPECT_EQ(validated.at("fit").at("reason"), "");
  EXPECT_EQ(ReadJson(folder, "s.json").at("fit").at("verdict"), "good");
  EXPECT_NE(validate.out.find("predicts this log to "), std::string::npos) << validate.out;
  constexpr double kSameSum_V = 1e-9;  // the same numbers from a file printed to round-trip
  EXPECT_NEAR(log.at("rmse_V").get<double>(), pulses.at("rmse_V").get<double>(), kSameSum_V);
  EXPECT_NEAR(log.at("mean_error_percent").get<double>(),
              pulses.at("mean_error_percent").get<double>(),
              kSameSum_V);

  const std::string text = ReadTextFile(folder + "/r.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "log,time_s,current_A,voltage_V,fitted_V,residual_V,soc");
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  double squares = 0.0;
  std::size_t rows = 0;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int k = 0; k < 6; ++k) std::getline(cells, cell, ',');
    squares += std::stod(cell) * std::stod(cell);
    ++rows;
  }
  EXPECT_EQ(rows, pulses.at("rows").get<std::size_t>());
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(rows)),
              pulses.at("rmse_V").get<double>(),
              kSameSum_V);
}

TEST(Identify, SeveralCampaignsGiveACellEachAndTheirSpread) {
  const auto folder = TestFolder();
  for (const char* cell : {"gifi-600mAh-1", "gifi-600mAh-2", "gifi-600mAh-3"}) {
    SynthesizeLogs(folder, cell, cell);
  }
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "gifi-600mAh-1/campaign.toml",
                              "gifi-600mAh-2/campaign.toml",
                              "gifi-600mAh-3/campaign.toml",
                              "-o",
                              "cells",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(FilesIn(folder + "/cells"),
            (std::vector<std::string>{
                "gifi-600mAh-1.cell.json", "gifi-600mAh-2.cell.json", "gifi-600mAh-3.cell.json"}));
  EXPECT_NE(run.out.find("Spread over 3 cells"), std::string::npos);
  const Json summary = ReadJson(folder, "s.json");
  ASSERT_EQ(summary.at("cells").size(), 3U);
  const Json& beta = summary.at("spread").at("beta");
  double mean = 0.0;
  for (const auto& cell : summary.at("cells")) {
    mean += cell.at("cell").at("diffusion").at("beta_per_sqrt_s").get<double>() / 3.0;
  }
  EXPECT_NEAR(beta.at("mean").get<double>(), mean, 1e-15);
  EXPECT_GT(beta.at("standard_deviation").get<double>(), 0.0);
}

TEST(Identify, SaysABadFileOnceAndWritesNothing) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "--constant-current",
                              "none.csv",
                              "logs/cc_1C.csv",
                              "--low-rate",
                              "none.csv",
                              "--pulses",
                              "none.csv",
                              "--cutoff-V",
                              "3",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(Lines(run.err), 1U) << run.err;
  EXPECT_EQ(run.err.rfind("none.csv: error: ", 0), 0U) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("exit_code"), 3);
  EXPECT_EQ(summary.at("error").at("diagnostics").size(), 1U);
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"logs", "s.json"}));
}

// Without constant currents the staged method takes alpha from the low-rate log, the joint fit does not. By the
// curve of another cell both miss, the staged method by more than there is to measure.
TEST(Identify, FallbacksAndErrorsOfTheStagedMethodAreNoneOfTheJointFit) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  std::vector<std::string> arguments{"identify",
                                     "--low-rate",
                                     "logs/low_rate.csv",
                                     "--pulses",
                                     "logs/pulses.csv",
                                     "--cutoff-V",
                                     "3",
                                     "--capacity-Ah",
                                     "0.6",
                                     "-o",
                                     "cell.json"};
  const std::string says =
      "\nFallbacks of the staged method, from which the joint fit started\n   - no constant-current";
  EXPECT_NE(RunLipoid(folder, arguments).out.find(says), std::string::npos);
  arguments.insert(arguments.end(), {"--method", "staged"});
  EXPECT_NE(RunLipoid(folder, arguments).out.find("\nFallbacks\n"), std::string::npos);

  const auto other = RunLipoid(folder,
                               {"identify",
                                SourcePath("fixtures/lab/dmegc_inr18650_26_r1/campaign.toml"),
                                "--reference",
                                "gifi-600mAh-1",
                                "-o",
                                "other.json",
                                "--summary",
                                "s.json"});
  EXPECT_EQ(other.exit_code, 1) << other.err;
  const Json fitted = ReadJson(folder, "s.json").at("logs").at(0);
  EXPECT_GT(fitted.at("staged").at("mean_error_percent").get<double>(), 100.0);
  const std::string row = other.out.substr(other.out.find("\n   cc_0p5c.csv ") + 1);
  EXPECT_TRUE(row.substr(0, row.find('\n')).ends_with(" >100")) << other.out;
}

TEST(Identify, RefusesWhatDoesNotFitTogether) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  struct Case {
    std::vector<std::string> arguments;
    std::string message;
  };
  const Case cases[] = {
      {{}, "CAMPAIGN is missing: a campaign file, or logs by --constant-current"},
      {{"logs/campaign.toml", "--pulses", "logs/pulses.csv"},
       "give either a campaign file or logs by options"},
      {{"logs/campaign.toml", "--cutoff-V", "3"},
       "option --cutoff-V goes with logs given by options"},
      {{"logs/campaign.toml", "--battery", "2"},
       "option --battery goes with logs given by options"},
      {{"logs/campaign.toml", "--fix", "q_1=3"},
       "--fix: no parameter 'q_1' in this fit; there are beta, r_s"},
      {{"logs/campaign.toml", "--fix", "beta"}, "option --fix: expected NAME=VALUE, found 'beta'"},
      {{"logs/campaign.toml", "--bounds", "beta=0.1"},
       "option --bounds: expected NAME=LOW,HIGH, found 'beta=0.1'"},
      {{"logs/campaign.toml", "--method", "magic"}, "expected one of staged, joint, found 'magic'"},
      {{"logs/campaign.toml", "--branches", "6"},
       "--branches: expected a whole number, 0 .. 5, found '6'"},
      {{"--pulses", "logs/pulses.csv", "--initial-voltage-V", "4.1"},
       "--initial-voltage-V needs v_oc(A)"},
      {{"--constant-current", "logs/cc_1C.csv", "--cutoff-V", "3"},
       "expected a low-rate log for the open-circuit voltage, or pulses with rests, found neither"},
      {{"--constant-current",
        "logs/cc_1C.csv",
        "--cutoff-V",
        "3",
        "--open-circuit-voltage",
        SourcePath("fixtures/cells/gifi-600mAh-1.json")},
       "lipoid identify: error: expected a log that gives the capacity (two constant currents, or a "
       "low-rate log), --capacity-Ah, or --alpha-C, found constant currents that do not differ"},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.message);
    std::vector<std::string> arguments{"identify", "-o", "cell.json"};
    arguments.insert(arguments.end(), one.arguments.begin(), one.arguments.end());
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(one.message), std::string::npos) << run.err;
    EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"logs"}));
  }
}

TEST(Identify, OfAPoorFitIsToldWhereverTheCellIsLoaded) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  const auto poor = RunLipoid(folder,
                              {"identify",
                               "logs/campaign.toml",
                               "--method",
                               "staged",
                               "--alpha-C",
                               "1",
                               "-o",
                               "-",
                               "--quiet"});
  EXPECT_EQ(poor.exit_code, 1) << poor.err;
  EXPECT_EQ(poor.err, "");
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"logs"}));
  WriteFileAtomically(folder + "/poor.json", poor.out);
  EXPECT_EQ(LoadCell(folder + "/poor.json").diffusion->alpha_C, 1.0);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{
            "simulate", "poor.json", "--current", "logs/cc_1C.csv", "-o", "s.csv"},
        std::vector<std::string>{"identify",
                                 "logs/campaign.toml",
                                 "--method",
                                 "staged",
                                 "--truth",
                                 "poor.json",
                                 "-o",
                                 "cell.json"}}) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_NE(run.err.find("poor.json: lipoid identify judged its fit poor: do not rely on what it "
                           "predicts (alpha is "),
              std::string::npos)
        << run.err;
  }
}

TEST(Identify, HoldsWhatIsGiven) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--method",
                              "staged",
                              "logs/campaign.toml",
                              "-o",
                              "cell.json",
                              "--fix",
                              "beta=0.2",
                              "--fix",
                              "tau_1=45",
                              "--bounds",
                              "r_s=0,0.1",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Cell cell = LoadCell(folder + "/cell.json");
  EXPECT_EQ(cell.diffusion->beta_per_sqrt_s, 0.2);
  EXPECT_EQ(cell.branches.at(0).time_constant_s, 45.0);
  EXPECT_LE(cell.series_resistance_Ohm.resistance_Ohm[0], 0.1);
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_TRUE(summary.at("stages").at("pulses_beta_held").is_null());
  EXPECT_EQ(summary.at("stages").at("pulses").at("at_bound"), Json::array({"r_s"}));
  EXPECT_EQ(summary.at("cautions").at(0), "held as given: beta = 0.2 s^-1/2, tau_1 = 45 s");
}

TEST(Identify, ReadsAGivenCurveFromCsvAndRefusesAWrongOne) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  const auto identify = [&](const std::string& curve) {
    WriteFileAtomically(folder + "/curve.csv", curve);
    return RunLipoid(folder,
                     {"identify",
                      "--method",
                      "staged",
                      "--pulses",
                      "logs/pulses.csv",
                      "--alpha-C",
                      "1353.6",
                      "--open-circuit-voltage",
                      "curve.csv",
                      "-o",
                      "cell.json"});
  };
  const auto good = identify(
      "soc,voltage_V\n1,4.2\n0.9,4.11\n.8,4.02\n.7,3.95\n.6,3.87\n.5,3.82\n.4,3.77\n.3,3.74\n.2,3."
      "7\n.1,3.6\n"
      ".05,3.45\n.02,3.3\n0,3\n");
  ASSERT_EQ(good.exit_code, 0) << good.err;
  EXPECT_NEAR(LoadCell(folder + "/cell.json").diffusion->beta_per_sqrt_s / 0.1924, 1.0, 1e-6);
  const std::pair<std::string, std::string> bad[] = {
      {"", "curve.csv:1:1: error: expected soc,voltage_V rows or a cell file, found nothing\n"},
      {"a,b\n1,2\n", "curve.csv:1:1: error: expected the header 'soc,voltage_V', found 'a,b'\n"},
      {"soc,voltage_V\n1,4.2\n",
       "curve.csv:1:1: error: expected at least two rows of soc and voltage_V, found 1\n"},
      {"soc,voltage_V\n1,x\n",
       "curve.csv:2:3: error: expected a number for voltage_V, found 'x'\n"},
      {"soc,voltage_V\n1,4.2\n0.5\n",
       "curve.csv:3:4: error: expected voltage_V, found the end of the line\n"},
      {"soc,voltage_V\n100,4.2\n0,3\n",
       "curve.csv:2:1: error: expected soc as a fraction, 1 when full, found 100 (a "
       "percentage?)\n"},
      {"soc,voltage_V\n0,3000\n1,4200\n",
       "curve.csv:1:1: error: expected v_oc(A) of one cell in V, found 4200 V at full charge; are "
       "these mV? Divide them by 1000\n"},
      {"soc,voltage_V\n0,12\n1,16.8\n",
       "curve.csv:1:1: error: expected v_oc(A) of one cell in V, found 16.8 V at full charge; is it "
       "that of 4 cells in series? Divide it by 4\n"},
      {"soc,voltage_V\n1,4.2\n0,3\n1,4.1\n",
       "curve.csv:4:1: error: expected every soc once, found 1 again\n"},
  };
  for (const auto& [text, message] : bad) {
    const auto run = identify(text);
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_EQ(run.err, message);
  }
}

// A slow charge that is one takes no part, and it is said.
TEST(Identify, SaysThatTheStagedMethodUsesNoSlowCharge) {
  const auto folder = TestFolder();
  SynthesizeLogs(folder, "gifi-600mAh-1", "logs");
  std::string rows = "time_s,current_A,voltage_V\n";
  for (int k = 0; k <= 100; ++k)
    rows += fmt::format("{},{},{}\n", 450 * k, k == 0 ? 0.0 : -0.03, 3.0 + 0.012 * k);
  WriteFileAtomically(folder + "/logs/charge.csv", rows);
  WriteFileAtomically(folder + "/logs/c.toml",
                      ReadTextFile(folder + "/logs/campaign.toml") +
                          "\n[[log]]\nkind = \"low-rate-charge\"\nfile = \"charge.csv\"\n"
                          "current_sign = \"discharge-positive\"\ninitial_soc = 0\n");
  const auto run =
      RunLipoid(folder, {"identify", "logs/c.toml", "--method", "staged", "-o", "c.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("charge.csv: the staged method does not use a slow charge; --method joint "
                         "does"),
            std::string::npos)
      << run.err;
}

// In whichever order they stand.
TEST(Identify, RefusesAnOptionAndASettingThatContradictEachOther) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/c.toml", "[cell]\ncutoff_V = 3.0\n");
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"identify", "c.toml", "-o", "c.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunLipoid(folder, arguments);
  };
  const std::pair<std::vector<std::string>, const char*> refused[] = {
      {{"--branches", "1", "--set", "joint.branches=0"}, "--branches 1 and --set joint.branches=0"},
      {{"--set", "joint.branches=-1", "--branches", "1"},
       "--branches 1 and --set joint.branches=-1"},
      {{"--method", "staged", "--branches", "2", "--set", "pulses.branches=1"},
       "--branches 2 and --set pulses.branches=1"},
      {{"--no-diffusion", "--set", "pulses.diffusion=true"},
       "--no-diffusion and --set pulses.diffusion=true"}};
  for (const auto& [more, names] : refused) {
    const auto result = run(more);
    EXPECT_EQ(result.exit_code, 2);
    const auto message = std::string("options ") + names + " contradict each other; leave one out";
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
  }
  const std::vector<std::string> same[] = {
      {"--branches", "1", "--set", "joint.branches=1"},
      {"--branches", "1", "--set", "pulses.branches=1"},
      {"--method", "staged", "--branches", "2", "--set", "joint.branches=1"},
      {"--no-diffusion", "--set", "pulses.diffusion=false"}};
  for (const auto& more : same) EXPECT_EQ(run(more).err.find("contradict"), std::string::npos);
}

// Settings of what does not run.
TEST(Identify, SaysWhichSettingsChangeNothing) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/c.toml", "[cell]\ncutoff_V = 3.0\n");
  const auto said = [&](const std::string& method, const std::string& setting) {
    return RunLipoid(folder,
                     {"identify", "c.toml", "-o", "c.json", "--method", method, "--set", setting})
        .err;
  };
  EXPECT_NE(said("staged", "joint.branches=1").find("options --set joint.* change nothing"),
            std::string::npos);
  EXPECT_EQ(said("joint", "joint.branches=1").find("change nothing"), std::string::npos);
  EXPECT_NE(said("joint", "pulses.branches=1")
                .find("pulses.branches and pulses.starts are of the staged run"),
            std::string::npos);
  EXPECT_EQ(said("staged", "pulses.branches=1").find("are of the staged run"), std::string::npos);
  EXPECT_NE(said("joint", "open_circuit_voltage.method=fourier").find("of the staged run alone"),
            std::string::npos);
  EXPECT_EQ(said("staged", "open_circuit_voltage.method=fourier").find("of the staged run alone"),
            std::string::npos);
}

}  // namespace
}  // namespace lipoid::test
