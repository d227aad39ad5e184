// Files, names and limits from elsewhere, as hostile as they come: each ends in a sentence and an
// exit code, in little time and memory.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "identify/logs/campaign.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/sanitized.h"

namespace lipoid::test {
namespace {

namespace fs = std::filesystem;

// A refusal takes milliseconds; what was quadratic took 20 s and more.
constexpr double kPatience_s = 10.0;
constexpr std::size_t kMostOfMessages = 12'000;

std::string Repeated(std::string_view piece, std::size_t times) {
  std::string text;
  for (std::size_t k = 0; k < times; ++k) text += piece;
  return text;
}

// Runs, and checks what holds for every run.
RunResult Refused(const std::string& folder, const std::vector<std::string>& arguments) {
  const auto began = std::chrono::steady_clock::now();
  auto run = RunLipoid(folder, arguments);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  EXPECT_LT(took.count(), kPatience_s) << arguments[0];
  EXPECT_TRUE(run.exit_code == 2 || run.exit_code == 3)
      << arguments[0] << ": " << run.exit_code << "\n"
      << run.err;
  EXPECT_LT(run.err.size(), kMostOfMessages) << arguments[0];
  EXPECT_EQ(run.err.find('\x1b'), std::string::npos) << arguments[0];
  EXPECT_EQ(run.out, "") << arguments[0];
  return run;
}

TEST(Hostile, JsonOfEveryKindIsRefusedWhereverItIsRead) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/log.csv") << kFourRowLog;
  std::vector<std::string> files;
  for (const char* const name :
       {"01_nul_double_free.json", "01_nul_escaped_exception.json", "01_nul_segfault.json"}) {
    files.push_back(SourcePath(std::string("fixtures/hostile/") + name));
  }
  const auto make = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder + "/" + name) << text;
    files.push_back(name);
  };
  make("deep.json", Repeated("[", 20'000) + Repeated("]", 20'000));
  make("objects.json", Repeated("{\"a\":", 20'000) + "1" + Repeated("}", 20'000));
  std::string keys = "{";
  for (int k = 0; k < 100'000; ++k) keys += "\"k" + std::to_string(k) + "\":1,\n";
  make("keys.json", keys + "\"schema\":1}");
  make("name.json", "{\"schema\": \"" + std::string(900'000, 'x') + "\\u001b[2J\"}");
  make("key.json", "{\"\\u001b[2J" + std::string(900'000, 'x') + "\": 1}");
  make("empty.json", "");
  files.push_back("/dev/zero");
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    for (const auto& arguments : std::vector<std::vector<std::string>>{
             {"validate", file, "log.csv"},
             {"fly", "hover", "--cell", file},
             {"fly", "hover", "--gains", file},
             {"report", file, "-o", "page.html"},
             {"study", "branches", "none.toml", "--open-circuit-voltage", file}}) {
      (void)Refused(folder, arguments);
    }
  }
}

TEST(Hostile, TomlOfEveryKindIsRefusedWhereverItIsRead) {
  const auto folder = TestFolder();
  const std::string long_key = Repeated("a.", 50'000) + "a";
  const std::pair<const char*, std::string> files[] = {
      {"dotted.toml", long_key + " = 1\n"},
      {"header.toml", "[" + long_key + "]\n"},
      {"array.toml", "x = " + Repeated("[", 100'000)},
      {"inline.toml", "x = " + Repeated("{a = ", 20'000)},
      {"text.toml", "name = \"" + std::string(900'000, 'x') + "\x1b[2J\"\n"},
      {"open.toml", "name = \"\"\"" + std::string(900'000, 'x')},
      {"key.toml", "\"" + std::string(900'000, 'x') + "\" = 1\n"}};
  for (const auto& [name, text] : files) {
    std::ofstream(folder + "/" + name) << text;
    SCOPED_TRACE(name);
    (void)Refused(folder, {"identify", name, "-o", "cell.json"});
    (void)Refused(folder, {"fly", "hover", "--vehicle", name});
    (void)Refused(folder, {"fly", "waypoints", "--waypoints", name});
  }
  EXPECT_FALSE(fs::exists(folder + "/cell.json"));
}

TEST(Hostile, LogsAndNamesAreShownShortAndEscaped) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/log.csv")
      << "time_s,current_A,voltage_V\n0,0,4.1\n1," + std::string(1'000'000, 'x') + "\x1b[2J,4\n";
  (void)Refused(folder, {"convert", "log.csv", "-o", "out.csv"});
  std::ofstream(folder + "/header.csv")
      << "time_s,current_A,\x1b[2J" + std::string(1'000'000, 'y') + "\n0,0,4.1\n1,1,4\n";
  (void)Refused(folder, {"convert", "header.csv", "-o", "out.csv"});
  (void)Refused(folder, {"inspect", "/dev/zero"});
  (void)Refused(folder, {"validate", "\x1b[2Jcell", "log.csv"});
  (void)Refused(folder, {"validate", std::string(60'000, 'x'), "log.csv"});
  (void)Refused(folder, {"\x1b[2J"});
  (void)Refused(folder, {"fly", "hover", "--\x1b[2J"});
  (void)Refused(folder, {"fly", "hover", "--set", "\x1b[2J" + std::string(60'000, 'x') + "=1"});
}

TEST(Hostile, LoopsOfLinksAreSaid) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/log.csv") << kFourRowLog;
  fs::create_symlink("loop", folder + "/loop");
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"validate", "loop", "log.csv"},
           {"validate", "gifi-600mAh-1", "loop"},
           {"inspect", "loop"},
           {"inspect", "loop/log.csv"},
           {"inspect", "log.csv", "--write-campaign", "loop"},
           {"convert", "log.csv", "--current-sign", "discharge-positive", "-o", "loop"},
           {"convert", "log.csv", "--current-sign", "discharge-positive", "-o", "loop/out.csv"},
           {"convert", "loop", "-o", "out.csv"},
           {"identify", "loop", "-o", "out.json"},
           {"identify", "--pulses", "log.csv", "-o", "loop"},
           {"synthesize", "gifi-600mAh-1", "-o", "loop"},
           {"fly", "hover", "--vehicle", "loop"},
           {"fly", "hover", "-o", "loop"},
           {"validate", "gifi-600mAh-1", "log.csv", "--summary", "loop"}}) {
    (void)Refused(folder, arguments);
  }
  EXPECT_EQ(FilesIn(folder), (std::vector<std::string>{"log.csv", "loop"}));
}

TEST(Hostile, NumbersThatAreNoneAreRefusedLikeTheirTwins) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/log.csv") << kFourRowLog;
  for (const char* const option : {"--start-s", "--end-s"}) {
    for (const char* const value : {"inf", "-inf", "nan", "infinity"}) {
      const auto run = Refused(
          folder, {"convert", "log.csv", std::string(option) + "=" + value, "-o", "out.csv"});
      EXPECT_NE(
          run.err.find(std::string("option ") + option + ": expected a number, found '" + value),
          std::string::npos)
          << run.err;
    }
  }
  for (const char* const line :
       {"weight = 1e308", "weight = 1e-308", "weight = inf", "start_s = inf"}) {
    std::ofstream(folder + "/c.toml")
        << "[cell]\ncutoff_V = 3.0\n[[log]]\nkind = \"pulses\"\nfile = \"log.csv\"\n"
        << line << "\n";
    EXPECT_EQ(Refused(folder, {"identify", "c.toml", "-o", "cell.json"}).exit_code, 3) << line;
  }
}

TEST(Hostile, CellsInParallelAreJudgedLikeThoseInSeries) {
  const auto folder = TestFolder();
  // 0.1 A and 4 V of the pack.
  std::ofstream(folder + "/log.csv")
      << "time_s,current_A,voltage_V\n0,0,4.1\n1,0.1,4.0\n2,0.1,3.9\n3,0,4.0\n";
  for (const std::string key : {"series", "parallel"}) {
    std::ofstream(folder + "/c.toml") << "[cell]\ncutoff_V = 3.0\n" + key + " = 100000\n"
                                      << "[[log]]\nkind = \"pulses\"\nfile = \"log.csv\"\n"
                                      << "current_sign = \"discharge-positive\"\n";
    const auto run = Refused(folder, {"identify", "c.toml", "-o", "cell.json"});
    EXPECT_EQ(run.exit_code, 3) << key;
    EXPECT_NE(run.err.find("is `" + key + "` too large?"), std::string::npos) << run.err;
  }
}

// A draft is one that identify reads, or none is written and the exit code says so.
TEST(Hostile, ADraftThatIsWrittenReadsBack) {
  const auto folder = TestFolder();
  for (const char* const name : {"05_denormal_current", "06_discharge_to_0V", "06_pack_2s"}) {
    SCOPED_TRACE(name);
    const std::string log = SourcePath(std::string("fixtures/hostile/") + name + ".csv");
    const std::string draft = std::string(name) + ".toml";
    const auto run = RunLipoid(folder, {"inspect", log, "--write-campaign", draft});
    EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 2) << run.exit_code << run.err;
    ASSERT_EQ(fs::exists(folder + "/" + draft), run.exit_code == 0) << run.err;
    if (run.exit_code == 0) {
      EXPECT_NO_THROW((void)ReadCampaign(folder + "/" + draft));
    }
  }
}

TEST(Hostile, LittleStackIsEnough) {
  const auto folder = TestFolder();
  fs::copy_file(SourcePath("fixtures/cells/gifi-600mAh-1.json"), folder + "/cell.json");
  for (const std::string command :
       {"synthesize cell.json --sampling-s 10 --quiet -o logs",
        "inspect logs --write-campaign c.toml --quiet >/dev/null",
        "identify logs/campaign.toml --method staged --quiet -o found.json >/dev/null",
        "validate cell.json logs/pulses.csv >/dev/null",
        "fly hover --cell cell.json --duration 2 --quiet >/dev/null"}) {
    const auto run = RunShell(folder, "ulimit -s 64; \"$LIPOID\" " + command);
    EXPECT_EQ(run.exit_code, 0) << command << run.err;
  }
}

// As another user, who may start no further process or thread: one thread does it all.
// (The search for leaks, in a build with sanitizers, needs one more.)
TEST(Hostile, NoFurtherThreadIsNeeded) {
  if (::geteuid() != 0) GTEST_SKIP() << "skipped: only root can become another user";
  const auto folder = TestFolder();
  const auto alone = RunShell(
      folder,
      "cp \"$LIPOID\" ./copy && chmod 755 ./copy && T=$(mktemp -d) && mv copy $T/lipoid && "
      "chmod -R 777 $T . && cd $T && export ASAN_OPTIONS=detect_leaks=0 && "
      "setpriv --reuid=65534 --regid=65534 --clear-groups prlimit --nproc=1 sh -c '"
      "exec ./lipoid synthesize gifi-600mAh-1 --sampling-s 10 --quiet -o logs' && "
      "setpriv --reuid=65534 --regid=65534 --clear-groups prlimit --nproc=1 sh -c '"
      "exec ./lipoid identify logs/campaign.toml --method staged --quiet -o cell.json' >/dev/null; "
      "code=$?; ls cell.json; cd /; rm -r $T; exit $code");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_EQ(alone.out, "cell.json\n");
}

// Ten minutes of every control step are 40 MB of samples and 36 MB of text: neither is kept.
TEST(Hostile, AFlightOfAnyLengthTakesTheSameMemory) {
#ifdef LIPOID_SANITIZED
  GTEST_SKIP() << "skipped: the address sanitizer takes more addresses than the limit of this test";
#endif
  const auto folder = TestFolder();
  const auto run =
      RunShell(folder,
               "ulimit -v 400000; \"$LIPOID\" fly hover --battery ideal --duration 3000 "
               "--log-step-s 0.005 --quiet -o - >/dev/null");
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

}  // namespace
}  // namespace lipoid::test
