// What a lab prints over a result: cell, date, logs, the verdict, the error to expect.
import { element, facts, notice } from "../../dom.js";
import { duration, plural, significant } from "../../format.js";

const sum = (values) => values.reduce((a, b) => a + b, 0);

function logsInWords(logs) {
  const kinds = new Map();
  for (const { kind } of logs) kinds.set(kind, (kinds.get(kind) ?? 0) + 1);
  const parts = [...kinds].map(([kind, number]) => `${number} ${kind}`);
  return `${plural(logs.length, "log")} (${parts.join(", ")}), ${plural(sum(logs.map(({ rows }) => rows)), "row")}, ${duration(
    sum(logs.map(({ duration_s }) => duration_s)))}`;
}

// The staged method judges the logs of one kind.
const PART = { "pulses": "pulses", "constant-current": "discharges" };

function verdictSentence({ verdict, fitted_kind: kind, flights }) {
  const averaged = flights?.averaged;
  if (!verdict) return null;
  const { grade, rmse_V, mean_error_percent, reasons } = verdict;
  const part = PART[kind] ? ` (${PART[kind]} alone)` : averaged ? ` (${averaged})` : "";
  return judgement({ verdict: grade, rmse_V, mean_error_percent, reason: (reasons ?? []).join("; ") }, `its own logs${part}`);
}

/** The key `fit` of a summary as a sentence; `what` are the logs that it is of. */
export function judgement({ verdict, rmse_V, mean_error_percent, reason }, what) {
  const error = typeof rmse_V === "number"
    ? `The cell predicts ${what} to ${significant(1e3 * rmse_V, 3)} mV (${significant(mean_error_percent, 2)} %): `
    : `How the cell predicts ${what} is not known: `;
  return element("p", { class: "sentence" }, error, element("span", { class: `grade ${verdict}` }, verdict), reason ? `, because ${reason}` : "", ".");
}

function expectedError({ expected_error_percent: error, expected_error_interval_95: interval }) {
  if (typeof error !== "number") return "not known: the logs leave too little to hold out";
  const [low, high] = interval ?? [];
  const range = typeof low === "number" && typeof high === "number" ? ` (95 %: ${significant(low, 3)} % to ${significant(high, 3)} %)` : "";
  return `${significant(error, 3)} %${range}`;
}

const METHOD = { joint: "all logs at once (joint)", staged: "stage by stage (staged)" };

function solverMessage(summary) {
  return summary.joint?.message ?? summary.stages?.pulses?.message;
}

export function header({ summary, program, cautions }) {
  const { cell, campaign } = summary;
  const pack = campaign && (campaign.series > 1 || campaign.parallel > 1) ? `${campaign.series} in series, ${campaign.parallel} parallel; numbers are of one cell` : null;
  return element(
    "header",
    {},
    verdictSentence(summary),
    summary.converged === false
      ? notice("error", `The search did not converge${solverMessage(summary) ? `: ${solverMessage(summary)}` : ""}. The numbers below are where it stopped.`)
      : null,
    facts([
      ["Cell", cell?.name || campaign?.name || "no name"],
      ["Date", program?.written],
      ["Logs", campaign ? logsInWords(campaign.logs) : null],
      ["Pack", pack],
      ["Method", METHOD[summary.method] ?? summary.method],
      [`Mean error to expect of new ${PART[summary.fitted_kind] ?? "logs of these kinds"}`, expectedError(summary)],
      ["Nominal capacity", campaign?.capacity_Ah ? `${significant(campaign.capacity_Ah)} Ah` : null],
      ["Cut-off", cell?.cutoff_V ? `${significant(cell.cutoff_V)} V` : null],
      ["Cell file", summary.file],
      ["Time taken", typeof summary.wall_s === "number" ? duration(Number(summary.wall_s.toPrecision(3))) : null],
    ]),
    (summary.done_instead ?? []).map((text) =>
      notice("warning", summary.method === "joint" ? `Staged method, from which the joint fit started: ${text}` : text)),
    cautions.header.map((text) => notice("warning", text)),
  );
}
