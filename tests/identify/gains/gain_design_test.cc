#include "identify/gains/gain_design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "model/analysis/placed_gains.h"
#include "model/core/errors.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/f450.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

GainDesign Design(Loop loop, std::vector<WeightedXi> xi) {
  GainDesign design;
  design.loop = loop;
  design.vehicle = LoadVehicle("mambo-thesis");
  design.xi = std::move(xi);
  design.altitude_gains = LoadGains("aware").altitude;
  if (loop == Loop::kAttitude) design.options.duration_s = 12.0;
  return design;
}

TEST(GainDesign, GradientsAreExact) {
  for (const Loop loop : {Loop::kAltitude, Loop::kAttitude}) {
    const GainProblem problem(Design(loop, {{0.85, 1.0}, {1.0, 2.0}}));
    for (const auto& x : {Eigen::Vector3d(0.5, 0.14, 0.8), Eigen::Vector3d(0.3, 0.02, 0.5)}) {
      Eigen::VectorXd gradient;
      const double cost = problem.Gradient(x, gradient);
      // One a sum of 4000 squares, the other the norm of a triangular factor.
      EXPECT_NEAR(cost, problem.Cost(x), 1e-11 * cost);
      for (int k = 0; k < 3; ++k) {
        const auto along = [&](double value) {
          Eigen::VectorXd at = x;
          at[k] = value;
          return problem.Cost(at);
        };
        const auto slope = test::Ridders(along, x[k], 1e-3);
        // Saturation makes kinks: differences over them err, the tangent does not.
        EXPECT_NEAR(gradient[k], slope.value, 1e-5 * gradient.norm() + 10.0 * slope.error)
            << int(loop) << " " << k;
      }
    }
  }
}

// The parameters of a regulator are its weights, the gains are those of the Riccati equation.
TEST(GainDesign, OfARegulatorSearchesItsWeights) {
  GainDesign design = Design(Loop::kAttitude, {{0.8, 1.0}, {1.0, 1.0}});
  design.vehicle = test::F450();
  design.controller.law = "lqr";
  design.options.proportional_bound = design.options.integral_bound =
      design.options.derivative_bound = 20.0;
  const GainProblem problem(design, 10.0);
  const Eigen::Vector3d x(0.09, 0.4, 0.01);
  const ErrorGains gains = problem.Gains(x);
  EXPECT_NEAR(gains.integral, 8.0, 1e-9);
  EXPECT_NEAR(gains.proportional * gains.proportional - 16.0 * gains.derivative, 36.0, 1e-8);
  EXPECT_LT((problem.Point(gains) - x).norm(), 1e-8);
  Eigen::VectorXd gradient;
  const double cost = problem.Gradient(x, gradient);
  EXPECT_NEAR(cost, problem.Cost(x), 1e-11 * cost);
  for (int k = 0; k < 3; ++k) {
    const auto along = [&](double value) {
      Eigen::VectorXd at = x;
      at[k] = value;
      return problem.Cost(at);
    };
    const auto slope = test::Ridders(along, x[k], 1e-3);
    EXPECT_NEAR(gradient[k], slope.value, 1e-5 * gradient.norm() + 10.0 * slope.error) << k;
  }
  const auto result = DesignGains(design, gains, FindOptimizer("levenberg-marquardt"), {});
  EXPECT_TRUE(result.answer().stable);
  EXPECT_LT(result.answer().cost, result.start_cost);
  // Gains that no weights have: the search starts elsewhere, and what is said of them is their own cost.
  const ErrorGains of_thesis{.proportional = 0.95, .integral = 0.25, .derivative = 0.54};
  EXPECT_EQ(DesignGains(design, of_thesis, FindOptimizer("levenberg-marquardt"), {}).start_cost,
            problem.CostOf(of_thesis));
  // Of a regulator: K_e² >= 2 K_edot K_eI and K_edot² >= 2 K_e.
  constexpr double kRounding = 1e-9;
  const ErrorGains& found = result.answer().gains;
  EXPECT_GE(found.proportional * found.proportional * (1.0 + kRounding),
            2.0 * found.derivative * found.integral);
  EXPECT_GE(found.derivative * found.derivative * (1.0 + kRounding), 2.0 * found.proportional);
}

TEST(GainDesign, CostIsTheIntegralOfTheSquaredError) {
  const GainDesign design = Design(Loop::kAltitude, {{0.8, 1.0}, {0.9, 3.0}});
  const GainProblem problem(design);
  const ErrorGains gains = LoadGains("aware").altitude;
  double expected = 0.0;
  for (const auto& [xi, weight] : design.xi) {
    LoopTask task;
    task.vehicle = design.vehicle;
    task.xi = xi;
    task.plan = DesignPlan(design);
    RunAltitudeLoop(
        task, SampledCommands(task.plan), gains, [&, weight = weight](std::size_t, double e) {
          expected += weight * e * e * kControlStep_s;
        });
  }
  EXPECT_NEAR(problem.CostOf(gains), expected, 1e-14 * expected);
  EXPECT_GT(expected, 1e-4);
}

TEST(GainDesign, EveryLocalMethodFindsTheSameGains) {
  const GainDesign design = Design(Loop::kAltitude, {{0.8, 1.0}, {0.9, 1.0}, {1.0, 1.0}});
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::pair<std::string, double>> costs;
  for (const OptimizerEntry& optimizer : Optimizers()) {
    if (optimizer.global) continue;
    const auto result = DesignGains(design, LoadGains("aware").altitude, optimizer, {});
    EXPECT_TRUE(result.optimization.usable()) << optimizer.name;
    EXPECT_LE(result.search.cost, result.start_cost);
    EXPECT_LE(result.polished.cost, result.search.cost);
    costs.emplace_back(optimizer.name, result.search.cost);
    best = std::min(best, result.search.cost);
  }
  ASSERT_GE(costs.size(), 6U);
  for (const auto& [name, cost] : costs) {
    // Nelder-Mead's simplex flattens on the bounds that hold here and ends above the others.
    EXPECT_LT(cost, (name == "nelder-mead" ? 1.05 : 1.001) * best) << name;
  }
}

TEST(GainDesign, WhatIsLeftIsFoundWhateverTheSearchWasAllowed) {
  OptimizerSettings none;
  none.levenberg_marquardt.iterations_per_variable = 0;
  const auto& optimizer = FindOptimizer("levenberg-marquardt");
  const ErrorGains start = LoadGains("aware").altitude;
  // With two voltages the gains of the least error alone would not keep the margin.
  for (const auto& xi : {std::vector<WeightedXi>{{0.8, 1.0}, {0.9, 1.0}, {1.0, 1.0}},
                         std::vector<WeightedXi>{{0.8, 1.0}, {1.0, 1.0}}}) {
    const GainDesign design = Design(Loop::kAltitude, xi);
    const auto stopped = DesignGains(design, start, optimizer, none);
    EXPECT_EQ(stopped.search.cost, stopped.start_cost);
    EXPECT_EQ(stopped.polished.cost, DesignGains(design, start, optimizer, {}).search.cost)
        << xi.size();
  }
}

// At the start the weight of the rate is 0, for K_edot² is less than 2 K_e.
TEST(GainDesign, AWeightThatStartsAtNothingIsFound) {
  for (const auto& [loop, xi] :
       {std::pair(Loop::kAltitude, std::vector<WeightedXi>{{1.0, 1.0}}),
        std::pair(Loop::kAttitude, std::vector<WeightedXi>{{0.8, 1.0}, {1.0, 1.0}})}) {
    GainDesign design = Design(loop, xi);
    design.controller.law = "lqr";
    const Gains unaware = LoadGains("unaware");
    const ErrorGains start = loop == Loop::kAltitude ? unaware.altitude : unaware.attitude;
    EXPECT_EQ(GainProblem(design).Point(start)[2], 0.0);
    const auto of = [&](const char* optimizer) {
      return DesignGains(design, start, FindOptimizer(optimizer), {}).search.cost;
    };
    const double without_slopes = of("bobyqa");
    EXPECT_LT(of("levenberg-marquardt"), 1.001 * without_slopes);
    EXPECT_LT(of("sqp"), 1.001 * without_slopes);
  }
}

TEST(GainDesign, WhatASearchMissedIsTheAnswer) {
  OptimizerSettings none;
  none.levenberg_marquardt.iterations_per_variable = 0;
  const GainDesign design = Design(Loop::kAltitude, {{0.8, 1.0}, {1.0, 1.0}});
  const auto result =
      DesignGains(design, LoadGains("aware").altitude, FindOptimizer("levenberg-marquardt"), none);
  EXPECT_TRUE(result.missed());
  EXPECT_EQ(result.answer().cost, result.polished.cost);
  EXPECT_NEAR(GainProblem(design).CostOf(result.answer().gains),
              result.answer().cost,
              1e-12 * result.answer().cost);
}

// On the way from here every gain stands at a bound at once, in a corner that is no minimum.
TEST(GainDesign, ABoundOnTheWayIsLeftAgain) {
  GainDesign design = Design(Loop::kAttitude, {{0.8, 1.0}});
  design.options.duration_s = 50.0;
  const GainProblem problem(design);
  const Eigen::VectorXd from = problem.Point(LoadGains("aware").attitude);
  const Eigen::VectorXd x = FindOptimizer("levenberg-marquardt").Minimize(problem, from, {}).x;
  Eigen::VectorXd slope;
  // Slopes are of the cost over a whole range of gains: in the corner a third of the cost.
  const double flat = 1e-3 * problem.Gradient(x, slope);
  for (int k = 0; k < 3; ++k) {
    if (x[k] > 0.0) {
      EXPECT_LT(slope[k], flat) << k;
    }
    if (x[k] < 1.0) {
      EXPECT_GT(slope[k], -flat) << k;
    }
  }
}

TEST(GainDesign, TheSwarmFindsItToo) {
  const GainDesign design = Design(Loop::kAltitude, {{0.8, 1.0}, {1.0, 1.0}});
  const GainProblem problem(design);
  OptimizerSettings settings;
  settings.context.seed = 3;
  const ErrorGains start = LoadGains("unaware").altitude;
  const auto swarm = DesignGains(design, start, FindOptimizer("particle-swarm"), settings);
  const auto again = DesignGains(design, start, FindOptimizer("particle-swarm"), settings);
  EXPECT_LT(swarm.search.cost, 1.001 * swarm.polished.cost);
  EXPECT_EQ(swarm.search.cost, again.search.cost);
  EXPECT_LE(swarm.search.gains.proportional, problem.bounds().proportional);
  EXPECT_LT(swarm.search.cost, problem.CostOf(start));
}

TEST(GainDesign, BoundsAreTheThesisOrTheUsers) {
  GainDesign design = Design(Loop::kAltitude, {{1.0, 1.0}});
  EXPECT_EQ(GainProblem(design).bounds().derivative, 10.0);
  design.options.derivative_bound = 3.5;
  EXPECT_EQ(GainProblem(design).bounds().derivative, 3.5);
  EXPECT_EQ(GainProblem(Design(Loop::kAttitude, {{1.0, 1.0}})).bounds().proportional, 1.0);
}

// The least error of this vehicle is that of gains which grow, more slowly than the maneuver lasts.
TEST(GainDesign, SaysWhichParametersStandAtABound) {
  GainDesign design = Design(Loop::kAltitude, {{1.0, 1.0}});
  design.options.derivative_bound = 3.0;
  const GainProblem problem(design);
  EXPECT_TRUE(problem.AtBound(Eigen::Vector3d(0.5, 0.01, 0.99)).empty());
  const auto at = problem.AtBound(Eigen::Vector3d(0.5, 0.0, 1.0));
  ASSERT_EQ(at.size(), 2U);
  EXPECT_EQ(at[0].gain, "integral");
  EXPECT_FALSE(at[0].largest);
  EXPECT_EQ(at[0].value, 0.0);
  EXPECT_EQ(at[1].gain, "derivative");
  EXPECT_TRUE(at[1].largest);
  EXPECT_EQ(at[1].value, 3.0);
}

TEST(GainDesign, NeverReturnsGainsThatAreUnstable) {
  GainDesign design = Design(Loop::kAttitude, {});
  design.vehicle = test::F450();
  design.vehicle.armature_resistance_Ohm = 0.08;
  design.vehicle.rotor_inertia_kg_m2 = 2e-5;
  for (double xi = 0.8; xi < 1.005; xi += 0.05) design.xi.push_back({xi, 1.0});
  design.options.duration_s = 0.0;
  const GainProblem problem(design);
  const ErrorGains start = LoadGains("aware").attitude;
  const auto& optimizer = FindOptimizer("levenberg-marquardt");
  const auto alone = optimizer.Minimize(problem, problem.Point(start), {});
  ASSERT_TRUE(alone.usable());
  EXPECT_FALSE(problem.Stable(problem.Gains(alone.x)));
  const auto result = DesignGains(design, start, optimizer, {});
  EXPECT_TRUE(result.answer().constrained);
  EXPECT_TRUE(result.answer().stable);
  EXPECT_TRUE(problem.Stable(result.answer().gains));
  EXPECT_LT(result.answer().cost, result.start_cost);
  // The margin costs little, since it is the least error that is just beyond it.
  EXPECT_LT(result.answer().cost, 1.1 * 2.0 * alone.cost);
  // The poles themselves, with motor lag, at all voltages.
  Gains gains = LoadGains("aware");
  gains.attitude = result.answer().gains;
  for (const auto& [xi, weight] : design.xi) {
    EXPECT_LT(PolesAt(Loop::kAttitude, design.vehicle, gains, xi).full.front().real(), 0.0) << xi;
  }
}

// The maneuver starts with the integral of its hover and alone needs no gain of it: before, the answer
// was K_eI = 0, with which hover at another voltage is no equilibrium.
TEST(GainDesign, TheAltitudeKeepsAnIntegralThatFollowsTheBattery) {
  for (const char* name : {"f450", "camera-10in"}) {
    GainDesign design = Design(Loop::kAltitude, {{1.0, 1.0}});
    design.vehicle = LoadVehicle(name);
    Gains gains = GainsFor("", design.vehicle, "unaware");
    design.references = gains.references;
    WidenBounds(design, gains.altitude);
    const GainProblem problem(design);
    const auto& optimizer = FindOptimizer("levenberg-marquardt");
    const auto alone = optimizer.Minimize(problem, problem.Point(gains.altitude), {});
    ASSERT_EQ(problem.Gains(alone.x).integral, 0.0) << name;
    EXPECT_FALSE(problem.Stable(problem.Gains(alone.x))) << name;
    const auto result = DesignGains(design, gains.altitude, optimizer, {});
    EXPECT_TRUE(result.answer().stable) << name;
    EXPECT_TRUE(result.answer().constrained) << name;
    EXPECT_LT(result.answer().cost, result.start_cost) << name;
    gains.altitude = result.answer().gains;
    const auto poles = PolesAt(Loop::kAltitude, design.vehicle, gains, 1.0).full;
    EXPECT_LT(poles.front().real(), -kAltitudeDecay_per_s) << name;
    // The supply falls by 0.5 % of the nominal voltage a second: a drop of the thrust at which the
    // integral must grow by about 2 g 0.005/s, and the error by that over K_eI.
    EXPECT_LT(2.0 * 9.81 * 0.005 / gains.altitude.integral, 1.0) << name;
  }
}

// Doublets are flown best by damping alone: before, the answer was an attitude that forgets an error
// within a quarter of an hour.
TEST(GainDesign, TheAttitudeIsHeld) {
  for (const char* name : {"f450", "racer-5in"}) {
    GainDesign design = Design(Loop::kAttitude, {{1.0, 1.0}});
    design.vehicle = LoadVehicle(name);
    Gains gains = GainsFor("", design.vehicle, "unaware");
    design.references = gains.references;
    design.altitude_gains = gains.altitude;
    design.attitude_decay_per_s = AttitudeDecayFor(design.vehicle);
    EXPECT_NEAR(
        design.attitude_decay_per_s, 0.1 * PlaceGains(design.vehicle).attitude_rad_per_s, 1e-12);
    WidenBounds(design, gains.attitude);
    EXPECT_TRUE(GainProblem(design).Stable(gains.attitude)) << name;
    const auto result =
        DesignGains(design, gains.attitude, FindOptimizer("levenberg-marquardt"), {});
    EXPECT_TRUE(result.answer().stable) << name;
    EXPECT_TRUE(result.answer().constrained) << name;
    EXPECT_LT(result.answer().cost, result.start_cost) << name;
    gains.attitude = result.answer().gains;
    const auto poles = PolesAt(Loop::kAttitude, design.vehicle, gains, 1.0).full;
    EXPECT_LT(poles.front().real(), -design.attitude_decay_per_s) << name;
  }
  EXPECT_EQ(AttitudeDecayFor(LoadVehicle("mambo-thesis")), 0.0);
}

TEST(GainDesign, SaysWhereNoGainsWithinTheBoundsAreStable) {
  GainDesign design = Design(Loop::kAttitude, {{0.9, 1.0}});
  design.vehicle = test::F450();
  design.vehicle.rotor_inertia_kg_m2 *= 100.0;  // motors of four seconds
  design.options.duration_s = 1.0;
  design.options.derivative_bound = 0.01;
  design.options.integral_bound = 1e-9;
  const auto result =
      DesignGains(design, LoadGains("aware").attitude, FindOptimizer("levenberg-marquardt"), {});
  // K_e > 0 needs K_edot > lag K_e; the step aims at a decay of 1e-3/s.
  EXPECT_EQ(result.answer().stable, GainProblem(design).Stable(result.answer().gains));
  EXPECT_TRUE(result.answer().constrained);
}

TEST(GainDesign, TheRowsOfTheMarginHaveExactSlopes) {
  GainDesign design = Design(Loop::kAttitude, {{0.8, 1.0}, {1.0, 1.0}});
  design.vehicle = test::F450();
  const GainProblem problem(design, 100.0);
  const Eigen::Vector3d x(0.95, 0.07, 0.05);  // unstable
  ASSERT_FALSE(problem.Stable(problem.Gains(x)));
  Eigen::VectorXd gradient;
  const double cost = problem.Gradient(x, gradient);
  EXPECT_NEAR(cost, problem.Cost(x), 1e-11 * cost);
  EXPECT_GT(cost, 1.5 * GainProblem(design).Cost(x));
  for (int k = 0; k < 3; ++k) {
    const auto along = [&](double value) {
      Eigen::VectorXd at = x;
      at[k] = value;
      return problem.Cost(at);
    };
    const auto slope = test::Ridders(along, x[k], 1e-3);
    EXPECT_NEAR(gradient[k], slope.value, 1e-5 * gradient.norm() + 10.0 * slope.error) << k;
  }
}

TEST(GainDesign, WithoutLagAndSaturationAnyGainsAreAsGoodAtFullVoltage) {
  // What makes (6.2) degenerate: the error left is that of sampling.
  GainDesign design = Design(Loop::kAltitude, {{1.0, 1.0}});
  design.options.motor_lag = false;
  design.controller.saturate = false;
  const GainProblem ideal(design);
  design.options.motor_lag = true;
  design.controller.saturate = true;
  const GainProblem real(design);
  const ErrorGains unaware = LoadGains("unaware").altitude;
  EXPECT_LT(ideal.CostOf(unaware), 0.02 * real.CostOf(unaware));
}

// A regulator with integral action is a PID about hover, and so is what is left of the inversion in a climb: costs of laws are like for
// like at the same gains.
TEST(GainDesign, LawsCostTheSameAtTheSameGains) {
  const ErrorGains gains{.proportional = 0.1644, .integral = 0.002377, .derivative = 5.686};
  for (const Loop loop : {Loop::kAltitude, Loop::kAttitude}) {
    std::map<std::string, std::vector<double>> costs;
    for (const char* law : {"inversion", "pid", "lqr"}) {
      GainDesign design = Design(loop, {{0.8, 1.0}, {0.9, 1.0}, {1.0, 1.0}});
      design.controller.law = law;
      costs[law] = GainProblem(design).CostsOf(gains);
    }
    // The inversion adds thrust where the vehicle leans: 1/cos of 4 degrees.
    const double of_inversion = loop == Loop::kAltitude ? 1e-12 : 0.01;
    for (std::size_t k = 0; k < 3; ++k) {
      const double pid = costs["pid"][k];
      EXPECT_NEAR(costs["lqr"][k], pid, 1e-12 * pid);
      EXPECT_NEAR(costs["inversion"][k], pid, of_inversion * pid);
    }
  }
}

// What a design of six and of eight rotors promises is what the whole flight of such a vehicle does.
TEST(GainDesign, OfSixAndEightRotorsKeepsItsPromiseInFlight) {
  for (const RotorLayout layout : {RotorLayout::kHexaX, RotorLayout::kOctoX}) {
    GainDesign design = Design(Loop::kAttitude, {{0.85, 1.0}, {1.0, 1.0}});
    design.vehicle = LoadVehicle("hexacopter");
    design.vehicle.layout = layout;
    design.vehicle.mass_kg *= static_cast<double>(RotorsOf(layout).size()) / 6.0;
    design.options = {};
    Gains gains = GainsFor("", design.vehicle, "aware");
    design.altitude_gains = gains.altitude;
    design.references = gains.references;
    WidenBounds(design, gains.attitude);
    const GainDesignResult found =
        DesignGains(design, gains.attitude, FindOptimizer("levenberg-marquardt"), {});
    EXPECT_TRUE(found.answer().stable);
    EXPECT_LT(found.answer().cost, 0.9 * found.start_cost);
    gains.attitude = found.answer().gains;
    double flown = 0.0;
    for (const auto& [xi, weight] : design.xi) {
      FlightSetup setup;
      setup.vehicle = design.vehicle;
      setup.xi = xi;
      setup.gains = gains;
      setup.controller = design.controller;
      setup.controller.pwm = Pwm::kContinuous;
      setup.simulation.ground = false;
      (void)Fly(setup, DesignPlan(design), [&, weight = weight](const FlightSample& s) {
        const double error = s.angle_references_rad[1] - s.angles_rad[1];
        flown += weight * error * error * kControlStep_s;
      });
    }
    constexpr double kRounding = 1e-6;  // of the loops, reduced_loops_test.cc
    EXPECT_NEAR(found.answer().cost, flown, kRounding * flown)
        << design.vehicle.rotor_count() << " rotors";
  }
}

TEST(GainDesign, RefusesNoXi) {
  EXPECT_THROW(GainProblem(Design(Loop::kAltitude, {})), PreconditionError);
  EXPECT_THROW(GainProblem(Design(Loop::kAltitude, {{0.0, 1.0}})), PreconditionError);
}

}  // namespace
}  // namespace lipoid
