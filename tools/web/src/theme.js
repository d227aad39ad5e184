// Colours of the style sheet, for what draws on a canvas: those of the page as it is shown, light or
// dark, and those of paper, which are the light ones always.

const seen = { page: new Map(), paper: new Map() };
const listeners = new Set();

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  seen.page.clear();
  for (const listener of listeners) listener();
});

/** Calls whenever the page turns dark or light. */
export function onThemeChange(listener) {
  listeners.add(listener);
}

// The element whose variables are those of paper; style.css has class "paper".
let sheet = null;
function holderOf(where) {
  if (where === "page") return document.documentElement;
  if (!sheet) {
    sheet = document.createElement("div");
    sheet.className = "paper";
    sheet.hidden = true;
    document.body.append(sheet);
  }
  return sheet;
}

/** The value of a variable, "--text"; `where` is "page" or "paper". */
export function colour(name, where = "page") {
  const known = seen[where];
  if (!known.has(name)) known.set(name, getComputedStyle(holderOf(where)).getPropertyValue(name).trim());
  return known.get(name);
}

const SERIES = 7;

/** Okabe and Ito's palette, told apart by people who are colour-blind; lighter on a dark page. */
export function seriesColour(index, where = "page") {
  return colour(`--series-${index % SERIES}`, where);
}

/** A colour #rrggbb that lets through what lies behind it. */
export function faint(hex, share = 0.2) {
  const alpha = Math.round(255 * share).toString(16).padStart(2, "0");
  return hex + alpha;
}
