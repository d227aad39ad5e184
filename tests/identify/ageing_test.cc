#include "identify/ageing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"

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
  // 30 and 40 C make 50 C, 2.5 % of the first.
  EXPECT_NEAR(capacity.change_low_percent, -7.5, 1e-12);
  EXPECT_NEAR(capacity.change_high_percent, -2.5, 1e-12);
  EXPECT_EQ(capacity.verdict, ChangeVerdict::kChanged);
  EXPECT_EQ(found[1].name, "beta");
  EXPECT_EQ(found[1].at[1].verdict, ChangeVerdict::kNoInterval);
  EXPECT_EQ(found[2].name, "resistance_1s");
  EXPECT_NEAR(found[2].at[1].change_percent, 10.0, 1e-9);
  EXPECT_EQ(found[2].at[1].verdict, ChangeVerdict::kNotShown) << "10 % with 14 % each way";
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
