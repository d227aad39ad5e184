// `lipoid plan`: what an experiment would tell, against the length of pulse and rest, the rate and the sampling.
import { lineChart } from "../chart.js";
import { element, facts, note, section } from "../dom.js";
import { duration, significant } from "../format.js";
import { distinct, isNumber, listOf, times } from "../numbers.js";
import { table } from "../table.js";

const VARIED = [
  { key: "pulse_s", title: "Length of the pulses", label: "pulse / s", unit: "s", log: true },
  { key: "rest_s", title: "Rest after each pulse", label: "rest / s", unit: "s", log: true },
  { key: "rate_C", title: "Rate of the pulses", label: "rate / C", unit: "C", log: false },
  { key: "sampling_s", title: "Time between rows", label: "sampling / s", unit: "s", log: true },
];
const IDENTIFIED = "identified";
// Of a plan with temperatures each row has one.
const MOST_SENTENCES = 9;

const parameterOf = (row, name) => listOf(row.parameters).find((parameter) => parameter.name === name);
const percentOf = (row, name) => times(100, parameterOf(row, name)?.relative_standard_error);

// Which quantities are not well determined by an experiment, in words.
function doubts(row) {
  const weak = listOf(row.parameters).filter((parameter) => parameter.verdict !== IDENTIFIED);
  return weak.length === 0 ? "all identified" : weak.map(({ name, verdict }) => `${name}: ${verdict}`).join("; ");
}

// Standard errors against one quantity, the others held at what is chosen.
function against(varied, rows, names, others) {
  const values = distinct(rows.map((row) => row[varied.key]));
  const chosen = Object.fromEntries(others.map(({ key, values: all }) => [key, all[0]]));
  const holder = element("div", {});
  const draw = () => {
    const own = values.map((value) => rows.find((row) => !isNumber(row.second_degC) && row[varied.key] === value && others.every(({ key }) => row[key] === chosen[key])));
    holder.replaceChildren(lineChart({
      title: `Standard error against the ${varied.title.toLowerCase()}`,
      x: { label: varied.label, values, log: varied.log && values[0] > 0 },
      y: { label: "standard error / %", log: true },
      lines: names.map((name, k) => ({ label: name, values: own.map((row) => (row ? percentOf(row, name) : null)), dots: true, colour: k % 7, dash: k >= 7 ? [6, 4] : undefined })),
      name: `standard error against ${varied.key}`,
    }));
  };
  const choices = others.map(({ key, label, values: all }) =>
    element("label", {}, `${label} `,
      element("select", { onchange: (event) => { chosen[key] = all[Number(event.target.value)]; draw(); } },
        all.map((value, k) => element("option", { value: k }, significant(value)))), " "));
  draw();
  return section(varied.title, choices.length > 0 ? element("p", { class: "choices" }, "The others at: ", choices) : null, holder);
}

// What is done at which temperatures; empty where none takes part.
function temperaturesOf(row) {
  if (!Array.isArray(row.ambient_degC)) return "";
  const at = row.ambient_degC.map((degC) => significant(degC)).join(", ");
  if (!isNumber(row.second_degC)) return `${at} °C`;
  return `${at} °C and ${row.second_pulses === "one" ? "one pulse" : "pulses"} at ${significant(row.second_degC)} °C`;
}

function planTable(rows, names, varied, warms) {
  return table(
    [
      ...(warms ? [{ title: "temperatures", of: temperaturesOf, class: "name" }] : []),
      ...(varied.length > 0 || warms ? varied : VARIED).map(({ key, label }) => ({ title: label, of: (row) => row[key] })),
      { title: "duration", of: (row) => duration(row.duration_s), by: (row) => row.duration_s, class: "number" },
      { title: "rows", of: (row) => row.rows },
      ...names.map((name) => ({ title: `${name} / %`, of: (row) => percentOf(row, name), digits: 3 })),
      { title: "identifiability", of: doubts, class: "name" },
    ],
    rows,
    { sort: true, caption: "Standard errors that each experiment would give, in % of the parameter" },
  );
}

export const plan = {
  command: "plan",
  title: ({ summary }) => `Experiments planned for ${summary.cell}`,
  parts: ({ summary }) => {
    const rows = listOf(summary.rows);
    const names = [...new Set(rows.flatMap((row) => listOf(row.parameters).map(({ name }) => name)))];
    const noise = summary.noise ?? {};
    const warms = rows.some((row) => temperaturesOf(row) !== "");
    const varied = VARIED.map((each) => ({ ...each, values: distinct(rows.map((row) => row[each.key])) })).filter(({ values }) => values.length > 1);
    return [
      rows.length === 1 || warms
        ? rows.slice(0, MOST_SENTENCES).map((row) => element("p", { class: "sentence" }, `${temperaturesOf(row) && `${temperaturesOf(row)}: `}${row.sentence}`)) : null,
      facts([
        ["Cell", summary.cell],
        ["Energies and heat balance", summary.temperature_assumed ? "typical values" : null],
        ["White noise", isNumber(noise.white_V) ? `${significant(1e3 * noise.white_V)} mV` : null],
        ...VARIED.filter(({ key }) => varied.every((each) => each.key !== key))
          .map(({ key, title, unit }) => [title, `${significant(rows[0]?.[key])} ${unit}`]),
        ["Slow errors", isNumber(noise.coloured_V) ? `${significant(1e3 * noise.coloured_V)} mV over ${duration(noise.correlation_s)}` : null],
      ]),
      noise.sentence ? element("p", { class: "sentence" }, noise.sentence) : null,
      planTable(rows, names, varied, warms),
      varied.map((each) => against(each, rows, names, varied.filter(({ key }) => key !== each.key))),
      varied.length === 0 && !warms
        ? note("One experiment has no curve: give lists, as in `lipoid plan CELL --pulse-s 10,30,60 --rest-s 600,1770 --rate-C 1,2`.")
        : null,
      listOf(summary.left_out).length > 0
        ? section("Left out", element("ul", {}, listOf(summary.left_out).map((text) => element("li", {}, text)))) : null,
    ];
  },
};
