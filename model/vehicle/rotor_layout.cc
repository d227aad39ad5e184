#include "model/vehicle/rotor_layout.h"

#include <cmath>
#include <numbers>

namespace lipoid {
namespace {

enum class Level { kSingle, kUpper, kLower };

struct Place {
  double from_nose_deg;  // clockwise, seen from above
  double turning;
  Level level = Level::kSingle;
};

struct Row {
  RotorLayout layout;
  std::array<Place, kMostRotors> places;
  std::size_t count;
};

// The only list of layouts, in the order of the enumeration. Neighbours turn against each other;
// in coaxial pairs the lower rotor turns against the upper one.
constexpr std::array kRows{
    Row{RotorLayout::kQuadX, {{{45, 1}, {135, -1}, {225, 1}, {315, -1}}}, 4},
    Row{RotorLayout::kQuadPlus, {{{0, 1}, {90, -1}, {180, 1}, {270, -1}}}, 4},
    Row{RotorLayout::kHexaX, {{{30, 1}, {90, -1}, {150, 1}, {210, -1}, {270, 1}, {330, -1}}}, 6},
    Row{RotorLayout::kHexaPlus, {{{0, 1}, {60, -1}, {120, 1}, {180, -1}, {240, 1}, {300, -1}}}, 6},
    Row{RotorLayout::kOctoX,
        {{{22.5, 1},
          {67.5, -1},
          {112.5, 1},
          {157.5, -1},
          {202.5, 1},
          {247.5, -1},
          {292.5, 1},
          {337.5, -1}}},
        8},
    Row{RotorLayout::kOctoPlus,
        {{{0, 1}, {45, -1}, {90, 1}, {135, -1}, {180, 1}, {225, -1}, {270, 1}, {315, -1}}},
        8},
    Row{RotorLayout::kY6,
        {{{60, 1, Level::kUpper},
          {60, -1, Level::kLower},
          {180, 1, Level::kUpper},
          {180, -1, Level::kLower},
          {300, 1, Level::kUpper},
          {300, -1, Level::kLower}}},
        6},
    Row{RotorLayout::kX8,
        {{{45, 1, Level::kUpper},
          {45, -1, Level::kLower},
          {135, -1, Level::kUpper},
          {135, 1, Level::kLower},
          {225, 1, Level::kUpper},
          {225, -1, Level::kLower},
          {315, -1, Level::kUpper},
          {315, 1, Level::kLower}}},
        8},
};

constexpr bool InOrder() {
  for (std::size_t k = 0; k < kRows.size(); ++k)
    if (kRows[k].layout != RotorLayout(k)) return false;
  return kRows.size() == OptionNames(RotorLayout{}).size();
}
static_assert(InOrder());

using Rotors = std::array<Rotor, kMostRotors>;

// Cosine that is exactly the same, up to its sign, for angles that mirror each other.
double Cosine(double degrees) {
  const double folded = std::abs(std::remainder(degrees, 360.0));  // 0 .. 180
  if (folded == 90.0) return 0.0;
  if (folded > 90.0) return -Cosine(180.0 - folded);
  if (folded == 45.0) return std::sqrt(0.5);
  return std::cos(folded * std::numbers::pi / 180.0);
}

std::array<Rotors, kRows.size()> AllRotors() {
  std::array<Rotors, kRows.size()> all;
  for (std::size_t k = 0; k < kRows.size(); ++k) {
    for (std::size_t i = 0; i < kRows[k].count; ++i) {
      const Place& place = kRows[k].places[i];
      all[k][i] = {.ahead = Cosine(place.from_nose_deg),
                   .right = Cosine(place.from_nose_deg - 90.0),
                   .turning = place.turning,
                   .lower = place.level == Level::kLower};
    }
  }
  return all;
}

}  // namespace

std::span<const Rotor> RotorsOf(RotorLayout layout) {
  static const auto all = AllRotors();
  const auto k = std::size_t(layout);
  return std::span(all[k]).first(kRows[k].count);
}

}  // namespace lipoid
