// `lipoid health`: capacity and resistance of a pack by flights on it, each with its interval, and over the flights.
import { lineChart } from "../chart.js";
import { element, facts, note, notice, section } from "../dom.js";
import { baseName, duration, interval, plural, significant } from "../format.js";
import { isNumber, listOf, times } from "../numbers.js";
import { table } from "../table.js";

// What stands under an interval's name: "soc_start_interval_95", or with the unit's place taken, "capacity_interval_95".
const intervalOf = (one, name) => one[`${name}_interval_95`] ?? one[`${name.replace(/_[A-Za-z]+$/, "")}_interval_95`];

function overFlights(all, name, title, label, factor) {
  // A copy of an earlier flight is no flight of its own, and a search that stopped says nothing: for the trend neither.
  const flights = all.map((one) => (one.same_rows_as || one.converged === false ? {} : one));
  const ends = (side) => flights.map((one) => times(factor(one), intervalOf(one, name)?.[side]));
  return lineChart({
    title,
    x: { label: "flight", values: flights.map((_, k) => k + 1), whole: true },
    y: { label, zero: true },
    lines: [{ label: "as the sensor counts, with its 95 % interval", values: flights.map((one) => times(factor(one), one[name])), band: [ends(0), ends(1)], dots: true }],
    name: title,
  });
}

function trendFacts(trend) {
  const change = (one, what) =>
    (one ? [what, `${significant(one.change_percent, 3)} % over ${plural(one.flights, "flight")} (95 %: ${interval(one.change_interval_95 ?? one.change_percent_interval_95) ?? "unknown"})`] : null);
  return facts([change(trend.counted_capacity_Ah, "Capacity"), change(trend.counted_resistance_Ohm, "Resistance")].filter(Boolean));
}

export const health = {
  command: "health",
  title: () => "Health of a pack, by its flights",
  parts: ({ summary }) => {
    const flights = listOf(summary.flights);
    const reference = summary.reference ?? {};
    const sentences = listOf(summary.sentences);
    // A resistance is that after a time which the sampling of each flight sets: only shares of the new one compare.
    const ofNew = flights.every((one) => isNumber(one.new_resistance_Ohm) || !isNumber(one.counted_resistance_Ohm));
    const doubts = (text, { doubted_because }) => Boolean(doubted_because) && text.includes(doubted_because);
    return [
      sentences.map((text) => element("p", { class: flights.some((one) => doubts(text, one)) ? "sentence notice warning" : "sentence" }, text)),
      facts([
        ["Flights", plural(flights.length, "flight")],
        ["When new", isNumber(reference.capacity_Ah) ? `${significant(reference.capacity_Ah)} Ah` : null],
        ["Reference", reference.typical ? `${reference.name}, a typical curve and not this pack's` : reference.name],
      ]),
      summary.trend ? section("Over the flights", trendFacts(summary.trend)) : null,
      table(
        [
          { title: "flight", of: ({ file, doubted_because }) => baseName(file) + (doubted_because ? " (doubted)" : "") },
          { title: "duration", of: (one) => duration(one.duration_s), by: (one) => one.duration_s, class: "number" },
          { title: "charge at start / %", of: (one) => times(100, one.soc_start), digits: 3 },
          { title: "95 %", of: (one) => interval(intervalOf(one, "soc_start"), 100), class: "number" },
          { title: "at the end / %", of: (one) => times(100, one.soc_end), digits: 3 },
          { title: "95 %", of: (one) => interval(intervalOf(one, "soc_end"), 100), class: "number" },
          { title: "capacity / Ah", of: (one) => one.capacity_Ah, digits: 3 },
          { title: "95 %", of: (one) => interval(intervalOf(one, "capacity_Ah")), class: "number" },
          { title: "resistance / mΩ", of: (one) => times(1e3, one.resistance_Ohm), digits: 3 },
          { title: "95 %", of: (one) => interval(intervalOf(one, "resistance_Ohm"), 1e3), class: "number" },
          { title: "mean error / %", of: (one) => one.mean_error_percent, digits: 2 },
        ],
        flights,
        { sort: true, caption: "What each flight says of the pack" },
      ),
      flights.length > 1
        ? [overFlights(flights, "counted_capacity_Ah", "Capacity as the sensor counts it, over the flights", "counted capacity / Ah", () => 1),
           overFlights(flights, "counted_resistance_Ohm", "Resistance as the sensor counts it, over the flights",
                       ofNew ? "counted resistance / % of new" : "counted resistance / mΩ", (one) => (ofNew ? 100 / one.new_resistance_Ohm : 1e3))]
        : note("Give several flights on one pack, the oldest first, to see how it ages."),
      listOf(summary.refused).map(({ file, reason }) => notice("warning", `${file}: ${reason}`)),
      flights.map((one) => {
        // Where the flight is doubted altogether, that is why its quantities are not known.
        const unknown = (what, why) => (why && !one.doubted_because ? `The ${what} is not known: ${why}` : null);
        const all = [unknown("capacity", one.capacity_unknown_because),
          unknown("resistance", one.resistance_unknown_because), ...listOf(one.cautions)].filter(Boolean);
        // What the sentences above say is not said again.
        const said = sentences.some((text) => doubts(text, one));
        const doubted = one.doubted_because && !said ? notice("warning", one.doubted_because) : null;
        return doubted || all.length > 0
          ? section(baseName(one.file), doubted, element("ul", {}, all.map((text) => element("li", {}, text)))) : null;
      }),
    ];
  },
};
