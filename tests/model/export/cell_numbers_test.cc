// The C law of the exports against the cell model, which it must be in other words.
#include "model/export/cell_numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "model/battery/prediction.h"
#include "model/export/curve_nodes.h"
#include "tests/support/export_cases.h"

namespace lipoid {
namespace {

// Both are exact; rounding is 1e-16 of each of 6000 steps and of 13 V, times 15 V per unit of A.
constexpr double kRounding_V = 1e-10;

TEST(CellLaw, GivesTheVoltagesOfTheCellModelForEveryTermAndCurve) {
  for (const Cell& cell : test::ExportCells()) {
    auto request = test::RequestOf(cell);
    for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
      request.mission.hold = hold;
      request.mission.initial_soc = 0.97;
      const auto& m = request.mission;
      const auto law = RunCellLaw(cell, m, LawNumbers::kDouble);
      const auto model = Predict(cell, m.time_s, m.current_A, m.hold, m.initial_soc).voltage_V;
      ASSERT_EQ(law.size(), model.size());
      double worst_V = 0.0;
      for (std::size_t k = 0; k < law.size(); ++k)
        worst_V = std::max(worst_V, std::abs(law[k] - model[k]));
      EXPECT_LT(worst_V, kRounding_V) << cell.name;
      EXPECT_GT(model.front() - model[4000], 0.5 * cell.series) << "the sortie does nothing";
    }
  }
}

TEST(CellLaw, CurveContinuesBeyondItsEndsAsTheCellsDoes) {
  for (const Cell& cell : test::ExportCells()) {
    for (const double soc : {-0.3, 0.0, 0.01, 0.5, 1.0, 1.2}) {
      ExportMission mission;
      mission.time_s = {0.0};
      mission.current_A = {0.0};
      mission.initial_soc = soc;
      EXPECT_NEAR(RunCellLaw(cell, mission, LawNumbers::kDouble)[0],
                  cell.series * cell.open_circuit_voltage(soc),
                  kRounding_V)
          << cell.name << " at " << soc;
    }
  }
}

// A cell with a flat end of the curve empties all the same, with the next chord that rises, and its last
// piece stays flat.
TEST(CellLaw, FlatEndsAreThoseOfTheCell) {
  Cell cell = test::CellWithEveryTerm();
  const std::vector<double> soc{0.05, 0.1, 0.3, 0.9, 1.0};
  const std::vector<double> voltage_V{3.2, 3.2, 3.6, 4.15, 4.15};
  for (const bool lines : {true, false}) {
    cell.open_circuit_voltage = lines ? OpenCircuitVoltage::Linear(soc, voltage_V)
                                      : OpenCircuitVoltage::MonotoneCubic(soc, voltage_V);
    const Cell in_lines = [&] {
      Cell made = cell;
      made.open_circuit_voltage = StraightLines(cell.open_circuit_voltage);
      return made;
    }();
    for (const double at : {-0.01, 0.02, 0.07, 0.95, 0.99, 1.05}) {
      ExportMission mission;
      mission.time_s = {0.0};
      mission.current_A = {0.0};
      mission.initial_soc = at;
      const double expected_V = cell.series * cell.open_circuit_voltage(at);
      EXPECT_NEAR(RunCellLaw(cell, mission, LawNumbers::kDouble)[0], expected_V, kRounding_V)
          << lines << " at " << at;
      EXPECT_NEAR(RunCellLaw(in_lines, mission, LawNumbers::kDouble)[0],
                  expected_V,
                  cell.series * kCurveTolerance_V)
          << lines << " at " << at;
    }
  }
}

// In float a charge of 1e-9 of the capacity a step would be lost without the carried rounding.
TEST(CellLaw, FloatFollowsTheCellToMicrovolts) {
  for (const Cell& cell : test::ExportCells()) {
    const auto request = test::RequestOf(cell);
    const auto error = MissionError(request, RunCellLaw(cell, request.mission, LawNumbers::kFloat));
    EXPECT_LT(error.max_error_V, 2e-5 * cell.series) << cell.name;
    EXPECT_GT(error.max_error_V, 1e-8) << "that is no float";
  }
}

TEST(CellNumbers, RefusesWhatIsNoBattery) {
  Cell cell = test::CellWithEveryTerm();
  cell.diffusion->alpha_C = 0.0;
  EXPECT_THROW((void)NumbersOf(cell), PreconditionError);
  cell = test::CellWithEveryTerm();
  cell.series_resistance_Ohm.resistance_Ohm[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)NumbersOf(cell), PreconditionError);
  cell = test::CellWithEveryTerm();
  cell.open_circuit_voltage = {};
  EXPECT_THROW((void)NumbersOf(cell), PreconditionError);
  cell = test::CellWithEveryTerm();
  cell.series = 0;
  EXPECT_THROW((void)NumbersOf(cell), PreconditionError);
}

TEST(CellNumbers, CConstantsGiveTheSameDouble) {
  for (const double value : {1.0, -3.0, 0.1, 1e-5, 1353.6, 1e300, 2.5e-308, 1.0 / 3.0}) {
    const auto text = CNumber(value);
    EXPECT_EQ(std::strtod(text.c_str(), nullptr), value);
    EXPECT_NE(text.find_first_of(".e"), std::string::npos) << text;
  }
}

TEST(CellNumbers, IdentifiersAreThoseOfEveryLanguage) {
  EXPECT_EQ(Identifier("gifi_600mAh_1"), "gifi_600mAh_1");
  EXPECT_EQ(Identifier("3S pack;system(\"x\")"), "cell_3S_pack_system__x__");
  EXPECT_EQ(Identifier("__init__"), "cell___init__");
  EXPECT_EQ(Identifier(""), "cell_");
  EXPECT_EQ(Identifier("end"), "cell_end");  // MATLAB would not read `end = struct();`
  EXPECT_EQ(Identifier("ending"), "ending");
  EXPECT_EQ(Identifier(std::string(200, 'a')).size(), 63U);
}

TEST(MissionError, SaysHowFarAndWhere) {
  auto request = test::RequestOf(test::CellWithEveryTerm());
  const auto& m = request.mission;
  auto off = Predict(request.cell, m.time_s, m.current_A);
  off.voltage_V[1234] += 0.3;
  const auto error = MissionError(request, off.voltage_V);
  EXPECT_NEAR(error.max_error_V, 0.3, 1e-12);
  EXPECT_NEAR(error.rmse_V, 0.3 / std::sqrt(6001.0), 1e-12);
  EXPECT_DOUBLE_EQ(error.worst_s, m.time_s[1234]);
  EXPECT_DOUBLE_EQ(error.worst_soc, off.soc[1234]);
  off.voltage_V[77] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(MissionError(request, off.voltage_V).rmse_V));
}

}  // namespace
}  // namespace lipoid
