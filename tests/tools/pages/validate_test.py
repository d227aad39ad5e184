"""The page of lipoid validate."""

import json
import re
import unittest

from page import LAB, PageTest, main


class Validate(PageTest):
    def test_has_charts_of_every_log(self):
        logs = [LAB / "dmegc_inr18650_26_r1" / name for name in ("pulse.csv", "cc_1c.csv")]
        self.lipoid("validate", "gifi-600mAh-1", *logs, "--report", "page.html", "--summary", "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        page = self.open("page.html")
        self.assertEqual(page.run("return document.querySelectorAll('.chart canvas').length"), 6)
        rows = page.run("return [...document.querySelectorAll('tbody tr')].map(r => r.cells[1].textContent)")
        verdict = page.run("return document.querySelector('.sentence').textContent")
        shown_mV = float(re.search(r"these logs to ([0-9.e+]+) mV", verdict)[1])
        self.assertAlmostEqual(shown_mV, 1e3 * summary["fit"]["rmse_V"], delta=5e-3 * shown_mV)
        self.assertEqual(page.run("return document.querySelector('.grade').textContent"), summary["fit"]["verdict"])
        self.assertEqual(rows[:2], [str(log["rows"]) for log in summary["logs"]])


if __name__ == "__main__":
    main()
