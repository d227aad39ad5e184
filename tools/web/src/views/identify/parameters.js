// What the logs know, and each parameter with its interval and verdict; the staged answer beside it.
import { element, note, notice, section } from "../../dom.js";
import { significant } from "../../format.js";
import { table } from "../../table.js";

const WORDS = {
  identified: "identified",
  weak: "weak",
  "at-bound": "at a bound",
  "only-in-combination-with": "only with",
};

export function verdictText({ verdict, with: partners }) {
  const word = WORDS[verdict] ?? verdict;
  return verdict === "only-in-combination-with" ? `${word} ${(partners ?? []).join(", ")}` : word;
}

// Digits that tell an estimate from its interval.
function digitsFor({ estimate, standard_error: error }) {
  if (!(typeof estimate === "number" && error > 0)) return 5;
  return Math.max(5, Math.min(9, Math.floor(Math.log10(Math.max(1, Math.abs(estimate) / error))) + 2));
}

// A column of numbers with these digits.
function number(title, of) {
  const one = (row) => (typeof of(row) === "number" ? significant(of(row), digitsFor(row)) : "unknown");
  return { title, class: "number", of: one, by: of };
}

// Words of the program as a sentence: a symbol at its beginning keeps its letter.
function asSentence(text, names) {
  const first = text.split(/[ ,]/)[0];
  return `${names.includes(first) || first.includes("_") ? text[0] : text[0].toUpperCase()}${text.slice(1)}.`;
}

const EXACT = { open_circuit_voltage: "v_oc(A)" };

const scaled = (value, factor) => (typeof value === "number" ? factor * value : null);

/** "What the logs know": charge and resistances at half charge. */
export function known({ summary }) {
  const alpha = (summary.parameters ?? []).find(({ name }) => name === "alpha");
  const interval = alpha?.interval_95 ?? [];
  const all = [
    { what: "charge alpha", value: scaled(summary.alpha_C, 1 / 3600), low: scaled(interval[0], 1 / 3600), high: scaled(interval[1], 1 / 3600), unit: "Ah" },
    ...(summary.resistance ?? []).map((r) => ({
      what: `resistance at ${significant(100 * r.soc)} % charge, ${r.after_s} s after ${significant(r.current_A, 3)} A are switched on`,
      value: scaled(r.resistance_Ohm, 1e3),
      low: scaled(r.interval_95?.[0], 1e3),
      high: scaled(r.interval_95?.[1], 1e3),
      unit: "mΩ",
    })),
  ];
  const rows = all.filter(({ value }) => typeof value === "number");
  if (rows.length === 0) return null;
  return section(
    "What the logs know",
    table(
      [
        { title: "quantity", of: ({ what }) => what },
        number("value", ({ value }) => value),
        number("95 % from", ({ low }) => low),
        number("to", ({ high }) => high),
        { title: "unit", of: ({ unit }) => unit },
      ],
      rows.map((row) => ({ ...row, estimate: row.value, standard_error: (row.high - row.low) / 4 })),
    ),
  );
}

export function parameters({ summary, cautions }) {
  const rows = summary.parameters ?? [];
  if (rows.length === 0) return null;
  const staged = new Map((summary.staged?.parameters ?? []).map((row) => [row.name, row]));
  const other = (row) => staged.get(row.name);
  const columns = [
    { title: "parameter", of: ({ name }) => name },
    number("estimate", ({ estimate }) => estimate),
    { title: "standard error", class: "number", of: (row) => (typeof row.standard_error === "number" ? significant(row.standard_error, 2) : "unknown"), by: (row) => row.standard_error },
    number("95 % from", ({ interval_95 }) => interval_95?.[0]),
    number("to", ({ interval_95 }) => interval_95?.[1]),
    { title: "unit", of: ({ unit }) => unit },
    { title: "identifiability", of: verdictText },
  ];
  if (staged.size > 0) {
    columns.push(
      { title: "staged estimate", class: "number", of: (row) => (other(row) ? significant(other(row).estimate, 5) : "–"), by: (row) => other(row)?.estimate },
      { title: "staged standard error", class: "number", of: (row) => (typeof other(row)?.standard_error === "number" ? significant(other(row).standard_error, 2) : "–"), by: (row) => other(row)?.standard_error },
      { title: "staged identifiability", of: (row) => (other(row) ? verdictText(other(row)) : "–") },
    );
  }
  const alone = [...staged.values()].filter(({ name }) => !rows.some((row) => row.name === name));
  const sentence = summary.trust?.sentence;
  return section(
    "Parameters",
    sentence ? element("p", {}, asSentence(sentence, rows.map(({ name }) => name))) : null,
    cautions.parameters.map((text) => notice("warning", text)),
    table(columns, rows, { sort: true, caption: "Estimates with 95 % intervals; “unknown” is an error without limit" }),
    alone.length > 0
      ? note(`The staged method alone has ${alone.map((row) => `${row.name} = ${significant(row.estimate, 5)} ${row.unit} (${verdictText(row)})`).join(", ")}.`)
      : null,
    summary.trust?.taken_as_exact?.length > 0 ? note(`The intervals take ${summary.trust.taken_as_exact.map((key) => EXACT[key] ?? key).join(" and ")} as exact.`) : null,
    summary.not_drawn?.length > 0
      ? note(`Cells drawn from this one vary only in what is known of ${summary.not_drawn.join(", ")}.`)
      : null,
    truth(summary.truth),
  );
}

function truth(comparison) {
  if (!comparison) return null;
  const rows = Object.entries(comparison.parameters ?? {}).map(([name, row]) => ({ name, ...row }));
  return table(
    [
      { title: "parameter", of: ({ name }) => name },
      { title: "truth", of: (row) => row.truth, digits: 6 },
      { title: "estimate", of: (row) => row.estimate, digits: 6 },
      { title: "error / %", of: (row) => row.error_percent, digits: 3 },
    ],
    rows,
    { caption: `Truth against estimate; v_oc after equal charge is off by ${significant(1e3 * comparison.open_circuit_rms_V, 3)} mV rms, ${
      significant(1e3 * comparison.open_circuit_max_V, 3)} mV at most` },
  );
}
