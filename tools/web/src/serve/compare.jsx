// Two identified cells side by side.
import { useEffect, useState } from "preact/hooks";

import { significant } from "../format.js";
import { get } from "./api.js";
import { titleOf } from "./jobs.jsx";

function useSummary(id) {
  const [summary, setSummary] = useState(null);
  useEffect(() => {
    let wanted = true;
    setSummary(null);
    get(`jobs/${id}/summary.json`).then(
      (answer) => wanted && setSummary(answer),
      () => {},
    );
    return () => {
      wanted = false;
    };
  }, [id]);
  return summary;
}

const number = (value, digits = 4) =>
  typeof value === "number" && Number.isFinite(value) ? significant(value, digits) : "–";

const estimate = (parameter) =>
  !parameter
    ? "–"
    : parameter.standard_error
      ? `${number(parameter.estimate)} ± ${number(parameter.standard_error, 2)}`
      : number(parameter.estimate);

// Of the second to the first, in percent of the first.
function difference(a, b) {
  if (typeof a !== "number" || typeof b !== "number" || a === 0) return "–";
  const percent = (100 * (b - a)) / Math.abs(a);
  return `${percent > 0 ? "+" : ""}${significant(percent, 3)} %`;
}

// Whether both intervals at 95 % exclude each other.
function apart(a, b) {
  const [a_low, a_high] = a?.interval_95 ?? [];
  const [b_low, b_high] = b?.interval_95 ?? [];
  if ([a_low, a_high, b_low, b_high].some((value) => typeof value !== "number")) return "–";
  return a_low > b_high || b_low > a_high ? "yes" : "no";
}

function rowsOf(a, b) {
  const byName = (summary) => new Map((summary.parameters ?? []).map((each) => [each.name, each]));
  const [of_a, of_b] = [byName(a), byName(b)];
  return [...new Set([...of_a.keys(), ...of_b.keys()])].map((name) => {
    const [left, right] = [of_a.get(name), of_b.get(name)];
    return {
      name,
      unit: (left ?? right).unit,
      left: estimate(left),
      right: estimate(right),
      difference: difference(left?.estimate, right?.estimate),
      apart: apart(left, right),
    };
  });
}

function qualityOf(a, b) {
  const rows = [
    ["verdict", (s) => s.verdict?.grade ?? "–"],
    ["method", (s) => s.method],
    ["mean error of its own logs", (s) => s.verdict?.mean_error_percent, "%"],
    ["rmse of its own logs", (s) => 1e3 * s.verdict?.rmse_V, "mV"],
    ["mean error to expect of a new log", (s) => s.expected_error_percent, "%"],
    ["branches", (s) => s.cell?.branches?.length],
    ["time", (s) => s.wall_s, "s"],
  ];
  return rows.map(([name, of, unit = ""]) => {
    const [left, right] = [of(a), of(b)];
    const shown = (value) => (typeof value === "string" ? value : number(value));
    return { name, unit, left: shown(left), right: shown(right), difference: unit && difference(left, right), apart: "" };
  });
}

export function Compare({ jobs }) {
  const [first, second] = jobs;
  const a = useSummary(first.id);
  const b = useSummary(second.id);
  if (!a || !b) return null;
  return (
    <section id="compare">
      <h2>
        Job {first.id} and job {second.id} side by side
      </h2>
      <div class="scroll">
        <table>
          <thead>
            <tr>
              <th scope="col">quantity</th>
              <th scope="col">unit</th>
              {[first, second].map((job) => (
                <th scope="col" key={job.id} title={titleOf(job)}>
                  job {job.id}
                </th>
              ))}
              <th scope="col">difference</th>
              <th scope="col">apart at 95 %</th>
            </tr>
          </thead>
          <tbody>
            {[...qualityOf(a, b), ...rowsOf(a, b)].map((row) => (
              <tr key={row.name}>
                <th scope="row">{row.name}</th>
                <td>{row.unit}</td>
                <td class="number">{row.left}</td>
                <td class="number">{row.right}</td>
                <td class="number">{row.difference}</td>
                <td>{row.apart}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p class="hint">
        Estimates with their standard errors; the difference is that of job {second.id} in percent of job {first.id};
        “apart” says whether the intervals at 95 % exclude each other.
      </p>
    </section>
  );
}
