// The law of a lithium-polymer cell in C99, which is C++ as well: what the exported C file, the sources of the
// exported FMU and lipoid's own check of both are made of. It is included by each after these macros:
//
//   CELL_FLOAT   1: cell_real is float, 0: double
//
//   u_m' = -beta^2 m^2 u_m + i,  m = 1 .. modes;  q' = i      unavailable and delivered charge
//   A    = 1 - (q + 2 sum_m u_m + tail i)/alpha               state of charge, a fraction
//   v_j' = (r_j(A) i - v_j)/tau_j                             branches
//   h'   = (i^2 - h)/tau_h                                    thermal state
//   v    = v_oc(A) - r_s(A, h) i - sum_j v_j - r_ct(A) i_0 asinh(i/i_0)
//
// One cell: amperes (discharge positive), volts, seconds, coulombs. Each step is the exact solution for a
// current and an r_j that are constant over it, whatever its length; r_j is that of its beginning. A state is the
// numbers q, u_1 .., v_1 .., h in a row.

#if CELL_FLOAT
typedef float cell_real;
#define CELL_MATH(function) function##f
#define CELL_ALIVE 1e-25f
#else
typedef double cell_real;
#define CELL_MATH(function) function
#define CELL_ALIVE 1e-200
#endif

// Straight lines between nodes, constant beyond them; one node: a constant.
typedef struct {
  int nodes;
  const cell_real *soc;
  const cell_real *resistance_Ohm;
} cell_resistance;

enum { CELL_CURVE_PIECES = 0, CELL_CURVE_CHEBYSHEV = 1, CELL_CURVE_FOURIER = 2 };

typedef struct {
  cell_real alpha_C;            // charge from A = 1 to A = 0 at vanishing rate
  cell_real tail_s;             // the modes that were left out, per ampere
  int modes;                    // m
  const cell_real *rate_per_s;  // beta^2 m^2
  int branches;
  const cell_real *time_constant_s;  // 0: the branch has no inertia
  const cell_resistance *branch;
  cell_resistance series;
  int warms;                    // whether the cell has self-heating
  cell_real thermal_s;           // tau_h
  cell_real drop_Ohm_per_A2;    // r_s(A, h) = r_s(A) - drop h, at least least_share r_s(A)
  cell_real least_share;
  int transfers;                // whether the cell has charge transfer
  cell_real transfer_A;         // i_0
  cell_resistance transfer;     // r_ct
  int curve;                    // of v_oc(A): one of CELL_CURVE_...
  int nodes;                    // of pieces
  const cell_real *soc;         // of pieces: their ends; else the two ends of the range
  const cell_real *piece_V;     // of pieces: four coefficients each, powers of A less the piece's beginning
  int coefficients;             // of a series, with the constant
  const cell_real *cosine_V;    // Chebyshev or cosine coefficients
  const cell_real *sine_V;      // from the first harmonic on
  cell_real frequency_rad;
  cell_real end_V[2];           // value and slope at the lower and the upper end of the curve, with
  cell_real end_slope_V[2];     // which it continues
} cell_numbers;

static int cell_states(const cell_numbers *cell) {
  return 1 + cell->modes + cell->branches + (cell->warms ? 1 : 0);
}

// The last node that is not above `at`, of at least two nodes and an `at` between the first and the last.
static int cell_node_below(const cell_real *node, int nodes, cell_real at) {
  int below = 0;
  int above = nodes - 1;
  while (above - below > 1) {
    const int middle = below + (above - below) / 2;
    if (at >= node[middle]) {
      below = middle;
    } else {
      above = middle;
    }
  }
  return below;
}

static cell_real cell_ohms(const cell_resistance *of, cell_real soc) {
  const int last = of->nodes - 1;
  int k;
  if (last < 1 || !(soc > of->soc[0])) return of->resistance_Ohm[0];
  if (soc >= of->soc[last]) return of->resistance_Ohm[last];
  k = cell_node_below(of->soc, of->nodes, soc);
  return of->resistance_Ohm[k] + (soc - of->soc[k]) / (of->soc[k + 1] - of->soc[k]) *
                                     (of->resistance_Ohm[k + 1] - of->resistance_Ohm[k]);
}

// v_oc(A).
static cell_real cell_open_circuit(const cell_numbers *cell, cell_real soc) {
  const cell_real *end = cell->soc + (cell->curve == CELL_CURVE_PIECES ? cell->nodes - 1 : 1);
  if (!(soc >= cell->soc[0])) return cell->end_V[0] + cell->end_slope_V[0] * (soc - cell->soc[0]);
  if (soc >= *end) return cell->end_V[1] + cell->end_slope_V[1] * (soc - *end);
  if (cell->curve == CELL_CURVE_PIECES) {
    const int k = cell_node_below(cell->soc, cell->nodes, soc);
    const int first = 4 * k;
    const cell_real *c = cell->piece_V + first;
    const cell_real x = soc - cell->soc[k];
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]));
  }
  if (cell->curve == CELL_CURVE_CHEBYSHEV) {
    // Clenshaw's recurrence.
    const cell_real x =
        (cell_real)2 * (soc - cell->soc[0]) / (cell->soc[1] - cell->soc[0]) - (cell_real)1;
    cell_real b1 = 0;
    cell_real b2 = 0;
    int k;
    for (k = cell->coefficients - 1; k > 0; --k) {
      const cell_real b = (cell_real)2 * x * b1 - b2 + cell->cosine_V[k];
      b2 = b1;
      b1 = b;
    }
    return x * b1 - b2 + cell->cosine_V[0];
  }
  {
    cell_real sum_V = cell->cosine_V[0];
    int k;
    for (k = 1; k < cell->coefficients; ++k) {
      const cell_real angle = (cell_real)k * cell->frequency_rad * soc;
      sum_V += cell->cosine_V[k] * CELL_MATH(cos)(angle) + cell->sine_V[k - 1] * CELL_MATH(sin)(angle);
    }
    return sum_V;
  }
}

// A while this current flows.
static cell_real cell_soc(const cell_numbers *cell, const cell_real *x, cell_real current_A) {
  cell_real sum_C = 0;
  int m;
  for (m = 1; m <= cell->modes; ++m) sum_C += x[m];
  return (cell->alpha_C - (x[0] + (cell_real)2 * sum_C + cell->tail_s * current_A)) / cell->alpha_C;
}

// r_s at this A and thermal state; `scale` multiplies the resistance of the cell where it is relaxed.
static cell_real cell_series(const cell_numbers *cell, const cell_real *x, cell_real soc, cell_real scale) {
  const cell_real cold_Ohm = scale * cell_ohms(&cell->series, soc);
  if (cell->warms) {
    const cell_real warm_Ohm = cold_Ohm - cell->drop_Ohm_per_A2 * x[1 + cell->modes + cell->branches];
    const cell_real least_Ohm = cell->least_share * cold_Ohm;
    return warm_Ohm < least_Ohm ? least_Ohm : warm_Ohm;
  }
  return cold_Ohm;
}

// Terminal voltage while this current flows.
static cell_real cell_voltage(const cell_numbers *cell, const cell_real *x, cell_real current_A, cell_real scale) {
  const cell_real soc = cell_soc(cell, x, current_A);
  cell_real voltage_V = cell_open_circuit(cell, soc) - cell_series(cell, x, soc, scale) * current_A;
  int j;
  for (j = 0; j < cell->branches; ++j) voltage_V -= x[1 + cell->modes + j];
  if (cell->transfers) {
    voltage_V -= cell_ohms(&cell->transfer, soc) * cell->transfer_A *
                 CELL_MATH(asinh)(current_A / cell->transfer_A);
  }
  return voltage_V;
}

// What a step of dt_s needs: x' = drive gain - loss x with loss = 1 - e^{-dt/tau} and, for charges, gain = loss tau.
// Neither loses digits where dt is short.
static void cell_prepare(const cell_numbers *cell, cell_real dt_s, cell_real *loss, cell_real *gain) {
  int k;
  int n = 0;
  loss[n] = 0;
  gain[n++] = dt_s;
  for (k = 0; k < cell->modes; ++k, ++n) {
    loss[n] = -CELL_MATH(expm1)(-cell->rate_per_s[k] * dt_s);
    gain[n] = loss[n] / cell->rate_per_s[k];
  }
  for (k = 0; k < cell->branches; ++k, ++n) {
    loss[n] = cell->time_constant_s[k] > (cell_real)0 ? -CELL_MATH(expm1)(-dt_s / cell->time_constant_s[k])
                                                       : (cell_real)1;
    gain[n] = loss[n];
  }
  if (cell->warms) {
    loss[n] = -CELL_MATH(expm1)(-dt_s / cell->thermal_s);
    gain[n] = loss[n];
  }
}

// Adds to a state what a step changes. What rounding loses is carried to the next step, without which a charge in
// float would stand still in short steps; the compiler must not reorder sums (no -ffast-math).
static void cell_add(cell_real *x, cell_real *carry, cell_real change) {
  const cell_real wanted = change - *carry;
  const cell_real sum = *x + wanted;
  *carry = (sum - *x) - wanted;
  *x = sum;
}

// The state after this current has flowed for the step that was prepared. A branch takes its resistance at the A
// with which the step begins. A mode that dies out in a long rest is kept from denormal numbers.
static void cell_advance(const cell_numbers *cell, cell_real *x, cell_real *carry, const cell_real *loss,
                         const cell_real *gain, cell_real current_A) {
  const cell_real soc = cell->branches > 0 ? cell_soc(cell, x, current_A) : (cell_real)0;
  int n = 0;
  int k;
  cell_add(&x[0], &carry[0], gain[0] * current_A);
  for (n = 1; n <= cell->modes; ++n) {
    cell_add(&x[n], &carry[n], gain[n] * current_A - loss[n] * x[n] + CELL_ALIVE);
  }
  for (k = 0; k < cell->branches; ++k, ++n) {
    const cell_real steady_V = cell_ohms(&cell->branch[k], soc) * current_A;
    cell_add(&x[n], &carry[n], gain[n] * steady_V - loss[n] * x[n] + CELL_ALIVE);
  }
  if (cell->warms) {
    cell_add(&x[n], &carry[n], gain[n] * (current_A * current_A) - loss[n] * x[n] + CELL_ALIVE);
  }
}

// Relaxed at this state of charge: nothing held back, nothing charged, nothing warm.
static void cell_relax(const cell_numbers *cell, cell_real *x, cell_real *carry, cell_real soc) {
  const int states = cell_states(cell);
  int n;
  for (n = 0; n < states; ++n) {
    x[n] = 0;
    carry[n] = 0;
  }
  x[0] = cell->alpha_C * ((cell_real)1 - soc);
}
