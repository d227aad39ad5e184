// A chart as a picture in the colours of paper: SVG for a report or for print, PNG for a slide. It
// shows what the chart shows, zoom and hidden lines included.
import { colour, faint, seriesColour } from "./theme.js";

const WIDTH = 720;
const FONT = "system-ui, sans-serif";
const PAPER = "paper";
const LEFT = 66;
const RIGHT = 14;
const SIZE = 12;

const ruler = document.createElement("canvas").getContext("2d");
function widthOf(text, size = SIZE) {
  ruler.font = `${size}px ${FONT}`;
  return ruler.measureText(text).width;
}

const round = (value) => Math.round(value * 10) / 10;

// From values to places: linear or logarithmic.
function mapping({ min, max, distr }, from, to) {
  const transform = distr === 3 ? Math.log : (value) => value;
  const [a, b] = [transform(min), transform(max)];
  return (value) => from + ((transform(value) - a) / (b - a)) * (to - from);
}

// A line through samples; of those that fall upon one half of a pixel the ends, the least and the
// largest.
function pathOf(xs, ys, toX, toY, range, spanGaps) {
  let d = "";
  let column = null;
  let drawing = false;
  const put = (x, y) => {
    d += `${drawing ? "L" : "M"}${round(x)} ${round(y)}`;
    drawing = true;
  };
  const flush = () => {
    if (!column) return;
    const { x, first, low, high, last } = column;
    for (const y of low === high ? [first] : [first, low, high, last]) put(x, y);
    column = null;
  };
  let n0 = 0;
  while (n0 + 1 < xs.length && xs[n0 + 1] < range.min) ++n0;
  for (let n = n0; n < xs.length; ++n) {
    if (ys[n] === null || ys[n] === undefined) {
      if (!spanGaps) {
        flush();
        drawing = false;
      }
      continue;
    }
    const x = Math.round(2 * toX(xs[n])) / 2;
    const y = toY(ys[n]);
    if (column && column.x === x) {
      column.low = Math.min(column.low, y);
      column.high = Math.max(column.high, y);
      column.last = y;
    } else {
      flush();
      column = { x, first: y, low: y, high: y, last: y };
    }
    if (xs[n] > range.max) break;
  }
  flush();
  return d;
}

function steppedPath(xs, ys, toX, toY, align) {
  let d = "";
  let before = null;
  xs.forEach((value, n) => {
    if (ys[n] === null) {
      before = null;
      return;
    }
    const [x, y] = [round(toX(value)), round(toY(ys[n]))];
    if (before === null) d += `M${x} ${y}`;
    else d += align < 0 ? `V${y}H${x}` : `H${x}V${y}`;
    before = y;
  });
  return d;
}

function pointsPath(xs, ys, toX, toY, range, radius) {
  let d = "";
  for (let n = 0; n < xs.length; ++n) {
    if (ys[n] === null || ys[n] === undefined || xs[n] < range.min || xs[n] > range.max) continue;
    d += `M${round(toX(xs[n]) - radius)} ${round(toY(ys[n]))}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0 ${-2 * radius} 0`;
  }
  return d;
}

function bandPath(xs, low, high, toX, toY) {
  const at = Array.from(xs.keys()).filter((n) => low[n] !== null && high[n] !== null && low[n] !== undefined);
  if (at.length === 0) return "";
  const there = at.map((n) => `${round(toX(xs[n]))} ${round(toY(high[n]))}`);
  const back = at.reverse().map((n) => `${round(toX(xs[n]))} ${round(toY(low[n]))}`);
  return `M${there.join("L")}L${back.join("L")}Z`;
}

// Ticks as the chart on the screen has them; its ends where it was never drawn.
function ticksOf(plot, k) {
  const axis = plot.axes[k];
  const scale = plot.scales[k === 0 ? "x" : "y"];
  const splits = axis._splits ?? [scale.min, scale.max];
  const values = axis._values ?? splits.map(String);
  return axis.grid.filter(plot, splits)
    .map((value, n) => ({ value, text: values[n] === null || values[n] === undefined ? "" : String(values[n]) }))
    .filter(({ value }) => value !== null && value >= scale.min && value <= scale.max);
}

function legendRows(entries) {
  const rows = [[]];
  let x = LEFT;
  for (const entry of entries) {
    const width = 26 + widthOf(entry.label) + 18;
    if (x + width > WIDTH && rows[rows.length - 1].length > 0) {
      rows.push([]);
      x = LEFT;
    }
    rows[rows.length - 1].push({ entry, x });
    x += width;
  }
  return rows;
}

/** Where a guide ends within the scales: at its end, or where it leaves them; null where it is not to be seen. */
export function endOfGuide({ x, y }, from, to) {
  const inside = (t) => {
    const [a, b] = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
    return a >= x.min && a <= x.max && b >= y.min && b <= y.max ? [a, b] : null;
  };
  for (let t = 1; t > 0; t -= 0.02) {
    const end = inside(t);
    if (end) return end;
  }
  return null;
}

/** Whether a short label there is clear of those before it; `taken` remembers it then. */
export function hasRoom(taken, x, y, size) {
  if (taken.some(([a, b]) => Math.abs(x - a) < 2.2 * size && Math.abs(y - b) < 1.2 * size)) return false;
  taken.push([x, y]);
  return true;
}

/** The shapes of a picture: {width, height, area, shapes: [{path | text, ...}]}. */
export function drawing(plot, { title, x, y, time, spans, marks, guides = [], rings = [] }, body) {
  const shapes = [];
  const text = (content, at, more = {}) => shapes.push({ text: content, size: SIZE, fill: colour("--text", PAPER), anchor: "start", ...at, ...more });
  const path = (d, more) => d && shapes.push({ path: d, ...more });
  const shown = plot.entries.filter((entry) => plot.series[entry.index].show);
  const rows = legendRows(shown);
  const top = 30;
  const bottom = top + body;
  const height = bottom + 44 + 18 * rows.length;
  const area = { left: LEFT, top, width: WIDTH - LEFT - RIGHT, height: body };
  const range = plot.scales.x;
  const toX = mapping(range, area.left, area.left + area.width);
  const toY = mapping(plot.scales.y, bottom, top);
  const right = area.left + area.width;

  text(title, { x: LEFT, y: 18 }, { bold: true, size: 14 });
  for (const span of spans) {
    const [from, to] = [toX(Math.max(span.from, range.min)), toX(Math.min(span.to, range.max))];
    if (to > from) path(`M${round(from)} ${top}H${round(to)}V${bottom}H${round(from)}Z`, { fill: faint(seriesColour(span.colour, PAPER), 0.16), clip: true });
  }
  const grid = { stroke: colour("--grid", PAPER), width: 1 };
  for (const { value, text: words } of ticksOf(plot, 0)) {
    path(`M${round(toX(value))} ${top}V${bottom + 4}`, grid);
    text(words, { x: toX(value), y: bottom + 17 }, { anchor: "middle" });
  }
  for (const { value, text: words } of ticksOf(plot, 1)) {
    path(`M${area.left - 4} ${round(toY(value))}H${right}`, grid);
    text(words, { x: area.left - 7, y: toY(value) + 4 }, { anchor: "end" });
  }
  text(time?.label ?? x.label, { x: area.left + area.width / 2, y: bottom + 34 }, { anchor: "middle" });
  text(y.label, { x: 12, y: top + body / 2 }, { anchor: "middle", turned: true });
  for (const mark of marks) path(`M${round(toX(mark.x))} ${top}V${bottom}`, { stroke: colour("--text", PAPER), width: 1, dash: [4, 4], clip: true });
  const taken = [];
  for (const { from, to, label } of guides) {
    path(`M${round(toX(from[0]))} ${round(toY(from[1]))}L${round(toX(to[0]))} ${round(toY(to[1]))}`, { stroke: colour("--soft", PAPER), width: 1, dash: [4, 4], clip: true });
    const end = endOfGuide(plot.scales, from, to);
    if (end && hasRoom(taken, toX(end[0]), toY(end[1]), 10)) text(label, { x: toX(end[0]) + 4, y: toY(end[1]) + 12 }, { size: 10, fill: colour("--soft", PAPER) });
  }
  const xs = plot.data[0];
  for (const { index, also, line, colour: number } of shown) {
    const stroke = seriesColour(number, PAPER);
    const ys = plot.data[index];
    if (also.length > 0) path(bandPath(xs, plot.data[also[0]], plot.data[also[1]], toX, toY), { fill: faint(stroke), clip: true });
    if (line.points) {
      const dots = pointsPath(xs, ys, toX, toY, range, (line.size ?? 5) / 2);
      path(dots, line.hollow ? { fill: colour("--page", PAPER), stroke, width: 2, clip: true } : { fill: stroke, clip: true });
    } else if (line.bars) {
      const half = Math.min(30, (0.3 * area.width) / Math.max(1, xs.length));
      const base = toY(Math.max(plot.scales.y.min, 0));
      xs.forEach((value, n) => ys[n] !== null && path(`M${round(toX(value) - half)} ${round(base)}V${round(toY(ys[n]))}h${round(2 * half)}V${round(base)}Z`, { fill: stroke, clip: true }));
    } else {
      const d = line.step
        ? steppedPath(Array.from(xs), ys, toX, toY, line.step === "before" ? -1 : 1)
        : pathOf(xs, ys, toX, toY, range, plot.series[index].spanGaps);
      path(d, { stroke, width: line.width ?? 1.5, dash: line.dash, clip: true });
      if (line.dots) path(pointsPath(xs, ys, toX, toY, range, 3), { fill: stroke, clip: true });
    }
  }
  for (const { at, colour: number } of rings) {
    const stroke = seriesColour(number, PAPER);
    path(`M${round(toX(at[0]) - 6)} ${round(toY(at[1]))}a6 6 0 1 0 12 0a6 6 0 1 0 -12 0`, { stroke, width: 2, clip: true });
  }
  path(`M${area.left} ${top}V${bottom}H${right}`, { stroke: colour("--text", PAPER), width: 1 });
  rows.forEach((row, n) => {
    const at = bottom + 54 + 18 * n;
    for (const { entry, x: from } of row) {
      const stroke = seriesColour(entry.colour, PAPER);
      if (entry.line.points) path(`M${from + 6} ${at - 4}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0`, entry.line.hollow ? { stroke, width: 2 } : { fill: stroke });
      else path(`M${from} ${at - 4}h20`, { stroke, width: entry.mark === "bar" ? 8 : 2.5, dash: entry.line.dash });
      text(entry.label, { x: from + 26, y: at });
    }
  });
  return { width: WIDTH, height, area, shapes };
}

const SVG = "http://www.w3.org/2000/svg";
let clips = 0;

/** The picture as an SVG element. */
export function toSvg({ width, height, area, shapes }, title) {
  const make = (tag, attributes, text) => {
    const node = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (value !== undefined) node.setAttribute(name, String(value));
    }
    if (text !== undefined) node.textContent = text;
    return node;
  };
  const clip = `area-${++clips}`;
  const svg = make("svg", { xmlns: SVG, viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "font-family": FONT });
  svg.append(make("title", {}, title));
  const frame = make("clipPath", { id: clip });
  frame.append(make("rect", { x: area.left, y: area.top, width: area.width, height: area.height }));
  svg.append(frame);
  for (const shape of shapes) {
    svg.append(
      shape.path !== undefined
        ? make("path", {
            d: shape.path,
            fill: shape.fill ?? "none",
            stroke: shape.stroke ?? "none",
            "stroke-width": shape.width,
            "stroke-linejoin": "round",
            "stroke-dasharray": shape.dash?.join(" "),
            "clip-path": shape.clip ? `url(#${clip})` : undefined,
          })
        : make(
            "text",
            {
              x: round(shape.x),
              y: round(shape.y),
              fill: shape.fill,
              "font-size": shape.size,
              "font-weight": shape.bold ? "bold" : undefined,
              "text-anchor": shape.anchor,
              transform: shape.turned ? `rotate(-90 ${round(shape.x)} ${round(shape.y)})` : undefined,
            },
            shape.text,
          ),
    );
  }
  return svg;
}

/** The picture as a PNG, twice as fine as on the screen. */
export function toPng({ width, height, area, shapes }) {
  const canvas = document.createElement("canvas");
  const fine = 2;
  canvas.width = fine * width;
  canvas.height = fine * height;
  const ctx = canvas.getContext("2d");
  ctx.scale(fine, fine);
  ctx.fillStyle = colour("--page", PAPER);
  ctx.fillRect(0, 0, width, height);
  const anchors = { start: "left", middle: "center", end: "right" };
  for (const shape of shapes) {
    ctx.save();
    if (shape.clip) {
      ctx.beginPath();
      ctx.rect(area.left, area.top, area.width, area.height);
      ctx.clip();
    }
    if (shape.path !== undefined) {
      const path = new Path2D(shape.path);
      ctx.lineJoin = "round";
      ctx.setLineDash(shape.dash ?? []);
      if (shape.fill) {
        ctx.fillStyle = shape.fill;
        ctx.fill(path);
      }
      if (shape.stroke) {
        ctx.strokeStyle = shape.stroke;
        ctx.lineWidth = shape.width;
        ctx.stroke(path);
      }
    } else {
      ctx.font = `${shape.bold ? "bold " : ""}${shape.size}px ${FONT}`;
      ctx.fillStyle = shape.fill;
      ctx.textAlign = anchors[shape.anchor];
      ctx.translate(shape.x, shape.y);
      if (shape.turned) ctx.rotate(-Math.PI / 2);
      ctx.fillText(shape.text, 0, 0);
    }
    ctx.restore();
  }
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

const onPaper = [];

/** On paper the chart is its picture: sharp, as wide as the sheet, and dark on white. */
export function printed(figure, plot, about) {
  onPaper.push({ figure, plot, about });
}

addEventListener("beforeprint", () => {
  for (const { figure, plot, about } of onPaper) {
    figure.querySelector(".printed")?.remove();
    const svg = toSvg(drawing(plot, about, 0.8 * plot.height), about.title);
    svg.classList.add("printed");
    figure.append(svg);
  }
});
addEventListener("afterprint", () => document.querySelectorAll(".printed").forEach((svg) => svg.remove()));
