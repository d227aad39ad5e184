// What runs, what waits and what is done.
import { useEffect, useRef, useState } from "preact/hooks";

import { getText, post, remove } from "./api.js";
import { bytes, count, duration } from "./words.js";

const STATUS = {
  queued: "waits",
  running: "runs",
  done: "done",
  failed: "failed",
  cancelled: "cancelled",
};

/** "identify, Nissan Leaf, 5 logs". */
export function titleOf(job) {
  const cell = job.cell_of ? `the cell of job ${job.cell_of}` : job.cell;
  if (job.command === "identify") return [`identify`, job.name || "the cell", count(job.logs, "log")].join(", ");
  if (job.command === "fly") return `fly ${job.maneuver}, ${cell}`;
  return `validate ${cell}, ${count(job.logs, "log")}`;
}

function optionText(options) {
  return options.map(([name, value]) => (value === undefined ? `--${name}` : `--${name} ${value}`)).join(" ");
}

/** Exit 1: a result that is doubted, or a flight that did not end as it should. */
const isDoubted = (job) => job.status === "done" && job.exit_code === 1;

function statusText(job) {
  return isDoubted(job) ? "done, with reservations" : STATUS[job.status];
}

function Outputs({ job }) {
  return (
    <ul class="outputs">
      {job.outputs
        .filter(({ name }) => !["output.txt", "messages.txt"].includes(name))
        .map(({ name, bytes: size }) => (
          <li key={name}>
            <a href={`jobs/${job.id}/${name}`} download>
              {name}
            </a>{" "}
            <span class="hint">{bytes(size)}</span>
          </li>
        ))}
    </ul>
  );
}

function Job({ job, selected, compared, act }) {
  const waits = job.status === "queued" || job.status === "running";
  const took = job.began_s && job.ended_s ? duration(job.ended_s - job.began_s) : "";
  return (
    <li class={selected ? "card job selected" : "card job"} data-job={job.id} data-status={job.status}>
      <div class="row">
        <h3>
          {job.id}. {titleOf(job)}
        </h3>
        <span class={`status ${isDoubted(job) ? "doubted" : job.status}`} role="status">
          {statusText(job)}
          {took && `, ${took}`}
        </span>
      </div>
      {job.options.length > 0 && <code class="hint">{optionText(job.options)}</code>}
      {job.status === "running" && (
        <div class="row">
          <progress max={1} value={job.fraction} aria-label={`Progress of job ${job.id}`} />
          <span class="hint">{job.doing}</span>
        </div>
      )}
      {job.verdict && <p>{job.verdict}</p>}
      {job.message && <pre class={job.status === "done" ? "message" : "error"}>{job.message}</pre>}
      {job.outputs && job.status === "done" && <Outputs job={job} />}
      <div class="row buttons">
        {waits && (
          <button type="button" onClick={() => act.run(() => post(`api/jobs/${job.id}/cancel`, {}))}>
            Cancel
          </button>
        )}
        {job.status === "done" && (
          <button type="button" aria-pressed={selected} onClick={() => act.select(selected ? null : job.id)}>
            {selected ? "Hide the result" : "Show the result"}
          </button>
        )}
        {job.status === "done" && job.command === "identify" && (
          <label class="compare">
            <input
              type="checkbox"
              checked={compared}
              onChange={(event) => act.compare(job.id, event.currentTarget.checked)}
            />
            compare
          </label>
        )}
        <button type="button" onClick={() => act.again(job)}>
          Take its options
        </button>
        {!waits && (
          <button type="button" aria-label={`Remove job ${job.id}`} onClick={() => act.run(() => remove(`api/jobs/${job.id}`))}>
            Remove
          </button>
        )}
      </div>
    </li>
  );
}

export function Jobs({ state, selected, compared, act }) {
  if (state.jobs.length === 0) return <p class="hint">Nothing was run yet.</p>;
  return (
    <ul class="cards" id="jobs">
      {[...state.jobs].reverse().map((job) => (
        <Job key={job.id} job={job} selected={job.id === selected} compared={compared.includes(job.id)} act={act} />
      ))}
    </ul>
  );
}

/** The report of a job, and what the command printed. */
export function Result({ job, program }) {
  const [text, setText] = useState("");
  const section = useRef(null);
  useEffect(() => {
    section.current.scrollIntoView({ block: "start" });
    let shown = true;
    setText("");
    getText(`jobs/${job.id}/output.txt`).then(
      (printed) => shown && setText(printed),
      () => {},
    );
    return () => {
      shown = false;
    };
  }, [job.id]);
  const report = job.outputs.some(({ name }) => name === "report.html");
  const address = `../${program.report_key}/jobs/${job.id}/report.html`;
  return (
    <section ref={section} class="result" aria-label={`Result of job ${job.id}`}>
      <h2>
        {job.id}. {titleOf(job)}
      </h2>
      {report && (
        <>
          <p>
            <a href={address} target="_blank" rel="noopener noreferrer">
              Open the report in a tab of its own
            </a>
          </p>
          <iframe title={`Report of job ${job.id}`} src={address} sandbox="allow-scripts allow-downloads" />
        </>
      )}
      <details open={!report}>
        <summary>What lipoid printed</summary>
        <pre class="terminal">{text}</pre>
      </details>
    </section>
  );
}
