#include "identify/export/projected.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "model/battery/cell_parameters.h"

namespace lipoid {
namespace {

ExportMission ShareOf(ExportMission mission, int parallel) {
  for (double& current_A : mission.current_A) current_A /= parallel;
  return mission;
}

}  // namespace

SingleCell::SingleCell(const ExportRequest& request)
    : cell(request.cell.AsOne()),
      mission(ShareOf(request.mission, request.cell.parallel)),
      reference(ReferenceOf(request.Whole().AsOne(), mission)),
      drawn_Ah(ChargeDrawn_Ah(cell, mission)) {}

double SingleCell::TypicalResistance() const {
  double ohm = TotalResistance(cell, 0.5);
  if (cell.diffusion) {
    // pi²/(3 beta²) seconds of current are held back.
    constexpr double kPiSquaredOverThree = 3.289868133696453;
    const double slope_V = cell.open_circuit_voltage(0.8) - cell.open_circuit_voltage(0.3);
    const double beta = cell.diffusion->beta_per_sqrt_s;
    ohm += std::max(0.0, slope_V / 0.5) * kPiSquaredOverThree / (beta * beta) / cell.alpha_C();
  }
  constexpr double kLeast_Ohm = 1e-7;
  return std::max(ohm, kLeast_Ohm);
}

bool Usable(const Projection& projection, Exported& exported) {
  if (projection.termination != Termination::kFailure) return true;
  exported.notes.push_back("No numbers were found: " + projection.message);
  return false;
}

void AddBoundNotes(const Projection& projection, Exported& exported) {
  if (projection.termination == Termination::kMaxIterations)
    exported.notes.emplace_back(
        "The search for the best numbers was cut short: they may not be the best ones.");
  if (!projection.at_bound.empty()) {
    exported.notes.push_back(fmt::format(
        "{} {} at a bound, of what the target takes or of what is physical: beyond it this law would be "
        "nearer to the cell over this mission.",
        fmt::join(projection.at_bound, ", "),
        projection.at_bound.size() == 1 ? "stands" : "stand"));
  }
}

void AddStartNote(const ExportRequest& request, Exported& exported) {
  const double first_A = request.mission.current_A.front();
  if (first_A == 0.0) return;
  exported.notes.push_back(
      fmt::format("The mission starts under a load of {:.3g} A and this battery at rest: the first "
                  "rows carry the whole drop as an error.",
                  first_A));
}

}  // namespace lipoid
