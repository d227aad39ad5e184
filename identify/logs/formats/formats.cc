#include "identify/logs/formats/formats.h"

#include "identify/logs/formats/find_header.h"
#include "identify/logs/formats/packed.h"

namespace lipoid {
namespace {

// The only list of log formats.
constexpr const Layout* kFormats[] = {&kArbin,
                                      &kBasytec,
                                      &kBatteryDataFormat,
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

bool IsNoLog(const std::string& file, const ReadOptions& options) {
  try {
    TextSource source(file);
    (void)PlanReading(source, options);
  } catch (const NoLogError&) {
    return true;
  } catch (const LoadError&) {
    // It may be a log that cannot be read.
  }
  return false;
}

}  // namespace lipoid
