// A chart of lines, points, bars or bands over a common axis, by uPlot.
import uPlot from "uplot";

import { element, note } from "./dom.js";
import { significant } from "./format.js";
import { legend, nearest } from "./legend.js";
import { endOfGuide, hasRoom, printed } from "./picture.js";
import { saveMenu } from "./save.js";
import { colour, faint, onThemeChange, seriesColour } from "./theme.js";
import { timeAxis } from "./time_axis.js";
import { bindZoom, followZoom, isZoomed, resetZoom, sharedCursor } from "./zoom.js";

export { seriesColour };

const HEIGHT = 280;
const LEAST_WIDTH = 240;
const FONT = "12px system-ui, sans-serif";

// Beyond this no axis has ticks. Nothing that is measured comes near; a damaged summary might.
const MOST = 1e100;
const drawable = (value, log) => value !== null && Math.abs(value) < MOST && (!log || value > 0);

// What cannot be drawn is a gap, which uPlot knows as null.
function withGaps(values, log) {
  return values.every((value) => drawable(value, log)) ? values : Array.from(values, (value) => (drawable(value, log) ? value : null));
}

// Samples that have a place on the axis, in the order of x, the first of equal ones.
function ordered(xs, log) {
  const order = Array.from(xs.keys()).filter((k) => drawable(xs[k], log)).sort((a, b) => xs[a] - xs[b]);
  return order.filter((k, n) => n === 0 || xs[k] !== xs[order[n - 1]]);
}

// One table for all lines: [x, y of the first line, ...], the edges of a line's band right behind it.
function tableOf(x, lines, log) {
  const columnsOf = (line) => [line.values, ...(line.band ?? [])];
  if (lines.every((line) => !line.x) && x.values.every((value) => drawable(value, x.log))) {
    return [x.values, ...lines.flatMap((line) => columnsOf(line).map((ys) => withGaps(ys, log)))];
  }
  const tables = lines.map((line) => {
    const xs = line.x ?? x.values;
    const order = ordered(xs, x.log);
    const pick = (values) => order.map((k) => values[k]);
    return [pick(xs), ...columnsOf(line).map((ys) => withGaps(pick(ys), log))];
  });
  const joined = uPlot.join(tables);
  return joined.map((column) => Array.from(column, (value) => value ?? null));
}

// The next number below with one digit, from which uPlot counts the grid of a logarithmic axis.
function digitBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return Math.max(1, Math.floor(value / power + 1e-9)) * power;
}

// Where a chart has points or bars, those at its ends are not cut.
function padding(x, lines) {
  if (x.categories) return () => [-0.5, x.categories.length - 0.5];
  const also = x.include ?? [];
  const pad = lines.some((line) => line.points || line.dots || line.bars) ? 0.03 : 0;
  return (least, most) => {
    const [min, max] = [Math.min(least, ...also), Math.max(most, ...also)];
    if (min === max) return x.log ? [min / 2, min * 2] : [min - (Math.abs(min) || 1) / 2, min + (Math.abs(min) || 1) / 2];
    if (x.log) return [digitBelow(min / (max / min) ** pad), max * (max / min) ** pad];
    return [min - pad * (max - min), max + pad * (max - min)];
  };
}

function scaleOfY(y) {
  if (y.log) return { distr: 3 };
  const room = 1.08;
  if (y.zero && !y.reach) {
    return { range: (_, min, max) => (min === null ? [0, 1] : [Math.min(0, room * min), Math.max(0, room * max) || 1]) };
  }
  const end = (soft) => ({ pad: 0.08, soft, mode: soft === undefined ? 0 : 1 });
  const [low, high] = y.reach ?? [undefined, undefined];
  return { range: { min: end(low), max: end(high) } };
}

function axesOf(x, y, time) {
  const shared = {
    stroke: () => colour("--text"),
    grid: { stroke: () => colour("--grid"), width: 1 },
    ticks: { stroke: () => colour("--grid"), width: 1 },
    font: FONT,
    labelFont: FONT,
    labelSize: 20,
  };
  const numbers = (_, splits) => splits.map((value) => (value === null ? "" : significant(value, 6)));
  const names = (_, splits) => splits.map((value) => x.categories[value] ?? "");
  return [
    {
      ...shared,
      label: time?.label ?? x.label,
      size: 34,
      space: time?.values ? 80 : 60,
      ...(time?.incrs ? { incrs: time.incrs } : {}),
      ...(x.categories || x.whole ? { incrs: [1, 2, 5, 10, 20, 50, 100] } : {}),
      ...(x.log ? { filter: withRoom } : {}),
      values: x.categories ? names : time?.values ?? numbers,
    },
    { ...shared, ...(y.log ? { filter: withRoom, grid: { ...shared.grid, filter: fewLines } } : {}), label: y.label, size: (_, values) => sizeOf(values), values: numbers },
  ];
}

// Of the ticks of a logarithmic axis those whose numbers have room beside one another, powers of ten first.
function withRoom(plot, splits, axis, space) {
  const place = (value) => plot.valToPos(value, plot.axes[axis].scale);
  const rank = (value) => [1, 5, 2, 3, 7, 4, 6, 8, 9].indexOf(Number(value.toExponential()[0]));
  const taken = [];
  for (const value of [...splits].sort((a, b) => rank(a) - rank(b))) {
    if (taken.every((other) => Math.abs(place(other) - place(value)) >= space)) taken.push(value);
  }
  return splits.map((value) => (taken.includes(value) ? value : null));
}

// Over many decades the grid of a logarithmic axis has its powers of ten alone.
function fewLines(_, splits) {
  const decades = Math.log10(splits[splits.length - 1] / splits[0]);
  const power = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;
  return decades < 5 ? splits : splits.map((value) => (power(value) ? value : null));
}

// Room for the longest number beside the axis, at least as in other charts, so that they align.
function sizeOf(values) {
  const longest = Math.max(0, ...(values ?? []).map((value) => String(value ?? "").length));
  return Math.max(56, 18 + 7 * longest);
}

function pathsOf(line) {
  if (line.points) return () => null;
  if (line.bars) return uPlot.paths.bars({ size: [0.6, 60] });
  if (line.step) return uPlot.paths.stepped({ align: line.step === "before" ? -1 : 1 });
  return undefined;
}

// The lines as uPlot's series, with the edges of bands, and what the legend and the picture need.
function seriesOf(lines) {
  const series = [];
  const bands = [];
  const entries = [];
  lines.forEach((line, k) => {
    const index = series.length + 1;
    const number = line.colour ?? k;
    const stroke = () => seriesColour(number);
    series.push({
      label: line.label,
      scale: "y",
      show: line.show !== false,
      auto: line.scaled !== false,
      stroke,
      width: line.points ? 1 : line.width ?? 1.5,
      dash: line.dash,
      fill: line.bars ? () => faint(seriesColour(number), 0.6) : undefined,
      paths: pathsOf(line),
      spanGaps: Boolean(line.x) || line.spanGaps === true,
      points: line.points
        ? { show: true, size: line.size ?? 5, fill: line.hollow ? () => colour("--page") : stroke, stroke, width: line.hollow ? 2 : 1 }
        : line.dots ? { show: true, size: 6, fill: stroke, stroke, width: 1 } : { show: false },
    });
    const also = [];
    if (line.band) {
      const [low, high] = [index + 1, index + 2];
      for (const edge of [low, high]) {
        also.push(edge);
        series.push({ label: `${line.label}, ${edge === low ? "low" : "high"}`, scale: "y", stroke: "transparent",
                      width: 0, points: { show: false }, spanGaps: Boolean(line.x) });
      }
      bands.push({ series: [high, low], fill: () => faint(seriesColour(number)) });
    }
    entries.push({
      label: line.label,
      mark: line.points ? (line.hollow ? "dots hollow" : "dots") : line.bars ? "bar" : line.dash ? "dashed" : "line",
      colour: number,
      index,
      also,
      line,
      say: line.say ?? ((value) => significant(value, line.digits ?? 5)),
    });
  });
  return { series, bands, entries };
}

// Draws within the area of the chart.
function within(plot, draw) {
  const { ctx } = plot;
  const { left, top, width, height } = plot.bbox;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  draw(ctx, plot.bbox);
  ctx.restore();
}

// Stretches of x with a coloured ground.
function drawSpans(plot, spans) {
  within(plot, (ctx, { top, height }) => {
    for (const span of spans) {
      const from = plot.valToPos(span.from, "x", true);
      const to = plot.valToPos(span.to, "x", true);
      ctx.fillStyle = faint(seriesColour(span.colour), 0.16);
      ctx.fillRect(from, top, Math.max(1, to - from), height);
    }
  });
}

// Places of x and straight lines that the chart is marked with: over its grid, behind its samples.
function drawMarks(plot, marks, guides) {
  const at = ([x, y]) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
  within(plot, (ctx, { top, height }) => {
    const stroke = (from, to) => {
      ctx.beginPath();
      ctx.moveTo(...from);
      ctx.lineTo(...to);
      ctx.stroke();
    };
    ctx.setLineDash([4 * uPlot.pxRatio, 4 * uPlot.pxRatio]);
    ctx.lineWidth = uPlot.pxRatio;
    ctx.strokeStyle = colour("--text");
    for (const mark of marks) {
      const x = Math.round(plot.valToPos(mark.x, "x", true)) + 0.5;
      stroke([x, top], [x, top + height]);
    }
    ctx.strokeStyle = colour("--soft");
    ctx.fillStyle = colour("--soft");
    ctx.font = `${11 * uPlot.pxRatio}px system-ui, sans-serif`;
    // uPlot leaves them as its last axis had them.
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    const taken = [];
    for (const { from, to, label } of guides) {
      stroke(at(from), at(to));
      const end = endOfGuide(plot.scales, from, to);
      if (!end) continue;
      const [x, y] = at(end);
      if (hasRoom(taken, x, y, 11 * uPlot.pxRatio)) ctx.fillText(label, x + 4 * uPlot.pxRatio, y + 12 * uPlot.pxRatio);
    }
  });
}

// Circles about samples that something outside of the chart speaks of.
function drawRings(plot, rings) {
  within(plot, (ctx) => {
    ctx.lineWidth = 2 * uPlot.pxRatio;
    for (const { at, colour: number } of rings) {
      ctx.strokeStyle = seriesColour(number);
      ctx.beginPath();
      ctx.arc(plot.valToPos(at[0], "x", true), plot.valToPos(at[1], "y", true), 6 * uPlot.pxRatio, 0, 2 * Math.PI);
      ctx.stroke();
    }
  });
}

/**
 * @param title   words above the chart
 * @param x       {label, values, time, log, categories, whole, include}: the common axis; label carries the unit. `whole`: ticks at
 *                whole numbers alone. `include`: values that the axis shows in any case. `time`: values are seconds,
 *                shown as h:mm:ss where they are many. `categories`: names of the values 0, 1, ...
 * @param lines   [{label, values, x, points, hollow, dots, bars, step, band: [low, high], dash, width, colour, show, scaled, digits, say}]: one
 *                line each, values as long as x, or as its own x. `points`: samples alone, `hollow` as rings; `dots`: samples on
 *                their line. `scaled: false`: the scale of y does not follow the line. colour is the number of a colour of the palette. A value of
 *                null or NaN is a gap.
 * @param y       {label, log, zero, reach}; `zero`: the axis begins at zero; `reach`: [low, high] that it shows at least
 * @param link    charts with the same key zoom and show their cursor together
 * @param spans   [{from, to, colour}]: stretches of x with a coloured ground
 * @param marks   [{x}]: places of x with a dashed line
 * @param guides  [{from: [x, y], to: [x, y], label}]: straight lines behind the samples
 * @param rings   [{at: [x, y], colour}]: samples with a circle; figure.showRings(rings) changes them
 * @param name    of the files that it is saved as
 * @returns a figure, or a sentence where there is nothing to draw; its `plot` is uPlot's, its data-points the number of samples that it shows
 */
export function lineChart({ title, x, lines, y, link, spans = [], marks = [], guides = [], rings = [], name, height = HEIGHT }) {
  const data = tableOf(x, lines, y.log);
  if (data.length === 0 || data[0].length === 0) return note(`${title}: there is nothing to draw.`);
  const { series, bands, entries } = seriesOf(lines);
  const xs = data[0];
  const time = x.time ? timeAxis(xs[0], xs[xs.length - 1]) : null;
  const sayX = time?.say ?? (x.categories ? (value) => x.categories[value] : (value) => `${x.label.split(" / ")[0]} ${significant(value, 7)}`);
  const key = legend(entries, sayX);
  const holder = element("div", {
    class: "plot",
    tabindex: 0,
    role: "group",
    "aria-roledescription": "chart",
    "aria-label": `${title}: ${entries.map((entry) => entry.label).join(", ")} against ${x.label}. Arrow keys move the cursor.`,
  });
  const reset = element("button", { type: "button", hidden: true, onclick: () => resetZoom(plot) }, "Show all");
  const figure = element("figure", { class: "chart" });
  const pad = padding(x, lines);
  const about = { title, name: name ?? title, x, y, time, spans, marks, guides, rings };
  // uPlot asks for what someone zoomed to as well, which is left as it is.
  const rangeOfX = (_, min, max) => {
    if (min === null) return [0, 1];
    return min === xs[0] && max === xs[xs.length - 1] ? pad(min, max) : [min, max];
  };
  const options = {
    width: 800,
    height,
    legend: { show: false },
    // The last number of an axis may be half beyond its end.
    padding: [8, time?.values ? 28 : 12, 0, 0],
    cursor: {
      ...sharedCursor(link),
      dataIdx: (plot, k, index) => (k === 0 ? index : nearest(plot, k, index)),
      points: { size: 7, fill: (plot, k) => (entries.some(({ index, line }) => index === k && line.points) ? colour("--page") : plot.series[k]._stroke ?? "transparent") },
    },
    scales: {
      x: { time: false, distr: x.log ? 3 : 1, range: rangeOfX },
      y: scaleOfY(y),
    },
    axes: axesOf(x, y, time),
    series: [{ label: x.label }, ...series],
    bands,
    hooks: {
      drawClear: spans.length > 0 ? [(plot) => drawSpans(plot, spans)] : [],
      drawAxes: marks.length + guides.length > 0 ? [(plot) => drawMarks(plot, marks, guides)] : [],
      draw: [(plot) => drawRings(plot, about.rings)],
      setCursor: [(plot) => key.update(plot, document.activeElement === holder)],
      setScale: [
        (plot, which) => {
          if (which !== "x") return;
          followZoom(plot);
          reset.hidden = !isZoomed(plot);
        },
      ],
    },
  };
  const plot = new uPlot(options, data, (made, begin) => {
    holder.append(made.root);
    made.padded = pad;
    begin();
  });
  plot.entries = entries;
  bindZoom(plot, holder, link);
  key.bind(plot);
  figure.append(
    element("figcaption", {}, element("span", { class: "title" }, title),
            element("span", { class: "tools" }, reset, saveMenu(plot, about))),
    holder,
    key.root,
  );
  figure.plot = plot;
  figure.dataset.points = String(entries.reduce(
    (sum, entry) => sum + data[entry.index].reduce((n, value) => (value === null ? n : n + 1), 0), 0));
  figure.showRings = (shown) => {
    about.rings = shown;
    plot.redraw(false, false);
  };
  printed(figure, plot, about);
  const fit = () => {
    const width = Math.max(LEAST_WIDTH, holder.clientWidth);
    if (holder.clientWidth > 0 && width !== plot.width) plot.setSize({ width, height });
  };
  new ResizeObserver(fit).observe(holder);
  onThemeChange(() => plot.redraw(false));
  return figure;
}
