// The manual page and the completions of shells, of the program as it is built.
#include <gtest/gtest.h>

#include <string>

#include "model/core/run_record.h"
#include "tests/support/run_lipoid.h"

namespace lipoid {
namespace {

using test::RunLipoid;
using test::RunShell;
using test::TestFolder;

// What bash offers for the last of these words.
std::string OfferedByBash(const std::string& words, int last) {
  const auto result = RunShell(
      TestFolder(),
      "$LIPOID --completion bash > c.bash && bash -c '. ./c.bash; COMP_WORDS=(" + words +
          "); COMP_CWORD=" + std::to_string(last) + "; _lipoid; echo \"${COMPREPLY[@]}\"'");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result.out;
}

TEST(Completion, BashOffersCommandsOptionsChoicesAndSettings) {
  EXPECT_EQ(OfferedByBash("lipoid val", 1), "validate\n");
  EXPECT_EQ(OfferedByBash("lipoid identify --resid", 2), "--residuals\n");
  EXPECT_EQ(OfferedByBash("lipoid identify --method sta", 3), "staged\n");
  EXPECT_EQ(OfferedByBash("lipoid identify --set solver.max_iter", 3), "solver.max_iterations=\n");
  EXPECT_EQ(OfferedByBash("lipoid validate --initial-soc 0", 3), "\n");  // a number: nothing
}

TEST(Completion, BashOffersFilesElsewhere) {
  const auto result =
      RunShell(TestFolder(),
               "$LIPOID --completion bash > c.bash && touch pulses.csv && bash -c '. ./c.bash; "
               "COMP_WORDS=(lipoid inspect pul); COMP_CWORD=2; _lipoid; echo \"${COMPREPLY[@]}\"'");
  EXPECT_EQ(result.out, "pulses.csv\n") << result.err;
}

// Each option that --help of a command shows is offered by every shell.
TEST(Completion, EveryShellKnowsTheOptionsOfACommand) {
  const auto folder = TestFolder();
  const auto zsh = RunLipoid(folder, {"--completion", "zsh"});
  const auto fish = RunLipoid(folder, {"--completion", "fish"});
  const auto bash = RunLipoid(folder, {"--completion", "bash"});
  const auto help = RunLipoid(folder, {"fly", "--help"}).out;
  int options = 0;
  for (auto at = help.find("  --"); at != std::string::npos; at = help.find("\n  --", at + 1)) {
    const auto from = help.find("--", at) + 2;
    const auto name = help.substr(from, help.find_first_of(" \n", from) - from);
    ++options;
    EXPECT_NE(bash.out.find("--" + name), std::string::npos) << name;
    EXPECT_NE(zsh.out.find("--" + name + "["), std::string::npos) << name;
    EXPECT_NE(fish.out.find("__fish_seen_subcommand_from fly' -l " + name), std::string::npos)
        << name;
  }
  EXPECT_GT(options, 5);
}

TEST(Completion, ShellsTakeTheirScript) {
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    if (RunShell(TestFolder(), "command -v " + shell).exit_code != 0) continue;
    const auto read = RunShell(
        TestFolder(), "$LIPOID --completion " + shell + " > script && " + shell + " -n script");
    EXPECT_EQ(read.exit_code, 0) << shell << ": " << read.err;
  }
}

TEST(Completion, AnUnknownShellIsRefused) {
  const auto result = RunLipoid(TestFolder(), {"--completion", "csh"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("unknown shell 'csh'. Did you mean 'zsh'? Known: bash, zsh, fish"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(RunLipoid(TestFolder(), {"--completion"}).exit_code, 2);
}

TEST(Manual, HasASectionForEveryCommandAndALineForEveryOption) {
  const auto folder = TestFolder();
  const auto page = RunLipoid(folder, {"--manual"});
  EXPECT_EQ(page.exit_code, 0) << page.err;
  EXPECT_EQ(page.out.rfind(".TH LIPOID 1", 0), 0U);
  for (const std::string part : {".SH IDENTIFY\n",
                                 ".SH VALIDATE\n",
                                 ".SH EXIT STATUS\n",
                                 ".B \\-o, \\-\\-output",
                                 ".B \\-\\-residuals CSV"}) {
    EXPECT_NE(page.out.find(part), std::string::npos) << part;
  }
}

// groff warns of what it cannot set.
TEST(Manual, IsSetWithoutAWarning) {
  const auto folder = TestFolder();
  if (RunShell(folder, "command -v groff").exit_code != 0)
    GTEST_SKIP() << "skipped: there is no groff";
  const auto set =
      RunShell(folder, "$LIPOID --manual > lipoid.1 && groff -man -Tutf8 -ww -b lipoid.1");
  EXPECT_EQ(set.exit_code, 0);
  EXPECT_EQ(set.err, "");
  EXPECT_NE(set.out.find("lipoid"), std::string::npos);
}

TEST(Version, HasALetterToo) {
  const auto folder = TestFolder();
  const auto letter = RunLipoid(folder, {"-V"});
  EXPECT_EQ(letter.exit_code, 0);
  EXPECT_EQ(letter.out, RunLipoid(folder, {"--version"}).out);
  EXPECT_EQ(letter.out.rfind(std::string("lipoid ") + Version(), 0), 0U);
}

}  // namespace
}  // namespace lipoid
