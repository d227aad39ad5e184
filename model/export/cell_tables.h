#pragma once

/// @file
/// A cell as a CSV table over its state of charge, and back. Lines that begin with "#:" hold its
/// other numbers, "#: alpha_C = 1353.6"; other lines that begin with # are comments.
///
///   soc,open_circuit_voltage_V,series_resistance_Ohm,resistance_1_Ohm,time_constant_1_s,...
///
/// Straight lines between rows; beyond them v_oc continues with its end slope, and resistances keep
/// their end values. Tests: tests/identify/export/import_cell_test.cc.

#include <string>

#include "model/battery/cell.h"
#include "model/export/exported.h"

namespace lipoid {

/// `comment`: lines that begin with "# ", which stand first.
[[nodiscard]] std::string CellTables(const Cell& cell, const std::string& comment);

struct TableDefaults {
  std::optional<double> capacity_Ah;
  std::optional<double> cutoff_V;
  std::string name = "imported";
};

/// Reads it strictly: an unknown column or key, a number that is none, a state of charge that does
/// not rise are LoadErrors with line and column. What the file does not say is taken from
/// `defaults`; a capacity must be said, a cut-off is v_oc(0) otherwise.
[[nodiscard]] Cell ParseCellTables(const std::string& text,
                                   const std::string& file,
                                   const TableDefaults& defaults = {});

/// The target tables: the law is the cell's own, up to the straight lines of its v_oc.
[[nodiscard]] Exported ExportTables(const ExportRequest& request);

}  // namespace lipoid
