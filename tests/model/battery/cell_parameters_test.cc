#include "model/battery/cell_parameters.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string_view>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

std::string OptionErrorOf(Cell cell, std::string_view name, double value) {
  try {
    SetCellParameter(cell, name, value);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CellParameters, AreNamedAsOnTheCommandLine) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  EXPECT_EQ(CellParameterNames(cell),
            (std::vector<std::string>{"alpha", "beta", "r_s", "r_1", "c_1", "tau_1"}));
  EXPECT_EQ(CellParameter(cell, "alpha"), 1353.6);  // Table 4.11
  EXPECT_EQ(CellParameter(cell, "beta"), 0.1924);
  EXPECT_EQ(CellParameter(cell, "r_s"), 0.1314);
  EXPECT_EQ(CellParameter(cell, "c_1"), 10.1739);
  EXPECT_EQ(CellParameter(cell, "tau_1"), 2.3643e-5 * 10.1739);
  EXPECT_EQ(CellParameter(cell, "r_2"), std::nullopt);
}

// Of tables the values at that state of charge, by hand; a charge transfer counts for small currents alone.
TEST(CellParameters, ResistancesAddUp) {
  Cell cell = LoadCell("gifi-600mAh-1");
  Resistance<double> table;
  table.soc = {0.0, 1.0};
  table.resistance_Ohm = {0.3, 0.1};
  cell.series_resistance_Ohm = table;
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}, {table, 10.0, {}}};
  EXPECT_DOUBLE_EQ(SeriesAndBranches(cell, 0.25), 0.25 + 0.03 + 0.25);
  EXPECT_EQ(TotalResistance(cell, 0.25), SeriesAndBranches(cell, 0.25));
  cell.charge_transfer = {.current_A = 0.5, .resistance_Ohm = Resistance<double>(0.02)};
  EXPECT_DOUBLE_EQ(SeriesAndBranches(cell, 0.25), 0.53);
  EXPECT_DOUBLE_EQ(TotalResistance(cell, 0.25), 0.55);
}

TEST(CellParameters, ResistanceAndCapacitanceMakeTheTimeConstantInEitherOrder) {
  Cell a = LoadCell("gifi-600mAh-1");
  SetCellParameter(a, "r_1", 0.03);
  SetCellParameter(a, "c_1", 1500.0);
  Cell b = LoadCell("gifi-600mAh-1");
  SetCellParameter(b, "c_1", 1500.0);
  SetCellParameter(b, "r_1", 0.03);
  EXPECT_EQ(a.branches[0].time_constant_s, 45.0);
  EXPECT_EQ(b.branches[0].time_constant_s, 45.0);
}

TEST(CellParameters, AGivenTimeConstantStaysWhenTheResistanceChanges) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "tau_1", 60.0);
  SetCellParameter(cell, "r_1", 0.02);
  EXPECT_EQ(CellParameter(cell, "tau_1"), 60.0);
  EXPECT_EQ(CellParameter(cell, "c_1"), 3000.0);  // 60 s / 0.02 Ohm
}

TEST(CellParameters, TheNextResistanceAddsABranch) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "r_2", 0.01);
  SetCellParameter(cell, "tau_2", 5.0);
  ASSERT_EQ(cell.branches.size(), 2U);
  EXPECT_EQ(cell.branches[1].time_constant_s, 5.0);
}

TEST(CellParameters, ATermIsAddedByItsTwoParametersInEitherOrder) {
  using Assignments = std::vector<std::pair<const char*, double>>;
  for (const Assignments& all :
       {Assignments{{"tau_h", 300}, {"rho_h", 1e-5}, {"i_0", 0.5}, {"r_ct", 0}},
        Assignments{{"r_ct", 0}, {"rho_h", 1e-5}, {"i_0", 0.5}, {"tau_h", 300}}}) {
    Cell cell = LoadCell("gifi-600mAh-1");
    for (const auto& [name, value] : all) SetCellParameter(cell, name, value);
    EXPECT_EQ(MissingCellParameter(cell), std::nullopt);
    EXPECT_EQ(cell.self_heating->time_constant_s, 300.0);
    EXPECT_EQ(cell.self_heating->resistance_drop_Ohm_per_A2, 1e-5);
    EXPECT_EQ(cell.charge_transfer->current_A, 0.5);
    EXPECT_EQ(cell.charge_transfer->resistance_Ohm.resistance_Ohm, (std::vector<double>{0.0}));
    EXPECT_EQ(CellParameterNames(cell),
              (std::vector<std::string>{
                  "alpha", "beta", "r_s", "r_1", "c_1", "tau_1", "tau_h", "rho_h", "i_0", "r_ct"}));
    for (const auto& [name, value] : all) EXPECT_EQ(CellParameter(cell, name), value) << name;
    SetCellParameter(cell, "rho_h", 2e-5);
    EXPECT_EQ(CellParameter(cell, "rho_h"), 2e-5);
    EXPECT_EQ(CellParameter(cell, "tau_h"), 300.0);
  }
}

TEST(CellParameters, WhatWasBegunAndNotCompletedIsNamed) {
  const std::pair<const char*, const char*> all[] = {{"r_2", "r_2 needs c_2 or tau_2 beside it"},
                                                     {"tau_h", "tau_h needs rho_h beside it"},
                                                     {"rho_h", "rho_h needs tau_h beside it"},
                                                     {"i_0", "i_0 needs r_ct beside it"},
                                                     {"r_ct", "r_ct needs i_0 beside it"}};
  for (const auto& [name, message] : all) {
    Cell cell = LoadCell("gifi-600mAh-1");
    EXPECT_EQ(MissingCellParameter(cell), std::nullopt);
    SetCellParameter(cell, name, 0.01);
    EXPECT_EQ(MissingCellParameter(cell), message);
    EXPECT_EQ(CellParameterNames(cell),
              (std::vector<std::string>{"alpha", "beta", "r_s", "r_1", "c_1", "tau_1", name}));
  }
}

TEST(CellParameters, ATableHasNoName) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.2, 0.1});
  cell.charge_transfer = {0.5, cell.series_resistance_Ohm};
  EXPECT_EQ(MissingCellParameter(cell), std::nullopt);
  EXPECT_EQ(CellParameterNames(cell),
            (std::vector<std::string>{"alpha", "beta", "r_1", "c_1", "tau_1", "i_0"}));
}

// A cell of which everything that can be a table is one.
Cell WithTables() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 0.4, 1.0}, {3.0, 3.7, 4.2});
  cell.series_resistance_Ohm = Resistance<double>({0.0, 0.5, 1.0}, {0.3, 0.2, 0.1});
  cell.branches = {{.resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.06, 0.05}),
                    .time_constant_s = 40.0,
                    .capacitance_F = {}}};
  cell.charge_transfer = {0.5, Resistance<double>({0.5}, {0.01})};
  return cell;
}

constexpr auto kNodes = std::to_array<std::string_view>(
    {"r_s[0]", "r_s[1]", "r_s[2]", "r_1[0]", "r_1[1]", "r_ct[0]", "v_oc[0]", "v_oc[1]", "v_oc[2]"});

TEST(CellParameters, NodesAreCountedFromZero) {
  const Cell cell = WithTables();
  EXPECT_EQ(CellParameter(cell, "r_s[0]"), 0.3);
  EXPECT_EQ(CellParameter(cell, "r_s[2]"), 0.1);
  EXPECT_EQ(CellParameter(cell, "r_1[1]"), 0.05);
  EXPECT_EQ(CellParameter(cell, "r_ct[0]"), 0.01);
  EXPECT_EQ(CellParameter(cell, "v_oc[1]"), 3.7);
  for (const std::string_view name : kNodes) EXPECT_TRUE(CellParameter(cell, name)) << name;
  for (const char* name : {"r_s[3]",
                           "r_1[2]",
                           "r_2[0]",
                           "r_ct[1]",
                           "v_oc[3]",
                           "r_s[",
                           "r_s[]",
                           "r_s[-1]",
                           "r_s[1]x",
                           "beta[0]"})
    EXPECT_EQ(CellParameter(cell, name), std::nullopt) << name;
  // A constant is a parameter, not a table of one node; series have no nodes.
  EXPECT_EQ(CellParameter(LoadCell("gifi-600mAh-1"), "r_s[0]"), std::nullopt);
  Cell series = cell;
  series.open_circuit_voltage = OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.6, 0.6});
  EXPECT_EQ(CellParameter(series, "v_oc[0]"), std::nullopt);
}

TEST(CellParameters, ANodeChangesAlone) {
  const Cell before = WithTables();
  for (const std::string_view name : kNodes) {
    Cell cell = before;
    SetCellParameter(cell, name, 0.02);
    for (const std::string_view other : kNodes)
      EXPECT_EQ(CellParameter(cell, other), other == name ? 0.02 : *CellParameter(before, other));
    EXPECT_EQ(cell.series_resistance_Ohm.soc, before.series_resistance_Ohm.soc);
    EXPECT_EQ(cell.branches[0].time_constant_s, 40.0);
  }
  Cell cell = before;
  SetCellParameter(cell, "v_oc[1]", 3.6);
  EXPECT_DOUBLE_EQ(cell.open_circuit_voltage(0.2), 3.3);  // halfway from 3.0 V to 3.6 V
  Cell smooth = before;
  smooth.open_circuit_voltage =
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.3, 0.6, 1.0}, {3.0, 3.6, 3.8, 4.2});
  SetCellParameter(smooth, "v_oc[3]", 4.1);
  EXPECT_EQ(smooth.open_circuit_voltage.method(), OcvMethod::kMonotoneCubic);
  EXPECT_EQ(smooth.open_circuit_voltage(1.0), 4.1);
}

TEST(CellParameters, NodesThatAreNotThereAreRefused) {
  const Cell cell = WithTables();
  EXPECT_EQ(OptionErrorOf(cell, "r_s[3]", 0.1),
            "'r_s[3]' is no parameter of this cell: the nodes of r_s are 0 to 2");
  EXPECT_EQ(OptionErrorOf(cell, "r_2[0]", 0.1),
            "'r_2[0]' is no parameter of this cell: it has no table r_2");
  EXPECT_EQ(OptionErrorOf(cell, "r_1[1]", -0.1),
            "r_1[1]: expected a resistance of at least 0 Ohm, found -0.1");
  EXPECT_EQ(OptionErrorOf(cell, "v_oc[0]", std::nan("")),
            "v_oc[0]: expected a finite voltage, found nan");
}

TEST(CellParameters, EachHasItsUnit) {
  const std::pair<const char*, const char*> all[] = {{"alpha", "C"},
                                                     {"beta", "s^-1/2"},
                                                     {"r_s", "Ohm"},
                                                     {"r_12", "Ohm"},
                                                     {"c_1", "F"},
                                                     {"tau_1", "s"},
                                                     {"tau_h", "s"},
                                                     {"rho_h", "Ohm/A^2"},
                                                     {"i_0", "A"},
                                                     {"r_ct", "Ohm"},
                                                     {"r_s[3]", "Ohm"},
                                                     {"r_1[0]", "Ohm"},
                                                     {"v_oc[7]", "V"}};
  for (const auto& [name, unit] : all) EXPECT_EQ(CellParameterUnit(name), unit) << name;
}

// Terms of two numbers are begun with one and completed with the other; a slope has either sign.
TEST(CellParameters, HysteresisAndHeatAreTermsOfTwoNumbers) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameter(cell, "M", 0.02);
  EXPECT_EQ(MissingCellParameter(cell), "M needs gamma beside it");
  SetCellParameter(cell, "gamma", 40.0);
  EXPECT_EQ(MissingCellParameter(cell), std::nullopt);
  EXPECT_EQ(cell.hysteresis->half_V, std::vector<double>{0.02});
  SetCellParameter(cell, "R_th", 12.0);
  EXPECT_EQ(MissingCellParameter(cell), "R_th needs C_th beside it");
  SetCellParameter(cell, "C_th", 15.0);
  EXPECT_EQ(MissingCellParameter(cell), std::nullopt);
  SetCellParameter(cell, "dv_dT", -2e-4);
  EXPECT_EQ((*cell.temperature->entropy)(0.3), -2e-4);
  cell.temperature->entropy = EntropySlope<double>{{0.0, 1.0}, {-1e-4, 1e-4}};
  EXPECT_EQ(CellParameter(cell, "dv_dT"), std::nullopt);
  EXPECT_EQ(CellParameter(cell, "dv_dT[1]"), 1e-4);
  SetCellParameter(cell, "dv_dT[1]", -3e-4);
  EXPECT_EQ((*cell.temperature->entropy)(1.0), -3e-4);
}

TEST(CellParameters, WhatCannotBeIsRefused) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  EXPECT_EQ(OptionErrorOf(cell, "beta", 1.5),
            "beta: expected a number from 0.0001 to 1, found 1.5");
  EXPECT_EQ(OptionErrorOf(cell, "alpha", 0.0), "alpha: expected a charge above 0 C, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "r_s", -1.0),
            "r_s: expected a resistance of at least 0 Ohm, found -1");
  EXPECT_EQ(OptionErrorOf(cell, "c_2", 1.0),
            "c_2: the cell has 1 branch; give r_2 first to add one");
  EXPECT_EQ(OptionErrorOf(cell, "tau_h", 0.0),
            "tau_h: expected a time constant above 0 s, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "rho_h", -1e-5),
            "rho_h: expected a drop of the resistance of at least 0 Ohm/A^2, found -1e-05");
  EXPECT_EQ(OptionErrorOf(cell, "i_0", 0.0), "i_0: expected a current above 0 A, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "r_ct", -0.1),
            "r_ct: expected a resistance of at least 0 Ohm, found -0.1");
  EXPECT_EQ(OptionErrorOf(cell, "gamma", 0.0),
            "gamma: expected a number of e-folds above 0, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "M", -0.1), "M: expected a voltage of at least 0 V, found -0.1");
  EXPECT_EQ(OptionErrorOf(cell, "C_th", 0.0),
            "C_th: expected a heat capacity above 0 J/K, found 0");
  EXPECT_EQ(OptionErrorOf(cell, "delta", 1.0),
            "'delta' is no parameter of this cell; it has alpha, beta, r_s, r_1, c_1, tau_1");
}

TEST(CellParameters, AQuantityOfAReportHasItsStateOfChargeInBrackets) {
  EXPECT_EQ(SplitQuantity("r_total(0.5)").name, "r_total");
  EXPECT_EQ(SplitQuantity("r_total(0.5)").soc, 0.5);
  EXPECT_EQ(SplitQuantity("tau_1").name, "tau_1");
  EXPECT_EQ(SplitQuantity("tau_1").soc, std::nullopt);
}

TEST(CellParameters, SeveralMakeAWholeCell) {
  Cell cell = LoadCell("gifi-600mAh-1");
  SetCellParameters(cell, {{"r_1", 0.03}, {"tau_1", 45.0}, {"r_2", 0.01}, {"c_2", 100.0}});
  EXPECT_EQ(cell.branches[0].time_constant_s, 45.0);
  EXPECT_EQ(cell.branches[1].time_constant_s, 1.0);
  const auto error_of = [&](const std::vector<std::pair<std::string, double>>& values) {
    Cell other = cell;
    return test::MessageOf<OptionError>([&] { SetCellParameters(other, values); });
  };
  EXPECT_EQ(error_of({{"tau_1", 45.0}, {"c_1", 1500.0}}),
            "give either c_1 or tau_1, not both: tau_1 = r_1 c_1");
  EXPECT_EQ(error_of({{"r_1", 0.02}, {"r_1", 0.03}}), "r_1 is given twice; give it once");
  EXPECT_EQ(error_of({{"r_3", 0.02}}), "r_3 needs c_3 or tau_3 beside it");
}

}  // namespace
}  // namespace lipoid
