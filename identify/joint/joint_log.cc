#include "identify/joint/joint_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "identify/stages/condensed_log.h"
#include "model/core/parallel.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Every fifth pulse, and every fifth of sixty pieces of a discharge or twelve neighbouring ones, are left
// out together. The ends of a discharge stay: beyond them there is nothing to predict from.
constexpr int kGroups = 5;
constexpr int kPieces = 60;
// Neighbouring pieces are compared together, so that errors of units hardly depend on each other.
constexpr int kPiecesOfUnit = 6;
// Logs of up to so many rows are taken as they are.
constexpr std::size_t kShortLog = 2500;
// Blocks take no more than this share of a log's rows, so that v_oc(A) is seen in detail.
constexpr double kLargestBlock = 1.0 / 150.0;

// Rows that start a pulse: with what follows until the next one they are left out together.
std::vector<std::size_t> PulseStarts(const std::vector<Segment>& segments) {
  std::vector<std::size_t> starts;
  bool rested = true;
  for (const Segment& segment : segments) {
    if (segment.kind != SegmentKind::kRest && rested) starts.push_back(segment.first);
    rested = segment.kind == SegmentKind::kRest;
  }
  return starts;
}

// Second differences of evenly spaced rows see the noise of a voltage and nothing of its slope; the
// median does not see edges. A long log is looked at here and there: 1e5 rows give the median to 0.3 %.
double VoltageNoise(const Record& record) {
  constexpr double kEven = 1e-3;
  constexpr std::size_t kEnoughRows = std::size_t{1} << 17;
  const std::size_t stride = record.size() / kEnoughRows + 1;
  std::vector<double> bends;
  for (std::size_t k = 1; k + 1 < record.size(); k += stride) {
    const double before_s = record.time_s[k] - record.time_s[k - 1];
    const double after_s = record.time_s[k + 1] - record.time_s[k];
    if (std::abs(after_s - before_s) > kEven * before_s) continue;
    bends.push_back(
        std::abs(record.voltage_V[k - 1] - 2.0 * record.voltage_V[k] + record.voltage_V[k + 1]));
  }
  constexpr double kMedianOfNormal = 0.6745;
  return bends.empty() ? 0.0 : Median(std::move(bends)) / (kMedianOfNormal * std::sqrt(6.0));
}

Condensation HowToCondense(const Record& record) {
  if (record.size() <= kShortLog) return Condensation::None();
  Condensation how;
  how.nodes = 3;
  how.growth = 0.16;
  how.late_growth = 0.16;
  how.least_rows = 6;
  how.most_rows = std::max<std::size_t>(
      8, static_cast<std::size_t>(kLargestBlock * static_cast<double>(record.size())));
  how.coarse = true;
  return how;
}

// Lengths of steps that differ by no more than the stamps' rounding are one.
JointSteps FindSteps(const JointLog& log, bool warm) {
  std::unordered_map<std::int64_t, std::uint32_t> known;
  JointSteps steps;
  steps.to.assign(log.size(), 0);
  for (std::size_t k = 1; k < log.size(); ++k) {
    const double dt_s = log.time_s[k] - log.time_s[k - 1];
    const double tolerance_s = 4.0 * std::numeric_limits<double>::epsilon() * log.time_s[k];
    const double at_K = warm ? log.HalfWay_K(k) : 0.0;
    // A length at the edge of two keys is at worst there twice.
    const auto key = static_cast<std::int64_t>(std::min(dt_s, 4e9) * 0x1p30) ^
                     static_cast<std::int64_t>(at_K * 0x1p50);
    const auto [found, fresh] =
        known.try_emplace(key, static_cast<std::uint32_t>(steps.length_s.size()));
    const std::size_t at = found->second;
    if (!fresh &&
        (std::abs(steps.length_s[at] - dt_s) > tolerance_s || (warm && steps.at_K[at] != at_K)))
      found->second = static_cast<std::uint32_t>(steps.length_s.size());
    if (found->second == steps.length_s.size()) {
      steps.length_s.push_back(dt_s);
      if (warm) steps.at_K.push_back(at_K);
    }
    steps.to[k] = found->second;
  }
  return steps;
}

bool HasPoints(const LoadedLog& log, std::optional<LogKind> only = std::nullopt) {
  const LogKind kind = log.entry.kind;
  return (only ? kind == *only : kind != LogKind::kValidation) && log.log.record.size() > 1;
}

// A temperature changes far more slowly than points follow one another.
void TakeTemperature(const LoadedLog& loaded, JointLog& log) {
  const Record& record = loaded.log.record;
  log.temperature_K.clear();
  if (!record.temperature_degC.empty()) {
    std::size_t row = 0;
    for (const double time_s : log.time_s) {
      while (row + 1 < record.size() && record.time_s[row + 1] <= time_s) ++row;
      double degC = record.temperature_degC[row];
      if (row + 1 < record.size()) {
        const double share =
            (time_s - record.time_s[row]) / (record.time_s[row + 1] - record.time_s[row]);
        if (share > 0.0) degC += share * (record.temperature_degC[row + 1] - degC);
      }
      log.temperature_K.push_back(degC + kZeroCelsius_K);
    }
  } else if (loaded.entry.ambient_degC) {
    log.temperature_K.assign(log.size(), *loaded.entry.ambient_degC + kZeroCelsius_K);
  }
  log.steps = FindSteps(log, false);
  log.warm_steps = log.temperature_K.empty() ? JointSteps{} : FindSteps(log, true);
}

JointLog MakePoints(const LoadedLog& loaded, const JointLogs& all) {
  const Record& record = loaded.log.record;
  JointLog log;
  log.file = loaded.entry.file;
  log.kind = loaded.entry.kind;
  log.initial_soc = loaded.entry.initial_soc;
  log.log_weight = loaded.entry.weight;
  log.rows = record.size();

  const auto segments = FindSegments(record);
  std::vector<std::size_t> starts;
  if (log.kind == LogKind::kPulses) starts = PulseStarts(segments);
  const double from_s = record.time_s.front();
  const double length_s = record.time_s.back() - from_s;
  struct Place {
    int group = JointLog::kAlways;
    int stretch = JointLog::kAlways;
    int unit = JointLog::kAlways;
  };
  const auto place_of = [&](std::size_t row) -> Place {
    if (log.kind == LogKind::kLowRate) return {};
    // A slow charge is left out in pieces: it alone shows v_oc from that side.
    if (log.kind == LogKind::kConstantCurrent || log.kind == LogKind::kLowRateCharge) {
      const double share = (record.time_s[row] - from_s) / length_s;
      const int piece = std::min(static_cast<int>(share * kPieces), kPieces - 1);
      if (piece == 0 || piece >= kPieces - 2) return {};
      const int unit = piece / kPiecesOfUnit;
      const int group = piece % kGroups;
      if (log.kind == LogKind::kLowRateCharge) return {group, group, unit};
      if (all.whole) return {0, 0, unit};
      return {group, all.stretched ? piece * kGroups / kPieces : group, unit};
    }
    const auto after = std::upper_bound(starts.begin(), starts.end(), row);
    const int pulse = std::max<int>(static_cast<int>(after - starts.begin()) - 1, 0);
    return {pulse % kGroups, pulse % kGroups, pulse};
  };
  const auto add =
      [&](double time_s, double step_A, double current_A, double v, double w, Place at) {
        log.time_s.push_back(time_s);
        log.step_A.push_back(step_A);
        log.current_A.push_back(current_A);
        log.voltage_V.push_back(v);
        log.count.push_back(w);
        log.group.push_back(at.group);
        log.stretch.push_back(at.stretch);
        log.unit.push_back(at.unit);
      };
  const CondensedLog condensed(record, HowToCondense(record));
  const bool backward = record.hold == Hold::kBackward;
  double scatter_V2 = 0.0;
  double free_rows = 0.0;
  for (const CondensedPiece& piece : condensed.pieces()) {
    if (piece.plain()) {
      for (std::size_t k = piece.first; k < piece.first + piece.rows; ++k) {
        const double step_A = k == 0 ? 0.0 : record.current_A[backward ? k : k - 1];
        add(record.time_s[k], step_A, record.current_A[k], record.voltage_V[k], 1.0, place_of(k));
      }
      continue;
    }
    const BlockShape& shape = condensed.shapes()[piece.shape];
    const double* voltage_V = condensed.node_voltage_V(piece);
    const double before_s = record.time_s[piece.first - 1];
    const Place place = place_of(piece.first);
    scatter_V2 += piece.remainder;
    free_rows += static_cast<double>(piece.rows) - static_cast<double>(shape.nodes());
    for (Eigen::Index j = 0; j < shape.nodes(); ++j) {
      add(before_s + shape.node_s[j],
          piece.current_A,
          piece.current_A,
          voltage_V[j],
          shape.weight[j],
          place);
    }
    const double end_s = before_s + piece.duration_s;
    if (end_s > log.time_s.back()) add(end_s, piece.current_A, piece.current_A, 0.0, 0.0, place);
  }

  TakeTemperature(loaded, log);
  log.noise_V = VoltageNoise(record);
  // Steps of a coarse voltage are scatter, and next to each other mostly none.
  if (free_rows > 0.0) log.scatter_V = std::sqrt(scatter_V2 / free_rows);
  log.shortest_s = ShortestInterval(record.time_s);
  for (const Segment& segment : segments)
    log.longest_s = std::max(log.longest_s, segment.duration_s());
  return log;
}

// A slow discharge shows v_oc, and no resistance beside it.
void FindLoads(JointLogs& all, double alpha_C) {
  constexpr double kLoad = 0.2;
  constexpr double kWide = 0.15;
  double lowest = 1.0;
  double highest = 0.0;
  for (const JointLog& log : all.logs) {
    double delivered_C = log.delivered_C;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) delivered_C += log.step_A[k] * (log.time_s[k] - log.time_s[k - 1]);
      if (std::abs(log.current_A[k]) < kLoad * all.typical_A) continue;
      const double soc = 1.0 - delivered_C / alpha_C;
      lowest = std::min(lowest, soc);
      highest = std::max(highest, soc);
    }
  }
  all.lowest_loaded_soc = lowest > kWide ? lowest : -kInfinity;
  all.highest_loaded_soc = highest < 1.0 - kWide ? highest : kInfinity;
}

// Weights of rows, then of the log.
void WeighLog(JointLog& log,
              double alpha_C,
              const OpenCircuitVoltage& curve,
              const JointWeights& weights) {
  log.delivered_C = alpha_C * (1.0 - log.initial_soc);
  double charge_C = log.delivered_C;
  double sum = 0.0;
  log.weight = log.count;
  for (std::size_t k = 0; k < log.size(); ++k) {
    if (k > 0) charge_C += log.step_A[k] * (log.time_s[k] - log.time_s[k - 1]);
    const double slope_V = curve.Evaluate(1.0 - charge_C / alpha_C).slope_V;
    const double charge_V = weights.charge_uncertainty * slope_V;
    const double voltage_V = weights.voltage_uncertainty_V;
    sum += log.weight[k];
    log.weight[k] /= 1.0 + charge_V * charge_V / (voltage_V * voltage_V);
  }
  for (double& w : log.weight) w *= log.log_weight / sum;
}

// Groups and units of one log become those of all.
void NumberGroups(JointLogs& all) {
  for (JointLog& log : all.logs) {
    int last_group = -1;
    int last_stretch = -1;
    int last_unit = -1;
    const auto first_unit = static_cast<int>(all.unit_weight.size());
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (log.group[k] == JointLog::kAlways) continue;
      last_group = std::max(last_group, log.group[k]);
      last_unit = std::max(last_unit, log.unit[k]);
      last_stretch = std::max(last_stretch, log.stretch[k]);
      log.group[k] += all.groups;
      log.stretch[k] += all.stretches;
      log.unit[k] += first_unit;
    }
    all.groups += last_group + 1;
    all.stretches += last_stretch + 1;
    all.unit_weight.resize(static_cast<std::size_t>(first_unit + last_unit + 1), 0.0);
  }
}

// Constant currents that differ by more than their scatter.
int DifferentCurrents(const std::vector<const LoadedLog*>& logs) {
  constexpr double kSame = 0.05;
  std::vector<double> currents_A;
  for (const LoadedLog* log : logs) {
    if (log->entry.kind == LogKind::kConstantCurrent)
      currents_A.push_back(Median(log->log.record.current_A.ToVector()));
  }
  std::sort(currents_A.begin(), currents_A.end());
  int different = 0;
  double last_A = 0.0;
  for (const double current_A : currents_A) {
    if (different > 0 && current_A - last_A <= kSame * std::abs(current_A)) continue;
    ++different;
    last_A = current_A;
  }
  return different;
}

// Mean over the rows for which the points stand.
double MeanTemperature(const JointLog& log) {
  double sum_K = 0.0;
  double rows = 0.0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    sum_K += log.count[k] * log.temperature_K[k];
    rows += log.count[k];
  }
  return sum_K / rows;
}

// The current of the loads, and whether a hundredth of their points has half as much again as another hundredth.
void FindCurrents(JointLogs& all) {
  constexpr double kLoad = 0.05;  // of the largest current
  constexpr double kRatio = 1.5;
  std::vector<double> loads_A;
  for (const JointLog& log : all.logs) {
    if (log.kind == LogKind::kLowRate || log.kind == LogKind::kLowRateCharge) continue;
    for (const double current_A : log.current_A) {
      if (std::abs(current_A) > kLoad * all.largest_A) loads_A.push_back(std::abs(current_A));
    }
  }
  if (loads_A.empty()) return;
  const std::size_t few = loads_A.size() / 100;
  const double small_A = ValueAtPlace(loads_A, few);
  all.several_currents = ValueAtPlace(loads_A, loads_A.size() - 1 - few) >= kRatio * small_A;
  all.load_A = ValueAtPlace(loads_A, loads_A.size() / 2);
}

// What the temperatures of the logs let be asked; every log knows its own.
void FindTemperatures(JointLogs& all) {
  struct Span {
    double low_K = std::numeric_limits<double>::infinity();
    double high_K = -std::numeric_limits<double>::infinity();
    void Take(double low, double high) {
      low_K = std::min(low_K, low);
      high_K = std::max(high_K, high);
    }
  };
  Span points;
  Span starts;
  Span means;
  std::map<LogKind, Span> of_kind;
  for (const JointLog& log : all.logs) {
    const auto [low, high] =
        std::minmax_element(log.temperature_K.begin(), log.temperature_K.end());
    points.Take(*low, *high);
    starts.Take(log.temperature_K.front(), log.temperature_K.front());
    const double mean_K = MeanTemperature(log);
    means.Take(mean_K, mean_K);
    of_kind[log.kind].Take(mean_K, mean_K);
  }
  all.coldest_K = points.low_K;
  all.warmest_K = points.high_K;
  all.start_span_K = starts.high_K - starts.low_K;
  for (const auto& [kind, span] : of_kind)
    all.like_span_K = std::max(all.like_span_K, span.high_K - span.low_K);
  const auto pulses = of_kind.find(LogKind::kPulses);
  const Span& told = pulses != of_kind.end() ? pulses->second : means;
  constexpr double kNear_K = 5.0;
  const double low_degC = told.low_K - kZeroCelsius_K;
  const double high_degC = told.high_K - kZeroCelsius_K;
  if (told.low_K > kUsual_K + kNear_K) all.told_K = std::round(low_degC) + kZeroCelsius_K;
  if (told.high_K < kUsual_K - kNear_K) all.told_K = std::round(high_degC) + kZeroCelsius_K;
}

}  // namespace

bool BothWays(const JointLogs& logs) {
  const auto any = [&](LogKind kind) {
    return std::any_of(
        logs.logs.begin(), logs.logs.end(), [kind](const auto& log) { return log.kind == kind; });
  };
  return any(LogKind::kLowRate) && any(LogKind::kLowRateCharge);
}

JointLogs MakeJointLogs(const std::vector<LoadedLog>& logs,
                        double alpha_C,
                        const OpenCircuitVoltage& curve,
                        const JointWeights& weights,
                        std::optional<LogKind> only) {
  JointLogs all = MakeJointPoints(logs, only);
  Weigh(all, alpha_C, curve, weights);
  return all;
}

JointLogs AtTemperaturesOf(const std::vector<LoadedLog>& loaded, JointLogs logs) {
  auto log = logs.logs.begin();
  for (const LoadedLog& from : loaded) {
    if (HasPoints(from)) TakeTemperature(from, *log++);
  }
  return logs;
}

JointLogs MakeJointPoints(const std::vector<LoadedLog>& logs, std::optional<LogKind> only) {
  std::vector<const LoadedLog*> used;
  for (const LoadedLog& log : logs) {
    if (HasPoints(log, only)) used.push_back(&log);
  }
  JointLogs all;
  all.logs.resize(used.size());
  const int currents = DifferentCurrents(used);
  all.whole = currents >= kWholeCurrents;
  all.stretched =
      !all.whole && currents > 1 && std::any_of(used.begin(), used.end(), [](const LoadedLog* log) {
        return log->entry.kind == LogKind::kLowRate;
      });
  ParallelFor(used.size(), [&](std::size_t l) { all.logs[l] = MakePoints(*used[l], all); });
  if (std::none_of(all.logs.begin(),
                   all.logs.end(),
                   [](const JointLog& log) { return log.temperature_K.empty(); }) &&
      !all.logs.empty()) {
    FindTemperatures(all);
  }
  NumberGroups(all);
  for (const JointLog& log : all.logs) {
    all.largest_A = std::max(all.largest_A, LargestMagnitude(log.current_A));
    all.weight_sum += log.log_weight;
    if (log.noise_V > 0.0 && !(all.noise_V > 0.0 && all.noise_V < log.noise_V))
      all.noise_V = log.noise_V;
  }
  FindCurrents(all);
  return all;
}

void Weigh(JointLogs& all,
           double alpha_C,
           const OpenCircuitVoltage& curve,
           const JointWeights& weights) {
  ParallelFor(all.logs.size(),
              [&](std::size_t l) { WeighLog(all.logs[l], alpha_C, curve, weights); });
  double squares = 0.0;
  double loaded = 0.0;
  std::fill(all.unit_weight.begin(), all.unit_weight.end(), 0.0);
  for (const JointLog& log : all.logs) {
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (log.group[k] != JointLog::kAlways)
        all.unit_weight[static_cast<std::size_t>(log.unit[k])] += log.weight[k];
      if (std::abs(log.current_A[k]) < 0.05 * all.largest_A) continue;
      squares += log.weight[k] * log.current_A[k] * log.current_A[k];
      loaded += log.weight[k];
    }
  }
  double left_out = 0.0;
  all.noise_mean_V = 0.0;
  for (const JointLog& log : all.logs) {
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (log.group[k] == JointLog::kAlways || log.count[k] <= 0.0) continue;
      left_out += log.weight[k];
      all.noise_mean_V += log.weight[k] * all.noise_V / std::sqrt(log.count[k]);
    }
  }
  constexpr double kMeanOfNormal = 0.79788;  // sqrt(2/pi)
  if (left_out > 0.0) all.noise_mean_V *= kMeanOfNormal / left_out;
  all.typical_A = loaded > 0.0 ? std::sqrt(squares / loaded) : 1.0;
  FindLoads(all, alpha_C);
}

}  // namespace lipoid
