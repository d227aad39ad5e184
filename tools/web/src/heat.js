// A matrix of numbers from -1 to 1 as a table whose cells are coloured: blue below zero, orange above.
import { element } from "./dom.js";
import { faint, onThemeChange, seriesColour } from "./theme.js";

const NEGATIVE = 0;
const POSITIVE = 1;

function paint(cell, value) {
  const strength = Math.min(1, Math.abs(value));
  cell.style.backgroundColor = Number.isFinite(value)
    ? faint(seriesColour(value < 0 ? NEGATIVE : POSITIVE), 0.55 * strength)
    : "";
}

/** names of rows and columns, and rows of numbers; null or NaN is shown as "–". */
export function heatMap(names, rows, caption) {
  const painted = [];
  const cellOf = (row, k, n) => {
    const value = row[n];
    const known = typeof value === "number" && Number.isFinite(value);
    const cell = element(
      "td",
      { title: known ? `${names[k]} and ${names[n]}: ${value.toFixed(4)}` : null },
      known ? value.toFixed(2).replace("-0.00", "0.00") : "–",
    );
    painted.push([cell, known ? value : NaN]);
    return cell;
  };
  const table = element(
    "table",
    { class: "heat" },
    element("caption", {}, caption),
    element("thead", {}, element("tr", {}, element("td", {}), names.map((name) => element("th", { scope: "col" }, name)))),
    element(
      "tbody",
      {},
      rows.map((row, k) =>
        element("tr", {}, element("th", { scope: "row" }, names[k]), names.map((_, n) => cellOf(row, k, n)))),
    ),
  );
  const paintAll = () => painted.forEach(([cell, value]) => paint(cell, value));
  paintAll();
  onThemeChange(paintAll);
  return element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": caption }, table);
}
