#include "model/core/toml_reader.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>

#include "tests/support/colour.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::Colour;

// What is wrong with the text, one line per mistake; empty where nothing is.
std::string Refusal(const std::string& text, const std::function<void(const TomlReader&)>& read) {
  const toml::table document = ParseToml(text, "x.toml", "a test");
  std::vector<Diagnostic> problems;
  read(TomlReader(document, "x.toml", problems));
  if (problems.empty()) return "";
  return test::MessageOf<LoadError>([&] { ThrowProblems(problems); });
}

TEST(TomlReader, ReadsEveryKindOfValue) {
  std::string text;
  double number = 0.0;
  double whole = 0.0;
  std::array<double, 3> numbers{};
  int integer = 0;
  std::vector<int> integers;
  Colour colour = Colour::kRed;
  EXPECT_EQ(Refusal("a = \"b\"\nn = 2.5\nw = 3\nl = [1, 2.5, -3e2]\ni = -4\nm = [5, 6]\n"
                    "c = \"blue\"\n",
                    [&](const TomlReader& reader) {
                      EXPECT_TRUE(reader.Text("a", text));
                      EXPECT_TRUE(reader.Number("n", 0.0, 3.0, "", number));
                      EXPECT_TRUE(reader.Number("w", 0.0, 3.0, "", whole));
                      EXPECT_TRUE(reader.Numbers("l", -300.0, 3.0, "", numbers));
                      EXPECT_TRUE(reader.Integer("i", -4, 0, integer));
                      EXPECT_TRUE(reader.Integers("m", integers));
                      EXPECT_TRUE(reader.Choice("c", colour));
                      EXPECT_FALSE(reader.Text("absent", text));
                      reader.OnlyKeys({"a", "n", "w", "l", "i", "m", "c"});
                    }),
            "");
  EXPECT_EQ(text, "b");
  EXPECT_EQ(number, 2.5);
  EXPECT_EQ(whole, 3.0);
  EXPECT_EQ(numbers, (std::array{1.0, 2.5, -300.0}));
  EXPECT_EQ(integer, -4);
  EXPECT_EQ(integers, (std::vector{5, 6}));
  EXPECT_EQ(colour, Colour::kBlue);
}

TEST(TomlReader, NamesEveryMistakeInTheOrderOfTheFile) {
  double number = 7.0;
  std::array<double, 2> pair{};
  std::string text = "as before";
  EXPECT_EQ(Refusal("n = nan\n  p = [1.0]\nt = 5\nq = [1, inf]\n\nz = 1\n",
                    [&](const TomlReader& reader) {
                      EXPECT_FALSE(reader.Text("t", text));
                      EXPECT_FALSE(reader.Numbers("q", 0.0, reader.kLargest, "two sides", pair));
                      EXPECT_FALSE(reader.Numbers("p", 0.0, 1.0, "two sides", pair));
                      EXPECT_FALSE(reader.Number("n", 0.0, 1.0, "a share", number));
                      reader.OnlyKeys({"n", "p", "q", "t"});
                    }),
            "x.toml:1:5: error: n: expected a share, found nan\n"
            "x.toml:2:7: error: p: expected 2 numbers, two sides, found 1\n"
            "x.toml:3:5: error: t: expected a text in quotes, found 5\n"
            "x.toml:4:9: error: q: expected two sides, found inf\n"
            "x.toml:6:1: error: expected one of the keys n, p, q, t, found 'z'");
  EXPECT_EQ(number, 7.0);
  EXPECT_EQ(text, "as before");
}

TEST(TomlReader, TakesNoTypeForAnother) {
  double number = 0.0;
  int integer = 0;
  std::vector<int> integers;
  std::array<double, 2> pair{};
  Colour colour = Colour::kRed;
  EXPECT_EQ(Refusal("a = true\nb = 2.0\nc = [1.5]\nd = \"green\"\ne = { f = 1 }\n",
                    [&](const TomlReader& reader) {
                      reader.Number("a", 0.0, 1.0, "a number", number);
                      reader.Integer("b", 0, 9, integer);
                      reader.Integers("c", integers);
                      reader.Choice("d", colour);
                      reader.Numbers("e", 0.0, 1.0, "a and b", pair);
                    }),
            "x.toml:1:5: error: a: expected a number, found true\n"
            "x.toml:2:5: error: b: expected an integer from 0 to 9, found 2.0\n"
            "x.toml:3:6: error: c: expected an integer, at least 0, found 1.5\n"
            "x.toml:4:5: error: d: expected one of red, blue, found 'green'\n"
            "x.toml:5:5: error: e: expected 2 numbers, a and b, found a table");
  EXPECT_EQ(integers.size(), 0U);
}

TEST(TomlReader, SyntaxErrorsHaveLineAndColumn) {
  EXPECT_EQ(
      test::MessageOf<LoadError>([] { (void)ParseToml("a = 1\nb = \n", "x.toml", "a test"); }),
      "x.toml:2:5: error: not a test in TOML: key-value pair: expected value, saw '\\n'");
  EXPECT_EQ(test::MessageOf<LoadError>([] {
              (void)ParseToml("a = 1\na = 2\n", "x.toml", "a test");
            }).substr(0, 31),
            "x.toml:2:5: error: not a test i");
}

TEST(TomlReader, NothingWrongThrowsNothing) { EXPECT_NO_THROW(ThrowProblems({})); }

TEST(TomlReader, WritesWhatItReadsBack) {
  EXPECT_EQ(TomlFloat(2.0), "2.0");
  EXPECT_EQ(TomlFloat(1e-4), "0.0001");
  const std::string text = "a \"quoted\" \\ text\twith TAB";
  EXPECT_EQ(ParseToml("t = " + TomlText(text), "x.toml", "a test")["t"].value<std::string>(), text);
  EXPECT_EQ(ParseToml("t = " + TomlFloat(0.1 + 0.2), "x.toml", "a test")["t"].value<double>(),
            0.1 + 0.2);
}

}  // namespace
}  // namespace lipoid
