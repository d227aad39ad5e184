// What is drawn of flights over time, in charts that share their cursor.
import { lineChart } from "../chart.js";
import { element } from "../dom.js";
import { significant } from "../format.js";

import { inDegrees, placeIn, rangeOf } from "./flights.js";

// An angle that never gets so far is told in a sentence.
const STILL_DEG = 0.005;
const STILL_M = 5e-4;

const MOTORS = ["1, front right", "2, back right", "3, back left", "4, front left"];

// Numbers of colours of what is drawn beside a flight.
const OTHER = { reference: 1, estimate: 2, command: 6 };

/** All times of all flights, in order, each once. */
function commonTime(flights) {
  if (flights.length === 1) return flights[0].time;
  const all = Float64Array.from(flights.flatMap(({ time }) => [...time])).sort();
  return all.filter((time, k) => k === 0 || time !== all[k - 1]);
}

// A column at the common times: between rows by a straight line, nothing after the end of the flight.
function atTimes(times, flight, values) {
  if (times === flight.time) return values;
  const last = flight.time[flight.time.length - 1];
  return Float64Array.from(times, (time) => {
    if (time > last) return NaN;
    const { row, share } = placeIn(flight.time, time);
    return share === 0 ? values[row] : values[row] + share * (values[row + 1] - values[row]);
  });
}

// uPlot knows a gap as null.
const withGaps = (values) => Array.from(values, (value) => (Number.isFinite(value) ? value : null));

function same(a, b) {
  if (a === b) return true;
  return a.length === b.length && a.every((value, k) => value === b[k] || (value !== value && b[k] !== b[k]));
}

// The same but for the places of a step, which thinned flights do not have at the same instant.
const APART = 0.01;
function nearlySame(a, b) {
  if (same(a, b)) return true;
  const { low, high } = rangeOf([a, b]);
  let apart = 0;
  for (let k = 0; k < a.length; ++k) apart += Math.abs(a[k] - b[k]) > APART * (high - low) ? 1 : 0;
  return apart < APART * a.length;
}

/** The charts, and sentences between them; marks are [{x}], times with a dashed line. */
export function flightCharts(flights, link, marks) {
  const times = commonTime(flights);
  const x = { label: "time / s", values: times, time: true };
  const several = flights.length > 1;
  const sampled = new Map();
  const at = (flight, values) => {
    if (!sampled.has(values)) sampled.set(values, atTimes(times, flight, values));
    return sampled.get(values);
  };

  // Lines of one quantity: that of each flight, then its reference, one where all have the same.
  // of and others are (flight) => column; others {label: (flight) => column or null}.
  const linesOf = (what, of, others = {}) => {
    const lines = flights.map((flight) => ({
      label: several ? flight.name : what,
      values: at(flight, of(flight)),
      colour: flight.index,
    }));
    for (const [label, other] of Object.entries(others)) {
      const found = flights
        .map((flight) => ({ flight, values: other(flight) }))
        .filter(({ values }) => values)
        .map(({ flight, values }) => ({ flight, values: at(flight, values) }));
      const alike = found.length > 0 && found.every(({ values }) => nearlySame(values, found[0].values));
      for (const { flight, values } of alike ? found.slice(0, 1) : found) {
        lines.push({
          label: several && !alike ? `${label}, ${flight.name}` : label,
          values,
          dash: label === "command" ? [2, 4] : [6, 4],
          colour: several && !alike ? flight.index : several ? 6 : OTHER[label],
        });
      }
    }
    return lines;
  };
  const chart = (title, label, lines, more = {}) => lineChart({ title, x, y: { label }, lines, link, marks, ...more });

  const degrees = new Map();
  const turned = (values) => {
    if (!degrees.has(values)) degrees.set(values, inDegrees(values));
    return degrees.get(values);
  };
  const estimated = (name) => ({ column }) =>
    column[name] !== column[name.replace("_estimate", "")] ? column[name] : null;

  const parts = [
    chart("Altitude", "altitude / m", linesOf("altitude", ({ column }) => column.altitude_m, {
      reference: ({ column }) => column.altitude_reference_m,
      command: ({ column }) => column.altitude_command_m,
      estimate: estimated("altitude_estimate_m"),
    })),
    chart("Altitude error: reference less altitude", "error / mm", linesOf("error", ({ column }) => {
      column.altitude_error_mm ??= column.altitude_m.map(
        (altitude, k) => 1e3 * (column.altitude_reference_m[k] - altitude));
      return column.altitude_error_mm;
    }), { height: 180 }),
  ];

  const still = [];
  for (const axis of ["x", "y"]) {
    const of = ({ column }) => column[`${axis}_m`];
    const command = ({ column }) => column[`${axis}_command_m`];
    const { low, high } = rangeOf(flights.flatMap((flight) => [of(flight), command(flight)]));
    if (Math.max(-low, high) < STILL_M) {
      still.push(axis);
      continue;
    }
    parts.push(chart(axis === "x" ? "Place along x, ahead" : "Place along y, to the right", `${axis} / m`,
      linesOf(axis, of, { command }), { height: 200 }));
  }
  for (const angle of ["pitch", "roll", "yaw"]) {
    const of = ({ column }) => turned(column[`${angle}_rad`]);
    const reference = ({ column }) => turned(column[`${angle}_reference_rad`]);
    const { low, high } = rangeOf(flights.flatMap((flight) => [of(flight), reference(flight)]));
    if (Math.max(-low, high) < STILL_DEG) {
      still.push(angle);
      continue;
    }
    const estimate = (flight) => {
      const values = estimated(`${angle}_estimate_rad`)(flight);
      return values && turned(values);
    };
    parts.push(chart(`${angle[0].toUpperCase()}${angle.slice(1)}`, `${angle} / degrees`,
      linesOf(angle, of, { reference, estimate }), { height: 200 }));
  }
  if (still.length > 0) {
    parts.push(element("p", {}, `Without a chart, since nothing moves there: ${still.join(", ")} (less than ` +
      `${significant(1e3 * STILL_M)} mm or ${STILL_DEG} degrees).`));
  }

  for (const [title, label, name] of [
    ["Motor speeds", "speed / (rad/s)", (motor) => `speed_${motor}_rad_per_s`],
    ["Duty cycles", "duty cycle", (motor) => `duty_${motor}`],
  ]) {
    parts.push(several ? ofOneMotor(title, label, name) : ofAllMotors(title, label, name));
  }

  function ofAllMotors(title, label, name) {
    const [{ column }] = flights;
    const columns = MOTORS.map((_, k) => column[name(k + 1)]);
    // Four motors that do the same are one line.
    if (columns.every((values) => same(values, columns[0]))) {
      return chart(title, label, [{ label: "all four motors", values: columns[0] }], { height: 200 });
    }
    return chart(title, label, columns.map((values, k) => ({ label: MOTORS[k], values })), { height: 220 });
  }

  // Of several flights one motor at a time: four lines of each would hide one another.
  function ofOneMotor(title, label, name) {
    const linesFor = (motor) => linesOf("", ({ column }) => column[name(motor)]);
    const figure = chart(title, label, linesFor(1), { height: 200 });
    const motor = element(
      "select",
      { onchange: () => {
        const { min, max } = figure.plot.scales.x;
        figure.plot.setData([times, ...linesFor(Number(motor.value)).map(({ values }) => withGaps(values))]);
        figure.plot.setScale("x", { min, max });
      } },
      ...MOTORS.map((text, k) => element("option", { value: k + 1 }, text)),
    );
    figure.prepend(element("label", { class: "choice" }, `${title} of the motor `, motor));
    return figure;
  }

  const cutoffs = [...new Set(flights.map(({ summary }) => summary.cutoff_V).filter(Number.isFinite))];
  parts.push(
    chart("Voltage of the battery", "voltage / V", [
      ...linesOf("voltage", ({ column }) => column.battery_V),
      ...cutoffs.map((cutoff) => ({
        label: "cut-off", values: new Float64Array(times.length).fill(cutoff), dash: [2, 4], colour: 6,
      })),
    ]),
    chart("Current of the battery", "current / A", linesOf("current", ({ column }) => column.battery_A),
      { height: 220 }),
  );
  if (flights.some(({ column }) => column.soc.some(Number.isFinite))) {
    parts.push(chart("State of charge", "state of charge / %",
      linesOf("state of charge", ({ column }) => (column.soc_percent ??= column.soc.map((soc) => 100 * soc))),
      { height: 200 }));
  }
  return parts;
}

