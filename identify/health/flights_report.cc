#include "identify/health/flights_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/battery/cell_parameters.h"
#include "model/battery/prediction.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/counted.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

double ResistanceAfter(const Cell& cell, const PulseResistance& pulse) {
  const auto predicted = Predict(cell,
                                 std::vector<double>{0.0, pulse.after_s},
                                 std::vector<double>{0.0, pulse.current_A},
                                 Hold::kBackward,
                                 pulse.soc,
                                 {});
  return (predicted.voltage_V[0] - predicted.voltage_V[1]) / pulse.current_A;
}

// How a quantity of the cell moves, and how much of its variance goes.
class Moved {
 public:
  Moved(const Cell& by_lab, const FlightsWithLab& flights)
      : by_lab_(by_lab), flights_(flights), around_(by_lab) {}

  struct Change {
    double value = 0.0;
    double variance = 0.0;  // less by this
    double of = 0.0;        // of the variance that the covariance says; what is left of it is not 0

    // Of a standard error. The covariance may say more than the variance that is known of the quantity, which
    // was found in another way; not all of that goes then.
    [[nodiscard]] double Share(double known) const {
      const double all = std::max(known, of);
      return all > 0.0 ? std::sqrt(std::clamp(1.0 - variance / all, 0.0, 1.0)) : 1.0;
    }
  };
  template <class Quantity>
  [[nodiscard]] Change Of(const Quantity& quantity) const {
    constexpr double kStep = 0.1;  // of a standard deviation
    const Eigen::VectorXd x = around_.estimate() + flights_.moves * flights_.coordinates;
    Eigen::VectorXd slope(flights_.moves.cols());
    for (Eigen::Index k = 0; k < slope.size(); ++k) {
      const auto at = [&](double step) {
        return quantity(around_.At(x + step * flights_.moves.col(k)));
      };
      slope[k] = (at(kStep) - at(-kStep)) / (2.0 * kStep);
    }
    const double left = slope.dot(flights_.coordinate_covariance * slope);
    return {quantity(flights_.cell) - quantity(by_lab_),
            slope.squaredNorm() - left,
            slope.squaredNorm()};
  }

 private:
  const Cell& by_lab_;
  const FlightsWithLab& flights_;
  UncertainCell around_;
};

// What a quantity of a cell can be.
std::pair<double, double> RangeOf(const std::string& name) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const auto found = FindCellParameter(name);
  if (!found) return {0.0, kAny};  // a resistance at one state of charge
  if (found->kind == nullptr || found->kind->any_sign) return {-kAny, kAny};
  return {0.0, found->kind->upper};
}

Json EndsOf(const WithInterval& value) { return {value.low, value.high}; }

}  // namespace

std::optional<double> CellQuantity(const Cell& cell, const std::string& name) {
  const auto [what, soc] = SplitQuantity(name);
  if (!soc) return FindCellParameter(what) ? CellParameter(cell, what) : std::nullopt;
  if (const auto* one = CellResistance(cell, what)) return (*one)(*soc);
  if (what == "r_total") return TotalResistance(cell, *soc);
  return std::nullopt;
}

void MoveTrust(const Cell& by_lab, const FlightsWithLab& flights, TrustReport& trust) {
  if (!flights.taken) return;
  const Cell before = by_lab.AsOne();
  FlightsWithLab one = flights;
  one.cell = flights.cell.AsOne();
  const Moved moved(before, one);
  // With fewer degrees of freedom an interval reaches further.
  const double further = Reach95(flights.cell.uncertainty->degrees_of_freedom) /
                         Reach95(by_lab.uncertainty->degrees_of_freedom);
  for (QuantityTrust& q : trust.quantities) {
    if (!std::isfinite(q.standard_error) || q.standard_error <= 0.0) continue;
    if (!CellQuantity(before, q.name)) continue;
    const auto change = moved.Of([&](const Cell& cell) { return *CellQuantity(cell, q.name); });
    const double share = change.Share(q.standard_error * q.standard_error);
    const double estimate = q.estimate + change.value;
    const auto [least, most] = RangeOf(q.name);
    q.low = std::clamp(
        estimate - further * share * (q.estimate - q.low), std::min(least, estimate), estimate);
    q.high = std::clamp(
        estimate + further * share * (q.high - q.estimate), estimate, std::max(most, estimate));
    q.estimate = estimate;
    q.standard_error *= share;
    q.model_standard_error *= share;
    q.relative_standard_error *= share;
  }
  for (PulseResistance& pulse : trust.resistance) {
    if (!std::isfinite(pulse.high_Ohm)) continue;
    const auto change = moved.Of([&](const Cell& cell) { return ResistanceAfter(cell, pulse); });
    const double reach_Ohm = 0.5 * (pulse.high_Ohm - pulse.low_Ohm);
    // The reach is a number of standard errors that is between 2 and some: 2 takes no more away than there is.
    const double variance = 0.25 * reach_Ohm * reach_Ohm;
    const double share = change.Share(variance);
    const double now_Ohm = pulse.resistance_Ohm + change.value;
    pulse.low_Ohm = std::max(std::min(0.0, now_Ohm),
                             now_Ohm - further * share * (pulse.resistance_Ohm - pulse.low_Ohm));
    pulse.high_Ohm = now_Ohm + further * share * (pulse.high_Ohm - pulse.resistance_Ohm);
    pulse.resistance_Ohm = now_Ohm;
  }
}

Json FlightsWithLabToJson(const FlightsWithLab& found) {
  Json flights = Json::array();
  for (const auto& flight : found.flights) {
    flights.push_back({{"file", flight.file},
                       {"soc_start", flight.soc_start.value},
                       {"soc_start_interval_95", EndsOf(flight.soc_start)},
                       {"current_scale", flight.current_scale.value},
                       {"current_scale_interval_95", EndsOf(flight.current_scale)},
                       {"current_offset_A", flight.current_offset_A.value},
                       {"current_offset_interval_95", EndsOf(flight.current_offset_A)},
                       {"lag_s", flight.lag_s.value},
                       {"lag_interval_95", EndsOf(flight.lag_s)},
                       {"window_s", flight.window_s},
                       {"coherence", flight.coherence},
                       {"mean_error_percent", flight.mean_error_percent},
                       {"max_error_percent", flight.max_error_percent},
                       {"temperature_known", flight.temperature_known},
                       {"cautions", flight.cautions}});
  }
  Json refused = Json::array();
  for (const Diagnostic& diagnostic : found.refused)
    refused.push_back({{"file", diagnostic.position.file}, {"reason", diagnostic.message}});
  Json parameters = Json::array();
  for (const auto& one : found.parameters) {
    parameters.push_back({{"name", one.name},
                          {"unit", std::string(CellParameterUnit(one.name))},
                          {"by_lab", one.by_lab},
                          {"by_lab_standard_error", one.by_lab_error},
                          {"estimate", one.estimate},
                          {"standard_error", one.error}});
  }
  return {{"taken", found.taken},
          {"not_taken_because",
           found.not_taken_because.empty() ? Json(nullptr) : Json(found.not_taken_because)},
          {"distance", found.distance},
          {"distance_limit", found.distance_limit},
          {"directions", found.directions},
          {"lab_mean_error_percent", NumberOrNull(found.lab_mean_error_percent)},
          {"lab_mean_error_with_flights_percent",
           NumberOrNull(found.lab_mean_error_with_flights_percent)},
          {"flights", std::move(flights)},
          {"refused", std::move(refused)},
          {"parameters", std::move(parameters)}};
}

std::string FlightsWithLabText(const FlightsWithLab& found) {
  if (!found.taken)
    return fmt::format("The cell is that of the lab logs alone: {}.", found.not_taken_because);
  constexpr double kWorthSaying = 0.9;  // of the standard error before
  const FlightsWithLab::Parameter* best = nullptr;
  double least = kWorthSaying;
  for (const auto& one : found.parameters) {
    if (!(one.by_lab_error > 0.0) || one.error / one.by_lab_error >= least) continue;
    least = one.error / one.by_lab_error;
    best = &one;
  }
  std::string text = fmt::format("The cell is that of the lab logs and of {} together. ",
                                 Counted(found.flights.size(), "flight"));
  if (best != nullptr) {
    text += fmt::format(
        "The flights add most to {}: {:.4g} +- {:.2g} {} by the lab logs, {:.4g} +- {:.2g} with the "
        "flights. ",
        best->name,
        best->by_lab,
        best->by_lab_error,
        CellParameterUnit(best->name),
        best->estimate,
        best->error);
  } else {
    text += "They make no standard error smaller by a tenth or more. ";
  }
  text += fmt::format("The mean error of the lab logs is {:.3g} % with them, {:.3g} % without.",
                      found.lab_mean_error_with_flights_percent,
                      found.lab_mean_error_percent);
  return text;
}

}  // namespace lipoid
