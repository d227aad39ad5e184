#include "identify/logs/log_writer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <random>
#include <span>

#include "identify/logs/log.h"
#include "model/core/errors.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

Record DischargeOfRows(std::size_t rows) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  Record record;
  for (std::size_t k = 0; k < rows; ++k) {
    record.time_s.push_back(static_cast<double>(k) / 7.0);
    record.current_A.push_back(k < 3 ? 0.0 : 2.0 + 1e-3 * any(random));
    record.voltage_V.push_back((k < 3 ? 4.1 : 4.0) -
                               static_cast<double>(k) / static_cast<double>(rows) +
                               1e-4 * any(random));
    record.temperature_degC.push_back(25.0 + any(random));
  }
  return record;
}

void ExpectTheSameBits(std::span<const double> a, std::span<const double> b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
}

TEST(LogWriter, WhatWasWrittenReadsBackBitForBit) {
  for (const auto format : {LogFileFormat::kCsv, LogFileFormat::kBdf}) {
    const Record record = DischargeOfRows(20000);
    const std::string file = test::WriteText("out.csv", "");
    WriteLog(record, file, format);
    const Log log = ReadLog(file);
    EXPECT_EQ(log.report.format, format == LogFileFormat::kCsv ? "plain-csv" : "bdf");
    EXPECT_EQ(log.report.current_sign,
              format == LogFileFormat::kCsv ? "discharge-positive" : "discharge-negative");
    ExpectTheSameBits(log.record.time_s, record.time_s);
    ExpectTheSameBits(log.record.current_A, record.current_A);
    ExpectTheSameBits(log.record.voltage_V, record.voltage_V);
    ExpectTheSameBits(log.record.temperature_degC, record.temperature_degC);
  }
}

TEST(LogWriter, TheTextIsPlain) {
  Record record;
  record.time_s = {0, 0.5};
  record.current_A = {0, 1.25};
  record.voltage_V = {4.2, 4.1};
  const std::string file = test::WriteText("out.csv", "");
  WriteLog(record, file);
  EXPECT_EQ(test::ReadText(file), "time_s,current_A,voltage_V\n0,0,4.2\n0.5,1.25,4.1\n");
  WriteLog(record, file, LogFileFormat::kBdf);
  EXPECT_EQ(test::ReadText(file),
            "Test Time / s,Current / A,Voltage / V\n0,0,4.2\n0.5,-1.25,4.1\n");
}

TEST(LogWriter, RefusesAFolderThatIsMissingAndColumnsOfUnequalLength) {
  Record record = DischargeOfRows(5);
  EXPECT_THROW(WriteLog(record, "/nonexistent/folder/x.csv"), OptionError);
  record.voltage_V.resize(record.size() - 1);
  EXPECT_THROW(WriteLog(record, test::WriteText("out.csv", "")), PreconditionError);
}

}  // namespace
}  // namespace lipoid
