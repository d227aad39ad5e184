// Poles of a closed loop as the voltage falls: the complex plane with a slider over xi, a table of the poles there, and damping
// and speed against xi. Rows are those of `lipoid poles`: {xi, kappa, poles, poles_quasistatic, poles_full}.
import { lineChart } from "./chart.js";
import { element, note, notice } from "./dom.js";
import { significant } from "./format.js";
import { isNumber, listOf } from "./numbers.js";
import { table } from "./table.js";

const KINDS = [
  { key: "poles", label: "closed form", colour: 0, size: 7 },
  { key: "poles_quasistatic", label: "quasi-static", colour: 1, size: 4 },
  { key: "poles_full", label: "with motor lag", colour: 2, size: 5 },
];
const DAMPING = [0.1, 0.2, 0.4, 0.6, 0.8];
// The poles of the motors lie far to the left; those within so many times the slowest loop's are shown.
const NEAR = 1.5;

const polesOf = (row, { key }) => listOf(row[key]).filter((pole) => isNumber(pole?.[0]) && isNumber(pole?.[1]))
  .map(([re, im]) => ({ re, im, size: Math.hypot(re, im) }));
const upper = (poles) => poles.filter(({ im }) => im >= 0);
const dampingOf = ({ re, size }) => (size > 0 ? -re / size : 0);

// Conjugates have one damping: of all poles the least damped, of all poles the slowest.
const leastDamping = (poles) => poles.reduce((least, pole) => Math.min(least, dampingOf(pole)), 1);
const slowest_s = (poles) => {
  const re = poles.reduce((most, pole) => Math.max(most, pole.re), -Infinity);
  return re < 0 && Number.isFinite(re) ? -1 / re : null;
};

function guidesWithin(reach) {
  return DAMPING.map((zeta) => ({
    from: [0, 0],
    to: [-reach * zeta, reach * Math.sqrt(1 - zeta * zeta)],
    label: String(zeta),
  }));
}

function plane(rows, name, reach) {
  const lines = KINDS.map((kind) => {
    const poles = rows.flatMap((row) => upper(polesOf(row, kind))).filter(({ size }) => size <= reach);
    return { label: kind.label, x: poles.map(({ re }) => re), values: poles.map(({ im }) => im), points: true, size: kind.size, colour: kind.colour };
  }).filter((line) => line.x.length > 0);
  if (lines.length === 0) return null;
  // Where all poles are real the plane has a height all the same; those on the axis are not cut.
  const height = Math.max(...lines.flatMap((line) => line.x.map((re, k) => Math.max(0.1 * Math.abs(re), line.values[k]))));
  return lineChart({
    title: `Poles of ${name}: upper half of the complex plane`,
    x: { label: "real part / (1/s)", values: [], include: [0] },
    y: { label: "imaginary part / (1/s)", reach: [-0.04 * height, height] },
    lines,
    guides: guidesWithin(reach),
    marks: [{ x: 0 }],
    height: 380,
  });
}

const ringsAt = (row, reach) =>
  KINDS.flatMap((kind) => upper(polesOf(row, kind)).filter(({ size }) => size <= reach)
    .map(({ re, im }) => ({ at: [re, im], colour: kind.colour })));

function tableAt(row) {
  const poles = KINDS.flatMap((kind) => upper(polesOf(row, kind)).map((pole) => ({ kind: kind.label, ...pole })));
  return table(
    [
      { title: "computed", of: ({ kind }) => kind },
      {
        title: "pole / (1/s)",
        of: ({ re, im }) => (im > 0 ? `${significant(re)} ± ${significant(im)}i` : significant(re)),
        by: ({ re }) => re,
        class: "number",
      },
      { title: "natural frequency / (rad/s)", of: ({ size }) => size },
      { title: "damping ratio", of: (pole) => dampingOf(pole) },
      { title: "time constant / s", of: ({ re }) => (re < 0 ? -1 / re : null) },
    ],
    poles,
    { sort: true, caption: `Poles at a voltage ratio of ${significant(row.xi)}` },
  );
}

// The slider: whatever shows one row is told which.
function slider(rows, show) {
  const output = element("output", {});
  const input = element("input", { type: "range", min: 0, max: rows.length - 1, step: 1, value: rows.length - 1, "aria-label": "voltage ratio xi" });
  const update = () => {
    const row = rows[Number(input.value)];
    const words = `xi = ${significant(row.xi)}${isNumber(row.kappa) ? `, kappa = ${significant(row.kappa)}` : ""}`;
    output.textContent = words;
    input.setAttribute("aria-valuetext", words);
    show(row);
  };
  input.addEventListener("input", update);
  update();
  return element("p", { class: "slider" }, element("label", {}, "Voltage over the nominal one ", input), " ", output);
}

function against(rows, name, title, label, of, more = {}) {
  const kinds = KINDS.filter((kind) => rows.some((row) => polesOf(row, kind).length > 0));
  return lineChart({
    title: `${title} of ${name}`,
    x: { label: "voltage ratio xi", values: rows.map(({ xi }) => xi) },
    y: { label, ...more },
    lines: kinds.map((kind) => ({
      label: kind.label,
      colour: kind.colour,
      dots: rows.length < 60,
      dash: kind.key === "poles_quasistatic" ? [6, 4] : undefined,
      values: rows.map((row) => {
        const poles = polesOf(row, kind);
        return poles.length > 0 ? of(poles) : null;
      }),
    })),
    link: `poles ${name}`,
    height: 220,
  });
}

/** @param name  what the poles belong to, in the titles: "the altitude loop" */
export function rootLocus(allRows, name) {
  const rows = listOf(allRows).filter((row) => isNumber(row?.xi) && KINDS.some((kind) => polesOf(row, kind).length > 0))
    .sort((a, b) => a.xi - b.xi);
  if (rows.length === 0) return [note("The summary has no poles.")];
  const slow = rows.flatMap((row) => polesOf(row, KINDS[1]).concat(polesOf(row, KINDS[0])));
  const reach = NEAR * Math.max(...(slow.length > 0 ? slow : rows.flatMap((row) => polesOf(row, KINDS[2]))).map(({ size }) => size), 1e-9);
  const chart = plane(rows, name, reach);
  const holder = element("div", {});
  const control = slider(rows, (row) => {
    holder.replaceChildren(tableAt(row));
    chart?.showRings?.(ringsAt(row, reach));
  });
  const unstable = rows.filter((row) => polesOf(row, KINDS[2]).some(({ re }) => re >= 0));
  const far = rows.some((row) => polesOf(row, KINDS[2]).some(({ size }) => size > reach));
  return [
    unstable.length > 0
      ? notice("warning", `With motor lag the loop is unstable at ${unstable.length} of ${rows.length} voltages, up to xi = ${significant(unstable[unstable.length - 1].xi)}.`)
      : null,
    control,
    chart,
    note(
      "Each point is a pole at one voltage ratio; circles mark those of the slider. The lower half of the plane mirrors the upper. ",
      "Dashed lines from the origin have the damping ratio that stands beside them; right of the dashed vertical a loop is unstable.",
      far ? " The poles of the motors lie too far to the left to be shown; the table has them." : "",
    ),
    holder,
    rows.length > 1
      ? element("div", { class: "columns" },
          against(rows, name, "Least damping ratio", "damping ratio", leastDamping),
          against(rows, name, "Slowest time constant", "time constant / s", slowest_s, { zero: true }))
      : null,
  ];
}
