#pragma once

/// @file
/// Open-circuit voltage of a cell against its state of charge, v_oc = f(A), (4.49).
///
///   linear          straight lines between nodes (the thesis' choice)
///   monotone-cubic  cubic pieces through nodes that rise where the nodes rise (the pchip of
///                   MATLAB and SciPy)
///   polynomial      sum_k c_k T_k(x), Chebyshev polynomials of x = (2 A - lo - hi)/(hi - lo)
///   fourier         a_0 + sum_k a_k cos(k w A) + b_k sin(k w A)
///
/// A is a fraction: 1 full, 0 at cut-off at vanishing rate. Outside the range it was made for the
/// curve continues with its end slope, a table with a flat end with that of the next chord that
/// rises; who needs to know counts with InRange(). Volts of one cell.
/// Tests: tests/model/battery/open_circuit_voltage_test.cc.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "model/battery/exact_hold.h"

namespace lipoid {

enum class OcvMethod { kLinear, kPolynomial, kFourier, kMonotoneCubic };

constexpr std::array<std::pair<OcvMethod, std::string_view>, 4> OptionNames(OcvMethod) {
  return {{{OcvMethod::kLinear, "linear"},
           {OcvMethod::kPolynomial, "polynomial"},
           {OcvMethod::kFourier, "fourier"},
           {OcvMethod::kMonotoneCubic, "monotone-cubic"}}};
}

/// Default-constructed there is no curve yet: its voltages are NaN.
class OpenCircuitVoltage {
 public:
  struct ValueAndSlope {
    double value_V;
    double slope_V;  ///< per unit of state of charge
  };
  /// c0 + c1 x + c2 x² + c3 x³ with x = A less the node at which it begins.
  struct Piece {
    double c0, c1, c2, c3;
  };

  /// Nodes at strictly increasing soc, at least two. PreconditionError otherwise.
  static OpenCircuitVoltage Linear(std::vector<double> soc, std::vector<double> voltage_V);
  /// At least four nodes; voltage_V must not fall with soc if the curve is to be monotone.
  static OpenCircuitVoltage MonotoneCubic(std::vector<double> soc, std::vector<double> voltage_V);
  static OpenCircuitVoltage Polynomial(double soc_lo,
                                       double soc_hi,
                                       std::vector<double> chebyshev_V);
  /// cosine_V[0] is the constant; sine_V[0] belongs to the first harmonic, as cosine_V[1] does.
  static OpenCircuitVoltage Fourier(double soc_lo,
                                    double soc_hi,
                                    double frequency_rad,
                                    std::vector<double> cosine_V,
                                    std::vector<double> sine_V);

  [[nodiscard]] OcvMethod method() const { return method_; }
  [[nodiscard]] double soc_lo() const { return lo_; }
  [[nodiscard]] double soc_hi() const { return hi_; }
  [[nodiscard]] bool InRange(double soc) const { return soc >= lo_ && soc <= hi_; }

  /// Nodes of linear and monotone-cubic curves; empty for the others.
  [[nodiscard]] const std::vector<double>& soc() const { return soc_; }
  [[nodiscard]] const std::vector<double>& voltage_V() const { return voltage_V_; }
  /// One per interval between nodes.
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  /// The lines with which the curve continues below soc_lo() and above soc_hi(): from the value there,
  /// with a slope that is another one than that of the piece where the end is flat.
  [[nodiscard]] const ValueAndSlope& below() const { return first_; }
  [[nodiscard]] const ValueAndSlope& above() const { return last_; }
  /// Coefficients of polynomial curves, cosine coefficients of Fourier curves.
  [[nodiscard]] const std::vector<double>& coefficients_V() const { return coefficients_V_; }
  [[nodiscard]] const std::vector<double>& sine_V() const { return sine_V_; }
  [[nodiscard]] double frequency_rad() const { return frequency_rad_; }

  /// f(A) and f'(A); NaN in, NaN out.
  [[nodiscard]] ValueAndSlope Evaluate(double soc) const {
    if (!(soc >= lo_)) return {first_.value_V + first_.slope_V * (soc - lo_), first_.slope_V};
    if (soc >= hi_) return {last_.value_V + last_.slope_V * (soc - hi_), last_.slope_V};
    return pieces_.empty() ? SeriesInRange(soc) : EvaluatePiece(FindPiece(soc), soc);
  }

  /// Between two states of charge of one formula f is smooth: knots divide the formulas.
  [[nodiscard]] std::size_t Formula(double soc) const {
    if (!(soc >= lo_)) return 0;
    if (soc >= hi_) return pieces_.size() + 2;
    return pieces_.empty() ? 1 : 1 + FindPiece(soc);
  }

  /// Evaluate() of an A whose formula is known: along a log many have the same.
  [[nodiscard]] ValueAndSlope EvaluateIn(std::size_t formula, double soc) const {
    if (formula == 0 || formula > pieces_.size()) return Evaluate(soc);
    return EvaluatePiece(formula - 1, soc);
  }

  /// f(A) for any scalar type, (4.49).
  template <class T>
  [[nodiscard]] T operator()(const T& soc) const {
    if constexpr (std::is_same_v<T, double>) return Value(soc);
    const auto at = Evaluate(ScalarPart(soc));
    return Linearized(at.value_V, at.slope_V, soc);
  }

  /// The state of charge at which the curve has this voltage: the highest such A in range, or the
  /// nearest end where the voltage is never reached.
  [[nodiscard]] double SocAtVoltage(double voltage_V) const;

 private:
  void SetPieces(std::vector<Piece> pieces);
  [[nodiscard]] ValueAndSlope EvaluatePiece(std::size_t k, double soc) const {
    const Piece& p = pieces_[k];
    const double x = soc - soc_[k];
    return {p.c0 + x * (p.c1 + x * (p.c2 + x * p.c3)), p.c1 + x * (2.0 * p.c2 + x * 3.0 * p.c3)};
  }
  // Evaluate() without the slope.
  [[nodiscard]] double Value(double soc) const {
    if (!(soc >= lo_)) return first_.value_V + first_.slope_V * (soc - lo_);
    if (soc >= hi_) return last_.value_V + last_.slope_V * (soc - hi_);
    if (pieces_.empty()) return SeriesInRange(soc).value_V;
    const std::size_t k = FindPiece(soc);
    const Piece& p = pieces_[k];
    const double x = soc - soc_[k];
    return p.c0 + x * (p.c1 + x * (p.c2 + x * p.c3));
  }
  // Of soc in [lo, hi).
  [[nodiscard]] std::size_t FindPiece(double soc) const {
    const auto bucket = static_cast<std::size_t>((soc - lo_) * buckets_per_soc_);
    std::size_t k = bucket_[std::min(bucket, bucket_.size() - 1)];
    while (k + 1 < pieces_.size() && soc >= soc_[k + 1]) ++k;
    return k;
  }
  [[nodiscard]] ValueAndSlope SeriesInRange(double soc) const;

  OcvMethod method_ = OcvMethod::kLinear;
  double lo_ = 0.0;
  double hi_ = 1.0;
  std::vector<double> soc_;
  std::vector<double> voltage_V_;
  std::vector<double> coefficients_V_;
  std::vector<double> sine_V_;
  double frequency_rad_ = 0.0;

  std::vector<Piece> pieces_;          // one per interval between nodes
  std::vector<std::uint32_t> bucket_;  // piece in which an equal share of [lo, hi] starts
  double buckets_per_soc_ = 0.0;
  ValueAndSlope first_{std::numeric_limits<double>::quiet_NaN(), 0.0};
  ValueAndSlope last_ = first_;
};

}  // namespace lipoid
