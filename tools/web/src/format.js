// Numbers and words for people.

/** A number with so many significant digits; "–" where there is none. */
export function significant(value, digits = 4) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const magnitude = Math.abs(value);
  if (magnitude >= 1e-3 && magnitude < 1e6) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
}

/** A whole number with a thin space between groups of three digits. */
export function count(value) {
  if (!Number.isFinite(value)) return "–";
  return String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** The last part of a path. */
export function baseName(path) {
  return String(path).split(/[/\\]/).pop();
}

/** Seconds as h:mm:ss, with as many decimals as asked for. */
export function clock(seconds, decimals = 0) {
  const units = 10 ** decimals;
  const whole = Math.round(Math.abs(seconds) * units);
  const pad = (value) => String(value).padStart(2, "0");
  const s = Math.floor(whole / units);
  const rest = decimals > 0 ? `.${String(whole % units).padStart(decimals, "0")}` : "";
  const sign = seconds < 0 && whole > 0 ? "-" : "";
  return `${sign}${Math.floor(s / 3600)}:${pad(Math.floor(s / 60) % 60)}:${pad(s % 60)}${rest}`;
}

/** A stretch of time in words: "12.5 min". */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 180) return `${significant(seconds)} s`;
  if (seconds < 3 * 3600) return `${significant(seconds / 60, 3)} min`;
  if (seconds < 72 * 3600) return `${significant(seconds / 3600, 3)} h`;
  return `${significant(seconds / 86400, 3)} days`;
}

/** "1 log", "2 logs". */
export function plural(number, thing) {
  return `${count(number)} ${thing}${number === 1 ? "" : "s"}`;
}

/** A name for a file, of words. */
export function fileStem(text) {
  const stem = String(text).normalize("NFKD").toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "");
  return stem.slice(0, 80) || "chart";
}

/** "1.2 to 1.4" of a pair of numbers, each times a factor; null where one is not known. */
export function interval(pair, factor = 1, digits = 3) {
  const known = Array.isArray(pair) && pair.every(Number.isFinite);
  return known ? `${significant(factor * pair[0], digits)} to ${significant(factor * pair[1], digits)}` : null;
}

const ALPHA_SOURCES = {
  "discharge-times": "the discharge times",
  "low-rate-charge": "the charge of the low-rate log",
  "pulse-charge": "the charge of the pulses",
  "nominal-capacity": "the nominal capacity",
  "delivered-charge": "what the deepest log delivered",
  rests: "the ends of the rests on the given curve",
  given: "a given value",
};

/** Where alpha came from, of the key alpha_source, in words. */
export function alphaSource(source) {
  return ALPHA_SOURCES[source] ?? source;
}
