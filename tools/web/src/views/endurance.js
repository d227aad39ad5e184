// `lipoid endurance`: how long a vehicle flies on a pack, and how far that is known.
import { element, facts, note } from "../dom.js";
import { significant } from "../format.js";
import { isNumber } from "../numbers.js";
import { provenance } from "../provenance.js";
import { table } from "../table.js";

const SUFFIX = "_interval_95";

const ENDED = {
  reserve: "the charge that is left was down to the reserve",
  "cut-off": "the battery was below its cut-off",
  empty: "the charge that is available at this current was used up",
  "motor-voltage": "the motors need more voltage than the battery gives",
  power: "no current of the battery gives the power any more",
  "mission-done": "the mission was flown to its end",
  "time-limit": "the calculation ended before the battery did",
};

// "landing_voltage_V": landing voltage / V.
function words(key) {
  const parts = key.split("_");
  const unit = parts.length > 1 && /^(V|A|Ah|Wh|W|degC|C|s)$/.test(parts[parts.length - 1]) ? parts.pop() : null;
  return `${parts.join(" ")}${unit ? ` / ${unit.replace("degC", "°C")}` : ""}`;
}

export const endurance = {
  command: "endurance",
  title: ({ summary }) => (isNumber(summary.minutes) ? `${significant(summary.minutes, 3)} minutes until landing` : "Endurance"),
  parts: ({ summary }) => {
    const rows = Object.keys(summary)
      .filter((key) => isNumber(summary[key]) && key + SUFFIX in summary)
      .map((key) => ({ key, interval: summary[key + SUFFIX] }));
    const known = rows.some(({ interval }) => Array.isArray(interval));
    return [
      element("p", { class: "sentence" }, `The flight ends because ${ENDED[summary.ended_by] ?? summary.ended_by}.`),
      facts([
        ["Vehicle", summary.vehicle],
        ["Battery", `${summary.series}S${summary.parallel}P of ${summary.cell}`],
        ["Mission", summary.mission],
        ["Flights drawn", summary.ensemble?.flights],
      ]),
      table(
        [
          { title: "until landing", of: ({ key }) => words(key) },
          { title: "estimate", of: ({ key }) => summary[key] },
          { title: "95 % from", of: ({ interval }) => interval?.[0] ?? null },
          { title: "to", of: ({ interval }) => interval?.[1] ?? null },
        ],
        rows,
        { caption: known ? "With the intervals that hold 95 % of what the uncertainties allow" : "Nothing that is uncertain was given" },
      ),
      known ? null : note("Give a cell with `uncertainty`, as lipoid identify writes it, or values as X+-SE, for intervals."),
      provenance(summary.run),
    ];
  },
};
