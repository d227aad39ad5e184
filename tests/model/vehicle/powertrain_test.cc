#include "model/vehicle/powertrain.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <random>

#include "model/battery/cell_file.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kDrawSeed;

// v_b as a root: the voltage at which what the battery gives is what the motors take. Knows (3.9)
// and (3.11), not their solution.
double RootOfTheLoop(const Vehicle& v,
                     const Supply<double>& supply,
                     const PerMotor<double>& duty,
                     const PerMotor<double>& speed) {
  const auto surplus = [&](double voltage_V) {
    double current_A = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      current_A += duty[i] * (duty[i] * voltage_V - v.motor_constant_N_m_per_A * speed[i]) /
                   v.armature_resistance_Ohm;
    }
    return supply.voltage_V - supply.resistance_Ohm * current_A - voltage_V;
  };
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      surplus, -100.0, 100.0, boost::math::tools::eps_tolerance<double>(52), iterations);
  return 0.5 * (bracket.first + bracket.second);
}

TEST(Powertrain, ClosedFormIsTheRootOfTheLoop) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  std::mt19937 engine(kDrawSeed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<double> resistances{0.0, 1e-3, 5.0};
  for (const auto& name : ShippedCellNames()) {
    resistances.push_back(LoadCell(name).series_resistance_Ohm(1.0));
  }
  for (const double resistance : resistances) {
    for (int draw = 0; draw < 50; ++draw) {
      const Supply<double> supply{3.0 + 1.2 * share(engine), resistance};
      PerMotor<double> duty;
      PerMotor<double> speed;
      for (std::size_t i = 0; i < 4; ++i) {
        duty[i] = share(engine);
        speed[i] = 4000.0 * share(engine);
      }
      const double voltage = LoopVoltage(v, supply, duty, speed);
      // The bracket of the root finder is 52 bits of up to 100 V wide at worst.
      ASSERT_NEAR(voltage, RootOfTheLoop(v, supply, duty, speed), 1e-13)
          << "R = " << resistance << ", draw " << draw;
      PerMotor<double> current;
      for (std::size_t i = 0; i < 4; ++i) {
        current[i] = ArmatureCurrent(v, duty[i] * voltage, speed[i]);
      }
      ASSERT_NEAR(voltage, supply.voltage_V - resistance * BatteryCurrent(duty, current), 1e-12);
    }
  }
}

TEST(Powertrain, AnIdealSourceKeepsItsVoltage) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  EXPECT_EQ(LoopVoltage(v, Supply<double>{3.7, 0.0}, {0.1, 1.0, 0.5, 0.7}, {0.0, 9e3, 1.0, 2e3}),
            3.7);
}

TEST(Powertrain, WithoutDutyNothingFlows) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  EXPECT_EQ(LoopVoltage(v, Supply<double>{3.7, 0.2}, {}, {2e3, 2e3, 2e3, 2e3}), 3.7);
  EXPECT_EQ(BatteryCurrent<double>({}, {1.0, 2.0, 3.0, 4.0}), 0.0);
}

// Rotors faster than their voltage push current back: the battery charges, and v_b rises above
// what it has at rest.
TEST(Powertrain, FastRotorsCharge) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const PerMotor<double> duty{0.1, 0.1, 0.1, 0.1};
  const PerMotor<double> speed{2e3, 2e3, 2e3, 2e3};
  EXPECT_GT(LoopVoltage(v, Supply<double>{3.7, 0.2}, duty, speed), 3.7);
}

// A five inch racer's motors behind controllers that lose.
Vehicle Lossy(bool synchronous) {
  Vehicle v = LoadVehicle("mambo-coupled");
  v.motor_constant_N_m_per_A = 0.0055;
  v.armature_resistance_Ohm = 0.06;
  v.esc = {.resistance_Ohm = 0.005,
           .switching_time_s = 1e-7,
           .switching_frequency_Hz = 48000.0,
           .diode_V = synchronous ? 0.0 : 0.7,
           .synchronous = synchronous};
  v.avionics_power_W = 5.0;
  return v;
}

// One motor's current and the battery's share of it, in words of the circuit.
struct OneMotor {
  double motor_A;
  double battery_A;
};
OneMotor AtVoltage(const Vehicle& v, double duty, double speed, double voltage_V) {
  const double diodes_V = v.esc.synchronous ? 0.0 : (1.0 - duty) * v.esc.diode_V;
  double motor_A = (duty * voltage_V - diodes_V - v.motor_constant_N_m_per_A * speed) /
                   (v.armature_resistance_Ohm + v.esc.resistance_Ohm);
  if (!v.esc.synchronous) motor_A = std::max(motor_A, 0.0);
  const double switching =
      duty > 0.0 && duty < 1.0 ? v.esc.switching_time_s * v.esc.switching_frequency_Hz : 0.0;
  return {motor_A, duty * motor_A + switching * std::abs(motor_A)};
}

struct Draw {
  Supply<double> supply;
  PerMotor<double> duty;
  PerMotor<double> speed;
};
// Of motors that drive, brake and stand.
Draw RandomDraw(std::mt19937& engine) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Draw draw{{15.0 + 2.0 * share(engine), 0.05 * share(engine)}, {}, {}};
  for (std::size_t i = 0; i < 4; ++i) {
    draw.duty[i] = share(engine) < 0.1 ? std::round(share(engine)) : share(engine);
    draw.speed[i] = 3000.0 * share(engine);
  }
  return draw;
}

TEST(Powertrain, WithLossesTheVoltageIsTheRootOfTheLoopToo) {
  for (const bool synchronous : {true, false}) {
    const Vehicle v = Lossy(synchronous);
    std::mt19937 engine(kDrawSeed);
    for (int n = 0; n < 500; ++n) {
      const Draw draw = RandomDraw(engine);
      const auto surplus = [&](double voltage_V) {
        double battery_A = v.avionics_power_W / voltage_V;
        for (std::size_t i = 0; i < 4; ++i) {
          battery_A += AtVoltage(v, draw.duty[i], draw.speed[i], voltage_V).battery_A;
        }
        return draw.supply.voltage_V - draw.supply.resistance_Ohm * battery_A - voltage_V;
      };
      const double found_V = LoopVoltage(v, draw.supply, draw.duty, draw.speed);
      // Volts of rounding in currents of up to a thousand ampere.
      ASSERT_NEAR(surplus(found_V), 0.0, 1e-10) << n;
    }
  }
}

// What the battery gives is what turns the rotors, what is heat in windings, transistors and
// diodes, and what the avionics take.
TEST(Powertrain, LossesAreWhereThePowerGoes) {
  for (const bool synchronous : {true, false}) {
    const Vehicle v = Lossy(synchronous);
    std::mt19937 engine(kDrawSeed);
    for (int n = 0; n < 200; ++n) {
      const Draw draw = RandomDraw(engine);
      const double battery_V = LoopVoltage(v, draw.supply, draw.duty, draw.speed);
      PerMotor<double> motor_A;
      double used_W = 0.0;
      double largest_W = 1.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double i_A = motor_A[i] = MotorCurrent(v, draw.duty[i], battery_V, draw.speed[i]);
        ASSERT_NEAR(i_A, AtVoltage(v, draw.duty[i], draw.speed[i], battery_V).motor_A, 1e-9);
        const bool switches = draw.duty[i] > 0.0 && draw.duty[i] < 1.0;
        used_W += v.motor_constant_N_m_per_A * draw.speed[i] * i_A +
                  (v.armature_resistance_Ohm + 0.005) * i_A * i_A +
                  (synchronous ? 0.0 : (1.0 - draw.duty[i]) * 0.7 * i_A) +
                  (switches ? 0.0048 * battery_V * std::abs(i_A) : 0.0);
        largest_W = std::max(largest_W, battery_V * std::abs(i_A));
      }
      ASSERT_NEAR(battery_V * ControllersCurrent(v, draw.duty, motor_A), used_W, 1e-12 * largest_W);
    }
  }
}

TEST(Powertrain, ThroughDiodesNothingFlowsBack) {
  const Vehicle v = Lossy(false);
  const PerMotor<double> duty{0.1, 0.1, 0.1, 0.1};
  const PerMotor<double> speed{2e3, 2e3, 2e3, 2e3};
  const Supply<double> supply{16.0, 0.02};
  const double battery_V = LoopVoltage(v, supply, duty, speed);
  EXPECT_EQ(MotorCurrent(v, 0.1, battery_V, 2e3), 0.0);
  EXPECT_NEAR(battery_V * (16.0 - battery_V) / 0.02, 5.0, 1e-9);  // the avionics alone
  Vehicle charging = Lossy(true);
  EXPECT_GT(LoopVoltage(charging, supply, duty, speed), 16.0);
}

TEST(Powertrain, WithoutLossesTheyChangeNoBit) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  std::mt19937 engine(kDrawSeed);
  for (int n = 0; n < 50; ++n) {
    const Draw draw = RandomDraw(engine);
    const double share = draw.supply.resistance_Ohm * (1.0 / v.armature_resistance_Ohm);
    const auto& d = draw.duty;
    const auto& w = draw.speed;
    const double closed_V =
        (draw.supply.voltage_V + share * v.motor_constant_N_m_per_A *
                                     ((d[0] * w[0] + d[1] * w[1]) + (d[2] * w[2] + d[3] * w[3]))) /
        (1.0 + share * ((d[0] * d[0] + d[1] * d[1]) + (d[2] * d[2] + d[3] * d[3])));
    EXPECT_EQ(LoopVoltage(v, draw.supply, d, w), closed_V);
  }
}

// With no power left the voltage is that of the largest power, not NaN.
TEST(Powertrain, AvionicsThatAskTooMuchGetTheLargestPower) {
  Vehicle v = Lossy(true);
  v.avionics_power_W = 1e4;
  EXPECT_DOUBLE_EQ(LoopVoltage(v, Supply<double>{16.0, 1.0}, {}, {}), 8.0);
}

TEST(Powertrain, WithLossesItCanBeDifferentiated) {
  using Jet = ceres::Jet<double, 10>;  // 4 duties, 4 speeds, voltage and resistance of the supply
  for (const bool synchronous : {true, false}) {
    const Vehicle v = Lossy(synchronous);
    std::mt19937 engine(kDrawSeed);
    int checked = 0;
    for (int n = 0; n < 40; ++n) {
      Draw draw = RandomDraw(engine);
      draw.supply.resistance_Ohm += 0.01;
      const double at_V = LoopVoltage(v, draw.supply, draw.duty, draw.speed);
      // At corners, where a current changes its sign or a duty cycle ends, there is no derivative.
      bool corner = false;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto [motor_A, battery_A] = AtVoltage(v, draw.duty[i], draw.speed[i], at_V);
        corner = corner || draw.duty[i] < 0.05 || draw.duty[i] > 0.95 ||
                 (synchronous && std::abs(motor_A) < 20.0) ||
                 (!synchronous &&
                  std::abs(draw.duty[i] * at_V - v.motor_constant_N_m_per_A * draw.speed[i]) < 2.0);
      }
      if (corner) continue;
      ++checked;
      Supply<Jet> supply{Jet(draw.supply.voltage_V, 8), Jet(draw.supply.resistance_Ohm, 9)};
      PerMotor<Jet> duty;
      PerMotor<Jet> speed;
      for (int i = 0; i < 4; ++i) {
        duty[std::size_t(i)] = Jet(draw.duty[std::size_t(i)], i);
        speed[std::size_t(i)] = Jet(draw.speed[std::size_t(i)], 4 + i);
      }
      const Jet voltage = LoopVoltage(v, supply, duty, speed);
      EXPECT_NEAR(voltage.a, at_V, 1e-12 * at_V);
      for (int k = 0; k < 10; ++k) {
        const auto of = [&](double value) {
          Draw moved = draw;
          const auto i = std::size_t(k % 4);
          (k < 4    ? moved.duty[i]
           : k < 8  ? moved.speed[i]
           : k == 8 ? moved.supply.voltage_V
                    : moved.supply.resistance_Ohm) = value;
          return LoopVoltage(v, moved.supply, moved.duty, moved.speed);
        };
        const auto i = std::size_t(k % 4);
        const double x = k < 4    ? draw.duty[i]
                         : k < 8  ? draw.speed[i]
                         : k == 8 ? draw.supply.voltage_V
                                  : draw.supply.resistance_Ohm;
        const auto slope = test::Ridders(of, x, 1e-3 * std::max(x, 0.1));
        EXPECT_NEAR(voltage.v[k], slope.value, 1e-7 * std::abs(slope.value) + 10 * slope.error)
            << k;
      }
    }
    EXPECT_GT(checked, 3);
  }
}

}  // namespace
}  // namespace lipoid
