// The error that an export states is the one that the target's law has, as a second statement of it
// in Python (export_laws.py) finds: for the six shipped cells, a pack, and cells identified from
// lab logs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "identify/export/mission.h"
#include "identify/export/targets.h"
#include "identify/identification.h"
#include "identify/logs/load_campaign.h"
#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/csv_writer.h"
#include "model/export/export_error.h"
#include "tests/support/paths.h"
#include "tests/support/text_files.h"

namespace lipoid {
namespace {

using test::FreshFolder;
using test::SourcePath;

// The stated error is that of the law to this.
constexpr double kRelative = 0.02;
constexpr double kVolts = 5e-5;

struct Case {
  Json json;
  std::string title;
  double rmse_V = 0.0;
  double max_error_V = 0.0;
  double rms_level = 0.0;  // of a state of charge that the target shows; 0: it shows none
};

class ExportReferenceTest : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(LIPOID_PYTHON).empty()) GTEST_SKIP() << "skipped: no python3 with numpy";
    // Tests of one program may run side by side.
    folder_ = FreshFolder(std::string("export_reference/") +
                          testing::UnitTest::GetInstance()->current_test_info()->name());
  }

  // The cell, its mission and what was exported as a case of export_laws.py, or of thevenin_peer.py
  // where the law is none of lipoid's.
  void Add(const Cell& cell, const std::string& target, const std::string& law, int branches = 2) {
    ExportRequest request;
    request.cell = cell;
    request.name = "c";
    request.mission = DefaultMission(cell);
    request.branches = branches;
    const Exported exported = Export(FindExportTarget(target), request);
    ASSERT_TRUE(exported.error.has_value()) << target;
    const std::string stem = fmt::format("{}", cases_.size());
    WriteFileAtomically(folder_ + "/" + stem + ".yaml", exported.files[0].content);
    WriteCellFile(cell, folder_ + "/" + stem + ".json");
    CsvWriter csv(folder_ + "/" + stem + ".csv", "time_s,current_A");
    for (std::size_t k = 0; k < request.mission.time_s.size(); ++k)
      csv.Row(request.mission.time_s[k], request.mission.current_A[k]);
    csv.Commit();
    Json parameters = Json::object();
    for (const auto& parameter : exported.parameters) parameters[parameter.name] = parameter.value;
    cases_.push_back(
        {{{"law", law},
          {"parameters", std::move(parameters)},
          {"file", stem + ".yaml"},
          {"cell", stem + ".json"},
          {"series", cell.series},
          {"parallel", cell.parallel},
          {"mission", stem + ".csv"}},
         fmt::format("{} of {} ({}s{}p)", target, cell.name, cell.series, cell.parallel),
         exported.error->rmse_V,
         exported.error->max_error_V,
         exported.charge_error ? exported.charge_error->rms : 0.0});
  }

  void Judge(const std::string& python = LIPOID_PYTHON,
             const std::string& script = "export_laws.py") {
    Json list = Json::array();
    for (const auto& one : cases_) list.push_back(one.json);
    WriteFileAtomically(folder_ + "/cases", list.dump());
    const std::string command = fmt::format("{} -B {} {}/cases > {}/answers 2> {}/log",
                                            python,
                                            SourcePath("tests/reference/" + script),
                                            folder_,
                                            folder_,
                                            folder_);
    ASSERT_EQ(std::system(command.c_str()), 0) << test::ReadText(folder_ + "/log");
    const Json answers = Json::parse(test::ReadText(folder_ + "/answers"));
    ASSERT_EQ(answers.size(), cases_.size());
    for (std::size_t k = 0; k < cases_.size(); ++k) {
      const double rmse_V = answers[k]["rmse_V"];
      const double max_error_V = answers[k]["max_error_V"];
      EXPECT_NEAR(cases_[k].rmse_V, rmse_V, std::max(kVolts, kRelative * rmse_V))
          << cases_[k].title;
      EXPECT_NEAR(cases_[k].max_error_V, max_error_V, std::max(kVolts, kRelative * max_error_V))
          << cases_[k].title;
      EXPECT_GT(rmse_V, 0.0);
      if (cases_[k].rms_level > 0.0) {
        const double rms_level = answers[k]["rms_level"];
        EXPECT_NEAR(cases_[k].rms_level, rms_level, kRelative * rms_level) << cases_[k].title;
      }
    }
  }

  static std::vector<Cell> Cells() {
    std::vector<Cell> cells;
    for (const auto& name : ShippedCellNames()) cells.push_back(LoadCell(name));
    Cell pack = LoadCell("gifi-600mAh-1");
    pack.series = 3;
    pack.parallel = 2;
    cells.push_back(pack);
    return cells;
  }

  std::string folder_;
  std::vector<Case> cases_;
};

TEST_F(ExportReferenceTest, ArduPilotStatesTheErrorOfItsLaw) {
  for (const auto& cell : Cells()) Add(cell, "ardupilot", "ardupilot");
  Judge();
}

TEST_F(ExportReferenceTest, GazeboStatesTheErrorOfItsLaw) {
  for (const auto& cell : Cells()) Add(cell, "gazebo", "gazebo");
  Judge();
}

TEST_F(ExportReferenceTest, Px4StatesTheErrorsOfItsLawAndOfItsEstimator) {
  for (const auto& cell : Cells()) Add(cell, "px4", "px4");
  Judge();
}

// A cell as the joint method finds them: resistances over the state of charge, charge transfer, a
// slow relaxation, self-heating, a smooth v_oc.
Cell FullCell() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.name = "full";
  cell.series_resistance_Ohm = Resistance<double>({0.05, 0.3, 0.9}, {0.14, 0.09, 0.08});
  cell.branches = {{Resistance<double>({0.1, 0.8}, {0.03, 0.02}), 3.0, std::nullopt},
                   {0.02, 80.0, std::nullopt}};
  cell.charge_transfer = Cell::ChargeTransfer{0.4, Resistance<double>({0.1, 0.5}, {0.06, 0.04})};
  cell.self_heating = Cell::SelfHeating{300.0, 0.002};
  cell.open_circuit_voltage = OpenCircuitVoltage::MonotoneCubic(
      {0.0, 0.05, 0.1, 0.3, 0.5, 0.8, 1.0}, {3.0, 3.4, 3.6, 3.72, 3.8, 4.0, 4.2});
  return cell;
}

TEST_F(ExportReferenceTest, ACellWithEveryTermIsExportedWithItsError) {
  Add(FullCell(), "ardupilot", "ardupilot");
  Add(FullCell(), "gazebo", "gazebo");
  Add(FullCell(), "px4", "px4");
  Judge();
}

// Cells as the joint method finds them in lab logs: tables over the state of charge, charge transfer.
std::vector<Cell> IdentifiedCells() {
  std::vector<Cell> cells;
  for (const auto* const lab : {"dmegc_inr18650_26_r1", "nissan_leaf_33ah"}) {
    const std::string file = test::LabDataPath(std::string(lab) + "/campaign.toml");
    if (file.empty()) continue;
    const Campaign campaign = ReadCampaign(file);
    Cell cell = Identify(campaign, LoadCampaign(campaign), {}).cell;
    cell.uncertainty.reset();  // no part of a law
    cells.push_back(std::move(cell));
  }
  return cells;
}

TEST_F(ExportReferenceTest, IdentifiedCellsAreExportedWithTheirError) {
  const auto cells = IdentifiedCells();
  ASSERT_EQ(cells.size(), 2U) << "their logs stand in fixtures/lab";
  for (const Cell& cell : cells) {
    Add(cell, "ardupilot", "ardupilot");
    Add(cell, "gazebo", "gazebo");
    Add(cell, "px4", "px4");
  }
  Judge();
}

// ns-3 itself, where Debian's libns3-dev is installed: its level, row by row, against the cell.
TEST_F(ExportReferenceTest, Ns3StatesTheErrorOfItsOwnModel) {
  const std::string libraries = "/usr/lib/x86_64-linux-gnu/libns3-";
  if (!std::filesystem::exists("/usr/include/ns3/rv-battery-model.h"))
    GTEST_SKIP() << "skipped: no libns3-dev (tools/setup --extra)";
  const std::string peer = folder_ + "/ns3_peer";
  std::string compile = "c++ -O1 -std=c++17 -o " + peer + " ";
  compile += SourcePath("tests/reference/ns3_peer.cc");
  for (const auto* const library : {"energy", "config-store", "network", "core"})
    compile += " " + libraries + library + ".so";
  ASSERT_EQ(std::system((compile + " 2> " + folder_ + "/log").c_str()), 0)
      << test::ReadText(folder_ + "/log");
  for (const Cell& cell : Cells()) {
    SCOPED_TRACE(cell.name);
    ExportRequest request;
    request.cell = cell;
    request.target_version = "3.37";
    request.mission = DefaultMission(cell);
    const Exported exported = Export(FindExportTarget("ns3"), request);
    WriteFileAtomically(folder_ + "/ns3.txt", exported.files[0].content);
    CsvWriter csv(folder_ + "/ns3.csv", "time_s,current_A");
    for (std::size_t k = 0; k < request.mission.time_s.size(); ++k)
      csv.Row(request.mission.time_s[k], request.mission.current_A[k]);
    csv.Commit();
    const std::string run =
        fmt::format("cd {} && ./ns3_peer ns3.txt ns3.csv > levels 2> log", folder_);
    ASSERT_EQ(std::system(run.c_str()), 0) << test::ReadText(folder_ + "/log");
    const Prediction truth = ReferenceOf(cell, request.mission);
    std::istringstream levels(test::ReadText(folder_ + "/levels"));
    double level = 0.0;
    double squares = 0.0;
    double most = 0.0;
    std::size_t rows = 0;
    while (levels >> level) {
      ASSERT_LT(rows, truth.soc.size());
      const double error = level - truth.soc[rows++];
      squares += error * error;
      most = std::max(most, std::abs(error));
    }
    ASSERT_EQ(rows, truth.soc.size());
    const double rms = std::sqrt(squares / static_cast<double>(rows));
    EXPECT_NEAR(exported.charge_error->rms, rms, kRelative * rms);
    EXPECT_NEAR(exported.charge_error->max_error, most, kRelative * most);
    // What is known to be reachable with its default number of terms.
    EXPECT_LT(exported.charge_error->max_error, 0.007 * 1.03);
  }
}

// The package itself, where tools/setup --extra has installed it.
TEST_F(ExportReferenceTest, TheveninStatesTheErrorOfThePackage) {
  const std::string python = test::ExtraPython();
  const std::string probe = python + " -c 'import thevenin, scipy' 2> /dev/null";
  if (python.empty() || std::system(probe.c_str()) != 0)
    GTEST_SKIP() << "skipped: no thevenin in build/python-extra (tools/setup --extra)";
  for (const auto& cell : Cells()) Add(cell, "thevenin", "", 2);
  Add(LoadCell("gifi-600mAh-1"), "thevenin", "", 1);
  Add(FullCell(), "thevenin", "", 2);
  for (const Cell& cell : IdentifiedCells()) Add(cell, "thevenin", "", 2);
  Judge(python, "thevenin_peer.py");
}

}  // namespace
}  // namespace lipoid
