"""The page of flights: the path in three dimensions, and charts that keep its time."""

import csv
import json
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from page import PageTest, main

# WebGL is drawn in software here: a small window takes little time.
SMALL = {"width": 800, "height": 600}

# Of seven digits, which the page keeps.
FLOAT = 1e-6

FLIGHT = "document.querySelector('.flight')"
TIME = f"return {FLIGHT}.player.time_s"
SHOWN = f"return {FLIGHT}.stage.shown"

# [title, [[label, values], ...]] of each chart, and its times.
CHARTS = """
return [...document.querySelectorAll('.chart')].map((figure) => ({
  title: figure.querySelector('.title').textContent,
  points: Number(figure.dataset.points),
  times: [...figure.plot.data[0]],
  lines: figure.plot.series.slice(1).map(({label}, k) => [label, [...figure.plot.data[k + 1]]]),
}));
"""


def columns(file):
    with open(file, encoding="utf-8", newline="") as lines:
        rows = csv.reader(lines)
        header = next(rows)
        return dict(zip(header, zip(*([float(cell or "nan") for cell in row] for row in rows))))


class Fly(PageTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        self = cls()
        for name, more in (("plain", []), ("compensated", ["--compensate"])):
            self.lipoid("fly", "altitude-steps", "--duration", "16", *more, "-o", f"{name}.csv", "--summary", f"{name}.json",
                        "--report", f"{name}.html")
        self.lipoid("report", "plain.json", "compensated.json", "-o", "both.html")
        self.lipoid("fly", "hover", "--xi", "0.6", "--report", "crash.html", "--summary", "crash.json", code=1)
        cls.log = columns(cls.folder / "plain.csv")

    def near(self, values, wanted, what):
        self.assertEqual(len(values), len(wanted), what)
        for k, (value, want) in enumerate(zip(values, wanted)):
            self.assertAlmostEqual(value, want, delta=FLOAT * max(1.0, abs(want)), msg=f"{what}, row {k}")

    def charts(self, page):
        return {chart["title"]: chart for chart in page.run(CHARTS)}

    def test_charts_have_the_values_of_the_flight_log(self):
        page = self.open("plain.html", **SMALL)
        charts = self.charts(page)
        rows = len(self.log["time_s"])
        self.assertEqual(rows, 3200)
        wanted = {
            "Altitude": {"altitude": "altitude_m", "reference": "altitude_reference_m", "command": "altitude_command_m"},
            "Motor speeds": {"all four motors": "speed_1_rad_per_s"},
            "Duty cycles": {"all four motors": "duty_4"},
            "Voltage of the battery": {"voltage": "battery_V"},
            "Current of the battery": {"current": "battery_A"},
        }
        for title, lines in wanted.items():
            self.near(charts[title]["times"], self.log["time_s"], title)
            found = dict(charts[title]["lines"])
            for label, column in lines.items():
                self.near(found[label], self.log[column], f"{title}, {label}")
        self.assertEqual(charts["Altitude"]["points"], 3 * rows)
        soc = dict(charts["State of charge"]["lines"])["state of charge"]
        self.near(soc, [100 * value for value in self.log["soc"]], "state of charge")
        # Nothing pitches in steps of altitude.
        self.assertNotIn("Pitch", charts)
        self.assertIn("pitch", page.run("return document.querySelector('.over-time').textContent"))

    def test_says_what_the_command_said(self):
        printed = self.lipoid("fly", "altitude-steps", "--series", "3", "--duration", "16", "--summary", "pack.json",
                              "--report", "pack.html")
        messages = json.loads((self.folder / "pack.json").read_text())["messages"]
        self.assertIn("is made for 1 cell in series, and this pack has 3", messages[0])
        self.assertEqual([message for message in messages if message not in printed], [])
        notices = "return [...document.querySelectorAll('.notice')].map((each) => each.textContent)"
        shown = self.open("pack.html", **SMALL).run(notices)
        self.assertEqual([each.removeprefix("Caution: ") for each in shown], messages)
        # On a page of several flights each says which one it is about.
        self.lipoid("report", "plain.json", "pack.json", "-o", "two.html")
        shown = "".join(self.open("two.html", **SMALL).run(notices))
        self.assertEqual([message for message in messages if f"pack.json: {message}" not in shown], [])

    def test_plays_and_pauses(self):
        page = self.open("plain.html", **SMALL)
        self.assertEqual(page.run(TIME), 0)  # less motion is wanted
        self.near(page.run(SHOWN)[0], [0, 0, self.log["altitude_m"][0]], "at the start")
        button = page.driver.find_element(By.CSS_SELECTOR, ".play")
        self.assertEqual(button.text, "Play")
        button.click()
        page.wait(f"{FLIGHT}.player.time_s > 0.5")
        self.assertEqual(button.text, "Pause")
        self.assertNotAlmostEqual(page.run(SHOWN)[0][2], self.log["altitude_m"][0], places=4)
        button.click()
        stopped = page.run(TIME)
        page.run("return new Promise((done) => setTimeout(done, 200))")
        self.assertEqual(page.run(TIME), stopped)
        self.near([page.run(SHOWN)[0][2]], [self.altitude(stopped)], "where it was stopped")
        self.assertEqual(page.complaints(), [])

    def altitude(self, time_s):
        """Between the rows of the log."""
        place = min(int(time_s / 0.005), len(self.log["time_s"]) - 1)
        after = min(place + 1, len(self.log["time_s"]) - 1)
        share = (time_s - self.log["time_s"][place]) / 0.005 if after > place else 0.0
        return self.log["altitude_m"][place] * (1 - share) + self.log["altitude_m"][after] * share

    def test_time_line_and_keys_seek(self):
        page = self.open("plain.html", **SMALL)
        page.run("""const line = document.querySelector('.flight .time'); line.value = '13.005';
                    line.dispatchEvent(new Event('input', {bubbles: true}));""")
        self.assertAlmostEqual(page.run(TIME), 13.005)
        self.near([page.run(SHOWN)[0][2]], [self.altitude(13.005)], "by the time line")
        self.assertIn("13.0", page.run("return document.querySelector('.flight .clock').textContent"))
        line = page.driver.find_element(By.CSS_SELECTOR, ".flight .time")
        line.send_keys(Keys.ARROW_RIGHT)
        self.assertAlmostEqual(page.run(TIME), 13.105)
        line.send_keys(Keys.SHIFT, Keys.ARROW_LEFT)
        self.assertAlmostEqual(page.run(TIME), 12.105)
        canvas = page.driver.find_element(By.CSS_SELECTOR, ".stage canvas")
        canvas.send_keys(Keys.END)
        self.assertAlmostEqual(page.run(TIME), 16.0)
        canvas.send_keys(Keys.HOME)
        canvas.send_keys(Keys.SPACE)
        page.wait(f"{FLIGHT}.player.playing && {FLIGHT}.player.time_s > 0")
        canvas.send_keys(Keys.SPACE)
        self.assertFalse(page.run(f"return {FLIGHT}.player.playing"))

    def test_speeds_are_times_the_real_one(self):
        page = self.open("plain.html", **SMALL)
        rates = page.run("return [...document.querySelectorAll('.flight .controls select option')].map((o) => o.value)")
        self.assertEqual(rates[:6], ["0.25", "0.5", "1", "2", "4", "8"])
        # The clock of the page, in place of the screen's.
        page.run(f"""const p = {FLIGHT}.player; p.seek(1); p.rate = 8; p.playing = true; p.last_ms = 1000;
                     p.tick(1100); p.pause();""")
        self.assertAlmostEqual(page.run(TIME), 1.8)

    def test_charts_and_flight_share_their_time(self):
        page = self.open("plain.html", **SMALL)
        page.run(f"{FLIGHT}.player.seek(13.2)")
        # The legends of all charts say what was at that time.
        at = page.run("return [...document.querySelectorAll('.chart .legend .at')].map((each) => each.textContent)")
        self.assertGreater(len(at), 5)
        self.assertEqual({text[:7] for text in at}, {"at 13.2"})
        shown = page.run("return document.querySelector('.chart .legend output').textContent")
        self.assertAlmostEqual(float(shown), self.altitude(13.2), delta=0.01)
        # The mouse in any chart takes the vehicle to its time, and leaves it there.
        over = page.run("const o = document.querySelectorAll('.chart')[3].plot.over; o.scrollIntoView({block: 'center'}); return o")
        ActionChains(page.driver).move_to_element(over).perform()
        page.wait(f"{FLIGHT}.player.held")
        middle = page.run("const {min, max} = document.querySelectorAll('.chart')[3].plot.scales.x; return (min + max) / 2")
        self.assertAlmostEqual(page.run(TIME), middle, delta=0.05)
        self.near([page.run(SHOWN)[0][2]], [self.altitude(page.run(TIME))], "under the cursor")
        ActionChains(page.driver).move_to_element(page.driver.find_element(By.CSS_SELECTOR, "footer")).perform()
        page.wait(f"!{FLIGHT}.player.held")
        self.assertAlmostEqual(page.run(TIME), middle, delta=0.05)
        # So does the cursor that keys move.
        page.run("document.querySelectorAll('.chart')[1].querySelector('.plot').focus()")
        page.driver.switch_to.active_element.send_keys(Keys.HOME)
        self.assertEqual(page.run(TIME), 0)
        self.assertEqual(page.complaints(), [])

    def test_two_flights_are_in_one_scene_and_in_the_same_charts(self):
        page = self.open("both.html", **SMALL)
        self.assertEqual(page.run("return document.querySelectorAll('article').length"), 1)
        names = ["not compensated", "compensated"]
        self.assertEqual(page.run("return [...document.querySelectorAll('.stage .name')].map((each) => each.textContent)"), names)
        page.run(f"{FLIGHT}.player.seek(13.2)")
        other = columns(self.folder / "compensated.csv")
        row = round(13.2 / 0.005)
        self.near([place[2] for place in page.run(SHOWN)], [self.log["altitude_m"][row], other["altitude_m"][row]], "altitudes")
        charts = self.charts(page)
        lines = dict(charts["Altitude"]["lines"])
        self.assertEqual(list(lines), [*names, "reference", "command"])
        self.near(lines["not compensated"], self.log["altitude_m"], "first flight")
        self.near(lines["compensated"], other["altitude_m"], "second flight")
        # One motor at a time, any of them.
        page.run("""const choice = document.querySelector('.chart .choice select'); choice.value = '3';
                    choice.dispatchEvent(new Event('change'));""")
        self.near(dict(self.charts(page)["Motor speeds"]["lines"])["compensated"], other["speed_3_rad_per_s"], "motor 3")
        peaks = json.loads((self.folder / "compensated.json").read_text())["peak_altitude_error_m"]
        self.assertIn(f"{1e3 * peaks[0]:.4g}", page.run("return document.querySelector('main').textContent"))

    def test_flights_are_named_by_the_option_in_which_they_differ(self):
        for wind in (0, 1):
            self.lipoid("fly", "hover", "--duration", "2", "--wind", wind, "--summary", f"wind{wind}.json")
        self.lipoid("report", "wind0.json", "wind1.json", "-o", "wind.html")
        page = self.open("wind.html", **SMALL)
        self.assertEqual(page.run("return [...document.querySelectorAll('.stage .name')].map((each) => each.textContent)"),
                         ["wind 0 m/s", "wind 1 m/s"])
        shown = page.run("return document.querySelector('main').innerText")
        self.assertIn("position error, root mean square / m", shown)
        self.assertIn("Where wind1.json comes from", shown)

    def test_without_webgl_the_path_is_drawn_flat(self):
        page = self.open("both.html", webgl=False, **SMALL)
        self.assertIn("no WebGL", page.run("return document.querySelector('.plan').textContent"))
        self.assertEqual(page.run("return document.querySelectorAll('.plan svg').length"), 2)
        marker = "return document.querySelectorAll('.plan svg')[1].querySelector('.marker').getAttribute('transform')"
        before = page.run(marker)
        page.run(f"{FLIGHT}.player.seek(13.2)")
        self.assertNotEqual(page.run(marker), before)
        page.driver.find_element(By.CSS_SELECTOR, ".play").click()
        page.wait(f"{FLIGHT}.player.time_s > 13.3")
        self.assertEqual(page.complaints(), [])

    def test_says_how_a_flight_ended(self):
        page = self.open("crash.html", **SMALL)
        summary = json.loads((self.folder / "crash.json").read_text())
        self.assertIn("crashed at", page.run("return document.querySelector('.stage .trouble').textContent"))
        self.assertIn("crashed at", page.run("return document.querySelector('.chart .event').textContent"))
        self.assertIn(summary["reason"][1:], page.run("return document.querySelector('.notice').textContent"))
        self.assertEqual(page.run("return document.querySelectorAll('.flight .marks span').length"), 1)

    def test_plays_by_itself_where_motion_is_welcome(self):
        page = self.open("crash.html", motion=True, **SMALL)
        self.assertFalse(page.run(f"return {FLIGHT}.player.playing"))  # out of sight
        page.run(f"{FLIGHT}.scrollIntoView()")
        page.wait(f"{FLIGHT}.player.time_s > 0.2")

    def test_the_camera_turns_and_follows(self):
        page = self.open("plain.html", **SMALL)
        canvas = page.driver.find_element(By.CSS_SELECTOR, ".stage canvas")
        picture = "return document.querySelector('.stage canvas').toDataURL()"
        seen = {page.run(picture)}
        for text in ("From above", "From the side", "From behind"):
            page.driver.find_element(By.XPATH, f"//button[text()='{text}']").click()
            page.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            seen.add(page.run(picture))
        canvas.send_keys("d")
        page.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        seen.add(page.run(picture))
        page.run("""const follow = document.querySelector('.camera select'); follow.value = '0';
                    follow.dispatchEvent(new Event('change'));""")
        page.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        seen.add(page.run(picture))
        self.assertEqual(len(seen), 6)
        self.assertEqual(page.complaints(), [])

    def test_pages_stay_small(self):
        # All that moves: nearly every column differs from row to row.
        for k in (1, 2, 3):
            self.lipoid("fly", "square", "--estimate", "--seed", k, "--summary", f"square{k}.json", "--report", "square.html")
        self.lipoid("report", "square1.json", "square2.json", "square3.json", "-o", "three.html")
        for page in ("square.html", "three.html"):
            self.assertLess((self.folder / page).stat().st_size, 2_000_000, page)


if __name__ == "__main__":
    main()
