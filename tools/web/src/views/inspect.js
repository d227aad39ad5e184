// `lipoid inspect`: each log with its segments, gaps and the kind that it looks like.
import { disclosure, element, facts, note, notice, section } from "../dom.js";
import { baseName, duration, plural, significant } from "../format.js";
import { logCharts, thinnedNote } from "../log_charts.js";
import { table } from "../table.js";

const KINDS = { rest: 6, "constant-current": 2, pulse: 1, varying: 3 };
const Ah = (charge_C) => (typeof charge_C === "number" ? charge_C / 3600 : null);

function range({ least, largest } = {}, unit) {
  if (typeof least !== "number") return null;
  return least === largest ? `${significant(least, 5)} ${unit}` : `${significant(least, 5)} ${unit} to ${significant(largest, 5)} ${unit}`;
}

const DROPPED = {
  dropped_repeated_times: "with a repeated time stamp",
  dropped_unselected: "outside the chosen part",
  dropped_cut_last_line: "cut short at the end",
  dropped_spikes: "with a voltage or a current that cannot be",
};

function dropped(file) {
  return Object.entries(DROPPED)
    .filter(([name]) => file[name] > 0)
    .map(([name, why]) => `${plural(file[name], "row")} ${why}`)
    .join(", ");
}

// What the coloured grounds of the charts mean.
function key(segments) {
  const counts = new Map();
  for (const { kind } of segments) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  return element(
    "p",
    { class: "legend" },
    [...counts].map(([kind, number]) => {
      const mark = element("span", { class: "swatch ground", "aria-hidden": "true" });
      mark.style.setProperty("--colour", `var(--series-${KINDS[kind] ?? 4})`);
      return element("span", { class: "entry" }, mark, `${kind} (${number})`);
    }),
  );
}

function segmentTable(segments) {
  return table(
    [
      { title: "segment", of: ({ kind }) => kind },
      { title: "start / s", of: ({ start_s }) => start_s, digits: 8 },
      { title: "duration / s", of: ({ start_s, end_s }) => end_s - start_s, digits: 6 },
      { title: "current / A", of: ({ current_A }) => current_A },
      { title: "charge / Ah", of: ({ charge_C }) => Ah(charge_C) },
      { title: "rows", of: ({ first_row, last_row }) => last_row - first_row + 1 },
    ],
    segments,
    { sort: true, caption: "Segments; discharge is positive" },
  );
}

function partTable(parts) {
  return table(
    [
      { title: "part", of: (part) => String(parts.indexOf(part) + 1) },
      { title: "start_s", of: ({ start_s }) => start_s, digits: 10 },
      { title: "end_s", of: ({ end_s }) => end_s, digits: 10 },
      { title: "charge out / Ah", of: ({ charge_out_C }) => Ah(charge_out_C) },
      { title: "rests at / V", of: ({ start_voltage_V }) => start_voltage_V },
      { title: "kind", of: ({ suggested_kind }) => suggested_kind ?? "none" },
    ],
    parts,
    { caption: "Tests within the file, between recharges or gaps" },
  );
}

function file(one, k, series) {
  const title = baseName(one.file);
  if (one.error) return section(title, notice("error", one.error));
  const segments = one.segments ?? [];
  const drawn = series.find(({ of }) => of === k);
  const spans = segments.map(({ kind, start_s, end_s }) => ({ from: start_s, to: end_s, colour: KINDS[kind] ?? 4 }));
  const gaps = one.gaps ?? [];
  const marks = gaps.flatMap(({ start_s, length_s }) => [{ x: start_s }, { x: start_s + length_s }]);
  const thinned = drawn ? thinnedNote(drawn) : null;
  return section(
    title,
    element("p", { class: "sentence" }, one.parts?.length > 0
      ? `${plural(one.parts.length, "test")} in one file.`
      : `${one.suggested_kind ?? "Of no kind that a campaign takes"}: ${one.suggested_kind_reason}.`),
    facts([
      ["File", one.file],
      ["Format", one.format],
      ["Rows", plural(one.rows, "row")],
      ["Time", `${duration(one.duration_s)}${one.sampling_s?.median > 0 ? `, a row every ${significant(one.sampling_s.median)} s` : ""}`],
      ["Current", range(one.current_A, "A")],
      ["Voltage", range(one.voltage_V, "V")],
      ["Pack", one.series > 1 ? `${one.series} cells in series, by the voltage` : null],
      ["Temperature", range(one.temperature_degC, "°C")],
      ["Charge", `${significant(Ah(one.charge_out_C))} Ah out, ${significant(Ah(one.charge_in_C))} Ah in`],
      ["Sign of the current", one.current_sign_reason?.startsWith("discharge is ") ? one.current_sign_reason : `${one.current_sign}: ${one.current_sign_reason}`],
      ["Dropped", dropped(one)],
    ]),
    (one.warnings ?? []).map((text) => notice("warning", text)),
    gaps.map(({ start_s, length_s, unknown_C }) =>
      notice("warning", `No rows for ${duration(length_s)} from ${significant(start_s, 8)} s on (dashed in the charts)${
        unknown_C > 0 ? `; as much as ${significant(Ah(unknown_C))} Ah may have moved` : ""}.`)),
    (one.notes ?? []).map((text) => note(text)),
    one.parts?.length > 0 ? partTable(one.parts) : null,
    key(segments),
    thinned ? note(thinned) : null,
    drawn ? logCharts(drawn, { link: `file ${k}`, spans, marks }) : null,
    segments.length > 12 ? disclosure(plural(segments.length, "segment"), segmentTable(segments)) : segmentTable(segments),
  );
}

export const inspect = {
  command: "inspect",
  title: ({ summary }) => (summary.files?.length === 1 ? `What is in ${baseName(summary.files[0].file)}` : "What is in the logs"),
  parts: ({ summary, series }) => {
    const files = summary.files ?? [];
    return [
      files.length > 1
        ? table(
            [
              { title: "log", of: (one) => one.file },
              { title: "format", of: (one) => (one.error ? "not read" : one.format) },
              { title: "rows", of: ({ rows }) => rows },
              { title: "duration", class: "number", of: (one) => (one.error ? null : duration(one.duration_s)), by: ({ duration_s }) => duration_s },
              { title: "charge out / Ah", of: ({ charge_out_C }) => Ah(charge_out_C) },
              { title: "kind", of: (one) => (one.parts?.length > 0 ? plural(one.parts.length, "test") : one.suggested_kind ?? "none") },
            ],
            files,
            { sort: true, caption: "All logs" },
          )
        : null,
      ...files.map((one, k) => file(one, k, series)),
    ].filter((part) => part !== null);
  },
};
