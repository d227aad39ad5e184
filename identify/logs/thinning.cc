#include "identify/logs/thinning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/constancy.h"
#include "model/core/parallel.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// A jump of the voltage may be a reading that failed: spikes.h looks for twice as much.
constexpr double kJump_V = 0.1;
// Intervals that grow by this may be a gap: as gaps.cc has it.
constexpr double kLongerThanLast = 10.0;
// The first rows say the resolution of the clock: plausibility.h.
constexpr std::size_t kFirstRows = 32;
// Of the rows to the nearest row at which something happens.
constexpr std::size_t kShareOfDistance = 4;
// Rows that are thinned side by side.
constexpr std::size_t kRowsOfPiece = std::size_t{1} << 16;
// Rows that come before they are thinned.
constexpr std::size_t kTail = std::size_t{1} << 20;

// The columns of rows, to be written over; those that the log does not have are null.
struct View {
  double* time_s = nullptr;
  double* current_A = nullptr;
  double* voltage_V = nullptr;
  double* temperature_degC = nullptr;
  std::int8_t* direction = nullptr;

  // Rows that lie behind move forward.
  void Move(std::size_t from, std::size_t to, std::size_t rows) const {
    const auto move = [=](auto* column) {
      if (column != nullptr) std::copy(column + from, column + from + rows, column + to);
    };
    move(time_s);
    move(current_A);
    move(voltage_V);
    move(temperature_degC);
    move(direction);
  }
};

struct Rule {
  Hold hold = Hold::kBackward;
  std::size_t group = 1;
  double tolerance_A = 0.0;
  double share_of_age = Thinning::kShareOfAge;
  double jump_V = kJump_V;
  bool all_alike = false;  // what happens does not count any more: there is too much of it
};

bool Steps(const View& rows, std::size_t row, const Rule& rule) {
  return std::abs(rows.current_A[row] - rows.current_A[row - 1]) > rule.tolerance_A;
}

// Whether something happens between a row and the one before it, which has one before it as well.
bool Happens(const View& rows, std::size_t row, const Rule& rule) {
  const double* t = rows.time_s;
  return Steps(rows, row, rule) ||
         (rows.voltage_V != nullptr &&
          std::abs(rows.voltage_V[row] - rows.voltage_V[row - 1]) > rule.jump_V) ||
         t[row] - t[row - 1] > kLongerThanLast * (t[row - 1] - t[row - 2]) ||
         (rows.direction != nullptr && rows.direction[row] != rows.direction[row - 1]);
}

// Rows that are thinned by themselves: the first and the last one stay.
struct ThinnedPiece {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t kept = 0;
  double changed_s = 0.0;  // when the current last stepped before it
  std::vector<std::uint8_t> stays = {};
  std::span<RowLabel> labels = {};  // of its rows

  void Keep(std::size_t from, std::size_t to) {
    from = std::max(from, first);
    to = std::min(to, end);
    for (std::size_t k = from; k < to; ++k) stays[k - first] = 1;
  }
};

// Which rows of the piece stay; of all rows, `rows_of_all`, those beside it matter too. Returns when
// the current last stepped in it, and NaN where it did not.
double Mark(const View& rows, std::size_t rows_of_all, ThinnedPiece& piece, const Rule& rule) {
  piece.stays.assign(piece.end - piece.first, 0);
  piece.Keep(piece.first, piece.first + 1);
  piece.Keep(piece.end - 1, piece.end);
  double stepped_s = std::numeric_limits<double>::quiet_NaN();
  if (rule.all_alike) return stepped_s;
  piece.Keep(0, kFirstRows);
  constexpr std::size_t kBeside = Thinning::kBeside;
  const auto keep_around = [&](std::size_t row) {
    piece.Keep(row - std::min(row, kBeside), row + kBeside);
  };
  const std::size_t from = std::max<std::size_t>(piece.first, 2 + kBeside) - kBeside;
  for (std::size_t k = from; k < std::min(piece.end + kBeside, rows_of_all); ++k) {
    if (!Happens(rows, k, rule)) continue;
    keep_around(k);
    if (k >= piece.first && k < piece.end && Steps(rows, k, rule)) stepped_s = rows.time_s[k - 1];
  }
  for (const RowLabel& label : piece.labels) keep_around(label.row);
  return stepped_s;
}

// Makes one row of rows [first, last], of which none is the first or last of its piece.
void Join(const View& rows, std::size_t first, std::size_t last, std::size_t to, Hold hold) {
  const bool backward = hold == Hold::kBackward;
  const double* t = rows.time_s;
  const double first_A = rows.current_A[first];
  double excess_C = 0.0;
  for (std::size_t k = first + 1; k <= last; ++k) {
    const double dt_s = backward ? t[k] - t[k - 1] : t[k + 1] - t[k];
    excess_C += (rows.current_A[k] - first_A) * dt_s;
  }
  const double flowed_s = backward ? t[last] - t[first - 1] : t[last + 1] - t[first];
  rows.Move(backward ? last : first, to, 1);
  rows.current_A[to] = first_A + excess_C / flowed_s;
}

// In its place: row `to` is written when it is no longer needed, as `to` is never beyond the row at
// hand.
void ThinPiece(const View& rows, ThinnedPiece& piece, const Rule& rule) {
  std::size_t to = piece.first;
  std::size_t label = 0;
  double changed_s = piece.changed_s;
  const auto stays = [&](std::size_t row) { return piece.stays[row - piece.first] != 0; };
  const auto name = [&](std::size_t last) {
    for (; label < piece.labels.size() && piece.labels[label].row <= last; ++label)
      piece.labels[label].row = to;
  };
  for (std::size_t k = piece.first; k < piece.end;) {
    if (stays(k)) {
      if (k > piece.first && Steps(rows, k, rule)) changed_s = rows.time_s[k - 1];
      name(k);
      rows.Move(k++, to++, 1);
      continue;
    }
    std::size_t next = k;
    while (!stays(next)) ++next;
    const std::size_t quiet = k;
    while (k < next) {
      const std::size_t room = std::min(k - quiet, next - 1 - k) / kShareOfDistance;
      const std::size_t most = std::clamp<std::size_t>(room, 1, rule.group);
      const double most_s = rule.share_of_age * (rows.time_s[k] - changed_s);
      const double level_A = rows.current_A[k];
      std::size_t last = k;
      while (last + 1 < k + most && rows.time_s[last + 1] - rows.time_s[k - 1] <= most_s &&
             std::abs(rows.current_A[last + 1] - level_A) <= rule.tolerance_A)
        ++last;
      name(last);
      if (last > k) {
        Join(rows, k, last, to, rule.hold);
      } else {
        rows.Move(k, to, 1);
      }
      ++to;
      k = last + 1;
    }
  }
  piece.kept = to - piece.first;
}

// Rows [first, end) become fewer; returns where they end then.
std::size_t ThinRows(const View& rows,
                     std::size_t first,
                     std::size_t end,
                     std::span<RowLabel> labels,
                     const Rule& rule,
                     double& changed_s) {
  std::vector<ThinnedPiece> pieces;
  for (std::size_t begin = first; begin < end; begin += kRowsOfPiece) {
    ThinnedPiece piece{.first = begin, .end = std::min(end, begin + kRowsOfPiece)};
    const auto before = [](const RowLabel& label, std::size_t row) { return label.row < row; };
    const auto from = std::lower_bound(labels.begin(), labels.end(), piece.first, before);
    piece.labels = {from, std::lower_bound(from, labels.end(), piece.end, before)};
    pieces.push_back(std::move(piece));
  }
  std::vector<double> stepped_s(pieces.size());
  ParallelFor(pieces.size(),
              [&](std::size_t p) { stepped_s[p] = Mark(rows, end, pieces[p], rule); });
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    pieces[p].changed_s = changed_s;
    if (!std::isnan(stepped_s[p])) changed_s = stepped_s[p];
  }
  ParallelFor(pieces.size(), [&](std::size_t p) { ThinPiece(rows, pieces[p], rule); });
  std::size_t to = first;
  for (ThinnedPiece& piece : pieces) {
    for (RowLabel& label : piece.labels) label.row -= piece.first - to;
    rows.Move(piece.first, to, piece.kept);
    to += piece.kept;
  }
  return to;
}

View ViewOf(Thinning::Rows rows) {
  const auto data = [](auto& column) { return column.empty() ? nullptr : &*column.begin(); };
  return {.time_s = data(rows.record.time_s),
          .current_A = data(rows.record.current_A),
          .voltage_V = data(rows.record.voltage_V),
          .temperature_degC = data(rows.record.temperature_degC),
          .direction = data(rows.directions)};
}

void Resize(Thinning::Rows rows, std::size_t size) {
  const auto resize = [size](auto& column) {
    if (!column.empty()) column.resize(size);
  };
  for (const auto column : kRecordColumns) resize(rows.record.*column);
  resize(rows.directions);
  // Of several labels of one row the last one is right.
  auto& labels = rows.labels;
  const auto last = std::unique(
      labels.rbegin(), labels.rend(), [](const auto& a, const auto& b) { return a.row == b.row; });
  labels.erase(labels.begin(), last.base());
}

}  // namespace

void Thinning::MakeRoom(std::size_t more, Rows rows) {
  const std::size_t size = rows.record.size();
  if (group_ == 1) {
    if (size + more <= most_rows_ || size < 3) return;
  } else if (size - thinned_ + more <= std::min(kTail, most_rows_ / 4)) {
    return;
  }
  ThinTail(rows);
}

std::optional<ThinningFacts> Thinning::Finish(Rows rows) {
  Record& record = rows.record;
  if (group_ == 1 && record.size() <= most_rows_) return std::nullopt;
  ThinTail(rows);
  report_.rows = record.size();
  report_.rows_of_log = record.size() + dropped_;
  report_.most_rows = most_rows_;
  report_.group = group_;
  report_.tolerance_A = tolerance_A_;
  // The room of the rows that are gone is given back.
  for (const auto column : kRecordColumns) record.*column = (record.*column).ToVector();
  return report_;
}

void Thinning::Begin(const Record& record) {
  group_ = 4;
  changed_s_ = record.time_s[0];
  std::vector<double> steps_s;
  const std::size_t stride = record.size() / kTail + 1;
  for (std::size_t k = 1; k < record.size(); k += stride)
    steps_s.push_back(record.time_s[k] - record.time_s[k - 1]);
  report_.median_s = UpperMedian(std::move(steps_s));
  report_.shortest_s = std::numeric_limits<double>::infinity();
}

// What is reported of rows that are about to be thinned.
void Thinning::Count(const Record& record) {
  for (std::size_t k = std::max<std::size_t>(thinned_, 1); k < record.size(); ++k) {
    const double step_s = record.time_s[k] - record.time_s[k - 1];
    report_.shortest_s = std::min(report_.shortest_s, step_s);
    report_.longest_s = std::max(report_.longest_s, step_s);
  }
  constexpr double kLeastShare = 1e-3;
  constexpr double kDeviations = 6.0;
  const auto tail = std::span<const double>(record.current_A).subspan(thinned_);
  tolerance_A_ = std::max({tolerance_A_,
                           kLeastShare * LargestMagnitude(tail),
                           kDeviations * RowNoise(tail, 0, tail.size() - 1)});
}

void Thinning::ThinTail(Rows rows) {
  Record& record = rows.record;
  if (record.size() == thinned_) return;  // blocks behind the chosen part bring no rows
  if (group_ == 1) Begin(record);
  Count(record);
  const Rule rule{.hold = hold_,
                  .group = group_,
                  .tolerance_A = tolerance_A_,
                  .share_of_age = share_of_age_,
                  .jump_V = kJump_V * rows.volt,
                  .all_alike = false};
  const std::size_t size = record.size();
  thinned_ = ThinRows(ViewOf(rows), thinned_, size, rows.labels, rule, changed_s_);
  dropped_ += size - thinned_;
  Resize(rows, thinned_);
  while (thinned_ > most_rows_ / 2) Regroup(rows);
}

// Makes one row of two wherever that can be.
void Thinning::Regroup(Rows rows) {
  const std::size_t size = thinned_;
  const double largest_A = LargestMagnitude(rows.record.current_A);
  double changed_s = rows.record.time_s[0];
  const Rule rule{.hold = hold_,
                  .group = 2,
                  .tolerance_A = tolerance_A_,
                  .share_of_age = share_of_age_,
                  .jump_V = kJump_V * rows.volt,
                  .all_alike = tolerance_A_ > 2.0 * largest_A};
  thinned_ = ThinRows(ViewOf(rows), 0, size, rows.labels, rule, changed_s);
  dropped_ += size - thinned_;
  Resize(rows, thinned_);
  group_ *= 2;
  constexpr double kTooMany = 0.75;
  if (static_cast<double>(thinned_) <= kTooMany * static_cast<double>(size)) return;
  tolerance_A_ *= 2.0;
  share_of_age_ *= 2.0;
}

std::string ThinningText(const ThinningFacts& thinned) {
  return fmt::format(
      "{} rows, of which {} would be kept as they are, were thinned to {}: where the current keeps "
      "within {:.3g} A and nothing else happens, one row stands for up to {} with the charge of all",
      thinned.rows_of_log,
      thinned.most_rows,
      thinned.rows,
      thinned.tolerance_A,
      thinned.group);
}

}  // namespace lipoid
