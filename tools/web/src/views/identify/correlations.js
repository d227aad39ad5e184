// How errors of parameters go together.
import { note, section } from "../../dom.js";
import { heatMap } from "../../heat.js";

const MOST = 30;

export function correlations({ summary }) {
  const { names, rows } = summary.covariance ?? summary.trust?.covariance ?? {};
  if (!names || names.length < 2) return null;
  const error = names.map((_, k) => Math.sqrt(rows[k][k] ?? NaN));
  const known = Array.from(names.keys()).filter((k) => error[k] > 0 && Number.isFinite(error[k])).slice(0, MOST);
  if (known.length < 2) return null;
  const left = names.filter((_, k) => !known.includes(k));
  return section(
    "Correlation of the estimates",
    note("Near 1 or −1 the logs determine only a combination of two parameters: use them together, never one without the other."),
    heatMap(
      known.map((k) => names[k]),
      known.map((k) => known.map((n) => Math.max(-1, Math.min(1, rows[k][n] / (error[k] * error[n]))))),
      "Correlation coefficients; blue is below zero, orange above",
    ),
    left.length > 0 ? note(`Without an error of their own, and left out: ${left.join(", ")}.`) : null,
  );
}
