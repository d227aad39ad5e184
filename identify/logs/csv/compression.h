#pragma once

/// @file
/// The bytes of a file that is compressed with gzip or zstd, as a stream: by zlib and by libzstd.
/// What is compressed is known by its first bytes. Memory does not grow with the file, and neither
/// does what a small file may stand for: see kMostRatio.
/// Tests: tests/identify/logs/csv/compression_test.cc.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

class Decompressor {
 public:
  /// Up to so many bytes of the file; 0 at its end.
  using ReadBytes = std::function<std::size_t(char* to, std::size_t most)>;

  /// So many bytes any file may stand for, and so many more for each byte that it has: no log gets
  /// that short, and a file made to fill a disk or a day gets shorter.
  static constexpr std::uint64_t kMostFree = std::uint64_t{1} << 24;
  static constexpr std::uint64_t kMostRatio = 100;

  /// Null where `begin`, the first bytes of the file, are those of neither.
  [[nodiscard]] static std::unique_ptr<Decompressor> Make(std::string_view begin,
                                                          std::string file,
                                                          ReadBytes read);
  virtual ~Decompressor() = default;
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  /// Up to so many bytes of what was compressed; 0 at its end. LoadError where the file is cut,
  /// damaged, or stands for too much, with how far it could be read.
  [[nodiscard]] std::size_t Read(char* to, std::size_t most);

  /// "gzip" or "zstd".
  [[nodiscard]] const std::string& name() const { return name_; }

 protected:
  Decompressor(std::string name, std::string_view begin, std::string file, ReadBytes read);

  enum class State {
    kGoesOn,
    kEnds,  ///< of a stream, behind which another one may begin
  };
  /// Takes from `in` and writes to `out`, both of which get shorter from the front.
  [[nodiscard]] virtual State Step(std::string_view& in, char*& out, char* out_end) = 0;
  /// Makes ready for another stream, which begins with `in`; false where it does not begin there.
  [[nodiscard]] virtual bool Again(std::string_view in) = 0;
  /// LoadError: "expected ..., found ...", and how far the file could be read; the step at hand had
  /// written so many bytes.
  [[noreturn]] void Fail(std::string_view found, std::size_t written = 0) const;

 private:
  void Refill();

  std::string name_;
  std::string file_;
  ReadBytes read_;
  std::vector<char> buffer_;
  std::string_view in_;       // of the buffer, not yet taken
  std::uint64_t read_bytes_;  // of the file
  std::uint64_t text_bytes_ = 0;
  bool at_end_ = false;  // of the file
  bool ended_ = false;   // the stream
};

}  // namespace lipoid
