#include "model/core/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace lipoid {
namespace {

// Optimal string alignment distance.
std::size_t Edits(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> edits(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) edits[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) edits[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = a[i - 1] == b[j - 1];
      edits[i][j] = std::min(
          {edits[i - 1][j] + 1, edits[i][j - 1] + 1, edits[i - 1][j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
      }
    }
  }
  return edits[a.size()][b.size()];
}

}  // namespace

std::string Nearest(std::string_view typed, const std::vector<std::string>& known) {
  // More than a third of the letters wrong is another word.
  std::size_t fewest = std::max<std::size_t>(1, typed.size() / 3) + 1;
  std::string nearest;
  for (const auto& name : known) {
    // As many edits as the lengths differ are needed anyhow, and a typed megabyte is like no name.
    if (std::max(name.size(), typed.size()) - std::min(name.size(), typed.size()) >= fewest)
      continue;
    const auto edits = Edits(typed, name);
    if (edits < fewest) {
      fewest = edits;
      nearest = name;
    }
  }
  return nearest;
}

std::string DidYouMean(std::string_view typed, const std::vector<std::string>& known) {
  const std::string nearest = Nearest(typed, known);
  return nearest.empty() ? "" : fmt::format(" Did you mean '{}'?", nearest);
}

std::string NearKey(std::string_view typed, const std::vector<std::string>& known) {
  constexpr std::size_t kFewest = 3;
  const std::string near = typed.size() < kFewest ? "" : Nearest(typed, known);
  return near.empty() ? "" : fmt::format("; is it '{}'?", near);
}

std::string UnknownName(std::string_view what,
                        std::string_view typed,
                        const std::vector<std::string>& known) {
  if (known.empty()) return fmt::format("unknown {} '{}'; there are none", what, typed);
  return fmt::format("unknown {} '{}'.{} Known: {}",
                     what,
                     typed,
                     DidYouMean(typed, known),
                     fmt::join(known, ", "));
}

}  // namespace lipoid
