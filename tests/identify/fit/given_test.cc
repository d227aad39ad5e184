#include "identify/fit/given.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using NameList = std::vector<std::string>;

std::string ErrorOf(const GivenParameters& given, int branches = 1, bool diffusion = true) {
  return test::MessageOf<OptionError>(
      [&] { CheckGiven(given, FitParameterNames(diffusion, branches)); });
}

TEST(Given, NamesAreThoseOfTheTableOfParameters) {
  EXPECT_EQ(FitParameterNames(true, 2),
            (NameList{"beta", "r_s", "r_1", "r_2", "tau_1", "tau_2", "c_1", "c_2"}));
  EXPECT_EQ(FitParameterNames(false, 0), NameList{"r_s"});
  for (const auto& name : FitParameterNames(true, 12)) EXPECT_TRUE(FindCellParameter(name)) << name;
}

TEST(Given, WhatACellMayHaveIsAccepted) {
  EXPECT_NO_THROW(CheckGiven({.fixed = {{"r_s", 0.0}, {"beta", 1.0}},
                              .start = {{"tau_1", 1e-9}},
                              .bounds = {{"r_1", {0.0, 0.0}},
                                         {"beta", {0.0, 1.0}},
                                         {"tau_2", {3.0, std::numeric_limits<double>::infinity()}},
                                         {"r_s", {0.0, 0.2}}}},
                             FitParameterNames(true, 2)));
}

TEST(Given, WhatNoCellMayHaveIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ErrorOf({.fixed = {{"r_s", -1.0}}}),
            "--fix r_s=-1: expected a resistance of at least 0 Ohm");
  EXPECT_EQ(ErrorOf({.fixed = {{"beta", 5.0}}}),
            "--fix beta=5: expected a number from 0.0001 to 1");
  EXPECT_EQ(ErrorOf({.start = {{"c_1", 0.0}}}), "--start c_1=0: expected a capacitance above 0 F");
  EXPECT_EQ(ErrorOf({.start = {{"tau_1", nan}}}),
            "--start tau_1=nan: expected a time constant above 0 s");
  EXPECT_EQ(ErrorOf({.fixed = {{"beta", 0.2}}}, 1, false),
            "--fix: no parameter 'beta' in this fit; there are r_s, r_1, tau_1, c_1");
  EXPECT_EQ(ErrorOf({.fixed = {{"tau_1x", 1.0}}}, 1),
            "--fix: no parameter 'tau_1x' in this fit; there are beta, r_s, r_1, tau_1, c_1");
  EXPECT_EQ(ErrorOf({.bounds = {{"beta", {nan, 0.5}}}}),
            "--bounds beta=nan,0.5: expected 0 <= low <= high <= 1");
  EXPECT_EQ(ErrorOf({.bounds = {{"tau_1", {2.0, 1.0}}}}),
            "--bounds tau_1=2,1: expected 0 <= low <= high");
  EXPECT_EQ(ErrorOf({.bounds = {{"tau_1", {0.0, 0.0}}}}),
            "--bounds tau_1=0,0: expected a time constant above 0 s at the upper end");
  EXPECT_EQ(ErrorOf({.fixed = {{"r_s", 0.5}}, .bounds = {{"r_s", {0.0, 0.1}}}}),
            "--fix r_s=0.5 lies outside --bounds r_s=0,0.1");
  EXPECT_EQ(ErrorOf({.start = {{"r_s", 0.5}}, .bounds = {{"r_s", {0.0, 0.1}}}}),
            "--start r_s=0.5 lies outside --bounds r_s=0,0.1");
  EXPECT_EQ(
      ErrorOf({.fixed = {{"r_s", 0.5}}, .start = {{"r_s", 0.1}}}),
      "--start r_s=0.1: --fix holds it, and what is held is not searched; leave one of the two "
      "out");
  EXPECT_EQ(ErrorOf({.fixed = {{"tau_2", 1.0}}, .bounds = {{"c_2", {0.0, 1.0}}}}, 2),
            "give either c_2 or tau_2, not both");
}

TEST(Given, ABranchIsNamedByAnyOfItsParametersInAnyRole) {
  EXPECT_FALSE((GivenParameters{.fixed = {{"beta", 0.1}, {"r_s", 0.1}}}.NamesABranch()));
  EXPECT_TRUE((GivenParameters{.fixed = {{"r_1", 0.1}}}.NamesABranch()));
  EXPECT_TRUE((GivenParameters{.start = {{"c_2", 0.1}}}.NamesABranch()));
  EXPECT_TRUE((GivenParameters{.bounds = {{"tau_1", {1.0, 2.0}}}}.NamesABranch()));
}

}  // namespace
}  // namespace lipoid
