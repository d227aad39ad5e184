// Entry of the page of lipoid serve.
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";

import { get, post, useKept, useWorkbench } from "./serve/api.js";
import { CellForm } from "./serve/cell.jsx";
import { Compare } from "./serve/compare.jsx";
import { Jobs, Result } from "./serve/jobs.jsx";
import { DropZone, LogCards, ReadingForm } from "./serve/logs.jsx";
import { chosenOf } from "./serve/options.jsx";
import { FlyForm, IdentifyForm, ValidateForm } from "./serve/run.jsx";

const selectedOfAddress = () => Number(/^#job-(\d+)$/.exec(location.hash)?.[1] ?? 0) || null;

function Bench({ program }) {
  const { state, lost, ask } = useWorkbench();
  const [problem, setProblem] = useState("");
  const [selected, setSelected] = useState(selectedOfAddress);
  const [compared, setCompared] = useKept("compared", []);
  const [chosen, setChosen] = useKept("chosen", { identify: {}, fly: {}, validate: {} });

  useEffect(() => {
    const changed = () => setSelected(selectedOfAddress());
    addEventListener("hashchange", changed);
    return () => removeEventListener("hashchange", changed);
  }, []);
  useEffect(() => {
    if (state) document.documentElement.dataset.ready = "yes"; // for who waits until all is there
  }, [state !== null]);
  if (!state) return lost ? <p class="error">{lost}</p> : null;

  const act = {
    // Does what the server may refuse, and shows what it says; whether it was done.
    run: async (action) => {
      let done = true;
      try {
        setProblem("");
        done = (await action()) !== false;
      } catch (error) {
        setProblem(error.message);
        done = false;
      }
      ask();
      return done;
    },
    change: (change) => act.run(() => post("api/change", change)),
    start: (asked) => act.run(() => post("api/jobs", asked)),
    select: (id) => {
      location.hash = id === null ? "" : `job-${id}`;
    },
    compare: (id, wanted) =>
      setCompared((now) => {
        const others = now.filter((each) => each !== id);
        return wanted ? [...others, id].slice(-2) : others;
      }),
    again: (job) => {
      setChosen((now) => ({ ...now, [job.command]: chosenOf(program.commands[job.command], job.options) }));
      document.getElementById(job.command)?.scrollIntoView({ block: "center" });
    },
  };
  const form = (command) => ({
    state,
    program,
    act,
    chosen: chosen[command],
    onChange: (change) => setChosen((now) => ({ ...now, [command]: change(now[command]) })),
  });
  const shown = state.jobs.find(({ id, status }) => id === selected && status === "done");
  const pair = [...compared].sort((a, b) => a - b).map((id) => state.jobs.find((job) => job.id === id && job.status === "done")).filter(Boolean);
  return (
    <>
      <header>
        <h1>lipoid</h1>
        <p class="hint">{program.version}; everything stays on this machine, and goes when lipoid serve ends</p>
      </header>
      {lost && (
        <p class="error" role="alert">
          {lost}
        </p>
      )}
      {problem && (
        <div class="error row" role="alert">
          <span>{problem}</span>
          <button type="button" onClick={() => setProblem("")}>
            Dismiss
          </button>
        </div>
      )}
      <section aria-label="Logs">
        <h2>Logs</h2>
        <DropZone program={program} ask={ask} />
        <LogCards state={state} act={act} />
        {state.files.length > 0 && <ReadingForm state={state} act={act} />}
      </section>
      <section aria-label="Cell">
        <h2>Cell</h2>
        <CellForm state={state} act={act} />
      </section>
      <section aria-label="Identify">
        <h2>Identify</h2>
        <IdentifyForm {...form("identify")} />
      </section>
      <section aria-label="Jobs">
        <h2>Jobs</h2>
        <Jobs state={state} selected={selected} compared={compared} act={act} />
      </section>
      {pair.length === 2 && <Compare jobs={pair} />}
      {shown && <Result job={shown} program={program} />}
      <section aria-label="Use the cell">
        <h2>Use the cell</h2>
        <details id="use-fly">
          <summary>Fly a maneuver</summary>
          <FlyForm {...form("fly")} />
        </details>
        <details id="use-validate">
          <summary>Validate it on logs</summary>
          <ValidateForm {...form("validate")} />
        </details>
      </section>
    </>
  );
}

function App() {
  const [program, setProgram] = useState(null);
  const [problem, setProblem] = useState("");
  useEffect(() => {
    get("api/program").then(setProgram, (error) => setProblem(error.message));
  }, []);
  if (problem) return <p class="error">{problem}</p>;
  return program && <Bench program={program} />;
}

render(<App />, document.querySelector("main"));
