#pragma once

/// @file
/// An option that names a cell (model/core/option_kinds.h): a file on the command line, in Python
/// also a cell.

#include <memory>
#include <string>

#include "model/battery/cell.h"
#include "model/core/option_kinds.h"

namespace lipoid {

struct CellSource : InputFile {
  std::shared_ptr<const Cell> cell = {};  ///< where it is not a file

  [[nodiscard]] bool given() const { return cell != nullptr || !path.empty(); }
  /// For the record.
  [[nodiscard]] std::string name() const { return cell ? cell->name : path; }
};

}  // namespace lipoid
