// The exported subcircuit, run by ngspice, against the cell model.
#include "model/export/spice.h"

#include <fmt/format.h>
#include <fmt/os.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/export/cell_numbers.h"
#include "model/export/curve_nodes.h"
#include "tests/support/export_cases.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

#define LIPOID_SKIP_WITHOUT_NGSPICE()                                            \
  {                                                                              \
    std::string version;                                                         \
    if (test::RunCommand("ngspice --version", version) != 0)                     \
      GTEST_SKIP() << "skipped: ngspice is not installed (tools/setup --extra)"; \
  }

struct Run {
  std::vector<double> voltage_V;
  std::vector<double> soc;
};

// The mission as a current source that steps within 1 us after each row; voltages at the rows.
Run RunNgspice(const ExportRequest& request, const Exported& exported, const std::string& folder) {
  test::WriteExported(exported, folder, "cell");
  const auto& m = request.mission;
  {
    auto deck = fmt::output_file(folder + "/deck.cir");
    deck.print("mission\n.include cell.lib\nX1 p 0 soc {} soc0={}\n",
               Identifier(request.name),
               m.initial_soc);
    deck.print("Iload p 0 PWL(\n");
    for (std::size_t k = 0; k < m.time_s.size(); ++k) {
      deck.print("+ {} {}\n", m.time_s[k], m.current_A[k]);
      if (k + 1 < m.time_s.size()) deck.print("+ {} {}\n", m.time_s[k] + 1e-6, m.current_A[k + 1]);
    }
    deck.print(
        "+ )\n.options reltol=1e-6\n.tran 0.1 {} 0 0.1\n.control\nset wr_singlescale\n"
        "set numdgt=12\nrun\nwrdata out.txt v(p) v(soc)\nquit\n.endc\n.end\n",
        m.time_s.back());
  }
  std::string output;
  const int code = test::RunCommand("cd " + folder + " && ngspice -b deck.cir", output);
  EXPECT_EQ(code, 0) << output;
  const auto numbers = test::ReadNumbers(folder + "/out.txt");
  Run run;
  std::size_t at = 0;
  for (const double time_s : m.time_s) {
    while (at + 3 < numbers.size() && numbers[at] < time_s - 1e-8) at += 3;
    if (at >= numbers.size() || std::abs(numbers[at] - time_s) > 1e-7) {
      ADD_FAILURE() << "no time point at " << time_s << "\n" << output.substr(0, 2000);
      return run;
    }
    run.voltage_V.push_back(numbers[at + 1]);
    run.soc.push_back(numbers[at + 2]);
  }
  return run;
}

// The trapezoidal rule of ngspice at steps of 0.1 s and reltol 1e-6.
constexpr double kNgspice_V = 1e-4;

TEST(Spice, NgspiceFollowsTheCellModelForEveryTermAndCurve) {
  LIPOID_SKIP_WITHOUT_NGSPICE();
  for (const Cell& cell : test::ExportCells()) {
    auto request = test::RequestOf(cell);
    request.mission = test::Thinned(request.mission, 5);
    const auto exported = ExportSpice(request);
    ASSERT_TRUE(exported.error);
    const auto run = RunNgspice(request, exported, test::FreshFolder("spice_" + request.name));
    ASSERT_EQ(run.voltage_V.size(), request.mission.time_s.size()) << cell.name;
    const auto measured = MissionError(request, run.voltage_V);
    EXPECT_NEAR(measured.rmse_V, exported.error->rmse_V, 1e-5 * cell.series) << cell.name;
    EXPECT_NEAR(measured.max_error_V, exported.error->max_error_V, kNgspice_V * cell.series)
        << cell.name;
    // Rows of 0.5 s, over which the cell model holds the resistance of a branch: 0.05 mV a cell.
    EXPECT_LT(measured.rmse_V, 6e-5 * cell.series) << cell.name;
  }
}

TEST(Spice, RealSortieOfAThreeByTwoPackIsWithinATenthOfAMillivolt) {
  LIPOID_SKIP_WITHOUT_NGSPICE();
  const auto sortie = test::LabDataPath("missions/sortie.csv");
  LIPOID_SKIP_WITHOUT(sortie);
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.cell.series = 3;
  request.cell.parallel = 2;
  request.mission = test::ReadMission(sortie);
  for (double& current_A : request.mission.current_A) current_A *= 2.0;
  const auto exported = ExportSpice(request);
  const auto run = RunNgspice(request, exported, test::FreshFolder("spice_sortie"));
  ASSERT_EQ(run.voltage_V.size(), request.mission.time_s.size());
  const auto measured = MissionError(request, run.voltage_V);
  RecordProperty("rms_mV", std::to_string(1e3 * measured.rmse_V));
  RecordProperty("max_mV", std::to_string(1e3 * measured.max_error_V));
  EXPECT_LT(measured.rmse_V, 3e-5);
  EXPECT_LT(measured.max_error_V, kNgspice_V);
  const auto model = Predict(request.cell,
                             request.mission.time_s,
                             request.mission.current_A,
                             request.mission.hold,
                             request.mission.initial_soc);
  for (std::size_t k = 0; k < model.soc.size(); k += 50)
    ASSERT_NEAR(run.soc[k], model.soc[k], 1e-5) << k;
}

// A load that flows from the first instant finds the cell relaxed, and not in the steady state of a
// charge that has flowed forever.
TEST(Spice, StartsRelaxedUnderLoadAndAtAnyCharge) {
  LIPOID_SKIP_WITHOUT_NGSPICE();
  auto request = test::RequestOf(test::CellWithEveryTerm());
  request.mission = {};
  request.mission.initial_soc = 0.6;
  for (int k = 0; k <= 100; ++k) {
    request.mission.time_s.push_back(0.1 * k);
    request.mission.current_A.push_back(12.0);
  }
  const auto exported = ExportSpice(request);
  const auto run = RunNgspice(request, exported, test::FreshFolder("spice_start"));
  ASSERT_EQ(run.voltage_V.size(), 101U);
  // The branch of 1 ms that is folded has not charged in the cell at the first row: 3 times 6 mV.
  const auto measured = MissionError(request, run.voltage_V);
  EXPECT_NEAR(measured.max_error_V, 0.018, 3 * kNgspice_V);
  EXPECT_EQ(measured.worst_s, 0.0);
  ASSERT_TRUE(exported.error);
  EXPECT_NEAR(measured.max_error_V, exported.error->max_error_V, 3 * kNgspice_V);
  EXPECT_NEAR(measured.rmse_V, exported.error->rmse_V, 3 * kNgspice_V);
}

TEST(Spice, LinesStraightenACurveWithinTheToleranceAndGoOnWithItsEndSlopes) {
  for (const Cell& cell : test::ExportCells()) {
    const auto& curve = cell.open_circuit_voltage;
    const auto lines = StraightLines(curve);
    for (double soc = -0.2; soc < 1.2; soc += 0.00037)
      ASSERT_NEAR(lines(soc), curve(soc), 1.2e-5) << cell.name << " " << soc;
    EXPECT_LT(lines.soc().size(), 400U);
  }
}

TEST(Spice, LtspiceHasItsOwnTablesAndNothingElse) {
  const auto ours = ExportSpice(test::RequestOf(test::CellWithEveryTerm(), "ngspice"));
  const auto theirs = ExportSpice(test::RequestOf(test::CellWithEveryTerm(), "ltspice"));
  std::string text = ours.files[0].content;
  text = text.substr(text.find(".subckt"));
  for (auto at = text.find("pwl("); at != std::string::npos; at = text.find("pwl("))
    text.replace(at, 4, "table(");
  std::string other = theirs.files[0].content;
  other = other.substr(other.find(".subckt"));
  // Lines are broken elsewhere, since the words have other lengths.
  const auto joined = [](std::string lines) {
    for (auto at = lines.find("\n+"); at != std::string::npos; at = lines.find("\n+"))
      lines.erase(at, 2);
    return lines;
  };
  EXPECT_EQ(joined(text), joined(other));
}

TEST(Spice, NamesOfOthersStayInComments) {
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.source = "a\n.include /etc/passwd\n+b";
  request.name = "x\n.include y";
  const auto text = ExportSpice(request).files[0].content;
  EXPECT_EQ(text.find("\n.include"), std::string::npos) << text;
  EXPECT_NE(text.find(".subckt x__include_y p n soc"), std::string::npos) << text;
}

TEST(Spice, RefusesAnotherVersion) {
  try {
    (void)ExportSpice(test::RequestOf(LoadCell("gifi-600mAh-1"), "pspice"));
    FAIL() << "no error";
  } catch (const OptionError& error) {
    EXPECT_STREQ(error.what(),
                 "the target spice has the versions ngspice and ltspice, found 'pspice'");
  }
}

}  // namespace
}  // namespace lipoid
