// The sign of the current on mutated logs: noise, rests cut out, one direction only, written either
// way round. Counts what is right, refused and wrong; docs/formats.md shows the table that this
// prints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "identify/logs/columns.h"
#include "identify/logs/current_sign.h"
#include "identify/logs/log.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"

namespace lipoid {
namespace {

constexpr double kRestShare = 0.02;  // of the largest current

struct Judgements {
  int right = 0;
  int refused = 0;
  int wrong = 0;

  [[nodiscard]] int all() const { return right + refused + wrong; }
  Judgements& operator+=(const Judgements& other) {
    right += other.right;
    refused += other.refused;
    wrong += other.wrong;
    return *this;
  }
};

Record Select(const Record& record, const std::function<bool(std::size_t)>& keep) {
  Record selected;
  selected.file = record.file;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (!keep(k)) continue;
    selected.time_s.push_back(record.time_s[k]);
    selected.current_A.push_back(record.current_A[k]);
    selected.voltage_V.push_back(record.voltage_V[k]);
  }
  return selected;
}

// As a logger writes it that leaves out rests: the clock goes on.
Record WithoutRests(const Record& record) {
  const double rest_A = kRestShare * LargestMagnitude(record.current_A);
  return Select(record, [&](std::size_t k) { return std::abs(record.current_A[k]) >= rest_A; });
}

// The direction in which most of the charge flows, and rests.
Record OneDirection(const Record& record) {
  const double rest_A = kRestShare * LargestMagnitude(record.current_A);
  const double side = CountCharge(record, 0, record.size() - 1).charge_C < 0.0 ? -1.0 : 1.0;
  return Select(record, [&](std::size_t k) { return side * record.current_A[k] >= -rest_A; });
}

struct Noise {
  const char* name = "";
  double of_range = 0.0;    // share of the largest current, in every row
  double of_reading = 0.0;  // share of the current of the row
  double voltage_V = 0.0;
};

constexpr Noise kNoises[] = {
    {.name = "none"},
    {.name = "current 0.5 % of range", .of_range = 0.005},
    {.name = "current 1 % of range", .of_range = 0.01},
    {.name = "current 2 % of range", .of_range = 0.02},
    {.name = "current 5 % of range", .of_range = 0.05},
    {.name = "current 2 % of reading", .of_reading = 0.02},
    {.name = "current 5 % of reading", .of_reading = 0.05},
    {.name = "voltage 1 mV", .voltage_V = 1e-3},
    {.name = "voltage 3 mV", .voltage_V = 3e-3},
    {.name = "voltage 10 mV", .voltage_V = 10e-3},
    {.name = "current 5 % of range, voltage 10 mV", .of_range = 0.05, .voltage_V = 10e-3},
};

Record Noisy(Record record, const Noise& noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const double largest_A = LargestMagnitude(record.current_A);
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double i_A = record.current_A[k];
    record.current_A[k] +=
        (noise.of_range * largest_A + noise.of_reading * std::abs(i_A)) * normal(random);
    record.voltage_V[k] += noise.voltage_V * normal(random);
  }
  return record;
}

// Of a record whose discharge is positive, and of the same written the other way round.
Judgements Judge(Record record, const std::string& what) {
  Judgements count;
  for (const CurrentSign truth :
       {CurrentSign::kDischargePositive, CurrentSign::kDischargeNegative}) {
    const SignFinding found = FindSignFromPhysics(record);
    if (found.sign == truth) {
      ++count.right;
    } else if (found.sign == CurrentSign::kUnclear) {
      ++count.refused;
    } else {
      ++count.wrong;
      ADD_FAILURE() << record.file << ", " << what << ": " << found.reason;
    }
    for (double& i : record.current_A) i = -i;
  }
  return count;
}

// A discharge, or a charge, that no engineer misses: the voltage of the loaded rows moves by 0.3 V,
// and nearly all charge goes one way.
bool IsPlain(const Record& record) {
  if (record.size() < 2) return false;
  const Record loaded = WithoutRests(record);
  const Extent extent = FindExtent(loaded.voltage_V);
  const ChargeMoved moved = CountCharge(record, 0, record.size() - 1);
  const double all_C = moved.most_C - moved.least_C;
  return loaded.size() > 10 && extent.most - extent.least > 0.3 &&
         std::abs(moved.charge_C) > 0.9 * all_C;
}

struct Tally {
  std::map<std::string, Judgements> plain;   // by form and noise
  std::map<std::string, Judgements> others;  // short pulses, cycles, ...

  void Take(const Record& whole) {
    const std::pair<const char*, Record> forms[] = {
        {"as recorded", whole},
        {"no rests", WithoutRests(whole)},
        {"one direction", OneDirection(whole)},
        {"one direction, no rests", WithoutRests(OneDirection(whole))}};
    unsigned seed = 1;
    for (const auto& [form, record] : forms) {
      std::map<std::string, Judgements>& counts = IsPlain(record) ? plain : others;
      for (const Noise& noise : kNoises) {
        const std::string what = std::string(form) + " | " + noise.name;
        counts[what] += Judge(Noisy(record, noise, seed++), what);
      }
    }
  }

  static Judgements Sum(const std::map<std::string, Judgements>& counts) {
    Judgements sum;
    for (const auto& [what, count] : counts) sum += count;
    return sum;
  }

  void Print() const {
    std::printf(
        "%-64s %30s %30s\n", "", "plain: right refused wrong", "others: right refused wrong");
    std::map<std::string, std::pair<Judgements, Judgements>> rows;
    for (const auto& [what, count] : plain) rows[what].first += count;
    for (const auto& [what, count] : others) rows[what].second += count;
    rows["sum"] = {Sum(plain), Sum(others)};
    for (const auto& [what, row] : rows) {
      std::printf("%-64s %16d %7d %5d %16d %7d %5d\n",
                  what.c_str(),
                  row.first.right,
                  row.first.refused,
                  row.first.wrong,
                  row.second.right,
                  row.second.refused,
                  row.second.wrong);
    }
  }
};

constexpr const char* kNoLabLogs =
    "skipped: the real lab logs (../shared/data) are not beside the project";

// The logs of the lab folders; discharge is positive in all of them. None where they are absent.
std::vector<Record> LabLogs() {
  std::vector<Record> logs;
  for (const char* folder : {"nissan_leaf_33ah",
                             "dmegc_inr18650_26_r1",
                             "lg_m50_5ah",
                             "samsung_30t_hppc",
                             "panasonic_18650pf",
                             "lg_m50_temperatures",
                             "nasa_rw26_ageing"}) {
    const std::string path = test::LabDataPath(folder);
    if (path.empty()) return {};
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
      const bool derived = entry.path().filename() == "ocv_from_rests.csv";  // no log
      if (entry.path().extension() == ".csv" && !derived) files.push_back(entry.path().string());
    }
    EXPECT_FALSE(files.empty()) << path;
    std::sort(files.begin(), files.end());
    for (const std::string& file : files) logs.push_back(test::ReadPlainCsv(file));
  }
  return logs;
}

// A cell of 40 mOhm and slower 30 mOhm in 40 s, 2 Ah, by its own recurrence.
Record Simulate(const std::string& name, const std::vector<double>& current_A, double interval_s) {
  Record record;
  record.file = name;
  double slow_V = 0.0;
  double soc = current_A.back() < 0.0 ? 0.1 : 1.0;
  for (std::size_t k = 0; k < current_A.size(); ++k) {
    const double i_A = current_A[k];
    soc -= k > 0 ? i_A * interval_s / 7200.0 : 0.0;
    slow_V += (0.03 * i_A - slow_V) * (1.0 - std::exp(-interval_s / 40.0));
    const double open_V = 3.0 + 1.1 * soc - 0.3 * std::exp(-20.0 * soc);
    record.time_s.push_back(interval_s * static_cast<double>(k));
    record.current_A.push_back(i_A);
    record.voltage_V.push_back(open_V - 0.04 * i_A - slow_V);
  }
  return record;
}

std::vector<Record> SimulatedLogs() {
  const auto profile = [](int times, const std::vector<std::pair<int, double>>& parts) {
    std::vector<double> current_A;
    for (int round = 0; round < times; ++round) {
      for (const auto& [rows, i_A] : parts)
        current_A.insert(current_A.end(), static_cast<std::size_t>(rows), i_A);
    }
    return current_A;
  };
  std::vector<double> drive{0.0};  // without regeneration: half of the time at rest, else to 6 A
  std::mt19937_64 random(7);
  while (drive.size() < 3000) {
    const double draw = static_cast<double>(random() % 1000) / 1000.0;
    drive.insert(drive.end(), 1 + random() % 8, std::max(0.0, 12.0 * (draw - 0.5)));
  }
  return {Simulate("C/10 discharge", profile(1, {{1, 0.0}, {1100, 0.2}}), 30.0),
          Simulate("1C discharge", profile(1, {{1, 0.0}, {3200, 2.0}}), 1.0),
          Simulate("C/10 charge", profile(1, {{1, 0.0}, {1000, -0.2}}), 30.0),
          Simulate("pulses", profile(10, {{30, 0.0}, {60, 6.0}, {120, 0.0}, {180, 1.0}}), 1.0),
          Simulate("pulses with regeneration",
                   profile(10, {{30, 0.0}, {30, 6.0}, {40, 0.0}, {10, -4.0}, {300, 2.0}}),
                   1.0),
          Simulate("drive", drive, 1.0)};
}

// A slower logger's rows of a long log, to save time where noise is added.
Record Slower(const Record& record) {
  constexpr std::size_t kEnough = 10000;
  const std::size_t stride = record.size() / kEnough + 1;
  return Select(record, [&](std::size_t k) { return k % stride == 0; });
}

TEST(CurrentSignOnLogs, OfSimulatedCellsIsRightUnderNoiseAndWithoutRests) {
  Tally tally;
  for (const Record& log : SimulatedLogs()) tally.Take(log);
  tally.Print();
  const Judgements plain = Tally::Sum(tally.plain);
  EXPECT_EQ(plain.wrong, 0);
  EXPECT_EQ(plain.refused, 0);
  EXPECT_EQ(Tally::Sum(tally.others).wrong, 0);
}

// The short logs of fixtures/, a dozen rows each: little noise is enough to hide the sign of some.
TEST(CurrentSignOnLogs, OfMutatedFixturesIsRightOrRefused) {
  Tally tally;
  int read = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(test::SourcePath("fixtures/logs"))) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || name == "README.md" || name == "generate.py") continue;
    Record record;
    try {
      record = ReadLog(entry.path().string()).record;
    } catch (const LoadError&) {
      continue;  // it needs options to be read
    }
    ++read;
    tally.Take(record);
    EXPECT_EQ(Judge(record, "as recorded").right, 2) << record.file;
  }
  EXPECT_GE(read, 38);
  tally.Print();
  Judgements all = Tally::Sum(tally.plain);
  all += Tally::Sum(tally.others);
  EXPECT_EQ(all.wrong, 0);
  EXPECT_GT(all.right, all.refused);
}

TEST(CurrentSignOnLogs, OfMutatedLogsIsRightOrRefused) {
  const std::vector<Record> logs = LabLogs();
  if (logs.empty()) GTEST_SKIP() << kNoLabLogs;
  Tally tally;
  for (const Record& log : logs) tally.Take(Slower(log));
  tally.Print();
  const Judgements plain = Tally::Sum(tally.plain);
  const Judgements others = Tally::Sum(tally.others);
  EXPECT_EQ(plain.wrong + others.wrong, 0);
  // Pulse tests at 0 and -20 degC, whose voltage rises for hours after heavy pulses.
  EXPECT_LT(plain.refused, plain.all() / 100);
  // Most of these are pulses without the rests beside them, in which nothing is left to see.
  EXPECT_GT(others.right, others.all() / 2);
  for (const Record& log : logs) {  // all rows
    const Judgements whole = Judge(log, "all rows");
    EXPECT_EQ(whole.right, 2) << log.file;
  }
}

// The amount of a current that charges and discharges has no sign to be found; that of one
// direction has.
TEST(CurrentSignOnLogs, OfAmountsOfBothDirectionsIsRefused) {
  const std::vector<Record> logs = LabLogs();
  if (logs.empty()) GTEST_SKIP() << kNoLabLogs;
  int both_directions = 0;
  for (const Noise& noise : {Noise{}, Noise{.of_range = 0.005, .voltage_V = 1e-3}}) {
    for (const Record& log : logs) {
      Record amounts = log;
      for (double& i : amounts.current_A) i = std::abs(i);
      const CurrentSign found = FindSignFromPhysics(Noisy(amounts, noise, 11)).sign;
      const Extent extent = FindExtent(log.current_A);
      const double rest_A = kRestShare * LargestMagnitude(log.current_A);
      if (extent.least < -rest_A && extent.most > rest_A) {
        ++both_directions;
        EXPECT_EQ(found, CurrentSign::kUnclear) << log.file;
      } else {
        EXPECT_EQ(found,
                  extent.most > rest_A ? CurrentSign::kDischargePositive
                                       : CurrentSign::kDischargeNegative)
            << log.file;
      }
    }
  }
  EXPECT_GE(both_directions, 10);  // two pulse tests, three cycles
}

}  // namespace
}  // namespace lipoid
