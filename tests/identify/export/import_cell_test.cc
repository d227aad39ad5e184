// Batteries of other programs as cells.
#include "identify/export/import_cell.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "identify/export/mission.h"
#include "identify/export/targets.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/export/ardupilot_law.h"
#include "model/export/cell_tables.h"
#include "model/export/curve_nodes.h"
#include "model/export/export_error.h"
#include "model/export/gazebo_law.h"
#include "tests/support/load_error.h"

namespace lipoid {
namespace {

ExportRequest RequestOfFileC(const Cell& cell) {
  ExportRequest request;
  request.cell = cell;
  request.source = "c.json";
  request.name = "c";
  request.mission = DefaultMission(cell);
  return request;
}

std::vector<double> VoltsOf(const Cell& cell, const ExportMission& mission) {
  return ReferenceOf(cell, mission).voltage_V;
}

double LargestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = a.size() == b.size() ? 0.0 : HUGE_VAL;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
    most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(ImportCell, TablesComeBackWithTheSameVoltages) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series = 3;
  cell.parallel = 2;
  cell.series_resistance_Ohm = Resistance<double>({0.15, 0.55, 1.05}, {0.2, 0.12, 0.1});
  cell.branches.push_back({Resistance<double>({-0.1, 0.8}, {0.03, 0.02}), 30.0, std::nullopt});
  cell.self_heating = Cell::SelfHeating{300.0, 0.002};
  cell.charge_transfer = Cell::ChargeTransfer{0.4, Resistance<double>({0.1, 0.5}, {0.06, 0.04})};
  const auto request = RequestOfFileC(cell);
  const Exported exported = Export(FindExportTarget("tables"), request);
  const ImportedCell back = ImportCell(exported.files[0].content, "t.csv");
  EXPECT_EQ(back.format, "tables");
  EXPECT_EQ(back.cell.name, cell.name);
  // Straight lines through the nodes of all tables: only rounding is left.
  constexpr double kRounding_V = 1e-12;
  EXPECT_LT(LargestDifference(VoltsOf(cell, request.mission), VoltsOf(back.cell, request.mission)),
            kRounding_V);
}

TEST(ImportCell, TablesOfASmoothCurveComeBackWithinTheirTolerance) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.open_circuit_voltage = OpenCircuitVoltage::MonotoneCubic(
      {0.0, 0.05, 0.1, 0.3, 0.5, 0.8, 1.0}, {3.0, 3.4, 3.6, 3.72, 3.8, 4.0, 4.2});
  const auto request = RequestOfFileC(cell);
  const Exported exported = Export(FindExportTarget("tables"), request);
  const ImportedCell back = ImportCell(exported.files[0].content, "t.csv");
  const double difference_V =
      LargestDifference(VoltsOf(cell, request.mission), VoltsOf(back.cell, request.mission));
  EXPECT_LT(difference_V, 2.0 * kCurveTolerance_V);
  EXPECT_NEAR(exported.error->max_error_V, difference_V, 1e-12);
}

TEST(ImportCell, AFrameOfArduPilotIsACellWithItsLaw) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series = 3;
  const auto request = RequestOfFileC(cell);
  const Exported exported = Export(FindExportTarget("ardupilot"), request);
  const ImportedCell back = ImportCell(exported.files[0].content, "frame.json");
  EXPECT_EQ(back.format, "ardupilot");
  EXPECT_EQ(back.cell.series, 3) << "from 12.5 V";
  const ArduPilotBattery battery{
      exported.parameters[0].value, exported.parameters[1].value, exported.parameters[2].value};
  const auto drawn_Ah = ChargeDrawn_Ah(cell, request.mission);
  // The low-pass of the resting voltage is left out: 16 ms times its slope, and half a row of it.
  constexpr double kLag_V = 1e-3;
  EXPECT_LT(LargestDifference(VoltsOf(back.cell, request.mission),
                              ArduPilotVoltageSmooth(battery, request.mission, drawn_Ah)),
            kLag_V);
}

TEST(ImportCell, AnSdfOfGazeboIsACellWithItsLaw) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series = 2;
  cell.parallel = 2;
  const auto request = RequestOfFileC(cell);
  const GazeboBattery battery{8.3, -1.4, 0.8, 0.3, 6.0};
  const std::string sdf =
      "<?xml version='1.0'?>\n<sdf version='1.9'><model name='m'><!-- <plugin> -->\n"
      "<plugin filename='gz-sim-linearbatteryplugin-system' "
      "name='gz::sim::systems::LinearBatteryPlugin'>\n"
      "<battery_name>b</battery_name><voltage>8.3</voltage>\n"
      "<open_circuit_voltage_constant_coef>8.3</open_circuit_voltage_constant_coef>\n"
      "<open_circuit_voltage_linear_coef>-1.4</open_circuit_voltage_linear_coef>\n"
      "<capacity> 0.8 </capacity><resistance>0.3</resistance>\n"
      "<smooth_current_tau>6</smooth_current_tau></plugin></model></sdf>\n";
  ImportOptions options;
  options.series = 2;
  options.parallel = 2;
  const ImportedCell back = ImportCell(sdf, "m.sdf", options);
  EXPECT_EQ(back.format, "gazebo");
  EXPECT_EQ(back.notes.back(), "Not used, since a cell file has no place for it: voltage.");
  EXPECT_EQ(back.cell.name, "b");
  // Steps of 1 ms against exact ones: half a step over tau of the drop.
  constexpr double kStep_V = 3.3 * 0.3 * 1e-3 / 6.0;
  const auto drawn_Ah = ChargeDrawn_Ah(cell, request.mission);
  EXPECT_LT(LargestDifference(VoltsOf(back.cell, request.mission),
                              GazeboVoltage(battery, request.mission, drawn_Ah)),
            kStep_V);
  options.series = 3;
  EXPECT_NO_THROW((void)ImportCell(sdf, "m.sdf", options));
  options.series = 20;
  EXPECT_EQ(
      test::LoadErrorOf([&] { (void)ImportCell(sdf, "m.sdf", options); }),
      "m.sdf:1:1: error: expected 20 cells in series that have 1 to 5 V each when full, found 0.415 V; "
      "is --series right?");
  options.series = 2;
  // Without the numbers of its cells a pack is one cell of its voltage, as ever.
  const ImportedCell of_pack = ImportCell(sdf, "m.sdf", {});
  EXPECT_NEAR(of_pack.cell.open_circuit_voltage(1.0), 8.3, 1e-12);
  EXPECT_EQ(
      of_pack.notes.front(),
      "warning: 8.3 V when full is high for a lithium-polymer cell: 8.3 V looks like 2 in series "
      "(--series 2).");
  // What lipoid exports comes back too.
  const Exported exported = Export(FindExportTarget("gazebo"), request);
  EXPECT_EQ(ImportCell(exported.files[0].content, "m.sdf", options).cell.capacity_Ah,
            exported.parameters[2].value / 2.0);
}

TEST(ImportCell, CircuitsOfBothDialectsAreTheSameCell) {
  const std::string thevenin = R"({"num_RC_pairs": 1, "soc0": 1.0, "capacity": 0.376,
    "ocv": {"soc": [0, 0.5, 1], "voltage_V": [3.0, 3.8, 4.2]},
    "R0": {"soc": [0, 1], "resistance_Ohm": [0.15, 0.13]}, "R1": 0.02, "C1": 1000})";
  const std::string pybamm = R"({"Cell capacity [A.h]": 0.376, "Initial SoC": 1,
    "Open-circuit voltage [V]": {"soc": [0, 0.5, 1], "voltage_V": [3.0, 3.8, 4.2]},
    "R0 [Ohm]": {"soc": [0, 1], "resistance_Ohm": [0.15, 0.13]},
    "R1 [Ohm]": 0.02, "C1 [F]": 1000, "Lower voltage cut-off [V]": 3.0})";
  const ImportedCell a = ImportCell(thevenin, "a.json");
  const ImportedCell b = ImportCell(pybamm, "b.json");
  EXPECT_EQ(a.format, "circuit");
  EXPECT_EQ(a.cell.cutoff_V, 3.0) << "v_oc(0)";
  const auto mission = DefaultMission(a.cell);
  EXPECT_EQ(VoltsOf(a.cell, mission), VoltsOf(b.cell, mission));
  // By hand: after a long time at 0.1 A from full, all drops and the charge.
  const std::vector<double> time_s{0.0, 600.0};
  const double soc = 1.0 - 60.0 / (3600.0 * 0.376);
  const double expected_V = 4.2 - (1.0 - soc) * 0.8 - 0.1 * (0.15 - 0.02 * soc) - 0.1 * 0.02;
  EXPECT_NEAR(
      Predict(a.cell, time_s, std::vector<double>{0.0, 0.1}).voltage_V[1], expected_V, 1e-9);
}

TEST(ImportCell, DoubtsCellsThatAreFullAtAnotherVoltage) {
  const auto first_note = [](const std::string& text, const ImportOptions& options) {
    const auto notes = ImportCell(text, "f", options).notes;
    return notes.empty() ? "" : notes.front();
  };
  const std::string frame = R"({"maxVoltage":12.588,"battCapacityAh":0.6,"refBatRes":0.4})";
  EXPECT_EQ(first_note(frame, {.series = 4}),
            "warning: 3.147 V when full is low for a lithium-polymer cell: 12.59 V looks like 3 in "
            "series (--series 3).");
  EXPECT_FALSE(first_note(frame, {.series = 3}).starts_with("warning"));
  const auto circuit = [](const std::string& full_V) {
    return R"({"capacity": 0.6, "ocv": {"soc": [0, 1], "voltage_V": [2, )" + full_V +
           R"(]}, "R0": 0.1, "cutoff_V": 2})";
  };
  EXPECT_EQ(
      first_note(circuit("12.6"), {}),
      "warning: 12.6 V when full is high for a lithium-polymer cell: the file looks like one of "
      "3 in series; give voltages and resistances of one cell.");
  EXPECT_EQ(first_note(circuit("2.7"), {}),
            "warning: 2.7 V when full is low for a lithium-polymer cell.");
  EXPECT_EQ(first_note(circuit("3.5"), {.series = 4}), "");
}

TEST(ImportCell, RefusesNumbersThatTheFileHas) {
  const std::string circuit =
      R"({"capacity": 0.6, "ocv": {"soc": [0, 1], "voltage_V": [3, 4.2]}, "R0": 0.1, "cutoff_V": 3})";
  const auto refusal = [&](const ImportOptions& options) -> std::string {
    try {
      (void)ImportCell(circuit, "f", options);
    } catch (const OptionError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(
      refusal({.capacity_Ah = 99.0}),
      "option --capacity-Ah: it is for a file without such a number, and f has 0.6; leave the "
      "option out");
  EXPECT_EQ(
      refusal({.cutoff_V = 50.0}),
      "option --cutoff-V: it is for a file without such a number, and f has 3; leave the option "
      "out");
  EXPECT_EQ(refusal({.capacity_Ah = 0.6, .cutoff_V = 3.0}), "");
}

TEST(ImportCell, TheDiffusionElementOfPybammIsTheCellsDiffusion) {
  const std::string pybamm =
      R"({"Cell capacity [A.h]": 0.376, "Diffusion time constant [s]": 266.618,
    "Open-circuit voltage [V]": {"soc": [0, 1], "voltage_V": [3.0, 4.2]}, "R0 [Ohm]": 0.13})";
  const Cell cell = ImportCell(pybamm, "b.json").cell;
  ASSERT_TRUE(cell.diffusion.has_value());
  EXPECT_NEAR(cell.diffusion->beta_per_sqrt_s, 0.1924, 1e-5);
  EXPECT_NEAR(cell.diffusion->alpha_C, 1353.6, 1e-9);
}

std::string MessageOf(const std::string& text) {
  return test::LoadErrorOf([&] { (void)ImportCell(text, "f"); });
}

TEST(ImportCell, RefusesWhatIsNoBatteryWithLineAndColumn) {
  EXPECT_EQ(MessageOf("  \n"),
            "f:1:1: error: expected a battery of another program, found nothing");
  EXPECT_EQ(
      MessageOf("{\n \"maxVoltage\": 12.6, \"battCapacityAh\": 0, \"refBatRes\": 0.1}"),
      "f:2:40: error: /battCapacityAh: expected a capacity above 0 (ArduPilot takes others as "
      "a battery without an end), found 0");
  EXPECT_NE(MessageOf("{\"maxVoltage\": 12.6}").find("battCapacityAh"), std::string::npos);
  EXPECT_NE(
      MessageOf("{\"maxVoltage\": NaN, \"battCapacityAh\": 1, \"refBatRes\": 0.1}").find("f:1:"),
      std::string::npos);
  const std::string circuit =
      "{\"capacity\": 1, \"ocv\": {\"soc\": [0, 1], \"voltage_V\": [3, 4]},\n";
  EXPECT_NE(MessageOf(circuit + "\"R0\": 0.1, \"R_0\": 1}").find("unknown key 'R_0'"),
            std::string::npos);
  EXPECT_NE(MessageOf(circuit + "\"R0\": 0.1, \"R1\": 0.1, \"C1\": 9, \"num_RC_pairs\": 2}")
                .find("expected the number of the branches that stand here, 1, found 2"),
            std::string::npos);
  EXPECT_NE(MessageOf(circuit + "\"R0\": -0.1}").find("f:2:7: error: /R0: expected"),
            std::string::npos)
      << MessageOf(circuit + "\"R0\": -0.1}");
  EXPECT_NE(
      MessageOf(circuit + "\"R0\": 0.1, \"R2\": 1, \"C2\": 3}")
          .find("expected branches that are numbered on from 1, each with a resistance, found 2"),
      std::string::npos);
  EXPECT_NE(MessageOf(circuit + "\"R0\": 0.1, \"R1\": 1}")
                .find("expected either C1 or tau1 beside it, found neither"),
            std::string::npos);
  EXPECT_NE(
      MessageOf(circuit + "\"R0\": 0.1, \"gamma\": 2}")
          .find("expected 0, since this law of hysteresis is another than a cell file's, found 2"),
      std::string::npos);
  EXPECT_NE(MessageOf("{\"capacity\": 0, \"ocv\": {}, \"R0\": 1}").find("/capacity: expected"),
            std::string::npos);
  EXPECT_NE(MessageOf("{\"schema\": \"lipoid.cell/1\"}").find("a cell file of lipoid already"),
            std::string::npos);
  EXPECT_EQ(
      MessageOf("{\"capacity\": 1, \"ocv\": {\"soc\": [0, 1], \"voltage_V\": [4, 3]}, \"R0\": 1}"),
      "f:1:1: error: expected a battery, found one whose v_oc(1) of 3 V is not above its "
      "cut-off of 4 V (--cutoff-V)");
}

TEST(ImportCell, SaysThatOtherProgramsGotItFromLipoid) {
  const ExportRequest request = RequestOfFileC(LoadCell("gifi-600mAh-1"));
  for (const char* target : {"c", "px4", "pybamm", "spice"}) {
    const Exported exported = Export(FindExportTarget(target), request);
    EXPECT_EQ(
        MessageOf(exported.files.front().content),
        "f:1:1: error: this is a cell that lipoid exported to a program whose files it does not "
        "read; use the cell file that its first lines name, which holds more")
        << target;
  }
}

TEST(ImportCell, RefusesSdfsThatHoldNoOneBattery) {
  const auto plugin = [](const std::string& inside) {
    return "<plugin name='gz::sim::systems::LinearBatteryPlugin'>\n" + inside + "</plugin>";
  };
  const std::string good =
      "<open_circuit_voltage_constant_coef>12</open_circuit_voltage_constant_coef>\n"
      "<open_circuit_voltage_linear_coef>-2</open_circuit_voltage_linear_coef>\n"
      "<resistance>1</resistance>\n";
  EXPECT_EQ(MessageOf("<sdf><plugin name='x'/></sdf>"),
            "f:1:1: error: expected one plugin with LinearBatteryPlugin, found 0");
  EXPECT_EQ(MessageOf("<a>" + plugin(good) + plugin(good) + "</a>"),
            "f:1:1: error: expected one plugin with LinearBatteryPlugin, found 2");
  EXPECT_EQ(MessageOf(plugin(good + "<capacity>0</capacity>")),
            "f:5:1: error: expected a number above 0 for capacity, found '0'");
  EXPECT_EQ(MessageOf(plugin(good + " <capacity>nan</capacity>")),
            "f:5:2: error: expected a number above 0 for capacity, found 'nan'");
  EXPECT_EQ(MessageOf(plugin(good)), "f:1:1: error: expected an element capacity, found none");
  EXPECT_NE(MessageOf(plugin(good + "<capacty>1</capacty>")).find("Did you mean 'capacity'"),
            std::string::npos);
  EXPECT_NE(MessageOf("<sdf><plugin>").find("error: expected XML, found none"), std::string::npos);
  std::string deep;
  for (int k = 0; k < 5000; ++k) deep += "<a>";
  EXPECT_NE(MessageOf(deep).find("elements in one another, found more"), std::string::npos);
}

// Thousands where there are ones: no battery has more drop than voltage at a current that empties it in an hour.
TEST(ImportCell, RefusesCapacitiesAndResistancesInThousandths) {
  const auto circuit = [](const std::string& capacity, const std::string& resistance) {
    return R"({"capacity": )" + capacity +
           R"(, "ocv": {"soc": [0, 1], "voltage_V": [3.0, 4.2]}, "R0": )" + resistance + "}";
  };
  EXPECT_EQ(
      MessageOf(circuit("376", "0.13")),
      "f:1:1: error: expected a capacity in Ah and resistances in Ohm, found 376 Ah and 0.13 Ohm: at 1C "
      "they would take 48.88 V of 4.2 V; is the capacity in mAh, or a resistance in mOhm?");
  EXPECT_NE(MessageOf(circuit("0.376", "130")).find("found 0.376 Ah and 130 Ohm"),
            std::string::npos);
  EXPECT_EQ(ImportCell(circuit("0.376", "0.13"), "f").cell.capacity_Ah, 0.376);
  // The numbers are those of the file, whose pack has three cells.
  EXPECT_NE(MessageOf(R"({"maxVoltage":12.6,"battCapacityAh":1300,"refBatRes":30})")
                .find("found 1300 Ah and 30 Ohm: at 1C they would take 3.9e+04 V of 12.6 V"),
            std::string::npos);
}

TEST(ImportCell, RefusesTablesThatAreNone) {
  const std::string header = "soc,open_circuit_voltage_V,series_resistance_Ohm\n";
  const std::string capacity = "#: capacity_Ah = 1\n";
  EXPECT_EQ(
      MessageOf(header + "0,3,0.1\n1,4,0.1\n"),
      "f:1:1: error: expected a line '#: capacity_Ah = ...', found none; --capacity-Ah gives it");
  EXPECT_EQ(MessageOf("#: capacity_Ah = 0\n" + header),
            "f:1:18: error: expected a number above 0 for capacity_Ah, found 0");
  EXPECT_NE(MessageOf("#: capacityAh = 1\n" + header)
                .find("f:1:1: error: unknown number of a cell 'capacityAh'. Did you mean "
                      "'capacity_Ah'"),
            std::string::npos);
  EXPECT_EQ(MessageOf(capacity + capacity + header),
            "f:2:1: error: expected every number once, found capacity_Ah again");
  EXPECT_NE(MessageOf(capacity + "soc,ocv,open_circuit_voltage_V\n")
                .find("f:2:5: error: expected columns"),
            std::string::npos);
  EXPECT_EQ(MessageOf(capacity + header + "0,3000,0.1\n1,4200,0.1\n"),
            "f:1:1: error: expected voltages in V, found a v_oc(1) of 4200, which looks like mV");
  EXPECT_EQ(
      MessageOf(capacity + header + "0,3,0.1\n50,3.7,0.1\n100,4.2,0.1\n"),
      "f:1:1: error: expected states of charge from 0 to 1, found 100, which looks like per cent");
  EXPECT_EQ(MessageOf(capacity + "soc,open_circuit_voltage_V\n0,1\n"),
            "f:2:1: error: expected a column series_resistance_Ohm, found none");
  EXPECT_EQ(MessageOf(capacity + header + "0,3,0.1\n0,4,0.1\n"),
            "f:4:1: error: expected a soc above 0, that of the row before, found 0");
  EXPECT_EQ(MessageOf(capacity + header + "0,3\n"),
            "f:3:1: error: expected 3 fields as in the header, found 2");
  EXPECT_EQ(
      MessageOf(capacity + header + "0,3,-1\n"),
      "f:3:5: error: expected a number of at least 0 for a resistance or time constant, found "
      "-1");
  EXPECT_EQ(MessageOf(capacity + header + "0,inf,1\n"),
            "f:3:3: error: expected a number for open_circuit_voltage_V, found 'inf'");
  EXPECT_EQ(
      MessageOf(capacity + "soc,open_circuit_voltage_V,series_resistance_Ohm,resistance_1_Ohm,"
                           "time_constant_1_s\n0,3,0.1,0.1,5\n1,4,0.1,0.1,6\n"),
      "f:4:13: error: expected one time constant for the whole column, 5, found 6");
  EXPECT_EQ(
      MessageOf(capacity + "open_circuit_voltage_V,soc,series_resistance_Ohm,time_constant_2_s\n"),
      "f:2:1: error: expected a column resistance_2_Ohm, found none");
}

}  // namespace
}  // namespace lipoid
