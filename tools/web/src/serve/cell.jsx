// What a person says of the cell.
import { significant } from "../format.js";
import { TextField } from "./field.jsx";
import { number } from "./words.js";

export function CellForm({ state, act }) {
  const { cell, drafted } = state;
  const found = (value, unit) =>
    value === null || value === undefined ? "" : `${significant(value, 4)}${unit} (found)`;
  const change = (key, read) => (text) => act.run(() => act.change({ cell: { [key]: read(text) } }));
  const shown = (value) => (value === null ? "" : String(value));
  const name = (text) => (text.trim() === "" ? null : text.trim());
  return (
    <>
      <div class="fields">
        <TextField label="Name" value={shown(cell.name)} placeholder="The cell" onCommit={change("name", name)} />
        <TextField
          label="Nominal capacity / Ah"
          hint="of one cell; for C-rates and checks"
          inputMode="decimal"
          value={shown(cell.capacity_Ah)}
          placeholder={found(drafted.capacity_Ah, " Ah")}
          onCommit={change("capacity_Ah", number)}
        />
        <TextField
          label="Cut-off / V"
          hint="of one cell, at which a discharge ends"
          inputMode="decimal"
          value={shown(cell.cutoff_V)}
          placeholder={found(drafted.cutoff_V, " V")}
          onCommit={change("cutoff_V", number)}
        />
        <TextField
          label="Cells in series"
          inputMode="numeric"
          value={shown(cell.series)}
          placeholder={found(drafted.series, "")}
          onCommit={change("series", number)}
        />
        <TextField
          label="Cells in parallel"
          inputMode="numeric"
          value={shown(cell.parallel)}
          placeholder={found(drafted.parallel, "")}
          onCommit={change("parallel", number)}
        />
      </div>
      {(drafted.remarks ?? []).map((remark) => (
        <p key={remark} class="warning">
          {remark}
        </p>
      ))}
    </>
  );
}
