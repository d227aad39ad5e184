// Every log with what the cell predicts of it.
import { element, note, notice, section } from "../../dom.js";
import { baseName, duration, plural } from "../../format.js";
import { logCharts, thinnedNote } from "../../log_charts.js";
import { table } from "../../table.js";

const mV = (volts) => (typeof volts === "number" ? 1e3 * volts : null);

// Errors of a log: fitted, validation or, of the staged method, among the constant currents.
function errorsOf(summary, log) {
  const same = ({ file }) => file === log.file;
  const flown = summary.flights?.fitted?.find(same);
  if (flown) return { by: flown };
  const staged = summary.staged ?? {};
  if (log.kind === "validation") {
    return { by: summary.validation?.find(same), staged: staged.validation?.find(same) };
  }
  const fitted = summary.logs?.find(same);
  if (fitted) return { by: fitted, staged: fitted.staged };
  const alike = (summary.campaign?.logs ?? []).filter(({ kind }) => kind === log.kind);
  if (log.kind === summary.fitted_kind && alike.length === 1) return { by: summary.stages?.pulses };
  const constant = summary.constant_current?.find(same);
  if (constant) return { by: constant, staged: staged.constant_current?.find(same) };
  return {};
}

function errorTable(summary, logs) {
  const rows = logs.map((log) => ({ log, ...errorsOf(summary, log) }));
  const both = rows.some(({ staged }) => staged);
  const averaged = summary.flights?.averaged;
  return table(
    [
      { title: "log", of: ({ log }) => log.file },
      { title: "kind", of: ({ log }) => log.kind },
      { title: "rows", of: ({ log }) => log.rows },
      ...(averaged ? [{ title: "means", of: ({ by }) => by?.rows }] : []),
      { title: "mean error / %", of: ({ by }) => by?.mean_error_percent },
      { title: "maximum / %", of: ({ by }) => by?.max_error_percent },
      { title: "rms / mV", of: ({ by }) => mV(by?.rmse_V) },
      ...(both
        ? [
            { title: "staged mean error / %", of: ({ staged }) => staged?.mean_error_percent },
            { title: "staged rms / mV", of: ({ staged }) => mV(staged?.rmse_V) },
          ]
        : []),
    ],
    rows,
    { sort: true, caption: both ? "Errors over all rows of each log: the joint answer, and the staged one beside it" : averaged ? `Errors ${averaged}` : "Errors over all rows of each log" },
  );
}

export function logs({ summary, series, key, cautions }) {
  const listed = summary.campaign?.logs ?? [];
  const drawn = series.filter(({ kind }) => kind === "log");
  const staged = drawn.some(({ column }) => column.staged_V);
  const single = (one, k) => {
    const log = listed[k] ?? { file: one.name, kind: "log", rows: one.rows };
    const thinned = thinnedNote(one);
    const apart = log.kind === "validation" ? " It took no part in the fit." : "";
    return element(
      "section",
      { class: "log" },
      element("h4", {}, `${baseName(log.file)} (${log.kind})`),
      note(`${plural(one.rows, "row")}${typeof log.duration_s === "number" ? `, ${duration(log.duration_s)}` : ""}.${apart}${thinned ? ` ${thinned}` : ""}`),
      (cautions.logs[log.file] ?? []).map((text) => notice("warning", text)),
      logCharts(one, { link: `${key} log ${k}` }),
    );
  };
  return section(
    "The logs and what the cell predicts",
    listed.length > 0 ? errorTable(summary, listed) : null,
    staged ? note("“predicted” is by this cell, fitted to all logs at once; “staged” is by the cell that the staged method found from the same logs.") : null,
    drawn.map(single),
  );
}
