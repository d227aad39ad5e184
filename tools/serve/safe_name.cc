#include "tools/serve/safe_name.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/core/foreign_text.h"
#include "model/core/text_cells.h"

namespace lipoid {
namespace {

constexpr std::size_t kMostBytes = 100;
constexpr std::size_t kMostBytesOfExtension = 12;

bool IsAlphanumeric(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// Some disks take no name that ends so.
void TrimEnd(std::string& name) {
  while (!name.empty() && (name.back() == ' ' || name.back() == '.')) name.pop_back();
}

}  // namespace

std::string SafeName(std::string_view given, const std::set<std::string>& taken) {
  // Windows' browsers of long ago sent whole paths.
  const auto slash = given.find_last_of("/\\");
  std::string name(given.substr(slash == given.npos ? 0 : slash + 1));
  const bool foreign = ForeignText(name, name.size() + 1) != name;
  for (char& c : name) {
    constexpr std::string_view kOthers = " ._-+,()@";
    const bool beyond_ascii = static_cast<unsigned char>(c) >= 0x80 && !foreign;
    if (!IsAlphanumeric(c) && kOthers.find(c) == kOthers.npos && !beyond_ascii) c = '_';
  }
  TrimEnd(name);
  const auto dot = name.rfind('.');
  const bool has_extension = dot != name.npos && name.size() - dot <= kMostBytesOfExtension;
  const std::string extension = has_extension ? name.substr(dot) : "";
  std::string stem = name.substr(0, name.size() - extension.size());
  stem.erase(stem.begin(), std::find_if(stem.begin(), stem.end(), [](char c) {
               return IsAlphanumeric(c) || static_cast<unsigned char>(c) >= 0x80;
             }));
  if (stem.empty()) stem = "log";
  if (stem.size() + extension.size() > kMostBytes) {
    std::size_t bytes = kMostBytes - extension.size();
    while ((static_cast<unsigned char>(stem[bytes]) & 0xC0) == 0x80) --bytes;  // within a character
    stem.resize(bytes);
    TrimEnd(stem);
  }
  const auto is_taken = [&](const std::string& candidate) {
    return std::any_of(taken.begin(), taken.end(), [&](const std::string& other) {
      return LowerCase(other) == LowerCase(candidate);
    });
  };
  std::string free = stem + extension;
  for (int k = 2; is_taken(free); ++k) free = fmt::format("{}-{}{}", stem, k, extension);
  return free;
}

}  // namespace lipoid
