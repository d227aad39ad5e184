// `lipoid identify`: a cell, how well it describes its logs, and how far to believe each number.
import { disclosure, element, notice } from "../dom.js";
import { plural } from "../format.js";
import { table } from "../table.js";
import { dischargeTimes } from "./identify/discharge_times.js";
import { flights } from "./identify/flights.js";
import { header } from "./identify/header.js";
import { logs } from "./identify/logs.js";
import { openCircuitVoltage } from "./identify/open_circuit_voltage.js";
import { known, parameters } from "./identify/parameters.js";
import { correlations } from "./identify/correlations.js";
import { profiles } from "./identify/profiles.js";
import { resistances } from "./identify/resistances.js";
import { stages } from "./identify/stages.js";
import { tried } from "./identify/tried.js";
import { spread } from "./identify/spread.js";
import { provenance } from "../provenance.js";

// One cell. `key` tells its charts from those of other cells of the page.
function cell(summary, series, program, key) {
  const result = { summary, series, program, key, cautions: sorted(summary) };
  return [
    header(result),
    known(result),
    parameters(result),
    logs(result),
    flights(result),
    dischargeTimes(result),
    openCircuitVoltage(result),
    resistances(result),
    correlations(result),
    profiles(result),
    tried(result),
    stages(result),
  ].filter((part) => part !== null);
}

// Each caution stands where it is about something that is seen; the others stand at the top.
function sorted(summary) {
  const places = { header: [], curve: [], parameters: [], logs: {} };
  const files = (summary.campaign?.logs ?? []).map(({ file }) => file);
  for (const text of [...(summary.cautions ?? []), ...(summary.flights?.cautions ?? []), ...(summary.log_notes ?? [])]) {
    const file = files.filter((name) => text.startsWith(name)).sort((a, b) => b.length - a.length)[0];
    if (file) (places.logs[file] ??= []).push(text);
    else if (/v_oc/.test(text)) places.curve.push(text);
    else if (/^branch|beta|tau_|r_s|r_\d/.test(text)) places.parameters.push(text);
    else places.header.push(text);
  }
  for (const log of summary.campaign?.logs ?? []) {
    const said = (places.logs[log.file] ??= []);
    said.push(...(log.warnings ?? []).filter((text) => !said.some((other) => other.endsWith(text))));
  }
  return places;
}

const nameOf = (summary) => summary.cell?.name || summary.campaign?.name || "The cell";

function batch({ summary, series, program }) {
  const failed = summary.failed ?? [];
  return [
    element("p", { class: "sentence" }, `${plural(summary.cells.length, "cell")} identified${
      failed.length > 0 ? `, ${plural(failed.length, "campaign")} not` : ""}.`),
    ...failed.map(({ campaign, message }) => notice("error", `${campaign} is not identified. ${message}`)),
    spread(summary),
    ...summary.cells.map((one, k) => {
      const part = disclosure(
        `${nameOf(one)}: ${one.verdict?.grade ?? "no verdict"}`,
        cell(one, series.filter(({ of }) => of === k), program, `cell ${k}`),
        provenance(one.cell?.run),
      );
      part.classList.add("cell");
      return part;
    }),
  ];
}

export const identify = {
  command: "identify",
  run: (summary) => summary.cell?.run ?? summary.run,  // that of the cell file, which lives longer
  title: ({ summary }) => (summary.cells ? "Cells identified" : nameOf(summary)),
  parts: (result) =>
    result.summary.cells ? batch(result) : cell(result.summary, result.series, result.program, "cell"),
};
