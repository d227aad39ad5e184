// Frame models of ArduPilot, in which # begins a comment.
#include "identify/export/frame_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/core/json.h"
#include "tests/support/load_error.h"

namespace lipoid {
namespace {

const std::vector<std::pair<std::string, std::string>> kNumbers = {{"maxVoltage", "12.5"},
                                                                   {"refBatRes", "0.05"}};

Json Parsed(const std::string& frame) { return ParseJson(FrameWithoutComments(frame, "f"), "f"); }

TEST(FrameJson, MergingChangesTheNumbersAndNothingElse) {
  const std::string frame =
      "my frame\n{ # of a club\n  \"mass\": 2.5, # kg\n  \"maxVoltage\" : 50.4,\n"
      "  \"motor1_position\": [0.1, 0.2, 0],\n  \"refBatRes\":0.0226 }\n";
  const std::string merged = MergeIntoFrame(frame, "f", kNumbers, "# new\n");
  EXPECT_EQ(merged,
            "my frame\n{\n# new\n # of a club\n  \"mass\": 2.5, # kg\n  \"maxVoltage\" : 12.5,\n"
            "  \"motor1_position\": [0.1, 0.2, 0],\n  \"refBatRes\":0.05 }\n");
}

TEST(FrameJson, MissingKeysComeFirst) {
  const std::string merged =
      MergeIntoFrame("{\"mass\": 1, \"inner\": {\"maxVoltage\": 3}}", "f", kNumbers, "# new\n");
  const Json json = Parsed(merged);
  EXPECT_EQ(json["maxVoltage"], 12.5);
  EXPECT_EQ(json["refBatRes"], 0.05);
  EXPECT_EQ(json["inner"]["maxVoltage"], 3) << "of another object";
  EXPECT_EQ(json["mass"], 1);
  EXPECT_EQ(Parsed(MergeIntoFrame("{}", "f", kNumbers, ""))["refBatRes"], 0.05);
}

TEST(FrameJson, RefusesWhatIsNoFrame) {
  const auto message = [](const std::string& text) {
    return test::LoadErrorOf([&] { (void)MergeIntoFrame(text, "f.json", kNumbers, ""); });
  };
  EXPECT_EQ(message("no brace"),
            "f.json:1:1: error: expected a frame model of ArduPilot, which begins with '{', found "
            "none");
  EXPECT_EQ(message("{\n \"maxVoltage\": \"12\" }"),
            "f.json:2:16: error: /maxVoltage: expected a number, found \"12\"");
  EXPECT_NE(message("{ \"mass\": # 1\n }").find("f.json:2:2: error"), std::string::npos)
      << message("{ \"mass\": # 1\n }");
  EXPECT_NE(message(std::string(100, '{')).find("error"), std::string::npos);
}

}  // namespace
}  // namespace lipoid
