#pragma once

/// @file
/// A cell whose tables lie on the nodes of a structure, and the same cell as the joint fit writes it:
/// structure, nonlinear unknowns, linear unknowns. Tests add the terms that they are about.

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "identify/joint/joint_model.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_model.h"

namespace lipoid::test {

struct JointExample {
  Cell cell;
  JointStructure structure;
  JointRates rates;
};

/// Two branches and charge transfer, with four nodes of every resistance.
inline JointExample ExampleOfTables() {
  JointExample e;
  e.cell = LoadCell("gifi-600mAh-1");
  e.structure.branches = 2;
  e.structure.resistance_soc = {0.05, 0.3, 0.6, 0.95};
  e.structure.voltage_soc = e.cell.open_circuit_voltage.soc();
  e.structure.charge_transfer = true;
  e.rates.beta_per_sqrt_s = 0.15;
  e.rates.time_constant_s = {8.0, 200.0};
  e.rates.charge_transfer_A = 1.3;
  const auto table = [&](double scale) {
    return Resistance<double>(e.structure.resistance_soc,
                              {1.7 * scale, 1.1 * scale, 0.9 * scale, 1.3 * scale});
  };
  e.cell.diffusion->beta_per_sqrt_s = e.rates.beta_per_sqrt_s;
  e.cell.series_resistance_Ohm = table(0.1);
  e.cell.branches = {{table(0.02), 8.0, {}}, {table(0.03), 200.0, {}}};
  e.cell.charge_transfer = Cell::ChargeTransfer{.current_A = 1.3, .resistance_Ohm = table(0.05)};
  return e;
}

/// Its cell as simulations step it, in a scalar that carries its derivatives: those in beta and in
/// both time constants stand at 0 to 2, that in i_0 where it is told.
template <class Jet>
CellParameters<Jet> DifferentiableTables(const Cell& cell, int of_transfer) {
  const CellParameters<double> p = cell.Parameters();
  const auto table = [](const Resistance<double>& r) {
    return Resistance<Jet>(r.soc, {r.resistance_Ohm.begin(), r.resistance_Ohm.end()});
  };
  CellParameters<Jet> jets;
  jets.alpha_C = Jet(p.alpha_C);
  jets.beta_per_sqrt_s = Jet(p.beta_per_sqrt_s, 0);
  jets.terms = p.terms;
  jets.tail = p.tail;
  jets.series_resistance_Ohm = table(p.series_resistance_Ohm);
  for (int j = 0; j < 2; ++j)
    jets.branches.push_back(
        {table(p.branches[j].resistance_Ohm), Jet(p.branches[j].time_constant_s, 1 + j)});
  jets.open_circuit_voltage = p.open_circuit_voltage;
  jets.charge_transfer = ChargeTransfer<Jet>{Jet(p.charge_transfer->current_A, of_transfer),
                                             table(p.charge_transfer->resistance_Ohm)};
  return jets;
}

inline void AddSelfHeating(JointExample& e) {
  e.structure.self_heating = true;
  e.rates.heating_time_constant_s = 400.0;
  e.cell.self_heating =
      Cell::SelfHeating{.time_constant_s = 400.0, .resistance_drop_Ohm_per_A2 = 1e-3};
}

inline JointSetup SetupOf(const Cell& cell) {
  return {.alpha_C = cell.alpha_C(),
          .diffusion = true,
          .terms = cell.diffusion->terms,
          .tail = cell.diffusion->tail,
          .open_circuit_voltage = cell.open_circuit_voltage};
}

/// The unknowns of the cell's tables, as JointLayout has them: v_oc is the reference.
inline Eigen::VectorXd UnknownsOf(const JointExample& e, double typical_A) {
  const JointLayout layout(e.structure);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(layout.size());
  const auto put = [&](int at, const Resistance<double>& r) {
    for (int k = 0; k < layout.nodes(); ++k) x[at + k] = r.resistance_Ohm[k] * typical_A;
  };
  put(layout.series(), e.cell.series_resistance_Ohm);
  for (int j = 0; j < e.structure.branches; ++j)
    put(layout.branch(j), e.cell.branches[static_cast<std::size_t>(j)].resistance_Ohm);
  put(layout.transfer(), e.cell.charge_transfer->resistance_Ohm);
  if (e.structure.self_heating) {
    x[layout.heating()] =
        e.cell.self_heating->resistance_drop_Ohm_per_A2 * std::pow(typical_A, 3.0);
  }
  for (int k = 0; k < layout.entropies(); ++k)
    x[layout.entropy() + k] = e.cell.temperature->entropy->slope_V_per_K[k] * kEntropyScale_K;
  for (int k = 0; k < layout.hystereses(); ++k)
    x[layout.hysteresis() + k] = e.cell.hysteresis->half_V[static_cast<std::size_t>(k)];
  return x;
}

}  // namespace lipoid::test
