// The legend of a chart: what each line is, its value under the cursor, and a button that hides it.
import { element } from "./dom.js";

const NEAR_PX = 24;

/** The sample of a line nearest to the cursor: gaps are passed over, but not far. */
export function nearest(plot, k, index) {
  if (index === null || index === undefined) return null;
  const values = plot.data[k];
  if (values[index] !== null && values[index] !== undefined) return index;
  const xs = plot.data[0];
  const at = plot.valToPos(xs[index], "x");
  const seek = (step) => {
    for (let n = index + step; n >= 0 && n < xs.length; n += step) {
      if (Math.abs(plot.valToPos(xs[n], "x") - at) > NEAR_PX) return null;
      if (values[n] !== null && values[n] !== undefined) return n;
    }
    return null;
  };
  const [before, after] = [seek(-1), seek(1)];
  if (before === null || after === null) return before ?? after;
  return xs[index] - xs[before] < xs[after] - xs[index] ? before : after;
}

function swatch(entry) {
  const mark = element("span", { class: `swatch ${entry.mark}`, "aria-hidden": "true" });
  mark.style.setProperty("--colour", `var(--series-${entry.colour % 7})`);
  return mark;
}

/**
 * @param entries  [{label, mark, colour, index, also: [indices of its band], say: value => text}]
 * @param sayX     words for a value of x
 * @returns {root, bind(plot), update(plot)}
 */
export function legend(entries, sayX) {
  const spoken = element("span", { class: "spoken", "aria-live": "polite" });
  const x = element("span", { class: "at" });
  const rows = entries.map((entry) => {
    const value = element("output", {});
    const button = element(
      "button",
      { type: "button", "aria-pressed": "true", title: "Hide or show this line" },
      swatch(entry),
      entry.label,
    );
    return { entry, value, button, root: element("span", { class: "entry" }, button, value) };
  });
  const root = element("div", { class: "legend" }, ...rows.map((row) => row.root), x, spoken);
  const bind = (plot) => {
    for (const { entry, button } of rows) {
      button.addEventListener("click", () => {
        const show = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(show));
        plot.batch(() => [entry.index, ...entry.also].forEach((k) => plot.setSeries(k, { show })));
      });
    }
  };
  const update = (plot, focused) => {
    const { idx } = plot.cursor;
    const inside = idx !== null && idx !== undefined;
    x.textContent = inside ? `at ${sayX(plot.data[0][idx])}` : "";
    const words = [];
    for (const { entry, value } of rows) {
      const near = nearest(plot, entry.index, idx);
      value.textContent = near === null ? "" : entry.say(plot.data[entry.index][near]);
      if (value.textContent) words.push(`${entry.label} ${value.textContent}`);
    }
    spoken.textContent = inside && focused ? `${x.textContent}: ${words.join(", ")}` : "";
  };
  return { root, bind, update };
}
