#include "identify/logs/csv/compression.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 18;
constexpr std::string_view kGzip = "\x1F\x8B";
constexpr std::string_view kZstd = "\x28\xB5\x2F\xFD";
// A frame to be skipped may come first (pzstd): one of sixteen bytes, then these.
constexpr std::string_view kZstdSkipped = "\x2A\x4D\x18";

class Gzip final : public Decompressor {
 public:
  Gzip(std::string_view begin, std::string file, ReadBytes read)
      : Decompressor("gzip", begin, std::move(file), std::move(read)) {
    constexpr int kOnlyGzip = 16;
    if (::inflateInit2(&stream_, kOnlyGzip + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  }
  ~Gzip() override { ::inflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

 private:
  State Step(std::string_view& in, char*& out, char* out_end) override {
    static_assert(sizeof(Bytef) == 1);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));  // zlib only reads it
    stream_.avail_in = static_cast<uInt>(in.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out);
    stream_.avail_out = static_cast<uInt>(out_end - out);
    const int result = ::inflate(&stream_, Z_NO_FLUSH);
    in.remove_prefix(in.size() - stream_.avail_in);
    const auto written = static_cast<std::size_t>(out_end - out) - stream_.avail_out;
    out += written;
    if (result == Z_STREAM_END) return State::kEnds;
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    if (result != Z_OK && result != Z_BUF_ERROR)
      Fail(stream_.msg != nullptr ? stream_.msg : "bytes that are damaged", written);
    return State::kGoesOn;
  }
  bool Again(std::string_view in) override {
    return in.starts_with(kGzip.front()) && ::inflateReset(&stream_) == Z_OK;
  }

  z_stream stream_{};
};

class Zstd final : public Decompressor {
 public:
  Zstd(std::string_view begin, std::string file, ReadBytes read)
      : Decompressor("zstd", begin, std::move(file), std::move(read)),
        stream_(::ZSTD_createDStream(), ::ZSTD_freeDStream) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }

 private:
  State Step(std::string_view& in, char*& out, char* out_end) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out, static_cast<std::size_t>(out_end - out), 0};
    const std::size_t result = ::ZSTD_decompressStream(stream_.get(), &to, &from);
    in.remove_prefix(from.pos);
    out += to.pos;
    if (::ZSTD_isError(result) != 0) Fail(::ZSTD_getErrorName(result), to.pos);
    return result == 0 ? State::kEnds : State::kGoesOn;
  }
  // Frames follow one another, some of which may be skipped: the library knows them.
  bool Again(std::string_view) override { return true; }

  std::unique_ptr<ZSTD_DStream, decltype(&::ZSTD_freeDStream)> stream_;
};

}  // namespace

std::unique_ptr<Decompressor> Decompressor::Make(std::string_view begin,
                                                 std::string file,
                                                 ReadBytes read) {
  if (begin.starts_with(kGzip))
    return std::make_unique<Gzip>(begin, std::move(file), std::move(read));
  const bool skipped = begin.size() > 4 && begin[0] >= 0x50 && begin[0] <= 0x5F &&
                       begin.substr(1).starts_with(kZstdSkipped);
  if (skipped || begin.starts_with(kZstd))
    return std::make_unique<Zstd>(begin, std::move(file), std::move(read));
  return nullptr;
}

Decompressor::Decompressor(std::string name,
                           std::string_view begin,
                           std::string file,
                           ReadBytes read)
    : name_(std::move(name)),
      file_(std::move(file)),
      read_(std::move(read)),
      buffer_(std::max(begin.size(), kInputBytes)),
      read_bytes_(begin.size()) {
  std::copy(begin.begin(), begin.end(), buffer_.begin());
  in_ = {buffer_.data(), begin.size()};
}

std::size_t Decompressor::Read(char* to, std::size_t most) {
  char* out = to;
  char* const out_end = to + most;
  while (out == to && most > 0) {
    if (in_.empty()) Refill();
    if (ended_) {
      // Loggers and tapes fill up with zeros.
      while (!in_.empty() && in_.find_first_not_of('\0') == std::string_view::npos && !at_end_) {
        in_ = {};
        Refill();
      }
      if (in_.find_first_not_of('\0') == std::string_view::npos) return 0;
      if (!Again(in_)) Fail("bytes that are none behind its end");
      ended_ = false;
    }
    const std::size_t before = in_.size();
    const State state = Step(in_, out, out_end);
    ended_ = state == State::kEnds;
    if (!ended_ && out == to && in_.empty() && at_end_) Fail("the end of the file before that");
    if (!ended_ && out == to && !in_.empty() && in_.size() == before)
      Fail("bytes that are damaged");
  }
  text_bytes_ += static_cast<std::uint64_t>(out - to);
  if (text_bytes_ > kMostFree + kMostRatio * read_bytes_) {
    throw LoadError({file_},
                    fmt::format("expected a log, found {} bytes of {} that stand for {} bytes and "
                                "more: no log gets {} times shorter",
                                read_bytes_,
                                name_,
                                text_bytes_,
                                kMostRatio));
  }
  return static_cast<std::size_t>(out - to);
}

void Decompressor::Refill() {
  if (at_end_) return;
  const std::size_t count = read_(buffer_.data(), buffer_.size());
  at_end_ = count == 0;
  read_bytes_ += count;
  in_ = {buffer_.data(), count};
}

void Decompressor::Fail(std::string_view found, std::size_t written) const {
  throw LoadError(
      {file_},
      fmt::format("expected {} to its end, found {} ({} bytes into the file); what comes before "
                  "stands for {} bytes: unpack what can be unpacked, and read that",
                  name_,
                  found,
                  read_bytes_ - in_.size(),
                  text_bytes_ + written));
}

}  // namespace lipoid
