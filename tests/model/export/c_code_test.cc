// The exported C, compiled by the compilers of C and C++ and run, against the cell model.
#include "model/export/c_code.h"

#include <fmt/format.h>
#include <fmt/os.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/export/cell_numbers.h"
#include "tests/support/export_cases.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

constexpr const char* kWarnings = "-Wall -Wextra -Wconversion -Wdouble-promotion -pedantic -Werror";
constexpr const char* kSanitizers = "-g -fsanitize=address,undefined -fno-sanitize-recover=all";

#define LIPOID_SKIP_WITHOUT_C() \
  if (test::CCompiler().empty()) GTEST_SKIP() << "skipped: there is no C compiler (cc)"

// What each kind of compiler needs to know.
std::string Compile(const std::string& language, const std::string& flags) {
  return (language == "c" ? "cc -x c -std=c99 " : "c++ -x c++ -std=c++11 ") + flags;
}

TEST(CCode, CompilesWithoutAWarningAndPassesItsOwnTestUnderSanitizers) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code");
  for (const Cell& cell : test::ExportCells()) {
    if (cell.name.starts_with("grepow") || cell.name.ends_with("-3")) continue;  // the same shape
    const auto name = test::RequestOf(cell).name;
    std::string upper = name;
    std::transform(upper.begin(), upper.end(), upper.begin(), ::toupper);
    for (const char* version : {"double", "float"}) {
      test::WriteExported(ExportC(test::RequestOf(cell, version)), folder, name);
      for (const char* language : {"c", "c++"}) {
        std::string output;
        const auto command = fmt::format("cd {} && {} {} {} -D{}_TEST {}.c -lm -o {} && ./{}",
                                         folder,
                                         Compile(language, "-O1"),
                                         kWarnings,
                                         kSanitizers,
                                         upper,
                                         name,
                                         name,
                                         name);
        EXPECT_EQ(test::RunCommand(command, output), 0) << command << "\n" << output;
        EXPECT_NE(output.find(fmt::format("{} ({}): off by at most", name, version)),
                  std::string::npos)
            << output;
      }
    }
  }
}

// Before, its cell_soc was the law's.
TEST(CCode, ACellOfTheNameCellCompiles) {
  LIPOID_SKIP_WITHOUT_C();
  for (const std::string name : {"cell", "Cell"}) {
    const auto folder = test::FreshFolder("c_code_" + name);
    auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
    request.name = name;
    const auto exported = ExportC(request);
    EXPECT_EQ(exported.notes.back(),
              "Its names begin with lipoid_" + name + ": those of its law begin with cell.");
    test::WriteExported(exported, folder, name);
    for (const char* language : {"c", "c++"}) {
      std::string output;
      const auto command =
          fmt::format("cd {} && {} {} -DLIPOID_CELL_TEST {}.c -lm -o test && ./test",
                      folder,
                      Compile(language, "-O1"),
                      kWarnings,
                      name);
      EXPECT_EQ(test::RunCommand(command, output), 0) << command << "\n" << output;
    }
  }
}

TEST(CCode, ItsOwnTestFailsWhereANumberIsWrong) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code_wrong");
  auto exported = ExportC(test::RequestOf(LoadCell("gifi-600mAh-1")));
  auto& source = exported.files[1].content;
  const auto at = source.find("CELL_NUMBER(1353.6)");
  ASSERT_NE(at, std::string::npos);
  source.replace(at, 19, "CELL_NUMBER(1353.7)");
  test::WriteExported(exported, folder, "gifi_600mAh_1");
  std::string output;
  EXPECT_EQ(
      test::RunCommand(
          "cd " + folder + " && cc -DGIFI_600MAH_1_TEST gifi_600mAh_1.c -lm -o wrong && ./wrong",
          output),
      1);
  EXPECT_NE(output.find("that is more than 1e-09 V"), std::string::npos) << output;
}

// A program that steps the exported cell through a mission, and one voltage a line.
constexpr const char* kHarness = R"(
#include <stdio.h>
#include "cell.h"
int main(void) {
  double dt_s, current_A, before_s = -1.0;
  @name@_state state;
  @name@_step step;
  @name@_start(&state, 1);
  while (scanf("%lf %lf", &dt_s, &current_A) == 2) {
    if (dt_s > 0.0) {
      if (dt_s != before_s) @name@_make_step(&step, (@name@_real)dt_s);
      before_s = dt_s;
      @name@_advance(&state, &step, (@name@_real)current_A);
    }
    printf("%.17g\n", (double)@name@_voltage_V(&state, (@name@_real)current_A));
  }
  return 0;
}
)";

std::string WithName(std::string text, const std::string& name) {
  for (auto at = text.find("@name@"); at != std::string::npos; at = text.find("@name@"))
    text.replace(at, 6, name);
  return text;
}

TEST(CCode, RunsTheMissionWithTheErrorThatIsStated) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code_mission");
  for (const Cell& cell : test::ExportCells()) {
    for (const char* version : {"double", "float"}) {
      auto request = test::RequestOf(cell, version);
      request.stem = "cell";
      const auto exported = ExportC(request);
      test::WriteExported(exported, folder, "cell");
      std::ofstream(folder + "/main.c") << WithName(kHarness, request.name);
      {
        auto rows = fmt::output_file(folder + "/rows.txt");
        const auto& m = request.mission;
        for (std::size_t k = 0; k < m.time_s.size(); ++k)
          rows.print("{} {}\n", k == 0 ? 0.0 : m.time_s[k] - m.time_s[k - 1], m.current_A[k]);
      }
      std::string output;
      ASSERT_EQ(
          test::RunCommand(
              "cd " + folder +
                  " && cc -std=c99 -O2 main.c cell.c -lm -o run && ./run < rows.txt > out.txt",
              output),
          0)
          << output;
      const auto voltage_V = test::ReadNumbers(folder + "/out.txt");
      ASSERT_EQ(voltage_V.size(), request.mission.time_s.size());
      const double measured = MissionError(request, voltage_V).max_error_V;
      ASSERT_TRUE(exported.error);
      // The compiler of the user may fuse or not: the error of float is itself rounding, so only its
      // size is compared. Double: below any voltmeter.
      EXPECT_LT(measured, version == std::string("double") ? 1e-9 : 2e-5 * cell.series)
          << cell.name;
      EXPECT_NEAR(measured, exported.error->max_error_V, 1e-9 + 0.5 * exported.error->max_error_V)
          << cell.name << " " << version;
    }
  }
}

TEST(CCode, TenMillionStepsDoNotDrift) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code_drift");
  const Cell cell = LoadCell("gifi-600mAh-1");
  constexpr int kSteps = 10'000'000;
  constexpr double kStep_s = 0.005;
  // Discharge and charge in turn, a minute each: 1e7 steps keep within 3 % of the capacity.
  const auto current = [](int k) { return (k / 12000) % 2 == 0 ? 0.625 : -0.625; };
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.8);
  const auto step = model.MakeStep(kStep_s);
  for (int k = 0; k < kSteps; ++k) model.Advance(state, current(k), step);
  const double expected_V = model.Voltage(state, current(kSteps - 1));
  for (const char* version : {"double", "float"}) {
    auto request = test::RequestOf(cell, version);
    request.stem = "cell";
    test::WriteExported(ExportC(request), folder, "cell");
    std::ofstream(folder + "/main.c") << WithName(R"(
#include <stdio.h>
#include "cell.h"
int main(void) {
  int k;
  @name@_state state;
  @name@_step step;
  @name@_start(&state, (@name@_real)0.8);
  @name@_make_step(&step, (@name@_real)0.005);
  for (k = 0; k < 10000000; ++k)
    @name@_advance(&state, &step, (@name@_real)((k / 12000) % 2 == 0 ? 0.625 : -0.625));
  printf("%.17g\n", (double)@name@_voltage_V(&state, (@name@_real)-0.625));
  return 0;
}
)",
                                                  request.name);
    std::string output;
    ASSERT_EQ(
        test::RunCommand("cd " + folder + " && cc -O2 main.c cell.c -lm -o run && ./run > out.txt",
                         output),
        0)
        << output;
    // Double: the cell model adds 1e7 charges of 3 mC up to 30 C, rounding 1e-14 C a step at most and
    // not always in one direction. Float: 3 ms of the step are off by 6e-8, and so is the charge.
    EXPECT_NEAR(test::ReadNumbers(folder + "/out.txt").at(0),
                expected_V,
                version == std::string("double") ? 1e-9 : 2e-5)
        << version;
  }
}

TEST(CCode, TwoCellsLiveInOneProgramOfCPlusPlus) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code_two");
  test::WriteExported(ExportC(test::RequestOf(LoadCell("gifi-600mAh-1"))), folder, "gifi_600mAh_1");
  test::WriteExported(
      ExportC(test::RequestOf(test::CellWithEveryTerm(), "float")), folder, "every_term");
  std::ofstream(folder + "/main.cc") << R"(
#include <cstdio>
#include "every_term.h"
#include "gifi_600mAh_1.h"
int main() {
  gifi_600mAh_1_state a;
  every_term_state b;
  gifi_600mAh_1_start(&a, 1.0);
  every_term_start(&b, 1.0f);
  std::printf("%.6f %.6f\n", gifi_600mAh_1_voltage_V(&a, 0.0), double(every_term_voltage_V(&b, 0)));
}
)";
  std::string output;
  EXPECT_EQ(test::RunCommand("cd " + folder +
                                 " && cc -c gifi_600mAh_1.c && c++ -c -x c++ every_term.c && "
                                 "c++ main.cc gifi_600mAh_1.o every_term.o -lm -o run && ./run",
                             output),
            0);
  EXPECT_EQ(output, "4.200000 12.570000\n");
}

TEST(CCode, NamesOfOthersStayInCommentsAndCompile) {
  LIPOID_SKIP_WITHOUT_C();
  const auto folder = test::FreshFolder("c_code_hostile");
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.source = "a*/ int evil(void); /*\n#error evil\\\nint evil;";
  request.name = "int; #error evil";
  request.stem = "cell";
  test::WriteExported(ExportC(request), folder, "cell");
  std::string output;
  EXPECT_EQ(
      test::RunCommand("cd " + folder + " && cc -std=c99 " + kWarnings + " -c cell.c && nm cell.o",
                       output),
      0)
      << output;
  EXPECT_EQ(output.find(" evil"), std::string::npos) << output;
  EXPECT_NE(output.find("T int___error_evil_voltage_V"), std::string::npos) << output;
}

TEST(CCode, RefusesAnotherVersionAndAStemThatCannotBeIncluded) {
  try {
    (void)ExportC(test::RequestOf(LoadCell("gifi-600mAh-1"), "half"));
    FAIL() << "no error";
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(), "the target c has the versions double and float, found 'half'");
  }
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.stem = "a\"\nb";
  EXPECT_THROW((void)ExportC(request), OptionError);
}

}  // namespace
}  // namespace lipoid
