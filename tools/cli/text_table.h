#pragma once

/// @file
/// Tables for people: numbers to the right, words to the left, units in the header. A table that
/// is wider than a screen of 100 columns leaves out the folder that its files have in common, then
/// breaks the headers of its numbers and its words at blanks.
///
///   TextTable table({{"log", kLeft}, {"mean / %"}});
///   table.Row({"cc_1C.csv", Significant(0.2234)});
///
/// Tests: tests/tools/cli_test.cc.

#include <string>
#include <string_view>
#include <vector>

namespace lipoid::cli {

/// kFile: names of files, to the left.
enum class Align { kRight, kLeft, kFile };

class TextTable {
 public:
  struct Column {
    std::string header;
    Align align = Align::kRight;
  };

  /// A table with a caption goes into papers, too (TablesForPaper).
  explicit TextTable(std::vector<Column> columns, std::string caption = "")
      : columns_(std::move(columns)), caption_(std::move(caption)) {}

  /// As many cells as there are columns.
  void Row(std::vector<std::string> cells);
  [[nodiscard]] std::string Text() const;
  /// The same for a paper: a table with booktabs' rules under its caption.
  [[nodiscard]] std::string Latex(std::string_view about = "") const;

 private:
  std::vector<Column> columns_;
  std::string caption_;
  std::vector<std::vector<std::string>> rows_;
};

/// While it lives, keeps for a paper each table with a caption that this thread makes text of, so
/// that the paper has what the screen shows. One at a time.
class TablesForPaper {
 public:
  TablesForPaper();
  ~TablesForPaper();
  TablesForPaper(const TablesForPaper&) = delete;
  TablesForPaper& operator=(const TablesForPaper&) = delete;

  /// Its preamble wants \\usepackage{booktabs}.
  [[nodiscard]] const std::string& latex() const { return latex_; }
  /// What the tables from here on are of, before each caption: a log or a cell where there are several; "" is none.
  static void About(std::string_view what);

 private:
  friend class TextTable;
  std::string latex_;
  std::string about_;
};

/// Words as LaTeX shows them: what LaTeX reads as commands is escaped, and the letters that units
/// need (square, Ohm, degree, root, micro) become its own.
[[nodiscard]] std::string LatexText(std::string_view words);

/// A number with so many significant digits, trailing zeros kept: "0.2234", "1354", "2.400e-05".
/// "-" where it is not a number.
[[nodiscard]] std::string Significant(double value, int digits = 4);

/// Words in lines that end before column 100. The first begins at column `indent`, where the caller
/// has put it; the others are indented as far.
[[nodiscard]] std::string Wrapped(const std::string& text, std::size_t indent = 0);

/// The same of each line of a text.
[[nodiscard]] std::string WrappedLines(const std::string& text);

/// A title, and sentences under it in lines of at most 100 characters, each marked; "" without any.
[[nodiscard]] std::string Bullets(std::string_view title,
                                  const std::vector<std::string>& sentences);

}  // namespace lipoid::cli
