#include "identify/joint/capacity_reference.h"

#include "identify/fit/cell_of_solution.h"
#include "identify/joint/joint_sweep.h"
#include "model/core/errors.h"

namespace lipoid {

CutoffPoint FindCutoff(const std::vector<double>& soc,
                       const std::vector<double>& voltage_V,
                       double cutoff_V) {
  Require(soc.size() >= 2 && soc.size() == voltage_V.size(),
          "two nodes or more",
          {{"nodes", static_cast<double>(soc.size())}});
  CutoffPoint point;
  const std::size_t last = soc.size() - 1;
  if (voltage_V.front() <= cutoff_V) {
    while (point.lower + 1 < last && voltage_V[point.lower + 1] <= cutoff_V) ++point.lower;
    point.upper = point.lower + 1;
  } else {
    point.extrapolated = true;
    constexpr double kFlat_V = 1e-4;
    while (point.lower + 1 < last && voltage_V[point.lower + 1] <= voltage_V.front() + kFlat_V)
      ++point.lower;
    point.upper = point.lower + 1;
    while (point.upper < last && soc[point.upper] - soc[point.lower] < kSecantSoc) ++point.upper;
  }
  const double rise_V = voltage_V[point.upper] - voltage_V[point.lower];
  point.soc = soc[point.lower];
  if (!(rise_V > 0.0)) return point;
  const double width = soc[point.upper] - soc[point.lower];
  const double below_V = cutoff_V - voltage_V[point.lower];
  point.soc += below_V * width / rise_V;
  point.per_upper_V = -below_V * width / (rise_V * rise_V);
  point.per_lower_V = -width / rise_V - point.per_upper_V;
  point.found = true;
  return point;
}

CutoffPoint CutoffOf(const JointSolution& solution,
                     const JointLogs& logs,
                     const JointSetup& setup,
                     double cutoff_V) {
  const auto& nodes = solution.structure.voltage_soc;
  const SocTrace soc = TraceSoc(logs, setup, solution.rates);
  const ReachedSoc reached{soc.lowest, soc.highest};
  const std::size_t first = reached.Of(nodes, 2).first;
  const OpenCircuitVoltage curve = CurveOf(solution, setup.open_circuit_voltage, reached);
  CutoffPoint point = FindCutoff(curve.soc(), curve.voltage_V(), cutoff_V);
  point.lower += first;
  point.upper += first;
  return point;
}

}  // namespace lipoid
