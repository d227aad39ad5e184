#include "model/battery/error_metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/core/special_values.h"

namespace lipoid {
namespace {

TEST(ErrorMetrics, AreThoseOfTheThesis) {
  // (4.56): 25 %, 12.5 %, 0 % of the measured value, whichever side the prediction lies on.
  ErrorAccumulator errors;
  errors.Add(4.0, 3.0);
  errors.Add(2.0, 2.25);
  errors.Add(3.0, 3.0);
  const auto result = errors.Result();
  EXPECT_DOUBLE_EQ(result.mean_error_percent, 37.5 / 3.0);  // (4.57)
  EXPECT_DOUBLE_EQ(result.max_error_percent, 25.0);         // (4.58)
  EXPECT_DOUBLE_EQ(result.rmse, std::sqrt((1.0 + 0.25 * 0.25) / 3.0));
  EXPECT_EQ(result.rows, 3U);
}

TEST(ErrorMetrics, WeightsCountARowAsThatManyRows) {
  ErrorAccumulator weighted;
  weighted.Add(4.0, 3.0, 3.0);
  weighted.Add(2.0, 2.25, 1.0);
  ErrorAccumulator repeated;
  for (int k = 0; k < 3; ++k) repeated.Add(4.0, 3.0);
  repeated.Add(2.0, 2.25);
  EXPECT_DOUBLE_EQ(weighted.Result().mean_error_percent, repeated.Result().mean_error_percent);
  EXPECT_DOUBLE_EQ(weighted.Result().rmse, repeated.Result().rmse);
  EXPECT_EQ(weighted.Result().max_error_percent, repeated.Result().max_error_percent);
}

TEST(ErrorMetrics, AreNaNBeforeTheFirstRow) {
  const auto result = ErrorAccumulator().Result();
  EXPECT_TRUE(std::isnan(result.mean_error_percent));
  EXPECT_TRUE(std::isnan(result.max_error_percent));
  EXPECT_TRUE(std::isnan(result.rmse));
  EXPECT_EQ(result.rows, 0U);
}

TEST(ErrorMetrics, NaNDoesNotVanishBehindLaterRows) {
  ErrorAccumulator errors;
  errors.Add(4.0, 3.0);
  errors.Add(4.0, kNaN);
  errors.Add(4.0, 3.5);
  EXPECT_TRUE(std::isnan(errors.Result().mean_error_percent));
  EXPECT_TRUE(std::isnan(errors.Result().max_error_percent));
  EXPECT_TRUE(std::isnan(errors.Result().rmse));
}

}  // namespace
}  // namespace lipoid
