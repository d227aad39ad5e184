#include "tools/report/summary_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "tools/report/summary_schemas.h"  // written by the build

namespace lipoid {
namespace {

constexpr std::string_view kSchemaSuffix = ".summary.schema";

bool HasType(const Json& value, const std::string& type) {
  if (type == "number" || type == "null") return value.is_number() || value.is_null();
  if (type == "array") return value.is_array();
  if (type == "object") return value.is_object();
  if (type == "string") return value.is_string();
  return type == "boolean" && value.is_boolean();
}

std::string Words(const std::string& type) {
  if (type == "array") return "a list";
  if (type == "object") return "an object";
  if (type == "string") return "a text";
  if (type == "boolean") return "true or false";
  return "a number";
}

// The part of JSON Schema that tools/schemas writes: type, properties, required and items, of which
// those with the key `error` may have a schema of their own. The depth is that of the schema, whatever the file holds. The schemas were found from some runs: what had
// a value in all of them may have none in others, but in `exact` schemas, and which parameters there are (`by_name`)
// depends on the cell.
void Check(const Json& schema, const Json& value, const JsonReader& at, bool by_name = false) {
  if (value.is_null() && !schema.contains("exact")) return;
  if (const auto found = schema.find("type"); found != schema.end()) {
    const auto types = found->is_array() ? found->get<std::vector<std::string>>()
                                         : std::vector{found->get<std::string>()};
    const auto has = [&](const std::string& type) { return HasType(value, type); };
    if (std::none_of(types.begin(), types.end(), has)) {
      std::vector<std::string> words;
      for (const auto& type : types) {
        if (type != "null") words.push_back(Words(type));
      }
      at.Fail(fmt::format("{}", fmt::join(words, " or ")));
    }
  }
  if (value.is_object()) {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!by_name) static_cast<void>(at.At(key.get<std::string>()));
    }
    const Json known = schema.value("properties", Json::object());
    for (const auto& [key, of_key] : known.items()) {
      // Options are those of the run: which there are depends on what was asked for.
      if (std::string_view(key).ends_with("options")) continue;
      // The run record of a cell in it is not shown.
      if (key == "metrics") continue;
      if (const auto member = value.find(key); member != value.end())
        Check(of_key, *member, at.At(key), key == "parameters" || key == "spread");
    }
  }
  if (!value.is_array() || !schema.contains("items")) return;
  const Json& items = schema["items"];
  for (std::size_t k = 0; k < value.size(); ++k) {
    const bool failed = value[k].is_object() && value[k].contains("error");
    Check(items.contains("if") ? items.at(failed ? "then" : "else") : items, value[k], at.Item(k));
  }
}

// Of any command: the runs that the schemas were found from need not have had an input.
const Json& SchemaOfRun() {
  static const Json schema = [] {
    const Json text = {{"type", "string"}, {"exact", true}};
    const Json input = {{"type", "object"},
                        {"exact", true},
                        {"required", {"file", "sha256"}},
                        {"properties", {{"file", text}, {"sha256", text}}}};
    return Json{{"type", "object"},
                {"exact", true},
                {"required", {"arguments", "version", "commit", "inputs"}},
                {"properties",
                 {{"arguments", {{"type", "array"}, {"exact", true}, {"items", text}}},
                  {"version", text},
                  {"commit", text},
                  {"inputs", {{"type", "array"}, {"exact", true}, {"items", input}}}}}};
  }();
  return schema;
}

const Json& SchemaOf(const std::string& command, const JsonReader& at) {
  static std::map<std::string, Json> parsed;
  for (const auto& [name, text] : kSummarySchemas) {
    if (name != command + std::string(kSchemaSuffix)) continue;
    auto& schema = parsed[command];
    if (schema.is_null()) schema = Json::parse(text);
    return schema;
  }
  at.Fail(fmt::format("one of the commands whose results can be shown ({})",
                      fmt::join(CommandsWithReport(), ", ")));
}

}  // namespace

std::vector<std::string> CommandsWithReport() {
  std::vector<std::string> commands;
  for (const auto& entry : kSummarySchemas)
    commands.emplace_back(entry.name.substr(0, entry.name.size() - kSchemaSuffix.size()));
  return commands;
}

Json ReadSummary(const std::string& file) {
  const std::string text = ReadTextFile(file);
  Json summary = ParseJson(text, file);
  const JsonReader reader(summary, file, text);
  if (summary.is_object() && summary.value("schema", Json()) == kCellSchema) {
    throw LoadError(
        NoFile(file),
        "expected the results of a command, found a cell file; what made it writes a page, too: "
        "lipoid identify CAMPAIGN --report PAGE");
  }
  if (!summary.is_object() || !summary.contains("command"))
    reader.Fail("what `lipoid COMMAND --summary` writes, an object with the key 'command'");
  const auto command = reader.At("command");
  const Json& schema = SchemaOf(command.Text(), command);
  Check(schema.at(summary.contains("error") ? "then" : "else"), summary, reader);
  if (const auto run = reader.Find("run")) Check(SchemaOfRun(), summary.at("run"), *run);
  return summary;
}

}  // namespace lipoid
