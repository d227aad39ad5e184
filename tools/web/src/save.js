// What a reader takes along: a chart as SVG or PNG, its samples as CSV.
import { element } from "./dom.js";
import { fileStem } from "./format.js";
import { drawing, toPng, toSvg } from "./picture.js";

/** Gives the browser a file to keep. */
export function save(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// A spreadsheet takes a text that begins with one of these for a formula.
const inert = (text) => (/^[=+\-@\t\r]/.test(text) ? `'${text}` : text);
const quoted = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** Columns [{name, values}] of equal length as the text of a CSV file. */
export function csvText(columns) {
  const rows = [columns.map(({ name }) => quoted(inert(name))).join(",")];
  const say = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "";
    return typeof value === "number" ? String(value) : quoted(inert(String(value)));
  };
  for (let k = 0; k < columns[0].values.length; ++k) rows.push(columns.map(({ values }) => say(values[k])).join(","));
  return `${rows.join("\n")}\n`;
}

/** The samples of a chart, all of them, with the unit of y beside each name. */
export function chartCsv(plot, { x, y }) {
  const unit = y.label.includes(" / ") ? ` / ${y.label.split(" / ").pop()}` : "";
  const nameOf = (label) => (label.includes(" / ") ? label : label + unit);
  const columns = [{ name: x.label, values: x.categories ?? plot.data[0] }];
  for (let k = 1; k < plot.series.length; ++k) columns.push({ name: nameOf(plot.series[k].label), values: plot.data[k] });
  return csvText(columns);
}

/** A menu that saves the chart. */
export function saveMenu(plot, about) {
  const stem = fileStem(about.name);
  const picture = () => drawing(plot, about, plot.height);
  const ways = [
    ["SVG", () => save(new Blob([new XMLSerializer().serializeToString(toSvg(picture(), about.title))], { type: "image/svg+xml" }), `${stem}.svg`)],
    ["PNG", async () => save(await toPng(picture()), `${stem}.png`)],
    ["CSV", () => save(new Blob([chartCsv(plot, about)], { type: "text/csv" }), `${stem}.csv`)],
  ];
  const menu = element("details", { class: "menu" }, element("summary", {}, "Save"));
  const act = (run) => () => {
    menu.open = false;
    run();
  };
  menu.append(
    element("div", {}, ...ways.map(([name, run]) => element("button", { type: "button", onclick: act(run) }, `as ${name}`))),
  );
  return menu;
}
