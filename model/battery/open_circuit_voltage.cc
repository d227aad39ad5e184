#include "model/battery/open_circuit_voltage.h"

#include <math.h>  // boost 1.74's pchip.hpp calls isnan without std:: (NOLINT: the C header is meant)

#include <boost/math/interpolators/pchip.hpp>

#include "model/core/errors.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

void RequireNodes(const std::vector<double>& soc,
                  const std::vector<double>& voltage_V,
                  std::size_t least) {
  Require(soc.size() == voltage_V.size() && soc.size() >= least,
          "as many voltages as states of charge, and enough of them",
          {{"soc.size()", static_cast<double>(soc.size())},
           {"voltage_V.size()", static_cast<double>(voltage_V.size())},
           {"least", static_cast<double>(least)}});
  for (std::size_t k = 0; k < soc.size(); ++k) {
    Require(std::isfinite(soc[k]) && std::isfinite(voltage_V[k]),
            "finite nodes",
            {{"soc", soc[k]}, {"voltage_V", voltage_V[k]}});
    Require(k == 0 || soc[k] > soc[k - 1], "soc strictly increasing", {{"soc", soc[k]}});
  }
}

// Slope at an end node by the parabola through the first three nodes, kept from turning the curve
// around: what pchip of MATLAB and SciPy do. Boost's own default is the first chord, which is only
// first order.
double EndSlope(double h0, double h1, double chord0, double chord1) {
  const double slope = ((2.0 * h0 + h1) * chord0 - h0 * chord1) / (h0 + h1);
  if (!(slope * chord0 > 0.0)) return 0.0;
  const bool turns = !(chord0 * chord1 > 0.0) && std::abs(slope) > 3.0 * std::abs(chord0);
  return turns ? 3.0 * chord0 : slope;
}

}  // namespace

OpenCircuitVoltage OpenCircuitVoltage::Linear(std::vector<double> soc,
                                              std::vector<double> voltage_V) {
  RequireNodes(soc, voltage_V, 2);
  OpenCircuitVoltage curve;
  curve.method_ = OcvMethod::kLinear;
  std::vector<Piece> pieces(soc.size() - 1);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    pieces[k] = {voltage_V[k], (voltage_V[k + 1] - voltage_V[k]) / (soc[k + 1] - soc[k]), 0.0, 0.0};
  }
  curve.soc_ = std::move(soc);
  curve.voltage_V_ = std::move(voltage_V);
  curve.SetPieces(std::move(pieces));
  return curve;
}

OpenCircuitVoltage OpenCircuitVoltage::MonotoneCubic(std::vector<double> soc,
                                                     std::vector<double> voltage_V) {
  RequireNodes(soc, voltage_V, 4);
  OpenCircuitVoltage curve;
  curve.method_ = OcvMethod::kMonotoneCubic;
  const auto h = [&](std::size_t k) { return soc[k + 1] - soc[k]; };
  const auto chord = [&](std::size_t k) { return (voltage_V[k + 1] - voltage_V[k]) / h(k); };
  const std::size_t last = soc.size() - 2;
  const auto library = boost::math::interpolators::pchip<std::vector<double>>(
      std::vector<double>(soc),
      std::vector<double>(voltage_V),
      EndSlope(h(0), h(1), chord(0), chord(1)),
      EndSlope(h(last), h(last - 1), chord(last), chord(last - 1)));
  std::vector<Piece> pieces(soc.size() - 1);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const double s0 = library.prime(soc[k]);
    const double s1 = library.prime(soc[k + 1]);
    // Hermite's cubic between the nodes with the library's slopes.
    pieces[k] = {voltage_V[k],
                 s0,
                 (3.0 * chord(k) - 2.0 * s0 - s1) / h(k),
                 (s0 + s1 - 2.0 * chord(k)) / (h(k) * h(k))};
  }
  curve.soc_ = std::move(soc);
  curve.voltage_V_ = std::move(voltage_V);
  curve.SetPieces(std::move(pieces));
  return curve;
}

OpenCircuitVoltage OpenCircuitVoltage::Polynomial(double soc_lo,
                                                  double soc_hi,
                                                  std::vector<double> chebyshev_V) {
  Require(soc_hi > soc_lo && !chebyshev_V.empty(),
          "soc_lo < soc_hi and at least one coefficient",
          {{"soc_lo", soc_lo}, {"soc_hi", soc_hi}});
  OpenCircuitVoltage curve;
  curve.method_ = OcvMethod::kPolynomial;
  curve.lo_ = soc_lo;
  curve.hi_ = soc_hi;
  curve.coefficients_V_ = std::move(chebyshev_V);
  curve.first_ = curve.SeriesInRange(soc_lo);
  curve.last_ = curve.SeriesInRange(soc_hi);
  return curve;
}

OpenCircuitVoltage OpenCircuitVoltage::Fourier(double soc_lo,
                                               double soc_hi,
                                               double frequency_rad,
                                               std::vector<double> cosine_V,
                                               std::vector<double> sine_V) {
  Require(soc_hi > soc_lo && cosine_V.size() == sine_V.size() + 1,
          "soc_lo < soc_hi and one cosine coefficient more than sines",
          {{"soc_lo", soc_lo}, {"soc_hi", soc_hi}});
  OpenCircuitVoltage curve;
  curve.method_ = OcvMethod::kFourier;
  curve.lo_ = soc_lo;
  curve.hi_ = soc_hi;
  curve.frequency_rad_ = frequency_rad;
  curve.coefficients_V_ = std::move(cosine_V);
  curve.sine_V_ = std::move(sine_V);
  curve.first_ = curve.SeriesInRange(soc_lo);
  curve.last_ = curve.SeriesInRange(soc_hi);
  return curve;
}

void OpenCircuitVoltage::SetPieces(std::vector<Piece> pieces) {
  pieces_ = std::move(pieces);
  lo_ = soc_.front();
  hi_ = soc_.back();
  const std::size_t buckets = std::min<std::size_t>(4 * pieces_.size(), 1U << 16);
  buckets_per_soc_ = static_cast<double>(buckets) / (hi_ - lo_);
  bucket_.resize(buckets);
  std::uint32_t piece = 0;
  for (std::size_t b = 0; b < buckets; ++b) {
    // A start a little early is harmless: Evaluate() walks forward. Rounding must not make it late.
    const double start = lo_ + (static_cast<double>(b) - 1e-6) / buckets_per_soc_;
    while (piece + 1 < pieces_.size() && soc_[piece + 1] <= start) ++piece;
    bucket_[b] = piece;
  }
  const Piece& p = pieces_.back();
  const double x = hi_ - soc_[soc_.size() - 2];
  first_ = {pieces_.front().c0, pieces_.front().c1};
  last_ = {voltage_V_.back(), p.c1 + x * (2.0 * p.c2 + x * 3.0 * p.c3)};
  // A cell with a flat end of the curve empties all the same: it goes on with the next chord that rises.
  const auto chord = [&](std::size_t k) {
    return (voltage_V_[k + 1] - voltage_V_[k]) / (soc_[k + 1] - soc_[k]);
  };
  if (chord(0) == 0.0) {
    for (std::size_t k = 1; k < pieces_.size() && first_.slope_V == 0.0; ++k)
      first_.slope_V = chord(k);
  }
  if (chord(pieces_.size() - 1) == 0.0) {
    for (std::size_t k = pieces_.size() - 1; k > 0 && last_.slope_V == 0.0; --k)
      last_.slope_V = chord(k - 1);
  }
}

OpenCircuitVoltage::ValueAndSlope OpenCircuitVoltage::SeriesInRange(double soc) const {
  if (coefficients_V_.empty()) return {kNaN, kNaN};  // default-constructed: no curve yet
  if (method_ == OcvMethod::kPolynomial) {
    // Clenshaw's recurrence for sum c_k T_k(x) and, differentiated, for its slope.
    const double scale = 2.0 / (hi_ - lo_);
    const double x = scale * (soc - lo_) - 1.0;
    double b1 = 0.0;
    double b2 = 0.0;
    double d1 = 0.0;
    double d2 = 0.0;
    for (std::size_t k = coefficients_V_.size(); k-- > 1;) {
      const double d = 2.0 * x * d1 + 2.0 * b1 - d2;
      d2 = d1;
      d1 = d;
      const double b = 2.0 * x * b1 - b2 + coefficients_V_[k];
      b2 = b1;
      b1 = b;
    }
    return {x * b1 - b2 + coefficients_V_[0], scale * (x * d1 + b1 - d2)};
  }
  ValueAndSlope sum{coefficients_V_[0], 0.0};
  for (std::size_t k = 0; k < sine_V_.size(); ++k) {
    const double w = static_cast<double>(k + 1) * frequency_rad_;
    const double c = std::cos(w * soc);
    const double s = std::sin(w * soc);
    sum.value_V += coefficients_V_[k + 1] * c + sine_V_[k] * s;
    sum.slope_V += w * (sine_V_[k] * c - coefficients_V_[k + 1] * s);
  }
  return sum;
}

double OpenCircuitVoltage::SocAtVoltage(double voltage_V) const {
  // Curves may dip a little: look from the full end for the first interval that brackets the
  // voltage, then bisect it down to neighbouring doubles.
  constexpr int kIntervals = 4096;
  double above = hi_;
  if (voltage_V >= Evaluate(above).value_V) return above;
  for (int k = kIntervals - 1; k >= 0; --k) {
    double below = lo_ + (hi_ - lo_) * k / kIntervals;
    if (Evaluate(below).value_V > voltage_V) {
      above = below;
      continue;
    }
    for (double middle = 0.5 * (below + above); middle > below && middle < above;
         middle = 0.5 * (below + above)) {
      (Evaluate(middle).value_V > voltage_V ? above : below) = middle;
    }
    return below;
  }
  return lo_;
}

}  // namespace lipoid
