#include "model/analysis/stability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "model/battery/cell_file.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/f450.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

const LoopStability& Of(const std::vector<LoopStability>& loops, std::string_view name) {
  const auto at = std::find_if(
      loops.begin(), loops.end(), [&](const LoopStability& loop) { return loop.loop == name; });
  if (at == loops.end()) ADD_FAILURE() << "no loop " << name;
  return *at;
}

std::vector<LoopStability> Check(const Vehicle& vehicle, const Gains& gains, double xi) {
  return CheckLoops(vehicle, gains, {}, true, HoverAt(vehicle, xi));
}

// How an error swings in a flight: its frequency and the decay of its amplitude, by the times and
// sizes of its extremes after the fast poles have died out.
struct Swing {
  double frequency_rad_per_s;
  double growth_per_s;
};
template <class Error>
Swing SwingOf(FlightSetup setup, const FlightPlan& plan, double from_s, Error&& error) {
  setup.controller.pwm = Pwm::kContinuous;
  std::vector<double> times;
  std::vector<double> values;
  (void)Fly(setup, plan, [&](const FlightSample& sample) {
    times.push_back(sample.time_s);
    values.push_back(error(sample));
  });
  std::vector<double> at;
  std::vector<double> size;
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    if (times[k] < from_s) continue;
    const double before = values[k] - values[k - 1];
    const double after = values[k + 1] - values[k];
    if (before * after >= 0.0) continue;
    // Of the parabola through three samples.
    const double bend = after - before;
    const double shift = -0.5 * (before + after) / bend;
    at.push_back(times[k] + shift * kControlStep_s);
    size.push_back(std::abs(values[k] - 0.5 * bend * shift * shift));
  }
  if (at.size() < 8) {
    ADD_FAILURE() << "no swing: " << at.size() << " extremes";
    return {};
  }
  const double swung_s = at.back() - at.front();
  return {std::numbers::pi * double(at.size() - 1) / swung_s,
          std::log(size.back() / size.front()) / swung_s};
}

FlightSetup SetupOf(const Vehicle& vehicle, const char* gains, double xi) {
  FlightSetup setup;
  setup.vehicle = vehicle;
  setup.gains = LoadGains(gains);
  setup.xi = xi;
  return setup;
}

// A flight is a second implementation of all that is analysed: sampled, and with the whole vehicle.
TEST(Stability, SaysHowTheLoopsSwingInFlight) {
  const Vehicle mambo = LoadVehicle("mambo-thesis");
  constexpr double kSmall = 1e-3;  // m and rad: nothing saturates
  // Of the frequency and of the decay: the slow real pole of the altitude still bends the swing.
  constexpr double kSwing = 3e-3;
  const auto expect = [&](std::string_view loop, const FlightSetup& setup, const Swing& swing) {
    SCOPED_TRACE(std::string(loop));
    const LoopStability said = Of(Check(setup.vehicle, setup.gains, setup.xi), loop);
    EXPECT_NEAR(swing.frequency_rad_per_s, said.frequency_rad_per_s, kSwing);
    EXPECT_NEAR(swing.growth_per_s, -said.damping * said.frequency_rad_per_s, kSwing);
  };
  for (const Vehicle& vehicle : {mambo, test::F450()}) {
    SCOPED_TRACE(vehicle.name);
    FlightPlan climb{.commands = {{0.0, {.altitude_m = 5.0}}, {1.0, {.altitude_m = 5.0 + kSmall}}},
                     .duration_s = 80.0};
    FlightSetup setup = SetupOf(vehicle, "unaware", 0.85);
    expect("altitude", setup, SwingOf(setup, climb, 30.0, [](const FlightSample& s) {
             return s.position_m[2] - s.altitude_reference_m;
           }));
    FlightPlan lean{
        .commands = {{0.0, {.altitude_m = 5.0, .hold_position = false}},
                     {1.0, {.altitude_m = 5.0, .hold_position = false, .pitch_rad = kSmall}}},
        .duration_s = 80.0};
    expect("attitude", setup, SwingOf(setup, lean, 20.0, [](const FlightSample& s) {
             return s.angles_rad[1] - s.angle_references_rad[1];
           }));
    FlightPlan aside{
        .commands = {{0.0, {.altitude_m = 5.0}}, {1.0, {.altitude_m = 5.0, .x_m = kSmall}}},
        .duration_s = 80.0};
    expect("position", setup, SwingOf(setup, aside, 20.0, [](const FlightSample& s) {
             return s.angles_rad[1] - s.angle_references_rad[1];
           }));
  }
}

// Where flights of the thesis' unaware gains were found to become unstable (docs/corrections.md).
TEST(Stability, FindsWhereTheUnawareAttitudeBecomesUnstable) {
  const Vehicle mambo = LoadVehicle("mambo-thesis");
  const Gains unaware = LoadGains("unaware");
  EXPECT_TRUE(Of(Check(mambo, unaware, 0.86), "attitude").stable());
  EXPECT_FALSE(Of(Check(mambo, unaware, 0.81), "attitude").stable());
  // Motors without lag would still hold it.
  EXPECT_LT(Of(Check(mambo, unaware, 0.81), "attitude").quasistatic_per_s, 0.0);
}

TEST(Stability, MarginsLeadToTheEdge) {
  const Vehicle vehicle = test::F450();
  Gains gains = LoadGains("aware");
  const auto loops = Check(vehicle, gains, 0.9);
  const auto scaled = [](ErrorGains own, double by) {
    return ErrorGains{own.proportional * by, own.integral * by, own.derivative * by};
  };
  constexpr double kEdge_per_s = 1e-5;  // the margins are found to 1e-15, roots to less
  for (const double factor :
       {Of(loops, "attitude").gain_margin_up, Of(loops, "attitude").gain_margin_down}) {
    Gains at = gains;
    at.attitude = scaled(gains.attitude, factor);
    EXPECT_NEAR(Of(Check(vehicle, at, 0.9), "attitude").pole.real(), 0.0, kEdge_per_s) << factor;
    EXPECT_TRUE(factor > 0.0 && std::isfinite(factor)) << factor;
  }
  Gains at = gains;
  const double up = Of(loops, "position").gain_margin_up;
  at.position.proportional_rad_per_m *= up;
  at.position.derivative_rad_s_per_m *= up;
  EXPECT_NEAR(Of(Check(vehicle, at, 0.9), "position").pole.real(), 0.0, kEdge_per_s);
}

// With K_e and K_edot alone |L| = 1 is an equation of third order in the square of the frequency.
TEST(Stability, PhaseMarginIsThatOfTheClosedForm) {
  const Vehicle vehicle = test::F450();
  Gains gains = LoadGains("aware");
  gains.altitude = {.proportional = 4.0, .integral = 0.0, .derivative = 3.0};
  const auto loops = Check(vehicle, gains, 1.0);
  const auto response = ResponseAtHover(vehicle, HoverAt(vehicle, 1.0)).altitude;
  const double hold_s = 0.5 * kControlStep_s;
  double low = 0.1;
  double high = 100.0;
  for (int k = 0; k < 100; ++k) {
    const double w = 0.5 * (low + high);
    const double gain = response.kappa * std::hypot(4.0, 3.0 * w) /
                        (w * w * std::hypot(1.0, response.lag_s * w) * std::hypot(1.0, hold_s * w));
    (gain > 1.0 ? low : high) = w;
  }
  const double phase =
      std::atan(0.75 * low) - std::atan(response.lag_s * low) - std::atan(hold_s * low);
  EXPECT_NEAR(Of(loops, "altitude").phase_margin_deg, phase * 180.0 / std::numbers::pi, 1e-9);
}

TEST(Stability, NothingThatBringsItBackIsUnstable) {
  Gains gains = LoadGains("aware");
  gains.attitude = {.proportional = 0.0, .integral = 0.0, .derivative = 1.0};
  const HoverStability hover{"take-off", 1.0, Check(test::F450(), gains, 1.0)};
  EXPECT_FALSE(hover.stable());
  const auto warnings = StabilityWarnings({&hover, 1});
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings.front(),
            "the attitude loop is unstable at xi = 1 (take-off): nothing brings it back, as its "
            "K_e is 0");
  gains.attitude.integral = 0.1;
  EXPECT_FALSE(Of(Check(test::F450(), gains, 1.0), "attitude").stable());
}

TEST(Stability, AnAltitudeWithoutIntegralIsStable) {
  Gains gains = LoadGains("aware");
  gains.altitude.integral = 0.0;
  EXPECT_TRUE(Of(Check(test::F450(), gains, 0.8), "altitude").stable());
  gains.position = {};
  EXPECT_EQ(Check(test::F450(), gains, 0.8).size(), 3U);
}

// A pole at -K_eI/K_e is slow, and no pole at 0.
TEST(Stability, ASmallIntegralGainIsAsStableAsNone) {
  Gains gains = LoadGains("aware");
  for (const double integral : {0.0, 1e-9, 1e-12}) {
    gains.altitude.integral = integral;
    const auto loops = Check(test::F450(), gains, 1.0);
    const LoopStability& altitude = Of(loops, "altitude");
    EXPECT_TRUE(altitude.stable()) << integral;
    EXPECT_GT(altitude.phase_margin_deg, 0.0) << integral;
    const HoverStability hover{"take-off", 1.0, loops};
    for (const std::string& warning : StabilityWarnings({&hover, 1}))
      EXPECT_EQ(warning.find("altitude"), std::string::npos) << warning;
  }
  // Without K_e the same gain drives it away, however slowly.
  gains.altitude = {.proportional = 0.0, .integral = 1e-12, .derivative = 7.87};
  EXPECT_FALSE(Of(Check(test::F450(), gains, 1.0), "altitude").stable());
}

TEST(Stability, GrowthHasTheSlopesOfItsDifferences) {
  const AxisResponse response{.kappa = 0.8, .lag_s = 0.04};
  for (const ErrorGains& at : {ErrorGains{0.95, 0.07, 0.12}, ErrorGains{5.0, 1.4, 7.9}}) {
    const Growth growth = GrowthOf(response, at);
    const auto slope = [&](double ErrorGains::*gain) {
      const auto along = [&](double value) {
        ErrorGains moved = at;
        moved.*gain = value;
        return GrowthOf(response, moved).per_s;
      };
      return test::Ridders(along, at.*gain, 0.01).value;
    };
    constexpr double kClose = 1e-7;
    EXPECT_NEAR(growth.slopes.proportional, slope(&ErrorGains::proportional), kClose);
    EXPECT_NEAR(growth.slopes.integral, slope(&ErrorGains::integral), kClose);
    EXPECT_NEAR(growth.slopes.derivative, slope(&ErrorGains::derivative), kClose);
  }
}

TEST(Stability, AFlightIsCheckedFullAndEmpty) {
  FlightSetup setup = SetupOf(LoadVehicle("mambo-coupled"), "unaware", 1.0);
  setup.cell = LoadCell("gifi-600mAh-1");
  const auto hovers = CheckFlightLoops(setup);
  ASSERT_EQ(hovers.size(), 2U);
  EXPECT_NEAR(hovers[1].xi, 3.0 / 4.2, 1e-9);  // the cell's cut-off
  EXPECT_TRUE(hovers[0].stable());
  EXPECT_FALSE(hovers[1].stable());
  const auto warnings = StabilityWarnings(hovers);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].substr(0, warnings[0].find(':')),
            "the altitude loop is unstable at xi = 0.714 (lowest voltage allowed)");
  EXPECT_EQ(warnings[2].find("the position loop rings at 1.0"), 0U) << warnings[2];
  // Compensated commands make every voltage the nominal one.
  setup.controller.compensate = true;
  for (const auto& hover : CheckFlightLoops(setup)) {
    EXPECT_NEAR(Of(hover.loops, "attitude").pole.real(),
                Of(Check(setup.vehicle, setup.gains, 1.0), "attitude").pole.real(),
                1e-9);
  }
  setup.land_below_V = 3.5;
  EXPECT_NEAR(CheckFlightLoops(setup)[1].xi, 3.5 / 4.2, 1e-9);
}

TEST(Stability, OfAVehicleThatCannotHoverSaysNothing) {
  FlightSetup setup = SetupOf(LoadVehicle("mambo-thesis"), "aware", 0.6);
  EXPECT_TRUE(CheckFlightLoops(setup).empty());
}

}  // namespace
}  // namespace lipoid
