#include "identify/joint/joint_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/fit/cell_of_solution.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/exact_hold.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

constexpr double kGain = 0.03;
constexpr double kBetterFit = 0.05;
constexpr double kAtTheNoise = 1.1;
// No cycler resolves less, and no term is asked for by less: the logs of a simulation have no noise.
constexpr double kFinest_V = 1e-5;
// A branch whose resistance is below this share of r_s may be none. Others are plainly there, and a fit
// without them would cost its time for nothing.
constexpr double kSlight = 0.05;

const std::vector<double> kSmoothness{1e-4, 1e-3, 1e-2, 1e-1};
// Of the ratio to a shape that is held: little more than a factor is left. A short test cannot choose it:
// what it prefers where it went is no shape for where it did not go.
constexpr double kTypicalOfHeld = 1.0;
constexpr std::size_t kUsualVoltageNodes = 80;  // VoltageNodes(0) has fewer
constexpr int kFewNodes = 13;
constexpr int kManyNodes = 34;

bool FitsBetter(const LeftOutErrors& rich, const LeftOutErrors& simple) {
  return rich.fitted_V < (1.0 - kBetterFit) * simple.fitted_V;
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

// Whether a time constant came so near to its limit that this may have kept it there.
bool NearSlowest(const JointRates& rates, double longest_tau_s) {
  return std::any_of(rates.time_constant_s.begin(), rates.time_constant_s.end(), [&](double tau_s) {
    return tau_s > 0.5 * longest_tau_s;
  });
}

bool NearFastest(const JointRates& rates, double shortest_tau_s) {
  constexpr double kNear = 1.05;
  return std::any_of(rates.time_constant_s.begin(), rates.time_constant_s.end(), [&](double tau_s) {
    return tau_s < kNear * shortest_tau_s;
  });
}

// What no row of the voltage shows.
constexpr double kNothing_V = 1e-6;

bool IsGone(const JointSolution& solution, int table, const JointLogs& logs) {
  const JointLayout layout(solution.structure);
  const double scale = logs.typical_A / logs.largest_A;
  return solution.x.segment(layout.table(table), layout.nodes()).maxCoeff() < kNothing_V * scale;
}

// Whether the heat takes more from r_s, in these logs, than a cell lets it (SelfHeating::Warm). The fit is
// linear in both and goes on, and the cell would not be what was fitted.
bool HeatLeavesItsLaw(const JointSolution& solution, const JointLogs& logs, double alpha_C) {
  if (!solution.structure.self_heating) return false;
  Cell cell;
  PutInto(cell, solution, logs.typical_A);
  const auto& heating = *cell.self_heating;
  for (const JointLog& log : logs.logs) {
    double heat_A2 = 0.0;
    double charge_C = log.delivered_C;
    for (std::size_t k = 1; k < log.size(); ++k) {
      const double dt_s = log.time_s[k] - log.time_s[k - 1];
      const double current_A = log.step_A[k];
      const auto hold = ExactHold(1.0 / heating.time_constant_s, dt_s);
      heat_A2 = hold.decay * heat_A2 + hold.gain / heating.time_constant_s * current_A * current_A;
      charge_C += current_A * dt_s;
      if (current_A == 0.0) continue;
      const double cold_Ohm = cell.series_resistance_Ohm(1.0 - charge_C / alpha_C);
      const double by_law_Ohm = cold_Ohm - heating.resistance_drop_Ohm_per_A2 * heat_A2;
      if (heating.Warm(cold_Ohm, heat_A2) > by_law_Ohm) return true;
    }
  }
  return false;
}

// Whether every term has a part in the answer.
bool Complete(const JointSolution& solution, const JointLogs& logs, double alpha_C) {
  if (solution.x.size() == 0 || HeatLeavesItsLaw(solution, logs, alpha_C)) return false;
  const JointLayout layout(solution.structure);
  for (int t = 1; t < layout.tables(); ++t) {
    if (IsGone(solution, t, logs)) return false;
  }
  if (layout.hystereses() > 0 &&
      solution.x.segment(layout.hysteresis(), layout.hystereses()).maxCoeff() < kNothing_V)
    return false;
  return !solution.structure.self_heating || solution.x[layout.heating()] > 0.0;
}

// Its structure without terms that have no part in the answer.
JointStructure WithoutGoneTerms(const JointSolution& solution, const JointLogs& logs) {
  const JointLayout layout(solution.structure);
  JointStructure structure = solution.structure;
  structure.charge_transfer =
      structure.charge_transfer && !IsGone(solution, layout.tables() - 1, logs);
  structure.self_heating = structure.self_heating && solution.x[layout.heating()] > 0.0;
  return structure;
}

// Whether a log shows v_oc from the other side: by how much it was charged.
bool Charges(const JointLogs& logs, double alpha_C) {
  constexpr double kEnough = 0.05;
  for (const JointLog& log : logs.logs) {
    double charged_C = 0.0;
    for (std::size_t k = 1; k < log.size(); ++k)
      charged_C += std::max(-log.step_A[k], 0.0) * (log.time_s[k] - log.time_s[k - 1]);
    if (charged_C > kEnough * alpha_C) return true;
  }
  return false;
}

// With a node more between any two.
std::vector<double> Halved(const std::vector<double>& nodes) {
  std::vector<double> fine;
  if (nodes.empty()) return fine;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    fine.push_back(nodes[k]);
    fine.push_back(0.5 * (nodes[k] + nodes[k + 1]));
  }
  fine.push_back(nodes.back());
  return fine;
}

// How often the values turn round, by more than a quarter of their mean each time.
int Turns(const Eigen::VectorXd& values) {
  const double least = 0.25 * values.mean();
  int turns = 0;
  int direction = 0;
  double extreme = values[0];  // the highest since it rises, the lowest since it falls
  for (const double value : values) {
    if (direction >= 0 ? value > extreme : value < extreme) {
      extreme = value;
    } else if (std::abs(value - extreme) > least) {
      if (direction != 0) ++turns;
      direction = direction >= 0 && value < extreme ? -1 : 1;
      extreme = value;
    }
  }
  return turns;
}

// Whether a branch goes up and down over the state of charge as no cell's does.
bool Zigzags(const JointSolution& solution) {
  constexpr int kMostTurns = 6;  // real cells turn at most five times, noise seventeen
  const JointLayout layout(solution.structure);
  for (int j = 0; j < solution.structure.branches; ++j) {
    const int turns = Turns(solution.x.segment(layout.branch(j), layout.nodes()));
    if (turns > kMostTurns) return true;
  }
  return false;
}

std::string Describe(const JointStructure& s) {
  std::string text = s.nodes() == 1 ? "constant resistances" : fmt::format("{} nodes", s.nodes());
  text += fmt::format(", {} branch{}", s.branches, s.branches == 1 ? "" : "es");
  for (const JointTerm& term : JointTerms()) {
    if (term.present(s)) text += fmt::format(", {}", term.words);
  }
  if (s.shared_energies == SharedEnergies::kAll) text += ", one activation energy";
  if (s.shared_energies == SharedEnergies::kAllButSeries)
    text += ", one activation energy of all but r_s";
  if (s.hysteresis_soc.size() > 1) text += fmt::format(", M at {} nodes", s.hysteresis_soc.size());
  if (s.voltage_soc.size() > kUsualVoltageNodes)
    text += fmt::format(", v_oc at {} nodes", s.voltage_soc.size());
  if (s.branch_smoothness > 1.0)
    text += fmt::format(", branches {:g} times as smooth", s.branch_smoothness);
  return text;
}

}  // namespace

// Whether a richer structure is worth it. What fits as well as the noise lets it can only be
// overtaken by following the noise. Discharges that are left out whole are an experiment of their
// own: the richer structure is asked for where it predicts them better by more than chance. Stretches of
// few discharges are too few for that, and kGain decides.
bool IsAskedFor(const LeftOutErrors& rich, const LeftOutErrors& simple, const JointLogs& logs) {
  if (simple.fitted_V <= kFinest_V) return false;
  if (logs.whole) return CompareErrors(simple.unit_V, rich.unit_V, logs.unit_weight).AskedFor();
  if (simple.fitted_V <= kAtTheNoise * logs.noise_mean_V) return false;
  return rich.expected_V < (1.0 - kGain) * simple.expected_V;
}

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

std::vector<double> EntropyNodes() { return {0.0, 0.1, 0.2, 0.35, 0.55, 0.8, 1.0}; }

std::vector<double> OnAxis(std::vector<double> nodes, double lowest_soc) {
  constexpr double kNearZero = 0.02;
  if (nodes.size() > 1 && std::abs(lowest_soc) > kNearZero) {
    for (double& a : nodes) a = 1.0 - (1.0 - a) * (1.0 - lowest_soc);
  }
  return nodes;
}

OpenCircuitVoltage AtNodes(const OpenCircuitVoltage& curve, const std::vector<double>& soc) {
  std::vector<double> voltage_V;
  double highest_V = -std::numeric_limits<double>::infinity();
  for (const double a : soc) {
    highest_V = std::max(highest_V, curve(a));
    voltage_V.push_back(highest_V);
  }
  return OpenCircuitVoltage::Linear(soc, std::move(voltage_V));
}

namespace {

class Choosing {
 public:
  Choosing(const ChoiceTask& task, JointChoice choice, const JointChoice* before)
      : fit_(task.fit),
        logs_(task.logs),
        voltage_soc_(task.voltage_soc),
        lowest_soc_(task.lowest_soc),
        options_(task.options),
        free_alpha_(task.free_alpha),
        progress_(task.progress),
        before_(before),
        near_(task.near),
        compare_(logs_.groups >= 2),
        rough_(options_.smoothness > 0.0  ? options_.smoothness
               : fit_.seen().setup().held ? kTypicalOfHeld
                                          : kTypicalSmoothness),
        choice_(std::move(choice)) {}

  JointChoice Run() {
    choice_.shortest_tau_s = fit_.seen().scales().shortest_tau_s;
    choice_.longest_tau_s = fit_.seen().scales().longest_tau_s;
    JointStructure structure;
    structure.branches =
        options_.branches >= 0 ? options_.branches : std::min(1, options_.most_branches);
    structure.voltage_soc = voltage_soc_;
    structure.self_heating = options_.self_heating == Presence::kOn;
    structure.charge_transfer = options_.charge_transfer == Presence::kOn;
    structure.temperature = options_.temperature == Presence::kOn;
    structure.current_offset = options_.current_offset == Presence::kOn;
    structure.free_alpha = free_alpha_;
    if (options_.hysteresis == Presence::kOn) structure.hysteresis_soc = MemoryNodes();
    if (structure.temperature && structure.self_heating) {
      throw OptionError(
          "--set joint.temperature=on joint.self_heating=on: both are laws of a cell that warms; "
          "leave one of them out");
    }
    if (structure.temperature && std::isnan(logs_.coldest_K)) {
      throw OptionError(
          "--set joint.temperature=on: expected the temperature of every log, found logs without; "
          "give ambient_degC in the campaign, or logs with a column temperature_degC");
    }
    if (structure.temperature && options_.entropy == Presence::kOn)
      structure.entropy_soc = Entropies();
    const int given = options_.resistance_nodes;
    structure.resistance_soc = Nodes(given > 0 ? given : compare_ ? kFewNodes : 1);
    if (Held() != nullptr) {  // nothing is left to choose
      structure.resistance_soc = Held()->ResistanceNodes();
      Search(structure);
      return std::move(choice_);
    }
    Search(structure);
    if (compare_) {
      TryTemperature(structure);
      TryBothWays(structure);
      TryTerms(structure);
      if (given == 0) TryNodes();
      if (!logs_.whole && best().nodes() != structure.nodes()) TrySimplerTerms();
      TryBranches();
      if (best().branches > structure.branches) TrySimpler();
      DropBranches();
      TryEntropy();
      TryHysteresisNodes();
      TryShared();
      if (logs_.whole) DropTerms([&](const JointStructure& simpler) { Simplify(simpler); });
      TryVoltageNodes();
      SmoothBranches();
    } else {
      choice_.reason =
          "too few pulses and discharges to leave any out: the simplest structure is taken";
    }
    return std::move(choice_);
  }

  JointChoice Finish() {
    for (std::size_t k = 0; compare_ && k < choice_.tried.size(); ++k) {
      if (k != choice_.taken) choice_.tried[k].gain = Gain(k, choice_.taken);
    }
    choice_.tried[choice_.taken].taken = true;
    PolishBest();
    FindWeights();
    if (Held() == nullptr) FindFiner();
    Tell(1.0);
    return std::move(choice_);
  }

 private:
  void Tell(double share) {
    done_ = std::max(done_, share);
    if (progress_) progress_(done_);
  }
  [[nodiscard]] std::vector<double> Nodes(int count) const {
    return OnAxis(ResistanceNodes(count), lowest_soc_);
  }
  [[nodiscard]] const JointStructure& best() const { return choice_.best.structure; }
  [[nodiscard]] bool IsComplete(const JointSolution& solution) const {
    return Complete(solution, logs_, fit_.seen().setup().alpha_C);
  }
  void Take(std::size_t k) {
    choice_.taken = k;
    choice_.best = choice_.tried[k].solution;
    choice_.errors = choice_.tried[k].errors;
  }

  [[nodiscard]] PairedGain Gain(std::size_t simple, std::size_t rich) const {
    return CompareErrors(
        choice_.tried[simple].errors.unit_V, choice_.tried[rich].errors.unit_V, logs_.unit_weight);
  }
  [[nodiscard]] bool IsBetter(const LeftOutErrors& rich, const LeftOutErrors& simple) const {
    return IsAskedFor(rich, simple, logs_);
  }

  // How well a solution's structure predicts held-out rows.
  [[nodiscard]] TriedStructure Assess(JointSolution solution) const {
    TriedStructure row{.what = Describe(solution.structure), .solution = std::move(solution)};
    row.errors.smoothness = rough_;
    if (compare_) {
      row.errors =
          LeaveOut(fit_,
                   logs_,
                   row.solution.structure,
                   row.solution.rates,
                   options_.smoothness > 0.0 || Held() != nullptr ? std::vector<double>{rough_}
                                                                  : kSmoothness);
    }
    return row;
  }
  // A time constant came near a limit that has moved since the choice before.
  [[nodiscard]] bool IsFreed(const JointRates& rates) const {
    return (choice_.longest_tau_s > before_->longest_tau_s &&
            NearSlowest(rates, before_->longest_tau_s)) ||
           (choice_.shortest_tau_s < before_->shortest_tau_s &&
            NearFastest(rates, before_->shortest_tau_s));
  }

  // The same row of the choice before, as long as all rows up to it are the same there, and no time
  // constant came near its limit.
  [[nodiscard]] const TriedStructure* FromBefore(std::size_t row, const JointStructure& structure) {
    if (before_ == nullptr) return nullptr;
    const bool same = row < before_->tried.size() &&
                      before_->tried[row].solution.structure == structure &&
                      !IsFreed(before_->tried[row].solution.rates);
    if (!same) before_ = nullptr;
    return same ? &before_->tried[row] : nullptr;
  }
  // A structure tried is taken where it is better than what was taken before.
  std::size_t Judge(TriedStructure row) {
    const bool taking =
        choice_.tried.empty() || (IsComplete(row.solution) && IsBetter(row.errors, choice_.errors));
    choice_.tried.push_back(std::move(row));
    if (taking) Take(choice_.tried.size() - 1);
    Tell(0.1 * static_cast<double>(choice_.tried.size()));
    return choice_.tried.size() - 1;
  }
  // What was found before for a structure like the first, unless its limits held it.
  [[nodiscard]] const JointSolution* Near(const JointStructure& structure) const {
    const bool like = near_ != nullptr && near_->x.size() > 0 &&
                      near_->structure.branches == structure.branches &&
                      near_->structure.temperature == structure.temperature &&
                      !NearSlowest(near_->rates, fit_.seen().scales().longest_start_tau_s);
    return like ? near_ : nullptr;
  }
  // Structures that do not wait for one another are searched side by side, each near what was taken
  // before all of them, and judged in their order.
  std::vector<std::size_t> SearchEach(const std::vector<JointStructure>& structures,
                                      const JointSolution* near = nullptr) {
    if (near == nullptr) near = choice_.tried.empty() ? Near(structures[0]) : &choice_.best;
    std::vector<TriedStructure> rows(structures.size());
    std::vector<const TriedStructure*> known;
    for (std::size_t k = 0; k < rows.size(); ++k)
      known.push_back(FromBefore(choice_.tried.size() + k, structures[k]));
    ParallelFor(rows.size(), [&](std::size_t k) {
      rows[k] = known[k] != nullptr ? *known[k] : Assess(fit_.Search(structures[k], rough_, near));
    });
    std::vector<std::size_t> tried;
    for (TriedStructure& row : rows) tried.push_back(Judge(std::move(row)));
    return tried;
  }
  std::size_t Search(const JointStructure& structure, const JointSolution* near = nullptr) {
    return SearchEach({structure}, near).front();
  }

  // The simpler structure is taken where the richer one is not better, or holds a part that is zero.
  void Simplify(const JointStructure& simpler, const JointSolution* near = nullptr) {
    const LeftOutErrors richer = choice_.errors;
    const bool complete = IsComplete(choice_.best);
    const TriedStructure* known = FromBefore(choice_.tried.size(), simpler);
    const std::size_t k =
        Judge(known != nullptr
                  ? *known
                  : Assess(fit_.Search(simpler, rough_, near != nullptr ? near : &choice_.best)));
    if (k != choice_.taken && IsComplete(choice_.tried[k].solution) &&
        !(complete && IsBetter(richer, choice_.tried[k].errors)))
      Take(k);
  }

  // The resistance of a branch over r_s.
  [[nodiscard]] double BranchShare(int branch) const {
    const JointLayout layout(best());
    const auto sum = [&](int table) { return choice_.best.x.segment(table, layout.nodes()).sum(); };
    return sum(layout.branch(branch)) / std::max(sum(layout.series()), 1e-12);
  }

  [[nodiscard]] const HeldShape* Held() const { return fit_.seen().setup().held.get(); }
  // The nodes of M.
  [[nodiscard]] std::vector<double> MemoryNodes() const {
    if (Held() == nullptr || Held()->cell.hysteresis->soc.empty()) return {0.5};
    return Held()->cell.hysteresis->soc;
  }
  [[nodiscard]] std::vector<double> Entropies() const {
    if (Held() != nullptr) {
      const auto& soc = Held()->cell.temperature->entropy->soc;
      return soc.size() > 1 ? soc : std::vector<double>{0.0, 1.0};
    }
    return OnAxis(EntropyNodes(), lowest_soc_);
  }

  // First of all: at several temperatures nothing else can be told without it.
  void TryTemperature(JointStructure& structure) {
    if (options_.temperature != Presence::kAuto || structure.self_heating) return;
    if (!(logs_.warmest_K - logs_.coldest_K >= kLeastSpan_K)) return;
    JointStructure richer = structure;
    richer.temperature = true;
    if (options_.entropy == Presence::kOn) richer.entropy_soc = Entropies();
    std::vector<JointStructure> both{richer};
    // What a slope of v_oc does at another temperature, tables and branches would follow.
    if (MayHaveEntropy(richer)) {
      both.push_back(richer);
      both.back().entropy_soc = Entropies();
    }
    for (const std::size_t k : SearchEach(both)) {
      if (k == choice_.taken) structure = best();
    }
  }

  // What charge and discharge do not agree on: the voltage, or the charge itself. Each alone, as one
  // may stand in for the other, and both.
  void TryBothWays(JointStructure& structure) {
    const bool voltage = options_.hysteresis == Presence::kAuto &&
                         structure.hysteresis_soc.empty() &&
                         Charges(logs_, fit_.seen().setup().alpha_C);
    const bool charge =
        options_.current_offset == Presence::kAuto && !structure.current_offset && BothWays(logs_);
    std::vector<JointStructure> richer;
    for (const int which : {1, 2, 3}) {
      const bool with_voltage = (which & 1) != 0;
      const bool with_charge = (which & 2) != 0;
      if ((with_voltage && !voltage) || (with_charge && !charge)) continue;
      richer.push_back(structure);
      if (with_voltage) richer.back().hysteresis_soc = {0.5};
      if (with_charge) richer.back().current_offset = true;
    }
    SearchEach(richer);
    structure.hysteresis_soc = best().hysteresis_soc;
    structure.current_offset = best().current_offset;
  }

  // Charge and discharge differ most near empty.
  void TryHysteresisNodes() {
    if (options_.hysteresis != Presence::kAuto || best().hysteresis_soc.empty()) return;
    JointStructure richer = best();
    richer.hysteresis_soc = OnAxis({0.0, 0.05, 0.15, 0.35, 0.65, 1.0}, lowest_soc_);
    Search(richer);
  }

  // Logs of one kind at several temperatures, or what differs between the kinds passes for the slope:
  // a slow discharge in the warm and pulses in the cold differ by hysteresis and polarisation, too.
  [[nodiscard]] bool MayHaveEntropy(const JointStructure& structure) const {
    return options_.entropy == Presence::kAuto && structure.temperature && !voltage_soc_.empty() &&
           logs_.like_span_K >= kLeastSpan_K;
  }

  // The slope that was asked for beside fewer terms must be asked for beside these; one that is asked for
  // only now may have been followed by terms and tables, which must be asked for beside it.
  void TryEntropy() {
    if (!MayHaveEntropy(best())) return;
    JointStructure other = best();
    if (!other.entropy_soc.empty()) {
      other.entropy_soc.clear();
      Simplify(other);
      return;
    }
    other.entropy_soc = Entropies();
    if (Search(other) == choice_.taken) TrySimpler();
  }

  // Energies that the left-out rows cannot tell apart are one: first those that are alike, then all.
  void TryShared() {
    if (!best().temperature) return;
    for (const SharedEnergies which : {SharedEnergies::kAllButSeries, SharedEnergies::kAll}) {
      JointStructure simpler = best();
      simpler.shared_energies = which;
      const bool diffusion = fit_.seen().setup().diffusion;
      const auto names = SharedEnergyNames(simpler, diffusion);
      if (names.size() < 2) continue;
      JointSolution near = choice_.best;
      double sum = 0.0;
      for (const std::string& name : names) {
        const JointRates& r = near.rates;
        sum += name == "E_d"    ? r.Diffusion()
               : name == "E_s"  ? r.Series()
               : name == "E_ct" ? r.Transfer()
                                : r.Branch(FindCellParameter(name)->branch);
      }
      near.rates.shared_J_per_mol = sum / static_cast<double>(names.size());
      Simplify(simpler, &near);
    }
  }

  // The terms first: without them no number of nodes tells a cell that warms from one that does
  // not. Each alone, as one may stand in for the other; then both, if both helped.
  void TryTerms(JointStructure structure) {
    // At one current both are one more process in time, and say nothing of another current.
    if (!logs_.several_currents) return;
    const bool free_heating = options_.self_heating == Presence::kAuto && !structure.temperature;
    const bool free_transfer = options_.charge_transfer == Presence::kAuto;
    const LeftOutErrors plain = choice_.errors;  // with temperature, where that was taken
    std::vector<JointStructure> richer;
    for (const bool heating : {false, true}) {
      if (!(heating ? free_heating : free_transfer)) continue;
      richer.push_back(structure);
      (heating ? richer.back().self_heating : richer.back().charge_transfer) = true;
    }
    const std::vector<std::size_t> tried = SearchEach(richer);
    const bool both_helped = std::all_of(tried.begin(), tried.end(), [&](std::size_t k) {
      return IsBetter(choice_.tried[k].errors, plain);
    });
    if (!free_heating || !free_transfer || !both_helped) return;
    structure.self_heating = structure.charge_transfer = true;
    Search(structure);
  }

  void TryNodes() {
    const std::size_t middle = choice_.taken;
    JointStructure fewest = best();
    JointStructure most = best();
    fewest.resistance_soc = Nodes(1);
    most.resistance_soc = Nodes(kManyNodes);
    const std::vector<std::size_t> tried = SearchEach({fewest, most});
    std::size_t best = tried[0];
    for (const std::size_t k : {tried[0], middle, tried[1]}) {
      if (IsBetter(choice_.tried[k].errors, choice_.tried[best].errors)) best = k;
    }
    Take(best);
    // Tables that fit better and predict worse may follow what one more branch would say.
    if (best == tried[0] && FitsBetter(choice_.tried[middle].errors, choice_.errors))
      AddBranches(middle);
  }

  // From that structure on, as long as each fits better than the one before. Two branches may be
  // worth it where one more is not.
  void AddBranches(std::size_t from) {
    if (options_.branches >= 0) return;
    // Cold slows what a warm cell does at once, so that more of it is seen.
    const int most = options_.most_branches + (best().temperature ? 1 : 0);
    while (choice_.tried[from].solution.structure.branches < most) {
      const JointSolution near = choice_.tried[from].solution;
      JointStructure richer = near.structure;
      ++richer.branches;
      std::size_t k = Search(richer, &near);
      // A term that stood in for the branch may be gone beside it.
      const TriedStructure& row = choice_.tried[k];
      if (k != choice_.taken && row.solution.x.size() > 0 && IsBetter(row.errors, choice_.errors)) {
        const JointSolution beside = row.solution;
        const JointStructure without = WithoutGoneTerms(beside, logs_);
        if (without != beside.structure) k = Search(without, &beside);
      }
      if (k != choice_.taken && !FitsBetter(choice_.tried[k].errors, choice_.tried[from].errors))
        return;
      from = k;
    }
  }

  void TryBranches() {
    // Every fit began with one branch, which may have found nothing.
    if (options_.branches < 0 && best().branches == 1 && BranchShare(0) < kSlight) {
      JointStructure simpler = best();
      simpler.branches = 0;
      Simplify(simpler);
      if (best().branches == 0) return;
    }
    AddBranches(choice_.taken);
  }

  // A branch without resistance is none, whatever it gains: what it was added for is said by the others since a
  // term was dropped. Where the temperature takes part, resistances are those of another one.
  void DropBranches() {
    if (options_.branches >= 0 || best().temperature) return;
    for (int j = best().branches - 1; j >= 0 && best().branches > 1; --j) {
      if (BranchShare(j) > kNotFound) continue;
      JointSolution near = choice_.best;
      near.rates.time_constant_s.erase(near.rates.time_constant_s.begin() + j);
      JointStructure simpler = best();
      --simpler.branches;
      const std::size_t k = Search(simpler, &near);
      if (IsComplete(choice_.tried[k].solution)) Take(k);
    }
  }

  // Tables and terms that were asked for beside fewer branches must be asked for beside these.
  void TrySimpler() {
    TrySimplerTerms();
    if (options_.resistance_nodes > 0 || best().nodes() == 1) return;
    JointStructure simpler = best();
    simpler.resistance_soc = Nodes(1);
    SimplifyNear(simpler);
  }
  void TrySimplerTerms() {
    DropTerms([&](const JointStructure& simpler) { SimplifyNear(simpler); });
  }
  // What is far worse at the rates that were found is not searched.
  void SimplifyNear(const JointStructure& simpler) {
    constexpr double kFarWorse = 1.2;
    const TriedStructure glance = Assess(AtFoundRates(simpler, rough_));
    if (glance.errors.expected_V < kFarWorse * choice_.errors.expected_V) Simplify(simpler);
  }

  // A term that was asked for beside other tables must be asked for beside these too.
  template <class Simplify>
  void DropTerms(Simplify&& simplify) {
    using Term = std::pair<bool JointStructure::*, Presence>;
    for (const auto& [term, wish] :
         {Term{&JointStructure::self_heating, options_.self_heating},
          Term{&JointStructure::charge_transfer, options_.charge_transfer},
          Term{&JointStructure::current_offset, options_.current_offset}}) {
      if (!(best().*term) || wish != Presence::kAuto) continue;
      JointStructure simpler = best();
      simpler.*term = false;
      simplify(simpler);
    }
  }

  // A structure at the rates of the best one, whose search it ends as.
  [[nodiscard]] JointSolution AtFoundRates(const JointStructure& structure,
                                           double smoothness) const {
    JointSolution solution = fit_.Solve(structure, choice_.best.rates, smoothness);
    solution.termination = choice_.best.termination;
    solution.message = choice_.best.message;
    return solution;
  }

  // The nodes of v_oc do not move the rates: those found are kept.
  void TryVoltageNodes() {
    if (voltage_soc_.empty() || options_.voltage_nodes != 0) return;
    JointStructure finer = best();
    finer.voltage_soc = Halved(voltage_soc_);
    const std::size_t k = Judge(Assess(AtFoundRates(finer, rough_)));
    const LeftOutErrors& errors = choice_.tried[k].errors;
    if (k != choice_.taken && !logs_.whole && choice_.errors.fitted_V > kFinest_V &&
        errors.expected_V < choice_.errors.expected_V && FitsBetter(errors, choice_.errors))
      Take(k);
  }

  // At each node the logs may hardly tell r_s from a branch, and then noise divides their sum: one
  // node gives all to the one, the next to the other. No resistance of a cell goes up and down so
  // often. The branches are made smoother, as little as does, and r_s stays as free as it was.
  void SmoothBranches() {
    if (best().nodes() < 3 || options_.smoothness > 0.0) return;
    for (const double times : {10.0, 100.0, 1000.0}) {
      if (!Zigzags(choice_.best)) return;
      JointStructure smoother = best();
      smoother.branch_smoothness = times;
      TriedStructure row{.what = Describe(smoother),
                         .solution = AtFoundRates(smoother, choice_.errors.smoothness)};
      row.errors = LeaveOut(fit_, logs_, smoother, row.solution.rates, {choice_.errors.smoothness});
      choice_.tried.push_back(std::move(row));
      Take(choice_.tried.size() - 1);
    }
  }

  // The last polish follows the fit. Where held-out rows are predicted worse for it, it followed
  // noise along a flat valley.
  void PolishBest() {
    // Where the model fits to within the noise of a row nothing needs smoothing, and what pulls the
    // last nodes of v_oc to the reference's shape would move alpha by a part in a hundred thousand.
    if (compare_ && options_.smoothness == 0.0 && Held() == nullptr &&
        choice_.errors.fitted_V <= logs_.noise_V)
      choice_.errors.smoothness = kNoSmoothness;
    JointSolution before = AtFoundRates(best(), choice_.errors.smoothness);
    JointSolution polished = fit_.Polish(before, kFineStep, options_.iterations_per_variable);
    // A search that converged, and many more steps that gain nothing.
    constexpr double kNoGain = 1e-6;
    if (polished.termination == Termination::kMaxIterations &&
        !(polished.cost < (1.0 - kNoGain) * before.cost))
      polished = before;
    if (compare_) {
      const LeftOutErrors errors =
          LeaveOut(fit_, logs_, polished.structure, polished.rates, {choice_.errors.smoothness});
      if (errors.expected_V > choice_.errors.expected_V) {
        // Where kinks of a curve stopped the search before it, the polish is what ended it.
        if (before.termination == Termination::kMaxIterations) {
          before.termination = polished.termination;
          before.message = polished.message;
        }
        polished = std::move(before);
      } else {
        choice_.errors = errors;
      }
    }
    choice_.best = std::move(polished);
  }

  void FindWeights() {
    double sum = 0.0;
    for (std::size_t k = 0; k < choice_.tried.size(); ++k) {
      TriedStructure& row = choice_.tried[k];
      if (k == choice_.taken) {
        row.weight = 0.5;
      } else if (row.solution.x.size() > 0 && !Zigzags(row.solution)) {
        row.weight = Gain(choice_.taken, k).Probability();
      }
      sum += row.weight;
    }
    for (TriedStructure& row : choice_.tried) row.weight /= sum;
  }

  void FindFiner() {
    JointStructure finer = best();
    finer.voltage_soc = Halved(finer.voltage_soc);
    if (finer.nodes() < kManyNodes) finer.resistance_soc = Halved(finer.resistance_soc);
    if (finer == best() || choice_.best.x.size() == 0) return;
    choice_.finer = fit_.Approach(fit_.Solve(finer, choice_.best.rates, choice_.best.smoothness));
  }

  const JointFit& fit_;
  const JointLogs& logs_;
  const std::vector<double>& voltage_soc_;
  double lowest_soc_;
  const JointOptions& options_;
  bool free_alpha_;
  const std::function<void(double)>& progress_;
  const JointChoice* before_;
  const JointSolution* near_;
  bool compare_;
  double rough_;
  double done_ = 0.0;
  JointChoice choice_;
};

}  // namespace

JointChoice ChooseStructure(const ChoiceTask& task, const JointChoice* before) {
  return Choosing(task, {}, before).Run();
}

JointChoice FinishChoice(const ChoiceTask& task, JointChoice choice) {
  return Choosing(task, std::move(choice), nullptr).Finish();
}

}  // namespace lipoid
