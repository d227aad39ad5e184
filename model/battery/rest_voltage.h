#pragma once

/// @file
/// From the voltage of a pack at rest to its state of charge, as predictions begin.
/// Tests: tests/model/battery/rest_voltage_test.cc.

#include "model/battery/cell.h"
#include "model/battery/prediction.h"

namespace lipoid {

/// The voltage with which the pack rests at a state of charge, as a prediction among these surroundings begins.
[[nodiscard]] double VoltageAtRest(const Cell& cell,
                                   double soc,
                                   const Surroundings& surroundings = {});

/// The state of charge at which the pack rests with this voltage, as a prediction among these
/// surroundings begins: with hysteresis a rest is not on v_oc(A), with dv_oc/dT it is another one in
/// the cold. A full cell was charged and rests higher by 2 M than one that is not quite full: a voltage
/// in between is that of a full one, on the side that is nearer. OptionError where it never has it.
[[nodiscard]] double SocAtRestVoltage(const Cell& cell,
                                      double voltage_V,
                                      const Surroundings& surroundings = {});
/// The same; the end that is nearer where it never has it.
[[nodiscard]] double NearestSocAtRest(const Cell& cell,
                                      double voltage_V,
                                      const Surroundings& surroundings = {});

}  // namespace lipoid
