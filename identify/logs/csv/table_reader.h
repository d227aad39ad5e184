#pragma once

/// @file
/// Reads the wanted columns of a delimited text file, block by block, as doubles.
///
/// Strict: every row has the fields of the header, every wanted cell is wholly what it should be;
/// otherwise a LoadError with line and column. Plain rows take a path with nothing but fast_float
/// and comparisons; any row with a quote, a blank or trouble is taken again by the careful one.
/// Pieces of text go down the plain path side by side, each up to its first row that needs care;
/// care is taken of one after the other, and what is found does not depend on the number of
/// threads. Tests: tests/identify/logs/csv/table_reader_test.cc.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/logs/csv/text_source.h"
#include "identify/logs/csv/times.h"
#include "model/core/errors.h"
#include "model/core/text_cells.h"

namespace lipoid {

enum class CellKind {
  kNumber,
  kDuration,  ///< 01:02:03.4, in s
  kDateTime,  ///< a date with a time of day, in s since that of the first row read
  kWord,      ///< a text that TableSpec::word turns into a number
};

struct WantedColumn {
  std::string name = {};  ///< the header's, for messages
  std::size_t field = 0;  ///< from 0
  CellKind kind = CellKind::kNumber;
  bool lenient = false;  ///< a cell that is not a number becomes NaN
  /// Not in the rows but in the lines above them: see TableSpec::levels.
  std::optional<std::size_t> level = {};
};

struct TableSpec {
  char delimiter = ',';
  std::size_t first_line = 1;         ///< number of the first line that NextBlock() sees
  std::size_t fields = 0;             ///< of the header, up to its last name
  std::size_t nameless_fields = 0;    ///< of the header, those without a name at its end included
  std::vector<WantedColumn> columns;  ///< any order
  DateOrder date_order = DateOrder::kYearFirst;
  bool comments = false;  ///< lines that start with # are skipped
  /// The fields of each level of heading above the rows; rows start with as many delimiters as
  /// there are levels, a heading of level k with k.
  std::vector<std::size_t> levels;
  std::function<double(std::string_view)> word;
};

/// Rows of one block, column by column in the order of TableSpec::columns.
struct TableBlock {
  std::size_t rows = 0;
  std::size_t bytes = 0;     ///< of text, to estimate how many rows are still to come
  std::size_t capacity = 0;  ///< rows that fit into the columns
  std::vector<std::unique_ptr<double[]>> columns;
};

class TableReader {
 public:
  /// The source stands at the first line after the header.
  TableReader(TextSource& source, TableSpec spec);

  /// False at the end. Positions and texts are those of this block until the next call.
  bool NextBlock(TableBlock& block);

  /// Every block in order, each while the next ones are read.
  void ForEachBlock(const std::function<void(TableBlock&)>& take);

  /// Where a cell of the block at hand stands.
  [[nodiscard]] SourcePosition PositionOf(std::size_t row, std::size_t column) const;
  /// Its text, for messages.
  [[nodiscard]] std::string TextOf(std::size_t row, std::size_t column) const;

  /// 1 where the last line of the file was dropped because it is certainly cut off: it lacks
  /// fields, or (without a line end) digits that every other row has.
  [[nodiscard]] std::size_t cut_last_lines() const {
    return cut_last_lines_ + (short_line_ > 0 ? 1 : 0);
  }
  [[nodiscard]] std::size_t blank_lines() const { return blank_lines_; }
  [[nodiscard]] std::size_t comment_lines() const { return comment_lines_; }
  [[nodiscard]] bool last_line_has_no_end() const { return last_line_has_no_end_; }
  [[nodiscard]] bool decimal_comma() const { return decimal_ == ','; }
  [[nodiscard]] bool trailing_delimiter() const { return trailing_delimiter_; }
  /// Of dates such as 03/04/2021, where they themselves said it.
  [[nodiscard]] std::optional<DateOrder> found_date_order() const { return dates_.found(); }

 private:
  enum class Row { kRead, kSkipped, kUnusual };

  // A number that the last row had too, as currents do: where the same bytes come again, up to the
  // delimiter behind them, so does the number.
  struct Repeated {
    static constexpr int kMostBytes = 8;
    static constexpr int kMostMisses = 64;

    std::uint64_t bytes = 0;  // of the field and its delimiter, in one word
    std::uint64_t mask = 0;   // those of the word that count; 0: none
    double value = 0.0;
    std::ptrdiff_t length = 0;  // of the field
    int misses = 0;             // in a row; a column with too many is not looked at any more
  };

  // A piece of text and what the plain path made of its beginning.
  struct Piece {
    std::string_view text;
    TableBlock block;
    std::size_t bytes_read = 0;  // of the text, by block.rows rows
    bool trailing_delimiter = false;
    char decimal = '.';              // the mark that they were read with
    std::vector<Repeated> repeated;  // of each column
  };

  void ReadPlainRows(Piece& piece);
  void Finish(Piece& piece);
  Row ReadFast(const char*& at,
               const char* end,
               std::size_t row,
               char decimal,
               TableBlock& block,
               bool& trailing_delimiter,
               Repeated* repeated);
  const char* ReadNumber(
      const char* at, const char* end, char decimal, Repeated* repeated, double& value) const;
  Row ReadCarefully(std::string_view line, bool has_end, std::size_t row);
  void ReadHeading(const std::vector<TextCell>& cells, std::size_t level);
  bool Convert(std::string_view text, const WantedColumn& column, double& value);
  [[nodiscard]] bool NeedsOnlyNumbers() const;
  void DecideDecimalMark();
  bool IsCut(std::string_view line, const std::vector<TextCell>& cells) const;
  void NoteLastFields(std::string_view piece);
  [[nodiscard]] std::string_view LineOfRow(std::size_t row, std::size_t& line) const;
  [[noreturn]] void FailShort() const;
  [[noreturn]] void FailAt(std::size_t column, std::string message) const;

  TextSource& source_;
  TableSpec spec_;
  std::vector<std::size_t>
      order_;  // columns in the order of their fields, those of levels left out
  char line_end_;

  TableBlock* block_ = nullptr;
  std::string_view piece_;
  std::size_t piece_line_ = 1;  // number of the first line of the piece
  std::size_t line_ = 1;        // number of the line at hand
  std::vector<std::pair<std::size_t, std::size_t>>
      row_lines_;  // row, its line: where rows stop being adjacent
  std::vector<TextCell> cells_;
  std::vector<double> heading_values_;
  std::array<Piece, TextSource::kPiecesAlive> pieces_;  // taken in turn

  std::atomic<char> decimal_ = '.';  // found out by Finish() while other pieces are read
  bool decimal_is_known_ = false;
  DateColumn dates_;
  std::size_t cut_last_lines_ = 0;
  std::size_t short_line_ =
      0;  // number of a line that lacks fields: an error if another row follows
  std::size_t short_fields_ = 0;
  std::size_t blank_lines_ = 0;
  std::size_t comment_lines_ = 0;
  bool last_line_has_no_end_ = false;
  bool trailing_delimiter_ = false;
  // Digits after the decimal mark in the last field of the rows looked at, and whether that is a
  // number.
  std::size_t last_field_rows_ = 0;
  std::size_t last_field_decimals_ = 0;
  bool last_field_varies_ = false;
};

}  // namespace lipoid
