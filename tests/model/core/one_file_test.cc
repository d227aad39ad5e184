#include "model/core/one_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

TEST(OneFile, LinksRelativePathsAndTheCaseOfNewNamesAreFollowed) {
  const std::string folder = test::FreshFolder("OneFile.Links");
  WriteFileAtomically(folder + "/a.csv", "1");
  fs::create_symlink("a.csv", folder + "/link.csv");
  fs::create_directory(folder + "/sub");
  EXPECT_TRUE(LeadToOneFile(folder + "/a.csv", folder + "/link.csv"));
  EXPECT_TRUE(LeadToOneFile(folder + "/a.csv", folder + "/sub/../a.csv"));
  EXPECT_TRUE(LeadToOneFile(folder + "/new.csv", folder + "/sub/../NEW.csv"));
  EXPECT_FALSE(LeadToOneFile(folder + "/a.csv", folder + "/new.csv"));
}

TEST(OneFile, AnInputIsNoOutput) {
  const std::string folder = test::FreshFolder("OneFile.AnInput");
  const std::string input = folder + "/a.csv";
  WriteFileAtomically(input, "1");
  const std::vector<std::string> inputs{"gifi-600mAh-1", input};
  const std::vector<NamedOutput> over{{"file", folder + "/./a.csv"}};
  EXPECT_EQ(test::MessageOf<OptionError>([&] { RefuseInputs(over, inputs); }),
            "option file: '" + folder + "/./a.csv' is also an input; name another file");
  // A name that is no file is nothing that could be lost.
  const std::vector<NamedOutput> beside{{"file", "gifi-600mAh-1"}, {"file", folder + "/b.csv"}};
  EXPECT_NO_THROW(RefuseInputs(beside, inputs));
}

}  // namespace
}  // namespace lipoid
