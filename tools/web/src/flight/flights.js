// Flights as functions of time: where a vehicle is, how it stands, what its motors and battery do.

const DEGREES = 180 / Math.PI;

/** The row of a sorted column at or before a value, and how far it is to the next (0 to 1). */
export function placeIn(sorted, value) {
  let low = 0;
  let high = sorted.length - 1;
  if (value >= sorted[high]) return { row: high, share: 0 };
  if (value <= sorted[low]) return { row: low, share: 0 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle;
    else high = middle;
  }
  return { row: low, share: (value - sorted[low]) / (sorted[high] - sorted[low]) };
}

function between(values, { row, share }) {
  return share === 0 ? values[row] : values[row] + share * (values[row + 1] - values[row]);
}

// The heading may jump by a whole turn from one row to the next.
function angleBetween(values, { row, share }) {
  if (share === 0) return values[row];
  const step = values[row + 1] - values[row];
  return values[row] + share * (step - 2 * Math.PI * Math.round(step / (2 * Math.PI)));
}

// What tells one flight from another, in the order in which it is said.
const NAMING = [
  (s) => s.maneuver,
  (s) => `${s.gains} gains`,
  (s) => `${s.controller} controller`,
  (s) => (s.compensate ? "compensated" : "not compensated"),
  (s) => (s.estimate ? "on sensors" : "on the true state"),
  (s) => s.vehicle,
  (s) => s.battery,
  (s) => Object.entries(s.maneuver_options ?? {}).map(([name, value]) => `${name} = ${value}`).join(", "),
];

// "ambient-degC": "air in °C".
function optionWords(name) {
  const parts = name.split("-");
  const unit = parts.length > 1 && /^(V|A|Ah|s|degC|g|m)$/.test(parts[parts.length - 1]) ? parts.pop() : null;
  return parts.join(" ").replace(/^ambient$/, "air") + (unit ? ` in ${unit.replace("degC", "°C")}` : "");
}

// What was typed for a flight and not for all of them, files apart.
const FILES = ["--summary", "--report", "--output", "-o"];
function typed(summary, summaries) {
  const words = (each) => (each.run?.arguments ?? []).filter((word, k, all) =>
    !FILES.some((option) => word === option || word.startsWith(`${option}=`) || all[k - 1] === option));
  // An option stays with its value: a bare "3" says nothing.
  const pairs = (each) => words(each).reduce((all, word) => {
    const last = all.length - 1;
    if (!word.startsWith("--") && last >= 0 && /^--[^= ]+$/.test(all[last])) all[last] += ` ${word}`;
    else all.push(word);
    return all;
  }, []);
  const others = summaries.filter((other) => other !== summary).map(pairs);
  const own = pairs(summary).filter((pair) => !others.every((list) => list.includes(pair)));
  return own.map((pair) => pair.replace(/^--([^ =]+)[ =]?/, (_, name) => `${optionWords(name)} `).trim()
    .replace(/^set /, "")
    .replace(/^[a-z]+\.(.+)=/, "$1 = ")
    .replace(/^(wind|gusts) (.+)$/, "$1 $2 m/s").replace(/^(.+) in (\S+) (.+)$/, "$1 $3 $2")).join(", ");
}

/** A short name for each summary, by what they differ in; never twice the same. */
export function namesOf(summaries) {
  if (summaries.length === 1) return [summaries[0].maneuver];
  const differing = NAMING.filter((say) => new Set(summaries.map(say)).size > 1);
  const ways = [
    (summary) => differing.map((say) => say(summary)).join(", "),
    (summary) => typed(summary, summaries),
    (_, k) => `flight ${k + 1}`,
  ];
  const unique = (names) => new Set(names).size === names.length && !names.includes("");
  return ways.map((way) => summaries.map(way)).find(unique);
}

/** How it ended, as a few words; "" where it was completed. */
export function troubleOf(summary) {
  if (summary.outcome === "crashed") return `crashed at ${summary.simulated_s.toFixed(2)} s`;
  if (summary.outcome === "off-course") return "off course";
  if (summary.outcome === "battery-empty") return `battery empty at ${summary.simulated_s.toFixed(2)} s`;
  return "";
}

/** A flight of a result: its summary, the columns of its series by name, and its state at a time. */
export function flightOf(summary, series, name, index) {
  const column = series.column;
  const time = column.time_s;
  const speeds = [1, 2, 3, 4].map((motor) => column[`speed_${motor}_rad_per_s`]);
  return {
    name,
    index,
    summary,
    series,
    column,
    time,
    end_s: Math.max(time[time.length - 1], summary.simulated_s ?? 0),
    trouble: troubleOf(summary),
    /** A column at a time. */
    value: (of, time_s) => between(column[of], placeIn(time, time_s)),
    /** Metres along x, y and up, and angles in rad (3.1). */
    pose(time_s) {
      const place = placeIn(time, time_s);
      return {
        row: place.row,
        x_m: between(column.x_m, place),
        y_m: between(column.y_m, place),
        altitude_m: between(column.altitude_m, place),
        roll_rad: between(column.roll_rad, place),
        pitch_rad: between(column.pitch_rad, place),
        yaw_rad: angleBetween(column.yaw_rad, place),
      };
    },
    speeds: (time_s) => {
      const place = placeIn(time, time_s);
      return speeds.map((values) => between(values, place));
    },
  };
}

// What is left of a number where a reference has come to rest.
const NOTHING_DEG = 1e-9;

/** An angle's column in degrees. */
export function inDegrees(values) {
  return values.map((value) => (Math.abs(value * DEGREES) < NOTHING_DEG ? 0 : value * DEGREES));
}

/** Least and largest of columns of several flights; those that are not numbers are passed over. */
export function rangeOf(columns) {
  let low = Infinity;
  let high = -Infinity;
  for (const values of columns) {
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? { low, high } : { low: 0, high: 0 };
}

/**
 * The place that the flights take, ground included where they are not far above it, and a length
 * for the squares of a grid, of which some ten go across.
 */
export function placeOf(flights) {
  const all = (...names) => rangeOf(flights.flatMap(({ column }) => names.map((name) => column[name])));
  const x = all("x_m", "x_command_m");
  const y = all("y_m", "y_command_m");
  const up = all("altitude_m", "altitude_reference_m");
  const arm_m = Math.max(...flights.map(({ summary }) => summary.vehicle_geometry.arm_m));
  const across_m = Math.max(x.high - x.low, y.high - y.low, up.high - up.low, 6 * arm_m);
  if (up.low < 4 * across_m) up.low = Math.min(0, up.low);
  const size_m = Math.max(across_m, up.high - up.low);
  const rough = size_m / 8;
  const power = 10 ** Math.floor(Math.log10(rough));
  const square_m = power * [1, 2, 5, 10].find((step) => step * power >= rough * 0.999);
  return { x, y, up, size_m, square_m, arm_m };
}
