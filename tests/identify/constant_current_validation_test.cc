#include "identify/constant_current_validation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "identify/fit_quality.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr double kSampling_s = 1.0;

using test::Truth;

// A minute of rest, the discharge down to the first row at cut-off, and ten rows of rest.
LoadedLog Discharged(const Cell& cell, double current_A, double initial_soc = 1.0) {
  Record record;
  record.file = "/somewhere/cc.csv";
  const auto rows = static_cast<int>(60.0 + 1.2 * 1353.6 / current_A);
  for (int k = 0; k < rows; ++k) {
    record.time_s.push_back(kSampling_s * k);
    record.current_A.push_back(k <= 60 ? 0.0 : current_A);
  }
  Cell one = cell;
  one.series = one.parallel = 1;
  const auto predict = [&] {
    return Predict(one, record.time_s, record.current_A, Hold::kBackward, initial_soc).voltage_V;
  };
  record.voltage_V = predict();
  std::size_t last = 61;
  while (record.voltage_V[last] > cell.cutoff_V) ++last;
  for (std::size_t k = last + 1; k < record.size(); ++k) record.current_A[k] = 0.0;
  for (auto* column : {&record.time_s, &record.current_A}) column->resize(last + 11);
  record.voltage_V = predict();
  LoadedLog log;
  log.entry.kind = LogKind::kConstantCurrent;
  log.entry.file = "cc.csv";
  log.entry.initial_soc = initial_soc;
  log.log.record = std::move(record);
  return log;
}

TEST(ConstantCurrentValidation, FindsNoErrorInTheLogsOfTheSameCell) {
  Cell pack = Truth();
  pack.series = 4;
  pack.parallel = 2;  // logs are those of one cell
  const auto errors = ValidateConstantCurrents(
      pack, {Discharged(pack, 0.6), Discharged(pack, 3.0), Discharged(pack, 1.2, 0.8)});
  ASSERT_EQ(errors.size(), 3U);
  const double currents_A[] = {0.6, 3.0, 1.2};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(errors[k].voltage.file, "cc.csv");
    EXPECT_EQ(errors[k].voltage.all.rmse, 0.0);
    EXPECT_GT(errors[k].voltage.all.rows, errors[k].voltage.above_10_soc.rows);
    EXPECT_NEAR(errors[k].current_A, currents_A[k], 1e-9);
    // The crossing of a log is interpolated between its rows, on a straight line.
    EXPECT_NEAR(errors[k].predicted_s, errors[k].measured_s, 0.02 * kSampling_s);
    EXPECT_NEAR(errors[k].error_percent,
                100.0 * std::abs(errors[k].predicted_s / errors[k].measured_s - 1.0),
                1e-12);
  }
  EXPECT_GT(errors[0].measured_s, 5.0 * errors[1].measured_s);
}

// A resistance that is too large: the voltage is lower by what it drops, and the end comes where
// the voltage of the truth is still higher by as much.
TEST(ConstantCurrentValidation, AnErrorThatWasPutInIsFound) {
  const Cell truth = Truth();
  Cell wrong = truth;
  wrong.series_resistance_Ohm = 0.1314 + 0.01;
  const LoadedLog log = Discharged(truth, 3.0);
  const auto errors = ValidateConstantCurrents(wrong, {log});
  // All rows but those at rest, of which there are 61 and 10.
  const double rows = static_cast<double>(log.log.record.size());
  EXPECT_NEAR(errors[0].voltage.all.rmse, 0.03 * std::sqrt((rows - 71.0) / rows), 1e-12);
  Cell later = truth;
  later.cutoff_V = truth.cutoff_V + 0.03;
  const LoadedLog ends_there = Discharged(later, 3.0);
  const auto higher = ValidateConstantCurrents(later, {ends_there});
  EXPECT_NEAR(errors[0].predicted_s, higher[0].predicted_s, 1e-9);
  EXPECT_LT(errors[0].predicted_s, errors[0].measured_s - 1.0);
  EXPECT_GT(errors[0].error_percent, 0.3);
}

// A heat balance that is wrong says nothing of a discharge whose temperature was measured.
TEST(ConstantCurrentValidation, AMeasuredTemperatureIsFollowed) {
  Cell truth = Truth();
  Cell::Temperature& term = truth.temperature.emplace();
  term.series_J_per_mol = 25e3;
  term.branches_J_per_mol.assign(truth.branches.size(), 40e3);
  term.diffusion_J_per_mol = 40e3;
  term.heat = HeatBalance<double>{15.0, 20.0};
  LoadedLog log = Discharged(truth, 3.0);
  Record& record = log.log.record;
  const Prediction at =
      Predict(truth, record.time_s, record.current_A, record.hold, 1.0, {.ambient_degC = 0.0});
  record.voltage_V = at.voltage_V;
  record.temperature_degC = at.temperature_degC;
  ASSERT_GT(record.temperature_degC.back(), 5.0);
  Cell wrong = truth;
  wrong.temperature->heat = HeatBalance<double>{1500.0, 20.0};
  log.entry.ambient_degC = 0.0;
  std::size_t end = 61;
  while (end < record.size() && record.voltage_V[end] > truth.cutoff_V) ++end;
  ASSERT_LT(end, record.size());  // colder than the discharge of 25 degC whose current it has
  for (std::size_t k = end + 1; k < record.size(); ++k) record.current_A[k] = 0.0;
  const auto errors = ValidateConstantCurrents(wrong, {log});
  EXPECT_NEAR(errors[0].predicted_s, errors[0].measured_s, 0.2);
  // Without the thermometer the cell stays cold, and ends earlier.
  record.temperature_degC = {};
  const auto cold = ValidateConstantCurrents(wrong, {log});
  EXPECT_LT(cold[0].predicted_s, 0.98 * cold[0].measured_s);
}

TEST(ConstantCurrentValidation, ACellThatNeverEndsHasNoTime) {
  const LoadedLog log = Discharged(Truth(), 3.0);
  Cell endless = Truth();
  endless.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.0, 4.0});
  const auto errors = ValidateConstantCurrents(endless, {log});
  EXPECT_TRUE(std::isnan(errors[0].predicted_s));
  EXPECT_TRUE(std::isnan(errors[0].error_percent));
  EXPECT_TRUE(std::isfinite(errors[0].voltage.all.rmse));
}

// A cold cell dips to its cut-off and recovers while it warms: whether a prediction that is off by millivolts gets
// there, too, says nothing of it.
TEST(ConstantCurrentValidation, ADipThatComesBackIsNoEnd) {
  LoadedLog log = Discharged(Truth(), 3.0);
  Cell endless = Truth();
  endless.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.0, 4.0});
  const auto empty = ValidateConstantCurrents(endless, {log});
  EXPECT_FALSE(empty[0].comes_back);
  EXPECT_EQ(JudgeFit(endless, {}, empty, 0.0, 0.0).grade, FitGrade::kPoor);
  Record& record = log.log.record;
  std::vector<double> current_A = record.current_A.ToVector();
  std::vector<double> voltage_V = record.voltage_V.ToVector();
  for (std::size_t k = record.size() - 10; k < record.size(); ++k) {
    current_A[k] = 3.0;
    voltage_V[k] = endless.cutoff_V + 0.1;
  }
  record.current_A = std::move(current_A);
  record.voltage_V = std::move(voltage_V);
  const auto dips = ValidateConstantCurrents(endless, {log});
  EXPECT_TRUE(dips[0].comes_back);
  for (const std::string& reason : JudgeFit(endless, {}, dips, 0.0, 0.0).reasons)
    EXPECT_EQ(reason.find("never reaches the cut-off"), std::string::npos) << reason;
}

TEST(ConstantCurrentValidation, TakesOnlyLogsOfItsKindAndTimesThatAreKnown) {
  LoadedLog pulses = Discharged(Truth(), 3.0);
  pulses.entry.kind = LogKind::kPulses;
  const std::vector<LoadedLog> logs{pulses, Discharged(Truth(), 3.0)};
  const auto errors = ValidateConstantCurrents(Truth(), logs, {{"cc.csv", 3.0, 250.0}});
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].measured_s, 250.0);
  EXPECT_THROW((void)ValidateConstantCurrents(Truth(), logs, {{"a", 3, 250}, {"b", 3, 250}}),
               PreconditionError);
  EXPECT_TRUE(ValidateConstantCurrents(Truth(), {pulses}).empty());
}

TEST(ConstantCurrentValidation, RefusesALogThatEndsAboveTheCutOff) {
  Cell deeper = Truth();
  deeper.cutoff_V = 2.5;
  const auto message = test::MessageOf<LoadError>(
      [&] { (void)ValidateConstantCurrents(deeper, {Discharged(Truth(), 3.0)}); });
  EXPECT_NE(message.find("2.5 V"), std::string::npos) << message;
}

}  // namespace
}  // namespace lipoid
