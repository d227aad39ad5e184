#include "identify/logs/parts.h"

#include <algorithm>
#include <cmath>

#include "identify/logs/columns.h"
#include "identify/logs/gaps.h"

namespace lipoid {
namespace {

// Shares of the charge that the record moves.
constexpr double kRecharge = 0.3;
constexpr double kLeastDischarge = 0.02;

// Charging segments without a rest between them are one recharge.
std::vector<bool> RowsOfRecharges(const Record& record,
                                  const std::vector<Segment>& segments,
                                  double range_C) {
  std::vector<bool> recharges(record.size(), false);
  const auto charges = [&](std::size_t k) {
    return segments[k].kind != SegmentKind::kRest && segments[k].charge_C < 0.0;
  };
  for (std::size_t k = 0; k < segments.size();) {
    double charge_C = 0.0;
    std::size_t end = k;
    for (; end < segments.size() && charges(end); ++end) charge_C -= segments[end].charge_C;
    if (charge_C >= kRecharge * range_C) {
      std::fill(recharges.begin() + static_cast<std::ptrdiff_t>(segments[k].first),
                recharges.begin() + static_cast<std::ptrdiff_t>(segments[end - 1].last + 1),
                true);
    }
    k = std::max(end, k + 1);
  }
  return recharges;
}

}  // namespace

std::vector<LogPart> FindParts(const Record& record,
                               const std::vector<Segment>& segments,
                               const std::vector<Gap>& gaps) {
  if (record.size() < 2) return {};
  const double range_C = CountCharge(record).range_C();
  if (!(range_C > 0.0)) return {};
  const std::vector<bool> recharges = RowsOfRecharges(record, segments, range_C);
  std::vector<bool> begins_anew(record.size(), false);
  bool cut = std::find(recharges.begin(), recharges.end(), true) != recharges.end();
  for (const Gap& gap : gaps) {
    if (gap.unknown_C <= kMostUnknownCharge * range_C) continue;
    begins_anew[gap.row] = true;
    cut = true;
  }
  if (!cut) return {};
  std::vector<LogPart> parts;
  for (std::size_t k = 0; k < record.size();) {
    if (recharges[k]) {
      ++k;
      continue;
    }
    LogPart part{.first = k, .last = k, .after_gap = begins_anew[k]};
    while (part.last + 1 < record.size() && !recharges[part.last + 1] &&
           !begins_anew[part.last + 1])
      ++part.last;
    k = part.last + 1;
    const ChargeMoved out = CountCharge(record, part.first, part.last);
    if (out.most_C >= kLeastDischarge * range_C) parts.push_back(part);
  }
  return parts;
}

Record RowsOf(const Record& record, const LogPart& part) {
  Record rows;
  rows.file = record.file;
  rows.hold = record.hold;
  for (const auto column : kRecordColumns) {
    const Column& from = record.*column;
    if (!from.empty())
      rows.*column = Column(from.begin() + part.first, from.begin() + part.last + 1);
  }
  const double start_s = rows.time_s.empty() ? 0.0 : rows.time_s.front();
  for (double& t : rows.time_s) t -= start_s;
  return rows;
}

}  // namespace lipoid
