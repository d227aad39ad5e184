#pragma once

/// @file
/// What the projected targets have in common. Tests: tests/identify/export/targets_test.cc.

#include <vector>

#include "identify/export/projection.h"
#include "model/export/export_error.h"
#include "model/export/exported.h"

namespace lipoid {

/// The full voltage of a law stays within this share of the cell's own, v_oc(1): a mission alone
/// would let it wander (a resistance and a voltage do the same to a current that hardly changes).
inline constexpr double kFullTolerance = 0.02;

/// One cell of the pack over its share of the mission: what numbers are fitted to.
struct SingleCell {
  explicit SingleCell(const ExportRequest& request);

  Cell cell;
  ExportMission mission;
  Prediction reference;
  std::vector<double> drawn_Ah;

  /// What the drop under a steady current is about, in Ohm: series resistance, branches and the
  /// quasi-static share of the diffusion, at the cell's middle; above 0.
  [[nodiscard]] double TypicalResistance() const;
};

/// Whether numbers were found; where not, a note says why and the errors are not there.
[[nodiscard]] bool Usable(const Projection& projection, Exported& exported);

/// A note on parameters that stand at a bound and on a search that was cut short.
void AddBoundNotes(const Projection& projection, Exported& exported);

/// A note where the mission starts under load and the law, whose drop is filtered, at rest.
void AddStartNote(const ExportRequest& request, Exported& exported);

}  // namespace lipoid
