// lipoid health, as a user runs it.
#include "identify/health/health.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "model/core/json.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/synthetic_flight.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

// A pack of four cells and 5.2 Ah, against the curve of a shipped cell.
auto HealthOf4SPack(const std::string& folder, const std::vector<std::string>& more) {
  std::vector<std::string> all{
      "health", "--cell", "gifi-600mAh-1", "--capacity-Ah", "5.2", "--series", "4"};
  all.insert(all.end(), more.begin(), more.end());
  return RunLipoid(folder, all);
}

TEST(Health, OfASoloFlightSaysWhatItTells) {
  const std::string folder = TestFolder();
  const auto run = HealthOf4SPack(folder, {FlightFixture("log171.bin"), "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.find("capacity "), 0U) << run.out;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_TRUE(summary.at("reference").at("typical"));
  EXPECT_EQ(summary.at("trend"), nullptr);
  const Json flight = summary.at("flights").at(0);
  EXPECT_LT(flight.at("mean_error_percent").get<double>(), 0.5);
  // It rested at 16.53 V, 4.13 V a cell, where the shipped curve is at 0.92; between rests 729 mAh
  // left.
  EXPECT_NEAR(flight.at("soc_start").get<double>(), 0.92, 0.04);
  EXPECT_NEAR(flight.at("charge_Ah").get<double>(), 0.729, 0.001);
  // A seventh of the charge says little of the whole: not known, or within wide limits that hold
  // what is printed on the pack.
  if (!flight.at("capacity_Ah").is_null()) {
    EXPECT_LT(flight.at("capacity_interval_95").at(0).get<double>(), 5.2);
    EXPECT_GT(flight.at("capacity_interval_95").at(1).get<double>(), 5.2);
  }
  // From rest at 16.51 V and 0.6 A the take-off falls to 15.86 V at 12.9 A within 8 s, and most of
  // that at once: between 30 and 55 milliohm.
  EXPECT_GT(flight.at("resistance_interval_95").at(0).get<double>(), 0.025);
  EXPECT_LT(flight.at("resistance_interval_95").at(1).get<double>(), 0.055);
}

// The Solo's pack is one of 5.2 Ah.
TEST(Health, NoPackGrows) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--capacity-Ah",
                              "1",
                              "--series",
                              "4",
                              FlightFixture("log171.bin")});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_NE(OnOneLine(run.out).find("no pack grows: does the new one hold more than 1 Ah"),
            std::string::npos)
      << run.out;
  EXPECT_NE(OnOneLine(run.out).find("wrong? By the fit: "), std::string::npos) << run.out;
}

TEST(Health, RefusesAirInFahrenheit) {
  const auto run =
      HealthOf4SPack(TestFolder(), {FlightFixture("log171.bin"), "--ambient-degC", "77"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("--ambient-degC: expected -60 .. 60, found '77'"), std::string::npos)
      << run.err;
}

// The log is the reference's own prediction: of a cell with a charge transfer and tables, near full.
TEST(Health, AnUnchangedCellHasTheResistanceOfNew) {
  const std::string folder = TestFolder();
  std::string current = "time_s,current_A\n";
  for (int k = 0; k <= 600; ++k)
    current += fmt::format("{},{}\n", k, k < 10 ? 0.0 : 1.0 + 3.0 * ((k / 20) % 2));
  WriteText(folder + "/i.csv", current);
  const std::string cell = folder + "/cell.json";
  const auto identified = RunLipoid(
      folder,
      {"identify", SourcePath("fixtures/lab/dmegc_inr18650_26_r1/campaign.toml"), "-o", cell});
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  const auto made = RunLipoid(folder, {"simulate", cell, "--current", "i.csv", "-o", "flight.csv"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto run = RunLipoid(
      folder, {"health", "--cell", cell, "--series", "1", "flight.csv", "--summary", "s.json"});
  const Json flight = ReadJson(folder, "s.json").at("flights").at(0);
  const double new_Ohm = flight.at("new_resistance_Ohm");
  // At once is r_s and the charge transfer, at the state of charge of the flight: r_s at half would be a sixth of it.
  // The scale of the current sensor is not known to 5 %, and moves the estimate by as much.
  EXPECT_NEAR(flight.at("resistance_Ohm").get<double>(), new_Ohm, 0.15 * new_Ohm) << run.out;
  EXPECT_LT(flight.at("resistance_interval_95").at(0), new_Ohm);
  EXPECT_GT(flight.at("resistance_interval_95").at(1), new_Ohm);
}

// A pack that is charged 0.15 V higher than the reference begins beyond its full.
TEST(Health, TakesNoLimitOfTheStartForACapacity) {
  const std::string folder = TestFolder();
  std::string current = "time_s,current_A\n";
  for (int k = 0; k <= 900; ++k)
    current += fmt::format("{},{}\n", k, k < 2 ? 0.0 : 30.0 + 60.0 * ((k / 20) % 2));
  WriteText(folder + "/i.csv", current);
  const std::string cell = "grepow-32Ah-1";
  const auto made = RunLipoid(
      folder, {"simulate", cell, "--current", "i.csv", "--ambient-degC", "25", "-o", "flight.csv"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Record flown = ReadPlainCsv(folder + "/flight.csv");
  const auto health_of = [&](double higher_V, double noise_V) {
    NormalNoise normal(1, 0);
    std::string log = "time_s,current_A,voltage_V\n";
    for (std::size_t k = 0; k < flown.size(); ++k) {
      log += fmt::format("{},{},{:.6f}\n",
                         flown.time_s[k],
                         flown.current_A[k],
                         flown.voltage_V[k] + higher_V + noise_V * normal());
    }
    WriteText(folder + "/log.csv", log);
    return RunLipoid(folder,
                     {"health",
                      "--cell",
                      cell,
                      "--capacity-Ah",
                      "32",
                      "--series",
                      "1",
                      "--ambient-degC",
                      "25",
                      "log.csv",
                      "--summary",
                      "s.json"});
  };
  const auto flight = [&] { return ReadJson(folder, "s.json").at("flights").at(0); };
  constexpr double kNoise_V = 0.002;
  const auto as_it_is = health_of(0.0, kNoise_V);
  EXPECT_EQ(as_it_is.exit_code, 0) << as_it_is.out;
  EXPECT_NEAR(flight().at("soc_start").get<double>(), 1.0, 0.02);
  EXPECT_NE(flight().dump().find("the log rests for less than 3 s before its load"),
            std::string::npos);
  const auto higher = health_of(0.15, kNoise_V);
  EXPECT_EQ(flight().at("capacity_Ah"), nullptr) << higher.out;
  EXPECT_NE(flight().dump().find("the pack is charged higher than the reference was"),
            std::string::npos)
      << flight().dump();
  // Without noise a sensor that shows twice of what flows makes up for the last tenth of a millivolt: it
  // was half of the capacity, with an interval that missed the truth.
  const auto exact = health_of(0.0, 0.0);
  EXPECT_EQ(exact.exit_code, 1);
  EXPECT_NE(OnOneLine(exact.out).find("the current sensor would have to show 2 times what flows"),
            std::string::npos)
      << exact.out;
}

// Steps of the altitude whose pack did not warm, while the reference is taken to: the sensor would have to be off
// by 2 A, seven times what such sensors are. It was 113 % of the capacity with an interval that missed the truth.
TEST(Health, DoubtsAnOffsetThatNoSensorHas) {
  const std::string folder = TestFolder();
  const std::vector<std::string> pack{"--cell", "gifi-600mAh-1", "--series", "4"};
  std::vector<std::string> fly{"fly", "altitude-steps", "--vehicle", "f450", "--parallel", "9"};
  fly.insert(fly.end(), pack.begin(), pack.end());
  fly.insert(fly.end(),
             {"--duration",
              "700",
              "--log-step-s",
              "0.1",
              "--set",
              "altitude-steps.high_m=6",
              "--set",
              "altitude-steps.every_s=15",
              "--ambient-degC",
              "25",
              "-o",
              "f.csv"});
  const auto flown = RunLipoid(folder, fly);
  ASSERT_EQ(flown.exit_code, 0) << flown.out << flown.err;
  // The log of a recorder that has no thermometer: without the last column.
  std::istringstream with(ReadText(folder + "/f.csv"));
  std::string without;
  for (std::string row; std::getline(with, row);) without += row.substr(0, row.rfind(',')) + "\n";
  ASSERT_EQ(without.substr(0, without.find('\n')).find("temperature_degC"), std::string::npos);
  std::ofstream(folder + "/f.csv") << without;
  std::vector<std::string> ask{"health", "f.csv", "--capacity-Ah", "3.384"};
  ask.insert(ask.end(), pack.begin(), pack.end());
  ask.insert(ask.end(), {"--ambient-degC", "25", "--current-scale-uncertainty", "0.01"});
  const auto run = RunLipoid(folder, ask);
  EXPECT_EQ(run.exit_code, 1) << run.out << run.err;
  // Seven times what the sensor is right to: the tenth of an ampere is the search's.
  const std::string words = OnOneLine(run.out);
  const std::string before = "the current sensor would have to show ";
  const std::size_t place = words.find(before);
  ASSERT_NE(place, std::string::npos) << run.out;
  const std::string shown = words.substr(place + before.size());
  std::size_t digits = 0;
  EXPECT_NEAR(std::stod(shown, &digits), -1.95, 0.2) << run.out;
  EXPECT_TRUE(shown.substr(digits).starts_with(" A where none flows")) << run.out;
}

// A second battery five minutes later on one clock, and a voltage that never moves.
TEST(Health, RefusesGapsAndFlatVoltages) {
  const std::string folder = TestFolder();
  std::string gap = "time_s,current_A,voltage_V\n";
  std::string flat = gap;
  for (int k = 0; k < 300; ++k) {
    const double current_A = k < 5 ? 0.0 : 8.0 + (k / 10) % 3;
    gap += fmt::format(
        "{},{},{:.3f}\n", k < 150 ? k : k + 300, current_A, 16.6 - 0.03 * current_A - 0.002 * k);
    flat += fmt::format("{},{},16\n", k, current_A);
  }
  WriteText(folder + "/gap.csv", gap);
  WriteText(folder + "/flat.csv", flat);
  const auto health = [&](const std::string& file) {
    return HealthOf4SPack(folder, {"--current-sign", "discharge-positive", file});
  };
  const auto of_gap = health("gap.csv");
  EXPECT_EQ(of_gap.exit_code, 3) << of_gap.out << of_gap.err;
  EXPECT_NE(of_gap.err.find("read the part before it (end_s = 149)"), std::string::npos)
      << of_gap.err;
  const auto of_flat = health("flat.csv");
  EXPECT_EQ(of_flat.exit_code, 3);
  EXPECT_NE(
      of_flat.err.find(
          "expected a voltage that falls under load, found 16 V throughout while the current goes from "
          "0 A to 10 A"),
      std::string::npos)
      << of_flat.err;
}

TEST(Health, OfARacerAgreesWithItsEdges) {
  const std::string file = LabDataPath("flights/predictive-bms_30.csv");
  LIPOID_SKIP_WITHOUT(file);
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--capacity-Ah",
                              "1.5",
                              "--series",
                              "4",
                              file,
                              "--columns",
                              "time_s=1",
                              "voltage_V=2",
                              "current_A=7",
                              "--units",
                              "ms,mA,V",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json flight = ReadJson(folder, "s.json").at("flights").at(0);
  EXPECT_LT(flight.at("mean_error_percent").get<double>(), 0.5);
  // Changes of more than 5 A from row to row in the first 9 s of the flight, 35 of them, show 22 to 23
  // milliohm; later ones less, because the pack warms.
  constexpr double kEdges_Ohm = 0.0225;
  EXPECT_NEAR(flight.at("resistance_Ohm").get<double>(), kEdges_Ohm, 0.15 * kEdges_Ohm);
  // 1.035 Ah left between rests at 4.14 V and 3.74 V a cell, 0.93 and 0.30 on the shipped curve: 1.64 Ah.
  EXPECT_LT(flight.at("capacity_interval_95").at(0).get<double>(), 1.64);
  EXPECT_GT(flight.at("capacity_interval_95").at(1).get<double>(), 1.64);
}

TEST(Health, RefusesWhatSaysNothing) {
  const auto brief = RunLipoid(TestFolder(),
                               {"health",
                                "--cell",
                                "gifi-600mAh-1",
                                "--battery",
                                "2",
                                FlightFixture("sample_log_small.ulg")});
  EXPECT_EQ(brief.exit_code, 3);
  EXPECT_NE(brief.err.find("expected a flight of at least 20 s, found 6 s"), std::string::npos)
      << brief.err;
  std::string idle = "time_s,voltage_V,current_A\n";
  for (int k = 0; k < 100; ++k) {
    idle += std::to_string(k);
    idle += k % 2 == 0 ? ",4.0,0.01\n" : ",3.99,0.02\n";
  }
  const auto flown = [](const std::string& file, const std::string& rows) {
    return RunLipoid(TestFolder(),
                     {"health",
                      "--cell",
                      "gifi-600mAh-1",
                      "--series",
                      "1",
                      "--current-sign",
                      "discharge-positive",
                      WriteText(file, rows)});
  };
  const auto calm = flown("idle.csv", idle);
  EXPECT_EQ(calm.exit_code, 3);
  EXPECT_NE(calm.err.find("too idle to say anything of the pack"), std::string::npos) << calm.err;
  std::string wired = "time_s,voltage_V,current_A\n";
  for (int k = 0; k < 400; ++k)
    wired += std::to_string(k) + (k % 2 == 0 ? ",4.0,-0.5\n" : ",3.9,-1.5\n");
  const auto backwards = flown("wired.csv", wired);
  EXPECT_EQ(backwards.exit_code, 3);
  EXPECT_NE(
      OnOneLine(backwards.err)
          .find(
              "expected a flight that takes charge from its pack, found one that charges it by 0.111 Ah, with "
              "up to 1.5 A: a sensor that is wired backwards?"),
      std::string::npos)
      << backwards.err;
}

// 0.6 Ah of a pack of some 20 Ah, 39 s long and never at rest: nobody says how large it is, and the
// flight does not either.
TEST(Health, GuessesNoCapacityFromATypicalCurve) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--series",
                              "6",
                              FlightFixture("esc_status_log.ulg"),
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  constexpr double kOfThePack_Ah = 20.0;  // 609 mAh for 3 % by the autopilot's own counter
  const Json& flight = summary.at("flights")[0];
  if (!flight.at("capacity_Ah").is_null()) {
    EXPECT_GE(flight.at("capacity_interval_95")[1].get<double>(), kOfThePack_Ah);
  }
  EXPECT_TRUE(summary.at("reference").at("capacity_Ah").is_null());
  EXPECT_NE(run.out.find("give --capacity-Ah"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("% of new"), std::string::npos) << run.out;
}

// 5.2 Ah in mAh: a flight at 2.5 C then looks idle.
TEST(Health, AsksWhetherACapacityIsInmAh) {
  const auto run = RunLipoid(TestFolder(),
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5200",
                              FlightFixture("log171.bin")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("is the capacity in mAh, where Ah are expected? Of 5.2 Ah"),
            std::string::npos)
      << run.err;
}

// Nobody says how large the pack is: no capacity is called that of the new one.
TEST(Health, CallsNoGuessTheNewPack) {
  const auto run = RunLipoid(TestFolder(),
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--series",
                              "10",
                              FlightFixture("quadrotor_local.ulg"),
                              FlightFixture("esc_status_log.ulg")});
  EXPECT_NE(run.out.find("ended at its limit"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("of the new pack"), std::string::npos) << run.out;
}

// A reference of the wrong size: that is said, and no capacity made of it.
TEST(Health, SaysThatTheReferenceIsNotOfThisSize) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "0.4",
                              FlightFixture("log171.bin"),
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json flight = ReadJson(folder, "s.json").at("flights")[0];
  EXPECT_TRUE(flight.at("capacity_Ah").is_null()) << flight.dump();
  EXPECT_NE(flight.at("capacity_unknown_because").get<std::string>().find("--capacity-Ah"),
            std::string::npos)
      << flight.dump();
}

// A pack of 4/5 of the capacity and 3/2 of the resistance, flown from 25 degC.
Log FlightOfAnOldPack(const std::string& name, const FlightPlan& plan = {}) {
  Cell cell = WithTypicalTemperature(NewFlightCell());
  cell.diffusion->alpha_C *= 0.8;
  cell.series_resistance_Ohm = 1.5 * cell.series_resistance_Ohm(0.5);
  cell.branches[0].resistance_Ohm = 1.5 * cell.branches[0].resistance_Ohm(0.5);
  return FlyAndLog(cell, 4, plan, LikePx4(), name).log;
}

FlightHealth HealthOfAnOldPack(const Record& record) {
  Log log;
  log.record = record;
  HealthOptions options;
  options.series = 4;
  options.ambient_degC = 25.0;
  return AssessHealth(NewFlightCell(), {log}, options).flights.at(0);
}

// The records one after the other, with this much time between them.
Record Joined(Record first, const Record& second, double apart_s) {
  const double later_s = first.time_s.back() + apart_s - second.time_s.front();
  for (std::size_t k = 0; k < second.size(); ++k) {
    first.time_s.push_back(second.time_s[k] + later_s);
    first.current_A.push_back(second.current_A[k]);
    first.voltage_V.push_back(second.voltage_V[k]);
  }
  return first;
}

Record RowsOf(const Record& record, double from_s, double to_s) {
  Record part;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (record.time_s[k] < from_s || record.time_s[k] > to_s) continue;
    part.time_s.push_back(record.time_s[k]);
    part.current_A.push_back(record.current_A[k]);
    part.voltage_V.push_back(record.voltage_V[k]);
  }
  return part;
}

// Two flights with a recharge in between, however the first one ends, look like one pack of twice the capacity.
TEST(Health, SeesThatAnotherPackWasPluggedIn) {
  const Record whole = FlightOfAnOldPack("whole").record;
  const Record cut = RowsOf(whole, 0.0, 200.0);  // ends under load
  for (const Record& both : {Joined(whole, whole, 60.0), Joined(cut, whole, 0.2)}) {
    const FlightHealth health = HealthOfAnOldPack(both);
    EXPECT_NE(health.doubted_because.find("which no current of this log explains"),
              std::string::npos)
        << health.doubted_because;
    EXPECT_NE(health.doubted_because.find("give the rows before and those after as two files"),
              std::string::npos);
    EXPECT_FALSE(health.capacity_Ah.known());
  }
  // A hole in the rows of one flight is none.
  EXPECT_EQ(HealthOfAnOldPack(Joined(cut, RowsOf(whole, 201.0, 1e9), 1.0)).doubted_because, "");
}

// A flight on a pack that begins lower than the one before ended gave 1.21 Ah (0.95 to 1.55) of 1.75.
TEST(Health, SeesThatAnEmptierPackWasPluggedIn) {
  const Record full = FlightOfAnOldPack("full", {.charge_share = 0.15}).record;
  const Record lower = FlightOfAnOldPack("lower", {.start_soc = 0.5, .charge_share = 0.3}).record;
  const FlightHealth health = HealthOfAnOldPack(Joined(full, lower, 0.2));
  EXPECT_TRUE(health.doubted_because.starts_with("the voltage falls at once by 0."))
      << health.doubted_because;
  EXPECT_NE(health.doubted_because.find(
                "a contact or a cell that fails, or another flight or pack, begins there"),
            std::string::npos);
  EXPECT_FALSE(health.capacity_Ah.known());
  // A pack that is flown empty falls fast, too.
  EXPECT_EQ(
      HealthOfAnOldPack(FlightOfAnOldPack("empty", {.charge_share = 0.93}).record).doubted_because,
      "");
}

// After 200 s the pack is 20 K warmer than the air, and its resistance half.
TEST(Health, ACutFlightDoesNotBeginAtTheTemperatureOfTheAir) {
  const Record whole = FlightOfAnOldPack("whole").record;
  const FlightHealth all = HealthOfAnOldPack(whole);
  const FlightHealth cut = HealthOfAnOldPack(RowsOf(whole, 200.0, 1e9));
  EXPECT_LT(cut.resistance_Ohm.low, all.resistance_Ohm.value);
  EXPECT_GT(cut.resistance_Ohm.high, all.resistance_Ohm.value);
  const auto says = [](const FlightHealth& health) {
    return std::any_of(health.cautions.begin(), health.cautions.end(), [](const auto& caution) {
      return caution.find("how warm the pack was then is not known") != std::string::npos;
    });
  };
  EXPECT_TRUE(says(cut));
  EXPECT_FALSE(says(all));
}

// The pack warms by 20 K and more, and loses a third of its resistance on the way.
TEST(Health, SeesThatAThermometerIsStuck) {
  const Record whole = FlightOfAnOldPack("whole").record;
  const double truth_Ohm = HealthOfAnOldPack(whole).resistance_Ohm.value;
  Record stuck = whole;
  stuck.temperature_degC = Column(stuck.size(), 25.0);
  const FlightHealth health = HealthOfAnOldPack(stuck);
  EXPECT_LT(health.resistance_Ohm.low, truth_Ohm);
  EXPECT_GT(health.resistance_Ohm.high, truth_Ohm);
  const auto says = [](const FlightHealth& of) {
    return std::any_of(of.cautions.begin(), of.cautions.end(), [](const auto& caution) {
      return caution.starts_with("the temperature of the log hardly moves");
    });
  };
  EXPECT_TRUE(says(health));
  // One that follows the pack is believed.
  const Record followed = FlyAndLog(WithTypicalTemperature(NewFlightCell()),
                                    4,
                                    {},
                                    {.temperature_step_degC = 0.1},
                                    "followed")
                              .log.record;
  EXPECT_FALSE(says(HealthOfAnOldPack(followed)));
}

// With 50 Ah for 5 this flight fits a hardly used pack nearly as well, and only what was said of the capacity is for it.
TEST(Health, DoesNotConfirmACapacityThatIsTenTimesTooLarge) {
  const SyntheticFlight flight =
      FlyAndLog(NewFlightCell(), 4, {.charge_share = 0.65}, LikePx4(), "flight");
  HealthOptions options;
  options.series = 4;
  options.ambient_degC = 25.0;
  options.capacity_Ah = 50.0;
  const FlightHealth health = AssessHealth(NewFlightCell(), {flight.log}, options).flights.at(0);
  EXPECT_FALSE(health.capacity_Ah.known()) << health.capacity_Ah.value;
  EXPECT_NE(health.capacity_Ah.unknown_because.find("give the right capacity"), std::string::npos)
      << health.capacity_Ah.unknown_because;
}

// With 50 Ah for 5 and a resistance that hides how the voltage falls this flight ended at 80 % of the charge; the pack
// rests for 50 s where the reference has 17 %.
TEST(Health, APackThatRestsEmptierThanTheFitIsNoneOfThisCapacity) {
  Cell old = NewFlightCell();
  old.series_resistance_Ohm = 0.012;
  old.branches = {{Resistance<double>(0.0045), 60.0, {}}};
  const FlightPlan plan{.charge_share = 0.7, .rest_after_s = 50.0, .unrest = 0.2};
  const auto health = [&](const Cell& truth, double capacity_Ah) {
    HealthOptions options;
    options.series = 4;
    options.capacity_Ah = capacity_Ah;
    const Log log = FlyAndLog(truth, 4, plan, LikePx4(), "flight").log;
    return AssessHealth(LoadCell("gifi-600mAh-1"), {log}, options).flights.at(0);
  };
  const FlightHealth wrong = health(old, 50.0);
  EXPECT_NE(wrong.doubted_because.find(
                "a cell after the flight, where the reference has 17 % of its charge"),
            std::string::npos)
      << wrong.doubted_because;
  EXPECT_FALSE(wrong.capacity_Ah.known());
  EXPECT_FALSE(wrong.soc_end.known());
  EXPECT_EQ(health(NewFlightCell(), 5.0).doubted_because, "");
}

// From the middle of a flight on, under load: one capacity would call for another, and that for the
// first.
TEST(Health, TakesNoLimitOfTheSearchForACapacity) {
  const std::string all = LabDataPath("flights/predictive-bms_30.csv");
  LIPOID_SKIP_WITHOUT(all);
  const std::string folder = TestFolder();
  const std::string text = ReadText(all);
  std::size_t from = text.size();
  for (int row = 0; row <= 2500; ++row) from = text.rfind('\n', from - 1);
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--capacity-Ah",
                              "1.5",
                              "--series",
                              "4",
                              WriteText("tail.csv", text.substr(from + 1)),
                              "--columns",
                              "time_s=1",
                              "voltage_V=2",
                              "current_A=7",
                              "--units",
                              "ms,mA,V"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("this flight does not tell it"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("give the right capacity"), std::string::npos) << run.out;
}

// The pack of log171.bin has four cells and rests at 16.53 V before the flight: no cell of a smaller or larger pack
// does, which is known without a fit.
TEST(Health, SaysThatTheRestIsThatOfAnotherNumberOfCells) {
  const std::string folder = TestFolder();
  for (const auto& [series, says] :
       {std::pair{
            "3",
            "rests at 5.51 V a cell before the flight, where the reference has 4.2 V when full"},
        {"5",
         "rests at 3.31 V a cell before the flight, where the reference has 2.2 % of its charge"},
        {"8", "rests at 2.07 V a cell"}}) {
    const auto run = RunLipoid(folder,
                               {"health",
                                "--cell",
                                "gifi-600mAh-1",
                                "--series",
                                series,
                                "--capacity-Ah",
                                "5.2",
                                FlightFixture("log171.bin"),
                                "--summary",
                                "s.json"});
    EXPECT_EQ(run.exit_code, 1) << run.err;
    const std::string first = run.out.substr(0, run.out.find('\n'));
    EXPECT_NE(first.find(says), std::string::npos) << first;
    EXPECT_NE(first.find("is --series (now " + std::string(series) +
                         ") wrong? The voltage looks like that of 4 cells"),
              std::string::npos)
        << first;
    const Json flight = ReadJson(folder, "s.json").at("flights")[0];
    for (const char* quantity : {"soc_start", "soc_end", "capacity", "resistance", "current_scale"})
      EXPECT_TRUE(flight.at(std::string(quantity) + "_interval_95").is_null()) << flight.dump();
    EXPECT_TRUE(flight.at("doubted_because").is_string()) << flight.dump();
  }
}

// A flight that hardly tells its state of charge: twice its error above is more than a pack holds.
TEST(Health, NoStateOfChargeIsAboveFull) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "grepow-32Ah-1",
                              FlightFixture("esc_status_log.ulg"),
                              "--summary",
                              "s.json"});
  const Json ends = ReadJson(folder, "s.json").at("flights")[0].at("soc_start_interval_95");
  EXPECT_LT(ends[0].get<double>(), 0.8) << run.out;
  EXPECT_EQ(ends[1].get<double>(), 1.05) << run.out;
}

// What one autopilot was told is not true of the pack of another.
TEST(Health, RefusesFlightsThatWereToldOfSeveralPacks) {
  const auto health = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"health", "--cell", "gifi-600mAh-1"});
    return RunLipoid(TestFolder(), more);
  };
  const auto cells = health({FlightFixture("quadrotor_local.ulg"), FlightFixture("log171.bin")});
  EXPECT_EQ(cells.exit_code, 2);
  EXPECT_NE(cells.err.find("option --series: expected flights of one pack, found "),
            std::string::npos)
      << cells.err;
  EXPECT_NE(cells.err.find("that says 8 cells in series, and "), std::string::npos) << cells.err;
  EXPECT_NE(cells.err.find("that says nothing of it; give --series"), std::string::npos)
      << cells.err;
  const auto capacities =
      health({FlightFixture("quadrotor_local.ulg"), FlightFixture("log171.bin"), "--series", "4"});
  EXPECT_EQ(capacities.exit_code, 2);
  EXPECT_NE(capacities.err.find("log171.bin that says 5.2 Ah; give --capacity-Ah"),
            std::string::npos)
      << capacities.err;
}

// A log that starts in flight has no rest, and of a pack of four taken for one of three no fit is near, however
// narrow the intervals about it.
TEST(Health, SaysThatTheReferenceDoesNotDescribeTheFlight) {
  const std::string folder = TestFolder();
  ASSERT_EQ(
      RunLipoid(folder, {"convert", FlightFixture("log171.bin"), "-o", "all.bdf.csv"}).exit_code,
      0);
  const std::string all = ReadText(folder + "/all.bdf.csv");
  std::size_t from = all.size();
  for (int row = 0; row <= 1200; ++row) from = all.rfind('\n', from - 1);
  const auto run =
      RunLipoid(folder,
                {"health",
                 "--cell",
                 "gifi-600mAh-1",
                 "--series",
                 "3",
                 "--capacity-Ah",
                 "5.2",
                 WriteText("tail.bdf.csv", all.substr(0, all.find('\n')) + all.substr(from)),
                 "--summary",
                 "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(run.out.find("the reference does not describe this flight (mean error "), 0U)
      << run.out;
  EXPECT_NE(run.out.find("--series"), std::string::npos) << run.out;
  const Json flight = ReadJson(folder, "s.json").at("flights")[0];
  for (const char* quantity : {"soc_start", "soc_end", "capacity", "resistance", "current_scale"})
    EXPECT_TRUE(flight.at(std::string(quantity) + "_interval_95").is_null()) << flight.dump();
  EXPECT_TRUE(flight.at("doubted_because").is_string()) << flight.dump();
}

// A reference of ten times the resistance is no younger state of this pack.
TEST(Health, DoubtsWhatNoCellBecomes) {
  const std::string folder = TestFolder();
  Json reference = Json::parse(ReadText(SourcePath("fixtures/cells/gifi-600mAh-1.json")));
  reference.at("open_circuit_voltage").erase("assumed");
  reference["series_resistance_Ohm"] = 10.0 * reference.at("series_resistance_Ohm").get<double>();
  const std::string file = WriteText("reference.json", reference.dump());
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              file,
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5.2",
                              FlightFixture("log171.bin"),
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(run.out.find("the resistance would be "), 0U) << run.out;
  EXPECT_NE(run.out.find("is the reference another cell"), std::string::npos) << run.out;
  const Json flight = ReadJson(folder, "s.json").at("flights")[0];
  EXPECT_TRUE(flight.at("doubted_because").is_string()) << flight.dump();
}

// A flight without noise, of a pack that has 80 % of the capacity and 1.5 times the resistance of new, straight
// from `fly`: the search takes several hundred steps.
TEST(Health, OfASimulatedFlightConvergesToWhatThePackIs) {
  const std::string folder = TestFolder();
  constexpr double kShare = 5.0 / 32.0;  // a cell of 5 Ah
  Json cell = Json::parse(ReadText(SourcePath("fixtures/cells/grepow-32Ah-1.json")));
  const auto scale = [&](double capacity, double resistance) {
    cell["capacity_Ah"] = capacity * cell.at("capacity_Ah").get<double>();
    Json& alpha_C = cell.at("diffusion").at("alpha_C");
    alpha_C = capacity * alpha_C.get<double>();
    cell["series_resistance_Ohm"] = resistance * cell.at("series_resistance_Ohm").get<double>();
  };
  scale(kShare, 1.0 / kShare);
  cell["branches"] = Json::array();
  const double of_new_Ah = cell.at("diffusion").at("alpha_C").get<double>() / 3600.0;
  const std::string reference = WriteText("new.json", cell.dump());
  scale(0.8, 1.5);
  const std::string aged = WriteText("aged.json", cell.dump());
  const auto flown = RunLipoid(folder,
                               {"fly",
                                "endurance",
                                "--cell",
                                aged,
                                "--vehicle",
                                "f450",
                                "--series",
                                "4",
                                "-o",
                                "flight.csv"});
  ASSERT_EQ(flown.exit_code, 1) << flown.err;  // until the battery is empty
  // A rest before the flight.
  std::string flight = ReadText(folder + "/flight.csv");
  const auto header = flight.find('\n') + 1;
  const auto columns =
      std::count(flight.begin(), flight.begin() + static_cast<std::ptrdiff_t>(header), ',');
  std::string rest;
  for (int k = -60; k < 0; ++k)
    rest +=
        std::to_string(k) + std::string(static_cast<std::size_t>(columns) - 2, ',') + "16.8,0,1\n";
  for (std::size_t at = 0; (at = rest.find(",,", at)) != std::string::npos;) rest.insert(++at, "0");
  flight.insert(header, rest);
  const std::string rested = WriteText("rested.csv", flight);
  const auto told = [&](double capacity_Ah) {
    return RunLipoid(folder,
                     {"health",
                      "--cell",
                      reference,
                      "--series",
                      "4",
                      "--capacity-Ah",
                      std::to_string(capacity_Ah),
                      rested,
                      "--summary",
                      "s.json"});
  };
  const auto run = told(of_new_Ah);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  const Json found = ReadJson(folder, "s.json").at("flights")[0];
  EXPECT_TRUE(found.at("converged").get<bool>());
  EXPECT_LT(found.at("capacity_interval_95")[0].get<double>(), 0.8 * of_new_Ah);
  EXPECT_GT(found.at("capacity_interval_95")[1].get<double>(), 0.8 * of_new_Ah);
  // A capacity mistyped by three: near it lies an end of the search that no slope leaves.
  const auto mistyped = told(3.0 * of_new_Ah);
  EXPECT_NE(mistyped.out.find("capacity not known: the flight fits a pack of 0.2"),
            std::string::npos)
      << mistyped.out;
}

// `fly` knows whether the pack warmed, and its log says so: taken to warm as a typical pack does, a flight at one
// temperature had all of its intervals elsewhere.
TEST(Health, OfASimulatedFlightIsAsWarmAsItWasFlown) {
  const std::string folder = TestFolder();
  for (const bool warms : {false, true}) {
    std::vector<std::string> fly{
        "fly", "hover", "--cell", "gifi-600mAh-1", "--duration", "150", "-o", "flight.csv"};
    if (warms) fly.insert(fly.end(), {"--ambient-degC", "25"});
    ASSERT_EQ(RunLipoid(folder, fly).exit_code, 0);
    const auto run = RunLipoid(folder,
                               {"health",
                                "--cell",
                                "gifi-600mAh-1",
                                "--series",
                                "1",
                                "flight.csv",
                                "--summary",
                                "s.json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json flight = ReadJson(folder, "s.json").at("flights").at(0);
    EXPECT_TRUE(flight.at("temperature_known").get<bool>());
    EXPECT_EQ(run.out.find("without a temperature") != std::string::npos, !warms) << run.out;
    const auto holds = [&](const char* key, double truth) {
      return flight.at(key)[0].get<double>() <= truth && truth <= flight.at(key)[1].get<double>();
    };
    EXPECT_TRUE(holds("capacity_interval_95", 0.376)) << flight;
    EXPECT_TRUE(holds("soc_start_interval_95", 1.0)) << flight;
  }
}

TEST(Health, CountsAFlightOnce) {
  const std::string folder = TestFolder();
  const auto health = [&](std::vector<std::string> files) {
    files.insert(files.begin(),
                 {"health", "--cell", "gifi-600mAh-1", "--series", "4", "--capacity-Ah", "5.2"});
    return RunLipoid(folder, files);
  };
  const auto twice =
      health({FlightFixture("log171.bin"), SourcePath("fixtures/./flights/log171.bin")});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.err.find("is given twice; name each log once"), std::string::npos) << twice.err;

  const std::string log = ReadText(FlightFixture("log171.bin"));
  const auto copies = health({FlightFixture("log171.bin"),
                              WriteText("b.bin", log),
                              WriteText("c.bin", log),
                              "--summary",
                              "s.json"});
  ASSERT_EQ(copies.exit_code, 0) << copies.err;
  EXPECT_NE(copies.out.find("holds the same rows as"), std::string::npos) << copies.out;
  EXPECT_EQ(copies.out.find("changed by"), std::string::npos) << copies.out;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_TRUE(summary.at("trend").is_null());
  EXPECT_TRUE(summary.at("flights")[0].at("same_rows_as").is_null());
  EXPECT_TRUE(summary.at("flights")[2].at("same_rows_as").is_string());
}

// A resistance at another temperature than that of the flight needs an energy, and here it is assumed.
TEST(Health, SaysByWhichEnergyAResistanceIsThatAt25DegC) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5.2",
                              "--ambient-degC",
                              "5",
                              FlightFixture("log171.bin"),
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("The resistance is that at 25 degC"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("kJ/mol"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("assumed"), std::string::npos) << run.out;
  const Json reference = ReadJson(folder, "s.json").at("reference");
  EXPECT_TRUE(reference.at("temperature_assumed").get<bool>());
  EXPECT_GT(reference.at("activation_energy_J_per_mol").get<double>(), 1e4);
}

TEST(Health, AsksForTheCellsInSeries) {
  const auto run =
      RunLipoid(TestFolder(), {"health", "--cell", "gifi-600mAh-1", FlightFixture("log171.bin")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("expected how many cells the pack has in series"), std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find("give --series 4, which the voltage of"), std::string::npos) << run.err;
}

// One flight beside others that say nothing: it is used, they are named.
TEST(Health, NamesWhatItLeavesOut) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"health",
                              "--cell",
                              "gifi-600mAh-1",
                              "--capacity-Ah",
                              "5.2",
                              "--series",
                              "6",
                              FlightFixture("esc_status_log.ulg"),
                              "--battery",
                              "1",
                              FlightFixture("sample_log_small.ulg"),
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("flights").size(), 1U);
  EXPECT_EQ(summary.at("refused").size(), 1U);
  const auto refused = run.out.find("Refused\n");
  ASSERT_NE(refused, std::string::npos) << run.out;
  EXPECT_NE(run.out.find("sample_log_small.ulg: expected a flight", refused), std::string::npos)
      << run.out;
}

TEST(IdentifyFlights, GivesWhatFlightsAloneTell) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--flight",
                              FlightFixture("log171.bin"),
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5.2",
                              "--initial-soc",
                              "0.93",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  EXPECT_NE(run.out.find("What flights alone do not tell"), std::string::npos) << run.out;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("method"), "flights");
  const Json flights = summary.at("flights");
  EXPECT_LT(flights.at("fitted").at(0).at("mean_error_percent").get<double>(), 0.5);
  // 729 of 5200 mAh, less half a window of 3.2 s at the 22 A of the end.
  constexpr double kHalfWindow = 0.004;
  EXPECT_NEAR(flights.at("highest_soc").get<double>() - flights.at("lowest_soc").get<double>(),
              0.729 / 5.2,
              kHalfWindow);
  const auto simulated = RunLipoid(folder,
                                   {"validate",
                                    "cell.json",
                                    FlightFixture("log171.bin"),
                                    "--series",
                                    "4",
                                    "--initial-soc",
                                    "0.93"});
  EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
}

// More charge than the cell is said to have: the curve would go on below empty.
TEST(IdentifyFlights, CannotGiveMoreThanTheCellHolds) {
  const std::string folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--flight",
                              FlightFixture("log171.bin"),
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "0.52",
                              "--initial-soc",
                              "0.93",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err << run.out;
  EXPECT_NE(run.out.find("poor: alpha is 0.52 Ah, less than the 0.75"), std::string::npos)
      << run.out;
  EXPECT_EQ(ReadJson(folder, "s.json").at("fit").at("verdict"), "poor");
}

// A flight alone fits with any pack; what the pack cannot be is said in the first line.
TEST(IdentifyFlights, SayThatThePackIsNotThatOfTheFlight) {
  const std::string folder = TestFolder();
  const auto first_line = [&](const std::string& flight, std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "identify", "--flight", FlightFixture(flight), "-o", "cell.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, arguments);
    EXPECT_LE(run.exit_code, 1) << run.err;
    std::string line = run.out.substr(0, run.out.find("\n\n")) + run.err;
    std::replace(line.begin(), line.end(), '\n', ' ');
    return line;
  };
  const auto with = [&](const std::string& series, const std::string& capacity_Ah) {
    return first_line("log171.bin",
                      {"--initial-soc", "0.93", "--series", series, "--capacity-Ah", capacity_Ah});
  };
  EXPECT_NE(with("4", "5.2").find(": good"), std::string::npos);
  EXPECT_NE(with("5", "5.2")
                .find("fair: a cell would rest at 3.31 V at a state of charge of 0.93, "
                      "where a lithium-polymer cell has 4.14 V: is `series` wrong (5)"),
            std::string::npos);
  EXPECT_NE(with("4", "52").find("fair: the capacity is 52 Ah, and the autopilot was told 5.2 Ah"),
            std::string::npos);
  const std::vector<std::string> pack{"--capacity-Ah", "20", "--initial-soc", "0.5"};
  const std::string by_log = first_line("quadrotor_local.ulg", pack);
  EXPECT_NE(by_log.find("divided by the 8 cells in series that the autopilot was told"),
            std::string::npos)
      << by_log;
  auto other = pack;
  other.insert(other.end(), {"--series", "7"});
  const std::string by_option = first_line("quadrotor_local.ulg", other);
  EXPECT_NE(by_option.find("`series` is 7, and the autopilot was told 8"), std::string::npos)
      << by_option;
}

TEST(IdentifyFlights, AreNoProblemForOptimizers) {
  const auto run = RunLipoid(TestFolder(),
                             {"compare",
                              "--flight",
                              FlightFixture("log171.bin"),
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5.2"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("expected logs of the lab, found flights alone"), std::string::npos)
      << run.err;
}

// A flight on a pack of twice the cell bends the cell of the lab logs until both fit badly.
TEST(IdentifyFlights, OfAnotherPackAreNotTakenWithLabLogs) {
  const std::string folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder,
                      {"convert", FlightFixture("log171.bin"), "--series", "4", "-o", "l4.bdf.csv"})
                .exit_code,
            0);
  const auto lab = [](const std::string& name) {
    return SourcePath("fixtures/lab/dmegc_inr18650_26_r1/" + name);
  };
  const auto run = RunLipoid(folder,
                             {"identify",
                              "--low-rate",
                              lab("low_rate.csv"),
                              "--pulses",
                              lab("pulse.csv"),
                              "--flight",
                              "l4.bdf.csv",
                              "--cutoff-V",
                              "2.5",
                              "--capacity-Ah",
                              "2.6",
                              "-o",
                              "cell.json",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json flights = ReadJson(folder, "s.json").at("flights_with_lab");
  EXPECT_FALSE(flights.at("taken").get<bool>());
  ASSERT_EQ(flights.at("refused").size(), 1U);
  EXPECT_NE(flights.at("refused")[0].at("reason").get<std::string>().find("it is of another cell"),
            std::string::npos)
      << flights.dump();
}

TEST(IdentifyFlights, AsksForTheCapacity) {
  const auto run = RunLipoid(
      TestFolder(),
      {"identify", "--flight", FlightFixture("log171.bin"), "--series", "4", "-o", "cell.json"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("flights alone do not tell it, found none; give --capacity-Ah"),
            std::string::npos)
      << run.err;
}

void WriteInto(const std::string& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder + "/" + name) << text;
}

std::vector<double> ColumnOf(const std::string& file, const std::string& name) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const auto before = line.substr(0, line.find("," + name + ",") + 1);
  const auto commas = std::count(before.begin(), before.end(), ',');
  std::vector<double> values;
  while (std::getline(in, line)) {
    std::size_t at = 0;
    for (auto k = commas; k > 0; --k) at = line.find(',', at) + 1;
    values.push_back(std::stod(line.substr(at)));
  }
  return values;
}

// The log of a hover with steps of altitude, by a pack of half the capacity that rested before: what `fly` and
// `simulate` say, without noise.
Record FlightOfAWornPack(const std::string& folder) {
  Json cell = Json::parse(ReadText(SourcePath("fixtures/cells/gifi-600mAh-1.json")));
  cell["diffusion"]["alpha_C"] = 0.5 * cell["diffusion"]["alpha_C"].get<double>();
  cell["branches"] = Json::array();
  cell["temperature"] = {
      {"reference_degC", 25.0},
      {"activation_energy_J_per_mol",
       {{"series", 20000.0}, {"branches", Json::array()}, {"diffusion", 40000.0}}},
      {"heat_capacity_J_per_K", 14.8},
      {"thermal_resistance_K_per_W", 19.5}};
  WriteInto(folder, "worn.json", cell.dump());
  const auto fly = RunLipoid(folder,
                             {"fly",
                              "altitude-steps",
                              "--vehicle",
                              "mambo-physical",
                              "--cell",
                              "worn.json",
                              "--duration",
                              "120",
                              "--log-step-s",
                              "0.1",
                              "--ambient-degC",
                              "25",
                              "-o",
                              "fly.csv"});
  EXPECT_EQ(fly.exit_code, 0) << fly.err;
  const std::vector<double> battery_A = ColumnOf(folder + "/fly.csv", "battery_A");
  std::string current = "time_s,current_A\n";
  constexpr int kRest_s = 20;
  for (int k = 0; k < 10 * kRest_s; ++k) current += fmt::format("{:.3f},0\n", 0.1 * k);
  for (std::size_t k = 1; k < battery_A.size(); ++k)
    current += fmt::format("{:.3f},{:.6f}\n", kRest_s + 0.1 * double(k), battery_A[k - 1]);
  WriteInto(folder, "current.csv", current);
  const auto made = RunLipoid(folder,
                              {"simulate",
                               "worn.json",
                               "--current",
                               "current.csv",
                               "-o",
                               "clean.csv",
                               "--beyond-cutoff",
                               "--ambient-degC",
                               "25"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return ReadPlainCsv(folder + "/clean.csv");
}

// The kinks of v_oc(A) fit 2 mV of noise in several places, and the search ended in a wrong one in some of these
// flights, a fifth or more away, with an interval that left the truth out.
TEST(Health, OfAWornPackShortFlightsDoNotEndInAWrongPlace) {
  const std::string folder = TestFolder();
  const Record clean = FlightOfAWornPack(folder);
  constexpr int kFlights = 12;
  std::vector<std::string> arguments{"health",
                                     "--cell",
                                     "gifi-600mAh-1",
                                     "--capacity-Ah",
                                     "0.376",
                                     "--series",
                                     "1",
                                     "--ambient-degC",
                                     "25",
                                     "--summary",
                                     "s.json"};
  for (int flight = 0; flight < kFlights; ++flight) {
    NormalNoise normal(static_cast<std::uint64_t>(flight), 0);
    std::string log = "time_s,current_A,voltage_V\n";
    for (std::size_t k = 0; k < clean.size(); ++k) {
      log += fmt::format("{:.3f},{:.4f},{:.4f}\n",
                         clean.time_s[k],
                         clean.current_A[k],
                         clean.voltage_V[k] + 0.002 * normal());
    }
    arguments.push_back(fmt::format("flight_{}.csv", flight));
    WriteInto(folder, arguments.back(), log);
  }
  const auto run = RunLipoid(folder, arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  int held = 0;
  const Json summary = ReadJson(folder, "s.json");
  for (const Json& flight : summary.at("flights")) {
    constexpr double kTruth_Ah = 0.5 * 0.376;
    constexpr double kHere = 0.13;  // relative; the places next to it are 0.2 away
    EXPECT_NEAR(flight.at("capacity_Ah").get<double>(), kTruth_Ah, kHere * kTruth_Ah);
    const Json& interval = flight.at("capacity_interval_95");
    if (interval[0] <= kTruth_Ah && interval[1] >= kTruth_Ah) ++held;
  }
  std::printf("%d of %d intervals of the capacity hold the truth\n", held, kFlights);
  EXPECT_GE(held, 0.88 * kFlights);
}

}  // namespace
}  // namespace lipoid::test
