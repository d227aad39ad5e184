// Fig. 4.10 of the thesis: how long each constant current lasted, and how long it was to last.
import { lineChart } from "../../chart.js";
import { note, notice, section } from "../../dom.js";
import { significant } from "../../format.js";
import { table } from "../../table.js";

// L = alpha/I - pi²/(3 beta²), (4.53).
function steadyLine({ alpha_C: alpha, beta_per_sqrt_s: beta }, from, to) {
  const lag = beta > 0 ? Math.PI ** 2 / (3 * beta ** 2) : 0;
  const x = Array.from({ length: 121 }, (_, k) => from * (to / from) ** (k / 120));
  return { x, values: x.map((current) => Math.max(0, alpha / current - lag)) };
}

export function dischargeTimes({ summary, key }) {
  const stage = summary.stages?.discharge_times ?? null;
  const simulated = (summary.constant_current ?? []).filter(({ current_A }) => current_A > 0);
  const rows = stage?.logs ?? [];
  if (rows.length + simulated.length === 0) return null;
  const measured = rows.length > 0 ? rows : simulated;
  const currents = measured.map(({ current_A }) => current_A);
  const [least, most] = [Math.min(...currents), Math.max(...currents)];
  const nearly = most - least < 0.1 * most;  // one current, many times
  const lines = [{ label: "measured", x: currents, values: measured.map(({ measured_s }) => measured_s), points: true, hollow: true, size: 12, colour: 0 }];
  if (simulated.length > 0) {
    lines.push({ label: "this cell, voltage to cut-off", x: simulated.map(({ current_A }) => current_A),
                 values: simulated.map(({ predicted_s }) => predicted_s), points: true, size: 8, colour: 1 });
  }
  if (rows.length > 0) {
    lines.push({ label: "stage 1", x: currents, values: rows.map(({ predicted_s }) => predicted_s), points: true, size: 4, colour: 3 });
    if (Number.isFinite(stage.alpha_C)) lines.push({ label: "stage 1, (4.53)", ...steadyLine(stage, least * 0.9, most * 1.1), colour: 3, dash: [6, 4], width: 1 });
  }
  const byFile = new Map(simulated.map((row) => [row.file, row]));
  const all = rows.length > 0 ? rows : simulated;
  return section(
    "Discharge times",
    note("The time from switch-on to cut-off against the current. The cell of this report predicts the voltage, and so the time; stage 1 has the " +
         "time of diffusion alone, L = alpha/I − π²/(3 beta²), (4.53)."),
    stage && stage.identifiable === false ? notice("warning", `beta is not identifiable from the discharge times${stage.reason ? `: ${stage.reason}` : ""}.`) : null,
    lineChart({
      title: "Discharge time against current",
      name: `${key} discharge times`,
      x: { label: "current / A", values: currents, include: nearly ? [0.9 * least, 1.1 * most] : [] },
      y: { label: "time / s", zero: true },
      lines,
    }),
    table(
      [
        { title: "log", of: ({ file }) => file },
        { title: "current / A", of: ({ current_A }) => current_A },
        { title: "measured / s", of: ({ measured_s }) => measured_s, digits: 5 },
        { title: "this cell / s", of: ({ file }) => byFile.get(file)?.predicted_s, digits: 5 },
        { title: "error / %", of: ({ file }) => byFile.get(file)?.error_percent, digits: 3 },
        { title: "stage 1 / s", of: (row) => (rows.length > 0 ? row.predicted_s : null), digits: 5 },
        { title: "its error / %", of: (row) => (rows.length > 0 ? row.error_percent : null), digits: 3 },
      ],
      all,
      { sort: true, caption: stage ? `Stage 1: alpha ${significant(stage.alpha_C, 5)} C, mean error ${significant(stage.mean_error_percent, 3)} %, rms ${significant(stage.rmse_s, 3)} s` : "Times until cut-off" },
    ),
  );
}
