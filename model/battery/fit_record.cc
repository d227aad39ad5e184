#include "model/battery/fit_record.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

// The first reason for the verdict, in brackets; "" where a file gives none.
std::string Because(const Json& verdict) {
  const auto reasons = verdict.find("reasons");
  if (reasons == verdict.end() || !reasons->is_array() || reasons->empty()) return "";
  const Json& first = reasons->front();
  return first.is_string() ? fmt::format(" ({})", first.get<std::string>()) : "";
}

}  // namespace

const Json& FitMetric(const Cell& cell, const char* key) {
  static const Json kNull = nullptr;
  if (!cell.run || !cell.run->is_object() || !cell.run->contains("metrics")) return kNull;
  const Json& metrics = cell.run->at("metrics");
  return metrics.is_object() && metrics.contains(key) ? metrics.at(key) : kNull;
}

bool IsOfPoorFit(const Cell& cell) {
  const Json& verdict = FitMetric(cell, "verdict");
  return verdict.is_object() && verdict.value("grade", Json()) == "poor";
}

std::string DoubtAboutFit(const Cell& cell) {
  if (IsOfPoorFit(cell)) {
    return "lipoid identify judged its fit poor: do not rely on what it predicts" +
           Because(FitMetric(cell, "verdict"));
  }
  if (FitMetric(cell, "converged") == false) {
    return "the search for it ended before it had converged: do not rely on what it predicts";
  }
  return "";
}

}  // namespace lipoid
