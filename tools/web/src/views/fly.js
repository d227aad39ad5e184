// `lipoid fly`: flights over one another, in three dimensions and in charts that keep their time.
import { element, notice, section } from "../dom.js";
import { controlsOf, listenToKeys, stepsOf } from "../flight/controls.js";
import { tieCharts } from "../flight/chart_time.js";
import { flightCharts } from "../flight/flight_charts.js";
import { flightOf, namesOf, troubleOf } from "../flight/flights.js";
import { planOf } from "../flight/plan.js";
import { Player, wantsLessMotion } from "../flight/player.js";
import { listOf } from "../numbers.js";
import { table } from "../table.js";

// What is read off while it plays, at most so often.
const READ_EVERY_MS = 100;

let sections = 0;

const root = (square, factor = 1) => (typeof square === "number" ? factor * Math.sqrt(square) : null);
const percent = (share) => (typeof share === "number" ? 100 * share : null);

const RESULTS = [
  ["outcome", (s) => troubleOf(s) || s.outcome],
  ["simulated / s", (s) => s.simulated_s],
  ["altitude error, root mean square / mm", (s) => root(s.mse_altitude_m2, 1e3)],
  ["pitch error, root mean square / degrees", (s) => root(s.mse_pitch_deg2)],
  ["position error, root mean square / m", (s) => root(s.mse_position_m2)],
  ["position error, largest / m", (s) => s.largest_position_error_m ?? null],
  ["charge / C", (s) => s.charge_C],
  ["voltage at the end / V", (s) => s.final_voltage_V],
  ["lowest voltage / V", (s) => s.minimum_voltage_V],
  ["available state of charge A at the end, under load / %", (s) => percent(s.final_soc)],
  ["share of the charge left, of what the pack can deliver / %", (s) => percent(s.remaining_soc)],
  ["steps in which a motor is at its limit / %", (s) => percent(s.saturated_share)],
  ["duty cycle in hover at the start", (s) => s.trim.duty],
  ["current in hover at the start / A", (s) => s.trim.battery_A],
];

// One row for each waypoint that any of the flights has; of many the largest distance alone.
const mostShown = 8;
const waypoints = (summaries) => {
  const length = Math.max(...summaries.map((s) => listOf(s.waypoint_distance_m).length));
  if (length > mostShown) {
    return [["largest distance from a waypoint at the end of its stay / m", (s) =>
      listOf(s.waypoint_distance_m).length ? Math.max(...s.waypoint_distance_m) : null]];
  }
  return Array.from({ length }, (_, k) =>
    [`distance from waypoint ${k + 1} at the end of its stay / m`, (s) => listOf(s.waypoint_distance_m)[k] ?? null]);
};

// Flights side by side.
function results(summaries, names) {
  return table(
    [
      { title: "quantity", of: ([title]) => title },
      ...summaries.map((summary, k) => ({ title: names[k], of: ([, of]) => of(summary) })),
    ],
    // What no flight has (a state of charge on an ideal source) is left out.
    [...RESULTS, ...waypoints(summaries)].filter(([, of]) => summaries.some((summary) => of(summary) !== null)),
    { caption: "Results" },
  );
}

function peaks(summaries, names) {
  const most = Math.max(...summaries.map(({ peak_altitude_error_m }) => peak_altitude_error_m.length));
  if (most === 0) return null;
  return section(
    "Largest altitude error after each step",
    element("p", {}, "In mm: the most that the reference was above the altitude in the 5 s after the command changed."),
    table(
      [
        { title: "step", of: (k) => String(k + 1) },
        ...summaries.map(({ peak_altitude_error_m }, flight) => ({
          title: `${names[flight]} / mm`,
          of: (k) => (k < peak_altitude_error_m.length ? 1e3 * peak_altitude_error_m[k] : null),
        })),
      ],
      Array.from({ length: most }, (_, k) => k),
    ),
  );
}

const ENSEMBLE = [
  ["final_soc", "available state of charge A at the end, under load"],
  ["remaining_soc", "share of the charge left"],
  ["minimum_voltage_V", "least voltage / V"],
  ["simulated_s", "flown / s"],
  ["mse_altitude_m2", "mean square altitude error / m²"],
  ["charge_C", "charge / C"],
];

function ensemble(summary, name) {
  if (!summary.ensemble) return null;
  const { completed, crashed, battery_empty, off_course = 0, interval_95 } = summary.ensemble;
  return section(
    `Cells as uncertain as the fit leaves them: ${name}`,
    element("p", {}, `Of the cells drawn ${completed} complete the flight, ${crashed} crash, on ` +
      `${battery_empty} the battery is empty before, and ${off_course} are off course.`),
    table(
      [
        { title: "quantity", of: ([, words]) => words },
        { title: "of the estimate", of: ([key]) => summary[key] },
        { title: "95 % from", of: ([key]) => interval_95[key][0] },
        { title: "to", of: ([key]) => interval_95[key][1] },
      ],
      ENSEMBLE,
    ),
  );
}

function sentences(summaries, names) {
  return summaries.flatMap((summary, k) => {
    const { reason, vehicle, battery, gains, compensate } = summary;
    const compensated = compensate ? ", commands compensated for the voltage" : "";
    const why = reason ? `${reason[0].toUpperCase()}${reason.slice(1)}.` : "";
    const trouble = troubleOf(summary);
    return [
      element("p", {}, `${names[k]}: ${vehicle} on ${battery}, ${gains} gains${compensated}.${trouble ? "" : ` ${why}`}`),
      trouble ? notice("warning", `${names[k]}: ${trouble}. ${why}`) : null,
      ...listOf(summary.doubts).map((doubt) => notice("warning", `${names[k]}: ${doubt}.`)),
    ];
  });
}

// What stands at the time that is shown.
function readout(flights, player) {
  const rows = [
    ["altitude / m", (flight, time) => flight.value("altitude_m", time), 3],
    ["reference / m", (flight, time) => flight.value("altitude_reference_m", time), 3],
    ["voltage / V", (flight, time) => flight.value("battery_V", time), 3],
    ["current / A", (flight, time) => flight.value("battery_A", time), 2],
    ["available charge A / %", (flight, time) => 100 * flight.value("soc", time), 1],
  ].filter(([, of]) => flights.some((flight) => Number.isFinite(of(flight, 0))));
  const cells = flights.map(() => rows.map(() => element("td", { class: "number" })));
  let last_ms = -Infinity;
  player.listen(({ time_s, playing }) => {
    const now_ms = performance.now();
    if (playing && now_ms - last_ms < READ_EVERY_MS) return;
    last_ms = now_ms;
    flights.forEach((flight, k) =>
      rows.forEach(([, of, decimals], row) => {
        const value = of(flight, time_s);
        cells[k][row].textContent = Number.isFinite(value) ? value.toFixed(decimals) : "–";
      }));
  });
  const head = (scope, text) => element("th", { scope }, text);
  return element("div", { class: "scroll" }, element("table", { class: "readout" },
    element("thead", {}, element("tr", {}, head("col", "at that time"), ...rows.map(([title]) => head("col", title)))),
    element("tbody", {}, ...flights.map(({ name }, k) => element("tr", {}, head("row", name), ...cells[k])))));
}

// Plays once it is seen, unless someone was there before or wants less motion.
function playWhenSeen(shell, player) {
  if (wantsLessMotion() || player.end_s === 0) return;
  const seen = new IntersectionObserver((entries) => {
    if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
    seen.disconnect();
    if (player.time_s === 0) player.play();
  }, { threshold: 0.6 });
  seen.observe(shell);
}

/** The view; `stages` are tried in turn: (flights, player) => {picture, tools, shown}, or null where that cannot be. */
export function flyView(stages) {
  return {
    command: "fly",
    together: ({ maneuver }) => maneuver,
    title: (all) => `${all.length > 1 ? "Flights" : "Flight"}: ${all[0].summary.maneuver}`,
    parts(all) {
      const summaries = all.map(({ summary }) => summary);
      const names = namesOf(summaries);
      const flights = all.flatMap(({ summary, series }, k) => {
        const found = series.find(({ kind }) => kind === "flight");
        return found ? [flightOf(summary, found, names[k], k)] : [];
      });
      const about = [sentences(summaries, names), results(summaries, names)];
      const tables = [
        peaks(summaries, names),
        ...summaries.map((summary, k) => ensemble(summary, names[k])),
      ];
      if (flights.length === 0) return [...about, ...tables];
      const player = new Player(Math.max(...flights.map(({ end_s }) => end_s)));
      const marks = flights.flatMap(({ name, time, trouble, summary }) => [
        ...(trouble ? [{ time_s: time[time.length - 1], text: flights.length > 1 ? `${name}: ${trouble}` : trouble }] : []),
        ...(summary.landed_s === undefined ? [] : [{ time_s: summary.landed_s, text: flights.length > 1 ? `${name}: landed` : "landed" }]),
      ]);
      let stage = null;
      for (const make of stages) stage ??= make(flights, player);
      const charts = flightCharts(flights, `flight ${(sections += 1)}`, marks.map(({ time_s }) => ({ x: time_s })));
      const shell = element(
        "section",
        { class: "flight" },
        element("h3", {}, "The flight"),
        stage.picture,
        controlsOf(player, marks),
        readout(flights, player),
        ...stage.tools,
        element("p", { class: "hint" }, stepsOf(player)),
      );
      shell.tabIndex = -1;
      shell.player = player;
      shell.stage = stage;
      listenToKeys(shell, player);
      const over = section("Over time", ...charts);
      over.classList.add("over-time");
      tieCharts(charts.filter(({ plot }) => plot), player, marks);
      player.tell();
      playWhenSeen(shell, player);
      return [...about, shell, over, ...tables];
    },
  };
}

/** For pages without three.js. */
export const fly = flyView([planOf]);
