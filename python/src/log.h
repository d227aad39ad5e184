#pragma once

/// @file
/// A log as Python sees it, and the ways in which one is read.

#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "identify/logs/log.h"
#include "identify/logs/reading_request.h"
#include "python/src/keywords.h"

namespace lipoid::python {

/// Shared by Python, by arrays over its columns, and by campaigns; never changes.
struct PythonLog {
  std::shared_ptr<const Log> log;

  /// The same log, whose columns are those of this one: nothing is copied.
  [[nodiscard]] Log Lent() const;
};

/// How logs are read: `request`, whose members are the defaults, and beyond what commands take the
/// keys of a log in a campaign file.
[[nodiscard]] ReadOptions ReadingOf(Keywords& keywords, ReadingRequest request, bool of_a_file);

void AddLogs(nb::module_& module);

}  // namespace lipoid::python
