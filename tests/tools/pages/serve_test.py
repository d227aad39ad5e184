"""The page of lipoid serve: from dropped logs to a cell file, in a browser."""

import json
import os
import signal
import subprocess
import time
import unittest
import urllib.request

from page import LAB, PageTest, main

LOGS = [LAB / "dmegc_inr18650_26_r1" / name for name in ("low_rate.csv", "pulse.csv", "cc_1c.csv")]

# Drops files as a person does: a drag of these names and texts ends above the element.
DROP = """
const [names, texts] = arguments;
const data = new DataTransfer();
names.forEach((name, k) => data.items.add(new File([texts[k]], name)));
const target = document.querySelector(".drop");
for (const kind of ["dragenter", "dragover", "drop"])
  target.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
"""


class Serve(PageTest):
    def setUp(self):
        self.process = subprocess.Popen([self.program, "serve"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        text=True, env=dict(os.environ, TMPDIR=str(self.folder)))
        self.addCleanup(self.end)
        self.address = self.process.stdout.readline().strip()
        self.page = self.open(self.address)

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=60)
        self.process.stdout.close()

    def drop(self, files):
        self.page.run(DROP, [file.name for file in files], [file.read_text() for file in files])
        self.page.wait("[...document.querySelectorAll('.log')].every(log => log.dataset.status !== 'waiting') && "
                       f"document.querySelectorAll('.log').length === {len(files)}", 60)

    def click(self, words, within="document"):
        """The button of these words, by the mouse's click."""
        self.page.wait(f"[...{within}.querySelectorAll('button')].some(b => b.textContent === {json.dumps(words)})")
        self.page.run(f"[...{within}.querySelectorAll('button')].find(b => b.textContent === {json.dumps(words)}).click()")

    def job(self, number):
        return f"document.querySelector('.job[data-job=\"{number}\"]')"

    def wait_job(self, number, status):
        self.page.wait(f"{self.job(number)}?.dataset.status === '{status}'", 120)

    def identify(self):
        self.page.wait("!document.getElementById('identify').disabled", 60)
        self.page.run("document.getElementById('identify').click()")

    def download(self, name, number):
        """What the link in the page leads to."""
        address = self.page.run(
            f"return [...{self.job(number)}.querySelectorAll('a')].find(a => a.textContent === '{name}').href")
        with urllib.request.urlopen(address, timeout=60) as answer:
            self.assertIn("attachment", answer.headers["Content-Disposition"])
            return answer.read()

    def fine(self):
        self.assertEqual(self.page.complaints(), [])

    def test_from_logs_to_a_cell_file(self):
        self.drop(LOGS)
        self.assertEqual(self.page.run("return [...document.querySelectorAll('.kind select')].map(s => s.value)"),
                         ["low-rate", "pulses", "constant-current"])
        self.page.wait("document.body.textContent.includes('one discharge of 2.527 Ah at 2.601 A')")
        # A name for the cell, typed.
        name = self.page.driver.find_element("css selector", "section[aria-label=Cell] input")
        name.send_keys("Lab cell 7\n")
        self.identify()
        self.wait_job(1, "done")
        self.click("Show the result", self.job(1))
        self.page.wait("document.querySelector('.terminal').textContent.includes('Lab cell 7 predicts its own logs')")
        cell = json.loads(self.download("cell.json", 1))
        self.assertEqual((cell["schema"], cell["name"]), ("lipoid.cell/1", "Lab cell 7"))
        self.assertIn(b'name = "Lab cell 7"', self.download("campaign.toml", 1))
        # Another method, and the two side by side.
        self.page.run("""const method = [...document.querySelectorAll('.label')].find(l => l.textContent === '--method')
                           .parentElement.querySelector('select');
                         method.value = 'staged'; method.dispatchEvent(new Event('change', { bubbles: true }));""")
        self.identify()
        self.wait_job(2, "done")
        self.assertIn("--method staged", self.page.run(f"return {self.job(2)}.textContent"))
        for number in (1, 2):
            self.page.run(f"{self.job(number)}.querySelector('input[type=checkbox]').click()")
        self.page.wait("document.querySelector('#compare tbody')")
        shown = self.page.run("""return [...document.querySelectorAll('#compare tbody tr')]
                                   .find(row => row.cells[0].textContent === 'alpha').cells[2].textContent""")
        summary = json.loads(self.download("summary.json", 1))
        alpha = next(each for each in summary["parameters"] if each["name"] == "alpha")
        self.assertAlmostEqual(float(shown.split(" ")[0]), alpha["estimate"], delta=alpha["estimate"] * 1e-3)
        # Fly it.
        self.page.run("document.getElementById('use-fly').open = true")
        self.page.run("""const maneuver = [...document.querySelectorAll('#use-fly select')][1];
                         maneuver.value = 'hover'; maneuver.dispatchEvent(new Event('change', { bubbles: true }));""")
        self.page.wait("!document.getElementById('fly').disabled")
        self.page.run("document.getElementById('fly').click()")
        self.page.wait(f"{self.job(3)} && ['done', 'failed'].includes({self.job(3)}.dataset.status)", 120)
        self.assertIn("the cell of job 2", self.page.run(f"return {self.job(3)}.textContent"))
        self.fine()

    def test_shows_the_report(self):
        self.drop(LOGS[1:2])
        self.page.run("document.getElementById('use-validate').open = true")
        self.page.run("document.getElementById('validate').click()")
        self.wait_job(1, "done")
        self.click("Show the result", self.job(1))
        frame = self.page.driver.find_element("css selector", "iframe")
        self.assertEqual(frame.get_attribute("sandbox"), "allow-scripts allow-downloads")
        self.page.driver.switch_to.frame(frame)
        self.page.wait("document.documentElement.dataset.ready === 'yes'")
        self.assertGreater(self.page.run("return document.querySelectorAll('.chart canvas').length"), 0)
        # The report can reach nothing of the page that shows it.
        self.assertEqual(self.page.run("return origin"), "null")
        self.page.driver.switch_to.default_content()
        self.fine()

    def test_shows_what_is_wrong_with_a_file(self):
        bad = self.folder / "<img src=x onerror=alert(1)>.csv"
        bad.write_text("time_s,current_A,voltage_V\n0,0,4.1\n1,1,4.0\n2,abc,3.9\n")
        self.drop([bad])
        self.assertEqual(self.page.run("return document.querySelector('.log h3').textContent"), bad.name)
        self.assertIn(":4:3: error: expected a number in column 'current_A', found 'abc'",
                      self.page.run("return document.querySelector('.log .error').textContent"))
        self.assertTrue(self.page.run("return document.getElementById('identify').disabled"))
        self.assertEqual(self.page.run("return document.images.length"), 0)
        self.click("Remove")
        self.page.wait("document.querySelectorAll('.log').length === 0")
        self.fine()

    def test_survives_a_reload_and_a_second_tab(self):
        self.drop(LOGS[:2])
        kind = "document.querySelector('.kind select')"
        self.page.run(f"{kind}.value = ''; {kind}.dispatchEvent(new Event('change', {{ bubbles: true }}))")
        self.page.wait("document.getElementById('identify').disabled === false", 30)
        second = self.open(self.address)
        self.assertEqual(second.run(f"return {kind}.value"), "")
        second.run(f"{kind}.value = 'low-rate'; {kind}.dispatchEvent(new Event('change', {{ bubbles: true }}))")
        self.page.wait(f"{kind}.value === 'low-rate'")
        self.identify()
        self.page.wait(self.job(1))
        self.page.open(self.address)
        self.wait_job(1, "done")
        second.wait(f"{self.job(1)}?.dataset.status === 'done'", 60)
        self.click("Show the result", self.job(1))
        self.page.wait("location.hash === '#job-1' && document.querySelector('.terminal')")
        self.page.driver.refresh()
        self.page.wait("document.querySelector('.terminal')?.textContent.includes('predicts its own logs')")
        self.fine()

    def test_a_refused_value_does_not_stay_in_its_field(self):
        self.drop(LOGS)
        cutoff = """[...document.querySelectorAll('.label')].find(l => l.textContent === 'Cut-off / V')
                      .parentElement.querySelector('input')"""
        for typed, refusal, kept in (("2,75", "", "2.75"), ("27.5", "cut-off in V: expected a number from 0.5 to 6", "2.75"),
                                     ("two", "expected a number, found “two”", "2.75")):
            self.page.run(f"""const field = {cutoff}; field.focus(); field.value = '{typed}';
                              field.dispatchEvent(new Event('input', {{ bubbles: true }})); field.blur();""")
            self.page.wait(f"{cutoff}.value === '{kept}'")
            if refusal:
                self.page.wait(f"document.querySelector('[role=alert]')?.textContent.includes('{refusal}')")
        start = """[...document.querySelectorAll('.kind .label')].find(l => l.textContent === 'State of charge at the start')
                     .parentElement.querySelector('input')"""
        self.page.run(f"""const field = {start}; field.closest('details').open = true;
                          field.focus(); field.value = '0.95';
                          field.dispatchEvent(new Event('input', {{ bubbles: true }})); field.blur();""")
        deadline = time.monotonic() + 30
        text = ""
        while "initial_soc = 0.95" not in text and time.monotonic() < deadline:
            with urllib.request.urlopen(self.address + "campaign.toml", timeout=60) as answer:
                text = answer.read().decode()
        self.assertIn("initial_soc = 0.95", text)
        self.assertIn("cutoff_V = 2.75", text)

    def start_long_flight(self):
        self.page.run("document.getElementById('use-fly').open = true")
        self.page.run("""
          const field = (name) => [...document.querySelectorAll('#use-fly .label')].find(l => l.textContent === name)
            .parentElement.querySelector('input');
          for (const details of document.querySelectorAll('#use-fly details')) details.open = true;
          for (const [name, value] of [['--duration', '400'], ['simulation.substeps', '2000']]) {
            const input = field(name);
            input.focus();
            input.value = value;
            input.dispatchEvent(new Event('input', { bubbles: true }));
            input.blur();
          }""")
        time.sleep(0.3)
        self.page.run("document.getElementById('fly').click()")

    def test_two_jobs_wait_for_each_other_and_can_be_cancelled(self):
        self.start_long_flight()
        self.wait_job(1, "running")
        self.page.run("document.getElementById('fly').click()")
        self.wait_job(2, "queued")
        self.page.wait(f"{self.job(1)}.querySelector('progress').value > 0", 60)
        self.assertIn("flying", self.page.run(f"return {self.job(1)}.textContent"))
        self.click("Cancel", self.job(1))
        self.wait_job(1, "cancelled")
        self.wait_job(2, "running")
        self.click("Cancel", self.job(2))
        self.wait_job(2, "cancelled")
        self.fine()

    def test_says_when_the_server_has_ended(self):
        self.page.run("document.getElementById('use-fly').open = true")
        self.end()
        self.page.run("document.getElementById('fly').click()")
        self.page.wait("document.querySelector('[role=alert]')?.textContent.includes('lipoid serve has ended')", 30)
        self.assertNotIn("Failed to fetch", self.page.run("return document.body.textContent"))

    def test_a_flight_that_ends_early_is_not_shown_as_a_success(self):
        self.page.run("document.getElementById('use-fly').open = true")
        self.page.run("""
          const input = [...document.querySelectorAll('#use-fly .label')].find(l => l.textContent === '--initial-soc')
            .parentElement.querySelector('input');
          input.closest('details').open = true;
          input.focus();
          input.value = '0.02';
          input.dispatchEvent(new Event('input', { bubbles: true }));
          input.blur();""")
        time.sleep(0.3)
        self.page.run("document.getElementById('fly').click()")
        self.wait_job(1, "done")
        status = f"{self.job(1)}.querySelector('.status')"
        self.assertIn("done, with reservations", self.page.run(f"return {status}.textContent"))
        colours = self.page.run(f"""
          const good = document.createElement('span');
          good.className = 'status done';
          document.body.append(good);
          return [getComputedStyle({status}).color, getComputedStyle(good).color];""")
        self.assertNotEqual(*colours)
        self.fine()

    def test_goes_by_keys_and_fits_a_telephone(self):
        for width, dark in ((390, False), (390, True), (800, True)):
            window = self.open(self.address, width=width, dark=dark)
            self.assertLessEqual(window.run("return document.documentElement.scrollWidth"), width)
        # Every control can be reached by the tab key, and has a name.
        self.drop(LOGS[:1])
        unnamed = self.page.run("""
          return [...document.querySelectorAll('button, input:not([hidden]), select, textarea, a[href]')]
            .filter(e => e.tabIndex < 0 || !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim()))
            .map(e => e.outerHTML)""")
        self.assertEqual(unnamed, [])
        kind = self.page.driver.find_element("css selector", ".kind select")
        kind.send_keys("p")
        self.page.wait("document.querySelector('.kind select').value === 'pulses'")
        choose = self.page.driver.find_element("css selector", ".drop button")
        self.page.run("arguments[0].focus()", choose)
        self.assertEqual(self.page.run("return getComputedStyle(document.activeElement).outlineStyle"), "solid")
        self.fine()

    def test_takes_files_by_the_button(self):
        self.page.driver.find_element("id", "files").send_keys("\n".join(map(str, LOGS)))
        self.page.wait("document.querySelectorAll('.log[data-status=read]').length === 3", 60)
        self.fine()


if __name__ == "__main__":
    main()
