#pragma once

/// @file
/// How warm a cell is in a prediction, declared once: options of the commands that predict, and
/// keywords of the functions of Python that do the same. Tests: tests/tools/predict_test.cc,
/// tests/python/test_identify.py.

#include <optional>

#include "identify/logs/record.h"
#include "model/battery/prediction.h"
#include "model/battery/ranges.h"

namespace lipoid {

struct SurroundingsRequest {
  std::optional<double> ambient_degC = {};
  std::optional<double> initial_degC = {};
  bool predict_temperature = false;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    VisitOfAmbient(self, v);
    v("predict_temperature",
      self.predict_temperature,
      Names{},
      "predict the temperature also where a log has temperature_degC; without "
      "--ambient-degC the surroundings are as warm as its first row");
  }

  /// Of these what can be said where no log is.
  template <class Self, class Visitor>
  static void VisitOfAmbient(Self& self, Visitor&& v) {
    v("ambient_degC",
      self.ambient_degC,
      kTemperatures_degC,
      "temperature of the surroundings in degC, from which the cell starts and warms, where "
      "a log has no temperature_degC; by default the cell's reference temperature");
    v("initial_degC",
      self.initial_degC,
      kTemperatures_degC,
      "temperature of the cell at the first row in degC, where its temperature is predicted; by default that "
      "of the first row of a log that has temperature_degC, else that of the surroundings");
  }

  /// Of a record, which must outlive what is returned.
  [[nodiscard]] Surroundings Of(const Record& record) const;
};

}  // namespace lipoid
