#include "model/flight/endurance_lanes.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

using Lanes = Eigen::Array<double, kLanes, 1>;

constexpr std::size_t kBlockSteps = 64;

// A piece of a curve over A in each lane: cubic, from lo to hi.
struct Pieces {
  Lanes lo = Lanes::Constant(-kInfinity);
  Lanes hi = Lanes::Constant(kInfinity);
  Lanes from = Lanes::Zero();
  Lanes c0 = Lanes::Zero();
  Lanes c1 = Lanes::Zero();
  Lanes c2 = Lanes::Zero();
  Lanes c3 = Lanes::Zero();

  [[nodiscard]] bool Holds(const Lanes& soc) const { return (soc >= lo).all() && (soc < hi).all(); }
};

// The formula of a curve of pieces at this A.
void SetPiece(Pieces& pieces, Eigen::Index l, const OpenCircuitVoltage& curve, double soc) {
  const auto& nodes = curve.soc();
  const auto above =
      static_cast<std::size_t>(std::upper_bound(nodes.begin(), nodes.end(), soc) - nodes.begin());
  if (above == 0 || above == nodes.size()) {
    const double end = above == 0 ? nodes.front() : nodes.back();
    const auto& line = above == 0 ? curve.below() : curve.above();
    pieces.lo[l] = above == 0 ? -kInfinity : end;
    pieces.hi[l] = above == 0 ? end : kInfinity;
    pieces.from[l] = end;
    pieces.c0[l] = line.value_V;
    pieces.c1[l] = line.slope_V;
    pieces.c2[l] = 0.0;
    pieces.c3[l] = 0.0;
    return;
  }
  const OpenCircuitVoltage::Piece& piece = curve.pieces()[above - 1];
  pieces.lo[l] = pieces.from[l] = nodes[above - 1];
  pieces.hi[l] = nodes[above];
  pieces.c0[l] = piece.c0;
  pieces.c1[l] = piece.c1;
  pieces.c2[l] = piece.c2;
  pieces.c3[l] = piece.c3;
}

// A straight line between two nodes, or a constant beyond them.
void SetPiece(Pieces& pieces, Eigen::Index l, const Resistance<double>& table, double soc) {
  const auto& nodes = table.soc;
  const auto above =
      static_cast<std::size_t>(std::upper_bound(nodes.begin(), nodes.end(), soc) - nodes.begin());
  const auto& r = table.resistance_Ohm;
  pieces.lo[l] = above == 0 ? -kInfinity : nodes[above - 1];
  pieces.hi[l] = above == nodes.size() ? kInfinity : nodes[above];
  const bool between = above > 0 && above < nodes.size();
  pieces.from[l] = between ? nodes[above - 1] : 0.0;
  pieces.c0[l] = above == 0 ? r.front() : r[above - 1];
  pieces.c1[l] = between ? (r[above] - r[above - 1]) / (nodes[above] - nodes[above - 1]) : 0.0;
}

// Cells of the flights, one in each lane; of one cell, not of the pack.
class Batch {
 public:
  Batch(std::span<const EnduranceSetup* const> setups, std::span<const double> step_s)
      : setups_(setups) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      // Empty lanes fly the last one again.
      const std::size_t k = std::min(l, setups.size() - 1);
      Add(static_cast<Eigen::Index>(l), *setups[k], step_s[k]);
    }
    for (auto& table : tables_) table.pieces.hi.setConstant(-kInfinity);  // none is found yet
    curve_.hi.setConstant(-kInfinity);
    ended_.fill(false);
  }

  std::vector<MissionState> Run() {
    std::vector<MissionState> ends(setups_.size());
    while (std::find(ended_.begin(), ended_.end(), false) != ended_.end()) {
      const Now before = now_;
      for (std::size_t k = 0; k < kBlockSteps; ++k) Step();
      for (std::size_t l = 0; l < kLanes; ++l) {
        if (ended_[l] || !MayHaveEnded(static_cast<Eigen::Index>(l))) continue;
        ended_[l] = true;
        if (l < setups_.size()) ends[l] = StateOf(static_cast<Eigen::Index>(l), before);
        // What is left of the lane rests.
        power_W_[static_cast<Eigen::Index>(l)] = 0.0;
        switched_A_[static_cast<Eigen::Index>(l)] = 0.0;
      }
      steps_ += kBlockSteps;
    }
    return ends;
  }

 private:
  struct Now {
    Lanes delivered_C = Lanes::Zero();
    std::vector<Lanes> mode_C;
    std::vector<Lanes> branch_V;
    Lanes last_A = Lanes::Zero();    // that flowed in the last step
    Lanes before_A = Lanes::Zero();  // at the beginning of it
    Lanes charge_C = Lanes::Zero();
    Lanes energy_J = Lanes::Zero();
    Lanes minimum_V = Lanes::Constant(kInfinity);
    Lanes peak_A = Lanes::Zero();
    // The least since the beginning of the flight: they fall.
    Lanes least_discriminant = Lanes::Constant(kInfinity);
    Lanes least_soc = Lanes::Constant(kInfinity);
  };
  struct Table {
    std::array<const Resistance<double>*, kLanes> of{};
    Pieces pieces;
  };

  void Add(Eigen::Index l, const EnduranceSetup& setup, double step_s) {
    const auto p = setup.cell.Parameters();
    const CellModel<double> model(p);
    const auto state = model.Relaxed(setup.initial_soc);
    const auto step = model.MakeStep(step_s);
    const MissionLeg& leg = setup.mission.legs.front();
    const double cells = static_cast<double>(setup.cell.series) * setup.cell.parallel;
    if (l == 0) {
      now_.mode_C.assign(state.unavailable_C.size(), Lanes::Zero());
      now_.branch_V.assign(state.branch_V.size(), Lanes::Zero());
      decay_.assign(state.unavailable_C.size(), Lanes::Zero());
      gain_.assign(state.unavailable_C.size(), Lanes::Zero());
      branch_decay_.assign(state.branch_V.size(), Lanes::Zero());
      branch_share_.assign(state.branch_V.size(), Lanes::Zero());
      tables_.resize(1 + state.branch_V.size());
    }
    alpha_C_[l] = p.alpha_C;
    per_alpha_[l] = 1.0 / p.alpha_C;
    tail_s_[l] = model.tail_s();
    dt_s_[l] = step_s;
    power_W_[l] = (leg.power_W + leg.drive_W) / cells;
    switched_A_[l] = leg.switched_A / setup.cell.parallel;
    now_.delivered_C[l] = state.delivered_C;
    for (std::size_t m = 0; m < decay_.size(); ++m) {
      decay_[m][l] = step.diffusion[m].decay;
      gain_[m][l] = step.diffusion[m].gain;
    }
    const auto at = static_cast<std::size_t>(l);
    curves_[at] = &setup.cell.open_circuit_voltage;
    tables_[0].of[at] = &setup.cell.series_resistance_Ohm;
    for (std::size_t j = 0; j < branch_decay_.size(); ++j) {
      const double tau_s = p.branches[j].time_constant_s;
      branch_decay_[j][l] = step.branch[j].decay;
      branch_share_[j][l] = tau_s > 0.0 ? step.branch[j].gain / tau_s : 1.0;
      tables_[1 + j].of[at] = &setup.cell.branches[j].resistance_Ohm;
    }
  }

  void FindPieces(const Lanes& soc) {
    if (!curve_.Holds(soc)) {
      for (Eigen::Index l = 0; l < soc.size(); ++l)
        SetPiece(curve_, l, *curves_[static_cast<std::size_t>(l)], soc[l]);
    }
    for (Table& table : tables_) {
      if (table.pieces.Holds(soc)) continue;
      for (Eigen::Index l = 0; l < soc.size(); ++l)
        SetPiece(table.pieces, l, *table.of[static_cast<std::size_t>(l)], soc[l]);
    }
  }

  static Lanes LineAt(const Pieces& pieces, const Lanes& soc) {
    return pieces.c0 + pieces.c1 * (soc - pieces.from);
  }

  // As Mission::Step() of endurance.cc, in units of one cell.
  void Step() {
    Lanes held_C = Lanes::Zero();
    for (const Lanes& mode : now_.mode_C) held_C += mode;
    const Lanes relaxed_soc = (alpha_C_ - (now_.delivered_C + 2.0 * held_C)) * per_alpha_;
    const Lanes soc = relaxed_soc - tail_s_ * now_.last_A * per_alpha_;
    FindPieces(soc);
    const Lanes x = soc - curve_.from;
    const Lanes slope_V =
        (curve_.c1 + x * (2.0 * curve_.c2 + x * (3.0 * curve_.c3))).max(Lanes::Zero());
    Lanes open_V = curve_.c0 + x * (curve_.c1 + x * (curve_.c2 + x * curve_.c3)) +
                   slope_V * (relaxed_soc - soc);
    for (const Lanes& drop : now_.branch_V) open_V -= drop;
    const Lanes resistance = LineAt(tables_[0].pieces, soc) + slope_V * tail_s_ * per_alpha_;
    open_V -= resistance * switched_A_;
    const Lanes discriminant = open_V * open_V - 4.0 * resistance * power_W_;
    const Lanes voltage_V = 0.5 * (open_V + discriminant.max(Lanes::Zero()).sqrt());
    const Lanes begin_A = power_W_ / voltage_V + switched_A_;
    if (first_) now_.before_A = begin_A;
    first_ = false;
    const Lanes mean_A = begin_A + 0.5 * (begin_A - now_.before_A);
    for (std::size_t j = 0; j < now_.branch_V.size(); ++j) {
      now_.branch_V[j] =
          branch_decay_[j] * now_.branch_V[j] +
          (branch_share_[j] * (LineAt(tables_[1 + j].pieces, soc) * mean_A) + kAlive);
    }
    for (std::size_t m = 0; m < now_.mode_C.size(); ++m)
      now_.mode_C[m] = decay_[m] * now_.mode_C[m] + (gain_[m] * mean_A + kAlive);
    const Lanes charge_C = mean_A * dt_s_;
    now_.delivered_C += charge_C;
    now_.charge_C += charge_C;
    now_.energy_J += voltage_V * begin_A * dt_s_;
    now_.minimum_V = now_.minimum_V.min(voltage_V);
    now_.peak_A = now_.peak_A.max(begin_A);
    now_.least_discriminant = now_.least_discriminant.min(discriminant);
    now_.least_soc = now_.least_soc.min(soc);
    now_.last_A = mean_A;
    now_.before_A = begin_A;
  }

  // Whether the lane's flight could have ended in the last block, or a sum is not a number.
  [[nodiscard]] bool MayHaveEnded(Eigen::Index l) const {
    const EnduranceSetup& setup =
        *setups_[std::min(static_cast<std::size_t>(l), setups_.size() - 1)];
    const double least_V =
        std::max(setup.cell.cutoff_V, setup.mission.legs.front().least_V / setup.cell.series);
    const double rest_soc = (alpha_C_[l] - now_.delivered_C[l]) * per_alpha_[l];
    const double time_s = static_cast<double>(steps_ + kBlockSteps) * dt_s_[l];
    return !(now_.minimum_V[l] >= least_V && now_.least_soc[l] > kLeastSoc &&
             now_.least_discriminant[l] > 0.0 && rest_soc > setup.reserve &&
             time_s < setup.options.longest_s);
  }

  [[nodiscard]] MissionState StateOf(Eigen::Index l, const Now& at) const {
    const EnduranceSetup& setup = *setups_[static_cast<std::size_t>(l)];
    MissionState state;
    state.cell = CellModel<double>(setup.cell.Parameters()).Relaxed(setup.initial_soc);
    state.cell.delivered_C = at.delivered_C[l];
    for (std::size_t m = 0; m < at.mode_C.size(); ++m)
      state.cell.unavailable_C[m] = at.mode_C[m][l];
    for (std::size_t j = 0; j < at.branch_V.size(); ++j) state.cell.branch_V[j] = at.branch_V[j][l];
    state.cell_A = at.last_A[l];
    state.before_A = at.before_A[l] * setup.cell.parallel;
    state.steps = steps_;
    state.charge_C = at.charge_C[l] * setup.cell.parallel;
    state.energy_J = at.energy_J[l] * setup.cell.parallel * setup.cell.series;
    state.minimum_voltage_V = at.minimum_V[l] * setup.cell.series;
    state.peak_current_A = at.peak_A[l] * setup.cell.parallel;
    return state;
  }

  // Diffusion's tail makes A at the end of a step lower than at its beginning.
  static constexpr double kLeastSoc = 1e-3;

  std::span<const EnduranceSetup* const> setups_;
  Lanes alpha_C_, per_alpha_, tail_s_, dt_s_, power_W_, switched_A_;
  std::vector<Lanes> decay_, gain_, branch_decay_, branch_share_;
  std::array<const OpenCircuitVoltage*, kLanes> curves_{};
  Pieces curve_;
  std::vector<Table> tables_;  // of the series resistance, then of the branches
  Now now_;
  bool first_ = true;
  std::size_t steps_ = 0;
  std::array<bool, kLanes> ended_{};
};

}  // namespace

bool FitsLanes(const EnduranceSetup& setup) {
  const Cell& cell = setup.cell;
  const OcvMethod method = cell.open_circuit_voltage.method();
  const auto& legs = setup.mission.legs;
  return legs.size() == 1 && !std::isfinite(legs[0].duration_s) && legs[0].diode_V == 0.0 &&
         legs[0].power_W + legs[0].drive_W > 0.0 &&
         (method == OcvMethod::kLinear || method == OcvMethod::kMonotoneCubic) &&
         !cell.temperature && !cell.hysteresis && !cell.self_heating && !cell.charge_transfer;
}

std::vector<MissionState> FlyLanes(std::span<const EnduranceSetup* const> setups,
                                   std::span<const double> step_s) {
  Require(!setups.empty() && setups.size() <= kLanes && step_s.size() == setups.size() &&
              std::all_of(
                  setups.begin(), setups.end(), [](const auto* one) { return FitsLanes(*one); }),
          "flights that fit into lanes, each with its step");
  return Batch(setups, step_s).Run();
}

}  // namespace lipoid
