#include "identify/logs/formats/formats.h"

#include "identify/logs/formats/arbin.h"
#include "identify/logs/formats/basytec.h"
#include "identify/logs/formats/bdf.h"
#include "identify/logs/formats/betaflight.h"
#include "identify/logs/formats/biologic.h"
#include "identify/logs/formats/bitrode.h"
#include "identify/logs/formats/digatron.h"
#include "identify/logs/formats/find_header.h"
#include "identify/logs/formats/maccor.h"
#include "identify/logs/formats/neware.h"
#include "identify/logs/formats/novonix.h"
#include "identify/logs/formats/packed.h"
#include "identify/logs/formats/plain_csv.h"
#include "identify/logs/formats/simulated_flight.h"

namespace lipoid {
namespace {

// The only list of log formats.
constexpr const Layout* kFormats[] = {&kArbin,
                                      &kBasytec,
                                      &kBdf,
                                      &kBetaflight,
                                      &kBiologic,
                                      &kBitrode,
                                      &kDigatron,
                                      &kMaccor,
                                      &kNeware,
                                      &kNovonix,
                                      &kPlainCsv,
                                      &kSimulatedFlight};

}  // namespace

std::span<const Layout* const> LogFormats() { return kFormats; }

LogPlan PlanReading(TextSource& source, const ReadOptions& options) {
  RefusePacked(source.file(), source.head());
  const auto lines = HeadLines(source.head(), source.line_end());
  return PlanColumns(source, options, FindHeader(source, lines, kFormats, options), lines);
}

}  // namespace lipoid
