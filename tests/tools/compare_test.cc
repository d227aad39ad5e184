// lipoid compare, end to end: synthesized logs whose truth is known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "model/core/atomic_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

constexpr double kBeta = 0.1924, kSeries = 0.1314;  // of gifi-600mAh-1

void SynthesizeExactLogs(const std::string& folder) {
  const auto run = RunLipoid(folder,
                             {"synthesize",
                              "gifi-600mAh-1",
                              "--with",
                              "r_1=0.03,c_1=1500",
                              "--sampling-s",
                              "2",
                              "--quiet",
                              "-o",
                              "logs"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// With alpha and v_oc(A) given, the truth is the optimum.
std::vector<std::string> Compare(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"compare",
                                     "logs/campaign.toml",
                                     "--alpha-C",
                                     "1353.6",
                                     "--open-circuit-voltage",
                                     "logs/truth.json",
                                     "--summary",
                                     "s.json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Compare, RunsTheSevenOfTheThesisUnlessToldOtherwise) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(folder, Compare({"--csv", "table.csv"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find(" rows of 1 log, "), std::string::npos) << run.out;
  const Json summary = ReadJson(folder, "s.json");
  const std::vector<std::string> seven{"interior-point",
                                       "sqp",
                                       "active-set",
                                       "levenberg-marquardt",
                                       "genetic",
                                       "particle-swarm",
                                       "simulated-annealing"};
  ASSERT_EQ(summary.at("results").size(), seven.size());
  for (std::size_t k = 0; k < seven.size(); ++k) {
    const Json& r = summary.at("results")[k];
    EXPECT_EQ(r.at("optimizer"), seven[k]);
    for (const char* key : {"mean_error_percent",
                            "max_error_percent",
                            "rmse_V",
                            "wall_s",
                            "evaluations",
                            "gradient_evaluations",
                            "starts",
                            "success_rate"}) {
      EXPECT_TRUE(r.at(key).is_number()) << seven[k] << ' ' << key;
    }
    EXPECT_TRUE(r.at("termination").is_string());
    // Without noise the best cost is next to nothing and a search may end well above it, but the
    // cell must be found: 1 mV of 4 V.
    EXPECT_LT(r.at("rmse_V").get<double>(), 1e-3) << seven[k];
    EXPECT_NEAR(r.at("parameters").at("r_s").get<double>(), kSeries, 0.03 * kSeries) << seven[k];
    EXPECT_NE(run.out.find(seven[k]), std::string::npos);
  }
  // A solver with exact gradients comes as near as its step tolerance lets it.
  const Json& lm = summary.at("results")[3].at("parameters");
  EXPECT_NEAR(lm.at("beta").get<double>(), kBeta, 1e-5 * kBeta);
  EXPECT_NEAR(lm.at("r_1").get<double>(), 0.03, 1e-5);
  EXPECT_NEAR(lm.at("c_1").get<double>(), 1500.0, 0.1);
  EXPECT_NE(run.out.find("box up to"), std::string::npos) << "the box is stated";

  // One line says which lipoid, one what the columns are, then one run of each.
  const auto csv = ReadText(folder + "/table.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9);
  EXPECT_EQ(csv.rfind("# lipoid 0.", 0), 0U);
  EXPECT_NE(csv.find("\noptimizer,start,seed,cost_V2,"), std::string::npos);
}

TEST(Compare, WritesOneRowPerStartAndTablesForAPaperAndCallsATieATie) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(folder,
                             Compare({"--optimizers",
                                      "levenberg-marquardt,interior-point",
                                      "--starts",
                                      "2",
                                      "--fix",
                                      "beta=0.25",
                                      "--csv",
                                      "runs.csv",
                                      "--latex",
                                      "tables.tex"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::istringstream lines(ReadText(folder + "/runs.csv"));
  std::string line;
  std::vector<std::string> found;
  const Json summary = ReadJson(folder, "s.json");
  const double best = summary.at("best").at("cost_V2");
  while (std::getline(lines, line)) {
    if (line[0] == '#' || line.rfind("optimizer,", 0) == 0) continue;
    std::istringstream cells(line);
    std::string optimizer, start, seed, cost, gap, reached;
    for (std::string* cell : {&optimizer, &start, &seed, &cost, &gap, &reached})
      std::getline(cells, *cell, ',');
    found.push_back(optimizer + " " + start + " " + seed);
    // `reached` is what the cost says it is, at the target that the summary states.
    EXPECT_EQ(reached, std::stod(cost) <= best * 1.001 ? "yes" : "no") << line;
    EXPECT_NEAR(std::stod(gap), 100.0 * (std::stod(cost) / best - 1.0), 1e-9) << line;
    EXPECT_EQ(line.find(",\"") != std::string::npos, true) << "the reason is quoted: " << line;
  }
  EXPECT_EQ(found,
            (std::vector<std::string>{"levenberg-marquardt 0 0",
                                      "levenberg-marquardt 1 1",
                                      "levenberg-marquardt 2 2",
                                      "interior-point 0 0",
                                      "interior-point 1 1",
                                      "interior-point 2 2"}));

  // Both find the one minimum that there is with beta held off the truth.
  ASSERT_EQ(summary.at("best").at("tied").size(), 1U) << run.out;
  EXPECT_NE(run.out.find("A tie: "), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("Best: "), std::string::npos) << run.out;

  const auto tex = ReadText(folder + "/tables.tex");
  const auto count = [&](const std::string& what) {
    std::size_t times = 0;
    for (auto at = tex.find(what); at != std::string::npos; at = tex.find(what, at + 1)) ++times;
    return times;
  };
  EXPECT_EQ(count("\\begin{tabular}"), 4U) << tex;
  EXPECT_EQ(count("\\bottomrule"), 4U);
  EXPECT_EQ(tex.rfind("% lipoid 0.", 0), 0U);
  EXPECT_NE(tex.find("mean / \\%"), std::string::npos) << tex;
  EXPECT_NE(tex.find("levenberg-marquardt & "), std::string::npos) << tex;
}

TEST(Latex, HasEachNumberThatTheScreenShows) {
  const auto folder = TestFolder();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"plan", "gifi-600mAh-1"},
        {"poles", "altitude"},
        {"fly", "hover", "--duration", "2"}}) {
    auto with = arguments;
    with.insert(with.end(), {"--latex", "t.tex"});
    const auto run = RunLipoid(folder, with);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    std::istringstream lines(ReadText(folder + "/t.tex"));
    std::size_t shown = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.find(" & ") == std::string::npos) continue;
      std::istringstream words(line);
      for (std::string word; words >> word;) {
        if (word.find_first_of("0123456789") != 0) continue;
        EXPECT_NE(run.out.find(word), std::string::npos) << word << " of " << line;
        ++shown;
      }
    }
    EXPECT_GE(shown, 5U) << arguments[0];
  }
}

TEST(Compare, TriesRandomStartsAndGivesTheSameForAnyNumberOfThreads) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  std::vector<std::string> texts;
  for (const char* threads : {"1", "2"}) {
    const auto run = RunLipoid(folder,
                               Compare({"--optimizers",
                                        "levenberg-marquardt,bobyqa,particle-swarm",
                                        "--set",
                                        "particle-swarm.population=20",
                                        "--starts",
                                        "3",
                                        "--seed",
                                        "5",
                                        "--threads",
                                        threads}));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    Json summary = ReadJson(folder, "s.json");
    for (Json& r : summary.at("results")) {
      EXPECT_EQ(r.at("starts"), 3);
      for (const char* time : {"wall_s", "time_to_target_s"}) r.erase(time);
      for (Json& improvement : r.at("improvements")) improvement.erase("wall_s");
    }
    for (const char* key : {"wall_s", "command", "run"}) summary.erase(key);
    texts.push_back(summary.dump());
  }
  EXPECT_EQ(texts[0], texts[1]);
  EXPECT_NE(texts[0].find("\"population\":\"20\""), std::string::npos);
}

TEST(Compare, HoldsBoundsAndFitsTimeConstants) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(folder,
                             Compare({"--optimizers",
                                      "sqp,nelder-mead",
                                      "--time-constants",
                                      "--fix",
                                      "beta=0.1924",
                                      "--bounds",
                                      "r_s=0.1,0.12",
                                      "--start",
                                      "tau_1=20"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  std::vector<std::string> names;
  for (const Json& v : summary.at("problem")) names.push_back(v.at("parameter"));
  EXPECT_EQ(names, (std::vector<std::string>{"r_s", "r_1", "tau_1"}));
  EXPECT_EQ(run.out.rfind("Problem (4.60): ", 0), 0U) << run.out;  // beta is held
  EXPECT_EQ(summary.at("problem")[2].at("start"), 20.0);
  EXPECT_EQ(summary.at("problem")[1].at("unit"), "Ohm");  // of start and bounds
  EXPECT_EQ(summary.at("problem")[2].at("unit"), "s");
  EXPECT_GT(summary.at("problem")[1].at("scale"), 0.0);
  for (const Json& r : summary.at("results")) {
    EXPECT_EQ(r.at("parameters").at("beta"), kBeta);
    EXPECT_NEAR(r.at("parameters").at("r_s").get<double>(), 0.12, 1e-6);  // 0.1314 is not allowed
  }
  const auto plain = RunLipoid(
      folder, Compare({"--optimizers", "sqp", "--no-diffusion", "--branches", "2", "--quiet"}));
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_FALSE(ReadJson(folder, "s.json").at("results")[0].at("parameters").contains("beta"));
}

TEST(Compare, MovesNaturalParametersWhereScalingIsNone) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run =
      RunLipoid(folder, Compare({"--optimizers", "levenberg-marquardt", "--set", "scaling=none"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  for (const Json& v : summary.at("problem")) EXPECT_EQ(v.at("scale"), 1.0);
  EXPECT_EQ(summary.at("options").at("scaling"), "none");
}

TEST(Compare, WhereNothingConvergedThereIsNoAnswer) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto stopped = [&](const std::string& optimizers) {
    return RunLipoid(folder,
                     Compare({"--optimizers",
                              optimizers,
                              "--set",
                              "levenberg-marquardt.iterations_per_variable=0",
                              "--set",
                              "nelder-mead.iterations_per_variable=1"}));
  };
  const auto run = stopped("levenberg-marquardt");
  EXPECT_EQ(run.exit_code, 1);
  const std::string why =
      "the best is where an optimizer was stopped, and no answer: levenberg-marquardt did "
      "not converge (No iteration was allowed.); allow it more (--set "
      "levenberg-marquardt.iterations_per_variable=...)";
  EXPECT_NE(OnOneLine(run.err).find(why), std::string::npos) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("no_answer_because"), why);
  EXPECT_EQ(stopped("levenberg-marquardt,nelder-mead").exit_code, 1);
  EXPECT_EQ(stopped("levenberg-marquardt,sqp").exit_code, 0) << "one has an answer";
  EXPECT_EQ(ReadJson(folder, "s.json").at("no_answer_because"), nullptr);
}

// A search of the whole box ends when its iterations are used up, but what is below it was stopped, and one without an
// iteration has found nothing.
TEST(Compare, AStoppedBestIsNoAnswerBesideASearchThatEnded) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto beside = RunLipoid(folder,
                                Compare({"--optimizers",
                                         "nelder-mead,genetic",
                                         "--set",
                                         "nelder-mead.iterations_per_variable=40",
                                         "--set",
                                         "genetic.iterations_per_variable=1"}));
  const Json best = ReadJson(folder, "s.json").at("best");
  ASSERT_EQ(best.at("optimizer"), "nelder-mead");
  EXPECT_EQ(beside.exit_code, 1) << beside.out;
  const auto none = RunLipoid(
      folder, Compare({"--optimizers", "genetic", "--set", "genetic.iterations_per_variable=0"}));
  EXPECT_EQ(none.exit_code, 1) << none.out;
}

// Whether a branch is there does not depend on the units of the search, and of one that is not nobody knows c_1.
TEST(Compare, ABranchThatIsNotThereIsNoneInAnyScaling) {
  const auto folder = TestFolder();
  for (const std::string scaling : {"typical", "none"}) {
    const auto run = RunLipoid(folder,
                               {"compare",
                                SourcePath("fixtures/lab/nissan_leaf_33ah/campaign.toml"),
                                "--optimizers",
                                "bobyqa",
                                "--set",
                                "scaling=" + scaling,
                                "--summary",
                                "s.json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json summary = ReadJson(folder, "s.json");
    EXPECT_EQ(summary.at("results")[0].at("at_bound"), Json({"r_1"})) << scaling;
    ASSERT_EQ(summary.at("cautions").size(), 1U);
    const auto& caution = summary.at("cautions")[0].get_ref<const std::string&>();
    EXPECT_EQ(
        caution,
        "r_1 ended at its bound of 0, which is no such branch, with bobyqa: such a value is no finding.");
    EXPECT_NE(OnOneLine(run.out).find(caution), std::string::npos) << run.out;
  }
}

// From a tenth of beta a step on natural parameters seems small, and the best of one is always the best.
TEST(Compare, TheBestOfARunThatIsWrongByAVoltIsNoSuccess) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(folder,
                             Compare({"--optimizers",
                                      "levenberg-marquardt",
                                      "--start",
                                      "beta=0.02",
                                      "--set",
                                      "scaling=none"}));
  EXPECT_EQ(run.exit_code, 1);
  const Json fit = ReadJson(folder, "s.json").at("best").at("fit");
  EXPECT_EQ(fit.at("verdict"), "poor");
  const Json result = ReadJson(folder, "s.json").at("results")[0];
  EXPECT_EQ(result.at("successes"), 0);
  EXPECT_EQ(result.at("success_rate"), 0.0);
  EXPECT_EQ(result.at("time_to_target_s"), nullptr);
  EXPECT_NE(run.out.find("levenberg-marquardt      0/1"), std::string::npos) << run.out;
  EXPECT_GT(fit.at("rmse_V"), 1.0);
  EXPECT_NE(OnOneLine(run.err).find("the best fit of this run predicts these logs to"),
            std::string::npos)
      << run.err;
  EXPECT_NE(OnOneLine(run.out).find("Gap and success are against this best of the run."),
            std::string::npos)
      << run.out;
  EXPECT_NE(OnOneLine(run.out).find("r_s ended at its bound of 0 with levenberg-marquardt; r_1 "
                                    "ended at its bound of 0, which is no such branch, with"),
            std::string::npos)
      << run.out;
}

TEST(Compare, ABranchAtTheEndOfTheBoxWantsAWiderOne) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(
      folder, Compare({"--optimizers", "cma-es,levenberg-marquardt", "--set", "decades=0"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(OnOneLine(run.out).find(", the end of the box that is searched (more than --set "
                                    "decades=0 widens it), with cma-es"),
            std::string::npos)
      << run.out;
}

TEST(Compare, SaysWhichSettingsChangeNothing) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto said = [&](const char* optimizers) {
    return RunLipoid(folder,
                     Compare({"--optimizers", optimizers, "--set", "particle-swarm.population=20"}))
        .err;
  };
  EXPECT_NE(said("sqp,levenberg-marquardt")
                .find("options --set particle-swarm.* change nothing: particle-swarm is none of "
                      "--optimizers sqp,levenberg-marquardt; add it there, or leave them out"),
            std::string::npos);
  EXPECT_EQ(said("sqp,particle-swarm").find("change nothing"), std::string::npos);
}

// The pulses of this cell let a branch be as slow as it likes: r_1 and tau_1 grow without end, c_1 stays.
TEST(Compare, SaysWhichBranchIsSlowerThanTheLogsCanShow) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"compare",
                              SourcePath("fixtures/lab/lg_m50_5ah/campaign.toml"),
                              "--optimizers",
                              "levenberg-marquardt"});
  EXPECT_NE(
      run.out.find(
          "tau_1 = r_1 c_1 of levenberg-marquardt is beyond 69730 s, the longest that these logs can"),
      std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("its r_1 is no finding"), std::string::npos) << run.out;
}

// gifi-600mAh-1 as it is has next to no branch.
// A resistance at a bound of its own, which is not 0, has a branch: its capacitance was hidden.
TEST(Compare, ABranchAtABoundOfItsOwnHasACapacitance) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const auto run = RunLipoid(
      folder, Compare({"--optimizers", "levenberg-marquardt", "--bounds", "r_1=0.001,0.02"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json result = ReadJson(folder, "s.json").at("results")[0];
  EXPECT_NEAR(result.at("parameters").at("r_1").get<double>(), 0.02, 1e-6);
  const double c_1 = result.at("parameters").at("c_1");
  const std::string line = run.out.substr(run.out.rfind("\nlevenberg-marquardt") + 1);
  EXPECT_NE(line.substr(0, line.find('\n')).find(fmt::format("{:.4g}", c_1).substr(0, 4)),
            std::string::npos)
      << run.out;
}

TEST(Compare, ABranchWithoutResistanceHasNoCapacitanceInTheTable) {
  const auto folder = TestFolder();
  ASSERT_EQ(
      RunLipoid(
          folder,
          {"synthesize", "gifi-600mAh-1", "--with", "r_1=0", "--sampling-s", "2", "-o", "logs"})
          .exit_code,
      0);
  const auto run = RunLipoid(
      folder, Compare({"--optimizers", "levenberg-marquardt,sqp", "--latex", "table.tex"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::size_t without = 0;
  const Json summary = ReadJson(folder, "s.json");
  for (const Json& result : summary.at("results")) {
    if (!result.at("parameters").at("c_1").is_null()) continue;
    ++without;
    // Its last line in the text, and its last row for LaTeX, are those of what it found.
    const std::string name = result.at("optimizer");
    const std::string line = run.out.substr(run.out.rfind("\n" + name) + 1);
    EXPECT_TRUE(line.substr(0, line.find('\n')).ends_with(" -")) << run.out;
    const std::string tex = ReadText(folder + "/table.tex");
    const std::string row = tex.substr(tex.rfind(name + " &"));
    EXPECT_NE(row.substr(0, row.find("\\\\")).rfind("& -"), std::string::npos) << tex;
  }
  EXPECT_GT(without, 0U) << run.out;
}

TEST(Compare, RefusesWhatMakesNoSense) {
  const auto folder = TestFolder();
  SynthesizeExactLogs(folder);
  const struct {
    std::vector<std::string> more;
    const char* says;
  } cases[] = {
      {{"--optimizers", "sqp,newton"}, "unknown optimizer 'newton'. Known: interior-point"},
      {{"--optimizers", "sqp,sqp"}, "sqp stands there twice"},
      {{"--optimizers", "all,sqp"},
       "option --optimizers: all stands alone; leave the other names out"},
      {{"--optimizers", ""}, "option --optimizers: expected NAME,NAME,..., found ''"},
      {{"--starts", "-1"}, "--starts"},
      {{"--set", "scaling=metric"}, "metric"},
      {{"--set", "genetic.population=2"}, "population"},
      {{"--set", "newton.population=2"}, "newton.population"},
      {{"--fix", "beta=0.2", "--fix", "r_s=0.1", "--fix", "r_1=0.1", "--fix", "c_1=100"},
       "nothing to compare"},
      {{"--fix", "gamma=1"}, "no parameter 'gamma'"},
  };
  for (const auto& c : cases) {
    const auto run = RunLipoid(folder, Compare(c.more));
    EXPECT_EQ(run.exit_code, 2) << c.says;
    EXPECT_NE(run.err.find(c.says), std::string::npos) << c.says << "\n" << run.err;
    EXPECT_EQ(run.out, "");
  }
  EXPECT_EQ(RunLipoid(folder, {"compare", "nowhere.toml"}).exit_code, 3);
  EXPECT_EQ(RunLipoid(folder, {"compare"}).exit_code, 2);
}

}  // namespace
}  // namespace lipoid::test
