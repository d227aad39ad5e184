// Several cells of a kind: how far they lie apart.
import { lineChart } from "../../chart.js";
import { element, note, section } from "../../dom.js";
import { table } from "../../table.js";

const nameOf = (one, k) => one.cell?.name || one.campaign?.name || `cell ${k + 1}`;

// Each cell's value over the mean of all.
function chart(spread, cells) {
  const drawn = Object.entries(spread).filter(([, { mean, values }]) => mean && values?.length === cells.length);
  return lineChart({
    title: "Each cell over the mean of all",
    x: { label: "cell", values: cells.map((_, k) => k), categories: cells.map(nameOf) },
    y: { label: "value over the mean" },
    lines: drawn.map(([name, { mean, values }]) => ({ label: name, values: values.map((value) => (typeof value === "number" ? value / mean : null)), points: true, size: 8 })),
    height: 260,
  });
}

export function spread(summary) {
  const { spread: found, cells } = summary;
  const rows = cells.map((one, k) => ({ one, name: nameOf(one, k) }));
  return section(
    "The cells together",
    table(
      [
        { title: "cell", of: ({ name }) => name },
        { title: "fit", of: ({ one }) => element("span", { class: `grade ${one.verdict?.grade ?? ""}` }, one.verdict?.grade ?? "–"), by: ({ one }) => one.verdict?.grade },
        { title: "rms / mV", of: ({ one }) => (typeof one.verdict?.rmse_V === "number" ? 1e3 * one.verdict.rmse_V : null) },
        { title: "mean error / %", of: ({ one }) => one.verdict?.mean_error_percent },
        { title: "error to expect / %", of: ({ one }) => one.expected_error_percent },
        { title: "alpha / Ah", of: ({ one }) => (typeof one.alpha_C === "number" ? one.alpha_C / 3600 : null) },
        { title: "converged", of: ({ one }) => (one.converged === false ? "no" : "yes") },
        { title: "cell file", of: ({ one }) => one.file },
      ],
      rows,
      { sort: true, caption: "The verdict on each" },
    ),
    found
      ? [
          table(
            [
              { title: "parameter", of: ({ name }) => name },
              { title: "mean", of: ({ mean }) => mean },
              { title: "standard deviation", of: (row) => row.standard_deviation },
              { title: "standard deviation / %", of: (row) => (row.mean ? (100 * row.standard_deviation) / Math.abs(row.mean) : null), digits: 3 },
              { title: "least", of: ({ least }) => least },
              { title: "most", of: ({ most }) => most },
            ],
            Object.entries(found).map(([name, row]) => ({ name, ...row })),
            { sort: true, caption: "Spread over the cells, in SI units; the mean error is in %" },
          ),
          chart(found, cells),
        ]
      : note("A spread needs two cells or more."),
  );
}
