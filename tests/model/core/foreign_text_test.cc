#include "model/core/foreign_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "model/core/errors.h"

namespace lipoid {
namespace {

TEST(ForeignText, LeavesWhatCanBeShown) {
  for (const char* const text :
       {"", "plain", "a 'quoted' \"word\", 100 %", "C:\\logs\\x.csv", "Spannung Ω µ é 電池 🔋"}) {
    EXPECT_EQ(ForeignText(text), text);
  }
}

TEST(ForeignText, EscapesWhatATerminalWouldObey) {
  EXPECT_EQ(ForeignText("a\nb\r\tc"), "a\\nb\\r\\tc");
  EXPECT_EQ(ForeignText("\x1b[2J\x1b]0;title\x07"), "\\x1b[2J\\x1b]0;title\\x07");
  EXPECT_EQ(ForeignText(std::string_view("\0\x7f", 2)), "\\x00\\x7f");
  EXPECT_EQ(ForeignText("\xc2\x9b"
                        "2J"),
            "\\u009b2J");  // the C1 form of escape [
  EXPECT_EQ(ForeignText("abc\xe2\x80\xae"
                        "def"),
            "abc\\u202edef");  // right to left from here
}

TEST(ForeignText, EscapesWhatIsNotUtf8) {
  EXPECT_EQ(ForeignText("\xff\xfe.csv"), "\\xff\\xfe.csv");
  EXPECT_EQ(ForeignText("Gr\xf6\xdf"
                        "e"),
            "Gr\\xf6\\xdfe");                                 // Latin-1
  EXPECT_EQ(ForeignText("\xc0\xaf"), "\\xc0\\xaf");           // overlong
  EXPECT_EQ(ForeignText("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
  EXPECT_EQ(ForeignText("\xe2\x82"), "\\xe2\\x82");           // cut short
}

TEST(ForeignText, ShowsBeginningAndEndOfLongTextAndItsLength) {
  const std::string text = "first" + std::string(1'000'000, 'x') + "last";
  const std::string shown = ForeignText(text);
  EXPECT_LE(shown.size(), kMostBytesOfValue);
  EXPECT_TRUE(shown.starts_with("firstx")) << shown;
  EXPECT_TRUE(shown.ends_with("xlast")) << shown;
  EXPECT_NE(shown.find(" ... (1000009 bytes) ... "), std::string::npos) << shown;
}

// Whatever the bytes: what is shown is short, free of control characters, and shown again the same.
TEST(ForeignText, IsShortFreeOfControlCharactersAndTheSameWhenDoneTwice) {
  std::mt19937 engine(1);
  std::uniform_int_distribution<int> any(0, 255);
  std::uniform_int_distribution<int> length(0, 600);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text(static_cast<std::size_t>(length(engine)), ' ');
    for (char& c : text) c = static_cast<char>(any(engine));
    if (trial % 3 == 0) {
      for (char& c : text) c = "\xf0\x9f\x94\x8b"[static_cast<std::size_t>(&c - text.data()) % 4];
    }
    const std::string shown = ForeignText(text);
    ASSERT_LE(shown.size(), kMostBytesOfValue) << trial;
    ASSERT_TRUE(std::none_of(shown.begin(), shown.end(), [](unsigned char c) {
      return c < 0x20 || c == 0x7f;
    })) << trial;
    ASSERT_EQ(ForeignText(shown), shown) << trial;
  }
}

TEST(ForeignLines, KeepsLinesApart) {
  EXPECT_EQ(ForeignLines("one\x1b\n\ntwo\t\n"), "one\\x1b\n\ntwo\\t\n");
  EXPECT_EQ(ForeignLines(""), "");
  EXPECT_EQ(ForeignLines("no end"), "no end");
  EXPECT_LE(ForeignLines("short\n" + std::string(1'000'000, 'x')).size(), 6 + kMostBytesOfMessage);
}

TEST(ForeignText, IsHowErrorsSpeak) {
  const LoadError error({"\x1b[2J.csv", 1, 2}, "found '\x1b[31m" + std::string(100'000, 'x') + "'");
  const std::string what = error.what();
  EXPECT_LT(what.size(), 2 * kMostBytesOfMessage);
  EXPECT_TRUE(what.starts_with("\\x1b[2J.csv:1:2: error: found '\\x1b[31mxxx")) << what;
  EXPECT_EQ(what.find('\x1b'), std::string::npos);
  EXPECT_EQ(error.diagnostics()[0].position.file, "\x1b[2J.csv");
}

TEST(ForeignText, KnowsUtf8) {
  for (const char* text : {"", "abc", "\u00b5", "\u7535\u6d41", "\U0001f50b"})
    EXPECT_TRUE(IsUtf8(text));
  // GBK, Latin-1, cut off, longer than need be, a surrogate.
  for (const char* text : {"\xB5\xE7", "caf\xE9", "\xE7\x94", "\xC0\x80", "\xED\xA0\x80"})
    EXPECT_FALSE(IsUtf8(text)) << text;
}

}  // namespace
}  // namespace lipoid
