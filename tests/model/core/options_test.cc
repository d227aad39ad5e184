#include "model/core/options.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "tests/support/colour.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::Colour;

struct Sample {
  bool tail = true;
  int terms = 10;
  int any = -1;
  double tolerance = 1e-6;
  double least = 0.5;
  std::string label = "none";
  Colour colour = Colour::kRed;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("tail", self.tail, Names(), "a switch");
    v("terms", self.terms, Range{0, 1000}, "a number of terms");
    v("any", self.any, Range{}, "any whole number");
    v("tolerance", self.tolerance, Range{0.0, 1.0}, "a tolerance");
    v("least", self.least, Range{.lo = 0.25}, "bounded below");
    v("label", self.label, Names(), "a text");
    v("colour", self.colour, Names(), "a choice");
  }
};

std::string Refusal(const char* name, const char* text) {
  Sample options;
  return test::MessageOf<OptionError>([&] { SetOption(options, name, text); });
}

TEST(Options, EveryKindIsSetFromText) {
  Sample options;
  SetOption(options, "tail", "off");
  SetOption(options, "terms", "25");
  SetOption(options, "any", "-40");
  SetOption(options, "tolerance", "2.5e-9");
  SetOption(options, "least", "1e300");
  SetOption(options, "label", "a, b=c");
  SetOption(options, "colour", "blue");
  EXPECT_FALSE(options.tail);
  EXPECT_EQ(options.terms, 25);
  EXPECT_EQ(options.any, -40);
  EXPECT_EQ(options.tolerance, 2.5e-9);
  EXPECT_EQ(options.least, 1e300);
  EXPECT_EQ(options.label, "a, b=c");
  EXPECT_EQ(options.colour, Colour::kBlue);
  SetOption(options, "tail", "yes");
  EXPECT_TRUE(options.tail);
}

TEST(Options, RefusalsNameTheOptionTheTextAndWhatIsValid) {
  EXPECT_EQ(Refusal("tail", "maybe"), "option tail: expected true or false, found 'maybe'");
  EXPECT_EQ(Refusal("terms", "1001"),
            "option terms: expected a whole number, 0 .. 1000, found '1001'");
  EXPECT_EQ(Refusal("terms", "2.7"),
            "option terms: expected a whole number, 0 .. 1000, found '2.7'");
  EXPECT_EQ(Refusal("terms", ""), "option terms: expected a whole number, 0 .. 1000, found ''");
  EXPECT_EQ(Refusal("any", "9999999999"),
            "option any: expected a whole number, found '9999999999'");
  EXPECT_EQ(Refusal("tolerance", "-1"), "option tolerance: expected 0 .. 1, found '-1'");
  EXPECT_EQ(Refusal("tolerance", "nan"), "option tolerance: expected 0 .. 1, found 'nan'");
  EXPECT_EQ(
      Refusal("tolerance", "0.5x"),
      "option tolerance: expected a number, 0 .. 1, found '0.5x': write the number alone, in the option's own "
      "unit");
  EXPECT_EQ(
      Refusal("tolerance", "25°C"),
      "option tolerance: expected a number, 0 .. 1, found '25°C': write the number alone, in the option's own "
      "unit");
  EXPECT_EQ(
      Refusal("terms", "4S"),
      "option terms: expected a whole number, 0 .. 1000, found '4S': write the number alone, in the option's own "
      "unit");
  EXPECT_EQ(Refusal("tolerance", "90%"),
            "option tolerance: expected a number, 0 .. 1, found '90%': write 0.9");
  EXPECT_EQ(Refusal("tolerance", "900%"),
            "option tolerance: expected a number, 0 .. 1, found '900%'");
  EXPECT_EQ(Refusal("tolerance", "0,5"),
            "option tolerance: expected a number, 0 .. 1, found '0,5'");
  EXPECT_EQ(Refusal("least", "0.2"), "option least: expected at least 0.25, found '0.2'");
  EXPECT_EQ(Refusal("colour", "green"), "option colour: expected one of red, blue, found 'green'");
  EXPECT_EQ(
      Refusal("term", "3"),
      "unknown option 'term'. Did you mean 'terms'? Known: tail, terms, any, tolerance, least, label, colour");
}

TEST(Options, RefusedTextChangesNothing) {
  Sample options;
  EXPECT_THROW(SetOption(options, "terms", "-1"), OptionError);
  EXPECT_EQ(options.terms, 10);
}

TEST(Options, DescriptionsComeFromTheDeclaration) {
  const auto all = DescribeOptions<Sample>();
  ASSERT_EQ(all.size(), 7U);
  const char* const expected[7][4] = {{"tail", "true", "true | false", "a switch"},
                                      {"terms", "10", "0 .. 1000", "a number of terms"},
                                      {"any", "-1", "a whole number", "any whole number"},
                                      {"tolerance", "1e-06", "0 .. 1", "a tolerance"},
                                      {"least", "0.5", "at least 0.25", "bounded below"},
                                      {"label", "none", "text", "a text"},
                                      {"colour", "red", "red | blue", "a choice"}};
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_EQ(all[k].name, expected[k][0]);
    EXPECT_EQ(all[k].default_text, expected[k][1]);
    EXPECT_EQ(all[k].valid, expected[k][2]);
    EXPECT_EQ(all[k].help, expected[k][3]);
  }
}

TEST(Options, JsonHoldsNumbersAsNumbersAndChoicesByName) {
  Sample options;
  options.tolerance = 0.1;
  options.colour = Colour::kBlue;
  EXPECT_EQ(
      OptionsToJson<Json>(options).dump(),
      R"({"tail":true,"terms":10,"any":-1,"tolerance":0.1,"least":0.5,"label":"none","colour":"blue"})");
}

TEST(Options, TextOfEveryValueSetsItAgain) {
  Sample options;
  options.tolerance = 1.0 / 3.0;
  options.colour = Colour::kBlue;
  options.tail = false;
  Sample again;
  for (const auto& [name, text] : OptionValues(options)) SetOption(again, name, text);
  EXPECT_EQ(OptionValues(again), OptionValues(options));
  EXPECT_EQ(again.tolerance, 1.0 / 3.0);
  EXPECT_EQ(again.colour, Colour::kBlue);
}

}  // namespace
}  // namespace lipoid
