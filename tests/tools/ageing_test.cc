// lipoid ageing, end to end. What it finds: tests/identify/ageing_test.cc.
#include <gtest/gtest.h>

#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

// A resistance is that of half charge, and the word behind each interval has a header.
TEST(AgeingCommand, TheTableSaysWhatItsRowsAndColumnsAre) {
  const auto folder = TestFolder();
  ASSERT_EQ(RunLipoid(folder, {"synthesize", "gifi-600mAh-1", "--sampling-s", "10", "-o", "logs"})
                .exit_code,
            0);
  ASSERT_EQ(
      RunLipoid(folder, {"identify", "logs/campaign.toml", "--method", "staged", "-o", "cell.json"})
          .exit_code,
      0);
  const auto run = RunLipoid(folder, {"ageing", "cell.json", "cell.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* row :
       {"\ncapacity ", "\nresistance after 1 s ", "\nResistances are those at half charge"})
    EXPECT_NE(run.out.find(row), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("resistance_1s"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("  verdict\n"), std::string::npos) << run.out;
}

}  // namespace
}  // namespace lipoid::test
