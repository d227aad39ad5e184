// v_oc(A) with the rows that it was found from.
import { lineChart } from "../../chart.js";
import { bandOf, openCircuitCurve } from "../../curves.js";
import { note, notice, section } from "../../dom.js";
import { significant } from "../../format.js";

const SOURCES = {
  "low-rate": "the low-rate log",
  rests: "the ends of the rests between pulses",
  given: "the file that was given",
};

export function openCircuitVoltage({ summary, series, key, cautions }) {
  const curve = openCircuitCurve(summary.cell?.open_circuit_voltage);
  if (curve.soc.length === 0) return null;
  const rows = (kind) => series.filter((each) => each.kind === kind);
  const all = (kind, column) => rows(kind).flatMap((each) => Array.from(each.column[column]));
  const lines = [];
  const points = (label, kind, column, more) => {
    if (rows(kind).length > 0) lines.push({ label, x: all(kind, "soc"), values: all(kind, column), points: true, size: 3, ...more });
  };
  points("low-rate log, as measured", "low-rate", "voltage_V", { colour: 6 });
  points("low-rate log, drops taken away", "low-rate", "open_circuit_V", { colour: 0 });
  points("ends of rests", "rests", "open_circuit_V", { colour: 2, size: 7 });
  lines.push({ label: "v_oc(A)", x: curve.soc, values: curve.values, band: bandOf(summary.cell.uncertainty, "v_oc", curve), colour: 1, width: 2 });
  const staged = rows("staged-curve")[0];
  if (staged) lines.push({ label: "staged v_oc(A)", x: Array.from(staged.column.soc), values: Array.from(staged.column.voltage_V), colour: 3, dash: [6, 4] });
  const stage = summary.stages?.open_circuit_voltage;
  const source = stage ? SOURCES[stage.source] ?? stage.source : null;
  return section(
    "Open-circuit voltage",
    note("A is the state of charge by (4.48): 1 is full, 0 is the cut-off at vanishing rate. Points are rows of the logs with the drops that the cell predicts " +
         "taken away; what is left between points and curve is the error of the fit. The band holds the curve in 95 % of cases."),
    cautions.curve.map((text) => notice("warning", text)),
    lineChart({
      title: "Open-circuit voltage",
      name: `${key} open-circuit voltage`,
      x: { label: "state of charge A", values: curve.soc },
      y: { label: "voltage / V" },
      lines,
      height: 360,
    }),
    typeof stage?.rmse_V === "number"
      ? note(`The staged method took it from ${source}: ${stage.nodes ?? "–"} nodes from ${stage.rows ?? "–"} rows; on held-out rows it is off by ${
          significant(1e3 * stage.rmse_V, 3)} mV rms.`)
      : source ? note(`The staged method took it from ${source}.`) : null,
  );
}
