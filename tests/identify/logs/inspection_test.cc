#include "identify/logs/inspection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/logs/inspection_report.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::RecordOfSteps;

TEST(Inspection, SaysWhatTheRecordCovers) {
  // 0.05 V per ampere: 3.7 V at rest, 3.6 V under load.
  const auto record = RecordOfSteps({{600.0, 0.0, 60.0}, {1800.0, 2.0, 1.0}, {600.0, -1.0, 10.0}});
  LogReport report;
  report.format = "plain-csv";
  const auto inspection = InspectRecord(record, report);
  EXPECT_EQ(inspection.file, "synthetic.csv");
  EXPECT_EQ(inspection.report.format, "plain-csv");
  EXPECT_EQ(inspection.duration_s, 3000.0);
  EXPECT_EQ(inspection.sampling_s.least, 1.0);
  EXPECT_EQ(inspection.sampling_s.median, 1.0);
  EXPECT_EQ(inspection.sampling_s.largest, 60.0);
  EXPECT_EQ(inspection.current_A.least, -1.0);
  EXPECT_EQ(inspection.current_A.largest, 2.0);
  ASSERT_TRUE(inspection.voltage_V.has_value());
  EXPECT_DOUBLE_EQ(inspection.voltage_V->least, 3.6);
  EXPECT_DOUBLE_EQ(inspection.voltage_V->largest, 3.75);
  EXPECT_FALSE(inspection.temperature_degC.has_value());
  EXPECT_DOUBLE_EQ(inspection.charge_out_C, 3600.0);
  EXPECT_DOUBLE_EQ(inspection.charge_in_C, 600.0);
  EXPECT_EQ(inspection.segments.size(), 3U);
}

TEST(Inspection, EdgeResistanceIsVoltageStepOverCurrentStep) {
  const auto inspection = InspectRecord(RecordOfSteps({{60.0, 0.0}, {3600.0, 2.0}}), LogReport{});
  ASSERT_TRUE(inspection.discharge.has_value());
  EXPECT_NEAR(inspection.edge_resistance_Ohm, 0.05, 1e-14);
}

// Before, the voltage at the end of its discharge was read where there is none.
TEST(Inspection, OfACurrentAloneHasNoVoltage) {
  auto record = RecordOfSteps({{60.0, 0.0}, {3600.0, 2.0}});
  record.voltage_V.clear();
  const auto inspection = InspectRecord(record, LogReport{});
  ASSERT_TRUE(inspection.discharge.has_value());
  EXPECT_DOUBLE_EQ(inspection.discharge->charge_C, 7200.0);
  EXPECT_TRUE(std::isnan(inspection.discharge->end_voltage_V));
  EXPECT_TRUE(std::isnan(inspection.edge_resistance_Ohm));
  EXPECT_FALSE(inspection.voltage_V.has_value());
  EXPECT_TRUE(InspectionToJson(inspection).at("voltage_V").is_null());
}

TEST(Inspection, OfAnEmptyRecordSaysSo) {
  const auto inspection = InspectRecord(Record{}, LogReport{});
  EXPECT_EQ(inspection.duration_s, 0.0);
  EXPECT_EQ(inspection.suggestion.reason, "only rest");
}

Suggestion SuggestedFor(const Record& record) {
  return SuggestKind(FindSegments(record), WholeDischarge(record));
}

void ExpectSuggestion(const Record& record,
                      std::optional<LogKind> kind,
                      const std::string& reason) {
  const auto suggestion = SuggestedFor(record);
  EXPECT_EQ(suggestion.kind, kind);
  EXPECT_EQ(suggestion.reason, reason);
}

TEST(SuggestKind, OfEachKind) {
  ExpectSuggestion(RecordOfSteps({{60.0, 0.0}, {1800.0, 4.0}, {600.0, 0.0}}),
                   LogKind::kConstantCurrent,
                   "one discharge of 2 Ah at 4 A, 2 C of its own charge");
  ExpectSuggestion(RecordOfSteps({{60.0, 0.0}, {36000.0, 0.2, 10.0}}),
                   LogKind::kLowRate,
                   "one discharge of 2 Ah at 0.2 A, 0.1 C of its own charge");
  ExpectSuggestion(
      RecordOfSteps({{60.0, 0.0}, {30.0, 4.0}, {1770.0, 0.0}, {30.0, 4.0}, {1770.0, 0.0}}),
      LogKind::kPulses,
      "2 pulses, 2 of them followed by a rest");
  ExpectSuggestion(
      RecordOfSteps({{60.0, 0.0}, {120.0, 4.0}, {120.0, 1.0}, {120.0, 3.0}, {120.0, 0.5}}),
      LogKind::kValidation,
      "4 loads without a pulse followed by a rest");
  ExpectSuggestion(
      RecordOfSteps({{60.0, 0.0}, {3600.0, -2.0}, {600.0, 0.0}, {3600.0, 2.0}}),
      LogKind::kValidation,
      "charges and discharges; for another kind choose a part with steps, cycles or times");
}

// A load that holds its power draws more as the voltage falls; one that is a resistor draws less.
TEST(Inspection, ALoadThatHoldsNoCurrentIsForValidation) {
  for (const bool power : {true, false}) {
    Record record = RecordOfSteps({{60.0, 0.0}, {1000.0, 4.0}});
    const double first_V = record.voltage_V[70];
    for (std::size_t k = 0; k < record.size(); ++k) {
      if (record.current_A[k] == 0.0) continue;
      record.voltage_V[k] = first_V - 4e-4 * record.time_s[k];
      record.current_A[k] = power ? 15.0 / record.voltage_V[k] : record.voltage_V[k] / 0.9;
    }
    const Suggestion found = InspectRecord(record, LogReport{}).suggestion;
    EXPECT_EQ(found.kind, LogKind::kValidation);
    EXPECT_TRUE(found.reason.starts_with(
        power ? "a discharge at a constant power of 15 W: its current moves by "
              : "a discharge at a constant resistance of 0.9 Ohm: its current moves by "))
        << found.reason;
  }
}

// US06 of a cell: here and there a load is even and a rest follows, but it is no pulse test.
TEST(SuggestKind, ADriveCycleIsForValidation) {
  std::vector<Segment> segments;
  const auto add = [&](SegmentKind kind, std::size_t rows, double charge_C) {
    Segment segment;
    segment.kind = kind;
    segment.first = segments.empty() ? 0 : segments.back().last + 1;
    segment.last = segment.first + rows - 1;
    segment.charge_C = charge_C;
    segments.push_back(segment);
  };
  for (int k = 0; k < 20; ++k) {
    for (int load = 0; load < 9; ++load) add(SegmentKind::kVarying, 20, 30.0);
    add(SegmentKind::kPulse, 20, 20.0);
    add(SegmentKind::kRest, 100, 0.0);
  }
  const Suggestion cycle = SuggestKind(segments, std::nullopt);
  EXPECT_EQ(cycle.kind, LogKind::kValidation);
  EXPECT_EQ(cycle.reason, "200 loads, 180 of them varying, as in a drive cycle");
  // Pulses whose current settles over some rows remain pulses.
  segments.clear();
  for (int k = 0; k < 20; ++k) {
    add(SegmentKind::kVarying, 3, 5.0);
    add(SegmentKind::kPulse, 20, 20.0);
    add(SegmentKind::kRest, 100, 0.0);
  }
  EXPECT_EQ(SuggestKind(segments, std::nullopt).kind, LogKind::kPulses);
}

TEST(SuggestKind, NoneForRestOrChargingAlone) {
  ExpectSuggestion(RecordOfSteps({{60.0, 0.0}}), {}, "only rest");
  ExpectSuggestion(RecordOfSteps({{60.0, 0.0}, {3600.0, -2.0}}),
                   {},
                   "only charging; a slow charge takes part in a campaign as `low-rate-charge`, "
                   "with its `initial_soc`");
}

TEST(SuggestKind, OfRealLogsIsWhatTheirCampaignsSay) {
  const std::pair<const char*, LogKind> cases[] = {
      {"nissan_leaf_33ah/cc_1c.csv", LogKind::kConstantCurrent},
      {"nissan_leaf_33ah/cc_3c.csv", LogKind::kConstantCurrent},
      {"nissan_leaf_33ah/low_rate.csv", LogKind::kLowRate},
      {"nissan_leaf_33ah/pulse.csv", LogKind::kPulses},
      {"dmegc_inr18650_26_r1/cc_0p5c.csv", LogKind::kConstantCurrent},
      {"dmegc_inr18650_26_r1/low_rate.csv", LogKind::kLowRate},
      {"dmegc_inr18650_26_r1/pulse.csv", LogKind::kPulses},
      {"dmegc_inr18650_26_r1/random_walk_01.csv", LogKind::kValidation},
      {"lg_m50_5ah/cc_2c.csv", LogKind::kConstantCurrent},
      {"lg_m50_5ah/low_rate.csv", LogKind::kLowRate},
      {"panasonic_18650pf/t25/us06.csv", LogKind::kValidation},
      {"panasonic_18650pf/tm20/us06.csv", LogKind::kValidation},
      {"samsung_30t_hppc/multipulse.csv", LogKind::kPulses}};
  for (const auto& [name, kind] : cases) {
    const auto file = test::LabDataPath(name);
    LIPOID_SKIP_WITHOUT(file);
    EXPECT_EQ(SuggestedFor(test::ReadPlainCsv(file)).kind, kind) << name;
  }
}

}  // namespace
}  // namespace lipoid
