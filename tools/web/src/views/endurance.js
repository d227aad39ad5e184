// `lipoid endurance`: how long a vehicle flies on a pack, and how far that is known.
import { lineChart } from "../chart.js";
import { element, facts, note, notice, section } from "../dom.js";
import { significant } from "../format.js";
import { isNumber, listOf } from "../numbers.js";
import { table } from "../table.js";

const SUFFIX = "_interval_95";
const CANNOT = "This pack cannot carry this mission";

const ENDED = {
  reserve: "the charge that is left was down to the reserve",
  "cut-off": "the battery was below its cut-off",
  empty: "the charge that is available at this current was used up",
  "motor-voltage": "the motors need more voltage than the battery gives",
  power: "no current of the battery gives the power any more",
  "mission-done": "the mission was flown to its end",
  full: "powers that flow back charge the pack beyond full",
  "time-limit": "the calculation ended before the battery did",
};

// The numbers of a flight, as the command prints them.
const NUMBERS = {
  minutes: "flight time / min",
  charge_Ah: "charge used / Ah",
  energy_Wh: "energy used / Wh",
  landing_voltage_V: "voltage at landing, under load / V",
  landing_rest_voltage_V: "voltage after landing, rested / V",
  minimum_voltage_V: "lowest voltage / V",
  peak_current_A: "highest current / A",
  remaining_soc: "share of the charge left",
  range_km: "way over the ground / km",
  hottest_degC: "hottest cell / °C",
};

// What may be uncertain: {value, standard_error}.
function uncertain(quantity, unit = "", factor = 1) {
  if (!isNumber(quantity?.value)) return null;
  const error = quantity.standard_error > 0 ? ` ± ${significant(factor * quantity.standard_error, 3)}` : "";
  return `${significant(factor * quantity.value)}${error}${unit}`;
}

const speed = (value) => (isNumber(value) ? `${significant(value, 3)} m/s` : null);
const flownSpeed = ({ level_flight }) => (level_flight?.airspeed_m_per_s > 0 ? speed(level_flight.airspeed_m_per_s) : null);

const OVER = { "ambient-degC": "temperature of the air / °C", "airspeed-m-per-s": "airspeed / (m/s)" };

// "payload_g": payload / g.
function words(key) {
  const parts = key.split("_");
  const unit = parts.length > 1 && /^(V|A|Ah|Wh|W|degC|C|s|g)$/.test(parts[parts.length - 1]) ? parts.pop() : null;
  return `${parts.join(" ")}${unit ? ` / ${unit.replace("degC", "°C")}` : ""}`;
}

// The flight time over a quantity: --over payload-g=0:100:500.
function overQuantity({ name, rows }) {
  const values = listOf(rows);
  const ends = (side) => values.map((row) => row.minutes_interval_95?.[side] ?? null);
  const known = values.some((row) => Array.isArray(row.minutes_interval_95));
  const label = OVER[name] ?? words(name.replaceAll("-", "_"));
  const title = label.split(" / ")[0];
  return section(`Over the ${title}`,
    lineChart({
      title: `Flight time over the ${title}`,
      x: { label, values: values.map(({ value }) => value) },
      y: { label: "flight time / min", zero: true },
      lines: [{ label: known ? "minutes, with their 95 % interval" : "minutes", values: values.map(({ minutes }) => minutes), band: known ? [ends(0), ends(1)] : undefined, dots: true }],
      name: "flight time",
    }),
    table(
      [
        { title: label, of: ({ value }) => value },
        { title: "flight time / min", of: ({ minutes }) => minutes },
        ...(known ? [
          { title: "95 % from", of: (row) => row.minutes_interval_95?.[0] ?? null },
          { title: "to", of: (row) => row.minutes_interval_95?.[1] ?? null },
        ] : []),
        { title: "voltage at landing / V", of: (row) => row.landing_voltage_V },
        { title: "rested / V", of: (row) => row.landing_rest_voltage_V },
        { title: "the flight ends because", of: (row) => ENDED[row.ended_by] ?? row.ended_by },
      ],
      values,
      { caption: `The flights over the ${title}` },
    ));
}

export const endurance = {
  command: "endurance",
  title: ({ summary }) => {
    if (!isNumber(summary.minutes)) return "Endurance";
    return summary.carries_mission ? `${significant(summary.minutes, 3)} minutes until landing` : CANNOT;
  },
  parts: ({ summary }) => {
    const rows = Object.keys(summary)
      .filter((key) => isNumber(summary[key]) && key + SUFFIX in summary)
      .map((key) => ({ key, interval: summary[key + SUFFIX] }));
    const known = rows.some(({ interval }) => Array.isArray(interval));
    // Of a pack that cannot fly the first sentence begins with the title.
    const [first, ...others] = listOf(summary.sentences);
    const sentence = (text) => element("p", { class: "sentence" }, text);
    return [
      summary.carries_mission ? sentence(first) : notice("error", first.replace(`${CANNOT}: t`, "T")),
      ...others.map(sentence),
      facts([
        ["Vehicle", summary.vehicle],
        ["Battery", `${summary.series}S${summary.parallel}P of ${summary.cell}`],
        ["Capacity of a new cell", isNumber(summary.capacity_Ah) ? `${significant(summary.capacity_Ah)} Ah` : null],
        ["Charge that it gives until it is empty (alpha)", isNumber(summary.alpha_Ah) ? `${significant(summary.alpha_Ah)} Ah` : null],
        ["Mission", summary.mission],
        ["Payload", uncertain(summary.payload_kg, " g", 1e3)],
        ["Airspeed", uncertain(summary.airspeed_m_per_s, " m/s") ?? flownSpeed(summary)],
        ["Flies longest at", speed(summary.speeds?.best_endurance_m_per_s)],
        ["Flies farthest at", speed(summary.speeds?.best_range_m_per_s)],
        ["Flies no faster than", speed(summary.speeds?.fastest_m_per_s)],
        ["Temperature of the air", uncertain(summary.ambient_degC, " °C") ??
          (isNumber(summary.hottest_degC) ? "that of the cell's reference, from which the battery warms"
            : "the battery has the reference temperature of the cell throughout")],
        ["Capacity left, over that of the new cell", uncertain(summary.health)],
        ["Resistance over that of the cell file", uncertain(summary.resistance_factor)],
        ["Power over that of the vehicle file", uncertain(summary.power_factor)],
        ["Reserve at landing", uncertain(summary.reserve, " %", 100)],
        ["Flights drawn", summary.ensemble?.flights],
      ]),
      table(
        [
          { title: "until landing", of: ({ key }) => NUMBERS[key] ?? words(key) },
          { title: "estimate", of: ({ key }) => summary[key] },
          { title: "95 % from", of: ({ interval }) => interval?.[0] ?? null },
          { title: "to", of: ({ interval }) => interval?.[1] ?? null },
        ],
        rows,
        { caption: known ? "With the intervals that hold 95 % of what the uncertainties allow" : "Nothing that is uncertain was given" },
      ),
      summary.over ? overQuantity(summary.over) : null,
      known ? null : note("Give a cell with `uncertainty`, as lipoid identify writes it, or values as X+-SE, for intervals."),
    ];
  },
};
