// Where a result comes from: program, options, and the files that were read, with their hashes.
import { disclosure, element, facts, section } from "./dom.js";
import { table } from "./table.js";

const hash = (text) => element("span", { class: "hash" }, text);

/** run: the run record of a cell file, or that of a command. */
export function provenance(run) {
  if (!run) return null;
  const inputs = Array.isArray(run.inputs) ? run.inputs : [];
  const options = run.options && Object.keys(run.options).length > 0;
  return section(
    "Where this comes from",
    facts([
      ["Program", run.version ? `lipoid ${run.version} (${run.commit ?? "commit unknown"})` : null],
      ["Seed", run.seed],
      ["Command", run.command ? element("code", {}, run.command) : null],
    ]),
    inputs.length > 0
      ? table(
          [
            { title: "file that was read", of: ({ file }) => file },
            { title: "SHA-256", of: ({ sha256 }) => hash(sha256) },
          ],
          inputs,
          { caption: "Files by their contents" },
        )
      : null,
    options ? disclosure("All options", element("pre", {}, JSON.stringify(run.options, null, 2))) : null,
  );
}
