// Flights that were fitted with the lab logs: what each one's own unknowns are, what they add and what they cost.
import { facts, notice, section } from "../../dom.js";
import { baseName, plural, significant } from "../../format.js";
import { isNumber, listOf } from "../../numbers.js";
import { table } from "../../table.js";

const interval = (pair, digits = 3) =>
  (Array.isArray(pair) && pair.every(isNumber) ? `${significant(pair[0], digits)} to ${significant(pair[1], digits)}` : null);

const share = ({ standard_error, by_lab_standard_error }) => standard_error / by_lab_standard_error;

export function flights({ summary }) {
  const found = summary.flights_with_lab;
  if (!found) return null;
  const told = listOf(found.parameters).filter((one) => one.by_lab_standard_error > 0 && isNumber(one.standard_error));
  const most = [...told].sort((a, b) => share(a) - share(b)).slice(0, 8);
  return section(
    "Flights",
    found.taken
      ? facts([
          ["Fitted with the lab logs", plural(listOf(found.flights).length, "flight")],
          ["Mean error of the lab logs", `${significant(found.lab_mean_error_with_flights_percent, 3)} %, without the flights ${significant(found.lab_mean_error_percent, 3)} %`],
        ])
      : notice("warning", `The cell is that of the lab logs alone: ${found.not_taken_because}.`),
    table(
      [
        { title: "flight", of: ({ file }) => baseName(file) },
        { title: "charge at start", of: (one) => one.soc_start, digits: 3 },
        { title: "95 %", of: (one) => interval(one.soc_start_interval_95), class: "number" },
        { title: "true over shown current", of: (one) => one.current_scale, digits: 3 },
        { title: "95 %", of: (one) => interval(one.current_scale_interval_95), class: "number" },
        { title: "lag / s", of: (one) => one.lag_s, digits: 2 },
        { title: "mean error / %", of: (one) => one.mean_error_percent, digits: 2 },
      ],
      listOf(found.flights),
      { caption: "What each flight has of its own" },
    ),
    found.taken && most.length > 0
      ? table(
          [
            { title: "parameter", of: ({ name }) => name },
            { title: "by the lab", of: (one) => one.by_lab, digits: 5 },
            { title: "standard error", of: (one) => one.by_lab_standard_error, digits: 2 },
            { title: "with the flights", of: (one) => one.estimate, digits: 5 },
            { title: "standard error", of: (one) => one.standard_error, digits: 2 },
            { title: "unit", of: ({ unit }) => unit },
          ],
          most,
          { caption: "Where the flights add most" },
        )
      : null,
  );
}
