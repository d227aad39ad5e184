#include "identify/export/targets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "identify/export/fitted_targets.h"
#include "model/battery/curve_range.h"
#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "model/export/c_code.h"
#include "model/export/cell_numbers.h"
#include "model/export/cell_tables.h"
#include "model/export/export_error.h"
#include "model/export/fmi.h"
#include "model/export/pybamm.h"
#include "model/export/spice.h"

namespace lipoid {
namespace {

using enum TargetKind;

// clang-format off
constexpr std::array kTargets{
    ExportTarget{"ardupilot", "frame model (JSON) and parameters of ArduPilot's simulator SITL", kProjected, ".json", ".parm", "any 2026-06", "into", &ExportArduPilot},
    ExportTarget{"c", "header and source in C99 and C++, float or double, without allocation", kExact, ".h", ".c", "", "precision", &ExportC},
    ExportTarget{"fmi", "FMU for co-simulation and model exchange, with C sources and a library for this machine", kExact, ".fmu", "", "2 3", "", &ExportFmi},
    ExportTarget{"gazebo", "SDF element of Gazebo's LinearBatteryPlugin", kProjected, ".sdf", "", "harmonic fortress garden ionic jetty", "", &ExportGazebo},
    ExportTarget{"ns3", "attributes of ns-3's RvBatteryModel (ConfigStore text)", kProjected, ".txt", "", "3.42 3.37", "", &ExportNs3},
    ExportTarget{"px4", "numbers of PX4's battery estimator (QGroundControl .params)", kProjected, ".params", "", "", "", &ExportPx4},
    ExportTarget{"pybamm", "Python module with the parameters of PyBaMM's Thevenin model with diffusion", kExact, ".py", "", "", "", &ExportPybamm},
    ExportTarget{"simscape", "MATLAB script with the vectors of Simscape's table-based batteries", kProjected, ".m", "", "", "branches", &ExportSimscape},
    ExportTarget{"spice", "subcircuit for ngspice or LTspice: diffusion, tables, branches, state of charge", kExact, ".lib", "", "ngspice ltspice", "", &ExportSpice},
    ExportTarget{"tables", "CSV of v_oc, resistances and branches over the state of charge", kData, ".csv", "", "", "", &ExportTables},
    ExportTarget{"thevenin", "YAML of the Python package thevenin: 1 or 2 RC pairs, tables over the state of charge", kProjected, ".yaml", "", "", "branches", &ExportThevenin},
};
// clang-format on
static_assert(std::is_sorted(kTargets.begin(), kTargets.end(), [](const auto& a, const auto& b) {
  return a.name < b.name;
}));

// Numbers fitted beyond the ends of v_oc would be those of its end slope: a flat one makes a pack of
// many times the capacity.
void RefuseUnknownCurve(const ExportTarget& target, const ExportRequest& request) {
  if (target.kind != kProjected || KnowsCurve(request.cell, 0.0, 1.0)) return;
  const std::vector<double> soc = ReferenceOf(request).soc;
  const auto [lowest, highest] = std::minmax_element(soc.begin(), soc.end());
  const std::string doubt = DoubtAboutCurve(request.cell, *lowest, *highest);
  if (doubt.empty()) return;
  throw OptionError(fmt::format(
      "{} cannot be fitted over this mission: {}. Give a mission that stays within what is known, such as a log "
      "that the cell was identified from (--mission LOG, and --initial-soc where it did not start full)",
      target.name,
      doubt));
}

std::vector<std::string> Words(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    if (end > 0) words.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

}  // namespace

std::vector<std::string> ExportTarget::Versions() const { return Words(versions); }

std::vector<std::string> ExportTarget::FurtherSuffixes() const { return Words(further); }

bool ExportTarget::Takes(std::string_view option) const {
  const auto words = Words(options);
  return std::find(words.begin(), words.end(), option) != words.end();
}

std::span<const ExportTarget> ExportTargets() { return kTargets; }

const ExportTarget& FindExportTarget(std::string_view name) {
  return FindNamed("target", name, kTargets);
}

Exported Export(const ExportTarget& target, ExportRequest request) {
  const auto versions = target.Versions();
  if (request.target_version.empty()) {
    if (!versions.empty()) request.target_version = versions.front();
  } else if (std::find(versions.begin(), versions.end(), request.target_version) ==
             versions.end()) {
    throw OptionError(
        versions.empty()
            ? fmt::format("option --target-version: {} has no versions that differ; leave it out",
                          target.name)
            : fmt::format("option --target-version: expected one of {}, found '{}'",
                          fmt::join(versions, ", "),
                          request.target_version));
  }
  RefuseUnknownCurve(target, request);
  return target.make(request);
}

std::string IdentifierOf(std::string_view name) {
  constexpr std::size_t kLongest = 60;  // MATLAB's limit is 63 letters
  return Identifier(name).substr(0, kLongest);
}

}  // namespace lipoid
