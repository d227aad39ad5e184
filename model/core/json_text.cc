#include "model/core/json_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

void Write(const Json& json, const std::string& margin, std::string& text) {
  const auto plain = [](const Json& one) {
    return one.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  const bool nested = std::any_of(
      json.begin(), json.end(), [](const Json& one) { return one.is_structured() && !one.empty(); });
  if (!json.is_structured() || json.empty()) {
    text += plain(json);
  } else if (json.is_array() && !nested) {
    const char* before = "[";
    for (const Json& one : json) {
      text += before + plain(one);
      before = ", ";
    }
    text += "]";
  } else {
    const std::string inner = margin + "  ";
    const char* before = json.is_array() ? "[\n" : "{\n";
    for (const auto& [key, value] : json.items()) {
      text += before + inner;
      if (json.is_object()) text += plain(Json(key)) + ": ";
      Write(value, inner, text);
      before = ",\n";
    }
    text += "\n" + margin + (json.is_array() ? "]" : "}");
  }
}

}  // namespace

std::string JsonText(const Json& json) {
  std::string text;
  Write(json, "", text);
  return text + "\n";
}

}  // namespace lipoid
