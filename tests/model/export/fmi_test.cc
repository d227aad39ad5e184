// The exported FMU, run by FMPy, against the cell model.
#include "model/export/fmi.h"

#include <fmt/format.h>
#include <fmt/os.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/export/cell_numbers.h"
#include "model/export/folded_branches.h"
#include "tests/support/export_cases.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

// Exact steps in another order of sums.
constexpr double kCosimulation_V = 1e-9;
// FMPy's solver at a relative tolerance of 1e-9 of states that are worth volts.
constexpr double kModelExchange_V = 1e-5;

std::vector<double> Column(const std::vector<double>& numbers, std::size_t of, std::size_t column) {
  std::vector<double> picked;
  for (std::size_t k = column; k < numbers.size(); k += of) picked.push_back(numbers[k]);
  return picked;
}

double Worst(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) return INFINITY;
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double off = std::abs(a[k] - b[k]);
    if (!(off <= worst)) worst = off;
  }
  return worst;
}

class FmiTest : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(FmiTest, RunsInFmpyAsTheCellModelDoes) {
  LIPOID_SKIP_WITHOUT_SIMULATORS();
  const auto& [name, version] = GetParam();
  Cell cell;
  for (const Cell& other : test::ExportCells()) {
    if (other.name == name) cell = other;
  }
  auto request = test::RequestOf(cell, version);
  const auto exported = ExportFmi(request);
  ASSERT_TRUE(exported.error);
  EXPECT_LT(exported.error->max_error_V, kCosimulation_V);
  const auto folder = test::FreshFolder("fmi_" + request.name + version);
  const auto file = test::WriteExported(exported, folder, request.name);
  const auto& m = request.mission;
  {
    auto rows = fmt::output_file(folder + "/rows.txt");
    for (std::size_t k = 0; k < m.time_s.size(); ++k)
      rows.print("{} {}\n", m.time_s[k], m.current_A[k]);
  }
  std::string output;
  const int code = test::RunCommand(fmt::format("{} -B {} {} {} {}",
                                                test::ExtraPython(),
                                                test::SourcePath("tests/reference/run_fmu.py"),
                                                file,
                                                folder + "/rows.txt",
                                                folder),
                                    output);
  EXPECT_EQ(code, 0) << output;

  const auto model = Predict(cell, m.time_s, m.current_A);
  for (const char* by : {"/cosimulation.txt", "/sources.txt"}) {
    const auto found = test::ReadNumbers(folder + by);
    EXPECT_LT(Worst(Column(found, 3, 0), model.voltage_V), kCosimulation_V) << by;
    EXPECT_LT(Worst(Column(found, 3, 1), model.soc), 1e-11) << by;
    EXPECT_LT(Worst(Column(found, 3, 2), model.open_circuit_V), kCosimulation_V) << by;
  }

  // Model exchange under 2 A a cell against the exact step of the cell model.
  const auto exchange = test::ReadNumbers(folder + "/exchange.txt");
  const auto time_s = Column(exchange, 2, 0);
  ASSERT_GE(time_s.size(), 60U);
  const CellModel<double> law(FoldFastBranches(cell).cell.Parameters());
  double worst_V = 0.0;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    auto state = law.Relaxed(1.0);
    // Where a branch's resistance depends on A, a step takes it at its beginning: short steps.
    const auto step = law.MakeStep(time_s[k] / 20000.0);
    for (int n = 0; n < 20000 && time_s[k] > 0.0; ++n) law.Advance(state, 2.0, step);
    worst_V =
        std::max(worst_V, std::abs(exchange[2 * k + 1] - cell.series * law.Voltage(state, 2.0)));
  }
  EXPECT_LT(worst_V, kModelExchange_V * cell.series);

  // Power: the current times the voltage is what was asked, and the charge that left is its integral
  // (found here by steps of 1 ms, the current from the voltage at the end of each).
  const auto power = test::ReadNumbers(folder + "/power.txt");
  ASSERT_EQ(power.size(), 240U);
  auto state = law.Relaxed(1.0);
  const auto step = law.MakeStep(1e-3);
  double current_A = 5.0 / law.Voltage(state, 0.0);
  for (int n = 0; n < 60000; ++n) {
    for (int k = 0; k < 30; ++k) current_A = 5.0 / law.Voltage(state, current_A);
    law.Advance(state, current_A, step);
  }
  for (int k = 0; k < 100; ++k) current_A = 5.0 / law.Voltage(state, current_A);
  EXPECT_NEAR(power[238], cell.series * law.Voltage(state, current_A), 2e-4 * cell.series);
  EXPECT_NEAR(power[238] * power[239], 5.0 * cell.series * cell.parallel, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Cells,
                         FmiTest,
                         testing::Combine(testing::Values("gifi-600mAh-1",
                                                          "grepow-32Ah-2",
                                                          "every-term",
                                                          "no-diffusion",
                                                          "chebyshev",
                                                          "fourier"),
                                          testing::Values("2", "3")),
                         [](const auto& of) {
                           std::string name = std::get<0>(of.param) + std::get<1>(of.param);
                           for (char& c : name) {
                             if (c == '-') c = '_';
                           }
                           return name;
                         });

TEST(Fmi, SameCellGivesTheSameBytesInAnyTimeZone) {
  const auto request = test::RequestOf(test::CellWithEveryTerm());
  const auto once = ExportFmi(request).files[0].content;
  setenv("TZ", "Pacific/Auckland", 1);
  const auto again = ExportFmi(request).files[0].content;
  unsetenv("TZ");
  EXPECT_EQ(once, again);
}

TEST(Fmi, LibraryNeedsNeitherLipoidNorCPlusPlus) {
  std::string output;
  for (const char* version : {"2", "3"}) {
    const auto command =
        fmt::format("ldd {}", test::ScratchPath("../model/lipoid_fmi") + version + ".so");
    ASSERT_EQ(test::RunCommand(command, output), 0) << output;
  }
  EXPECT_NE(output.find("libc.so"), std::string::npos) << output;
  EXPECT_EQ(output.find("stdc++"), std::string::npos) << output;
  EXPECT_EQ(output.find("san"), std::string::npos) << output;
}

TEST(Fmi, DamagedResourcesAreRefusedOrRunWithoutHarm) {
  if (test::CCompiler().empty()) GTEST_SKIP() << "skipped: there is no C compiler (cc)";
  const auto folder = test::FreshFolder("fmi_damaged");
  test::WriteExported(ExportFmi(test::RequestOf(test::CellWithEveryTerm())), folder, "cell");
  std::string output;
  const auto command = fmt::format(
      "cd {} && python3 -m zipfile -e cell.fmu fmu && mv fmu/resources/cell.bin "
      "fmu/resources/cell.orig && "
      "cc -std=c99 -g -O1 -Wall -Wextra -fsanitize=address,undefined -fno-sanitize-recover=all "
      "-I{} {} -lm -o damaged && "
      "./damaged fmu/resources $(grep -o 'guid=\"[^\"]*\"' fmu/modelDescription.xml | cut -d'\"' -f2)",
      folder,
      test::SourcePath("model/export/runtime"),
      test::SourcePath("tests/model/export/fmu_damaged.c"));
  EXPECT_EQ(test::RunCommand(command, output), 0) << output;
  EXPECT_NE(output.find(" of 1500 ran"), std::string::npos) << output;
}

// FMPy took such a step again and again, and logged each.
TEST(Fmi, StepsForMorePowerThanThePackHasEndTheSimulation) {
  if (test::CCompiler().empty()) GTEST_SKIP() << "skipped: there is no C compiler (cc)";
  const auto folder = test::FreshFolder("fmi_spent");
  const auto file = test::WriteExported(
      ExportFmi(test::RequestOf(LoadCell("gifi-600mAh-1"), "2")), folder, "spent");
  std::string output;
  const auto command = fmt::format(
      "cd {} && python3 -m zipfile -e {} fmu && cc -std=c99 -Wall -Wextra -I{} {} -lm -o spent && "
      "./spent fmu/resources $(grep -o 'guid=\"[^\"]*\"' fmu/modelDescription.xml | cut -d'\"' -f2)",
      folder,
      file,
      test::SourcePath("model/export/runtime"),
      test::SourcePath("tests/model/export/fmu_spent.c"));
  EXPECT_EQ(test::RunCommand(command, output), 0) << output;
}

TEST(Fmi, RefusesAnotherVersion) {
  try {
    (void)ExportFmi(test::RequestOf(LoadCell("gifi-600mAh-1"), "1"));
    FAIL() << "no error";
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(), "the target fmi has the versions 2 and 3, found '1'");
  }
}

}  // namespace
}  // namespace lipoid
