// Tables: words to the left, numbers to the right.
import { element } from "./dom.js";
import { significant } from "./format.js";

/** columns: [{title, of: row => number or text}]. */
export function table(columns, rows) {
  const cell = (value) =>
    typeof value === "number"
      ? element("td", { class: "number" }, significant(value))
      : element("td", {}, value ?? "–");
  return element(
    "div",
    { class: "scroll" },
    element(
      "table",
      {},
      element("thead", {}, element("tr", {}, ...columns.map(({ title }) => element("th", { scope: "col" }, title)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, ...columns.map(({ of }) => cell(of(row)))))),
    ),
  );
}
