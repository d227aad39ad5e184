#include "model/battery/cell_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

TEST(CellFile, ShippedCellsAreThoseOfTheTables) {
  struct Row {
    const char* name;
    double alpha_C, beta, series_Ohm, branch_Ohm, branch_F;
  };
  // Tables 4.8-4.13; alpha of 4.12 and 4.13 corrected by a factor of 100.
  const Row rows[] = {{"gifi-600mAh-1", 1353.6, 0.1924, 0.1314, 2.3643e-5, 10.1739},
                      {"gifi-600mAh-2", 1355.5, 0.2038, 0.1316, 1.9728e-5, 10.1826},
                      {"gifi-600mAh-3", 1353.3, 0.1966, 0.1315, 1.0077e-5, 10.1325},
                      {"grepow-32Ah-1", 1.1586e5, 0.2074, 0.0016, 1.0238e-6, 500.0597},
                      {"grepow-32Ah-2", 1.1590e5, 0.1810, 0.0017, 4.5346e-6, 500.2820},
                      {"grepow-32Ah-3", 1.1603e5, 0.2018, 0.0017, 2.7461e-6, 500.9338}};
  ASSERT_EQ(ShippedCellNames().size(), std::size(rows));
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const Cell cell = LoadCell(row.name);
    EXPECT_EQ(cell.name, row.name);
    ASSERT_TRUE(cell.diffusion.has_value());
    EXPECT_EQ(cell.diffusion->alpha_C, row.alpha_C);
    EXPECT_EQ(cell.diffusion->beta_per_sqrt_s, row.beta);
    EXPECT_EQ(cell.series_resistance_Ohm.resistance_Ohm[0], row.series_Ohm);
    ASSERT_EQ(cell.branches.size(), 1U);
    EXPECT_EQ(cell.branches[0].resistance_Ohm.resistance_Ohm[0], row.branch_Ohm);
    EXPECT_EQ(cell.branches[0].capacitance_F, row.branch_F);
    EXPECT_EQ(cell.branches[0].time_constant_s, row.branch_Ohm * row.branch_F);
    EXPECT_TRUE(cell.open_circuit_voltage_assumed);
    EXPECT_EQ(cell.open_circuit_voltage(0.3), 3.74);
  }
}

// What a file may hold, all of it at once.
const char* const kFull = R"({
  "schema": "lipoid.cell/1",
  "name": "full",
  "series": 6,
  "parallel": 2,
  "capacity_Ah": 0.6,
  "cutoff_V": 3.0,
  "diffusion": {
    "alpha_C": 1353.6,
    "beta_per_sqrt_s": 0.1924,
    "terms": 12,
    "tail": false
  },
  "open_circuit_voltage": {
    "method": "linear",
    "soc": [-0.1, 0.3, 1.01],
    "voltage_V": [2.9, 3.7, 4.2],
    "assumed": true
  },
  "series_resistance_Ohm": {
    "soc": [0.1, 0.9],
    "resistance_Ohm": [0.2, 0.1]
  },
  "branches": [
    {
      "resistance_Ohm": 0.03,
      "capacitance_F": 1500.0
    },
    {
      "resistance_Ohm": {
        "soc": [0.5],
        "resistance_Ohm": [0.01]
      },
      "time_constant_s": 0.7
    }
  ],
  "run": {
    "seed": 7
  }
})";

TEST(CellFile, EverythingInTheFileIsRead) {
  const Cell cell = ParseCell(kFull, "full.json");
  EXPECT_EQ(cell.name, "full");
  EXPECT_EQ(cell.series, 6);
  EXPECT_EQ(cell.parallel, 2);
  EXPECT_EQ(cell.capacity_Ah, 0.6);
  EXPECT_EQ(cell.cutoff_V, 3.0);
  EXPECT_EQ(cell.alpha_C(), 1353.6);
  EXPECT_EQ(cell.diffusion->beta_per_sqrt_s, 0.1924);
  EXPECT_EQ(cell.diffusion->terms, 12);
  EXPECT_FALSE(cell.diffusion->tail);
  EXPECT_EQ(cell.open_circuit_voltage.method(), OcvMethod::kLinear);
  EXPECT_EQ(cell.open_circuit_voltage.soc(), (std::vector<double>{-0.1, 0.3, 1.01}));
  EXPECT_EQ(cell.open_circuit_voltage.voltage_V(), (std::vector<double>{2.9, 3.7, 4.2}));
  EXPECT_TRUE(cell.open_circuit_voltage_assumed);
  EXPECT_EQ(cell.series_resistance_Ohm.soc, (std::vector<double>{0.1, 0.9}));
  EXPECT_EQ(cell.series_resistance_Ohm.resistance_Ohm, (std::vector<double>{0.2, 0.1}));
  ASSERT_EQ(cell.branches.size(), 2U);
  EXPECT_EQ(cell.branches[0].capacitance_F, 1500.0);
  EXPECT_EQ(cell.branches[0].time_constant_s, 0.03 * 1500.0);
  EXPECT_FALSE(cell.branches[1].capacitance_F.has_value());
  EXPECT_EQ(cell.branches[1].time_constant_s, 0.7);
  EXPECT_EQ(cell.branches[1].resistance_Ohm.resistance_Ohm, (std::vector<double>{0.01}));
  EXPECT_EQ(cell.run->at("seed"), 7);
}

TEST(CellFile, ParametersAreThoseOfTheFile) {
  const Cell cell = ParseCell(kFull, "full.json");
  const auto parameters = cell.Parameters();
  EXPECT_TRUE(parameters.diffusion);
  EXPECT_EQ(parameters.alpha_C, 1353.6);
  EXPECT_EQ(parameters.beta_per_sqrt_s, 0.1924);
  EXPECT_EQ(parameters.terms, 12);
  EXPECT_FALSE(parameters.tail);
  ASSERT_EQ(parameters.branches.size(), 2U);
  EXPECT_EQ(parameters.branches[0].resistance_Ohm(0.5), 0.03);
  EXPECT_EQ(parameters.branches[0].time_constant_s, 45.0);
  EXPECT_DOUBLE_EQ(parameters.series_resistance_Ohm(0.5), 0.15);
  EXPECT_EQ(parameters.open_circuit_voltage(0.3), 3.7);
}

TEST(CellFile, NoDiffusionCountsTheNominalCapacity) {
  Json json = Json::parse(kFull);
  json["diffusion"] = nullptr;
  const Cell cell = ParseCell(json.dump(), "x.json");
  EXPECT_FALSE(cell.diffusion.has_value());
  EXPECT_EQ(cell.alpha_C(), 3600.0 * 0.6);
  EXPECT_FALSE(cell.Parameters().diffusion);
}

TEST(CellFile, OptionalKeysHaveDefaults) {
  Json json = Json::parse(kFull);
  for (const char* key : {"series", "parallel", "run"}) json.erase(key);
  json["open_circuit_voltage"].erase("assumed");
  const Cell cell = ParseCell(json.dump(), "x.json");
  EXPECT_EQ(cell.series, 1);
  EXPECT_EQ(cell.parallel, 1);
  EXPECT_FALSE(cell.open_circuit_voltage_assumed);
  EXPECT_EQ(cell.run, nullptr);
}

// Written and read again, every number has the same bits: awkward ones, in every form of the curve.
TEST(CellFile, RoundTripKeepsEveryBit) {
  std::mt19937_64 engine(13);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const std::string file = test::FreshFolder("cell_round_trip") + "/cell.json";
  for (int trial = 0; trial < 40; ++trial) {
    Cell cell;
    cell.name = "trial \"" + std::to_string(trial) + "\" \xC3\xA9";
    cell.series = 1 + trial % 7;
    cell.capacity_Ah = uniform(engine);
    cell.cutoff_V = 2.0 + uniform(engine);
    if (trial % 5 != 0) {
      cell.diffusion = Cell::Diffusion{.alpha_C = 1e5 * uniform(engine),
                                       .beta_per_sqrt_s = uniform(engine),
                                       .terms = trial,
                                       .tail = trial % 2 == 0};
    }
    std::vector<double> soc = {-uniform(engine)};
    std::vector<double> values;
    for (int k = 0; k < 6; ++k) soc.push_back(soc.back() + uniform(engine));
    for (int k = 0; k < 7; ++k) values.push_back(3.0 + uniform(engine) * 1e-3);
    switch (trial % 4) {
      case 0:
        cell.open_circuit_voltage = OpenCircuitVoltage::Linear(soc, values);
        break;
      case 1:
        cell.open_circuit_voltage = OpenCircuitVoltage::MonotoneCubic(soc, values);
        break;
      case 2:
        cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(soc[0], soc[1], values);
        break;
      default:
        cell.open_circuit_voltage = OpenCircuitVoltage::Fourier(
            soc[0], soc[1], 3.0 * uniform(engine), values, {1.0 / 3, 0, 5e-324, 1, 2, 3});
    }
    cell.series_resistance_Ohm = Resistance<double>(soc, values);
    cell.branches.push_back({.resistance_Ohm = uniform(engine),
                             .time_constant_s = 0.0,
                             .capacitance_F = uniform(engine)});
    cell.branches[0].time_constant_s =
        cell.branches[0].resistance_Ohm.resistance_Ohm[0] * *cell.branches[0].capacitance_F;
    cell.branches.push_back(
        {.resistance_Ohm = 0.1, .time_constant_s = uniform(engine), .capacitance_F = {}});
    cell.run = std::make_shared<const Json>(Json{{"seed", trial}, {"x", 0.1}});
    WriteCellFile(cell, file);
    const Cell again = LoadCell(file);
    EXPECT_EQ(CellToJson(again), CellToJson(cell)) << trial;
    for (int k = -20; k <= 120; ++k) {
      const double a = 0.01 * k;
      ASSERT_EQ(again.open_circuit_voltage(a), cell.open_circuit_voltage(a)) << trial << " " << a;
      ASSERT_EQ(again.series_resistance_Ohm(a), cell.series_resistance_Ohm(a)) << trial << " " << a;
    }
    EXPECT_EQ(again.branches[0].time_constant_s, cell.branches[0].time_constant_s);
    EXPECT_EQ(again.branches[1].time_constant_s, cell.branches[1].time_constant_s);
  }
}

// The text of the file with one piece replaced.
std::string Changed(const std::string& from, const std::string& to) {
  std::string text = kFull;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Refusal(const std::string& text) {
  return test::MessageOf<LoadError>([&] { (void)ParseCell(text, "x.json"); });
}

TEST(CellFile, WhatIsNoCellFileIsRefused) {
  EXPECT_EQ(Refusal("[1, 2]"),
            "x.json:1:1: error: /: expected a cell file, \"schema\": \"lipoid.cell/1\", found a "
            "list of 2");
  EXPECT_EQ(Refusal("{}"),
            "x.json:1:1: error: /: expected an object with the key 'schema', found an object");
  EXPECT_EQ(
      Refusal(Changed("cell/1", "cell/2")),
      "x.json:2:13: error: /schema: expected schema \"lipoid.cell/1\", found \"lipoid.cell/2\"");
  EXPECT_EQ(Refusal(""),
            "x.json:1:1: error: expected JSON, found a syntax error while parsing value - "
            "unexpected end of "
            "input; expected '[', '{', or a literal");
  EXPECT_EQ(Refusal(std::string(kFull).substr(0, 120)),
            "x.json:7:18: error: expected JSON, found a syntax error while parsing object - "
            "unexpected end of "
            "input; expected '}'");
  EXPECT_EQ(Refusal(Changed("\"series\": 6,", "\"series\": 6")),
            "x.json:5:12: error: expected JSON, found a syntax error while parsing object - "
            "unexpected string "
            "literal; expected '}'");
}

TEST(CellFile, EveryTruncatedFileIsRefused) {
  const std::string text = kFull;
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_THROW((void)ParseCell(text.substr(0, length), "x.json"), LoadError) << length;
  }
  EXPECT_NO_THROW((void)ParseCell(text, "x.json"));
}

TEST(CellFile, EveryRequiredKeyIsMissed) {
  const std::vector<std::vector<std::string>> required = {{"schema"},
                                                          {"name"},
                                                          {"capacity_Ah"},
                                                          {"cutoff_V"},
                                                          {"diffusion"},
                                                          {"diffusion", "alpha_C"},
                                                          {"diffusion", "beta_per_sqrt_s"},
                                                          {"diffusion", "terms"},
                                                          {"diffusion", "tail"},
                                                          {"open_circuit_voltage"},
                                                          {"open_circuit_voltage", "method"},
                                                          {"open_circuit_voltage", "soc"},
                                                          {"open_circuit_voltage", "voltage_V"},
                                                          {"series_resistance_Ohm"},
                                                          {"series_resistance_Ohm", "soc"},
                                                          {"branches"}};
  for (const auto& path : required) {
    Json json = Json::parse(kFull);
    std::string pointer = "/";
    if (path.size() == 1) {
      json.erase(path[0]);
    } else {
      json[path[0]].erase(path[1]);
      pointer += path[0];
    }
    const auto message = Refusal(json.dump());
    const auto expected = "error: " + pointer + ": expected an object with the key '" +
                          path.back() + "', found an object";
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  }
}

struct BadValue {
  const char* from;
  const char* to;
  const char* message;
};

TEST(CellFile, EveryBadValueIsRefusedWhereItStands) {
  const BadValue all[] = {
      {"\"name\": \"full\"", "\"name\": 3", "3:11: error: /name: expected a text, found 3"},
      {"\"name\"",
       "\"title\": 1, \"name\"",
       "3:3: error: /title: expected one of the keys schema, name, series, parallel, capacity_Ah, "
       "cutoff_V, "
       "diffusion, open_circuit_voltage, series_resistance_Ohm, branches, self_heating, "
       "charge_transfer, temperature, reference_degC, hysteresis, run, uncertainty, found 'title'"},
      {"\"series\": 6",
       "\"series\": 0",
       "4:13: error: /series: expected a whole number from 1 to 100000, found 0"},
      {"\"parallel\": 2",
       "\"parallel\": 2.5",
       "5:15: error: /parallel: expected a whole number, found 2.5"},
      {"\"capacity_Ah\": 0.6",
       "\"capacity_Ah\": 0",
       "6:18: error: /capacity_Ah: expected a number above 0 and at most 1000000000000, found 0"},
      {"\"capacity_Ah\": 0.6",
       "\"capacity_Ah\": NaN",
       "6:18: error: expected JSON, found a syntax error while parsing value - invalid literal; "
       "last read: "
       "'\"capacity_Ah\": N'"},
      {"\"capacity_Ah\": 0.6",
       "\"capacity_Ah\": 1e400",
       "6:18: error: expected a number that a double can hold, found 1e400"},
      {"\"cutoff_V\": 3.0",
       "\"cutoff_V\": -1",
       "7:15: error: /cutoff_V: expected a number from 0 to 1000000000000, found -1"},
      {"\"cutoff_V\": 3.0",
       "\"cutoff_V\": \"3.0\"",
       "7:15: error: /cutoff_V: expected a number, found \"3.0\""},
      {"\"cutoff_V\": 3.0,",
       "\"cutoff_V\": 3.0, \"cutoff_V\": 3.0,",
       "7:20: error: expected every key once, found 'cutoff_V' again"},
      {"1353.6",
       "0",
       "9:16: error: /diffusion/alpha_C: expected a number above 0 and at most 1000000000000, "
       "found 0"},
      {"1353.6",
       "1e13",
       "9:16: error: /diffusion/alpha_C: expected a number above 0 and at most 1000000000000, "
       "found 10000000000000.0"},
      {"0.1924",
       "0",
       "10:24: error: /diffusion/beta_per_sqrt_s: expected a number from 0.0001 to 1, found 0"},
      {"0.1924",
       "1e-300",
       "10:24: error: /diffusion/beta_per_sqrt_s: expected a number from 0.0001 to 1, found 1e-300"},
      {"0.1924",
       "1.5",
       "10:24: error: /diffusion/beta_per_sqrt_s: expected a number from 0.0001 to 1, found 1.5"},
      {"\"terms\": 12",
       "\"terms\": -1",
       "11:14: error: /diffusion/terms: expected a whole number from 0 to 1000, found -1"},
      {"\"terms\": 12",
       "\"terms\": 1001",
       "11:14: error: /diffusion/terms: expected a whole number from 0 to 1000, found 1001"},
      {"\"tail\": false",
       "\"tail\": 0",
       "12:13: error: /diffusion/tail: expected true or false, found 0"},
      {"\"tail\": false",
       "\"tail\": false, \"gamma\": 1",
       "12:20: error: /diffusion/gamma: expected one of the keys alpha_C, beta_per_sqrt_s, terms, "
       "tail, found "
       "'gamma'"},
      {"\"linear\"",
       "\"spline\"",
       "15:15: error: /open_circuit_voltage/method: expected linear, polynomial, fourier or "
       "monotone-cubic, found "
       "\"spline\""},
      {"\"linear\"",
       "\"monotone-cubic\"",
       "16:12: error: /open_circuit_voltage/soc: expected at least 4 states of charge, found a "
       "list of 3"},
      {"\"linear\"",
       "\"polynomial\"",
       "14:27: error: /open_circuit_voltage: expected an object with the key 'soc_range', found an "
       "object"},
      {"[-0.1, 0.3, 1.01]",
       "[-0.1]",
       "16:12: error: /open_circuit_voltage/soc: expected at least 2 states of charge, found a "
       "list of 1"},
      {"[-0.1, 0.3, 1.01]",
       "[-0.1, 0.3, 0.3]",
       "16:24: error: /open_circuit_voltage/soc/2: expected a number greater than the one before, "
       "found 0.3"},
      {"[-0.1, 0.3, 1.01]",
       "[-0.1, 0.3]",
       "17:18: error: /open_circuit_voltage/voltage_V: expected 2 voltages, found a list of 3"},
      {"3.7, 4.2",
       "null, 4.2",
       "17:24: error: /open_circuit_voltage/voltage_V/1: expected a number, found null"},
      {"\"assumed\": true",
       "\"assumed\": \"yes\"",
       "18:16: error: /open_circuit_voltage/assumed: expected true or false, found \"yes\""},
      {"[0.2, 0.1]",
       "[0.2, -0.1]",
       "22:29: error: /series_resistance_Ohm/resistance_Ohm/1: expected a number from 0 to "
       "1000000000000, found -0.1"},
      {"[0.2, 0.1]",
       "[0.2]",
       "22:23: error: /series_resistance_Ohm/resistance_Ohm: expected 2 resistances, found a list "
       "of 1"},
      {"[0.1, 0.9]",
       "[0.9, 0.1]",
       "21:18: error: /series_resistance_Ohm/soc/1: expected a number greater than the one before, "
       "found 0.1"},
      {"\"resistance_Ohm\": 0.03",
       "\"resistance_Ohm\": -0.03",
       "26:25: error: /branches/0/resistance_Ohm: expected a number from 0 to 1000000000000, "
       "found -0.03"},
      {"\"resistance_Ohm\": 0.03",
       "\"resistance_Ohm\": \"0.03\"",
       "26:25: error: /branches/0/resistance_Ohm: expected a number or a table of soc and "
       "resistance_Ohm, found "
       "\"0.03\""},
      {"\"capacitance_F\": 1500.0",
       "\"capacitance_F\": 1500.0, \"time_constant_s\": 45",
       "25:5: error: /branches/0: expected either capacitance_F or time_constant_s, found an "
       "object"},
      {"\"resistance_Ohm\": 0.03,\n      \"capacitance_F\": 1500.0",
       "\"resistance_Ohm\": 0.03",
       "25:5: error: /branches/0: expected either capacitance_F or time_constant_s, found an "
       "object"},
      {"\"capacitance_F\": 1500.0",
       "\"capacitance_F\": -1",
       "27:24: error: /branches/0/capacitance_F: expected a number from 0 to 1e+30, found -1"},
      {"\"time_constant_s\": 0.7",
       "\"capacitance_F\": 70",
       "34:24: error: /branches/1/capacitance_F: expected time_constant_s, found capacitance_F "
       "beside a table of "
       "resistances"},
      {"\"time_constant_s\": 0.7",
       "\"time_constant_s\": 0.7, \"tau\": 1",
       "34:31: error: /branches/1/tau: expected one of the keys resistance_Ohm, capacitance_F, "
       "time_constant_s, "
       "found 'tau'"},
      {"\"seed\": 7\n  }",
       "\"seed\": 7\n  }, \"run2\": 3",
       "39:6: error: /run2: expected one of the keys schema, name, series, parallel, capacity_Ah, "
       "cutoff_V, "
       "diffusion, open_circuit_voltage, series_resistance_Ohm, branches, self_heating, "
       "charge_transfer, temperature, reference_degC, hysteresis, run, uncertainty, found 'run2'; is it 'run'?"},
      {"{\n    \"seed\": 7\n  }",
       "[]",
       "37:10: error: /run: expected an object, found a list of 0"}};
  for (const BadValue& bad : all) {
    EXPECT_EQ(Refusal(Changed(bad.from, bad.to)), "x.json:" + std::string(bad.message));
  }
}

// The full cell with the two terms beyond the thesis.
Json WithTerms() {
  Json json = Json::parse(kFull);
  const Json run = json["run"];
  json.erase("run");
  json["self_heating"] = {{"time_constant_s", 300.0}, {"resistance_drop_Ohm_per_A2", 1e-5}};
  json["charge_transfer"] = {
      {"current_A", 0.5},
      {"resistance_Ohm", {{"soc", {0.0, 1.0}}, {"resistance_Ohm", {0.2, 0.1}}}}};
  json["run"] = run;
  return json;
}

TEST(CellFile, TheTwoTermsAreReadAndWrittenBack) {
  EXPECT_FALSE(ParseCell(kFull, "full.json").self_heating.has_value());
  EXPECT_FALSE(ParseCell(kFull, "full.json").charge_transfer.has_value());
  const Json json = WithTerms();
  const Cell cell = ParseCell(json.dump(2), "x.json");
  EXPECT_EQ(cell.self_heating->time_constant_s, 300.0);
  EXPECT_EQ(cell.self_heating->resistance_drop_Ohm_per_A2, 1e-5);
  EXPECT_EQ(cell.charge_transfer->current_A, 0.5);
  EXPECT_EQ(cell.charge_transfer->resistance_Ohm.soc, (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(cell.charge_transfer->resistance_Ohm.resistance_Ohm, (std::vector<double>{0.2, 0.1}));
  const auto parameters = cell.Parameters();
  EXPECT_EQ(parameters.self_heating->time_constant_s, 300.0);
  EXPECT_EQ(parameters.self_heating->resistance_drop_Ohm_per_A2, 1e-5);
  EXPECT_EQ(parameters.charge_transfer->current_A, 0.5);
  EXPECT_NEAR(parameters.charge_transfer->resistance_Ohm(0.25), 0.175, 1e-16);
  EXPECT_EQ(CellToJson(cell).dump(2), json.dump(2));
  Json number = json;
  number["charge_transfer"]["resistance_Ohm"] = 0.07;
  EXPECT_EQ(CellToJson(ParseCell(number.dump(), "x.json")).dump(2), number.dump(2));
}

// The full cell with what its estimates may be off by: a rate, a constant, nodes of two tables.
Json WithUncertainty() {
  Json json = Json::parse(kFull);
  json["uncertainty"] = {{"parameters", {"beta", "r_1", "r_s[1]", "v_oc[0]"}},
                         {"covariance",
                          {{1e-4, 0.0, 1.0 / 3e6, 0.0},
                           {0.0, 0.0, 0.0, 0.0},
                           {1.0 / 3e6, 0.0, 1e-6, -1e-6},
                           {0.0, 0.0, -1e-6, 4e-6}}},
                         {"degrees_of_freedom", 12.5}};
  return json;
}

TEST(CellFile, UncertaintyIsReadAndWrittenBack) {
  EXPECT_FALSE(ParseCell(kFull, "full.json").uncertainty.has_value());
  Json json = WithUncertainty();
  const Cell cell = ParseCell(json.dump(2), "x.json");
  ASSERT_TRUE(cell.uncertainty.has_value());
  EXPECT_EQ(cell.uncertainty->parameters,
            (std::vector<std::string>{"beta", "r_1", "r_s[1]", "v_oc[0]"}));
  EXPECT_EQ(cell.uncertainty->covariance[2], (std::vector<double>{1.0 / 3e6, 0.0, 1e-6, -1e-6}));
  EXPECT_EQ(cell.uncertainty->degrees_of_freedom, 12.5);
  EXPECT_FALSE(cell.uncertainty->soc_follows_alpha);
  EXPECT_EQ(CellToJson(cell).dump(2), json.dump(2));
  json["uncertainty"]["soc_follows_alpha"] = true;
  EXPECT_TRUE(ParseCell(json.dump(), "x.json").uncertainty->soc_follows_alpha);
  EXPECT_EQ(CellToJson(ParseCell(json.dump(), "x.json")).dump(2), json.dump(2));
  const std::string file = test::FreshFolder("cell_uncertainty") + "/cell.json";
  WriteCellFile(cell, file);
  EXPECT_EQ(CellToJson(LoadCell(file)), CellToJson(cell));
  Cell wrong = cell;
  wrong.uncertainty->covariance[0][0] = std::nan("");
  EXPECT_THROW(WriteCellFile(wrong, file), PreconditionError);
}

TEST(CellFile, EveryBadUncertaintyIsRefusedWhereItStands) {
  struct {
    const char* pointer;
    Json value;
    const char* message;
  } const all[] = {
      {"/uncertainty", 3, "/uncertainty: expected an object, found 3"},
      {"/uncertainty/sigma",
       1,
       "/uncertainty/sigma: expected one of the keys parameters, covariance, degrees_of_freedom, "
       "soc_follows_alpha, found 'sigma'"},
      {"/uncertainty/parameters/1",
       "r_2",
       "/uncertainty/parameters/1: expected a parameter of this cell (alpha, beta, r_1, c_1, "
       "tau_1, tau_2) or a node of one of its tables, counted from 0 (r_s[0], v_oc[0]), found "
       "\"r_2\""},
      {"/uncertainty/parameters/2",
       "r_s[2]",
       "/uncertainty/parameters/2: expected a parameter of this cell (alpha, beta, r_1, c_1, "
       "tau_1, tau_2) or a node of one of its tables, counted from 0 (r_s[0], v_oc[0]), found "
       "\"r_s[2]\""},
      {"/uncertainty/parameters/3",
       "beta",
       "/uncertainty/parameters/3: expected every parameter once, found \"beta\""},
      {"/uncertainty/parameters/3", 7, "/uncertainty/parameters/3: expected a text, found 7"},
      {"/uncertainty/parameters",
       {"c_1", "tau_1", "r_1", "beta"},
       "/uncertainty/parameters/1: expected no tau_1 beside c_1, found \"tau_1\""},
      {"/uncertainty/parameters",
       {"tau_1", "c_1", "r_1", "beta"},
       "/uncertainty/parameters/1: expected no c_1 beside tau_1, found \"c_1\""},
      {"/uncertainty/covariance",
       {{1.0}},
       "/uncertainty/covariance: expected 4 rows, one for each parameter, found a list of 1"},
      {"/uncertainty/covariance/1",
       {0, 0, 0},
       "/uncertainty/covariance/1: expected 4 numbers, as there are rows, found a list of 3"},
      {"/uncertainty/covariance/1/1",
       -1e-9,
       "/uncertainty/covariance/1/1: expected a variance from 0 to 1e+24, found -1e-09"},
      {"/uncertainty/covariance/1/1",
       1e25,
       "/uncertainty/covariance/1/1: expected a variance from 0 to 1e+24, found 1e+25"},
      {"/uncertainty/covariance/3/3",
       nullptr,
       "/uncertainty/covariance/3/3: expected a number, found null"},
      {"/uncertainty/covariance/3/2",
       1e-6,
       "/uncertainty/covariance/3/2: expected a symmetric matrix, -1e-06 as in row 2 and column "
       "3, found 1e-06"},
      // A variance of zero allows no covariance.
      {"/uncertainty/covariance/1/0",
       1e-9,
       "/uncertainty/covariance/1/0: expected a symmetric matrix, 0 as in row 0 and column 1, "
       "found 1e-09"},
      {"/uncertainty/covariance",
       {{1, 0, 2, 0}, {0, 1, 0, 0}, {2, 0, 1, 0}, {0, 0, 0, 1}},
       "/uncertainty/covariance/2/0: expected a covariance of at most 1 in size, the root of both "
       "variances' product, found 2"},
      // Correlations of -0.9 of each of three with each other cannot be.
      {"/uncertainty/covariance",
       {{1, -0.9, -0.9, 0}, {-0.9, 1, -0.9, 0}, {-0.9, -0.9, 1, 0}, {0, 0, 0, 1}},
       "/uncertainty/covariance: expected a covariance, which gives no combination of parameters "
       "a negative variance, found one of correlations with the eigenvalue -0.8"},
      {"/uncertainty/degrees_of_freedom",
       0.5,
       "/uncertainty/degrees_of_freedom: expected a number from 1 to 1000000000000, found 0.5"},
      {"/uncertainty/soc_follows_alpha",
       1,
       "/uncertainty/soc_follows_alpha: expected true or false, found 1"}};
  for (const auto& bad : all) {
    Json json = WithUncertainty();
    json[Json::json_pointer(bad.pointer)] = bad.value;
    const std::string message = Refusal(json.dump());
    EXPECT_EQ(message.substr(message.find("error: ") + 7), bad.message);
  }
  for (const char* key : {"parameters", "covariance", "degrees_of_freedom"}) {
    Json json = WithUncertainty();
    json["uncertainty"].erase(key);
    const std::string expected = "/uncertainty: expected an object with the key '";
    EXPECT_NE(Refusal(json.dump()).find(expected + key + "'"), std::string::npos) << key;
  }
}

// What a fit leaves of a direction is rounding: half a part in a hundred million is let pass.
TEST(CellFile, RoundingOfACovarianceIsNoMistake) {
  Json json = WithUncertainty();
  json["uncertainty"]["parameters"] = {"beta", "r_1", "tau_1"};
  const double off = 1.0 + 5e-9;
  json["uncertainty"]["covariance"] = {{1, off, 1}, {1, 1, 1}, {1, 1, off}};
  EXPECT_NO_THROW((void)ParseCell(json.dump(), "x.json"));
}

TEST(CellFile, ATermThatIsAbsentIsNotWritten) {
  EXPECT_EQ(CellToJson(ParseCell(kFull, "full.json")).dump(2), Json::parse(kFull).dump(2));
  for (const auto& name : ShippedCellNames()) {
    const Json json = CellToJson(LoadCell(name));
    EXPECT_FALSE(json.contains("self_heating")) << name;
    EXPECT_FALSE(json.contains("charge_transfer")) << name;
  }
}

TEST(CellFile, EveryBadTermIsRefusedWhereItStands) {
  struct {
    const char* pointer;
    Json value;
    const char* message;
  } const all[] = {
      {"/self_heating/time_constant_s",
       0,
       "56:22: error: /self_heating/time_constant_s: expected a number above 0 and at most "
       "1000000000000, found 0"},
      {"/self_heating/resistance_drop_Ohm_per_A2",
       -1e-5,
       "57:33: error: /self_heating/resistance_drop_Ohm_per_A2: expected a number from 0 to "
       "1000000000000, found -1e-05"},
      {"/self_heating/tau",
       1,
       "58:3: error: /self_heating/tau: expected one of the keys time_constant_s, "
       "resistance_drop_Ohm_per_A2, found 'tau'"},
      {"/self_heating",
       Json::object(),
       "55:18: error: /self_heating: expected an object with the key 'time_constant_s', found an "
       "object"},
      {"/self_heating", nullptr, "55:18: error: /self_heating: expected an object, found null"},
      {"/self_heating",
       {{"time_constant_s", 300}},
       "55:18: error: /self_heating: expected an object with the key "
       "'resistance_drop_Ohm_per_A2', found an object"},
      {"/charge_transfer/current_A",
       0,
       "60:16: error: /charge_transfer/current_A: expected a number above 0 and at most "
       "1000000000000, found 0"},
      {"/charge_transfer/resistance_Ohm",
       -0.1,
       "61:21: error: /charge_transfer/resistance_Ohm: expected a number from 0 to 1000000000000, "
       "found -0.1"},
      {"/charge_transfer/resistance_Ohm",
       "0.1",
       "61:21: error: /charge_transfer/resistance_Ohm: expected a number or a table of soc and "
       "resistance_Ohm, found \"0.1\""},
      {"/charge_transfer/resistance_Ohm/resistance_Ohm/1",
       -0.1,
       "68:5: error: /charge_transfer/resistance_Ohm/resistance_Ohm/1: expected a number from 0 "
       "to 1000000000000, found -0.1"},
      {"/charge_transfer",
       {{"resistance_Ohm", 0.1}},
       "59:21: error: /charge_transfer: expected an object with the key 'current_A', found an "
       "object"},
      {"/charge_transfer",
       {{"current_A", 0.1}},
       "59:21: error: /charge_transfer: expected an object with the key 'resistance_Ohm', found "
       "an object"},
      {"/charge_transfer/i_0",
       1,
       "71:3: error: /charge_transfer/i_0: expected one of the keys current_A, resistance_Ohm, "
       "found 'i_0'"}};
  for (const auto& bad : all) {
    Json json = WithTerms();
    json[Json::json_pointer(bad.pointer)] = bad.value;
    EXPECT_EQ(Refusal(json.dump(1)), "x.json:" + std::string(bad.message));
  }
}

// The full cell, which has two branches, in the cold and in charge.
Json WithTemperature() {
  Json json = Json::parse(kFull);
  const Json run = json["run"];
  json.erase("run");
  json["temperature"] = {
      {"reference_degC", 23.0},
      {"activation_energy_J_per_mol",
       {{"series", 14000.0}, {"branches", {60000.0, 30000.0}}, {"diffusion", 35000.0}}},
      {"heat_capacity_J_per_K", 15.0},
      {"thermal_resistance_K_per_W", 20.0},
      {"entropy", {{"soc", {0.0, 1.0}}, {"slope_V_per_K", {-2e-4, 1e-4}}}},
      {"assumed", true},
      {"seen_degC", {-20.0, 35.5}}};
  json["hysteresis"] = {{"folds", 30.0},
                        {"half_V", {{"soc", {0.0, 1.0}}, {"half_V", {0.03, 0.01}}}}};
  json["run"] = run;
  return json;
}

TEST(CellFile, TemperatureAndHysteresisAreReadAndWrittenBack) {
  EXPECT_FALSE(ParseCell(kFull, "full.json").temperature.has_value());
  EXPECT_FALSE(ParseCell(kFull, "full.json").hysteresis.has_value());
  const Json json = WithTemperature();
  const Cell cell = ParseCell(json.dump(2), "x.json");
  const CellParameters<double> parameters = cell.Parameters();
  EXPECT_NEAR(parameters.temperature->reference_K, 296.15, 1e-12);
  EXPECT_EQ(parameters.temperature->series_J_per_mol, 14000.0);
  EXPECT_EQ(parameters.temperature->branches_J_per_mol, (std::vector<double>{60000.0, 30000.0}));
  EXPECT_EQ(parameters.temperature->diffusion_J_per_mol, 35000.0);
  EXPECT_EQ(parameters.temperature->charge_transfer_J_per_mol, 0.0);
  EXPECT_EQ(parameters.temperature->heat->heat_capacity_J_per_K, 15.0);
  EXPECT_EQ(parameters.temperature->heat->thermal_resistance_K_per_W, 20.0);
  EXPECT_NEAR((*parameters.temperature->entropy)(0.5), -5e-5, 1e-18);
  EXPECT_TRUE(cell.temperature_assumed);
  EXPECT_EQ(cell.temperature_seen, (TemperatureRange{-20.0, 35.5}));
  EXPECT_EQ(parameters.hysteresis->folds, 30.0);
  EXPECT_NEAR(parameters.hysteresis->Voltage(0.5, 1.0), 0.02, 1e-17);
  EXPECT_EQ(CellToJson(cell).dump(2), json.dump(2));
}

TEST(CellFile, EveryBadTemperatureIsRefusedWhereItStands) {
  struct {
    const char* pointer;
    Json value;
    const char* message;
  } const all[] = {
      {"/temperature/reference_degC",
       296,
       "/temperature/reference_degC: expected a number from -60 to 150, found 296"},
      {"/temperature/seen_degC",
       Json::array({25.0}),
       "/temperature/seen_degC: expected two temperatures, the coldest and the warmest, found a list of 1"},
      {"/temperature/seen_degC",
       Json::array({25.0, 0.0}),
       "/temperature/seen_degC: expected the coldest temperature before the warmest, found a list of 2"},
      {"/temperature/seen_degC",
       Json::array({253.0, 298.0}),
       "/temperature/seen_degC/0: expected a number from -60 to 150, found 253"},
      {"/temperature/activation_energy_J_per_mol/series",
       -1,
       "/temperature/activation_energy_J_per_mol/series: expected a number from 0 to 200000, found "
       "-1"},
      {"/temperature/activation_energy_J_per_mol/branches",
       Json::array({1.0}),
       "/temperature/activation_energy_J_per_mol/branches: expected 2 energies, one for each "
       "branch, found a list of 1"},
      {"/temperature/heat_capacity_J_per_K",
       0,
       "/temperature/heat_capacity_J_per_K: expected a number above 0 and at most 1000000000000, "
       "found 0"},
      {"/temperature/entropy/slope_V_per_K",
       Json::array({0.0, 1e308}),
       "/temperature/entropy/slope_V_per_K/1: expected a number from -1000000000000 to "
       "1000000000000, found 1e+308"},
      {"/reference_degC",
       20.0,
       "/reference_degC: expected no reference_degC beside temperature, which holds the one of this cell, found "
       "one"},
      {"/hysteresis/half_V",
       1e308,
       "/hysteresis/half_V: expected a number from 0 to 1000000000000, found 1e+308"},
      {"/self_heating",
       {{"time_constant_s", 300.0}, {"resistance_drop_Ohm_per_A2", 1e-5}},
       "/temperature: expected one of temperature and self_heating, which are two laws for one "
       "thing, found both"},
      {"/hysteresis/folds",
       0,
       "/hysteresis/folds: expected a number above 0 and at most 1000000000000, found 0"},
      {"/hysteresis/half_V/half_V",
       Json::array({0.01}),
       "/hysteresis/half_V/half_V: expected 2 voltages, found a list of 1"}};
  for (const auto& bad : all) {
    Json json = WithTemperature();
    json[Json::json_pointer(bad.pointer)] = bad.value;
    const std::string refusal = Refusal(json.dump(1));
    EXPECT_NE(refusal.find(std::string("error: ") + bad.message), std::string::npos) << refusal;
  }
  Json half = WithTemperature();
  half["temperature"].erase("heat_capacity_J_per_K");
  EXPECT_NE(Refusal(half.dump(1))
                .find("/temperature: expected both or none of heat_capacity_J_per_K and "
                      "thermal_resistance_K_per_W"),
            std::string::npos);
}

// Where a cell knows no temperature its file may say at which it was identified.
TEST(CellFile, KeepsTheTemperatureOfTheLogsOfACellThatKnowsNone) {
  EXPECT_FALSE(ParseCell(kFull, "full.json").reference_degC);
  Json json = CellToJson(ParseCell(kFull, "full.json"));
  json["reference_degC"] = 40.5;
  const Cell cell = ParseCell(json.dump(), "x.json");
  EXPECT_EQ(cell.reference_degC, 40.5);
  EXPECT_EQ(CellToJson(cell).at("reference_degC"), 40.5);
  json["reference_degC"] = 313.0;
  EXPECT_NE(
      Refusal(json.dump(1)).find("/reference_degC: expected a number from -60 to 150, found 313"),
      std::string::npos);
}

TEST(CellFile, ATermThatIsNotFiniteIsNotWritten) {
  const std::string file = test::FreshFolder("cell_not_finite") + "/never.json";
  const Cell whole = ParseCell(WithTerms().dump(), "x.json");
  const auto refusal = [&](auto&& change) {
    Cell cell = whole;
    change(cell, std::nan(""));
    EXPECT_THROW(WriteCellFile(cell, file), PreconditionError);
    EXPECT_FALSE(std::filesystem::exists(file));
  };
  refusal([](Cell& cell, double nan) { cell.self_heating->time_constant_s = nan; });
  refusal([](Cell& cell, double nan) { cell.self_heating->resistance_drop_Ohm_per_A2 = nan; });
  refusal([](Cell& cell, double nan) { cell.charge_transfer->current_A = nan; });
  refusal([](Cell& cell, double nan) { cell.charge_transfer->resistance_Ohm = nan; });
}

TEST(CellFile, EveryBadSeriesIsRefused) {
  const auto with_curve = [](const std::string& curve) {
    Json json = Json::parse(kFull);
    json["open_circuit_voltage"] = Json::parse(curve);
    return Refusal(json.dump(1));
  };
  EXPECT_EQ(
      with_curve(
          R"({"method": "polynomial", "soc_range": [0], "basis": "chebyshev", "coefficients_V": [3]})"),
      "x.json:16:16: error: /open_circuit_voltage/soc_range: expected two states of charge, found "
      "a list of 1");
  EXPECT_EQ(
      with_curve(
          R"({"method": "polynomial", "soc_range": [1, 0], "basis": "chebyshev", "coefficients_V": [3]})"),
      "x.json:18:4: error: /open_circuit_voltage/soc_range/1: expected a number greater than the "
      "one before, "
      "found 0");
  EXPECT_EQ(
      with_curve(
          R"({"method": "polynomial", "soc_range": [0, 1], "basis": "powers", "coefficients_V": [3]})"),
      "x.json:20:12: error: /open_circuit_voltage/basis: expected chebyshev, found \"powers\"");
  EXPECT_EQ(
      with_curve(
          R"({"method": "polynomial", "soc_range": [0, 1], "basis": "chebyshev", "coefficients_V": []})"),
      "x.json:21:21: error: /open_circuit_voltage/coefficients_V: expected at least one "
      "coefficient, found a "
      "list of 0");
  EXPECT_EQ(
      with_curve(
          R"({"method": "fourier", "soc_range": [0, 1], "frequency_rad": 2, "cosine_V": [3], "sine_V": [1]})"),
      "x.json:24:13: error: /open_circuit_voltage/sine_V: expected one coefficient less than "
      "cosine_V, found a list "
      "of 1");
  EXPECT_EQ(
      with_curve(
          R"({"method": "fourier", "soc_range": [0, 1], "frequency_rad": -2, "cosine_V": [3], "sine_V": []})"),
      "x.json:20:20: error: /open_circuit_voltage/frequency_rad: expected a number from 0 to "
      "1000000000000, found -2");
  EXPECT_EQ(
      with_curve(
          R"({"method": "fourier", "soc_range": [0, 1], "soc": [], "frequency_rad": 2, "cosine_V": [3],
                           "sine_V": []})"),
      "x.json:20:3: error: /open_circuit_voltage/soc: expected one of the keys method, assumed, "
      "soc_range, "
      "frequency_rad, cosine_V, sine_V, found 'soc'");
}

TEST(CellFile, WhatIsNoFileIsRefused) {
  const std::string folder = test::FreshFolder("cell_refusals");
  const auto refusal = [](const std::string& name) {
    return test::MessageOf<LoadError>([&] { (void)LoadCell(name); });
  };
  EXPECT_EQ(refusal(folder + "/none.json"),
            folder +
                "/none.json: error: expected a readable file, found none (No such file or "
                "directory)");
  EXPECT_EQ(refusal(folder), folder + ":1:1: error: expected a file, found a folder");
  EXPECT_EQ(refusal("gifi"),
            "gifi: error: expected a cell file or one of the shipped cells (gifi-600mAh-1, "
            "gifi-600mAh-2, "
            "gifi-600mAh-3, grepow-32Ah-1, grepow-32Ah-2, grepow-32Ah-3), found neither");
}

TEST(CellFile, FilesAreFoundByTheirName) {
  const std::string file = test::FreshFolder("cell_by_name") + "/mine.json";
  WriteFileAtomically(file, kFull);
  EXPECT_EQ(LoadCell(file).name, "full");
}

}  // namespace
}  // namespace lipoid
