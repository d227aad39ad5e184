// The framework of the command line, without the program: suggestions, tables, and what Run() makes
// of everything that a command may do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/throws.h"
#include "tools/cli/run.h"
#include "tools/cli/shell_word.h"
#include "tools/cli/text_table.h"

namespace lipoid::cli {
namespace {

using test::ReadJson;
using test::TestFolder;

// One of each kind of option_kinds.h.
struct EveryKind {
  bool flag = false;
  std::optional<int> count = 3;
  std::vector<double> times_s = {1.0, 2.0};
  std::map<std::string, double> fixed = {};
  std::map<std::string, Ends> bounds = {};
  std::map<std::string, std::string> columns = {};
  std::vector<std::string> words = {"a", "b"};
  InputFile file = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("flag", self.flag, Names(), "a flag");
    v("count_it", self.count, Range{0, 5}, "a count");
    v("times_s", self.times_s, Range{0.0, 100.0}, "times, s");
    v("fix", self.fixed, Word{"NAME=VALUE"}, "values");
    v("bounds", self.bounds, Word{"NAME=LOW,HIGH"}, "intervals");
    v("columns", self.columns, Word{"KEY=NAME"}, "names");
    v("words", self.words, Word{"NAME,..."}, "words");
    v("file", self.file, Word{"FILE"}, "a file");
  }
};

struct Nested {
  int count = 1;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("count", self.count, Range{0, 5}, "a count");
  }
};

EveryKind Read(std::vector<std::string> arguments, std::vector<std::string>* inputs = nullptr) {
  const Command command{"kinds", "", nullptr};
  CommandLine line(command, std::move(arguments));
  EveryKind options;
  line.Each(options);
  Nested nested;
  line.Group("nested", nested);
  EXPECT_TRUE(line.Parse());
  if (inputs != nullptr) *inputs = line.inputs();
  return options;
}

TEST(Each, ReadsEveryKindOfOption) {
  std::vector<std::string> inputs;
  const EveryKind read = Read({"--flag",
                               "--count-it",
                               "4",
                               "--times-s",
                               "5,10:10:30",
                               "--fix",
                               "beta=0.2,r_s=0.1",
                               "tau_1=3",
                               "--bounds",
                               "beta=0.1,0.5",
                               "--columns",
                               "time_s=Zeit, in s",
                               "--words",
                               "c,d",
                               "--file",
                               "in.json"},
                              &inputs);
  EXPECT_TRUE(read.flag);
  EXPECT_EQ(read.count, 4);
  EXPECT_EQ(read.times_s, (std::vector<double>{5.0, 10.0, 20.0, 30.0}));
  EXPECT_EQ(read.fixed,
            (std::map<std::string, double>{{"beta", 0.2}, {"r_s", 0.1}, {"tau_1", 3.0}}));
  EXPECT_EQ(read.bounds, (std::map<std::string, Ends>{{"beta", {0.1, 0.5}}}));
  EXPECT_EQ(read.columns, (std::map<std::string, std::string>{{"time_s", "Zeit, in s"}}));
  EXPECT_EQ(read.words, (std::vector<std::string>{"c", "d"}));
  EXPECT_EQ(read.file.path, "in.json");
  EXPECT_EQ(inputs, std::vector<std::string>{"in.json"});  // no output may be that
}

TEST(Each, KeepsDefaultsAndTakesSettingsToo) {
  const EveryKind kept = Read({});
  EXPECT_EQ(kept.count, 3);
  EXPECT_EQ(kept.times_s, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(kept.words, (std::vector<std::string>{"a", "b"}));
  const EveryKind set = Read({"--set", "flag=true", "--set", "count_it=0", "--set", "times_s=7"});
  EXPECT_TRUE(set.flag);
  EXPECT_EQ(set.count, 0);
  EXPECT_EQ(set.times_s, std::vector<double>{7.0});
  EXPECT_FALSE(Read({"--set", "flag=false"}).flag);
}

TEST(Each, RefusesWhatIsNotOfItsKind) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"--count-it", "6"}, "option --count-it: expected a whole number, 0 .. 5, found '6'"},
      {{"--times-s", "1,101"}, "option --times-s: expected 0 .. 100, found '101'"},
      {{"--times-s", ""}, "option --times-s: expected a number, 0 .. 100, found ''"},
      {{"--file", ""}, "option --file: expected FILE, found ''"},
      {{"--fix", "beta"}, "option --fix: expected NAME=VALUE, found 'beta'"},
      {{"--bounds", "beta=1"}, "option --bounds: expected NAME=LOW,HIGH, found 'beta=1'"},
      {{"--columns", "Zeit"}, "option --columns: expected KEY=NAME, found 'Zeit'"},
      {{"--words", "a,"}, "option --words: expected NAME,..., found 'a,'"},
      {{"--set", "flag=perhaps"}, "option flag: expected true or false, found 'perhaps'"},
      {{"--fix", "beta=0.1", "beta=0.3"}, "option --fix beta is given twice; give it once"},
      {{"--bounds", "beta=0,1", "--bounds", "beta=0,2"},
       "option --bounds beta is given twice; give it once"},
      {{"--columns", "time_s=a", "time_s=b"},
       "option --columns time_s is given twice; give it once"},
      {{"--count-it", "2", "--set", "count_it=2"}, "option count_it is given twice; give it once"},
      {{"--set", "flag=false", "--flag"}, "option flag is given twice; give it once"},
      {{"--set", "count_it=2", "--set", "count_it=4"},
       "option count_it is given twice; give it once"},
      {{"--set", "nested.count=2", "--set", "nested.count=4"},
       "option nested.count is given twice; give it once"}};
  for (const auto& [arguments, message] : cases)
    EXPECT_EQ(test::MessageOf<OptionError>([&, &given = arguments] { (void)Read(given); }),
              message);
}

TEST(TextTable, PutsNumbersRightAndWordsLeftAndCountsLettersNotBytes) {
  TextTable table({{"log", Align::kLeft}, {"mean / %"}});
  table.Row({"zelle_ä.csv", "0.2234"});
  table.Row({"b", "12"});
  EXPECT_EQ(table.Text(),
            "log          mean / %\n"
            "zelle_ä.csv    0.2234\n"
            "b                  12\n");
}

TEST(TextTable, BreaksHeadersAndWordsWhereAScreenEnds) {
  TextTable table({{"name", Align::kLeft}, {"mean error / %"}, {"what it does", Align::kLeft}});
  std::string words;
  for (int k = 0; k < 30; ++k) words += "word" + std::to_string(k) + " ";
  table.Row({"a", "0.1", words + "end"});
  table.Row({"b", "0.2", "short"});
  const auto text = table.Text();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << text;
  EXPECT_EQ(text.rfind("name  mean error / %  what it does\na                0.1  word0 ", 0), 0U)
      << text;
  EXPECT_NE(text.find(" end\nb                0.2  short\n"), std::string::npos) << text;
  for (int k = 0; k < 30; ++k)
    EXPECT_NE(text.find("word" + std::to_string(k)), std::string::npos) << k;

  // Headers of numbers break before their unit; they stand right above the numbers.
  std::vector<TextTable::Column> columns{{"log", Align::kLeft}};
  for (int k = 0; k < 9; ++k) columns.push_back({"mean error / %"});
  TextTable numbers(std::move(columns));
  numbers.Row({"a", "1", "2", "3", "4", "5", "6", "7", "8", "9"});
  const auto wrapped = numbers.Text();
  std::vector<std::string> shown;
  std::istringstream wrapped_lines(wrapped);
  for (std::string line; std::getline(wrapped_lines, line);) {
    EXPECT_LE(line.size(), 100U) << wrapped;
    shown.push_back(line);
  }
  ASSERT_GE(shown.size(), 3U) << wrapped;
  EXPECT_NE(shown[0].find("mean"), std::string::npos) << wrapped;
  EXPECT_EQ(shown[0].find('%'), std::string::npos) << wrapped;
  EXPECT_EQ(shown[shown.size() - 2].rfind("log ", 0), 0U) << wrapped;
  EXPECT_NE(shown[shown.size() - 2].find("/ %"), std::string::npos) << wrapped;
}

TEST(TextTable, LeavesOutTheFolderThatFilesHaveInCommonWhereAScreenEnds) {
  const std::string folder = "../a/folder/of/so/many/names/that/a/screen/is/too/narrow/for/them";
  const auto shown = [](const std::vector<std::string>& files, const std::string& word) {
    TextTable table({{"log", Align::kFile}, {"mean / %"}, {"why", Align::kLeft}});
    for (const auto& file : files) table.Row({"   " + file, "0.1", word});
    return table.Text();
  };
  EXPECT_EQ(
      shown({folder + "/t25/pulse.csv", folder + "/t2/cc.csv"}, "here are thirty letters or more"),
      "log               mean / %  why\n"
      "   t25/pulse.csv       0.1  here are thirty letters or more\n"
      "   t2/cc.csv           0.1  here are thirty letters or more\n");
  // Where there is room, or no folder in common, names stay as they are.
  EXPECT_NE(shown({folder + "/t25/pulse.csv"}, "here").find(folder), std::string::npos);
  const auto apart = shown({folder + "/pulse.csv", "/b"}, "here are thirty letters or more");
  EXPECT_NE(apart.find(folder + "/pulse.csv"), std::string::npos) << apart;
  // An indent does not push the numbers of its row to the right.
  const auto column = [&](const std::string& name) {
    const auto row = apart.find(name);
    return apart.find("0.1", row) - apart.rfind('\n', row);
  };
  EXPECT_EQ(column("   .."), column("   /b")) << apart;
}

TEST(TextTable, IsATableForLatexWithNothingThatLatexReadsAsACommand) {
  TextTable table({{"log", Align::kLeft}, {"cost / V²"}}, "Errors in %.");
  table.Row({"a_b&c#1$", "0.22"});
  EXPECT_EQ(table.Latex(),
            "\\begin{table}\n"
            "  \\centering\n"
            "  \\caption{Errors in \\%.}\n"
            "  \\begin{tabular}{lr}\n"
            "    \\toprule\n"
            "    log & cost / V\\textsuperscript{2} \\\\\n"
            "    \\midrule\n"
            "    a\\_b\\&c\\#1\\$ & 0.22 \\\\\n"
            "    \\bottomrule\n"
            "  \\end{tabular}\n"
            "\\end{table}\n");
  EXPECT_EQ(LatexText("beta / s^-1/2 \\x{y}~"),
            "beta / s\\textsuperscript{-1/2} \\textbackslash{}x\\{y\\}\\textasciitilde{}");
}

TEST(TextTable, WithACaptionIsKeptForThePaperOnceItIsShown) {
  TextTable shown({{"log", Align::kLeft}}, "Shown.");
  const TextTable hidden({{"log", Align::kLeft}}, "Hidden.");
  const TextTable plain({{"log", Align::kLeft}});
  (void)shown.Text();  // nobody writes a paper yet
  {
    const TablesForPaper paper;
    (void)shown.Text();
    (void)plain.Text();
    EXPECT_EQ(paper.latex(), "\n" + shown.Latex());
    TablesForPaper::About("a_b.csv");
    (void)shown.Text();
    TablesForPaper::About("");
    (void)shown.Text();
    EXPECT_EQ(paper.latex(),
              "\n" + shown.Latex() + "\n" + shown.Latex("a_b.csv: ") + "\n" + shown.Latex());
    EXPECT_NE(shown.Latex("a_b.csv: ").find("\\caption{a\\_b.csv: Shown.}"), std::string::npos);
  }
  const TablesForPaper next;
  EXPECT_EQ(next.latex(), "");
}

// As POSIX says (Shell Command Language, 2.2.2): nothing ends single quotes but a single quote.
TEST(ShellWord, IsReadBackByAShell) {
  EXPECT_EQ(ShellWord("logs/cc_1C.csv"), "logs/cc_1C.csv");
  EXPECT_EQ(ShellWord(""), "''");
  EXPECT_EQ(ShellWord("a'b"), "'a'\\''b'");
  for (const std::string word :
       {"it's $HOME", "'", "a b", "~/x", "*", "[a]{b}", "#", "!", "\\", "\"$(exit)`\"", "ä"}) {
    const auto read = test::RunShell(test::TestFolder(), "printf %s " + ShellWord(word));
    EXPECT_EQ(read.out, word);
  }
}

TEST(Wrapped, BreaksAtBlanksAndWhereThereAreNoneAfterCommas) {
  const std::string words(60, 'a');
  EXPECT_EQ(Wrapped(words + " " + words, 2), words + "\n  " + words);
  EXPECT_EQ(Wrapped("a b"), "a b");
  EXPECT_EQ(Wrapped(""), "");
  std::string names = "default ";
  for (int k = 0; k < 30; ++k) names += "name" + std::to_string(k) + (k < 29 ? "," : "");
  std::string whole;
  std::istringstream lines(Wrapped(names, 30));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 100U);
    whole += whole.empty() ? line : line.substr(30);
  }
  whole.erase(std::remove(whole.begin(), whole.end(), ' '), whole.end());
  names.erase(std::remove(names.begin(), names.end(), ' '), names.end());
  EXPECT_EQ(whole, names) << "no letter is lost";
  EXPECT_EQ(Wrapped(std::string(150, 'x')), std::string(150, 'x'))
      << "what cannot be broken is not";
  EXPECT_EQ(WrappedLines("one\n\n" + words + " " + words), "one\n\n" + words + "\n" + words);
}

TEST(Significant, KeepsSoManyDigitsAndNoMore) {
  EXPECT_EQ(Significant(0.22341), "0.2234");
  EXPECT_EQ(Significant(1353.6), "1354");
  EXPECT_EQ(Significant(115860.4), "115860");
  EXPECT_EQ(Significant(2.4e-5), "2.400e-05");
  EXPECT_EQ(Significant(9.99996), "10.00");  // the carry makes a digit more before the point
  EXPECT_EQ(Significant(-0.5, 2), "-0.50");
  EXPECT_EQ(Significant(0.0), "0");
  EXPECT_EQ(Significant(std::nan("")), "-");
}

ExitCode Succeed(CommandLine& line) {
  int number = 3;
  std::vector<std::string> words;
  line.Describe("Does it.", "lipoid succeed");
  line.Option("number", number, Range{0, 5}, "a number");
  line.Arguments("WORD", words, "words", 0);
  if (!line.Parse()) return ExitCode::kDone;
  line.summary()["number"] = number;
  line.summary()["words"] = words;
  line.Message("a message");
  line.Print("data {}\n", number);
  for (const auto& word : words) {
    if (word.size() < 3) continue;
    line.Print("word {}\n", word);
    line.Message("about {}", word);
  }
  return number == 5 ? ExitCode::kIncomplete : ExitCode::kDone;
}
ExitCode ThrowAfterPrinting(CommandLine& line) {
  if (!line.Parse()) return ExitCode::kDone;
  line.Print("half of the data\n");
  throw LoadError({{{"a.csv", 12, 7}, "expected a number, found 'abc'"}, {{"b.csv"}, "is empty"}});
}
ExitCode RunOutOfMemory(CommandLine&) { throw std::bad_alloc(); }
ExitCode ThrowAnything(CommandLine&) { throw 7; }
ExitCode BreakARule(CommandLine&) {
  Require(false, "dt_s > 0");
  return ExitCode::kDone;
}

ExitCode FindNoThread(CommandLine&) {
  throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
}

constexpr Command kCommands[] = {{"anything", "throws an int", &ThrowAnything},
                                 {"load", "throws a LoadError", &ThrowAfterPrinting},
                                 {"memory", "runs out of memory", &RunOutOfMemory},
                                 {"rule", "breaks a rule", &BreakARule},
                                 {"succeed", "succeeds", &Succeed},
                                 {"system", "gets no thread", &FindNoThread}};

struct Outcome {
  int exit_code;
  std::string out;
  std::string err;
};

Outcome RunHere(const std::vector<std::string>& arguments) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = Run(kCommands, arguments);
  const auto out = testing::internal::GetCapturedStdout();
  return {exit_code, out, testing::internal::GetCapturedStderr()};
}

TEST(Run, PrintsDataAndMessagesOnTheirStreamsAndWritesTheSummary) {
  const auto folder = TestFolder();
  const auto done =
      RunHere({"succeed", "a", "--number", "4", "b", "--summary", folder + "/s.json"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_EQ(done.out, "data 4\n");
  EXPECT_EQ(done.err, "a message\n");
  EXPECT_EQ(
      ReadJson(folder, "s.json"),
      Json::parse(R"({"command": "succeed", "exit_code": 0, "number": 4, "words": ["a", "b"]})"));
  EXPECT_EQ(RunHere({"succeed", "--quiet"}).err, "");
}

TEST(Run, KeepsTheExitCodeAndTheResultsOfACommandThatDidNotConverge) {
  const auto folder = TestFolder();
  EXPECT_EQ(RunHere({"succeed", "--number", "5", "--summary", folder + "/s.json"}).exit_code, 1);
  EXPECT_EQ(ReadJson(folder, "s.json").at("exit_code"), 1);
  EXPECT_EQ(ReadJson(folder, "s.json").at("number"), 5);
}

TEST(Run, BadInputIsThreeWithEveryDiagnosticAndNoHalfOfTheData) {
  const auto folder = TestFolder();
  const auto failed = RunHere({"load", "--summary=" + folder + "/s.json"});
  EXPECT_EQ(failed.exit_code, 3);
  EXPECT_EQ(failed.out, "");
  EXPECT_EQ(failed.err,
            "a.csv:12:7: error: expected a number, found 'abc'\nb.csv:1:1: error: is empty\n");
  EXPECT_EQ(ReadJson(folder, "s.json"), Json::parse(R"({
    "command": "load", "exit_code": 3, "error": {
      "kind": "bad-input",
      "message": "a.csv:12:7: error: expected a number, found 'abc'\nb.csv:1:1: error: is empty",
      "diagnostics": [
        {"file": "a.csv", "line": 12, "column": 7, "message": "expected a number, found 'abc'"},
        {"file": "b.csv", "line": 1, "column": 1, "message": "is empty"}]}})"));
}

TEST(Run, WhateverACommandThrowsIsOneLineAndAnExitCode) {
  const auto memory = RunHere({"memory"});
  EXPECT_EQ(memory.exit_code, 1);
  EXPECT_EQ(memory.err,
            "lipoid memory: error: out of memory; give it less at once, or a machine with more\n");
  constexpr const char* kReport =
      ": error: this should not have happened, and is a mistake of lipoid ";
  const auto anything = RunHere({"anything"});
  EXPECT_EQ(anything.exit_code, 4);
  EXPECT_NE(anything.err.find(kReport), std::string::npos) << anything.err;
  const auto folder = TestFolder();
  const auto rule = RunHere({"rule", "--summary", folder + "/s.json"});
  EXPECT_EQ(rule.exit_code, 4);
  EXPECT_NE(rule.err.find(kReport), std::string::npos) << rule.err;
  EXPECT_NE(rule.err.find("precondition broken: dt_s > 0"), std::string::npos) << rule.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("exit_code"), 4);
  EXPECT_EQ(ReadJson(folder, "s.json").at("error").at("kind"), "internal");
  EXPECT_NE(RunHere({"--help"}).out.find("4 internal error"), std::string::npos);
  const auto system = RunHere({"system"});
  EXPECT_EQ(system.exit_code, 4);
  EXPECT_NE(system.err.find("Resource temporarily unavailable"), std::string::npos) << system.err;
}

TEST(Run, TextFromElsewhereDoesNotReachTheTerminalRaw) {
  const auto run = RunHere({"succeed", "\x1b[2J\x1b]0;title\a"});
  EXPECT_EQ(run.out, "data 3\nword \\x1b[2J\\x1b]0;title\\x07\n");
  EXPECT_EQ(run.err, "a message\nabout \\x1b[2J\\x1b]0;title\\x07\n");
  const auto wrong = RunHere({"succeed", "--\x1b[2J"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(wrong.err.find('\x1b'), std::string::npos) << wrong.err;
  const auto large = RunHere({"succeed", std::string(100'000, 'x')});
  EXPECT_LT(large.err.size(), 10'000U);
}

TEST(Run, ASummaryThatCannotBeWrittenIsSaidBeforeTheCommandRuns) {
  const auto failed = RunHere({"load", "--summary", "/no/such/folder/s.json"});
  EXPECT_EQ(failed.exit_code, 2);
  EXPECT_EQ(
      failed.err,
      "lipoid: error: cannot write '/no/such/folder/s.json': No such file or directory; make its folder first\n"
      "Try 'lipoid --help'.\n");
}

struct Wrong {
  std::vector<std::string> arguments;
  const char* message;
};

TEST(Run, UsageErrorsSayWhatIsKnownAndWhatWasMeant) {
  const Wrong all[] = {
      {{}, "lipoid: error: a command is missing\nTry 'lipoid --help'.\n"},
      {{"sucede"},
       "lipoid: error: unknown command 'sucede'. Did you mean 'succeed'? Known: anything, load, "
       "memory, "
       "rule, succeed, system\nTry 'lipoid --help'.\n"},
      {{"--verison"},
       "lipoid: error: unknown option '--verison'. Did you mean '--version'? Known: "
       "--completion, --help, --manual, --schema, --version\n"
       "Try 'lipoid --help'.\n"},
      {{"succeed", "--numbre", "1"},
       "lipoid succeed: error: unknown option '--numbre'. Did you mean '--number'? Known: "
       "--summary, "
       "--seed, --threads, --quiet, --set, --help, --number\nTry 'lipoid succeed --help'.\n"},
      {{"succeed", "--num", "1"},  // abbreviations are not guessed
       "lipoid succeed: error: unknown option '--num'. Known: --summary, --seed, --threads, "
       "--quiet, "
       "--set, --help, --number\nTry 'lipoid succeed --help'.\n"},
      {{"succeed", "--number", "6"},
       "lipoid succeed: error: option --number: expected a whole number, 0 .. 5, found '6'\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--number", "2.5"},
       "lipoid succeed: error: option --number: expected a whole number, 0 .. 5, found '2.5'\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--number"},
       "lipoid succeed: error: option --number: expected a value, found none\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--quiet=1"},
       "lipoid succeed: error: option --quiet takes no value; leave out '=' and what follows\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--number", "1", "--number", "2"},
       "lipoid succeed: error: option --number is given twice; give it once\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--set", "number=1"},
       "lipoid succeed: error: option --set: unknown option 'number'; there are none\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--set", "number"},
       "lipoid succeed: error: option --set: expected OPTION=VALUE, found 'number'\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--seed", "-1"},
       "lipoid succeed: error: option --seed: expected a whole number of at least 0, found '-1'\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "--threads", "0"},
       "lipoid succeed: error: option --threads: expected a whole number, 1 .. 4096, found '0'\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"succeed", "word", ""},  // of a variable that is not set
       "lipoid succeed: error: WORD is an empty text; expected words\n"
       "Try 'lipoid succeed --help'.\n"},
      {{"load", "word"},
       "lipoid load: error: 'word' is one argument too many\nTry 'lipoid load --help'.\n"},
  };
  for (const auto& [arguments, message] : all) {
    const auto failed = RunHere(arguments);
    EXPECT_EQ(failed.exit_code, 2) << message;
    EXPECT_EQ(failed.out, "");
    EXPECT_EQ(failed.err, message);
  }
}

TEST(Run, AUsageErrorStillWritesTheSummary) {
  const auto folder = TestFolder();
  EXPECT_EQ(RunHere({"succeed", "--numbre", "--summary", folder + "/s.json"}).exit_code, 2);
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("exit_code"), 2);
  EXPECT_EQ(summary.at("error").at("kind"), "usage");
}

TEST(Run, ASummaryOfBytesThatAreNoTextIsStillJson) {
  const auto folder = TestFolder();
  EXPECT_EQ(RunHere({"succeed", "\xff\xfe.csv", "--summary", folder + "/s.json"}).exit_code, 0);
  EXPECT_EQ(ReadJson(folder, "s.json").at("words").size(), 1U);
}

}  // namespace
}  // namespace lipoid::cli
