// The missions that targets are compared over.
#include "identify/export/mission.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "identify/export/law_limits.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/battery/rest_voltage.h"
#include "model/export/export_error.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::WriteText;

double Lowest(const Cell& cell, const ExportMission& mission) {
  const auto prediction =
      Predict(cell, mission.time_s, mission.current_A, mission.hold, mission.initial_soc);
  return *std::min_element(prediction.voltage_V.begin(), prediction.voltage_V.end());
}

// Cells of many kinds: shipped ones, large, of high resistance, with a steep end, a pack.
std::vector<Cell> Cells() {
  std::vector<Cell> cells;
  for (const auto& name : ShippedCellNames()) cells.push_back(LoadCell(name));
  Cell large = LoadCell("gifi-600mAh-1");
  large.capacity_Ah = 2.9;
  large.diffusion->alpha_C = 2.9 * 3600.0;
  cells.push_back(large);
  Cell weak = large;
  weak.series_resistance_Ohm = 2.0;
  cells.push_back(weak);
  Cell plain = LoadCell("grepow-32Ah-1");
  plain.diffusion.reset();
  plain.series = 3;
  plain.parallel = 2;
  cells.push_back(plain);
  Cell slow = LoadCell("gifi-600mAh-1");
  slow.diffusion->beta_per_sqrt_s = 0.03;
  slow.branches = {{0.2, 200.0, std::nullopt}};
  cells.push_back(slow);
  return cells;
}

TEST(DefaultMission, StaysAboveTheCutOffOfAnyCellAndUsesMuchOfIt) {
  for (const Cell& cell : Cells()) {
    SCOPED_TRACE(cell.name);
    const ExportMission mission = DefaultMission(cell);
    EXPECT_GE(Lowest(cell, mission), cell.series * cell.cutoff_V);
    // Three quarters of what the high current would deliver in its time.
    const double high_A = *std::max_element(mission.current_A.begin(), mission.current_A.end());
    double charge_C = 0.0;
    for (std::size_t k = 1; k < mission.time_s.size(); ++k)
      charge_C += (mission.time_s[k] - mission.time_s[k - 1]) * mission.current_A[k];
    EXPECT_NEAR(charge_C, 0.75 * kDefaultEmpty_s * high_A, 1e-6 * charge_C);
    // One per cent more than that current would not last so long.
    const std::vector<double> time_s{0.0, kDefaultEmpty_s};
    Cell pack = cell;
    EXPECT_LT(Predict(pack, time_s, std::vector<double>{0.0, 1.01 * high_A}).voltage_V.back(),
              cell.series * cell.cutoff_V);
  }
}

TEST(DefaultMission, OfACellThatGivesNothingIsNone) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.cutoff_V = 4.3;
  EXPECT_EQ(DefaultCurrent_A(cell), 0.0);
  EXPECT_THROW((void)DefaultMission(cell), PreconditionError);
}

TEST(DefaultMission, HasTwoLevelsWithRestsBeforeBetweenAndAfter) {
  const ExportMission mission = DefaultMission(LoadCell("gifi-600mAh-1"));
  std::vector<double> levels;
  for (std::size_t k = 1; k < mission.time_s.size(); ++k) {
    if (levels.empty() || mission.current_A[k] != levels.back())
      levels.push_back(mission.current_A[k]);
    EXPECT_NEAR(mission.time_s[k] - mission.time_s[k - 1], kDefaultRow_s, 1e-9);
  }
  ASSERT_EQ(levels.size(), 5U);
  EXPECT_EQ(levels[0], 0.0);
  EXPECT_EQ(levels[2], 0.0);
  EXPECT_EQ(levels[4], 0.0);
  EXPECT_EQ(levels[3], 0.5 * levels[1]);
}

TEST(DefaultMission, OfAPackIsThatOfItsCells) {
  const Cell one = LoadCell("gifi-600mAh-1");
  Cell pack = one;
  pack.series = 3;
  pack.parallel = 2;
  const auto single = DefaultMission(one).current_A;
  const auto both = DefaultMission(pack).current_A;
  EXPECT_NEAR(*std::max_element(both.begin(), both.end()),
              2.0 * *std::max_element(single.begin(), single.end()),
              2e-3);  // four digits each
}

TEST(Mission, OfAForwardRecordHasEachCurrentWhereItEnds) {
  Record record;
  record.time_s = {0.0, 1.0, 2.4};
  record.current_A = {1.0, 2.0, 9.0};
  record.hold = Hold::kForward;
  const auto mission = MissionOf(record, "x", 1.0);
  EXPECT_EQ(mission.hold, Hold::kBackward);
  EXPECT_EQ(mission.time_s, (std::vector<double>{0.0, 1.0, 2.4}));
  EXPECT_EQ(mission.current_A, (std::vector<double>{1.0, 1.0, 2.0}));
}

TEST(Mission, OfRowsFarApartIsThatOfARowEverySecond) {
  Record few;
  few.time_s = {0.0, 3.0, 5.0};
  few.current_A = {0.0, 2.0, -1.0};
  const auto mission = MissionOf(few, "x", 1.0);
  EXPECT_EQ(mission.time_s, (std::vector<double>{0.0, 1.0, 2.0, 3.0, 4.0, 5.0}));
  EXPECT_EQ(mission.current_A, (std::vector<double>{0.0, 2.0, 2.0, 2.0, -1.0, -1.0}));
}

TEST(Mission, OfPowersGivesThesePowersAtTheEndOfEachRow) {
  Cell pack = LoadCell("gifi-600mAh-1");
  pack.series = 2;
  pack.parallel = 2;
  const PowerProfile power{{0.0, 10.0, 40.0, 41.0}, {0.0, 8.0, -4.0, 0.0}, Hold::kBackward};
  const auto mission = MissionOf(pack, power, "p", 1.0);
  const auto prediction = Predict(pack, mission.time_s, mission.current_A, mission.hold, 1.0);
  ASSERT_EQ(mission.time_s.size(), 1U + 10U + 30U + 1U);
  for (std::size_t k = 1; k < mission.time_s.size(); ++k) {
    const double expected_W = mission.time_s[k] <= 10.0   ? 8.0
                              : mission.time_s[k] <= 40.0 ? -4.0
                                                          : 0.0;
    EXPECT_NEAR(mission.current_A[k] * prediction.voltage_V[k], expected_W, 1e-9)
        << mission.time_s[k];
  }
}

TEST(Mission, OfPowersEndsWhereTheCellCannotGiveThem) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const PowerProfile power{{0.0, 10.0, 20.0}, {0.0, 5.0, 500.0}, Hold::kBackward};
  const auto mission = MissionOf(cell, power, "p", 1.0);
  EXPECT_EQ(mission.time_s.back(), 10.0);
}

TEST(MissionFile, TakesLogsPowersAndFlights) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  std::string log = "time_s,current_A\n";
  std::string powers = "# a survey\ntime_s,power_W\r\n";
  std::string flight = "time_s,x_m,battery_V,battery_A,soc\n";
  for (int k = 0; k < 12; ++k) {
    log += std::to_string(k) + ",0.5\n";
    powers += std::to_string(k) + ",2\r\n";
    flight += std::to_string(k) + ",0,4," + (k < 6 ? "0.5" : "1.5") + ",1\n";
  }
  const auto of_log = ReadMissionFile(cell, WriteText("log.csv", log), {}, {.initial_soc = 0.9});
  EXPECT_EQ(of_log.mission.current_A, std::vector<double>(12, 0.5));
  EXPECT_EQ(of_log.mission.initial_soc, 0.9);
  const auto of_powers = ReadMissionFile(cell, WriteText("power.csv", powers), {}, {});
  EXPECT_NEAR(of_powers.mission.current_A[5], 0.5, 0.03);
  // As a program in German writes it.
  std::string semicolons = "time_s;power_W\n";
  for (int k = 0; k < 12; ++k) semicolons += std::to_string(k) + ",0;2,0\n";
  const auto of_semicolons = ReadMissionFile(cell, WriteText("german.csv", semicolons), {}, {});
  EXPECT_EQ(of_semicolons.mission.current_A, of_powers.mission.current_A);
  const auto of_flight = ReadMissionFile(cell, WriteText("flight.csv", flight), {}, {});
  EXPECT_EQ(of_flight.mission.current_A[6], 0.5) << "what a row decides flows until the next";
  EXPECT_EQ(of_flight.mission.current_A[7], 1.5);
}

TEST(MissionFile, LeavesOutWhatTheCellCannotGive) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  std::string log = "time_s,current_A\n";
  for (int k = 0; k < 100; ++k) log += std::to_string(60 * k) + ",1\n";
  const auto read = ReadMissionFile(cell, WriteText("log.csv", log), {}, {});
  EXPECT_EQ(read.rows_of_file, 100U);
  EXPECT_GT(read.rows_beyond_cutoff, 70U);  // 1353 C last 22 minutes
  EXPECT_LT(read.rows_beyond_cutoff, 85U);
  // It ends within a row, in which the cut-off is reached.
  EXPECT_EQ(std::floor(read.mission.time_s.back() / 60.0),
            99.0 - static_cast<double>(read.rows_beyond_cutoff));
  EXPECT_EQ(read.warnings.back(),
            "the cell reaches its cut-off of 3 V; " + std::to_string(read.rows_beyond_cutoff) +
                " of 100 rows left out");
  EXPECT_GE(Lowest(cell, read.mission), cell.cutoff_V);
}

// A cell in a cold log: the mission has its temperatures, between the rows of which it goes straight, the
// cell is at its cut-off where simulate has it, and what is compared is the cell as it is there.
TEST(MissionFile, HasTheTemperatureOfItsLog) {
  const Cell cell = test::ColdTruth();
  std::string cold = "time_s,current_A,temperature_degC\n";
  std::string plain = "time_s,current_A\n";
  for (int k = 0; k < 80; ++k) {
    cold += fmt::format("{},1.2,{}\n", 10 * k, 0.1 * k - 10.0);
    plain += fmt::format("{},1.2\n", 10 * k);
  }
  const auto at_reference = ReadMissionFile(cell, WriteText("plain.csv", plain), {}, {});
  EXPECT_TRUE(at_reference.mission.temperature_degC.empty());
  EXPECT_EQ(at_reference.rows_beyond_cutoff, 0U);
  const auto read = ReadMissionFile(cell, WriteText("cold.csv", cold), {}, {});
  EXPECT_GT(read.rows_beyond_cutoff, 5U);
  ASSERT_EQ(read.mission.temperature_degC.size(), read.mission.time_s.size());
  EXPECT_NEAR(read.mission.temperature_degC[15], -9.85, 1e-12);  // at 15 s
  ASSERT_EQ(read.warnings.size(), 2U);
  EXPECT_EQ(
      read.warnings[0],
      "the cell has the temperature of the log, -10 to -2.1 degC (the cell file's reference is 25 degC): "
      "what is fitted and compared is the cell as it is there");
  ExportRequest request;
  SetCell(request, cell);
  request.mission = read.mission;
  const std::vector<double>& degC = read.mission.temperature_degC;
  EXPECT_EQ(ReferenceOf(request).voltage_V,
            Predict(cell,
                    read.mission.time_s,
                    read.mission.current_A,
                    Hold::kBackward,
                    1.0,
                    {.measured_degC = degC})
                .voltage_V);
  // A cell without temperature has no use for it.
  const auto unaware =
      ReadMissionFile(LoadCell("gifi-600mAh-1"), WriteText("cold.csv", cold), {}, {});
  EXPECT_TRUE(unaware.mission.temperature_degC.empty());
}

TEST(MissionFile, DoubtsAStartThatItsVoltageContradicts) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  std::string flight = "time_s,x_m,battery_V,battery_A,soc\n";
  for (int k = 0; k < 12; ++k) flight += fmt::format("{},0,7.3,0.5,0.4\n", k);
  Cell pack = cell;
  pack.series = 2;
  const auto file = WriteText("flight.csv", flight);
  const auto read = ReadMissionFile(pack, file, {}, {});
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_NE(read.warnings[0].find(
                "begins under load at 3.65 V, and is taken as a cell at a state of charge of 1"),
            std::string::npos)
      << read.warnings[0];
  EXPECT_TRUE(ReadMissionFile(pack, file, {}, {.initial_soc = 0.4}).warnings.empty());
}

TEST(MissionFile, StartsACellWithHysteresisWhereItRestsAtThatVoltage) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.hysteresis = Cell::Hysteresis{.folds = 50.0, .soc = {}, .half_V = {0.015}};
  std::string log = "time_s,current_A\n";
  for (int k = 0; k < 12; ++k) log += fmt::format("{},0.5\n", k);
  const auto read =
      ReadMissionFile(cell, WriteText("log.csv", log), {}, {.initial_voltage_V = 3.8});
  EXPECT_EQ(read.mission.initial_soc, SocAtRestVoltage(cell, 3.8, {}));
  EXPECT_GT(std::abs(read.mission.initial_soc - cell.open_circuit_voltage.SocAtVoltage(3.8)), 0.01);
}

TEST(MissionFile, RefusesWhatIsNoMission) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const auto message = [&](const std::string& text) {
    const auto file = WriteText("m.csv", text);
    return test::LoadErrorOf([&] { (void)ReadMissionFile(cell, file, {}, {}); })
        .substr(file.size());
  };
  std::string idle = "time_s,current_A\n";
  for (int k = 0; k < 20; ++k) idle += std::to_string(k) + ",0\n";
  EXPECT_EQ(message(idle),
            ":1:1: error: expected a mission that discharges the cell, found no current above 0");
  EXPECT_EQ(
      message("time_s,power_W\n0,1\n1,2\n"),
      ":1:1: error: expected a mission of at least 10 rows, or of 10 s where rows lie farther apart, in "
      "which the cell stays above its cut-off of 3 V, found 1 s in 2 of 2 rows");
  EXPECT_EQ(
      message("time_s,power_W\n0,1\n1,500\n"),
      ":1:1: error: expected a mission of at least 10 rows, or of 10 s where rows lie farther apart, in "
      "which the cell stays above its cut-off of 3 V, found 0 s in 1 of 2 rows; the current or the power "
      "may be too much for this pack (--series, --parallel)");
  std::string strong = "time_s,power_W\n";
  for (int k = 0; k < 40; ++k) strong += std::to_string(k) + (k < 21 ? ",0\n" : ",50\n");
  EXPECT_EQ(
      message(strong),
      ":1:1: error: expected a mission that discharges the cell, found no current above 0 in what "
      "stays above its cut-off of 3 V, 21 of 40 rows; the current or the power may be too much "
      "for this pack (--series, --parallel)");
  EXPECT_EQ(
      message("time_s,current_A\n0,0\n1,0.01\n700000,0.01\n"),
      ":1:1: error: expected a mission of at most 2000000 steps and 7 days, since a simulator's "
      "steps are walked through, found 700001 steps over 8.1 days; give a part of it");
  EXPECT_EQ(
      message("time_s,power_W\n0,1e-6\n1e12,1e-6\n"),
      ":1:1: error: expected a mission of at most 2000000 steps and 7 days, since a simulator's "
      "steps are walked through, found 1e+12 steps over 1.16e+07 days; give a part of it");
  EXPECT_EQ(message("time_s,power_W\n0,1\n1,nan\n"),
            ":3:3: error: expected a number for power_W, found 'nan'");
  EXPECT_EQ(message("time_s,power_W\n0,1\n0,2\n"),
            ":3:1: error: expected a time after 0 s, found 0 s");
  EXPECT_EQ(message("time_s,power_W\n0\n"),
            ":2:2: error: expected a number for power_W, found the end of the line");
  for (const char* header : {"time_min,power_W", "time_s,power_kW"}) {
    EXPECT_NE(message(header + std::string("\n0,1\n1,2\n"))
                  .find("; a power over time has the columns time_s,power_W, in these units"),
              std::string::npos)
        << header;
  }
}

}  // namespace
}  // namespace lipoid
