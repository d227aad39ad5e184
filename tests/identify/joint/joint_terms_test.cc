#include "identify/joint/joint_terms.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_parameters.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

JointStructure WithEveryTerm(bool temperature) {
  JointStructure structure;
  structure.branches = 2;
  structure.self_heating = !temperature;
  structure.temperature = temperature;
  structure.charge_transfer = true;
  structure.entropy_soc = {0.0, 1.0};
  structure.hysteresis_soc = {0.5};
  structure.current_offset = structure.free_alpha = true;
  return structure;
}

const FitScales kScales{.typical_A = 1.0,
                        .largest_A = 6.0,
                        .slowest_A = 0.05,
                        .weight_sum = 1.0,
                        .shortest_tau_s = 10.0,
                        .longest_tau_s = 18000.0,
                        .longest_start_tau_s = 1800.0};

JointSetup ASetup() {
  JointSetup setup;
  setup.alpha_C = 2000.0;
  return setup;
}

TEST(JointTerms, EveryRateHasItsSlotOnceInOrder) {
  for (const bool temperature : {false, true}) {
    const JointStructure structure = WithEveryTerm(temperature);
    const auto rates = AllRates(structure, ASetup(), kScales);
    ASSERT_EQ(static_cast<int>(rates.size()), RateSlots(structure).size());
    for (std::size_t k = 0; k < rates.size(); ++k) {
      const JointRate& rate = rates[k];
      EXPECT_EQ(rate.slot, static_cast<int>(k)) << rate.name;
      EXPECT_LT(rate.lower, rate.upper) << rate.name;
      EXPECT_GE(rate.start, rate.lower) << rate.name;
      EXPECT_LE(rate.start, rate.upper) << rate.name;
      for (const double value : rate.grid) {
        EXPECT_GE(value, rate.lower) << rate.name;
        EXPECT_LE(value, rate.upper) << rate.name;
      }
      // A parameter of cells, or of the sensor.
      EXPECT_TRUE(rate.name == "i_off" || FindCellParameter(rate.name)) << rate.name;
    }
  }
}

TEST(JointTerms, EnergiesThatAreOneHaveOneRate) {
  JointStructure structure = WithEveryTerm(true);
  const std::size_t own = AllRates(structure, ASetup(), kScales).size();
  for (const SharedEnergies which : {SharedEnergies::kAllButSeries, SharedEnergies::kAll}) {
    structure.shared_energies = which;
    const auto rates = AllRates(structure, ASetup(), kScales);
    const bool all = which == SharedEnergies::kAll;
    EXPECT_EQ(rates.size(), own - (all ? 4 : 3));
    ASSERT_EQ(static_cast<int>(rates.size()), RateSlots(structure).size());
    JointRates numbers;
    numbers.time_constant_s.resize(2);
    for (std::size_t k = 0; k < rates.size(); ++k) {
      EXPECT_EQ(rates[k].slot, static_cast<int>(k)) << rates[k].name;
      rates[k].In(numbers) = static_cast<double>(k) + 1.0;
    }
    EXPECT_EQ(numbers.Branch(1), numbers.Diffusion());
    EXPECT_EQ(numbers.Transfer(), numbers.Diffusion());
    EXPECT_EQ(numbers.Series() == numbers.Diffusion(), all);
  }
  EXPECT_EQ(SharedEnergyNames(structure, false),
            (std::vector<std::string>{"E_s", "E_1", "E_2", "E_ct"}));
}

// What is set by one entry is read by it alone: no two rates share a number.
TEST(JointTerms, EveryRateHasANumberOfItsOwn) {
  const auto rates = AllRates(WithEveryTerm(true), ASetup(), kScales);
  JointRates all;
  all.time_constant_s.resize(2);
  all.branch_J_per_mol.resize(2);
  for (std::size_t k = 0; k < rates.size(); ++k) rates[k].In(all) = static_cast<double>(k);
  for (std::size_t k = 0; k < rates.size(); ++k)
    EXPECT_EQ(rates[k].In(all), static_cast<double>(k)) << rates[k].name;
}

TEST(JointTerms, OtherTablesFollowTheLayout) {
  JointStructure structure = WithEveryTerm(false);
  const JointLayout layout(structure);
  const auto tables = OtherTables(structure, 2.0);
  ASSERT_EQ(tables.size(), 3U);
  EXPECT_EQ(tables[0].first, layout.entropy());
  EXPECT_TRUE(tables[0].name.empty());
  EXPECT_EQ(tables[1].first, layout.hysteresis());
  EXPECT_EQ(tables[2].first, layout.heating());
  EXPECT_EQ(tables[2].scale, 0.125);
  for (const JointTable& table : tables) {
    EXPECT_LE(table.first + static_cast<int>(table.soc.size()), layout.size()) << table.name;
    EXPECT_TRUE(table.name.empty() || CellParameterUnit(table.name) == table.unit) << table.name;
  }
  EXPECT_TRUE(OtherTables(JointStructure(), 2.0).empty());
}

TEST(JointTerms, CoordinatesAndValuesAreInverse) {
  for (const JointRate& rate : AllRates(WithEveryTerm(true), ASetup(), kScales)) {
    const double value = 0.3 * rate.lower + 0.7 * rate.upper;
    const double at = rate.Coordinate(value);
    EXPECT_NEAR(rate.Value(at), value, 1e-13 * std::abs(value)) << rate.name;
    const auto slope = test::Ridders([&](double x) { return rate.Value(x); }, at, 0.1);
    EXPECT_NEAR(rate.Slope(value), slope.value, 1e-9 * std::abs(slope.value)) << rate.name;
  }
}

// Searches take a step as small beside the size of all coordinates: that of alpha was 760, and a step of a fifth of the
// others small beside it.
TEST(JointTerms, NoCoordinateIsLargeWhereASearchStarts) {
  constexpr double kLargest = 11.0;  // of the logarithm of 40 kJ/mol, or of 10 h in seconds
  for (const bool temperature : {false, true}) {
    for (const JointRate& rate : AllRates(WithEveryTerm(temperature), ASetup(), kScales))
      EXPECT_LE(std::abs(rate.Coordinate(rate.start)), kLargest) << rate.name;
  }
}

TEST(JointTerms, AStructureHasTheTermsThatItWasGiven) {
  for (const JointTerm& term : JointTerms()) {
    EXPECT_FALSE(term.present(JointStructure())) << term.key;
    EXPECT_TRUE(term.present(WithEveryTerm(term.key != "self_heating"))) << term.key;
  }
}

}  // namespace
}  // namespace lipoid
