#include "identify/logs/formats/formats.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/logs/formats/arbin.h"
#include "identify/logs/formats/basytec.h"
#include "identify/logs/formats/bdf.h"
#include "identify/logs/formats/betaflight.h"
#include "identify/logs/formats/biologic.h"
#include "identify/logs/formats/bitrode.h"
#include "identify/logs/formats/digatron.h"
#include "identify/logs/formats/header.h"
#include "identify/logs/formats/maccor.h"
#include "identify/logs/formats/neware.h"
#include "identify/logs/formats/novonix.h"
#include "identify/logs/formats/packed.h"
#include "identify/logs/formats/plain_csv.h"

namespace lipoid {
namespace {

// The only list of log formats.
constexpr const Layout* kFormats[] = {&kArbin,
                                      &kBasytec,
                                      &kBdf,
                                      &kBetaflight,
                                      &kBiologic,
                                      &kBitrode,
                                      &kDigatron,
                                      &kMaccor,
                                      &kNeware,
                                      &kNovonix,
                                      &kPlainCsv};

// A header stands within this many lines.
constexpr std::size_t kPreambleLines = 2000;

constexpr char kDelimiters[] = {'\t', ';', ','};

constexpr Quantity kNeeded[] = {Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage};

struct Line {
  std::string_view text;  // without its line end
  std::size_t next = 0;   // offset of the line after it
};

std::vector<Line> LinesOf(std::string_view head, char line_end) {
  std::vector<Line> lines;
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

bool IsNumber(std::string_view text) {
  double value = 0.0;
  return ParseNumber(text, '.', value) || ParseNumber(text, ',', value);
}

bool LooksLikeData(std::span<const TextCell> cells) {
  return cells.size() >= 2 && std::all_of(cells.begin(), cells.end(), [](const TextCell& cell) {
           return cell.text.empty() || IsNumber(cell.text);
         });
}

// A header that was found: in which line, in which format.
struct Header {
  const Layout* layout = nullptr;
  char delimiter = ',';
  std::size_t line = 1;  // number of the header's line; of the first row where it is implied
  bool implied = false;
  std::vector<HeaderName> names = {};                // of the rows' level, its indent included
  std::vector<std::vector<HeaderName>> levels = {};  // above it
};

std::vector<HeaderName> NamesOf(std::string_view line, char delimiter) {
  std::vector<HeaderName> names = {};
  for (const TextCell& cell : CellsOf(line, delimiter)) names.push_back(ParseHeaderName(cell));
  while (!names.empty() && names.back().text.empty()) names.pop_back();
  return names;
}

// The user's name for a column, or the usual ones.
std::vector<HeaderMatch> Find(const Header& header, Quantity quantity, const ReadOptions& options) {
  const auto named = options.columns.find(std::string(Key(quantity)));
  if (named == options.columns.end()) {
    return FindColumns(header.names, quantity, header.layout->Of(quantity));
  }
  std::vector<HeaderMatch> matches;
  for (std::size_t field = 0; field < header.names.size(); ++field) {
    const HeaderName& name = header.names[field];
    if (LowerCase(name.text) != LowerCase(Trimmed(named->second))) continue;
    HeaderMatch match{.field = field, .unit = name.unit};
    if (match.unit.empty() && FindUnit(quantity, name.suffix)) match.unit = name.suffix;
    if (match.unit.empty() && FindUnit(quantity, name.name)) match.unit = name.name;
    match.unit_is_wrong = !match.unit.empty() && !FindUnit(quantity, match.unit);
    matches.push_back(std::move(match));
  }
  return matches;
}

// How many of time, current and voltage the header names.
std::size_t CountNeeded(const Header& header, const ReadOptions& options) {
  std::size_t count = 0;
  for (const Quantity quantity : kNeeded) {
    bool found = !Find(header, quantity, options).empty();
    if (!found && quantity == Quantity::kTime) {
      found = !FindColumns(header.names, quantity, header.layout->date).empty() ||
              !FindColumns(header.names, quantity, header.layout->step_clock).empty();
    }
    count += found ? 1 : 0;
  }
  return count;
}

bool HasNeeded(const Header& header, std::size_t count, const ReadOptions& options) {
  if (count == std::size(kNeeded)) return true;
  return options.voltage_optional && count + 1 == std::size(kNeeded) &&
         Find(header, Quantity::kVoltage, options).empty();
}

// The levels above a header of rows that starts with empty fields.
bool FindLevels(const std::vector<Line>& lines, std::size_t index, Header& header) {
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

// A table without a header, whose columns the user names by their numbers: "time_s=1 voltage_V=2".
std::optional<Header> FindNumbered(const std::vector<Line>& lines, const ReadOptions& options) {
  if (options.columns.empty()) return std::nullopt;
  for (const auto& [key, name] : options.columns) {
    if (!IsColumnNumber(name)) return std::nullopt;
  }
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
      return Header{.layout = &kPlainCsv,
                    .delimiter = delimiter,
                    .line = index + 1,
                    .implied = true,
                    .names = NamesOf(numbers, ',')};
    }
    return std::nullopt;
  }
  return std::nullopt;
}

std::optional<Header> FindHeader(const std::vector<Line>& lines,
                                 const ReadOptions& options,
                                 Header& nearest) {
  if (auto numbered = FindNumbered(lines, options)) return numbered;
  std::size_t nearest_count = 0;
  bool first_with_text = true;
  for (std::size_t index = 0; index < lines.size(); ++index) {
    const std::string_view text = Trimmed(lines[index].text);
    if (text.empty()) continue;
    if (std::exchange(first_with_text, false)) {
      for (const Layout* layout : kFormats) {
        if (!layout->is_row || !layout->is_row(CellsOf(text, ','))) continue;
        return Header{.layout = layout,
                      .delimiter = ',',
                      .line = index + 1,
                      .implied = true,
                      .names = NamesOf(layout->implied_header, ',')};
      }
    }
    if (text.front() == '#' || (text.front() >= '0' && text.front() <= '9')) continue;
    for (const char delimiter : kDelimiters) {
      if (text.find(delimiter) == std::string_view::npos) continue;
      Header header{.delimiter = delimiter,
                    .line = index + 1,
                    .names = NamesOf(lines[index].text, delimiter)};
      if (header.names.size() < 2) continue;
      for (const Layout* layout : kFormats) {
        header.layout = layout;
        header.levels.clear();
        if (layout->signature.empty()) continue;
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

std::string Listed(const std::vector<HeaderName>& names) {
  constexpr std::size_t kMost = 12;
  std::vector<std::string> shown;
  for (const HeaderName& name : names) {
    if (!name.text.empty() && shown.size() < kMost) shown.push_back(name.text.substr(0, 40));
  }
  return fmt::format("{}{}", fmt::join(shown, ", "), names.size() > kMost ? ", ..." : "");
}

[[noreturn]] void RefuseUnknown(const TextSource& source,
                                const std::vector<Line>& lines,
                                const Header& nearest,
                                const ReadOptions& options) {
  for (const Line& line : lines) {
    if (line.text.find("***End_of_Header***") == std::string_view::npos) continue;
    throw LoadError({source.file()},
                    "expected a header that names time, current and voltage, found a LabVIEW text "
                    "(.lvm), which describes its columns in prose; save the rows under a header "
                    "such as time_s,current_A,voltage_V");
  }
  const auto first = std::find_if(lines.begin(), lines.end(), [](const Line& line) {
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
  if (nearest.layout) {
    std::vector<std::string> missing;
    for (const Quantity quantity : kNeeded) {
      if (!Find(nearest, quantity, options).empty()) continue;
      const auto named = options.columns.find(std::string(Key(quantity)));
      missing.push_back(named == options.columns.end() ? std::string(Name(quantity))
                                                       : fmt::format("'{}'", named->second));
    }
    throw LoadError(
        {source.file(), nearest.line, 1},
        fmt::format(
            "expected columns for time, current and voltage, found none for {} among {}; name "
            "the columns with `columns = {{time_s = \"...\", current_A = \"...\", voltage_V = "
            "\"...\"}}`",
            fmt::join(missing, " and "),
            Listed(nearest.names)));
  }
  std::string found(Trimmed(first->text).substr(0, 60));
  for (char& c : found) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  throw LoadError(
      {source.file(), line, 1},
      fmt::format(
          "expected a header that names time, current and voltage, such as "
          "time_s,current_A,voltage_V, found '{}'; `lipoid list formats` shows what is read",
          found));
}

// "V" of "[V]" and of "(V)".
std::string_view WithoutBrackets(std::string_view text) {
  text = Trimmed(text);
  const bool within = text.size() >= 2 && ((text.front() == '[' && text.back() == ']') ||
                                           (text.front() == '(' && text.back() == ')'));
  return within ? Trimmed(text.substr(1, text.size() - 2)) : text;
}

// Whether a line below the header holds units: texts in brackets, or texts without a digit of which
// some are known units.
bool AreUnits(std::span<const TextCell> cells) {
  bool any = false;
  for (const TextCell& cell : cells) {
    const std::string_view unit = WithoutBrackets(cell.text);
    const bool in_brackets = unit.size() < Trimmed(cell.text).size();
    if (!in_brackets && unit.find_first_of("0123456789") != std::string_view::npos) return false;
    any = any || in_brackets;
    for (const Quantity quantity :
         {Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage, Quantity::kTemperature}) {
      any = any || (!unit.empty() && FindUnit(quantity, unit));
    }
  }
  return any;
}

// Resolves the columns of a header, one quantity at a time.
class Planner {
 public:
  Planner(const TextSource& source,
          const ReadOptions& options,
          Header header,
          const std::vector<Line>& lines)
      : source_(source), options_(options), header_(std::move(header)), lines_(lines) {}

  LogPlan Plan() {
    plan_.layout = header_.layout;
    plan_.header_line = header_.line;
    plan_.table.delimiter = header_.delimiter;
    plan_.table.fields = header_.names.size();
    if (!header_.implied) {
      plan_.table.nameless_fields =
          CellsOf(lines_[header_.line - 1].text, header_.delimiter).size();
    }
    plan_.table.date_order = header_.layout->date_order;
    plan_.table.comments = header_.layout->comments;
    plan_.table.word = &DirectionOfWord;
    for (const auto& level : header_.levels) plan_.table.levels.push_back(level.size());
    FindFirstRows();
    plan_.table.first_line = first_line_ + 1;
    PlanTime();
    PlanNumber(Quantity::kCurrent);
    const bool without_voltage =
        options_.voltage_optional && Find(header_, Quantity::kVoltage, options_).empty();
    if (!without_voltage) PlanNumber(Quantity::kVoltage);
    PlanTemperature();
    PlanLabels();
    return std::move(plan_);
  }

  // Bytes of head() before the first line to read.
  [[nodiscard]] std::size_t offset() const {
    return first_line_ == 0 ? 0 : lines_[first_line_ - 1].next;
  }

 private:
  [[noreturn]] void Fail(std::size_t column, std::string message) const {
    throw LoadError({source_.file(), header_.line, column}, std::move(message));
  }

  // Skips a line of units below the header, and collects a few rows to look at.
  void FindFirstRows() {
    first_line_ =
        header_.implied ? header_.line - 1 : header_.line;  // index of the line to look at
    if (first_line_ < lines_.size()) {
      const auto cells = CellsOf(lines_[first_line_].text, header_.delimiter);
      if (AreUnits(cells)) {
        for (std::size_t k = 0; k < std::min(cells.size(), header_.names.size()); ++k) {
          const std::string_view unit = WithoutBrackets(cells[k].text);
          if (!unit.empty()) header_.names[k].unit = LowerCase(unit);
        }
        ++first_line_;
      }
    }
    constexpr std::size_t kRows = 500;
    for (std::size_t k = first_line_; k < lines_.size() && rows_.size() < kRows; ++k) {
      auto cells = CellsOf(lines_[k].text, header_.delimiter);
      if (cells.size() < header_.names.size()) continue;
      bool is_row = true;
      for (std::size_t level = 0; level < header_.levels.size(); ++level)
        is_row &= cells[level].text.empty();
      if (is_row) rows_.push_back(std::move(cells));
    }
  }

  // The one column that holds the quantity, or none. Ambiguity is an error.
  std::optional<HeaderMatch> Choose(Quantity quantity,
                                    std::vector<HeaderMatch> matches,
                                    bool in_order) const {
    if (matches.empty()) return std::nullopt;
    std::stable_sort(matches.begin(), matches.end(), [](const auto& a, const auto& b) {
      return a.rank < b.rank;
    });
    if (matches.size() > 1 && (!in_order || matches[0].rank == matches[1].rank)) {
      const HeaderName& other = header_.names[matches[1].field];
      Fail(other.column,
           fmt::format("expected one column for the {0}, found '{1}' and '{2}'; say which with "
                       "`columns = {{{3} = \"{1}\"}}`",
                       Name(quantity),
                       header_.names[matches[0].field].text,
                       other.text,
                       Key(quantity)));
    }
    return matches.front();
  }

  HeaderMatch Needed(Quantity quantity, std::optional<HeaderMatch> match) const {
    const auto named = options_.columns.find(std::string(Key(quantity)));
    if (!match && named != options_.columns.end()) {
      Fail(1,
           fmt::format("expected a column '{}' as the option columns says, found {}",
                       named->second,
                       Listed(header_.names)));
    }
    if (!match) {
      Fail(1,
           fmt::format("expected a column for the {} in this {} log, found none among {}; name it "
                       "with `columns = {{{} = \"...\"}}`",
                       Name(quantity),
                       header_.layout->name,
                       Listed(header_.names),
                       Key(quantity)));
    }
    if (match->unit_is_wrong) {
      const HeaderName& name = header_.names[match->field];
      Fail(name.column,
           fmt::format("expected a unit of {} ({}) in '{}', found '{}'",
                       Name(quantity),
                       UsualUnits(quantity),
                       name.text,
                       match->unit));
    }
    return *match;
  }

  // The unit that the header states, or the user, or the format is known to mean; nullopt where
  // nobody does.
  std::optional<Unit> UnitOf(Quantity quantity, const HeaderMatch& match) const {
    const HeaderName& name = header_.names[match.field];
    std::optional<Unit> stated;
    if (!match.unit.empty()) stated = FindUnit(quantity, match.unit);
    if (const auto given = GivenUnit(quantity)) {
      if (stated && !stated->SameScale(*given)) {
        Fail(name.column,
             fmt::format("expected a column in {} as the option units says, found '{}'",
                         options_.units[static_cast<std::size_t>(quantity)],
                         name.text));
      }
      return given;
    }
    if (stated) return stated;
    const std::string_view known = header_.layout->Of(quantity).known_unit;
    return known.empty() ? std::nullopt : FindUnit(quantity, known);
  }

  std::optional<Unit> GivenUnit(Quantity quantity) const {
    const auto index = static_cast<std::size_t>(quantity);
    if (options_.units.empty() || index >= options_.units.size()) return std::nullopt;
    return FindUnit(quantity, options_.units[index]);
  }

  [[noreturn]] void FailWithoutUnit(Quantity quantity, const HeaderMatch& match) const {
    const HeaderName& name = header_.names[match.field];
    Fail(name.column,
         fmt::format("expected a header that states the unit of the {} ({}), found '{}'; add it "
                     "there or say `units` (--units s,A,V)",
                     Name(quantity),
                     UsualUnits(quantity),
                     name.text));
  }

  void Add(
      Quantity quantity, const HeaderMatch& match, CellKind kind, Unit unit, bool lenient = false) {
    const HeaderName& name = header_.names[match.field];
    plan_.columns[static_cast<std::size_t>(quantity)] =
        PlannedColumn{.column = plan_.table.columns.size(),
                      .unit = unit,
                      .header_column = name.column,
                      .header_text = name.text};
    plan_.table.columns.push_back(
        {.name = name.text, .field = match.field, .kind = kind, .lenient = lenient});
  }

  CellKind KindOfTime(std::size_t field) const {
    if (rows_.empty()) return CellKind::kNumber;
    const std::string_view text = rows_.front()[field].text;
    double seconds = 0.0;
    DateTime date;
    if (ParseDuration(text, '.', seconds) || ParseDuration(text, ',', seconds))
      return CellKind::kDuration;
    for (const DateOrder order : {DateOrder::kMonthFirst, DateOrder::kDayFirst}) {
      if (ParseDateTime(text, order, '.', date)) return CellKind::kDateTime;
    }
    return CellKind::kNumber;
  }

  void PlanTime() {
    const Layout& layout = *header_.layout;
    const bool in_order = layout.Of(Quantity::kTime).in_order;
    auto match = Choose(Quantity::kTime, Find(header_, Quantity::kTime, options_), in_order);
    if ((!match || match->unit_is_wrong) && !options_.columns.contains("time_s")) {
      auto other = Choose(
          Quantity::kTime, FindColumns(header_.names, Quantity::kTime, layout.step_clock), true);
      if (other && !other->unit_is_wrong) {
        match = other;
        plan_.clock_restarts_with_step = true;
      } else {
        other =
            Choose(Quantity::kTime, FindColumns(header_.names, Quantity::kTime, layout.date), true);
        if (other && !other->unit_is_wrong) match = other;
      }
    }
    const HeaderMatch time = Needed(Quantity::kTime, match);
    const CellKind kind = KindOfTime(time.field);
    if (kind != CellKind::kNumber) {
      Add(Quantity::kTime, time, kind, Unit{.name = "s"});
      return;
    }
    auto unit = UnitOf(Quantity::kTime, time);
    if (unit && unit->is_duration)
      unit.reset();  // the header promises hh:mm:ss, the rows hold numbers
    if (!unit) unit = UnitFromDates(time.field);
    if (!unit) FailWithoutUnit(Quantity::kTime, time);
    Add(Quantity::kTime, time, kind, *unit);
  }

  // The unit in which the time column agrees with the dates beside it.
  std::optional<Unit> UnitFromDates(std::size_t time_field) {
    const auto matches = FindColumns(header_.names, Quantity::kState, header_.layout->date);
    if (matches.empty() || rows_.size() < 2) return std::nullopt;
    const std::size_t field = matches.front().field;
    std::optional<DateTime> first_date;
    double first = 0.0;
    double date_s = 0.0;
    double clock = 0.0;
    for (const auto& cells : rows_) {
      DateTime date;
      double value = 0.0;
      if (!ParseNumber(cells[time_field].text, '.', value) &&
          !ParseNumber(cells[time_field].text, ',', value))
        break;
      if (!ParseDateTime(cells[field].text, DateOrder::kMonthFirst, '.', date) &&
          !ParseDateTime(cells[field].text, DateOrder::kDayFirst, '.', date)) {
        break;
      }
      if (!first_date) {
        first_date = date;
        first = value;
      }
      if (date.days != first_date->days)
        break;  // which of 03/04 is the month does not matter within a day
      date_s = date.second_of_day - first_date->second_of_day;
      clock = value - first;
    }
    constexpr double kResolution_s = 2.0;  // dates are written to the second
    constexpr double kEnough_s = 20.0;
    if (date_s < kEnough_s) return std::nullopt;
    for (const char* name : {"s", "min", "h"}) {
      const auto unit = FindUnit(Quantity::kTime, name);
      if (std::abs(unit->ToSi(clock) - date_s) > kResolution_s + 0.02 * date_s) continue;
      plan_.notes.push_back(
          fmt::format("the header states no unit of time; the dates beside it say {}", name));
      return unit;
    }
    return std::nullopt;
  }

  void PlanNumber(Quantity quantity) {
    const HeaderMatch match = Needed(
        quantity,
        Choose(quantity, Find(header_, quantity, options_), header_.layout->Of(quantity).in_order));
    const auto unit = UnitOf(quantity, match);
    if (!unit) FailWithoutUnit(quantity, match);
    if (quantity == Quantity::kVoltage && !GivenUnit(quantity)) {
      plan_.volts_or_millivolts =
          header_.layout->millivolts_beside == LowerCase(plan_.Of(Quantity::kCurrent)->header_text);
    } else if (match.unit.empty() && !GivenUnit(quantity)) {
      plan_.notes.push_back(fmt::format("the header states no unit of the {}; {} writes {}",
                                        Name(quantity),
                                        header_.layout->name,
                                        header_.layout->Of(quantity).known_unit));
    }
    Add(quantity, match, CellKind::kNumber, *unit);
  }

  // Optional: it never costs the log.
  void PlanTemperature() {
    constexpr auto kQuantity = Quantity::kTemperature;
    const bool named = options_.columns.contains(std::string(Key(kQuantity)));
    auto matches = Find(header_, kQuantity, options_);
    if (named) Needed(kQuantity, Choose(kQuantity, matches, false));
    if (matches.empty()) return;
    std::stable_sort(matches.begin(), matches.end(), [](const auto& a, const auto& b) {
      return a.rank < b.rank;
    });
    const HeaderMatch& match = matches.front();
    const auto unit = match.unit_is_wrong ? std::nullopt : UnitOf(kQuantity, match);
    const bool one = matches.size() == 1 ||
                     (header_.layout->Of(kQuantity).in_order && matches[0].rank != matches[1].rank);
    if (!unit || !one) {
      if (named) FailWithoutUnit(kQuantity, match);
      plan_.notes.push_back(fmt::format("temperature left out: {} '{}'",
                                        unit ? "more than one column beside" : "no unit in",
                                        header_.names[match.field].text));
      return;
    }
    Add(kQuantity, match, CellKind::kNumber, *unit, !named);
  }

  // Steps and cycles where rows are picked by them, the state where the format has one.
  void PlanLabels() {
    const auto add = [&](Quantity quantity, CellKind kind, bool needed, std::string_view option) {
      for (std::size_t level = header_.levels.size(); level-- > 0;) {
        const auto above =
            FindColumns(header_.levels[level], quantity, header_.layout->Of(quantity));
        if (above.empty()) continue;
        const HeaderName& name = header_.levels[level][above.front().field];
        plan_.columns[static_cast<std::size_t>(quantity)] = PlannedColumn{
            .column = plan_.table.columns.size(), .unit = {}, .header_text = name.text};
        plan_.table.columns.push_back(
            {.name = name.text, .field = above.front().field, .kind = kind, .level = level});
        return;
      }
      auto matches = FindColumns(header_.names, quantity, header_.layout->Of(quantity));
      std::stable_sort(matches.begin(), matches.end(), [](const auto& a, const auto& b) {
        return a.rank < b.rank;
      });
      if (!matches.empty()) {
        Add(quantity, matches.front(), kind, Unit{});
      } else if (needed) {
        Fail(1,
             fmt::format(
                 "expected a column for the {} because of the option {}, found none among {}",
                 Name(quantity),
                 option,
                 Listed(header_.names)));
      }
    };
    if (!options_.steps.empty() || plan_.clock_restarts_with_step || options_.labels) {
      add(Quantity::kStep,
          CellKind::kNumber,
          !options_.steps.empty() || plan_.clock_restarts_with_step,
          plan_.clock_restarts_with_step ? "columns.time_s" : "steps");
    }
    if (!options_.cycles.empty() || plan_.clock_restarts_with_step || options_.labels) {
      add(Quantity::kCycle, CellKind::kNumber, !options_.cycles.empty(), "cycles");
    }
    add(Quantity::kState, CellKind::kWord, false, "");
  }

  const TextSource& source_;
  const ReadOptions& options_;
  Header header_;
  const std::vector<Line>& lines_;
  std::size_t first_line_ = 0;  // index into lines_
  std::vector<std::vector<TextCell>> rows_;
  LogPlan plan_;
};

}  // namespace

std::span<const Layout* const> LogFormats() { return kFormats; }

LogPlan PlanReading(TextSource& source, const ReadOptions& options) {
  RefusePacked(source.file(), source.head());
  const auto lines = LinesOf(source.head(), source.line_end());
  Header nearest;
  auto header = FindHeader(lines, options, nearest);
  if (!header) RefuseUnknown(source, lines, nearest, options);
  Planner planner(source, options, std::move(*header), lines);
  LogPlan plan = planner.Plan();
  source.Skip(planner.offset());
  return plan;
}

}  // namespace lipoid
