"""The page of lipoid identify: what it shows is what the summary says, whatever the fit is worth."""

import json
import shutil
import unittest

from page import LAB, PageTest, main
from scipy import stats

LEAF = LAB / "nissan_leaf_33ah" / "campaign.toml"
DMEGC = LAB / "dmegc_inr18650_26_r1" / "campaign.toml"

CHARTS = "return [...document.querySelectorAll('.chart')].map(f => [f.querySelector('.title').textContent, +f.dataset.points])"
# Puts the cursor on a sample of the chart with this title and reads the legend.
UNDER_CURSOR = """
const figure = [...document.querySelectorAll('.chart')].filter(f => f.querySelector('.title').textContent === arguments[0])[arguments[1]];
const plot = figure.plot;
plot.setCursor({left: plot.valToPos(plot.data[0][arguments[2]], 'x'), top: 10});
return [plot.data[0][plot.cursor.idx], ...[...figure.querySelectorAll('.legend output')].map(o => o.textContent)];
"""
TABLE = """
const table = [...document.querySelectorAll('table')].find(t => (t.caption?.textContent ?? '').startsWith(arguments[0]));
return [...table.tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent));
"""


class Identify(PageTest):
    def identify(self, *arguments, code=0):
        self.lipoid("identify", *arguments, "-o", "cell.json", "--report", "page.html", "--summary", "s.json", code=code)
        return json.loads((self.folder / "s.json").read_text())

    def text(self, page):
        return page.run("return document.querySelector('main').innerText")

    def test_shows_what_the_joint_fit_found(self):
        summary = self.identify(LEAF, "--profile", "beta")
        page = self.open("page.html")
        charts = page.run(CHARTS)
        titles = [title for title, _ in charts]
        self.assertEqual(titles.count("Voltage"), len(summary["campaign"]["logs"]))
        self.assertEqual(titles.count("Measured less predicted voltage"), len(summary["campaign"]["logs"]))
        for title in ("Discharge time against current", "Open-circuit voltage", "Series resistance r_s"):
            self.assertIn(title, titles)
        self.assertTrue(any(title.startswith("beta:") for title in titles))
        # cc_1c.csv is short: measured, predicted and staged, each row of it.
        self.assertEqual(charts[0], ["Voltage", 3 * summary["campaign"]["logs"][0]["rows"]])
        rows = page.run(TABLE, "Estimates with 95 % intervals")
        self.assertEqual([row[0] for row in rows], [one["name"] for one in summary["parameters"]])
        for row, one in zip(rows, summary["parameters"]):
            self.assertAlmostEqual(float(row[1]), one["estimate"], delta=2e-4 * abs(one["estimate"]))
        beta = next(row for row in rows if row[0] == "beta")
        self.assertIn("weak", beta)
        falls = page.run(TABLE, "Fall of the voltage")
        self.assertGreater(len(falls), 2)
        self.assertEqual([float(row[3]) for row in falls], [float(f"{1e3 * one['measured_Ohm']:.3g}") for one in summary["edges"]])
        # Digits that tell the charge from its interval; what stands in the header stands there alone.
        charge = page.run("return [...document.querySelectorAll('tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))"
                          ".find(([name]) => name === 'charge alpha')")
        self.assertEqual(len(set(charge[1:4])), 3, charge)
        self.assertAlmostEqual(float(charge[1]), summary["alpha_C"] / 3600, delta=1e-4 * float(charge[1]))
        self.assertEqual(self.text(page).count("Mean error to expect"), 1)
        sentence = summary["trust"]["sentence"]
        self.assertIn(sentence if "_" in sentence.split()[0] else sentence[1:], self.text(page))
        errors = page.run(TABLE, "Errors over all rows")
        for row, log in zip(errors, summary["logs"]):
            self.assertEqual(row[0], log["file"])
            self.assertAlmostEqual(float(row[5]), 1e3 * log["rmse_V"], delta=0.5e-3 * float(row[5]))
            self.assertAlmostEqual(float(row[7]), 1e3 * log["staged"]["rmse_V"], delta=0.5e-3 * float(row[7]))
        self.assertEqual(len(page.run(TABLE, "Correlation")), len(summary["trust"]["covariance"]["names"]))
        names = summary["trust"]["covariance"]["names"]
        matrix = summary["trust"]["covariance"]["rows"]
        shown = page.run(TABLE, "Correlation")
        expected = matrix[0][3] / (matrix[0][0] * matrix[3][3]) ** 0.5
        self.assertAlmostEqual(float(shown[0][4]), expected, delta=0.006, msg=names[3])
        self.assertEqual(len(page.run(TABLE, "Errors are root")), len(summary["joint"]["tried"]))
        text = self.text(page)
        for hashed in summary["run"]["inputs"]:
            self.assertIn(hashed["sha256"], text)
        for caution in summary["cautions"]:
            self.assertIn(caution, text)
        self.assertIn("Nissan Leaf", text)
        self.assertLess((self.folder / "page.html").stat().st_size, 2_000_000)

    def test_values_under_the_cursor_are_those_of_the_log(self):
        self.identify(LEAF)
        page = self.open("page.html")
        log = [line.split(",") for line in (LEAF.parent / "cc_1c.csv").read_text().splitlines()]
        header = next(k for k, line in enumerate(log) if not line[0].lstrip().startswith("#"))
        column = {name.strip(): k for k, name in enumerate(log[header])}
        rows = log[header + 1:]
        voltage = next(k for name, k in column.items() if "volt" in name.lower() or name.startswith("V"))
        for k in (0, 40, len(rows) - 1):
            time_s, measured, *_ = page.run(UNDER_CURSOR, "Voltage", 0, k)
            self.assertAlmostEqual(float(measured), float(rows[k][voltage]), delta=6e-5)
            self.assertIsNotNone(time_s)

    def test_bands_reach_as_far_as_the_standard_errors(self):
        summary = self.identify(LEAF)
        page = self.open("page.html")
        uncertainty = summary["cell"]["uncertainty"]
        node = uncertainty["parameters"].index("r_s[10]")
        sigma = uncertainty["covariance"][node][node] ** 0.5
        middle, low, high = page.run("""
            const figure = [...document.querySelectorAll('.chart')].find(f => f.querySelector('.title').textContent === 'Series resistance r_s');
            return figure.plot.data.slice(1, 4).map(values => values[10]);""")
        self.assertAlmostEqual(middle, 1e3 * summary["cell"]["series_resistance_Ohm"]["resistance_Ohm"][10], places=9)
        student = stats.t.ppf(0.975, uncertainty["degrees_of_freedom"])
        self.assertAlmostEqual((high - middle) / (1e3 * sigma), student, delta=1e-5 * student)
        self.assertGreaterEqual(low, 0)

    def test_shows_the_staged_method_by_itself(self):
        summary = self.identify(DMEGC, "--method", "staged", "--profile", "tau_1")
        page = self.open("page.html")
        text = self.text(page)
        self.assertIn("stage by stage", text)
        self.assertIn(f"its own logs (pulses alone) to {1e3 * summary['verdict']['rmse_V']:.3g} mV", text)
        self.assertNotIn("staged estimate", text)
        self.assertIn("The intervals take alpha and v_oc(A) as exact.", text)
        rows = dict((row[0], row) for row in page.run(TABLE, "Estimates"))
        self.assertEqual(rows["beta"][2], "unknown")  # it stands at its bound
        self.assertIn("at a bound", rows["beta"])
        self.assertEqual(summary["method"], "staged")

    def test_a_staged_curve_that_is_far_off_does_not_set_the_axes(self):
        logs = self.synthesized()
        campaign = (logs / "campaign.toml").read_text()
        (logs / "short.toml").write_text(campaign.replace('"low_rate.csv"', '"low_rate.csv"\nend_s = 800'))
        summary = self.identify(logs / "short.toml")
        self.assertGreater(summary["logs"][0]["staged"]["rmse_V"], 10)
        page = self.open("page.html")
        low, high, staged = page.run("""const { plot } = document.querySelector('.chart');
            return [plot.scales.y.min, plot.scales.y.max, plot.entries.map(({ label }) => label).find((label) => label.startsWith('staged'))];""")
        self.assertTrue(2.5 < low < 3 < 4.2 < high < 4.5, (low, high))
        self.assertIn("beyond the chart", staged)

    def test_a_poor_fit_says_so_and_why(self):
        logs = self.synthesized()
        summary = self.identify("--pulses", logs / "pulses.csv", "--constant-current", logs / "cc_1C.csv",
                                "--cutoff-V", "3.3", "--capacity-Ah", "0.6", "--method", "staged", code=1)
        self.assertEqual(summary["verdict"]["grade"], "poor")
        page = self.open("page.html")
        self.assertEqual(page.run("return document.querySelector('.grade').textContent"), "poor")
        for reason in summary["verdict"]["reasons"]:
            self.assertIn(reason, self.text(page))

    def test_a_search_that_did_not_converge_says_so(self):
        summary = self.identify(LEAF, "--method", "staged", "--set", "solver.max_iterations=1", code=1)
        self.assertFalse(summary["converged"])
        page = self.open("page.html")
        self.assertIn("did not converge", page.run("return document.querySelector('.notice.error').textContent"))

    def test_a_batch_has_its_spread_its_cells_and_what_failed(self):
        (self.folder / "bad.toml").write_text('[cell]\ncutoff_V = 3\n[[log]]\nkind = "pulses"\nfile = "none.csv"\n')
        self.lipoid("identify", LEAF, DMEGC, "bad.toml", "-o", "cells", "--report", "batch.html", "--summary", "s.json", code=3)
        page = self.open("batch.html")
        self.assertEqual(page.run("return document.querySelectorAll('details.cell').length"), 2)
        self.assertIn("bad.toml", page.run("return document.querySelector('.notice.error').textContent"))
        self.assertEqual(page.run(TABLE, "Spread")[0][0], "alpha")
        # A cell's charts are drawn once it is opened, as wide as the page.
        page.run("document.querySelector('details.cell').open = true")
        page.wait("document.querySelector('details.cell .chart').plot.width > 900")
        self.assertEqual(page.complaints(), [])

    def test_names_of_files_are_text_and_nothing_else(self):
        logs = self.synthesized()
        evil = "<img src=x onerror=document.title='owned'>.csv"
        shutil.copy(logs / "pulses.csv", self.folder / evil)
        shutil.copy(logs / "low_rate.csv", self.folder / "=cmd()&amp;<script>alert(1)<!--.csv")
        self.identify("--pulses", evil, "--low-rate", "=cmd()&amp;<script>alert(1)<!--.csv", "--cutoff-V", "3",
                      "--name", "</title><script>document.title='owned'</script>")
        page = self.open("page.html")
        self.assertEqual(page.run("return document.querySelectorAll('img, main script, iframe').length"), 0)
        self.assertNotEqual(page.run("return document.title"), "owned")
        self.assertIn(evil, self.text(page))
        self.assertEqual(page.run("return document.querySelector('h2').textContent"),
                         "</title><script>document.title='owned'</script>")

    def test_fits_a_narrow_screen_and_paper(self):
        self.identify(LEAF)
        page = self.open("page.html", width=390, dark=True)
        self.assertEqual(page.run("return document.documentElement.scrollWidth"), 390)
        page.run("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(page.run("return document.querySelectorAll('svg.printed').length"),
                         page.run("return document.querySelectorAll('.chart').length"))
        self.assertEqual(page.run("return document.querySelectorAll('details:not([open]):not(.menu)').length"), 0)
        self.assertEqual(page.run("return [...document.querySelectorAll('svg.printed path')]"
                                  ".filter(p => /NaN|Infinity/.test(p.getAttribute('d'))).length"), 0)

    def test_a_summary_shows_the_same_later(self):
        self.identify(LEAF)
        first = self.open("page.html").run(CHARTS)
        self.lipoid("report", "s.json", "-o", "again.html")
        page = self.open("again.html")
        self.assertEqual(page.run(CHARTS), first)

    def synthesized(self):
        if not (self.folder / "logs").exists():
            self.lipoid("synthesize", "gifi-600mAh-1", "--with", "r_1=0.03,c_1=1500", "--sampling-s", "1",
                        "--voltage-noise-V", "0.0005", "--seed", "1", "-o", "logs")
        return self.folder / "logs"


if __name__ == "__main__":
    main()
