// `lipoid validate`: measured and predicted voltage of each log, the error under it.
import { element, note, section } from "../dom.js";
import { baseName } from "../format.js";
import { logCharts, thinnedNote } from "../log_charts.js";
import { table } from "../table.js";
import { judgement } from "./identify/header.js";

function log(series, k, all) {
  const thinned = thinnedNote(series);
  const alone = all.filter(({ name }) => baseName(name) === baseName(series.name)).length === 1;
  return section(alone ? baseName(series.name) : series.name, thinned ? note(thinned) : null, logCharts(series, { link: `log ${k}` }));
}

const mV = (volts) => (typeof volts === "number" ? 1e3 * volts : null);

export const validate = {
  command: "validate",
  title: () => "Prediction against measurement",
  parts: ({ summary, series }) => [
    summary.fit ? judgement(summary.fit, summary.logs?.length === 1 ? "this log" : "these logs") : null,
    element("p", {}, "Each log's current went through the cell; its voltage is compared with the measured one, row by row."),
    table(
      [
        { title: "log", of: ({ file }) => file },
        { title: "rows", of: ({ rows }) => rows },
        { title: "mean error / %", of: ({ mean_error_percent }) => mean_error_percent },
        { title: "maximum / %", of: ({ max_error_percent }) => max_error_percent },
        { title: "rms / mV", of: ({ rmse_V }) => mV(rmse_V) },
        { title: "mean error above 10 % charge / %", of: (row) => row.mean_error_percent_above_10_soc },
        { title: "rms above 10 % charge / mV", of: (row) => mV(row.rmse_V_above_10_soc) },
        { title: "rows outside v_oc(A)", of: (row) => row.rows_outside_curve },
      ],
      summary.logs ?? [],
      { sort: true, caption: "Errors of the logs" },
    ),
    ...series.filter(({ kind }) => kind === "log").map(log),
  ].filter((part) => part !== null),
};
