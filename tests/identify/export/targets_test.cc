// What holds for every target, and what the projected ones find.
#include "identify/export/targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "identify/export/export_report.h"
#include "identify/export/law_limits.h"
#include "identify/export/mission.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/export/provenance.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

ExportRequest RequestOfHostileSource(const Cell& cell) {
  ExportRequest request;
  request.cell = cell;
  request.source = "c*/ell -->\n{#x#}\\.json";
  request.sha256 = "abcd";
  request.name = IdentifierOf(cell.name);
  // Rows of a second: what is tested here holds for any.
  const ExportMission mission = DefaultMission(cell);
  request.mission.name = mission.name;
  for (std::size_t k = 0; k < mission.time_s.size(); k += 10) {
    request.mission.time_s.push_back(mission.time_s[k]);
    request.mission.current_A.push_back(mission.current_A[k]);
  }
  return request;
}

class EveryTarget : public testing::TestWithParam<std::string> {};

TEST_P(EveryTarget, StatesItsErrorItsLimitsAndItsFiles) {
  const ExportTarget& target = FindExportTarget(GetParam());
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series = 3;
  cell.parallel = 2;
  const Exported exported = Export(target, RequestOfHostileSource(cell));
  ASSERT_FALSE(exported.files.empty());
  EXPECT_FALSE(exported.parameters.empty());
  std::set<std::string> names;
  for (const auto& parameter : exported.parameters) {
    EXPECT_TRUE(std::isfinite(parameter.value)) << parameter.name;
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name << " twice";
  }
  EXPECT_TRUE(exported.error || exported.charge_error || target.kind == TargetKind::kData);
  if (target.kind == TargetKind::kProjected) {
    EXPECT_FALSE(exported.cannot_hold.empty());
    if (exported.error && exported.naive) {
      EXPECT_LT(exported.error->rmse_V, exported.naive->rmse_V) << "of what use is the fit?";
    }
  }
  const auto further = target.FurtherSuffixes();
  for (std::size_t k = 1; k < exported.files.size(); ++k)
    EXPECT_NE(std::find(further.begin(), further.end(), exported.files[k].suffix), further.end());
}

// The stated error is that against the cell as it is, and the first file says what is not in it.
TEST_P(EveryTarget, SaysWhatOfTheCellNoTargetHolds) {
  const ExportTarget& target = FindExportTarget(GetParam());
  Cell plain = LoadCell("gifi-600mAh-1");
  ExportRequest request = RequestOfHostileSource(plain);
  request.mission.initial_soc = 0.9;
  const Exported without = Export(target, request);
  Cell cell = plain;
  cell.hysteresis = Cell::Hysteresis{.folds = 30.0, .soc = {}, .half_V = {0.03}};
  cell.temperature.emplace();
  cell.temperature->reference_K = 298.15;
  cell.temperature->series_J_per_mol = 2e4;
  cell.temperature->branches_J_per_mol.assign(cell.branches.size(), 2e4);
  SetCell(request, cell);
  const Exported with = Export(target, request);
  if (target.kind != TargetKind::kProjected && with.error) {
    // A cell that has been discharged is half the width of the loop below the middle: 30 mV.
    const double more_V = with.error->rmse_V - without.error->rmse_V;
    EXPECT_NEAR(more_V, 0.03, 1e-3);
  }
  std::string text;
  for (const auto& line : ProvenanceLines(request, with)) text += line + "\n";
  EXPECT_NE(text.find("Temperature: the cell's numbers change with it; these do not"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("Hysteresis: this v_oc is that half-way"), std::string::npos) << text;
  EXPECT_EQ(text.find("neither the cell file nor"), std::string::npos) << text;
  EXPECT_NE(text.find("begun at a state of charge of 0.9,"), std::string::npos) << text;
  for (const char* const law : {"c", "fmi", "spice"}) {
    if (target.name != law) continue;
    EXPECT_NE(text.find("the cell's own without its temperature and hysteresis"), std::string::npos)
        << text;
  }
  const Json summary = ExportToJson(target, request, with);
  EXPECT_EQ(summary.at("initial_soc"), 0.9);
  EXPECT_EQ(summary.at("cannot_hold").size(), with.cannot_hold.size() + 2);
}

TEST_P(EveryTarget, GivesTheSameBytesAgain) {
  const ExportTarget& target = FindExportTarget(GetParam());
  const auto request = RequestOfHostileSource(LoadCell("grepow-32Ah-2"));
  const auto once = Export(target, request);
  const auto again = Export(target, request);
  ASSERT_EQ(once.files.size(), again.files.size());
  for (std::size_t k = 0; k < once.files.size(); ++k)
    EXPECT_EQ(once.files[k].content, again.files[k].content);
}

TEST_P(EveryTarget, KnowsItsVersionsAndNoOther) {
  const ExportTarget& target = FindExportTarget(GetParam());
  auto request = RequestOfHostileSource(LoadCell("gifi-600mAh-1"));
  for (const auto& version : target.Versions()) {
    request.target_version = version;
    EXPECT_FALSE(Export(target, request).files.empty()) << version;
  }
  request.target_version = "no such version";
  EXPECT_NE(test::MessageOf<OptionError>([&] {
              (void)Export(target, request);
            }).find("option --target-version: "),
            std::string::npos);
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const auto& target : ExportTargets()) names.emplace_back(target.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, EveryTarget, testing::ValuesIn(Names()), [](const auto& row) {
  return row.param;
});

TEST(Targets, AnUnknownNameIsToldTheNearest) {
  EXPECT_EQ(test::MessageOf<OptionError>([] { (void)FindExportTarget("ardupilto"); }).substr(0, 52),
            "unknown target 'ardupilto'. Did you mean 'ardupilot'");
}

TEST(Targets, ANameOfAnyCellIsAnIdentifier) {
  EXPECT_EQ(IdentifierOf("gifi-600mAh-1"), "gifi_600mAh_1");
  EXPECT_EQ(IdentifierOf("3 \"; rm"), "cell_3____rm");
  EXPECT_EQ(IdentifierOf(""), "cell_");
  EXPECT_LE(IdentifierOf(std::string(500, 'x')).size(), 60U);
}

TEST(LawLimits, NamesWhatTheCellHasAndTheLawHasNot) {
  Cell cell = LoadCell("gifi-600mAh-1");  // its branch is next to nothing
  const auto left_out = [&](const LawTerms& law) {
    ExportRequest request;
    SetCell(request, cell);
    return LeftOut(request, law);
  };
  EXPECT_EQ(left_out({}).size(), 2U);
  cell.diffusion.reset();
  EXPECT_EQ(left_out({}).size(), 1U);
  cell.branches.push_back({0.05, 20.0, std::nullopt});
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.2, 0.1});
  cell.charge_transfer = Cell::ChargeTransfer{1.0, 0.01};
  cell.self_heating = Cell::SelfHeating{100.0, 0.001};
  EXPECT_EQ(left_out({}).size(), 5U);
  EXPECT_EQ(left_out({.branches = 1, .resistance_table = true}).size(), 3U);
}

TEST(LawLimits, ABranchBelowAThousandthOrFasterThanAStepIsNegligible) {
  const Cell cell = LoadCell("gifi-600mAh-1");  // 0.1314 Ohm
  EXPECT_TRUE(IsNegligible(cell, {1.3e-4, 10.0, std::nullopt}, 0.01));
  EXPECT_FALSE(IsNegligible(cell, {1.4e-4, 10.0, std::nullopt}, 0.01));
  EXPECT_TRUE(IsNegligible(cell, {0.1, 0.009, std::nullopt}, 0.01));
}

}  // namespace
}  // namespace lipoid
