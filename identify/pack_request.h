#pragma once

/// @file
/// Into how large a pack cells are put, and in which state it starts, declared once: options of the
/// commands that predict, and keywords of the functions of Python that do the same. Tests:
/// tests/tools/predict_test.cc, tests/python/test_options.py.

#include <optional>

#include "model/battery/cell.h"
#include "model/battery/prediction.h"
#include "model/battery/ranges.h"
#include "model/core/options.h"

namespace lipoid {

/// The pack of a cell.
struct PackRequest {
  std::optional<int> series = {};
  std::optional<int> parallel = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("series", self.series, kPackSizes, "cells in series, instead of what the cell file says");
    v("parallel",
      self.parallel,
      kPackSizes,
      "cells in parallel, instead of what the cell file says");
  }

  [[nodiscard]] bool given() const { return series || parallel; }
  void ApplyTo(Cell& cell) const {
    cell.series = series.value_or(cell.series);
    cell.parallel = parallel.value_or(cell.parallel);
  }
};

/// The pack that logs were measured on.
struct LoggedPackRequest : PackRequest {
  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("series", self.series, kPackSizes, "cells in series in the logs");
    v("parallel", self.parallel, kPackSizes, "cells in parallel in the logs");
  }
};

/// Where a log, a mission or a flight starts.
struct StartRequest {
  std::optional<double> initial_soc = {};
  std::optional<double> initial_voltage_V = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    VisitOfSoc(self, v);
    v("initial_voltage_V",
      self.initial_voltage_V,
      Range{0.0, 1e5},
      "voltage in V at which the pack rested before the start, instead of a state of charge");
  }

  /// Of these what can be said where v_oc(A) is not known yet.
  template <class Self, class Visitor>
  static void VisitOfSoc(Self& self, Visitor&& v) {
    v("initial_soc",
      self.initial_soc,
      kInitialSocs,
      "state of charge at the start; 1 is full, the default");
  }

  [[nodiscard]] bool given() const { return initial_soc || initial_voltage_V; }
  /// The state of charge of the first row; 1 where nothing was said. OptionError where both were,
  /// or where the cell never rests at that voltage among these surroundings.
  [[nodiscard]] double Soc(const Cell& cell, const Surroundings& surroundings = {}) const;
  /// The same of a cell drawn from one for which Soc() was right: where its v_oc ends before the
  /// voltage, the end.
  [[nodiscard]] double SocOfDrawn(const Cell& cell, const Surroundings& surroundings = {}) const;
};

}  // namespace lipoid
