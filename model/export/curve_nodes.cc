#include "model/export/curve_nodes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lipoid {
namespace {

// The nodes inside (lo, hi), of which the ends are nodes already.
void Divide(const OpenCircuitVoltage& curve, double lo, double hi, int depth, CurveNodes& nodes) {
  constexpr int kMostHalvings = 16;
  const double middle = 0.5 * (lo + hi);
  // A quarter and three quarters too: a cubic may cross its chord in the middle.
  double worst_V = 0.0;
  for (const double share : {0.25, 0.5, 0.75}) {
    const double chord_V = (1.0 - share) * curve(lo) + share * curve(hi);
    worst_V = std::max(worst_V, std::abs(curve(lo + share * (hi - lo)) - chord_V));
  }
  if (worst_V <= kCurveTolerance_V || depth >= kMostHalvings) return;
  Divide(curve, lo, middle, depth + 1, nodes);
  nodes.soc.push_back(middle);
  nodes.voltage_V.push_back(curve(middle));
  Divide(curve, middle, hi, depth + 1, nodes);
}

}  // namespace

CurveNodes NodesOf(const OpenCircuitVoltage& curve) {
  if (curve.method() == OcvMethod::kLinear) return {curve.soc(), curve.voltage_V()};
  std::vector<double> ends = curve.soc();
  if (ends.empty()) {
    // Coefficients: an even start finds every wave that a few of them can have.
    constexpr int kPieces = 64;
    for (int k = 0; k <= kPieces; ++k)
      ends.push_back(curve.soc_lo() + (curve.soc_hi() - curve.soc_lo()) * k / kPieces);
  }
  CurveNodes nodes;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    if (k > 0) Divide(curve, ends[k - 1], ends[k], 0, nodes);
    nodes.soc.push_back(ends[k]);
    nodes.voltage_V.push_back(curve(ends[k]));
  }
  return nodes;
}

OpenCircuitVoltage StraightLines(const OpenCircuitVoltage& curve) {
  if (curve.method() == OcvMethod::kLinear) return curve;
  CurveNodes nodes = NodesOf(curve);
  // The curve goes on with its own end slopes: a last line of that slope, too short to matter.
  constexpr double kShort = 1e-6;
  const auto& low = curve.below();
  const auto& high = curve.above();
  nodes.soc.insert(nodes.soc.begin(), curve.soc_lo() - kShort);
  nodes.voltage_V.insert(nodes.voltage_V.begin(), low.value_V - kShort * low.slope_V);
  nodes.soc.push_back(curve.soc_hi() + kShort);
  nodes.voltage_V.push_back(high.value_V + kShort * high.slope_V);
  return OpenCircuitVoltage::Linear(std::move(nodes.soc), std::move(nodes.voltage_V));
}

CurveNodes ExtendedNodesOf(const OpenCircuitVoltage& curve, double beyond) {
  CurveNodes nodes = NodesOf(curve);
  const double below = nodes.soc.front() - beyond;
  const double above = nodes.soc.back() + beyond;
  nodes.soc.insert(nodes.soc.begin(), below);
  nodes.voltage_V.insert(nodes.voltage_V.begin(), curve(below));
  nodes.soc.push_back(above);
  nodes.voltage_V.push_back(curve(above));
  return nodes;
}

Resistance<double> FarExtended(Resistance<double> table) {
  table.soc.insert(table.soc.begin(), table.soc.front() - kFarBeyondCurve);
  table.resistance_Ohm.insert(table.resistance_Ohm.begin(), table.resistance_Ohm.front());
  table.soc.push_back(table.soc.back() + kFarBeyondCurve);
  table.resistance_Ohm.push_back(table.resistance_Ohm.back());
  return table;
}

}  // namespace lipoid
