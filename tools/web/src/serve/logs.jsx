// Logs: where they are dropped, and what lipoid inspect says of each.
import { useRef, useState } from "preact/hooks";

import { significant } from "../format.js";
import { remove, upload } from "./api.js";
import { TextField, SelectField } from "./field.jsx";
import { KINDS, bytes, count, duration, number, spread } from "./words.js";

const LEFT_OUT = "";

// The files of a drop, and those of the folders in it that may be logs.
async function filesOf(transfer, no_logs) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (entries.length === 0) return [...transfer.files];
  const files = [];
  const may_be_log = (name) => !name.startsWith(".") && !no_logs.some((extension) => name.endsWith(extension));
  const take = async (entry, depth) => {
    if (depth > 0 && !may_be_log(entry.name)) return;
    if (entry.isFile) files.push(await new Promise((done, failed) => entry.file(done, failed)));
    else if (depth < 4) {
      const reader = entry.createReader();
      for (;;) {
        const some = await new Promise((done, failed) => reader.readEntries(done, failed));
        if (some.length === 0) break;
        for (const each of some) await take(each, depth + 1);
      }
    }
  };
  for (const entry of entries) await take(entry, 0);
  return files;
}

/** Uploads one file after another. */
export function DropZone({ program, ask }) {
  const [uploads, setUploads] = useState([]);
  const [over, setOver] = useState(false);
  const input = useRef(null);
  const last = useRef(Promise.resolve());
  const number = useRef(0);

  const send = (files) => {
    for (const file of files) {
      const key = ++number.current;
      const change = (news) =>
        setUploads((all) => all.map((each) => (each.key === key ? { ...each, ...news } : each)));
      setUploads((all) => [...all, { key, name: file.name, total: file.size, sent: 0 }]);
      last.current = last.current.then(async () => {
        try {
          if (file.size > program.file_bytes)
            throw new Error(
              `this file has ${bytes(file.size)}, and a file may have ${bytes(program.file_bytes)}; start lipoid serve with a larger --max-file-MB`,
            );
          await upload(file, (sent) => change({ sent }));
          setUploads((all) => all.filter((each) => each.key !== key));
        } catch (error) {
          change({ error: error.message });
        }
        ask();
      });
    }
  };

  return (
    <>
      <div
        class={over ? "drop over" : "drop"}
        onDragOver={(event) => {
          event.preventDefault();
          setOver(true);
        }}
        onDragLeave={() => setOver(false)}
        onDrop={async (event) => {
          event.preventDefault();
          setOver(false);
          send(await filesOf(event.dataTransfer, program.no_logs));
        }}
      >
        <p>Drop logs of one cell here, or a folder of them.</p>
        <button type="button" onClick={() => input.current.click()}>
          Choose files
        </button>
        <input
          ref={input}
          id="files"
          type="file"
          multiple
          hidden
          aria-label="Logs"
          onChange={(event) => {
            send([...event.currentTarget.files]);
            event.currentTarget.value = "";
          }}
        />
      </div>
      <ul class="cards" aria-live="polite">
        {uploads.map(({ key, name, total, sent, error }) => (
          <li key={key} class="card upload">
            <div class="row">
              <strong>{name}</strong>
              {error ? (
                <button type="button" onClick={() => setUploads((all) => all.filter((each) => each.key !== key))}>
                  Dismiss
                </button>
              ) : (
                <progress max={Math.max(total, 1)} value={sent} aria-label={`Sending ${name}`} />
              )}
            </div>
            {error && <pre class="error">{error}</pre>}
          </li>
        ))}
      </ul>
    </>
  );
}

// What lipoid found of a test, and what a person says of it.
function Test({ row, act }) {
  const suggested = row.suggested ?? LEFT_OUT;
  const shown = (name, words) => (name === suggested ? `${words} (suggested)` : words);
  const choices = [...KINDS, [LEFT_OUT, "leave out"]].map(([name, words]) => [name, shown(name, words)]);
  const part = row.start_s === undefined ? "" : `${significant(row.start_s, 6)} s to ${significant(row.end_s, 6)} s`;
  const change = (said) => act.change({ tests: { [row.key]: said } });
  const text = (value) => (value === null ? "" : String(value));
  return (
    <div class="kind">
      <SelectField
        label={part ? `Kind, ${part}` : "Kind"}
        value={row.kind ?? LEFT_OUT}
        choices={choices}
        onCommit={(kind) => change({ kind: kind === suggested ? null : kind })}
      />
      <div class="why">
        <p>{row.reason}</p>
        {row.left_out && <p>Left out: {row.left_out}.</p>}
        {row.remarks.map((remark) => (
          <p key={remark}>{remark}</p>
        ))}
        <details open={row.initial_soc !== null || row.ambient_degC !== null || row.found_initial_soc !== 1}>
          <summary>Where it starts</summary>
          <div class="fields">
            <TextField
              label="State of charge at the start"
              hint="1 is full"
              inputMode="decimal"
              value={text(row.initial_soc)}
              placeholder={row.found_initial_soc === 1 ? "1" : `${significant(row.found_initial_soc, 3)} (found)`}
              onCommit={(typed) => act.run(() => change({ initial_soc: number(typed) }))}
            />
            <TextField
              label="Surroundings / °C"
              hint="where the log has no temperature"
              inputMode="decimal"
              value={text(row.ambient_degC)}
              placeholder="not told"
              onCommit={(typed) => act.run(() => change({ ambient_degC: number(typed) }))}
            />
          </div>
        </details>
      </div>
    </div>
  );
}

function Facts({ inspection }) {
  const { format, rows, duration_s, current_A, voltage_V, charge_out_C, series, temperature_degC } = inspection;
  const facts = [
    format,
    count(rows, "row"),
    duration(duration_s),
    spread(current_A, "A"),
    spread(voltage_V, "V"),
    temperature_degC && spread(temperature_degC, "°C"),
    `${significant(charge_out_C / 3600, 4)} Ah out`,
    series > 1 && `${series} cells in series, ${inspection.flight?.cells ? "as the autopilot was told" : "by the voltage"}`,
  ].filter(Boolean);
  const dropped = inspection.dropped_rows;
  const segments = Object.entries(inspection.segments_of_kind ?? {})
    .map(([kind, number]) => `${number} ${kind}`)
    .join(", ");
  return (
    <>
      <p class="read">{facts.join(" · ")}</p>
      {inspection.warnings.map((warning) => (
        <p key={warning} class="warning">
          {warning}
        </p>
      ))}
      <details>
        <summary>How it was read</summary>
        <ul>
          <li>{inspection.current_sign_reason}</li>
          {dropped > 0 && <li>{count(dropped, "row")} dropped</li>}
          {inspection.gaps > 0 && <li>{count(inspection.gaps, "gap")} in time</li>}
          {segments && <li>segments: {segments}</li>}
          {inspection.notes.map((note) => (
            <li key={note}>{note}</li>
          ))}
        </ul>
      </details>
    </>
  );
}

export function LogCards({ state, act }) {
  if (state.files.length === 0) return null;
  return (
    <ul class="cards" id="logs">
      {state.files.map((file) => (
        <li key={file.id} class="card log" data-status={file.status}>
          <div class="row">
            <h3>{file.name}</h3>
            <span class="hint">{bytes(file.bytes)}</span>
            <button type="button" aria-label={`Remove ${file.name}`} onClick={() => act.run(() => remove(`api/files/${file.id}`))}>
              Remove
            </button>
          </div>
          {file.kept_as !== file.name && <p class="hint">called {file.kept_as} from here on</p>}
          {file.status === "waiting" && <p class="hint">is being read …</p>}
          {file.error && <pre class="error">{file.error}</pre>}
          {file.inspection && <Facts inspection={file.inspection} />}
          {state.rows
            .filter((row) => row.file === file.id)
            .map((row) => (
              <Test key={row.key} row={row} act={act} />
            ))}
        </li>
      ))}
    </ul>
  );
}

/** How all logs are read, for what lipoid cannot find. */
export function ReadingForm({ state, act }) {
  const { columns = [], units = "", current_sign = "", hold = "", battery = "" } = state.reading;
  const change = (key) => (value) => act.change({ reading: { [key]: value } });
  return (
    <details open={columns.length > 0 || units !== "" || [current_sign, hold, battery].some(Boolean)}>
      <summary>How to read these logs</summary>
      <p class="hint">Only needed where a log is refused and its message asks for one of these.</p>
      <div class="fields">
        <TextField
          label="Columns (--columns)"
          hint="the header's names, with commas between: time_s=Zeit, current_A=Strom, voltage_V=U"
          value={columns.join(", ")}
          placeholder="as found"
          onCommit={(text) => change("columns")(text.split(",").map((each) => each.trim()).filter(Boolean))}
        />
        <TextField
          label="Units (--units)"
          hint="of time, current and voltage where the header states none: s,A,V"
          value={units}
          placeholder="as found"
          onCommit={(text) => change("units")(text.trim())}
        />
        <SelectField
          label="Current (--current-sign)"
          value={current_sign}
          choices={[
            ["", "sign as found"],
            ["discharge-positive", "discharge is positive"],
            ["discharge-negative", "discharge is negative"],
          ]}
          onCommit={change("current_sign")}
        />
        <SelectField
          label="A row's current holds (--hold)"
          value={hold}
          choices={[
            ["", "since the row before (default)"],
            ["forward", "until the next row"],
          ]}
          onCommit={change("hold")}
        />
        <TextField
          label="Battery of a flight log (--battery)"
          hint="its number, where the autopilot watched several"
          value={battery}
          placeholder="as found"
          onCommit={(text) => change("battery")(text.trim())}
        />
      </div>
    </details>
  );
}
