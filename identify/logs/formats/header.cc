#include "identify/logs/formats/header.h"

#include <algorithm>

namespace lipoid {
namespace {

// Is this byte one that continues a character of UTF-8?
bool Continues(std::string_view text, std::size_t k) {
  return k < text.size() && (static_cast<unsigned char>(text[k]) & 0xC0) == 0x80;
}

// Letters without their accents, of UTF-8 and of Latin-1: e for an e acute. The ones of Latin-1 that
// UTF-8 writes in two bytes begin with 0xC3, and then lack 0x40. Characters of three bytes, as the Chinese
// ones, stay.
std::string WithoutAccents(std::string_view text) {
  constexpr std::string_view kPlain =
      "aaaaaaaceeeeiiiidnooooo/ouuuuyts"   // 0xC0 .. 0xDF
      "aaaaaaaceeeeiiiidnooooo/ouuuuyty";  // 0xE0 .. 0xFF
  std::string plain;
  for (std::size_t k = 0; k < text.size(); ++k) {
    auto c = static_cast<unsigned char>(text[k]);
    if ((c & 0xF0) == 0xE0 && Continues(text, k + 1) && Continues(text, k + 2)) {
      plain += text.substr(k, 3);
      k += 2;
      continue;
    }
    if (c == 0xC3 && Continues(text, k + 1))
      c = static_cast<unsigned char>(static_cast<unsigned char>(text[++k]) + 0x40);
    plain += c >= 0xC0 ? kPlain[c - 0xC0] : static_cast<char>(c);
  }
  return plain;
}

// Blanks and hyphens as '_', never two in a row.
std::string Normal(std::string_view text) {
  std::string normal;
  for (const char c : WithoutAccents(LowerCase(Trimmed(text)))) {
    const char mark = c == ' ' || c == '-' || c == '\t' ? '_' : c;
    if (mark != '_' || !normal.ends_with('_')) normal += mark;
  }
  return normal;
}

}  // namespace

std::string Narrow(std::string_view text) {
  struct Wide {
    std::string_view bytes;
    char usual;
  };
  // The last is the micro sign of Latin-1, where that byte is no part of a longer character.
  constexpr Wide kWide[] = {{"\uFF08", '('},
                            {"\uFF09", ')'},
                            {"\u2103", 'C'},
                            {"\u2109", 'F'},
                            {"\u00B5", 'u'},
                            {"\u03BC", 'u'},
                            {"\xB5", 'u'}};
  const auto is_ascii = [&](std::size_t k) {
    return k >= text.size() || static_cast<unsigned char>(text[k]) < 0x80;
  };
  std::string narrow;
  for (std::size_t k = 0; k < text.size();) {
    const std::string_view rest = text.substr(k);
    const auto* const wide =
        std::find_if(std::begin(kWide), std::end(kWide), [&](const Wide& each) {
          return rest.starts_with(each.bytes) &&
                 (each.bytes.size() > 1 || ((k == 0 || is_ascii(k - 1)) && is_ascii(k + 1)));
        });
    const bool found = wide != std::end(kWide);
    narrow += found ? wide->usual : text[k];
    k += found ? wide->bytes.size() : 1;
  }
  return narrow;
}

HeaderName ParseHeaderName(const TextCell& cell) {
  const std::string lower = LowerCase(Narrow(cell.text));
  HeaderName header{.text = std::string(cell.text), .column = cell.column, .whole = Normal(lower)};
  std::string_view name = lower;
  if (name.ends_with(')') || name.ends_with(']')) {
    const auto open = name.find_last_of(name.back() == ')' ? '(' : '[');
    if (open != std::string_view::npos && open > 0) {
      header.unit = Trimmed(name.substr(open + 1, name.size() - open - 2));
      name = name.substr(0, open);
    }
  } else if (const auto mark = name.find_last_of("/#");
             mark != std::string_view::npos && mark + 1 < name.size()) {
    header.unit = Trimmed(name.substr(mark + 1));
    name = name.substr(0, mark);
  }
  header.name = Normal(name);
  while (header.name.ends_with('_')) header.name.pop_back();
  if (const auto last = header.name.rfind('_');
      header.unit.empty() && last != std::string::npos && last > 0) {
    header.stem = header.name.substr(0, last);
    header.suffix = header.name.substr(last + 1);
  }
  return header;
}

std::size_t RankIn(std::string_view alternatives, std::string_view name) {
  if (name.empty()) return alternatives.npos;
  for (std::size_t rank = 0; !alternatives.empty(); ++rank) {
    const auto bar = std::min(alternatives.find('|'), alternatives.size());
    if (alternatives.substr(0, bar) == name) return rank;
    alternatives.remove_prefix(std::min(bar + 1, alternatives.size()));
  }
  return alternatives.npos;
}

namespace {

std::vector<HeaderMatch> FindNamed(std::span<const HeaderName> header,
                                   Quantity quantity,
                                   std::string_view names) {
  std::vector<HeaderMatch> right;
  std::vector<HeaderMatch> wrong;
  const bool has_unit = !UsualUnits(quantity).empty();
  for (std::size_t field = 0; field < header.size(); ++field) {
    const HeaderName& column = header[field];
    HeaderMatch match{.field = field, .rank = RankIn(names, column.name), .unit = column.unit};
    if (match.rank != names.npos) {
      if (match.unit.empty() && has_unit && FindUnit(quantity, column.name))
        match.unit = column.name;  // Amps
    } else if (has_unit && !column.stem.empty()) {
      match.rank = RankIn(names, column.stem);
      match.unit = column.suffix;
    }
    if (match.rank == names.npos) continue;
    match.unit_is_wrong = has_unit && !match.unit.empty() && !FindUnit(quantity, match.unit);
    (match.unit_is_wrong ? wrong : right).push_back(std::move(match));
  }
  return right.empty() ? wrong : right;
}

}  // namespace

std::vector<HeaderMatch> FindColumns(std::span<const HeaderName> header,
                                     Quantity quantity,
                                     const ColumnNames& names) {
  auto matches = FindNamed(header, quantity, names.names);
  return matches.empty() ? FindNamed(header, quantity, names.otherwise) : matches;
}

bool Matches(std::span<const HeaderName> header, std::span<const std::string_view> signature) {
  return std::all_of(signature.begin(), signature.end(), [&](std::string_view alternatives) {
    const auto holds = [&](std::string_view name) {
      return RankIn(alternatives, name) != alternatives.npos;
    };
    return alternatives.empty() ||
           std::any_of(header.begin(), header.end(), [&](const HeaderName& column) {
             return holds(column.name) || holds(column.whole) || holds(column.stem);
           });
  });
}

}  // namespace lipoid
