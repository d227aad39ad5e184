#include "identify/logs/load_campaign.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/statistics/normal_noise.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::Write;

constexpr const char* kDischarge =
    "time_s,current_A,voltage_V\n0,0,8.4\n10,4,8.0\n20,4,7.0\n30,4,6.0\n";

TEST(LoadCampaign, MakesLogsThoseOfOneCell) {
  const auto folder = test::FreshFolder("load_campaign/pack");
  Write(folder + "/a.csv", kDischarge);
  Write(folder + "/c.toml",
        "[cell]\nseries = 2\nparallel = 4\n[[log]]\nkind = 'constant-current'\nfile = 'a.csv'\n");
  const auto logs = LoadCampaign(ReadCampaign(folder + "/c.toml"));
  ASSERT_EQ(logs.size(), 1U);
  EXPECT_EQ(logs[0].entry.file, "a.csv");
  EXPECT_EQ(logs[0].log.record.voltage_V, (std::vector{4.2, 4.0, 3.5, 3.0}));
  EXPECT_EQ(logs[0].log.record.current_A, (std::vector{0.0, 1.0, 1.0, 1.0}));
}

// While charge moves, in the pulses; the rest at the start, and the discharge, do not count.
TEST(LoadCampaign, KnowsTheTemperatureUnderLoad) {
  const auto folder = test::FreshFolder("load_campaign/temperature");
  Write(
      folder + "/p.csv",
      "time_s,current_A,voltage_V,temperature_degC\n0,0,4.2,10\n100,0,4.2,10\n110,4,4.0,30\n120,4,3.9,40\n"
      "130,0,4.0,45\n");
  Write(folder + "/a.csv", "time_s,current_A,voltage_V\n0,0,4.2\n10,4,4.0\n20,4,3.5\n30,4,3.0\n");
  const auto mean_degC = [&](const std::string& pulses, const std::string& discharge) {
    Write(folder + "/c.toml",
          "[cell]\n[[log]]\nkind = 'pulses'\nfile = 'p.csv'\n" + pulses +
              "[[log]]\nkind = 'constant-current'\nfile = 'a.csv'\n" + discharge);
    Campaign campaign = ReadCampaign(folder + "/c.toml");
    if (pulses.empty()) campaign.logs.erase(campaign.logs.begin());
    return LoadedTemperature_degC(LoadCampaign(campaign));
  };
  // Charges of 20, 40 and 20 C to the rows of 30, 40 and 45 degC.
  EXPECT_EQ(mean_degC("ambient_degC = 0\n", ""), 38.8);
  EXPECT_EQ(mean_degC("", "ambient_degC = 15\n"), 15.0);
  EXPECT_EQ(mean_degC("", ""), std::nullopt);
}

// Of a cell at rest, which has one temperature.
TEST(LoadCampaign, TakesTheCourseOfAThermometerThatWavers) {
  const auto folder = test::FreshFolder("load_campaign/wavers");
  NormalNoise normal(7, 0);
  const auto spread_K = [&](double noise_K) {
    std::string text = "time_s,current_A,voltage_V,temperature_degC\n";
    for (int k = 0; k < 400; ++k) {
      text += fmt::format(
          "{},{},{},{}\n", k, k < 100 ? 0 : 1, 4.2 - 0.002 * k, 20.0 + noise_K * normal());
    }
    Write(folder + "/a.csv", text);
    Write(folder + "/c.toml", "[cell]\n[[log]]\nkind = 'constant-current'\nfile = 'a.csv'\n");
    const auto logs = LoadCampaign(ReadCampaign(folder + "/c.toml"));
    const auto& warnings = logs[0].log.report.warnings;
    const bool said = std::any_of(warnings.begin(), warnings.end(), [](const std::string& one) {
      return one.find("degC from row to row, and the course of the rows around each is taken") !=
             std::string::npos;
    });
    EXPECT_EQ(said, noise_K > 0.02);
    const auto& shown = logs[0].log.record.temperature_degC;
    const auto [least, most] = std::minmax_element(shown.begin(), shown.end());
    return *most - *least;
  };
  EXPECT_LT(spread_K(0.1), 0.25);   // of 400 rows: 0.6
  EXPECT_GT(spread_K(0.01), 0.04);  // left alone
}

TEST(LoadCampaign, KeepsTheOrderOfTheCampaign) {
  const auto folder = test::FreshFolder("load_campaign/order");
  std::string campaign;
  for (int k = 0; k < 12; ++k) {
    Write(folder + "/" + std::to_string(k) + ".csv",
          "time_s,current_A,voltage_V\n0,0,4\n1," + std::to_string(k + 1) + ",3.9\n2," +
              std::to_string(k + 1) + ",3.8\n");
    campaign += "[[log]]\nkind = 'validation'\nfile = '" + std::to_string(k) + ".csv'\n";
  }
  Write(folder + "/c.toml", campaign);
  const auto logs = LoadCampaign(ReadCampaign(folder + "/c.toml"));
  ASSERT_EQ(logs.size(), 12U);
  for (int k = 0; k < 12; ++k)
    EXPECT_EQ(logs[static_cast<std::size_t>(k)].log.record.current_A[1], k + 1.0);
}

TEST(LoadCampaign, NamesEachBadFileOnceHoweverOftenItStands) {
  const auto folder = test::FreshFolder("load_campaign/bad");
  Write(folder + "/good.csv", kDischarge);
  Write(folder + "/text.csv", "time_s,current_A,voltage_V\n0,0,4.2\n10,abc,4.0\n20,x,3.9\n");
  std::string campaign = "[cell]\nseries = 2\n";
  for (const char* kind : {"constant-current", "pulses", "validation"}) {
    for (const char* file : {"good.csv", "missing.csv", "text.csv"}) {
      campaign += std::string("[[log]]\nkind = '") + kind + "'\nfile = '" + file + "'\n";
    }
  }
  Write(folder + "/c.toml", campaign);
  const auto text =
      test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;  // two lines
  EXPECT_EQ(text.find(folder + "/missing.csv: error: "), 0U) << text;
  EXPECT_NE(text.find("\n" + folder + "/text.csv:3:4: error: "), std::string::npos) << text;
}

TEST(LoadCampaign, RefusesAPackThatIsNotDeclared) {
  const auto folder = test::FreshFolder("load_campaign/undeclared");
  Write(folder + "/a.csv", kDischarge);
  Write(folder + "/c.toml", "[[log]]\nkind = 'validation'\nfile = 'a.csv'\n");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); }),
            folder +
                "/a.csv:1:1: error: expected the voltage of one cell, found 7.35 V on average; are "
                "these mV, or "
                "is it a pack (say `series`)?");
}

// Drive cycles without regeneration, whose campaigns had to name the sign.
TEST(LoadCampaign, NeedsNoSignForADriveCycleWithoutRegeneration) {
  for (const char* folder : {"panasonic_18650pf/t00", "panasonic_18650pf/tm20"}) {
    const auto file = test::LabDataPath(std::string(folder) + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    Campaign campaign = ReadCampaign(file);
    for (CampaignLog& log : campaign.logs) log.read.current_sign.clear();
    for (const LoadedLog& loaded : LoadCampaign(campaign)) {
      const LogReport& report = loaded.log.report;
      EXPECT_EQ(report.current_sign, "discharge-positive") << loaded.entry.file;
      EXPECT_FALSE(report.current_sign_is_of_others) << loaded.entry.file;
    }
  }
}

// Two discharges of one format, of which one counts the current the other way round, and a rest.
TEST(LoadCampaign, NotesWhoSettledWhomAndWhoDisagrees) {
  const auto folder = test::FreshFolder("load_campaign/notes");
  std::string turned = "time_s,current_A,voltage_V\n";
  std::string rest = turned;
  for (int k = 0; k < 60; ++k) {
    turned += fmt::format("{},{},{}\n", 60 * k, k == 0 ? 0 : -1, 4.1 - 0.01 * k);
    rest += fmt::format("{},0,4.1\n", 60 * k);
  }
  Write(folder + "/turned.csv", turned);
  Write(folder + "/rest.csv", rest);
  Write(folder + "/said.csv", rest);
  const auto notes = [&](const std::string& option) {
    Write(folder + "/c.toml",
          "[[log]]\nkind = 'validation'\nfile = 'turned.csv'\n"
          "[[log]]\nkind = 'validation'\nfile = '" +
              option);
    return NotesOnLogs(LoadCampaign(ReadCampaign(folder + "/c.toml")));
  };
  EXPECT_EQ(notes("rest.csv'\n"),
            std::vector<std::string>{
                "rest.csv: discharge is negative as in turned.csv, of the same format; by itself "
                "this log does not settle it: no current flows"});
  EXPECT_EQ(notes("said.csv'\ncurrent_sign = 'discharge-positive'\n"),
            std::vector<std::string>{
                "turned.csv is discharge-negative and said.csv is discharge-positive, although "
                "both have one format: look whether one is turned, and say `current_sign` of that "
                "one"});
}

TEST(LoadCampaign, SaysWhichLogsHoldTheSameRows) {
  const auto folder = test::FreshFolder("load_campaign/copies");
  std::string text = "time_s,current_A,voltage_V\n0,0,4.2\n";
  for (int k = 1; k < 60; ++k) text += fmt::format("{},1,{}\n", 60 * k, 4.1 - 0.01 * k);
  Write(folder + "/a.csv", text);
  Write(folder + "/b.csv", text);
  Write(folder + "/c.csv", text + "3600,1,3.4\n");
  const auto notes = [&](const std::string& kind, const std::string& other) {
    Write(folder + "/c.toml",
          "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n[[log]]\nkind = '" + kind + "'\nfile = '" +
              other + "'\n");
    return NotesOnLogs(LoadCampaign(ReadCampaign(folder + "/c.toml")));
  };
  EXPECT_EQ(
      notes("pulses", "b.csv"),
      std::vector<std::string>{"b.csv holds the same rows as a.csv, which therefore count twice: "
                               "leave one of the two out, or look whether one was copied by "
                               "mistake"});
  EXPECT_EQ(
      notes("validation", "b.csv"),
      std::vector<std::string>{"b.csv holds the same rows as a.csv, and so does not test the fit, "
                               "which has seen them: leave one of the two out, or look whether "
                               "one was copied by mistake"});
  EXPECT_EQ(notes("pulses", "c.csv"), std::vector<std::string>{});
}

TEST(LoadCampaign, ReadsThoseBesideTheProject) {
  for (const char* name : {"nissan_leaf_33ah", "dmegc_inr18650_26_r1", "lg_m50_5ah"}) {
    const auto file = test::LabDataPath(std::string(name) + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    for (const auto& log : LoadCampaign(ReadCampaign(file)))
      EXPECT_GT(log.log.record.size(), 50U) << log.entry.file;
  }
}

TEST(LoadCampaign, ACapacityInOtherUnitsIsNamed) {
  const auto folder = test::FreshFolder("load_campaign/capacity");
  Write(folder + "/a.csv",
        "time_s,current_A,voltage_V\n0,0,4.2\n1200,2,4.0\n2400,2,3.5\n3600,2,3\n");
  const auto complaint = [&](const std::string& capacity_Ah, const std::string& kind) {
    Write(folder + "/c.toml",
          "[cell]\ncapacity_Ah = " + capacity_Ah + "\n[[log]]\nkind = '" + kind +
              "'\nfile = 'a.csv'\n");
    return test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); });
  };
  EXPECT_EQ(complaint("2000", "constant-current"),
            folder +
                "/c.toml:2:15: error: capacity_Ah: expected logs that move the charge of a cell "
                "of 2000 Ah, found 2 Ah at most; is the capacity in mAh, or are times in "
                "minutes or currents in another unit than their headers say? A discharge that was "
                "stopped early is of kind \"validation\"");
  EXPECT_EQ(complaint("2.1", "constant-current"), "no error");
  // A minute taken for a second makes a 60th of it, a discharge that was stopped early a tenth.
  EXPECT_EQ(complaint("20.0", "constant-current"), "no error");
  EXPECT_NE(complaint("120.0", "constant-current"), "no error");
  // Pulses need not empty the cell, and validation logs prove nothing.
  EXPECT_EQ(complaint("20.0", "pulses"), "no error");
  EXPECT_NE(complaint("2000.0", "pulses"), "no error");
  EXPECT_EQ(complaint("2000.0", "validation"), "no error");
}

TEST(LoadCampaign, WhatNoLogOfTheCellCanBeIsNamed) {
  const auto folder = test::FreshFolder("load_campaign/never");
  Write(folder + "/a.csv",
        "time_s,current_A,voltage_V\n0,0,4.2\n1200,2,4.0\n2400,2,3.5\n3600,2,3\n");
  Write(folder + "/b.csv",
        "time_s,current_A,voltage_V\n0,0,3.6\n1200,-2,3.8\n2400,-2,4.0\n3600,-2,4.1\n");
  const auto complaint = [&](const std::string& cell, const std::string& log) {
    Write(folder + "/c.toml",
          "[cell]\ncapacity_Ah = 2.0\n" + cell + "\n[[log]]\nkind = 'pulses'\n" + log + "\n");
    return test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); });
  };
  EXPECT_EQ(complaint("cutoff_V = 3.0", "file = 'a.csv'"), "no error");
  EXPECT_EQ(
      complaint("cutoff_V = 4.5", "file = 'a.csv'"),
      folder +
          "/c.toml:3:12: error: cutoff_V: expected a voltage that a discharge ends at, found 4.5 V, "
          "and no log of this cell is above 4.2 V; the cut-off is that of one cell");
  const std::string charge = "current_sign = 'discharge-positive'\nfile = 'b.csv'";
  EXPECT_EQ(complaint("", charge + "\ninitial_soc = 0.2"), "no error");
  EXPECT_EQ(complaint("", charge),
            folder +
                "/b.csv:1:1: error: expected pulses of a cell that is full at most, found 2 Ah of "
                "charging from a state of charge of 1 of 2 Ah on; turn the current round "
                "(`current_sign`), or say where the log starts (`initial_soc`)");
  // Nothing was charged: the start is what is wrong.
  EXPECT_EQ(
      complaint("", "file = 'a.csv'\ninitial_soc = 1.4"),
      folder +
          "/a.csv:1:1: error: expected pulses of a cell that is full at most, found a start at a state of "
          "charge of 1.4; say where the log starts (`initial_soc`)");
}

// Before, a fit read voltages that are not there.
TEST(LoadCampaign, RefusesACurrentAloneUnderEveryKind) {
  const auto folder = test::FreshFolder("load_campaign/current_alone");
  Write(folder + "/a.csv", "time_s,current_A\n0,0\n10,4\n20,4\n30,4\n");
  const std::string none = folder + "/a.csv:1:1: error: expected a log with voltages, found none";
  for (const auto& [kind, name] : OptionNames(LogKind{})) {
    Write(folder + "/c.toml", "[[log]]\nkind = '" + std::string(name) + "'\nfile = 'a.csv'\n");
    Campaign campaign = ReadCampaign(folder + "/c.toml");
    campaign.logs[0].read.voltage_optional = true;
    EXPECT_EQ(test::LoadErrorOf([&] { (void)LoadCampaign(campaign); }), none) << name;
    const Log log = ReadLog(folder + "/a.csv", campaign.logs[0].read);
    EXPECT_EQ(test::LoadErrorOf([&] { (void)TakeLogs(campaign, {log}); }), none) << name;
  }
}

TEST(LoadCampaign, ADischargeIsNoSlowCharge) {
  const auto folder = test::FreshFolder("load_campaign/charge");
  const auto complaint = [&](const std::string& rows) {
    Write(folder + "/a.csv", "time_s,current_A,voltage_V\n" + rows);
    Write(folder + "/c.toml",
          "[[log]]\nkind = 'low-rate-charge'\nfile = 'a.csv'\n"
          "current_sign = 'discharge-positive'\n");
    return test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); });
  };
  EXPECT_EQ(
      complaint("0,0,4.2\n18000,0.2,4.0\n36000,0.2,3.5\n"),
      folder +
          "/a.csv:1:1: error: expected a slow charge, as kind \"low-rate-charge\" says, found "
          "2 Ah that flow out; a slow discharge is of kind \"low-rate\", and of a charge turn the "
          "current round (`current_sign`)");
  EXPECT_EQ(complaint("0,0,3.5\n18000,-0.2,3.9\n36000,-0.2,4.2\n"), "no error");
  // Nor is a slow charge a discharge.
  const auto other_way = [&](const std::string& rows) {
    Write(folder + "/a.csv", "time_s,current_A,voltage_V\n" + rows);
    Write(folder + "/c.toml",
          "[cell]\n[[log]]\nkind = 'low-rate'\nfile = 'a.csv'\n"
          "current_sign = 'discharge-positive'\n");
    return test::LoadErrorOf([&] { (void)LoadCampaign(ReadCampaign(folder + "/c.toml")); });
  };
  EXPECT_EQ(
      other_way("0,0,3.5\n18000,-0.2,3.9\n36000,-0.2,4.2\n"),
      folder +
          "/a.csv:1:1: error: expected a slow discharge, as kind \"low-rate\" says, found "
          "2 Ah that flow in; a slow charge is of kind \"low-rate-charge\", and of a discharge "
          "turn the current round (`current_sign`)");
  EXPECT_EQ(other_way("0,0,3.5\n18000,-0.2,4.2\n36000,0.19,3.5\n"), "no error");
  // A discharge and the recharge after it, which takes a little more, are both: a part is wanted.
  EXPECT_EQ(other_way("0,0,4.2\n18000,0.2,3.5\n36000,-0.201,4.2\n"), "no error");
  EXPECT_EQ(complaint("0,0,3.5\n18000,-0.2,4.2\n36000,0.201,3.5\n"), "no error");
  // What empties the cell before it is charged is not the charge.
  EXPECT_EQ(complaint("0,0,4.2\n18000,0.2,3.5\n36000,-0.19,4.2\n"), "no error");
}

// 77 degF are 25 degC.
TEST(LoadCampaign, ARestedCellFarFromItsSurroundingsIsDoubted) {
  const auto folder = test::FreshFolder("load_campaign/ambient");
  const auto warnings = [&](const std::string& degC, const std::string& log, int first_A = 0) {
    std::string rows = "time_s,current_A,voltage_V,temperature_degC\n";
    for (int k = 0; k < 4; ++k)
      rows += fmt::format("{},{},{},{}\n", 10 * k, k == 0 ? first_A : 1, 4.2 - 0.1 * k, degC);
    Write(folder + "/a.csv", rows);
    Write(folder + "/c.toml",
          "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\ncurrent_sign = 'discharge-positive'\n" + log);
    return LoadCampaign(ReadCampaign(folder + "/c.toml"))[0].log.report.warnings;
  };
  const std::vector<std::string> none;
  EXPECT_EQ(
      warnings("77", "ambient_degC = 25\n"),
      (std::vector<std::string>{
          "the cell rests at 77 degC in the first row, and ambient_degC is 25: if these are "
          "degrees Fahrenheit (25 degC), say degF in the header; where the cell was warmed or "
          "cooled before the test, say initial_degC"}));
  EXPECT_EQ(
      warnings("25", "ambient_degC = -20\n"),
      (std::vector<std::string>{
          "the cell rests at 25 degC in the first row, and ambient_degC is -20: look which of "
          "the two is right; where the cell was warmed or cooled before the test, say "
          "initial_degC"}));
  EXPECT_EQ(warnings("39", "ambient_degC = 25\n"), none);
  EXPECT_EQ(
      warnings("77", ""),
      (std::vector<std::string>{"the cell is at 77 degC in the first row: if these are degrees "
                                "Fahrenheit (25 degC), say degF in the header"}));
  EXPECT_EQ(warnings("55", ""), none);
  EXPECT_EQ(warnings("77", "ambient_degC = 25\ninitial_degC = 77\n"), none);
  const auto under_load = warnings("77", "ambient_degC = 25\n", 1);
  ASSERT_EQ(under_load.size(), 1U) << "a cell under load may be warm";
  EXPECT_EQ(under_load[0].find("it begins under load"), 0U);
}

// Of a thermometer of whole degrees, and of one that shows hundredths.
TEST(LoadCampaign, ATemperatureOfWholeDegreesGoesStraightBetweenThem) {
  const auto folder = test::FreshFolder("load_campaign/steps");
  const auto loaded = [&](double step) {
    std::string rows = "time_s,current_A,voltage_V,temperature_degC\n";
    for (int k = 0; k < 40; ++k)
      rows += fmt::format("{},{},{},{}\n",
                          10 * k,
                          k == 0 ? 0 : 1,
                          4.2 - 0.01 * k,
                          step * std::round((20.0 + 0.1 * k) / step));
    Write(folder + "/a.csv", rows);
    Write(folder + "/c.toml",
          "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\ncurrent_sign = 'discharge-positive'\n");
    return LoadCampaign(ReadCampaign(folder + "/c.toml"))[0];
  };
  const LoadedLog whole = loaded(1.0);
  EXPECT_NEAR(whole.log.record.temperature_degC[12], 21.2, 0.06);
  EXPECT_EQ(
      whole.log.report.warnings,
      (std::vector<std::string>{
          "its temperature is in steps of 1 degC, and is taken to go straight from one to the next"}));
  const LoadedLog fine = loaded(0.01);
  EXPECT_NEAR(fine.log.record.temperature_degC[12], 21.2, 1e-9);
  EXPECT_TRUE(fine.log.report.warnings.empty());
  // As whole as it is, a cell that warms from row to row shows no steps.
  EXPECT_EQ(loaded(0.1).log.record.temperature_degC[13], 0.1 * std::round(21.3 / 0.1));
}

// A published test of a cell of 3 Ah: pulses that move less than a hundredth of its charge.
TEST(LoadCampaign, PulsesMayMoveLittle) {
  const auto folder = test::FreshFolder("load_campaign/little");
  Write(folder + "/c.toml",
        "[cell]\ncapacity_Ah = 3\n[[log]]\nkind = 'pulses'\nunits = ['s', 'A', 'V']\nfile = '" +
            test::LabDataPath("samsung_30t_hppc/multipulse.csv") + "'\n");
  EXPECT_EQ(LoadCampaign(ReadCampaign(folder + "/c.toml")).size(), 1U);
}

// A part that is cut out of a log at its first loaded row takes the row of the rest before it along; ReadLog() gives
// the rows that were asked for.
TEST(LoadCampaign, BeginsAtTheRestBeforeThePart) {
  const auto folder = test::FreshFolder("load_campaign/rest_before");
  Write(
      folder + "/a.csv",
      "time_s,current_A,voltage_V,temperature_degC\n0,0,4.2,20\n10,0,4.2,21\n20,4,4.0,22\n30,4,3.5,23\n"
      "40,4,3.0,24\n");
  Write(
      folder + "/m.csv",
      "Rec#,Cyc#,Step,TestTime (Sec),Amps,Volts,State\n1,1,5,0,0,4.2,R\n2,1,5,10,0,4.2,R\n3,1,6,20,4,4.0,D\n"
      "4,1,6,30,4,3.5,D\n5,1,6,40,4,3.0,D\n");
  const auto read = [&](const std::string& which) {
    Write(folder + "/c.toml", "[cell]\n[[log]]\nkind = 'constant-current'\n" + which);
    return LoadCampaign(ReadCampaign(folder + "/c.toml")).front();
  };
  for (const std::string which :
       {"file = 'a.csv'\nstart_s = 20\n", "file = 'm.csv'\nsteps = [6]\n"}) {
    SCOPED_TRACE(which);
    const LoadedLog loaded = read(which);
    const Record& record = loaded.log.record;
    EXPECT_EQ(record.time_s, (std::vector{0.0, 10.0, 20.0, 30.0}));
    EXPECT_EQ(record.current_A, (std::vector{0.0, 4.0, 4.0, 4.0}));
    EXPECT_EQ(record.voltage_V, (std::vector{4.2, 4.0, 3.5, 3.0}));
    if (!record.temperature_degC.empty()) {
      EXPECT_EQ(record.temperature_degC, (std::vector{21.0, 22.0, 23.0, 24.0}));
    }
    EXPECT_TRUE(loaded.log.report.warnings.empty());
  }
  const Log alone = ReadLog(folder + "/m.csv", {.steps = {6}});
  EXPECT_EQ(alone.record.time_s, (std::vector{0.0, 10.0, 20.0}));
  // The rest is where the part begins: nothing is put before it.
  EXPECT_EQ(read("file = 'a.csv'\nstart_s = 10\n").log.record.time_s,
            (std::vector{0.0, 10.0, 20.0, 30.0}));
  Record columns;
  columns.file = "frame";
  columns.time_s = {0, 10, 20, 30, 40};
  columns.current_A = {0, 0, 4, 4, 4};
  columns.voltage_V = {4.2, 4.2, 4.0, 3.5, 3.0};
  const Log frame = TakeLog(columns, {.start_s = 15.0});
  ASSERT_TRUE(frame.before.has_value());
  EXPECT_EQ(frame.before->time_s, -10.0);
  EXPECT_EQ(frame.before->voltage_V, 4.2);
  EXPECT_FALSE(TakeLog(columns, {.end_s = 30.0}).before.has_value());
}

// Beta follows the first rows of a discharge: 10 s at 4C that are not there move it by ten standard errors.
TEST(LoadCampaign, ALogThatBeginsUnderLoadIsDoubted) {
  const auto folder = test::FreshFolder("load_campaign/under_load");
  const auto doubts = [&](const std::string& rows, const std::string& part = "") {
    Write(folder + "/a.csv", "time_s,current_A,voltage_V\n" + rows);
    Write(folder + "/c.toml",
          "[cell]\n[[log]]\nkind = 'constant-current'\nfile = 'a.csv'\n" + part);
    return LoadCampaign(ReadCampaign(folder + "/c.toml")).front().log.report.warnings;
  };
  EXPECT_EQ(
      doubts("0,4,4.1\n10,4,4.0\n20,4,3.5\n30,4,3.0\n"),
      std::vector<std::string>{
          "it begins under load (4 A), and the cell is taken as rested until its first row: one "
          "row more under load is 33 % of its charge; begin it with a row of the rest"});
  EXPECT_EQ(
      doubts("-60,0,4.2\n0,4,4.1\n10,4,4.0\n20,4,3.5\n30,4,3.0\n", "start_s = 0\n"),
      std::vector<std::string>{
          "it begins under load (4 A), and the cell is taken as rested until its first row: one "
          "row more under load is 33 % of its charge; the rest before it ends 60 s earlier"});
  EXPECT_EQ(
      doubts("0,4,4.1\n10,4,4.0\n20,4,3.5\n30,4,3.0\n", "start_s = 10\n"),
      std::vector<std::string>{
          "it begins under load (4 A), and the cell is taken as rested until its first row: one "
          "row more under load is 50 % of its charge; the row before it is under load, too"});
  // A clock that does not begin at 0 changes nothing.
  EXPECT_EQ(doubts("600,4,4.1\n610,4,4.0\n620,4,3.5\n630,4,3.0\n"),
            doubts("0,4,4.1\n10,4,4.0\n20,4,3.5\n30,4,3.0\n"));
  // A row before that cannot be is none to begin with.
  EXPECT_EQ(doubts("-10,0,42\n0,4,4.1\n10,4,4.0\n20,4,3.5\n30,4,3.0\n", "start_s = 0\n").size(),
            1U);
  // A hundredth of a second is nothing.
  std::string fine;
  for (int k = 0; k < 4000; ++k) fine += fmt::format("{},4,{}\n", 0.01 * k, 4.1 - 2e-4 * k);
  EXPECT_TRUE(doubts(fine).empty());
}

TEST(LoadCampaign, WarningsOfALogAreNotes) {
  LoadedLog log;
  log.entry.file = "a.csv";
  log.log.report.warnings = {"1 row dropped"};
  log.log.report.current_sign = "unsigned";
  EXPECT_EQ(NotesOnLogs({log}), (std::vector<std::string>{"a.csv: 1 row dropped"}));
}

}  // namespace
}  // namespace lipoid
