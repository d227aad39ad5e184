#include "model/core/structured_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace lipoid::structured_text {
namespace {

// The byte after a text in quotes of TOML that begins at `from`; the end where it does not end.
std::size_t AfterQuotes(std::string_view text, std::size_t from) {
  const char quote = text[from];
  const std::string three(3, quote);
  const bool long_text = text.substr(from, 3) == three;
  const std::string_view closing = long_text ? std::string_view(three) : text.substr(from, 1);
  for (std::size_t k = from + closing.size(); k < text.size(); ++k) {
    if (text[k] == '\\' && quote == '"') {
      ++k;
    } else if (text[k] == '\n' && !long_text) {
      return k;  // the parser will say so
    } else if (text.substr(k, closing.size()) == closing) {
      k += closing.size();
      // Up to two more quotes belong to a long text.
      for (int more = 0; long_text && more < 2 && k < text.size() && text[k] == quote; ++more) ++k;
      return k;
    }
  }
  return text.size();
}

}  // namespace

SourcePosition PositionOfByte(const std::string& file, std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto lines = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  const std::size_t last = before.rfind('\n');
  return {file, lines + 1, before.size() - (last == std::string_view::npos ? 0 : last + 1) + 1};
}

void CheckText(std::string_view text, const std::string& file) {
  if (text.size() > kMostBytes) {
    throw LoadError(
        {file},
        fmt::format("expected at most {} bytes, found more: this is no file that lipoid "
                    "reads",
                    kMostBytes));
  }
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    throw LoadError(PositionOfByte(file, text, nul), "expected text, found a NUL byte");
  }
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    if (end - from > kMostBytesOfLine) {
      throw LoadError(
          PositionOfByte(file, text, from),
          fmt::format(
              "expected lines of at most {} bytes, found one of {}", kMostBytesOfLine, end - from));
    }
    from = end + 1;
  }
}

void CheckToml(std::string_view text, const std::string& file) {
  Budget budget(text, file);
  std::size_t depth = 0;
  std::size_t dots = 0;  // since the last mark that ends a key or a number
  for (std::size_t k = 0; k < text.size(); ++k) {
    switch (text[k]) {
      case '#':
        k = std::min(text.find('\n', k), text.size());
        dots = 0;
        break;
      case '"':
      case '\'':
        k = AfterQuotes(text, k) - 1;
        break;
      case '.':
        budget.Dots(++dots, k);
        break;
      case '[':
      case '{':
        budget.Enter(k);
        ++depth;
        dots = 0;
        break;
      case ']':
      case '}':
        if (depth > 0) {
          budget.Leave();
          --depth;
        }
        dots = 0;
        break;
      case '=':
        budget.Key(k);
        dots = 0;
        break;
      case ',':
        budget.Value(k);
        dots = 0;
        break;
      case '\n':
        dots = 0;
        break;
      default:
        break;
    }
  }
}

void Budget::Enter(std::size_t byte) {
  if (++depth_ > kMostDepth) Fail(byte, kMostDepth, "lists and tables in one another");
}

void Budget::Key(std::size_t byte) {
  if (++keys_ > kMostKeys) Fail(byte, kMostKeys, "keys");
}

void Budget::Value(std::size_t byte) {
  if (++values_ > kMostValues) Fail(byte, kMostValues, "values");
}

void Budget::Dots(std::size_t dots, std::size_t byte) const {
  if (dots >= kMostDepth) Fail(byte, kMostDepth, "parts of a key");
}

void Budget::Fail(std::size_t byte, std::size_t most, std::string_view of_what) const {
  throw LoadError(PositionOfByte(file_, text_, byte),
                  fmt::format("expected at most {} {}, found more", most, of_what));
}

}  // namespace lipoid::structured_text
