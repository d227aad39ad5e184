// `lipoid vehicle`: the hover of a vehicle, and where each of its numbers is from.
import { facts, notice, section } from "../dom.js";
import { significant } from "../format.js";
import { isNumber, listOf } from "../numbers.js";
import { table } from "../table.js";

const HOVER = {
  battery_V: "voltage of the battery / V",
  battery_A: "current of the battery / A",
  power_W: "power of the battery / W",
  motor_A: "current of a motor / A",
  speed_rad_per_s: "speed of a rotor / (rad/s)",
  duty: "duty cycle",
};

const percent = (value) => (isNumber(value) ? `${significant(value, 3)} %` : null);

function bench(fit) {
  return section("The fit of the bench table",
    fit.converged ? null : notice("warning", `The fit did not converge: ${fit.message}`),
    facts([
      ["Speed, root mean square of the error", percent(fit.speed_rms_percent)],
      ["Current", percent(fit.current_rms_percent)],
      ["Thrust", percent(fit.thrust_rms_percent)],
      ["Degrees of freedom", fit.degrees_of_freedom],
    ]),
    table(
      [
        { title: "quantity", of: ({ name }) => name },
        { title: "estimate", of: ({ estimate }) => estimate },
        { title: "standard error", of: ({ fitted, standard_error }) => (fitted ? standard_error : null), digits: 2 },
        { title: "95 % from", of: ({ fitted, interval_95 }) => (fitted ? interval_95?.[0] : null) },
        { title: "to", of: ({ fitted, interval_95 }) => (fitted ? interval_95?.[1] : null) },
        { title: "from the table", of: ({ fitted }) => (fitted ? "yes" : "no, held") },
      ],
      listOf(fit.parameters),
    ));
}

export const vehicle = {
  command: "vehicle",
  title: ({ summary }) => `The vehicle ${summary.vehicle}`,
  parts: ({ summary }) => [
    ...[...listOf(summary.remarks), ...listOf(summary.cautions)].map((text) => notice("warning", text)),
    table(
      [
        { title: "in hover, at 3.7 V a cell", of: ([name]) => name },
        { title: "value", of: ([, value]) => value },
      ],
      [...Object.entries(HOVER).map(([key, name]) => [name, summary.hover?.[key]]),
        ["largest thrust over weight", summary.thrust_to_weight]],
    ),
    summary.bench ? bench(summary.bench) : null,
    section("Where each number is from",
      table(
        [
          { title: "number", of: ([name]) => name },
          { title: "from", of: ([, from]) => from },
        ],
        Object.entries({ ...Object.fromEntries(listOf(summary.assumed).map((name) => [name, "assumed: none"])), ...summary.sources }),
      )),
  ],
};
