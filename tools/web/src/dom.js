// Elements of the page. Text is always set as text: a log called <script>.csv does nothing.

/** An element with attributes (or on... handlers) and children, which are elements or text. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

/** A part of the page under a heading. */
export function section(title, ...children) {
  return element("section", {}, element("h3", {}, title), ...children);
}
