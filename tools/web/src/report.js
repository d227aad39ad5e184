// Entry of a report without a flight.
import { showReport } from "./page.js";
import { views } from "./views/views.js";

showReport(views);
