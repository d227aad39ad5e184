#include "identify/export/circuit_fit.h"

#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "identify/export/law_limits.h"
#include "identify/fit/bounded_quadratic.h"
#include "model/battery/soc_table.h"

namespace lipoid {
namespace {

constexpr int kNodes = 11;  // every tenth of the charge

// What the voltage of each row lacks to v_oc is linear in the resistances of all nodes: sums of the
// rows' normal equations, in blocks so that memory does not grow with the mission.
class LinearPart {
 public:
  LinearPart(const SingleCell& one, const EquivalentCircuit& shape)
      : one_(one), columns_(kNodes * (1 + static_cast<int>(shape.branches.size()))) {
    typical_Ohm_ = one.TypicalResistance();
  }

  // Fills in the resistances; false where there are none.
  bool Solve(EquivalentCircuit& circuit) const {
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(columns_, columns_);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(columns_);
    Sum(circuit, G, g);
    // Neighbours are drawn together, so little that only what the mission leaves open follows it.
    constexpr double kPull = 1e-3;
    constexpr double kRidge = 1e-9;
    const double size = G.trace() / columns_;
    if (!(size > 0.0)) return false;
    for (int block = 0; block < columns_; block += kNodes) {
      for (int k = block + 1; k < block + kNodes; ++k) {
        G(k, k) += kPull * size;
        G(k - 1, k - 1) += kPull * size;
        G(k, k - 1) -= kPull * size;
        G(k - 1, k) -= kPull * size;
      }
    }
    G.diagonal().array() += kRidge * size;
    constexpr double kLeastShare = 1e-3;
    const Eigen::VectorXd lower = Eigen::VectorXd::Constant(columns_, kLeastShare * typical_Ohm_);
    const auto found = MinimizeBoundedQuadratic(G, g, lower);
    if (!found.solved) return false;
    const auto nodes_of = [&](int block) {
      return std::vector<double>(found.x.data() + kNodes * block,
                                 found.x.data() + kNodes * (block + 1));
    };
    circuit.series_Ohm = nodes_of(0);
    for (std::size_t j = 0; j < circuit.branches.size(); ++j)
      circuit.branches[j].resistance_Ohm = nodes_of(1 + static_cast<int>(j));
    return true;
  }

 private:
  // Weights of the two nodes around a state of charge.
  struct Place {
    int node;
    double share;  // of the node after it
  };
  static Place PlaceOf(double soc) {
    const double at = std::clamp(soc, 0.0, 1.0) * (kNodes - 1);
    const int node = std::min(static_cast<int>(at), kNodes - 2);
    return {node, at - node};
  }

  void Sum(const EquivalentCircuit& circuit, Eigen::MatrixXd& G, Eigen::VectorXd& g) const {
    constexpr Eigen::Index kBlock = 512;
    Eigen::MatrixXd rows(kBlock, columns_);
    Eigen::VectorXd lacks(kBlock);
    Eigen::Index filled = 0;
    Eigen::VectorXd state = Eigen::VectorXd::Zero(columns_);  // the branches' part of a row
    const auto& mission = one_.mission;
    const auto flush = [&] {
      std::vector<Eigen::Index> used;
      for (Eigen::Index k = 0; k < columns_; ++k)
        if (!rows.col(k).head(filled).isZero(0.0)) used.push_back(k);
      const Eigen::MatrixXd part = rows(Eigen::seqN(0, filled), used);
      G(used, used) += part.transpose() * part;
      g(used) += part.transpose() * lacks.head(filled);
      filled = 0;
      // Nodes that were passed long ago are forgotten, and their columns are no longer used.
      constexpr double kForgotten_A = 1e-12;
      state = (state.array().abs() > kForgotten_A).select(state, 0.0);
    };
    double soc = 1.0;
    for (std::size_t k = 0; k < mission.time_s.size(); ++k) {
      const double before = soc;
      soc = 1.0 - one_.drawn_Ah[k] / circuit.capacity_Ah;
      if (k > 0) {
        const double flow_A = mission.FlowBefore_A(k);
        const double steps = std::max(1.0, std::ceil(std::abs(soc - before) / kLargestSocStep));
        const double dt_s = (mission.time_s[k] - mission.time_s[k - 1]) / steps;
        for (std::size_t j = 0; j < circuit.branches.size(); ++j) {
          const double share = -std::expm1(-dt_s / circuit.branches[j].time_constant_s);
          auto of_branch = state.segment(kNodes * (1 + static_cast<Eigen::Index>(j)), kNodes);
          for (double n = 0.0; n < steps; n += 1.0) {
            const Place place = PlaceOf(before + (soc - before) * (n + 0.5) / steps);
            of_branch *= 1.0 - share;
            of_branch[place.node] += share * (1.0 - place.share) * flow_A;
            of_branch[place.node + 1] += share * place.share * flow_A;
          }
        }
      }
      const Place place = PlaceOf(soc);
      rows.row(filled) = state.transpose();
      rows(filled, place.node) = (1.0 - place.share) * mission.current_A[k];
      rows(filled, place.node + 1) = place.share * mission.current_A[k];
      lacks[filled] = OverSoc(circuit.open_circuit.soc, circuit.open_circuit.voltage_V, soc) -
                      one_.reference.voltage_V[k];
      if (++filled == kBlock) flush();
    }
    flush();
  }

  const SingleCell& one_;
  int columns_;
  double typical_Ohm_;
};

}  // namespace

FittedCircuit FitCircuit(const SingleCell& one, int branches) {
  FittedCircuit fitted;
  EquivalentCircuit& shape = fitted.circuit;
  shape.capacity_Ah = UsableCapacity_Ah(one.cell);
  shape.open_circuit = ExtendedNodesOf(one.cell.open_circuit_voltage);
  for (int k = 0; k < kNodes; ++k) shape.soc.push_back(k / (kNodes - 1.0));
  shape.branches.resize(static_cast<std::size_t>(branches));
  const LinearPart linear(one, shape);
  // Logarithms of the time constants: of the first, and how much each is above the one before.
  const auto with = [&](const std::vector<double>& x) {
    EquivalentCircuit circuit = shape;
    double log_tau = 0.0;
    for (std::size_t j = 0; j < x.size(); ++j) {
      log_tau += x[j];
      circuit.branches[j].time_constant_s = std::exp(log_tau);
    }
    return circuit;
  };
  if (branches == 0) {
    fitted.projection.termination =
        linear.Solve(shape) ? Termination::kConverged : Termination::kFailure;
    fitted.projection.message = "The resistances are those of a linear problem.";
    return fitted;
  }
  const double duration_s = one.mission.time_s.back() - one.mission.time_s.front();
  const double longest = std::log(std::max(4.0 * kShortestTimeConstant_s, 0.5 * duration_s));
  const double shortest = std::log(kShortestTimeConstant_s);
  std::vector<FreeParameter> parameters = {{"tau_1", shortest, longest, 1.0}};
  std::vector<std::vector<double>> starts;
  if (branches == 1) {
    for (const double tau_s : {2.0, 10.0, 60.0}) starts.push_back({std::log(tau_s)});
  } else {
    // At least a factor of 1.5 apart: closer they are one branch.
    parameters.push_back({"tau_2", std::log(1.5), longest - shortest, 1.0});
    for (const auto& [fast_s, factor] : {std::pair{2.0, 10.0}, {5.0, 5.0}, {15.0, 8.0}})
      starts.push_back({std::log(fast_s), std::log(factor)});
  }
  const auto law = [&](const std::vector<double>& x) {
    EquivalentCircuit circuit = with(x);
    if (!linear.Solve(circuit)) return std::vector<double>(one.mission.time_s.size(), std::nan(""));
    return EquivalentCircuitVoltage(circuit, one.mission, one.drawn_Ah);
  };
  fitted.projection = Project(law, one.reference.voltage_V, parameters, starts);
  if (fitted.projection.termination != Termination::kFailure) {
    shape = with(fitted.projection.parameters);
    if (!linear.Solve(shape)) fitted.projection.termination = Termination::kFailure;
  }
  return fitted;
}

EquivalentCircuit NaiveCircuit(const Cell& cell, int branches) {
  EquivalentCircuit circuit;
  circuit.capacity_Ah = cell.capacity_Ah;
  circuit.open_circuit = ExtendedNodesOf(cell.open_circuit_voltage);
  for (int k = 0; k < kNodes; ++k) circuit.soc.push_back(k / (kNodes - 1.0));
  const auto table = [&](const Resistance<double>& resistance) {
    std::vector<double> values;
    for (const double soc : circuit.soc) values.push_back(resistance(soc));
    return values;
  };
  circuit.series_Ohm = table(cell.series_resistance_Ohm);
  for (const auto& branch : cell.branches) {
    constexpr double kShortest_s = 0.01;
    if (IsNegligible(cell, branch, kShortest_s)) {  // it acts at once
      const auto extra_Ohm = table(branch.resistance_Ohm);
      for (std::size_t k = 0; k < extra_Ohm.size(); ++k) circuit.series_Ohm[k] += extra_Ohm[k];
      continue;
    }
    if (static_cast<int>(circuit.branches.size()) >= branches) continue;
    circuit.branches.push_back({table(branch.resistance_Ohm), branch.time_constant_s});
  }
  return circuit;
}

std::optional<EquivalentCircuit> ReportCircuit(const ExportRequest& request, Exported& exported) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  FittedCircuit fitted = FitCircuit(one, request.branches);
  if (!Usable(fitted.projection, exported)) return std::nullopt;
  const EquivalentCircuit& circuit = fitted.circuit;
  // The law of one cell, the error of the pack.
  const auto error_of = [&](const EquivalentCircuit& law) {
    ExportError error = VoltageError(
        one.reference, one.mission, EquivalentCircuitVoltage(law, one.mission, one.drawn_Ah));
    error.rmse_V *= cell.series;
    error.max_error_V *= cell.series;
    for (double& law_V : error.law_V) law_V *= cell.series;
    return error;
  };
  exported.error = error_of(circuit);
  exported.naive = error_of(NaiveCircuit(cell, request.branches));
  exported.parameters = {{"capacity", circuit.capacity_Ah, "Ah"}};
  const auto add = [&](const std::string& name, const std::vector<double>& nodes) {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      exported.parameters.push_back(
          {fmt::format("{}({:g})", name, circuit.soc[k]), nodes[k], "Ohm"});
  };
  add("R0", circuit.series_Ohm);
  for (std::size_t j = 0; j < circuit.branches.size(); ++j) {
    exported.parameters.push_back(
        {fmt::format("tau{}", j + 1), circuit.branches[j].time_constant_s, "s"});
    add(fmt::format("R{}", j + 1), circuit.branches[j].resistance_Ohm);
  }
  exported.cannot_hold = LeftOut(request, {.branches = request.branches, .resistance_table = true});
  const auto& soc = one.reference.soc;
  const double lowest =
      1.0 - *std::max_element(one.drawn_Ah.begin(), one.drawn_Ah.end()) / circuit.capacity_Ah;
  exported.notes = {
      "The numbers are those of one cell; multiply volts by the cells in series and divide currents "
      "by those in parallel.",
      fmt::format("The mission reaches a state of charge of {:.3f} by charge ({:.3f} of the cell): "
                  "the resistances below that are those of the last node that it saw.",
                  lowest,
                  *std::min_element(soc.begin(), soc.end()))};
  if (cell.open_circuit_voltage_assumed)
    exported.notes.emplace_back("The cell's v_oc is a typical curve, not a measured one.");
  AddBoundNotes(fitted.projection, exported);
  return circuit;
}

std::string NumberList(const std::vector<double>& values) {
  return fmt::format("{}", fmt::join(values, ", "));
}

}  // namespace lipoid
