#include "tools/serve/job_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/nearest_name.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/serve/http_server.h"

namespace lipoid {
namespace {

constexpr std::size_t kMostOptions = 200;
constexpr std::size_t kMostBytesOfValue = 1000;

struct Offered {
  std::string_view command;
  std::string_view option;
};

// None takes a file; of --set that is for CheckSetting() to see to.
constexpr Offered kOffered[] = {
    {"identify", "method"},
    {"identify", "branches"},
    {"identify", "no-diffusion"},
    {"identify", "fix"},
    {"identify", "bounds"},
    {"identify", "start"},
    {"identify", "profile"},
    {"identify", "alpha-C"},
    {"identify", "seed"},
    {"identify", "set"},
    {"fly", "vehicle"},
    {"fly", "gains"},
    {"fly", "controller"},
    {"fly", "compensate"},
    {"fly", "estimate"},
    {"fly", "wind"},
    {"fly", "gusts"},
    {"fly", "duration"},
    {"fly", "land-below-V"},
    {"fly", "log-step-s"},
    {"fly", "ambient-degC"},
    {"fly", "payload-g"},
    {"fly", "capacity-Ah"},
    {"fly", "health"},
    {"fly", "resistance-factor"},
    {"fly", "initial-soc"},
    {"fly", "initial-voltage-V"},
    {"fly", "series"},
    {"fly", "parallel"},
    {"fly", "ensemble"},
    {"fly", "seed"},
    {"fly", "set"},
    {"validate", "initial-soc"},
    {"validate", "initial-voltage-V"},
    {"validate", "ambient-degC"},
    {"validate", "initial-degC"},
    {"validate", "predict-temperature"},
    {"validate", "series"},
    {"validate", "parallel"},
    {"validate", "seed"},
};

constexpr std::array<std::string_view, 3> kCommands = {"identify", "fly", "validate"};

// Where a file may be named, only the names that lipoid ships.
std::vector<std::string> ShippedFor(std::string_view option) {
  if (option == "vehicle") return ShippedVehicleNames();
  if (option == "gains") return ShippedGainsNames();
  return {};
}

std::vector<std::string> ManeuverNames() {
  std::vector<std::string> names;
  // What the maneuver waypoints flies along stands in a file.
  for (const Maneuver& maneuver : Maneuvers()) {
    if (maneuver.name != "waypoints") names.emplace_back(maneuver.name);
  }
  return names;
}

[[noreturn]] void Refuse(const std::string& message) { throw HttpError(400, message); }

std::string OneOf(const std::string& what,
                  const std::string& value,
                  const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), value) == known.end()) {
    Refuse(fmt::format(
        "{}: expected one of {}, found '{}'", what, fmt::join(known, ", "), ForeignText(value)));
  }
  return value;
}

// By --set the command takes its options as well, files among them: here only what it lists as settings,
// letter by letter.
void CheckSetting(const cli::CommandDescription& command, const std::string& assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos) {
    Refuse(fmt::format("option --set: expected OPTION=VALUE, found '{}'", ForeignText(assignment)));
  }
  const std::string name = assignment.substr(0, equals);
  std::vector<std::string> known;
  for (const auto& setting : command.settings) known.push_back(setting.name);
  if (std::find(known.begin(), known.end(), name) == known.end())
    Refuse("option --set: " + UnknownName("option", ForeignText(name), known));
}

std::string Text(const Json& value, const std::string& what) {
  if (!value.is_string()) Refuse(fmt::format("{}: expected text", what));
  const auto text = value.get<std::string>();
  if (text.size() > kMostBytesOfValue || text.find('\0') != std::string::npos)
    Refuse(fmt::format("{}: expected at most {} bytes of text", what, kMostBytesOfValue));
  return text;
}

int Number(const Json& value, const std::string& what) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 1'000'000'000)
    Refuse(fmt::format("{}: expected a number of the list", what));
  return value.get<int>();
}

}  // namespace

JobOptions::JobOptions(const std::vector<cli::CommandDescription>& all) {
  for (const std::string_view name : kCommands) {
    for (const cli::CommandDescription& description : all) {
      if (description.name != name) continue;
      cli::CommandDescription kept = description;
      std::erase_if(kept.options, [&](const cli::DescribedOption& option) {
        if (option.name == "report") reporting_.emplace_back(name);
        return std::none_of(std::begin(kOffered), std::end(kOffered), [&](const Offered& offered) {
          return offered.command == name && offered.option == option.name;
        });
      });
      commands_.push_back(std::move(kept));
    }
  }
}

const cli::CommandDescription* JobOptions::Find(std::string_view command) const {
  for (const auto& description : commands_) {
    if (description.name == command) return &description;
  }
  return nullptr;
}

bool JobOptions::Reports(std::string_view command) const {
  return std::find(reporting_.begin(), reporting_.end(), command) != reporting_.end();
}

JobRequest JobOptions::Read(const Json& asked) const {
  constexpr std::array<std::string_view, 6> kKeys = {
      "command", "options", "maneuver", "cell", "cell_of", "logs"};
  for (const auto& [key, value] : asked.items()) {
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end())
      Refuse(fmt::format("a job has no key '{}'", ForeignText(key)));
  }
  JobRequest request;
  request.command = Text(asked.value("command", Json()), "command");
  const cli::CommandDescription* const command = Find(request.command);
  if (command == nullptr) {
    Refuse(fmt::format("command: expected one of {}, found '{}'",
                       fmt::join(kCommands, ", "),
                       ForeignText(request.command)));
  }
  request.told = asked.value("options", Json::array());
  if (!request.told.is_array() || request.told.size() > kMostOptions)
    Refuse(fmt::format("options: expected a list of at most {}", kMostOptions));
  for (const Json& pair : request.told) {
    if (!pair.is_array() || pair.empty() || pair.size() > 2)
      Refuse("options: expected [name, value] or [name]");
    const std::string name = Text(pair[0], "options");
    const auto option = std::find_if(command->options.begin(),
                                     command->options.end(),
                                     [&](const auto& each) { return each.name == name; });
    if (option == command->options.end())
      Refuse(fmt::format(
          "lipoid serve takes no option --{} of {}", ForeignText(name), request.command));
    if (option->value.empty() != (pair.size() == 1))
      Refuse(fmt::format(
          "option --{}: expected {}", name, option->value.empty() ? "no value" : "a value"));
    if (pair.size() == 1) {
      request.options.push_back("--" + name);
      continue;
    }
    std::string value = Text(pair[1], "--" + name);
    if (const auto shipped = ShippedFor(name); !shipped.empty())
      value = OneOf("option --" + name, value, shipped);
    if (name == "set") CheckSetting(*command, value);
    request.options.push_back(fmt::format("--{}={}", name, value));
  }
  if (request.command == "fly")
    request.maneuver =
        OneOf("maneuver", Text(asked.value("maneuver", Json()), "maneuver"), ManeuverNames());
  if (request.command != "identify") {
    if (asked.contains("cell_of")) {
      request.cell_of = Number(asked["cell_of"], "cell_of");
    } else {
      request.cell = OneOf("cell", Text(asked.value("cell", Json()), "cell"), ShippedCellNames());
    }
  }
  if (request.command == "validate") {
    const Json logs = asked.value("logs", Json::array());
    if (!logs.is_array() || logs.empty() || logs.size() > kMostOptions)
      Refuse("logs: expected the numbers of at least one log");
    for (const Json& log : logs) request.logs.push_back(Number(log, "logs"));
  }
  return request;
}

Json JobOptions::ToJson() const {
  Json all = Json::object();
  for (const auto& command : commands_) {
    Json options = Json::array();
    for (const auto& option : command.options) {
      Json json = {{"name", option.name},
                   {"value", option.value},
                   {"default", option.default_text},
                   {"help", option.help},
                   {"several", option.several},
                   {"choices", option.Choices()}};
      if (const auto shipped = ShippedFor(option.name); !shipped.empty()) json["choices"] = shipped;
      options.push_back(std::move(json));
    }
    Json settings = Json::array();
    for (const auto& setting : command.settings) {
      settings.push_back({{"name", setting.name},
                          {"help", setting.help},
                          {"valid", setting.valid},
                          {"default", setting.default_text}});
    }
    all[command.name] = {{"summary", command.summary},
                         {"options", std::move(options)},
                         {"settings", std::move(settings)},
                         {"reports", Reports(command.name)}};
  }
  all["fly"]["maneuvers"] = ManeuverNames();
  all["fly"]["cells"] = ShippedCellNames();
  return all;
}

Json ParsedBody(const std::string& text) {
  try {
    Json json = ParseJson(text, "request");
    if (!json.is_object()) throw HttpError(400, "expected a JSON object");
    return json;
  } catch (const LoadError& error) {
    throw HttpError(400, error.what());
  }
}

}  // namespace lipoid
