#include "identify/logs/inspection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/logs/inspection_report.h"
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

}  // namespace
}  // namespace lipoid
