#include "identify/joint/reference_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "identify/identification.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::kJointNoise_V;

// Less charge and larger resistances; v_oc(A) higher by `moved_V` at half charge, and the same at its ends.
Cell Aged(double moved_V) {
  Cell cell = test::Truth();
  cell.diffusion->alpha_C *= 0.85;
  for (double& r : cell.series_resistance_Ohm.resistance_Ohm) r *= 1.5;
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (int k = 0; k <= 200; ++k) {
    soc.push_back(k / 200.0);
    voltage_V.push_back(cell.open_circuit_voltage(soc.back()) +
                        moved_V * std::sin(std::numbers::pi * soc.back()));
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(soc, voltage_V);
  return cell;
}

Identification AgainstNew(const Cell& aged) {
  const auto logs = test::SyntheticLogs(aged, 5.0, kJointNoise_V);
  IdentifyOptions options;
  options.given.reference = std::make_shared<const HeldShape>(
      HeldShape{.source = "new.cell.json", .cell = test::Truth()});
  constexpr double kCapacity_Ah = 0.35;  // of now, about: alpha must not be what is doubted
  return Identify(test::CampaignOf(logs, kCapacity_Ah), logs, options);
}

TEST(ReferenceCurve, OfACellWhoseCurveHasMovedIsDoubted) {
  for (const double moved_V : {0.04, -0.04}) {
    const Identification found = AgainstNew(Aged(moved_V));
    const auto& move = found.joint->held_curve;
    ASSERT_TRUE(move);
    EXPECT_TRUE(move->doubted()) << move->rmse_V << " " << move->corrected_rmse_V;
    // Alpha and the resistances take a part of it.
    EXPECT_GT(move->largest_V / moved_V, 0.5);
    EXPECT_LT(move->largest_V / moved_V, 1.5);
    EXPECT_GT(move->soc, 0.25);
    EXPECT_LT(move->soc, 0.75);
    EXPECT_EQ(found.quality.grade, FitGrade::kFair) << found.Verdict();
    EXPECT_NE(found.Verdict().find("the reference's open-circuit voltage does not fit these logs: "
                                   "that of new.cell.json is about "),
              std::string::npos)
        << found.Verdict();
    EXPECT_NE(found.Verdict().find(moved_V > 0.0 ? "mV too low about" : "mV too high about"),
              std::string::npos);
  }
}

TEST(ReferenceCurve, OfTheSameCurveIsNotDoubted) {
  const Identification found = AgainstNew(Aged(0.0));
  ASSERT_TRUE(found.joint->held_curve);
  EXPECT_FALSE(found.joint->held_curve->doubted());
  EXPECT_EQ(found.quality.grade, FitGrade::kGood) << found.Verdict();
  EXPECT_EQ(DoubtAboutHeldCurve("new.cell.json", *found.joint->held_curve), "");
}

TEST(ReferenceCurve, BeyondEmptyItIsAlphaThatIsWrong) {
  CurveMove move{.rmse_V = 0.258, .corrected_rmse_V = 0.008, .largest_V = 7.5, .soc = -0.46};
  EXPECT_FALSE(move.doubted());
  move.soc = -0.04;
  EXPECT_TRUE(move.doubted());
  EXPECT_NE(
      DoubtAboutHeldCurve("new.cell.json", move)
          .find("that of new.cell.json is about 7.5 V too low about 0 % charge, and a corrected "
                "one would leave 8 mV rms of 258, rows weighted as in the fit; alpha"),
      std::string::npos);
}

TEST(ReferenceCurve, IsAskedOnlyWhereOneIsHeld) {
  const auto logs = test::SyntheticLogs(test::Truth(), 5.0, kJointNoise_V);
  EXPECT_FALSE(IdentifyJoint(test::CampaignOf(logs), logs).held_curve);
}

}  // namespace
}  // namespace lipoid
