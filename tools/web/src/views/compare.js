// `lipoid compare`: optimizers on the same problem, by what they found and how fast.
import { lineChart } from "../chart.js";
import { disclosure, element, facts, note, notice, section } from "../dom.js";
import { alphaSource, count, significant } from "../format.js";
import { isNumber, listOf, times } from "../numbers.js";
import { table } from "../table.js";
import { judgement } from "./identify/header.js";

const COLOURS = 7;
const DASHES = [undefined, [6, 4], [2, 3]];

// Samples of several lines that hold until the next one, over all of their places of x: what the cursor reads is what held there.
function held(tracks) {
  const xs = [...new Set(tracks.flatMap((track) => track.at))].sort((a, b) => a - b);
  const columns = tracks.map(({ at, values }) => {
    let n = -1;
    return xs.map((x) => {
      while (n + 1 < at.length && at[n + 1] <= x) ++n;
      return n < 0 || x > at[at.length - 1] ? null : values[n];
    });
  });
  return { xs, columns };
}

// How far each got, by `along` ("wall_s" or "evaluations"): [{label, at, values}].
function tracksOf(results, along, value) {
  return results
    .map((result) => {
      const steps = listOf(result.improvements).filter((step) => step[along] > 0 && isNumber(value(step)));
      const at = steps.map((step) => step[along]);
      const values = steps.map(value);
      if (at.length > 0 && result[along] > at[at.length - 1]) {
        at.push(result[along]);
        values.push(values[values.length - 1]);
      }
      return { label: String(result.optimizer), at, values };
    });
}

function steps(title, tracks, x, y) {
  if (tracks.every((track) => track.at.length === 0)) return note(`${title}: the summary has no samples of this.`);
  const { xs, columns } = held(tracks);
  return lineChart({
    title,
    x: { ...x, values: xs, log: true },
    y,
    lines: tracks.map(({ label }, k) => ({
      label,
      values: columns[k],
      colour: k % COLOURS,
      dash: DASHES[Math.floor(k / COLOURS) % DASHES.length],
      step: "after",
      digits: 6,
    })),
  });
}

const TIME = { label: "time / s" };
const EVALUATIONS = { label: "evaluations" };

function progress(results, best) {
  const cost = (step) => step.cost_V2;
  const costAxis = { label: "cost / V²", log: true };
  const above = (step) => (isNumber(best) && best > 0 ? 100 * (step.cost_V2 / best - 1) : null);
  // What rounding leaves is no progress.
  const seen = (step) => (above(step) !== null ? Math.max(above(step), 1e-6) : null);
  return section(
    "Progress from the data's start",
    note("Each line is the least cost that an optimizer had found so far; it ends where the optimizer ended."),
    steps("Cost against time", tracksOf(results, "wall_s", cost), TIME, costAxis),
    steps("Cost against evaluations", tracksOf(results, "evaluations", cost), EVALUATIONS, costAxis),
    steps("Cost above the best against evaluations", tracksOf(results, "evaluations", seen), EVALUATIONS,
          { label: "cost above the best / %", log: true }),
  );
}

function reachedTracks(results, along) {
  return results.map((result) => {
    const reached = listOf(result.reached).filter((step) => step[along] > 0 && isNumber(step.success_rate));
    return { label: String(result.optimizer), at: reached.map((step) => step[along]), values: reached.map((step) => 100 * step.success_rate) };
  });
}

// Lines begin at no start and go on to the end of the chart: a share that was reached stays, and one that never was is seen.
function prolonged(tracks) {
  const all = tracks.flatMap((track) => track.at);
  if (all.length === 0) return tracks;
  const [begin, end] = [Math.min(...all) / 1.5, Math.max(...all) * 1.5];
  return tracks.map(({ label, at, values }) => ({
    label, at: [begin, ...at, end], values: [0, ...values, values[values.length - 1] ?? 0],
  }));
}

function success(results, target) {
  const share = { label: "starts / %", zero: true };
  const title = "Starts that came to the best cost";
  const near = isNumber(target) ? ` within ${significant(100 * target)} %` : "";
  return section(
    "Success over starts",
    note(`The share of the random starts from which an optimizer came${near} to the least cost that any run found, `,
         "within so many evaluations or so much time. All had the same starts."),
    successTable(results),
    element("div", { class: "columns" },
      steps(`${title}, against evaluations`, prolonged(reachedTracks(results, "evaluations")), EVALUATIONS, share),
      steps(`${title}, against time`, prolonged(reachedTracks(results, "wall_s")), TIME, share)),
  );
}

function resultsTable(results) {
  return table(
    [
      { title: "optimizer", of: (r) => r.optimizer, class: "name" },
      { title: "mean / %", of: (r) => r.mean_error_percent },
      { title: "max / %", of: (r) => r.max_error_percent },
      { title: "rmse / mV", of: (r) => times(1e3, r.rmse_V) },
      { title: "above the best / %", of: (r) => r.gap_percent, digits: 2 },
      { title: "time / s", of: (r) => r.wall_s, digits: 3 },
      { title: "evaluations", of: (r) => r.evaluations },
      { title: "gradients", of: (r) => r.gradient_evaluations },
      { title: "ended", of: (r) => r.termination },
    ],
    results,
    { sort: true, caption: "From the data's start: mean and maximum error of the voltage, and what it took" },
  );
}

function successTable(results) {
  return table(
    [
      { title: "optimizer", of: (r) => r.optimizer, class: "name" },
      { title: "success", of: (r) => `${r.successes} of ${r.starts}`, by: (r) => r.success_rate, class: "number" },
      { title: "median time to there / s", of: (r) => r.time_to_target_s, digits: 3 },
      { title: "median evaluations", of: (r) => r.evaluations_to_target },
      { title: "least cost / V²", of: (r) => r.best_cost_V2, digits: 6 },
    ],
    results,
    { sort: true, caption: "Starts from which the best cost was reached" },
  );
}

const unitOf = (name) => (/^(r|rho)_/.test(name) ? "Ohm" : /^c_/.test(name) ? "F" : /^tau_/.test(name) ? "s" : name === "beta" ? "s^-1/2" : "");
const withUnit = (name) => (unitOf(name) ? `${name} / ${unitOf(name)}` : name);

function foundTable(results) {
  const names = [...new Set(results.flatMap((r) => Object.keys(r.parameters ?? {})))];
  return table(
    [
      { title: "optimizer", of: (r) => r.optimizer, class: "name" },
      ...names.map((name) => ({ title: withUnit(name), of: (r) => (isNumber(r.parameters?.[name]) ? r.parameters[name] : null), digits: 6 })),
    ],
    results,
    { sort: true, caption: "What each optimizer found from the data's start" },
  );
}

// As the optimizers see it: over a typical value, or its logarithm.
function movedAs({ parameter, scale, logarithmic }) {
  const over = isNumber(scale) && scale !== 1 ? `${parameter}/${significant(scale)}` : String(parameter);
  return logarithmic ? `log(${over})` : over;
}

function problemTable(problem) {
  return table(
    [
      { title: "unknown", of: (p) => withUnit(String(p.parameter)) },
      { title: "start", of: (p) => p.start },
      { title: "lower bound", of: (p) => p.lower },
      { title: "upper bound", of: (p) => p.upper ?? "none" },
      { title: "box of random starts up to", of: (p) => p.box_upper },
      { title: "moved as", of: movedAs },
    ],
    problem,
    { caption: "What is free" },
  );
}

export const compare = {
  command: "compare",
  title: ({ summary }) => `Optimizers compared${summary.campaign ? `: ${summary.campaign}` : ""}`,
  parts: ({ summary }) => {
    const results = listOf(summary.results);
    const best = summary.best ?? {};
    const tied = listOf(best.tied);
    const cost = isNumber(best.cost_V2) ? `${significant(best.cost_V2, 6)} V²` : null;
    const random = results.some((r) => r.starts > 1);
    return [
      element("p", { class: "sentence" },
        !best.optimizer ? "No optimizer found a finite cost."
          : tied.length > 0 ? `A tie: ${[best.optimizer, ...tied].join(", ")} fit equally well${
            random ? ", each from its best start, where the table is from the data's start" : ""}, with a cost of ${cost}.`
          : `The best is ${best.optimizer}, with a cost of ${cost}.`),
      best.fit ? judgement(best.fit, "these logs") : null,
      summary.no_answer_because ? notice("error", `${summary.no_answer_because}.`) : null,
      listOf(summary.cautions).map((text) => notice("warning", text)),
      facts([["Campaign", summary.campaign], ["Rows", count(summary.rows)], ["Points after condensing", count(summary.points)],
             ["alpha / C", significant(summary.alpha_C)], ["from", alphaSource(summary.alpha_source)]]),
      listOf(summary.done_instead).map((text) => note(text)),
      resultsTable(results),
      disclosure("Why each ended", table(
        [{ title: "optimizer", of: (r) => r.optimizer, class: "name" }, { title: "its words", of: (r) => r.message }], results)),
      progress(results, best.cost_V2),
      random ? success(results, summary.options?.target)
        : section("Success over starts", note("Each ran once, from the data's start; `lipoid compare --starts 20` tries random starts, too.")),
      section("Parameters", foundTable(results), problemTable(listOf(summary.problem))),
    ];
  },
};
