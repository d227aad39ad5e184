// The time of a player in a chart, and the chart's cursor in the player.
import { element } from "../dom.js";

// The cursors of a dozen charts follow so often while it plays.
const EVERY_MS = 60;

/**
 * Ties charts over time in s, which share their cursor, to a player: the cursor shows its time, and one
 * that is moved by mouse or keys holds the player at its own. marks are [{time_s, text}]: words in the
 * first chart.
 */
export function tieCharts(figures, player, marks) {
  const [first] = figures.map((figure) => figure.plot);
  let own = false;  // the cursor is moved by the player
  let last_ms = -Infinity;
  const follow = () => {
    const now_ms = performance.now();
    if (player.held || (player.playing && now_ms - last_ms < EVERY_MS)) return;
    last_ms = now_ms;
    own = true;
    // Said to all charts of the link, as a mouse would.
    first.setCursor({ left: first.valToPos(player.time_s, "x"), top: first.over.clientHeight / 2 }, true, true);
    own = false;
  };
  player.listen(follow);

  for (const { plot } of figures) {
    const holder = plot.over.closest(".plot");
    plot.hooks.setCursor.push(() => {
      const { left, idx } = plot.cursor;
      if (own || left < 0 || idx === null) return;
      if (plot.over.matches(":hover")) player.hold(plot.posToVal(left, "x"));
      else if (document.activeElement === holder) player.hold(plot.data[0][idx]);
    });
    const release = () => {
      if (player.held) player.release();
    };
    plot.over.addEventListener("mouseleave", release);
    holder.addEventListener("blur", release);
  }

  const events = marks.map(({ time_s, text }) => ({ time_s, shown: element("span", { class: "event" }, text) }));
  first.over.append(...events.map(({ shown }) => shown));
  const place = () => {
    for (const { time_s, shown } of events) {
      const at = first.valToPos(time_s, "x");
      const width = first.over.clientWidth;
      shown.style.visibility = at >= 0 && at <= width ? "visible" : "hidden";
      const left = at > width / 2 ? at - shown.offsetWidth - 4 : at + 4;
      shown.style.transform = `translateX(${left.toFixed(1)}px)`;
    }
  };
  (first.hooks.draw ??= []).push(place, follow);
}
