"""The page of lipoid inspect: segments, values and complaints are those of the summary and the log."""

import csv
import json
import unittest

from page import LAB, PageTest, main

PULSE = LAB / "dmegc_inr18650_26_r1" / "pulse.csv"
SLOW = LAB / "dmegc_inr18650_26_r1" / "low_rate.csv"

TABLE = """
const table = [...document.querySelectorAll('table')].find(t => (t.caption?.textContent ?? '').startsWith(arguments[0]));
return [...table.tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent));
"""
# The samples of the first chart with this title.
SAMPLES = """
const figure = [...document.querySelectorAll('.chart')].find(f => f.querySelector('.title').textContent === arguments[0]);
return [[...figure.plot.data[0]], [...figure.plot.data[1]]];
"""


class Inspect(PageTest):
    def test_shows_what_is_in_each_log(self):
        self.lipoid("inspect", PULSE, SLOW, "--report", "page.html", "--summary", "s.json")
        files = json.loads((self.folder / "s.json").read_text())["files"]
        page = self.open("page.html")
        rows = page.run(TABLE, "All logs")
        self.assertEqual([row[0] for row in rows], [one["file"] for one in files])
        self.assertEqual([row[5] for row in rows], [one["suggested_kind"] for one in files])
        segments = page.run(TABLE, "Segments")
        self.assertEqual([row[0] for row in segments], [one["kind"] for one in files[0]["segments"]])
        for row, one in zip(segments, files[0]["segments"]):
            self.assertAlmostEqual(float(row[1]), one["start_s"], delta=1e-6 * max(1.0, one["end_s"]))
            self.assertEqual(int(row[5].replace("\u202f", "")), one["last_row"] - one["first_row"] + 1)

    def test_draws_the_rows_of_the_log(self):
        self.lipoid("inspect", PULSE, "--report", "page.html", "--summary", "s.json")
        page = self.open("page.html")
        with PULSE.open(newline="") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
        names = [name.lower() for name in rows[0]]
        at = {float(row[names.index("time_s")]): float(row[names.index("voltage_v")]) for row in rows[1:]}
        time_s, voltage_V = page.run(SAMPLES, "Voltage")
        self.assertGreater(len(time_s), 100)
        single = 2.0**-23 * 5.0  # voltages stand in the page in single precision
        for t, v in zip(time_s, voltage_V):
            self.assertAlmostEqual(v, at[t], delta=single)

    def test_says_which_file_it_cannot_read_beside_those_it_can(self):
        (self.folder / "broken.csv").write_text("time_s,current_A,voltage_V\n0,1,<b>4</b>\n")
        self.lipoid("inspect", PULSE, "broken.csv", "--report", "page.html", code=3)
        page = self.open("page.html")
        errors = page.run("return [...document.querySelectorAll('.notice')].map(n => n.textContent)")
        self.assertTrue(any("broken.csv:2:5" in text and "<b>" in text for text in errors), errors)
        self.assertEqual(page.run("return document.querySelectorAll('.notice b').length"), 0)


if __name__ == "__main__":
    main()
