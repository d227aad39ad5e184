#include "identify/logs/csv/text_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "model/core/errors.h"

namespace lipoid {
namespace {

std::string WhyNotOpened(const std::string& file, int error) {
  if (error == ENOENT || error == ENOTDIR) {
    return "expected a log file, found no file of this name; check the path";
  }
  return fmt::format(
      "expected a log file that can be read, found '{}': {}", file, std::strerror(error));
}

}  // namespace

TextSource::TextSource(std::string file) : file_(std::move(file)) {
  struct stat status {};
  if (::stat(file_.c_str(), &status) != 0)
    throw LoadError(NoFile(file_), WhyNotOpened(file_, errno));
  if (S_ISDIR(status.st_mode)) {
    throw LoadError({file_}, "expected a log file, found a folder; name the files in it");
  }
  descriptor_ = ::open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw LoadError({file_}, WhyNotOpened(file_, errno));
  if (S_ISREG(status.st_mode)) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    ::posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
  }
  try {
    Begin();
  } catch (...) {
    ::close(descriptor_);  // no destructor runs for an object that was never made
    throw;
  }
}

TextSource::TextSource(std::string file, std::string_view text)
    : file_(std::move(file)), descriptor_(::memfd_create("log", MFD_CLOEXEC)), size_(text.size()) {
  try {
    if (descriptor_ < 0) throw std::bad_alloc();
    for (std::size_t written = 0; written < text.size();) {
      const auto count = ::write(descriptor_, text.data() + written, text.size() - written);
      if (count <= 0) throw std::bad_alloc();  // such a file lies in memory
      written += static_cast<std::size_t>(count);
    }
    ::lseek(descriptor_, 0, SEEK_SET);
    Begin();
  } catch (...) {
    if (descriptor_ >= 0) ::close(descriptor_);
    throw;
  }
}

void TextSource::MakeHead(std::size_t bytes) {
  head_buffer_ = std::make_unique_for_overwrite<char[]>(bytes);
  current_ = head_buffer_.get();
  end_ = 0;
  Fill(bytes);
}

void TextSource::Begin() {
  // One byte more than the file has: only a read of nothing shows its end.
  const bool is_short = size_ > 0 && size_ < kBufferBytes;
  MakeHead(is_short ? static_cast<std::size_t>(size_) + 1 : kBufferBytes);
  if (end_ == 0) throw LoadError({file_}, "expected a log, found an empty file");
  decompressor_ = Decompressor::Make(
      head(), file_, [this](char* to, std::size_t most) { return ReadBytes(to, most); });
  if (decompressor_) {
    at_end_ = false;
    MakeHead(kBufferBytes);
    if (end_ == 0) {
      throw LoadError(
          {file_},
          fmt::format("expected a log, found an empty file packed by {}", decompressor_->name()));
    }
  }
  if (head().starts_with("\xEF\xBB\xBF")) {
    had_byte_order_mark_ = true;
    begin_ = 3;
  }
  if (head().find('\n') == std::string_view::npos && head().find('\r') != std::string_view::npos) {
    line_end_ = '\r';
  }
}

TextSource::~TextSource() { ::close(descriptor_); }

void TextSource::Skip(std::size_t bytes) {
  Require(bytes <= end_ - begin_, "only what head() holds can be skipped");
  begin_ += bytes;
}

void TextSource::Fill(std::size_t limit) {
  while (!at_end_ && end_ < limit) {
    const std::size_t count = decompressor_ ? decompressor_->Read(current_ + end_, limit - end_)
                                            : ReadBytes(current_ + end_, limit - end_);
    if (count == 0) at_end_ = true;
    end_ += count;
  }
}

std::size_t TextSource::ReadBytes(char* to, std::size_t most) {
  while (true) {
    const auto count = ::read(descriptor_, to, most);
    if (count >= 0) {
      read_bytes_ += static_cast<std::size_t>(count);
      return static_cast<std::size_t>(count);
    }
    if (errno != EINTR)
      throw LoadError({file_}, fmt::format("reading failed: {}", std::strerror(errno)));
  }
}

std::string_view TextSource::Rest(std::size_t most) {
  rest_ = head();
  begin_ = end_;
  while (!at_end_) {
    begin_ = end_ = 0;
    Fill(kPieceBytes);
    if (rest_.size() + end_ > most) {
      throw LoadError({file_}, fmt::format("expected a log of at most {} bytes, found more", most));
    }
    rest_.append(current_, end_);
  }
  return rest_;
}

std::string_view TextSource::NextPiece(std::size_t line) {
  // What is left may hold whole lines (after the header) or the start of one.
  while (true) {
    const std::string_view text = head();
    if (at_end_) {
      begin_ = end_;
      return text;
    }
    if (const auto last = text.rfind(line_end_); last != std::string_view::npos) {
      begin_ += last + 1;
      return text.substr(0, last + 1);
    }
    if (text.size() > kMaxLineBytes) {
      throw LoadError({file_, line, 1},
                      fmt::format("expected a row of a log, found a line of more than {} bytes",
                                  kMaxLineBytes));
    }
    // The start of a line goes on in the next buffer.
    auto& next = buffers_[turn_];
    turn_ = (turn_ + 1) % buffers_.size();
    if (!next) next = std::make_unique_for_overwrite<char[]>(kPieceBytes);
    std::memcpy(next.get(), text.data(), text.size());
    current_ = next.get();
    begin_ = 0;
    end_ = text.size();
    Fill(kPieceBytes);
  }
}

}  // namespace lipoid
