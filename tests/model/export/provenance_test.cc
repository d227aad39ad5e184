// What exported files say of themselves.
#include "model/export/provenance.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

ExportRequest Request(std::string source) {
  ExportRequest request;
  request.cell = LoadCell("gifi-600mAh-1");
  request.source = std::move(source);
  request.sha256 = "00ff";
  request.mission.name = "default";
  return request;
}

TEST(Provenance, SaysSourceErrorAndWhatIsLeftOut) {
  Exported exported;
  exported.error =
      ExportError{.rmse_V = 0.0179, .max_error_V = 0.075, .worst_s = 12.0, .worst_soc = 0.5};
  exported.naive =
      ExportError{.rmse_V = 0.119, .max_error_V = 0.3, .worst_s = 13.0, .worst_soc = 0.4};
  exported.cannot_hold = {"Diffusion is absorbed by the resistance."};
  const auto text = Commented(ProvenanceLines(Request("cell.json"), exported), "# ");
  for (const auto* expected : {"cell.json",
                               "00ff",
                               "17.900 mV rms, 75.000 mV at most (at 12.0 s",
                               "119.000 mV rms",
                               "Diffusion is absorbed"})
    EXPECT_NE(text.find(expected), std::string::npos) << expected << "\n" << text;
}

TEST(Provenance, NothingInANameEndsAComment) {
  for (const std::string evil :
       {"a*/system(1);/*", "a-->b<!--", "a\nimport os", "a\\", "{#a#}", "a\r\nb"}) {
    const auto lines = ProvenanceLines(Request(evil), {});
    for (const auto& line : lines) {
      for (const auto* end : {"*/", "/*", "--", "\n", "\r", "#}", "\\"})
        EXPECT_EQ(line.find(end), std::string::npos) << line;
    }
  }
}

TEST(Provenance, LinesWrapAndLoseNoWord) {
  std::string long_line = "  ";
  for (int k = 0; k < 60; ++k) long_line += "word" + std::to_string(k) + " ";
  const auto text = Commented({long_line}, "// ");
  std::size_t start = 0;
  int words = 0;
  while (start < text.size()) {
    const auto end = text.find('\n', start);
    const auto line = text.substr(start, end - start);
    EXPECT_LE(line.size(), 100U);
    EXPECT_EQ(line.rfind("//   word", 0), 0U) << line;
    for (std::size_t at = line.find("word"); at != std::string::npos;
         at = line.find("word", at + 1))
      ++words;
    start = end + 1;
  }
  EXPECT_EQ(words, 60);
  // A word longer than a line is cut, an empty line stays.
  EXPECT_EQ(Commented({std::string(150, 'x')}, "").size(), 152U);
  EXPECT_EQ(Commented({""}, "# "), "#\n");
}

}  // namespace
}  // namespace lipoid
