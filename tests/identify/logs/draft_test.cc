#include "identify/logs/draft.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "identify/logs/plausibility.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::RecordOfSteps;

InspectedFile Inspected(const std::string& file, Record record) {
  record.file = file;
  return {.file = file, .inspection = InspectRecord(record, LogReport{}), .problems = {}};
}

// A discharge whose last row has the given voltage.
InspectedFile Ending(const std::string& file,
                     double current_A,
                     double duration_s,
                     double end_V,
                     double edge_V = 3.6) {
  auto record = RecordOfSteps({{60.0, 0.0}, {duration_s, current_A, duration_s / 1000.0}});
  record.voltage_V[61] = edge_V;
  record.voltage_V.back() = end_V;
  return Inspected(file, std::move(record));
}

// A record at rest at the given voltage, then a discharge whose voltage falls in a straight line.
Record Falling(double rest_V, double current_A, double duration_s, double end_V) {
  auto record = RecordOfSteps({{60.0, 0.0}, {duration_s, current_A, duration_s / 1000.0}});
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double share = k <= 60 ? 0.0 : static_cast<double>(k - 60) / 1000.0;
    record.voltage_V[k] = rest_V + share * (end_V - rest_V);
  }
  return record;
}

TEST(Draft, TakesCapacityFromTheSlowestAndCutOffFromTheEnds) {
  const auto draft = DraftCampaign({Ending("lab/1c.csv", 2.0, 3550.0, 2.9985),
                                    Ending("lab/2c.csv", 4.0, 1750.0, 3.0),
                                    Ending("lab/slow.csv", 0.1, 73000.0, 3.15)},
                                   "lab",
                                   "lab/campaign.toml");
  EXPECT_EQ(draft.campaign.name, "lab");
  EXPECT_EQ(draft.campaign.cutoff_V, 3.0);
  EXPECT_EQ(draft.campaign.capacity_Ah, 2.03);  // 0.1 A for 73000 s: 2.0278 Ah
  ASSERT_EQ(draft.campaign.logs.size(), 3U);
  EXPECT_EQ(draft.campaign.logs[0].file, "1c.csv");
  EXPECT_EQ(draft.campaign.logs[2].kind, LogKind::kLowRate);
}

// A cycler stops within a row, and a fast discharge falls by a tenth of a volt in it: however many there are, the
// cut-off is where all of them passed it.
TEST(Draft, TheCutOffLiesInTheLastRowOfEveryDischarge) {
  std::vector<InspectedFile> files;
  for (const auto& [current_A, end_V, before_V] :
       {std::array{2.0, 2.995, 3.02}, {4.0, 2.981, 3.05}, {6.0, 2.93, 3.09}}) {
    Record record = Falling(4.2, current_A, 7200.0 / current_A, end_V);
    record.voltage_V[record.size() - 2] = before_V;
    files.push_back(Inspected(fmt::format("{}.csv", current_A), std::move(record)));
    EXPECT_EQ(DraftCampaign(files, "cell", "campaign.toml").campaign.cutoff_V, 3.0) << files.size();
  }
  // Of one alone that is fast, too.
  EXPECT_EQ(DraftCampaign({files.back()}, "cell", "campaign.toml").campaign.cutoff_V, 3.0);
}

// The one that did not start full has the lower edge, since v_oc is steep near full.
TEST(Draft, OfSlowDischargesTheOneThatMovesMostIsTaken) {
  const auto draft = DraftCampaign({Ending("lab/1c.csv", 2.0, 3550.0, 3.0),
                                    Ending("lab/slow_95.csv", 0.1, 69000.0, 3.0, 3.4),
                                    Ending("lab/slow.csv", 0.1, 73000.0, 3.0, 3.5)},
                                   "lab",
                                   "lab/campaign.toml");
  ASSERT_EQ(draft.campaign.logs.size(), 2U);
  EXPECT_EQ(draft.campaign.logs[1].file, "slow.csv");
  EXPECT_NE(DraftToToml(draft).find("slow.csv, which moves 2.028 Ah and not 1.917"),
            std::string::npos)
      << DraftToToml(draft);
}

// A slow discharge gives at least what a fast one does: this one began at half charge.
TEST(Draft, ASlowDischargeThatGivesLessThanAFastOneIsNoLowRate) {
  const auto draft = DraftCampaign({Ending("lab/1c.csv", 2.0, 3550.0, 3.0),
                                    Ending("lab/2c.csv", 4.0, 1750.0, 3.0),
                                    Ending("lab/slow_half.csv", 0.1, 36500.0, 3.0)},
                                   "lab",
                                   "lab/campaign.toml");
  EXPECT_EQ(draft.campaign.capacity_Ah, 1.97);
  ASSERT_EQ(draft.entries.size(), 3U);
  EXPECT_EQ(draft.entries[2].left_out,
            "gives 1.014 Ah, where a faster discharge gives 1.972 Ah: it does not go from full to "
            "empty, or is of another cell");
  EXPECT_EQ(draft.campaign.logs.size(), 2U);
  // Beside one that does, it is not the reference either.
  const auto both = DraftCampaign({Ending("lab/1c.csv", 2.0, 3550.0, 3.0),
                                   Ending("lab/slow.csv", 0.15, 48666.0, 3.0),
                                   Ending("lab/slow_half.csv", 0.1, 36500.0, 3.0)},
                                  "lab",
                                  "lab/campaign.toml");
  EXPECT_EQ(both.campaign.capacity_Ah, 2.03);
  ASSERT_EQ(both.campaign.logs.size(), 2U);
  EXPECT_EQ(both.campaign.logs[1].file, "slow.csv");
}

// A half cell against lithium lies below what any cell may be used to, full and empty.
TEST(Draft, OfWhatIsNoCellHasNoCutOff) {
  const auto draft =
      DraftCampaign({Inspected("half.csv", Falling(2.9, 2.0, 3600.0, 0.05))}, "lab", "c.toml");
  EXPECT_FALSE(draft.campaign.cutoff_V);
  EXPECT_NE(DraftToToml(draft).find("from 2.9 V to 0.05 V, where a lithium-ion cell is empty"),
            std::string::npos)
      << DraftToToml(draft);
}

// No cell is empty at 3.69 V, and none falls from full to empty by 30 mV.
TEST(Draft, DischargesThatWereStoppedEarlyGiveNeitherCapacityNorCutOff) {
  const auto draft = DraftCampaign({Inspected("1c.csv", Falling(4.2, 2.0, 1200.0, 3.688)),
                                    Inspected("2c.csv", Falling(4.2, 4.0, 600.0, 3.573)),
                                    Inspected("short.csv", Falling(3.52, 2.0, 140.0, 3.487))},
                                   "lab",
                                   "campaign.toml");
  EXPECT_EQ(draft.campaign.capacity_Ah, 0.0);
  EXPECT_FALSE(draft.campaign.cutoff_V);
  EXPECT_TRUE(draft.campaign.logs.empty());
  EXPECT_EQ(draft.entries[0].left_out, "ends at 3.688 V: it was stopped before the cell was empty");
  EXPECT_EQ(
      draft.remarks.at(0),
      "No log discharges the cell from full to empty: look its capacity and its cut-off up and "
      "give them as capacity_Ah and cutoff_V.");
  // One of iron phosphate does fall little.
  const auto lfp =
      DraftCampaign({Inspected("1c.csv", Falling(3.35, 2.0, 3600.0, 3.0))}, "lab", "campaign.toml");
  EXPECT_EQ(lfp.campaign.cutoff_V, 3.0);
}

TEST(Draft, DoubtsACutOffAtWhichOneDischargeEnds) {
  const auto draft = DraftCampaign({Inspected("1c.csv", Falling(4.2, 2.0, 3500.0, 3.45)),
                                    Inspected("2c.csv", Falling(4.2, 4.0, 1600.0, 3.3))},
                                   "lab",
                                   "campaign.toml");
  EXPECT_EQ(draft.campaign.cutoff_V, 3.45);
  EXPECT_EQ(draft.remarks.at(0),
            "The discharges do not end at one voltage, and 3.45 V is that of one of them: look the "
            "cut-off up.");
}

// The one that is left of discharges that were stopped by time ended at 3.4 V, which became the cut-off.
TEST(Draft, DoubtsTheUnusualCutOffOfOneDischargeAlone) {
  const auto remarks_of = [](double end_V) {
    return DraftCampaign(
               {Inspected("1c.csv", Falling(4.2, 2.0, 3500.0, end_V))}, "lab", "campaign.toml")
        .remarks;
  };
  EXPECT_EQ(remarks_of(3.0), std::vector<std::string>{});
  EXPECT_EQ(remarks_of(3.25), std::vector<std::string>{});
  EXPECT_EQ(remarks_of(3.4),
            std::vector<std::string>{
                "One discharge alone tells the cut-off, and 3.4 V is no usual one: look it up, for "
                "it may have been stopped by time or by a person."});
}

TEST(Draft, OfTwoLowRateLogsThatShowTheSameOneIsLeftOut) {
  const CampaignDraft draft = DraftCampaign(
      {Ending("lab/a.csv", 0.1, 73000.0, 3.0), Ending("lab/b.csv", 0.1, 73000.0, 3.0)},
      "lab",
      "lab/campaign.toml");
  ASSERT_EQ(draft.entries.size(), 2U);
  EXPECT_EQ(draft.entries[0].left_out, "");
  EXPECT_EQ(draft.entries[1].left_out, "as slow as a.csv, which shows as much");
}

// The log that settled the sign may be left out of the campaign.
TEST(Draft, WritesASignThatAnotherLogSettled) {
  auto settled = Ending("lab/slow.csv", 0.1, 73000.0, 3.0);
  settled.inspection->report.current_sign = "discharge-negative";
  settled.inspection->report.current_sign_is_of_others = true;
  const auto draft = DraftCampaign(
      {Ending("lab/1c.csv", 2.0, 3550.0, 3.0), std::move(settled)}, "lab", "lab/campaign.toml");
  ASSERT_EQ(draft.campaign.logs.size(), 2U);
  EXPECT_EQ(draft.campaign.logs[0].read.current_sign, "");
  EXPECT_EQ(draft.campaign.logs[1].read.current_sign, "discharge-negative");
}

TEST(Draft, IsACampaignWhenWritten) {
  auto broken =
      InspectedFile{.file = "lab/broken.csv",
                    .inspection = {},
                    .problems = {{{"lab/broken.csv", 7, 3}, "expected a number, found 'x'"}}};
  const auto draft = DraftCampaign({Ending("lab/1c.csv", 2.0, 3550.0, 3.0),
                                    Ending("lab/2c.csv", 4.0, 1750.0, 3.3),
                                    Ending("lab/2c_again.csv", 4.0, 1750.0, 3.0),
                                    std::move(broken),
                                    Ending("lab/slow.csv", 0.1, 73000.0, 3.0, 3.5),
                                    Ending("lab/slow_leads.csv", 0.1, 73000.0, 3.0, 3.4),
                                    Ending("lab/slow_c8.csv", 0.25, 28800.0, 3.0),
                                    Inspected("lab/rest.csv", RecordOfSteps({{60.0, 0.0}}))},
                                   "lab",
                                   "other/c.toml");
  const auto text = DraftToToml(draft);
  EXPECT_EQ(text,
            R"(# Drafted by lipoid inspect: read it over, most of all capacity, cut-off and kinds.
# No log rests above 3.7 V before its first load: if the cell is not full there, say `initial_soc` of each log.
[cell]
name = "lab"
capacity_Ah = 2.03
cutoff_V = 3.0

# one discharge of 1.972 Ah at 2 A, 1 C of its own charge
[[log]]
kind = "constant-current"
file = "../lab/1c.csv"

# one discharge of 1.944 Ah at 4 A, 2.1 C of its own charge
# Left out: ends at 3.3 V, above the cut-off.
# [[log]]
# kind = "constant-current"
# file = "../lab/2c.csv"

# one discharge of 1.944 Ah at 4 A, 2.1 C of its own charge
[[log]]
kind = "constant-current"
file = "../lab/2c_again.csv"

# one discharge of 2.028 Ah at 0.1 A, 0.049 C of its own charge
[[log]]
kind = "low-rate"
file = "../lab/slow.csv"

# one discharge of 2.028 Ah at 0.1 A, 0.049 C of its own charge
# Left out: as slow as ../lab/slow.csv, whose first edge shows 2 Ohm instead of 3 Ohm.
# [[log]]
# kind = "low-rate"
# file = "../lab/slow_leads.csv"

# one discharge of 2 Ah at 0.25 A, 0.12 C of its own charge
# Left out: ../lab/slow.csv is slower.
# [[log]]
# kind = "low-rate"
# file = "../lab/slow_c8.csv"

# Not used:
#   ../lab/broken.csv: expected a number, found 'x'
#   ../lab/rest.csv: only rest
)");
  const auto campaign = ParseCampaign(text, "other/c.toml");
  EXPECT_EQ(campaign.logs.size(), 3U);
  EXPECT_EQ(campaign.logs[0].path, "lab/1c.csv");
}

TEST(Draft, ReadsTheStartOfALogFromTheLowRateOne) {
  const std::vector<InspectedFile> files{Inspected("1c.csv", Falling(4.2, 2.0, 3600.0, 3.0)),
                                         Inspected("half.csv", Falling(3.6, 2.0, 1800.0, 3.0)),
                                         Inspected("slow.csv", Falling(4.2, 0.1, 72000.0, 3.0))};
  const auto draft = DraftCampaign(files, "lab", "campaign.toml");
  ASSERT_EQ(draft.campaign.logs.size(), 3U);
  EXPECT_EQ(draft.campaign.logs[0].initial_soc, 1.0);
  // Halfway down the straight line, which is that of the faster discharge, too: nothing drops.
  EXPECT_EQ(draft.campaign.logs[1].initial_soc, 0.5);
  EXPECT_EQ(draft.campaign.logs[2].initial_soc, 1.0);
  EXPECT_NE(
      DraftToToml(draft).find("# Does not start full: it rests at 3.6 V before its first load, "
                              "which slow.csv passes at 0.5 of its charge.\n[[log]]\nkind = "
                              "\"constant-current\"\nfile = \"half.csv\"\ninitial_soc = 0.5\n"),
      std::string::npos)
      << DraftToToml(draft);
  // Without one it can only ask.
  const auto asked = DraftCampaign({files[0], files[1]}, "lab", "campaign.toml");
  EXPECT_EQ(asked.campaign.logs[1].initial_soc, 1.0);
  EXPECT_EQ(
      asked.entries[1].remarks,
      (std::vector<std::string>{"Rests at 3.6 V before its first load, 1c.csv at 4.2 V: if it "
                                "does not start full, say its `initial_soc`."}));
}

// A slow discharge drops over its whole resistance, 50 mOhm here, of which its first edge shows a tenth; on this curve
// of 0.1 V the rest is a twentieth of the charge. A second discharge from full shows it.
TEST(Draft, AStartOnAFlatCurveRestsOnTheWholeResistance) {
  const auto on_curve = [](double rest_V, double current_A, double edge_V, double soc) {
    Record record = Falling(rest_V, current_A, 7200.0 * soc / current_A, 3.2);
    for (std::size_t k = 62; k < record.size(); ++k) record.voltage_V[k] -= 0.05 * current_A;
    record.voltage_V[61] = rest_V - edge_V;
    record.voltage_V.back() = 2.9;
    return record;
  };
  Record half = on_curve(3.25, 4.0, 0.02, 0.5);
  // Noise of 3 mV, 0.03 of the charge: the mean of the end of the rest decides, not its last row.
  half.voltage_V[60] = 3.253;
  const std::vector<InspectedFile> files{Inspected("1c.csv", on_curve(3.3, 2.0, 0.01, 1.0)),
                                         Inspected("half.csv", std::move(half)),
                                         Inspected("slow.csv", on_curve(3.3, 0.1, 0.0005, 1.0))};
  const auto draft = DraftCampaign(files, "lab", "campaign.toml");
  ASSERT_EQ(draft.campaign.logs.size(), 3U);
  EXPECT_NEAR(draft.campaign.logs[1].initial_soc, 0.5, 0.01);
  // In the cold all drops are larger, and say nothing of those in the warmth.
  Record cold = on_curve(3.29, 2.0, 0.01, 0.5);
  for (std::size_t k = 62; k + 1 < cold.size(); ++k) cold.voltage_V[k] -= 0.15;
  auto with_cold = files;
  with_cold.push_back(Inspected("cold.csv", std::move(cold)));
  for (InspectedFile& file : with_cold) {
    const double degC = file.file == "cold.csv" ? -20.0 : 25.0;
    file.inspection->temperature_degC = Spread{.least = degC, .largest = degC};
  }
  std::swap(with_cold.front(), with_cold.back());  // as slow as the other, and before it
  const auto beside = DraftCampaign(with_cold, "lab", "campaign.toml");
  ASSERT_EQ(beside.campaign.logs.size(), 4U) << DraftToToml(beside);
  ASSERT_EQ(beside.campaign.logs[1].file, "half.csv");
  EXPECT_NEAR(beside.campaign.logs[1].initial_soc, 0.5, 0.01) << DraftToToml(beside);
}

TEST(Draft, AGivenCutoffSaysWhichDischargesAreWhole) {
  const std::vector<InspectedFile> files{Inspected("2c.csv", Falling(4.2, 4.0, 1700.0, 2.81)),
                                         Inspected("3c.csv", Falling(4.2, 6.0, 1100.0, 2.812)),
                                         Inspected("4c.csv", Falling(4.2, 8.0, 800.0, 2.815)),
                                         Inspected("1c.csv", Falling(4.2, 2.0, 3600.0, 2.965))};
  const auto found = DraftCampaign(files, "lab", "campaign.toml");
  ASSERT_NEAR(*found.campaign.cutoff_V, 2.81, 0.02);
  ASSERT_EQ(found.campaign.logs.size(), 3u);
  const auto given = DraftCampaign(files, "lab", "campaign.toml", {.cutoff_V = 3.0});
  EXPECT_EQ(given.campaign.cutoff_V, 3.0);
  EXPECT_EQ(given.campaign.logs.size(), 4u);
  EXPECT_EQ(DraftCampaign(files, "lab", "campaign.toml", {.cutoff_V = 2.5}).entries[0].left_out,
            "ends at 2.81 V, above the cut-off");
}

TEST(Draft, AFullCellRestsLowerInTheCold) {
  std::vector<InspectedFile> files{Inspected("warm.csv", Falling(4.2, 2.0, 3600.0, 3.0)),
                                   Inspected("cold.csv", Falling(4.15, 2.0, 3600.0, 3.0)),
                                   Inspected("slow.csv", Falling(4.2, 0.1, 72000.0, 3.0))};
  const auto start_of_cold = [&](double cold_degC) {
    for (InspectedFile& file : files) {
      const double degC = file.file == "cold.csv" ? cold_degC : 25.0;
      file.inspection->temperature_degC = Spread{.least = degC, .largest = degC};
    }
    return DraftCampaign(files, "lab", "campaign.toml").campaign.logs[1].initial_soc;
  };
  // 50 mV: more than full cells differ by, and less than 45 K may add, 27 mV.
  EXPECT_LT(start_of_cold(25.0), 0.99);
  EXPECT_EQ(start_of_cold(-20.0), 1.0);
}

TEST(Draft, KnowsAPackByItsVoltage) {
  for (const auto& [highest_V, series] : {std::pair(4.2, 1),
                                          {4.9, 1},
                                          {7.4, 2},
                                          {8.4, 2},
                                          {8.7, 2},
                                          {12.6, 3},
                                          {11.4, 3},
                                          {16.8, 4},
                                          {25.2, 6},
                                          {50.4, 12},
                                          {0.0, 1}}) {
    EXPECT_EQ(CellsInSeries(highest_V), series) << highest_V;
  }
  // Full by one number alone, or two numbers are said. A log of eight cells began at 30.9 V, which are 4.42 V of seven.
  for (const auto& [highest_V, words] : {std::pair(4.2, "1"),
                                         {8.4, "2"},
                                         {12.6, "3"},
                                         {16.8, "4"},
                                         {30.2, "7 or 8"},
                                         {30.9, "8"},
                                         {46.8, "11 or 12"}}) {
    EXPECT_EQ(CellsInSeriesInWords(highest_V), words) << highest_V;
  }
  std::vector<InspectedFile> files;
  for (const auto& [name, current_A] : {std::pair("1c.csv", 2.0), {"2c.csv", 4.0}})
    files.push_back(Inspected(name, Falling(12.6, current_A, 7200.0 / current_A, 9.0)));
  files.push_back(Inspected("cell.csv", Falling(4.2, 2.0, 3600.0, 3.0)));
  const auto draft = DraftCampaign(files, "pack", "campaign.toml", {.parallel = 2});
  EXPECT_EQ(draft.campaign.series, 3);
  EXPECT_EQ(draft.campaign.parallel, 2);
  EXPECT_EQ(draft.campaign.cutoff_V, 3.0);
  EXPECT_EQ(draft.campaign.capacity_Ah, 1.0);
  ASSERT_EQ(draft.campaign.logs.size(), 2U);
  EXPECT_EQ(draft.entries[2].left_out, "its voltage is that of 1 in series");
  EXPECT_EQ(DraftCampaign(files, "pack", "campaign.toml", {.series = 1}).campaign.series, 1);
}

// A pulse near full moves 8 mAh of a cell of some ampere hours: its charge is no capacity.
TEST(Draft, LeavesOutACapacityThatNoLogShows) {
  const auto draft = DraftCampaign(
      {Inspected("pulse.csv", Falling(4.2, 3.0, 10.0, 4.1))}, "cell", "campaign.toml");
  EXPECT_EQ(draft.campaign.capacity_Ah, 0.0);
  EXPECT_EQ(DraftToToml(draft).find("\ncapacity_Ah"), std::string::npos);
  EXPECT_NE(DraftToToml(draft).find("give them as capacity_Ah"), std::string::npos);
}

TEST(Draft, CutsAFileIntoItsTests) {
  Record record = RecordOfSteps({{60.0, 0.0}, {3600.0, 2.0}, {60.0, 0.0}, {3600.0, -2.0}});
  const Record second = RecordOfSteps({{60.0, 0.0}, {1800.0, 4.0}});
  for (std::size_t k = 1; k < second.size(); ++k) {
    record.time_s.push_back(record.time_s.back() + 1.0);
    record.current_A.push_back(second.current_A[k]);
    record.voltage_V.push_back(second.voltage_V[k]);
  }
  const auto draft = DraftCampaign({Inspected("program.csv", record)}, "lab", "campaign.toml");
  ASSERT_EQ(draft.entries.size(), 2U);
  EXPECT_EQ(draft.entries[0].log.read.start_s, 0.0);
  EXPECT_EQ(draft.entries[0].log.read.end_s, 3720.0);
  EXPECT_EQ(draft.entries[1].log.read.start_s, 7321.0);
  EXPECT_EQ(draft.entries[1].log.read.end_s, record.time_s.back());
  EXPECT_EQ(draft.entries[1].log.kind, LogKind::kConstantCurrent);
  EXPECT_NO_THROW((void)ParseCampaign(DraftToToml(draft), "campaign.toml"));
}

// What a file from elsewhere may hold must not become a number that identify refuses.
TEST(Draft, OfADischargeToNothingIsStillACampaign) {
  const auto draft =
      DraftCampaign({Inspected("deep.csv", Falling(4.2, 2.0, 3600.0, 0.0))}, "lab", "c.toml");
  EXPECT_EQ(draft.campaign.cutoff_V, 3.0);
  EXPECT_EQ(draft.remarks,
            (std::vector<std::string>{"The discharges end at 0 V, below what any cell may be used "
                                      "to; 3 V is typical, look it up."}));
  Record tiny = Falling(4.2, 1e-320, 3600.0, 3.0);
  const auto of_tiny = DraftCampaign({Inspected("tiny.csv", std::move(tiny))}, "lab", "c.toml");
  EXPECT_NO_THROW((void)ParseCampaign(DraftToToml(of_tiny), "c.toml"));
}

TEST(Draft, OfRealFoldersIsTheirCampaign) {
  for (const std::string cell : {"nissan_leaf_33ah", "dmegc_inr18650_26_r1", "lg_m50_5ah"}) {
    const auto folder = test::LabDataPath(cell);
    LIPOID_SKIP_WITHOUT(folder);
    std::vector<InspectedFile> files;
    for (const auto& file : FilesOfFolder(folder))
      files.push_back(Inspected(file, test::ReadPlainCsv(file)));
    const auto draft = DraftCampaign(files, cell, folder + "/drafted.toml").campaign;
    const auto wanted = ReadCampaign(folder + "/campaign.toml");
    EXPECT_EQ(draft.cutoff_V, wanted.cutoff_V) << cell;
    // The nominal capacity of a used cell may be a tenth above what it delivers.
    EXPECT_NEAR(draft.capacity_Ah / wanted.capacity_Ah, 1.0, 0.1) << cell;
    ASSERT_EQ(draft.logs.size(), wanted.logs.size()) << cell;
    for (std::size_t k = 0; k < draft.logs.size(); ++k) {
      EXPECT_EQ(draft.logs[k].file, wanted.logs[k].file);
      EXPECT_EQ(draft.logs[k].kind, wanted.logs[k].kind) << draft.logs[k].file;
    }
  }
}

TEST(Draft, TakesACopyOnce) {
  const auto folder = test::FreshFolder("draft/copies");
  for (const std::string name : {"1c.csv", "2c.csv", "copy.csv", "slow.csv"})
    std::ofstream(folder + "/" + name) << (name == "copy.csv" ? "2c.csv" : name) << "\n";
  const auto draft = DraftCampaign({Ending(folder + "/1c.csv", 2.0, 3550.0, 3.0),
                                    Ending(folder + "/2c.csv", 4.0, 1750.0, 3.0),
                                    Ending(folder + "/copy.csv", 4.0, 1750.0, 3.0),
                                    Ending(folder + "/slow.csv", 0.1, 73000.0, 3.0)},
                                   "lab",
                                   folder + "/campaign.toml");
  EXPECT_EQ(draft.campaign.logs.size(), 3U);
  EXPECT_EQ(draft.unused,
            (std::vector<std::pair<std::string, std::string>>{
                {"copy.csv", "holds the same bytes as 2c.csv"}}));
}

TEST(FilesOfFolder, LeavesOutWhatIsNoLog) {
  const auto folder = test::FreshFolder("files_of_folder");
  for (const char* name :
       {"b.csv", "a.txt", "c.041", ".hidden.csv", "README.md", "campaign.toml", "cell.json"}) {
    std::ofstream(folder + "/" + name) << "x\n";
  }
  EXPECT_EQ(FilesOfFolder(folder),
            (std::vector{folder + "/a.txt", folder + "/b.csv", folder + "/c.041"}));
  const auto none = test::FreshFolder("files_of_folder/none");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)FilesOfFolder(none); }),
            none + ": error: expected a folder of logs, found none in it");
  std::filesystem::create_directory(none + "/b");
  std::filesystem::create_directory(none + "/a");
  EXPECT_EQ(
      test::LoadErrorOf([&] { (void)FilesOfFolder(none); }),
      none +
          ": error: expected a folder of logs, found none in it; there are folders within, name one of them: "
          "a, b");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)FilesOfFolder("no/folder"); }),
            "no/folder: error: expected a folder of logs, found No such file or directory");
}

}  // namespace
}  // namespace lipoid
