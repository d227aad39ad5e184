#include "tools/cli/assignments.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/core/errors.h"
#include "model/core/options.h"
#include "tools/cli/split.h"

namespace lipoid {
namespace {

double Number(const std::string& option, const std::string& name, const std::string& text) {
  return options_internal::ParseDouble(option + " " + name, text, Range{});
}

}  // namespace

std::vector<std::pair<std::string, double>> ParseAssignments(
    const std::string& option, const std::vector<std::string>& texts) {
  std::vector<std::pair<std::string, double>> all;
  for (const std::string& text : texts) {
    for (const std::string& piece : SplitAt(text, ',')) {
      const auto equals = piece.find('=');
      if (equals == std::string::npos) {
        throw OptionError(fmt::format("option {}: expected NAME=VALUE, found '{}'", option, text));
      }
      const auto name = piece.substr(0, equals);
      all.emplace_back(name, Number(option, name, piece.substr(equals + 1)));
    }
  }
  return all;
}

std::vector<std::pair<std::string, std::pair<double, double>>> ParseRanges(
    const std::string& option, const std::vector<std::string>& texts) {
  std::vector<std::pair<std::string, std::pair<double, double>>> all;
  for (const std::string& text : texts) {
    const auto equals = text.find('=');
    const auto ends = equals == std::string::npos ? std::vector<std::string>{}
                                                  : SplitAt(text.substr(equals + 1), ',');
    if (ends.size() != 2) {
      throw OptionError(fmt::format("option {}: expected NAME=LOW,HIGH, found '{}'", option, text));
    }
    const auto name = text.substr(0, equals);
    all.emplace_back(name, std::pair{Number(option, name, ends[0]), Number(option, name, ends[1])});
  }
  return all;
}

}  // namespace lipoid
