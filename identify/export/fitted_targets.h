#pragma once

/// @file
/// The targets whose numbers are fitted to the cell; each is written by a file of its own. Tests:
/// tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// A frame model (JSON) for ArduPilot SITL's option --model and a parameter file. Fits full voltage,
/// capacity and resistance; writes the frame's three battery keys, into the frame of
/// request.into_text where there is one. LoadError where that is no frame. Law:
/// model/export/ardupilot_law.h.
[[nodiscard]] Exported ExportArduPilot(const ExportRequest& request);

/// The SDF element of a LinearBatteryPlugin. Fits e0, e1, resistance and smoothing; the capacity is
/// the cell's usable one. Law: model/export/gazebo_law.h.
[[nodiscard]] Exported ExportGazebo(const ExportRequest& request);

/// Attributes of ns-3's RvBatteryModel as a text of its ConfigStore. The model is the diffusion of
/// the cell, (4.46) to (4.48), without the tail of its sum, in mA and minutes; its voltage is a
/// constant, so that the error is one of the state of charge. Fits beta, which makes up for the
/// tail; alpha is the pack's own.
[[nodiscard]] Exported ExportNs3(const ExportRequest& request);

/// The numbers of PX4's battery estimator as a parameter file of QGroundControl. Fits empty and
/// charged voltage and the resistance; the capacity is the cell's usable one. Law:
/// model/export/px4_law.h.
[[nodiscard]] Exported ExportPx4(const ExportRequest& request);

/// A MATLAB script with the vectors of the blocks Battery (Table-Based) of Simscape Electrical and
/// Battery Equivalent Circuit of Simscape Battery. The circuit is that of ExportThevenin().
[[nodiscard]] Exported ExportSimscape(const ExportRequest& request);

/// The YAML file of the Python package thevenin, an equivalent circuit of one cell: one or two pairs
/// of resistor and capacitor (request.branches), resistances over the state of charge; v_oc and
/// capacity are the cell's own. Law: model/export/equivalent_circuit_law.h.
[[nodiscard]] Exported ExportThevenin(const ExportRequest& request);

}  // namespace lipoid
