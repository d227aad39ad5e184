#include "identify/logs/segments.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "identify/logs/columns.h"
#include "identify/logs/constancy.h"

namespace lipoid {
namespace {

constexpr double kRestShare = 0.005;       // of the largest current: C/20 beside 5C is still a load
constexpr double kToleranceShare = 0.005;  // of the largest current: what a level may wander
constexpr double kNearZeroShare =
    0.05;                              // of the largest current: rows below have the noise of zero
constexpr double kGlitchShare = 0.05;  // of the largest current: what a row or two may stray
constexpr double kEdgeShare = 0.1;     // of the rows of a level: what its slow edge may take
constexpr std::size_t kHeldRows = 3;   // fewer show no level
constexpr int kPulseLevels = 3;        // HPPC may go from regeneration straight into a discharge
constexpr double kPulseTimeShare = 0.25;   // of the record
constexpr double kPulseChargeShare = 0.6;  // of the record: two pulses may halve it
constexpr double kBriefTimeShare =
    0.1;                           // of the record: loads so brief are pulses whatever they move
constexpr double kPulse_s = 60.0;  // no cell is emptied in less

// What counts as small in this record.
struct Scale {
  double largest_A = 0.0;
  double zero_noise_A = 0.0;  // standard deviation of a row at rest
  double load_noise_A = 0.0;  // and under load

  [[nodiscard]] double Noise(double level_A) const {
    return std::abs(level_A) > kNearZeroShare * largest_A ? load_noise_A : zero_noise_A;
  }
  [[nodiscard]] double Tolerance(double level_A) const {
    return std::max(kToleranceShare * largest_A, 0.5 * Noise(level_A));
  }
};

Scale FindScale(std::span<const double> current_A) {
  Scale scale;
  scale.largest_A = LargestMagnitude(current_A);
  // One noise for rest and load where it is too large to tell them apart by row.
  const double overall = current_A.empty() ? 0.0 : RowNoise(current_A, 0, current_A.size() - 1);
  scale.zero_noise_A = scale.load_noise_A = overall;
  const double border_A = kNearZeroShare * scale.largest_A;
  if (3.0 * overall > border_A) return scale;
  std::vector<double> zero;
  std::vector<double> load;
  constexpr std::size_t kSamples = 1 << 17;
  constexpr std::size_t kRun = 64;  // neighbours stay neighbours
  const std::size_t stride = kRun * (current_A.size() / kSamples + 1);
  for (std::size_t start = 0; start < current_A.size(); start += stride) {
    for (std::size_t k = start; k < std::min(start + kRun, current_A.size()); ++k) {
      (std::abs(current_A[k]) > border_A ? load : zero).push_back(current_A[k]);
    }
  }
  if (!zero.empty()) scale.zero_noise_A = RowNoise(zero, 0, zero.size() - 1);
  if (!load.empty()) scale.load_noise_A = RowNoise(load, 0, load.size() - 1);
  return scale;
}

// Rows [first, last] at one level, or moving.
struct Piece {
  std::size_t first = 0;
  std::size_t last = 0;
  double mean_A = 0.0;  // of the rows, each alike
  bool rest = false;
  bool held = false;  // long enough and level

  [[nodiscard]] std::size_t rows() const { return last - first + 1; }
};

double Mean(std::span<const double> x, std::size_t first, std::size_t last) {
  const std::size_t rows = last - first + 1;
  return Sum(std::span(x).subspan(first, rows)) / static_cast<double>(rows);
}

// The most likely first row of a new level among [first, last], given the old level.
std::size_t ChangePoint(std::span<const double> x,
                        std::size_t first,
                        std::size_t last,
                        double old_A) {
  std::size_t best = first;
  double new_A = x[last];
  for (int pass = 0; pass < 2; ++pass) {
    const double middle = 0.5 * (old_A + new_A);
    const double sign = new_A > old_A ? 1.0 : -1.0;
    double sum = 0.0;
    double largest = -INFINITY;
    for (std::size_t k = last + 1; k-- > first;) {
      sum += sign * (x[k] - middle);
      if (sum > largest) {
        largest = sum;
        best = k;
      }
    }
    new_A = Mean(x, best, last);
  }
  return best;
}

// Cuts where the level changes: Page's test in both directions around the running mean.
std::vector<Piece> FindLevels(std::span<const double> x, const Scale& scale) {
  // exp(-2 tolerance threshold / noise²) is the chance of a false alarm: e^-20.
  constexpr double kLogFalseAlarm = 10.0;
  std::vector<Piece> pieces;
  std::size_t first = 0;
  double rows = 1.0;
  double mean = x[0];
  double up = 0.0;
  double down = 0.0;
  std::size_t up_since = 0;
  std::size_t down_since = 0;
  // Within this of the mean nothing adds up, whatever the noise.
  const double quiet_A = std::min(scale.Tolerance(0.0), scale.Tolerance(scale.largest_A));
  for (std::size_t k = 1; k < x.size(); ++k) {
    if (up == 0.0 && down == 0.0 && std::abs(x[k] - mean) <= quiet_A) {
      rows += 1.0;
      if (x[k] != mean) mean += (x[k] - mean) / rows;
      continue;
    }
    const double noise = scale.Noise(mean);
    const double tolerance = scale.Tolerance(mean);
    const double drift =
        tolerance + 2.0 * noise / std::sqrt(rows);  // the mean itself is not sharp yet
    const double threshold = kLogFalseAlarm * noise * noise / tolerance;
    const double deviation = x[k] - mean;
    if (up == 0.0) up_since = k;
    if (down == 0.0) down_since = k;
    up = std::max(0.0, up + deviation - drift);
    down = std::max(0.0, down - deviation - drift);
    if (up <= threshold && down <= threshold) {
      rows += 1.0;
      mean += deviation / rows;
      continue;
    }
    const std::size_t since = up > threshold ? up_since : down_since;
    const std::size_t change = ChangePoint(x, std::max(since, first + 1), k, mean);
    pieces.push_back({.first = first, .last = change - 1});
    first = change;
    rows = static_cast<double>(k - change + 1);
    mean = Mean(x, change, k);
    up = down = 0.0;
  }
  pieces.push_back({.first = first, .last = x.size() - 1});
  return pieces;
}

class Cutter {
 public:
  explicit Cutter(const Record& record)
      : time_s_(record.time_s), x_(record.current_A), scale_(FindScale(record.current_A)) {}

  std::vector<Piece> Cut() {
    auto pieces = FindLevels(x_, scale_);
    for (Piece& piece : pieces) Describe(piece);
    RemoveGlitches(pieces);
    JoinMoving(pieces);
    JoinEdges(pieces);
    return pieces;
  }

 private:
  void Describe(Piece& piece) const {
    piece.mean_A = Mean(x_, piece.first, piece.last);
    const double rows = static_cast<double>(piece.rows());
    const double noise = scale_.Noise(piece.mean_A);
    piece.rest = std::abs(piece.mean_A) <=
                 std::max(kRestShare * scale_.largest_A, 4.0 * noise / std::sqrt(rows));
    piece.held = piece.rows() >= kHeldRows && !Slopes(piece);
  }

  // A taper is cut into pieces that each still fall.
  [[nodiscard]] bool Slopes(const Piece& piece) const {
    const std::size_t half = piece.rows() / 2;
    const double rise =
        Mean(x_, piece.last - half + 1, piece.last) - Mean(x_, piece.first, piece.first + half - 1);
    const double noise = scale_.Noise(piece.mean_A) * std::sqrt(2.0 / static_cast<double>(half));
    return std::abs(rise) > 0.4 * kToleranceShare * scale_.largest_A + 4.0 * noise;
  }

  [[nodiscard]] bool Steps(const Piece& a, const Piece& b) const {
    return std::abs(x_[b.first] - x_[a.last]) > kGlitchShare * scale_.largest_A;
  }

  // A row or two that stray a little and return to the level before.
  void RemoveGlitches(std::vector<Piece>& pieces) const {
    std::vector<Piece> kept;
    std::vector<std::size_t> joined;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const bool inside = !kept.empty() && k + 1 < pieces.size();
      if (inside && pieces[k].rows() < kHeldRows) {
        const double before = kept.back().mean_A;
        const double back = pieces[k + 1].mean_A - before;
        if (std::abs(back) <= 2.0 * scale_.Tolerance(before) &&
            std::abs(pieces[k].mean_A - before) <= kGlitchShare * scale_.largest_A) {
          kept.back().last = pieces[++k].last;
          if (joined.empty() || joined.back() + 1 != kept.size()) joined.push_back(kept.size() - 1);
          continue;
        }
      }
      kept.push_back(pieces[k]);
    }
    pieces = std::move(kept);
    for (const std::size_t k : joined) Describe(pieces[k]);
  }

  // Neighbours of which none is held make one; a rest of a row or two among them is part of the
  // drive.
  void JoinMoving(std::vector<Piece>& pieces) const {
    const auto moving = [](const Piece& piece) {
      return !piece.held && (!piece.rest || piece.rows() < kHeldRows);
    };
    const auto joins = [&](const Piece& a, const Piece& b) {
      if (!moving(a) || !moving(b)) return false;
      if (a.rows() < kHeldRows && b.rows() < kHeldRows) return true;
      return a.mean_A * b.mean_A > 0.0 &&
             !(a.rows() >= kHeldRows && b.rows() >= kHeldRows && Steps(a, b));
    };
    std::vector<Piece> kept;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const Piece& next = pieces[k];
      const bool goes_on = !next.rest || (k + 1 < pieces.size() && joins(next, pieces[k + 1]));
      if (!kept.empty() && !kept.back().rest && goes_on && joins(kept.back(), next)) {
        kept.back().last = next.last;
        kept.back().mean_A = Mean(x_, kept.back().first, next.last);
      } else {
        kept.push_back(next);
      }
    }
    pieces = std::move(kept);
  }

  // The short time in which the current finds its level belongs to that level; the tail of a taper,
  // where it hardly falls any more, belongs to the taper.
  void JoinEdges(std::vector<Piece>& pieces) const {
    const auto time_s = [&](const Piece& piece) {
      return time_s_[piece.last] - time_s_[piece.first - std::min<std::size_t>(piece.first, 1)];
    };
    const auto edge_of = [&](const Piece& piece, const Piece& level) {
      return !piece.rest && !piece.held && level.held && !level.rest &&
             (piece.rows() < kHeldRows || time_s(piece) <= kEdgeShare * time_s(level)) &&
             std::abs(piece.mean_A) < std::abs(level.mean_A) && piece.mean_A * level.mean_A > 0.0;
    };
    const auto tail_of = [&](const Piece& piece, const Piece& taper) {
      return !piece.rest && !taper.rest && !taper.held &&
             std::abs(piece.mean_A) < std::abs(taper.mean_A) && piece.mean_A * taper.mean_A > 0.0 &&
             !Steps(taper, piece);
    };
    std::vector<Piece> kept;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      if (k + 1 < pieces.size() && edge_of(pieces[k], pieces[k + 1])) {
        pieces[k + 1].first = pieces[k].first;
      } else if (!kept.empty() &&
                 ((pieces[k].rows() < kHeldRows && edge_of(pieces[k], kept.back())) ||
                  tail_of(pieces[k], kept.back()))) {
        kept.back().last = pieces[k].last;
      } else {
        kept.push_back(pieces[k]);
      }
    }
    pieces = std::move(kept);
  }

  std::span<const double> time_s_;
  std::span<const double> x_;
  Scale scale_;
};

// The charge delivered so far, from piece to piece and never back.
class ChargeWalk {
 public:
  explicit ChargeWalk(const Record& record) : record_(record) {}

  double At(std::size_t row) {
    if (row > row_) moved_.Append(CountCharge(record_, row_, row));
    row_ = std::max(row, row_);
    return moved_.charge_C;
  }
  [[nodiscard]] double range_C() const { return moved_.most_C - moved_.least_C; }

 private:
  const Record& record_;
  std::size_t row_ = 0;
  ChargeMoved moved_;
};

// When the current of rows [first, last] flows, and what it moves.
Segment Measure(const Record& record, ChargeWalk& charge, const Piece& piece) {
  const bool backward = record.hold == Hold::kBackward;
  const std::size_t from = backward && piece.first > 0 ? piece.first - 1 : piece.first;
  const std::size_t to = !backward && piece.last + 1 < record.size() ? piece.last + 1 : piece.last;
  Segment segment{.first = piece.first,
                  .last = piece.last,
                  .start_s = record.time_s[from],
                  .end_s = record.time_s[to]};
  const double before_C = charge.At(from);
  segment.charge_C = charge.At(to) - before_C;
  segment.current_A = to > from ? segment.charge_C / segment.duration_s() : piece.mean_A;
  return segment;
}

// Tells pulses from longer loads among those between two rests.
void NameLoads(const Record& record,
               double charge_range_C,
               double load_s,
               bool beside_rest,
               std::vector<Segment>::iterator begin,
               std::vector<Segment>::iterator end) {
  const double record_s = record.time_s.back() - record.time_s.front();
  std::ptrdiff_t levels = 0;
  for (auto segment = begin; segment != end; ++segment) {
    if (!MeasureConstancy(record, segment->first, segment->last).constant()) continue;
    segment->kind = SegmentKind::kConstantCurrent;
    ++levels;
  }
  for (auto segment = begin; segment != end; ++segment) {
    const double duration_s = segment->duration_s();
    const bool part = std::abs(segment->charge_C) <= kPulseChargeShare * charge_range_C ||
                      load_s <= kBriefTimeShare * record_s;
    const bool brief = duration_s <= kPulse_s || (duration_s <= kPulseTimeShare * record_s && part);
    if (segment->kind != SegmentKind::kConstantCurrent || !brief) continue;
    if (levels <= kPulseLevels && beside_rest) segment->kind = SegmentKind::kPulse;
    if (levels > kPulseLevels) segment->kind = SegmentKind::kVarying;
  }
}

}  // namespace

std::vector<Segment> FindSegments(const Record& record) {
  std::vector<Segment> segments;
  if (record.size() == 0) return segments;
  ChargeWalk charge(record);
  double load_s = 0.0;
  for (const Piece& piece : Cutter(record).Cut()) {
    segments.push_back(Measure(record, charge, piece));
    segments.back().kind = piece.rest ? SegmentKind::kRest : SegmentKind::kVarying;
    if (!piece.rest) load_s += segments.back().duration_s();
  }
  const auto is_rest = [](const Segment& segment) { return segment.kind == SegmentKind::kRest; };
  for (auto first = segments.begin(); first != segments.end();) {
    if (is_rest(*first)) {
      ++first;
      continue;
    }
    const auto end = std::find_if(first, segments.end(), is_rest);
    const bool beside_rest = (first != segments.begin() && (first - 1)->duration_s() > 0.0) ||
                             (end != segments.end() && end->duration_s() > 0.0);
    NameLoads(record, charge.range_C(), load_s, beside_rest, first, end);
    first = end;
  }
  return segments;
}

double RestThreshold(const Record& record) {
  const Scale scale = FindScale(record.current_A);
  return std::max(kRestShare * scale.largest_A, 4.0 * scale.zero_noise_A);
}

}  // namespace lipoid
