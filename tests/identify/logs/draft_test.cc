#include "identify/logs/draft.h"

#include <gtest/gtest.h>

#include <fstream>

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
            none + ":1:1: error: expected a folder of logs, found none in it");
  EXPECT_EQ(test::LoadErrorOf([&] { (void)FilesOfFolder("no/folder"); }),
            "no/folder:1:1: error: expected a folder of logs, found No such file or directory");
}

}  // namespace
}  // namespace lipoid
