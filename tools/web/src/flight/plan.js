// The path in two dimensions, from above and from the side, for browsers without WebGL.
import { element } from "../dom.js";
import { significant } from "../format.js";

import { placeOf } from "./flights.js";

const SIZE = 300;
const MARGIN = 34;
const MOST_POINTS = 1500;
const DEGREES = 180 / Math.PI;

function drawn(tag, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

// A view: across and up are columns, {low, high, label} of each in m.
function viewOf(title, flights, { across, up, square_m, marker }) {
  const span = Math.max(across.high - across.low, up.high - up.low, 4 * square_m) * 1.1;
  const scale = (SIZE - MARGIN) / span;
  const left = (across.high + across.low - span) / 2;
  const bottom = (up.high + up.low - span) / 2;
  const x = (value) => MARGIN + (value - left) * scale;
  const y = (value) => SIZE - MARGIN - (value - bottom) * scale;
  const grid = [];
  const ticks = (from) => {
    const first = Math.ceil(from / square_m);
    const count = Math.floor((from + span) / square_m) - first + 1;
    return Array.from({ length: count }, (_, k) => (first + k) * square_m);
  };
  const text = (value) => significant(Number(value.toFixed(9)), 4);
  for (const value of ticks(left)) {
    grid.push(drawn("line", { class: "grid", x1: x(value), x2: x(value), y1: y(bottom), y2: y(bottom + span) }));
    grid.push(drawn("text", { x: x(value), y: SIZE - MARGIN + 14, "text-anchor": "middle" }, text(value)));
  }
  for (const value of ticks(bottom)) {
    grid.push(drawn("line", { class: "grid", x1: x(left), x2: x(left + span), y1: y(value), y2: y(value) }));
    grid.push(drawn("text", { x: MARGIN - 4, y: y(value) + 4, "text-anchor": "end" }, text(value)));
  }
  const markers = flights.map((flight) => {
    const step = Math.max(1, Math.floor(flight.time.length / MOST_POINTS));
    const points = [];
    for (let k = 0; k < flight.time.length; k += step) {
      points.push(`${x(flight.column[across.column][k]).toFixed(1)},${y(flight.column[up.column][k]).toFixed(1)}`);
    }
    grid.push(drawn("polyline", { points: points.join(" "), class: `path series-${flight.index % 7}` }));
    return drawn("g", { class: `marker series-${flight.index % 7}` }, ...marker(flight));
  });
  const svg = drawn(
    "svg",
    { viewBox: `0 0 ${SIZE} ${SIZE}`, role: "img", "aria-label": title },
    ...grid,
    drawn("text", { x: (SIZE + MARGIN) / 2, y: SIZE - 4, "text-anchor": "middle" }, across.label),
    drawn("text", { x: 4, y: 12 }, up.label),
    ...markers,
  );
  return { figure: element("figure", {}, element("figcaption", {}, title), svg), markers, x, y };
}

const ARM = 11;  // of a drawn vehicle, whatever its size

/** The same interface as sceneOf() in scene.js. */
export function planOf(flights, player) {
  const { x, y, up, square_m } = placeOf(flights);
  const line = (x2, y2) => drawn("line", { x1: 0, y1: 0, x2, y2 });
  const above = viewOf("From above", flights, {
    across: { ...y, column: "y_m", label: "y / m (to the right)" },
    up: { ...x, column: "x_m", label: "x / m (ahead)" },
    square_m,
    marker: ({ summary }) => summary.vehicle_geometry.motors.map(({ ahead_m, right_m }) => {
      const { arm_m } = summary.vehicle_geometry;
      return line((ARM * right_m) / arm_m, (-ARM * ahead_m) / arm_m);
    }),
  });
  const side = viewOf("From the side", flights, {
    across: { ...x, column: "x_m", label: "x / m (ahead)" },
    up: { ...up, column: "altitude_m", label: "altitude / m" },
    square_m,
    marker: () => [line(ARM, 0), line(-ARM, 0)],
  });
  const shown = flights.map(() => [0, 0, 0]);
  player.listen(({ time_s }) => {
    const poses = flights.map((flight) => flight.pose(time_s));
    poses.forEach(({ x_m, y_m, altitude_m }, k) => (shown[k] = [x_m, y_m, altitude_m]));
    const put = (view, k, across_m, up_m, turned_rad) => {
      const place = `${view.x(across_m).toFixed(2)} ${view.y(up_m).toFixed(2)}`;
      view.markers[k].setAttribute("transform", `translate(${place}) rotate(${(turned_rad * DEGREES).toFixed(2)})`);
    };
    poses.forEach((pose, k) => {
      put(above, k, pose.y_m, pose.x_m, pose.yaw_rad);
      put(side, k, pose.x_m, pose.altitude_m, -pose.pitch_rad);
    });
  });
  const picture = element(
    "div",
    { class: "plan" },
    element("p", { class: "note" },
      "This browser shows no three dimensions (it has no WebGL), so the path is drawn from above and from the side."),
    element("div", { class: "views" }, above.figure, side.figure),
  );
  return { picture, tools: [], shown };
}
