// Logs of one format have one sign: who settles whom, and what is said about it.
#include "identify/logs/read_logs.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::kLogHeader;

// Falls by 1 V while 2 A flow, which count as `written`.
std::string TextOfDischarge(double written) {
  std::string text = kLogHeader;
  for (int k = 0; k <= 100; ++k) {
    text += std::to_string(36 * k) + "," + std::to_string(k > 0 ? written : 0.0) + "," +
            std::to_string(4.1 - 0.01 * k) + "\n";
  }
  return text;
}

const std::string kTextOfRest = kLogHeader + "0,0,4.1\n60,0,4.1\n120,0,4.1\n";

// The amount of a discharge and of the charge after it.
std::string AmountOfACycle() {
  std::string text = kLogHeader;
  for (int k = 0; k <= 200; ++k) {
    text += std::to_string(36 * k) + ",2," +
            std::to_string(k <= 100 ? 4.1 - 0.01 * k : 3.15 + 0.01 * (k - 100)) + "\n";
  }
  return text;
}

struct Outcome {
  std::map<std::string, Log> logs;  // by name
  std::map<std::string, std::string> problems;
};

Outcome ReadTogether(const std::string& name,
                     const std::vector<std::pair<std::string, std::string>>& files,
                     const std::map<std::string, ReadOptions>& options = {}) {
  const std::string folder = test::FreshFolder("read_logs/" + name);
  std::vector<LogToRead> logs;
  for (const auto& [file, text] : files) {
    std::ofstream(folder + "/" + file) << text;
    const auto given = options.find(file);
    logs.push_back({folder + "/" + file, given != options.end() ? given->second : ReadOptions{}});
  }
  std::vector<Log> taken(logs.size());
  const auto problems = ReadLogs(logs, [&](std::size_t k, Log log) { taken[k] = std::move(log); });
  Outcome outcome;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (problems[k].empty()) {
      outcome.logs[files[k].first] = std::move(taken[k]);
    } else {
      outcome.problems[files[k].first] = problems[k].front().message;
    }
  }
  return outcome;
}

TEST(ReadLogs, OneSettledLogSettlesItsNeighbours) {
  const Outcome outcome = ReadTogether("settles",
                                       {{"a_rest.csv", kTextOfRest},
                                        {"b.csv", TextOfDischarge(-2.0)},
                                        {"c.csv", TextOfDischarge(-2.0)},
                                        {"d_rest.csv", kTextOfRest}});
  EXPECT_TRUE(outcome.problems.empty());
  const LogReport& rest = outcome.logs.at("a_rest.csv").report;
  EXPECT_EQ(rest.current_sign, "discharge-negative");
  EXPECT_TRUE(rest.current_sign_is_of_others);
  EXPECT_EQ(rest.current_sign_reason,
            "discharge is negative as in b.csv and 1 more, of the same format; by itself this log "
            "does not settle it: no current flows");
  EXPECT_TRUE(outcome.logs.at("d_rest.csv").report.current_sign_is_of_others);
  EXPECT_FALSE(outcome.logs.at("b.csv").report.current_sign_is_of_others);
  EXPECT_EQ(outcome.logs.at("b.csv").record.current_A.back(), 2.0);
}

TEST(ReadLogs, LogsThatDisagreeSettleNone) {
  const Outcome outcome = ReadTogether("disagree",
                                       {{"one.csv", TextOfDischarge(2.0)},
                                        {"other.csv", TextOfDischarge(-2.0)},
                                        {"rest.csv", kTextOfRest}});
  EXPECT_EQ(outcome.logs.size(), 2U);
  EXPECT_EQ(outcome.problems.at("rest.csv"),
            "expected a current whose sign the data settle, found that no current flows, and that "
            "the other logs of its format disagree (one.csv says that discharge is positive, "
            "other.csv says that discharge is negative); say `current_sign` (--current-sign "
            "discharge-positive or discharge-negative), or read a part of the log");
}

TEST(ReadLogs, AnotherFormatSettlesNothing) {
  std::string other = TextOfDischarge(-2.0);
  other.replace(0, kLogHeader.size(), "Time [s],I [A],U [V]\n");
  const Outcome outcome =
      ReadTogether("formats", {{"other.csv", other}, {"rest.csv", kTextOfRest}});
  EXPECT_EQ(outcome.problems.at("rest.csv"),
            "expected a current whose sign the data settle, found that no current flows; say "
            "`current_sign` (--current-sign discharge-positive or discharge-negative), or read a "
            "part of the log");
}

TEST(ReadLogs, ALogThatContradictsItselfIsSettledByNone) {
  const Outcome outcome = ReadTogether(
      "contradicts", {{"plain.csv", TextOfDischarge(2.0)}, {"amount.csv", AmountOfACycle()}});
  EXPECT_EQ(
      outcome.problems.at("amount.csv"),
      "expected a current whose sign the data settle, found that the voltage falls with the "
      "current in some places and rises in others, as if the current had no sign or another pack began in between; say "
      "`current_sign` (--current-sign discharge-positive or discharge-negative), or read a "
      "part of the log");
}

TEST(ReadLogs, WhatIsGivenWinsAndSettlesTheOthers) {
  const Outcome outcome = ReadTogether("given",
                                       {{"given.csv", kTextOfRest}, {"open.csv", kTextOfRest}},
                                       {{"given.csv", {.current_sign = "discharge-negative"}}});
  EXPECT_EQ(outcome.logs.at("given.csv").report.current_sign_reason,
            "given by the option current_sign");
  EXPECT_EQ(outcome.logs.at("open.csv").report.current_sign, "discharge-negative");
  EXPECT_TRUE(outcome.logs.at("open.csv").report.current_sign_is_of_others);

  const Outcome against =
      ReadTogether("against",
                   {{"given.csv", kTextOfRest}, {"found.csv", TextOfDischarge(2.0)}},
                   {{"given.csv", {.current_sign = "discharge-negative"}}});
  EXPECT_EQ(against.logs.at("given.csv").report.current_sign, "discharge-negative");
  EXPECT_EQ(against.logs.at("found.csv").report.current_sign, "discharge-positive");
}

TEST(ReadLogs, WhatTakeRefusesIsAProblemOfThatFile) {
  const std::string folder = test::FreshFolder("read_logs/take");
  std::ofstream(folder + "/a.csv") << TextOfDischarge(2.0);
  std::ofstream(folder + "/b.csv") << TextOfDischarge(2.0);
  const auto problems = ReadLogs({{folder + "/a.csv", {}}, {folder + "/b.csv", {}}},
                                 [](std::size_t k, const Log& log) {
                                   if (k == 1) throw LoadError({log.record.file, 3, 1}, "no");
                                 });
  EXPECT_TRUE(problems[0].empty());
  ASSERT_EQ(problems[1].size(), 1U);
  EXPECT_EQ(problems[1][0].Text(), folder + "/b.csv:3:1: error: no");
}

}  // namespace
}  // namespace lipoid
