// The only list of views: one for each command whose result can be seen.
import { validate } from "./validate.js";

export const views = [validate];
