#include "identify/logs/csv/table_reader.h"

#include <fast_float/fast_float.h>
#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <numeric>
#include <utility>

#include "identify/logs/csv/plain_decimal.h"

namespace lipoid {
namespace {

// No time, current or voltage of a log reaches this; loggers write 3.4E38 where they overflow.
constexpr double kOverflow = 1e30;

// How many rows at the end of each block tell how the last field is printed.
constexpr std::size_t kRowsLookedAt = 32;

std::string Shown(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown(text.substr(0, kLongest));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  }
  if (text.size() > kLongest) shown += "...";
  return shown;
}

std::string_view Expected(CellKind kind) {
  switch (kind) {
    case CellKind::kDuration:
      return "a duration such as 00:01:02.5";
    case CellKind::kDateTime:
      return "a date and time such as 2021-03-26 17:01:33";
    case CellKind::kNumber:
    case CellKind::kWord:
      break;
  }
  return "a number";
}

// 4'180 and 1.000,5, and 4.997 among numbers with a decimal comma.
bool HasForeignMark(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && is_digit(text.front()) && is_digit(text.back()) &&
         std::all_of(text.begin(), text.end(), [&](char c) {
           const bool is_mark = std::string_view(".,' _").find(c) != std::string_view::npos;
           return is_digit(c) || is_mark || static_cast<unsigned char>(c) >= 0x80;  // a wide blank
         });
}

// Length of what follows the decimal mark, exponent included: the same in every row of a fixed
// format.
std::size_t Decimals(std::string_view number) {
  const auto mark = number.find_last_of(".,");
  return mark == std::string_view::npos ? 0 : number.size() - mark - 1;
}

}  // namespace

TableReader::TableReader(TextSource& source, TableSpec spec)
    : source_(source),
      spec_(std::move(spec)),
      line_end_(source.line_end()),
      line_(spec_.first_line),
      heading_values_(spec_.columns.size(), std::numeric_limits<double>::quiet_NaN()),
      dates_(spec_.date_order) {
  Require(spec_.fields > 0 && !spec_.columns.empty(), "a table has fields and wanted columns");
  for (std::size_t k = 0; k < spec_.columns.size(); ++k) {
    if (!spec_.columns[k].level) order_.push_back(k);
  }
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return spec_.columns[a].field < spec_.columns[b].field;
  });
}

bool TableReader::NeedsOnlyNumbers() const {
  return spec_.levels.empty() && std::all_of(order_.begin(), order_.end(), [&](std::size_t k) {
           return spec_.columns[k].kind == CellKind::kNumber;
         });
}

// The rows of a piece down to the first that is unusual. Columns of numbers are read without
// touching anything else of this reader: pieces may be read side by side.
void TableReader::ReadPlainRows(Piece& piece) {
  // A row has a delimiter or line end per field.
  const std::size_t most_rows = piece.text.size() / spec_.fields + 1;
  if (piece.block.columns.size() != spec_.columns.size() || piece.block.capacity < most_rows) {
    piece.block.capacity = std::max(most_rows, piece.block.capacity);
    piece.block.columns.clear();
    for (std::size_t k = 0; k < spec_.columns.size(); ++k)
      piece.block.columns.push_back(std::make_unique_for_overwrite<double[]>(piece.block.capacity));
  }
  piece.block.rows = 0;
  piece.block.bytes = piece.text.size();
  piece.trailing_delimiter = false;
  piece.decimal = decimal_;
  piece.repeated.assign(spec_.columns.size(), {});
  const char* at = piece.text.data();
  const char* const end = at + piece.text.size();
  if (NeedsOnlyNumbers()) {
    while (at < end && ReadFast(at,
                                end,
                                piece.block.rows,
                                piece.decimal,
                                piece.block,
                                piece.trailing_delimiter,
                                piece.repeated.data()) == Row::kRead)
      ++piece.block.rows;
  }
  piece.bytes_read = static_cast<std::size_t>(at - piece.text.data());
}

bool TableReader::NextBlock(TableBlock& block) {
  Piece& piece = pieces_[0];
  piece.text = source_.NextPiece(line_);
  block.rows = 0;
  block_ = &block;
  if (piece.text.empty()) {
    piece_ = {};
    return false;
  }
  std::swap(block, piece.block);
  ReadPlainRows(piece);
  try {
    Finish(piece);
  } catch (...) {
    std::swap(block, piece.block);  // the rows before the trouble
    block_ = &block;
    throw;
  }
  std::swap(block, piece.block);
  block_ = &block;
  return true;
}

void TableReader::ForEachBlock(const std::function<void(TableBlock&)>& take) {
  if (!NeedsOnlyNumbers() || source_.head_is_all()) {  // one piece is not parsed side by side
    TableBlock block;
    while (NextBlock(block)) take(block);
    return;
  }
  std::size_t count = 0;
  std::exception_ptr failure;
  const auto read = [&](tbb::flow_control& flow) -> Piece* {
    Piece& piece = pieces_[count % pieces_.size()];
    try {
      piece.text = source_.NextPiece(0);
    } catch (const LoadError&) {
      failure = std::current_exception();
      piece.text = {};
    }
    if (piece.text.empty()) {
      flow.stop();
      return nullptr;
    }
    ++count;
    return &piece;
  };
  const auto parse = [&](Piece* piece) {
    ReadPlainRows(*piece);
    return piece;
  };
  const auto finish = [&](Piece* piece) {
    Finish(*piece);
    take(piece->block);
  };
  tbb::parallel_pipeline(
      pieces_.size(),
      tbb::make_filter<void, Piece*>(tbb::filter_mode::serial_in_order, read) &
          tbb::make_filter<Piece*, Piece*>(tbb::filter_mode::parallel, parse) &
          tbb::make_filter<Piece*, void>(tbb::filter_mode::serial_in_order, finish));
  if (failure == nullptr) return;
  static_cast<void>(source_.NextPiece(line_));  // says it again, now with the number of the line
  std::rethrow_exception(failure);              // a disk that failed only once has failed
}

// What the plain path left over, and everything that depends on the pieces before.
void TableReader::Finish(Piece& piece) {
  if (piece.decimal != decimal_) ReadPlainRows(piece);  // the mark was found out since
  TableBlock& block = piece.block;
  block_ = &block;
  row_lines_.clear();
  piece_line_ = line_;
  piece_ = piece.text;
  trailing_delimiter_ |= piece.trailing_delimiter;
  NoteLastFields(piece_.substr(0, piece_.rfind(line_end_) + 1));

  if (block.rows > 0) {
    if (short_line_ > 0) FailShort();  // it was not the last
    row_lines_.emplace_back(0, line_);
    line_ += block.rows;
  }
  const char* at = piece_.data() + piece.bytes_read;
  const char* const end = piece_.data() + piece_.size();
  while (at < end) {
    const char* const start = at;
    Row outcome = spec_.levels.empty()
                      ? ReadFast(at, end, block.rows, decimal_, block, trailing_delimiter_, nullptr)
                      : Row::kUnusual;
    if (outcome == Row::kUnusual) {
      const auto* stop = static_cast<const char*>(
          std::memchr(start, line_end_, static_cast<std::size_t>(end - start)));
      const std::string_view line(start, static_cast<std::size_t>((stop ? stop : end) - start));
      outcome = ReadCarefully(line, stop != nullptr, block.rows);
      at = stop ? stop + 1 : end;
    }
    if (outcome == Row::kRead) {
      if (short_line_ > 0) FailShort();  // it was not the last
      const std::size_t offset = line_ - block.rows;
      if (row_lines_.empty() || row_lines_.back().second != offset)
        row_lines_.emplace_back(block.rows, offset);
      ++block.rows;
    }
    ++line_;
  }
  if (!decimal_is_known_) {
    for (const std::size_t k : order_) {
      if (spec_.columns[k].kind != CellKind::kNumber || spec_.columns[k].lenient) continue;
      const double* values = block.columns[k].get();
      decimal_is_known_ |=
          std::any_of(values, values + block.rows, [](double x) { return x != std::floor(x); });
    }
  }
}

// Where the plain number at `at` ends; null where it is none.
inline const char* TableReader::ReadNumber(
    const char* at, const char* end, char decimal, Repeated* repeated, double& value) const {
  if (end - at < kPlainDecimalReach) return nullptr;
  if (repeated == nullptr || repeated->misses >= Repeated::kMostMisses)
    return ReadPlainDecimal(at, decimal, value);
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, at, sizeof bytes);
  if (repeated->mask != 0 && ((bytes ^ repeated->bytes) & repeated->mask) == 0) {
    repeated->misses = 0;
    value = repeated->value;
    return at + repeated->length;
  }
  const char* const stop = ReadPlainDecimal(at, decimal, value);
  ++repeated->misses;
  repeated->mask = 0;
  if (stop == nullptr || stop - at >= Repeated::kMostBytes) return stop;
  constexpr int kBits = 8;
  repeated->mask = ~std::uint64_t{0} >> (kBits * (Repeated::kMostBytes - 1 - (stop - at)));
  repeated->bytes = bytes;
  repeated->value = value;
  repeated->length = stop - at;
  return stop;
}

TableReader::Row TableReader::ReadFast(const char*& at,
                                       const char* end,
                                       std::size_t row,
                                       char decimal,
                                       TableBlock& block,
                                       bool& trailing_delimiter,
                                       Repeated* repeated) {
  const char delimiter = spec_.delimiter;
  const fast_float::parse_options options(fast_float::chars_format::general, decimal);
  const char* p = at;
  std::size_t field = 0;
  bool ended = false;
  for (const std::size_t k : order_) {
    const WantedColumn& column = spec_.columns[k];
    if (ended) return Row::kUnusual;
    for (; field < column.field; ++field, ++p) {
      while (p < end && *p != delimiter) {
        if (*p == line_end_ || *p == '"') return Row::kUnusual;
        ++p;
      }
      if (p == end) return Row::kUnusual;
    }
    while (p < end && *p == ' ') ++p;
    double value = 0.0;
    if (column.kind == CellKind::kNumber) {
      const char* stop =
          ReadNumber(p, end, decimal, repeated != nullptr ? &repeated[k] : nullptr, value);
      if (stop == nullptr || !(*stop == delimiter || *stop == line_end_ || *stop == '\r')) {
        const auto result = fast_float::from_chars_advanced(p, end, value, options);
        if (result.ec != std::errc() || !(std::abs(value) < kOverflow)) return Row::kUnusual;
        stop = result.ptr;
      }
      p = stop;
    } else {
      const char* const begin = p;
      while (p < end && *p != delimiter && *p != line_end_) {
        if (*p == '"') return Row::kUnusual;
        ++p;
      }
      const std::string_view text = Trimmed({begin, static_cast<std::size_t>(p - begin)});
      if (!Convert(text, column, value)) return Row::kUnusual;
      if (p > begin && p < end && *p == '\n' && p[-1] == '\r') --p;
    }
    block.columns[k][row] = value;
    if (p == end) return Row::kUnusual;
    if (*p == delimiter) {
      ++p;
      ++field;
    } else {
      ended = true;
    }
  }
  if (!ended) {
    for (; p < end && *p != line_end_; ++p) {
      if (*p == delimiter) ++field;
      if (*p == '"') return Row::kUnusual;
    }
    if (p == end) return Row::kUnusual;
    const char before = p[-1] == '\r' && line_end_ == '\n' ? p[-2] : p[-1];
    if (before == delimiter && field == spec_.fields) {
      trailing_delimiter = true;
      --field;
    }
  } else if (*p == '\r' && line_end_ == '\n' && p + 1 < end) {
    ++p;
  }
  if (*p != line_end_ || field + 1 != spec_.fields) return Row::kUnusual;
  at = p + 1;
  return Row::kRead;
}

TableReader::Row TableReader::ReadCarefully(std::string_view line, bool has_end, std::size_t row) {
  if (spec_.comments && Trimmed(line).starts_with('#')) {
    ++comment_lines_;
    return Row::kSkipped;
  }
  const std::string_view inside = Unwrapped(line, spec_.delimiter);
  SplitLine(inside, spec_.delimiter, cells_);
  for (TextCell& cell : cells_)
    cell.column += static_cast<std::size_t>(inside.data() - line.data());
  if (std::all_of(
          cells_.begin(), cells_.end(), [](const TextCell& cell) { return cell.text.empty(); })) {
    ++(has_end || cells_.size() == 1 ? blank_lines_ : cut_last_lines_);
    return Row::kSkipped;
  }
  if (short_line_ > 0) FailShort();
  if (!spec_.levels.empty()) {
    std::size_t level = 0;
    while (level < spec_.levels.size() && cells_[level].text.empty()) ++level;
    if (level < spec_.levels.size()) {
      if (!has_end) {
        ++cut_last_lines_;
        return Row::kSkipped;
      }
      ReadHeading(cells_, level);
      return Row::kSkipped;
    }
  }
  std::size_t fields = cells_.size();
  while (fields > spec_.fields &&
         (cells_[fields - 1].text.empty() || fields <= spec_.nameless_fields)) {
    --fields;
    trailing_delimiter_ = true;
  }
  // A line in quotes as a whole has its last digit before the closing quote.
  const bool closed = inside.size() < line.size();
  if (!has_end && (fields < spec_.fields || (!closed && IsCut(line, cells_)))) {
    ++cut_last_lines_;
    return Row::kSkipped;
  }
  if (fields != spec_.fields) {
    short_line_ = line_;  // fine if nothing follows: the logger was stopped here
    short_fields_ = fields;
    if (fields > spec_.fields) FailShort();
    return Row::kSkipped;
  }
  if (!has_end && !line.ends_with('\r')) last_line_has_no_end_ = true;
  if (!decimal_is_known_) DecideDecimalMark();
  for (std::size_t k = 0; k < spec_.columns.size(); ++k) {
    const WantedColumn& column = spec_.columns[k];
    double& value = block_->columns[k][row];
    if (column.level) {
      value = heading_values_[k];
      if (std::isnan(value))
        FailAt(1, fmt::format("expected a line with '{}' above this row, found none", column.name));
      continue;
    }
    const TextCell& cell = cells_[column.field];
    const bool converted = Convert(cell.text, column, value);
    if (column.lenient && !(converted && std::abs(value) < kOverflow)) {
      value = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    if (!converted) {
      const std::string found =
          cell.text.empty() ? "an empty cell" : fmt::format("'{}'", Shown(cell.text));
      std::string remedy;
      if (column.kind == CellKind::kNumber && HasForeignMark(cell.text)) {
        remedy = fmt::format(
            "; numbers of this file are read with a decimal {} and without marks for thousands: export them so",
            decimal_comma() ? "comma" : "point");
      }
      if (cell.text == column.name)
        remedy =
            "; the header is repeated here: logs that were joined are read one by one, each from a file of its own";
      FailAt(cell.column,
             fmt::format("expected {} in column '{}', found {}{}",
                         Expected(column.kind),
                         column.name,
                         found,
                         remedy));
    }
    if (!std::isfinite(value) || std::abs(value) >= kOverflow) {
      FailAt(cell.column,
             fmt::format("expected a finite number in column '{}', found '{}'{}",
                         column.name,
                         Shown(cell.text),
                         std::isfinite(value) ? ", which loggers write for an overflow" : ""));
    }
  }
  return Row::kRead;
}

void TableReader::ReadHeading(const std::vector<TextCell>& cells, std::size_t level) {
  // A heading may hold those of the levels below it in the same line.
  std::size_t begin = level;
  for (; level < spec_.levels.size(); ++level) {
    if (begin >= cells.size()) return;
    for (std::size_t k = 0; k < spec_.columns.size(); ++k) {
      const WantedColumn& column = spec_.columns[k];
      if (column.level != level) continue;
      if (begin + column.field >= cells.size() ||
          !Convert(cells[begin + column.field].text, column, heading_values_[k])) {
        FailAt(1,
               fmt::format(
                   "expected a line with '{}', found '{}'", column.name, Shown(cells[begin].text)));
      }
    }
    begin += spec_.levels[level];
  }
}

bool TableReader::Convert(std::string_view text, const WantedColumn& column, double& value) {
  switch (column.kind) {
    case CellKind::kNumber:
      return ParseNumber(text, decimal_, value);
    case CellKind::kDuration:
      return ParseDuration(text, text.find(',') != std::string_view::npos ? ',' : '.', value);
    case CellKind::kDateTime:
      return dates_.Seconds(text, text.find(',') != std::string_view::npos ? ',' : '.', value);
    case CellKind::kWord:
      value = spec_.word(text);
      return true;
  }
  return false;
}

void TableReader::DecideDecimalMark() {
  // The first number with a fraction decides for the file.
  const auto is_number = [&](std::size_t k) {
    return spec_.columns[k].kind == CellKind::kNumber && !spec_.columns[k].lenient;
  };
  const auto holds = [&](std::size_t k, char mark) {
    return is_number(k) && cells_[spec_.columns[k].field].text.find(mark) != std::string_view::npos;
  };
  const auto has_fraction = [&](std::size_t k) {
    if (!is_number(k)) return false;
    const double* values = block_->columns[k].get();
    return std::any_of(values, values + block_->rows, [](double x) { return x != std::floor(x); });
  };
  if (std::none_of(order_.begin(), order_.end(), [&](std::size_t k) { return holds(k, ','); }))
    return;
  decimal_is_known_ = true;
  const bool points = std::any_of(order_.begin(), order_.end(), [&](std::size_t k) {
    return holds(k, '.') || has_fraction(k);
  });
  if (!points) decimal_ = ',';
}

bool TableReader::IsCut(std::string_view line, const std::vector<TextCell>& cells) const {
  const auto last =
      std::find_if(spec_.columns.begin(), spec_.columns.end(), [&](const WantedColumn& column) {
        return !column.level && column.field + 1 == spec_.fields;
      });
  // Only in the last field can digits be missing without a trace; where nobody wants it, nothing is
  // lost.
  if (last == spec_.columns.end() || cells.size() != spec_.fields || line.ends_with('\r'))
    return false;
  const std::string_view written = Trimmed(line.substr(line.rfind(spec_.delimiter) + 1));
  if (written.size() > 1 && written.front() == '"' && written.back() == '"') return false;
  const std::string_view text = cells.back().text;
  if (text.empty() || std::string_view(".,eE+-").find(text.back()) != std::string_view::npos)
    return true;
  if (trailing_delimiter_) return true;
  if (last->kind == CellKind::kWord) return std::isnan(spec_.word(text));
  constexpr std::size_t kEnoughRows = 3;
  return last_field_rows_ >= kEnoughRows && !last_field_varies_ &&
         Decimals(text) < last_field_decimals_;
}

void TableReader::NoteLastFields(std::string_view text) {
  for (std::size_t k = 0; k < kRowsLookedAt && !text.empty(); ++k) {
    text.remove_suffix(1);
    const auto before = text.rfind(line_end_);
    const std::string_view line = text.substr(before + 1);
    text = text.substr(0, before + 1);
    const std::string_view field = Trimmed(line.substr(line.rfind(spec_.delimiter) + 1));
    if (field.empty()) continue;
    const std::size_t decimals = Decimals(field);
    if (last_field_rows_++ == 0) last_field_decimals_ = decimals;
    last_field_varies_ |= decimals != last_field_decimals_;
  }
}

std::string_view TableReader::LineOfRow(std::size_t row, std::size_t& line) const {
  auto place = std::upper_bound(
      row_lines_.begin(), row_lines_.end(), row, [](std::size_t r, const auto& entry) {
        return r < entry.first;
      });
  line = row + std::prev(place)->second;
  std::string_view text = piece_;
  for (std::size_t k = piece_line_; k < line; ++k) text.remove_prefix(text.find(line_end_) + 1);
  return text.substr(0, text.find(line_end_));
}

SourcePosition TableReader::PositionOf(std::size_t row, std::size_t column) const {
  Require(block_ && row < block_->rows, "a row of the block at hand");
  SourcePosition position{source_.file()};
  const std::string_view text = LineOfRow(row, position.line);
  if (spec_.columns[column].level) return position;
  const std::string_view inside = Unwrapped(text, spec_.delimiter);
  std::vector<TextCell> cells;
  SplitLine(inside, spec_.delimiter, cells);
  position.column = cells[spec_.columns[column].field].column +
                    static_cast<std::size_t>(inside.data() - text.data());
  return position;
}

std::string TableReader::TextOf(std::size_t row, std::size_t column) const {
  std::size_t line = 0;
  const std::string_view text = LineOfRow(row, line);
  std::vector<TextCell> cells;
  SplitLine(Unwrapped(text, spec_.delimiter), spec_.delimiter, cells);
  return Shown(cells[spec_.columns[column].field].text);
}

void TableReader::FailShort() const {
  throw LoadError(
      {source_.file(), short_line_, 1},
      fmt::format("expected {} fields as in the header, found {}", spec_.fields, short_fields_));
}

void TableReader::FailAt(std::size_t column, std::string message) const {
  throw LoadError({source_.file(), line_, column}, std::move(message));
}

}  // namespace lipoid
