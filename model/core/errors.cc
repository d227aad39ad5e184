#include "model/core/errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/core/foreign_text.h"

namespace lipoid {
namespace {

// As they are shown: fit for a terminal, and none twice.
std::vector<Diagnostic> Shown(std::vector<Diagnostic> all) {
  std::vector<Diagnostic> kept;
  for (auto& one : all) {
    one.message = ForeignText(one.message, kMostBytesOfMessage);
    if (std::find(kept.begin(), kept.end(), one) == kept.end()) kept.push_back(std::move(one));
  }
  return kept;
}

std::string JoinLines(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  const auto shown = std::min(diagnostics.size(), LoadError::kMaxLines);
  for (std::size_t k = 0; k < shown; ++k) {
    if (k > 0) text += '\n';
    text += diagnostics[k].Text();
  }
  if (diagnostics.size() > shown)
    text += fmt::format("\n... and {} more", diagnostics.size() - shown);
  return text;
}

}  // namespace

std::string Diagnostic::Text() const {
  const std::string place =
      position.line == 0 ? "" : fmt::format(":{}:{}", position.line, position.column);
  return fmt::format("{}{}: error: {}",
                     ForeignText(position.file, kMostBytesOfMessage),
                     place,
                     ForeignText(message, kMostBytesOfMessage));
}

LoadError::LoadError(SourcePosition position, std::string message)
    : LoadError(std::vector<Diagnostic>{{std::move(position), std::move(message)}}) {}

LoadError::LoadError(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(JoinLines(Shown(diagnostics))),
      diagnostics_(Shown(std::move(diagnostics))) {}

void Require(bool holds,
             std::string_view rule,
             std::initializer_list<std::pair<std::string_view, double>> values,
             const char* file,
             int line) {
  if (holds) return;
  std::string text = fmt::format("{}:{}: precondition broken: {}", file, line, rule);
  const char* separator = " where ";
  for (const auto& [name, value] : values) {
    text += fmt::format("{}{} = {}", separator, name, value);
    separator = ", ";
  }
  throw PreconditionError(text);
}

}  // namespace lipoid
