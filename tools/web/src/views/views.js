// The only list of views: one for each command whose result can be seen.
import { ageing } from "./ageing.js";
import { compare } from "./compare.js";
import { design } from "./design.js";
import { endurance } from "./endurance.js";
import { exported } from "./export.js";
import { fly } from "./fly.js";
import { health } from "./health.js";
import { identify } from "./identify.js";
import { inspect } from "./inspect.js";
import { plan } from "./plan.js";
import { poles } from "./poles.js";
import { simulate } from "./simulate.js";
import { study } from "./study.js";
import { validate } from "./validate.js";
import { vehicle } from "./vehicle.js";

export const views = [
  ageing,
  compare,
  design,
  endurance,
  exported,
  fly,
  health,
  identify,
  inspect,
  plan,
  poles,
  simulate,
  study,
  validate,
  vehicle,
];
