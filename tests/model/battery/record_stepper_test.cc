#include "model/battery/record_stepper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/core/errors.h"
#include "model/core/special_values.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

// Counts charge and drops r_s i: everything can be done by hand.
CellParameters<double> PlainParameters() {
  CellParameters<double> cell;
  cell.alpha_C = 1024.0;
  cell.diffusion = false;
  cell.series_resistance_Ohm = 0.125;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  return cell;
}

CellParameters<double> FullCell() {
  CellParameters<double> cell = PlainParameters();
  cell.diffusion = true;
  cell.beta_per_sqrt_s = 0.2;
  cell.branches = {{0.03, 45.0}, {0.012, 0.7}};
  return cell;
}

struct Row {
  double time_s;
  double current_A;
};

std::vector<double> Voltages(const CellModel<double>& model,
                             Hold hold,
                             const std::vector<Row>& rows) {
  RecordStepper<double> stepper(model, hold, model.Relaxed(1.0));
  std::vector<double> voltage_V;
  for (const Row& row : rows) {
    stepper.Row(row.time_s, row.current_A);
    voltage_V.push_back(stepper.Voltage());
  }
  return voltage_V;
}

// What a row of a log may be that has rows where the current changes alone: ten minutes at 1C. The resistance of a
// branch is a table, and would be that of the row's beginning.
TEST(RecordStepper, ALongRowEndsWhereShortRowsDo) {
  CellParameters<double> cell = FullCell();
  cell.alpha_C = 3600.0;
  cell.branches[0].resistance_Ohm = {{0.0, 0.5, 1.0}, {0.15, 0.03, 0.06}};
  const CellModel<double> model(cell);
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const auto after = [&](int rows) {
      RecordStepper<double> stepper(model, hold, model.Relaxed(1.0));
      for (int k = 0; k <= rows; ++k) stepper.Row(600.0 / rows * k, 1.0);
      return stepper.Voltage();
    };
    // Parts of 6 s against rows of 1 s; in one step the branch alone ends 9 mV away.
    EXPECT_NEAR(after(1), after(600), 2e-4);
  }
}

CellParameters<double> ColdCell() {
  CellParameters<double> cell = FullCell();
  cell.alpha_C = 3600.0;
  cell.series_resistance_Ohm = 0.05;
  cell.branches = {{0.05, 60.0}};
  TemperatureDependence<double>& term = cell.temperature.emplace();
  term.series_J_per_mol = 30e3;
  term.branches_J_per_mol = {40e3};
  term.diffusion_J_per_mol = 25e3;
  term.heat =
      HeatBalance<double>{.heat_capacity_J_per_K = 15.0, .thermal_resistance_K_per_W = 10.0};
  return cell;
}

CellModel<double>::State Cold(const CellModel<double>& model) {
  auto state = model.Relaxed(1.0);
  state.ambient_K = state.temperature_K = 263.15;
  return state;
}

// From one row to the next it warms by up to 12 K. A step at the temperature of its beginning or its end halves its
// error with the rows; half-way it is a quarter.
TEST(RecordStepper, AColdCellIsSteppedHalfWayBetweenTheRows) {
  const CellModel<double> model(ColdCell());
  const auto after_V = [&](int rows) {
    RecordStepper<double> stepper(model, Hold::kBackward, Cold(model));
    for (int k = 0; k <= rows; ++k) stepper.Row(480.0 / rows * k, 4.0);
    return stepper.Voltage();
  };
  const double exact_V = after_V(4800);
  const double off_60s_V = std::abs(after_V(8) - exact_V);
  const double off_30s_V = std::abs(after_V(16) - exact_V);
  EXPECT_GT(off_60s_V, 1e-4);
  EXPECT_LT(off_60s_V, 0.01);
  EXPECT_LT(off_30s_V, off_60s_V / 3.5);
}

// So that a log that the cell predicted, with its temperatures, is one that it fits.
TEST(RecordStepper, PredictedTemperaturesAreThoseThatWouldBeMeasured) {
  CellParameters<double> cell = ColdCell();
  cell.branches[0].resistance_Ohm = {{0.0, 0.5, 1.0}, {0.15, 0.03, 0.06}};
  const CellModel<double> model(cell);
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    for (const double row_s : {0.01, 1.0, 60.0, 3600.0}) {
      RecordStepper<double> predicts(model, hold, Cold(model));
      auto state = Cold(model);
      state.ambient_K = kNaN;
      RecordStepper<double> measures(model, hold, state);
      for (int k = 0; k < 20; ++k) {
        const double current_A = (k % 4 < 2 ? 3000.0 : -400.0) / std::max(row_s, 600.0);
        predicts.Row(row_s * k, current_A);
        measures.Row(row_s * k, current_A, predicts.state().temperature_K);
        ASSERT_NEAR(predicts.Voltage(), measures.Voltage(), 1e-8) << row_s << " " << k;
      }
      EXPECT_NE(predicts.state().temperature_K, 263.15);
    }
  }
}

// Powers of two throughout: exact.
TEST(RecordStepper, BackwardHoldMovesTheCurrentOfTheRowSinceTheRowBefore) {
  const CellModel<double> model(PlainParameters());
  const auto voltage_V =
      Voltages(model, Hold::kBackward, {{0.0, 2.0}, {64.0, 4.0}, {96.0, 0.0}, {128.0, -8.0}});
  EXPECT_EQ(voltage_V[0], 4.0 - 0.125 * 2.0);           // no charge yet, but the drop
  EXPECT_EQ(voltage_V[1], 4.0 - 256.0 / 1024.0 - 0.5);  // 4 A for 64 s
  EXPECT_EQ(voltage_V[2], 4.0 - 256.0 / 1024.0);
  EXPECT_EQ(voltage_V[3], 4.0 + 1.0);  // 8 A back for 32 s
}

TEST(RecordStepper, ForwardHoldMovesTheCurrentOfTheRowUntilTheNext) {
  const CellModel<double> model(PlainParameters());
  const auto voltage_V =
      Voltages(model, Hold::kForward, {{0.0, 2.0}, {64.0, 4.0}, {96.0, 0.0}, {128.0, -8.0}});
  EXPECT_EQ(voltage_V[0], 4.0 - 0.125 * 2.0);
  EXPECT_EQ(voltage_V[1], 4.0 - 128.0 / 1024.0 - 0.5);  // 2 A for 64 s
  EXPECT_EQ(voltage_V[2], 4.0 - 256.0 / 1024.0);        // and 4 A for 32 s
  EXPECT_EQ(voltage_V[3], 4.0 - 256.0 / 1024.0 + 1.0);  // the charging has not begun to move charge
}

// Shifted by a row the two conventions are one: backward with i[k] moves what forward moves with
// i[k-1].
TEST(RecordStepper, HoldsAreEachOtherShiftedByOneRow) {
  const CellModel<double> model(FullCell());
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  RecordStepper<double> backward(model, Hold::kBackward, model.Relaxed(1.0));
  RecordStepper<double> forward(model, Hold::kForward, model.Relaxed(1.0));
  double time_s = 0.0;
  double next_A = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double flowed_A = next_A;
    next_A = 4.0 * uniform(engine) - 1.0;
    backward.Row(time_s, flowed_A);
    forward.Row(time_s, next_A);
    ASSERT_EQ(backward.state().delivered_C, forward.state().delivered_C) << k;
    ASSERT_EQ(backward.state().unavailable_C, forward.state().unavailable_C) << k;
    ASSERT_EQ(backward.state().branch_V, forward.state().branch_V) << k;
    time_s += 30.0 * uniform(engine) + 0.001;
  }
  EXPECT_GT(backward.state().delivered_C, 100.0);
}

// A stepper that starts from another's state with the row where that one stopped goes on as if
// nothing had happened. Quarters of a second are exact, so that both meet the same intervals: bit
// for bit.
TEST(RecordStepper, SplitRecordIsTheWholeRecord) {
  const CellModel<double> model(FullCell());
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    std::vector<Row> rows;
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> current(-1.0, 3.0);
    std::uniform_int_distribution<int> quarters(1, 40);
    for (double time_s = 0.0; rows.size() < 300; time_s += 0.25 * quarters(engine)) {
      rows.push_back({time_s, current(engine)});
    }
    const auto whole_V = Voltages(model, hold, rows);
    for (const std::size_t cut : {std::size_t{1}, std::size_t{100}, std::size_t{299}}) {
      RecordStepper<double> first(model, hold, model.Relaxed(1.0));
      for (std::size_t k = 0; k < cut; ++k) first.Row(rows[k].time_s, rows[k].current_A);
      RecordStepper<double> second(model, hold, first.state());
      second.Row(rows[cut - 1].time_s, rows[cut - 1].current_A);
      for (std::size_t k = cut; k < rows.size(); ++k) {
        second.Row(rows[k].time_s, rows[k].current_A);
        ASSERT_EQ(second.Voltage(), whole_V[k]) << "cut at " << cut << ", row " << k;
      }
    }
  }
}

// Rows in between under the same current add nothing and take nothing.
TEST(RecordStepper, FinerSamplingOfTheSameCurrentGivesTheSameVoltages) {
  const CellModel<double> model(FullCell());
  RecordStepper<double> coarse(model, Hold::kBackward, model.Relaxed(1.0));
  RecordStepper<double> fine(model, Hold::kBackward, model.Relaxed(1.0));
  coarse.Row(0.0, 0.0);
  fine.Row(0.0, 0.0);
  for (int minute = 1; minute <= 10; ++minute) {
    const double current_A = minute % 3 == 0 ? 0.0 : 0.4 * minute;
    coarse.Row(60.0 * minute, current_A);
    for (int k = 1; k <= 6000; ++k) fine.Row(60.0 * (minute - 1) + 0.01 * k, current_A);
    // 6e4 additions of charge, each rounded at 1e3 C; the slope of v_oc is 1 V per 1024 C.
    EXPECT_NEAR(fine.Voltage(), coarse.Voltage(), 6e4 * kEpsilon) << minute;
  }
  EXPECT_GT(coarse.state().delivered_C, 500.0);
}

TEST(RecordStepper, TimeThatDoesNotIncreaseBreaksThePrecondition) {
  const CellModel<double> model(PlainParameters());
  RecordStepper<double> stepper(model, Hold::kBackward, model.Relaxed(1.0));
  stepper.Row(1.0, 0.0);
  EXPECT_THROW(stepper.Row(1.0, 0.0), PreconditionError);
  EXPECT_THROW(stepper.Row(0.5, 0.0), PreconditionError);
  EXPECT_THROW(stepper.Row(std::nan(""), 0.0), PreconditionError);
}

TEST(IntervalCache, ComputesOncePerLengthWhateverTheRoundingOfTheStamps) {
  IntervalCache<double> cache;
  int made = 0;
  double before_s = 0.0;
  for (int k = 1; k <= 2'000'000; ++k) {  // 10 ms for five and a half hours
    const double time_s = 0.01 * k;
    const double dt_s = time_s - before_s;
    const double value = cache.Get(dt_s, time_s, [&](double dt, double& out) {
      ++made;
      out = dt;
    });
    ASSERT_NEAR(value, dt_s, 4.0 * kEpsilon * time_s) << k;
    before_s = time_s;
  }
  EXPECT_LE(made, 2) << "one slot, or two where the lengths straddle a boundary";
}

TEST(IntervalCache, NeverConfusesLengthsThatDiffer) {
  IntervalCache<double> cache;
  std::mt19937 engine(6);
  std::uniform_real_distribution<double> logarithm(std::log(1e-6), std::log(1e7));
  std::vector<double> lengths(5000);  // far more than there are slots
  for (double& length : lengths) length = std::exp(logarithm(engine));
  std::uniform_int_distribution<std::size_t> pick(0, lengths.size() - 1);
  for (int k = 0; k < 50'000; ++k) {
    const double dt_s = lengths[pick(engine)];
    const double value = cache.Get(dt_s, dt_s, [](double dt, double& out) { out = dt; });
    ASSERT_NEAR(value, dt_s, 4.0 * kEpsilon * dt_s);
  }
}

// A picosecond is far more than the rounding of a stamp of 100 s (4 eps t = 9e-14 s).
TEST(IntervalCache, TellsApartLengthsThatDifferByMoreThanRounding) {
  IntervalCache<double> cache;
  const auto get = [&](double dt_s) {
    return cache.Get(dt_s, 100.0, [](double dt, double& out) { out = dt; });
  };
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(get(0.01 + 1e-12), 0.01 + 1e-12);
    EXPECT_EQ(get(0.01), 0.01);
  }
  EXPECT_EQ(get(0.01 + 2e-14), 0.01) << "within the rounding: shared";
}

// Alternating lengths, as of a log of pulses, stay in their slots.
TEST(IntervalCache, KeepsSeveralLengthsAtOnce) {
  IntervalCache<double> cache;
  int made = 0;
  const double lengths[] = {0.01, 1.0, 60.0, 0.5};
  for (int k = 0; k < 400; ++k) {
    cache.Get(lengths[k % 4], 100.0, [&](double dt, double& out) {
      ++made;
      out = dt;
    });
  }
  EXPECT_EQ(made, 4);
}

// Irregular stamps: the stepper equals a model whose steps are computed one by one.
TEST(RecordStepper, IrregularSamplingEqualsStepsComputedOneByOne) {
  const CellModel<double> model(FullCell());
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> dt(0.001, 40.0);
  RecordStepper<double> stepper(model, Hold::kBackward, model.Relaxed(1.0));
  auto state = model.Relaxed(1.0);
  stepper.Row(0.0, 0.0);
  double time_s = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double next_s = time_s + dt(engine);
    const double current_A = k % 7 < 3 ? 0.05 : -0.01;
    stepper.Row(next_s, current_A);
    model.Advance(state, current_A, model.MakeStep(next_s - time_s));
    time_s = next_s;
    ASSERT_EQ(stepper.Voltage(), model.Voltage(state, current_A)) << k;
  }
}

}  // namespace
}  // namespace lipoid
