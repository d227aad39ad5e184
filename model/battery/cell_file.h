#pragma once

/// @file
/// The cell file, schema "lipoid.cell/1": JSON, described in docs/formats.md.
/// Tests: tests/model/battery/cell_file_test.cc.

#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

inline constexpr const char* kCellSchema = "lipoid.cell/1";

/// Reads a cell file strictly: another schema, an unknown or missing key, a value outside its range
/// are LoadErrors with line, column and pointer.
[[nodiscard]] Cell ParseCell(const std::string& text, const std::string& file);

[[nodiscard]] Json CellToJson(const Cell& cell);

/// Whole or not at all.
void WriteCellFile(const Cell& cell, const std::string& file);

/// Names of the cells that are shipped, sorted.
[[nodiscard]] std::vector<std::string> ShippedCellNames();

/// The bytes of a shipped cell by name, else of the file of that name. LoadError names both ways where
/// neither is.
[[nodiscard]] std::string CellText(const std::string& name_or_file);

/// A shipped cell by name, else the cell file of that name. LoadError names both ways where neither
/// is.
[[nodiscard]] Cell LoadCell(const std::string& name_or_file);

}  // namespace lipoid
