#include "model/battery/fit_record.h"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

Cell WithMetrics(Json metrics) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.run = std::make_shared<const Json>(Json{{"metrics", std::move(metrics)}});
  return cell;
}

TEST(FitRecord, APoorOrUnfinishedFitIsDoubted) {
  const Json good = {{"verdict", {{"grade", "good"}, {"reasons", {"none"}}}}, {"converged", true}};
  EXPECT_EQ(DoubtAboutFit(WithMetrics(good)), "");
  const Json poor = {{"verdict", {{"grade", "poor"}, {"reasons", {"0.9 V off", "more"}}}}};
  EXPECT_TRUE(IsOfPoorFit(WithMetrics(poor)));
  EXPECT_EQ(DoubtAboutFit(WithMetrics(poor)),
            "lipoid identify judged its fit poor: do not rely on what it predicts (0.9 V off)");
  EXPECT_EQ(DoubtAboutFit(WithMetrics({{"converged", false}})),
            "the search for it ended before it had converged: do not rely on what it predicts");
}

// The run record is for people, and may be anything.
TEST(FitRecord, OfNoFitSaysNothing) {
  EXPECT_EQ(DoubtAboutFit(LoadCell("gifi-600mAh-1")), "");
  for (const Json& metrics : {Json(nullptr), Json(3), Json{{"verdict", 3}, {"converged", "no"}}}) {
    EXPECT_EQ(DoubtAboutFit(WithMetrics(metrics)), "") << metrics;
    EXPECT_TRUE(FitMetric(WithMetrics(metrics), "age").is_null());
  }
  EXPECT_TRUE(IsOfPoorFit(WithMetrics({{"verdict", {{"grade", "poor"}, {"reasons", {7}}}}})));
}

}  // namespace
}  // namespace lipoid
