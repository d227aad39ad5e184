// lipoid report, end to end: summaries that are there become a page, and nothing else does.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "model/core/json_text.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"
#include "tools/report/report.h"
#include "tools/report/summary_schema.h"

namespace lipoid::test {
namespace {

namespace fs = std::filesystem;

// What the page carries: {"schema": ..., "results": [...]}.
Json DataOf(const std::string& page) {
  const std::string text = ReadTextFile(page);
  const std::string_view begin = "<script type=\"application/json\" id=\"data\">";
  const auto from = text.find(begin) + begin.size();
  return Json::parse(text.substr(from, text.find("</script>", from) - from));
}

class Report : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!CanReport()) GTEST_SKIP() << "built without reports";
    folder_ = TestFolder();
    Write(folder_ + "/log.csv", kFourRowLog);
  }

  Json Summary(const std::vector<std::string>& arguments) {
    auto all = arguments;
    all.insert(all.end(), {"--summary", "s.json", "--quiet"});
    const auto run = RunLipoid(folder_, all);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ReadJson(folder_, "s.json");
  }

  // s.json changed in a way, and read again.
  RunResult Changed(const Json& summary, const std::function<void(Json&)>& change) {
    Json changed = summary;
    change(changed);
    Write(folder_ + "/c.json", JsonText(changed));
    return RunLipoid(folder_, {"report", "c.json", "-o", "c.html"});
  }

  void ExpectRefused(const RunResult& run, const std::string& message) {
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_EQ(run.err, message + "\n");
    EXPECT_FALSE(fs::exists(folder_ + "/c.html"));
  }

  std::string folder_;
};

TEST_F(Report, HasASchemaForEachCommandWithAReportAndNoOther) {
  std::vector<std::string> with_report;
  for (const auto& entry : fs::directory_iterator(SourcePath("docs/schemas"))) {
    const std::string file = entry.path().filename().string();
    const std::string command = file.substr(0, file.find('.'));
    if (command == "cell" || command == "lipoid-fleet") continue;  // no commands of this program
    const auto help = RunLipoid(folder_, {command, "--help"});
    EXPECT_EQ(help.exit_code, 0) << command;
    if (help.out.find("--report HTML") != std::string::npos) with_report.push_back(command);
  }
  std::sort(with_report.begin(), with_report.end());
  EXPECT_EQ(CommandsWithReport(), with_report);
}

TEST_F(Report, ShowsASummaryOfLogsOfWhichOneCouldNotBeRead) {
  std::ofstream(folder_ + "/broken.csv") << "no log";
  ASSERT_EQ(
      RunLipoid(folder_, {"inspect", "log.csv", "broken.csv", "--summary", "s.json"}).exit_code, 3);
  const auto run = RunLipoid(folder_, {"report", "s.json", "-o", "page.html"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(Report, MakesThePageThatTheCommandItselfMakes) {
  (void)Summary({"validate", "gifi-600mAh-1", "log.csv", "--report", "own.html"});
  const auto run = RunLipoid(folder_, {"report", "s.json", "-o", "page.html"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Json own = DataOf(folder_ + "/own.html").at("results").at(0);
  const Json page = DataOf(folder_ + "/page.html").at("results").at(0);
  EXPECT_EQ(page.at("summary"), own.at("summary"));
  EXPECT_EQ(page.at("series"), own.at("series"));
  EXPECT_EQ(page.at("series").size(), 1U);
  EXPECT_EQ(page.at("file"), "s.json");
  EXPECT_EQ(page.at("notes"), Json::array());
}

TEST_F(Report, FliesAFlightAgain) {
  (void)Summary({"fly", "hover", "--duration", "1", "-o", "flight.csv", "--report", "own.html"});
  fs::remove(folder_ + "/flight.csv");  // what a flight wrote, it does not need
  const auto run = RunLipoid(folder_, {"report", "s.json", "-o", "page.html"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_FALSE(fs::exists(folder_ + "/flight.csv"));
  const Json page = DataOf(folder_ + "/page.html").at("results").at(0);
  EXPECT_EQ(page.at("series").size(), 1U);
  EXPECT_EQ(page.at("series").at(0).at("rows"), 200);
  const Json own = DataOf(folder_ + "/own.html").at("results").at(0).at("series").at(0);
  EXPECT_EQ(page.at("series").at(0).at("columns"), own.at("columns"));
}

TEST_F(Report, ShowsSeveralResultsInTheirOrder) {
  (void)Summary({"poles", "altitude", "--xi", "0.9"});
  fs::rename(folder_ + "/s.json", folder_ + "/poles.json");
  (void)Summary({"validate", "gifi-600mAh-1", "log.csv"});
  const auto run =
      RunLipoid(folder_, {"report", "s.json", "poles.json", "-o", "p.html", "--summary", "r.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json results = ReadJson(folder_, "r.json").at("results");
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].at("command"), "validate");
  EXPECT_EQ(results[0].at("series"), 1);
  EXPECT_EQ(results[1].at("command"), "poles");
  EXPECT_EQ(results[1].at("series"), 0);
  EXPECT_EQ(DataOf(folder_ + "/p.html").at("results").size(), 2U);
}

TEST_F(Report, SaysWhichFileIsMissingOrHasChanged) {
  (void)Summary({"validate", "gifi-600mAh-1", "log.csv"});
  const auto note = [&] {
    const auto run = RunLipoid(folder_, {"report", "s.json", "-o", "page.html"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const Json page = DataOf(folder_ + "/page.html").at("results").at(0);
    EXPECT_EQ(page.at("series"), Json::array());
    EXPECT_EQ(run.err, "s.json: " + page.at("notes").at(0).get<std::string>() + "\n");
    return page.at("notes").at(0).get<std::string>();
  };
  Write(folder_ + "/log.csv", std::string(kFourRowLog) + "4,0,4.0\n");
  EXPECT_EQ(note(),
            "The charts of samples are not here: log.csv has another SHA-256 than it had. Run "
            "`lipoid validate` again with --report.");
  fs::remove(folder_ + "/log.csv");
  EXPECT_EQ(note(),
            "The charts of samples are not here: log.csv is not there any more. Run `lipoid "
            "validate` again with --report.");
}

TEST_F(Report, SaysWhereASummaryDoesNotFitItsArguments) {
  const Json summary = Summary({"validate", "gifi-600mAh-1", "log.csv"});
  const auto note = [&](const std::function<void(Json&)>& change) {
    const auto run = Changed(summary, change);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  };
  const auto expected = [](const std::string& why) {
    std::string text = "c.json: The charts of samples are not here: ";
    text += why;
    return text + ". Run `lipoid validate` again with --report.\n";
  };
  EXPECT_EQ(note([](Json& s) { s["logs"][0]["rmse_V"] = 1.0; }),
            expected("run again, `lipoid validate` finds something else than the summary says, "
                     "which lipoid " +
                     summary["run"]["version"].get<std::string>() + " (" +
                     summary["run"]["commit"].get<std::string>() + ") wrote"));
  EXPECT_EQ(note([](Json& s) { s["run"]["inputs"] = Json::array(); }),
            expected("'log.csv' is not among the inputs that the summary names"));
  EXPECT_EQ(note([](Json& s) { s["run"]["arguments"] = {"--help"}; }),
            expected("its arguments ask for help alone"));
  EXPECT_EQ(note([](Json& s) {
              s["run"]["arguments"] = {"none.json", "log.csv"};
            }).substr(0, 44),
            expected("").substr(0, 44));
}

TEST_F(Report, WritesNothingButItsPage) {
  const Json summary = Summary({"validate", "gifi-600mAh-1", "log.csv"});
  Write(folder_ + "/precious.txt", "precious");
  const auto run = Changed(summary, [](Json& s) {
    for (const char* word : {"--summary", "precious.txt", "--report", "new.html"})
      s["run"]["arguments"].push_back(word);
  });
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadTextFile(folder_ + "/precious.txt"), "precious");
  EXPECT_EQ(FilesIn(folder_),
            (std::vector<std::string>{"c.html", "c.json", "log.csv", "precious.txt", "s.json"}));
}

TEST_F(Report, RefusesToReplaceWhatItsResultsWereMadeFrom) {
  Summary({"inspect", "."});
  const std::string before = ReadTextFile(folder_ + "/log.csv");
  const auto run = RunLipoid(folder_, {"report", "s.json", "-o", "log.csv"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("'log.csv' is also an input; name another file"), std::string::npos)
      << run.err;
  EXPECT_EQ(ReadTextFile(folder_ + "/log.csv"), before);
  // Nor what the command wrote beside its summary.
  Summary({"simulate", "gifi-600mAh-1", "--current", "log.csv", "-o", "predicted.csv"});
  const std::string predicted = ReadTextFile(folder_ + "/predicted.csv");
  EXPECT_EQ(RunLipoid(folder_, {"report", "s.json", "-o", "predicted.csv"}).exit_code, 2);
  EXPECT_EQ(ReadTextFile(folder_ + "/predicted.csv"), predicted);
}

TEST_F(Report, ShowsACommandThatFailed) {
  const auto failed =
      RunLipoid(folder_, {"validate", "gifi-600mAh-1", "none.csv", "--summary", "f.json"});
  ASSERT_EQ(failed.exit_code, 3);
  const auto run = RunLipoid(folder_, {"report", "f.json", "-o", "page.html"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(DataOf(folder_ + "/page.html").at("results").at(0).at("summary").at("error").at("kind"),
            "bad-input");
}

TEST_F(Report, RefusesWhatIsNoSummary) {
  const auto refused = [&](const std::string& text) {
    Write(folder_ + "/c.json", text);
    return RunLipoid(folder_, {"report", "c.json", "-o", "c.html"});
  };
  ExpectRefused(
      refused("{\"schema\": \"lipoid.cell/1\"}\n"),
      "c.json: error: expected the results of a command, found a cell file; what made it writes a page, too: "
      "lipoid identify CAMPAIGN --report PAGE");
  ExpectRefused(
      refused("{\"schema\": [1]}\n"),
      "c.json:1:1: error: /: expected what `lipoid COMMAND --summary` writes, an object with "
      "the key 'command', found an object");
  ExpectRefused(
      refused("[1, 2]\n"),
      "c.json:1:1: error: /: expected what `lipoid COMMAND --summary` writes, an object with "
      "the key 'command', found a list of 2");
  ExpectRefused(refused("{\"command\": 7}\n"),
                "c.json:1:13: error: /command: expected a text, found 7");
  ExpectRefused(
      refused("{\"command\": \"convert\"}\n"),
      "c.json:1:13: error: /command: expected one of the commands whose results can be "
      "shown (ageing, compare, design, endurance, export, fly, health, identify, inspect, plan, poles, "
      "simulate, study, validate, vehicle), found \"convert\"");
  ExpectRefused(refused("{\"command\": \"validate\"}\n"),
                "c.json:1:1: error: /: expected an object with the key 'edges', found an object");
  ExpectRefused(refused("{\"command\": \"poles\", \"command\": \"poles\"}\n"),
                "c.json:1:22: error: expected every key once, found 'command' again");
}

TEST_F(Report, RefusesValuesOfAnotherType) {
  const Json poles = Summary({"poles", "altitude", "--xi", "0.9"});
  const auto message = [&](const std::function<void(Json&)>& change) {
    const auto run = Changed(poles, change);
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_FALSE(fs::exists(folder_ + "/c.html"));
    return run.err;
  };
  EXPECT_NE(
      message([](Json& s) { s["rows"] = 3; }).find(": error: /rows: expected a list, found 3"),
      std::string::npos);
  EXPECT_NE(message([](Json& s) {
              s["rows"][0]["xi"] = "0.9";
            }).find(": error: /rows/0/xi: expected a number, found \"0.9\""),
            std::string::npos);
  EXPECT_NE(message([](Json& s) {
              s["rows"][0]["poles"][0] = Json::object();
            }).find(": error: /rows/0/poles/0: expected a list, found an object"),
            std::string::npos);
  EXPECT_NE(message([](Json& s) {
              s["rows"][0].erase("kappa");
            }).find(": error: /rows/0: expected an object with the key 'kappa', found an object"),
            std::string::npos);
  EXPECT_NE(message([](Json& s) {
              s["run"]["inputs"] = {7};
            }).find(": error: /run/inputs/0: expected an object, found 7"),
            std::string::npos);
  // The run record has no numbers, and a page needs all of it.
  EXPECT_NE(message([](Json& s) {
              s["run"]["arguments"] = nullptr;
            }).find(": error: /run/arguments: expected a list, found null"),
            std::string::npos);
  EXPECT_NE(message([](Json& s) {
              s["run"]["inputs"] = {nullptr};
            }).find(": error: /run/inputs/0: expected an object, found null"),
            std::string::npos);
  // What could not be computed is null, and what a later lipoid adds is passed over.
  EXPECT_EQ(Changed(poles,
                    [](Json& s) {
                      s["rows"][0]["kappa"] = nullptr;
                      s["later"] = 1;
                    })
                .exit_code,
            0);
}

TEST_F(Report, HoldsNoMarkupThatItsNamesBring) {
  const Json poles = Summary({"poles", "altitude", "--xi", "0.9"});
  const auto run =
      Changed(poles, [](Json& s) { s["vehicle"] = "</script><script>alert(1)</script><!--"; });
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadTextFile(folder_ + "/c.html").find("<script>alert"), std::string::npos);
  EXPECT_EQ(DataOf(folder_ + "/c.html").at("results").at(0).at("summary").at("vehicle"),
            "</script><script>alert(1)</script><!--");
}

}  // namespace
}  // namespace lipoid::test
