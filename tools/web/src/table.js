// Tables: words to the left, numbers to the right.
import { element } from "./dom.js";
import { significant } from "./format.js";

const text = (value, digits) => {
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return String(value);
  if (typeof value === "number") return significant(value, digits);
  return value === null || value === undefined || value === "" ? "–" : value;
};

// Numbers by size, words by the alphabet, what is missing last.
function order(a, b) {
  const missing = (value) => value === null || value === undefined || Number.isNaN(value);
  if (missing(a) || missing(b)) return Number(missing(a)) - Number(missing(b));
  if (typeof a === "number" && typeof b === "number") return a - b;
  return String(a).localeCompare(String(b), "en", { numeric: true });
}

function sortable(head, body, columns, rows, made) {
  let by = null;
  let up = true;
  head.querySelectorAll("th").forEach((cell, k) => {
    const button = element("button", { type: "button", title: "Sort by this column" }, ...cell.childNodes);
    button.addEventListener("click", () => {
      up = by === k ? !up : true;
      by = k;
      const value = (row) => (columns[k].by ?? columns[k].of)(row);
      const sorted = rows.map((row, n) => ({ row, n }));
      sorted.sort((a, b) => {
        const [x, y] = [value(a.row), value(b.row)];
        const gone = (v) => v === null || v === undefined;
        return (up || gone(x) || gone(y) ? order(x, y) : order(y, x)) || a.n - b.n;
      });
      body.append(...sorted.map(({ n }) => made[n]));
      head.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
      cell.setAttribute("aria-sort", up ? "ascending" : "descending");
    });
    cell.append(button);
  });
}

/**
 * @param columns  [{title, of: row => number, text or element, digits, by: row => what it sorts by, class}]; the first one names
 *                 the row
 * @param sort     whether a click on a header sorts
 * @param caption  words above the table
 */
export function table(columns, rows, { sort = false, caption } = {}) {
  const cell = (column, row, k) => {
    const value = column.of(row);
    const kind = [typeof value === "number" ? "number" : "", column.class ?? ""].join(" ").trim();
    return element(k === 0 ? "th" : "td", { scope: k === 0 ? "row" : null, class: kind || null }, text(value, column.digits));
  };
  const numeric = (column) => rows.length > 0 && rows.some((row) => typeof column.of(row) === "number");
  const head = element(
    "tr",
    {},
    ...columns.map((column) => element("th", { scope: "col", class: numeric(column) ? "number" : null }, column.title)),
  );
  const made = rows.map((row) => element("tr", {}, ...columns.map((column, k) => cell(column, row, k))));
  const body = element("tbody", {}, ...made);
  if (sort && rows.length > 1) sortable(head, body, columns, rows, made);
  return element(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": caption ?? columns[0].title },
    element("table", {}, caption ? element("caption", {}, caption) : null, element("thead", {}, head), body),
  );
}
