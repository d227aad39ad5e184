// The files of the projected targets: what stands in them, and that their numbers have the stated
// error.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "identify/export/frame_json.h"
#include "identify/export/mission.h"
#include "identify/export/targets.h"
#include "model/battery/cell_file.h"
#include "model/export/ardupilot_law.h"
#include "model/export/equivalent_circuit_law.h"
#include "model/export/export_error.h"
#include "model/export/gazebo_law.h"

namespace lipoid {
namespace {

Cell Pack() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series = 3;
  cell.parallel = 2;
  return cell;
}

ExportRequest RequestOfMyCell(const Cell& cell) {
  ExportRequest request;
  request.cell = cell;
  request.source = "c.json";
  request.sha256 = "abcd";
  request.name = "my_cell";
  request.mission = DefaultMission(cell);
  return request;
}

// "NAME separator VALUE" lines as numbers by name; comments and other lines are skipped.
std::map<std::string, double> NumbersOf(const std::string& text, char separator) {
  std::map<std::string, double> numbers;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto at = line.find(separator);
    if (line.empty() || line[0] == '#' || at == std::string::npos) continue;
    numbers[line.substr(0, at)] = std::atof(line.c_str() + at + 1);
  }
  return numbers;
}

TEST(ArduPilotFiles, HoldTheSameNumbersAndTheseHaveTheStatedError) {
  auto request = RequestOfMyCell(Pack());
  request.target_version = "2026-06";
  const auto exported = Export(FindExportTarget("ardupilot"), request);
  const Json frame = ParseJson(FrameWithoutComments(exported.files[0].content, "f"), "f");
  const auto parm = NumbersOf(exported.files[1].content, ' ');
  EXPECT_EQ(parm.at("SIM_BATT_VOLTAGE"), frame["maxVoltage"].get<double>());
  EXPECT_EQ(parm.at("SIM_BATT_CAP_AH"), frame["battCapacityAh"].get<double>());
  EXPECT_EQ(parm.at("SIM_BATT_RES_OHM"), frame["refBatRes"].get<double>());
  EXPECT_EQ(parm.at("BATT_CAPACITY"),
            std::round(1000.0 * request.cell.parallel * UsableCapacity_Ah(request.cell)));
  const auto drawn_Ah = ChargeDrawn_Ah(request.cell, request.mission);
  const auto error = VoltageError(
      ReferenceOf(request.cell, request.mission),
      request.mission,
      ArduPilotVoltage({frame["maxVoltage"], frame["battCapacityAh"], frame["refBatRes"]},
                       request.mission,
                       drawn_Ah));
  EXPECT_EQ(error.rmse_V, exported.error->rmse_V);
  EXPECT_EQ(exported.files[1].suffix, ".parm");
  request.target_version = "any";
  EXPECT_EQ(Export(FindExportTarget("ardupilot"), request).files[1].content.find("\nSIM_BATT_RES"),
            std::string::npos);
}

// A short flight fits a pack of twice the capacity as well: it is not asked.
TEST(ArduPilotFiles, AMissionOverAPartOfTheChargeTellsNoCapacity) {
  auto request = RequestOfMyCell(Pack());
  for (double& current_A : request.mission.current_A) current_A *= 0.3;
  const auto exported = Export(FindExportTarget("ardupilot"), request);
  EXPECT_EQ(exported.parameters[1].name, "battCapacityAh");
  constexpr double kFloat = 1e-6;
  EXPECT_NEAR(exported.parameters[1].value,
              request.cell.parallel * UsableCapacity_Ah(request.cell),
              kFloat);
  EXPECT_TRUE(std::any_of(exported.notes.begin(), exported.notes.end(), [](const auto& note) {
    return note.find("% of the charge does not tell it") != std::string::npos;
  }));
}

TEST(Px4File, HasTheFiveColumnsOfQGroundControl) {
  const auto exported = Export(FindExportTarget("px4"), RequestOfMyCell(Pack()));
  std::istringstream lines(exported.files[0].content);
  std::map<std::string, std::pair<double, int>> found;
  for (std::string line; std::getline(lines, line);) {
    if (line[0] == '#') continue;
    std::istringstream fields(line);
    int vehicle = 0;
    int component = 0;
    std::string name;
    double value = 0.0;
    int type = 0;
    ASSERT_TRUE(fields >> vehicle >> component >> name >> value >> type) << line;
    EXPECT_EQ(std::count(line.begin(), line.end(), '\t'), 4) << line;
    EXPECT_EQ(vehicle, 1);
    found[name] = {value, type};
  }
  ASSERT_EQ(found.size(), 5U);
  EXPECT_EQ(found["BAT1_N_CELLS"], (std::pair{3.0, 6}));
  EXPECT_NEAR(found["BAT1_CAPACITY"].first, 2.0 * 376.0, 0.01);
  EXPECT_NEAR(found["BAT1_V_CHARGED"].first, 4.15, 0.05) << "of one cell";
  EXPECT_EQ(found["BAT1_R_INTERNAL"].second, 9);
  EXPECT_NEAR(found["BAT1_R_INTERNAL"].first, 0.17 / 2.0, 0.02) << "the pack's current";
}

TEST(GazeboFile, HasTheNamesOfItsVersion) {
  auto request = RequestOfMyCell(Pack());
  const auto& gazebo = FindExportTarget("gazebo");
  EXPECT_NE(Export(gazebo, request)
                .files[0]
                .content.find("<plugin filename=\"gz-sim-linearbatteryplugin-system\"\n"
                              "        name=\"gz::sim::systems::LinearBatteryPlugin\">"),
            std::string::npos);
  request.target_version = "fortress";
  const std::string old = Export(gazebo, request).files[0].content;
  EXPECT_NE(old.find("<plugin filename=\"ignition-gazebo-linearbatteryplugin-system\"\n"
                     "        name=\"ignition::gazebo::systems::LinearBatteryPlugin\">"),
            std::string::npos);
  for (const auto* const element : {"<battery_name>my_cell</battery_name>",
                                    "<fix_issue_225>true</fix_issue_225>",
                                    "<capacity>0.752</capacity>",
                                    "<initial_charge>0.752</initial_charge>",
                                    "<power_load>"})
    EXPECT_NE(old.find(element), std::string::npos) << element;
  // The battery starts with the voltage that its law has when full.
  const auto number = [&](const std::string& tag) {
    return std::atof(old.c_str() + old.find("<" + tag + ">") + tag.size() + 2);
  };
  EXPECT_EQ(number("voltage"), number("open_circuit_voltage_constant_coef"));
}

TEST(GazeboFile, ACommentCannotEndEarly) {
  auto request = RequestOfMyCell(Pack());
  request.source = "a-->b<evil/>--";
  const std::string sdf = Export(FindExportTarget("gazebo"), request).files[0].content;
  const auto end = sdf.find("-->");
  EXPECT_EQ(sdf.find("--", sdf.find("<!--") + 4), end) << "one comment, one end";
  EXPECT_EQ(sdf.find("-->", end + 1), std::string::npos);
}

TEST(FilteredTargets, SayWhereAMissionStartsUnderLoad) {
  auto request = RequestOfMyCell(Pack());
  const auto says = [&](const char* target) {
    const std::string file = Export(FindExportTarget(target), request).files[0].content;
    return file.find("The mission starts under a load of 1 A") != std::string::npos;
  };
  EXPECT_FALSE(says("ardupilot"));
  request.mission.current_A[0] = 1.0;
  EXPECT_TRUE(says("ardupilot"));
  EXPECT_TRUE(says("gazebo"));
}

TEST(Ns3File, NamesTheClassOfItsVersionInItsUnits) {
  auto request = RequestOfMyCell(Pack());
  const auto& ns3 = FindExportTarget("ns3");
  const std::string now = Export(ns3, request).files[0].content;
  // 2 x 1353.6 C are 45120 mA min.
  EXPECT_NE(now.find("\ndefault ns3::energy::RvBatteryModel::RvBatteryModelAlphaValue \"45120\"\n"),
            std::string::npos)
      << now;
  request.target_version = "3.37";
  const auto exported = Export(ns3, request);
  EXPECT_NE(
      exported.files[0].content.find("\ndefault ns3::RvBatteryModel::RvBatteryModelAlphaValue"),
      std::string::npos);
  EXPECT_FALSE(exported.error.has_value()) << "its voltage is a constant";
  // beta in 1/sqrt(min), a little below the cell's 1.49 for the tail that the model does not have.
  EXPECT_LT(exported.parameters[1].value, 0.1924 * std::sqrt(60.0));
  EXPECT_GT(exported.parameters[1].value, 0.95 * 0.1924 * std::sqrt(60.0));
}

// alpha and beta of the cell file lack the terms beyond the tenth alone: under a current that lasts these are a level of
// 2 i / (alpha beta²) times the sum of 1/m².
TEST(Ns3File, NumbersReadOffTheCellFileAreItsAlphaAndBeta) {
  const auto request = RequestOfMyCell(Pack());
  const auto exported = Export(FindExportTarget("ns3"), request);
  const Cell& cell = request.cell;
  const double most_A =
      *std::max_element(request.mission.current_A.begin(), request.mission.current_A.end()) /
      cell.parallel;
  double tail = std::numbers::pi * std::numbers::pi / 6.0;
  for (int m = 1; m <= 10; ++m) tail -= 1.0 / (m * m);
  const double beta = cell.diffusion->beta_per_sqrt_s;
  constexpr double kOfTheRise = 1e-3;  // the eleventh term after the longest time at one current
  ASSERT_TRUE(exported.naive_charge_error.has_value());
  EXPECT_NEAR(exported.naive_charge_error->max_error,
              2.0 * most_A / (cell.alpha_C() * beta * beta) * tail,
              kOfTheRise * exported.naive_charge_error->max_error);
  EXPECT_LT(exported.charge_error->rms, exported.naive_charge_error->rms);
  auto counts = request;
  counts.cell.diffusion.reset();
  EXPECT_FALSE(Export(FindExportTarget("ns3"), counts).naive_charge_error.has_value());
}

TEST(TheveninFile, HasEveryKeyAndNothingButNumbersInItsFunctions) {
  auto request = RequestOfMyCell(LoadCell("gifi-600mAh-1"));
  request.source = "x\n!eval os.system('a')";
  for (const int branches : {1, 2}) {
    request.branches = branches;
    const std::string yaml = Export(FindExportTarget("thevenin"), request).files[0].content;
    std::vector<std::string> keys = {"num_RC_pairs",
                                     "soc0",
                                     "capacity",
                                     "ce",
                                     "gamma",
                                     "mass",
                                     "Cp",
                                     "T_inf",
                                     "h_therm",
                                     "A_therm",
                                     "isothermal",
                                     "ocv",
                                     "M_hyst",
                                     "R0"};
    for (int j = 1; j <= branches; ++j) {
      keys.push_back("R" + std::to_string(j));
      keys.push_back("C" + std::to_string(j));
    }
    std::size_t found = 0;
    std::istringstream lines(yaml);
    for (std::string line; std::getline(lines, line);) {
      if (line[0] == '#' || line[0] == ' ') continue;
      ++found;
      EXPECT_NE(std::find(keys.begin(), keys.end(), line.substr(0, line.find(':'))), keys.end())
          << line;
    }
    EXPECT_EQ(found, keys.size()) << yaml;
    EXPECT_EQ(yaml.find("\n!eval"), std::string::npos);
  }
}

TEST(SimscapeFile, ItsVectorsHaveTheStatedError) {
  auto request = RequestOfMyCell(Pack());
  request.branches = 2;
  const auto exported = Export(FindExportTarget("simscape"), request);
  const std::string& script = exported.files[0].content;
  const auto vector = [&](const std::string& field) {
    const std::string begin = "\nmy_cell." + field + " = [";
    const auto at = script.find(begin);
    EXPECT_NE(at, std::string::npos) << field;
    std::vector<double> values;
    std::istringstream list(script.substr(at + begin.size()));
    for (double value = 0.0; list >> value; list.ignore(1)) {
      values.push_back(value);
      if (list.peek() != ',') break;
    }
    return values;
  };
  EquivalentCircuit circuit;
  const std::string capacity = "\nmy_cell.AH = ";
  circuit.capacity_Ah = std::atof(script.c_str() + script.find(capacity) + capacity.size());
  circuit.soc = vector("SOC_vec");
  circuit.open_circuit = {circuit.soc, vector("V0_vec")};
  circuit.series_Ohm = vector("R0_vec");
  circuit.branches = {{vector("R1_vec"), vector("tau1_vec").front()},
                      {vector("R2_vec"), vector("tau2_vec").front()}};
  Cell one = request.cell;
  one.series = 1;
  one.parallel = 1;
  ExportMission share = request.mission;
  for (double& current_A : share.current_A) current_A /= 2.0;
  const auto error =
      VoltageError(ReferenceOf(one, share),
                   share,
                   EquivalentCircuitVoltage(circuit, share, ChargeDrawn_Ah(one, share)));
  // Three cells in series; the mission stays within the vector of the state of charge.
  EXPECT_NEAR(3.0 * error.rmse_V, exported.error->rmse_V, 1e-9);
  EXPECT_NE(script.find("\nmy_cell.Ns = 3;"), std::string::npos);
}

}  // namespace
}  // namespace lipoid
