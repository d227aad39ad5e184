#pragma once

/// @file
/// The only list of optimizers: help, messages, docs and tests are made from it.

#include <array>
#include <string_view>
#include <vector>

#include "model/core/options.h"

namespace lipoid {

struct OptimizerEntry {
  std::string_view name;
  std::string_view library;
  std::string_view summary;
  std::vector<OptionDescription> (*options)();
};

[[nodiscard]] const std::vector<OptimizerEntry>& Optimizers();

}  // namespace lipoid
