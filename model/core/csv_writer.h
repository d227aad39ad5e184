#pragma once

/// @file
/// Writes numbers as CSV, fast: every number with the shortest digits that read back to the same
/// double and without an exponent, NaN as nothing. The file appears whole or not at all
/// (atomic_file.h).
///
///   CsvWriter csv("out.csv", "time_s,voltage_V");
///   csv.Row(0.5, 3.7);
///   csv.Commit();
///
/// Tests: tests/model/core/csv_writer_test.cc.

#include <charconv>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "model/core/atomic_file.h"

namespace lipoid {

class CsvWriter {
 public:
  /// Begins with the header line. OptionError where the file cannot be written.
  CsvWriter(const std::string& file, std::string_view header) : file_(file) {
    buffer_.append(header);
    buffer_.push_back('\n');
  }

  template <class... Numbers>
  void Row(Numbers... numbers) {
    (Number(numbers), ...);
    EndRow();
  }
  /// The same of at least one number in a list, and of a word behind them that needs no quotes, if any.
  void RowOf(std::span<const double> numbers, std::string_view word = {}) {
    for (const double number : numbers) Number(number);
    if (!word.empty()) buffer_.append(word).push_back(',');
    EndRow();
  }

  /// Hands what was written to the disk; Commit() does it too.
  void Flush() {
    file_.Write(buffer_);
    bytes_ += buffer_.size();
    buffer_.clear();
  }
  void Commit() {
    Flush();
    file_.Commit();
  }

  [[nodiscard]] std::size_t rows() const { return rows_; }
  /// Handed to the disk so far.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 20;

  void EndRow() {
    buffer_.back() = '\n';
    ++rows_;
    if (buffer_.size() > kPiece) Flush();
  }
  void Number(double value) {
    if (!std::isnan(value)) {
      char digits[400];  // 1.8e308 has 309 of them before the point, 5e-324 has 326 behind it
      const auto [end, error] =
          std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed);
      buffer_.append(digits, end);
    }
    buffer_.push_back(',');
  }

  AtomicFile file_;
  std::string buffer_;
  std::size_t rows_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace lipoid
