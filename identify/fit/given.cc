#include "identify/fit/given.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

template <class Map>
auto Find(const Map& map, const std::string& name) {
  const auto found = map.find(name);
  return found == map.end() ? std::nullopt : std::optional(found->second);
}

const CellParameterKind& KindOf(std::string_view option,
                                const std::string& name,
                                const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw OptionError(fmt::format("--{}: no parameter '{}' in this fit; there are {}{}",
                                  option,
                                  name,
                                  fmt::join(names, ", "),
                                  name == "alpha" ? ", and --alpha-C gives alpha" : ""));
  }
  return *FindCellParameter(name)->kind;
}

void CheckValue(std::string_view option,
                const std::string& name,
                double value,
                const std::vector<std::string>& names) {
  const CellParameterKind& kind = KindOf(option, name, names);
  if (kind.Holds(value)) return;
  throw OptionError(fmt::format("--{} {}={}: expected {}", option, name, value, kind.expected));
}

}  // namespace

std::optional<double> GivenParameters::Fixed(const std::string& name) const {
  return Find(fixed, name);
}
std::optional<double> GivenParameters::Start(const std::string& name) const {
  return Find(start, name);
}
std::optional<std::pair<double, double>> GivenParameters::Bounds(const std::string& name) const {
  return Find(bounds, name);
}
std::optional<std::pair<double, double>> GivenParameters::Range(const std::string& name) const {
  if (const auto value = Fixed(name)) return std::pair{*value, *value};
  return Bounds(name);
}

bool GivenParameters::Mentions(const std::string& name) const {
  return fixed.count(name) + start.count(name) + bounds.count(name) > 0;
}
bool GivenParameters::NamesABranch() const {
  const auto any = [](const auto& map) {
    return std::any_of(map.begin(), map.end(), [](const auto& entry) {
      const auto name = FindCellParameter(entry.first);
      return name && name->kind->of_branch;
    });
  };
  return any(fixed) || any(start) || any(bounds);
}

std::vector<std::string> FitParameterNames(bool diffusion, int branches) {
  std::vector<std::string> names;
  if (diffusion) names.emplace_back("beta");
  names.emplace_back("r_s");
  for (const char* symbol : {"r", "tau", "c"}) {
    for (int j = 1; j <= branches; ++j) names.push_back(fmt::format("{}_{}", symbol, j));
  }
  return names;
}

void CheckGiven(const GivenParameters& given, const std::vector<std::string>& names) {
  for (const auto& [name, value] : given.fixed) CheckValue("fix", name, value, names);
  for (const auto& [name, value] : given.start) CheckValue("start", name, value, names);
  for (const auto& [name, range] : given.bounds) {
    const auto& [low, high] = range;
    const CellParameterKind& kind = KindOf("bounds", name, names);
    // An upper bound of infinity is none. A lower bound of 0 stands for the least there is.
    if (!(low >= 0.0 && low <= high && high <= kind.upper)) {
      throw OptionError(fmt::format("--bounds {}={},{}: expected 0 <= low <= high{}",
                                    name,
                                    low,
                                    high,
                                    kind.upper == 1.0 ? " <= 1" : ""));
    }
    if (!kind.zero && high == 0.0) {
      throw OptionError(fmt::format(
          "--bounds {}={},{}: expected {} at the upper end", name, low, high, kind.expected));
    }
    const auto within = [&, name = name, low = low, high = high](
                            std::string_view option, const std::optional<double>& value) {
      if (!value || (*value >= low && *value <= high)) return;
      throw OptionError(fmt::format(
          "--{0} {1}={2} lies outside --bounds {1}={3},{4}", option, name, *value, low, high));
    };
    within("fix", given.Fixed(name));
    within("start", given.Start(name));
  }
  for (const auto& [name, value] : given.start) {
    if (!given.Fixed(name)) continue;
    throw OptionError(fmt::format(
        "--start {}={}: --fix holds it, and what is held is not searched; leave one of the two out",
        name,
        value));
  }
  for (const std::string& name : names) {
    const auto found = FindCellParameter(name);
    if (found->kind->symbol != "tau") continue;
    const auto c = fmt::format("c_{}", found->branch + 1);
    if (given.Mentions(name) && given.Mentions(c))
      throw OptionError(fmt::format("give either {} or {}, not both", c, name));
  }
}

}  // namespace lipoid
