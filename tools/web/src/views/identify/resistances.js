// r_s(A), r_j(A) with their 95 % bands.
import { lineChart } from "../../chart.js";
import { bandOf, resistanceCurve } from "../../curves.js";
import { element, note, section } from "../../dom.js";
import { significant } from "../../format.js";
import { isNumber, listOf, times } from "../../numbers.js";
import { table } from "../../table.js";

// What is small in ohm is shown in mOhm.
const MILLI = 1e3;

function timeOf(branch) {
  if (typeof branch.time_constant_s === "number") return `, tau ${significant(branch.time_constant_s)} s`;
  if (typeof branch.resistance_Ohm === "number" && typeof branch.capacitance_F === "number")
    return `, tau ${significant(branch.resistance_Ohm * branch.capacitance_F)} s`;
  return "";
}

// What the voltage falls by after a step of the current, as a pulse test has it.
function falls({ edges }) {
  const rows = listOf(edges);
  if (rows.length === 0) return null;
  return table(
    [
      { title: "after / s", of: ({ after_s }) => after_s },
      { title: "charge / %", of: ({ soc: [from, to] }) => `${significant(100 * from)} to ${significant(100 * to)}`, class: "number" },
      { title: "steps", of: (one) => one.edges },
      { title: "by the logs / mΩ", of: ({ measured_Ohm }) => times(MILLI, measured_Ohm), digits: 3 },
      { title: "by the cell / mΩ", of: ({ cell_Ohm }) => times(MILLI, cell_Ohm), digits: 3 },
      { title: "off by / %", of: ({ ratio }) => (isNumber(ratio) ? 100 * (ratio - 1) : null), digits: 2 },
    ],
    rows,
    { caption: "Fall of the voltage after steps of the current: medians" },
  );
}

export function resistances({ summary, key }) {
  const { cell } = summary;
  if (!cell) return null;
  const all = [
    { name: "r_s", words: "series resistance r_s", value: cell.series_resistance_Ohm },
    ...(cell.branches ?? []).map((branch, k) => ({ name: `r_${k + 1}`, words: `branch ${k + 1}, r_${k + 1}${timeOf(branch)}`, value: branch.resistance_Ohm })),
    ...(cell.charge_transfer ? [{ name: "r_ct", words: `charge transfer r_ct, i_0 ${significant(cell.charge_transfer.current_A)} A`, value: cell.charge_transfer.resistance_Ohm }] : []),
  ].filter(({ value }) => value !== null && value !== undefined);
  const staged = summary.staged?.stages?.pulses?.parameters ?? {};
  const chart = ({ name, words, value }, k) => {
    const curve = resistanceCurve(value);
    const band = bandOf(cell.uncertainty, name, curve, { positive: true });
    const scale = (values) => values.map((each) => (each === null ? null : MILLI * each));
    const lines = [{ label: words, values: scale(curve.values), band: band?.map(scale), colour: k, width: 2 }];
    if (typeof staged[name] === "number") lines.push({ label: `staged ${name}`, values: curve.soc.map(() => MILLI * staged[name]), colour: 6, dash: [6, 4] });
    return lineChart({
      title: words.charAt(0).toUpperCase() + words.slice(1),
      name: `${key} ${name}`,
      x: { label: "state of charge A", values: curve.soc },
      y: { label: "resistance / mΩ", zero: true },
      lines,
      height: 240,
      link: `${key} resistances`,
    });
  };
  return section(
    "Resistances over the state of charge",
    note("The band holds the resistance in 95 % of cases; where it is missing the logs say nothing of that state of charge, or the value stands at a bound. " +
         "A straight line is a resistance that does not depend on it."),
    element("div", { class: "columns" }, all.map(chart)),
    falls(summary),
  );
}
