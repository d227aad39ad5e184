// Profile likelihoods: a parameter held at values around its estimate, the others fitted anew.
import { lineChart } from "../../chart.js";
import { element, note, section } from "../../dom.js";
import { significant } from "../../format.js";

function interval({ interval_95: [low, high] = [], points, unit }) {
  const text = (value) => significant(value, 5);
  const known = (value) => typeof value === "number";
  if (known(low) && known(high)) return `95 % from ${text(low)} to ${text(high)} ${unit}`;
  const [first, last] = [points[0].value, points[points.length - 1].value];
  if (known(low)) return `95 % from ${text(low)} ${unit}, no end up to ${text(last)}`;
  if (known(high)) return `95 % up to ${text(high)} ${unit}, no end down to ${text(first)}`;
  return `no end from ${text(first)} to ${text(last)} ${unit}`;
}

export function profiles({ summary, key }) {
  const all = summary.profiles ?? [];
  if (all.length === 0) return null;
  const chart = (profile) => {
    const points = profile.points ?? [];
    if (points.length === 0) return note(`No profile of ${profile.name}: ${profile.none_because ?? "it has no value"}.`);
    const costs = points.map(({ cost }) => cost).filter((cost) => typeof cost === "number");
    const least = Math.min(...costs);
    const rise = profile.objective_rise_95;
    const known = typeof rise === "number" && rise > 0;
    const share = (cost) => (typeof cost === "number" ? (cost - least) / (known ? rise : Math.max(least, Number.MIN_VALUE)) : null);
    const x = points.map(({ value }) => value);
    const lines = [
      { label: "rise of the cost", values: points.map(({ cost }) => share(cost)), colour: 0 },
      { label: "refits", values: points.map(({ cost }) => share(cost)), points: true, size: 6, colour: 0 },
    ];
    if (known) lines.push({ label: "where 95 % end", values: x.map(() => 1), colour: 1, dash: [6, 4] });
    return lineChart({
      title: `${profile.name}: ${interval(profile)}`,
      name: `${key} profile ${profile.name}`,
      x: { label: `${profile.name} / ${profile.unit}`, values: x },
      y: { label: known ? "rise / rise at 95 %" : "rise of the cost, relative", zero: true },
      lines,
      marks: [{ x: profile.estimate }],
      height: 260,
    });
  };
  return section(
    "Profile likelihoods",
    note("Each point is a fit of all other parameters with this one held. The 95 % interval ends where the curve crosses the line; the dashed upright is the estimate."),
    element("div", { class: "columns" }, all.map(chart)),
  );
}
