#include "identify/ageing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "model/battery/arrhenius.h"
#include "model/battery/cell_file.h"
#include "model/battery/fit_record.h"

namespace lipoid {
namespace {

// A cell with the run record of an identification: alpha and a resistance with their intervals.
Cell Aged(const char* age, double alpha_C, double reach_C, double ohm, double reach_Ohm) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion->alpha_C = alpha_C;
  const Json metrics = {
      {"age", age},
      {"parameters",
       {{{"name", "alpha"}, {"interval_95", {alpha_C - reach_C, alpha_C + reach_C}}},
        {{"name", "beta"}, {"interval_95", {nullptr, nullptr}}}}},
      {"resistance",
       {{{"after_s", 1.0},
         {"resistance_Ohm", ohm},
         {"interval_95", {ohm - reach_Ohm, ohm + reach_Ohm}}}}}};
  cell.run = std::make_shared<const Json>(Json{{"metrics", metrics}});
  return cell;
}

TEST(Ageing, TellsAChangeFromNone) {
  const std::vector<Cell> cells{Aged("new", 2000.0, 30.0, 0.10, 0.01),
                                Aged("old", 1900.0, 40.0, 0.11, 0.01)};
  EXPECT_EQ(AgeOf(cells[1]), "old");
  const auto found = CompareAges(cells);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].name, "capacity");
  EXPECT_EQ(found[0].at[0].verdict, ChangeVerdict::kFirst);
  const AgedValue& capacity = found[0].at[1];
  EXPECT_NEAR(capacity.value, 1900.0 / 3600.0, 1e-12);
  EXPECT_NEAR(capacity.change_percent, -5.0, 1e-12);
  // 30 and 40 C make 50 C, 2.5 % of the first; the ratio of two intervals is within 0.1 % of it.
  EXPECT_NEAR(capacity.change_low_percent, -7.5, 0.1);
  EXPECT_NEAR(capacity.change_high_percent, -2.5, 0.1);
  EXPECT_EQ(capacity.verdict, ChangeVerdict::kChanged);
  EXPECT_EQ(found[1].name, "beta");
  EXPECT_EQ(found[1].at[1].verdict, ChangeVerdict::kNoInterval);
  EXPECT_EQ(found[2].name, "resistance_1s");
  EXPECT_NEAR(found[2].at[1].change_percent, 10.0, 1e-9);
  EXPECT_EQ(found[2].at[1].verdict, ChangeVerdict::kNotShown) << "10 % with 14 % each way";
}

// Half charge is another place where the charge is not known.
TEST(Ageing, ResistancesAtHalvesOfUnknownChargesAreNotCompared) {
  const Cell known = Aged("new", 2000.0, 30.0, 0.10, 0.001);
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto verdict = [&](double alpha_C) {
    return CompareAges({known, Aged("old", alpha_C, none, 0.11, 0.001)})[2].at[1].verdict;
  };
  EXPECT_EQ(verdict(1500.0), ChangeVerdict::kNoInterval);
  EXPECT_EQ(verdict(2010.0), ChangeVerdict::kChanged);
}

// A fit that does not describe its own logs has numbers, too.
TEST(Ageing, ComparesNothingWithAPoorFit) {
  std::vector<Cell> cells{Aged("new", 2000.0, 30.0, 0.10, 0.01),
                          Aged("old", 1500.0, 40.0, 0.11, 0.01),
                          Aged("older", 1900.0, 40.0, 0.11, 0.01)};
  const auto grade = [](Cell& cell, const char* name) {
    Json run = *cell.run;
    run["metrics"]["verdict"] = {{"grade", name}};
    cell.run = std::make_shared<const Json>(std::move(run));
  };
  grade(cells[0], "good");
  grade(cells[1], "poor");
  EXPECT_FALSE(IsOfPoorFit(cells[0]));
  EXPECT_TRUE(IsOfPoorFit(cells[1]));
  auto found = CompareAges(cells);
  EXPECT_EQ(found[0].at[1].verdict, ChangeVerdict::kPoorFit);
  EXPECT_TRUE(std::isnan(found[0].at[1].change_percent));
  EXPECT_EQ(found[0].at[2].verdict, ChangeVerdict::kChanged);
  grade(cells[0], "poor");
  found = CompareAges(cells);
  EXPECT_EQ(found[0].at[0].verdict, ChangeVerdict::kPoorFit);
  EXPECT_EQ(found[0].at[2].verdict, ChangeVerdict::kPoorFit);
}

// A cell loses capacity, and not most of it.
TEST(Ageing, DoubtsWhatAreNoAgesOfOneCell) {
  const auto doubts = [](double alpha_C) {
    return DoubtsAboutAges(
        CompareAges({Aged("a", 2000.0, 30.0, 0.1, 0.01), Aged("b", alpha_C, 30.0, 0.1, 0.01)}));
  };
  EXPECT_TRUE(doubts(1900.0).empty());
  EXPECT_TRUE(doubts(2060.0).empty());
  ASSERT_EQ(doubts(2400.0).size(), 1U);
  EXPECT_EQ(doubts(2400.0)[0].first, 1U);
  EXPECT_EQ(doubts(2400.0)[0].second,
            "has 20 % more capacity than the first: are both one cell, and the youngest first?");
  EXPECT_EQ(doubts(600.0).at(0).second,
            "has 70 % less capacity than the first: are both one cell?");
}

// However wide the interval of the first: no resistance falls by more than all of it.
TEST(Ageing, NothingFallsByMoreThanAHundredPerCent) {
  const auto found =
      CompareAges({Aged("new", 2000.0, 30.0, 0.10, 0.09), Aged("old", 1900.0, 40.0, 0.03, 0.02)});
  const AgedValue& resistance = found[2].at[1];
  EXPECT_NEAR(resistance.change_percent, -70.0, 1e-9);
  const double down = std::hypot(std::log(0.03 / 0.01), std::log(0.19 / 0.10));
  EXPECT_NEAR(resistance.change_low_percent, 100.0 * (0.3 * std::exp(-down) - 1.0), 1e-9);
  EXPECT_GT(resistance.change_low_percent, -100.0);
  EXPECT_GT(resistance.change_high_percent, 0.0);
  EXPECT_EQ(resistance.verdict, ChangeVerdict::kNotShown);
  // An interval that begins at zero: it may have vanished, or have grown without end.
  const auto wide =
      CompareAges({Aged("new", 2000.0, 30.0, 0.10, 0.10), Aged("old", 1900.0, 40.0, 0.03, 0.03)});
  EXPECT_EQ(wide[2].at[1].change_low_percent, -100.0);
  EXPECT_TRUE(std::isinf(wide[2].at[1].change_high_percent));
  EXPECT_EQ(wide[2].at[1].verdict, ChangeVerdict::kNotShown);
}

// A resistance in the cold is no resistance that grew.
TEST(Ageing, AResistanceOfAnotherTemperatureIsNotCompared) {
  std::vector<Cell> cells{Aged("new", 2000.0, 30.0, 0.10, 0.01),
                          Aged("cold", 1900.0, 40.0, 0.20, 0.01)};
  const auto measured_at = [&](Cell& cell, double degC) {
    Json run = *cell.run;
    run["metrics"]["resistance"][0]["temperature_degC"] = degC;
    cell.run = std::make_shared<const Json>(std::move(run));
  };
  measured_at(cells[0], 25.0);
  measured_at(cells[1], 0.0);
  const auto found = CompareAges(cells);
  EXPECT_EQ(found[0].at[1].verdict, ChangeVerdict::kChanged);
  EXPECT_EQ(found[2].at[1].verdict, ChangeVerdict::kOtherTemperature);
  EXPECT_TRUE(std::isnan(found[2].at[1].change_percent));
  EXPECT_EQ(found[2].at[1].value, 0.20);
  measured_at(cells[1], 25.0);
  EXPECT_EQ(CompareAges(cells)[2].at[1].verdict, ChangeVerdict::kChanged);
  // One cell does not say where it was seen.
  Json run = *cells[1].run;
  run["metrics"]["resistance"][0]["temperature_degC"] = nullptr;
  cells[1].run = std::make_shared<const Json>(std::move(run));
  EXPECT_EQ(CompareAges(cells)[2].at[1].verdict, ChangeVerdict::kTemperatureNotKnown);
}

// A cell that knows no temperature may know at which its logs were.
// What it gives in the cold is not what it has.
TEST(Ageing, CellsOfLogsOfOtherTemperaturesAreNotCompared) {
  std::vector<Cell> cells{Aged("new", 2000.0, 30.0, 0.10, 0.001),
                          Aged("old", 1900.0, 40.0, 0.12, 0.001)};
  EXPECT_TRUE(DoubtAboutTemperatures(cells).starts_with(
      "no cell file says at which temperature its logs were"));
  EXPECT_EQ(DoubtAboutTemperatures({cells[0]}), "");
  cells[0].reference_degC = 25.0;
  EXPECT_TRUE(DoubtAboutTemperatures(cells).starts_with(
      "old does not say at which temperature the logs were (temperature_degC, or ambient_degC"));
  const auto verdicts = [&](double first_degC, double second_degC) {
    cells[0].reference_degC = first_degC;
    cells[1].reference_degC = second_degC;
    EXPECT_EQ(DoubtAboutTemperatures(cells), "");
    const auto found = CompareAges(cells);
    return std::array{found[0].at[1].verdict, found[1].at[1].verdict, found[2].at[1].verdict};
  };
  EXPECT_EQ(verdicts(21.0, 27.0),
            (std::array{ChangeVerdict::kOtherTemperature,
                        ChangeVerdict::kOtherTemperature,
                        ChangeVerdict::kOtherTemperature}));
  // An old cell warms more in the same chamber.
  EXPECT_EQ(
      verdicts(25.3, 26.8),
      (std::array{ChangeVerdict::kChanged, ChangeVerdict::kNoInterval, ChangeVerdict::kChanged}));
  // A cell that knows temperature has one capacity; its resistances are of its reference.
  const auto knows = [](Cell& cell, double degC) {
    cell.temperature.emplace().reference_K = degC + kZeroCelsius_K;
  };
  knows(cells[0], 25.0);
  EXPECT_EQ(CompareAges(cells)[0].at[1].verdict, ChangeVerdict::kChanged) << "25 and 26.8";
  cells[1].reference_degC = 0.0;
  EXPECT_EQ(CompareAges(cells)[0].at[1].verdict, ChangeVerdict::kOtherTemperature);
  knows(cells[1], 0.0);
  const auto found = CompareAges(cells);
  EXPECT_EQ(found[0].at[1].verdict, ChangeVerdict::kChanged);
  EXPECT_EQ(found[1].at[1].verdict, ChangeVerdict::kOtherTemperature);
}

TEST(Ageing, WhatOneCellDoesNotSayIsNotKnown) {
  std::vector<Cell> cells{LoadCell("gifi-600mAh-1"), Aged("old", 1900.0, 40.0, 0.11, 0.01)};
  for (Cell& cell : cells) cell.reference_degC = 25.0;
  const auto verdicts = [&] {
    const AgedQuantity resistance = CompareAges(cells)[2];
    return std::array{resistance.at[0].verdict, resistance.at[1].verdict};
  };
  EXPECT_EQ(verdicts(), (std::array{ChangeVerdict::kNotKnown, ChangeVerdict::kFirstNotKnown}));
  std::swap(cells[0], cells[1]);
  EXPECT_EQ(verdicts(), (std::array{ChangeVerdict::kFirst, ChangeVerdict::kNotKnown}));
}

TEST(Ageing, ACellWithoutARunRecordHasValuesAlone) {
  const auto found = CompareAges({LoadCell("gifi-600mAh-1"), LoadCell("gifi-600mAh-2")});
  ASSERT_EQ(found.size(), 2U);  // no resistance of a pulse was found
  EXPECT_TRUE(std::isnan(found[0].at[1].low));
  EXPECT_EQ(found[0].at[1].verdict, ChangeVerdict::kNoInterval);
  EXPECT_EQ(AgeOf(LoadCell("gifi-600mAh-1")), "");
}

}  // namespace
}  // namespace lipoid
