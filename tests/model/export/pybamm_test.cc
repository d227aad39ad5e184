// The exported module, run by the real PyBaMM, against the cell model.
#include "model/export/pybamm.h"

#include <fmt/format.h>
#include <fmt/os.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/export/cell_numbers.h"
#include "tests/support/export_cases.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

// Voltage of the pack at every row, as the module's own run prints it.
std::vector<double> RunModule(const ExportRequest& request, const Exported& exported) {
  const auto folder = test::FreshFolder("pybamm_" + request.name);
  const auto file = test::WriteExported(exported, folder, "cell");
  {
    auto rows = fmt::output_file(folder + "/mission.csv");
    rows.print("time_s,current_A\n");
    for (std::size_t k = 0; k < request.mission.time_s.size(); ++k)
      rows.print("{},{}\n", request.mission.time_s[k], request.mission.current_A[k]);
  }
  std::string output;
  const int code = test::RunCommand(
      fmt::format("cd {} && PYBAMM_DISABLE_TELEMETRY=true {} -B cell.py mission.csv "
                  "> out.csv && tail -n +2 out.csv | cut -d, -f2 > voltage.txt",
                  folder,
                  test::ExtraPython()),
      output);
  EXPECT_EQ(code, 0) << output;
  return test::ReadNumbers(folder + "/voltage.txt");
}

void ExpectStatedIsMeasured(const ExportRequest& request, double most_V) {
  const auto exported = ExportPybamm(request);
  ASSERT_TRUE(exported.error);
  const auto voltage_V = RunModule(request, exported);
  ASSERT_EQ(voltage_V.size(), request.mission.time_s.size()) << request.name;
  const auto measured = MissionError(request, voltage_V);
  // 2 % or 0.05 mV: PyBaMM's solver at a relative tolerance of 1e-8 is far closer.
  EXPECT_NEAR(
      measured.rmse_V, exported.error->rmse_V, std::max(5e-5, 0.02 * exported.error->rmse_V))
      << request.name;
  EXPECT_NEAR(measured.max_error_V,
              exported.error->max_error_V,
              std::max(5e-5, 0.02 * exported.error->max_error_V))
      << request.name;
  EXPECT_LT(measured.rmse_V, most_V) << request.name;
}

// Rows of 2 s. Constant resistances: only the mesh is off. Tables and self-heating: projected. Without
// the tail the cell lacks modes that the element has.
TEST(Pybamm, StatedErrorIsWhatPybammHas) {
  LIPOID_SKIP_WITHOUT_SIMULATORS();
  for (const Cell& cell : test::ExportCells()) {
    auto request = test::RequestOf(cell);
    request.mission = test::Thinned(request.mission, 20);
    const bool shipped = cell.name.starts_with("gifi") || cell.name.starts_with("grepow");
    ExpectStatedIsMeasured(request,
                           shipped                       ? 5e-4
                           : cell.name == "no-diffusion" ? 1e-6
                           : cell.name == "no-tail"      ? 5e-2
                                                         : 1e-2 * cell.series);
  }
}

TEST(Pybamm, BranchMayVanishAtSomeStatesOfCharge) {
  LIPOID_SKIP_WITHOUT_SIMULATORS();
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>({0.3, 0.6, 0.8}, {0.03, 0.0, 0.02}), 20.0, {}},
                   {Resistance<double>(0.0), 5.0, {}}};
  auto request = test::RequestOf(cell);
  request.name = "vanishing";
  request.mission = test::Thinned(request.mission, 50);
  ExpectStatedIsMeasured(request, 5e-3);
}

TEST(Pybamm, RealSortieIsWithinATenthOfAMillivoltButForTheJumps) {
  LIPOID_SKIP_WITHOUT_SIMULATORS();
  const auto sortie = test::LabDataPath("missions/sortie.csv");
  LIPOID_SKIP_WITHOUT(sortie);
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.name = "sortie";
  request.mission = test::ReadMission(sortie);
  const auto exported = ExportPybamm(request);
  ASSERT_TRUE(exported.error);
  RecordProperty("rms_mV", std::to_string(1e3 * exported.error->rmse_V));
  RecordProperty("max_mV", std::to_string(1e3 * exported.error->max_error_V));
  ExpectStatedIsMeasured(request, 1e-4);
}

// The law of the mesh against the series that it stands for: the surface of the element is A, and
// the difference falls with the square of the points.
TEST(Pybamm, MeshComesToTheCellWithTheSquareOfItsPoints) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches.clear();
  cell.diffusion->terms = 1000;  // nearly all
  ExportMission mission;
  for (int k = 0; k <= 300; ++k) {
    mission.time_s.push_back(k);
    mission.current_A.push_back(k > 0 ? 1.6 : 0.0);
  }
  const auto model = Predict(cell, mission.time_s, mission.current_A).voltage_V;
  const auto worst = [&](int points) {
    const auto mesh = RunPybammLaw(cell, mission, points);
    double off_V = 0.0;
    for (std::size_t k = 5; k < mesh.size(); ++k)
      off_V = std::max(off_V, std::abs(mesh[k] - model[k]));
    return off_V;
  };
  EXPECT_NEAR(worst(100) / worst(200), 4.0, 0.4);
  EXPECT_NEAR(worst(50) / worst(100), 4.0, 0.4);
  EXPECT_LT(worst(100), 2e-4);
}

TEST(Pybamm, SaysWhatItCannotHold) {
  const auto plain = ExportPybamm(test::RequestOf(LoadCell("gifi-600mAh-1")));
  EXPECT_TRUE(plain.cannot_hold.empty());
  const auto every = ExportPybamm(test::RequestOf(test::CellWithEveryTerm()));
  ASSERT_EQ(every.cannot_hold.size(), 3U);
  EXPECT_NE(every.cannot_hold[0].find("Self-heating"), std::string::npos);
  EXPECT_NE(every.cannot_hold[1].find("mean state of charge"), std::string::npos);
  EXPECT_NE(every.cannot_hold[2].find("modes"), std::string::npos);
  for (const auto& [name, value] : {std::pair{"Cell capacity [A.h]", 1353.6 / 3600.0},
                                    std::pair{"Diffusion time constant [s]", 266.618}}) {
    double found = NAN;
    for (const auto& parameter : plain.parameters) {
      if (parameter.name == name) found = parameter.value;
    }
    EXPECT_NEAR(found, value, 5e-4) << name;
  }
}

TEST(Pybamm, NamesOfOthersStayInComments) {
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  request.source = "a\nraise SystemExit(9)\n\"\"\"";
  request.name = "x\"\"\"\nraise SystemExit(9)";
  const auto text = ExportPybamm(request).files[0].content;
  EXPECT_EQ(text.find("\nraise"), std::string::npos);
  const auto folder = test::FreshFolder("pybamm_hostile");
  std::ofstream(folder + "/cell.py") << text;
  std::string output;
  EXPECT_EQ(test::RunCommand("python3 -c 'import ast; t = ast.parse(open(\"" + folder +
                                 "/cell.py\").read()); "
                                 "assert not any(isinstance(n, ast.Raise) for n in ast.walk(t))'",
                             output),
            0)
      << output;
}

// Before, what it says of its use imported the name of the cell.
TEST(Pybamm, SaysTheNameOfItsOwnFile) {
  auto request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  const auto says = [&](const std::string& stem, const std::string& what) {
    request.stem = stem;
    return ExportPybamm(request).files[0].content.find(what) != std::string::npos;
  };
  EXPECT_TRUE(says("", "    import pybamm, gifi_600mAh_1\n    model = gifi_600mAh_1.make_model()"));
  EXPECT_TRUE(says("pack", "    python3 pack.py MISSION.csv"));
  EXPECT_TRUE(says("pack", "    import pybamm, pack\n    model = pack.make_model()"));
  EXPECT_TRUE(says("my-cell",
                   "    import importlib, pybamm\n"
                   "    gifi_600mAh_1 = importlib.import_module(\"my-cell\")\n"
                   "    model = gifi_600mAh_1.make_model()"));
  EXPECT_TRUE(says("a\"\"\"b", "    import pybamm, gifi_600mAh_1\n"));
}

TEST(Pybamm, DoesNotHideThePackage) {
  ExportRequest request = test::RequestOf(LoadCell("gifi-600mAh-1"));
  for (const char* stem : {"pybamm", "numpy"}) {
    request.stem = stem;
    EXPECT_EQ(
        test::MessageOf<OptionError>([&] { (void)ExportPybamm(request); }),
        fmt::format(
            "option -o: {0}.py would hide the package {0} from every program of its folder; give "
            "another name",
            stem));
  }
}

TEST(Pybamm, RefusesAVersion) {
  EXPECT_THROW((void)ExportPybamm(test::RequestOf(LoadCell("gifi-600mAh-1"), "1")), OptionError);
}

}  // namespace
}  // namespace lipoid
