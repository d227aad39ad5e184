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
  /// Of the text of a campaign file, or of what was given where that is empty. `sha256` are the sums
  /// of an earlier one, which is made anew, perhaps elsewhere: Logs() refuses other files.
  PythonCampaign(Campaign campaign,
                 std::vector<std::optional<PythonLog>> given,
                 std::string text,
                 std::vector<std::string> sha256);

  [[nodiscard]] const Campaign& campaign() const { return campaign_; }
  [[nodiscard]] const std::vector<std::optional<PythonLog>>& given() const { return given_; }
  [[nodiscard]] const std::string& text() const { return text_; }
  /// The campaign file and its logs; of logs in memory the names.
  [[nodiscard]] std::vector<std::string> Inputs() const;
  /// Of the inputs, once they are read or where an earlier campaign read them; else none.
  [[nodiscard]] std::vector<std::string> Sums() const;
  /// Read at the first call, kept for later ones. Needs no lock of the interpreter.
  [[nodiscard]] const std::vector<LoadedLog>& Logs() const;
  /// The files and their sums when they were read; of logs in memory the sum of their columns.
  void AddInputsTo(RunRecord& run) const;

 private:
  void AddSums() const;

  Campaign campaign_;
  std::string text_;
  std::vector<std::string> earlier_;             // sums that the inputs had
  std::vector<std::optional<PythonLog>> given_;  // of the campaign's logs, those in memory
  mutable std::mutex mutex_;
  mutable std::optional<std::vector<LoadedLog>> logs_;
  mutable std::vector<std::string> files_;
  mutable std::vector<std::string> sha256_;
};

void AddCampaigns(nb::module_& module);

}  // namespace lipoid::python
