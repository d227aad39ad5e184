// Entry of a report with a flight, which alone needs three.js.
import { planOf } from "./flight/plan.js";
import { sceneOf } from "./flight/scene.js";
import { showReport } from "./page.js";
import { flyView } from "./views/fly.js";
import { views } from "./views/views.js";

showReport([...views.filter(({ command }) => command !== "fly"), flyView([sceneOf, planOf])]);
