// The real exports beside the project, read right. The numbers come from a Python script that knows
// each file's columns by their position (csv split, float(), datetime), drops rows whose time
// repeats, and sums with sum().
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "identify/logs/log.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

using test::LabDataPath;

struct Export {
  const char* file;
  const char* format;
  const char* sign;
  std::size_t rows;
  std::size_t repeated;
  std::size_t cut;
  double first[3];
  double last[3];
  double sums[3];
  ReadOptions options = {};
};

void PrintTo(const Export& one, std::ostream* os) { *os << one.file; }

const Export kExports[] = {
    {"vendor/arbin/beep_2017-05-09_test-TC-contact_CH33.csv",
     "arbin",
     "discharge-negative",
     287,
     0,
     0,
     {0.0, -6.600444793701172, 3.298668384552002},
     {1022.8913, -1.1000289916992188, 3.4119858741760254},
     {147022.05519999992, -573.1040983200073, 978.6578431129456}},
    {"vendor/arbin/pyprobe_sample_data_arbin.csv",
     "arbin",
     "discharge-negative",
     13,
     0,
     0,
     {30.0005, 0, 3.534595},
     {301.214, -2.650138, 3.599601},
     {2551.9312, -5.2977419999999995, 46.074583}},
    {"vendor/basytec/pyprobe_sample_data_basytec.txt",
     "basytec",
     "discharge-negative",
     74,
     0,
     0,
     {0, 0, 3.52575489148741},
     {70.2358036666668, -0.449601734416934, 3.53285012323902},
     {2608.001412666668, -4.9475710398066095, 260.9655002693861}},
    {"vendor/bdf/sample_human_labels.bdf.csv",
     "bdf",
     "discharge-positive",
     3,
     0,
     0,
     {0, 0.1, 3.7},
     {2, 0.1, 3.5},
     {3.0, 0.30000000000000004, 10.8}},
    // Unsigned: only steps of one direction can be read. Times are those of the file less the
    // first.
    {"vendor/bdf/faraday__lg-INR21700M50-2019-002__2019-06-02__rate__25degC__maccor.bdf.csv",
     "bdf",
     "discharge-positive",
     62,
     0,
     0,
     {0, 0.502632, 3.1128},
     {2637.3 - 1800.04002, 0.500038, 2.5},
     {139792.67016 - 62 * 1800.04002, 31.00282600000001, 173.73350000000002},
     {.steps = {2}}},
    {"vendor/bdf/faraday__lg-INR21700M50-2019-002__2019-06-02__rate__25degC__maccor.bdf.csv",
     "bdf",
     "discharge-negative",
     399,
     0,
     0,
     {0, -1.50423, 2.8893},
     {20774.85 - 9837.33, -1.49966, 4.2},
     {5936892.757080048 - 399 * 9837.33, -598.4709500000001, 1486.2555000000002},
     {.steps = {4}}},
    {"vendor/biologic/pyprobe_Sample_data_biologic_01_MB_CA1.txt",
     "biologic",
     "discharge-negative",
     1397,
     0,
     0,
     {0, 0, 3.5180547},
     {139.5240066270344, 0.89982635, 3.4854481},
     {97412.13062682771, 1167.1332572800045, 4883.598299999995}},
    {"vendor/biologic/pyprobe_Sample_data_biologic_timestamped.txt",
     "biologic",
     "discharge-negative",
     8,
     0,
     0,
     {0, 0, 4.1465597},
     {12.464, -0.4499184, 4.154593},
     {66.248, -3.14958643, 33.2217797}},
    {"vendor/bitrode/1C-Discharge-Bitrode-data.csv",
     "bitrode",
     "discharge-negative",
     2287,
     0,
     0,
     {1, 0, 3.147},
     {66041.4, 0, 4.185},
     {75338723.49999967, 981.9999999999638, 8557.960000000034}},
    {"vendor/bitrode/NissanLeaf-cell-Low-Current-HPPC-25C-2.csv",
     "bitrode",
     "discharge-negative",
     13248,
     0,
     0,
     {1, -10, 3.327},
     {58968.2, 10, 3},
     {473698694.0999692, 96700.81000000074, 51051.71300000019}},
    {"vendor/digatron/lghg2_549_Dis_2C.csv",
     "digatron",
     "discharge-negative",
     27,
     0,
     0,
     {269999.325, 5.99956, 3.92674},
     {271548.166, 5.99956, 2.79993},
     {7311030.618000002, 161.97532000000004, 93.85232000000002}},
    {"vendor/digatron/lghg2_551_Cap_1C.csv",
     "digatron",
     "discharge-negative",
     395,
     2,
     0,
     {7616.735, 0, 4.19271},
     {11538.204, 0, 3.07158},
     {3785622.994000006, 984.0712000000065, 1390.21052}},
    {"vendor/maccor/beep_maccor_test_file_4267-66-6519.041",
     "maccor",
     "unsigned",
     11,
     63,
     0,
     {0, 0, 3.90806439},
     {10, 0, 3.91126879},
     {55.0, 0, 43.01953157}},
    // TestTime in minutes: its dates run from 11:23:46 to 14:55:46 while it counts from 0 to 212.
    {"vendor/maccor/cellpy_maccor_two.txt",
     "maccor",
     "unsigned",
     213,
     0,
     1,
     {0, 0, 0.1377},
     {12720, 0, 0.149},
     {1354680.0, 0, 31.88959999999997}},
    {"vendor/maccor/pyprobe_sample_data_maccor.csv",
     "maccor",
     "discharge-negative",
     15,
     0,
     0,
     {0, 0, 3.668},
     {13.06, -28.798, 3.716},
     {101.24, -115.239, 55.201}},
    {"vendor/neware/cellpy_neware_uio.csv",
     "neware",
     "discharge-negative",
     8967,
     98,
     0,
     {0, 0, 2.917},
     {518538, -0.00099171, 0.4251},
     {2327281956.0, 0.2867530000000115, 4603.933700000003}},
    {"vendor/novonix/pyprobe_sample_data_novonix.csv",
     "novonix",
     "discharge-negative",
     207,
     0,
     0,
     {0, 0, 3.84318331},
     {12287.48004, -0.49999387, 4.12864581},
     {1261371.5884800002, -102.99856999999999, 830.4171389399997}},
    {"samsung_30t_hppc/multipulse.csv",
     "plain-csv",
     "discharge-positive",
     1187,
     7,
     0,
     {9.918000922, 0, 4.18647},
     {814.6999966, 0, 4.15849},
     {423943.3932876821, 847.9297299999974, 4945.444929999985},
     {.units = {"s", "A", "V"}}},
};

class VendorExport : public testing::TestWithParam<Export> {};

TEST_P(VendorExport, IsReadRight) {
  const Export& expected = GetParam();
  const std::string path = LabDataPath(expected.file);
  LIPOID_SKIP_WITHOUT(path);
  const Log log = ReadLog(path, expected.options);
  EXPECT_EQ(log.report.format, expected.format);
  EXPECT_EQ(log.report.current_sign, expected.sign) << log.report.current_sign_reason;
  EXPECT_FALSE(log.report.current_sign_reason.empty());
  EXPECT_EQ(log.report.dropped_repeated_times, expected.repeated);
  EXPECT_EQ(log.report.dropped_cut_last_line, expected.cut);
  ASSERT_EQ(log.record.size(), expected.rows);
  const Column* columns[] = {&log.record.time_s, &log.record.current_A, &log.record.voltage_V};
  for (int k = 0; k < 3; ++k) {
    SCOPED_TRACE(k);
    // Units and offsets round once or twice; sums add up n roundings in another order at most.
    constexpr double kRounding = 1e-15;
    const auto& column = *columns[k];
    const double scale = std::abs(expected.sums[k]) + std::abs(expected.last[k]) + 1e3;
    EXPECT_NEAR(column.front(), expected.first[k], kRounding * scale);
    EXPECT_NEAR(column.back(), expected.last[k], kRounding * scale);
    double sum = 0.0;
    for (const double x : column) sum += x;
    EXPECT_NEAR(sum, expected.sums[k], kRounding * static_cast<double>(expected.rows) * scale);
  }
}

INSTANTIATE_TEST_SUITE_P(All, VendorExport, testing::ValuesIn(kExports));

TEST(VendorExport, AnUnsignedCurrentWithoutAStateIsRefused) {
  const std::string path = LabDataPath(
      "vendor/bdf/faraday__lg-INR21700M50-2019-002__2019-06-02__rate__25degC__maccor.bdf.csv");
  LIPOID_SKIP_WITHOUT(path);
  EXPECT_EQ(
      test::LoadErrorOf([&] { (void)ReadLog(path); }),
      path +
          ":1:31: error: expected a current whose sign the data settle, found that the voltage "
          "falls from 31471.84998 s to 67457.08002 s and rises from 9837.33 s to 20924.88 s, as if "
          "the current had no sign or another pack began in between; no option gives it one: read a part in which the cell is only "
          "charged or only discharged (start_s and end_s, steps or cycles in a campaign; lipoid "
          "convert --start-s --end-s, --steps or --cycles), or export the current with its sign or "
          "with a column of states");
  EXPECT_TRUE(ReadLog(path, {.current_sign = "discharge-positive"})
                  .report.warnings.at(0)
                  .starts_with("the current never changes its sign while the voltage rises"));
}

}  // namespace
}  // namespace lipoid
