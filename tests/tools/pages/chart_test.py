"""What every chart of a page can do: zoom, cursor, keys, legend, saved files, dark mode and paper."""

import unittest

from page import LAB, PageTest, main

LOGS = [LAB / "dmegc_inr18650_26_r1" / name for name in ("pulse.csv", "cc_1c.csv")]

RANGES = "return [...document.querySelectorAll('.chart')].map(f => [f.plot.scales.x.min, f.plot.scales.x.max])"

# Drags over the middle third of a chart.
DRAG = """
const over = document.querySelectorAll('.chart')[arguments[0]].plot.over;
const box = over.getBoundingClientRect();
const at = (type, share, target) => target.dispatchEvent(new MouseEvent(type, {
  bubbles: true, cancelable: true, view: window, button: 0, buttons: 1, movementX: 9,
  clientX: box.left + share * box.width, clientY: box.top + box.height / 2}));
at('mousemove', 1 / 3, over); at('mousedown', 1 / 3, over);
at('mousemove', 2 / 3, over); at('mouseup', 2 / 3, document);
"""

KEY = """
const plot = document.querySelectorAll('.chart')[arguments[0]].querySelector('.plot');
plot.focus();
plot.dispatchEvent(new KeyboardEvent('keydown', {key: arguments[1], bubbles: true, cancelable: true}));
"""

# What a click on a button of the Save menu would store, as text (PNG: its first bytes).
SAVED = """
const [index, name, done] = arguments;
const old = URL.createObjectURL;
URL.createObjectURL = (blob) => {
  URL.createObjectURL = old;
  const kept = HTMLAnchorElement.prototype.click;
  HTMLAnchorElement.prototype.click = function () {
    HTMLAnchorElement.prototype.click = kept;
    const file = this.download;
    blob.slice(0, 4e6)[blob.type === 'image/png' ? 'arrayBuffer' : 'text']().then((bytes) =>
      done([file, typeof bytes === 'string' ? bytes : [...new Uint8Array(bytes).slice(0, 4)]]));
  };
  return 'blob:none';
};
const menu = document.querySelectorAll('.chart')[index].querySelector('.menu');
[...menu.querySelectorAll('button')].find((b) => b.textContent === name).click();
"""


# Room right of where the time axis of each chart ends, and half the width of a number there.
ROOM = """
return [...document.querySelectorAll('.chart')].map(({ plot }) => {
  plot.ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  const width = plot.ctx.measureText('4:30:00').width;
  return [plot.ctx.canvas.width - plot.bbox.left - plot.bbox.width, width / 2];
});"""


class Chart(PageTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.lipoid(cls(), "validate", "gifi-600mAh-1", *LOGS, "--report", "page.html")

    def test_charts_of_a_log_zoom_together_and_others_do_not(self):
        page = self.open("page.html")
        before = page.run(RANGES)
        page.run(DRAG, 0)
        page.wait("document.querySelectorAll('.chart')[0].querySelector('.tools button').hidden === false")
        after = page.run(RANGES)
        width = before[0][1] - before[0][0]
        for linked in (0, 1, 2):
            self.assertAlmostEqual(after[linked][1] - after[linked][0], width / 3, delta=0.02 * width)
            self.assertAlmostEqual(after[linked][0], before[0][0] + width / 3, delta=0.02 * width)
        self.assertEqual(after[3:], before[3:])
        page.run("document.querySelectorAll('.chart')[1].querySelector('.tools button').click()")
        page.wait("document.querySelectorAll('.chart')[0].querySelector('.tools button').hidden")
        self.assertEqual(page.run(RANGES), before)
        self.assertEqual(page.complaints(), [])

    def test_the_last_number_of_a_time_axis_is_whole(self):
        for room, half in self.open("page.html").run(ROOM):
            self.assertGreaterEqual(room, half)

    def test_keys_zoom_move_and_reset(self):
        page = self.open("page.html")
        before = page.run(RANGES)
        page.run(KEY, 0, "+")
        page.wait(f"(() => {{ {RANGES} }})()[1][0] > {before[1][0]}")
        zoomed = page.run(RANGES)
        self.assertAlmostEqual(zoomed[0][1] - zoomed[0][0], (before[0][1] - before[0][0]) / 2)
        page.run(KEY, 1, "Escape")
        page.wait(f"(() => {{ {RANGES} }})()[0][0] === {before[0][0]}")
        page.run(KEY, 0, "Home")
        page.wait("document.querySelector('.legend .at').textContent !== ''")
        first = page.run("return document.querySelector('.chart').plot.data[1][0]")
        shown = page.run("return document.querySelector('.legend output').textContent")
        self.assertAlmostEqual(float(shown), first, delta=1e-4)
        self.assertIn("measured", page.run("return document.querySelector('.spoken').textContent"))

    def test_the_legend_hides_a_line(self):
        page = self.open("page.html")
        page.run("document.querySelector('.legend button').click()")
        self.assertEqual(page.run("const p = document.querySelector('.chart').plot;"
                                  "return [p.series[1].show, p.series[2].show]"), [False, True])
        self.assertEqual(page.run("return document.querySelector('.legend button').getAttribute('aria-pressed')"), "false")

    def test_saves_the_samples_and_the_picture(self):
        page = self.open("page.html")
        name, text = page.driver.execute_async_script(SAVED, 0, "as CSV")
        self.assertTrue(name.endswith(".csv"), name)
        rows = text.strip().split("\n")
        points = page.run("return document.querySelector('.chart').plot.data[0].length")
        self.assertEqual(rows[0], "time / s,measured / V,predicted / V")
        self.assertEqual(len(rows), points + 1)
        first = page.run("const d = document.querySelector('.chart').plot.data; return [d[0][0], d[1][0], d[2][0]]")
        self.assertEqual([float(value) for value in rows[1].split(",")], first)
        name, text = page.driver.execute_async_script(SAVED, 0, "as SVG")
        self.assertIn("<svg", text)
        self.assertIn("voltage / V", text)
        name, start = page.driver.execute_async_script(SAVED, 0, "as PNG")
        self.assertEqual(start, [0x89, *b"PNG"])
        self.assertEqual(page.complaints(), [])

    def test_is_coloured_anew_when_the_page_turns_dark(self):
        page = self.open("page.html")
        stroke = "return document.querySelector('.chart').plot.series[1]._stroke"
        light = page.run(stroke)
        page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        page.wait(f"document.querySelector('.chart').plot.series[1]._stroke !== '{light}'")

    def test_paper_has_each_chart_whole(self):
        page = self.open("page.html", dark=True)
        page.pdf(self.folder / "page.pdf")
        paper = (self.folder / "page.pdf").read_bytes()
        self.assertTrue(paper.startswith(b"%PDF"))
        page.run("dispatchEvent(new Event('beforeprint'))")
        pictures = page.run("return [...document.querySelectorAll('svg.printed')].map(s => [s.querySelectorAll('path').length,"
                            "s.querySelector('path').getAttribute('stroke')])")
        self.assertEqual(len(pictures), 6)  # voltage, error and current of two logs
        for shapes, grid in pictures:
            self.assertGreater(shapes, 5)
            self.assertEqual(grid, "#e3e5e8")  # that of paper, though the page is dark

    def test_fits_a_narrow_screen(self):
        page = self.open("page.html", width=390)
        self.assertEqual(page.run("return document.documentElement.scrollWidth"), 390)


if __name__ == "__main__":
    main()
