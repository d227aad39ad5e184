#include "model/battery/rest_voltage.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "model/battery/cell_model.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

// Of one cell: with hysteresis it depends on where the cell came from, with dv_oc/dT on how warm it
// is.
class RestVoltage {
 public:
  RestVoltage(const Cell& cell, const Surroundings& surroundings)
      : curve_(cell.open_circuit_voltage), surroundings_(surroundings) {
    if (!cell.hysteresis && !(cell.temperature && cell.temperature->entropy)) return;
    Cell one = cell.AsOne();
    model_.emplace(one.Parameters());
  }
  double operator()(double soc) const {
    return model_ ? model_->Voltage(StartAmong(*model_, soc, surroundings_), 0.0) : curve_(soc);
  }
  /// As OpenCircuitVoltage::SocAtVoltage(): an end of the curve for what lies beyond it.
  [[nodiscard]] double Soc(double voltage_V) const {
    if (!model_) return curve_.SocAtVoltage(voltage_V);
    double low = curve_.soc_lo();
    double high = curve_.soc_hi();
    for (int n = 0; n < 100 && high - low > 1e-15; ++n) {
      const double middle = 0.5 * (low + high);
      ((*this)(middle) < voltage_V ? low : high) = middle;
    }
    // Where a full cell rests higher than one that is not quite full: of the two the nearer.
    const double below_V = (*this)(low);
    const double above_V = (*this)(high);
    if (above_V - below_V > kTolerance_V)
      return voltage_V - below_V < above_V - voltage_V ? low : high;
    return 0.5 * (low + high);
  }
  /// Whether the cell at the state of charge found has this voltage, up to that jump.
  [[nodiscard]] bool Has(double soc, double voltage_V) const {
    if (std::abs((*this)(soc)-voltage_V) <= kTolerance_V) return true;
    return model_ && voltage_V > (*this)(curve_.soc_lo()) && voltage_V < (*this)(curve_.soc_hi());
  }

 private:
  // A voltage beyond the ends is none of this cell's.
  static constexpr double kTolerance_V = 1e-3;

  const OpenCircuitVoltage& curve_;
  const Surroundings& surroundings_;
  std::optional<CellModel<double>> model_;
};

}  // namespace

double VoltageAtRest(const Cell& cell, double soc, const Surroundings& surroundings) {
  return cell.series * RestVoltage(cell, surroundings)(soc);
}

double NearestSocAtRest(const Cell& cell, double voltage_V, const Surroundings& surroundings) {
  return RestVoltage(cell, surroundings).Soc(voltage_V / cell.series);
}

double SocAtRestVoltage(const Cell& cell, double voltage_V, const Surroundings& surroundings) {
  const double of_one_V = voltage_V / cell.series;
  const RestVoltage rest_V(cell, surroundings);
  const double soc = rest_V.Soc(of_one_V);
  if (!rest_V.Has(soc, of_one_V)) {
    const bool of_one_cell = cell.series > 1 && rest_V.Has(rest_V.Soc(voltage_V), voltage_V);
    throw OptionError(fmt::format(
        "initial voltage: expected one that v_oc(A) of the {} has, {:.4g} .. {:.4g} V, found {} V{}",
        cell.series > 1 ? fmt::format("pack of {} cells in series", cell.series) : "cell",
        cell.series * rest_V(cell.open_circuit_voltage.soc_lo()),
        cell.series * rest_V(cell.open_circuit_voltage.soc_hi()),
        voltage_V,
        of_one_cell
            ? fmt::format(", which is that of one of them: give {:.4g}", cell.series * voltage_V)
            : ""));
  }
  return soc;
}

}  // namespace lipoid
