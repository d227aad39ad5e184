#include "model/core/nearest_name.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

const std::vector<std::string> kKnown{"identify", "inspect", "list", "validate"};

TEST(NearestName, HasTheFewestEdits) {
  EXPECT_EQ(Nearest("validat", kKnown), "validate");
  EXPECT_EQ(Nearest("idnetify", kKnown), "identify");  // swapped neighbours are one edit
  EXPECT_EQ(Nearest("lst", kKnown), "list");
  EXPECT_EQ(Nearest("zzzzzz", kKnown), "");
}

TEST(NearestName, IsASentenceForMessages) {
  EXPECT_EQ(DidYouMean("lsit", kKnown), " Did you mean 'list'?");
  EXPECT_EQ(DidYouMean("zzzzzz", kKnown), "");
  EXPECT_EQ(UnknownName("command", "lsit", {"list", "study"}),
            "unknown command 'lsit'. Did you mean 'list'? Known: list, study");
  EXPECT_EQ(UnknownName("command", "x", {"list", "study"}), "unknown command 'x'. Known: list, study");
  EXPECT_EQ(UnknownName("command", "x", {}), "unknown command 'x'; there are none");
}

}  // namespace
}  // namespace lipoid
