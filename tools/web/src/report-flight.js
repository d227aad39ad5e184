// Entry of a report with a flight, which alone needs three.js.
import { showReport } from "./page.js";
import { views } from "./views/views.js";

showReport([...views]);
