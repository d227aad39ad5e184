// The only list of views: one for each command whose result can be seen.
import { identify } from "./identify.js";
import { inspect } from "./inspect.js";
import { validate } from "./validate.js";

export const views = [
  identify,
  inspect,
  validate,
];
