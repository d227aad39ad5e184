#include "model/control/reference_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/core/errors.h"

namespace lipoid {
namespace {

struct Point {
  double value;
  double rate;
};

// Answer of y'' + 2 zeta w y' + w² y = w² to a unit step from rest, in the three cases of damping.
Point StepResponse(double w, double zeta, double t) {
  if (zeta < 1.0) {
    const double wd = w * std::sqrt(1.0 - zeta * zeta);
    const double decay = std::exp(-zeta * w * t);
    return {1.0 - decay * (std::cos(wd * t) + zeta * w / wd * std::sin(wd * t)),
            decay * w * w / wd * std::sin(wd * t)};
  }
  if (zeta == 1.0) {
    return {1.0 - (1.0 + w * t) * std::exp(-w * t), w * w * t * std::exp(-w * t)};
  }
  const double root = w * std::sqrt(zeta * zeta - 1.0);
  const double slow = zeta * w - root;
  const double fast = zeta * w + root;
  return {1.0 + (slow * std::exp(-fast * t) - fast * std::exp(-slow * t)) / (fast - slow),
          slow * fast * (std::exp(-slow * t) - std::exp(-fast * t)) / (fast - slow)};
}

struct Case {
  double omega, damping, step_s;
};
class ReferenceModelOf : public testing::TestWithParam<Case> {};

TEST_P(ReferenceModelOf, HasThePolesOfTheClosedForm) {
  const auto [w, zeta, step_s] = GetParam();
  // Sum and product of e^{p step} over the poles p of (3.59).
  const double decay = std::exp(-zeta * w * step_s);
  const double angle = w * std::sqrt(std::abs(1.0 - zeta * zeta)) * step_s;
  const double sum = 2.0 * decay * (zeta < 1.0 ? std::cos(angle) : std::cosh(angle));
  const double product = decay * decay;
  constexpr double kTo = 1.5;
  ReferenceModel model(w, zeta, step_s);
  model.Reset(-0.5);
  std::vector<double> gap;
  for (int k = 0; k < 400; ++k) gap.push_back(model.Step(kTo).value - kTo);
  for (std::size_t k = 2; k < gap.size(); ++k)
    ASSERT_NEAR(gap[k], sum * gap[k - 1] - product * gap[k - 2], 1e-14) << k;
}

// A mass that is pushed as told, and nothing else, has the reference's value and rate.
TEST_P(ReferenceModelOf, IsFollowedExactlyByWhatDoesAsItIsTold) {
  const auto [w, zeta, step_s] = GetParam();
  ReferenceModel model(w, zeta, step_s);
  model.Reset(-0.5);
  double value = -0.5;
  double rate = 0.0;
  for (int k = 0; k < 400; ++k) {
    const auto out = model.Step(k < 200 ? 1.5 : -3.0);
    // Roundings of the rate, of order w, add up over the steps.
    ASSERT_NEAR(out.rate, rate, 1e-14 * w * (1 + k)) << k;
    ASSERT_NEAR(out.value, value, 1e-14 * (1 + k)) << k;
    value += step_s * (rate + 0.5 * step_s * out.acceleration);
    rate += step_s * out.acceleration;
  }
}

TEST_P(ReferenceModelOf, AnswersAStepAsTheClosedForm) {
  const auto [w, zeta, step_s] = GetParam();
  ReferenceModel model(w, zeta, step_s);
  model.Reset(0.0);
  // Holding the acceleration changes it by (w step)²/12 at first; twice that covers the rest.
  const double apart = std::pow(w * step_s, 2) / 6.0;
  for (int k = 0; k < 400; ++k) {
    const auto wanted = StepResponse(w, zeta, k * step_s);
    const auto out = model.Step(1.0);
    ASSERT_NEAR(out.value, wanted.value, apart) << k;
    ASSERT_NEAR(out.rate, wanted.rate, apart * w) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         ReferenceModelOf,
                         testing::Values(Case{5.0, 0.3, 0.005},
                                         Case{5.0, 1.0, 0.005},
                                         Case{5.0, 2.5, 0.005},
                                         Case{100.0, 1.0, 0.005},
                                         Case{200.0, 0.7, 0.005},
                                         Case{1.0, 1.0, 0.1}));

// Half the step, a quarter of the difference from (3.59).
TEST(ReferenceModel, ApproachesTheClosedFormWithTheSquareOfTheStep) {
  constexpr double kOmega = 20.0;
  const auto furthest = [&](double step_s) {
    ReferenceModel model(kOmega, 1.0, step_s);
    model.Reset(0.0);
    double apart = 0.0;
    for (int k = 0; k * step_s < 0.5; ++k)
      apart = std::max(
          apart, std::abs(model.Step(1.0).value - StepResponse(kOmega, 1.0, k * step_s).value));
    return apart;
  };
  EXPECT_NEAR(furthest(0.004) / furthest(0.002), 4.0, 0.1);
  EXPECT_NEAR(furthest(0.002) / furthest(0.001), 4.0, 0.05);
}

// Where neighbouring cases of damping meet nothing jumps.
TEST(ReferenceModel, IsContinuousInTheDamping) {
  const auto end = [](double damping) {
    ReferenceModel model(5.0, damping, 0.005);
    model.Reset(0.0);
    for (int k = 0; k < 60; ++k) (void)model.Step(1.0);
    return model.value();
  };
  EXPECT_NEAR(end(1.0 - 1e-7), end(1.0), 1e-6);
  EXPECT_NEAR(end(1.0 + 1e-7), end(1.0), 1e-6);
}

TEST(ReferenceModel, RestsWhereItIsReset) {
  ReferenceModel model(5.0, 1.0, 0.005);
  model.Reset(3.0);
  for (int k = 0; k < 10; ++k) {
    const auto out = model.Step(3.0);
    EXPECT_EQ(out.value, 3.0);
    EXPECT_EQ(out.rate, 0.0);
    EXPECT_EQ(out.acceleration, 0.0);
  }
  (void)model.Step(4.0);
  model.Reset(1.0);  // rate and all
  EXPECT_EQ(model.Step(1.0).rate, 0.0);
}

// A limit of the acceleration: a parabola while it holds, never above it, and still to the command.
TEST(ReferenceModel, KeepsWithinItsLimitAndArrives) {
  constexpr double kStep_s = 0.005;
  constexpr double kLimit = 40.0;
  for (const double command : {0.07, 0.35, -1.0}) {  // all at full limit for five steps
    SCOPED_TRACE(command);
    ReferenceModel model(100.0, 1.0, kStep_s, kLimit);
    model.Reset(0.0);
    std::vector<LoopReference<double>> path;
    for (int k = 0; k < 400; ++k) path.push_back(model.Step(command));
    for (int k = 0; k < 5; ++k) {
      const double t = k * kStep_s;
      ASSERT_NEAR(path[std::size_t(k)].value, std::copysign(0.5 * kLimit * t * t, command), 1e-14);
      ASSERT_NEAR(path[std::size_t(k)].rate, std::copysign(kLimit * t, command), 1e-14);
    }
    double furthest = 0.0;
    for (std::size_t k = 0; k < path.size(); ++k) {
      ASSERT_LE(std::abs(path[k].acceleration), kLimit);
      furthest = std::max(furthest, path[k].value / command);
      if (k + 1 == path.size()) break;
      // What is handed out is what the reference does.
      ASSERT_NEAR(path[k + 1].rate - path[k].rate, kStep_s * path[k].acceleration, 1e-13);
    }
    EXPECT_NEAR(path.back().value, command, 1e-9 * std::abs(command));
    EXPECT_NEAR(path.back().rate, 0.0, 1e-9);
    EXPECT_GE(furthest, 1.0 - 1e-9);
  }
}

// However far the command: it is never overshot, and reached in little more than the least time,
// 2 sqrt(gap/limit), that any brake of this limit needs.
TEST(ReferenceModel, BrakesInTime) {
  constexpr double kStep_s = 0.005;
  constexpr double kLimit = 40.0;
  for (const double omega : {4.0, 100.0, 200.0}) {
    for (const double ratio : {1.0, 5.0, 10.0, 30.0, 100.0, 1000.0}) {
      SCOPED_TRACE(testing::Message() << "omega " << omega << ", ratio " << ratio);
      const double command = ratio * kLimit / (omega * omega);
      ReferenceModel model(omega, 1.0, kStep_s, kLimit);
      model.Reset(0.0);
      // Critically damped, the last 2 % take 6/omega from rest.
      const double enough = 1.25 * 2.0 * std::sqrt(command / kLimit) + 6.0 / omega + 2.0 * kStep_s;
      double rate = 0.0;
      for (int k = 0; k < 10000; ++k) {
        const auto out = model.Step(command);
        ASSERT_LE(out.value, command * (1.0 + 1e-12)) << k;
        ASSERT_LE(std::abs(out.acceleration), kLimit);
        ASSERT_NEAR(out.rate, rate, 1e-12 * (1.0 + rate)) << k;
        rate += kStep_s * out.acceleration;
        if (k * kStep_s > enough) {
          ASSERT_GE(out.value, 0.98 * command) << k * kStep_s << " s";
        }
      }
    }
  }
}

// A command that would not need the limit's brake is answered by (3.59) itself.
TEST(ReferenceModel, IsItselfWhereTheLimitIsNotReached) {
  ReferenceModel limited(5.0, 1.0, 0.005, 10.0);
  ReferenceModel free(5.0, 1.0, 0.005);
  limited.Reset(0.0);
  free.Reset(0.0);
  for (int k = 0; k < 400; ++k) {
    const auto a = limited.Step(0.39);  // 5² * 0.39 = 9.75
    const auto b = free.Step(0.39);
    ASSERT_EQ(a.value, b.value);
    ASSERT_EQ(a.acceleration, b.acceleration);
  }
}

TEST(ReferenceModel, RefusesWhatIsNoReference) {
  EXPECT_THROW(ReferenceModel(0.0, 1.0, 0.005), PreconditionError);
  EXPECT_THROW(ReferenceModel(5.0, 0.0, 0.005), PreconditionError);
  EXPECT_THROW(ReferenceModel(5.0, 1.0, 0.0), PreconditionError);
  EXPECT_THROW(ReferenceModel(5.0, 1.0, 0.005, 0.0), PreconditionError);
  EXPECT_THROW(ReferenceModel(std::nan(""), 1.0, 0.005), PreconditionError);
}

}  // namespace
}  // namespace lipoid
