#include "identify/logs/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "identify/logs/formats/quantity.h"
#include "model/battery/arrhenius.h"
#include "model/battery/ranges.h"

namespace lipoid {
namespace {

// As kMostPack_V.
constexpr double kMostPack_A = 1e5;
// The largest cells and packs are charged and discharged at some hundred amperes.
constexpr double kUsualPack_A = 1e3;
constexpr double kLongest_s = 20 * 365.25 * 86400.0;

constexpr double kLeastCell_V = 0.02;
// On average, of a pack that was divided by its cells: half of what any lithium cell has.
constexpr double kLeastOfPack_V = 1.2;
// A button cell of 1 mAh that is emptied in 100 hours.
constexpr double kLeastCell_A = 1e-5;
// Charge between the fullest and the emptiest moment of a log, in capacities; and C-rate.
constexpr double kMostCapacities = 5.0;
constexpr double kMostRate_per_h = 500.0;

// A cell's voltage is positive and stays within this factor; its current does not. Read under the
// wrong names, the "current" looks like a voltage and the "voltage" does not.
constexpr double kMostVoltageRatio = 2.5;
constexpr double kLeastVoltage_V = 1.5;
constexpr double kLeastVoltageSpread = 0.03;

// Whether one falls where the other rises, from row to row, as the voltage of a battery does with its current.
bool MoveAgainstEachOther(const Record& record) {
  constexpr double kLeastCoherence = 0.5;
  double vv = 0.0, vi = 0.0, ii = 0.0;
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double dv = record.voltage_V[k] - record.voltage_V[k - 1];
    const double di = record.current_A[k] - record.current_A[k - 1];
    vv += dv * dv;
    vi += dv * di;
    ii += di * di;
  }
  return -vi > kLeastCoherence * std::sqrt(vv * ii);
}

bool LooksExchanged(const Record& record, const Extent& current, const Extent& voltage) {
  if (record.size() < 3 || record.voltage_V.empty()) return false;
  const bool current_is_a_voltage =
      current.least > kLeastVoltage_V && current.most < kMostVoltageRatio * current.least &&
      current.most - current.least > kLeastVoltageSpread * current.most;
  if (!current_is_a_voltage) return false;
  return voltage.least <= 0.02 * voltage.most ||
         (voltage.most - voltage.least < 0.01 * voltage.most && !MoveAgainstEachOther(record));
}

double EmptyVoltage(const OpenCircuitVoltage& curve) {
  return curve(std::max(0.0, curve.soc_lo()));
}

// What makes a voltage or a current larger than one cell's, where so many cells were said.
std::string LargerPack(std::string_view option, int cells) {
  return cells == 1 ? fmt::format("is it a pack (say `{}`)", option)
                    : fmt::format("is `{}` more than {}", option, cells);
}

// Steps of the current, and at how many of them each of the two columns seems to be read one row late.
struct LateRows {
  static constexpr std::size_t kFewest = 5;
  std::size_t steps = 0;
  std::size_t voltage = 0;
  std::size_t current = 0;

  [[nodiscard]] bool AreMost(std::size_t late) const {
    return steps >= kFewest && 10 * late >= 9 * steps;
  }
};

LateRows CountLateRows(const Record& record) {
  constexpr std::size_t kEnough = 100;
  constexpr double kStep = 0.2;   // of the range of the current
  constexpr double kHeld = 0.02;  // as far as it may move in the rows beside the step
  constexpr double kLate = 0.1;   // of what the next row shows, in the row of the step
  // Of what the row before shows, in the row of the step and the next: a cell relaxes on.
  constexpr double kEarly = 0.5;
  constexpr double kLeast_V = 5e-3;
  LateRows late;
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  if (v.size() < 2 * LateRows::kFewest) return late;
  const Extent extent = FindExtent(i);
  const double range_A = extent.most - extent.least;
  for (std::size_t k = 2; k + 1 < v.size() && late.steps < kEnough; ++k) {
    if (!(std::abs(i[k] - i[k - 1]) > kStep * range_A)) continue;
    if (std::abs(i[k + 1] - i[k]) > kHeld * range_A ||
        std::abs(i[k - 1] - i[k - 2]) > kHeld * range_A)
      continue;
    const double at_once_V = std::abs(v[k] - v[k - 1]);
    const double after_V = std::abs(v[k + 1] - v[k]);
    const double before_V = std::abs(v[k - 1] - v[k - 2]);
    if (std::max({at_once_V, after_V, before_V}) < kLeast_V) continue;
    ++late.steps;
    if (at_once_V < kLate * after_V) ++late.voltage;
    if (std::max(at_once_V, after_V) < kEarly * before_V) ++late.current;
  }
  return late;
}

// Of a high-voltage cell when full, with the error of a sensor.
constexpr double kHighestCell_V = 4.38;

}  // namespace

int CellsInSeries(double highest_V) {
  constexpr double kFullCell_V = 4.2;
  constexpr double kOneCell_V = 5.0;
  if (!(highest_V > kOneCell_V) || highest_V > kMostPack_V) return 1;
  const double least = std::ceil(highest_V / kHighestCell_V);
  return static_cast<int>(std::max(least, std::round(highest_V / kFullCell_V)));
}

std::string CellsInSeriesInWords(double highest_V) {
  constexpr double kLeastFull_V = 4.1;
  constexpr double kMostFull_V = 4.25;
  constexpr double kLeastFlown_V = 3.6;  // fewer begin a test or a flight below it
  const int cells = CellsInSeries(highest_V);
  if (cells == 1) return "1";
  const double of_one_V = highest_V / cells;
  if (of_one_V >= kLeastFull_V && of_one_V <= kMostFull_V) return fmt::format("{}", cells);
  if (highest_V / (cells - 1) <= kHighestCell_V) return fmt::format("{} or {}", cells - 1, cells);
  if (highest_V / (cells + 1) >= kLeastFlown_V) return fmt::format("{} or {}", cells, cells + 1);
  return fmt::format("{}", cells);
}

std::string DoubtAboutTime(const Record& record) {
  constexpr std::size_t kFewest = 20;
  constexpr double kRounding = 2e-3;  // of a step: four digits behind the point
  if (record.size() < kFewest) return "";
  for (const auto& [per_unit, unit] : {std::pair(60.0, "min"), std::pair(3600.0, "h")}) {
    std::size_t whole = 0;
    std::size_t decimal = 0;
    for (std::size_t k = 1; k < kFewest; ++k) {
      const double step = record.time_s[k] - record.time_s[k - 1];
      const double steps = step * per_unit;
      if (steps > 0.5 && std::abs(steps - std::round(steps)) < kRounding * steps) ++whole;
      const double thousandths = 1e3 * step;
      if (std::abs(thousandths - std::round(thousandths)) < 0.25 * kRounding * thousandths)
        ++decimal;
    }
    if (whole == kFewest - 1 && decimal < kFewest / 2) {
      return fmt::format(
          "rows are 1/{:.0f} s apart, as whole seconds are on a clock in {}; if the times are in "
          "{}, say `units` (--units {},A,V)",
          per_unit / std::max(1.0, std::round((record.time_s[1] - record.time_s[0]) * per_unit)),
          unit,
          unit,
          unit);
    }
  }
  return "";
}

std::string DoubtAboutHotStart(const Record& record) {
  constexpr double kMost_degC = 60.0;
  if (record.temperature_degC.empty() || !(record.temperature_degC.front() > kMost_degC)) return "";
  const double first_degC = record.temperature_degC.front();
  return fmt::format(
      "the cell is at {:.4g} degC in the first row: {}", first_degC, InFahrenheit(first_degC));
}

std::string InFahrenheit(double shown_degC) {
  return fmt::format("if these are degrees Fahrenheit ({:.4g} degC), say degF in the header",
                     FindUnit(Quantity::kTemperature, "degF")->ToSi(shown_degC));
}

std::string DoubtAboutLag(const Record& record) {
  const LateRows late = CountLateRows(record);
  if (late.current > late.voltage && late.AreMost(late.current)) {
    return fmt::format(
        "at {} of {} steps of the current the voltage has moved one row before: if the logger reads the current a row "
        "late, shift one of the two columns by a row; as it stands, rows without a current show the voltage under load",
        late.current,
        late.steps);
  }
  if (!late.AreMost(late.voltage)) return "";
  return fmt::format(
      "at {} of {} steps of the current the voltage moves one row later: if the logger reads it a row late, shift one "
      "of the two columns by a row; as it stands, resistances within one row come out too small",
      late.voltage,
      late.steps);
}

bool ReadsCurrentLate(const Record& record) {
  const LateRows late = CountLateRows(record);
  return late.current > late.voltage && late.AreMost(late.current);
}

std::string CheckReadable(const Record& record, const ColumnPositions& positions) {
  const Extent current = FindExtent(record.current_A);
  const Extent voltage = FindExtent(record.voltage_V);
  if (!positions.known && LooksExchanged(record, current, voltage)) {
    throw LoadError(
        positions.voltage,
        "expected a voltage, found what looks like a current, and a voltage in the column of the "
        "current; if the two are exchanged, say which is which: columns = {current_A = \"...\", "
        "voltage_V = \"...\"} (--columns)");
  }
  if (const double most_V = voltage.Magnitude(); most_V > kMostPack_V) {
    throw LoadError(
        positions.voltage,
        fmt::format(
            "expected a voltage in V, found {:.6g} V; are these mV? {}", most_V, positions.remedy));
  }
  if (!record.voltage_V.empty() && voltage.Magnitude() > kLeastCell_V &&
      Sum(record.voltage_V) < 0.0) {
    throw LoadError(
        positions.voltage,
        fmt::format(
            "expected a voltage above 0 V, found {:.4g} to {:.4g} V: are its leads exchanged? Turn the sign "
            "of the column round",
            voltage.least,
            voltage.most));
  }
  // None at all is a log of the current alone.
  if (const double most_V = voltage.Magnitude(); most_V > 0.0 && most_V < kLeastCell_V) {
    throw LoadError(
        positions.voltage,
        fmt::format("expected a voltage of at least {:g} V, found {:.3g} V at most; {}are these V "
                    "under a header that says mV? {}",
                    kLeastCell_V,
                    most_V,
                    positions.voltage_in_thousands
                        ? "if the mark before the last three digits is one for thousands, export "
                          "all numbers without such marks; or "
                        : "",
                    positions.remedy));
  }
  if (const double most_A = current.Magnitude(); most_A > kMostPack_A) {
    throw LoadError(
        positions.current,
        fmt::format(
            "expected a current in A, found {:.6g} A; are these mA? {}", most_A, positions.remedy));
  }
  if (const double length_s =
          record.size() < 2 ? 0.0 : record.time_s.back() - record.time_s.front();
      length_s > kLongest_s) {
    throw LoadError(
        positions.time,
        fmt::format("expected times in s, found a log of {:.3g} years; are these ms? {}",
                    length_s / (365.25 * 86400.0),
                    positions.remedy));
  }
  if (!(current.Magnitude() > kUsualPack_A)) return "";
  return fmt::format(
      "the current goes up to {:.4g} A, more than nearly any cell or pack carries; is it in mA? {}",
      current.Magnitude(),
      positions.remedy);
}

ChargeMoved CheckPlausible(const Record& record, double capacity_Ah, int series, int parallel) {
  if (record.voltage_V.empty()) return capacity_Ah > 0.0 ? CountCharge(record) : ChargeMoved();
  const Extent voltage = FindExtent(record.voltage_V);
  if (voltage.most > kMostCell_V) {
    const double mean_V = Sum(record.voltage_V) / static_cast<double>(record.size());
    if (mean_V > kMostCell_V) {
      throw LoadError(
          {record.file},
          fmt::format(
              "expected the voltage of one cell, found {:.4g} V on average; are these mV, or {}?",
              mean_V,
              LargerPack("series", series)));
    }
    const auto highest = std::max_element(record.voltage_V.begin(), record.voltage_V.end());
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the voltage of one cell, found {:.4g} V at {:.10g} s; remove the rows "
            "that were read wrongly, or read a part without them (start_s, end_s)",
            *highest,
            record.time_s[static_cast<std::size_t>(highest - record.voltage_V.begin())]));
  }
  if (const double most_V = voltage.Magnitude(); most_V < kLeastCell_V) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the voltage of one cell, found {:.3g} V at most; are these V under a header "
            "that says mV, or is `series` too large?",
            most_V));
  }
  if (series > 1) {
    const double mean_V = Sum(record.voltage_V) / static_cast<double>(record.size());
    if (mean_V < kLeastOfPack_V) {
      throw LoadError(
          {record.file},
          fmt::format("expected the voltage of one lithium cell of {} in series, found "
                      "{:.3g} V on average; is `series` less than {}, or is this log one "
                      "of a single cell?",
                      series,
                      mean_V,
                      series));
    }
  }
  const double most_A = LargestMagnitude(record.current_A);
  if (most_A > 0.0 && most_A < kLeastCell_A) {
    throw LoadError(
        {record.file},
        fmt::format("expected the current of one cell, found {:.3g} A at most; are these A under a "
                    "header that says mA, or is `parallel` too large?",
                    most_A));
  }
  if (!(capacity_Ah > 0.0)) return {};
  if (most_A > kMostRate_per_h * capacity_Ah) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the current of one cell of {:.4g} Ah, found {:.4g} A; are these mA, {}, or is "
            "the capacity wrong?",
            capacity_Ah,
            most_A,
            LargerPack("parallel", parallel)));
  }
  const ChargeMoved moved = CountCharge(record);
  if (const double range_Ah = moved.range_C() / 3600.0; range_Ah > kMostCapacities * capacity_Ah) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected charges of one cell of {:.4g} Ah, found {:.4g} Ah going one way; are the "
            "units of time and current right, {}, or has the current no sign?",
            capacity_Ah,
            range_Ah,
            LargerPack("parallel", parallel)));
  }
  return moved;
}

std::string ImpossibleTemperature(std::span<const double> time_s,
                                  std::span<const double> temperature_degC) {
  const auto wrong = std::find_if(temperature_degC.begin(),
                                  temperature_degC.end(),
                                  [](double degC) { return !kTemperatures_degC.Contains(degC); });
  if (wrong == temperature_degC.end()) return "";
  const bool kelvin =
      std::all_of(temperature_degC.begin(), temperature_degC.end(), [](double degC) {
        return kTemperatures_degC.Contains(degC - kZeroCelsius_K);
      });
  return fmt::format("{:.6g} degC at {:.10g} s is not within {:g} to {:g}{}",
                     *wrong,
                     time_s[static_cast<std::size_t>(wrong - temperature_degC.begin())],
                     kTemperatures_degC.lo,
                     kTemperatures_degC.hi,
                     kelvin ? ", but the whole column would be in kelvin" : "");
}

void RefuseWithoutVoltage(const Record& record) {
  if (record.voltage_V.empty())
    throw LoadError({record.file}, "expected a log with voltages, found none");
}

std::string DoubtAboutCutoff(double cutoff_V) {
  if (!(cutoff_V > kHighestCutoff_V)) return "";
  return fmt::format(
      "no lithium cell is empty at {:.4g} V: the charge below this cut-off is missing in alpha; give the "
      "cut-off of the cell as cutoff_V (--cutoff-V)",
      cutoff_V);
}

int LoggedSeries(const Record& record, const OpenCircuitVoltage& curve, int series) {
  constexpr double kFarBelow = 0.75;
  if (series == 1 || record.voltage_V.empty()) return series;
  const double most_V = FindExtent(record.voltage_V).most;
  if (most_V >= kFarBelow * EmptyVoltage(curve)) return series;
  return std::min(series, CellsInSeries(most_V * series));
}

void CheckSeries(const Record& record, const OpenCircuitVoltage& curve, int series) {
  const int cells = LoggedSeries(record, curve, series);
  if (cells == series) return;
  throw LoadError(
      {record.file},
      fmt::format("expected the voltage of {} cells in series, whose v_oc(A) is {:.3g} V when "
                  "empty, found {:.3g} V per cell at most; is this log one of {}? Then say "
                  "`series` = {} (--series {})",
                  series,
                  EmptyVoltage(curve),
                  FindExtent(record.voltage_V).most,
                  cells == 1 ? "a single cell" : fmt::format("{} cells", cells),
                  cells,
                  cells));
}

}  // namespace lipoid
