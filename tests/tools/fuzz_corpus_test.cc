// The corpora of the fuzzers again: each input ends in an answer or in a refusal.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/fuzz/targets.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

class FuzzCorpus : public testing::TestWithParam<FuzzTarget> {};

TEST_P(FuzzCorpus, EndsInAnswersAndRefusals) {
  const std::filesystem::path corpus = SourcePath("tests/fuzz/corpus");
  const std::filesystem::path folder = corpus / GetParam().name;
  ASSERT_TRUE(std::filesystem::is_directory(folder)) << folder;
  int inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    EXPECT_NO_THROW(RunFuzzTarget(GetParam(), ReadText(entry.path().string())));
    ++inputs;
  }
  EXPECT_GT(inputs, 0);
}

INSTANTIATE_TEST_SUITE_P(Targets,
                         FuzzCorpus,
                         testing::ValuesIn(FuzzTargets().begin(), FuzzTargets().end()),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace lipoid::test
