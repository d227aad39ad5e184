// A log in pictures: voltage with predictions, what they are off by, current and temperature.
import { lineChart } from "./chart.js";
import { baseName } from "./format.js";

const MEASURED = { label: "measured", column: "voltage_V", colour: 0 };

const ERROR_HEIGHT = 180;
const SMALL_HEIGHT = 140;

/** Predictions that a series may hold: what they are called, how they look, and whether one stands aside: the axes need not reach it. */
export const PREDICTIONS = [
  { label: "predicted", column: "predicted_V", colour: 1 },
  { label: "staged", column: "staged_V", colour: 3, dash: [6, 4], aside: true },
];

// Whether a line leaves what the others span by more than that span.
function strays(values, others) {
  const all = others.flatMap((column) => Array.from(column).filter(Number.isFinite));
  const low = all.reduce((least, value) => Math.min(least, value), Infinity);
  const high = all.reduce((most, value) => Math.max(most, value), -Infinity);
  return high > low && values.some((value) => value < 2 * low - high || value > 2 * high - low);
}

function errors(measured, predicted) {
  return Float64Array.from(measured, (value, k) => 1e3 * (value - predicted[k]));
}

/**
 * The charts of a series of kind "log", linked.
 * @param link         a key of its own among the logs of the page
 * @param predictions  what to draw of PREDICTIONS, or others like them; those that the series lacks are left out
 */
export function logCharts(series, { link, predictions = PREDICTIONS, spans, marks } = {}) {
  const { column } = series;
  const x = { label: "time / s", values: column.time_s, time: true };
  const shared = { x, link: link ?? `log ${series.name}`, spans, marks };
  const stem = baseName(series.name);
  const drawn = predictions.filter((prediction) => column[prediction.column]);
  const there = drawn.map((prediction) => {
    // The staged cell of a log that it was not made for may end at -30 V, and nothing else would be seen.
    const others = [MEASURED, ...drawn].filter((other) => other.column !== prediction.column && column[other.column]);
    return prediction.aside && strays(column[prediction.column], others.map((other) => column[other.column]))
      ? { ...prediction, label: `${prediction.label}, in part beyond the chart`, scaled: false }
      : prediction;
  });
  const charts = [];
  const chart = (title, unit, lines, height) =>
    charts.push(lineChart({ ...shared, title, name: `${stem} ${title}`, y: { label: unit }, lines, height }));
  if (column.voltage_V || there.length > 0) {
    const shown = column.voltage_V ? [MEASURED, ...there] : there;
    chart("Voltage", "voltage / V", shown.map(({ column: from, ...line }) => ({ ...line, values: column[from] })));
  }
  if (column.voltage_V && there.length > 0) {
    chart(
      "Measured less predicted voltage",
      "error / mV",
      there.map(({ column: from, ...line }) => ({ ...line, values: errors(column.voltage_V, column[from]), digits: 4 })),
      ERROR_HEIGHT,
    );
  }
  if (column.current_A) {
    chart("Current, discharge positive", "current / A", [{ label: "current", values: column.current_A, colour: 2 }], SMALL_HEIGHT);
  }
  if (column.temperature_degC) {
    chart("Temperature", "T / °C", [{ label: "temperature", values: column.temperature_degC, colour: 4 }], SMALL_HEIGHT);
  }
  return charts;
}

/** A sentence where the page has fewer rows than the log. */
export function thinnedNote(series) {
  const shown = series.column.time_s?.length ?? 0;
  return shown < series.rows
    ? `The charts show ${shown} of ${series.rows} rows: every peak, and all rows about the steps of the current that are kept whole.`
    : null;
}
