#include "identify/health/health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/fit_quality.h"
#include "identify/health/flight_problem.h"
#include "identify/joint/held_shape.h"
#include "identify/logs/columns.h"
#include "identify/logs/formats/layout.h"
#include "identify/logs/gaps.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/segments.h"
#include "identify/still_temperature.h"
#include "model/battery/arrhenius.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/statistics/order_statistics.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

using U = FlightUnknowns;

// A flight that tells less than this of a logarithm tells nothing that a guess does not.
constexpr double kUselessCapacity = 0.3;
constexpr double kUselessResistance = 0.4;

// Where nobody says how large the pack is: a flight takes about half of the charge, give or take a
// factor of seven.
constexpr double kGuessedOverFlown = 2.0;
constexpr double kGuessedLogCapacity = 2.0;
// Standard deviations from what was believed of the capacity, beyond which that was wrong.
constexpr double kFarFromReference = 2.0;

// Where a search ended at a limit of the capacity, the best of the range is not the best.
bool AtLimit(double log_capacity) {
  constexpr double kClose = 0.02;
  return log_capacity < kLowestLogCapacity + kClose || log_capacity > kHighestLogCapacity - kClose;
}

// Where a search for the start ended at its limit, the capacity went with it.
constexpr double kFullestStart = kMostStart_soc - 0.005;

WithInterval Symmetric(double value, double deviation) {
  const double reach = Reach95(kFlightFreedom) * deviation;
  return {value, value - reach, value + reach, {}};
}

WithInterval Logarithmic(double value, double deviation) {
  const double factor = std::exp(Reach95(kFlightFreedom) * deviation);
  return {value, value / factor, value * factor, {}};
}

WithInterval Unknown(std::string because) { return {.unknown_because = std::move(because)}; }

double Deviation(const Eigen::VectorXd& slope, const Eigen::MatrixXd& covariance) {
  return std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
}

// With the scale of the current sensor taken as exactly what was found: what flights of one sensor
// share.
Eigen::MatrixXd GivenScale(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd with = covariance.col(U::kScale);
  return covariance - with * with.transpose() / covariance(U::kScale, U::kScale);
}

const char* UnrestedStart(FlightStart start) {
  return start == FlightStart::kIdle ? "the log rests for less than 3 s before its load"
                                     : "the log starts under load";
}

// A pack that was flown before its log begins is warmer than the air, by 0 to twice this.
constexpr double kGuessedWarmth_K = 15.0;
bool WarmthIsGuessed(const Record& record, const FlightHealth& health) {
  return health.temperature_known && record.temperature_degC.empty() &&
         StartOfFlight(record) == FlightStart::kLoaded;
}

// The deviation of the logarithm of a resistance where the temperature is known to lie within this of what it is taken
// to be, and no more is.
double OfWarmth(const ReferenceCell& reference, double warmth_K, double at_degC) {
  const double at_K = at_degC + kZeroCelsius_K;
  return warmth_K / std::sqrt(3.0) * reference.cell.temperature->series_J_per_mol /
         (kGasConstant_J_per_mol_K * at_K * at_K);
}

void AddCautions(const FlightSamples& samples,
                 const FlightFit& fit,
                 const ReferenceCell& reference,
                 FlightHealth& health) {
  auto& cautions = health.cautions;
  if (fit.start != FlightStart::kRested) {
    cautions.push_back(
        fmt::format("{}: what was left of the load before it is estimated, not known",
                    UnrestedStart(fit.start)));
  }
  if (samples.gap_C > 0.0) {
    cautions.push_back(
        fmt::format("up to {:.2g} % of the capacity may have flowed in gaps between rows",
                    100.0 * samples.gap_C / (reference.cell.alpha_C())));
  }
  if (samples.dropped_rows > 0) {
    cautions.push_back(fmt::format(
        "{} at the end left out: the voltage falls there without a load, as while the plug is "
        "pulled",
        Counted(samples.dropped_rows, "row")));
  }
  for (std::string& said : samples.Said()) cautions.push_back(std::move(said));
  constexpr double kWorthSaying = 0.005;  // of the charge
  if (samples.unresolved.charge_C > kWorthSaying * std::abs(fit.charge_C)) {
    cautions.push_back(fmt::format(
        "the current changes faster than its values come, {:.2g} s apart: between them it is known to {:.2g} A at worst and the "
        "charge to {:.2g} %, which the intervals hold; values that come more often, or that are means, tell more",
        samples.unresolved.between_s,
        samples.unresolved.most_A(),
        100.0 * samples.unresolved.charge_C / std::abs(fit.charge_C)));
  }
  if (fit.nearly_as_likely && health.capacity_Ah.known()) {
    cautions.push_back(fmt::format(
        "a pack of {:.3g} Ah would explain this flight nearly as well: the intervals reach towards it, and a longer "
        "flight tells the two apart",
        reference.cell.alpha_C() * std::exp(*fit.nearly_as_likely) / 3600.0));
  }
  if (!health.temperature_known) {
    cautions.emplace_back(
        "the temperature is not known: the resistance is that of the flight, a cold pack looks old, and "
        "the pack is taken to warm as a typical one does");
  }
  if (WarmthIsGuessed(samples.record, health)) {
    cautions.push_back(fmt::format(
        "the log starts under load, and how warm the pack was then is not known: it is taken to be {:g} K above "
        "the air, and that it may be 0 to {:g} K is in the interval of the resistance; give the log from its "
        "beginning, or one with a temperature",
        kGuessedWarmth_K,
        2.0 * kGuessedWarmth_K));
  }
  const double spread = fit.noise.white_V;
  if (health.doubted_because.empty() &&
      (GradeOf(health.mean_error_percent, kMeanErrorLimits_percent) != FitGrade::kGood ||
       spread > 0.1)) {
    cautions.push_back(fmt::format(
        "the prediction is {:.2g} % off on average: the reference may be of another chemistry, or "
        "`series` wrong",
        health.mean_error_percent));
  }
  const double curve = fit.unknowns.tail(kCurveNodes).cwiseAbs().maxCoeff();
  if (curve > 3.5) {
    cautions.emplace_back(
        "the voltage over the state of charge differs from the reference's by more than such cells "
        "do: the reference may be of another chemistry");
  }
}

// Another cell, or one of another size, can be bent until it fits.
void DoubtTheResistance(FlightHealth& health) {
  const double new_Ohm = health.new_resistance_Ohm;
  if (!health.doubted_because.empty() || !health.resistance_Ohm.known() || !(new_Ohm > 0.0)) return;
  const double of_new = health.resistance_Ohm.value / new_Ohm;
  if (of_new >= kLeastResistanceOfNew && of_new <= kMostResistanceOfNew) return;
  health.doubted_because = fmt::format(
      "the resistance would be {:.0f} % of new, and no cell becomes like this: is the reference another "
      "cell, or the pack of another size (--capacity-Ah, --parallel, --series)? Then the capacity is "
      "not that of the pack either",
      100.0 * of_new);
}

// A flight that is not one of this pack says nothing of it, however narrow the intervals about its fit.
void Withdraw(const char* because, FlightHealth& health) {
  for (WithInterval* quantity : {&health.soc_start,
                                 &health.soc_end,
                                 &health.capacity_Ah,
                                 &health.counted_capacity_Ah,
                                 &health.resistance_Ohm,
                                 &health.counted_resistance_Ohm,
                                 &health.current_scale,
                                 &health.current_offset_A,
                                 &health.lag_s})
    *quantity = Unknown(because);
}

// The voltage before the load is known without a fit. One that the reference cannot have, or with which a pack
// could not have given the charge of the flight, is that of another number of cells.
void DoubtTheRest(const ReferenceCell& reference,
                  const Record& record,
                  int series,
                  double charge_Ah,
                  FlightHealth& health) {
  constexpr double kAboveFull_V =
      0.2;  // packs that are charged to 4.35 V, against a reference of 4.2 V
  constexpr double kLeastSoc = 0.05;  // no flight begins with less
  constexpr double kLowSoc = 0.2;     // from here down the curve is steep, and tells the charge
  constexpr double kLeastShare =
      0.5;  // of the charge that flowed: pack, sensor and curve are roughly known
  const std::optional<double> rest_V = RestVoltage(record);
  if (!rest_V) return;
  const OpenCircuitVoltage& curve = reference.cell.open_circuit_voltage;
  const double soc = curve.SocAtVoltage(*rest_V);
  const double left_Ah = soc * reference.cell.alpha_C() / 3600.0;
  const bool above = *rest_V > curve(1.0) + kAboveFull_V;
  if (!above && soc >= kLeastSoc && (soc >= kLowSoc || left_Ah >= kLeastShare * charge_Ah)) return;
  const int cells = CellsInSeries(series * *rest_V);
  health.doubted_because = fmt::format(
      "the pack rests at {:.3g} V a cell before the flight, where the reference {}: {}",
      *rest_V,
      above ? fmt::format("has {:.3g} V when full", curve(1.0))
            : fmt::format(
                  "has {:.2g} % of its charge, and then gives {:.3g} Ah", 100.0 * soc, charge_Ah),
      cells == series ? fmt::format("is --series (now {}) or the reference wrong?", series)
                      : fmt::format("is --series (now {}) wrong? The voltage looks like that of {}",
                                    series,
                                    Counted(static_cast<std::size_t>(cells), "cell")));
  Withdraw("the voltage before the flight is none of such a pack", health);
}

// After a load a cell recovers: where it rests for a while after the flight it holds what its voltage says and some more.
// A pack that is said to be much too large would hold far more, and a large resistance hides that.
void DoubtTheEnd(const ReferenceCell& reference,
                 const FlightSamples& samples,
                 FlightHealth& health) {
  constexpr double kRest_s = 20.0;
  constexpr double kIdle = 0.03;  // of the largest current
  constexpr double kMean_s = 2.0;
  constexpr double kMore = 0.25;  // of the charge: what a cell still recovers after that rest
  const Record& record = samples.record;
  if (!health.doubted_because.empty() || !health.soc_end.known()) return;
  const double end_s = record.time_s.back();
  double sum_V = 0.0;
  double rows = 0.0;
  for (std::size_t k = record.size(); k-- > 0 && end_s - record.time_s[k] <= kRest_s;) {
    if (std::abs(record.current_A[k]) > kIdle * samples.largest_A) return;
    if (end_s - record.time_s[k] > kMean_s) continue;
    sum_V += record.voltage_V[k];
    rows += 1.0;
  }
  const double rest_V = sum_V / rows;
  const double soc = reference.cell.open_circuit_voltage.SocAtVoltage(rest_V);
  if (health.soc_end.low <= soc + kMore) return;
  health.doubted_because = fmt::format(
      "the pack rests at {:.3g} V a cell after the flight, where the reference has {:.0f} % of its charge, and this fit "
      "leaves {:.0f} %: give the right capacity (--capacity-Ah), unless the reference is another cell",
      rest_V,
      100.0 * std::max(0.0, soc),
      100.0 * health.soc_end.value);
  Withdraw("the voltage after the flight is none of such a pack", health);
}

// A prediction moves as the current makes it, also over a rest and a gap. Where the voltage moves beside it and
// stays there, another charge was plugged in. Rows that are wrong by themselves, and a landing that the voltage shows
// late, are outweighed by the seconds around them. A fall must come at once and under one current: a pack that is
// nearly empty falls faster than predicted, too, and a step of the current shows a resistance that is.
void DoubtThatItIsOneFlight(const FlightSamples& samples,
                            const FlightFit& fit,
                            FlightHealth& health) {
  constexpr double kAround_s = 5.0;
  constexpr std::size_t kFewest = 3;
  constexpr double kLeast_V =
      0.1;  // a cell; the logs of single flights in fixtures/ have 0.014 at most
  constexpr double kAtOnce = 0.7;   // of a fall, from one window to the next but one
  constexpr double kSteady = 0.05;  // of the largest current
  const Eigen::VectorXd off_V = samples.voltage_V - samples.InWindows(fit.voltage_V, fit.lag_s);
  const Eigen::VectorXd current_A = samples.InWindows(
      Eigen::Map<const Eigen::VectorXd>(samples.record.current_A.data(),
                                        static_cast<Eigen::Index>(samples.record.size())),
      fit.lag_s);
  const std::size_t windows = samples.windows.size();
  const double window_s = fit.duration_s / static_cast<double>(windows);
  const std::size_t around = std::max(kFewest, static_cast<std::size_t>(kAround_s / window_s));
  const auto level = [&](const Eigen::VectorXd& of, std::size_t first) {
    const double* from = of.data() + first;
    return Median(std::vector<double>(from, from + around));
  };
  double most_V = 0.0;
  std::size_t at = 0;
  bool rises = false;
  for (std::size_t w = around; w + around <= windows; ++w) {
    const double moved_V = level(off_V, w) - level(off_V, w - around);
    if (std::abs(moved_V) <= most_V) continue;
    if (moved_V < 0.0) {
      const auto k = static_cast<Eigen::Index>(w);
      const double at_once_V = off_V[k] - off_V[k - 2];
      const double steady_A = kSteady * samples.largest_A;
      if (at_once_V > kAtOnce * moved_V ||
          std::abs(level(current_A, w) - level(current_A, w - around)) > steady_A ||
          std::abs(current_A[k] - current_A[k - 2]) > steady_A)
        continue;
    }
    most_V = std::abs(moved_V);
    at = w;
    rises = moved_V > 0.0;
  }
  if (!health.doubted_because.empty() || most_V < kLeast_V) return;
  health.doubted_because = fmt::format(
      "the voltage {} by {:.2g} V a cell near {:.5g} s, which no current of this log explains: {}, or another flight or "
      "pack, begins there; give the rows before and those after as two files",
      rises ? "rises" : "falls at once",
      most_V,
      samples.time_s[at],
      rises ? "a recharge" : "a contact or a cell that fails");
  Withdraw("the log holds more than one flight", health);
}

void DoubtTheCurrent(const FlightSamples& samples, FlightHealth& health) {
  if (!health.doubted_because.empty() || samples.doubt.empty()) return;
  health.doubted_because = samples.doubt;
  Withdraw("the current that flowed is not known", health);
}

void DoubtTheFit(FlightHealth& health) {
  if (!health.doubted_because.empty() ||
      GradeOf(health.mean_error_percent, kMeanErrorLimits_percent) != FitGrade::kPoor)
    return;
  health.doubted_because = fmt::format(
      "the reference does not describe this flight (mean error {:.2g} %; beyond {:g} % a fit says "
      "nothing): is --series, --columns or the reference wrong?",
      health.mean_error_percent,
      kMeanErrorLimits_percent.fair);
  Withdraw("the reference does not describe this flight", health);
}

// A sensor that is far from what any is stands for something else that is wrong.
void DoubtTheSensor(const SensorSpread& sensors, double largest_A, FlightHealth& health) {
  constexpr double kFarthest = 4.0;  // standard deviations of what was believed
  if (!health.doubted_because.empty() || !health.capacity_Ah.known()) return;
  const double scale = health.current_scale.value;
  const double offset_A = health.current_offset_A.value;
  const bool scale_is_off = std::abs(scale - 1.0) > kFarthest * sensors.current_scale;
  const bool offset_is_off = std::abs(offset_A) > kFarthest * sensors.OffsetOf(largest_A);
  if (!scale_is_off && !offset_is_off) return;
  const std::string would =
      scale_is_off
          ? fmt::format("{:.2g} times what flows, and such sensors are right to {:.2g} %",
                        1.0 / scale,
                        100.0 * sensors.current_scale)
          : fmt::format("{:.2g} A where none flows, and such sensors are right to {:.2g} A",
                        offset_A,
                        sensors.OffsetOf(largest_A));
  health.doubted_because = fmt::format(
      "the current sensor would have to show {}: {}is the pack charged to another voltage than the reference, or "
      "are the current, its unit or the reference wrong?",
      would,
      health.temperature_known
          ? ""
          : "the temperature is not known, and the pack may warm otherwise than was assumed (--ambient-degC); or ");
  Withdraw("the current sensor would be impossible", health);
}

// Packs lose capacity. Where the whole interval lies beyond what a new one may have above its label, the label
// is another pack's.
void DoubtTheCapacity(double new_Ah, FlightHealth& health) {
  constexpr double kMostOfNew = 1.2;
  if (!health.doubted_because.empty() || !health.capacity_Ah.known() ||
      !(health.capacity_Ah.low > kMostOfNew * new_Ah))
    return;
  health.doubted_because = fmt::format(
      "the capacity would be {:.0f} % of new, 95 % from {:.0f} % on, and no pack grows: does the new one hold "
      "more than {:.3g} Ah (--capacity-Ah, --parallel), or is the unit of the current wrong?",
      100.0 * health.capacity_Ah.value / new_Ah,
      100.0 * health.capacity_Ah.low / new_Ah,
      new_Ah);
}

// A fit lines up the kinks of the reference's curve with those of the pack, and believes the state of charge there.
// Kinks of a typical curve are not the pack's: how far they may move a state of charge, as a standard deviation.
double KinksInSoc(const ReferenceCell& reference, double soc) {
  constexpr double kLeastSlope_V = 0.2;  // that of the flattest tenth of a lithium-polymer cell
  const OpenCircuitVoltage& curve = reference.cell.open_circuit_voltage;
  const double low = std::clamp(soc - kKinksLength, 0.0, 1.0 - 2.0 * kKinksLength);
  const double high = low + 2.0 * kKinksLength;
  const double slope_V = (curve(high) - curve(low)) / (high - low);
  return reference.spread.kinks_V / std::max(slope_V, kLeastSlope_V);
}

// What flowed in a gap is not known: cautions say so of less, beside intervals of some per cent.
constexpr double kMostInGaps = 0.02;

// The capacity of the new pack is NaN where nobody says it.
FlightHealth AssessFlight(const ReferenceCell& reference,
                          double new_capacity_Ah,
                          const Log& log,
                          const HealthOptions& options) {
  Log one = log;
  DivideByPack(one.record, options.series, 1);
  CheckPlausible(one.record, reference.cell.alpha_C() / 3600.0, options.series);
  const bool at_one_temperature = one.report.format == kSimulatedFlight.name &&
                                  one.record.temperature_degC.empty() && !options.ambient_degC;
  if (at_one_temperature) {
    one.record.temperature_degC =
        Column(one.record.size(), CelsiusOf(reference.cell.temperature->reference_K));
  }
  FlightSamples samples = SampleFlight(one);
  const Record& record = samples.record;

  FlightHealth health;
  health.file = record.file;
  health.temperature_known = !record.temperature_degC.empty() || options.ambient_degC.has_value();
  // A pack of which nothing is known begins at the reference temperature and warms from there.
  Surroundings among{.measured_degC = record.temperature_degC,
                     .ambient_degC = options.ambient_degC,
                     .initial_degC = {}};
  double of_warmth = 0.0;  // in the logarithm of the resistance
  if (WarmthIsGuessed(record, health)) {
    among.initial_degC = *among.ambient_degC + kGuessedWarmth_K;
    of_warmth = OfWarmth(reference, kGuessedWarmth_K, *among.initial_degC);
  }
  const FittedFlight fitted = FitAsFlowed(reference, samples, among, options.sensors);
  const FlightModel& model = *fitted.model;
  const FlightFit& fit = fitted.fit;

  health.converged = fit.converged;
  const Eigen::VectorXd& x = fit.unknowns;
  const Eigen::MatrixXd& covariance = fit.covariance;
  const Eigen::MatrixXd given = GivenScale(covariance);
  const double alpha_C = reference.cell.alpha_C() * std::exp(x[U::kCapacity]);
  const double true_C =
      (1.0 + x[U::kScale]) * (fit.charge_C + fit.uncounted_C - x[U::kOffset_A] * fit.duration_s);
  health.duration_s = fit.duration_s;
  health.charge_Ah = fit.charge_C / 3600.0;
  health.soc_start = WithinPack(Symmetric(x[U::kStart],
                                          std::hypot(std::sqrt(covariance(U::kStart, U::kStart)),
                                                     KinksInSoc(reference, x[U::kStart]))));
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(x.size());
  slope[U::kStart] = 1.0;
  slope[U::kCapacity] = true_C / alpha_C;
  slope[U::kScale] = -true_C / (1.0 + x[U::kScale]) / alpha_C;
  slope[U::kOffset_A] = (1.0 + x[U::kScale]) * fit.duration_s / alpha_C;
  const double soc_end = x[U::kStart] - true_C / alpha_C;
  const double of_uncounted = -(1.0 + x[U::kScale]) / alpha_C;
  const double of_end = std::sqrt(
      std::max(0.0,
               slope.dot(covariance * slope) + 2.0 * of_uncounted * slope.dot(fit.uncounted_with) +
                   of_uncounted * of_uncounted * fit.uncounted_variance_C2));
  health.soc_end =
      WithinPack(Symmetric(soc_end, std::hypot(of_end, KinksInSoc(reference, soc_end))));

  const double scale = 1.0 + x[U::kScale];
  slope.setZero();
  slope[U::kCapacity] = 1.0;
  const double of_capacity = Deviation(slope, covariance);
  health.log_capacity = x[U::kCapacity];
  health.log_capacity_deviation = Deviation(slope, given);
  const double span = 100.0 * std::abs(true_C / alpha_C);
  const bool is_far = std::abs(x[U::kCapacity]) > kFarFromReference * reference.spread.log_capacity;
  if (health.log_capacity_deviation > kUselessCapacity) {
    const std::string because = fmt::format(
        "the flight takes about {:.0f} % of the charge, over which the voltage does not tell how much "
        "that is of the whole",
        span);
    health.capacity_Ah = health.counted_capacity_Ah = Unknown(because);
  } else if (AtLimit(x[U::kCapacity]) || (is_far && fit.start != FlightStart::kRested)) {
    // How full the pack was went with the capacity.
    const bool told = std::isfinite(new_capacity_Ah);
    const std::string because = fmt::format(
        "this flight does not tell it: the search ended {}{}; the flight takes too little of the "
        "charge, {}, {}. Give a flight that begins at rest and takes half of the charge",
        AtLimit(x[U::kCapacity]) ? "at its limit" : "far from any such pack",
        told ? fmt::format(", {:.2g} times the {:.3g} Ah of the new pack",
                           std::exp(x[U::kCapacity]),
                           new_capacity_Ah)
             : "",
        fit.start == FlightStart::kRested
            ? std::string("at a voltage that the reference does not have there")
            : fmt::format("{}, so that its start is not known", UnrestedStart(fit.start)),
        told ? "or --capacity-Ah is of another pack"
             : "and nobody says how large the pack is (--capacity-Ah)");
    health.capacity_Ah = health.counted_capacity_Ah = Unknown(because);
    health.soc_start = health.soc_end = Unknown(
        "the search for the capacity ended where no such pack is, and the state of charge with it");
  } else if (x[U::kStart] > kFullestStart) {
    const std::string because = fmt::format(
        "the search for the state of charge at the start ended at its limit, {:.0f} % of the reference's "
        "full: the pack is charged higher than the reference was, or its temperature, its current or "
        "the reference is wrong",
        100.0 * x[U::kStart]);
    health.capacity_Ah = health.counted_capacity_Ah = Unknown(because);
    health.soc_start = health.soc_end = Unknown(because);
  } else if (is_far || fit.against_belief) {
    // What was believed of the capacity and what the flight says exclude one another.
    const std::string because = fmt::format(
        "the flight fits a pack of {:.2g} times the capacity of the new one, which is {:.3g} Ah; give "
        "the right capacity (--capacity-Ah), unless the current is wrong, or its unit{}",
        std::exp(fit.against_belief.value_or(x[U::kCapacity])),
        reference.cell.alpha_C() / 3600.0,
        health.temperature_known ? ", or the temperature is not that of the pack" : "");
    health.capacity_Ah = health.counted_capacity_Ah = Unknown(because);
    if (fit.against_belief) health.soc_start = health.soc_end = Unknown(because);
  } else {
    // The kinks move each end, and with them the charge that was taken between. They are the same ones for all flights
    // of a pack, so that a trend does not count them.
    const double of_kinks =
        std::hypot(KinksInSoc(reference, x[U::kStart]), KinksInSoc(reference, soc_end)) * alpha_C /
        std::abs(true_C);
    health.capacity_Ah = Logarithmic(alpha_C / 3600.0, std::hypot(of_capacity, of_kinks));
    health.counted_capacity_Ah =
        Logarithmic(alpha_C / scale / 3600.0, std::hypot(health.log_capacity_deviation, of_kinks));
  }

  const double step_A = 0.5 * samples.largest_A;
  const double middle = std::clamp(0.5 * (x[U::kStart] + soc_end), 0.2, 0.9);
  const auto resistance_of = [&](const Eigen::VectorXd& unknowns) {
    return model.StepResistance(unknowns, middle, std::max(step_A, 1e-3), samples.settle_s());
  };
  const ResistanceAt resistance = resistance_of(x);
  health.reference_resistance_Ohm =
      options.series * resistance_of(Eigen::VectorXd::Zero(model.size())).resistance_Ohm;
  health.new_resistance_Ohm = reference.typical ? kNaN : health.reference_resistance_Ohm;
  // Where a current was measured at another instant than the voltage, a slope of one over the other
  // is too small. The slope the other way round is too large, by the square of the coherence between
  // them: the truth is in between.
  double sampling = 0.25 * (1.0 - samples.coherence * samples.coherence);
  // Of a current that changes between its values nobody knows how long that of a row had flowed before it, and with
  // it how much of the drop takes time.
  if (samples.unresolved.any()) {
    sampling = std::hypot(
        sampling,
        0.5 * model.GrowthOfDrop(x, middle, std::max(step_A, 1e-3), samples.unresolved.between_s));
  }
  const double unshown_K =
      at_one_temperature
          ? 0.0
          : UnshownWarming_K(reference.cell, record, std::clamp(x[U::kStart], 0.0, 1.0));
  if (unshown_K > 0.0) {
    health.cautions.push_back(fmt::format(
        "the temperature of the log hardly moves, where such a pack would warm by {:.2g} K: it is that of the air, or of a "
        "thermometer that is stuck, unless the pack is held at one temperature. That the pack may be as much warmer is in the "
        "interval of the resistance; take the column out and give --ambient-degC",
        unshown_K));
    of_warmth = OfWarmth(reference, unshown_K, record.temperature_degC.front());
  }
  const double of_resistance =
      std::hypot(Deviation(resistance.slope, covariance), sampling, of_warmth);
  health.log_resistance_deviation =
      std::hypot(Deviation(resistance.slope, given), sampling, of_warmth);
  if (health.log_resistance_deviation > kUselessResistance) {
    health.resistance_Ohm = health.counted_resistance_Ohm = Unknown(
        "the loads of the flight change too little, or voltage and current are too far apart");
  } else {
    const double pack_Ohm = options.series * resistance.resistance_Ohm;
    health.resistance_Ohm = Logarithmic(pack_Ohm, of_resistance);
    health.counted_resistance_Ohm = Logarithmic(pack_Ohm * scale, health.log_resistance_deviation);
  }
  health.current_scale = Symmetric(scale, std::sqrt(covariance(U::kScale, U::kScale)));
  health.current_offset_A =
      Symmetric(x[U::kOffset_A], std::sqrt(covariance(U::kOffset_A, U::kOffset_A)));
  health.lag_s = Symmetric(fit.lag_s, fit.lag_deviation_s);
  health.window_s = samples.window_s;
  health.coherence = samples.coherence;
  health.mean_error_percent = fit.mean_error_percent;
  health.max_error_percent = fit.max_error_percent;
  DoubtTheRest(reference, record, options.series, health.charge_Ah, health);
  DoubtThatItIsOneFlight(samples, fit, health);
  DoubtTheEnd(reference, samples, health);
  if (auto doubt = DoubtAboutHotStart(record); health.doubted_because.empty() && !doubt.empty()) {
    health.doubted_because = std::move(doubt);
    Withdraw("the temperature of the first row is none of a pack before a flight", health);
  }
  DoubtTheCurrent(samples, health);
  DoubtTheFit(health);
  DoubtTheSensor(options.sensors, samples.largest_A, health);
  DoubtTheResistance(health);
  DoubtTheCapacity(new_capacity_Ah, health);
  AddCautions(samples, fit, reference, health);
  if (at_one_temperature) {
    health.cautions.emplace_back(
        "the log is of a flight that lipoid simulated without a temperature: the pack is taken to have been at the "
        "reference temperature all the time");
  }
  if (log.report.flight) {
    for (std::string& doubt :
         DoubtsAboutPack(*log.report.flight, options.series, options.capacity_Ah.value_or(0.0)))
      health.cautions.push_back(std::move(doubt));
  }
  return health;
}

// What the autopilots were told of the pack; 0: none was told. OptionError where they were told different
// things, or only some of them: these are flights on several packs, and one has no number for the others.
template <class Value>
Value Told(const std::vector<Log>& logs,
           const char* option,
           const char* what,
           Value FlightFacts::*fact) {
  const auto of = [&](const Log& log) {
    const Value value = log.report.flight ? (*log.report.flight).*fact : Value{};
    return value > Value{} ? value : Value{};  // NaN, too, is none
  };
  for (const Log& log : logs) {
    const Value value = of(log);
    if (value == of(logs[0])) continue;
    const auto said = [&](Value told) {
      return told > Value{} ? fmt::format("{:.4g} {}", static_cast<double>(told), what)
                            : std::string("nothing of it");
    };
    throw OptionError(fmt::format(
        "option {}: expected flights of one pack, found {} that says {}, and {} that says {}; give {}, "
        "or each pack a run of its own",
        option,
        logs[0].record.file,
        said(of(logs[0])),
        log.record.file,
        said(value),
        option));
  }
  return logs.empty() ? Value{} : of(logs[0]);
}

// The most charge that any of the logs moved, as it shows it.
double LargestCharge_Ah(const std::vector<Log>& logs) {
  double largest_C = 0.0;
  for (const Log& log : logs) {
    if (log.record.size() > 0) largest_C = std::max(largest_C, DeliveredCharge(log.record).back());
  }
  return std::max(largest_C / 3600.0, 1e-3);
}

}  // namespace

int SeriesOfPack(const std::vector<Log>& logs, std::optional<int> given) {
  if (given) return *given;
  const int found = Told(logs, "--series", "cells in series", &FlightFacts::cells);
  if (found == 0) {
    throw OptionError(fmt::format(
        "option --series: expected how many cells the pack has in series, which these logs do not "
        "say; give {}",
        logs.empty()
            ? "--series 4, say"
            : fmt::format("--series {}, which the voltage of {} looks like, or what the pack has",
                          CellsInSeriesInWords(FindExtent(logs[0].record.voltage_V).most),
                          logs[0].record.file)));
  }
  return found;
}

std::optional<HealthTrend> TrendOf(std::span<const FlightHealth> flights,
                                   WithInterval FlightHealth::*counted,
                                   double FlightHealth::*deviation,
                                   double FlightHealth::*reference) {
  std::vector<TrendPoint> points;
  double last = 1.0;
  for (const FlightHealth& flight : flights) {
    const WithInterval& quantity = flight.*counted;
    if (!quantity.known() || !flight.converged || !flight.same_rows_as.empty()) continue;
    if (reference != nullptr) last = flight.*reference;
    const double of = reference != nullptr ? last : 1.0;
    points.push_back({static_cast<double>(flight.place), quantity.value / of, flight.*deviation});
  }
  for (TrendPoint& point : points) point.value *= last;
  return FitTrend(points);
}

HealthReport AssessHealth(const Cell& cell, std::vector<Log> logs, const HealthOptions& options) {
  // A typical curve says nothing of how large this pack is: what the autopilot was told does, and
  // without that only the flights themselves.
  std::optional<double> capacity_Ah = options.capacity_Ah;
  HealthReport report;
  report.typical = cell.open_circuit_voltage_assumed;
  if (report.typical && !capacity_Ah) {
    const double told_Ah = Told(logs, "--capacity-Ah", "Ah", &FlightFacts::capacity_Ah);
    report.capacity_told = told_Ah > 0.0;
    if (report.capacity_told) capacity_Ah = told_Ah;
  }
  const bool guessed = report.typical && !capacity_Ah;
  if (guessed) capacity_Ah = kGuessedOverFlown * LargestCharge_Ah(logs);
  ReferenceCell reference = MakeReference(cell, options.parallel, capacity_Ah);
  if (guessed) reference.spread.log_capacity = kGuessedLogCapacity;
  report.reference = cell.name;
  report.new_capacity_Ah = guessed ? kNaN : reference.cell.alpha_C() / 3600.0;
  report.activation_energy_J_per_mol = reference.cell.temperature->series_J_per_mol;
  report.reference_degC = CelsiusOf(reference.cell.temperature->reference_K);
  report.temperature_assumed = reference.cell.temperature_assumed;
  // A guess by the charge of the flights cannot say that they hardly took any.
  const double busy_Ah =
      (guessed ? options.parallel * cell.alpha_C() : reference.cell.alpha_C()) / 3600.0;
  std::vector<FlightHealth> flights(logs.size());
  std::vector<std::vector<Diagnostic>> problems(logs.size());
  ParallelFor(logs.size(), [&](std::size_t k) {
    problems[k] = DiagnosticsOf([&] {
      RefuseIdleFlight(logs[k].record, busy_Ah);
      RefuseUnknownCharge(logs[k].record, logs[k].report.gaps, busy_Ah, kMostInGaps);
      flights[k] = AssessFlight(reference, report.new_capacity_Ah, logs[k], options);
    });
  });
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!problems[k].empty()) continue;
    const auto same = std::find_if(
        logs.begin(), logs.begin() + static_cast<std::ptrdiff_t>(k), [&](const Log& log) {
          return HoldTheSameRows(log.record, logs[k].record);
        });
    if (same == logs.begin() + static_cast<std::ptrdiff_t>(k)) continue;
    flights[k].same_rows_as = same->record.file;
    flights[k].cautions.push_back(fmt::format(
        "holds the same rows as {}, so that the trend leaves it out: leave one of the two out, or look "
        "whether one was copied by mistake",
        same->record.file));
  }
  for (std::size_t k = 0; k < logs.size(); ++k) {
    report.refused.insert(report.refused.end(), problems[k].begin(), problems[k].end());
    if (!problems[k].empty()) continue;
    flights[k].place = k;
    report.flights.push_back(std::move(flights[k]));
  }
  if (report.flights.empty()) throw LoadError(report.refused);
  report.capacity_trend = TrendOf(
      report.flights, &FlightHealth::counted_capacity_Ah, &FlightHealth::log_capacity_deviation);
  report.resistance_trend = TrendOf(report.flights,
                                    &FlightHealth::counted_resistance_Ohm,
                                    &FlightHealth::log_resistance_deviation,
                                    &FlightHealth::reference_resistance_Ohm);
  return report;
}

}  // namespace lipoid
