#pragma once

/// @file
/// What a person sets on the page: the data of the cell, and how its logs are read. A change comes
/// as JSON, in which each key may be missing and null is as lipoid finds it. A change that is wrong
/// is an HttpError, and changes nothing. Tests: tests/tools/serve_test.py.

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/log.h"
#include "model/core/json.h"

namespace lipoid {

/// HttpError unless `object` is one whose keys are all known.
void OnlyKeys(const Json& object, std::initializer_list<std::string_view> known);

/// A short text; HttpError for anything else, naming `what`.
[[nodiscard]] std::string TextOf(const Json& value, const std::string& what);

[[nodiscard]] std::optional<LogKind> KindNamed(std::string_view text);

/// The value of an optional, or null.
[[nodiscard]] Json NullOr(const auto& value) { return value ? Json(*value) : Json(nullptr); }

struct CellSettings {
  std::optional<std::string> name;
  std::optional<double> capacity_Ah;
  std::optional<double> cutoff_V;
  std::optional<int> series;
  std::optional<int> parallel;

  /// {"name": ..., "capacity_Ah": ..., "cutoff_V": ..., "series": ..., "parallel": ...}
  void Change(const Json& change);
  [[nodiscard]] Json ToJson() const;
  /// Of the pack, for `lipoid inspect` and `lipoid validate`.
  [[nodiscard]] std::vector<std::string> PackArguments() const;
  /// The same, and by what a draft knows its discharges.
  [[nodiscard]] std::vector<std::string> DraftArguments() const;
};

/// What a person says of a test; what is not said is as lipoid finds it.
struct RowSettings {
  std::optional<LogKind> kind;
  bool left_out = false;
  std::optional<double> initial_soc;
  std::optional<double> ambient_degC;

  /// {"kind": ..., "initial_soc": ..., "ambient_degC": ...}; the kind "" leaves the test out.
  void Change(const Json& change);
};

class ReadingSettings {
 public:
  /// {"columns": [...], "units": ..., "current_sign": ..., "hold": ..., "battery": ...}
  void Change(const Json& change);
  [[nodiscard]] const Json& ToJson() const { return said_; }
  /// For `lipoid inspect` and `lipoid validate`.
  [[nodiscard]] std::vector<std::string> Arguments() const;
  /// The same for a campaign.
  [[nodiscard]] ReadOptions Options() const;

 private:
  Json said_ = Json::object();
};

}  // namespace lipoid
