#pragma once

/// @file
/// A text file in pieces of whole lines, by read(2) into one buffer: memory does not grow with the
/// file. Files of 10^8 rows pass through here, so nothing is mapped, copied or looked at twice. A file
/// that is compressed with gzip or zstd is unpacked on the way.
/// Tests: tests/identify/logs/csv/table_reader_test.cc, tests/identify/logs/log_test.cc.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "identify/logs/csv/compression.h"

namespace lipoid {

class TextSource {
 public:
  /// Bytes of the buffer, and the most that the preamble of a log may fill.
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
  /// Bytes read at a time after that: what stays in the cache between reading and parsing.
  static constexpr std::size_t kPieceBytes = std::size_t{1} << 18;
  /// So many pieces stay valid at a time, so that they can be parsed side by side.
  static constexpr std::size_t kPiecesAlive = 8;
  /// A line longer than this is not a row of a log.
  static constexpr std::size_t kMaxLineBytes = kPieceBytes / 2;

  /// Opens the file and reads its beginning. LoadError where it is missing, a folder, unreadable or
  /// empty.
  explicit TextSource(std::string file);
  /// The same of text in memory, which is copied; `file` is only for messages.
  TextSource(std::string file, std::string_view text);
  ~TextSource();
  TextSource(const TextSource&) = delete;
  TextSource& operator=(const TextSource&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }
  /// Bytes of text, 0 where their number is not known: of a pipe, or a compressed file.
  [[nodiscard]] std::uint64_t size() const { return decompressor_ ? 0 : size_; }
  /// Of the bytes of the file, those that were read; 0 where their number is not known.
  [[nodiscard]] double share_read() const {
    return size_ > 0 ? static_cast<double>(read_bytes_) / static_cast<double>(size_) : 0.0;
  }
  /// "gzip" or "zstd"; "" of a file that is not compressed.
  [[nodiscard]] std::string compression() const {
    return decompressor_ ? decompressor_->name() : std::string();
  }
  /// The beginning of the file without its byte order mark. Valid until the first NextPiece().
  [[nodiscard]] std::string_view head() const { return {current_ + begin_, end_ - begin_}; }
  /// head() holds the whole file.
  [[nodiscard]] bool head_is_all() const { return at_end_; }
  [[nodiscard]] bool had_byte_order_mark() const { return had_byte_order_mark_; }
  /// '\n', or '\r' in a file that knows no '\n'.
  [[nodiscard]] char line_end() const { return line_end_; }

  /// Forgets the first bytes of head(): the preamble and the header.
  void Skip(std::size_t bytes);

  /// The next whole lines; empty at the end of the file. Only the last piece may end without a line
  /// end. `line` is the number of the piece's first line, for the message about a line that is too
  /// long; to ask again after that message repeats it. A piece is valid until kPiecesAlive - 1 more
  /// were asked for.
  [[nodiscard]] std::string_view NextPiece(std::size_t line);

  /// All that was not yet handed out, as it stands in the file: of one that is no text. LoadError
  /// where it has more bytes than `most`.
  [[nodiscard]] std::string_view Rest(std::size_t most);

 private:
  void Begin();
  void MakeHead(std::size_t bytes);
  void Fill(std::size_t limit);
  std::size_t ReadBytes(char* to, std::size_t most);

  std::string file_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::atomic<std::uint64_t> read_bytes_ = 0;   // asked for while other threads read on
  std::unique_ptr<Decompressor> decompressor_;  // null: the file is not compressed
  std::unique_ptr<char[]> head_buffer_;
  std::string rest_;
  std::array<std::unique_ptr<char[]>, kPiecesAlive> buffers_;  // taken in turn after the head
  std::size_t turn_ = 0;
  char* current_ = nullptr;
  std::size_t begin_ = 0;  // of what was read and not yet handed out
  std::size_t end_ = 0;
  bool at_end_ = false;
  bool had_byte_order_mark_ = false;
  char line_end_ = '\n';
};

}  // namespace lipoid
