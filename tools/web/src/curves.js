// Functions of the state of charge as the cell file has them, sampled for a chart.

const STEPS = 300;

function sampled(lo, hi, of) {
  const soc = Array.from({ length: STEPS + 1 }, (_, k) => lo + ((hi - lo) * k) / STEPS);
  return { soc, values: soc.map(of) };
}

function chebyshev(coefficients, x) {
  let [before, here] = [1, x];
  let sum = coefficients[0] ?? 0;
  for (let k = 1; k < coefficients.length; ++k) {
    sum += coefficients[k] * here;
    [before, here] = [here, 2 * x * here - before];
  }
  return sum;
}

/** v_oc(A): {soc, values}; between the nodes of a table the chart draws straight lines. */
export function openCircuitCurve(curve) {
  if (!curve) return { soc: [], values: [] };
  if (Array.isArray(curve.soc)) return { soc: curve.soc, values: curve.voltage_V };
  const [lo, hi] = curve.soc_range;
  if (curve.method === "fourier") {
    const { frequency_rad: w, cosine_V: a, sine_V: b } = curve;
    return sampled(lo, hi, (A) =>
      a.reduce((sum, value, k) => sum + value * Math.cos(k * w * A), 0) +
      b.reduce((sum, value, k) => sum + value * Math.sin((k + 1) * w * A), 0));
  }
  return sampled(lo, hi, (A) => chebyshev(curve.coefficients_V, (2 * A - lo - hi) / (hi - lo)));
}

/** A resistance, a number or a table, over the state of charge: {soc, values, constant}. */
export function resistanceCurve(resistance) {
  if (typeof resistance === "number") return { soc: [0, 1], values: [resistance, resistance], constant: true };
  return { soc: resistance.soc, values: resistance.resistance_Ohm, constant: false };
}

/**
 * 95 % bands of what a cell file calls `name` (r_s) or, for tables, name[0], name[1], ...: {low, high}, null where the uncertainty
 * does not name a node, or none at all.
 */
export function bandOf(uncertainty, name, curve, { positive = false } = {}) {
  const errors = uncertainty?.standard_errors;
  const reach = uncertainty?.reach_95;
  if (!Array.isArray(errors) || typeof reach !== "number") return null;
  const errorOf = new Map(uncertainty.parameters.map((parameter, k) => [parameter, errors[k]]));
  const error = (k) => errorOf.get(curve.constant ? name : `${name}[${k}]`) ?? null;
  const known = curve.values.map((_, k) => error(k));
  if (known.every((value) => value === null)) return null;
  const end = (sign) => curve.values.map((value, k) => {
    if (known[k] === null) return null;
    const at = value + sign * reach * known[k];
    return positive ? Math.max(0, at) : at;
  });
  return [end(-1), end(1)];
}
