// `lipoid ageing`: what changed between cells of several ages.
import { lineChart } from "../chart.js";
import { facts, note, section } from "../dom.js";
import { baseName, interval, plural } from "../format.js";
import { listOf, times } from "../numbers.js";
import { table } from "../table.js";

const WORDS = { capacity: "Capacity", beta: "beta of the diffusion" };
const words = (name) => WORDS[name] ?? name.replace(/^resistance_(\d+)s$/, "Resistance at half charge, after $1 s");

// Resistances are of milliohms.
const scaled = ({ unit, at }) => (unit === "Ohm" ? { unit: "mΩ", factor: 1e3, at } : { unit, factor: 1, at });

function overAges(quantity, ages) {
  const { unit, factor, at } = scaled(quantity);
  const ends = (side) => at.map(({ interval_95 }) => times(factor, interval_95?.[side]));
  const title = words(quantity.name);
  return section(title,
    lineChart({
      title: `${title}, over the ages`,
      x: { label: "age", values: ages.map((_, k) => k), categories: ages },
      y: { label: `${title.split(" ")[0]} / ${unit}`, zero: true },
      lines: [{ label: "estimate, with its 95 % interval", values: at.map(({ value }) => times(factor, value)), band: [ends(0), ends(1)], dots: true }],
      name: title,
      height: 220,
    }),
    table(
      [
        { title: "age", of: ({ age }) => age },
        { title: `estimate / ${unit}`, of: ({ value }) => times(factor, value) },
        { title: "95 % from", of: ({ interval_95 }) => times(factor, interval_95?.[0]) },
        { title: "to", of: ({ interval_95 }) => times(factor, interval_95?.[1]) },
        { title: "change / %", of: ({ change_percent, verdict }) => (verdict === "first" ? null : change_percent), digits: 3 },
        { title: "its 95 %", of: (row) => interval(row.change_interval_95_percent), class: "number" },
        { title: "verdict", of: ({ verdict }) => verdict },
      ],
      at.map((value, k) => ({ age: ages[k], ...value })),
    ));
}

export const ageing = {
  command: "ageing",
  title: () => "What changed from age to age",
  parts: ({ summary }) => {
    const cells = listOf(summary.cells);
    const ages = cells.map(({ file, age }) => age || baseName(file));
    return [
      facts([
        ["Cells", plural(cells.length, "cell")],
        ["Compared with", ages[0]],
      ]),
      note("A change is shown where the 95 % interval of the ratio of two ages leaves out 1; where it does not, there may be one all the same."),
      listOf(summary.quantities).map((quantity) => overAges(quantity, ages)),
      table(
        [
          { title: "age", of: ({ k }) => ages[k] },
          { title: "cell file", of: ({ file }) => file },
          { title: "describes its own logs", of: (cell) => (cell.poor_fit ? "no" : "yes") },
        ],
        cells.map((cell, k) => ({ ...cell, k })),
        { caption: "The cells" },
      ),
    ];
  },
};
