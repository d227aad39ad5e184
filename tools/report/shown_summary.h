#pragma once

/// @file
/// The summary of a command as a page needs it. Tests: tests/tools/report_page_test.cc.

#include "model/core/json.h"

namespace lipoid {

/// The same without what no chart shows and what would make the page large: of each cell the
/// metrics of its run, which the summary has beside it, and the covariance, of which the page needs
/// `uncertainty.{parameters, standard_errors, reach_95}` alone. reach_95 is how many standard
/// errors a 95 % interval reaches to either side. Whatever is not as `identify` writes it stays.
[[nodiscard]] Json ShownSummary(Json summary);

}  // namespace lipoid
