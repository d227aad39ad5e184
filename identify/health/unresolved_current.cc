#include "identify/health/unresolved_current.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/logs/columns.h"
#include "identify/logs/flight/updates.h"

namespace lipoid {
namespace {

// Values on either side that tell how much changes between them, and that the mean is of.
constexpr std::size_t kTell = 15;
constexpr std::size_t kMean = 5;

struct Beside {
  double variance_A2 = 0.0;  // of what changes between the values
  double share = 0.0;        // of all that changes from value to value
  double mean_A = 0.0;
};

Beside LookBeside(const std::vector<double>& x, std::size_t at) {
  const auto range = [&](std::size_t reach) {
    return std::pair(at < reach ? 0 : at - reach, std::min(at + reach + 1, x.size()));
  };
  const auto [first, end] = range(kTell);
  double one = 0.0, two = 0.0;
  for (std::size_t k = first + 2; k < end; ++k) {
    one += 0.5 * (std::pow(x[k - 1] - x[k - 2], 2) + std::pow(x[k] - x[k - 1], 2));
    two += std::pow(x[k] - x[k - 2], 2);
  }
  Beside beside;
  if (one > 0.0) beside.share = std::clamp((2.0 * one - two) / one, 0.0, 1.0);
  beside.variance_A2 = beside.share * one / (2.0 * static_cast<double>(end - first - 2));
  const auto [from, to] = range(kMean);
  for (std::size_t k = from; k < to; ++k) beside.mean_A += x[k] / static_cast<double>(to - from);
  return beside;
}

}  // namespace

UnresolvedCurrent FindUnresolved(const Record& record, double update_s) {
  constexpr double kMatters = 1e-3;  // of the charge that was counted
  const Column& time_s = record.time_s;
  UnresolvedCurrent found;
  found.rows = FreshRows(time_s, record.current_A, update_s);
  if (found.rows.size() < 2 * kTell) return {};
  std::vector<double> at_s, shown_A;
  for (const std::size_t row : found.rows) {
    at_s.push_back(time_s[row]);
    shown_A.push_back(record.current_A[row]);
  }
  found.between_s = MedianInterval(at_s);
  found.flowed_A = record.current_A;
  const double longest_s = 2.0 * found.between_s;  // gaps are told of elsewhere
  double variance_C2 = 0.0;
  for (std::size_t f = 0; f < at_s.size(); ++f) {
    const Beside beside = LookBeside(shown_A, f);
    found.deviation_A.push_back(std::sqrt(beside.variance_A2));
    const double flowed_A = shown_A[f] + beside.share * (beside.mean_A - shown_A[f]);
    const bool backward = record.hold == Hold::kBackward;
    if (f == (backward ? 0 : at_s.size() - 1))
      continue;  // nothing flows before the first, or after the last
    const std::size_t from = backward ? f - 1 : f;
    variance_C2 +=
        beside.variance_A2 * std::pow(std::min(at_s[from + 1] - at_s[from], longest_s), 2);
    for (std::size_t k = found.rows[from] + 1; k <= found.rows[from + 1]; ++k)
      found.flowed_A[k] = flowed_A;
  }
  found.charge_C = std::sqrt(variance_C2);
  if (!(found.charge_C > kMatters * std::abs(DeliveredCharge(record).back()))) return {};
  return found;
}

double UnresolvedCurrent::most_A() const {
  return deviation_A.empty() ? 0.0 : *std::max_element(deviation_A.begin(), deviation_A.end());
}

Eigen::MatrixXd UnresolvedCurrent::Modes(int count) const {
  Eigen::MatrixXd modes_A =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(flowed_A.size()), any() ? count : 0);
  const auto values = static_cast<double>(rows.size());
  for (Eigen::Index mode = 0; mode < modes_A.cols(); ++mode) {
    const double height = std::sqrt((mode == 0 ? 1.0 : 2.0) / values);
    for (std::size_t f = 1; f < rows.size(); ++f) {
      const double place = (static_cast<double>(f) + 0.5) / values;
      const double value_A =
          height * deviation_A[f] * std::cos(std::numbers::pi * static_cast<double>(mode) * place);
      for (std::size_t k = rows[f - 1] + 1; k <= rows[f]; ++k)
        modes_A(static_cast<Eigen::Index>(k), mode) = value_A;
    }
  }
  return modes_A;
}

}  // namespace lipoid
