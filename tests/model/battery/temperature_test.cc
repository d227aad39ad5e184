#include "model/battery/temperature.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/at_temperature.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_model.h"
#include "model/battery/prediction.h"
#include "model/battery/temperature_range.h"
#include "model/battery/typical_temperature.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr double kReference_K = 298.15;
constexpr double kCold_K = 263.15;

CellParameters<double> CellOfTemperature() {
  CellParameters<double> cell;
  cell.alpha_C = 10000.0;
  cell.beta_per_sqrt_s = 0.15;
  cell.terms = 4;
  cell.series_resistance_Ohm = 0.02;
  cell.branches = {{0.03, 45.0}, {Resistance<double>({0.0, 1.0}, {0.02, 0.01}), 400.0}};
  cell.charge_transfer = {2.0, Resistance<double>({0.0, 1.0}, {0.03, 0.02})};
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.2});
  cell.temperature.emplace();
  cell.temperature->series_J_per_mol = 14e3;
  cell.temperature->branches_J_per_mol = {60e3, 30e3};
  cell.temperature->diffusion_J_per_mol = 45e3;
  cell.temperature->charge_transfer_J_per_mol = 62e3;
  return cell;
}

TEST(ArrheniusFactor, IsOneAtTheReferenceAndTheKnownRatioElsewhere) {
  EXPECT_EQ(ArrheniusFactor(50e3, kReference_K, kReference_K), 1.0);
  // ln f(T1)/f(T2) = E/R (1/T1 - 1/T2), whatever the reference.
  const double ratio = ArrheniusFactor(50e3, 273.15, 310.0) / ArrheniusFactor(50e3, 298.15, 310.0);
  EXPECT_NEAR(std::log(ratio), 50e3 / 8.314462618 * (1.0 / 273.15 - 1.0 / 298.15), 1e-12);
  // The chemist's rule: 53 kJ/mol doubles a rate from 25 to 35 degC, within 2 %.
  EXPECT_NEAR(ArrheniusFactor(53e3, 308.15, 298.15), 0.5, 0.01);
}

TEST(HeatBalance, ApproachesWhereHeatAndCoolingAreEqual) {
  const HeatBalance<double> balance{45.0, 8.0};
  const double ambient_K = 270.0;
  double temperature_K = 280.0;
  double time_s = 0.0;
  for (const double dt_s : {0.01, 3.0, 120.0, 900.0, 1e4}) {
    temperature_K = balance.After(temperature_K, 1.5, ambient_K, dt_s);
    time_s += dt_s;
    const double settled_K = ambient_K + 1.5 * 8.0;
    const double expected_K = settled_K + (280.0 - settled_K) * std::exp(-time_s / (45.0 * 8.0));
    EXPECT_NEAR(temperature_K, expected_K, 20.0 * kEpsilon * 280.0) << time_s;
  }
}

TEST(HeatBalance, KeepsItsEnergy) {
  // What is released is stored or has gone to the surroundings; the cooling is integrated in closed
  // form, of a temperature that is an exponential.
  const HeatBalance<double> balance{45.0, 8.0};
  const double before_K = 265.0;
  const double ambient_K = 273.0;
  const double heat_W = 2.5;
  const double dt_s = 250.0;
  const double after_K = balance.After(before_K, heat_W, ambient_K, dt_s);
  const double tau_s = 45.0 * 8.0;
  const double settled_K = ambient_K + heat_W * 8.0;
  const double cooling_J = ((settled_K - ambient_K) * dt_s +
                            (before_K - settled_K) * tau_s * -std::expm1(-dt_s / tau_s)) /
                           8.0;
  EXPECT_NEAR(heat_W * dt_s, 45.0 * (after_K - before_K) + cooling_J, 1e-10);
}

TEST(Temperature, AtTheReferenceACellIsTheOneWithoutIt) {
  auto cell = CellOfTemperature();
  const CellModel<double> with(cell);
  cell.temperature.reset();
  const CellModel<double> without(cell);
  RecordStepper<double> a(with, Hold::kBackward, with.Relaxed(1.0));
  RecordStepper<double> b(without, Hold::kBackward, without.Relaxed(1.0));
  for (int k = 0; k < 300; ++k) {
    const double current_A = 3.0 * std::sin(0.1 * k) + 1.0;
    a.Row(2.7 * k, current_A);
    b.Row(2.7 * k, current_A);
    // Factors of one change no more than a rounding of each drop.
    ASSERT_NEAR(a.Voltage(), b.Voltage(), 64.0 * kEpsilon) << k;
  }
}

TEST(Temperature, ScalesEachQuantityByItsOwnFactor) {
  // At a constant temperature the cell is one without the term, of scaled parameters.
  const auto cell = CellOfTemperature();
  const TemperatureDependence<double>& term = *cell.temperature;
  const auto f = [&](double energy) {
    return std::exp(energy / 8.314462618 * (1.0 / kCold_K - 1.0 / kReference_K));
  };
  auto cold = cell;
  cold.temperature.reset();
  cold.series_resistance_Ohm = 0.02 * f(term.series_J_per_mol);
  cold.beta_per_sqrt_s = 0.15 / std::sqrt(f(term.diffusion_J_per_mol));
  cold.branches = {{0.03 * f(60e3), 45.0},
                   {Resistance<double>({0.0, 1.0}, {0.02 * f(30e3), 0.01 * f(30e3)}), 400.0}};
  const double ratio = kCold_K / kReference_K;
  const double factor = f(62e3);
  cold.charge_transfer = {
      2.0 / factor, Resistance<double>({0.0, 1.0}, {0.03 * ratio * factor, 0.02 * ratio * factor})};
  const CellModel<double> model(cell);
  const CellModel<double> expected(cold);
  auto start = model.Relaxed(1.0);
  start.temperature_K = kCold_K;
  RecordStepper<double> a(model, Hold::kBackward, start);
  RecordStepper<double> b(expected, Hold::kBackward, expected.Relaxed(1.0));
  double largest_V = 0.0;
  for (int k = 0; k < 400; ++k) {
    const double current_A = k % 40 < 25 ? 4.0 : k % 40 < 30 ? -1.0 : 0.0;
    a.Row(3.1 * k, current_A);
    b.Row(3.1 * k, current_A);
    ASSERT_NEAR(a.Voltage(), b.Voltage(), 1e-12) << k;
    largest_V = std::max(largest_V, 4.2 - a.Voltage());
  }
  EXPECT_GT(largest_V, 0.5) << "the cold costs something";
}

TEST(Temperature, EntropyMovesTheOpenCircuitVoltageAlone) {
  auto cell = CellOfTemperature();
  cell.temperature->entropy = EntropySlope<double>{{0.0, 1.0}, {-4e-4, 2e-4}};
  const CellModel<double> model(cell);
  auto state = model.Relaxed(0.75);
  const double warm_V = model.Voltage(state, 0.0);
  state.temperature_K = kReference_K - 20.0;
  // -4e-4 + 0.75 * 6e-4 = 5e-5 V/K.
  EXPECT_NEAR(model.Voltage(state, 0.0) - warm_V, -20.0 * 5e-5, 8.0 * kEpsilon * 4.2);
  EXPECT_EQ(model.Voltage(state, 0.0), model.OpenCircuit(state, 0.0));
}

// The energy of the cell is the integral of v_oc over the charge that left it: what it loses is
// electrical work or heat, at every instant, and the heat is stored or carried away.
class TemperatureWithHysteresis : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Of, TemperatureWithHysteresis, testing::Values(0.0, 0.05));

TEST_P(TemperatureWithHysteresis, EnergyIn_IsHeatElectricalAndStored) {
  auto cell = CellOfTemperature();
  if (GetParam() > 0.0) {
    cell.hysteresis.emplace();
    cell.hysteresis->half_V = {GetParam()};
    cell.hysteresis->folds = 20.0;
  }
  cell.temperature->heat = HeatBalance<double>{40.0, 1e9};  // it keeps its heat
  const CellModel<double> model(cell);
  auto state = model.Relaxed(1.0);
  state.temperature_K = state.ambient_K = 268.15;
  double electrical_J = 0.0;
  const double dt_s = 0.02;
  double voltage_V = 0.0;
  typename CellModel<double>::Step step;
  for (int k = 0; k < 100'000; ++k) {
    const double current_A = k < 60'000 ? 5.0 : k < 80'000 ? 0.0 : -2.0;
    const double before_V = model.Voltage(state, current_A);
    model.MakeStep(dt_s, state.temperature_K, step);
    model.Advance(state, current_A, step);
    voltage_V = model.Voltage(state, current_A);
    electrical_J += 0.5 * (before_V + voltage_V) * current_A * dt_s;
  }
  const double gone = state.delivered_C / cell.alpha_C;
  const double stored_J = cell.alpha_C * (4.2 * gone - 0.5 * 1.2 * gone * gone);
  const double heat_J = 40.0 * (state.temperature_K - 268.15);
  EXPECT_GT(heat_J, 500.0);
  // The trapezoid rule of both powers over 20 ms: they bend with the fastest mode, 1/s.
  EXPECT_NEAR(stored_J, electrical_J + heat_J, 1e-4 * heat_J);
}

TEST(Temperature, ReversibleHeatIsThatOfTheEntropicSlope) {
  auto cell = CellOfTemperature();
  cell.temperature->entropy = EntropySlope<double>{{}, {3e-4}};
  const CellModel<double> with(cell);
  cell.temperature->entropy->reversible_heat = false;
  const CellModel<double> without(cell);
  auto state = with.Relaxed(0.6);
  state.temperature_K = 280.0;
  // A discharge cools where v_oc rises with the temperature, a charge warms: -i T dv_oc/dT.
  for (const double current_A : {3.0, -2.0}) {
    EXPECT_NEAR(with.Heat(state, current_A) - without.Heat(state, current_A),
                -current_A * 280.0 * 3e-4,
                1e-14);
    EXPECT_EQ(with.Voltage(state, current_A), without.Voltage(state, current_A));
  }
}

TEST(Temperature, PredictedFollowsTheHeatOfAResistance) {
  // A cell of a resistance alone: the heat is i² r(T), and at energy zero the closed form holds.
  CellParameters<double> plain;
  plain.alpha_C = 36000.0;
  plain.diffusion = false;
  plain.series_resistance_Ohm = 0.05;
  plain.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.2});
  plain.temperature.emplace();
  plain.temperature->heat = HeatBalance<double>{40.0, 10.0};
  const CellModel<double> model(plain);
  auto state = StartAmong(model, 1.0, {.ambient_degC = -10.0});
  EXPECT_EQ(state.temperature_K, 263.15);
  for (int k = 0; k < 200; ++k) model.Advance(state, 4.0, model.MakeStep(5.0));
  const double rise_K = 16.0 * 0.05 * 10.0 * -std::expm1(-1000.0 / 400.0);
  // v_oc less v_b, both near 4 V, has their roundings.
  EXPECT_NEAR(state.temperature_K, 263.15 + rise_K, 1e-10);
}

TEST(Temperature, BeyondWhatWasSeenItIsExtrapolated) {
  Cell cell;
  cell.name = "a";
  EXPECT_EQ(DoubtAboutTemperature(cell, -40.0, 60.0), "");  // knows no temperature
  cell.temperature.emplace();
  EXPECT_EQ(DoubtAboutTemperature(cell, -40.0, 60.0), "");  // and where it was seen
  cell.temperature_seen = {.coldest_degC = 0.0, .warmest_degC = 30.0};
  EXPECT_EQ(DoubtAboutTemperature(cell, -5.0, 35.0), "");
  EXPECT_EQ(
      DoubtAboutTemperature(cell, -20.0, 25.0),
      "a was identified from logs between 0 and 30 degC: at -20 degC its resistances and diffusion "
      "are extrapolated, and no interval counts that");
  EXPECT_NE(DoubtAboutTemperature(cell, 20.0, 40.0).find("at 40 degC"), std::string::npos);
  EXPECT_NE(DoubtAboutTemperature(cell, -10.0, 40.0).find("at -10 and 40 degC"), std::string::npos);
}

TEST(Temperature, TypicalValuesAreMarkedAndScaleWithTheCell) {
  Cell cell;
  cell.capacity_Ah = 0.6;
  cell.branches = {{Resistance<double>(0.03), 45.0, {}}};
  cell.self_heating = Cell::SelfHeating{300.0, 1e-3};
  const Cell small = WithTypicalTemperature(cell);
  EXPECT_TRUE(small.temperature_assumed);
  EXPECT_FALSE(small.self_heating);
  EXPECT_EQ(small.temperature->branches_J_per_mol.size(), 1U);
  // 0.6 Ah at 3.7 V and 150 Wh/kg are 14.8 g, of 1 J/(g K).
  EXPECT_NEAR(small.temperature->heat->heat_capacity_J_per_K, 14.8, 1e-12);
  cell.capacity_Ah =
      8.0 * 0.6;  // twice as long each way: eight times the mass, four times the skin
  const Cell large = WithTypicalTemperature(cell);
  EXPECT_NEAR(large.temperature->heat->heat_capacity_J_per_K, 8.0 * 14.8, 1e-11);
  EXPECT_NEAR(small.temperature->heat->thermal_resistance_K_per_W /
                  large.temperature->heat->thermal_resistance_K_per_W,
              4.0,
              1e-12);
}

// What its logs were at is the temperature at which the numbers of its file hold.
TEST(Temperature, TypicalValuesAreAboutTheTemperatureOfTheLogs) {
  Cell cell;
  cell.capacity_Ah = 0.6;
  EXPECT_EQ(WithTypicalTemperature(cell).temperature->reference_K, 298.15);
  cell.reference_degC = 40.0;
  const Cell warm = WithTypicalTemperature(cell);
  EXPECT_EQ(warm.temperature->reference_K, 313.15);
  EXPECT_FALSE(warm.reference_degC);
}

constexpr int kTemperatureUnknowns = 6;
const char* const kTemperatureNames[kTemperatureUnknowns] = {
    "E_s", "E_1", "E_d", "E_ct", "heat capacity", "thermal resistance"};

template <class T>
T LastVoltageOfTemperature(const std::vector<T>& x) {
  CellParameters<T> cell;
  cell.alpha_C = T(10000.0);
  cell.beta_per_sqrt_s = T(0.15);
  cell.terms = 4;
  cell.series_resistance_Ohm = T(0.02);
  cell.branches = {{T(0.03), T(45.0)}};
  cell.charge_transfer = ChargeTransfer<T>{T(2.0), T(0.02)};
  cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(-1.0, 2.0, {3.6, 0.5, -0.06});
  cell.temperature.emplace();
  cell.temperature->series_J_per_mol = x[0];
  cell.temperature->branches_J_per_mol = {x[1]};
  cell.temperature->diffusion_J_per_mol = x[2];
  cell.temperature->charge_transfer_J_per_mol = x[3];
  cell.temperature->heat = HeatBalance<T>{x[4], x[5]};
  const CellModel<T> model(cell);
  auto state = model.Relaxed(T(1.0));
  state.temperature_K = state.ambient_K = T(260.0);
  RecordStepper<T> stepper(model, Hold::kBackward, state);
  for (int k = 0; k < 60; ++k) stepper.Row(7.0 * k, T(k % 3 == 0 ? 6.0 : -0.3));
  return stepper.Voltage();
}

TEST(Temperature, DerivativesAreThoseOfRiddersDifferences) {
  using Jet = ceres::Jet<double, kTemperatureUnknowns>;
  const std::vector<double> at = {14e3, 60e3, 45e3, 62e3, 40.0, 10.0};
  std::vector<Jet> jets;
  for (int k = 0; k < kTemperatureUnknowns; ++k) jets.emplace_back(at[k], k);
  const Jet voltage = LastVoltageOfTemperature(jets);
  EXPECT_NEAR(voltage.a, LastVoltageOfTemperature(at), 16.0 * kEpsilon * voltage.a);
  for (int k = 0; k < kTemperatureUnknowns; ++k) {
    const auto f = [&](double x) {
      auto moved = at;
      moved[k] = x;
      return LastVoltageOfTemperature(moved);
    };
    const auto difference = test::Ridders(f, at[k], 0.1 * at[k]);
    // As in cell_model_test.cc: rounding of a 4 V value over a step of 1 % of the parameter.
    const double tolerance = 1e-8 * std::abs(difference.value) + 1e3 * kEpsilon / at[k];
    EXPECT_NEAR(voltage.v[k], difference.value, tolerance) << kTemperatureNames[k];
    EXPECT_NE(voltage.v[k], 0.0) << kTemperatureNames[k];
  }
}

TEST(AtOneTemperature, ShowsTheVoltagesOfTheCellAtThatTemperature) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion->beta_per_sqrt_s = 0.15;
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.12, 0.08});
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}, {Resistance<double>(0.02), 400.0, {}}};
  cell.charge_transfer = {2.0, Resistance<double>({0.0, 1.0}, {0.03, 0.02})};
  cell.temperature.emplace();
  cell.temperature->series_J_per_mol = 14e3;
  cell.temperature->branches_J_per_mol = {60e3, 30e3};
  cell.temperature->diffusion_J_per_mol = 45e3;
  cell.temperature->charge_transfer_J_per_mol = 62e3;
  cell.temperature->entropy = EntropySlope<double>{{0.2, 0.55, 0.9}, {-3e-4, 1e-4, 2e-4}};
  std::vector<double> time_s;
  std::vector<double> current_A;
  for (int k = 0; k < 300; ++k) {
    time_s.push_back(10.0 * k);
    current_A.push_back(k % 30 < 10 ? 1.2 : -0.1);
  }
  for (const double at_degC : {-10.0, 25.0, 40.0}) {
    const Cell there = AtOneTemperature(cell, at_degC);
    EXPECT_FALSE(there.temperature);
    EXPECT_NEAR(
        *there.branches[0].capacitance_F * there.branches[0].resistance_Ohm(0.5), 45.0, 1e-12);
    const auto expected =
        Predict(cell, time_s, current_A, Hold::kBackward, 1.0, {.ambient_degC = at_degC}).voltage_V;
    const auto voltage_V = Predict(there, time_s, current_A).voltage_V;
    for (std::size_t k = 0; k < time_s.size(); ++k)  // sums of some ten terms of 4 V
      ASSERT_NEAR(voltage_V[k], expected[k], 100.0 * 4.0 * kEpsilon) << at_degC << " " << k;
  }
}

}  // namespace
}  // namespace lipoid
