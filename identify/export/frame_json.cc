#include "identify/export/frame_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/structured_text.h"

namespace lipoid {
namespace {

// Where the value of a key of the outermost object stands in valid JSON: from its first byte to the
// one behind its last.
std::optional<std::pair<std::size_t, std::size_t>> ValueOf(const std::string& json,
                                                           const std::string& key) {
  int depth = 0;
  bool key_is_it = false;
  for (std::size_t at = 0; at < json.size(); ++at) {
    const char c = json[at];
    if (c == '"') {
      std::size_t end = at + 1;
      while (json[end] != '"') end += json[end] == '\\' ? 2 : 1;
      std::size_t next = json.find_first_not_of(" \t\r\n", end + 1);
      key_is_it = depth == 1 && next != std::string::npos && json[next] == ':' &&
                  json.compare(at + 1, end - at - 1, key) == 0;
      at = end;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if (c == '}' || c == ']') {
      --depth;
    } else if (c == ':' && key_is_it) {
      const std::size_t begin = json.find_first_not_of(" \t\r\n", at + 1);
      std::size_t end = json.find_first_of(",}", begin);
      end = json.find_last_not_of(" \t\r\n", end - 1) + 1;
      return {{begin, end}};
    }
  }
  return std::nullopt;
}

}  // namespace

std::string FrameWithoutComments(const std::string& text, const std::string& file) {
  structured_text::CheckText(text, file);
  const std::size_t brace = text.find('{');
  if (brace == std::string::npos) {
    throw LoadError({file},
                    "expected a frame model of ArduPilot, which begins with '{', found none");
  }
  std::string json = text;
  const auto blank = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      if (json[k] != '\n') json[k] = ' ';
    }
  };
  blank(0, brace);
  for (std::size_t at = json.find('#', brace); at != std::string::npos; at = json.find('#', at)) {
    const std::size_t end = std::min(json.find('\n', at), json.size());
    blank(at, end);
    at = end;
  }
  return json;
}

std::string MergeIntoFrame(const std::string& text,
                           const std::string& file,
                           const std::vector<std::pair<std::string, std::string>>& numbers,
                           const std::string& lines) {
  std::string json = FrameWithoutComments(text, file);
  const Json parsed = ParseJson(json, file);
  const JsonReader frame(parsed, file, json);
  if (!frame.IsObject()) frame.Fail("a frame model of ArduPilot, an object");
  std::string merged = text;
  std::string first;
  for (const auto& [key, number] : numbers) {
    if (const auto own = frame.Find(key)) {
      if (!own->IsNumber()) own->Fail("a number");
      const auto place = ValueOf(json, key);
      Require(place.has_value(), "a key that was parsed stands in the text");
      const std::size_t length = place->second - place->first;
      merged.replace(place->first, length, number);
      json.replace(place->first, length, number);
    } else {
      first += "  \"" + key + "\": " + number + ",\n";
    }
  }
  const std::size_t brace = json.find('{');
  const std::size_t next = json.find_first_not_of(" \t\r\n", brace + 1);
  if (json[next] == '}' && !first.empty()) first.erase(first.size() - 2, 1);  // nothing follows
  merged.insert(brace + 1, "\n" + lines + first);
  return merged;
}

}  // namespace lipoid
