#include "identify/stages/open_circuit_voltage_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "identify/stages/curve_forms.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

bool HasNodes(const CurveRows& rows, const OcvFitOptions& options) {
  const bool joins =
      options.method == OcvMethod::kLinear || options.method == OcvMethod::kMonotoneCubic;
  return joins && rows.size() > static_cast<std::size_t>(options.interpolate_up_to);
}

OpenCircuitVoltage FitCurve(const CurveRows& rows,
                            const Share& share,
                            const NodeTask& task,
                            const OcvFitOptions& options) {
  switch (options.method) {
    case OcvMethod::kPolynomial:
      return FitPolynomial(rows, share, options.degree);
    case OcvMethod::kFourier:
      return FitFourier(rows, share, options.harmonics);
    case OcvMethod::kLinear:
    case OcvMethod::kMonotoneCubic:
      break;
  }
  CurveNodes curve = FitOnNodes(task, rows, share);
  if (options.method == OcvMethod::kLinear) {
    return OpenCircuitVoltage::Linear(std::move(curve.soc), std::move(curve.voltage_V));
  }
  MakeMonotone(curve.voltage_V);
  return OpenCircuitVoltage::MonotoneCubic(std::move(curve.soc), std::move(curve.voltage_V));
}

// The state of charge of every row, by counting.
struct ChargeCount {
  std::unique_ptr<double[]> soc;
  double most_C = 0.0;  // that left at any time
};

// In pieces, side by side, once it is known what left before each.
ChargeCount CountedSoc(const Record& record, double alpha_C, double initial_soc) {
  constexpr std::size_t kPiece = 1 << 16;
  ChargeCount counted{std::make_unique_for_overwrite<double[]>(record.size())};
  if (record.size() > 0) counted.soc[0] = initial_soc;
  if (record.size() < 2) return counted;
  const std::size_t last = record.size() - 1;
  const std::size_t pieces = (last + kPiece - 1) / kPiece;
  std::vector<ChargeMoved> moved(pieces);
  const auto end = [&](std::size_t p) { return std::min(last, (p + 1) * kPiece); };
  ParallelFor(pieces, [&](std::size_t p) { moved[p] = CountCharge(record, p * kPiece, end(p)); });
  std::vector<ChargeMoved> before(pieces);
  for (std::size_t p = 1; p < pieces; ++p) {
    before[p] = before[p - 1];
    before[p].Append(moved[p - 1]);
  }
  const std::size_t back = record.hold == Hold::kBackward ? 0 : 1;
  ParallelFor(pieces, [&](std::size_t p) {
    double charge_C = before[p].charge_C;
    for (std::size_t k = p * kPiece + 1; k <= end(p); ++k) {
      charge_C += record.current_A[k - back] * (record.time_s[k] - record.time_s[k - 1]);
      counted.soc[k] = initial_soc - charge_C / alpha_C;  // (4.59)
    }
  });
  before.back().Append(moved.back());
  counted.most_C = before.back().most_C;
  return counted;
}

struct RowsUnderLoad {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t count = 0;  // less than end - first where rests stand between them
};

RowsUnderLoad FindRowsUnderLoad(const Record& record, double rest_A) {
  const auto loaded = [&](double current_A) { return current_A > rest_A; };
  const auto& current_A = record.current_A;
  const auto first = std::find_if(current_A.begin(), current_A.end(), loaded);
  const auto end = std::find_if(current_A.rbegin(), current_A.rend(), loaded).base();
  if (first == current_A.end()) return {};
  return {.first = static_cast<std::size_t>(first - current_A.begin()),
          .end = static_cast<std::size_t>(end - current_A.begin()),
          .count = static_cast<std::size_t>(std::count_if(first, end, loaded))};
}

}  // namespace

OcvFitResult FitOpenCircuitVoltage(const Record& record,
                                   double alpha_C,
                                   double initial_soc,
                                   const OcvFitOptions& options) {
  Require(alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", alpha_C}});
  const double rest_A = RestThreshold(record);
  OcvFitResult result;
  ChargeCount counted = CountedSoc(record, alpha_C, initial_soc);
  result.charge_C = counted.most_C;
  const RowsUnderLoad loaded = FindRowsUnderLoad(record, rest_A);
  CurveRows rows;
  std::vector<double> gathered_V;
  if (loaded.count == loaded.end - loaded.first) {
    rows.soc = {counted.soc.get() + loaded.first, loaded.count};
    rows.voltage_V = std::span(record.voltage_V).subspan(loaded.first, loaded.count);
  } else {  // rests stand between them
    gathered_V.reserve(loaded.count);
    for (std::size_t k = loaded.first; k < loaded.end; ++k) {
      if (record.current_A[k] <= rest_A) continue;
      counted.soc[gathered_V.size()] = counted.soc[k];
      gathered_V.push_back(record.voltage_V[k]);
    }
    rows.soc = {counted.soc.get(), gathered_V.size()};
    rows.voltage_V = gathered_V;
  }
  const std::size_t coefficients = options.method == OcvMethod::kPolynomial ? options.degree + 1
                                   : options.method == OcvMethod::kFourier
                                       ? 2 * options.harmonics + 1
                                       : 4;
  if (rows.size() < 3 * coefficients) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected at least {} rows under load for this open-circuit voltage curve, found {}",
            3 * coefficients,
            rows.size()));
  }

  // The curve reaches up to where the log started, a row above the first one under load.
  const Extent reached = FindExtent(rows.soc);
  rows.lo = reached.least;
  rows.hi = std::max(initial_soc, reached.most);

  const Share shown{options.leave_out_every};
  NodeTask task;
  if (HasNodes(rows, options)) {
    const int count = std::clamp(options.knots, 4, std::max(4, static_cast<int>(rows.size() / 3)));
    task = MakeNodeTask(rows, count, shown);
  }
  const OpenCircuitVoltage judged = FitCurve(rows, shown, task, options);
  ErrorAccumulator errors;
  for (std::size_t k = shown.first(); k < rows.size(); k += std::max<std::size_t>(shown.step(), 1))
    errors.Add(rows.voltage_V[k], judged(rows.soc[k]));
  result.errors = errors.Result();
  result.curve = FitCurve(rows, {}, task, options);
  result.rows = rows.size();
  // The median load, of rows enough.
  constexpr std::size_t kSamples = 1 << 16;
  std::vector<double> loads;
  const std::size_t stride = rows.size() / kSamples + 1;
  loads.reserve(rows.size() / stride + 1);
  for (std::size_t k = loaded.first; k < loaded.end; k += stride) {
    if (record.current_A[k] > rest_A) loads.push_back(record.current_A[k]);
  }
  result.current_A = UpperMedian(std::move(loads));
  return result;
}

}  // namespace lipoid
