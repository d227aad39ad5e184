#include "tools/serve/safe_name.h"

#include <gtest/gtest.h>

#include <random>

namespace lipoid {
namespace {

TEST(SafeName, KeepsNamesThatLeadNowhere) {
  for (const char* const name : {"cc_1C.csv",
                                 "Zelle 3 (25 degC).txt",
                                 "\xC3\xBC"
                                 "ber.csv",
                                 "a",
                                 "1.2.3"})
    EXPECT_EQ(SafeName(name, {}), name);
}

TEST(SafeName, TakesTheLastPartOfAPath) {
  EXPECT_EQ(SafeName("../../etc/passwd", {}), "passwd");
  EXPECT_EQ(SafeName("C:\\logs\\a.csv", {}), "a.csv");
  for (const char* const nothing : {"", ".", "..", "/", "a/", "...", " . ", "-", "--", "\n"})
    EXPECT_EQ(SafeName(nothing, {}), "log") << nothing;
}

TEST(SafeName, CountsNamesThatAreTaken) {
  EXPECT_EQ(SafeName("a.csv", {"a.csv"}), "a-2.csv");
  EXPECT_EQ(SafeName("A.csv", {"a.csv", "a-2.csv"}), "A-3.csv");
  EXPECT_EQ(SafeName("a", {"a"}), "a-2");
}

TEST(SafeName, CutsLongNamesBetweenCharacters) {
  std::string name;
  for (int k = 0; k < 80; ++k) name += "\xC3\xBC";
  const std::string cut = SafeName(name + ".csv", {});
  EXPECT_EQ(cut, name.substr(0, 96) + ".csv");
  EXPECT_EQ(SafeName("x" + name + ".csv", {}), ("x" + name).substr(0, 95) + ".csv");
}

TEST(SafeName, NothingElseEverComesOut) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<int> length(0, 150);
  for (int k = 0; k < 20000; ++k) {
    std::string name(static_cast<std::size_t>(length(random)), '\0');
    for (char& c : name) c = static_cast<char>(byte(random));
    const std::string safe = SafeName(name, {"log"});
    ASSERT_FALSE(safe.empty());
    ASSERT_LE(safe.size(), 104U);
    ASSERT_EQ(safe.find_first_of(std::string("/\\\0\n\r\t\"'$`*?<>|&;:", 19)), std::string::npos);
    ASSERT_NE(safe.front(), '.');
    ASSERT_NE(safe.front(), '-');
    ASSERT_EQ(SafeName(safe, {}), safe);
  }
}

}  // namespace
}  // namespace lipoid
