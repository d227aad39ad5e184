#include "model/core/foreign_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace lipoid {
namespace {

struct Character {
  std::size_t bytes = 0;  // 0: not UTF-8
  std::uint32_t code = 0;
};

// The character that the text begins with.
Character FirstCharacter(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {1, first};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = first & (0xFFU >> (bytes + 1));
  for (std::size_t k = 1; k < bytes; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) return {};
    code = (code << 6U) | (byte(k) & 0x3FU);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < kLeast[bytes] || code > 0x10FFFF || surrogate) return {};
  return {bytes, code};
}

// Marks and overrides of the direction of writing, and separators that a terminal may obey.
bool MovesText(std::uint32_t code) {
  return code == 0x61C || (code >= 0x200B && code <= 0x200F) ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2060 && code <= 0x2069) || code == 0xFEFF;
}

std::string Escaped(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    const auto first = static_cast<unsigned char>(text[0]);
    const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
    if (first == '\n') {
      shown += "\\n";
    } else if (first == '\r') {
      shown += "\\r";
    } else if (first == '\t') {
      shown += "\\t";
    } else if (character.bytes == 0 || first < 0x20 || first == 0x7F) {
      shown += fmt::format("\\x{:02x}", first);
    } else if ((character.code >= 0x80 && character.code < 0xA0) || MovesText(character.code)) {
      shown += fmt::format("\\u{:04x}", character.code);
    } else {
      shown += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return shown;
}

// Moved up to where a character begins.
std::size_t CharacterStart(std::string_view text, std::size_t at) {
  while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  return at;
}

}  // namespace

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = FirstCharacter(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

std::string ForeignText(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) {
    std::string whole = Escaped(text);
    if (whole.size() <= most_bytes) return whole;
  }
  const std::string between = fmt::format(" ... ({} bytes) ... ", text.size());
  const std::size_t room = most_bytes - std::min(most_bytes, between.size());
  const std::size_t tail_room = room / 4;
  std::string head = Escaped(text.substr(0, most_bytes));
  while (head.size() > room - tail_room ||
         (!head.empty() && (static_cast<unsigned char>(head.back()) & 0xC0U) == 0x80U)) {
    head.pop_back();
  }
  if (!head.empty() && static_cast<unsigned char>(head.back()) >= 0xC0) head.pop_back();
  const std::size_t from = text.size() - std::min(text.size(), most_bytes);
  const std::string tail = Escaped(text.substr(CharacterStart(text, from)));
  const std::size_t tail_from = tail.size() - std::min(tail.size(), tail_room);
  return head + between + tail.substr(CharacterStart(tail, tail_from));
}

std::string ForeignLines(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    shown += ForeignText(text.substr(0, end), kMostBytesOfMessage);
    if (end < text.size()) shown += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return shown;
}

}  // namespace lipoid
