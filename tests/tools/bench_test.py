#!/usr/bin/env python3
"""tools/bench without running anything: its judge of Thevenin cells, its goals, its report."""

import copy
import json
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
# pylint: disable=wrong-import-position
from benchmarks import figure, goals, report, staged, thevenin

CELL = {
    "capacity_Ah": 1.0, "initial_soc": 0.9,
    "curve": {"soc": [0.0, 1.0], "voltage_V": [3.0, 4.0]},
    "parameters": {"r_s": 0.02, "r_1": 0.01, "c_1": 500.0, "r_2": 0.03, "c_2": 1000.0},
}


class TheveninTest(unittest.TestCase):
    def test_a_step_charges_both_branches_exponentially(self):
        time_s = np.array([0.0, 1.0, 3.5, 40.0, 41.0])
        current_A = np.array([0.0, 2.0, 2.0, 2.0, 2.0])
        found = thevenin.voltage_of((time_s, current_A), CELL, "backward")
        # 2 A from t = 0 on; the series resistance acts from the first row with the current on.
        soc = 0.9 - 2.0 * time_s / 3600.0
        wanted = 3.0 + soc - 0.02 * current_A
        for resistance, tau in ((0.01, 5.0), (0.03, 30.0)):
            wanted -= 2.0 * resistance * (1.0 - np.exp(-time_s / tau))
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-14)

    def test_forward_is_backward_one_interval_later(self):
        time_s = np.arange(6.0)
        pulse = np.array([0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        later = np.roll(pulse, 1)
        backward = thevenin.branch_voltage(time_s, later, 0.01, 3.0, "backward")
        forward = thevenin.branch_voltage(time_s, pulse, 0.01, 3.0, "forward")
        np.testing.assert_allclose(forward, backward, rtol=0.0, atol=1e-16)

    def test_straight_lines_are_the_limit_of_many_steps(self):
        coarse_s = np.array([0.0, 2.0, 5.0, 11.0])
        current_A = np.array([0.0, 3.0, 3.0, -1.0])
        fine_s = np.linspace(0.0, 11.0, 110001)
        middle = np.interp(fine_s, coarse_s, current_A)
        steps = 0.5 * (middle[:-1] + middle[1:])
        stepped = thevenin.branch_voltage(fine_s, np.concatenate([[0.0], steps]), 0.03, 4.0,
                                          "backward")
        lines = thevenin.branch_voltage(coarse_s, current_A, 0.03, 4.0, "linear")
        # Second order in steps of 0.1 ms: (1e-4/4)² of 0.1 V.
        np.testing.assert_allclose(lines, np.interp(coarse_s, fine_s, stepped), rtol=0.0, atol=1e-9)


class PeerLineTest(unittest.TestCase):
    def test_figures_are_read_from_what_the_peer_prints(self):
        line = ("alpha 116327.1 beta0 0.1782 load 0.05 s eval 0.006 s fit 3.04 s nfev 471 rmse "
                "0.006172 theta [1.8e-01 1.6e-03 3.1e-04 6.8e+04] TOTAL 3.10 s\n")
        self.assertEqual(staged.PEER_LINE.search(line).groups(),
                         ("116327.1", "0.05", "0.006", "3.04", "471", "0.006172",
                          "1.8e-01 1.6e-03 3.1e-04 6.8e+04", "3.10"))


RESULT = {"stages": {"staged": {
    "lipoid": {"median": {"wall_s": 0.4, "joint_fit_s": 0.1, "rmse_V": 0.006,
                          "peak_memory_MB": 500}},
    "peer": {"median": {"total_s": 100.0, "fit_s": 100.0, "rmse_V": 0.006}},
    "validation": {"difference_V": 0.0},
}}}


def met(result):
    return {row["goal"].split(",")[0]: row["met"] for row in goals.judge(result)}


class GoalsTest(unittest.TestCase):
    def test_ratios_are_met_at_the_goal_and_not_below(self):
        found = met(RESULT)
        self.assertTrue(found["whole staged run"])
        self.assertTrue(found["the joint fit (4.61) alone"])
        slower = copy.deepcopy(RESULT)
        slower["stages"]["staged"]["lipoid"]["median"].update(wall_s=0.401, joint_fit_s=0.101)
        self.assertFalse(met(slower)["whole staged run"])
        self.assertFalse(met(slower)["the joint fit (4.61) alone"])

    def test_speed_at_a_larger_rmse_does_not_count(self):
        worse = copy.deepcopy(RESULT)
        worse["stages"]["staged"]["lipoid"]["median"]["rmse_V"] = 0.006001
        self.assertFalse(met(worse)["whole staged run"])

    def test_what_was_not_measured_is_open(self):
        self.assertEqual(set(met({"stages": {}}).values()), {None})
        self.assertIsNone(met(RESULT)["particle swarm with the thesis' settings"])

    def test_particle_swarm_needs_time_and_cost(self):
        for wall_s, above, wanted in ((9.9, 0.1, True), (10.0, 0.0, False), (1.0, 0.11, False)):
            row = {"optimizer": "particle-swarm", "wall_s": wall_s,
                   "cost_above_best_percent": above}
            found = met({"stages": {"optimizers": {"rows": [row]}}})
            self.assertEqual(found["particle swarm with the thesis' settings"], wanted)


class ReportTest(unittest.TestCase):
    def test_numbers_keep_their_significant_digits(self):
        for value, wanted in ((1234567.0, "1,235,000"), (0.00123456, "0.001235"),
                              (12.3456, "12.35"), (1e-9, "1.000e-09"), (0.0, "0"), (None, "-"),
                              (float("nan"), "-")):
            self.assertEqual(report.number(value), wanted)

    def test_axes_place_decades_and_round_steps(self):
        decades = figure.Axis([1e4, 1e8], 200.0, logarithmic=True)
        self.assertAlmostEqual(decades.place(1e6), 100.0)
        linear = figure.Axis([0.0, 7.3], 100.0, logarithmic=False)
        self.assertEqual(linear.ticks, [0.0, 2.0, 4.0, 6.0, 8.0])

    def test_the_report_names_every_goal_of_the_committed_figures(self):
        result = json.loads((ROOT / "docs/benchmarks.json").read_text(encoding="utf-8"))
        text, _ = report.write(result, "figure.svg")
        for row in result["goals"]:
            self.assertIn(row["goal"], text)
        self.assertEqual(result["goals"], goals.judge(result))


if __name__ == "__main__":
    unittest.main()
