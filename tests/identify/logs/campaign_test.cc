#include "identify/logs/campaign.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::LoadErrorOf;

std::string RefusalOfCampaign(const std::string& text) {
  return LoadErrorOf([&] { (void)ParseCampaign(text, "lab/c.toml"); });
}

constexpr const char* kEveryKey = R"([cell]
name = "A \"quoted\" cell's C:\\name"
capacity_Ah = 33.1
cutoff_V = 3
series = 4
parallel = 2

[[log]]
kind = "constant-current"
file = "cc_1c.csv"
[[log]]
kind = "low-rate"
file = "../slow/c20.csv"
hold = "forward"
columns = { time_s = "Zeit", voltage_V = "U [V]", current_A = 7 }
units = "min, mA, mV"
current_sign = "discharge-negative"
steps = [3, 4]
cycles = [1]
start_s = 100
end_s = 1e6
initial_soc = 0.98
lead_resistance_Ohm = 0.109
weight = 2.5
ambient_degC = -10
initial_degC = 5.5
[[log]]
kind = "validation"
file = "/data/walk.csv"
units = ["s", "A", "V"]
)";

void ExpectEveryKey(const Campaign& campaign) {
  EXPECT_EQ(campaign.name, "A \"quoted\" cell's C:\\name");
  EXPECT_EQ(campaign.capacity_Ah, 33.1);
  EXPECT_EQ(campaign.cutoff_V, 3.0);
  EXPECT_EQ(campaign.series, 4);
  EXPECT_EQ(campaign.parallel, 2);
  ASSERT_EQ(campaign.logs.size(), 3U);
  EXPECT_EQ(campaign.logs[0].kind, LogKind::kConstantCurrent);
  EXPECT_EQ(campaign.logs[0].file, "cc_1c.csv");
  EXPECT_EQ(campaign.logs[0].path, "lab/cc_1c.csv");
  EXPECT_EQ(campaign.logs[0].read.hold, Hold::kBackward);
  EXPECT_EQ(campaign.logs[0].read.start_s, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(campaign.logs[0].initial_soc, 1.0);
  EXPECT_EQ(campaign.logs[0].weight, 1.0);
  const CampaignLog& slow = campaign.logs[1];
  EXPECT_EQ(slow.kind, LogKind::kLowRate);
  EXPECT_EQ(slow.path, "slow/c20.csv");
  EXPECT_EQ(slow.read.hold, Hold::kForward);
  EXPECT_EQ(slow.read.columns,
            (std::map<std::string, std::string>{
                {"time_s", "Zeit"}, {"voltage_V", "U [V]"}, {"current_A", "7"}}));
  EXPECT_EQ(slow.read.units, (std::vector<std::string>{"min", "mA", "mV"}));
  EXPECT_EQ(slow.read.current_sign, "discharge-negative");
  EXPECT_EQ(slow.read.steps, (std::vector{3, 4}));
  EXPECT_EQ(slow.read.cycles, std::vector{1});
  EXPECT_EQ(slow.read.start_s, 100.0);
  EXPECT_EQ(slow.read.end_s, 1e6);
  EXPECT_EQ(slow.initial_soc, 0.98);
  EXPECT_TRUE(slow.initial_soc_told);
  EXPECT_FALSE(campaign.logs[0].initial_soc_told);
  EXPECT_EQ(slow.read.lead_resistance_Ohm, 0.109);
  EXPECT_EQ(slow.weight, 2.5);
  EXPECT_EQ(slow.ambient_degC, -10.0);
  EXPECT_EQ(slow.initial_degC, 5.5);
  EXPECT_FALSE(campaign.logs[0].ambient_degC);
  EXPECT_EQ(campaign.logs[2].path, "/data/walk.csv");
  EXPECT_EQ(campaign.logs[2].read.units, (std::vector<std::string>{"s", "A", "V"}));
}

TEST(Campaign, TheSurroundingsOfTheCellAreThoseOfItsLogs) {
  const Campaign campaign = ParseCampaign(
      "[cell]\nambient_degC = 20\n"
      "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n"
      "[[log]]\nkind = 'pulses'\nfile = 'b.csv'\nambient_degC = 0\n",
      "campaign.toml");
  ASSERT_EQ(campaign.logs.size(), 2U);
  EXPECT_EQ(campaign.logs[0].ambient_degC, 20.0);
  EXPECT_EQ(campaign.logs[1].ambient_degC, 0.0);
}

TEST(Campaign, ReadsEveryKey) {
  const auto campaign = ParseCampaign(kEveryKey, "lab/c.toml");
  EXPECT_EQ(campaign.file, "lab/c.toml");
  ExpectEveryKey(campaign);
  EXPECT_EQ(campaign.logs[0].position, (SourcePosition{"lab/c.toml", 10, 8}));
  EXPECT_EQ(campaign.logs[1].position, (SourcePosition{"lab/c.toml", 13, 8}));
}

TEST(Campaign, WritesWhatItReads) {
  const auto text = CampaignToToml(ParseCampaign(kEveryKey, "lab/c.toml"));
  ExpectEveryKey(ParseCampaign(text, "lab/c.toml"));
  EXPECT_EQ(CampaignToToml(ParseCampaign(text, "lab/c.toml")), text);
}

TEST(Campaign, WritesNumbersToTheLastBit) {
  Campaign campaign;
  campaign.capacity_Ah = 0.1 + 0.2;
  campaign.cutoff_V = std::nextafter(3.0, 4.0);
  CampaignLog log;
  log.file = "a.csv";
  log.weight = 1.0 / 3.0;
  campaign.logs.push_back(log);
  const auto again = ParseCampaign(CampaignToToml(campaign), "c.toml");
  EXPECT_EQ(again.capacity_Ah, 0.1 + 0.2);
  EXPECT_EQ(again.cutoff_V, std::nextafter(3.0, 4.0));
  EXPECT_EQ(again.logs[0].weight, 1.0 / 3.0);
}

TEST(Campaign, ReadsThoseBesideTheProject) {
  for (const char* name : {"nissan_leaf_33ah", "dmegc_inr18650_26_r1", "lg_m50_5ah"}) {
    const auto file = test::LabDataPath(std::string(name) + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    const auto campaign = ReadCampaign(file);
    EXPECT_EQ(campaign.Count(LogKind::kConstantCurrent), 3U) << name;
    EXPECT_EQ(campaign.Count(LogKind::kLowRate), 1U) << name;
    EXPECT_NO_THROW(CheckCampaign(campaign, false)) << name;
  }
}

TEST(CampaignRefuses, AMissingFile) {
  EXPECT_EQ(LoadErrorOf([] { (void)ReadCampaign("no/such.toml"); }).find("no/such.toml: error: "),
            0U);
}

TEST(CampaignRefuses, AFolderAndALogWithWhatToDo) {
  const auto folder = test::FreshFolder("campaign/folder");
  EXPECT_EQ(LoadErrorOf([&] { (void)ReadCampaign(folder); }),
            folder + ":1:1: error: expected a campaign, found a folder; lipoid inspect " + folder +
                " --write-campaign " + folder + "/campaign.toml drafts one of its logs");
  test::Write(folder + "/campaign.toml", "");
  EXPECT_EQ(LoadErrorOf([&] { (void)ReadCampaign(folder); }),
            folder + ":1:1: error: expected a campaign, found a folder; its campaign is " + folder +
                "/campaign.toml");
  const std::string log = folder + "/a.csv";
  test::Write(log, "time_s,current_A,voltage_V\n0,0,4.2\n");
  const std::string said = LoadErrorOf([&] { (void)ReadCampaign(log); });
  EXPECT_EQ(said.find(log + ":1:7: error: not a campaign in TOML: "), 0U);
  EXPECT_TRUE(said.ends_with(". If this is a log, lipoid inspect " + log +
                             " --write-campaign campaign.toml drafts a campaign"))
      << said;
}

TEST(CampaignRefuses, WhatIsNotToml) {
  // The words after the colon are toml++'s.
  EXPECT_EQ(RefusalOfCampaign("[cell]\nname = \n")
                .find("lab/c.toml:2:8: error: not a campaign in TOML: "),
            0U);
  EXPECT_EQ(RefusalOfCampaign("[cell]\nname = 'a'\nname = 'b'\n")
                .find("lab/c.toml:3:8: error: not a campaign in TOML: "),
            0U);
  EXPECT_EQ(RefusalOfCampaign("time_s,current_A\n1,2\n")
                .find("lab/c.toml:1:7: error: not a campaign in TOML: "),
            0U);
}

TEST(CampaignRefuses, AnEmptyCampaign) {
  const auto none = "lab/c.toml:1:1: error: expected at least one [[log]], found none";
  EXPECT_EQ(RefusalOfCampaign(""), none);
  EXPECT_EQ(RefusalOfCampaign("[cell]\nname = 'x'\n"), none);
  EXPECT_EQ(RefusalOfCampaign("log = []\n"), none);
}

TEST(CampaignRefuses, SingleBrackets) {
  EXPECT_EQ(RefusalOfCampaign("[log]\nkind = 'pulses'\nfile = 'a.csv'\n"),
            "lab/c.toml:1:1: error: expected [[log]], in double brackets, found [log]");
}

TEST(CampaignRefuses, UnknownKeysAndListsTheKnownOnes) {
  EXPECT_EQ(
      RefusalOfCampaign(
          "[cell]\ncutof_V = 3.0\n[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n  fiel = 1\n[lab]\n"),
      "lab/c.toml:2:1: error: expected one of the keys name, capacity_Ah, cutoff_V, series, "
      "parallel, ambient_degC, age, found "
      "'cutof_V'; is it 'cutoff_V'?\n"
      "lab/c.toml:6:3: error: expected one of the keys kind, file, hold, columns, units, "
      "current_sign, steps, "
      "cycles, start_s, end_s, battery, initial_soc, lead_resistance_Ohm, weight, ambient_degC, "
      "initial_degC, found 'fiel'; is it 'file'?\n"
      "lab/c.toml:7:2: error: expected one of the keys cell, log, found 'lab'");
}

TEST(CampaignRefuses, AnUnknownKind) {
  EXPECT_EQ(
      RefusalOfCampaign("[[log]]\nkind = \"pulse\"\nfile = 'a.csv'\n"),
      "lab/c.toml:2:8: error: kind: expected one of constant-current, low-rate, low-rate-charge, pulses, "
      "flight, validation, found "
      "'pulse'");
}

TEST(CampaignRefuses, MissingKindAndFile) {
  EXPECT_EQ(RefusalOfCampaign("[[log]]\nhold = 'backward'\n"),
            "lab/c.toml:1:1: error: expected the key 'kind' in this [[log]], found none\n"
            "lab/c.toml:1:1: error: expected the key 'file' in this [[log]], found none");
}

TEST(CampaignRefuses, WrongTypes) {
  EXPECT_EQ(
      RefusalOfCampaign("[cell]\nname = 5\ncapacity_Ah = '33'\nseries = 1.5\n[[log]]\nkind = "
                        "true\nfile = ['a.csv']\n"),
      "lab/c.toml:2:8: error: name: expected a text in quotes, found 5\n"
      "lab/c.toml:3:15: error: capacity_Ah: expected a capacity above 0 Ah, found '33'\n"
      "lab/c.toml:4:10: error: series: expected an integer from 1 to 100000, found 1.5\n"
      "lab/c.toml:6:8: error: kind: expected one of constant-current, low-rate, low-rate-charge, pulses, "
      "flight, validation, found true\n"
      "lab/c.toml:7:8: error: file: expected a text in quotes, found an array");
}

struct BadLine {
  const char* line;
  const char* message;
};
void PrintTo(const BadLine& bad, std::ostream* out) { *out << bad.line; }

class CampaignRefusesLine : public testing::TestWithParam<BadLine> {};
INSTANTIATE_TEST_SUITE_P(
    All,
    CampaignRefusesLine,
    testing::Values(
        BadLine{"weight = nan",
                "4:10: error: weight: expected a number from 1e-6 to 1e6, found nan"},
        BadLine{"weight = 0", "4:10: error: weight: expected a number from 1e-6 to 1e6, found 0"},
        BadLine{"weight = 1e308",
                "4:10: error: weight: expected a number from 1e-6 to 1e6, found 1e+308"},
        BadLine{"initial_soc = 98",
                "4:15: error: initial_soc: expected a state of charge from -0.5 to 1.5 (1 is "
                "full), found 98"},
        BadLine{"lead_resistance_Ohm = -0.1",
                "4:23: error: lead_resistance_Ohm: expected a resistance from 0 to 1000 Ohm, found "
                "-0.1"},
        BadLine{"start_s = inf", "4:11: error: start_s: expected a time in seconds, found inf"},
        BadLine{"end_s = 5\nstart_s = 5",
                "4:9: error: end_s: expected a time after start_s = 5, found 5"},
        BadLine{"hold = 'zero'",
                "4:8: error: hold: expected one of backward, forward, found 'zero'"},
        BadLine{"current_sign = 'negative'",
                "4:16: error: current_sign: expected one of auto, discharge-positive, "
                "discharge-negative, found 'negative'"},
        BadLine{"steps = 3", "4:9: error: steps: expected a list of integers, [1, 2], found 3"},
        BadLine{"steps = [1, -2]", "4:13: error: steps: expected an integer, at least 0, found -2"},
        BadLine{"cycles = [1.0]",
                "4:11: error: cycles: expected an integer, at least 0, found 1.0"},
        BadLine{"columns = 'x'",
                "4:11: error: columns: expected a table, { time_s = \"name in the header\" }, "
                "found 'x'"},
        BadLine{"columns = { voltage = 'x' }",
                "4:13: error: columns: expected one of time_s, current_A, voltage_V, "
                "temperature_degC, found 'voltage'"},
        BadLine{
            "columns = { voltage_V = 0 }",
            "4:25: error: columns.voltage_V: expected the name of a column in quotes, or its number from 1, found "
            "0"},
        BadLine{
            "columns = { voltage_V = 2.5 }",
            "4:25: error: columns.voltage_V: expected the name of a column in quotes, or its number from 1, found "
            "2.5"},
        BadLine{"units = 's,A'",
                "4:9: error: units: expected the units of time, current and voltage, [\"s\", "
                "\"A\", \"V\"] (s, ms, min or h; A or mA; V or mV), found 's,A'"},
        BadLine{"units = ['s', 'V', 'A']",
                "4:9: error: units: expected the units of time, current and voltage, [\"s\", "
                "\"A\", \"V\"] (s, ms, min or h; A or mA; V or mV), found [s, V, A]"}));

TEST_P(CampaignRefusesLine, WithLineAndColumn) {
  const auto text =
      std::string("[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n") + GetParam().line + "\n";
  EXPECT_EQ(RefusalOfCampaign(text), std::string("lab/c.toml:") + GetParam().message);
}

TEST(CampaignRefuses, CutOffThatIsNoCells) {
  EXPECT_EQ(
      RefusalOfCampaign("[cell]\ncutoff_V = 3000\n[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n"),
      "lab/c.toml:2:12: error: cutoff_V: expected the cut-off of one cell, from 0.5 V to 6 "
      "V, found 3000");
}

TEST(CampaignRefuses, TheSameLogTwice) {
  const std::string one = "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\n";
  EXPECT_EQ(RefusalOfCampaign(one + "[[log]]\nkind = 'pulses'\nfile = './a.csv'\n"),
            "lab/c.toml:6:8: error: expected each log once, found './a.csv' of kind pulses again "
            "(first in line 3)");
  EXPECT_EQ(RefusalOfCampaign(one + "[[log]]\nkind = 'pulses'\nfile = 'a.csv'\nsteps = [5]\n"),
            "no error");
  EXPECT_EQ(RefusalOfCampaign(one + "[[log]]\nkind = 'validation'\nfile = 'a.csv'\n"), "no error");
}

// The sets that cannot identify a cell.

std::string SetRefusal(const std::string& kinds, const std::string& cell, bool curve_given) {
  std::string text = "[cell]\n" + cell + "\n";
  for (const char kind : kinds) {
    text += std::string("[[log]]\nfile = '") + kind + ".csv'\nkind = '" +
            (kind == 'c'   ? "constant-current"
             : kind == 'l' ? "low-rate"
             : kind == 'p' ? "pulses"
             : kind == 'f' ? "flight"
                           : "validation") +
            "'\n";
  }
  const auto campaign = ParseCampaign(text, "c.toml");
  return LoadErrorOf([&] { CheckCampaign(campaign, curve_given); });
}

TEST(CheckCampaign, OfFlightsAloneNeedsTheCapacity) {
  EXPECT_EQ(SetRefusal("fv", "capacity_Ah = 5.2", false), "no error");
  EXPECT_EQ(SetRefusal("fv", "cutoff_V = 3.0", false),
            "c.toml:1:1: error: expected the capacity of the cell, because flights alone do not "
            "tell it, found none; give capacity_Ah in [cell]");
}

TEST(CheckCampaign, NeedsALowRateLogPulsesOrACurve) {
  EXPECT_EQ(SetRefusal("c", "cutoff_V = 3.0", false),
            "c.toml:1:1: error: expected a [[log]] of kind \"low-rate\" for the open-circuit "
            "voltage, or of kind \"pulses\" with rests, found neither; add one, or give the curve "
            "with --open-circuit-voltage FILE");
  EXPECT_EQ(SetRefusal("c", "cutoff_V = 3.0", true), "no error");
  EXPECT_EQ(SetRefusal("p", "", false), "no error");
  EXPECT_EQ(SetRefusal("pl", "", false), "no error");
}

TEST(CheckCampaign, NeedsPulsesOrConstantCurrents) {
  EXPECT_EQ(SetRefusal("lv", "", false),
            "c.toml:1:1: error: expected a [[log]] of kind \"constant-current\" or \"pulses\", "
            "found none; without a "
            "load no resistance can be identified");
}

TEST(CheckCampaign, NeedsACutOffForConstantCurrents) {
  EXPECT_EQ(SetRefusal("lc", "", false),
            "c.toml:1:1: error: expected cutoff_V in [cell], the voltage of one cell that ends the "
            "constant-current "
            "logs, found none");
  EXPECT_EQ(SetRefusal("lc", "cutoff_V = 3.0", false), "no error");
}

TEST(AddLogs, KeepsKindsAndOptions) {
  Campaign campaign;
  campaign.cutoff_V = 3.0;
  const ReadOptions read{.units = {"s", "A", "V"}};
  AddLogs(campaign, LogKind::kConstantCurrent, {"a/1c.csv", "a/2c.csv"}, read, 0.9);
  AddLogs(campaign, LogKind::kLowRate, {"slow.csv"}, read, 0.9);
  EXPECT_TRUE(campaign.file.empty());
  ASSERT_EQ(campaign.logs.size(), 3U);
  EXPECT_EQ(campaign.logs[1].path, "a/2c.csv");
  EXPECT_EQ(campaign.logs[2].kind, LogKind::kLowRate);
  EXPECT_EQ(campaign.logs[2].read.units.size(), 3U);
  EXPECT_EQ(campaign.logs[2].initial_soc, 0.9);
  EXPECT_NO_THROW(CheckCampaign(campaign, false));
}

TEST(AddLogs, RefusesByOptionAndNotByFile) {
  const auto refusal = [](const std::vector<std::string>& files) -> std::string {
    Campaign campaign;
    try {
      AddLogs(campaign, LogKind::kConstantCurrent, files, {});
      CheckCampaign(campaign, false);
    } catch (const OptionError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(refusal({"1c.csv", "./1c.csv"}), "'./1c.csv' is given twice; name each log once");
  EXPECT_EQ(refusal({"1c.csv"}),
            "expected a low-rate log for the open-circuit voltage, or pulses with rests, found "
            "neither; give one with --low-rate or --pulses, or the curve with "
            "--open-circuit-voltage FILE\n"
            "expected the cut-off voltage of the constant-current logs, found none; give it with "
            "--cutoff-V");
}

}  // namespace
}  // namespace lipoid
