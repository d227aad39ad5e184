#include "tools/cli/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/core/errors.h"

namespace lipoid::cli {
namespace {

// Letters, not bytes: names of files may be UTF-8.
std::size_t Letters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

void TextTable::Row(std::vector<std::string> cells) {
  Require(cells.size() == columns_.size(), "as many cells as columns");
  rows_.push_back(std::move(cells));
}

std::string TextTable::Text() const {
  std::vector<std::size_t> width;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    width.push_back(Letters(columns_[c].header));
    for (const auto& row : rows_) width[c] = std::max(width[c], Letters(row[c]));
  }
  std::string text;
  const auto add = [&](std::size_t c, const std::string& cell) {
    const std::string blank(width[c] - Letters(cell), ' ');
    if (c > 0) text += "  ";
    text += columns_[c].align == Align::kRight ? blank + cell : cell + blank;
  };
  const auto end_line = [&] {
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  };
  for (std::size_t c = 0; c < columns_.size(); ++c) add(c, columns_[c].header);
  end_line();
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < columns_.size(); ++c) add(c, row[c]);
    end_line();
  }
  return text;
}

std::string Significant(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (value == 0.0 || std::isinf(value)) return fmt::format("{}", value);
  // Rounding may carry into the next power of ten: take the exponent after it.
  auto scientific = fmt::format("{:.{}e}", value, digits - 1);
  const int exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  if (exponent < -4 || exponent >= 9) return scientific;
  return fmt::format("{:.{}f}", value, std::max(0, digits - 1 - exponent));
}

std::string Bullets(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return "";
  std::string text = fmt::format("{}\n", title);
  for (const auto& sentence : sentences) {
    std::string line = "   -";
    for (std::size_t from = 0; from < sentence.size();) {
      const auto to = std::min(sentence.find(' ', from), sentence.size());
      if (line.size() + 1 + (to - from) > 100) {
        text += line + "\n";
        line = "    ";
      }
      line += " " + sentence.substr(from, to - from);
      from = to + 1;
    }
    text += line + "\n";
  }
  return text;
}

}  // namespace lipoid::cli
