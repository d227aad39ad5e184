#pragma once

/// @file
/// What is said of the cell and the pack where logs make a campaign without a campaign file, declared
/// once: options of the commands that identify, and keywords of lipoid.Campaign().

#include <optional>
#include <string>

#include "identify/logs/campaign.h"
#include "model/battery/ranges.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

/// A row counts as often as the weight of its log: beyond these the sums over rows know nothing of the
/// other logs.
inline constexpr Range kWeights{1e-6, 1e6};

struct CampaignRequest {
  std::string name = {};
  std::optional<double> capacity_Ah = {};
  std::optional<double> cutoff_V = {};
  int series = 1;
  int parallel = 1;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("name", self.name, Word{"TEXT"}, "name of the cell");
    v("capacity_Ah", self.capacity_Ah, Range{1e-9, 1e9}, "nominal capacity of one cell");
    v("cutoff_V", self.cutoff_V, Range{0.0, 100.0}, "voltage of one cell that ends a discharge");
    v("series", self.series, kPackSizes, "cells in series in the logs");
    v("parallel", self.parallel, kPackSizes, "cells in parallel in the logs");
  }

  void ApplyTo(Campaign& campaign) const {
    campaign.name = name;
    if (capacity_Ah) campaign.capacity_Ah = *capacity_Ah;
    campaign.cutoff_V = cutoff_V;
    campaign.series = series;
    campaign.parallel = parallel;
  }
};

}  // namespace lipoid
