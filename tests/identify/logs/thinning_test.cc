// A long log in fewer rows: against the same log with every row kept, for charge, switches, gaps,
// spikes, labels and segments.
#include "identify/logs/thinning.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "identify/logs/columns.h"
#include "identify/logs/inspection.h"
#include "identify/logs/log.h"
#include "identify/logs/segments.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::kEveryRow;
constexpr std::size_t kMost = 16384;

// Rows of a discharge with rests before each load, 100 per second, as text.
struct Bench {
  std::string header = "time_s,current_A,voltage_V";
  double noise_A = 0.0;
  double scale_V = 1.0;
  std::size_t rows = 120000;
  std::size_t period = 10000;  // rows
  std::string text = {};

  [[nodiscard]] double Level_A(std::size_t k) const {
    return k % period < 2 * period / 5 ? 0.0 : 2.5;
  }

  template <class Row>
  void Write(const Row& row) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    text = header;
    text += '\n';
    double charge_C = 0.0;
    for (std::size_t k = 0; k < rows; ++k) {
      const double current_A = Level_A(k) + noise_A * normal(random);
      charge_C += 0.01 * current_A;
      const double voltage_V =
          scale_V * (4.1 - 0.02 * current_A - 4e-4 * charge_C + 2e-4 * normal(random));
      row(text, k, current_A, voltage_V);
    }
  }
  void Write() {
    Write([](std::string& to, std::size_t k, double current_A, double voltage_V) {
      fmt::format_to(
          std::back_inserter(to), "{:.2f},{:.5f},{:.5f}\n", 0.01 * double(k), current_A, voltage_V);
    });
  }
  [[nodiscard]] Log Read(std::size_t most_rows, ReadOptions options = {}) const {
    options.most_rows = most_rows;
    return ReadLogText(text, "F", options);
  }
};

// Rounding of sums over so many rows.
constexpr double kRounding_C = 1e-9;

TEST(Thinning, ALogThatIsShortEnoughStaysAsItIs) {
  Bench bench;
  bench.rows = kMost;
  bench.Write();
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  EXPECT_FALSE(log.report.thinned);
  EXPECT_EQ(log.record.time_s, every.record.time_s);
  EXPECT_EQ(log.record.voltage_V, every.record.voltage_V);
  EXPECT_TRUE(bench.Read(kMost - 1).report.thinned);
}

TEST(Thinning, LeavesHalfOfTheRowsAtMostAndCountsThemAll) {
  Bench bench;
  bench.period = 60000;
  bench.noise_A = 0.003;
  bench.Write();
  const Log log = bench.Read(kMost);
  ASSERT_TRUE(log.report.thinned);
  EXPECT_LE(log.record.size(), kMost / 2);
  EXPECT_EQ(log.record.size(), log.report.thinned->rows);
  EXPECT_EQ(log.report.rows, bench.rows);
  EXPECT_EQ(log.report.thinned->rows_of_log, bench.rows);
  EXPECT_NEAR(log.report.thinned->median_s, 0.01, 1e-9);
  EXPECT_NEAR(log.report.thinned->longest_s, 0.01, 1e-9);
  // Six deviations, as far as 0.9-quantiles of the noise tell one.
  EXPECT_NEAR(log.report.thinned->tolerance_A, 0.018, 0.003);
}

TEST(Thinning, ChargeIsThatOfEveryRow) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    SCOPED_TRACE(hold == Hold::kBackward ? "backward" : "forward");
    Bench bench;
    bench.noise_A = 0.003;
    bench.Write();
    const ReadOptions options{.hold = hold};
    const Log every = bench.Read(kEveryRow, options);
    const Log log = bench.Read(kMost, options);
    const auto charge_C = DeliveredCharge(log.record);
    const auto every_C = DeliveredCharge(every.record);
    std::size_t row = 0;
    for (std::size_t k = 0; k < log.record.size(); ++k) {
      while (every.record.time_s[row] < log.record.time_s[k]) ++row;
      ASSERT_EQ(every.record.time_s[row], log.record.time_s[k]);
      ASSERT_EQ(every.record.voltage_V[row], log.record.voltage_V[k]);
      ASSERT_NEAR(charge_C[k], every_C[row], kRounding_C);
    }
    EXPECT_EQ(row + 1, bench.rows);
  }
}

TEST(Thinning, RowsBesideAStepOfTheCurrentStay) {
  Bench bench;
  bench.Write();
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  for (std::size_t step = 4000; step < bench.rows; step += step % 10000 == 0 ? 4000 : 6000) {
    for (std::size_t row = step - Thinning::kBeside; row < step + Thinning::kBeside; ++row) {
      const auto found = std::lower_bound(
          log.record.time_s.begin(), log.record.time_s.end(), every.record.time_s[row]);
      const auto k = static_cast<std::size_t>(found - log.record.time_s.begin());
      ASSERT_LT(k, log.record.size());
      EXPECT_EQ(log.record.time_s[k], every.record.time_s[row]);
      EXPECT_EQ(log.record.current_A[k], every.record.current_A[row]);
      EXPECT_EQ(log.record.voltage_V[k], every.record.voltage_V[row]);
    }
  }
}

TEST(Thinning, ARowStandsForAShareOfTheTimeSinceTheCurrentStepped) {
  Bench bench;
  bench.period = 60000;
  bench.Write();
  const Log log = bench.Read(kMost);
  double stepped_s = 0.0;
  for (std::size_t k = 1; k < log.record.size(); ++k) {
    const double step_s = log.record.time_s[k] - log.record.time_s[k - 1];
    if (log.record.current_A[k] != log.record.current_A[k - 1])
      stepped_s = log.record.time_s[k - 1];
    const double age_s = log.record.time_s[k] - stepped_s;
    EXPECT_LE(step_s, std::max(0.0101, Thinning::kShareOfAge * age_s + 0.0101)) << k;
  }
}

TEST(Thinning, SegmentsAreThoseOfEveryRow) {
  Bench bench;
  bench.noise_A = 0.002;
  bench.Write();
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  const auto segments = FindSegments(log.record);
  const auto expected = FindSegments(every.record);
  ASSERT_EQ(segments.size(), expected.size());
  ASSERT_EQ(segments.size(), 24U);
  for (std::size_t k = 0; k < segments.size(); ++k) {
    EXPECT_EQ(segments[k].kind, expected[k].kind);
    EXPECT_EQ(segments[k].start_s, expected[k].start_s);
    EXPECT_EQ(segments[k].end_s, expected[k].end_s);
    EXPECT_NEAR(segments[k].charge_C, expected[k].charge_C, kRounding_C);
  }
}

TEST(Thinning, GapsAreThoseOfEveryRow) {
  Bench bench;
  bench.Write([](std::string& to, std::size_t k, double current_A, double voltage_V) {
    const double missing_s = k < 27000 ? 0.0 : 5.0;
    fmt::format_to(std::back_inserter(to),
                   "{:.2f},{:.5f},{:.5f}\n",
                   0.01 * double(k) + missing_s,
                   current_A,
                   voltage_V);
  });
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  ASSERT_EQ(every.report.gaps.size(), 1U);
  ASSERT_EQ(log.report.gaps.size(), 1U);
  EXPECT_EQ(log.report.gaps[0].start_s, every.report.gaps[0].start_s);
  EXPECT_EQ(log.report.gaps[0].length_s, every.report.gaps[0].length_s);
  EXPECT_EQ(log.report.gaps[0].unknown_C, every.report.gaps[0].unknown_C);
  EXPECT_EQ(log.report.thinned->longest_s, every.report.gaps[0].length_s);
}

TEST(Thinning, AChosenPartMayEndLongBeforeItsLog) {
  Bench bench;
  bench.Write();
  constexpr double kEnd_s = 300.0;  // of 1200
  const Log log = bench.Read(4096, {.end_s = kEnd_s});
  const Log every = bench.Read(kEveryRow, {.end_s = kEnd_s});
  ASSERT_TRUE(log.report.thinned);
  EXPECT_EQ(log.report.rows, every.record.size());
  EXPECT_EQ(log.record.time_s.back(), every.record.time_s.back());
}

TEST(Thinning, SpikesAreDroppedAllTheSame) {
  Bench bench;
  bench.Write([](std::string& to, std::size_t k, double current_A, double voltage_V) {
    if (k % 17000 == 8000) voltage_V = 9.5;
    fmt::format_to(
        std::back_inserter(to), "{:.2f},{:.5f},{:.5f}\n", 0.01 * double(k), current_A, voltage_V);
  });
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  EXPECT_EQ(every.report.dropped_spikes, 7U);
  EXPECT_EQ(log.report.dropped_spikes, 7U);
  EXPECT_EQ(log.report.rows, every.report.rows);
  EXPECT_EQ(log.report.warnings, every.report.warnings);
  EXPECT_EQ(log.report.thinned->spikes_s,
            (std::vector<double>{80.0, 250.0, 420.0, 590.0, 760.0, 930.0, 1100.0}));
  EXPECT_LT(LargestMagnitude(log.record.voltage_V), 5.0);
}

// Voltages in mV under a name that does not say so, whose jumps are thousandfold, and currents whose
// sign the cycler's states say.
TEST(Thinning, MillivoltsAreMillivolts) {
  Bench bench;
  bench.scale_V = 1000.0;
  bench.header = "Rec#,Cyc#,Step,Test (Sec),mAmps,Volts,State";
  bench.Write([](std::string& to, std::size_t k, double current_A, double voltage_V) {
    fmt::format_to(std::back_inserter(to),
                   "{},1,1,{:.2f},{:.5f},{:.5f},{}\n",
                   k,
                   0.01 * double(k),
                   1000.0 * current_A,
                   voltage_V,
                   current_A > 0.0 ? "D" : "R");
  });
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  EXPECT_EQ(log.report.format, "maccor");
  EXPECT_EQ(log.report.notes, every.report.notes);
  EXPECT_EQ(log.report.current_sign, every.report.current_sign);
  EXPECT_TRUE(log.report.thinned->millivolts);
  EXPECT_LT(LargestMagnitude(log.record.voltage_V), 5.0);
  EXPECT_LE(log.record.size(), kMost / 2);
  EXPECT_NEAR(CountCharge(log.record).charge_C, CountCharge(every.record).charge_C, kRounding_C);
}

// Where every row has another current, rows are joined all the same, and charge is not lost.
TEST(Thinning, ADriveCycleBecomesShortToo) {
  Bench bench;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(-1.0, 4.0);
  double charge_C = 0.0;
  double last_A = 0.0;
  bench.Write([&](std::string& to, std::size_t k, double, double) {
    const double current_A = k % 50 == 0 ? any(random) : last_A + 0.01 * any(random);
    last_A = current_A;
    charge_C += 0.01 * current_A;
    fmt::format_to(std::back_inserter(to),
                   "{:.2f},{:.5f},{:.5f}\n",
                   0.01 * double(k),
                   current_A,
                   4.1 - 0.05 * current_A - 5e-4 * charge_C);
  });
  const Log every = bench.Read(kEveryRow);
  const Log log = bench.Read(kMost);
  EXPECT_LE(log.record.size(), kMost / 2);
  EXPECT_NEAR(CountCharge(log.record).charge_C, CountCharge(every.record).charge_C, kRounding_C);
  EXPECT_EQ(log.report.current_sign, every.report.current_sign);
}

TEST(Thinning, StepsOfTheCyclerKeepTheirRows) {
  Bench bench;
  bench.header = "time_s,current_A,voltage_V,step";
  bench.Write([](std::string& to, std::size_t k, double current_A, double voltage_V) {
    fmt::format_to(std::back_inserter(to),
                   "{:.2f},{:.5f},{:.5f},{}\n",
                   0.01 * double(k),
                   current_A,
                   voltage_V,
                   k / 7000);
  });
  const ReadOptions options{.labels = true};
  const Log every = bench.Read(kEveryRow, options);
  const Log log = bench.Read(kMost, options);
  ASSERT_EQ(every.report.labels.size(), 18U);
  ASSERT_EQ(log.report.labels.size(), 18U);
  for (std::size_t k = 0; k < 18; ++k) {
    EXPECT_EQ(log.report.labels[k].step, every.report.labels[k].step);
    EXPECT_EQ(log.record.time_s[log.report.labels[k].row],
              every.record.time_s[every.report.labels[k].row]);
  }
}

TEST(Thinning, SaysWhatItDid) {
  EXPECT_EQ(ThinningText({.rows_of_log = 100000000,
                          .rows = 6250123,
                          .most_rows = 16777216,
                          .group = 16,
                          .tolerance_A = 0.00116}),
            "100000000 rows, of which 16777216 would be kept as they are, were thinned to 6250123: "
            "where the current keeps within 0.00116 A and nothing else happens, one row stands for "
            "up to 16 with the charge of all");
}

}  // namespace
}  // namespace lipoid
