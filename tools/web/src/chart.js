// A chart of lines or points over a common axis, by uPlot.
import uPlot from "uplot";

import { element } from "./dom.js";
import { significant } from "./format.js";

const HEIGHT = 280;

// Okabe and Ito's palette: told apart by people who are colour-blind. The page's style sheet has
// lighter ones for a dark page (--series-0 ...).
export function seriesColour(index) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--series-${index % 7}`).trim();
}

/**
 * @param title   words above the chart
 * @param x       {label, values, time}: the common axis; label carries the unit
 * @param lines   [{label, values, points, band: [low, high], dash}]: one line each, values as long as x
 * @param y       {label, log}
 * @param link    charts with the same key zoom and show their cursor together
 */
export function lineChart({ title, x, lines, y, link, height = HEIGHT }) {
  const holder = element("figure", { class: "chart" }, element("figcaption", {}, title));
  const options = {
    width: 800,
    height,
    cursor: link ? { sync: { key: link } } : {},
    scales: { x: { time: false, distr: x.log ? 3 : 1 }, y: { distr: y.log ? 3 : 1 } },
    axes: [
      { label: x.label, stroke: "currentColor" },
      { label: y.label, stroke: "currentColor", size: 70 },
    ],
    series: [
      { label: x.label, value: (_, value) => significant(value, 6) },
      ...lines.map((line, k) => ({
        label: line.label,
        stroke: seriesColour(k),
        dash: line.dash,
        paths: line.points ? () => null : undefined,
        points: line.points ? { show: true, size: 5 } : { show: false },
        value: (_, value) => significant(value, 5),
      })),
    ],
  };
  const plot = new uPlot(options, [x.values, ...lines.map((line) => line.values)], holder);
  const fit = () => plot.setSize({ width: Math.max(280, holder.clientWidth), height });
  new ResizeObserver(fit).observe(holder);
  return holder;
}
