#!/usr/bin/env python3
"""tools/reproduce without flying anything: what it computes, compares, draws and writes."""

import json
import math
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
# pylint: disable=wrong-import-position
from benchmarks.figure import Axis
from thesis import compare, poles, report, results, square
from thesis.lipoid import Lipoid, between, xis


class FakeLipoid(Lipoid):
    """Answers with a flight whose pitch error is a growing or falling oscillation."""

    def __init__(self, rate_per_s):  # pylint: disable=super-init-not-called
        self.rate_per_s = rate_per_s
        self.scratch = pathlib.Path("/nowhere")

    def log(self, *words, step_s):
        times = [k * step_s for k in range(round(150.0 / step_s))]
        swing = [0.3 * math.exp(self.rate_per_s * t) * math.sin(2.0 * math.pi * t / 7.5)
                 for t in times]
        return {}, {"time_s": times, "pitch_rad": swing, "pitch_reference_rad": [0.0] * len(times)}


class PolesTest(unittest.TestCase):
    def test_the_growth_of_an_oscillation_is_found(self):
        for rate in (0.004, -0.03):
            found = poles.growth_in_flight(FakeLipoid(rate), 0.8)["rate_per_s"]
            # Both spans are four whole periods: the ratio of their mean squares is exact, up to
            # the means that are taken away, of order (rate/omega)².
            self.assertAlmostEqual(found, rate, delta=1e-2 * abs(rate))

    def test_a_crossing_lies_on_the_straight_line(self):
        rows = [{"xi": 0.8, "rate_per_s": 0.03}, {"xi": 0.82, "rate_per_s": 0.01},
                {"xi": 0.84, "rate_per_s": -0.03}]
        self.assertAlmostEqual(poles.crossing(rows), 0.825, delta=1e-12)
        self.assertIsNone(poles.crossing(rows[:2]))

    def test_damping_is_that_of_the_oscillator(self):
        # s² + 2 zeta w s + w² with zeta = 0.6, w = 5.
        self.assertAlmostEqual(poles.damping([-3.0, 4.0]), 0.6, delta=1e-15)
        self.assertAlmostEqual(poles.damping([3.0, -4.0]), -0.6, delta=1e-15)


class SquareTest(unittest.TestCase):
    def test_a_spread_has_the_deviation_of_a_sample(self):
        found = square.spread([1.0, 2.0, 3.0, 4.0])
        self.assertEqual(found["mean"], 2.5)
        self.assertAlmostEqual(found["deviation"], math.sqrt(5.0 / 3.0), delta=1e-15)
        self.assertAlmostEqual(found["error_of_mean"], math.sqrt(5.0 / 12.0), delta=1e-15)
        self.assertIsNone(square.spread([1.0]))


class LipoidTest(unittest.TestCase):
    def test_ratios_are_as_typed_and_include_both_ends(self):
        self.assertEqual(xis(0.8, 0.84), [0.8, 0.81, 0.82, 0.83, 0.84])
        self.assertEqual(len(xis()), 21)

    def test_a_span_of_time_includes_both_ends(self):
        self.assertEqual(between([0.0, 0.1, 0.2, 0.30000000000000004, 0.4], 0.1, 0.3), [1, 2, 3])


class CompareTest(unittest.TestCase):
    OLD = {"command": "lipoid fly", "rows": [{"charge_C": 100.0, "xi": 0.8, "hovers": True}]}

    def changed(self, **values):
        new = json.loads(json.dumps(self.OLD))
        new["rows"][0].update(values)
        return list(compare.differences(new, self.OLD))

    def test_rounding_passes_and_a_changed_figure_does_not(self):
        self.assertEqual(self.changed(charge_C=100.01), [])
        self.assertEqual(self.changed(charge_C=100.2),
                         ["rows/0/charge_C: 100.2, in the JSON 100.0"])
        self.assertEqual(len(self.changed(charge_C=math.nan)), 1)

    def test_words_truths_and_keys_must_be_the_same(self):
        self.assertEqual(len(self.changed(hovers=False)), 1)
        self.assertEqual(len(self.changed(hovers=None)), 1)
        self.assertEqual(self.changed(mass_kg=1.0), ["rows/0/mass_kg: only in the new results"])
        self.assertEqual(len(list(compare.differences({"rows": []}, {"rows": [1.0]}))), 1)

    def test_the_tolerance_of_a_key_is_its_own(self):
        self.assertEqual(compare.tolerance(("attitude", 0, "rows", 3, "mse_pitch_deg2")),
                         compare.TOLERANCES["mse_pitch_deg2"])
        self.assertEqual(compare.tolerance(("square", "estimated", 0, "rows", "mse_pitch_deg2")),
                         compare.TOLERANCES["estimated"])
        self.assertEqual(compare.tolerance(("altitude", 0, "peak_m")), compare.DEFAULT)


class TextTest(unittest.TestCase):
    def test_the_text_is_the_same_json_with_numbers_on_one_line(self):
        value = {"a": [1.0, -2.5, 3e-7], "b": [{"c": [[0.5, 1.0], [2.0, 0.0]], "d": "[1,\n 2]"}],
                 "e": [], "f": None}
        text = results.text_of(value)
        self.assertEqual(json.loads(text), value)
        self.assertIn("[1.0, -2.5, 3e-07]", text)


class AxisTest(unittest.TestCase):
    def test_an_axis_from_the_least_value_holds_negative_values(self):
        axis = Axis([-0.28, -0.04, 0.01], 200, from_zero=False)
        self.assertLessEqual(axis.lo, -0.28)
        self.assertGreaterEqual(axis.hi, 0.01)
        self.assertIn(0.0, axis.ticks)
        self.assertAlmostEqual(axis.place(axis.lo), 0.0, delta=1e-9)
        self.assertAlmostEqual(axis.place(axis.hi), 200.0, delta=1e-9)


class ReportTest(unittest.TestCase):
    def test_every_stage_is_optional(self):
        committed = json.loads((ROOT / "docs/thesis-results.json").read_text(encoding="utf-8"))
        self.assertEqual(committed["schema"], results.SCHEMA)
        self.assertEqual(set(committed["stages"]), set(results.STAGES))
        self.assertEqual(set(report.SECTIONS), set(results.STAGES))
        for name, stage in committed["stages"].items():
            self.assertIn("lipoid ", report.SECTIONS[name](stage, {name: stage}), name)


if __name__ == "__main__":
    unittest.main()
