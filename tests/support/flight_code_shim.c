/* What the tests call of an exported controller: the same functions in double, whatever the
 * precision of the code. Compiled by the tests together with lipoid_controller.c. */
#include "lipoid_controller.h"

#ifdef __cplusplus
extern "C" {
#endif

static lipoid_controller controller;
static lipoid_estimator estimator;

/* position, velocity, angles, rates, volts. */
static void state_of(const double x[13], lipoid_state *state) {
  int k;
  for (k = 0; k < 3; ++k) {
    state->position_m[k] = (lipoid_real)x[k];
    state->velocity_m_per_s[k] = (lipoid_real)x[3 + k];
    state->angles_rad[k] = (lipoid_real)x[6 + k];
    state->body_rates_rad_per_s[k] = (lipoid_real)x[9 + k];
  }
  state->battery_V = (lipoid_real)x[12];
}

static void readings_of(const double r[11], lipoid_readings *readings) {
  int k;
  for (k = 0; k < 3; ++k) {
    readings->accelerometer_m_per_s2[k] = (lipoid_real)r[k];
    readings->gyro_rad_per_s[k] = (lipoid_real)r[3 + k];
  }
  readings->sonar_m = (lipoid_real)r[6];
  readings->pressure_altitude_m = (lipoid_real)r[7];
  readings->flow_m_per_s[0] = (lipoid_real)r[8];
  readings->flow_m_per_s[1] = (lipoid_real)r[9];
  readings->battery_V = (lipoid_real)r[10];
}

int shim_bytes_of_real(void) { return (int)sizeof(lipoid_real); }

int shim_reset(const double x[13]) {
  lipoid_state state;
  state_of(x, &state);
  return lipoid_controller_reset(&controller, &state);
}

/* command: altitude, yaw, whether position is held, x, y, roll, pitch; out: duty, pwm, saturated. */
int shim_step(const double c[7], const double x[13], double out[9]) {
  lipoid_state state;
  lipoid_command command;
  lipoid_output output;
  int code, k;
  state_of(x, &state);
  command.altitude_m = (lipoid_real)c[0];
  command.yaw_rad = (lipoid_real)c[1];
  command.hold_position = c[2] > 0.5;
  command.x_m = (lipoid_real)c[3];
  command.y_m = (lipoid_real)c[4];
  command.roll_rad = (lipoid_real)c[5];
  command.pitch_rad = (lipoid_real)c[6];
  code = lipoid_controller_step(&controller, &command, &state, &output);
  for (k = 0; k < 4; ++k) {
    out[k] = (double)output.duty[k];
    out[4 + k] = (double)output.pwm[k];
  }
  out[8] = (double)output.saturated;
  return code;
}

void shim_estimator_reset(const double x[13]) {
  lipoid_state state;
  state_of(x, &state);
  lipoid_estimator_reset(&estimator, &state);
}

void shim_estimator_calibrate(const double r[11]) {
  lipoid_readings readings;
  readings_of(r, &readings);
  lipoid_estimator_calibrate(&estimator, &readings);
}

void shim_estimator_step(const double r[11], double x[13]) {
  lipoid_readings readings;
  lipoid_state state;
  int k;
  readings_of(r, &readings);
  lipoid_estimator_step(&estimator, &readings, &state);
  for (k = 0; k < 3; ++k) {
    x[k] = (double)state.position_m[k];
    x[3 + k] = (double)state.velocity_m_per_s[k];
    x[6 + k] = (double)state.angles_rad[k];
    x[9 + k] = (double)state.body_rates_rad_per_s[k];
  }
  x[12] = (double)state.battery_V;
}

#ifdef __cplusplus
}
#endif
