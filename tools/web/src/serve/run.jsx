// Forms that start jobs.
import { useKept } from "./api.js";
import { SelectField } from "./field.jsx";
import { OptionsForm, optionsOf } from "./options.jsx";
import { count } from "./words.js";

export function IdentifyForm({ state, program, chosen, onChange, act }) {
  const command = program.commands.identify;
  const taking_part = state.rows.filter(({ kind }) => kind).length;
  const problems = taking_part === 0 ? ["No log takes part yet: drop some, and mark the kind of each."] : (state.problems ?? []);
  return (
    <>
      <OptionsForm command={command} first={["method", "branches", "fix", "bounds"]} chosen={chosen} onChange={onChange} />
      {state.files.length > 0 &&
        problems.map((problem) => (
          <p key={problem} class="warning">
            {problem}
          </p>
        ))}
      <div class="row buttons">
        <button
          type="button"
          id="identify"
          class="main"
          disabled={problems.length > 0 || state.inspecting}
          onClick={() => act.start({ command: "identify", options: optionsOf(command, chosen) })}
        >
          Identify
        </button>
        {taking_part > 0 && <span class="hint">{count(taking_part, "test")} of these logs take part</span>}
        {taking_part > 0 && (
          <a href="campaign.toml" download>
            campaign.toml
          </a>
        )}
      </div>
    </>
  );
}

// Cells that jobs found, newest first, and those that lipoid ships.
function cellChoices(state, program) {
  const found = state.jobs
    .filter(({ command, status }) => command === "identify" && status === "done")
    .map(({ id, name }) => [`job ${id}`, `job ${id}, ${name || "the cell"}`])
    .reverse();
  return [...found, ...program.commands.fly.cells.map((name) => [name, name])];
}

function askedCell(name) {
  const job = /^job (\d+)$/.exec(name);
  return job ? { cell_of: Number(job[1]) } : { cell: name };
}

function present(choices, name) {
  return choices.some(([each]) => each === name) ? name : choices[0][0];
}

export function FlyForm({ state, program, chosen, onChange, act }) {
  const command = program.commands.fly;
  const [kept_cell, setCell] = useKept("fly.cell", "");
  const [maneuver, setManeuver] = useKept("fly.maneuver", "altitude-steps");
  const cells = cellChoices(state, program);
  const cell = present(cells, kept_cell);
  return (
    <>
      <div class="fields">
        <SelectField label="Cell" value={cell} choices={cells} onCommit={(name) => setCell(() => name)} />
        <SelectField
          label="Maneuver"
          value={maneuver}
          choices={command.maneuvers.map((name) => [name, name])}
          onCommit={(name) => setManeuver(() => name)}
        />
      </div>
      <OptionsForm command={command} first={["vehicle", "compensate"]} chosen={chosen} onChange={onChange} />
      <div class="row buttons">
        <button
          type="button"
          id="fly"
          onClick={() =>
            act.start({ command: "fly", maneuver, ...askedCell(cell), options: optionsOf(command, chosen) })
          }
        >
          Fly
        </button>
      </div>
    </>
  );
}

export function ValidateForm({ state, program, chosen, onChange, act }) {
  const command = program.commands.validate;
  const [kept_cell, setCell] = useKept("validate.cell", "");
  const [unmarked, setUnmarked] = useKept("validate.without", []);
  const cells = cellChoices(state, program);
  const cell = present(cells, kept_cell);
  const read = state.files.filter(({ status }) => status === "read");
  const logs = read.filter(({ id }) => !unmarked.includes(id)).map(({ id }) => id);
  return (
    <>
      <div class="fields">
        <SelectField label="Cell" value={cell} choices={cells} onCommit={(name) => setCell(() => name)} />
      </div>
      <fieldset>
        <legend>Logs</legend>
        {read.length === 0 && <p class="hint">No log is read yet.</p>}
        {read.map(({ id, name }) => (
          <label key={id} class="check">
            <input
              type="checkbox"
              checked={!unmarked.includes(id)}
              onChange={({ currentTarget: { checked } }) =>
                setUnmarked((now) => (checked ? now.filter((each) => each !== id) : [...now, id]))
              }
            />{" "}
            {name}
          </label>
        ))}
      </fieldset>
      <OptionsForm command={command} first={[]} chosen={chosen} onChange={onChange} />
      <div class="row buttons">
        <button
          type="button"
          id="validate"
          disabled={logs.length === 0}
          onClick={() =>
            act.start({ command: "validate", ...askedCell(cell), logs, options: optionsOf(command, chosen) })
          }
        >
          Validate
        </button>
      </div>
    </>
  );
}
