#include "model/core/json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "model/core/errors.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

std::string ParseRefusal(const std::string& text) {
  return test::MessageOf<LoadError>([&] { (void)ParseJson(text, "x.json"); });
}

TEST(Json, KeepsTheOrderOfItsKeysAndTheBitsOfItsNumbers) {
  const auto document =
      ParseJson(R"({"z": 0.1, "a": 1.7976931348623157e308, "m": 5e-324})", "x.json");
  EXPECT_EQ(document.dump(), R"({"z":0.1,"a":1.7976931348623157e+308,"m":5e-324})");
  EXPECT_EQ(document["z"].get<double>(), 0.1);
}

TEST(Json, SyntaxErrorHasLineAndColumn) {
  EXPECT_EQ(
      ParseRefusal("{\n  \"a\": 1,\n  \"b\" 2\n}"),
      "x.json:3:7: error: expected JSON, found a syntax error while parsing object separator - "
      "unexpected number literal; expected ':'");
  EXPECT_EQ(ParseRefusal(""),
            "x.json:1:1: error: expected JSON, found a syntax error while parsing value - "
            "unexpected end of "
            "input; expected '[', '{', or a literal");
  EXPECT_EQ(ParseRefusal("{\"a\": [1, 2"),
            "x.json:1:12: error: expected JSON, found a syntax error while parsing array - "
            "unexpected end of "
            "input; expected ']'");
}

TEST(Json, NumbersThatAreNoneAreRefused) {
  EXPECT_EQ(ParseRefusal("{\"a\": NaN}"),
            "x.json:1:7: error: expected JSON, found a syntax error while parsing value - invalid "
            "literal; "
            "last read: '\"a\": N'");
  EXPECT_EQ(ParseRefusal("{\n \"a\": 1e999}"),
            "x.json:2:7: error: expected a number that a double can hold, found 1e999");
}

TEST(Json, RepeatedKeyIsRefusedWhereItIsRepeated) {
  EXPECT_EQ(ParseRefusal("{\"a\": 1,\n \"b\": 2,\n \"a\": 3}"),
            "x.json:3:2: error: expected every key once, found 'a' again");
  // The same name as a text, in another object, in a list of objects: only the third line repeats.
  EXPECT_EQ(
      ParseRefusal("{\"n\": \"soc\", \"t\": {\"soc\": 1}, \"l\": [{\"soc\": 1}, {\"soc\": 2}],\n"
                   " \"u\": {\"soc\": 1,\n  \"soc\": 2}}"),
      "x.json:3:3: error: expected every key once, found 'soc' again");
}

TEST(Json, KeysThatOnlyLookEqualAreNotRepeated) {
  EXPECT_NO_THROW((void)ParseJson(R"({"a/b": 1, "a": {"b": 2}, "a~1b": 3})", "x.json"));
  EXPECT_EQ(ParseRefusal(R"({"a": 1, "\u0061": 2})"),
            "x.json:1:10: error: expected every key once, found 'a' again");
}

// Messages of a reader: pointer, and line and column of the value itself.
class Reader : public ::testing::Test {
 protected:
  const std::string text_ =
      "{\n"
      "  \"number\": 2.5,\n"
      "  \"whole\": 7, \"true\": true,\n"
      "  \"text\": \"a \\\"quoted\\\" [word\",\n"
      "  \"list\": [1, 2,\n"
      "     {\"deep\": [\"x\", -3]}],\n"
      "  \"null\": null, \"a/b\": 1\n"
      "}";
  const std::string file_ = "x.json";
  const Json document_ = ParseJson(text_, file_);
  const JsonReader json_{document_, file_, text_};

  template <class Call>
  std::string Refusal(Call&& call) {
    return test::MessageOf<LoadError>([&] { (void)call(); });
  }
};

TEST_F(Reader, ReadsWhatIsThere) {
  EXPECT_EQ(json_.At("number").Number(0.0, 3.0), 2.5);
  EXPECT_EQ(json_.At("whole").Integer(7, 7), 7);
  EXPECT_EQ(json_.At("whole").Number(0.0, 10.0), 7.0);
  EXPECT_TRUE(json_.At("true").Boolean());
  EXPECT_EQ(json_.At("text").Text(), "a \"quoted\" [word");
  EXPECT_EQ(json_.At("list").Size(), 3U);
  EXPECT_EQ(json_.At("list").Item(2).At("deep").Item(1).Number(-5.0, 0.0), -3.0);
  EXPECT_TRUE(json_.At("null").IsNull());
  EXPECT_FALSE(json_.Find("absent").has_value());
}

TEST_F(Reader, WrongTypesAreRefusedWhereTheyStand) {
  EXPECT_EQ(Refusal([&] { return json_.At("true").Number(0, 1); }),
            "x.json:3:23: error: /true: expected a number, found true");
  EXPECT_EQ(Refusal([&] { return json_.At("number").Integer(0, 9); }),
            "x.json:2:13: error: /number: expected a whole number, found 2.5");
  EXPECT_EQ(Refusal([&] { return json_.At("whole").Boolean(); }),
            "x.json:3:12: error: /whole: expected true or false, found 7");
  EXPECT_EQ(Refusal([&] { return json_.At("null").Text(); }),
            "x.json:7:11: error: /null: expected a text, found null");
  EXPECT_EQ(Refusal([&] { return json_.At("text").Size(); }),
            "x.json:4:11: error: /text: expected a list, found \"a \\\"quoted\\\" [word\"");
  EXPECT_EQ(Refusal([&] { return json_.At("list").At("x"); }),
            "x.json:5:11: error: /list: expected an object, found a list of 3");
  EXPECT_EQ(Refusal([&] { return json_.At("list").Item(2).At("deep").Numbers(0, 1); }),
            "x.json:6:16: error: /list/2/deep/0: expected a number, found \"x\"");
}

TEST_F(Reader, ValuesOutsideTheirRangeAreRefused) {
  const double least = std::numeric_limits<double>::min();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Refusal([&] { return json_.At("number").Number(3, 4); }),
            "x.json:2:13: error: /number: expected a number from 3 to 4, found 2.5");
  EXPECT_EQ(Refusal([&] { return json_.At("number").Number(3, infinity); }),
            "x.json:2:13: error: /number: expected a number of at least 3, found 2.5");
  EXPECT_EQ(
      Refusal([&] { return json_.At("list").Item(2).At("deep").Item(1).Number(least, infinity); }),
      "x.json:6:21: error: /list/2/deep/1: expected a number above 0, found -3");
  EXPECT_EQ(Refusal([&] { return json_.At("number").Number(least, 1.0); }),
            "x.json:2:13: error: /number: expected a number above 0 and at most 1, found 2.5");
  EXPECT_EQ(Refusal([&] { return json_.At("whole").Integer(8, 9); }),
            "x.json:3:12: error: /whole: expected a whole number from 8 to 9, found 7");
}

TEST_F(Reader, MissingAndUnknownKeysAreRefused) {
  EXPECT_EQ(Refusal([&] { return json_.At("absent"); }),
            "x.json:1:1: error: /: expected an object with the key 'absent', found an object");
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] {
        json_.At("list").Item(2).OnlyKeys({"shallow", "flat"});
      }),
      "x.json:6:7: error: /list/2/deep: expected one of the keys shallow, flat, found 'deep'");
  EXPECT_EQ(test::MessageOf<LoadError>([&] {
              json_.OnlyKeys({"number", "whole", "true", "text", "list", "null"});
            }),
            "x.json:7:17: error: /a~1b: expected one of the keys number, whole, true, text, list, "
            "null, found "
            "'a/b'");
}

TEST(JsonReader, PositionsCountFromTheByteOrderMark) {
  const std::string file = "x.json";
  const std::string text = "\xEF\xBB\xBF{\"a\": 1}";
  const auto document = ParseJson(text, file);
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] { (void)JsonReader(document, file, text).At("a").Text(); }),
      "x.json:1:10: error: /a: expected a text, found 1");
}

TEST(ReadTextFile, RefusesWhatIsNoReadableFile) {
  const std::string folder = test::FreshFolder("read_text_file");
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] { (void)ReadTextFile(folder + "/none"); }),
      folder +
          "/none: error: expected a readable file, found none (No such file or directory)");
  EXPECT_EQ(test::MessageOf<LoadError>([&] { (void)ReadTextFile(folder); }),
            folder + ":1:1: error: expected a file, found a folder");
}

}  // namespace
}  // namespace lipoid
