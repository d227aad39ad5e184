#include "model/control/laws/control_laws.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/control/laws/pid.h"
#include "model/core/errors.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/plant_flight.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::Mambo;

TEST(ControlLaws, AreFoundByName) {
  EXPECT_EQ(FindControlLaw("pid").inner_loops, &PidInnerLoops);
  EXPECT_EQ(test::MessageOf<OptionError>([] { (void)FindControlLaw("mpc"); }),
            "unknown controller 'mpc'. Known: inversion, pid, lqr");
}

// At hover all laws are one to first order: level and still they give the same wrench.
TEST(ControlLaws, AgreeOnALevelVehicleThatDoesNotTurn) {
  InnerLoopState<double> state{-1.0, 0.2, {}, {}};
  InnerLoopReferences<double> reference;
  reference.down = {-1.5, 0.1, 0.3};
  reference.angles[0] = {0.1, 0.2, 0.4};
  reference.angles[2] = {0.3, 0.0, 0.0};
  const ErrorIntegrals<double> integrals{0.1, {0.01, 0.02, 0.03}};
  const auto wanted = InnerLoops<double>(Mambo(), LoadGains("aware"), state, reference, integrals);
  for (const ControlLaw& law : ControlLaws()) {
    const auto out = law.inner_loops(Mambo(), LoadGains("aware"), state, reference, integrals);
    EXPECT_DOUBLE_EQ(out.wrench.thrust_N, wanted.wrench.thrust_N) << law.name;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_DOUBLE_EQ(out.wrench.torque_N_m[k], wanted.wrench.torque_N_m[k]) << law.name;
  }
}

// Rolled by 60 degrees half of the thrust points up: inversion doubles it, PID does not.
TEST(ControlLaws, PidDoesNotKnowThatItIsTilted) {
  InnerLoopState<double> state{-1.0, 0.0, {std::acos(0.5), 0.0, 0.0}, {}};
  InnerLoopReferences<double> reference;
  reference.down.value = -1.0;
  const double weight_N = Mambo().mass_kg * kGravity_m_per_s2;
  const Gains gains = LoadGains("aware");
  EXPECT_NEAR(InnerLoops<double>(Mambo(), gains, state, reference, {}).wrench.thrust_N,
              2.0 * weight_N,
              1e-12);
  EXPECT_NEAR(PidInnerLoops(Mambo(), gains, state, reference, {}).wrench.thrust_N, weight_N, 1e-12);
}

FlightResult FlyWith(const std::string& law, const std::string& maneuver, double duration_s) {
  FlightSetup setup;
  setup.vehicle = LoadVehicle("mambo-coupled");
  setup.gains = LoadGains("aware");
  setup.controller.law = law;
  FlightPlan plan = FindManeuver(maneuver).plan({});
  plan.duration_s = duration_s;
  return Fly(setup, plan);
}

TEST(ControlLaws, EachFliesTheThesisManeuvers) {
  for (const ControlLaw& law : ControlLaws()) {
    for (const char* maneuver : {"hover", "altitude-steps", "attitude-doublets", "square"}) {
      SCOPED_TRACE(std::string(law.name) + " " + maneuver);
      const FlightResult flight = FlyWith(std::string(law.name), maneuver, 10.0);
      EXPECT_EQ(flight.outcome, Outcome::kCompleted) << flight.reason;
      for (const double peak_m : flight.peak_altitude_error_m) EXPECT_LT(peak_m, 0.5);
    }
  }
}

// The coupling that inversion cancels costs PID altitude while it pitches.
TEST(ControlLaws, InversionHoldsTheAltitudeBetterWhilePitching) {
  EXPECT_LT(FlyWith("inversion", "attitude-doublets", 10.0).mse_altitude_m2,
            FlyWith("pid", "attitude-doublets", 10.0).mse_altitude_m2);
}

}  // namespace
}  // namespace lipoid
