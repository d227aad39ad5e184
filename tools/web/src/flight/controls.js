// What plays a flight: button, time line, speed, and keys.
import { element } from "../dom.js";
import { clock } from "../format.js";

// What an arrow key steps by, and with Shift.
const STEP_S = 0.1;
const WIDE_STEP_S = 1;

/** The controls of a player; marks are [{time_s, text}], shown under the time line. */
export function controlsOf(player, marks) {
  const long = player.end_s > 600;
  const say = (time_s) => (long ? clock(time_s, 1) : `${time_s.toFixed(2)} s`);
  const play = element("button", { type: "button", class: "play", onclick: () => player.toggle() });
  const line = element("input", {
    type: "range",
    class: "time",
    min: 0,
    max: player.end_s,
    step: "any",
    value: 0,
    "aria-label": "Time of the flight",
    oninput: () => player.seek(Number(line.value)),
  });
  const now = element("output", { class: "clock" });
  const rate = element(
    "select",
    { onchange: () => (player.rate = Number(rate.value)) },
    ...player.rates.map((value) =>
      element("option", { value, selected: value === player.rate }, `${value} ×`)),
  );
  const ends = element("div", { class: "marks" });
  for (const { time_s, text } of marks) {
    const mark = element("span", { title: text }, "▲");
    mark.style.left = `${(100 * time_s) / player.end_s}%`;
    ends.append(mark);
  }
  player.listen(({ time_s, playing }) => {
    const text = playing ? "Pause" : "Play";
    if (play.textContent !== text) play.textContent = text;
    line.value = String(time_s);
    line.setAttribute("aria-valuetext", say(time_s));
    now.textContent = `${say(time_s)} of ${say(player.end_s)}`;
  });
  return element(
    "div",
    { class: "controls" },
    play,
    element("div", { class: "line" }, line, ends),
    now,
    element("label", {}, "speed ", rate),
  );
}

const stepOf = (player, wide) => (player.end_s > 600 ? 10 : 1) * (wide ? WIDE_STEP_S : STEP_S);

/** What the keys do, in words. */
export function stepsOf(player) {
  return `Space plays and pauses; the arrow keys step by ${stepOf(player, false)} s, with Shift by ${stepOf(player, true)} s. ` +
    "A cursor in a chart shows the flight at its time.";
}

/** Space plays and pauses, arrows step, Home and End go to the ends, wherever the focus is within `scope`. */
export function listenToKeys(scope, player) {
  const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1 };
  scope.addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
    if (key === " ") {
      // A button that has the focus is pressed by this key.
      if (target.tagName === "BUTTON") return;
      player.toggle();
    } else if (key in steps) {
      player.seek(player.time_s + steps[key] * stepOf(player, event.shiftKey));
    } else if (key === "Home") {
      player.seek(0);
    } else if (key === "End") {
      player.seek(player.end_s);
    } else {
      return;
    }
    event.preventDefault();
  });
}
