// `lipoid validate`: measured and predicted voltage of each log, the error under it.
import { lineChart } from "../chart.js";
import { baseName } from "../format.js";
import { section } from "../dom.js";
import { table } from "../table.js";

/** The voltage of a log with its prediction, and the error, zoomed together. */
export function logCharts(series) {
  const { time_s, voltage_V, predicted_V } = series.column;
  const error_mV = voltage_V.map((measured, k) => 1e3 * (measured - predicted_V[k]));
  const x = { label: "time / s", values: time_s, time: true };
  const link = `log ${series.name}`;
  return section(
    baseName(series.name),
    lineChart({
      title: "Voltage",
      x,
      y: { label: "voltage / V" },
      lines: [
        { label: "measured", values: voltage_V },
        { label: "predicted", values: predicted_V },
      ],
      link,
    }),
    lineChart({
      title: "Measured less predicted voltage",
      x,
      y: { label: "error / mV" },
      lines: [{ label: "error", values: error_mV }],
      link,
      height: 160,
    }),
  );
}

export const validate = {
  command: "validate",
  title: () => "Prediction against measurement",
  parts: ({ summary, series }) => [
    table(
      [
        { title: "log", of: (log) => baseName(log.file) },
        { title: "rows", of: (log) => log.rows },
        { title: "mean error / %", of: (log) => log.mean_error_percent },
        { title: "maximum / %", of: (log) => log.max_error_percent },
        { title: "rmse / V", of: (log) => log.rmse_V },
      ],
      summary.logs,
    ),
    ...series.filter(({ kind }) => kind === "log").map(logCharts),
  ],
};
