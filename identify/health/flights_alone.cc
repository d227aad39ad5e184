#include "identify/health/flights_alone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "identify/fit/cell_of_solution.h"
#include "identify/fit/linearized_fit.h"
#include "identify/health/flight_problem.h"
#include "identify/health/flight_samples.h"
#include "identify/joint/joint_sweep.h"
#include "identify/trust/cell_uncertainty.h"
#include "model/battery/cell_file.h"
#include "model/battery/error_metrics.h"
#include "model/core/parallel.h"

namespace lipoid {
namespace {

// A branch slower than this is not to be told from the curve over the charge of a flight.
constexpr double kSlowestBranch_s = 30.0;
// Nodes of v_oc(A) at least so far apart.
constexpr double kNodes = 0.04;

struct Flown {
  CampaignLog entry;  // its start may be put elsewhere
  const Log* log = nullptr;
  FlightSamples samples;
};

// All that are refused are told of together.
std::vector<Flown> SampleFlights(const Campaign& campaign, const std::vector<LoadedLog>& logs) {
  std::vector<Flown> flown;
  std::vector<Diagnostic> refused;
  for (const LoadedLog& loaded : logs) {
    if (loaded.entry.kind != LogKind::kFlight) continue;
    const auto wrong =
        DiagnosticsOf([&] { RefuseIdleFlight(loaded.log.record, campaign.capacity_Ah); });
    refused.insert(refused.end(), wrong.begin(), wrong.end());
    flown.push_back({loaded.entry, &loaded.log, {}});
  }
  if (!refused.empty()) throw LoadError(std::move(refused));
  ParallelFor(flown.size(), [&](std::size_t k) { flown[k].samples = SampleFlight(*flown[k].log); });
  return flown;
}

// The windows of a flight as points of the joint fit. The charge is that of all rows; the current at
// a point is the mean over its window, `lag_s` earlier, as its voltage is.
JointLog PointsOf(const Flown& flown, double alpha_C) {
  const FlightSamples& flight = flown.samples;
  const Record& record = flight.record;
  const auto rows = static_cast<Eigen::Index>(record.size());
  const std::vector<double> delivered = DeliveredCharge(record);
  Eigen::MatrixXd columns(rows, 2);
  for (Eigen::Index k = 0; k < rows; ++k)
    columns.row(k) << delivered[static_cast<std::size_t>(k)],
        record.current_A[static_cast<std::size_t>(k)];
  const Eigen::MatrixXd in = flight.InWindows(columns, flight.lag_s);
  JointLog log;
  log.file = flown.entry.file;
  log.kind = LogKind::kFlight;
  log.delivered_C = alpha_C * (1.0 - flown.entry.initial_soc) + in(0, 0);
  log.rows = record.size();
  log.log_weight = flown.entry.weight;
  log.shortest_s = std::max(flight.window_s, flight.voltage_update_s);
  log.longest_s = kSlowestBranch_s;
  const auto n = flight.windows.size();
  for (std::size_t w = 0; w < n; ++w) {
    const auto k = static_cast<Eigen::Index>(w);
    const double step_s = w == 0 ? 0.0 : flight.time_s[w] - flight.time_s[w - 1];
    log.time_s.push_back(flight.time_s[w]);
    log.step_A.push_back(w == 0 ? 0.0 : (in(k, 0) - in(k - 1, 0)) / step_s);
    log.current_A.push_back(in(k, 1));
    log.voltage_V.push_back(flight.voltage_V[k]);
    log.count.push_back(1.0);
    log.weight.push_back(log.log_weight / static_cast<double>(n));
    log.group.push_back(JointLog::kAlways);
    log.stretch.push_back(JointLog::kAlways);
    log.unit.push_back(JointLog::kAlways);
    log.steps.length_s.push_back(step_s);
    log.steps.to.push_back(static_cast<std::uint32_t>(w));
  }
  return log;
}

JointLogs AllOf(std::vector<JointLog> logs) {
  JointLogs all;
  all.logs = std::move(logs);
  double squares = 0.0;
  for (const JointLog& log : all.logs) {
    all.weight_sum += log.log_weight;
    for (std::size_t k = 0; k < log.size(); ++k) {
      all.largest_A = std::max(all.largest_A, std::abs(log.current_A[k]));
      squares += log.weight[k] * log.current_A[k] * log.current_A[k];
    }
  }
  all.typical_A = std::sqrt(squares / all.weight_sum);
  return all;
}

// The range that was flown.
std::pair<double, double> SocRange(const JointLogs& logs, double alpha_C) {
  double lowest = 2.0;
  double highest = -1.0;
  for (const JointLog& log : logs.logs) {
    double charge_C = log.delivered_C;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (k > 0) charge_C += log.step_A[k] * (log.time_s[k] - log.time_s[k - 1]);
      lowest = std::min(lowest, 1.0 - charge_C / alpha_C);
      highest = std::max(highest, 1.0 - charge_C / alpha_C);
    }
  }
  return {lowest, highest};
}

void AssessInto(FlightsAlone& found, const JointObservations& seen, const GivenParameters& known) {
  const JointSolution& best = found.solution;
  const LinearizedFit fit = Linearize(seen, best, known);
  std::vector<TrustedQuantity> quantities = fit.quantities;
  TrustedQuantity total = fit.Quantity("r_total", "Ohm", found.total_resistance_Ohm);
  const JointLayout layout(best.structure);
  for (int t = 0; t < layout.tables(); ++t)
    total.combination[fit.Linear(layout.table(t))] = 1.0 / found.logs.typical_A;
  quantities.push_back(std::move(total));
  TrustOptions options;
  options.held = fit.held;
  options.drawn = CellParametersAmong(quantities);
  const Eigen::Index size = fit.quantities.front().combination.size();
  for (std::size_t k = 0; k < found.cell.open_circuit_voltage.soc().size(); ++k) {
    // The unknowns are rises: a node is the sum of those up to it.
    Eigen::VectorXd of = Eigen::VectorXd::Zero(size);
    of.segment(fit.Linear(0), static_cast<Eigen::Index>(k) + 1).setOnes();
    options.drawn.push_back({fmt::format("v_oc[{}]", k), std::move(of), {}});
  }
  found.trust = AssessTrust(fit.logs, fit.penalty, quantities, options);
}

// What no lithium-polymer cell has, by the curve of a typical one.
void DoubtThePack(const Campaign& campaign, FlightsAlone& found) {
  constexpr double kMost_V = 0.25;  // between chemistries of 4.2 to 4.35 V, and starts roughly told
  constexpr double kMost = 0.3;     // of the charge
  const OpenCircuitVoltage typical = LoadCell("gifi-600mAh-1").open_circuit_voltage;
  const OpenCircuitVoltage& curve = found.cell.open_circuit_voltage;
  const double high_V = curve(found.highest_soc);
  const double low_V = curve(found.lowest_soc);
  const double usual_V = typical(found.highest_soc);
  const double span = found.highest_soc - found.lowest_soc;
  const double usual_span = typical.SocAtVoltage(high_V) - typical.SocAtVoltage(low_V);
  if (std::abs(high_V - usual_V) > kMost_V) {
    found.doubts.push_back(fmt::format(
        "a cell would rest at {:.3g} V at a state of charge of {:.2f}, where a lithium-polymer cell has {:.3g} V: "
        "is `series` wrong ({}), or `initial_soc`?",
        high_V,
        found.highest_soc,
        usual_V,
        campaign.series));
  } else if (usual_span - span > kMost) {
    found.doubts.push_back(fmt::format(
        "v_oc falls from {:.3g} to {:.3g} V over {:.0f} % of the capacity of {:.4g} Ah, as a lithium-polymer cell "
        "does over {:.0f} %: is the capacity too large?",
        high_V,
        low_V,
        100.0 * span,
        campaign.capacity_Ah,
        100.0 * usual_span));
  }
}

FlightsAlone FitFlightsAlone(const Campaign& campaign, const std::vector<const Flown*>& flights) {
  FlightsAlone found;
  const double alpha_C = 3600.0 * campaign.capacity_Ah;
  std::vector<JointLog> points;
  for (const Flown* flown : flights) {
    const CampaignLog& entry = flown->entry;
    const FlightSamples& flight = flown->samples;
    points.push_back(PointsOf(*flown, alpha_C));
    found.flights.push_back({entry.file,
                             entry.initial_soc,
                             false,
                             flight.lag_s,
                             flight.window_s,
                             flight.coherence,
                             {}});
    if (const auto& told = flown->log->report.flight) {
      const int series = campaign.series == 1 ? told->cells : campaign.series;  // 1: not said
      for (std::string& doubt :
           DoubtsAboutPack(*told, series, campaign.parallel * campaign.capacity_Ah)) {
        if (std::find(found.doubts.begin(), found.doubts.end(), doubt) == found.doubts.end())
          found.doubts.push_back(std::move(doubt));
      }
    }
    for (const std::string& said : flight.Said())
      found.cautions.push_back(fmt::format("{}: {}", entry.file, said));
    if (!flight.doubt.empty())
      found.doubts.push_back(fmt::format("{}: {}", entry.file, flight.doubt));
  }
  found.logs = AllOf(std::move(points));
  std::tie(found.lowest_soc, found.highest_soc) = SocRange(found.logs, alpha_C);

  JointStructure structure;
  structure.branches = 1;
  const int pieces = std::max(1, static_cast<int>((found.highest_soc - found.lowest_soc) / kNodes));
  for (int k = 0; k <= pieces; ++k) {
    structure.voltage_soc.push_back(found.lowest_soc +
                                    (found.highest_soc - found.lowest_soc) * k / pieces);
  }
  found.setup.alpha_C = alpha_C;
  found.setup.diffusion = false;
  // A straight line: where the flights say nothing, the curve is smooth.
  found.setup.open_circuit_voltage = OpenCircuitVoltage::Linear(
      {structure.voltage_soc.front(), structure.voltage_soc.back()}, {3.7, 3.7});
  GivenParameters known;
  known.bounds["tau_1"] = {0.2, kSlowestBranch_s};
  const JointObservations seen(found.logs, found.setup);
  const JointFit fit(seen, known);
  constexpr double kSmoothness = 1e-3;
  found.solution = fit.Polish(fit.Search(structure, kSmoothness), kFineStep);
  found.converged = found.solution.termination == Termination::kConverged;
  SortBranches(found.solution);

  const JointLayout layout(structure);
  for (int t = 0; t < layout.tables(); ++t)
    found.total_resistance_Ohm += found.solution.x[layout.table(t)] / found.logs.typical_A;
  Cell& cell = found.cell;
  cell.name = campaign.name;
  cell.capacity_Ah = campaign.capacity_Ah;
  cell.cutoff_V = campaign.cutoff_V.value_or(kUsualCutoff_V);
  cell.open_circuit_voltage = CurveOf(found.solution, found.setup.open_circuit_voltage);
  PutInto(cell, found.solution, found.logs.typical_A);
  AssessInto(found, seen, known);
  DoubtThePack(campaign, found);

  const auto rows = seen.Rows(structure, found.solution.rates, found.solution.x);
  for (std::size_t l = 0; l < rows.size(); ++l) {
    ErrorAccumulator errors;
    const auto& log = found.logs.logs[l];
    for (std::size_t k = 0; k < log.size(); ++k) {
      const double residual_V = rows[l].residual_V[static_cast<Eigen::Index>(k)];
      errors.Add(log.voltage_V[k], log.voltage_V[k] - residual_V);
    }
    found.flights[l].errors.file = log.file;
    found.flights[l].errors.all = errors.Result();
    found.flights[l].errors.above_10_soc = errors.Result();
  }
  found.cautions.push_back(fmt::format(
      "the state of charge is counted from where each log is said to start (initial_soc), by the "
      "capacity of {:.4g} Ah that was given and the current as shown: flights alone tell neither",
      campaign.capacity_Ah));
  found.cautions.push_back(fmt::format(
      "v_oc(A) is known from {:.3f} to {:.3f} of the charge, and goes on with its end slope",
      found.lowest_soc,
      found.highest_soc));
  found.cautions.emplace_back(
      "diffusion and branches slower than 30 s are in v_oc(A): the cell recovers less at rest than "
      "the real one");
  return found;
}

// Several flights whose starts are not all told: the flights of which nothing is told are put where the curve of
// the others has the voltage that they rest at, the highest first.
class Starts {
 public:
  Starts(const Campaign& campaign, std::vector<Flown> flights)
      : campaign_(campaign), flights_(std::move(flights)) {
    for (const Flown& flown : flights_) rest_V_.push_back(RestVoltage(flown.log->record));
  }

  FlightsAlone Find() {
    PlaceTold();
    while (known_.size() < flights_.size()) PlaceNext();
    std::vector<const Flown*> all;
    for (const Flown& flown : flights_) all.push_back(&flown);
    // With all flights the curve is another than that of the first.
    FlightsAlone found = FitFlightsAlone(campaign_, all);
    for (int round = 0; round < kRounds && !placed_.empty(); ++round) {
      for (const std::size_t k : placed_)
        flights_[k].entry.initial_soc = found.cell.open_circuit_voltage.SocAtVoltage(*rest_V_[k]);
      found = FitFlightsAlone(campaign_, all);
    }
    for (const std::size_t k : placed_) found.flights[k].start_found = true;
    return found;
  }

 private:
  static constexpr int kRounds = 3;
  static constexpr double kSame_V = 0.005;  // of two cells that rest at the same state of charge

  [[nodiscard]] LoadError Missing(std::size_t k, const std::string& why) const {
    const CampaignLog& entry = flights_[k].entry;
    return LoadError(
        entry.position.file.empty() ? SourcePosition{entry.file} : entry.position,
        fmt::format("{} {}: give initial_soc, the state of charge at its start", entry.file, why));
  }

  // Those whose start is told; where none is, the one that rests highest is full.
  void PlaceTold() {
    for (std::size_t k = 0; k < flights_.size(); ++k) {
      if (flights_[k].entry.TellsStart()) known_.push_back(k);
    }
    for (std::size_t k = 0; k < flights_.size(); ++k) {
      if (!flights_[k].entry.TellsStart() && !rest_V_[k])
        throw Missing(
            k, "begins under load, so that its start cannot be compared with those of the others");
    }
    if (!known_.empty()) return;
    const auto highest = std::max_element(rest_V_.begin(), rest_V_.end());
    for (std::size_t k = 0; k < flights_.size(); ++k) {
      if (*rest_V_[k] > **highest - kSame_V) known_.push_back(k);
    }
  }

  // The highest of the flights that are left, on the curve of those that are placed.
  void PlaceNext() {
    std::size_t next = flights_.size();
    for (std::size_t k = 0; k < flights_.size(); ++k) {
      if (std::find(known_.begin(), known_.end(), k) != known_.end()) continue;
      if (next == flights_.size() || *rest_V_[k] > *rest_V_[next]) next = k;
    }
    std::vector<const Flown*> placed;
    for (const std::size_t k : known_) placed.push_back(&flights_[k]);
    const FlightsAlone so_far = FitFlightsAlone(campaign_, placed);
    const OpenCircuitVoltage& curve = so_far.cell.open_circuit_voltage;
    const double low_V = curve(so_far.lowest_soc);
    const double high_V = curve(so_far.highest_soc);
    if (*rest_V_[next] < low_V || *rest_V_[next] > high_V + kSame_V) {
      throw Missing(
          next,
          fmt::format(
              "rests at {:.3f} V at its start, and the flights whose start is known say what v_oc "
              "is from {:.3f} to {:.3f} V only",
              *rest_V_[next],
              low_V,
              high_V));
    }
    flights_[next].entry.initial_soc = curve.SocAtVoltage(*rest_V_[next]);
    known_.push_back(next);
    placed_.push_back(next);
  }

  const Campaign& campaign_;
  std::vector<Flown> flights_;
  std::vector<std::optional<double>> rest_V_;
  std::vector<std::size_t> known_;
  std::vector<std::size_t> placed_;
};

}  // namespace

std::string FlightsAlone::Averaged() const {
  double longest_s = 0.0;
  for (const Flight& flight : flights) longest_s = std::max(longest_s, flight.window_s);
  return fmt::format("of means over {:.2g} s, with the lag of the voltage put back", longest_s);
}

FlightsAlone IdentifyFlightsAlone(const Campaign& campaign, const std::vector<LoadedLog>& logs) {
  std::vector<Flown> flights = SampleFlights(campaign, logs);
  if (flights.size() == 1) return FitFlightsAlone(campaign, {&flights[0]});
  return Starts(campaign, std::move(flights)).Find();
}

}  // namespace lipoid
