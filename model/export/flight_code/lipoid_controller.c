/* lipoid_controller.c: see lipoid_controller.h. Written by hand, the same for every vehicle; what
 * differs stands in lipoid_numbers.h. Equations are numbered as in lipoid's docs/equations.md.
 * Held to lipoid's own controller, digit for digit in double, by
 * tests/tools/export_controller_test.cc. */
#include "lipoid_controller.h"

#include <float.h>
#include <math.h>

/* A number of the source in the precision of the code. */
#define R(x) ((lipoid_real)(x))

#if LIPOID_DOUBLE
#define LARGEST DBL_MAX
#define ABS fabs
#define ATAN2 atan2
#define COPYSIGN copysign
#define COS cos
#define HYPOT hypot
#define NEARBYINT nearbyint
#define REMAINDER remainder
#define SIN sin
#define SQRT sqrt
#else
#define LARGEST FLT_MAX
#define ABS fabsf
#define ATAN2 atan2f
#define COPYSIGN copysignf
#define COS cosf
#define HYPOT hypotf
#define NEARBYINT nearbyintf
#define REMAINDER remainderf
#define SIN sinf
#define SQRT sqrtf
#endif

static const lipoid_real kStep = R(LIPOID_STEP_S);
static const lipoid_real kGravity = R(LIPOID_GRAVITY_M_PER_S2);

/* A NaN is none, and neither is an infinity. */
static int is_number(lipoid_real x) { return ABS(x) <= LARGEST; }

static int are_numbers(const lipoid_real *x, int count) {
  int k;
  for (k = 0; k < count; ++k) {
    if (!is_number(x[k])) return 0;
  }
  return 1;
}

static int are_within(const lipoid_real *x, int count, lipoid_real range) {
  int k;
  for (k = 0; k < count; ++k) {
    if (!(ABS(x[k]) <= range)) return 0;
  }
  return 1;
}

static lipoid_real or_zero(lipoid_real x) { return is_number(x) ? x : R(0.0); }

static lipoid_real clamped(lipoid_real x, lipoid_real low, lipoid_real high) {
  return x < low ? low : (high < x ? high : x);
}

/* ---- attitude ---------------------------------------------------------------------------- */

typedef lipoid_attitude attitude;

static attitude attitude_of(const lipoid_real angles[3]) {
  attitude a;
  a.sin_roll = SIN(angles[0]);
  a.cos_roll = COS(angles[0]);
  a.sin_pitch = SIN(angles[1]);
  a.cos_pitch = COS(angles[1]);
  a.sin_yaw = SIN(angles[2]);
  a.cos_yaw = COS(angles[2]);
  return a;
}

/* A vector in body axes written in inertial axes, (3.3). */
static void to_inertial(const attitude *a, const lipoid_real body[3], lipoid_real out[3]) {
  const lipoid_real x = a->cos_pitch * body[0] +
                        a->sin_pitch * (a->sin_roll * body[1] + a->cos_roll * body[2]);
  const lipoid_real y = a->cos_roll * body[1] - a->sin_roll * body[2];
  const lipoid_real z =
      a->cos_pitch * (a->sin_roll * body[1] + a->cos_roll * body[2]) - a->sin_pitch * body[0];
  out[0] = a->cos_yaw * x - a->sin_yaw * y;
  out[1] = a->sin_yaw * x + a->cos_yaw * y;
  out[2] = z;
}

/* The other way. */
static void to_body(const attitude *a, const lipoid_real inertial[3], lipoid_real out[3]) {
  const lipoid_real x = a->cos_yaw * inertial[0] + a->sin_yaw * inertial[1];
  const lipoid_real y = a->cos_yaw * inertial[1] - a->sin_yaw * inertial[0];
  const lipoid_real z = inertial[2];
  const lipoid_real down = a->sin_pitch * x + a->cos_pitch * z;
  out[0] = a->cos_pitch * x - a->sin_pitch * z;
  out[1] = a->cos_roll * y + a->sin_roll * down;
  out[2] = a->cos_roll * down - a->sin_roll * y;
}

/* rho' = S(rho) Omega, (3.6) and (3.8). */
static void angle_rates(const attitude *a, const lipoid_real rates[3], lipoid_real out[3]) {
  const lipoid_real across = a->sin_roll * rates[1] + a->cos_roll * rates[2];
  const lipoid_real yaw_rate = across / a->cos_pitch;
  out[0] = rates[0] + a->sin_pitch * yaw_rate;
  out[1] = a->cos_roll * rates[1] - a->sin_roll * rates[2];
  out[2] = yaw_rate;
}

/* ---- references, (3.59) -------------------------------------------------------------------- */

/* The numbers of a reference model of which a step is made. */
typedef struct reference_numbers {
  lipoid_real per_gap;  /* acceleration against a gap, 1/s^2 */
  lipoid_real per_rate; /* and against the rate, 1/s */
  lipoid_real limit;    /* of the acceleration */
  lipoid_real reach;    /* the gap beyond which the limit could no longer brake */
} reference_numbers;

typedef struct reference_now {
  lipoid_real value, rate, acceleration;
} reference_now;

static const reference_numbers kDown = {R(LIPOID_DOWN_PER_GAP),
                                        R(LIPOID_DOWN_PER_RATE),
                                        R(LIPOID_DOWN_LIMIT),
                                        R(LIPOID_DOWN_REACH)};
static const reference_numbers kAngles[3] = {{R(LIPOID_ROLL_PER_GAP),
                                              R(LIPOID_ROLL_PER_RATE),
                                              R(LIPOID_ROLL_LIMIT),
                                              R(LIPOID_ROLL_REACH)},
                                             {R(LIPOID_PITCH_PER_GAP),
                                              R(LIPOID_PITCH_PER_RATE),
                                              R(LIPOID_PITCH_LIMIT),
                                              R(LIPOID_PITCH_REACH)},
                                             {R(LIPOID_YAW_PER_GAP),
                                              R(LIPOID_YAW_PER_RATE),
                                              R(LIPOID_YAW_LIMIT),
                                              R(LIPOID_YAW_REACH)}};
static const reference_numbers kPosition = {R(LIPOID_POSITION_PER_GAP),
                                            R(LIPOID_POSITION_PER_RATE),
                                            R(LIPOID_POSITION_LIMIT),
                                            R(LIPOID_POSITION_REACH)};

static void reference_reset(lipoid_reference *reference, lipoid_real value) {
  reference->value = value;
  reference->rate = R(0.0);
}

/* The reference now; moves on by one step under the command. */
static reference_now reference_step(lipoid_reference *reference,
                                    const reference_numbers *of,
                                    lipoid_real command) {
  const lipoid_real gap = reference->value - command;
  const lipoid_real felt =
      ABS(gap) <= of->reach ? gap : COPYSIGN(SQRT(of->reach * ABS(gap)), gap);
  const lipoid_real wanted = -(of->per_gap * felt + of->per_rate * reference->rate);
  reference_now now;
  now.value = reference->value;
  now.rate = reference->rate;
  now.acceleration = clamped(wanted, -of->limit, of->limit);
  reference->value += kStep * (reference->rate + R(0.5) * kStep * now.acceleration);
  reference->rate += kStep * now.acceleration;
  return now;
}

/* ---- the vehicle's motors ------------------------------------------------------------------ */

/* D_i for the speed at this voltage, (3.17) and (5.52). */
static lipoid_real duty_cycle(lipoid_real speed, lipoid_real battery_V) {
  const lipoid_real holding_V =
      (R(LIPOID_SPEED_SLOPE) + R(LIPOID_SPEED_SQUARE) * speed) * speed * R(LIPOID_PER_MOTOR_CONSTANT);
  return holding_V / battery_V;
}

/* The speed that a voltage at the motor holds, (5.10). */
static lipoid_real held_speed(lipoid_real motor_V) {
  const lipoid_real gamma = R(LIPOID_GAMMA_RAD_PER_S);
  const lipoid_real drive = motor_V * R(LIPOID_DRIVE_PER_V);
  return (R(2.0) * drive) / (gamma + SQRT(gamma * gamma + R(4.0) * drive));
}

/* The voltage that commands reckon with. */
static lipoid_real assumed_V(lipoid_real battery_V) {
#if LIPOID_COMPENSATE
  return battery_V > R(0.0) ? battery_V : R(LIPOID_NOMINAL_VOLTAGE_V); /* (5.52) */
#else
  (void)battery_V;
  return R(LIPOID_NOMINAL_VOLTAGE_V); /* (3.17) */
#endif
}

/* omega_C^2 for torques and thrust, (3.13). */
static void squared_speeds(const lipoid_real torque[3], lipoid_real thrust, lipoid_real out[4]) {
  static const lipoid_real roll[4] = {R(-1.0), R(-1.0), R(1.0), R(1.0)};
  static const lipoid_real pitch[4] = {R(1.0), R(-1.0), R(-1.0), R(1.0)};
  static const lipoid_real yaw[4] = {R(-1.0), R(1.0), R(-1.0), R(1.0)};
  const lipoid_real per_thrust = R(LIPOID_SQUARE_PER_THRUST);
  const lipoid_real per_tilt = R(LIPOID_SQUARE_PER_TILT);
  const lipoid_real per_yaw = R(LIPOID_SQUARE_PER_YAW);
  int i;
  for (i = 0; i < 4; ++i) {
    out[i] = per_thrust * thrust + (per_tilt * roll[i]) * torque[0] +
             (per_tilt * pitch[i]) * torque[1] + (per_yaw * yaw[i]) * torque[2];
  }
}

#if LIPOID_SATURATE
/* Moves the squares together into [0, limit]: torque before thrust. 0: nothing was to be done. */
static int desaturate(lipoid_real squares[4], lipoid_real limit) {
  lipoid_real least = squares[0];
  lipoid_real most = squares[0];
  lipoid_real middle, reach, share, centre;
  int i;
  for (i = 1; i < 4; ++i) {
    if (squares[i] < least) least = squares[i];
    if (squares[i] > most) most = squares[i];
  }
  if (least >= R(0.0) && most <= limit) return 0;
  middle = R(0.5) * (least + most);
  reach = R(0.5) * (most - least);
  share = R(1.0);
  if (R(2.0) * reach > limit) {
    share = (R(0.5) * limit) / reach;
    reach = R(0.5) * limit;
  }
  centre = middle;
  if (middle < reach) centre = reach;
  if (middle > limit - reach) centre = limit - reach;
  for (i = 0; i < 4; ++i) {
    squares[i] = clamped(centre + share * (squares[i] - middle), R(0.0), limit);
  }
  return 1;
}
#endif

#if LIPOID_SATURATE
/* Thrust goes with the square of the speed: where the motors are told to become slow and are still
 * fast, a difference of the commanded squares becomes a larger one of the thrusts. */
static void soften_torques(lipoid_controller *c, lipoid_real squares[4]) {
  const lipoid_real noticed = R(1.5);
  lipoid_real mean = R(0.0);
  lipoid_real commanded, share;
  int i;
  for (i = 0; i < 4; ++i) mean += squares[i];
  mean /= R(4.0);
  commanded = SQRT(mean > R(0.0) ? mean : R(0.0));
  share = commanded / c->expected_rad_per_s;
  if (share * noticed < R(1.0)) {
    for (i = 0; i < 4; ++i) squares[i] = mean + noticed * share * (squares[i] - mean);
  }
  c->expected_rad_per_s += R(LIPOID_MOTOR_LAG_SHARE) * (commanded - c->expected_rad_per_s);
}
#endif

/* The pulse width for a duty cycle, (6.1), and the duty cycle that comes out. */
static void pulse_width(lipoid_controller *c, lipoid_output *output, int i) {
  const lipoid_real low = R(LIPOID_PWM_LOW);
  const lipoid_real span = R(LIPOID_PWM_SPAN);
#if !LIPOID_SATURATE
  (void)c;
  output->pwm[i] = low + span * clamped(output->duty[i], R(0.0), R(1.0));
#elif LIPOID_PWM_ROUNDS
  const lipoid_real wanted = clamped(output->duty[i], R(0.0), R(1.0));
  const lipoid_real exact = low + span * wanted + c->pwm_remainder[i]; /* (6.1) */
  const lipoid_real pwm = clamped(NEARBYINT(exact), low, low + span);
#if LIPOID_PWM_CARRIES
  c->pwm_remainder[i] = clamped(exact - pwm, R(-0.5), R(0.5));
#endif
  output->pwm[i] = pwm;
  output->duty[i] = (pwm - low) / span;
#else
  (void)c;
  output->duty[i] = clamped(output->duty[i], R(0.0), R(1.0));
  output->pwm[i] = low + span * output->duty[i];
#endif
}

/* ---- control -------------------------------------------------------------------------------- */

int lipoid_controller_reset(lipoid_controller *c, const lipoid_state *state) {
  const lipoid_real hover = R(LIPOID_HOVER_SPEED_RAD_PER_S);
  const lipoid_real volts = is_number(state->battery_V) && state->battery_V > R(0.0)
                                ? state->battery_V
                                : R(LIPOID_NOMINAL_VOLTAGE_V);
  const lipoid_real commanded = held_speed(duty_cycle(hover, volts) * assumed_V(volts));
  const lipoid_real control = kGravity - R(4.0) * R(LIPOID_THRUST_COEFFICIENT_N_S2) * commanded *
                                             commanded / R(LIPOID_MASS_KG);
  int k;
  c->expected_rad_per_s = commanded;
  reference_reset(&c->down, or_zero(state->position_m[2]));
  for (k = 0; k < 3; ++k) {
    reference_reset(&c->angles[k], or_zero(state->angles_rad[k]));
    c->angle_integrals[k] = R(0.0);
  }
  for (k = 0; k < 2; ++k) reference_reset(&c->position[k], or_zero(state->position_m[k]));
  c->down_integral = R(LIPOID_ALTITUDE_INTEGRAL) > R(0.0) ? control / R(LIPOID_ALTITUDE_INTEGRAL)
                                                          : R(0.0);
  for (k = 0; k < 4; ++k) {
    c->pwm_remainder[k] = R(0.0);
    c->last.duty[k] = R(0.0);
    c->last.pwm[k] = R(LIPOID_PWM_LOW);
  }
  c->last.saturated = 0;
  return !(are_numbers(state->position_m, 3) && are_numbers(state->angles_rad, 3) &&
           is_number(state->battery_V));
}

/* Position to roll and pitch, (3.67) and (3.68). */
static void tilt(lipoid_controller *c,
                 const lipoid_command *command,
                 const lipoid_state *state,
                 lipoid_real *roll_rad,
                 lipoid_real *pitch_rad) {
  const lipoid_real reach = R(LIPOID_POSITION_REACH_M);
  const lipoid_real limit = R(LIPOID_TILT_LIMIT_RAD);
  const lipoid_real proportional = R(LIPOID_POSITION_PROPORTIONAL_RAD_PER_M);
  const lipoid_real derivative = R(LIPOID_POSITION_DERIVATIVE_RAD_S_PER_M);
  const lipoid_real yaw_cos = COS(state->angles_rad[2]);
  const lipoid_real yaw_sin = SIN(state->angles_rad[2]);
  lipoid_real target[2];
  lipoid_real error[2];
  lipoid_real velocity[2];
  lipoid_real ahead, right;
  int k;
  target[0] = command->x_m;
  target[1] = command->y_m;
  for (k = 0; k < 2; ++k) {
    const lipoid_real from = c->position[k].value;
    const reference_now reference = reference_step(
        &c->position[k], &kPosition, clamped(target[k], from - reach, from + reach));
    error[k] = state->position_m[k] - reference.value;
    velocity[k] = state->velocity_m_per_s[k] - reference.rate;
  }
  ahead = proportional * (yaw_cos * error[0] + yaw_sin * error[1]) +
          derivative * (yaw_cos * velocity[0] + yaw_sin * velocity[1]);
  right = proportional * (yaw_cos * error[1] - yaw_sin * error[0]) +
          derivative * (yaw_cos * velocity[1] - yaw_sin * velocity[0]);
  *roll_rad = clamped(-right, -limit, limit);
  *pitch_rad = clamped(ahead, -limit, limit);
}

/* While a motor saturates an integral may shrink but not grow, (3.61). */
static void integrate(lipoid_real *integral, lipoid_real error, int saturated) {
  if (saturated && error * *integral > R(0.0)) return;
  *integral += kStep * error;
}

int lipoid_controller_step(lipoid_controller *c,
                           const lipoid_command *command,
                           const lipoid_state *state,
                           lipoid_output *output) {
  static const lipoid_real kProportional[3] = {R(LIPOID_ATTITUDE_PROPORTIONAL),
                                               R(LIPOID_ATTITUDE_PROPORTIONAL),
                                               R(LIPOID_YAW_PROPORTIONAL)};
  static const lipoid_real kIntegral[3] = {R(LIPOID_ATTITUDE_INTEGRAL),
                                           R(LIPOID_ATTITUDE_INTEGRAL),
                                           R(LIPOID_YAW_INTEGRAL)};
  static const lipoid_real kDerivative[3] = {R(LIPOID_ATTITUDE_DERIVATIVE),
                                             R(LIPOID_ATTITUDE_DERIVATIVE),
                                             R(LIPOID_YAW_DERIVATIVE)};
  static const lipoid_real kInertia[3] = {
      R(LIPOID_INERTIA_X_KG_M2), R(LIPOID_INERTIA_Y_KG_M2), R(LIPOID_INERTIA_Z_KG_M2)};
  const lipoid_real *const rates = state->body_rates_rad_per_s;
  lipoid_real roll_rad = command->roll_rad;
  lipoid_real pitch_rad = command->pitch_rad;
  reference_now down;
  reference_now wanted[3];
  lipoid_real rho_rates[3];
  lipoid_real down_error, down_control;
  lipoid_real errors[3];
  lipoid_real control[3];
  lipoid_real torque[3];
  lipoid_real thrust;
  lipoid_real squares[4];
  lipoid_real volts;
  int saturated = 0;
  int yaw_cut;
  int k;

  if (!are_numbers(state->position_m, 3) || !are_numbers(state->velocity_m_per_s, 3) ||
      !are_numbers(state->angles_rad, 3) || !are_numbers(rates, 3) ||
      !is_number(state->battery_V) || !is_number(command->altitude_m) ||
      !is_number(command->yaw_rad) ||
      !(command->hold_position ? is_number(command->x_m) && is_number(command->y_m)
                               : is_number(roll_rad) && is_number(pitch_rad))) {
    *output = c->last;
    return 1;
  }

  if (command->hold_position) tilt(c, command, state, &roll_rad, &pitch_rad);
  down = reference_step(&c->down,
                        &kDown,
                        clamped(-command->altitude_m,
                                c->down.value - R(LIPOID_CLIMB_REACH_M),
                                c->down.value + R(LIPOID_DESCENT_REACH_M)));
  wanted[0] = reference_step(&c->angles[0], &kAngles[0], roll_rad);
  wanted[1] = reference_step(&c->angles[1], &kAngles[1], pitch_rad);
  wanted[2] = reference_step(&c->angles[2], &kAngles[2], command->yaw_rad);

  {
    const attitude a = attitude_of(state->angles_rad);
#if LIPOID_LAW == 1
    for (k = 0; k < 3; ++k) rho_rates[k] = rates[k];
#else
    angle_rates(&a, rates, rho_rates);
#endif
    down_error = down.value - state->position_m[2]; /* (3.62) */
    down_control = down.acceleration + R(LIPOID_ALTITUDE_INTEGRAL) * c->down_integral +
                   R(LIPOID_ALTITUDE_PROPORTIONAL) * down_error +
                   R(LIPOID_ALTITUDE_DERIVATIVE) * (down.rate - state->velocity_m_per_s[2]);
    for (k = 0; k < 3; ++k) { /* (3.60) */
      errors[k] = wanted[k].value - state->angles_rad[k];
      control[k] = wanted[k].acceleration + kIntegral[k] * c->angle_integrals[k] +
                   kProportional[k] * errors[k] + kDerivative[k] * (wanted[k].rate - rho_rates[k]);
    }
#if LIPOID_LAW == 1
    (void)a;
    for (k = 0; k < 3; ++k) torque[k] = kInertia[k] * control[k];
    thrust = R(LIPOID_MASS_KG) * (kGravity - down_control);
#else
    {
      /* tau_C = J S^-1 (nu - S' Omega) + Omega x J Omega, (3.49). */
      const lipoid_real along = a.cos_roll * rates[1] - a.sin_roll * rates[2];
      const lipoid_real across = a.sin_roll * rates[1] + a.cos_roll * rates[2];
      const lipoid_real sec = R(1.0) / a.cos_pitch;
      const lipoid_real tangent = a.sin_pitch * sec;
      const lipoid_real drift[3] = {
          rho_rates[0] * tangent * along + rho_rates[1] * sec * sec * across,
          -(rho_rates[0] * across),
          sec * (rho_rates[0] * along + rho_rates[1] * tangent * across)};
      const lipoid_real level[3] = {
          control[0] - drift[0], control[1] - drift[1], control[2] - drift[2]};
      const lipoid_real turned = a.cos_pitch * level[2];
      const lipoid_real body[3] = {level[0] - a.sin_pitch * level[2],
                                   a.cos_roll * level[1] + a.sin_roll * turned,
                                   a.cos_roll * turned - a.sin_roll * level[1]};
      const lipoid_real gyroscopic[3] = {R(LIPOID_INERTIA_Z_LESS_Y_KG_M2) * (rates[1] * rates[2]),
                                         R(LIPOID_INERTIA_X_LESS_Z_KG_M2) * (rates[2] * rates[0]),
                                         R(LIPOID_INERTIA_Y_LESS_X_KG_M2) * (rates[0] * rates[1])};
      for (k = 0; k < 3; ++k) torque[k] = kInertia[k] * body[k] + gyroscopic[k];
      /* T_C = m (g - nu_Z)/(cos Phi cos Theta), (3.58). */
      thrust = R(LIPOID_MASS_KG) * (kGravity - down_control) / (a.cos_roll * a.cos_pitch);
    }
#endif
  }
  yaw_cut = ABS(torque[2]) > R(LIPOID_YAW_TORQUE_LIMIT_N_M);
  if (yaw_cut) {
    torque[2] = COPYSIGN(R(LIPOID_YAW_TORQUE_LIMIT_N_M), torque[2]);
  }
  squared_speeds(torque, thrust, squares);

  volts = assumed_V(state->battery_V);
#if LIPOID_SATURATE
  {
    const lipoid_real highest = held_speed(volts);
    saturated = desaturate(squares, highest * highest);
    soften_torques(c, squares);
  }
#endif
  for (k = 0; k < 4; ++k) {
    const lipoid_real square = squares[k] < R(0.0) ? R(0.0) : squares[k];
    c->last.duty[k] = duty_cycle(SQRT(square), volts);
    pulse_width(c, &c->last, k);
  }
  c->last.saturated = saturated;

  integrate(&c->down_integral, down_error, saturated);
  for (k = 0; k < 3; ++k) {
    integrate(&c->angle_integrals[k], errors[k], saturated || (k == 2 && yaw_cut));
  }
  *output = c->last;
  return 0;
}

/* ---- estimation ----------------------------------------------------------------------------- */

static lipoid_real away_from_the_pole(lipoid_real pitch_rad) {
  return clamped(pitch_rad, -R(LIPOID_GIMBAL_LOCK_RAD), R(LIPOID_GIMBAL_LOCK_RAD));
}

void lipoid_estimator_reset(lipoid_estimator *e, const lipoid_state *at_rest) {
  const attitude a = attitude_of(at_rest->angles_rad);
  lipoid_real gravity[3];
  int k;
  gravity[0] = R(0.0);
  gravity[1] = R(0.0);
  gravity[2] = -kGravity;
  to_body(&a, gravity, e->force_m_per_s2);
  e->attitude = a;
  for (k = 0; k < 3; ++k) {
    e->angles_rad[k] = at_rest->angles_rad[k];
    e->filter_rates_rad_per_s[k] = at_rest->body_rates_rad_per_s[k];
    e->rates_rad_per_s[k] = at_rest->body_rates_rad_per_s[k];
    e->acceleration_m_per_s2[k] = R(0.0);
    e->force_bias_m_per_s2[k] = R(0.0);
    e->rate_bias_rad_per_s[k] = R(0.0);
    e->rest_force_m_per_s2[k] = e->force_m_per_s2[k];
    e->rest_rates_rad_per_s[k] = e->rates_rad_per_s[k];
    e->counts[k] = R(0.0);
  }
  for (k = 0; k < 2; ++k) {
    e->position_m[k] = at_rest->position_m[k];
    e->velocity_m_per_s[k] = at_rest->velocity_m_per_s[k];
  }
  for (k = 0; k < 7; ++k) e->sums[k] = R(0.0);
  e->down_m = at_rest->position_m[2];
  e->down_rate_m_per_s = at_rest->velocity_m_per_s[2];
  e->variance_zz = R(0.0);
  e->variance_zw = R(0.0);
  e->variance_ww = R(0.0);
  e->velocity_variance = R(0.0);
  e->battery_V = at_rest->battery_V;
  e->without_altitude_s = R(0.0);
  e->pressure_bias_m = R(0.0);
  e->rest_down_m = at_rest->position_m[2];
}

void lipoid_estimator_calibrate(lipoid_estimator *e, const lipoid_readings *r) {
  int k;
  if (are_within(r->accelerometer_m_per_s2, 3, R(LIPOID_ACCELEROMETER_RANGE_M_PER_S2))) {
    e->counts[0] += R(1.0);
    for (k = 0; k < 3; ++k) {
      e->sums[k] += r->accelerometer_m_per_s2[k];
      e->force_bias_m_per_s2[k] = e->sums[k] / e->counts[0] - e->rest_force_m_per_s2[k];
    }
  }
  if (are_within(r->gyro_rad_per_s, 3, R(LIPOID_GYRO_RANGE_RAD_PER_S))) {
    e->counts[1] += R(1.0);
    for (k = 0; k < 3; ++k) {
      e->sums[3 + k] += r->gyro_rad_per_s[k];
      e->rate_bias_rad_per_s[k] = e->sums[3 + k] / e->counts[1] - e->rest_rates_rad_per_s[k];
    }
  }
  if (is_number(r->pressure_altitude_m)) {
    e->counts[2] += R(1.0);
    e->sums[6] += r->pressure_altitude_m;
    e->pressure_bias_m = e->sums[6] / e->counts[2] + e->rest_down_m;
  }
}

/* Complementary filter: the gyro, drawn towards the tilt that the accelerometer shows. */
static void step_attitude(lipoid_estimator *e) {
  const lipoid_real *const f = e->force_m_per_s2;
  attitude guess_attitude;
  lipoid_real before[3];
  lipoid_real after[3];
  lipoid_real guess[3];
  lipoid_real across;
  int k;
  angle_rates(&e->attitude, e->filter_rates_rad_per_s, before);
  for (k = 0; k < 3; ++k) guess[k] = e->angles_rad[k] + kStep * before[k];
  guess[1] = away_from_the_pole(guess[1]);
  guess_attitude = attitude_of(guess);
  angle_rates(&guess_attitude, e->rates_rad_per_s, after);
  for (k = 0; k < 3; ++k) {
    e->angles_rad[k] += R(0.5) * kStep * (before[k] + after[k]);
    e->filter_rates_rad_per_s[k] = e->rates_rad_per_s[k];
  }
  across = HYPOT(f[1], f[2]);
  if (ABS(HYPOT(f[0], across) - kGravity) <= R(LIPOID_GRAVITY_BAND_M_PER_S2)) {
    const lipoid_real weight = R(LIPOID_ACCELEROMETER_WEIGHT);
    const lipoid_real roll_error = ATAN2(-f[1], -f[2]) - e->angles_rad[0];
    e->angles_rad[0] += weight * REMAINDER(roll_error, R(LIPOID_TURN_RAD));
    e->angles_rad[1] += weight * (ATAN2(f[0], across) - e->angles_rad[1]);
  }
  e->angles_rad[1] = away_from_the_pole(e->angles_rad[1]);
  e->attitude = attitude_of(e->angles_rad);
}

/* Takes a reading of the height unless it is further than the gate from what is expected. */
static int take_down(lipoid_estimator *e, lipoid_real down_m, lipoid_real gate_m) {
  const lipoid_real innovation = down_m - e->down_m;
  lipoid_real gain_z, gain_w;
  if (!(ABS(innovation) <= gate_m)) return 0;
  gain_z = e->variance_zz / (e->variance_zz + R(LIPOID_ALTITUDE_R_M2));
  gain_w = e->variance_zw / (e->variance_zz + R(LIPOID_ALTITUDE_R_M2));
  e->down_m += gain_z * innovation;
  e->down_rate_m_per_s += gain_w * innovation;
  e->variance_ww -= gain_w * e->variance_zw;
  e->variance_zw *= R(1.0) - gain_z;
  e->variance_zz *= R(1.0) - gain_z;
  return 1;
}

/* The sonar, else the pressure; after a time without either the next reading is believed. */
static void take_altitude(lipoid_estimator *e, const lipoid_readings *r) {
  const int echo = is_number(r->sonar_m) && r->sonar_m > R(LIPOID_SONAR_FLOOR_M);
  const lipoid_real pressure_down_m = e->pressure_bias_m - r->pressure_altitude_m;
  if ((echo && take_down(e, -r->sonar_m, R(LIPOID_SONAR_GATE_M))) ||
      take_down(e, pressure_down_m, R(LIPOID_PRESSURE_GATE_M))) {
    e->without_altitude_s = R(0.0);
    return;
  }
  e->without_altitude_s += kStep;
  if (e->without_altitude_s < R(LIPOID_REACQUIRE_S)) return;
  if (!echo && !is_number(pressure_down_m)) return;
  e->down_m = echo ? -r->sonar_m : pressure_down_m;
  e->variance_zz = R(LIPOID_ALTITUDE_R_M2);
  e->variance_zw = R(0.0);
  e->without_altitude_s = R(0.0);
}

/* The flow is two components of the body's velocity; the third is the one that makes the vertical
 * speed what the filter of the height says. */
static void take_flow(lipoid_estimator *e, const lipoid_readings *r) {
  const attitude *const a = &e->attitude;
  const lipoid_real upright = a->cos_pitch * a->cos_roll;
  const lipoid_real *const flow = r->flow_m_per_s;
  lipoid_real body[3];
  lipoid_real velocity[3];
  lipoid_real gain;
  int k;
  if (!are_within(flow, 2, R(LIPOID_FLOW_RANGE_M_PER_S)) || upright < R(LIPOID_LEAST_UPRIGHT)) return;
  body[0] = flow[0];
  body[1] = flow[1];
  body[2] = (e->down_rate_m_per_s + a->sin_pitch * flow[0] - a->cos_pitch * a->sin_roll * flow[1]) /
            upright;
  to_inertial(a, body, velocity);
  gain = e->velocity_variance / (e->velocity_variance + R(LIPOID_VELOCITY_R_M2_PER_S2));
  for (k = 0; k < 2; ++k) {
    e->velocity_m_per_s[k] += gain * (velocity[k] - e->velocity_m_per_s[k]);
  }
  e->velocity_variance *= R(1.0) - gain;
}

void lipoid_estimator_step(lipoid_estimator *e, const lipoid_readings *r, lipoid_state *state) {
  lipoid_real acceleration[3];
  lipoid_real mean[3];
  lipoid_real before[2];
  int k;
  if (are_within(r->accelerometer_m_per_s2, 3, R(LIPOID_ACCELEROMETER_RANGE_M_PER_S2))) {
    for (k = 0; k < 3; ++k) {
      e->force_m_per_s2[k] = r->accelerometer_m_per_s2[k] - e->force_bias_m_per_s2[k];
    }
  }
  if (are_within(r->gyro_rad_per_s, 3, R(LIPOID_GYRO_RANGE_RAD_PER_S))) {
    for (k = 0; k < 3; ++k) {
      e->rates_rad_per_s[k] = r->gyro_rad_per_s[k] - e->rate_bias_rad_per_s[k];
    }
  }
  if (is_number(r->battery_V)) e->battery_V = r->battery_V;

  step_attitude(e);
  to_inertial(&e->attitude, e->force_m_per_s2, acceleration);
  acceleration[2] += kGravity;
  for (k = 0; k < 3; ++k) {
    mean[k] = R(0.5) * (e->acceleration_m_per_s2[k] + acceleration[k]);
    e->acceleration_m_per_s2[k] = acceleration[k];
  }

  e->down_m += kStep * (e->down_rate_m_per_s + R(0.5) * kStep * mean[2]);
  e->down_rate_m_per_s += kStep * mean[2];
  e->variance_zz += kStep * (R(2.0) * e->variance_zw + kStep * e->variance_ww);
  e->variance_zw += kStep * e->variance_ww;
  e->variance_ww += R(LIPOID_ALTITUDE_Q_M2_PER_S2);
  take_altitude(e, r);

  for (k = 0; k < 2; ++k) {
    before[k] = e->velocity_m_per_s[k];
    e->velocity_m_per_s[k] += kStep * mean[k];
  }
  e->velocity_variance += R(LIPOID_VELOCITY_Q_M2_PER_S2);
  take_flow(e, r);
  for (k = 0; k < 2; ++k) {
    e->position_m[k] += R(0.5) * kStep * (before[k] + e->velocity_m_per_s[k]);
  }

  for (k = 0; k < 2; ++k) {
    state->position_m[k] = e->position_m[k];
    state->velocity_m_per_s[k] = e->velocity_m_per_s[k];
  }
  state->position_m[2] = e->down_m;
  state->velocity_m_per_s[2] = e->down_rate_m_per_s;
  for (k = 0; k < 3; ++k) {
    state->angles_rad[k] = e->angles_rad[k];
    state->body_rates_rad_per_s[k] = e->rates_rad_per_s[k];
  }
  state->battery_V = e->battery_V;
}
