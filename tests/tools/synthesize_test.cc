// lipoid synthesize, end to end. What the logs hold: tests/identify/synthesis/synthesize_test.cc.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/core/run_record.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

std::vector<std::string> Arguments(std::initializer_list<std::string> more) {
  std::vector<std::string> all{"synthesize", "gifi-600mAh-1", "--sampling-s", "1", "--quiet"};
  all.insert(all.end(), more);
  return all;
}

TEST(Synthesize, SaysWhatItWrote) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, Arguments({"-o", "a/logs", "--summary", "s.json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(FilesIn(folder + "/a/logs"),
            (std::vector<std::string>{"campaign.toml",
                                      "cc_1C.csv",
                                      "cc_2C.csv",
                                      "cc_3C.csv",
                                      "cc_4C.csv",
                                      "cc_5C.csv",
                                      "cc_6C.csv",
                                      "low_rate.csv",
                                      "pulses.csv",
                                      "truth.json"}));
  const auto summary = ReadJson(folder, "s.json");
  ASSERT_EQ(summary.at("files").size(), 10U);
  for (const auto& file : summary.at("files")) {
    const std::string path = folder + "/" + file.at("file").get<std::string>();
    SCOPED_TRACE(path);
    EXPECT_EQ(file.at("bytes"), std::filesystem::file_size(path));
    const auto text = ReadTextFile(path);
    if (path.ends_with(".csv")) {
      EXPECT_EQ(file.at("rows"), std::count(text.begin(), text.end(), '\n') - 1);
    }
  }
}

TEST(Synthesize, TheTruthIsACellFileWithProtocolSeedAndNoise) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             Arguments({"-o",
                                        "logs",
                                        "--with",
                                        "r_1=0.03,c_1=1500",
                                        "--seed",
                                        "42",
                                        "--voltage-noise-V",
                                        "0.001",
                                        "--set",
                                        "current_noise_A=0.01"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Cell truth = LoadCell(folder + "/logs/truth.json");
  const Cell shipped = LoadCell("gifi-600mAh-1");
  EXPECT_EQ(truth.diffusion->alpha_C, shipped.diffusion->alpha_C);
  EXPECT_EQ(truth.branches.at(0).resistance_Ohm.resistance_Ohm[0], 0.03);
  EXPECT_EQ(truth.branches.at(0).capacitance_F, 1500.0);
  EXPECT_EQ(truth.branches.at(0).time_constant_s, 45.0);
  EXPECT_EQ(truth.run->at("protocol"), "thesis");
  EXPECT_EQ(truth.run->at("seed"), 42);
  EXPECT_EQ(truth.run->at("options").at("voltage_noise_V"), 0.001);
  EXPECT_EQ(truth.run->at("options").at("current_noise_A"), 0.01);
}

TEST(Synthesize, TermsAreAddedByTheirParametersInAnyOrder) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(
      folder, Arguments({"-o", "logs", "--with", "r_ct=0.02,rho_h=1e-3,i_0=0.5,tau_h=300"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Cell truth = LoadCell(folder + "/logs/truth.json");
  EXPECT_EQ(truth.self_heating->time_constant_s, 300.0);
  EXPECT_EQ(truth.self_heating->resistance_drop_Ohm_per_A2, 1e-3);
  EXPECT_EQ(truth.charge_transfer->current_A, 0.5);
  EXPECT_EQ(truth.charge_transfer->resistance_Ohm(0.5), 0.02);
  const std::pair<const char*, const char*> unfinished[] = {
      {"tau_h=300", "option --with: tau_h needs rho_h beside it"},
      {"r_ct=0.02", "option --with: r_ct needs i_0 beside it"},
      {"r_2=0.02", "option --with: r_2 needs c_2 or tau_2 beside it"},
      {"tau_1=45,c_1=1500", "option --with: give either c_1 or tau_1, not both: tau_1 = r_1 c_1"}};
  for (const auto& [with, message] : unfinished) {
    const auto half = RunLipoid(folder, Arguments({"-o", "half", "--with", with}));
    EXPECT_EQ(half.exit_code, 2);
    EXPECT_NE(half.err.find(message), std::string::npos) << half.err;
    EXPECT_FALSE(std::filesystem::exists(folder + "/half"));
  }
}

TEST(Synthesize, TheSameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  const auto folder = TestFolder();
  const auto synthesize =
      [&](const std::string& out, const std::string& threads, const std::string& seed) {
        const auto run = RunLipoid(folder,
                                   Arguments({"-o",
                                              out,
                                              "--threads",
                                              threads,
                                              "--seed",
                                              seed,
                                              "--voltage-noise-V",
                                              "0.001",
                                              "--current-noise-A",
                                              "0.001"}));
        EXPECT_EQ(run.exit_code, 0) << run.err;
      };
  synthesize("one", "1", "7");
  synthesize("two", "2", "7");
  synthesize("other", "2", "8");
  for (const auto& file : FilesIn(folder + "/one")) {
    if (file == "truth.json") continue;  // it holds the command as typed
    SCOPED_TRACE(file);
    const auto hash_in = [&](const char* run) {
      return Sha256OfFile(fmt::format("{}/{}/{}", folder, run, file));
    };
    const auto hash = hash_in("one");
    EXPECT_EQ(hash, hash_in("two"));
    if (file.ends_with(".csv")) {
      EXPECT_NE(hash, hash_in("other"));
    }
  }
}

TEST(Synthesize, NothingIsLeftBehindWhenItFails) {
  const auto folder = TestFolder();
  const std::vector<std::vector<std::string>> wrong = {
      Arguments(
          {"-o", "a/b", "--rates-C", "1,200"}),       // the last log fails while others are written
      Arguments({"-o", "a/b", "--pulse-s", "30.5"}),  // no multiple of the sampling
      Arguments({"-o", "a/b", "--rates-C", "1,x"}),
      Arguments({"-o", "a/b", "--with", "r_9=1"}),
      Arguments({"-o", "a/b", "--protocol", "other"}),
      {"synthesize", "no-such-cell", "-o", "a/b"},
      {"synthesize", "gifi-600mAh-1"},
  };
  for (const auto& arguments : wrong) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, arguments[1] == "no-such-cell" ? 3 : 2) << run.err;
    EXPECT_NE(run.err, "");
    EXPECT_EQ(FilesIn(folder), std::vector<std::string>{});
  }
}

TEST(Synthesize, AnInterruptedRunLeavesNothing) {
  const auto folder = TestFolder();
  for (const std::string signal : {"INT", "TERM", "HUP"}) {
    // At 1 ms the logs are of 70 million rows: the signal comes while they are written.
    const auto run =
        RunShell(folder,
                 "timeout --signal=" + signal +
                     " 0.3 \"$LIPOID\" synthesize gifi-600mAh-1 --sampling-s 0.001 -o a/b");
    EXPECT_NE(run.exit_code, 0);
    EXPECT_EQ(FilesIn(folder), std::vector<std::string>{}) << signal;
  }
}

TEST(Synthesize, AFolderThatCannotBeWrittenIsSaid) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunShell(folder, "echo >file").exit_code, 0);
  const auto run = RunLipoid(folder, Arguments({"-o", "file/logs"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "lipoid synthesize: error: cannot make the folder 'file/logs': Not a directory\n"
            "Try 'lipoid synthesize --help'.\n");
}

// Logs that identify would refuse, or hardly read.
TEST(Synthesize, SaysWhatMakesNoLogsOfALab) {
  const auto folder = TestFolder();
  const std::pair<std::vector<std::string>, const char*> refused[] = {
      {{"--rest-s", "0"}, "expected rests of at least 2 rows between the pulses"},
      {{"--pulse-s", "1000"},
       "pulses.csv: a pulse of 1000 s at 3.6 A empties the cell after 266 s, before any rest, and "
       "identify takes no such log for pulses; take shorter pulses or a lower rate"},
      {{"--low-rate-h", "0.5"}, "low_rate.csv: expected a low rate, at most 0.2 C, found 1.25 C"}};
  for (const auto& [options, message] : refused) {
    std::vector<std::string> arguments{
        "synthesize", "gifi-600mAh-1", "--sampling-s", "1", "-o", "none"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder + "/none"));
  }
  const auto noisy = RunLipoid(folder,
                               {"synthesize",
                                "gifi-600mAh-1",
                                "--sampling-s",
                                "1",
                                "--current-noise-A",
                                "0.6",
                                "-o",
                                "noisy"});
  EXPECT_EQ(noisy.exit_code, 0) << noisy.err;
  EXPECT_NE(noisy.err.find("the noise of the current, 0.6 A, is 21 of the least current"),
            std::string::npos)
      << noisy.err;
  Cell warms = LoadCell("gifi-600mAh-1");
  Cell::Temperature& term = warms.temperature.emplace();
  term.branches_J_per_mol.assign(warms.branches.size(), 0.0);
  term.heat = HeatBalance<double>{15.0, 20.0};
  WriteCellFile(warms, folder + "/warms.json");
  std::vector<std::string> arguments{
      "synthesize", "warms.json", "--sampling-s", "10", "-o", "warm"};
  const char* doubt =
      "the cell warms under load, and without --ambient-degC no log tells its temperature";
  const auto untold = RunLipoid(folder, arguments);
  EXPECT_EQ(untold.exit_code, 0) << untold.err;
  EXPECT_NE(untold.err.find(doubt), std::string::npos) << untold.err;
  EXPECT_NE(untold.err.find("; --ambient-degC 25 writes temperature_degC"), std::string::npos)
      << untold.err;
  arguments.insert(arguments.end(), {"--ambient-degC", "25"});
  const auto told = RunLipoid(folder, arguments);
  EXPECT_EQ(told.exit_code, 0) << told.err;
  EXPECT_EQ(told.err.find(doubt), std::string::npos) << told.err;
}

}  // namespace
}  // namespace lipoid::test
