// The readers of autopilots' logs: against rows that the autopilots' own programs read
// (fixtures/flights/*.csv, made by make.py), against logs written here by the description of their
// formats, and under damage.
#include "identify/logs/flight/autopilot_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <sstream>
#include <string>

#include "model/core/json.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

struct Row {
  int battery;
  double time_s, voltage_V, current_A;
};

std::vector<Row> RowsOf(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    Row row{};
    EXPECT_EQ(std::sscanf(line.c_str(),
                          "%d,%lf,%lf,%lf",
                          &row.battery,
                          &row.time_s,
                          &row.voltage_V,
                          &row.current_A),
              4)
        << line;
    rows.push_back(row);
  }
  return rows;
}

std::vector<Row> RowsOf(const AutopilotLog& log) {
  std::vector<Row> rows;
  for (const BatteryTrack& track : log.batteries) {
    for (std::size_t k = 0; k < track.size(); ++k)
      rows.push_back({track.number, track.time_s[k], track.voltage_V[k], track.current_A[k]});
  }
  return rows;
}

AutopilotLog Read(const std::string& bytes) {
  const AutopilotFormat* format = FindAutopilotFormat(bytes);
  EXPECT_NE(format, nullptr);
  return format->read(bytes);
}

// Both readers have the same integers and floats; only the multiplication by 1e-6 or 0.01 may round
// elsewhere.
constexpr double kRounding = 4e-16;

void ExpectSame(const std::vector<Row>& read, const std::vector<Row>& theirs) {
  ASSERT_EQ(read.size(), theirs.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    EXPECT_EQ(read[k].battery, theirs[k].battery) << k;
    EXPECT_NEAR(read[k].time_s, theirs[k].time_s, kRounding * theirs[k].time_s) << k;
    EXPECT_NEAR(read[k].voltage_V, theirs[k].voltage_V, kRounding * theirs[k].voltage_V) << k;
    EXPECT_NEAR(read[k].current_A, theirs[k].current_A, kRounding * std::abs(theirs[k].current_A))
        << k;
  }
}

struct Flight {
  const char* file;
  const char* rows;
  const char* format;
  const char* vehicle;
  std::size_t batteries;
  int cells;
  double capacity_Ah;
};

constexpr double kUnset = -1.0;

constexpr Flight kFlights[] = {{"esc_status_log.ulg",
                                "esc_status_log.csv",
                                "px4-ulog",
                                "PX4 1.9.0 on PX4_FMU_V3",
                                1,
                                6,
                                kUnset},
                               {"log171.bin",
                                "log171.csv",
                                "ardupilot-dataflash",
                                "APM:Copter V3.3-dev (ae3192b8), frame QUAD",
                                1,
                                0,
                                5.2},
                               {"quadrotor_local.ulg",
                                "quadrotor_local.csv",
                                "px4-ulog",
                                "PX4 1.16.1 on PX4_FMU_V6C",
                                1,
                                8,
                                kUnset},
                               {"sample_log_small.ulg",
                                "sample_log_small.csv",
                                "px4-ulog",
                                "PX4 1.11.2 on CUBEPILOT_CUBEORANGE",
                                2,
                                6,
                                30.0}};

void PrintTo(const Flight& flight, std::ostream* out) { *out << flight.file; }

std::string Fixture(const std::string& name) {
  return ReadTextFile(test::SourcePath("fixtures/flights/" + name));
}

class AutopilotLogs : public testing::TestWithParam<Flight> {};

TEST_P(AutopilotLogs, HaveTheRowsThatTheirOwnProgramsRead) {
  const Flight& flight = GetParam();
  const std::string bytes = Fixture(flight.file);
  EXPECT_EQ(FindAutopilotFormat(bytes)->name, flight.format);
  const AutopilotLog log = Read(bytes);
  ExpectSame(RowsOf(log), RowsOf(Fixture(flight.rows)));
  EXPECT_EQ(log.vehicle, flight.vehicle);
  EXPECT_EQ(log.batteries.size(), flight.batteries);
  EXPECT_EQ(log.batteries.front().cells, flight.cells);
  if (flight.capacity_Ah == kUnset) {
    EXPECT_TRUE(std::isnan(log.batteries.front().capacity_Ah));
  } else {
    EXPECT_DOUBLE_EQ(log.batteries.front().capacity_Ah, flight.capacity_Ah);
  }
  EXPECT_EQ(log.skipped_bytes, 0U);
  EXPECT_FALSE(log.cut_last_message);
}

// The fixtures were cut down by a program of ours: the whole logs must say the same.
TEST_P(AutopilotLogs, SayTheSameWhole) {
  const std::string path = test::LabDataPath(std::string("flights/") + GetParam().file);
  LIPOID_SKIP_WITHOUT(path);
  const AutopilotLog log = Read(ReadTextFile(path));
  ExpectSame(RowsOf(log), RowsOf(Fixture(GetParam().rows)));
  EXPECT_EQ(log.skipped_bytes, 0U);
}

TEST_P(AutopilotLogs, CutAnywhereKeepTheRowsBeforeTheCut) {
  const std::string bytes = Fixture(GetParam().file);
  const auto all = RowsOf(Fixture(GetParam().rows));
  std::mt19937_64 random(1);
  for (int n = 0; n < 40; ++n) {
    const std::size_t length =
        std::uniform_int_distribution<std::size_t>(200, bytes.size() - 1)(random);
    const AutopilotLog log = Read(bytes.substr(0, length));
    EXPECT_EQ(log.skipped_bytes, 0U) << length;
    std::size_t rows = 0;
    for (const BatteryTrack& track : log.batteries) rows += track.size();
    EXPECT_LE(rows, all.size());
    for (const Row& row : RowsOf(log)) {
      EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Row& other) {
        return other.battery == row.battery && std::abs(other.time_s - row.time_s) < 1e-9 &&
               (other.voltage_V == row.voltage_V ||
                std::abs(other.voltage_V - row.voltage_V) < 1e-12);
      }));
    }
  }
}

// Garbage between two messages costs no row, and is counted to the byte where no part of it looks
// like a message.
TEST_P(AutopilotLogs, PassOverGarbageBetweenMessages) {
  std::string bytes = Fixture(GetParam().file);
  const auto whole = RowsOf(Read(bytes));
  // A message is known to begin where the log still reads without a cut when it ends there.
  std::size_t at = bytes.size() / 2;
  while (Read(bytes.substr(0, at)).cut_last_message) ++at;
  bytes.insert(at, 100, '\0');
  const AutopilotLog log = Read(bytes);
  ExpectSame(RowsOf(log), whole);
  EXPECT_EQ(log.skipped_bytes, 100U);
  EXPECT_EQ(log.damaged_places, 1U);
}

TEST_P(AutopilotLogs, SurviveFlippedBytes) {
  const std::string intact = Fixture(GetParam().file);
  const std::size_t rows = RowsOf(Fixture(GetParam().rows)).size();
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    std::mt19937_64 random(seed);
    std::string bytes = intact;
    // Not in the first part, which says what everything means.
    std::uniform_int_distribution<std::size_t> place(bytes.size() / 2, bytes.size() - 1);
    for (int n = 0; n < 5; ++n) bytes[place(random)] = static_cast<char>(random());
    const std::size_t read = RowsOf(Read(bytes)).size();
    EXPECT_LE(read, rows + 5) << seed;
    // Each byte costs its message, and where it was a length at most what it claims.
    EXPECT_GE(read + 5 * 12, rows) << seed;
  }
}

TEST_P(AutopilotLogs, SurviveAnything) {
  const std::string intact = Fixture(GetParam().file);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 random(seed);
    std::string bytes = intact.substr(0, 4000);
    std::uniform_int_distribution<std::size_t> place(8, bytes.size() - 1);
    for (int n = 0; n < 200; ++n) bytes[place(random)] = static_cast<char>(random());
    const AutopilotLog log = Read(bytes);
    EXPECT_LE(log.skipped_bytes, bytes.size()) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(All, AutopilotLogs, testing::ValuesIn(kFlights));

TEST(AutopilotLogs, EndsInsideItsLastMessage) {
  const std::string path = test::LabDataPath("flights/backend_log_80k.bin");
  LIPOID_SKIP_WITHOUT(path);
  const AutopilotLog log = Read(ReadTextFile(path));
  EXPECT_TRUE(log.cut_last_message);
  ASSERT_EQ(log.batteries.size(), 1U);
  // As pymavlink reads them.
  EXPECT_EQ(log.batteries[0].voltage_V.size(), 4U);
  EXPECT_EQ(log.batteries[0].voltage_V[0], 16.434377670288086);
  EXPECT_EQ(log.batteries[0].current_A[0], 0.045277439057826996);
  EXPECT_EQ(log.vehicle, "ArduCopter V4.6.2 (1ebd4d99), frame QUAD/X");
}

// A log in the making, by the description of the format.
class Writer {
 public:
  explicit Writer(std::string bytes) : bytes_(std::move(bytes)) {}
  template <class T>
  Writer& Number(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
    return *this;
  }
  Writer& Text(std::string_view text, std::size_t width = 0) {
    bytes_ += text;
    if (width > text.size()) bytes_.append(width - text.size(), '\0');
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class ULogWriter {
 public:
  ULogWriter() : log_(std::string("ULog\x01\x12\x35\x01", 8)) { log_.Number<std::uint64_t>(0); }
  void Message(char type, const std::string& payload) {
    log_.Number(static_cast<std::uint16_t>(payload.size())).Number(type).Text(payload);
  }
  [[nodiscard]] const std::string& bytes() const { return log_.bytes(); }

 private:
  Writer log_;
};

TEST(ULog, HasNestedFormatsInstancesAndUnknownValues) {
  ULogWriter log;
  log.Message('F', "inner:uint16_t a;float[2] b;uint8_t[2] _padding0;");
  log.Message('F',
              "battery_status:uint64_t timestamp;inner[2] inside;float current_a;float voltage_v;"
              "float temperature;uint8_t cell_count;uint8_t[7] _padding0;");
  log.Message('?', "of a later version");  // damaged, as far as this reader can know
  log.Message(
      'A',
      Writer("").Number<std::uint8_t>(1).Number<std::uint16_t>(7).Text("battery_status").bytes());
  log.Message(
      'A',
      Writer("").Number<std::uint8_t>(0).Number<std::uint16_t>(9).Text("battery_status").bytes());
  const auto data = [&](std::uint16_t id, std::uint64_t time_us, float current_A, float voltage_V) {
    Writer payload("");
    payload.Number(id).Number(time_us);
    for (int k = 0; k < 2; ++k)
      payload.Number<std::uint16_t>(1).Number(2.0F).Number(3.0F).Number<std::uint16_t>(0);
    payload.Number(current_A).Number(voltage_V).Number(21.5F).Number<std::uint8_t>(4);
    log.Message('D', payload.bytes());  // its last padding is left out, as PX4 does
  };
  data(7, 1'500'000, 2.5F, 12.25F);
  data(9, 1'600'000, -1.0F, 11.0F);
  data(7, 2'500'000, 0.0F, 12.5F);
  log.Message('O', Writer("").Number<std::uint16_t>(250).bytes());
  const AutopilotLog read = Read(log.bytes());
  ASSERT_EQ(read.batteries.size(), 2U);
  const BatteryTrack& second = read.batteries[1];
  EXPECT_EQ(second.number, 2);
  EXPECT_EQ(second.time_s, (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(second.current_A, (std::vector<double>{2.5, 0.0}));
  EXPECT_EQ(second.voltage_V, (std::vector<double>{12.25, 12.5}));
  EXPECT_EQ(second.temperature_degC, (std::vector<double>{21.5, 21.5}));
  EXPECT_EQ(second.cells, 4);
  const BatteryTrack& first = read.batteries[0];
  EXPECT_EQ(first.number, 1);
  EXPECT_TRUE(std::isnan(first.current_A.at(0)));  // -1 is PX4's word for unknown
  EXPECT_EQ(read.dropouts, 1U);
  EXPECT_DOUBLE_EQ(read.dropped_out_s, 0.25);
  EXPECT_EQ(read.damaged_places, 1U);
}

TEST(ULog, FormatsThatNestThemselvesEndSomewhere) {
  ULogWriter log;
  log.Message(
      'F', "battery_status:uint64_t timestamp;battery_status[9999999999] again;float voltage_v;");
  log.Message(
      'A',
      Writer("").Number<std::uint8_t>(0).Number<std::uint16_t>(1).Text("battery_status").bytes());
  log.Message('D', Writer("").Number<std::uint16_t>(1).Number<std::uint64_t>(1'000'000).bytes());
  const AutopilotLog read = Read(log.bytes());
  ASSERT_EQ(read.batteries.size(), 1U);
  EXPECT_TRUE(std::isnan(read.batteries[0].voltage_V.at(0)));
}

// Formats of nothing but one another: each level names the one below two thousand times.
TEST(ULog, FormatsWithoutANumberEndSoon) {
  ULogWriter log;
  log.Message('F', "level0:uint8_t[0] nothing;");
  for (int level = 1; level <= 7; ++level) {
    std::string fields = "level" + std::to_string(level) + ":";
    for (int k = 0; k < 2000; ++k) fields += "level" + std::to_string(level - 1) + " a;";
    log.Message('F', fields);
  }
  log.Message('F', "battery_status:uint64_t timestamp;level7 deep;float voltage_v;");
  log.Message(
      'A',
      Writer("").Number<std::uint8_t>(0).Number<std::uint16_t>(1).Text("battery_status").bytes());
  log.Message(
      'D',
      Writer("").Number<std::uint16_t>(1).Number<std::uint64_t>(1'000'000).Number(12.0F).bytes());
  const AutopilotLog read = Read(log.bytes());
  ASSERT_EQ(read.batteries.size(), 1U);
  EXPECT_EQ(read.batteries[0].time_s.at(0), 1.0);
  EXPECT_TRUE(std::isnan(read.batteries[0].voltage_V.at(0)));
}

// Numbers of a battery that no battery has are passed over, and a second subscription loses no row.
TEST(ULog, CountsOfCellsThatCannotBeAreNone) {
  ULogWriter log;
  log.Message('F', "battery_status:uint64_t timestamp;float voltage_v;float cell_count;");
  const auto subscribe = [&] {
    log.Message(
        'A',
        Writer("").Number<std::uint8_t>(0).Number<std::uint16_t>(1).Text("battery_status").bytes());
  };
  const auto data = [&](float cells) {
    log.Message('D',
                Writer("")
                    .Number<std::uint16_t>(1)
                    .Number<std::uint64_t>(1'000'000)
                    .Number(12.0F)
                    .Number(cells)
                    .bytes());
  };
  subscribe();
  data(1e30F);
  data(std::nanf(""));
  subscribe();
  data(-3.0F);
  const AutopilotLog read = Read(log.bytes());
  ASSERT_EQ(read.batteries.size(), 1U);
  EXPECT_EQ(read.batteries[0].size(), 3U);
  EXPECT_EQ(read.batteries[0].cells, 0);
}

void AddFormat(Writer& log,
               int type,
               int length,
               std::string_view name,
               std::string_view format,
               std::string_view names) {
  log.Text("\xA3\x95\x80")
      .Number(static_cast<std::uint8_t>(type))
      .Number(static_cast<std::uint8_t>(length));
  log.Text(name, 4).Text(format, 16).Text(names, 64);
}

TEST(DataFlash, HasInstancesHundredthsAndHalfPrecision) {
  Writer log("");
  AddFormat(log, 128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
  AddFormat(log, 10, 3 + 8 + 1 + 4 + 2 + 2, "BAT", "QBfgc", "TimeUS,Inst,Volt,Curr,Temp");
  AddFormat(log, 11, 3 + 4 + 2 + 2, "CUR2", "IhH", "TimeMS,Volt,Curr");
  const auto head = [&](int type) { log.Text("\xA3\x95").Number(static_cast<std::uint8_t>(type)); };
  head(10);
  log.Number<std::uint64_t>(3'000'000)
      .Number<std::uint8_t>(2)
      .Number(15.5F)
      .Number<std::uint16_t>(0x4d00)
      .Number<std::int16_t>(-1250);
  head(11);
  log.Number<std::uint32_t>(4000).Number<std::int16_t>(1234).Number<std::uint16_t>(56);
  const AutopilotLog read = Read(log.bytes());
  ASSERT_EQ(read.batteries.size(), 2U);
  EXPECT_EQ(read.batteries[0].number, 2);
  EXPECT_DOUBLE_EQ(read.batteries[0].voltage_V.at(0), 12.34);
  EXPECT_DOUBLE_EQ(read.batteries[0].current_A.at(0), 0.56);
  EXPECT_EQ(read.batteries[1].number, 3);
  EXPECT_EQ(read.batteries[1].time_s.at(0), 3.0);
  EXPECT_EQ(read.batteries[1].current_A.at(0), 20.0);  // 0x4d00: 1.25 times 2^4
  EXPECT_DOUBLE_EQ(read.batteries[1].temperature_degC.at(0), -12.5);
}

TEST(AutopilotFormats, AreSortedAndNoTextIsOneOfThem) {
  const auto formats = AutopilotFormats();
  EXPECT_TRUE(std::is_sorted(formats.begin(), formats.end(), [](const auto& a, const auto& b) {
    return a.name < b.name;
  }));
  for (const char* text : {"", "ULog", "time_s,current_A,voltage_V\n0,1,2\n", "\xA3\x95"})
    EXPECT_EQ(FindAutopilotFormat(text), nullptr) << text;
}

}  // namespace
}  // namespace lipoid
