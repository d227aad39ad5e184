#include "model/battery/cell_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"

namespace lipoid {
namespace {

constexpr double kRoundingOfPercents = 1e-12;

const ParameterComparison& Find(const CellComparison& comparison, const std::string& name) {
  for (const auto& one : comparison.parameters) {
    if (one.name == name) return one;
  }
  ADD_FAILURE() << name;
  return comparison.parameters.front();
}

TEST(CellComparison, SaysTheErrorOfEachParameterInPercentOfTheTruth) {
  const Cell truth = LoadCell("gifi-600mAh-1");
  Cell estimate = truth;
  SetCellParameter(estimate, "beta", 0.1924 * 1.02);
  SetCellParameter(estimate, "r_s", 0.1314 * 0.99);
  const auto comparison = CompareCells(truth, estimate);
  EXPECT_EQ(Find(comparison, "alpha").error_percent, 0.0);
  EXPECT_NEAR(*Find(comparison, "beta").error_percent, 2.0, kRoundingOfPercents);
  EXPECT_NEAR(*Find(comparison, "r_s").error_percent, -1.0, kRoundingOfPercents);
  EXPECT_EQ(Find(comparison, "r_s").unit, "Ohm");
  EXPECT_NEAR(comparison.open_circuit_max_V, 0.0, kRoundingOfPercents);
}

// The same cell, its numbers written for 5 degC and for 25 degC.
TEST(CellComparison, AnotherReferenceTemperatureIsTheSameCell) {
  Cell truth = LoadCell("gifi-600mAh-1");
  truth.temperature.emplace();
  truth.temperature->reference_K = 278.15;
  truth.temperature->series_J_per_mol = 2e4;
  truth.temperature->branches_J_per_mol.assign(truth.branches.size(), 3e4);
  truth.temperature->diffusion_J_per_mol = 4e4;
  Cell estimate = truth;
  estimate.temperature->reference_K = 298.15;
  // Arrhenius' law, R = 8.314462618 J/(mol K).
  const double warmer = (1.0 / 298.15 - 1.0 / 278.15) / 8.314462618;
  SetCellParameter(estimate, "r_s", 0.1314 * std::exp(2e4 * warmer));
  SetCellParameter(estimate, "beta", 0.1924 / std::sqrt(std::exp(4e4 * warmer)));
  const auto comparison = CompareCells(truth, estimate);
  EXPECT_NEAR(*Find(comparison, "r_s").error_percent, 0.0, 1e-9);
  EXPECT_NEAR(*Find(comparison, "beta").error_percent, 0.0, 1e-9);
}

TEST(CellComparison, NamesWhatOnlyOneOfThemHas) {
  const Cell truth = LoadCell("gifi-600mAh-1");
  Cell estimate = truth;
  estimate.branches.clear();
  SetCellParameter(estimate, "r_1", 0.01);
  SetCellParameter(estimate, "tau_1", 50.0);
  SetCellParameter(estimate, "r_2", 0.02);
  SetCellParameter(estimate, "tau_2", 5.0);
  const auto comparison = CompareCells(truth, estimate);
  EXPECT_EQ(Find(comparison, "r_2").truth, std::nullopt);
  EXPECT_EQ(Find(comparison, "r_2").estimate, 0.01);
  EXPECT_EQ(Find(comparison, "r_2").error_percent, std::nullopt);
  EXPECT_EQ(ComparisonToJson(comparison).at("parameters").at("r_2").at("truth"), nullptr);
}

// The numbers of branches say nothing of which is which.
TEST(CellComparison, BranchesCorrespondByTheNearestTimeConstant) {
  Cell one = LoadCell("gifi-600mAh-1");
  one.temperature.emplace();
  one.branches.clear();
  Cell two = one;
  SetCellParameter(one, "r_1", 0.03);
  SetCellParameter(one, "tau_1", 30.0);
  SetCellParameter(one, "E_1", 2e4);
  SetCellParameter(two, "r_1", 2e-4);
  SetCellParameter(two, "tau_1", 2.2);
  SetCellParameter(two, "r_2", 0.0303);
  SetCellParameter(two, "tau_2", 33.0);
  const auto of_more = CompareCells(one, two);
  EXPECT_NEAR(*Find(of_more, "r_1").error_percent, 1.0, kRoundingOfPercents);
  EXPECT_NEAR(*Find(of_more, "tau_1").error_percent, 10.0, kRoundingOfPercents);
  EXPECT_EQ(Find(of_more, "tau_2").truth, std::nullopt);
  EXPECT_EQ(Find(of_more, "tau_2").estimate, 2.2);
  const auto of_fewer = CompareCells(two, one);
  EXPECT_EQ(Find(of_fewer, "tau_1").estimate, std::nullopt);
  EXPECT_EQ(Find(of_fewer, "E_1").estimate, std::nullopt);
  EXPECT_EQ(Find(of_fewer, "E_2").estimate, 2e4);
  EXPECT_EQ(Find(of_fewer, "tau_2").truth, 33.0);
  EXPECT_EQ(Find(of_fewer, "tau_2").estimate, 30.0);
}

TEST(CellComparison, AnotherGaugeOfAlphaIsTheSameCurve) {
  // The same voltages against charge: alpha 1 % larger, and every node of v_oc moved with it.
  const Cell truth = LoadCell("gifi-600mAh-1");
  Cell estimate = truth;
  SetCellParameter(estimate, "alpha", 1353.6 * 1.01);
  auto soc = truth.open_circuit_voltage.soc();
  for (double& node : soc) node = 1.0 - (1.0 - node) / 1.01;
  estimate.open_circuit_voltage =
      OpenCircuitVoltage::Linear(soc, truth.open_circuit_voltage.voltage_V());
  EXPECT_NEAR(CompareCells(truth, estimate).open_circuit_max_V, 0.0, kRoundingOfPercents);
  // Without moving them it is another curve: 1 % of the charge at the steepest end, 15 V per unit
  // of soc.
  estimate.open_circuit_voltage = truth.open_circuit_voltage;
  EXPECT_NEAR(CompareCells(truth, estimate).open_circuit_max_V, 15.0 * 0.01 / 1.01, 1e-9);
}

}  // namespace
}  // namespace lipoid
