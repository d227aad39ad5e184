#include "tools/commands/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/json_text.h"
#include "model/core/run_record.h"

namespace lipoid {
namespace {

// The commands whose charts need samples.
constexpr std::array<std::string_view, 6> kWithSeries{
    "export", "fly", "identify", "inspect", "simulate", "validate"};

// What stands in the way of these files; "" where all are there as they were.
std::string WhatChanged(const Json& inputs) {
  for (const Json& input : inputs) {
    const auto& file = input.at("file").get_ref<const std::string&>();
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none))
      return fmt::format("{} is not there any more", ForeignText(file));
    try {
      if (Sha256OfFile(file) != input.at("sha256").get_ref<const std::string&>())
        return fmt::format("{} has another SHA-256 than it had", ForeignText(file));
    } catch (const LoadError& error) {
      return error.what();
    }
  }
  return "";
}

// A summary without what differs from run to run.
Json Comparable(const Json& value) {
  if (value.is_array()) {
    Json list = Json::array();
    for (const Json& item : value) list.push_back(Comparable(item));
    return list;
  }
  if (!value.is_object()) return value;
  constexpr std::array<std::string_view, 5> kOfTheRun{
      "commit", "messages", "output", "version", "wall_s"};
  Json object = Json::object();
  for (const auto& [key, member] : value.items()) {
    if (std::find(kOfTheRun.begin(), kOfTheRun.end(), key) == kOfTheRun.end())
      object[key] = Comparable(member);
  }
  return object;
}

// Whether the command, run again, found what the summary says.
bool FoundTheSame(const Json& again, const Json& earlier) {
  // As numbers are when they are written and read.
  const Json read = Comparable(Json::parse(JsonText(again)));
  return std::all_of(read.items().begin(), read.items().end(), [&](const auto& item) {
    const auto before = earlier.find(item.key());
    return before != earlier.end() && Comparable(*before) == item.value();
  });
}

}  // namespace

ReportResult Replayed(Json summary, std::span<const cli::Command> commands) {
  ReportResult result{std::move(summary), {}, {}, ""};
  const auto& name = result.summary.at("command").get_ref<const std::string&>();
  const bool has_series =
      std::find(kWithSeries.begin(), kWithSeries.end(), name) != kWithSeries.end();
  if (!has_series || result.summary.contains("error")) return result;
  const auto without = [&](std::string_view why) {
    result.series.clear();
    result.notes.push_back(fmt::format(
        "The charts of samples are not here: {}. Run `lipoid {}` again with --report.", why, name));
  };
  const auto run = result.summary.find("run");
  if (run == result.summary.end()) {
    without("the summary does not say how it was made, as those of earlier versions of lipoid");
    return result;
  }
  if (const std::string changed = WhatChanged(run->at("inputs")); !changed.empty()) {
    without(changed);
    return result;
  }
  const auto command = std::find_if(
      commands.begin(), commands.end(), [&](const auto& row) { return row.name == name; });
  try {
    cli::CommandLine line(*command, run->at("arguments").get<std::vector<std::string>>());
    line.Replay(result.summary);
    static_cast<void>(command->run(line));
    if (!line.parsed()) throw OptionError("its arguments ask for help alone");
    if (!FoundTheSame(line.summary(), result.summary)) {
      throw OptionError(
          fmt::format("run again, `lipoid {}` finds something else than the summary says, which "
                      "lipoid {} ({}) wrote",
                      name,
                      ForeignText(run->at("version").get_ref<const std::string&>()),
                      ForeignText(run->at("commit").get_ref<const std::string&>())));
    }
    result.series = std::move(line.report_series());
  } catch (const LoadError& error) {
    without(error.what());
  } catch (const OptionError& error) {
    without(error.what());
  }
  return result;
}

}  // namespace lipoid
