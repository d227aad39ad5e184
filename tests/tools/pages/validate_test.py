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

    def test_says_what_the_command_said_and_which_log_is_which(self):
        text = (LAB / "dmegc_inr18650_26_r1" / "pulse.csv").read_text(encoding="utf-8")
        for folder in ("a", "b"):
            (self.folder / folder).mkdir()
            (self.folder / folder / "log.csv").write_text(text, encoding="utf-8")
        self.lipoid("validate", "gifi-600mAh-1", "a/log.csv", "b/log.csv", "--initial-soc", "0.5", "--report", "page.html",
                    "--summary", "s.json")
        messages = json.loads((self.folder / "s.json").read_text())["messages"]
        self.assertIn("b/log.csv holds the same rows as a/log.csv", messages[0])
        page = self.open("page.html")
        shown = page.run("return [...document.querySelectorAll('.notice')].map((each) => each.textContent)")
        self.assertEqual([each.removeprefix("Caution: ") for each in shown], messages)
        titles = page.run("return [...document.querySelectorAll('section > h3')].map((each) => each.textContent)")
        self.assertEqual(titles[:2], ["a/log.csv", "b/log.csv"])
        self.lipoid("report", "s.json", "-o", "again.html")
        self.assertEqual(self.open("again.html").run("return document.querySelectorAll('.chart canvas').length"), 6)


if __name__ == "__main__":
    main()
