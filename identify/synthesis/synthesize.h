#pragma once

/// @file
/// The lab's logs of a cell that is known: the exact response (4.46)-(4.51) under a protocol, with
/// noise and resolution where wanted, as plain CSV with a campaign file beside them and the truth
/// in a file of its own.
///
/// Each log begins full and relaxed with a row at rest and ends with the first row whose noise-free
/// voltage is at or below cut-off. Time stamps are the doubles nearest to their decimals and every
/// number is printed so that it reads back exactly: without noise, Predict() of the truth gives the
/// very same voltages. The same seed gives the same bytes with any number of threads. Tests:
/// tests/identify/synthesis/synthesize_test.cc.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "identify/synthesis/protocols.h"
#include "model/core/run_record.h"

namespace lipoid {

struct SynthesizedFile {
  std::string file;  ///< within the folder
  std::size_t rows = 0;
  std::size_t bytes = 0;
};

/// The files that Synthesize() writes, within the folder.
[[nodiscard]] std::vector<std::string> SynthesizedNames(const Cell& cell,
                                                        const Protocol& protocol,
                                                        const SynthesisOptions& options);

/// Whether an earlier Synthesize() wrote the folder: its truth is there.
[[nodiscard]] bool IsSynthesized(const std::string& folder);

/// What makes such logs hard to read, in sentences: noise beside which a current is hardly seen, a cell that warms in
/// logs without temperature.
[[nodiscard]] std::vector<std::string> DoubtsAboutSynthesis(const Cell& cell,
                                                            const Protocol& protocol,
                                                            const SynthesisOptions& options);

/// Writes the logs, campaign.toml and truth.json into the folder, which is made where it is
/// missing; all or none. `run` becomes part of truth.json. `progress` is called with a fraction,
/// from any thread. OptionError where an option does not suit the cell or a file cannot be written.
std::vector<SynthesizedFile> Synthesize(const Cell& cell,
                                        const Protocol& protocol,
                                        const SynthesisOptions& options,
                                        const RunRecord& run,
                                        const std::string& folder,
                                        const std::function<void(double)>& progress = {});

}  // namespace lipoid
