// The structures that the joint method tried, and which one held-out rows speak for.
import { element, note, section } from "../../dom.js";
import { significant } from "../../format.js";
import { table } from "../../table.js";

const mV = (volts) => (typeof volts === "number" ? 1e3 * volts : null);

export function tried({ summary }) {
  const rows = summary.joint?.tried ?? [];
  if (rows.length === 0) return null;
  const gain = ({ gain_V, gain_standard_error_V: error }) =>
    typeof gain_V === "number" && typeof error === "number" ? `${significant(1e3 * gain_V, 2)} ± ${significant(1e3 * error, 2)}` : "–";
  return section(
    "Structures tried",
    note("Each structure was fitted and judged by rows that it was not shown. The gain is by how much the structure taken predicts held-out rows better; where it does not exceed its own standard error, these rows do not tell the two structures apart."),
    table(
      [
        { title: "structure", of: ({ what, taken }) => (taken ? element("strong", {}, `${what} (taken)`) : what), by: ({ what }) => what },
        { title: "branches", of: ({ branches }) => branches },
        { title: "nodes of resistances", of: (row) => row.resistance_nodes },
        { title: "nodes of v_oc", of: (row) => row.voltage_nodes },
        { title: "fitted / mV", of: (row) => mV(row.fitted_V), digits: 3 },
        { title: "held out / mV", of: (row) => mV(row.left_out_V), digits: 3 },
        { title: "gain / mV", class: "number", of: gain, by: ({ gain_V }) => gain_V },
        { title: "weight", of: ({ weight }) => weight, digits: 2 },
        { title: "beta / s^-1/2", of: (row) => row.beta_per_sqrt_s },
        { title: "time constants / s", class: "number", of: (row) => (row.time_constants_s ?? []).map((value) => significant(value)).join(", "), by: (row) => row.time_constants_s?.[0] },
      ],
      rows,
      { sort: true, caption: "Errors are root mean squares over the logs" },
    ),
  );
}
