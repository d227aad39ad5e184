#include "identify/trust/trust_report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

TEST(TrustReport, WritesNullForWhatIsNoNumber) {
  TrustReport report;
  QuantityTrust r_s;
  r_s.name = "r_s";
  r_s.unit = "Ohm";
  r_s.estimate = 0.02;
  r_s.standard_error = 0.001;
  r_s.low = 0.018;
  r_s.high = 0.022;
  r_s.verdict = Verdict::kOnlyInCombination;
  r_s.with = {"r_1"};
  QuantityTrust tau;
  tau.name = "tau_1";
  tau.unit = "s";
  tau.estimate = 5.0;
  tau.standard_error = tau.high = std::numeric_limits<double>::infinity();
  tau.low = -tau.high;
  report.quantities = {r_s, tau};
  report.covariance = Eigen::Matrix2d{{1e-6, std::nan("")}, {std::nan(""), tau.high}};
  report.combinations = {{1e-3, {0.6, 0.8}}};
  report.residual_correlation = {{1e-4, 0.0, std::nan("")}};
  report.sentence = "A sentence.";

  const Json parameters = TrustedParametersToJson(report);
  EXPECT_EQ(parameters[0]["name"], "r_s");
  EXPECT_EQ(parameters[0]["interval_95"], Json({0.018, 0.022}));
  EXPECT_EQ(parameters[0]["verdict"], "only-in-combination-with");
  EXPECT_EQ(parameters[0]["with"], Json::array({"r_1"}));
  EXPECT_EQ(parameters[1]["verdict"], "weak");
  EXPECT_TRUE(parameters[1]["standard_error"].is_null());
  EXPECT_TRUE(parameters[1]["interval_95"][0].is_null());
  EXPECT_TRUE(parameters[1]["interval_95"][1].is_null());

  const Json trust = TrustToJson(report);
  EXPECT_EQ(trust["sentence"], "A sentence.");
  EXPECT_EQ(trust["singular_values"], Json::array({1e-3}));
  EXPECT_EQ(trust["combinations"][0]["weights"], Json({{"r_s", 0.6}, {"tau_1", 0.8}}));
  EXPECT_TRUE(trust["residual_correlation"][0]["correlation_s"].is_null());
  EXPECT_EQ(trust["covariance"]["rows"][0][0], 1e-6);
  EXPECT_TRUE(trust["covariance"]["rows"][1][1].is_null());
}

}  // namespace
}  // namespace lipoid
