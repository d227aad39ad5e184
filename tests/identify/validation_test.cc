#include "identify/validation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/prediction.h"
#include "model/core/special_values.h"
#include "tests/support/charge_counter.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::ChargeCounter;
using test::kEpsilon;

// From A = 1 to -0.02 in steps of 0.02, measured 1 % above what the cell says, and twice that below
// A = 0.1 (0.09 leaves the rounding of 0.1 aside).
Record Discharge() {
  Record record;
  record.file = "log.csv";
  for (int k = 0; k <= 51; ++k) {
    const double soc = 1.0 - 0.02 * k;
    record.time_s.push_back(20.0 * k);
    record.current_A.push_back(1.0);
    record.voltage_V.push_back((3.0 + soc) / (soc > 0.09 ? 0.99 : 0.98));
  }
  return record;
}

TEST(Validation, SaysTheErrorsOfAllRowsAndOfThoseAboveTenPercent) {
  const LogErrors errors = Validate(ChargeCounter(), Discharge());
  EXPECT_EQ(errors.file, "log.csv");
  EXPECT_EQ(errors.all.rows, 52U);
  EXPECT_EQ(errors.rows_outside_curve, 1U);
  EXPECT_NEAR(errors.all.max_error_percent, 2.0, 1e-12);
  // Rows 46 .. 51 lie below; row 45 stands at 0.1 itself.
  const auto above = errors.above_10_soc.rows;
  EXPECT_TRUE(above == 45U || above == 46U) << above;
  EXPECT_NEAR(errors.above_10_soc.mean_error_percent, 1.0, 1e-12);
  EXPECT_NEAR(errors.all.mean_error_percent, (46.0 * 1.0 + 6.0 * 2.0) / 52.0, 1e-12);
}

TEST(Validation, AgreesWithThePredictionKeptRowByRow) {
  const Record record = Discharge();
  const auto prediction = Predict(ChargeCounter(), record.time_s, record.current_A);
  double squares = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k)
    squares += std::pow(record.voltage_V[k] - prediction.voltage_V[k], 2);
  EXPECT_NEAR(Validate(ChargeCounter(), record).all.rmse,
              std::sqrt(squares / static_cast<double>(record.size())),
              16.0 * kEpsilon);
  EXPECT_EQ(prediction.rows_outside_curve, 1U);
}

TEST(Validation, OfALoggedCampaignIsThatOfOneCellFromItsOwnStart) {
  LoadedLog log;
  log.entry.file = "short name.csv";
  log.entry.initial_soc = 0.5;
  log.log.record = Discharge();
  Cell pack = ChargeCounter();
  pack.series = 6;
  pack.parallel = 4;
  const LogErrors errors = Validate(pack, log);
  EXPECT_EQ(errors.file, "short name.csv");
  EXPECT_EQ(errors.all.rmse, Validate(ChargeCounter(), Discharge(), 0.5).all.rmse);
  EXPECT_GT(errors.all.rmse, 0.3);
  // The record of a pack is judged by the pack.
  Record of_pack = Discharge();
  for (double& current : of_pack.current_A) current *= 4.0;
  for (double& voltage : of_pack.voltage_V) voltage *= 6.0;
  EXPECT_NEAR(Validate(pack, of_pack).all.rmse,
              6.0 * Validate(ChargeCounter(), Discharge()).all.rmse,
              100.0 * kEpsilon);
}

// v_oc is 3 V + A volts.
TEST(Validation, SeesThatALogDoesNotStartWhereItIsSaidTo) {
  const Cell cell = ChargeCounter();
  Record record;
  record.time_s = {0, 1, 2, 3};
  record.current_A = {0, 0, 2, 2};
  record.voltage_V = {3.52, 3.5, 3.4, 3.4};
  EXPECT_EQ(DoubtAboutStart(cell, record, 1.0),
            "rests at 3.5 V before its first load, where v_oc(A) has a state of charge of 0.5, not "
            "1; if it had rested long enough, say initial_soc 0.5");
  EXPECT_EQ(DoubtAboutStart(cell, record, 0.5), "");
  // A hundredth of the charge may be a good part of alpha (docs/joint.md, 3): three digits.
  record.voltage_V[1] = 3.4624;
  EXPECT_EQ(DoubtOfStart(cell, record, 1.0)->soc, 0.462);
  record.voltage_V[1] = 3.5;
  EXPECT_EQ(DoubtAboutStart(cell, record, 0.52), "");
  record.current_A[0] = record.current_A[1] = 2.0;  // no rest to be seen
  EXPECT_EQ(DoubtOfStart(cell, record, 1.0), std::nullopt);
  record.current_A = {0, 0, 0, 0};  // nothing but rest
  EXPECT_EQ(DoubtAboutStart(cell, record, 1.0), "");
  EXPECT_EQ(DoubtAboutStart(cell, Record{}, 1.0), "");
}

// Of a pack of two on the log of one cell `simulate` said initial_soc 0.
TEST(Validation, TheVoltageOfFewerCellsSaysNothingOfAStart) {
  Cell pack = ChargeCounter();
  pack.series = 2;
  Record record;
  record.time_s = {0, 1, 2, 3};
  record.current_A = {0, 0, 2, 2};
  record.voltage_V = {4.0, 4.0, 3.9, 3.9};
  EXPECT_EQ(
      DoubtAboutStart(pack, record, 1.0),
      "has the voltage of 1 cell, not of 2 in series: it does not say where these start, and only its current "
      "is used; for a pack of so many say --series 1");
  record.voltage_V = {7.0, 7.0, 6.9, 6.9};
  EXPECT_TRUE(
      DoubtAboutStart(pack, record, 1.0).starts_with("rests at 3.5 V before its first load"));
}

// Of a single cell on the log of a pack it said to look whether the log of v_oc(A) started full.
TEST(Validation, TheVoltageOfMoreCellsSaysNothingOfAStart) {
  Record record;
  record.time_s = {0, 1, 2, 3};
  record.current_A = {0, 0, 2, 2};
  record.voltage_V = {12.5, 12.5, 12.4, 12.4};
  EXPECT_EQ(
      DoubtAboutStart(ChargeCounter(), record, 1.0),
      "has the voltage of 3 cells, not of 1 in series: it does not say where these start, and only its current "
      "is used; for a pack of so many say --series 3");
}

// After a discharge this cell rests 30 mV below v_oc(A), and a prediction begins there.
TEST(Validation, ADoubtOfAStartKnowsHysteresis) {
  Cell cell = ChargeCounter();
  cell.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.03}};
  Record record;
  record.time_s = {0, 1, 2, 3};
  record.current_A = {0, 0, 2, 2};
  record.voltage_V = {3.47, 3.47, 3.4, 3.4};
  EXPECT_EQ(DoubtOfStart(cell, record, 0.5), std::nullopt);
  ASSERT_TRUE(DoubtOfStart(cell, record, 0.8).has_value());
  EXPECT_NEAR(DoubtOfStart(cell, record, 0.8)->soc, 0.5, 1e-9);
}

// A slow discharge from 95 % took itself for a full one, and the others said nothing.
// A cycler's file that begins with a charge: nothing rests there, and yet 3.4 V are no full cell.
TEST(Validation, ALogThatBeginsUnderLoadFarFromItsStartIsDoubted) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  Record record;
  record.time_s = {0.0, 1.0, 2.0};
  record.current_A = {-0.6, -0.6, 0.0};
  record.voltage_V = {3.4, 3.41, 3.35};
  EXPECT_TRUE(DoubtAboutLoadedStart(cell, record, 1.0)
                  .starts_with("begins under load at 3.4 V, and is taken as a cell at a state of "
                               "charge of 1, which rests at 4.2 V: say where it begins"));
  EXPECT_EQ(DoubtAboutLoadedStart(cell, record, 0.02), "");
  // Under load a full cell may have all of its drop or none.
  record.current_A = {6.0, 6.0, 0.0};
  for (const double first_V : {3.4, 4.15}) {
    record.voltage_V.front() = first_V;
    EXPECT_EQ(DoubtAboutLoadedStart(cell, record, 1.0), "") << first_V;
  }
  record.current_A.front() = 0.0;  // rests: DoubtOfStart
  record.voltage_V.front() = 3.4;
  EXPECT_EQ(DoubtAboutLoadedStart(cell, record, 1.0), "");
}

TEST(Validation, ARestFarAboveAFullCellDoubtsTheCurve) {
  Cell cell = ChargeCounter();
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.16});
  Record record;
  record.time_s = {0, 1, 2};
  record.current_A = {0, 0, 1};
  record.voltage_V = {4.19, 4.19, 4.1};
  EXPECT_EQ(DoubtAboutStart(cell, record, 1.0), "");
  record.voltage_V = {4.22, 4.22, 4.1};
  EXPECT_EQ(
      DoubtAboutStart(cell, record, 1.0),
      "rests at 4.22 V before its first load, and v_oc(A) of a full cell is 4.16 V: look whether the log "
      "that v_oc comes from started full, or say its initial_soc");
  EXPECT_TRUE(
      DoubtsAboutStarts(
          {{"a.csv", 4.22, kInfinity, 1.0, 4.16}, {"b.csv", 4.22, kInfinity, 1.0, 4.16}}, "mend")
          .ends_with("; the starts of b.csv (beyond full) are doubtful, too: mend"));
}

// Of hints that contradict one another the first is of the log that is furthest off, within full.
TEST(Validation, SaysOfManyStartsTheWorstFirst) {
  std::vector<StartDoubt> doubts{{"a.csv", 3.95, 0.97, 1.0}, {"b.csv", 3.9, 0.9, 1.0}};
  doubts.push_back({"c.csv", 3.5, 0.5, 1.0});
  EXPECT_EQ(DoubtsAboutStarts(doubts, "mend the first"),
            "c.csv rests at 3.5 V before its first load, where v_oc(A) has a state of charge of "
            "0.5, not 1; if it had rested long enough, say initial_soc 0.5; the starts of "
            "b.csv (0.9, not 1), a.csv (0.97, not 1) are doubtful, too: mend the first");
  doubts.assign(8, {"d.csv", 3.9, 0.9, 1.0});
  EXPECT_TRUE(DoubtsAboutStarts(doubts, "mend")
                  .ends_with("d.csv (0.9, not 1), 2 more are doubtful, too: mend"));
  EXPECT_EQ(DoubtsAboutStarts({}, "mend"), "");
}

}  // namespace
}  // namespace lipoid
