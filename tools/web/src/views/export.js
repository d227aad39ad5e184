// `lipoid export`: how far another program's battery is from the cell.
import { lineChart } from "../chart.js";
import { element, facts, note, section } from "../dom.js";
import { significant } from "../format.js";
import { thinnedNote } from "../log_charts.js";
import { isNumber, listOf, times } from "../numbers.js";
import { table } from "../table.js";

const ERROR_HEIGHT = 180;

const KINDS = {
  exact: "its law is the cell's own, up to what numbers are rounded to",
  projected: "its law is poorer; its numbers are those that follow the cell best over the mission",
  data: "a table for other programs",
};

function charts(series) {
  const { column } = series;
  const chart = (title, label, lines, height) => lineChart({
    title, link: "exported", x: { label: "time / s", values: column.time_s, time: true }, y: { label }, lines, height,
  });
  const laws = [
    { label: "exported", values: column.exported_V, colour: 1 },
    column.naive_V ? { label: "with numbers read off the cell file", values: column.naive_V, colour: 3, dash: [6, 4] } : null,
  ].filter(Boolean);
  const off = (values) => Float64Array.from(values, (value, k) => 1e3 * (value - column.cell_V[k]));
  return [
    chart("Voltage of the pack", "voltage / V", [{ label: "the cell", values: column.cell_V, colour: 0 }, ...laws]),
    chart("Less the voltage of the cell", "error / mV", laws.map((law) => ({ ...law, values: off(law.values), digits: 4 })), ERROR_HEIGHT),
    chart("Current of the mission, discharge positive", "current / A", [{ label: "current", values: column.current_A, colour: 2 }], ERROR_HEIGHT),
  ];
}

function errors({ rmse_V, max_error_V, worst_s, naive, charge_error, naive_charge_error }) {
  const voltage = (name, error) => (error && isNumber(error.rmse_V)
    ? { name, unit: "mV", rms: 1e3 * error.rmse_V, most: times(1e3, error.max_error_V), at: error.worst_s } : null);
  const charge = (name, error) => (error && isNumber(error.rms)
    ? { name, unit: "% of charge", rms: 100 * error.rms, most: times(100, error.max_error), at: error.worst_s } : null);
  const rows = [
    voltage("voltage", { rmse_V, max_error_V, worst_s }),
    voltage("voltage, with numbers read off the cell file", naive),
    charge("state of charge", charge_error),
    charge("state of charge, with numbers read off the cell file", naive_charge_error),
  ].filter(Boolean);
  return table(
    [
      { title: "how far from the cell", of: ({ name }) => name },
      { title: "root mean square", of: ({ rms }) => rms },
      { title: "at most", of: ({ most }) => most },
      { title: "unit", of: ({ unit }) => unit },
      { title: "at most at / s", of: ({ at }) => at },
    ],
    rows,
  );
}

const sentences = (title, texts) =>
  (listOf(texts).length > 0 ? section(title, element("ul", {}, ...texts.map((text) => element("li", {}, text)))) : null);

export const exported = {
  command: "export",
  title: ({ summary }) => `A cell for ${summary.target}`,
  parts: ({ summary, series }) => {
    const drawn = series.find(({ kind }) => kind === "export");
    const thinned = drawn ? thinnedNote(drawn) : null;
    return [
      facts([
        ["Target", `${summary.target}: ${KINDS[summary.kind] ?? summary.kind}`],
        ["Version of the target", summary.target_version],
        ["Pack", `${summary.series} in series, ${summary.parallel} in parallel`],
        ["Mission", summary.mission],
        ["State of charge at its start", isNumber(summary.initial_soc) ? `${significant(100 * summary.initial_soc)} %` : null],
        ["Files", listOf(summary.files).join(", ")],
      ]),
      errors(summary),
      thinned ? note(thinned) : null,
      drawn ? charts(drawn) : null,
      sentences("What this law cannot hold", summary.cannot_hold),
      sentences("For who loads it", summary.notes),
      table(
        [
          { title: "parameter", of: ({ name }) => name },
          { title: "value", of: ({ value }) => value, digits: 6 },
          { title: "unit", of: ({ unit }) => unit },
        ],
        Object.entries(summary.parameters ?? {}).map(([name, value]) => ({ name, value, unit: summary.units?.[name] })),
        { caption: "Parameters, as the target calls them" },
      ),
    ];
  },
};
