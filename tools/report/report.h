#pragma once

/// @file
/// A result as one page for a browser: its summary, and the series of samples that its charts need.
/// The page needs no network: scripts and styles are part of it, and its data cannot become
/// commands (everything is escaped, and a Content-Security-Policy allows the page's own script
/// alone). tools/web has the front end. Tests: tests/tools/report_page_test.cc, tests/tools/pages.

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/core/json.h"

namespace lipoid {

/// Columns of equal length. Names carry the unit; what is not finite is a gap in the line.
struct Series {
  struct Column {
    std::string name;
    std::vector<double> values;
  };
  std::string kind;      ///< what it shows, by which a view finds it: "log", "flight"
  std::string name;      ///< which one it is, as the summary names it: the file of the log
  std::size_t rows = 0;  ///< how many it had before it was thinned
  std::size_t of = 0;    ///< which of the results it belongs to, where a summary has several
  std::vector<Column> columns = {};
};

/// What `--summary` writes, with `command` and `exit_code`, and the series that belong to it.
struct ReportResult {
  Json summary;
  std::vector<Series> series;
  std::vector<std::string> notes;  ///< what a reader must know, as of series that are not there
  std::string file;                ///< where the summary stood; "" where it comes from its command
};

/// Whether this program was built with the front end, which needs npm when it is built.
[[nodiscard]] bool CanReport();

/// OptionError that says what is missing where it was not.
void RequireReport();

/// The page. Its results are shown one under another.
[[nodiscard]] std::string ReportPage(std::span<const ReportResult> results);

}  // namespace lipoid
