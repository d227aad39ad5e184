"""The pages of lipoid simulate, export, ageing and vehicle: what they draw is what the commands found."""

import csv
import json
import unittest

from page import LAB, PageTest, main

CELL = "gifi-600mAh-1"
PULSES = LAB / "dmegc_inr18650_26_r1" / "pulse.csv"

CHARTS = """return [...document.querySelectorAll('.chart')].map((figure) => ({
  title: figure.querySelector('.title').textContent,
  labels: figure.plot.entries.map((entry) => entry.label),
  data: figure.plot.data.map((column) => Array.from(column)),
}));"""
TEXT = "return document.querySelector('main').innerText"
ROWS = ("return [...document.querySelectorAll('tbody')[arguments[0]].rows]"
        ".map(row => [...row.cells].map(cell => cell.textContent))")


class Results(PageTest):
    def page(self, *arguments, code=0):
        """The summary of a command, and its page in a browser."""
        self.lipoid(*arguments, "--summary", "s.json", "--report", "page.html", code=code)
        return json.loads((self.folder / "s.json").read_text()), self.open("page.html")

    def same(self, shown, written):
        """Samples of a chart, which has them as single precision, and of a file."""
        self.assertEqual(len(shown), len(written))
        for one, other in zip(shown, written):
            self.assertAlmostEqual(one, other, delta=1e-6 * max(1.0, abs(other)))

    def test_simulate_draws_its_file_with_the_band(self):
        (self.folder / "current.csv").write_text(
            "time_s,current_A\n" + "".join(f"{k},{1.2 if 20 <= k < 200 else 0}\n" for k in range(300)), encoding="utf-8")
        self.lipoid("synthesize", CELL, "--sampling-s", "5", "--quiet", "-o", "logs")
        self.lipoid("identify", "logs/campaign.toml", "--method", "staged", "--quiet", "-o", "cell.json")
        summary, page = self.page("simulate", "cell.json", "--current", "current.csv", "--ensemble", 20, "-o", "out.csv")
        with open(self.folder / "out.csv", encoding="utf-8", newline="") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
        voltage, current, soc = page.run(CHARTS)
        self.assertEqual([chart["title"] for chart in (voltage, current, soc)],
                         ["Voltage", "Current, discharge positive", "Available state of charge A"])
        for k, name in enumerate(("time_s", "voltage_V", "voltage_low_V", "voltage_high_V", "open_circuit_V")):
            self.same(voltage["data"][k], [row[name] for row in rows])
        self.same(current["data"][1], [row["current_A"] for row in rows])
        self.same(soc["data"][1], [100 * row["soc"] for row in rows])
        self.assertIn(f"{summary['ensemble']['cells']}", page.run(TEXT))

        # Made again from the summary and the files that it names.
        self.lipoid("report", "s.json", "-o", "again.html")
        self.assertEqual(self.open("again.html").run(CHARTS), [voltage, current, soc])

    def test_simulate_says_where_the_cell_ends(self):
        summary, page = self.page("simulate", CELL, "--current", PULSES, "-o", "out.csv", code=1)
        text = page.run(TEXT)
        self.assertIn("the cell reaches its cut-off of 3 V", text)
        self.assertEqual(summary["messages"], [message for message in summary["messages"] if message in text])
        self.assertIn("of the log, which was not used", page.run(CHARTS)[0]["labels"])

    def test_export_draws_the_law_beside_the_cell(self):
        summary, page = self.page("export", CELL, "--to", "thevenin", "--series", 3, "-o", "frame.yaml")
        voltage, error, current = page.run(CHARTS)
        self.assertEqual(voltage["labels"], ["the cell", "exported", "with numbers read off the cell file"])
        _, cell_V, exported_V, naive_V = voltage["data"]
        self.assertEqual(len(cell_V), summary["mission_rows"])
        for law_V, told in ((exported_V, summary), (naive_V, summary["naive"])):
            rms = (sum((a - b) ** 2 for a, b in zip(law_V, cell_V)) / len(cell_V)) ** 0.5
            self.assertAlmostEqual(rms, told["rmse_V"], delta=1e-3 * told["rmse_V"] + 1e-6)
            most = max(abs(a - b) for a, b in zip(law_V, cell_V))
            self.assertAlmostEqual(most, told["max_error_V"], delta=1e-3 * told["max_error_V"] + 1e-6)
        self.assertAlmostEqual(max(map(abs, error["data"][1])), 1e3 * summary["max_error_V"], delta=1.0)
        self.assertEqual(max(current["data"][1]), max(current["data"][1][:400]))
        rows = page.run(ROWS, 1)
        self.assertEqual([row[0] for row in rows], list(summary["parameters"]))
        self.assertEqual([row[2] for row in rows], [summary["units"][name] for name in summary["parameters"]])
        self.lipoid("report", "s.json", "-o", "again.html")
        self.assertEqual(self.open("again.html").run(CHARTS), [voltage, error, current])

    def test_export_of_a_law_without_voltage_has_its_numbers(self):
        summary, page = self.page("export", CELL, "--to", "ns3", "-o", "ns3.txt")
        self.assertEqual(page.run(CHARTS), [])
        shown = float(page.run(ROWS, 0)[0][1])
        self.assertAlmostEqual(shown, 100 * summary["charge_error"]["rms"], delta=1e-3 * shown)

    def test_ageing_draws_each_quantity_over_the_ages(self):
        for name, alpha_C in (("new", 1353.6), ("old", 1200.0)):
            self.lipoid("synthesize", CELL, "--with", f"alpha={alpha_C}", "--sampling-s", "5",
                        "--voltage-noise-V", "0.001", "--quiet", "-o", name)
            self.lipoid("identify", f"{name}/campaign.toml", "--method", "staged", "--quiet", "-o", f"{name}.json")
        summary, page = self.page("ageing", "new.json", "old.json")
        charts = page.run(CHARTS)
        self.assertEqual(len(charts), len(summary["quantities"]))
        for chart, quantity in zip(charts, summary["quantities"]):
            factor = 1e3 if quantity["unit"] == "Ohm" else 1
            self.same(chart["data"][1], [factor * at["value"] for at in quantity["at"]])
            for side in (0, 1):
                self.same(chart["data"][2 + side], [factor * at["interval_95"][side] for at in quantity["at"]])
        self.assertEqual([row[-1] for row in page.run(ROWS, 0)], ["first", "changed"])

    def test_vehicle_says_where_each_number_is_from(self):
        summary, page = self.page("vehicle", "--mass-g", 650, "--frame-mm", 220, "--series", 4, "--propeller-in", 5,
                                  "--pitch-in", 4.3, "--blades", 3, "--kv-rpm-per-V", 2400,
                                  "--winding-resistance-Ohm", 0.06, "--no-load-A", 1.2, "-o", "racer.toml")
        hover = dict(page.run(ROWS, 0))
        self.assertAlmostEqual(float(hover["power of the battery / W"]), summary["hover"]["power_W"], delta=0.1)
        sources = dict(page.run(ROWS, 1))
        self.assertEqual({name: sources[name] for name in summary["sources"]}, summary["sources"])
        self.assertEqual(set(sources), set(summary["sources"]) | set(summary["assumed"]))
        for caution in summary["cautions"]:
            self.assertIn(caution, page.run(TEXT))


if __name__ == "__main__":
    main()
