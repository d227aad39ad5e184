/* lipoid_example.c: the whole loop. Three functions are the vehicle's: they read the sensors, write
 * the motors and wait for the next step. As they stand here they make a program for any computer, in
 * which the vehicle hovers still at 1 m and its sensors have a little noise:
 *
 *   cc -std=c99 -O2 -ffp-contract=off lipoid_example.c lipoid_controller.c -lm -o example
 *   ./example             shows the first outputs
 *   ./example 1000000     takes so many steps and says how long one took
 */
#include "lipoid_controller.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define R(x) ((lipoid_real)(x))

/* Between -1 and 1, even. */
static lipoid_real noise(void) {
  static unsigned long state = 1UL;
  state = (state * 1103515245UL + 12345UL) & 0x7fffffffUL;
  return (lipoid_real)((long)(state >> 8) - 0x400000L) / R(4194304.0);
}

static void read_sensors(lipoid_readings *r) {
  int k;
  for (k = 0; k < 3; ++k) {
    r->accelerometer_m_per_s2[k] = R(0.2) * noise();
    r->gyro_rad_per_s[k] = R(0.001) * noise();
  }
  r->accelerometer_m_per_s2[2] -= R(LIPOID_GRAVITY_M_PER_S2);
  r->sonar_m = R(1.0) + R(0.02) * noise();
  r->pressure_altitude_m = R(1.0) + R(0.1) * noise();
  r->flow_m_per_s[0] = R(0.01) * noise();
  r->flow_m_per_s[1] = R(0.01) * noise();
  r->battery_V = R(LIPOID_EXAMPLE_BATTERY_V);
}

static double pwm_sum = 0.0;

static void write_motors(const lipoid_output *output) {
  int k;
  for (k = 0; k < 4; ++k) pwm_sum += (double)output->pwm[k];
}

static void wait_for_the_next_step(void) { /* a timer's interrupt, every 5 ms */
}

int main(int argc, char **argv) {
  static lipoid_estimator estimator;
  static lipoid_controller controller;
  lipoid_readings readings;
  lipoid_state state = {{0}, {0}, {0}, {0}, 0};
  lipoid_command command = {0, 0, 0, 0, 0, 0, 0};
  lipoid_output output;
  const long steps = argc > 1 ? atol(argv[1]) : 5;
  clock_t began;
  double took_s;
  long step;
  int k;

  /* At rest: where it stands, and the biases of the sensors. */
  state.position_m[2] = R(-1.0);
  state.battery_V = R(LIPOID_EXAMPLE_BATTERY_V);
  lipoid_estimator_reset(&estimator, &state);
  for (k = 0; k < LIPOID_CALIBRATION_SAMPLES; ++k) {
    read_sensors(&readings);
    lipoid_estimator_calibrate(&estimator, &readings);
    wait_for_the_next_step();
  }
  lipoid_controller_reset(&controller, &state);

  command.altitude_m = R(1.0);
  command.hold_position = 1;
  began = clock();
  for (step = 0; step < steps; ++step) {
    read_sensors(&readings);
    lipoid_estimator_step(&estimator, &readings, &state);
    if (lipoid_controller_step(&controller, &command, &state, &output) != 0) {
      fputs("a number is none: the motors keep what they had\n", stderr);
    }
    write_motors(&output);
    if (argc < 2) {
      printf("step %ld: duty %.4f %.4f %.4f %.4f, pwm %.0f %.0f %.0f %.0f\n",
             step,
             (double)output.duty[0],
             (double)output.duty[1],
             (double)output.duty[2],
             (double)output.duty[3],
             (double)output.pwm[0],
             (double)output.pwm[1],
             (double)output.pwm[2],
             (double)output.pwm[3]);
    }
    wait_for_the_next_step();
  }
  took_s = (double)(clock() - began) / (double)CLOCKS_PER_SEC;
  if (argc > 1 && steps > 0) {
    printf("%ld steps, %.1f ns each; mean pwm %.2f\n",
           steps,
           1e9 * took_s / (double)steps,
           pwm_sum / (4.0 * (double)steps));
    printf("memory: controller %u bytes, estimator %u bytes\n",
           (unsigned)sizeof controller,
           (unsigned)sizeof estimator);
  }
  return 0;
}
