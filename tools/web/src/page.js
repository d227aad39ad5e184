// The page of a report: each result by the view of its command.
import { resultsOf } from "./data.js";
import { element, note, notice, section } from "./dom.js";
import { listOf } from "./numbers.js";
import { provenance } from "./provenance.js";
import { HELP } from "./zoom.js";

// A result that no view is for, shown as it is.
const plain = {
  title: ({ summary }) => `lipoid ${summary.command ?? "result"}`,
  parts: ({ summary }) => [element("pre", {}, JSON.stringify(summary, null, 1))],
};

const viewOf = (views, result) => views.find(({ command }) => command === result.summary.command) ?? plain;

// [{view, shown, failed}]: an article shows one result, or, where its view has `together`, all results
// for which that says the same, in the place of the first.
function articlesOf(results, views) {
  const articles = [];
  for (const result of results) {
    const view = viewOf(views, result);
    const failed = Boolean(result.summary.error);
    const together = failed ? undefined : view.together?.(result.summary);
    const begun = together !== undefined &&
      articles.find((article) => article.view === view && article.together === together);
    if (begun) begun.shown.push(result);
    else articles.push({ view, shown: together === undefined ? result : [result], failed, together });
  }
  return articles;
}

const ownRun = (summary) => summary.run;

// What its command said beside its results; of several results, which of them it is about.
const messagesOf = ({ summary, file }, all) =>
  listOf(summary.messages).map((text) => (all.length > 1 && file ? `${file}: ${text}` : text));

// What went wrong with one part leaves the others readable.
function articleOf({ view, shown, failed }, k) {
  const { title, parts } = failed
    ? { title: plain.title, parts: ({ summary }) => [notice("error", summary.error.message)] }
    : view;
  const all = [shown].flat();
  const [first, ...others] = parts(shown).filter((part) => part !== null);
  const files = all.flatMap(({ file }) => (file ? [file] : []));
  return element(
    "article",
    { id: `result-${k + 1}` },
    element("h2", {}, title(shown)),
    files.length > 0 ? note(`From ${files.join(", ")}.`) : null,
    all.flatMap(({ notes }) => notes ?? []).map((text) => notice("warning", text)),
    first,
    all.flatMap((one) => messagesOf(one, all)).map((text) => notice("warning", text)),
    ...others,
    ...all.map(({ file, summary }) => provenance((view.run ?? ownRun)(summary), summary.command, all.length > 1 ? file : null)),
  );
}

// A menu closes by Escape, and by a click elsewhere.
function closeMenus() {
  const close = (but) => document.querySelectorAll("details.menu[open]").forEach((menu) => {
    if (!but || !menu.contains(but)) menu.open = false;
  });
  addEventListener("click", (event) => close(event.target));
  addEventListener("keydown", (event) => event.key === "Escape" && close(null));
}

// Paper has nothing to click at: all is open while it is printed.
function openForPrint() {
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open]):not(.menu)")];
    for (const each of opened) each.open = true;
  });
  addEventListener("afterprint", () => {
    for (const each of opened) each.open = false;
  });
}

/** Shows results by these views, in an element. */
export function showResults(main, results, views) {
  const articles = articlesOf(results, views).map(articleOf);
  if (articles.length > 1) {
    main.append(
      element("ul", { class: "contents screen" }, ...articles.map((article) =>
        element("li", {}, element("a", { href: `#${article.id}` }, article.querySelector("h2").textContent)))),
    );
  }
  main.append(...articles);
}

/** Shows all results of the page's data by these views. */
export function showReport(views) {
  const { results, program } = resultsOf(document.getElementById("data").textContent);
  const main = document.querySelector("main");
  closeMenus();
  openForPrint();
  showResults(main, results.map((result) => ({ ...result, program })), views);
  const title = main.querySelector("h2");
  if (title) document.title = `${title.textContent} – lipoid`;
  main.append(
    element(
      "footer",
      { class: "soft" },
      section("About this page", element("p", { class: "screen" }, HELP)),
      program
        ? element("p", {}, `Written by lipoid ${program.version} (${program.commit}) on ${program.written}. The page needs no network.`)
        : null,
    ),
  );
  document.documentElement.dataset.ready = "yes";  // for who waits until all charts are there
}
