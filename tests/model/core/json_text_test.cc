#include "model/core/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

TEST(JsonText, KeepsListsOfNumbersOnALineAndEveryValue) {
  const Json json = {{"name", "a \"cell\""},
                     {"rows", {{1.0, 0.1}, {0.1, 2.5e-17}}},
                     {"nothing", Json::array()},
                     {"logs", {{{"file", "a.csv"}, {"error", nullptr}}}}};
  const std::string text = JsonText(json);
  EXPECT_EQ(text,
            R"({
  "name": "a \"cell\"",
  "rows": [
    [1.0, 0.1],
    [0.1, 2.5e-17]
  ],
  "nothing": [],
  "logs": [
    {
      "file": "a.csv",
      "error": null
    }
  ]
}
)");
  EXPECT_EQ(Json::parse(text), json);
  EXPECT_EQ(JsonText(Json()), "null\n");
  // Names of files may be anything but UTF-8.
  EXPECT_TRUE(Json::parse(JsonText({{"file", "\xff.csv"}})).is_object());
}

}  // namespace
}  // namespace lipoid
