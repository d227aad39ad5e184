#include "identify/logs/formats/plan_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/core/foreign_text.h"

namespace lipoid {
namespace {

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
    for (const Quantity quantity : kMeasured) {
      any = any || (!unit.empty() && FindUnit(quantity, unit));
    }
  }
  return any;
}

// +1 for a word that says discharge, -1 for charge, 0 for any other: DCHG, D, CC DChg, ...
double DirectionOfWord(std::string_view word) {
  const std::string lower = LowerCase(word);
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  if (lower == "d" || has("dch") || has("disch") || has("放电")) return 1.0;
  if (lower == "c" || lower == "cha" || has("charg") || has("chg") || has("chrg") || has("充电"))
    return -1.0;
  return 0.0;
}

// Those of equal ranks stay in the order of their fields.
std::vector<HeaderMatch> ByRank(std::vector<HeaderMatch> matches) {
  std::stable_sort(
      matches.begin(), matches.end(), [](const auto& a, const auto& b) { return a.rank < b.rank; });
  return matches;
}

// Resolves the columns of a header, one quantity at a time.
class Planner {
 public:
  Planner(const TextSource& source,
          const ReadOptions& options,
          FoundHeader header,
          const std::vector<HeadLine>& lines)
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
        options_.voltage_optional && header_.Find(Quantity::kVoltage, options_).empty();
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
    matches = ByRank(std::move(matches));
    if (matches.size() > 1 && (!in_order || matches[0].rank == matches[1].rank)) {
      const HeaderName& first = header_.names[matches[0].field];
      const HeaderName& other = header_.names[matches[1].field];
      const bool alike = first.text == other.text;
      Fail(other.column,
           fmt::format("expected one column for the {0}, found '{1}' and '{2}'; say which with "
                       "`columns = {{{3} = \"{4}\"}}`{5}",
                       Name(quantity),
                       first.text,
                       other.text,
                       Key(quantity),
                       alike ? fmt::format("{}", matches[0].field + 1) : first.text,
                       alike ? ", its place in the row" : ""));
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
    for (const Quantity other : kMeasured) {
      const auto& planned = plan_.Of(other);
      if (!planned || plan_.table.columns[planned->column].field != match.field) continue;
      Fail(name.column,
           fmt::format("expected a column of its own for each quantity, found '{}' for both the {} "
                       "and the {}; name another with `columns = {{{} = \"...\"}}` (--columns)",
                       name.text,
                       Name(other),
                       Name(quantity),
                       Key(other)));
    }
    plan_.columns[static_cast<std::size_t>(quantity)] =
        PlannedColumn{.column = plan_.table.columns.size(),
                      .unit = unit,
                      .header_column = name.column,
                      .header_text = name.text,
                      .in_thousands = IsInThousands(match.field)};
    plan_.table.columns.push_back(
        {.name = name.text, .field = match.field, .kind = kind, .lenient = lenient});
  }

  [[nodiscard]] bool IsInThousands(std::size_t field) const {
    return !rows_.empty() && std::all_of(rows_.begin(), rows_.end(), [&](const auto& cells) {
      const std::string_view text = cells[field].text;
      const auto mark = text.find_last_of(".,");
      return mark != text.npos &&
             text.substr(mark + 1).find_first_not_of("0123456789") == text.npos &&
             text.size() - mark - 1 == 3;
    });
  }

  CellKind KindOfTime(std::size_t field) const {
    if (rows_.empty()) return CellKind::kNumber;
    const std::string_view text = rows_.front()[field].text;
    double seconds = 0.0;
    DateTime date;
    if (ParseDuration(text, '.', seconds) || ParseDuration(text, ',', seconds))
      return CellKind::kDuration;
    for (const DateOrder order :
         {DateOrder::kMonthFirst, DateOrder::kDayFirst, DateOrder::kShortYearFirst}) {
      if (ParseDateTime(text, order, '.', date) || ParseDateTime(text, order, ',', date))
        return CellKind::kDateTime;
    }
    return CellKind::kNumber;
  }

  void PlanTime() {
    const Layout& layout = *header_.layout;
    const bool in_order = layout.Of(Quantity::kTime).in_order;
    auto match = Choose(Quantity::kTime, header_.Find(Quantity::kTime, options_), in_order);
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
      Add(Quantity::kTime, time, kind, Unit{});
      return;
    }
    auto unit = UnitOf(Quantity::kTime, time);
    if (unit && unit->is_duration)
      unit.reset();  // the header promises hh:mm:ss, the rows hold numbers
    if (!unit) unit = UnitFromDates(time.field);
    if (!unit) FailWithoutTime(time.field);
    if (!unit) FailWithoutUnit(Quantity::kTime, time);
    Add(Quantity::kTime, time, kind, *unit);
  }

  // What is no number needs no unit, but another way of writing.
  void FailWithoutTime(std::size_t field) const {
    double number = 0.0;
    if (rows_.empty() || rows_.front()[field].text.empty()) return;
    const std::string_view text = rows_.front()[field].text;
    if (ParseNumber(text, '.', number) || ParseNumber(text, ',', number)) return;
    Fail(header_.names[field].column,
         fmt::format(
             "expected times in column '{}' as numbers, as durations such as 00:01:02.5 or as "
             "dates such as 2021-03-26 17:01:33, found '{}' in the first row",
             header_.names[field].text,
             ForeignText(text)));
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
        Choose(quantity, header_.Find(quantity, options_), header_.layout->Of(quantity).in_order));
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
    const auto matches = ByRank(header_.Find(kQuantity, options_));
    if (named) Needed(kQuantity, Choose(kQuantity, matches, false));
    if (matches.empty()) return NameOtherTemperatures();
    const HeaderMatch& match = matches.front();
    const auto unit = match.unit_is_wrong ? std::nullopt : UnitOf(kQuantity, match);
    const bool one = matches.size() == 1 ||
                     (header_.layout->Of(kQuantity).in_order && matches[0].rank != matches[1].rank);
    if (!unit || !one) {
      if (named) FailWithoutUnit(kQuantity, match);
      const std::string& header = header_.names[match.field].text;
      const std::string why =
          unit ? fmt::format(
                     "there are more columns beside '{}'; name one with "
                     "`columns = {{{} = \"...\"}}` (--columns)",
                     header,
                     Key(kQuantity))
               : fmt::format("the header '{}' states no unit of temperature ({})",
                             header,
                             UsualUnits(kQuantity));
      plan_.warnings.push_back("temperature left out: " + why);
      return;
    }
    Add(kQuantity, match, CellKind::kNumber, *unit, !named);
  }

  // The log may have the temperature of the cell under a name that nobody foresaw.
  void NameOtherTemperatures() {
    std::vector<HeaderName> others;
    for (const HeaderName& name : header_.names) {
      const std::string& unit = name.unit.empty() ? name.suffix : name.unit;
      // One letter may stand for coulombs or farads.
      const std::string& of = name.unit.empty() ? name.stem : name.name;
      const bool may_be_another =
          unit.size() == 1 && of != "t" && name.name.find("temp") == std::string::npos;
      const bool is_unit = name.name.size() > 1 && FindUnit(Quantity::kTemperature, name.name);
      if (is_unit || (!may_be_another && FindUnit(Quantity::kTemperature, unit)))
        others.push_back(name);
    }
    if (others.empty()) return;
    plan_.warnings.push_back(fmt::format(
        "temperature left out: no header says which is that of the cell; if it is one of {}, name "
        "it with `columns = {{{} = \"...\"}}` (--columns)",
        Listed(others),
        Key(Quantity::kTemperature)));
  }

  // Steps and cycles where rows are picked by them, the state where the format has one.
  [[nodiscard]] bool IsEmptyAtFirst(std::size_t field) const {
    return !rows_.empty() && field < rows_.front().size() && rows_.front()[field].text.empty();
  }

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
      const auto matches =
          ByRank(FindColumns(header_.names, quantity, header_.layout->Of(quantity)));
      // A cycler that counts no steps leaves their column empty.
      if (!needed && kind == CellKind::kNumber && !matches.empty() &&
          IsEmptyAtFirst(matches.front().field))
        return;
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
  FoundHeader header_;
  const std::vector<HeadLine>& lines_;
  std::size_t first_line_ = 0;  // index into lines_
  std::vector<std::vector<TextCell>> rows_;
  LogPlan plan_;
};

}  // namespace

LogPlan PlanColumns(TextSource& source,
                    const ReadOptions& options,
                    FoundHeader header,
                    const std::vector<HeadLine>& lines) {
  Planner planner(source, options, std::move(header), lines);
  LogPlan plan = planner.Plan();
  source.Skip(planner.offset());
  return plan;
}

}  // namespace lipoid
