#pragma once

/// @file
/// Stage 2: v_oc(A) from a low-rate discharge, with A by counting charge, (4.59).
///
///   A(k) = (alpha - sigma(k))/alpha,   sigma(k) = i(k) dt + sigma(k-1)
///
/// minimizes the squared voltage error over the curve's coefficients: least squares on nodes for
/// the linear form, the same nodes joined by monotone cubics, Chebyshev polynomials or harmonics
/// for the others. Nodes stand densely where the curve falls fast: they share out its length. A log
/// of few rows is joined row by row. Rest rows take no part.
///
/// The errors reported are those on rows that a first fit was not shown; the curve returned has
/// seen all. Tests: tests/identify/stages/open_circuit_voltage_fit_test.cc.

#include <limits>
#include <vector>

#include "identify/logs/record.h"
#include "model/battery/error_metrics.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/core/options.h"

namespace lipoid {

struct OcvFitOptions {
  OcvMethod method = OcvMethod::kLinear;
  int knots = 200;
  int interpolate_up_to = 1000;
  int degree = 9;
  int harmonics = 7;
  int leave_out_every = 10;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("method", self.method, Names{}, "form of v_oc(A)");
    v("knots",
      self.knots,
      Range{4.0, 100000.0},
      "number of nodes of the forms linear and monotone-cubic; at most a third of the rows");
    v("interpolate_up_to",
      self.interpolate_up_to,
      Range{0.0, 1e6},
      "number of rows up to which v_oc(A) is interpolated row by row, as in the thesis, instead of "
      "fitted");
    v("degree", self.degree, Range{1.0, 60.0}, "degree of the form polynomial");
    v("harmonics", self.harmonics, Range{1.0, 30.0}, "number of harmonics of the form fourier");
    v("leave_out_every",
      self.leave_out_every,
      Range{2.0, 1e6},
      "one row in so many is held out of the fit and judges it");
  }
};

struct OcvFitResult {
  OpenCircuitVoltage curve;
  ErrorMetrics errors;     ///< of the voltage, on the held-out rows
  std::size_t rows = 0;    ///< shown to the final fit
  double charge_C = 0.0;   ///< that the log delivered
  double current_A = 0.0;  ///< its median under load
};

/// The record is a discharge that starts at initial_soc; alpha_C > 0. LoadError where it has too
/// few rows under load for the curve that is asked for.
[[nodiscard]] OcvFitResult FitOpenCircuitVoltage(const Record& record,
                                                 double alpha_C,
                                                 double initial_soc = 1.0,
                                                 const OcvFitOptions& options = {});

}  // namespace lipoid
