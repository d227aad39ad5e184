#include "identify/logs/formats/find_header.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "model/core/foreign_text.h"

namespace lipoid {
namespace {

// A header stands within this many lines.
constexpr std::size_t kPreambleLines = 2000;

constexpr char kDelimiters[] = {'\t', ';', ','};

constexpr Quantity kNeeded[] = {Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage};

bool IsNumber(std::string_view text) {
  double value = 0.0;
  return ParseNumber(text, '.', value) || ParseNumber(text, ',', value);
}

bool LooksLikeData(std::span<const TextCell> cells) {
  return cells.size() >= 2 && std::all_of(cells.begin(), cells.end(), [](const TextCell& cell) {
           return cell.text.empty() || IsNumber(cell.text);
         });
}

std::vector<HeaderName> NamesOf(std::string_view line, char delimiter) {
  std::vector<HeaderName> names = {};
  for (const TextCell& cell : CellsOf(line, delimiter)) names.push_back(ParseHeaderName(cell));
  while (!names.empty() && names.back().text.empty()) names.pop_back();
  return names;
}

// How many of time, current and voltage the header names.
std::size_t CountNeeded(const FoundHeader& header, const ReadOptions& options) {
  std::size_t count = 0;
  for (const Quantity quantity : kNeeded) {
    bool found = !header.Find(quantity, options).empty();
    if (!found && quantity == Quantity::kTime) {
      found = !FindColumns(header.names, quantity, header.layout->date).empty() ||
              !FindColumns(header.names, quantity, header.layout->step_clock).empty();
    }
    count += found ? 1 : 0;
  }
  return count;
}

bool HasNeeded(const FoundHeader& header, std::size_t count, const ReadOptions& options) {
  if (count == std::size(kNeeded)) return true;
  return options.voltage_optional && count + 1 == std::size(kNeeded) &&
         header.Find(Quantity::kVoltage, options).empty();
}

// The levels above a header of rows that starts with empty fields.
bool FindLevels(const std::vector<HeadLine>& lines, std::size_t index, FoundHeader& header) {
  std::size_t indent = 0;
  while (indent < header.names.size() && header.names[indent].text.empty()) ++indent;
  const auto& signatures = header.layout->level_signatures;
  if (indent == 0 || signatures.empty()) return true;
  if (indent != signatures.size() || index < indent) return false;
  for (std::size_t level = 0; level < indent; ++level) {
    auto names = NamesOf(lines[index - indent + level].text, header.delimiter);
    if (names.size() <= level || !Matches(names, signatures[level])) return false;
    names.erase(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(level));
    header.levels.push_back(std::move(names));
  }
  return true;
}

bool IsColumnNumber(std::string_view name) {
  name = Trimmed(name);
  return !name.empty() && name.size() <= 6 && name.front() != '0' &&
         name.find_first_not_of("0123456789") == name.npos;
}

bool AllNumbered(const ReadOptions& options) {
  return !options.columns.empty() &&
         std::all_of(options.columns.begin(), options.columns.end(), [](const auto& column) {
           return IsColumnNumber(column.second);
         });
}

// Numbers of columns are clear below a line of names, none of them a number, that rows of numbers
// follow at once or after a line of units.
bool IsNumbered(const std::vector<HeadLine>& lines, const FoundHeader& header) {
  constexpr std::size_t kUnits = 1;
  if (std::any_of(header.names.begin(), header.names.end(), [](const HeaderName& name) {
        return IsNumber(name.text);
      }))
    return false;
  for (std::size_t k = header.line; k < std::min(header.line + 1 + kUnits, lines.size()); ++k) {
    const auto cells = CellsOf(lines[k].text, header.delimiter);
    if (cells.size() >= header.names.size() && LooksLikeData(cells)) return true;
  }
  return false;
}

// A table without a header, whose columns the user names by their numbers: "time_s=1 voltage_V=2".
std::optional<FoundHeader> FindNumbered(const std::vector<HeadLine>& lines,
                                        const ReadOptions& options) {
  if (!AllNumbered(options)) return std::nullopt;
  for (std::size_t index = 0; index < lines.size(); ++index) {
    const std::string_view text = Trimmed(lines[index].text);
    if (text.empty() || text.front() == '#') continue;
    for (const char delimiter : kDelimiters) {
      const auto cells = CellsOf(lines[index].text, delimiter);
      if (!LooksLikeData(cells)) continue;
      std::string numbers;
      for (std::size_t k = 1; k <= cells.size(); ++k) {
        if (cells.back().text.empty() && k == cells.size()) break;  // a delimiter at the end
        numbers += fmt::format("{}{}", k > 1 ? "," : "", k);
      }
      return FoundHeader{.layout = &kPlainCsv,
                         .delimiter = delimiter,
                         .line = index + 1,
                         .implied = true,
                         .names = NamesOf(numbers, ',')};
    }
    return std::nullopt;
  }
  return std::nullopt;
}

std::optional<FoundHeader> SearchHeader(const std::vector<HeadLine>& lines,
                                        std::span<const Layout* const> formats,
                                        const ReadOptions& options,
                                        FoundHeader& nearest) {
  if (auto numbered = FindNumbered(lines, options)) return numbered;
  std::size_t nearest_count = 0;
  bool first_with_text = true;
  for (std::size_t index = 0; index < lines.size(); ++index) {
    const std::string_view text = Trimmed(lines[index].text);
    if (text.empty()) continue;
    if (std::exchange(first_with_text, false)) {
      for (const Layout* layout : formats) {
        if (!layout->is_row || !layout->is_row(CellsOf(text, ','))) continue;
        return FoundHeader{.layout = layout,
                           .delimiter = ',',
                           .line = index + 1,
                           .implied = true,
                           .names = NamesOf(layout->implied_header, ',')};
      }
    }
    if (text.front() == '#' || (text.front() >= '0' && text.front() <= '9')) continue;
    for (const char delimiter : kDelimiters) {
      if (text.find(delimiter) == std::string_view::npos) continue;
      FoundHeader header{.delimiter = delimiter,
                         .line = index + 1,
                         .names = NamesOf(lines[index].text, delimiter)};
      if (header.names.size() < 2) continue;
      header.numbered = IsNumbered(lines, header);
      for (const Layout* layout : formats) {
        header.layout = layout;
        header.levels.clear();
        if (layout->signature[0].empty()) continue;
        if (Matches(header.names, layout->signature) && FindLevels(lines, index, header))
          return header;
      }
      header.layout = &kPlainCsv;
      const std::size_t count = CountNeeded(header, options);
      if (HasNeeded(header, count, options)) return header;
      if (count > nearest_count) {
        nearest_count = count;
        nearest = header;
      }
    }
  }
  return std::nullopt;
}

// What may be wrong with a line that should be a header.
std::string_view Suspicion(std::string_view line) {
  if (!IsUtf8(line)) return "the file is not UTF-8: save it so; ";
  const bool separated = line.find_first_of("\t;,") != std::string_view::npos;
  const std::vector<TextCell> words = CellsOf(line, ' ');
  const auto filled = std::count_if(
      words.begin(), words.end(), [](const TextCell& word) { return !word.text.empty(); });
  if (!separated && filled >= std::ssize(kNeeded))
    return "what stands apart by blanks is one column: put TAB, ; or , between them; ";
  return "";
}

// Of a line, for a message.
std::string Beginning(std::string_view line) {
  std::string found(Trimmed(line).substr(0, 60));
  for (char& c : found) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return found;
}

[[noreturn]] void Refuse(bool log, SourcePosition position, std::string message) {
  if (log) throw LoadError(std::move(position), std::move(message));
  throw NoLogError(std::move(position), std::move(message));
}

[[noreturn]] void RefuseUnknown(const TextSource& source,
                                const std::vector<HeadLine>& lines,
                                const FoundHeader& nearest,
                                const ReadOptions& options) {
  for (const HeadLine& line : lines) {
    if (line.text.find("***End_of_Header***") == std::string_view::npos) continue;
    throw LoadError({source.file()},
                    "expected a header that names time, current and voltage, found a LabVIEW text "
                    "(.lvm), which describes its columns in prose; save the rows under a header "
                    "such as time_s,current_A,voltage_V");
  }
  const auto first = std::find_if(lines.begin(), lines.end(), [](const HeadLine& line) {
    return !Trimmed(line.text).empty() && Trimmed(line.text).front() != '#';
  });
  const std::size_t line =
      first == lines.end() ? 1 : static_cast<std::size_t>(first - lines.begin()) + 1;
  if (first == lines.end())
    throw LoadError({source.file()}, "expected a log, found only blank lines and comments");
  for (const char delimiter : kDelimiters) {
    if (!LooksLikeData(CellsOf(first->text, delimiter))) continue;
    throw LoadError(
        {source.file(), line, 1},
        "expected a header that names the columns, found numbers; add one line on top, such as "
        "time_s,current_A,voltage_V, or number the columns from 1 (--columns time_s=1 current_A=2 "
        "voltage_V=3 --units s,A,V)");
  }
  if (AllNumbered(options)) {
    throw LoadError(
        {source.file(), line, 1},
        fmt::format(
            "expected rows with the columns that --columns numbers, below at most a line of names and "
            "one of units, found '{}'; this file has a header: name the columns as it does "
            "(--columns time_s=\"...\")",
            Beginning(first->text)));
  }
  if (nearest.layout) {
    std::vector<std::string> wanted;
    std::vector<std::string> missing;
    std::vector<std::string> to_say;
    std::vector<HeaderName> names = nearest.names;
    for (const Quantity quantity : kNeeded) {
      if (quantity == Quantity::kVoltage && options.voltage_optional) continue;
      wanted.emplace_back(Name(quantity));
      if (!nearest.Find(quantity, options).empty()) continue;
      const auto named = options.columns.find(std::string(Key(quantity)));
      missing.push_back(named == options.columns.end() ? wanted.back()
                                                       : fmt::format("'{}'", named->second));
      to_say.push_back(fmt::format("{}=\"...\"", Key(quantity)));
      // What is in its unit comes first: long lists are cut.
      std::stable_partition(names.begin(), names.end(), [&](const HeaderName& name) {
        return FindUnit(quantity, name.unit.empty() ? name.suffix : name.unit).has_value();
      });
    }
    Refuse(missing.size() == 1,
           {source.file(), nearest.line, 1},
           fmt::format("expected columns for {} and {}, found none for {} among {}; name them as "
                       "the header does (--columns {}, or `columns` in a campaign)",
                       fmt::join(wanted.begin(), wanted.end() - 1, ", "),
                       wanted.back(),
                       fmt::join(missing, " and "),
                       Listed(names),
                       fmt::join(to_say, " ")));
  }
  const bool numbers = std::any_of(lines.begin(), lines.end(), [](const HeadLine& each) {
    return std::any_of(std::begin(kDelimiters), std::end(kDelimiters), [&](char delimiter) {
      return LooksLikeData(CellsOf(each.text, delimiter));
    });
  });
  Refuse(numbers,
         {source.file(), line, 1},
         fmt::format(
             "expected a header that names time, current and voltage, such as "
             "time_s,current_A,voltage_V, found '{}'; {}`lipoid list formats` shows what is read",
             Beginning(first->text),
             Suspicion(first->text)));
}

}  // namespace

std::vector<HeadLine> HeadLines(std::string_view head, char line_end) {
  std::vector<HeadLine> lines;
  for (std::size_t at = 0; at < head.size() && lines.size() < kPreambleLines;) {
    const auto end = std::min(head.find(line_end, at), head.size());
    lines.push_back({head.substr(at, end - at), std::min(end + 1, head.size())});
    at = end + 1;
  }
  return lines;
}

std::vector<TextCell> CellsOf(std::string_view line, char delimiter) {
  std::vector<TextCell> cells;
  SplitLine(Unwrapped(line, delimiter), delimiter, cells);
  return cells;
}

std::vector<HeaderMatch> FoundHeader::Find(Quantity quantity, const ReadOptions& options) const {
  const auto named = options.columns.find(std::string(Key(quantity)));
  if (named == options.columns.end()) {
    return FindColumns(names, quantity, layout->Of(quantity));
  }
  std::vector<HeaderMatch> matches;
  for (std::size_t field = 0; field < names.size(); ++field) {
    const HeaderName& name = names[field];
    const bool by_number = numbered && Trimmed(named->second) == std::to_string(field + 1);
    if (!by_number && LowerCase(name.text) != LowerCase(Trimmed(named->second))) continue;
    HeaderMatch match{.field = field, .unit = name.unit};
    if (match.unit.empty() && FindUnit(quantity, name.suffix)) match.unit = name.suffix;
    if (match.unit.empty() && FindUnit(quantity, name.name)) match.unit = name.name;
    for (const Quantity other : kMeasured) {  // voltage_V, which a user names as the current
      const auto found = FindColumns(std::span(&name, 1), other, layout->Of(other));
      if (match.unit.empty() && !found.empty() && !found.front().unit_is_wrong)
        match.unit = found.front().unit;
    }
    match.unit_is_wrong = !match.unit.empty() && !FindUnit(quantity, match.unit);
    matches.push_back(std::move(match));
  }
  return matches;
}

std::string Listed(const std::vector<HeaderName>& names) {
  constexpr std::size_t kMost = 12;
  std::vector<std::string> shown;
  for (const HeaderName& name : names) {
    if (!name.text.empty() && shown.size() < kMost) shown.push_back(name.text.substr(0, 40));
  }
  return fmt::format("{}{}", fmt::join(shown, ", "), names.size() > kMost ? ", ..." : "");
}

FoundHeader FindHeader(const TextSource& source,
                       const std::vector<HeadLine>& lines,
                       std::span<const Layout* const> formats,
                       const ReadOptions& options) {
  FoundHeader nearest;
  auto header = SearchHeader(lines, formats, options, nearest);
  if (!header) RefuseUnknown(source, lines, nearest, options);
  return std::move(*header);
}

}  // namespace lipoid
