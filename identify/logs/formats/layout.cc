#include "identify/logs/formats/layout.h"

namespace lipoid {

double DirectionOfWord(std::string_view word) {
  const std::string lower = LowerCase(word);
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  if (lower == "d" || has("dch") || has("disch") || has("放电")) return 1.0;
  if (lower == "c" || lower == "cha" || has("charg") || has("chg") || has("chrg") || has("充电"))
    return -1.0;
  return 0.0;
}

}  // namespace lipoid
