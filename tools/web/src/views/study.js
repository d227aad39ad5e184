// `lipoid study`: one stage done in several ways. Branches are Figs 4.19 to 4.21 of the thesis, one figure per cell.
import { lineChart } from "../chart.js";
import { element, facts, note } from "../dom.js";
import { baseName, significant } from "../format.js";
import { isNumber, listOf, times } from "../numbers.js";
import { table } from "../table.js";

const columns = (...charts) => element("div", { class: "columns" }, ...charts);

// A line for each group of rows, with its own places of x.
function groupedLines(rows, groups, x, value) {
  return groups.map(({ label, of }, k) => {
    const own = rows.filter((row) => of(row) && isNumber(row[x]));
    return { label, colour: k, dots: true, x: own.map((row) => row[x]), values: own.map(value) };
  }).filter((line) => line.x.length > 0);
}

function branches(summary, rows) {
  const x = { label: "resistor-capacitor branches", values: rows.map((row) => row.branches), whole: true };
  const chart = (title, label, lines, more = {}) =>
    lineChart({ title, x, y: { label, ...more }, lines: lines.map((line) => ({ dots: true, ...line })), link: "branches", height: 240,
                marks: isNumber(summary.recommended_branches) ? [{ x: summary.recommended_branches }] : [] });
  const n = summary.recommended_branches;
  return [
    element("p", { class: "sentence" },
      isNumber(n) ? `${n} ${n === 1 ? "branch is" : "branches are"} recommended (dashed line): more would fit noise.` : "No number of branches is recommended."),
    facts([["Rows", summary.data_rows], ["worth so many independent ones", significant(summary.effective_rows, 3)]]),
    chart("Time of the fit", "time / s", [{ label: "time", values: rows.map((row) => row.wall_s) }], { zero: true }),
    chart("Error of the voltage", "mean error / %", [{ label: "mean error", values: rows.map((row) => row.mean_error_percent) }], { zero: true }),
    columns(
      chart("Root mean square error", "rmse / mV", [{ label: "rmse", values: rows.map((row) => times(1e3, row.rmse_V)) }]),
      chart("Information criterion above the least", "BIC above the least", [{ label: "BIC above the least", values: rows.map((row) => row.information_criterion) }], { zero: true })),
    table(
      [
        { title: "branches", class: "name", of: (row) => `${row.branches}${row.recommended ? ", recommended" : ""}`, by: (row) => row.branches },
        { title: "time / s", of: (row) => row.wall_s, digits: 3 },
        { title: "mean error / %", of: (row) => row.mean_error_percent },
        { title: "maximum / %", of: (row) => row.max_error_percent },
        { title: "rmse / mV", of: (row) => times(1e3, row.rmse_V) },
        { title: "parameters", of: (row) => row.free_parameters },
        { title: "BIC above least", of: (row) => row.information_criterion },
        { title: "at a bound", of: (row) => listOf(row.at_bound).join(", ") },
      ],
      rows,
      { sort: true, caption: "Numbers of branches" },
    ),
  ];
}

const METHODS = [["linear", "straight lines"], ["monotone-cubic", "monotone cubic"], ["polynomial", "polynomial"], ["fourier", "Fourier series"]];

function ocv(summary, rows) {
  const groups = METHODS.map(([method, label]) => ({ label, of: (row) => row.method === method }));
  const chart = (title, label, value) => {
    const lines = groupedLines(rows, groups, "parameters", value);
    return lines.length > 0
      ? lineChart({ title, x: { label: "numbers that the curve is made of", values: [], log: true }, y: { label, log: true }, lines, link: "forms" })
      : null;
  };
  return [
    facts([["Low-rate log", baseName(summary.file ?? "")], ["Charge / C", significant(summary.charge_C)], ["Rows", summary.data_rows]]),
    chart("Error on held-out rows", "rmse / mV", (row) => times(1e3, row.left_out_rmse_V)),
    columns(
      chart("Error in the fit", "rmse / mV", (row) => times(1e3, row.rmse_V)),
      chart("Time", "time / s", (row) => row.wall_s)),
    table(
      [
        { title: "v_oc(A)", of: (row) => row.form, class: "name" },
        { title: "numbers", of: (row) => row.parameters },
        { title: "time / s", of: (row) => row.wall_s, digits: 3 },
        { title: "in the fit: mean / %", of: (row) => row.mean_error_percent, digits: 3 },
        { title: "max / %", of: (row) => row.max_error_percent, digits: 3 },
        { title: "rmse / mV", of: (row) => times(1e3, row.rmse_V) },
        { title: "held out: mean / %", of: (row) => row.left_out_mean_error_percent, digits: 3 },
        { title: "max / %", of: (row) => row.left_out_max_error_percent, digits: 3 },
        { title: "rmse / mV", of: (row) => times(1e3, row.left_out_rmse_V) },
      ],
      rows,
      { sort: true, caption: "Forms of the open-circuit voltage" },
    ),
  ];
}

function terms(_, rows) {
  const groups = [{ label: "with the tail", of: (row) => row.tail === true }, { label: "without", of: (row) => row.tail === false }];
  const chart = (title, label, value, more = {}) =>
    lineChart({ title, x: { label: "diffusion modes", values: [], log: true }, y: { label, ...more }, lines: groupedLines(rows, groups, "terms", value), link: "modes", height: 240 });
  const bias = (row) => (isNumber(row.beta_bias_percent) ? Math.abs(row.beta_bias_percent) : null);
  return [
    note("The series of the diffusion is cut after so many modes; its tail stands for all that are left out. The bias is that against the most modes with the tail."),
    columns(
      chart("Bias of beta", "|bias| / %", bias, { log: true }),
      chart("Bias of r_s", "|bias| / mOhm", (row) => (isNumber(row.series_resistance_bias_Ohm) ? 1e3 * Math.abs(row.series_resistance_bias_Ohm) : null), { log: true }),
      chart("Root mean square error", "rmse / mV", (row) => times(1e3, row.rmse_V)),
      chart("Time of the fit", "time / s", (row) => row.wall_s, { zero: true })),
    table(
      [
        { title: "modes", of: (row) => row.terms },
        { title: "tail", of: (row) => (row.tail ? "yes" : "no") },
        { title: "time / s", of: (row) => row.wall_s, digits: 3 },
        { title: "rmse / mV", of: (row) => times(1e3, row.rmse_V) },
        { title: "beta / s^-1/2", of: (row) => row.beta_per_sqrt_s },
        { title: "its bias / %", of: (row) => row.beta_bias_percent },
        { title: "r_s / Ohm", of: (row) => row.series_resistance_Ohm },
        { title: "its bias / mOhm", of: (row) => times(1e3, row.series_resistance_bias_Ohm) },
        { title: "lost share / %", of: (row) => row.lost_share_percent },
      ],
      rows,
      { sort: true, caption: "Diffusion modes" },
    ),
  ];
}

const STUDIES = {
  branches: { title: "Numbers of branches compared", parts: branches },
  ocv: { title: "Forms of the open-circuit voltage compared", parts: ocv },
  terms: { title: "Numbers of diffusion modes compared", parts: terms },
};
const known = (name) => (Object.hasOwn(STUDIES, name) ? STUDIES[name] : null);

export const study = {
  command: "study",
  title: ({ summary }) => known(summary.study)?.title ?? `Study ${summary.study}`,
  parts: ({ summary }) => {
    const rows = listOf(summary.rows);
    const own = known(summary.study);
    if (!own) return [note(`This page has no charts for the study ${summary.study}.`)];
    return rows.length > 0 ? [...listOf(summary.remarks).map((text) => note(`${text}.`)), ...own.parts(summary, rows)] : [note("The study has no rows.")];
  },
};
