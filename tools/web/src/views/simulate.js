// `lipoid simulate`: the voltage and the charge of a cell under the current of a log.
import { lineChart } from "../chart.js";
import { element, facts, note } from "../dom.js";
import { count, duration, significant } from "../format.js";
import { thinnedNote } from "../log_charts.js";
import { isNumber, listOf, times } from "../numbers.js";

const FLAT_HEIGHT = 160;

function charts(series) {
  const { column } = series;
  const chart = (title, label, lines, height) => lineChart({
    title, link: "simulated", x: { label: "time / s", values: column.time_s, time: true }, y: { label }, lines, height,
  });
  const band = column.voltage_low_V ? [column.voltage_low_V, column.voltage_high_V] : undefined;
  const lines = [
    column.voltage_V ? { label: "of the log, which was not used", values: column.voltage_V, colour: 0 } : null,
    { label: band ? "predicted, with the band that holds 95 % of the cells" : "predicted", values: column.predicted_V, colour: 1, band },
    { label: "open circuit", values: column.open_circuit_V, colour: 3, dash: [6, 4] },
  ];
  return [
    chart("Voltage", "voltage / V", lines.filter(Boolean)),
    chart("Current, discharge positive", "current / A", [{ label: "current", values: column.current_A, colour: 2 }], FLAT_HEIGHT),
    chart("Available state of charge A", "A / %", [{ label: "A", values: column.soc.map((share) => 100 * share), colour: 5 }], FLAT_HEIGHT),
    column.temperature_degC
      ? chart("Temperature of the cell", "T / °C", [{ label: "temperature", values: column.temperature_degC, colour: 4 }], FLAT_HEIGHT)
      : null,
  ];
}

const volts = (value) => (isNumber(value) ? `${significant(value)} V` : null);
const percent = (share) => (isNumber(share) ? `${significant(times(100, share))} %` : null);

export const simulate = {
  command: "simulate",
  title: () => "A cell under a recorded current",
  parts: ({ summary, series }) => {
    const [log] = listOf(summary.logs);
    const drawn = series.find(({ kind }) => kind === "simulation");
    const thinned = drawn ? thinnedNote(drawn) : null;
    return [
      facts([
        ["Current", log?.file],
        ["Rows", log ? `${count(log.rows)} of ${count(log.rows_of_current)}` : null],
        ["Lasts", duration(log?.duration_s)],
        ["Cut-off reached", isNumber(log?.cutoff_s) ? `at ${significant(log.cutoff_s, 6)} s` : "no"],
        ["State of charge at the start", percent(log?.initial_soc)],
        ["Available state of charge A at the end", percent(log?.final_soc)],
        ["Voltage at the end", volts(log?.final_voltage_V)],
        ["Lowest voltage", volts(log?.minimum_voltage_V)],
        ["Cells drawn", summary.ensemble?.cells],
        ["Width of their band, on average", volts(summary.ensemble?.band_mean_V)],
        ["At most", volts(summary.ensemble?.band_max_V)],
      ]),
      note("A is what of the charge is at hand, (4.48): under load it is less than what is left, by the gradient inside of the cell, and at rest it comes back."),
      thinned ? note(thinned) : null,
      drawn ? charts(drawn) : element("p", {}, "The samples stand in the file that the command wrote; its own page (--report) shows them."),
    ];
  },
};
