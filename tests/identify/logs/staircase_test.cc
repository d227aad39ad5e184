#include "identify/logs/staircase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lipoid {
namespace {

using Values = std::vector<double>;

struct Shown {
  Values time_s, truth, shown;
};

// A quantity by its law, shown in steps.
template <class Law>
Shown InSteps(double step, Law&& law) {
  Shown of;
  for (int k = 0; k < 1000; ++k) {
    const double time_s = 0.5 * k;
    of.time_s.push_back(time_s);
    of.truth.push_back(law(time_s));
    of.shown.push_back(step * std::round(of.truth.back() / step));
  }
  return of;
}

double Rms(const Values& a, const Values& b, std::size_t first, std::size_t end) {
  double sum = 0.0;
  for (std::size_t k = first; k < end; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum / static_cast<double>(end - first));
}

// A pack that warms by ten degrees: whole degrees are off by 0.29 rms, half of it between the steps.
TEST(Staircase, AQuantityThatRisesIsFoundBetweenItsSteps) {
  const auto warms = [](double t) { return 20.0 + 12.0 * -std::expm1(-t / 250.0); };
  const Shown of = InSteps(1.0, warms);
  const Values smooth = WithoutSteps(of.time_s, of.shown);
  ASSERT_EQ(smooth.size(), of.shown.size());
  const std::size_t end = 800;  // the last plateau is long, and nobody knows where it ends
  EXPECT_GT(Rms(of.shown, of.truth, 0, end), 0.25);
  EXPECT_LT(Rms(smooth, of.truth, 0, end), 0.05);
}

TEST(Staircase, IsNowhereFurtherThanHalfAStepFromWhatIsShown) {
  const auto wanders = [](double t) { return 25.0 + 3.0 * std::sin(t / 40.0) + std::sin(t / 3.0); };
  const Shown of = InSteps(0.5, wanders);
  const Values smooth = WithoutSteps(of.time_s, of.shown);
  for (std::size_t k = 0; k < smooth.size(); ++k)
    EXPECT_LE(std::abs(smooth[k] - of.shown[k]), 0.25 + 1e-12) << k;
}

// Where it turns back within a step it did not stay at the border of the step.
TEST(Staircase, PassesWhatIsShownWhereItTurnsBack) {
  const Values time_s{0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, shown{20, 20, 21, 21, 21, 20, 20};
  const Values smooth = WithoutSteps(time_s, shown);
  EXPECT_DOUBLE_EQ(smooth[3], 21.0);
  EXPECT_GT(smooth[2], 20.5);
  EXPECT_LT(smooth[2], 21.0);
  EXPECT_DOUBLE_EQ(smooth[2], smooth[4]);
  EXPECT_DOUBLE_EQ(smooth.front(), 20.0);
  EXPECT_DOUBLE_EQ(smooth.back(), 20.0);
}

// A jump of several steps was one: a gap, another pack.
TEST(Staircase, LeavesLargerJumps) {
  const Values time_s{0.0, 1.0, 2.0, 3.0, 4.0, 5.0}, shown{20, 20, 21, 21, 30, 30};
  const Values smooth = WithoutSteps(time_s, shown);
  EXPECT_DOUBLE_EQ(smooth[4], 30.0);
  EXPECT_DOUBLE_EQ(smooth[5], 30.0);
  EXPECT_GT(smooth[3], 20.5);
  EXPECT_LE(smooth[3], 21.0);
}

TEST(Staircase, OfNoStepsIsWhatIsShown) {
  EXPECT_EQ(WithoutSteps({}, {}), Values{});
  const Values time_s{0.0, 1.0, 2.0}, level{20.0, 20.0, 20.0};
  EXPECT_EQ(WithoutSteps(time_s, level), level);
  EXPECT_EQ(WithoutSteps(Values{3.0}, Values{25.0}), Values{25.0});
}

}  // namespace
}  // namespace lipoid
