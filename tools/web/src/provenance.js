// Where a result comes from: program, options, and the files that were read, with their hashes.
import { disclosure, element, facts, section } from "./dom.js";
import { table } from "./table.js";

const hash = (text) => element("span", { class: "hash" }, text);

const word = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

/** run: the run record of a cell file, or that of a command, whose name it lacks; of: the file of one result among several. */
export function provenance(run, name, of = null) {
  if (!run) return null;
  const command = run.command ?? (Array.isArray(run.arguments) ? ["lipoid", name, ...run.arguments].map(word).join(" ") : null);
  const inputs = Array.isArray(run.inputs) ? run.inputs : [];
  const options = run.options && Object.keys(run.options).length > 0;
  return section(
    of ? `Where ${of} comes from` : "Where this comes from",
    facts([
      ["Program", run.version ? `lipoid ${run.version} (${run.commit ?? "commit unknown"})` : null],
      ["Seed", run.seed],
      ["Command", command ? element("code", {}, command) : null],
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
