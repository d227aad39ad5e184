// Numbers and words for people.

/** A number with so many significant digits; "–" where there is none. */
export function significant(value, digits = 4) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const magnitude = Math.abs(value);
  if (magnitude >= 1e-3 && magnitude < 1e6) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1);
}

/** The last part of a path. */
export function baseName(path) {
  return String(path).split("/").pop();
}
