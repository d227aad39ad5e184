// Predict() against tests/reference/reference_cell.py, which was written from the thesis and not
// from the code: the same cell file and record through both, compared row by row.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/atomic_file.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

// Both are exact zero-order holds in double precision; they differ in rounding alone. Charge is
// summed over n <= 2e4 rows in another order, n * 1.1e-16 of it at worst, and v_oc falls by at most
// 15 V per unit of A: 3e-11 V. Measured worst: 1e-13 V.
constexpr double kVoltageTolerance_V = 3e-11;
constexpr double kSocTolerance = 2e-12;

struct Case {
  std::string label;
  Json cell;
  std::vector<double> time_s;
  std::vector<double> current_A;
  Hold hold = Hold::kBackward;
  double initial_soc = 1.0;
  bool plain_loop = false;
};

Json TypicalCurve() {
  return {{"method", "linear"},
          {"soc", {0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}},
          {"voltage_V", {3.0, 3.3, 3.45, 3.6, 3.7, 3.74, 3.77, 3.82, 3.87, 3.95, 4.02, 4.11, 4.2}}};
}

// A 600 mAh cell with as many of these branches as wanted: slow, fast, by capacitance and by time
// constant.
Json CellWith(int terms, bool tail, std::size_t branches) {
  const std::vector<Json> all = {{{"resistance_Ohm", 0.03}, {"capacitance_F", 1500.0}},
                                 {{"resistance_Ohm", 0.012}, {"time_constant_s", 0.7}},
                                 {{"resistance_Ohm", 2.4e-5}, {"capacitance_F", 10.17}}};
  return {{"schema", "lipoid.cell/1"},
          {"name", "reference"},
          {"capacity_Ah", 0.6},
          {"cutoff_V", 3.0},
          {"diffusion",
           {{"alpha_C", 1353.6}, {"beta_per_sqrt_s", 0.1924}, {"terms", terms}, {"tail", tail}}},
          {"open_circuit_voltage", TypicalCurve()},
          {"series_resistance_Ohm", 0.1314},
          {"branches",
           std::vector<Json>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(branches))}};
}

std::vector<double> UniformTimes(std::size_t rows, double sampling_s) {
  std::vector<double> time_s(rows);
  for (std::size_t k = 0; k < rows; ++k) time_s[k] = sampling_s * static_cast<double>(k);
  return time_s;
}

// Currents that stay at a random level, discharge or charge, for a random number of rows.
std::vector<double> SteppedCurrents(std::size_t rows, double largest_A, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> level(-0.4 * largest_A, largest_A);
  std::uniform_int_distribution<std::size_t> length(1, std::max<std::size_t>(2, rows / 20));
  std::vector<double> current_A;
  while (current_A.size() < rows) {
    const double next = engine() % 3 == 0 ? 0.0 : level(engine);
    current_A.insert(current_A.end(), length(engine), next);
  }
  current_A.resize(rows);
  return current_A;
}

// 10 ms through a pulse, seconds after it, minutes in the rest, and some stamps at random.
std::vector<double> MixedTimes(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> random(0.003, 90.0);
  std::vector<double> time_s = {0.0};
  const auto extend = [&](int rows, double step_s) {
    const double from = time_s.back();
    for (int k = 1; k <= rows; ++k) time_s.push_back(from + step_s * k);
  };
  for (int round = 0; round < 3; ++round) {
    extend(500, 0.01);
    extend(100, 1.0);
    extend(10, 60.0);
    for (int k = 0; k < 30; ++k) time_s.push_back(time_s.back() + random(engine));
  }
  return time_s;
}

std::vector<std::vector<double>> ReadColumns(const std::string& file) {
  std::ifstream stream(file);
  std::vector<std::vector<double>> columns(5);
  std::string line;
  std::getline(stream, line);  // header
  while (std::getline(stream, line)) {
    const char* at = line.c_str();
    for (auto& column : columns) {
      char* end = nullptr;
      column.push_back(std::strtod(at, &end));
      at = end + 1;
    }
  }
  return columns;
}

// Runs all cases through Python at once and compares each.
void ExpectAgreement(const std::string& name, const std::vector<Case>& cases) {
  const std::string python = LIPOID_PYTHON;
  if (python.empty()) GTEST_SKIP() << "skipped: no python3 with numpy and scipy was found";
  const std::string folder = test::FreshFolder("reference_" + name);
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const Case& one = cases[k];
    WriteFileAtomically(fmt::format("{}/{}.cell.json", folder, k), one.cell.dump());
    std::string csv = "time_s,current_A\n";
    for (std::size_t row = 0; row < one.time_s.size(); ++row) {
      csv += fmt::format("{:.17g},{:.17g}\n", one.time_s[row], one.current_A[row]);
    }
    WriteFileAtomically(fmt::format("{}/{}.csv", folder, k), csv);
    const Json request = {{"cell", fmt::format("{}.cell.json", k)},
                          {"record", fmt::format("{}.csv", k)},
                          {"output", fmt::format("{}.out.csv", k)},
                          {"hold", one.hold == Hold::kBackward ? "backward" : "forward"},
                          {"initial_soc", one.initial_soc},
                          {"plain_loop", one.plain_loop}};
    WriteFileAtomically(fmt::format("{}/{}.case.json", folder, k), request.dump());
  }
  const std::string command = fmt::format("'{}' -B '{}' batch '{}'",
                                          python,
                                          test::SourcePath("tests/reference/reference_cell.py"),
                                          folder);
  ASSERT_EQ(std::system(command.c_str()), 0) << command;

  double worst_V = 0.0;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const Case& one = cases[k];
    SCOPED_TRACE(one.label);
    const Cell cell = LoadCell(fmt::format("{}/{}.cell.json", folder, k));
    const auto ours = Predict(cell, one.time_s, one.current_A, one.hold, one.initial_soc);
    const auto theirs = ReadColumns(fmt::format("{}/{}.out.csv", folder, k));
    ASSERT_EQ(theirs[2].size(), one.time_s.size());
    double voltage_V = 0.0;
    double open_circuit_V = 0.0;
    double soc = 0.0;
    double moved_V = 0.0;
    for (std::size_t row = 0; row < one.time_s.size(); ++row) {
      ASSERT_TRUE(std::isfinite(ours.voltage_V[row])) << row;
      voltage_V = std::max(voltage_V, std::abs(ours.voltage_V[row] - theirs[2][row]));
      open_circuit_V =
          std::max(open_circuit_V, std::abs(ours.open_circuit_V[row] - theirs[3][row]));
      soc = std::max(soc, std::abs(ours.soc[row] - theirs[4][row]));
      moved_V = std::max(moved_V, std::abs(ours.voltage_V[row] - ours.voltage_V[0]));
    }
    EXPECT_LE(voltage_V, kVoltageTolerance_V * cell.series);
    EXPECT_LE(open_circuit_V, kVoltageTolerance_V * cell.series);
    EXPECT_LE(soc, kSocTolerance);
    EXPECT_GE(moved_V, 0.02) << "the record hardly moves the cell: it proves nothing";
    worst_V = std::max(worst_V, voltage_V / cell.series);
  }
  ::testing::Test::RecordProperty("worst_V", fmt::format("{:.3g}", worst_V));
}

TEST(Reference, AgreesUnderUniformSampling) {
  std::vector<Case> cases;
  struct Sampling {
    double step_s;
    std::size_t rows;
    double largest_A;
  };
  unsigned seed = 1;
  for (const Sampling& sampling :
       {Sampling{0.01, 20001, 9.0}, {1.0, 1501, 2.0}, {60.0, 301, 0.3}}) {
    for (const int terms : {0, 1, 5, 10, 50}) {
      for (const bool tail : {true, false}) {
        for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
          const std::size_t branches = seed % 4;
          cases.push_back({fmt::format("every {} s, M = {}, tail {}, {} branches, seed {}",
                                       sampling.step_s,
                                       terms,
                                       tail,
                                       branches,
                                       seed),
                           CellWith(terms, tail, branches),
                           UniformTimes(sampling.rows, sampling.step_s),
                           SteppedCurrents(sampling.rows, sampling.largest_A, seed),
                           hold,
                           seed % 5 == 0 ? 0.7 : 1.0,
                           sampling.rows < 1000});
          ++seed;
        }
      }
    }
  }
  ExpectAgreement("uniform", cases);
}

TEST(Reference, AgreesUnderMixedSampling) {
  std::vector<Case> cases;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto time_s = MixedTimes(seed);
    const auto branches = seed % 4;
    cases.push_back({fmt::format("mixed, seed {}", seed),
                     CellWith(seed % 2 == 0 ? 10 : 3, seed % 3 != 0, branches),
                     time_s,
                     SteppedCurrents(time_s.size(), 1.0, seed),
                     seed % 2 == 0 ? Hold::kForward : Hold::kBackward,
                     1.0,
                     true});
  }
  ExpectAgreement("mixed", cases);
}

TEST(Reference, AgreesWithoutDiffusion) {
  std::vector<Case> cases;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    Json cell = CellWith(10, true, 2);
    cell["diffusion"] = nullptr;
    cases.push_back({"no diffusion",
                     cell,
                     UniformTimes(1001, 1.0),
                     SteppedCurrents(1001, 2.0, 11),
                     hold,
                     0.9,
                     false});
  }
  ExpectAgreement("no_diffusion", cases);
}

TEST(Reference, AgreesForPacks) {
  std::vector<Case> cases;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    Json cell = CellWith(10, true, 2);
    cell["series"] = 6;
    cell["parallel"] = 4;
    cases.push_back(
        {"6s4p", cell, UniformTimes(1001, 1.0), SteppedCurrents(1001, 9.0, 12), hold, 1.0, false});
  }
  ExpectAgreement("packs", cases);
}

TEST(Reference, AgreesForTablesOfResistances) {
  std::vector<Case> cases;
  for (const bool tail : {true, false}) {
    for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
      Json cell = CellWith(10, tail, 1);
      cell["series_resistance_Ohm"] = {{"soc", {0.1, 0.3, 0.9}},
                                       {"resistance_Ohm", {0.3, 0.15, 0.12}}};
      cell["branches"].push_back(
          {{"resistance_Ohm", {{"soc", {0.0, 0.5, 1.0}}, {"resistance_Ohm", {0.1, 0.02, 0.03}}}},
           {"time_constant_s", 25.0}});
      cell["branches"].push_back({{"resistance_Ohm", {{"soc", {0.5}}, {"resistance_Ohm", {0.01}}}},
                                  {"time_constant_s", 0.0}});
      cases.push_back({fmt::format("tables, tail {}", tail),
                       cell,
                       UniformTimes(1501, 1.0),
                       SteppedCurrents(1501, 3.0, 13),
                       hold,
                       1.0,
                       false});
    }
  }
  ExpectAgreement("tables", cases);
}

TEST(Reference, AgreesForTheTwoTermsBeyondTheThesis) {
  std::vector<Case> cases;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    Json heating = CellWith(10, true, 2);
    // Up to 3/4 of r_s and beyond: 0.1314 Ohm against 0.03 Ohm/A² times 9 A².
    heating["self_heating"] = {{"time_constant_s", 120.0}, {"resistance_drop_Ohm_per_A2", 0.03}};
    Json kinetics = CellWith(10, false, 1);
    kinetics["charge_transfer"] = {{"current_A", 0.25}, {"resistance_Ohm", 0.05}};
    Json both = heating;
    both["series"] = 3;
    both["parallel"] = 2;
    both["series_resistance_Ohm"] = {{"soc", {0.1, 0.3, 0.9}},
                                     {"resistance_Ohm", {0.3, 0.15, 0.12}}};
    both["charge_transfer"] = {
        {"current_A", 0.25},
        {"resistance_Ohm", {{"soc", {0.0, 0.5, 1.0}}, {"resistance_Ohm", {0.2, 0.04, 0.06}}}}};
    for (const auto& [label, cell, largest_A] : {std::tuple{"heating", heating, 3.0},
                                                 std::tuple{"kinetics", kinetics, 3.0},
                                                 std::tuple{"both", both, 6.0}}) {
      cases.push_back({label,
                       cell,
                       UniformTimes(1501, 1.0),
                       SteppedCurrents(1501, largest_A, 15),
                       hold,
                       1.0,
                       false});
      const auto mixed = MixedTimes(16);
      cases.push_back(
          {label, cell, mixed, SteppedCurrents(mixed.size(), largest_A, 17), hold, 0.9, false});
    }
  }
  ExpectAgreement("terms", cases);
}

// The record drives A from above 1 to below 0, so that every piece of each curve and both
// continuations are visited.
TEST(Reference, AgreesForEveryFormOfTheOpenCircuitVoltage) {
  Json cubic = TypicalCurve();
  cubic["method"] = "monotone-cubic";
  Json wavy = cubic;  // not monotone: inner extrema, and ends where the three-point slope turns or
                      // overshoots
  wavy["soc"] = {0.0, 0.1, 0.2, 0.5, 0.9, 1.0};
  wavy["voltage_V"] = {3.0, 3.01, 3.5, 3.4, 4.0, 3.99};
  const Json polynomial = {
      {"method", "polynomial"},
      {"soc_range", {-0.01, 1.005}},
      {"basis", "chebyshev"},
      {"coefficients_V", {3.75, 0.45, -0.06, 0.08, -0.03, 0.02, -0.015, 0.008, -0.004, 0.002}}};
  const Json fourier = {{"method", "fourier"},
                        {"soc_range", {0.0, 1.0}},
                        {"frequency_rad", 2.7},
                        {"cosine_V", {3.8, -0.2, 0.05, -0.02, 0.01, 0.005, -0.002, 0.001}},
                        {"sine_V", {0.15, 0.04, -0.03, 0.01, -0.004, 0.002, -0.001}}};
  std::vector<Case> cases;
  for (const Json& curve : {TypicalCurve(), cubic, wavy, polynomial, fourier}) {
    Json cell = CellWith(10, true, 1);
    cell["open_circuit_voltage"] = curve;
    std::vector<double> current_A(2001, 0.75);  // 1500 C after 50 C of charging
    std::fill(current_A.begin(), current_A.begin() + 101, -0.5);
    cases.push_back(
        {curve.dump(), cell, UniformTimes(2001, 1.0), current_A, Hold::kForward, 1.0, false});
  }
  ExpectAgreement("curves", cases);
}

// Two solutions of the same record by the reference itself: its lfilter and its plain loop.
TEST(Reference, FilterAndPlainLoopOfTheReferenceAgree) {
  std::vector<Case> cases;
  for (const bool plain : {true, false}) {
    cases.push_back({plain ? "plain" : "filtered",
                     CellWith(10, true, 3),
                     UniformTimes(3001, 0.01),
                     SteppedCurrents(3001, 9.0, 14),
                     Hold::kBackward,
                     1.0,
                     plain});
  }
  ExpectAgreement("loops", cases);
}

}  // namespace
}  // namespace lipoid
