/* lipoid_controller.h: the flight controller of a quadrotor, as lipoid flies it.
 *
 * C99, also compiles as C++. Needs libm, allocates nothing, has no global state: what it remembers
 * stands in two structs that you place. The numbers of the vehicle, the gains and the options are
 * constants of lipoid_numbers.h. Compile with
 *
 *   cc -std=c99 -O2 -ffp-contract=off -c lipoid_controller.c
 *
 * and never with -ffast-math, which takes away the tests for numbers that are none. With fused
 * multiply-add (without -ffp-contract=off on such a processor) the last digit differs.
 *
 * How to call it, every 5 ms, no sooner and no later (lipoid_example.c is the whole loop):
 *
 *   lipoid_estimator estimator;
 *   lipoid_controller controller;
 *   lipoid_state state = {0};                       where it stands: position, heading, volts
 *   lipoid_estimator_reset(&estimator, &state);
 *   400 times: lipoid_estimator_calibrate(&estimator, &readings);          at rest and level
 *   lipoid_controller_reset(&controller, &state);
 *   every 5 ms:
 *     lipoid_estimator_step(&estimator, &readings, &state);
 *     lipoid_controller_step(&controller, &command, &state, &output);
 *     the motors get output.pwm, or output.duty
 *
 * Who has an estimator already fills lipoid_state from it and leaves the first one out.
 *
 * Frames. Inertial axes X Y Z with Z down: north, east, down, or any other heading. Body axes x
 * ahead, y to the right, z down. Angles are roll, pitch and yaw in rad, turned yaw first: roll is
 * right side down, pitch is nose up, yaw is nose to the right. Pitch must stay within 89 degrees
 * of level. Altitude is -Z, positive up.
 *
 * Motors 1 to 4, elements 0 to 3 of the outputs, are front right, back right, back left and front
 * left, seen from above. Whether front right and back left turn clockwise or counter-clockwise, and
 * the other two the other way, is a number of the vehicle: see the head of lipoid_numbers.h.
 */
#ifndef LIPOID_CONTROLLER_H
#define LIPOID_CONTROLLER_H

#include "lipoid_numbers.h"

#ifdef __cplusplus
extern "C" {
#endif

/* All numbers of the interface. lipoid_numbers.h says which; compile everything that includes this
 * header with -DLIPOID_DOUBLE=1 or -DLIPOID_DOUBLE=0 to decide otherwise. */
#if LIPOID_DOUBLE
typedef double lipoid_real;
#else
typedef float lipoid_real;
#endif

/* Seconds from one step to the next. */
#define LIPOID_STEP_S 0.005

/* What the pilot, or the mission, asks for. */
typedef struct lipoid_command {
  lipoid_real altitude_m;
  lipoid_real yaw_rad;
  int hold_position; /* 1: to x_m, y_m; 0: roll and pitch are commanded */
  lipoid_real x_m;
  lipoid_real y_m;
  lipoid_real roll_rad;
  lipoid_real pitch_rad;
} lipoid_command;

/* What the controller is told of the vehicle. */
typedef struct lipoid_state {
  lipoid_real position_m[3];           /* inertial, z down */
  lipoid_real velocity_m_per_s[3];     /* inertial, z down */
  lipoid_real angles_rad[3];           /* roll, pitch, yaw */
  lipoid_real body_rates_rad_per_s[3]; /* body */
  lipoid_real battery_V;               /* of the whole pack, under load */
} lipoid_state;

/* What the sensors say. A reading that is missing is a NaN; one beyond its range is left out. */
typedef struct lipoid_readings {
  lipoid_real accelerometer_m_per_s2[3]; /* specific force, body; (0, 0, -9.81) at rest, level */
  lipoid_real gyro_rad_per_s[3];         /* body */
  lipoid_real sonar_m;                   /* altitude */
  lipoid_real pressure_altitude_m;       /* altitude above where the calibration was */
  lipoid_real flow_m_per_s[2];           /* velocity ahead and to the right, body */
  lipoid_real battery_V;
} lipoid_readings;

typedef struct lipoid_output {
  lipoid_real duty[4]; /* of the motors; in [0, 1] where the controller saturates */
  lipoid_real pwm[4];  /* the same for the hardware, from LIPOID_PWM_LOW to LIPOID_PWM_HIGH; whole
                          numbers where the controller rounds */
  int saturated;       /* 1: a motor was at its limit, and integrals did not grow */
} lipoid_output;

/* Value and rate of a reference model, (3.59). */
typedef struct lipoid_reference {
  lipoid_real value;
  lipoid_real rate;
} lipoid_reference;

/* What the controller remembers. */
typedef struct lipoid_controller {
  lipoid_reference down;
  lipoid_reference angles[3];
  lipoid_reference position[2];
  lipoid_real down_integral;      /* of the error, m s */
  lipoid_real angle_integrals[3]; /* rad s */
  lipoid_real pwm_remainder[4];   /* of rounding, carried on */
  lipoid_real expected_rad_per_s; /* what the motors have followed to by now, on the mean */
  lipoid_output last;
} lipoid_controller;

/* Sines and cosines of an attitude. */
typedef struct lipoid_attitude {
  lipoid_real sin_roll, cos_roll, sin_pitch, cos_pitch, sin_yaw, cos_yaw;
} lipoid_attitude;

/* What the estimator remembers. */
typedef struct lipoid_estimator {
  lipoid_real angles_rad[3];
  lipoid_attitude attitude; /* of these angles */
  lipoid_real filter_rates_rad_per_s[3];
  lipoid_real down_m;
  lipoid_real down_rate_m_per_s;
  lipoid_real variance_zz;
  lipoid_real variance_zw;
  lipoid_real variance_ww;
  lipoid_real position_m[2];
  lipoid_real velocity_m_per_s[2];
  lipoid_real velocity_variance;
  lipoid_real force_m_per_s2[3]; /* of the last good readings, less the bias */
  lipoid_real rates_rad_per_s[3];
  lipoid_real acceleration_m_per_s2[3]; /* inertial, at the last step */
  lipoid_real battery_V;
  lipoid_real without_altitude_s;
  lipoid_real force_bias_m_per_s2[3];
  lipoid_real rate_bias_rad_per_s[3];
  lipoid_real pressure_bias_m;
  lipoid_real rest_force_m_per_s2[3]; /* what the calibration expects */
  lipoid_real rest_rates_rad_per_s[3];
  lipoid_real rest_down_m;
  lipoid_real sums[7];
  lipoid_real counts[3];
} lipoid_estimator;

/* At rest at a state and a heading, about to hover or hovering: the integral of the altitude starts
 * where hover at state->battery_V, the voltage under that load, is in equilibrium. Returns 0; or 1
 * where position, angles or voltage are infinite or none: zero, or the nominal voltage, then stand
 * in. */
int lipoid_controller_reset(lipoid_controller *controller, const lipoid_state *state);

/* The outputs for the coming 5 ms. Returns 0; or 1 where a number of the state or the command is
 * infinite or none: then the outputs are those of the last step (motors off before the first) and
 * nothing is remembered. */
int lipoid_controller_step(lipoid_controller *controller,
                           const lipoid_command *command,
                           const lipoid_state *state,
                           lipoid_output *output);

/* At a state of rest that is known, one step before the first lipoid_estimator_step(). */
void lipoid_estimator_reset(lipoid_estimator *estimator, const lipoid_state *at_rest);

/* A reading at that state of rest: the means of all of them are the biases of accelerometer, gyro
 * and pressure. Call it between reset and the first step, or never. */
void lipoid_estimator_calibrate(lipoid_estimator *estimator, const lipoid_readings *readings);

/* One step of 5 ms on. The position and the heading are integrated, and drift. */
void lipoid_estimator_step(lipoid_estimator *estimator,
                           const lipoid_readings *readings,
                           lipoid_state *state);

#ifdef __cplusplus
}
#endif

#endif
