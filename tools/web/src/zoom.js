// Zoom, pan and cursor of charts, by mouse and keyboard; charts of one link follow each other.

const groups = new Map();

const extent = (plot) => [plot.data[0][0], plot.data[0][plot.data[0].length - 1]];

/** The whole range of x that a chart shows when nothing is zoomed. */
export function wholeRange(plot) {
  const [first, last] = extent(plot);
  const group = plot.group ? [...plot.group] : [plot];
  const ends = group.map((each) => each.padded(...extent(each)));
  if (group.length === 1) return plot.padded(first, last);
  return [Math.min(...ends.map((end) => end[0])), Math.max(...ends.map((end) => end[1]))];
}

/** Shows this part of x, as far as there is any. */
export function zoomTo(plot, min, max) {
  const [lo, hi] = wholeRange(plot);
  const width = Math.min(max - min, hi - lo);
  if (!(width > 0)) return;
  const from = Math.max(lo, Math.min(min, hi - width));
  plot.setScale("x", { min: from, max: from + width });
}

/** Shows all of x. */
export function resetZoom(plot) {
  const [min, max] = wholeRange(plot);
  plot.setScale("x", { min, max });
}

/** Whether a part of x is out of sight. */
export function isZoomed(plot) {
  const [lo, hi] = wholeRange(plot);
  const { min, max } = plot.scales.x;
  return max - min < (hi - lo) * (1 - 1e-9);
}

// On a logarithmic axis equal steps are equal factors.
function along(plot, min, max, shift, factor, centre) {
  const log = plot.scales.x.distr === 3;
  const to = log ? Math.log : (value) => value;
  const back = log ? Math.exp : (value) => value;
  const [a, b, c] = [to(min), to(max), to(centre)];
  const offset = shift * (b - a);
  return [back(c + (a - c) * factor + offset), back(c + (b - c) * factor + offset)];
}

function change(plot, { shift = 0, factor = 1, centre }) {
  const { min, max } = plot.scales.x;
  zoomTo(plot, ...along(plot, min, max, shift, factor, centre ?? (min + max) / 2));
}

function cursorX(plot) {
  const { idx } = plot.cursor;
  const x = idx === null || idx === undefined ? undefined : plot.data[0][idx];
  return x >= plot.scales.x.min && x <= plot.scales.x.max ? x : undefined;
}

// To the next sample, or so many that the cursor moves by a pixel or two.
function moveCursor(plot, direction) {
  const xs = plot.data[0];
  const { min, max } = plot.scales.x;
  const at = cursorX(plot) === undefined ? plot.valToIdx(direction > 0 ? min : max) : plot.cursor.idx;
  const least = (max - min) / 200;
  let next = at + direction;
  while (next > 0 && next < xs.length - 1 && Math.abs(xs[next] - xs[at]) < least) next += direction;
  placeCursor(plot, Math.max(0, Math.min(xs.length - 1, next)));
}

function placeCursor(plot, index) {
  const x = plot.data[0][index];
  const { min, max } = plot.scales.x;
  if (x < min || x > max) zoomTo(plot, x - (max - min) / 2, x + (max - min) / 2);
  plot.setCursor({ left: plot.valToPos(x, "x"), top: plot.over.clientHeight / 2 }, true, true);
}

const KEYS = {
  ArrowLeft: (plot, shift) => (shift ? change(plot, { shift: -0.25 }) : moveCursor(plot, -1)),
  ArrowRight: (plot, shift) => (shift ? change(plot, { shift: 0.25 }) : moveCursor(plot, 1)),
  Home: (plot) => placeCursor(plot, 0),
  End: (plot) => placeCursor(plot, plot.data[0].length - 1),
  "+": (plot) => change(plot, { factor: 0.5, centre: cursorX(plot) }),
  "=": (plot) => change(plot, { factor: 0.5, centre: cursorX(plot) }),
  "-": (plot) => change(plot, { factor: 2, centre: cursorX(plot) }),
  0: resetZoom,
  Escape: resetZoom,
};

/** What the keys do, for the help on the page. */
export const HELP =
  "Drag over a chart to zoom; double-click or press 0 to see all again. With Shift held, dragging moves along the axis; " +
  "with Ctrl held, the wheel zooms. A chart that has the focus takes the keys: left and right move the cursor, with Shift the " +
  "axis, + and - zoom. Charts of one log move together. A click on a name in the legend hides its line.";

function bindKeys(plot, holder) {
  holder.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey || event.target !== holder) return;
    event.preventDefault();
    act(plot, event.shiftKey);
  });
}

function bindPointer(plot) {
  const { over } = plot;
  over.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey) return;  // the page scrolls
      event.preventDefault();
      change(plot, { factor: event.deltaY > 0 ? 1.25 : 0.8, centre: plot.posToVal(event.offsetX, "x") });
    },
    { passive: false },
  );
  over.addEventListener(
    "mousedown",
    (down) => {
      if (!down.shiftKey || down.button !== 0) return;
      down.preventDefault();
      down.stopImmediatePropagation();
      const { min, max } = plot.scales.x;
      const move = (event) => {
        const shift = (down.clientX - event.clientX) / over.clientWidth;
        zoomTo(plot, ...along(plot, min, max, shift, 1, min));
      };
      const end = () => {
        removeEventListener("mousemove", move);
        removeEventListener("mouseup", end);
      };
      addEventListener("mousemove", move);
      addEventListener("mouseup", end);
    },
    { capture: true },
  );
}

/** uPlot's options for a cursor shared by the charts of a link. */
export function sharedCursor(link) {
  return {
    drag: { x: true, y: false, dist: 4 },
    sync: link
      ? {
          key: link,
          setSeries: false,
          scales: ["x", null],
          filters: { pub: (type) => type === "mousemove" || type === "mouseleave" },
        }
      : undefined,
  };
}

/** Gives a chart its keys and its wheel, and joins it to those of the same link. */
export function bindZoom(plot, holder, link) {
  if (link) {
    if (!groups.has(link)) groups.set(link, new Set());
    plot.group = groups.get(link);
    plot.group.add(plot);
  }
  bindKeys(plot, holder);
  bindPointer(plot);
}

/**
 * To be called when the scale of x of a chart has changed: the others of its link follow. They do so later, and then call
 * this too, but for the range that the group has already.
 */
export function followZoom(plot) {
  const { group } = plot;
  if (!group) return;
  const { min, max } = plot.scales.x;
  if (group.min === min && group.max === max) return;
  group.min = min;
  group.max = max;
  for (const other of group) {
    if (other !== plot) other.setScale("x", { min, max });
  }
}
