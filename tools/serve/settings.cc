#include "tools/serve/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "model/battery/ranges.h"
#include "tools/cli/split.h"
#include "tools/serve/http_server.h"

namespace lipoid {
namespace {

constexpr std::size_t kMostBytesOfName = 200;

std::optional<double> NumberOf(const Json& value, double lo, double hi, const std::string& what) {
  if (value.is_null()) return std::nullopt;
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= lo && number <= hi))
    throw HttpError(400, fmt::format("{}: expected a number from {} to {}", what, lo, hi));
  return number;
}

std::optional<int> CountOf(const Json& value, const std::string& what) {
  const auto number =
      NumberOf(value, static_cast<double>(kPackSizes.lo), static_cast<double>(kPackSizes.hi), what);
  if (!number) return std::nullopt;
  if (*number != std::floor(*number))
    throw HttpError(400, fmt::format("{}: expected a whole number", what));
  return static_cast<int>(*number);
}

}  // namespace

void OnlyKeys(const Json& object, std::initializer_list<std::string_view> known) {
  if (!object.is_object()) throw HttpError(400, "expected a JSON object");
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw HttpError(400, "a change has a key that is not known");
  }
}

std::string TextOf(const Json& value, const std::string& what) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMostBytesOfName)
    throw HttpError(400,
                    fmt::format("{}: expected at most {} bytes of text", what, kMostBytesOfName));
  auto text = value.get<std::string>();
  if (text.find('\0') != text.npos) throw HttpError(400, fmt::format("{}: expected text", what));
  return text;
}

std::optional<LogKind> KindNamed(std::string_view text) {
  for (const auto& [kind, name] : OptionNames(LogKind{})) {
    if (name == text) return kind;
  }
  return std::nullopt;
}

void CellSettings::Change(const Json& change) {
  OnlyKeys(change, {"name", "capacity_Ah", "cutoff_V", "series", "parallel"});
  CellSettings changed = *this;
  if (change.contains("name")) {
    const Json& text = change["name"];
    changed.name = text.is_null() ? std::nullopt : std::optional(TextOf(text, "name"));
  }
  if (change.contains("capacity_Ah"))
    changed.capacity_Ah = NumberOf(change["capacity_Ah"], 1e-9, 1e6, "capacity in Ah");
  if (change.contains("cutoff_V"))
    changed.cutoff_V = NumberOf(change["cutoff_V"], 0.5, 6.0, "cut-off in V");
  if (change.contains("series")) changed.series = CountOf(change["series"], "cells in series");
  if (change.contains("parallel"))
    changed.parallel = CountOf(change["parallel"], "cells in parallel");
  *this = std::move(changed);
}

Json CellSettings::ToJson() const {
  return {{"name", NullOr(name)},
          {"capacity_Ah", NullOr(capacity_Ah)},
          {"cutoff_V", NullOr(cutoff_V)},
          {"series", NullOr(series)},
          {"parallel", NullOr(parallel)}};
}

std::vector<std::string> CellSettings::PackArguments() const {
  std::vector<std::string> arguments;
  if (series) arguments.push_back(fmt::format("--series={}", *series));
  if (parallel) arguments.push_back(fmt::format("--parallel={}", *parallel));
  return arguments;
}

std::vector<std::string> CellSettings::DraftArguments() const {
  std::vector<std::string> arguments = PackArguments();
  if (cutoff_V) arguments.push_back(fmt::format("--cutoff-V={}", *cutoff_V));
  return arguments;
}

void ReadingSettings::Change(const Json& change) {
  OnlyKeys(change, {"columns", "units", "current_sign", "hold", "battery"});
  Json changed = said_;
  for (const auto& [key, value] : change.items()) {
    if (key != "columns") {
      changed[key] = value.is_null() ? "" : TextOf(value, key);
      continue;
    }
    if (!value.is_array() || value.size() > 4)
      throw HttpError(400, "columns: expected a list of at most 4");
    changed[key] = Json::array();
    for (const Json& column : value) changed[key].push_back(TextOf(column, key));
  }
  said_ = std::move(changed);
}

void RowSettings::Change(const Json& change) {
  OnlyKeys(change, {"kind", "initial_soc", "ambient_degC"});
  RowSettings changed = *this;
  if (change.contains("kind")) {
    const Json& said = change["kind"];
    const std::string name = said.is_null() ? "" : TextOf(said, "kind");
    changed.kind = KindNamed(name);
    if (!name.empty() && !changed.kind)
      throw HttpError(400, "kind: expected a kind of log, or \"\" to leave it out");
    changed.left_out = said.is_string() && name.empty();
  }
  if (change.contains("initial_soc"))
    changed.initial_soc = NumberOf(change["initial_soc"],
                                   kInitialSocs.lo,
                                   kInitialSocs.hi,
                                   "state of charge at the start (1 is full)");
  if (change.contains("ambient_degC"))
    changed.ambient_degC = NumberOf(change["ambient_degC"],
                                    kTemperatures_degC.lo,
                                    kTemperatures_degC.hi,
                                    "temperature of the surroundings in degC");
  *this = changed;
}

std::vector<std::string> ReadingSettings::Arguments() const {
  std::vector<std::string> arguments;
  for (const Json& column : said_.value("columns", Json::array()))
    arguments.push_back("--columns=" + column.get<std::string>());
  for (const auto& [key, option] : {std::pair("units", "--units="),
                                    {"current_sign", "--current-sign="},
                                    {"hold", "--hold="},
                                    {"battery", "--battery="}}) {
    if (const auto value = said_.value(key, ""); !value.empty())
      arguments.push_back(option + value);
  }
  return arguments;
}

ReadOptions ReadingSettings::Options() const {
  ReadOptions read;
  for (const Json& column : said_.value("columns", Json::array())) {
    const auto text = column.get<std::string>();
    const auto equals = std::min(text.find('='), text.size());
    read.columns[text.substr(0, equals)] = text.substr(std::min(equals + 1, text.size()));
  }
  if (const auto units = said_.value("units", ""); !units.empty()) read.units = SplitAt(units, ',');
  read.current_sign = said_.value("current_sign", "");
  const std::string battery = said_.value("battery", "");
  std::from_chars(battery.data(), battery.data() + battery.size(), read.battery);  // or 0
  for (const auto& [hold, name] : OptionNames(Hold{})) {
    if (name == said_.value("hold", "")) read.hold = hold;
  }
  return read;
}

}  // namespace lipoid
