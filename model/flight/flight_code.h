#pragma once

/// @file
/// Flight code from outside, flown by the simulator in the place of lipoid's own controller and
/// estimator: code that was exported, say. The simulator's controller goes along, sees the same and
/// is not obeyed: references and errors in the log and the result are its.
/// Tests: tests/tools/export_controller_test.cc.

#include <span>

#include "model/control/flight_controller.h"
#include "model/vehicle/sensors.h"

namespace lipoid {

class FlightCode {
 public:
  FlightCode() = default;
  FlightCode(const FlightCode&) = delete;
  FlightCode& operator=(const FlightCode&) = delete;
  virtual ~FlightCode() = default;

  /// At rest, hovering; the voltage is that under hover's load.
  virtual void Reset(const MeasuredState& at_rest) = 0;
  /// Duty cycles for the coming control step.
  virtual PerMotor<double> Step(const FlightCommand& command, const MeasuredState& state) = 0;

  /// Only where the flight estimates: before Reset(), with the readings taken at rest.
  virtual void ResetEstimator(const MeasuredState& at_rest,
                              std::span<const SensorReadings> readings) = 0;
  virtual MeasuredState Estimate(const SensorReadings& readings) = 0;
};

}  // namespace lipoid
