#include "identify/export/export_report.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "model/battery/curve_range.h"
#include "model/export/provenance.h"

namespace lipoid {
namespace {

Json ErrorJson(const std::optional<ExportError>& error) {
  if (!error) return nullptr;
  return {{"rmse_V", NumberOrNull(error->rmse_V)},
          {"max_error_V", NumberOrNull(error->max_error_V)},
          {"worst_s", error->worst_s},
          {"worst_soc", error->worst_soc}};
}

Json ErrorJson(const std::optional<ExportChargeError>& error) {
  if (!error) return nullptr;
  return {{"rms", NumberOrNull(error->rms)},
          {"max_error", NumberOrNull(error->max_error)},
          {"worst_s", error->worst_s},
          {"lifetime_percent",
           error->lifetime_percent ? Json(*error->lifetime_percent) : Json(nullptr)}};
}

}  // namespace

ExportKind KindOfExport(const ExportTarget& target,
                        const ExportRequest& request,
                        const Exported& exported) {
  const std::string kind(options_internal::ToText(target.kind));
  const std::string without = WithoutWhatNoTargetHolds(request);
  const bool less = !without.empty() || !exported.cannot_hold.empty();
  if (target.kind != TargetKind::kExact || !less) return {kind, kind};
  return {"the cell's own law" + (without.empty() ? ", but for what it cannot hold" : without),
          "incomplete"};
}

Json ExportToJson(const ExportTarget& target,
                  const ExportRequest& request,
                  const Exported& exported) {
  Json summary;
  summary["target"] = target.name;
  summary["kind"] = KindOfExport(target, request, exported).key;
  const auto versions = target.Versions();
  summary["target_version"] = !request.target_version.empty() ? Json(request.target_version)
                              : versions.empty()              ? Json(nullptr)
                                                              : Json(versions.front());
  summary["series"] = request.cell.series;
  summary["parallel"] = request.cell.parallel;
  summary["parameters"] = Json::object();
  summary["units"] = Json::object();
  for (const auto& parameter : exported.parameters) {
    summary["parameters"][parameter.name] = NumberOrNull(parameter.value);
    summary["units"][parameter.name] = parameter.unit;
  }
  const Json error = ErrorJson(exported.error);
  for (const auto* const key : {"rmse_V", "max_error_V", "worst_s", "worst_soc"})
    summary[key] = error.is_null() ? Json(nullptr) : error[key];
  summary["naive"] = ErrorJson(exported.naive);
  summary["charge_error"] = ErrorJson(exported.charge_error);
  summary["naive_charge_error"] = ErrorJson(exported.naive_charge_error);
  summary["mission"] = request.mission.name;
  summary["mission_rows"] = request.mission.time_s.size();
  summary["initial_soc"] = request.mission.initial_soc;
  summary["cannot_hold"] = exported.cannot_hold;
  for (const auto& sentence : request.left_out) summary["cannot_hold"].push_back(sentence);
  summary["notes"] = exported.notes;
  if (const std::string doubt = DoubtAboutCurve(request.cell, 0.0, 1.0); !doubt.empty())
    summary["notes"].push_back(doubt + ".");
  summary["sha256"] = request.sha256;
  return summary;
}

std::string FileBeside(const std::string& output, const std::string& suffix) {
  const std::filesystem::path path(output);
  return (path.parent_path() / (path.stem().string() + suffix)).string();
}

}  // namespace lipoid
