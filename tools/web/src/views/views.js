// The only list of views: one for each command whose result can be seen.
import { compare } from "./compare.js";
import { design } from "./design.js";
import { endurance } from "./endurance.js";
import { fly } from "./fly.js";
import { health } from "./health.js";
import { identify } from "./identify.js";
import { inspect } from "./inspect.js";
import { plan } from "./plan.js";
import { poles } from "./poles.js";
import { study } from "./study.js";
import { validate } from "./validate.js";

export const views = [
  compare,
  design,
  endurance,
  fly,
  health,
  identify,
  inspect,
  plan,
  poles,
  study,
  validate,
];
