// What the joint estimator makes of logs that know their temperature.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "identify/identification.h"
#include "identify/joint/heat_fit.h"
#include "identify/joint/joint_run.h"
#include "identify/joint/joint_trust.h"
#include "identify/trust/profile.h"
#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_model.h"
#include "model/battery/typical_temperature.h"
#include "tests/support/joint_example.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::kJointNoise_V;

using test::JointExample;
using test::SetupOf;
using test::UnknownsOf;

// A cell with every term that knows temperature, its tables on the nodes of the structure.
JointExample ExampleWithTemperature() {
  JointExample e = test::ExampleOfTables();
  e.structure.temperature = true;
  e.structure.entropy_soc = {0.0, 0.4, 1.0};
  e.rates.diffusion_J_per_mol = 35e3;
  e.rates.series_J_per_mol = 14e3;
  e.rates.branch_J_per_mol = {60e3, 30e3};
  e.rates.transfer_J_per_mol = 62e3;
  Cell::Temperature& term = e.cell.temperature.emplace();
  term.series_J_per_mol = 14e3;
  term.branches_J_per_mol = {60e3, 30e3};
  term.diffusion_J_per_mol = 35e3;
  term.charge_transfer_J_per_mol = 62e3;
  term.entropy = EntropySlope<double>{e.structure.entropy_soc, {-3e-4, 1e-4, 2e-4}};
  return e;
}

// Between -20 and 20 degC within one log, as fast as no cell does.
std::vector<LoadedLog> LogsOfChangingTemperature(const Cell& cell, double dt_s, std::size_t most) {
  auto logs = test::SyntheticLogs(cell, dt_s);
  for (auto& log : logs) {
    Record& r = log.log.record;
    const std::size_t rows = std::min(r.size(), most);
    for (auto* column : {&r.time_s, &r.current_A, &r.voltage_V}) column->resize(rows);
    for (const double time_s : r.time_s)
      r.temperature_degC.push_back(20.0 * std::sin(time_s / 900.0));
    r.voltage_V =
        Predict(cell, r.time_s, r.current_A, r.hold, 1.0, {.measured_degC = r.temperature_degC})
            .voltage_V;
  }
  return logs;
}

TEST(JointTemperature, RowsAreThoseOfTheCellModel) {
  const JointExample e = ExampleWithTemperature();
  const auto logs = LogsOfChangingTemperature(e.cell, 2.0, 2400);
  const JointSetup setup = SetupOf(e.cell);
  const JointLogs joint = MakeJointLogs(logs, setup.alpha_C, setup.open_circuit_voltage, {});
  EXPECT_NEAR(joint.warmest_K, 293.15, 0.1);
  const JointObservations seen(joint, setup);
  const auto rows = seen.Rows(e.structure, e.rates, UnknownsOf(e, joint.typical_A));
  for (std::size_t l = 0; l < rows.size(); ++l) {
    ASSERT_EQ(rows[l].time_s.size(), logs[l].log.record.size());
    // Rounding of sums of some ten terms of 4 V.
    EXPECT_LT(rows[l].residual_V.cwiseAbs().maxCoeff(), 1e-12) << joint.logs[l].file;
  }
}

// The cell that simulations step, in a scalar that carries its derivatives.
using EnergyJet = ceres::Jet<double, 9>;
CellParameters<EnergyJet> DifferentiableInEnergies(const JointExample& e) {
  const CellParameters<double> p = e.cell.Parameters();
  CellParameters<EnergyJet> jets = test::DifferentiableTables<EnergyJet>(e.cell, 3);
  TemperatureDependence<EnergyJet>& term = jets.temperature.emplace();
  term.diffusion_J_per_mol = EnergyJet(p.temperature->diffusion_J_per_mol, 4);
  term.series_J_per_mol = EnergyJet(p.temperature->series_J_per_mol, 5);
  for (int j = 0; j < 2; ++j)
    term.branches_J_per_mol.emplace_back(p.temperature->branches_J_per_mol[j], 6 + j);
  term.charge_transfer_J_per_mol = EnergyJet(p.temperature->charge_transfer_J_per_mol, 8);
  const auto& slopes = p.temperature->entropy->slope_V_per_K;
  term.entropy =
      EntropySlope<EnergyJet>{p.temperature->entropy->soc, {slopes.begin(), slopes.end()}};
  return jets;
}

TEST(JointTemperature, SlopesAreThoseOfTheCellModel) {
  const JointExample e = ExampleWithTemperature();
  const RateSlots slots(e.structure);
  ASSERT_EQ(slots.size(), 9);
  const int of_jet[] = {slots.beta(),
                        slots.tau(0),
                        slots.tau(1),
                        slots.transfer(),
                        slots.diffusion_energy(),
                        slots.series_energy(),
                        slots.branch_energy(0),
                        slots.branch_energy(1),
                        slots.transfer_energy()};
  const auto logs = LogsOfChangingTemperature(e.cell, 5.0, 2000);
  const JointSetup setup = SetupOf(e.cell);
  const JointLogs joint = MakeJointLogs(logs, setup.alpha_C, setup.open_circuit_voltage, {});
  const JointObservations seen(joint, setup);
  const auto rows =
      seen.Rows(e.structure, e.rates, UnknownsOf(e, joint.typical_A), CurveSlope::kOfSegments);
  const CellModel<EnergyJet> model(DifferentiableInEnergies(e));
  for (std::size_t l = 0; l < rows.size(); ++l) {
    const JointLog& log = joint.logs[l];
    auto state = model.Relaxed(EnergyJet(1.0));
    typename CellModel<EnergyJet>::Step step;
    Eigen::VectorXd size = Eigen::VectorXd::Zero(9);
    Eigen::VectorXd off = size;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) {
        state.temperature_K = EnergyJet(log.HalfWay_K(k));
        model.MakeStep(log.time_s[k] - log.time_s[k - 1], state.temperature_K, step);
        model.Advance(state, EnergyJet(log.step_A[k]), step);
      }
      state.temperature_K = EnergyJet(log.temperature_K[k]);
      const EnergyJet voltage = model.Voltage(state, EnergyJet(log.current_A[k]));
      const auto slope = rows[l].sensitivity.row(static_cast<Eigen::Index>(k));
      for (int p = 0; p < 9; ++p) {
        size[p] = std::max(size[p], std::abs(voltage.v[p]));
        off[p] = std::max(off[p], std::abs(voltage.v[p] - slope[of_jet[p]]));
      }
    }
    // Sums of some thousand terms, each right to the last digits.
    for (int p = 0; p < 9; ++p) {
      EXPECT_LE(off[p], 1e-10 * size[p]) << log.file << " " << p;
      EXPECT_GT(size[p], 0.0) << p;
    }
  }
}

using test::ColdTruth;

// At the rows of a record, each step in ten parts: within one, the cell warms by a kelvin and more.
Prediction PredictInParts(const Cell& truth, const Record& record, double ambient_degC) {
  constexpr std::size_t kParts = 10;
  std::vector<double> time_s{record.time_s[0]};
  std::vector<double> current_A{record.current_A[0]};
  for (std::size_t k = 1; k < record.size(); ++k) {
    for (std::size_t part = 1; part <= kParts; ++part) {
      const double share = static_cast<double>(part) / kParts;
      time_s.push_back(record.time_s[k - 1] + share * (record.time_s[k] - record.time_s[k - 1]));
      current_A.push_back(record.current_A[k]);  // held backward
    }
  }
  const Prediction fine =
      Predict(truth, time_s, current_A, Hold::kBackward, 1.0, {.ambient_degC = ambient_degC});
  Prediction at;
  for (std::size_t k = 0; k < fine.voltage_V.size(); k += kParts) {
    at.voltage_V.push_back(fine.voltage_V[k]);
    at.temperature_degC.push_back(fine.temperature_degC[k]);
  }
  return at;
}

std::vector<LoadedLog> ClimateChamber(const Cell& truth,
                                      const std::vector<double>& ambients_degC,
                                      double noise_V,
                                      double chamber_rises_K = 0.0,
                                      double row_s = 20.0) {
  std::vector<LoadedLog> logs;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (const double ambient_degC : ambients_degC) {
    for (LoadedLog& log : test::SyntheticLogs(truth, row_s)) {
      Record& r = log.log.record;
      if (log.entry.kind == LogKind::kConstantCurrent) {  // a warm cell lasts longer
        const std::size_t longer = r.size() + r.size() / 3;
        while (r.size() < longer) {
          r.time_s.push_back(r.time_s.back() + row_s);
          r.current_A.push_back(r.current_A.back());
        }
      }
      Prediction at = PredictInParts(truth, r, ambient_degC);
      if (chamber_rises_K > 0.0) {  // from a third of the log on
        constexpr double kLag_s = 300.0;
        for (std::size_t k = 0; k < r.size(); ++k) {
          const double since_s = std::max(0.0, r.time_s[k] - r.time_s[r.size() / 3]);
          at.temperature_degC[k] += chamber_rises_K * -std::expm1(-since_s / kLag_s);
        }
        at = Predict(truth,
                     r.time_s,
                     r.current_A,
                     r.hold,
                     1.0,
                     {.measured_degC = at.temperature_degC, .ambient_degC = ambient_degC});
      }
      std::size_t rows = 0;
      while (rows < r.size() && at.voltage_V[rows] > truth.cutoff_V) ++rows;
      rows = std::min(rows + 1, r.size());
      r.voltage_V = at.voltage_V;
      r.temperature_degC = at.temperature_degC;
      for (auto* column : {&r.time_s, &r.current_A, &r.voltage_V, &r.temperature_degC})
        column->resize(rows);
      for (double& v : r.voltage_V) v += noise_V * noise(engine);
      for (double& t : r.temperature_degC) t += 0.02 * noise(engine);
      // As labs do: the slow discharge at room temperature, and one fast one at each.
      const bool room = ambient_degC == 25.0;
      if (!room && log.entry.kind == LogKind::kLowRate) continue;
      if (!room && log.entry.file == "cc_1C.csv") continue;
      logs.push_back(std::move(log));
    }
  }
  return logs;
}

bool SaysOfHeat(const JointResult& result) {
  return std::any_of(result.cautions.begin(), result.cautions.end(), [](const auto& caution) {
    return caution.starts_with("the heat balance is not to be believed");
  });
}

TEST(JointTemperature, FindsEnergiesAndHeatOfASyntheticCell) {
  const Cell truth = ColdTruth();
  const auto logs = ClimateChamber(truth, {25.0, 40.0, 10.0}, 0.0005);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  ASSERT_TRUE(result.cell.temperature);
  EXPECT_FALSE(result.cell.self_heating);
  const TrustReport trust = AssessJoint(result);
  struct Expected {
    const char* name;
    double value;
    double closeness;  // in J/mol, several of its interval: an interval must not be wide
  };
  for (const auto& [name, value, closeness] : {Expected{"E_s", 18e3, 500.0},
                                               Expected{"E_1", 45e3, 3000.0},
                                               Expected{"E_d", 30e3, 3000.0}}) {
    const QuantityTrust* found = FindQuantity(trust, name);
    ASSERT_NE(found, nullptr) << name;
    // Three standard errors: one campaign in a hundred lies outside.
    EXPECT_LE(std::abs(found->estimate - value), 1.5 * Reach95(*found)) << name;
    EXPECT_LE(std::abs(found->estimate - value), closeness) << name;
  }
  ASSERT_TRUE(result.heat);
  EXPECT_NEAR(result.heat->balance.heat_capacity_J_per_K, 15.0, 0.15);
  EXPECT_NEAR(result.heat->balance.thermal_resistance_K_per_W, 20.0, 0.15);
  EXPECT_LT(result.heat->rmse_K, 0.01 * result.heat->largest_rise_K);
  EXPECT_FALSE(SaysOfHeat(result));
  // The coldest log begins at 10 degC, the warmest at 40, and it warms; the thermometer has noise.
  ASSERT_TRUE(result.cell.temperature_seen);
  EXPECT_NEAR(result.cell.temperature_seen->coldest_degC, 10.0, 0.5);
  EXPECT_GT(result.cell.temperature_seen->warmest_degC, 40.0);
  EXPECT_LT(result.cell.temperature_seen->warmest_degC, 80.0);
}

TEST(JointTemperature, AHeatBalanceThatTheLogsContradictIsSaid) {
  const auto logs = ClimateChamber(ColdTruth(), {25.0, 10.0}, 0.0005, 20.0);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  EXPECT_TRUE(SaysOfHeat(result)) << result.heat->rmse_K << " of " << result.heat->largest_rise_K;
}

// Ensembles draw the heat balance, the activation energies and the slope of v_oc with all else.
TEST(JointTemperature, CellsThatAreDrawnDifferInHeatToo) {
  const Cell truth = ColdTruth();
  const auto logs = ClimateChamber(truth, {25.0, 40.0, 10.0}, 0.0005);
  IdentifyOptions options;
  options.joint.entropy = Presence::kOn;
  options.joint.branches = 1;
  const Identification found = Identify(test::CampaignOf(logs), logs, options);
  ASSERT_TRUE(found.cell.uncertainty);
  const auto& names = found.cell.uncertainty->parameters;
  for (const char* name : {"C_th", "R_th", "E_s", "E_1", "E_d", "dv_dT[0]"})
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  const auto& heat = *found.cell.temperature->heat;
  // What a file holds is read back.
  EXPECT_NO_THROW((void)ParseCell(CellToJson(found.cell).dump(), "cell.json"));
  constexpr int kDrawn = 400;
  double square = 0.0;
  for (const Cell& cell : DrawCells(found.cell, kDrawn, 1).cells) {
    square +=
        std::pow(cell.temperature->heat->heat_capacity_J_per_K - heat.heat_capacity_J_per_K, 2);
    EXPECT_NE(cell.temperature->entropy->slope_V_per_K[0],
              found.cell.temperature->entropy->slope_V_per_K[0]);
  }
  const double expected = found.joint->heat->heat_capacity_standard_error_J_per_K;
  const double freedom = found.cell.uncertainty->degrees_of_freedom;
  // Student's variance; 400 draws tell it to a tenth.
  EXPECT_NEAR(
      std::sqrt(square / kDrawn), expected * std::sqrt(freedom / (freedom - 2.0)), 0.2 * expected);
}

// Asked for at the end, tables of 13 nodes had followed the slope already.
TEST(JointTemperature, TheSlopeOfTheVoltageIsAskedForBeforeTablesFollowIt) {
  Cell truth = ColdTruth();
  truth.temperature->entropy =
      EntropySlope<double>{{0.0, 0.3, 0.6, 1.0}, {-2e-4, 2e-4, -1e-4, 1e-4}};
  const auto logs = ClimateChamber(truth, {25.0, 40.0, 5.0}, 0.0005, 0.0, 5.0);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  const JointStructure& found = result.choice.best.structure;
  EXPECT_EQ(found.nodes(), 1);
  EXPECT_EQ(found.branches, 1);
  EXPECT_FALSE(found.charge_transfer);
  ASSERT_TRUE(result.cell.temperature && result.cell.temperature->entropy);
  // Straight lines between other nodes than the truth's: a third of the largest slope.
  for (const double soc : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    EXPECT_NEAR((*result.cell.temperature->entropy)(soc), (*truth.temperature->entropy)(soc), 7e-5)
        << soc;
  }
  const auto& says = result.cautions;
  const auto limit = [](const std::string& one) {
    return one.starts_with("dv_oc/dT stands at its limit");
  };
  EXPECT_TRUE(std::none_of(says.begin(), says.end(), limit));
}

// More than any entropy: a thermometer that is off, or a cell that the logs do not share.
TEST(JointTemperature, ASlopeOfTheVoltageAtItsLimitIsSaid) {
  Cell truth = ColdTruth();
  truth.temperature->entropy = EntropySlope<double>{{0.0, 1.0}, {1.2e-3, 1.2e-3}};
  const auto logs = ClimateChamber(truth, {25.0, 40.0, 5.0}, 0.0005);
  JointOptions options;
  options.entropy = Presence::kOn;
  options.branches = 1;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
  const auto said =
      std::find_if(result.cautions.begin(), result.cautions.end(), [](const auto& one) {
        return one.starts_with("dv_oc/dT stands at its limit of 0.6 mV/K at A = ");
      });
  ASSERT_NE(said, result.cautions.end());
  EXPECT_NE(said->find("0.55"), std::string::npos) << *said;
}

// Pulses in the cold and a slow discharge in the warm, as cold campaigns have it: the resistances are said
// of the cold, where they are known, and what differs between the kinds is no entropy.
TEST(JointTemperature, ColdPulsesAreToldAtTheirOwnTemperature) {
  const Cell truth = ColdTruth();
  auto logs = ClimateChamber(truth, {25.0, 12.0}, 0.0005);
  std::erase_if(logs, [](const LoadedLog& log) {
    return log.entry.kind != LogKind::kLowRate && log.log.record.temperature_degC.front() > 18.0;
  });
  ASSERT_GT(logs.size(), 2U);
  JointOptions options;
  options.temperature = Presence::kOn;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
  double sum_degC = 0.0;
  double rows = 0.0;
  for (const LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kPulses) continue;
    for (const double degC : log.log.record.temperature_degC) sum_degC += degC;
    rows += static_cast<double>(log.log.record.size());
  }
  ASSERT_TRUE(result.cell.temperature);
  EXPECT_FALSE(result.cell.temperature->entropy);
  EXPECT_LT(result.logs.like_span_K, 10.0);
  const double told_degC = CelsiusOf(result.logs.told_K);
  EXPECT_EQ(told_degC, std::round(told_degC));
  EXPECT_NEAR(told_degC, sum_degC / rows, 1.0);  // the joint fit weighs blocks, not rows
  const TrustReport trust = AssessJoint(result);
  ASSERT_EQ(trust.resistance.size(), 3U);
  for (const PulseResistance& r : trust.resistance) {
    EXPECT_EQ(r.temperature_degC, told_degC);
    const std::vector<double> as_cold(2, told_degC);
    const Prediction pulse = Predict(truth,
                                     std::vector<double>{0.0, r.after_s},
                                     std::vector<double>{0.0, r.current_A},
                                     Hold::kBackward,
                                     r.soc,
                                     {.measured_degC = as_cold});
    const double truth_Ohm = (pulse.voltage_V[0] - pulse.voltage_V[1]) / r.current_A;
    // Half a per cent is what pulses of 20 s rows and 0.5 mV of noise tell of 10 s.
    EXPECT_NEAR(r.resistance_Ohm, truth_Ohm, 0.05 * truth_Ohm) << r.after_s;
    EXPECT_LT(r.high_Ohm - r.low_Ohm, 0.4 * truth_Ohm) << r.after_s;
  }
}

TEST(JointTemperature, OneTemperatureTellsNothingOfIt) {
  Cell truth = ColdTruth();
  truth.temperature->heat->heat_capacity_J_per_K = 1000.0;  // it hardly warms
  const auto logs = ClimateChamber(truth, {25.0}, 0.0005);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  EXPECT_FALSE(result.cell.temperature);
  bool said = false;
  for (const std::string& caution : result.cautions)
    said = said || caution.starts_with("activation energies are not identifiable: the logs lie");
  EXPECT_TRUE(said);
}

// A cell that warms by itself shows energies of a kind, and nobody sees that they were never tried.
TEST(JointTemperature, OneChamberTellsOnlyWhatWarmingDoes) {
  const auto says = [](const std::vector<LoadedLog>& logs) {
    IdentifyOptions options;
    options.joint.temperature = Presence::kOn;
    options.joint.branches = 1;
    const Identification found = Identify(test::CampaignOf(logs), logs, options);
    EXPECT_TRUE(found.cell.temperature);
    return std::any_of(
        found.joint->cautions.begin(), found.joint->cautions.end(), [](const std::string& caution) {
          return caution.find("the activation energies rest on how the cell warms by itself") !=
                 std::string::npos;
        });
  };
  EXPECT_TRUE(says(ClimateChamber(ColdTruth(), {25.0}, 0.0005)));
  EXPECT_FALSE(says(ClimateChamber(ColdTruth(), {25.0, 10.0}, 0.0005)));
}

// Energies are one where the truth has one, and each is then better known; and stay apart where they
// are.
TEST(JointTemperature, EnergiesAreSharedWhereTheLogsCannotTellThemApart) {
  for (const bool alike : {true, false}) {
    Cell truth = ColdTruth();
    if (alike) {
      Cell::Temperature& term = *truth.temperature;
      term.series_J_per_mol = term.branches_J_per_mol[0] = term.diffusion_J_per_mol = 35e3;
    }
    const auto logs = ClimateChamber(truth, {25.0, 40.0, 10.0}, 0.0005, 0.0, 5.0);
    const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
    ASSERT_TRUE(result.cell.temperature);
    const Cell::Temperature& found = *result.cell.temperature;
    const auto names = SharedEnergyNames(result.choice.best.structure, result.setup.diffusion);
    const Json file = CellToJson(result.cell)["temperature"];
    if (!alike) {
      EXPECT_TRUE(names.empty());
      EXPECT_FALSE(file.contains("shared_energies"));
      EXPECT_NE(found.series_J_per_mol, found.diffusion_J_per_mol);
      continue;
    }
    EXPECT_EQ(names, (std::vector<std::string>{"E_d", "E_s", "E_1"}));
    EXPECT_EQ(file["shared_energies"], Json({"diffusion", "series", "branches[0]"}));
    EXPECT_NO_THROW((void)ParseCell(CellToJson(result.cell).dump(), "cell.json"));
    EXPECT_EQ(found.series_J_per_mol, found.diffusion_J_per_mol);
    EXPECT_EQ(found.series_J_per_mol, found.branches_J_per_mol[0]);
    // The same logs with energies of their own.
    JointResult apart = result;
    JointStructure wanted = result.choice.best.structure;
    wanted.shared_energies = SharedEnergies::kNone;
    for (const TriedStructure& tried : result.choice.tried) {
      if (tried.solution.structure == wanted) apart.choice.best = tried.solution;
    }
    ASSERT_EQ(apart.choice.best.structure.shared_energies, SharedEnergies::kNone);
    const TrustReport one = AssessJoint(result);
    const TrustReport own = AssessJoint(apart);
    for (const char* name : {"E_d", "E_s", "E_1"}) {
      const QuantityTrust* shared = FindQuantity(one, name);
      ASSERT_NE(shared, nullptr) << name;
      EXPECT_LE(std::abs(shared->estimate - 35e3), 1.5 * Reach95(*shared)) << name;
      EXPECT_LT(shared->standard_error, FindQuantity(own, name)->standard_error) << name;
    }
  }
}

// The slope in one energy that all share is the sum of the slopes in each.
TEST(JointTemperature, TheSlopeInASharedEnergyIsTheSumOfThoseInEach) {
  const JointExample own = ExampleWithTemperature();
  const auto logs = LogsOfChangingTemperature(own.cell, 5.0, 2000);
  const JointSetup setup = SetupOf(own.cell);
  const JointLogs joint = MakeJointLogs(logs, setup.alpha_C, setup.open_circuit_voltage, {});
  const JointObservations seen(joint, setup);
  JointRates rates = own.rates;
  rates.diffusion_J_per_mol = rates.transfer_J_per_mol = 35e3;
  rates.branch_J_per_mol = {35e3, 35e3};
  for (const SharedEnergies which : {SharedEnergies::kAllButSeries, SharedEnergies::kAll}) {
    const bool all = which == SharedEnergies::kAll;
    rates.series_J_per_mol = all ? 35e3 : 14e3;
    JointStructure structure = own.structure;
    structure.shared_energies = which;
    JointRates shared;
    shared.beta_per_sqrt_s = rates.beta_per_sqrt_s;
    shared.time_constant_s = rates.time_constant_s;
    shared.charge_transfer_A = rates.charge_transfer_A;
    shared.shared_J_per_mol = 35e3;
    if (!all) shared.series_J_per_mol = 14e3;
    const Eigen::VectorXd x = UnknownsOf(own, joint.typical_A);
    const auto each = seen.Rows(own.structure, rates, x);
    const auto one = seen.Rows(structure, shared, x);
    const RateSlots from(own.structure);
    const RateSlots to(structure);
    for (std::size_t l = 0; l < each.size(); ++l) {
      EXPECT_EQ(one[l].residual_V, each[l].residual_V);
      Eigen::VectorXd sum = each[l].sensitivity.col(from.diffusion_energy()) +
                            each[l].sensitivity.col(from.branch_energy(0)) +
                            each[l].sensitivity.col(from.branch_energy(1)) +
                            each[l].sensitivity.col(from.transfer_energy());
      if (all) sum += each[l].sensitivity.col(from.series_energy());
      const Eigen::VectorXd found = one[l].sensitivity.col(to.diffusion_energy());
      // Five numbers in another order.
      EXPECT_LE((found - sum).cwiseAbs().maxCoeff(), 1e-14 * (1.0 + sum.cwiseAbs().maxCoeff()));
      EXPECT_GT(sum.cwiseAbs().maxCoeff(), 0.0);
    }
  }
}

bool Says(const JointResult& result, const std::string& words) {
  return std::any_of(
      result.cautions.begin(), result.cautions.end(), [&](const std::string& caution) {
        return caution.find(words) != std::string::npos;
      });
}

// One log among others has no thermometer: as warm as its surroundings it would bend every energy.
TEST(JointTemperature, ALogThatTellsItsSurroundingsAloneIsWarmedByTheHeatBalance) {
  const Cell truth = ColdTruth();
  auto logs = ClimateChamber(truth, {25.0, 40.0, 10.0}, kJointNoise_V);
  const auto fast = std::find_if(logs.begin(), logs.end(), [](const LoadedLog& log) {
    return log.entry.file == "cc_6C.csv" && log.log.record.temperature_degC.front() > 35.0;
  });
  ASSERT_NE(fast, logs.end());
  EXPECT_GT(fast->log.record.temperature_degC.back(), 50.0);
  fast->log.record.temperature_degC.clear();
  fast->entry.ambient_degC = 40.0;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  EXPECT_LT(result.rmse_V, 1.2 * kJointNoise_V);
  ASSERT_TRUE(result.cell.temperature);
  EXPECT_NEAR(result.cell.temperature->diffusion_J_per_mol, 30e3, 3000.0);
  EXPECT_NEAR(result.cell.temperature->series_J_per_mol, 18e3, 500.0);
  EXPECT_TRUE(Says(result,
                   "cc_6C.csv tells the temperature of the surroundings alone (ambient_degC): that "
                   "of the cell is predicted by its heat balance, up to "));
}

std::vector<LoadedLog> WithoutThermometer(std::vector<LoadedLog> logs) {
  for (LoadedLog& log : logs) {
    log.entry.ambient_degC = std::round(log.log.record.temperature_degC.front());
    log.log.record.temperature_degC.clear();
  }
  return logs;
}

// A chamber and no thermometer: cells that are as warm as the chamber while they warm by 30 K would have other
// parameters altogether.
TEST(JointTemperature, LogsThatAllTellTheirSurroundingsAloneAreWarmedAsATypicalCell) {
  const auto logs =
      WithoutThermometer(ClimateChamber(ColdTruth(), {25.0, 40.0, 10.0}, kJointNoise_V));
  // The structure of the truth: while the temperatures are still wrong, hundreds of others would fit better.
  const JointResult result =
      IdentifyJoint(test::CampaignOf(logs), logs, {}, {.branches = 1, .resistance_nodes = 1});
  ASSERT_TRUE(result.cell.temperature);
  const Cell::Temperature& found = *result.cell.temperature;
  EXPECT_NEAR(found.series_J_per_mol, 18e3, 2e3);
  EXPECT_NEAR(found.diffusion_J_per_mol, 30e3, 6e3);
  EXPECT_TRUE(Says(result, "that of the cell is predicted by a typical heat balance ("));
  EXPECT_FALSE(Says(result, "its temperature is not predicted"));
  // What was assumed is in the cell.
  const HeatBalance<double> typical = TypicalHeat(result.cell.capacity_Ah);
  ASSERT_TRUE(found.heat);
  EXPECT_NEAR(found.heat->heat_capacity_J_per_K,
              typical.heat_capacity_J_per_K,
              0.02 * typical.heat_capacity_J_per_K);
  EXPECT_TRUE(result.cell.heat_assumed);
  EXPECT_TRUE(CellToJson(result.cell).at("temperature").at("heat_assumed"));
  // And what is said of it is said of the cell of the file: by the temperatures that it predicts itself.
  ASSERT_EQ(result.fitted.size(), logs.size());
  for (std::size_t l = 0; l < logs.size(); ++l)
    EXPECT_EQ(Validate(result.cell, logs[l]).all.rmse, result.fitted[l].all.rmse);
  ASSERT_FALSE(result.constant_current.empty());
  for (const ConstantCurrentErrors& log : result.constant_current)
    EXPECT_LT(log.error_percent, 2.0) << log.current_A;
}

// In a fan or in a box a cell warms half as much as a typical one, or twice as much: its intervals know that.
TEST(JointTemperature, IntervalsCountThatAHeatBalanceWasAssumed) {
  int missed_without = 0;
  for (const double warmer : {0.5, 2.0}) {
    Cell truth = ColdTruth();
    truth.temperature->heat = TypicalHeat(truth.capacity_Ah);
    truth.temperature->heat->thermal_resistance_K_per_W *= warmer;
    const auto logs =
        WithoutThermometer(ClimateChamber(truth, {25.0, 40.0, 10.0}, kJointNoise_V, 0.0, 5.0));
    JointResult result =
        IdentifyJoint(test::CampaignOf(logs),
                      logs,
                      {},
                      {.branches = 1, .resistance_nodes = 1, .temperature = Presence::kOn});
    EXPECT_TRUE(Says(result, "half of which the intervals count as a standard error")) << warmer;
    const auto missed = [&] {
      int count = 0;
      const TrustReport trust = AssessJoint(result);
      for (const auto& [name, value] : {std::pair{"E_s", 18e3}, {"E_1", 45e3}, {"E_d", 30e3}}) {
        const QuantityTrust* found = FindQuantity(trust, name);
        EXPECT_NE(found, nullptr) << name;
        if (found != nullptr && !(found->low <= value && value <= found->high)) ++count;
      }
      return count;
    };
    EXPECT_EQ(missed(), 0) << warmer;
    result.choice.half_as_warm = {};
    missed_without += missed();
  }
  EXPECT_GT(missed_without, 0);
}

// Half as warm, the logs would have a beta beyond these bounds.
TEST(JointTemperature, TheFitToLogsHalfAsWarmKeepsTheBoundsThatWereGiven) {
  const auto logs =
      WithoutThermometer(ClimateChamber(ColdTruth(), {25.0, 40.0, 10.0}, kJointNoise_V, 0.0, 5.0));
  const JointOptions options{.branches = 1, .resistance_nodes = 1};
  const JointResult free = IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
  const double found = free.choice.best.rates.beta_per_sqrt_s;
  const double moved = free.choice.half_as_warm.rates.beta_per_sqrt_s;
  ASSERT_GT(std::abs(moved - found), 0.01 * found);
  const double edge = 0.5 * (found + moved);
  StagedGiven given;
  given.parameters.bounds["beta"] =
      moved > found ? std::pair{0.5 * found, edge} : std::pair{edge, 2.0 * found};
  const JointResult bounded = IdentifyJoint(test::CampaignOf(logs), logs, {}, options, given);
  EXPECT_NEAR(bounded.choice.half_as_warm.rates.beta_per_sqrt_s, edge, 1e-6 * edge);
}

// Where one log is silent temperature takes no part in any.
TEST(JointTemperature, ALogWithoutATemperatureIsNamed) {
  auto logs = ClimateChamber(ColdTruth(), {25.0, 10.0}, kJointNoise_V);
  logs.back().log.record.temperature_degC.clear();
  JointOptions options{.branches = 1, .resistance_nodes = 1};
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
  EXPECT_FALSE(result.cell.temperature);
  EXPECT_TRUE(Says(result,
                   "temperature takes no part, for " + logs.back().entry.file +
                       " tells none: ambient_degC says which it was"));
  for (LoadedLog& log : logs) log.log.record.temperature_degC.clear();
  EXPECT_FALSE(Says(IdentifyJoint(test::CampaignOf(logs), logs, {}, options), "tell"));
}

TEST(JointTemperature, IsRefusedWhereALogHasNone) {
  auto logs = test::SyntheticLogs(test::Truth(), 10.0);
  JointOptions options;
  options.temperature = Presence::kOn;
  EXPECT_THROW((void)IdentifyJoint(test::CampaignOf(logs), logs, {}, options), OptionError);
  for (LoadedLog& log : logs) log.entry.ambient_degC = 20.0;
  options.self_heating = Presence::kOn;
  EXPECT_THROW((void)IdentifyJoint(test::CampaignOf(logs), logs, {}, options), OptionError);
}

// A temperature that no parameter follows changes no bit of the result.
TEST(JointTemperature, AColumnAloneChangesNothing) {
  auto logs = test::SyntheticLogs(test::Truth(), 10.0, 0.0005);
  const Cell plain = IdentifyJoint(test::CampaignOf(logs), logs).cell;
  for (LoadedLog& log : logs) log.log.record.temperature_degC = Column(log.log.record.size(), 23.0);
  const Cell with = IdentifyJoint(test::CampaignOf(logs), logs).cell;
  EXPECT_EQ(with.reference_degC, 23.0);
  // Their run records differ in how long they took.
  Cell bare[] = {plain, with};
  for (Cell& cell : bare) {
    cell.run.reset();
    cell.reference_degC.reset();
  }
  EXPECT_EQ(CellToJson(bare[0]).dump(), CellToJson(bare[1]).dump());
}

}  // namespace
}  // namespace lipoid
