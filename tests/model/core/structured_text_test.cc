// The limits of structured files, and that reading what is at a limit takes no longer than its
// length.
#include "model/core/structured_text.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>

#include "model/core/json.h"
#include "model/core/toml_reader.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

// Linear reading of some megabytes takes a tenth of this; what was quadratic took 20 s and more.
constexpr double kPatience_s = 5.0;

std::string Repeated(std::string_view piece, std::size_t times) {
  std::string text;
  for (std::size_t k = 0; k < times; ++k) text += piece;
  return text;
}

template <class Call>
std::string RefusedInTime(Call&& call) {
  const auto began = std::chrono::steady_clock::now();
  const std::string what = test::MessageOf<LoadError>(call);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  EXPECT_LT(took.count(), kPatience_s);
  return what;
}

std::string JsonRefusal(const std::string& text) {
  return RefusedInTime([&] { (void)ParseJson(text, "x.json"); });
}

std::string TomlRefusal(const std::string& text) {
  return RefusedInTime([&] { (void)ParseToml(text, "x.toml", "a campaign"); });
}

constexpr const char* kReads = "(no exception)";

TEST(StructuredText, ANulIsNoText) {
  EXPECT_EQ(JsonRefusal(std::string("0\0,", 3)),
            "x.json:1:2: error: expected text, found a NUL byte");
  EXPECT_EQ(JsonRefusal(std::string("{\"a\":1}\n\0,\"b", 12)),
            "x.json:2:1: error: expected text, found a NUL byte");
  EXPECT_EQ(TomlRefusal(std::string("a = 1\nb\0", 8)),
            "x.toml:2:2: error: expected text, found a NUL byte");
}

TEST(StructuredText, TheFilesThatBrokeAnEarlierReaderAreRefused) {
  for (const char* const name :
       {"01_nul_double_free", "01_nul_escaped_exception", "01_nul_segfault"}) {
    const std::string text =
        ReadTextFile(test::SourcePath(std::string("fixtures/hostile/") + name + ".json"));
    EXPECT_NE(JsonRefusal(text).find("found a NUL byte"), std::string::npos) << name;
  }
}

TEST(StructuredText, DepthIsLimitedAndTheLimitIsReached) {
  for (const auto& [open, close] : {std::pair("[", "]"), std::pair("{\"a\":", "}")}) {
    const auto nested = [open = open, close = close](std::size_t depth) {
      return Repeated(open, depth) + "1" + Repeated(close, depth);
    };
    EXPECT_EQ(JsonRefusal(nested(structured_text::kMostDepth)), kReads);
    const std::string first = JsonRefusal(nested(structured_text::kMostDepth + 1));
    EXPECT_NE(first.find("error: expected at most 64 lists and tables in one another, found more"),
              std::string::npos)
        << first;
    EXPECT_EQ(JsonRefusal(nested(20'000)), first);
    EXPECT_EQ(JsonRefusal(Repeated(open, 1'000'000 / std::string_view(open).size())), first);
  }
}

TEST(StructuredText, DepthOfTomlIsLimitedInEveryForm) {
  constexpr const char* kDots = "expected at most 64 parts of a key, found more";
  constexpr const char* kNested = "expected at most 64 lists and tables in one another, found more";
  const std::string long_key = Repeated("a.", 35'000) + "a";
  for (const std::string& text : {long_key + " = 1",
                                  "[" + long_key + "]",
                                  "[[" + long_key + "]]",
                                  "x = {" + long_key + " = 1}",
                                  "x = \"\"\"a\"\"\"\"\n" + long_key + " = 1",
                                  "x = [\"\"\"a\"\"\"\"\", {" + long_key + " = 1}]",
                                  Repeated("\"a b\" . ", 5'000) + "c = 1"}) {
    EXPECT_NE(TomlRefusal(text).find(kDots), std::string::npos) << text.substr(0, 60);
  }
  EXPECT_NE(TomlRefusal("x = " + Repeated("[", 5'000)).find(kNested), std::string::npos);
  EXPECT_NE(TomlRefusal("x = " + Repeated("{a = ", 5'000)).find(kNested), std::string::npos);
  EXPECT_EQ(TomlRefusal(Repeated("a.", 60) + "a = 1"), kReads);
  EXPECT_EQ(TomlRefusal("x = " + Repeated("[", 60) + Repeated("]", 60)), kReads);
}

TEST(StructuredText, DotsAndBracketsOfValuesAndRemarksCountForNothing) {
  EXPECT_EQ(TomlRefusal("# " + Repeated("[.", 500) + "\nx = \"" + Repeated("{.", 500) + "\" # '\n" +
                        "y = '''" + Repeated("[.\n", 500) + "'''\nz = [" +
                        Repeated("1.5, 2.5, \n", 500) + "]\n"),
            kReads);
}

TEST(StructuredText, KeysAreLimitedAndReadInTheirNumber) {
  const auto keys = [](std::size_t count) {
    std::string text = "{";
    for (std::size_t k = 0; k < count; ++k)
      text += (k > 0 ? ",\n" : "") + std::string("\"k") + std::to_string(k) + "\":1";
    return text + "}";
  };
  EXPECT_EQ(JsonRefusal(keys(structured_text::kMostKeys)), kReads);
  EXPECT_EQ(JsonRefusal(keys(100'000)),
            "x.json:50001:1: error: expected at most 50000 keys, found more");
  std::string toml;
  for (int k = 0; k < 100'000; ++k) toml += "k" + std::to_string(k) + " = 1\n";
  EXPECT_EQ(TomlRefusal(toml), "x.toml:50001:8: error: expected at most 50000 keys, found more");
}

TEST(StructuredText, ValuesAndBytesAndLinesAreLimited) {
  EXPECT_NE(JsonRefusal("[" + Repeated("1,\n", 1'100'000) + "1]")
                .find("expected at most 1000000 values, found more"),
            std::string::npos);
  EXPECT_NE(TomlRefusal("x = [" + Repeated("1,\n", 1'100'000) + "1]")
                .find("expected at most 1000000 values, found more"),
            std::string::npos);
  EXPECT_EQ(JsonRefusal("\n\n" + std::string(structured_text::kMostBytesOfLine + 1, ' ')),
            "x.json:3:1: error: expected lines of at most 1048576 bytes, found one of 1048577");
  EXPECT_EQ(TomlRefusal(Repeated("# remark\n", 2'000'000)),
            "x.toml:1:1: error: expected at most 16777216 bytes, found more: this is no file that "
            "lipoid reads");
}

TEST(StructuredText, AFileWithoutEndIsReadUpToTheLimit) {
  EXPECT_EQ(
      RefusedInTime([] { (void)ReadTextFile("/dev/zero"); }),
      "/dev/zero:1:1: error: expected at most 16777216 bytes, found more: this is no file that "
      "lipoid reads");
}

TEST(StructuredText, MessagesShowLittleOfWhatIsLong) {
  const std::string megabyte(900'000, 'x');
  EXPECT_LT(JsonRefusal("{\"a\": \"" + megabyte).size(), 500U);
  EXPECT_LT(JsonRefusal("{\"" + megabyte + "\": 1, \"" + megabyte + "\": 1}").size(), 500U);
  EXPECT_LT(TomlRefusal("a = \"" + megabyte).size(), 500U);
  const std::string file = "x.json";
  const std::string text = "{\"a\": \"" + megabyte + "\x1b[2J\"}";
  EXPECT_NE(JsonRefusal(text).find("error: expected JSON, found a syntax error"),
            std::string::npos);
  const std::string right = "{\"a\": \"" + megabyte + "\\u001b[2J\"}";
  const Json document = ParseJson(right, file);
  const std::string refused = test::MessageOf<LoadError>(
      [&] { (void)JsonReader(document, file, right).At("a").Number(0.0, 1.0); });
  EXPECT_LT(refused.size(), 500U);
  EXPECT_EQ(refused.find('\x1b'), std::string::npos);
}

// Mutations of a real cell file: each is read, or refused with a place that is in the text.
TEST(StructuredText, WhateverBytesChangeThePlaceIsInTheText) {
  const std::string whole = ReadTextFile(test::SourcePath("fixtures/cells/gifi-600mAh-1.json"));
  std::mt19937 engine(7);
  std::uniform_int_distribution<std::size_t> at(0, whole.size() - 1);
  std::uniform_int_distribution<int> any(0, 255);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = whole;
    for (int change = 0; change <= trial % 3; ++change)
      text[at(engine)] = static_cast<char>(any(engine));
    if (trial % 5 == 0) text.resize(at(engine));
    try {
      const Json document = ParseJson(text, "x.json");
      EXPECT_EQ(document, Json::parse(text)) << trial;
    } catch (const LoadError& error) {
      ++refused;
      const SourcePosition& place = error.diagnostics().front().position;
      const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
      EXPECT_LE(place.line, lines + 1) << trial;
      EXPECT_GE(place.column, 1U) << trial;
    }
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace lipoid
