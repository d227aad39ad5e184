// `lipoid design`: the gains that were found, how the search went, and where the poles lie.
import { lineChart } from "../chart.js";
import { facts, note, notice, section } from "../dom.js";
import { duration, significant } from "../format.js";
import { isNumber, listOf } from "../numbers.js";
import { rootLocus } from "../root_locus.js";
import { table } from "../table.js";

// As the command prints them: what the optimizer found, and what is written where that is another.
function gainsTable({ start, search: found, gains, cost, longer_run, bounds }, unit) {
  const missed = found && JSON.stringify(found.gains) !== JSON.stringify(gains);
  const rows = [
    { name: "start", gains: start?.gains, cost: start?.cost },
    missed ? { name: "found", gains: found.gains, cost: found.cost } : null,
    { name: missed ? "from there on" : "found", gains, cost },
    longer_run ? { name: "by a run ten times longer", gains: longer_run.gains, cost: longer_run.cost } : null,
    { name: "upper bound", gains: bounds, cost: null },
  ].filter((row) => row?.gains);
  return table(
    [
      { title: "gains", of: ({ name }) => name },
      { title: "K_e / (1/s²)", of: (row) => row.gains.proportional },
      { title: "K_eI / (1/s³)", of: (row) => row.gains.integral },
      { title: "K_edot / (1/s)", of: (row) => row.gains.derivative },
      { title: `cost / (${unit})`, of: (row) => row.cost },
    ],
    rows,
    { caption: "Gains of the error controller" },
  );
}

function search(summary, unit) {
  const steps = listOf(summary.improvements).filter((step) => isNumber(step.evaluations) && isNumber(step.cost));
  if (steps.length === 0) return note("The summary does not tell how the search went.");
  return lineChart({
    title: "Least cost so far",
    x: { label: "evaluations", values: steps.map(({ evaluations }) => evaluations), log: true },
    y: { label: `cost / (${unit})`, log: true },
    lines: [{ label: summary.optimizer, values: steps.map(({ cost }) => cost), step: "after", dots: steps.length < 100 }],
    height: 240,
  });
}

export const design = {
  command: "design",
  title: ({ summary }) => `Gains of the ${summary.loop} loop`,
  parts: ({ summary }) => {
    const unit = summary.loop === "altitude" ? "m² s" : "rad² s";
    const xi = listOf(summary.xi).filter(isNumber);
    const gap = summary.longer_run?.gap_percent;
    return [
      facts([
        ["Vehicle", summary.vehicle],
        ["Optimizer", summary.optimizer],
        ["Voltage ratios xi", xi.length > 1 ? `${significant(xi[0])} to ${significant(xi[xi.length - 1])}, ${xi.length} of them` : significant(xi[0])],
        ["Evaluations", summary.evaluations],
        ["Time", duration(summary.wall_s)],
        ["Ended", summary.termination],
        ["Above a run ten times longer", isNumber(gap) ? `${significant(gap, 3)} %` : null],
      ]),
      note(summary.message ?? ""),
      listOf(summary.cautions).map((text) => notice("warning", text)),
      gainsTable(summary, unit),
      section("The search", search(summary, unit)),
      section("Poles with the gains found", ...rootLocus(summary.poles, "the gains found")),
      section("Poles with the gains it started from", ...rootLocus(summary.start?.poles, "the gains at the start")),
    ];
  },
};
