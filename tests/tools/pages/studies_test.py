"""The pages of lipoid compare, study, plan, poles and design, and several of them in one."""

import json
import math
import unittest

from page import PROJECT, PageTest, main

CELL = "gifi-600mAh-1"

# What a chart holds: its title, the names of its lines, and its table [x, y of the first line, ...].
CHARTS = """return [...document.querySelectorAll('.chart')].map((figure) => ({
  title: figure.querySelector('.title').textContent,
  labels: figure.plot.entries.map((entry) => entry.label),
  points: Number(figure.dataset.points),
  data: figure.plot.data.map((column) => Array.from(column)),
}));"""

# What the legend says where the cursor stands at this sample of this chart.
UNDER_CURSOR = """const figure = document.querySelectorAll('.chart')[arguments[0]];
const { plot } = figure;
plot.setCursor({ left: plot.valToPos(plot.data[0][arguments[1]], 'x'), top: 10 });
return [...figure.querySelectorAll('.legend output')].map((output) => output.textContent);"""

# Texts of the first chart that begin left of its area, of those that stand in it: draws it anew and looks on.
CUT_LABELS = """const done = arguments[0];
const { plot } = document.querySelector('.chart');
const proto = CanvasRenderingContext2D.prototype;
const fillText = proto.fillText;
const cut = [];
let seen = 0;
proto.fillText = function (text, x, y) {
  if (/^0\\.[1-8]$/.test(text) && x >= plot.bbox.left && y <= plot.bbox.top + plot.bbox.height) {
    seen += 1;
    const width = this.measureText(text).width;
    const from = x - ({ center: width / 2, right: width, end: width }[this.textAlign] ?? 0);
    if (from < plot.bbox.left) cut.push(text);
  }
  return fillText.apply(this, arguments);
};
plot.redraw(false, false);
setTimeout(() => {
  proto.fillText = fillText;
  done(seen > 0 ? cut : ['nothing was drawn']);
}, 200);"""

class Studies(PageTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.lipoid(cls(), "synthesize", CELL, "--with", "r_1=0.03,c_1=1500", "--sampling-s", "2",
                   "--voltage-noise-V", "0.001", "--quiet", "-o", "logs")

    def page(self, *arguments, code=0):
        """The summary of a command, and its page in a browser."""
        self.lipoid(*arguments, "--summary", "s.json", "--report", "page.html", code=code)
        return json.loads((self.folder / "s.json").read_text()), self.open("page.html")

    def near(self, shown, value):
        """What a legend shows is the value, to its five digits."""
        self.assertTrue(math.isclose(float(shown), value, rel_tol=2e-4, abs_tol=1e-12), (shown, value))

    def column(self, page, table, column):
        """The texts of a column of a table, both counted from 0 and 1."""
        return page.run("return [...document.querySelectorAll('table')[arguments[0]]"
                        ".querySelectorAll(`tbody tr > :nth-child(${arguments[1]})`)].map((cell) => cell.textContent)",
                        table, column)

    def test_a_study_has_one_unit_for_its_bias(self):
        summary, page = self.page("study", "terms", "logs/campaign.toml")
        chart = next(chart for chart in page.run(CHARTS) if chart["title"] == "Bias of r_s")
        drawn = sorted(value for column in chart["data"][1:] for value in column if value is not None)
        heads = page.run("return [...document.querySelectorAll('table thead th')].map((head) => head.textContent)")
        at = heads.index("its bias / mOhm")
        shown = sorted(abs(float(text)) for text in self.column(page, 0, at + 1) if text != "–" and float(text) != 0)
        self.assertEqual(len(shown), len(drawn))
        for one, other in zip(shown, drawn):
            self.assertTrue(math.isclose(one, other, rel_tol=1e-3), (one, other))
        self.assertEqual(len(summary["rows"]), len(self.column(page, 0, 1)))

    def test_compare_draws_what_each_optimizer_had_found(self):
        summary, page = self.page("compare", "logs/campaign.toml", "--optimizers",
                                  "levenberg-marquardt,sqp,nelder-mead", "--starts", "6")
        results = summary["results"]
        fit = summary["best"]["fit"]
        self.assertIn(f"The cell predicts these logs to {1e3 * fit['rmse_V']:.3g} mV",
                      page.run("return document.querySelector('main').innerText"))
        charts = page.run(CHARTS)
        self.assertEqual([chart["title"] for chart in charts],
                         ["Cost against time", "Cost against evaluations",
                          "Cost above the best against evaluations",
                          "Starts that came to the best cost, against evaluations",
                          "Starts that came to the best cost, against time"])
        by_evaluations = charts[1]
        self.assertEqual(by_evaluations["labels"], [result["optimizer"] for result in results])
        xs = by_evaluations["data"][0]
        for result, column in zip(results, by_evaluations["data"][1:]):
            for step in result["improvements"]:
                self.assertEqual(column[xs.index(step["evaluations"])], step["cost_V2"])
            # Between two improvements the better of before holds, and nothing before the first or after the end.
            for x, y in zip(xs, column):
                before = [step["cost_V2"] for step in result["improvements"] if step["evaluations"] <= x]
                self.assertEqual(y, before[-1] if before and x <= result["evaluations"] else None)
        reached = charts[3]
        for result, column in zip(results, reached["data"][1:]):
            shares = [value for value in column if value is not None]
            self.assertAlmostEqual(shares[-1] if shares else 0.0, 100 * result["success_rate"])
        at = xs.index(results[0]["improvements"][1]["evaluations"])
        self.near(page.run(UNDER_CURSOR, 1, at)[0], results[0]["improvements"][1]["cost_V2"])
        self.assertEqual(page.complaints(), [])

    def test_compare_says_that_the_best_is_no_answer_and_how_the_unknowns_are_moved(self):
        summary, page = self.page("compare", "logs/campaign.toml", "--optimizers", "sqp",
                                  "--set", "sqp.iterations_per_variable=1", code=1)
        self.assertIn(summary["no_answer_because"], page.run("return document.querySelector('.notice.error').textContent"))
        r_s = next(unknown for unknown in summary["problem"] if unknown["parameter"] == "r_s")
        moved = page.run("return [...document.querySelectorAll('td:last-child')].map((cell) => cell.textContent)")
        self.assertIn(f"r_s/{r_s['scale']:.4g}", moved)

    def test_compare_sorts_its_table(self):
        summary, page = self.page("compare", "logs/campaign.toml", "--optimizers",
                                  "nelder-mead,levenberg-marquardt,bobyqa")
        self.assertEqual(self.column(page, 0, 1), ["nelder-mead", "levenberg-marquardt", "bobyqa"])
        heads = page.driver.find_elements("css selector", "table thead th button")
        evaluations = next(head for head in heads if head.text.startswith("evaluations"))
        evaluations.click()
        rising = sorted(summary["results"], key=lambda result: result["evaluations"])
        self.assertEqual(self.column(page, 0, 1), [result["optimizer"] for result in rising])
        evaluations.click()
        self.assertEqual(self.column(page, 0, 1), [result["optimizer"] for result in reversed(rising)])
        self.assertIn("Each ran once", page.run("return document.body.textContent"))

    def test_studies_draw_their_rows(self):
        for study, x, y, factor, title in (
                ("branches", "branches", "wall_s", 1.0, "Time of the fit"),
                ("branches", "branches", "mean_error_percent", 1.0, "Error of the voltage"),
                ("ocv", "parameters", "left_out_rmse_V", 1e3, "Error on held-out rows"),
                ("terms", "terms", "rmse_V", 1e3, "Root mean square error")):
            with self.subTest(study=study, title=title):
                summary, page = self.page("study", study, "logs/campaign.toml")
                chart = next(chart for chart in page.run(CHARTS) if chart["title"] == title)
                self.assertEqual(chart["points"], len(summary["rows"]))
                text = page.run("return document.querySelector('main').textContent")
                self.assertTrue(summary["remarks"])
                self.assertEqual([remark for remark in summary["remarks"] if remark not in text], [])
                drawn = sorted((at, value) for column in chart["data"][1:]
                               for at, value in zip(chart["data"][0], column) if value is not None)
                rows = sorted((row[x], factor * row[y]) for row in summary["rows"])
                for (at, value), (of_x, of_y) in zip(drawn, rows, strict=True):
                    self.assertEqual(at, of_x)
                    self.assertAlmostEqual(value, of_y)

    def test_plan_draws_standard_errors_at_what_is_chosen(self):
        summary, page = self.page("plan", CELL, "--pulse-s", "10,30,60", "--rest-s", "300,600")
        charts = page.run(CHARTS)
        self.assertEqual(len(charts), 2)
        names = [parameter["name"] for parameter in summary["rows"][0]["parameters"]]
        self.assertEqual(charts[0]["labels"], names)

        def of(rest_s, name):
            return [100 * parameter["relative_standard_error"] for row in summary["rows"] if row["rest_s"] == rest_s
                    for parameter in row["parameters"] if parameter["name"] == name]

        # A logarithmic axis of less than a decade has more numbers than its power of ten.
        numbers = page.run("return document.querySelector('.chart').plot.axes[0]._values.filter((text) => text !== '')")
        self.assertGreaterEqual(len(numbers), 3, numbers)

        self.assertEqual(charts[0]["data"][0], [10, 30, 60])
        self.assertEqual(charts[0]["data"][1], of(300, names[0]))
        self.near(page.run(UNDER_CURSOR, 0, 1)[0], of(300, names[0])[1])
        page.run("const choice = document.querySelector('.choices select'); choice.selectedIndex = 1;"
                 "choice.dispatchEvent(new Event('change'));")
        self.assertEqual(page.run(CHARTS)[0]["data"][1], of(600, names[0]))
        self.assertEqual(page.complaints(), [])

    def test_poles_follow_the_slider(self):
        summary, page = self.page("poles", "altitude", "--xi", "0.8:0.05:1")
        charts = page.run(CHARTS)
        plane = charts[0]
        self.assertEqual(plane["labels"], ["closed form", "quasi-static", "with motor lag"])
        drawn = {(re, im) for re, im in zip(plane["data"][0], plane["data"][1]) if im is not None}
        self.assertEqual(drawn, {tuple(pole) for row in summary["rows"] for pole in row["poles"] if pole[1] >= 0})
        # The table has those of the slider, which starts at the right: both halves of a pair in one row.
        for position, row in ((len(summary["rows"]) - 1, summary["rows"][-1]), (0, summary["rows"][0])):
            page.run("const slider = document.querySelector('input[type=range]'); slider.value = arguments[0];"
                     "slider.dispatchEvent(new Event('input'));", position)
            self.assertIn(f"xi = {row['xi']:g}", page.run("return document.querySelector('.slider').textContent"))
            frequencies = self.column(page, 0, 3)
            poles = [pole for kind in ("poles", "poles_quasistatic", "poles_full") for pole in row[kind] if pole[1] >= 0]
            self.assertEqual(len(frequencies), len(poles))
            for shown, (re, im) in zip(frequencies, poles):
                self.near_4(shown, math.hypot(re, im))
        # Damping ratios stand beside their lines, whole.
        self.assertEqual(page.driver.execute_async_script(CUT_LABELS), [])
        least = [min(-re / math.hypot(re, im) for re, im in row["poles"]) for row in summary["rows"]]
        for value, expected in zip(charts[1]["data"][1], least, strict=True):
            self.assertAlmostEqual(value, expected)
        self.assertEqual(page.complaints(), [])

    def near_4(self, shown, value):
        self.assertTrue(math.isclose(float(shown), value, rel_tol=1e-3), (shown, value))

    def test_design_shows_gains_search_and_poles(self):
        summary, page = self.page("design", "altitude", "--aware", "--xi", "0.9:0.05:1", "--optimizer",
                                  "levenberg-marquardt", "--check", "never")
        self.assertEqual(self.column(page, 0, 1), ["start", "found", "upper bound"])
        self.near_4(self.column(page, 0, 3)[1], summary["gains"]["integral"])
        charts = page.run(CHARTS)
        self.assertEqual(charts[0]["data"][1], [step["cost"] for step in summary["improvements"]])
        self.assertEqual(sum(chart["title"].startswith("Poles of") for chart in charts), 2)
        self.assertEqual(self.warnings(page), summary["cautions"])

    def test_design_tells_what_was_found_from_what_is_written(self):
        summary, page = self.page("design", "altitude", "--optimizer", "genetic", "--set", "genetic.population=5",
                                  "--set", "genetic.iterations_per_variable=1", "--check", "never")
        self.assertEqual(self.column(page, 0, 1), ["start", "found", "from there on", "upper bound"])
        self.near_4(self.column(page, 0, 2)[1], summary["search"]["gains"]["proportional"])
        self.near_4(self.column(page, 0, 2)[2], summary["gains"]["proportional"])
        self.assertIn("ended at its upper bound", summary["cautions"][0])
        self.assertEqual(self.warnings(page), summary["cautions"])

    def warnings(self, page):
        return page.run("return [...document.querySelectorAll('.notice.warning')].map((p) => p.textContent.replace('Caution: ', ''))")

    def test_endurance_shows_speeds_and_the_flights_over_a_temperature(self):
        vehicle = ["--vehicle", "camera-10in", "--cell", "grepow-32Ah-1", "--capacity-Ah", "5.2", "--series", "4",
                   "--ensemble", "0"]
        summary, page = self.page("endurance", *vehicle, "--mission", "cruise")
        shown = page.run("return document.querySelector('main').innerText")
        for key, label in (("best_endurance_m_per_s", "Flies longest at"), ("best_range_m_per_s", "Flies farthest at"),
                           ("fastest_m_per_s", "Flies no faster than")):
            self.assertIn(f"{label}\n{summary['speeds'][key]:.3g} m/s", shown)
        summary, page = self.page("endurance", *vehicle, "--over", "ambient-degC=-30:35:40")
        self.assertEqual(self.column(page, 1, 1), ["-30", "5", "40"])
        self.assertEqual([row["ended_by"] for row in summary["over"]["rows"]], ["cut-off", "reserve", "reserve"])
        self.assertEqual(self.column(page, 1, 5)[0], "the battery was below its cut-off")
        shown = page.run("return document.querySelector('main').innerText")
        self.assertIn("Flight time over the temperature of the air", shown)
        self.assertNotIn("reference temperature of the cell throughout", shown)

    def test_health_begins_with_what_the_command_says(self):
        log = PROJECT / "fixtures" / "flights" / "log171.bin"
        copy = self.folder / "copy.bin"
        copy.write_bytes(log.read_bytes())
        said = ["health", "--cell", "gifi-600mAh-1", "--capacity-Ah", "5.2", "--series"]
        summary, page = self.page(*said, "5", log, code=1)
        self.assertEqual(page.run("return [...document.querySelectorAll('p.sentence')].map((p) => p.textContent)"),
                         summary["sentences"])
        self.assertIn("is --series (now 5) wrong?", summary["sentences"][0])
        # One reason once, not for every quantity of the flight.
        self.assertNotIn(" is not known: the voltage", page.run("return document.querySelector('main').innerText"))
        summary, page = self.page(*said, "4", log, copy)
        charts = page.run(CHARTS)
        self.assertEqual([chart["title"].split()[0] for chart in charts], ["Capacity", "Resistance"])
        for chart, key in zip(charts, ("counted_capacity_Ah", "counted_resistance_Ohm")):
            self.assertIn("as the sensor counts it", chart["title"])
            self.assertIsNone(chart["data"][1][1])  # the copy, which the trend leaves out
            self.assertIsNotNone(summary["flights"][1][key])

    def test_every_result_says_where_it_comes_from(self):
        for arguments in (["poles", "attitude", "--xi", "0.9"],
                          ["design", "altitude", "--xi", "1", "--check", "never"],
                          ["fly", "hover", "--duration", "2", "--wind", "1"]):
            _, page = self.page(*arguments)
            shown = page.run("return document.querySelector('main').innerText")
            self.assertIn("Where this comes from", shown, arguments)
            self.assertIn(f"lipoid {' '.join(arguments)} --summary s.json", shown)

    def test_several_results_stand_in_one_page_with_a_note_where_samples_are_missing(self):
        self.lipoid("poles", "attitude", "--xi", "0.9", "--summary", "poles.json")
        self.lipoid("validate", CELL, "logs/pulses.csv", "--summary", "validate.json")
        said = self.lipoid("report", "poles.json", "validate.json", "-o", "both.html")
        self.assertEqual(said, "")
        page = self.open("both.html")
        self.assertEqual(page.run("return [...document.querySelectorAll('article h2')].length"), 2)
        self.assertEqual(page.run("return document.querySelectorAll('.notice').length"), 0)
        with_samples = page.run("return document.querySelectorAll('.chart').length")
        validate = json.loads((self.folder / "validate.json").read_text())
        validate["run"]["inputs"][0]["sha256"] = "0" * 64
        (self.folder / "validate.json").write_text(json.dumps(validate))
        self.lipoid("report", "poles.json", "validate.json", "-o", "one.html")
        page = self.open("one.html")
        self.assertLess(page.run("return document.querySelectorAll('.chart').length"), with_samples)
        self.assertIn("has another SHA-256", page.run("return document.querySelector('.notice').textContent"))

    def test_a_summary_that_holds_nothing_is_shown_without_a_complaint(self):
        """Whatever passes the schema is shown: nulls for numbers, empty lists, names of markup. All in one page."""
        files = []
        for arguments in (["poles", "altitude", "--xi", "0.9"], ["plan", CELL], ["study", "terms", "logs/campaign.toml"],
                          ["study", "branches", "logs/campaign.toml"], ["study", "ocv", "logs/campaign.toml"],
                          ["compare", "logs/campaign.toml", "--optimizers", "sqp", "--starts", "1"],
                          ["design", "attitude", "--optimizer", "levenberg-marquardt", "--check", "never"]):
            self.lipoid(*arguments, "--summary", "whole.json")
            whole = json.loads((self.folder / "whole.json").read_text())
            for broken in (hollow(whole, lists=False), hollow(whole, lists=True), hostile(whole)):
                files.append(f"broken{len(files)}.json")
                (self.folder / files[-1]).write_text(json.dumps(broken))
        self.lipoid("report", *files, "-o", "broken.html")
        page = self.open("broken.html")
        self.assertEqual(page.run("return document.querySelectorAll('article h2').length"), len(files))
        self.assertIsNone(page.run("return window.harmed ?? null"))


def hollow(value, lists, key=None):
    """Every number null, or every list empty too."""
    if key == "run":
        return value
    if isinstance(value, dict):
        return {name: hollow(member, lists, name) for name, member in value.items()}
    if isinstance(value, list):
        return [] if lists else [hollow(item, lists) for item in value]
    return None if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def hostile(value, key=None):
    """Numbers as large as they come, and markup in every text but those that say what the summary is."""
    if key in ("run", "command", "study", "exit_code"):
        return value
    if isinstance(value, dict):
        return {name: hostile(member, name) for name, member in value.items()}
    if isinstance(value, list):
        return [hostile(item) for item in value]
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, (int, float)):
        return 1e308 if value > 0 else -1e308
    return "</script><img src=x onerror='window.harmed = 1'>\u202e=cmd()"


if __name__ == "__main__":
    main()
