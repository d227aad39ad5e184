// Elements of the page. Text is always set as text: a log called <script>.csv does nothing.

/** An element with attributes (or on... handlers) and children, which are elements or text. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

/** A part of the page under a heading. */
export function section(title, ...children) {
  return element("section", {}, element("h3", {}, title), ...children);
}

/** A sentence that explains what stands under it. */
export function note(...text) {
  return element("p", { class: "note" }, ...text);
}

/** What a reader must not overlook; kind is "warning" or "error". */
export function notice(kind, ...text) {
  const word = { warning: "Caution", error: "Error" }[kind];
  return element("p", { class: `notice ${kind}`, role: "note" }, element("strong", {}, `${word}: `), ...text);
}

/** Words that open to more. */
export function disclosure(title, ...children) {
  return element("details", {}, element("summary", {}, title), ...children);
}

/** Names and what they stand for; what has no value is left out. */
export function facts(rows) {
  return element(
    "dl",
    { class: "facts" },
    ...rows
      .filter(([, value]) => value !== null && value !== undefined && value !== "")
      .map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))),
  );
}
