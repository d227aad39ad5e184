#include "identify/exchanged_temperatures.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "identify/trust/edges.h"

namespace lipoid {
namespace {

struct LogAndTemperature {
  const LogErrors* errors = nullptr;
  double degC = 0.0;
  std::vector<EdgeGroup> groups = {};
};

std::vector<LogAndTemperature> ByTemperature(const std::vector<LogErrors>& errors,
                                             const std::vector<LoadedLog>& logs) {
  std::vector<LogAndTemperature> found;
  for (const LogErrors& of : errors) {
    const auto log = std::find_if(logs.begin(), logs.end(), [&](const LoadedLog& each) {
      return each.entry.file == of.file;
    });
    if (log == logs.end()) continue;
    const Column& measured_degC = log->log.record.temperature_degC;
    if (measured_degC.empty() && !log->entry.ambient_degC) continue;
    double degC = log->entry.ambient_degC.value_or(0.0);
    if (!measured_degC.empty()) {
      degC = 0.0;
      for (const double each : measured_degC)
        degC += each / static_cast<double>(measured_degC.size());
    }
    found.push_back({&of, degC, GroupEdges(of.edges)});
  }
  return found;
}

// The group of the warm log in which the colder one shows least; none where one of them does not show less.
const EdgeGroup* LessInTheCold(const LogAndTemperature& cold,
                               const LogAndTemperature& warm,
                               double& cold_Ohm) {
  constexpr double kClearly = 0.85;
  const EdgeGroup* least = nullptr;
  double least_ratio = std::numeric_limits<double>::infinity();
  for (const EdgeGroup& at : warm.groups) {
    const auto same =
        std::find_if(cold.groups.begin(), cold.groups.end(), [&](const EdgeGroup& each) {
          return each.after_s == at.after_s && each.low_soc == at.low_soc;
        });
    if (same == cold.groups.end()) continue;
    const double ratio = same->measured_Ohm / at.measured_Ohm;
    if (!(ratio < kClearly)) return nullptr;
    if (ratio >= least_ratio) continue;
    least_ratio = ratio;
    least = &at;
    cold_Ohm = same->measured_Ohm;
  }
  return least;
}

}  // namespace

std::string DoubtAboutExchangedTemperatures(const std::vector<LogErrors>& errors,
                                            const std::vector<LoadedLog>& logs) {
  constexpr double kApart_K = 8.0;
  const std::vector<LogAndTemperature> all = ByTemperature(errors, logs);
  for (const LogAndTemperature& cold : all) {
    for (const LogAndTemperature& warm : all) {
      if (warm.degC - cold.degC < kApart_K) continue;
      double cold_Ohm = 0.0;
      const EdgeGroup* at = LessInTheCold(cold, warm, cold_Ohm);
      if (at == nullptr) continue;
      return fmt::format(
          "{} shows {:.3g} mOhm after {:g} s at {:.3g} degC, and {} shows {:.3g} mOhm at {:.3g} degC: a cell has more "
          "resistance in the cold. Are the temperatures of the two exchanged, or is one of them another cell?",
          cold.errors->file,
          1e3 * cold_Ohm,
          at->after_s,
          cold.degC,
          warm.errors->file,
          1e3 * at->measured_Ohm,
          warm.degC);
    }
  }
  return "";
}

}  // namespace lipoid
