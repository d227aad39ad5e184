#include "model/core/text_cells.h"

#include <fast_float/fast_float.h>

#include <algorithm>

namespace lipoid {

std::string_view Trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty()) {
    if (is_blank(text.front())) {
      text.remove_prefix(1);
    } else if (text.starts_with("\xC2\xA0")) {
      text.remove_prefix(2);
    } else {
      break;
    }
  }
  while (!text.empty()) {
    if (is_blank(text.back())) {
      text.remove_suffix(1);
    } else if (text.ends_with("\xC2\xA0")) {
      text.remove_suffix(2);
    } else {
      break;
    }
  }
  return text;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

bool ParseNumber(std::string_view text, char decimal, double& value) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (text.empty()) return false;
  const auto* const end = text.data() + text.size();
  const fast_float::parse_options options(fast_float::chars_format::general, decimal);
  const auto result = fast_float::from_chars_advanced(text.data(), end, value, options);
  return result.ec == std::errc() && result.ptr == end;
}

void SplitLine(std::string_view line, char delimiter, std::vector<TextCell>& cells) {
  cells.clear();
  if (line.ends_with('\r')) line.remove_suffix(1);
  std::size_t begin = 0;
  while (true) {
    std::size_t first = begin;
    while (first < line.size() && line[first] == ' ') ++first;
    if (first < line.size() && line[first] == '"') {
      std::size_t close = first + 1;
      while (close < line.size() &&
             (line[close] != '"' || (close + 1 < line.size() && line[close + 1] == '"'))) {
        close += line[close] == '"' ? 2 : 1;
      }
      auto end = close < line.size() ? line.find(delimiter, close) : line.size();
      if (end == std::string_view::npos) end = line.size();
      const bool nothing_after =
          close < line.size() && Trimmed(line.substr(close + 1, end - close - 1)).empty();
      // A quote that never closes, or text after it, stays in the cell, which then is no number.
      cells.push_back({nothing_after ? Trimmed(line.substr(first + 1, close - first - 1))
                                     : Trimmed(line.substr(first, end - first)),
                       first + 1});
      if (end == line.size()) return;
      begin = end + 1;
      continue;
    }
    const auto end = std::min(line.find(delimiter, begin), line.size());
    const std::string_view text = Trimmed(line.substr(begin, end - begin));
    cells.push_back(
        {text, text.empty() ? begin + 1 : static_cast<std::size_t>(text.data() - line.data()) + 1});
    if (end == line.size()) return;
    begin = end + 1;
  }
}

std::string_view Unwrapped(std::string_view line, char delimiter) {
  const std::string_view text = Trimmed(line);
  if (text.size() < 3 || text.front() != '"' || text.back() != '"') return line;
  const std::string_view inside = text.substr(1, text.size() - 2);
  const bool one_text = inside.find('"') == std::string_view::npos &&
                        inside.find(delimiter) != std::string_view::npos;
  return one_text ? inside : line;
}

}  // namespace lipoid
