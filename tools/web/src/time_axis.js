// A time axis: seconds, and h:mm:ss where the log is longer than a few minutes.
import { clock, significant } from "./format.js";

const SHORT_S = 600;

const STEPS_S = [
  ...[-6, -5, -4, -3, -2, -1].flatMap((power) => [1, 2, 5].map((digit) => digit * 10 ** power)),
  ...[1, 2, 5, 10, 20, 30],
  ...[1, 2, 5, 10, 20, 30].map((minutes) => 60 * minutes),
  ...[1, 2, 3, 6, 12, 24, 48, 120, 240, 480, 1200, 2400, 4800, 12000, 24000, 48000].map((hours) => 3600 * hours),
];

// Decimals that tell two ticks apart.
const decimalsOf = (step) => (step >= 1 ? 0 : Math.min(6, Math.ceil(-Math.log10(step) - 1e-9)));

/** What uPlot needs of the axis, and words for a time: {label, incrs, values, say}. */
export function timeAxis(first_s, last_s) {
  if (last_s - first_s <= SHORT_S) {
    return { label: "time / s", say: (s) => `${significant(s, 7)} s` };
  }
  return {
    label: "time / h:mm:ss",
    incrs: STEPS_S,
    values: (_, splits, __, ___, step) => splits.map((s) => clock(s, decimalsOf(step))),
    say: (s) => `${clock(s, Number.isInteger(s) ? 0 : 2)} (${significant(s, 8)} s)`,
  };
}
