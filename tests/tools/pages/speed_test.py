"""A page of a large log: how large it is, and what its charts do when one of them is zoomed."""

import unittest

from page import PageTest, main

MOST_BYTES = 2_000_000

# Counts from here on how often each chart is drawn.
COUNT = """
window.plots = [...document.querySelectorAll('.chart')].map((chart) => chart.plot).filter((plot) => plot.group);
window.drawn = plots.map(() => 0);
plots.forEach((plot, k) => plot.hooks.draw.push(() => { drawn[k] += 1; }));
return plots.length;
"""

# How long a chart and those linked to it take to redraw a part of x, in ms. uPlot draws in a microtask, the linked charts in
# the next ones: all are done before a timeout.
ZOOM = """
const xs = plots[0].data[0];
const at = (share) => xs[Math.floor(xs.length * (share + 0.1 * arguments[0]))];
drawn.fill(0);
const began = performance.now();
plots[0].setScale('x', {min: at(0.1), max: at(0.5)});
document.took = undefined;
setTimeout(() => { document.took = performance.now() - began; });
"""


class Speed(PageTest):
    def test_a_log_of_a_million_rows_is_small_and_each_chart_drawn_once(self):
        self.lipoid("synthesize", "gifi-600mAh-1", "--with", "r_1=0.03,c_1=1500", "--sampling-s", "0.02",
                    "--voltage-noise-V", "0.001", "--seed", "1", "-o", "logs")
        self.lipoid("validate", "logs/truth.json", "logs/low_rate.csv", "--report", "page.html")
        self.assertLess((self.folder / "page.html").stat().st_size, MOST_BYTES)
        page = self.open("page.html")
        self.assertEqual(page.run(COUNT), 3)
        self.assertGreater(page.run("return plots[0].data[0].length"), 20_000)
        times = []
        for n in range(5):
            page.run(ZOOM, n)
            page.wait("document.took !== undefined")
            times.append(page.run("return document.took"))
            # Once each: a chart that answers its own followers, or that is drawn for each of them, would show here.
            self.assertEqual(page.run("return drawn"), [1, 1, 1])
            ranges = page.run("return plots.map(({scales}) => [scales.x.min, scales.x.max])")
            self.assertEqual(ranges, [ranges[0]] * 3)
            self.assertGreater(ranges[0][0], 0)
        # The goal is 50 ms; what a machine takes that does other things beside is no matter of a test.
        print(f"a zoom of three linked charts takes {sorted(times)[2]:.1f} ms")


if __name__ == "__main__":
    main()
