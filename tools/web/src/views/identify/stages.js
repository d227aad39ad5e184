// The stages of the thesis' method: what each of them found.
import { disclosure, element, notice, section } from "../../dom.js";
import { alphaSource, significant } from "../../format.js";
import { table } from "../../table.js";

const UNITS = [["alpha", "C"], ["beta", "s^-1/2"], ["r_", "Ω"], ["c_", "F"], ["tau_", "s"]];
const unitOf = (name) => UNITS.find(([start]) => name.startsWith(start))?.[1] ?? "";
const mV = (volts) => (typeof volts === "number" ? 1e3 * volts : null);

export function stages({ summary }) {
  const staged = summary.method === "joint" ? summary.staged : summary;
  const found = staged?.stages;
  if (!found?.pulses) return null;
  const [held, free] = [found.pulses_beta_held, found.pulses];
  const names = [...new Set([...Object.keys(held?.parameters ?? {}), ...Object.keys(free.parameters ?? {})])];
  const rows = [
    ...names.map((name) => ({ what: `${name} / ${unitOf(name)}`, held: held?.parameters?.[name], free: free.parameters?.[name] })),
    { what: "mean error / %", held: held?.mean_error_percent, free: free.mean_error_percent },
    { what: "maximum error / %", held: held?.max_error_percent, free: free.max_error_percent },
    { what: "rms / mV", held: mV(held?.rmse_V), free: mV(free.rmse_V) },
    { what: "evaluations", held: held?.evaluations, free: free.evaluations },
    { what: "time / s", held: held?.wall_s, free: free.wall_s },
    { what: "at a bound", held: held?.at_bound?.join(", "), free: free.at_bound?.join(", ") },
    { what: "why the search ended", held: held?.message, free: free.message },
  ];
  const content = [
    element("p", {}, `alpha is ${significant(staged.alpha_C, 6)} C, from ${alphaSource(staged.alpha_source)}. The fit of the pulses, with the beta of the discharge times held and with beta found anew:`),
    table(
      [
        { title: "stage 3", of: ({ what }) => what },
        { title: "beta held (4.60)", of: (row) => row.held, digits: 5 },
        { title: "beta free (4.61)", of: (row) => row.free, digits: 5 },
      ],
      rows,
    ),
    summary.method === "joint" ? (staged.cautions ?? []).map((text) => notice("warning", text)) : null,
  ];
  return summary.method === "joint"
    ? section("The staged method, for comparison", disclosure("What its stages found", content))
    : section("The stages", content);
}
