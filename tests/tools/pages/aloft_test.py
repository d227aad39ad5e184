"""The pages of lipoid endurance and lipoid health: what they show is what the summaries say."""

import json
import shutil
import unittest

from page import PROJECT, PageTest, main

CELL = "gifi-600mAh-1"
SOLO = PROJECT / "fixtures" / "flights" / "log171.bin"

TEXT = "return document.querySelector('main').innerText"
ROWS = "return [...document.querySelectorAll('tbody')[0].rows].map(row => [...row.cells].map(cell => cell.textContent))"
CHARTS = """return [...document.querySelectorAll('.chart')].map((figure) => ({
  title: figure.querySelector('.title').textContent,
  data: figure.plot.data.map((column) => Array.from(column)),
}));"""


class Aloft(PageTest):
    def test_endurance_shows_each_number_with_its_interval(self):
        self.lipoid("endurance", "--vehicle", "mambo-physical", "--cell", CELL, "--health", "0.9+-0.03",
                    "--ensemble", 40, "--set", "step_s=0.1", "--over", "payload-g=0:5:10", "--report", "page.html", "--summary", "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        page = self.open("page.html")
        rows = page.run(ROWS)
        time = rows[0]
        self.assertEqual([row[0] for row in rows[:2]], ["flight time / min", "charge used / Ah"])
        low, high = summary["minutes_interval_95"]
        for shown, value in zip(time[1:], (summary["minutes"], low, high)):
            self.assertAlmostEqual(float(shown), value, delta=5e-4 * value)
        self.assertIn(f"{summary['minutes']:.3g} minutes", page.run("return document.querySelector('h2').textContent"))

        text = page.run("return document.querySelector('main').innerText")
        for assumed in ("0.9 ± 0.03", "Reserve at landing", "20 %", "Power over that of the vehicle file",
                        "--health 0.9+-0.03 --ensemble 40"):
            self.assertIn(assumed, text)

        (chart,) = page.run(CHARTS)
        self.assertEqual(chart["title"], "Flight time over the payload")
        self.assertEqual(chart["data"][0], [0, 5, 10])
        self.assertEqual(chart["data"][1], [row["minutes"] for row in summary["over"]["rows"]])

    def test_endurance_says_that_a_pack_cannot_fly(self):
        # By the voltage, and with a charge that is used up at once.
        for pack in (["f450", "--series", 4], ["mambo-physical", "--initial-soc", 0.02, "--reserve", 0]):
            said = self.lipoid("endurance", "--cell", CELL, "--vehicle", *pack, "--report", "page.html", code=1)
            page = self.open("page.html")
            self.assertEqual(page.run("return document.querySelector('h2').textContent"), "This pack cannot carry this mission")
            sentence = page.run("return document.querySelector('.notice.error').textContent").removeprefix("Error: The")
            self.assertIn(f"This pack cannot carry this mission: the{sentence}", " ".join(said.split()))

    def test_health_shows_flights_and_how_they_change(self):
        logs = []
        for k in range(3):
            shutil.copy(SOLO, self.folder / f"flight {k}.bin")
            logs.append(f"flight {k}.bin")
        self.lipoid("health", "--cell", CELL, "--capacity-Ah", 5.2, "--series", 4, *logs,
                    "--report", "page.html", "--summary", "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        page = self.open("page.html")
        rows = page.run(ROWS)
        self.assertEqual([row[0] for row in rows], logs)
        for row, one in zip(rows, summary["flights"]):
            self.assertAlmostEqual(float(row[2]), 100 * one["soc_start"], delta=0.1)
            low, high = (float(end) for end in row[3].replace("−", "-").split(" to "))
            self.assertTrue(low < float(row[2]) < high)
            self.assertAlmostEqual(float(row[6]), one["capacity_Ah"], delta=5e-3 * one["capacity_Ah"])
            self.assertAlmostEqual(float(row[8]), 1e3 * one["resistance_Ohm"], delta=5.0 * one["resistance_Ohm"])
        charts = {chart["title"]: chart["data"] for chart in page.run(CHARTS)}
        # Copies of a flight say nothing new: the trend leaves them out, and their places are empty.
        data = charts["Capacity as the sensor counts it, over the flights"]
        self.assertEqual(data[0], [1, 2, 3])
        self.assertEqual(data[1], [summary["flights"][0]["counted_capacity_Ah"], None, None])

    def test_flights_alone_say_what_their_errors_are_of_and_what_they_do_not_tell(self):
        self.lipoid("identify", "--flight", SOLO, "--series", 4, "--capacity-Ah", 5.2, "-o", "cell.json",
                    "--report", "page.html", "--summary", "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        text = self.open("page.html").run(TEXT)
        self.assertRegex(summary["flights"]["averaged"], r"^of means over \d.* s, with the lag of the voltage put back$")
        self.assertIn(summary["flights"]["averaged"], text)
        for caution in summary["flights"]["cautions"]:
            self.assertIn(caution, text)
        self.assertNotIn("charge alpha", text)

    def test_health_says_which_flight_is_doubted(self):
        self.lipoid("health", "--cell", CELL, "--capacity-Ah", 5.2, "--series", 3, SOLO,
                    "--report", "page.html", "--summary", "s.json", code=1)
        (flight,) = json.loads((self.folder / "s.json").read_text())["flights"]
        page = self.open("page.html")
        self.assertEqual(page.run(ROWS)[0][0], "log171.bin (doubted)")
        self.assertIn(flight["doubted_because"], page.run("return document.querySelector('.notice.warning').textContent"))

    def test_identify_shows_what_flights_add(self):
        self.lipoid("synthesize", CELL, "--with", "r_1=0.03,c_1=1500", "--sampling-s", 1, "--voltage-noise-V", 0.001, "-o", "logs")
        self.lipoid("identify", "--low-rate", "logs/low_rate.csv", "--pulses", "logs/pulses.csv", "--flight", "logs/cc_6C.csv",
                    "--cutoff-V", 3, "--capacity-Ah", 0.6, "-o", "cell.json", "--report", "page.html", "--summary", "s.json")
        found = json.loads((self.folder / "s.json").read_text())["flights_with_lab"]
        self.assertTrue(found["taken"], found["not_taken_because"])
        page = self.open("page.html")
        rows = page.run("""const heading = [...document.querySelectorAll('h3')].find((one) => one.textContent === 'Flights');
          return [...heading.parentElement.querySelectorAll('tbody')].map((body) =>
            [...body.rows].map(row => [...row.cells].map(cell => cell.textContent)))""")
        self.assertEqual(rows[0][0][0], "cc_6C.csv")
        self.assertAlmostEqual(float(rows[0][0][1]), found["flights"][0]["soc_start"], delta=5e-3)
        named = {one["name"]: one for one in found["parameters"]}
        for row in rows[1]:
            self.assertAlmostEqual(float(row[3]), named[row[0]]["estimate"], delta=1e-4 * abs(named[row[0]]["estimate"]))


if __name__ == "__main__":
    main()
