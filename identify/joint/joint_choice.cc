#include "identify/joint/joint_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

constexpr double kGain = 0.03;
constexpr double kBetterFit = 0.05;
constexpr double kAtTheNoise = 1.1;

const std::vector<double> kSmoothness{1e-4, 1e-3, 1e-2, 1e-1};
constexpr double kTypicalSmoothness = 1e-3;
constexpr std::size_t kUsualVoltageNodes = 80;  // VoltageNodes(0) has fewer

// Whether a richer structure is worth it. What fits as well as the noise lets it can only be
// overtaken by following the noise.
bool Better(const LeftOutErrors& rich, const LeftOutErrors& simple, double noise_V) {
  if (simple.fitted_V <= kAtTheNoise * noise_V) return false;
  if (rich.expected_V < (1.0 - kGain) * simple.expected_V) return true;
  return rich.expected_V < simple.expected_V &&
         rich.fitted_V < (1.0 - kBetterFit) * simple.fitted_V;
}

// Nodes at equal steps of t in [0, 1], bent so that they are dense near empty, where cells bend
// most, and again near full, where every log starts.
std::vector<double> Bent(int count) {
  std::vector<double> nodes;
  for (int k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / (count - 1);
    const double soc = 0.35 * t + 0.65 * t * t * (1.0 + 0.9 * (1.0 - t) * t);
    nodes.push_back(soc);
  }
  nodes.back() = 1.0;
  return nodes;
}

// Whether every term has a part in the answer.
bool Complete(const JointSolution& solution, const JointLogs& logs) {
  if (solution.x.size() == 0) return false;
  const JointLayout layout(solution.structure);
  constexpr double kNothing_V = 1e-6;
  const double scale = logs.typical_A / logs.largest_A;
  for (int t = 1; t < layout.tables(); ++t) {
    if (solution.x.segment(layout.table(t), layout.nodes()).maxCoeff() < kNothing_V * scale)
      return false;
  }
  return !solution.structure.self_heating || solution.x[layout.heating()] > 0.0;
}

// With a node more between any two.
std::vector<double> Halved(const std::vector<double>& nodes) {
  std::vector<double> fine;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    fine.push_back(nodes[k]);
    fine.push_back(0.5 * (nodes[k] + nodes[k + 1]));
  }
  fine.push_back(nodes.back());
  return fine;
}

std::string Describe(const JointStructure& s) {
  std::string text = s.nodes() == 1 ? "constant resistances" : fmt::format("{} nodes", s.nodes());
  text += fmt::format(", {} branch{}", s.branches, s.branches == 1 ? "" : "es");
  if (s.self_heating) text += ", self-heating";
  if (s.charge_transfer) text += ", charge transfer";
  if (s.voltage_soc.size() > kUsualVoltageNodes)
    text += fmt::format(", v_oc at {} nodes", s.voltage_soc.size());
  return text;
}

}  // namespace

std::vector<double> ResistanceNodes(int count) {
  if (count <= 1) return {0.5};
  static const std::vector<std::vector<double>> kLadder = {
      {0.0, 0.1, 0.2, 0.4, 0.7, 1.0},
      {0.0, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.85, 0.95, 1.0},
      {0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.125, 0.15, 0.175, 0.2,
       0.3, 0.4,  0.5,  0.6,  0.7,  0.8, 0.9,   0.95, 0.98,  1.0},
      {0.0,  0.01, 0.02, 0.03, 0.04,  0.05, 0.06, 0.07, 0.08, 0.09, 0.1, 0.12,
       0.14, 0.16, 0.18, 0.2,  0.225, 0.25, 0.3,  0.35, 0.4,  0.45, 0.5, 0.55,
       0.6,  0.65, 0.7,  0.75, 0.8,   0.85, 0.9,  0.95, 0.98, 1.0}};
  for (const auto& nodes : kLadder) {
    if (static_cast<int>(nodes.size()) == count) return nodes;
  }
  return count == 2 ? std::vector<double>{0.0, 1.0} : Bent(count);
}

std::vector<double> VoltageNodes(int count) {
  if (count == 0) {
    std::vector<double> nodes{-0.05, -0.02};
    for (int k = 0; k <= 8; ++k) nodes.push_back(0.005 * k);
    for (int k = 5; k <= 20; ++k) nodes.push_back(0.01 * k);
    for (int k = 11; k <= 48; ++k) nodes.push_back(0.02 * k);
    for (const double a : {0.97, 0.98, 0.985, 0.99, 0.995, 1.0}) nodes.push_back(a);
    return nodes;
  }
  return count <= 2 ? std::vector<double>{0.0, 1.0} : Bent(count);
}

std::vector<double> OnAxis(std::vector<double> nodes, double lowest_soc) {
  constexpr double kNearZero = 0.02;
  if (nodes.size() > 1 && std::abs(lowest_soc) > kNearZero) {
    for (double& a : nodes) a = 1.0 - (1.0 - a) * (1.0 - lowest_soc);
  }
  return nodes;
}

JointChoice ChooseStructure(const JointFit& fit,
                            const JointLogs& logs,
                            const std::vector<double>& voltage_soc,
                            double lowest_soc,
                            const JointOptions& options,
                            const std::function<void(double)>& progress) {
  JointChoice choice;
  std::vector<double> ladder = kSmoothness;
  if (options.smoothness > 0.0) ladder = {options.smoothness};
  const double rough = options.smoothness > 0.0 ? options.smoothness : kTypicalSmoothness;
  const bool compare = logs.groups >= 2;
  double done = 0.0;
  const auto tell = [&](double share) {
    done = std::max(done, share);
    if (progress) progress(done);
  };

  std::size_t taken = 0;
  const auto take = [&](std::size_t k) {
    taken = k;
    choice.best = choice.tried[k].solution;
    choice.errors = choice.tried[k].errors;
  };
  const auto better = [&](const LeftOutErrors& rich, const LeftOutErrors& simple) {
    return Better(rich, simple, logs.noise_mean_V);
  };
  // Judges the solution, and takes it where it is better than what was taken before.
  const auto judge = [&](const JointStructure& structure, JointSolution solution) {
    TriedStructure row{.what = Describe(structure), .solution = std::move(solution)};
    if (compare) {
      row.errors = fit.LeaveOut(structure, row.solution.rates, ladder);
    } else {
      row.errors.smoothness = rough;
    }
    const bool taking =
        choice.tried.empty() || (Complete(row.solution, logs) && better(row.errors, choice.errors));
    choice.tried.push_back(std::move(row));
    if (taking) take(choice.tried.size() - 1);
    tell(0.08 * static_cast<double>(choice.tried.size()));
  };
  const auto try_one = [&](const JointStructure& structure) {
    judge(structure, fit.Search(structure, rough, choice.tried.empty() ? nullptr : &choice.best));
  };

  const auto on = [&](int nodes) { return OnAxis(ResistanceNodes(nodes), lowest_soc); };
  JointStructure structure;
  structure.branches =
      options.branches >= 0 ? options.branches : std::min(1, options.most_branches);
  structure.voltage_soc = voltage_soc;
  structure.self_heating = options.self_heating == Presence::kOn;
  structure.charge_transfer = options.charge_transfer == Presence::kOn;
  const int given_nodes = options.resistance_nodes;
  structure.resistance_soc = on(given_nodes > 0 ? given_nodes : compare ? 13 : 1);
  try_one(structure);
  if (!compare) {
    choice.reason =
        "too few pulses and discharges to leave any out: the simplest structure is taken";
  } else {
    // The terms first: without them no number of nodes tells a cell that warms from one that does
    // not. Each alone, as one may stand in for the other; then both, if both helped.
    const bool free_heating = options.self_heating == Presence::kAuto;
    const bool free_transfer = options.charge_transfer == Presence::kAuto;
    const LeftOutErrors plain = choice.errors;
    bool both = free_heating && free_transfer;
    for (const bool heating : {false, true}) {
      if (!(heating ? free_heating : free_transfer)) continue;
      JointStructure richer = structure;
      (heating ? richer.self_heating : richer.charge_transfer) = true;
      try_one(richer);
      both = both && better(choice.tried.back().errors, plain);
    }
    if (both) {
      structure.self_heating = structure.charge_transfer = true;
      try_one(structure);
    }
    if (given_nodes == 0) {
      const std::size_t middle = taken;
      const JointStructure base = choice.best.structure;
      std::vector<std::size_t> by_nodes;
      for (const int nodes : {1, 13, 34}) {
        if (nodes == base.nodes()) {
          by_nodes.push_back(middle);
          continue;
        }
        JointStructure other = base;
        other.resistance_soc = on(nodes);
        try_one(other);
        by_nodes.push_back(choice.tried.size() - 1);
      }
      std::size_t best = by_nodes.front();
      for (const std::size_t k : by_nodes) {
        if (better(choice.tried[k].errors, choice.tried[best].errors)) best = k;
      }
      take(best);
    }
    while (options.branches < 0 && choice.best.structure.branches < options.most_branches) {
      JointStructure richer = choice.best.structure;
      ++richer.branches;
      try_one(richer);
      if (taken + 1 != choice.tried.size()) break;
    }
    // The nodes of v_oc do not move the rates: those found are kept.
    if (!voltage_soc.empty() && options.voltage_nodes == 0) {
      JointStructure finer = choice.best.structure;
      finer.voltage_soc = Halved(voltage_soc);
      JointSolution solution = fit.Solve(finer, choice.best.rates, rough);
      solution.termination = choice.best.termination;
      solution.message = choice.best.message;
      judge(finer, std::move(solution));
    }
  }
  choice.tried[taken].taken = true;
  // Where the model fits to within the noise of a row nothing needs smoothing, and what pulls the
  // last nodes of v_oc to the reference's shape would move alpha by a part in a hundred thousand.
  if (compare && options.smoothness == 0.0 && choice.errors.fitted_V <= logs.noise_V)
    choice.errors.smoothness = kNoSmoothness;
  // The last polish follows the fit; where rows left out are predicted worse for it, it followed
  // noise along a flat valley.
  JointSolution before =
      fit.Solve(choice.best.structure, choice.best.rates, choice.errors.smoothness);
  before.at_bound = choice.best.at_bound;
  before.termination = choice.best.termination;
  before.message = choice.best.message;
  JointSolution polished = fit.Polish(before, kFineStep, options.iterations_per_variable);
  if (compare) {
    const LeftOutErrors errors =
        fit.LeaveOut(polished.structure, polished.rates, {choice.errors.smoothness});
    if (errors.expected_V > choice.errors.expected_V) {
      polished = std::move(before);
    } else {
      choice.errors = errors;
    }
  }
  choice.best = std::move(polished);
  tell(1.0);
  return choice;
}

}  // namespace lipoid
