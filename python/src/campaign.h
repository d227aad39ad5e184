#pragma once

/// @file
/// A campaign as Python sees it: its description, and its logs once they are read.

#include <nanobind/nanobind.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/load_campaign.h"
#include "model/core/run_record.h"
#include "python/src/log.h"

namespace lipoid::python {

class PythonCampaign {
 public:
  explicit PythonCampaign(Campaign campaign, std::vector<std::optional<PythonLog>> given = {});

  [[nodiscard]] const Campaign& campaign() const { return campaign_; }
  [[nodiscard]] const std::vector<std::optional<PythonLog>>& given() const { return given_; }
  /// Read at the first call, kept for later ones. Needs no lock of the interpreter.
  [[nodiscard]] const std::vector<LoadedLog>& Logs() const;
  /// The files and their sums when they were read; of logs in memory the sum of their columns.
  void AddInputsTo(RunRecord& run) const;

 private:
  void AddSums() const;

  Campaign campaign_;
  std::vector<std::optional<PythonLog>> given_;  // of the campaign's logs, those in memory
  mutable std::mutex mutex_;
  mutable std::optional<std::vector<LoadedLog>> logs_;
  mutable std::vector<std::string> files_;
  mutable std::vector<std::string> sha256_;
};

void AddCampaigns(nb::module_& module);

}  // namespace lipoid::python
