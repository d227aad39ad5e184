#include "tools/cli/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "model/core/errors.h"

namespace lipoid::cli {
namespace {

// Letters, not bytes: names of files may be UTF-8.
std::size_t Letters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

constexpr std::size_t kColumns = 100;  // of a screen
constexpr std::size_t kComfortable = 40;
constexpr std::size_t kLeastOfWords = 10;  // of a column of words: narrower is no pleasure to read

// A unit stays with its stroke: "/ mV" is one word.
std::size_t EndOfWord(const std::string& text, std::size_t from) {
  const auto to = std::min(text.find(' ', from), text.size());
  return to == from + 1 && text[from] == '/' ? std::min(text.find(' ', to + 1), text.size()) : to;
}

std::size_t Indent(const std::string& text) {
  return std::min(text.find_first_not_of(' '), text.size());
}

// With the indent, which each of its lines has.
std::size_t LongestWord(const std::string& text) {
  std::size_t longest = 0;
  for (std::size_t from = Indent(text); from < text.size();) {
    const auto to = EndOfWord(text, from);
    longest = std::max(longest, Letters(text.substr(from, to - from)));
    from = to + 1;
  }
  return Indent(text) + longest;
}

// The text in lines of at most so many letters, if its words let it; it keeps its indent.
std::vector<std::string> LinesOf(const std::string& text, std::size_t width) {
  if (Letters(text) <= width) return {text};
  const auto indent = Indent(text);
  std::vector<std::string> lines{std::string(indent, ' ')};
  for (std::size_t from = indent; from < text.size();) {
    const auto to = EndOfWord(text, from);
    const std::string word = text.substr(from, to - from);
    const bool first = lines.back().size() == indent;
    if (!first && Letters(lines.back()) + 1 + Letters(word) > width) {
      lines.emplace_back(indent, ' ');
      lines.back() += word;
    } else {
      lines.back() += (first ? "" : " ") + word;
    }
    from = to + 1;
  }
  return lines;
}

// Takes the folder that all names in a column have in common away; "   a/b" keeps its indent.
void TakeCommonFolder(std::vector<std::vector<std::string>>& rows, std::size_t column) {
  std::string common;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string& name = rows[r][column];
    const auto same = std::mismatch(common.begin(), common.end(), name.begin(), name.end());
    common = r == 0 ? name : std::string(common.begin(), same.first);
  }
  const auto stroke = common.rfind('/');
  if (stroke == common.npos) return;
  const auto indent = Indent(common);
  for (auto& row : rows) row[column].erase(indent, stroke + 1 - indent);
}

thread_local TablesForPaper* for_paper = nullptr;

}  // namespace

TablesForPaper::TablesForPaper() {
  Require(for_paper == nullptr, "tables are kept once");
  for_paper = this;
}

TablesForPaper::~TablesForPaper() { for_paper = nullptr; }

void TablesForPaper::About(std::string_view what) {
  if (for_paper != nullptr) for_paper->about_ = what.empty() ? "" : fmt::format("{}: ", what);
}

void TextTable::Row(std::vector<std::string> cells) {
  Require(cells.size() == columns_.size(), "as many cells as columns");
  rows_.push_back(std::move(cells));
}

std::string TextTable::Text() const {
  if (for_paper != nullptr && !caption_.empty())
    for_paper->latex_ += "\n" + Latex(for_paper->about_);
  auto rows = rows_;
  // What a column wants, and what it needs at least: whole numbers, and words that may stand below
  // one another.
  std::vector<std::size_t> width;
  std::vector<std::size_t> least;
  const auto measure = [&] {
    width.clear();
    least.clear();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const bool words = columns_[c].align != Align::kRight;
      width.push_back(Letters(columns_[c].header));
      least.push_back(LongestWord(columns_[c].header));
      for (const auto& row : rows) {
        width[c] = std::max(width[c], Letters(row[c]));
        least[c] = std::max(least[c], words ? LongestWord(row[c]) : Letters(row[c]));
      }
      if (words) least[c] = std::max(least[c], std::min(width[c], kLeastOfWords));
    }
  };
  const auto total = [&] {
    return std::accumulate(width.begin(), width.end(), 2 * (width.size() - 1));
  };
  measure();
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].align != Align::kFile || total() <= kColumns) continue;
    TakeCommonFolder(rows, c);
    measure();
  }
  // The widest words give way first, down to lines that read well, then the headers of numbers.
  for (const auto& [words, comfortable] : {std::pair{true, kComfortable},
                                           std::pair{false, std::size_t{0}},
                                           std::pair{true, std::size_t{0}}}) {
    while (total() > kColumns) {
      std::size_t widest = columns_.size();
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        if ((columns_[c].align != Align::kRight) == words &&
            width[c] > std::max(least[c], comfortable) &&
            (widest == columns_.size() || width[c] > width[widest]))
          widest = c;
      }
      if (widest == columns_.size()) break;
      --width[widest];
    }
  }

  std::string text;
  const auto add = [&](const std::vector<std::string>& cells, bool header) {
    std::vector<std::vector<std::string>> lines;
    std::size_t height = 0;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      lines.push_back(LinesOf(cells[c], width[c]));
      height = std::max(height, lines.back().size());
    }
    for (auto& cell : lines) {  // a header stands right above its column
      cell.insert(header ? cell.begin() : cell.end(), height - cell.size(), "");
    }
    for (std::size_t line = 0; line < height; ++line) {
      for (std::size_t c = 0; c < cells.size(); ++c) {
        const std::string& cell = lines[c][line];
        const std::string blank(width[c] - std::min(width[c], Letters(cell)), ' ');
        if (c > 0) text += "  ";
        text += columns_[c].align == Align::kRight ? blank + cell : cell + blank;
      }
      text.erase(text.find_last_not_of(' ') + 1);
      text += '\n';
    }
  };
  std::vector<std::string> headers;
  for (const auto& column : columns_) headers.push_back(column.header);
  add(headers, true);
  for (const auto& row : rows) add(row, false);
  return text;
}

std::string LatexText(std::string_view words) {
  constexpr std::pair<std::string_view, std::string_view> kReplaced[] = {
      {"\\", "\\textbackslash{}"},
      {"{", "\\{"},
      {"}", "\\}"},
      {"%", "\\%"},
      {"_", "\\_"},
      {"&", "\\&"},
      {"#", "\\#"},
      {"$", "\\$"},
      {"~", "\\textasciitilde{}"},
      {"^-1/2", "\\textsuperscript{-1/2}"},
      {"^", "\\textasciicircum{}"},
      {"<", "\\textless{}"},
      {">", "\\textgreater{}"},
      {"²", "\\textsuperscript{2}"},
      {"³", "\\textsuperscript{3}"},
      {"Ω", "$\\Omega$"},
      {"°", "$^\\circ$"},
      {"√", "$\\surd$"},
      {"µ", "$\\mu$"},
      {"±", "$\\pm$"},
      {"–", "--"},
  };
  std::string text;
  while (!words.empty()) {
    const auto* const found =
        std::find_if(std::begin(kReplaced), std::end(kReplaced), [&](const auto& replaced) {
          return words.substr(0, replaced.first.size()) == replaced.first;
        });
    if (found == std::end(kReplaced)) {
      text += words.front();
      words.remove_prefix(1);
    } else {
      text += found->second;
      words.remove_prefix(found->first.size());
    }
  }
  return text;
}

std::string TextTable::Latex(std::string_view about) const {
  std::string kinds;
  for (const auto& column : columns_) kinds += column.align == Align::kRight ? 'r' : 'l';
  const auto line = [](const auto& cells, auto&& text_of) {
    std::string text = "    ";
    for (std::size_t c = 0; c < cells.size(); ++c)
      text += (c > 0 ? " & " : "") + LatexText(text_of(cells[c]));
    return text + " \\\\\n";
  };
  std::string text = fmt::format(
      "\\begin{{table}}\n  \\centering\n  \\caption{{{}}}\n  \\begin{{tabular}}{{{}}}\n    "
      "\\toprule\n",
      LatexText(fmt::format("{}{}", about, caption_)),
      kinds);
  text += line(columns_, [](const Column& column) { return column.header; });
  text += "    \\midrule\n";
  for (const auto& row : rows_) text += line(row, [](const std::string& cell) { return cell; });
  return text + "    \\bottomrule\n  \\end{tabular}\n\\end{table}\n";
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

std::string Wrapped(const std::string& text, std::size_t indent) {
  std::string wrapped;
  std::size_t column = indent;
  for (std::size_t from = 0; from < text.size();) {
    const auto to = std::min(text.find(' ', from), text.size());
    auto word = text.substr(from, to - from);
    // A list of names without blanks that fills more than a line breaks after a comma.
    while (word.size() > kColumns - indent) {
      const auto comma = word.rfind(',', kColumns - indent - 1);
      if (comma == std::string::npos) break;
      if (column > indent) wrapped += '\n' + std::string(indent, ' ');
      wrapped += word.substr(0, comma + 1) + '\n' + std::string(indent, ' ');
      word.erase(0, comma + 1);
      column = indent;
    }
    if (column > indent && column + 1 + word.size() > kColumns) {
      wrapped += '\n' + std::string(indent, ' ');
      column = indent;
    }
    if (column > indent) {
      wrapped += ' ';
      ++column;
    }
    wrapped += word;
    column += word.size();
    from = to + 1;
  }
  return wrapped;
}

std::string WrappedLines(const std::string& text) {
  std::string wrapped;
  for (std::size_t from = 0; from <= text.size();) {
    const auto to = std::min(text.find('\n', from), text.size());
    wrapped += (from > 0 ? "\n" : "") + Wrapped(text.substr(from, to - from));
    from = to + 1;
  }
  return wrapped;
}

std::string Bullets(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return "";
  std::string text = fmt::format("{}\n", title);
  for (const auto& sentence : sentences) text += "   - " + Wrapped(sentence, 5) + "\n";
  return text;
}

}  // namespace lipoid::cli
