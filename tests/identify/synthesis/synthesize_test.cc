#include "identify/synthesis/synthesize.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "identify/synthesis/decimal_step.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"
#include "tests/support/constants.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

using test::kEpsilon;

Cell DroneCell() {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "r_1", 0.03);
  SetCellParameter(cell, "c_1", 1500.0);
  return cell;
}

// Tables wherever there may be one, and the two terms beyond the thesis.
Cell RichCell() {
  Cell cell = DroneCell();
  cell.series_resistance_Ohm = {{0.0, 0.4, 1.0}, {0.2, 0.13, 0.12}};
  cell.branches = {
      {.resistance_Ohm = {{0.0, 1.0}, {0.06, 0.02}}, .time_constant_s = 45.0, .capacitance_F = {}}};
  cell.self_heating = {.time_constant_s = 300.0, .resistance_drop_Ohm_per_A2 = 2e-3};
  cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = {{0.0, 0.5}, {0.09, 0.04}}};
  return cell;
}

// Logs in a fresh folder named after the test.
std::string SynthesizeInto(const std::string& name,
                           const Cell& cell,
                           const SynthesisOptions& options,
                           std::uint64_t seed = 1) {
  auto folder = test::FreshFolder("synthesize." + name);
  RunRecord run;
  run.seed = seed;
  Synthesize(cell, kProtocols[0], options, run, folder);
  return folder;
}

TEST(DecimalStep, MultiplesAreTheDoublesNearestToTheirDecimals) {
  for (const double step : {0.01, 0.03, 0.1, 0.25, 1.0, 60.0, 1e-9}) {
    const auto multiples = DecimalStep::Of(step);
    ASSERT_TRUE(multiples.has_value()) << step;
    for (std::int64_t k : {0, 1, 3, 7, 29, 57, 999, 123457, 4673394}) {
      // The decimal as text, by whole numbers of 1e-9, read by the C library.
      const auto nanos = static_cast<std::int64_t>(std::llround(step * 1e9)) * k;
      const auto text = fmt::format("{}.{:09}", nanos / 1'000'000'000, nanos % 1'000'000'000);
      EXPECT_EQ(multiples->Times(k), std::strtod(text.c_str(), nullptr)) << step << " " << text;
      EXPECT_EQ(multiples->Count(multiples->Times(k)), k);
    }
  }
  EXPECT_FALSE(DecimalStep::Of(1.0 / 3.0).has_value());
  EXPECT_FALSE(DecimalStep::Of(0.0).has_value());
}

TEST(Synthesize, RatesSuitTheCellsAsTheThesisChoseThem) {
  for (const auto& name : ShippedCellNames()) {
    EXPECT_EQ(HighestSuitableRate(LoadCell(name)), name.starts_with("gifi") ? 6.0 : 8.0) << name;
  }
  // 0.6 A per C: 0.0788 V of r_s, and 0.06 asinh(1.2) = 0.061 V at 1C, 0.06 asinh(6) = 0.149 V at
  // 5C.
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.charge_transfer = {0.5, 0.12};
  EXPECT_EQ(HighestSuitableRate(cell), 4.0);
  cell.charge_transfer = {0.5, 10.0};
  EXPECT_EQ(HighestSuitableRate(cell), 1.0);
}

TEST(Synthesize, ConstantCurrentObeysTheClosedForm) {
  const Cell cell = DroneCell();
  const auto folder = SynthesizeInto("closed_form", cell, {.rates_C = "2,6"});
  for (const double rate : {2.0, 6.0}) {
    const auto log = test::ReadPlainCsv(fmt::format("{}/cc_{}C.csv", folder, rate));
    ASSERT_GT(log.size(), 20000U);
    EXPECT_EQ(log.current_A[0], 0.0);
    EXPECT_EQ(log.voltage_V[0], 4.2);
    EXPECT_NEAR(log.current_A[1], 0.6 * rate, 4 * kEpsilon);
    const double current_A = 0.6 * rate;
    for (std::size_t k = 1; k < log.size(); k += 977) {
      const double t = log.time_s[k];
      EXPECT_EQ(t, std::strtod(fmt::format("{}.{:02}", k / 100, k % 100).c_str(), nullptr));
      // (4.37) integrated for a constant current, ten terms and the steady rest of the sum.
      const double beta_squared = 0.1924 * 0.1924;
      double unavailable_C = 0.0;
      double sum = 0.0;
      for (int m = 1; m <= 10; ++m) {
        unavailable_C +=
            2.0 * current_A * (1.0 - std::exp(-beta_squared * m * m * t)) / (beta_squared * m * m);
        sum += 1.0 / (m * m);
      }
      const double pi = std::numbers::pi;
      unavailable_C += 2.0 * current_A / beta_squared * (pi * pi / 6.0 - sum);
      const double soc = 1.0 - (current_A * t + unavailable_C) / 1353.6;
      const double branch_V = 0.03 * current_A * (1.0 - std::exp(-t / 45.0));
      const double expected_V = cell.open_circuit_voltage(soc) - 0.1314 * current_A - branch_V;
      // 3e4 steps, each rounding the states once; v_oc is steeper than 10 V nowhere.
      constexpr double kTolerance_V = 3e4 * 10.0 * kEpsilon;
      ASSERT_NEAR(log.voltage_V[k], expected_V, kTolerance_V)
          << "row " << k << " at " << rate << "C";
    }
  }
}

TEST(Synthesize, LogsEndWithTheFirstRowAtCutOff) {
  const auto folder = SynthesizeInto("cut_off", DroneCell(), {.sampling_s = 0.5});
  for (const char* file : {"cc_1C.csv", "cc_6C.csv", "low_rate.csv", "pulses.csv"}) {
    const auto log = test::ReadPlainCsv(folder + "/" + file);
    ASSERT_GT(log.size(), 100U) << file;
    EXPECT_LE(log.voltage_V.back(), 3.0) << file;
    for (std::size_t k = 0; k + 1 < log.size(); ++k)
      ASSERT_GT(log.voltage_V[k], 3.0) << file << " " << k;
  }
}

TEST(Synthesize, PulsesLast30SecondsAndRest29Minutes30) {
  const auto folder = SynthesizeInto("pulses", DroneCell(), {.sampling_s = 0.1});
  const auto log = test::ReadPlainCsv(folder + "/pulses.csv");
  ASSERT_GT(log.size(), 5U * 18000U);
  for (std::size_t k = 0; k < log.size(); ++k) {
    const auto row_of_cycle =
        (k + 18000 - 1) % 18000;  // row 0 rests, row 1 is the first of a pulse
    ASSERT_EQ(log.current_A[k], k > 0 && row_of_cycle < 300 ? 3.6 : 0.0) << k;
  }
  EXPECT_EQ(log.current_A.back(), 3.6);  // cut-off comes under load
}

TEST(Synthesize, TheLowRateTakesTheHoursAskedFor) {
  const auto folder =
      SynthesizeInto("low_rate", DroneCell(), {.low_rate_h = 12.5, .sampling_s = 10.0});
  const auto log = test::ReadPlainCsv(folder + "/low_rate.csv");
  // Rounding the current to three digits changes the hours by at most 0.5 %; diffusion and the drop
  // at the end of the discharge take less than 1 % more.
  EXPECT_NEAR(log.time_s.back() / 3600.0, 12.5, 0.015 * 12.5);
}

TEST(Synthesize, WithoutNoiseTheTruthPredictsTheVerySameVoltages) {
  for (const Cell& cell : {DroneCell(), RichCell()}) {
    for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
      const auto folder = SynthesizeInto("same", cell, {.sampling_s = 0.1, .hold = hold});
      const Cell truth = LoadCell(folder + "/truth.json");
      for (const char* file : {"cc_3C.csv", "low_rate.csv", "pulses.csv"}) {
        auto log = test::ReadPlainCsv(folder + "/" + file);
        log.hold = hold;
        EXPECT_EQ(Validate(truth, log).all.rmse, 0.0) << file;
        // The other hold is not the same: it is off by one row of charge.
        log.hold = hold == Hold::kBackward ? Hold::kForward : Hold::kBackward;
        EXPECT_GT(Validate(truth, log).all.rmse, 0.0) << file;
      }
    }
  }
}

// Two currents from rest to rest: without diffusion the cell of tables is known in closed form but
// for its branch, which is an integral over the charge.
TEST(Synthesize, TablesAndTermsAreInTheVoltagesOfAConstantCurrent) {
  Cell cell = RichCell();
  cell.diffusion.reset();
  cell.capacity_Ah = 1353.6 / 3600.0;
  const auto folder = SynthesizeInto("rich", cell, {.rates_C = "2"});
  const auto log = test::ReadPlainCsv(folder + "/cc_2C.csv");
  const double current_A = log.current_A.back();
  ASSERT_GT(log.size(), 100000U);
  for (std::size_t k = 1; k < log.size(); k += 977) {
    const double t = log.time_s[k];
    const double soc = 1.0 - current_A * t / 1353.6;
    const double series_Ohm = soc > 0.4 ? 0.13 - 0.01 * (soc - 0.4) / 0.6 : 0.2 - 0.07 * soc / 0.4;
    const double warm_Ohm = 2e-3 * current_A * current_A * -std::expm1(-t / 300.0);
    const double transfer_Ohm = soc > 0.5 ? 0.04 : 0.09 - 0.1 * soc;
    // v_c' = (r(A) i - v_c)/tau with r = r_0 + r' t from t = 0: r i lags by tau.
    const double slope_Ohm_per_s = 0.04 * current_A / 1353.6;
    const double branch_V = current_A * (slope_Ohm_per_s * t +
                                         (0.02 - slope_Ohm_per_s * 45.0) * -std::expm1(-t / 45.0));
    const double expected_V = cell.open_circuit_voltage(soc) - (series_Ohm - warm_Ohm) * current_A -
                              transfer_Ohm * 0.4 * std::asinh(current_A / 0.4) - branch_V;
    // A step takes r(A) where it starts: half a step of 10 ms late.
    const double tolerance_V = 0.01 * slope_Ohm_per_s * current_A + 1e-10;
    ASSERT_NEAR(log.voltage_V[k], expected_V, tolerance_V) << t;
  }
}

TEST(Synthesize, APackHasItsCellsVoltagesInSeriesAndCurrentsInParallel) {
  const SynthesisOptions options{.rates_C = "2", .sampling_s = 1.0};
  Cell cell = DroneCell();
  const auto one = SynthesizeInto("one", cell, options);
  cell.series = 4;
  cell.parallel = 2;
  const auto pack = SynthesizeInto("pack", cell, options);
  for (const char* file : {"cc_2C.csv", "low_rate.csv", "pulses.csv"}) {
    const auto a = test::ReadPlainCsv(one + "/" + file);
    const auto b = test::ReadPlainCsv(pack + "/" + file);
    ASSERT_EQ(a.size(), b.size()) << file;
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(b.voltage_V[k], 4.0 * a.voltage_V[k]) << file;
      ASSERT_EQ(b.current_A[k], 2.0 * a.current_A[k]) << file;
    }
  }
}

TEST(Synthesize, TheCampaignReadsBack) {
  Cell cell = DroneCell();
  cell.name = "a \"quoted\" name";
  cell.series = 4;
  cell.parallel = 2;
  const auto folder =
      SynthesizeInto("campaign", cell, {.rates_C = "2", .sampling_s = 1.0, .hold = Hold::kForward});
  const auto campaign = ReadCampaign(folder + "/campaign.toml");
  EXPECT_EQ(campaign.name, cell.name);
  EXPECT_EQ(campaign.capacity_Ah, 0.6);
  EXPECT_EQ(campaign.cutoff_V, 3.0);
  EXPECT_EQ(campaign.series, 4);
  EXPECT_EQ(campaign.parallel, 2);
  ASSERT_EQ(campaign.logs.size(), 3U);
  const LogKind kinds[] = {LogKind::kConstantCurrent, LogKind::kLowRate, LogKind::kPulses};
  const char* const files[] = {"cc_2C.csv", "low_rate.csv", "pulses.csv"};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(campaign.logs[k].kind, kinds[k]);
    EXPECT_EQ(campaign.logs[k].file, files[k]);
    EXPECT_TRUE(fs::equivalent(campaign.logs[k].path, folder + "/" + files[k]));
    EXPECT_EQ(campaign.logs[k].read.hold, Hold::kForward);
  }
}

TEST(Synthesize, NoiseHasTheSigmaAskedForAndItsOwnStreamInEachLog) {
  const Cell cell = DroneCell();
  const SynthesisOptions clean{.rates_C = "1", .sampling_s = 0.1};
  SynthesisOptions noisy = clean;
  noisy.voltage_noise_V = 0.002;
  noisy.current_noise_A = 0.01;
  const auto a = SynthesizeInto("clean", cell, clean);
  const auto b = SynthesizeInto("noisy", cell, noisy, 5);
  const auto noise_of = [&](const std::string& file, bool voltage) {
    const auto without = test::ReadPlainCsv(a + "/" + file);
    const auto with = test::ReadPlainCsv(b + "/" + file);
    EXPECT_EQ(without.size(), with.size());
    std::vector<double> noise(without.size());
    for (std::size_t k = 0; k < noise.size(); ++k) {
      noise[k] = voltage ? with.voltage_V[k] - without.voltage_V[k]
                         : with.current_A[k] - without.current_A[k];
    }
    return noise;
  };
  const auto dot = [](const std::vector<double>& x, const std::vector<double>& y, std::size_t n) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum / static_cast<double>(n);
  };
  const auto voltage = noise_of("cc_1C.csv", true);
  const auto current = noise_of("cc_1C.csv", false);
  const auto other = noise_of("low_rate.csv", true);
  const auto n = std::min(voltage.size(), other.size());
  ASSERT_GT(n, 20000U);
  // Five standard errors of a variance, and of a correlation.
  const double rows = static_cast<double>(n);
  EXPECT_NEAR(dot(voltage, voltage, n) / (0.002 * 0.002), 1.0, 5.0 * std::sqrt(2.0 / rows));
  EXPECT_NEAR(dot(current, current, n) / (0.01 * 0.01), 1.0, 5.0 * std::sqrt(2.0 / rows));
  EXPECT_NEAR(dot(voltage, current, n) / (0.002 * 0.01), 0.0, 5.0 / std::sqrt(rows));
  EXPECT_NEAR(dot(voltage, other, n) / (0.002 * 0.002), 0.0, 5.0 / std::sqrt(rows));
}

TEST(Synthesize, AResolutionGivesItsMultiples) {
  const auto folder =
      SynthesizeInto("resolution",
                     DroneCell(),
                     {.rates_C = "3", .sampling_s = 1.0, .voltage_resolution_V = 0.005});
  const auto log = test::ReadPlainCsv(folder + "/cc_3C.csv");
  const auto exact = test::ReadPlainCsv(
      SynthesizeInto("exact", DroneCell(), {.rates_C = "3", .sampling_s = 1.0}) + "/cc_3C.csv");
  ASSERT_EQ(log.size(), exact.size());
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double steps = log.voltage_V[k] / 0.005;
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
    ASSERT_LE(std::abs(log.voltage_V[k] - exact.voltage_V[k]), 0.0025 + 1e-12);
  }
}

TEST(Synthesize, AFailureLeavesTheOldLogsAsTheyWere) {
  const auto folder = SynthesizeInto("old", DroneCell(), {.rates_C = "1", .sampling_s = 1.0});
  const auto before = Sha256OfFile(folder + "/cc_1C.csv");
  EXPECT_THROW(Synthesize(DroneCell(),
                          kProtocols[0],
                          {.rates_C = "1,100", .sampling_s = 1.0, .voltage_noise_V = 0.1},
                          RunRecord(),
                          folder),
               OptionError);
  EXPECT_EQ(Sha256OfFile(folder + "/cc_1C.csv"), before);
  EXPECT_FALSE(fs::exists(folder + "/cc_100C.csv"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 5);
}

TEST(Synthesize, ACellThatNeverReachesItsCutOffIsSaid) {
  Cell cell = DroneCell();
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.2, 4.2});
  cell.cutoff_V = 1.0;
  const auto folder = test::FreshFolder("synthesize.never");
  try {
    Synthesize(cell, kProtocols[0], {.rates_C = "1", .sampling_s = 1.0}, RunRecord(), folder);
    FAIL() << "no error";
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find("never reaches its cut-off of 1 V"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace lipoid
