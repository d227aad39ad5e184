// The page of a report: each result by the view of its command.
import { resultsOf } from "./data.js";
import { element, section } from "./dom.js";

/** Shows all results of the page's data by these views. */
export function showReport(views) {
  const results = resultsOf(document.getElementById("data").textContent);
  const main = document.querySelector("main");
  for (const result of results) {
    const view = views.find(({ command }) => command === result.summary.command);
    main.append(
      element("article", {}, element("h2", {}, view.title(result)), ...view.parts(result)),
    );
  }
  document.documentElement.dataset.ready = "yes";  // for who waits until all charts are there
}
