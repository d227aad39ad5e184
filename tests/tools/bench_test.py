#!/usr/bin/env python3
"""tools/bench without running anything: its judge of Thevenin cells, its goals, its report."""

import copy
import json
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
# pylint: disable=wrong-import-position
from benchmarks import figure, goals, joint, joint_peer, report, staged, thevenin

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


# A cell whose voltage is written row by row, with no pass that the peer has.
NODES = {"soc": [-0.1, 0.1, 0.3, 1.0], "voltage_V": [2.8, 3.5, 3.7, 4.2]}
TRUTH = {"alpha_C": 1000.0, "beta": 0.2, "r_s": 0.05, "r_1": 0.02, "tau_1": 40.0, "rho": 0.002,
         "tau_h": 300.0}


def voltage_of(time_s, current_A):
    """(4.46)-(4.51) with ten modes and the tail, rows held backward."""
    modes, branch, heat, charge = np.zeros(10), 0.0, 0.0, 0.0
    rates = (TRUTH["beta"] * np.arange(1, 11)) ** 2
    tail = 2.0 / TRUTH["beta"] ** 2 * sum(1.0 / m ** 2 for m in range(11, 10 ** 6))
    voltage_V = []
    for k, i in enumerate(current_A):
        dt = time_s[k] - time_s[k - 1] if k else 0.0
        modes = modes * np.exp(-rates * dt) + i * (1 - np.exp(-rates * dt)) / rates
        branch += (1 - np.exp(-dt / TRUTH["tau_1"])) * (TRUTH["r_1"] * i - branch)
        heat += (1 - np.exp(-dt / TRUTH["tau_h"])) * (i * i - heat)
        charge += i * dt
        soc = 1 - (charge + 2 * modes.sum() + tail * i) / TRUTH["alpha_C"]
        voltage_V.append(np.interp(soc, NODES["soc"], NODES["voltage_V"])
                         - (TRUTH["r_s"] - TRUTH["rho"] * heat) * i - branch)
    return np.array(voltage_V)


class JointPeerTest(unittest.TestCase):
    def problem(self, folder):
        """A slow discharge, one of two hours, and pulses, as CSV."""
        logs = []
        for kind, step_s, current in (
                ("low-rate", 60.0, lambda t: 0.012 if t else 0.0),
                ("constant-current", 10.0, lambda t: 0.13 if t else 0.0),
                ("pulses", 5.0, lambda t: 1.0 if 0.0 < t % 1200.0 <= 60.0 else 0.0)):
            hours = {"low-rate": 23.0, "constant-current": 2.0, "pulses": 5.0}[kind]
            time_s = np.arange(0.0, 3600.0 * hours, step_s)
            current_A = np.array([current(t) for t in time_s])
            file = pathlib.Path(folder) / f"{kind}.csv"
            np.savetxt(file, np.column_stack([time_s, current_A, voltage_of(time_s, current_A)]),
                       delimiter=",", header="time_s,current_A,voltage_V", comments="")
            logs.append({"file": str(file), "kind": kind, "hold": "backward", "initial_soc": 1.0,
                         "weight": 1.0})
        return {"logs": logs, "alpha_C": TRUTH["alpha_C"], "terms": 10, "tail": True,
                "branches": 1, "voltage_soc": NODES["soc"], "resistance_soc": [0.5],
                "self_heating": True, "charge_transfer": False, "smoothness": 1e-6,
                "charge_uncertainty": 0.002, "voltage_uncertainty_V": 0.001,
                "answer": {"rates": {name: TRUTH[name] for name in ("beta", "tau_1", "tau_h")},
                           "voltage_V": NODES["voltage_V"],
                           "tables": [[TRUTH["r_s"]], [TRUTH["r_1"]]], "heating": TRUTH["rho"]}}

    def test_it_has_the_equations_and_finds_the_truth(self):
        with tempfile.TemporaryDirectory() as folder:
            result = joint_peer.fit(self.problem(folder))
        # Means of blocks of rows are off by 1 uV here, a hundredth of any cycler's noise.
        self.assertLess(result["judged"]["rmse_V"], 3e-6)
        self.assertLess(result["rmse_V"], 5e-6)
        for name in ("beta", "tau_1"):  # one pulse current tells little of tau_h
            self.assertAlmostEqual(result["rates"][name] / TRUTH[name], 1.0, delta=0.01)

    def test_recurrences_by_doubling_are_those_row_by_row(self):
        generator = np.random.default_rng(1)
        decay, drive = generator.uniform(size=(2, 100, 3))
        wanted, state = [], np.zeros(3)
        for k in range(100):
            state = decay[k] * state + drive[k]
            wanted.append(state)
        np.testing.assert_allclose(joint_peer.recurrence(decay, drive), wanted, rtol=1e-13)

    def test_blocks_hold_one_current_and_all_rows(self):
        current_A = np.repeat([0.0, 2.0, 0.0, 2.0], 2000)
        edges = joint_peer.block_edges(current_A)
        self.assertLess(len(edges), 500)
        for first, end in zip(edges, np.append(edges[1:], len(current_A))):
            self.assertEqual(len(set(current_A[first:end])), 1)
        self.assertEqual(list(joint_peer.block_edges(current_A[:100])), list(range(100)))

    def test_the_structure_is_that_of_the_cell_file(self):
        cell = {"series_resistance_Ohm": {"soc": [0.0, 1.0], "resistance_Ohm": [0.1, 0.2]},
                "branches": [{"resistance_Ohm": {"soc": [0.0, 1.0], "resistance_Ohm": [0.3, 0.4]},
                              "time_constant_s": 9.0}],
                "diffusion": {"alpha_C": 5.0, "beta_per_sqrt_s": 0.1, "terms": 3, "tail": False},
                "open_circuit_voltage": {"soc": [0.0, 1.0], "voltage_V": [3.0, 4.0]},
                "charge_transfer": {"resistance_Ohm": {"soc": [0.0, 1.0],
                                                       "resistance_Ohm": [0.5, 0.6]},
                                    "current_A": 7.0},
                "run": {"options": {"joint": {"charge_uncertainty": 0.002,
                                              "voltage_uncertainty_V": 0.001}}}}
        with tempfile.TemporaryDirectory() as folder:
            campaign = pathlib.Path(folder) / "campaign.toml"
            campaign.write_text("[[log]]\nkind = 'pulses'\nfile = 'a.csv'\ninitial_soc = 0.9\n"
                                "[[log]]\nkind = 'validation'\nfile = 'b.csv'\n",
                                encoding="utf-8")
            given = joint.problem(campaign, {"joint": {"smoothness": 0.01}}, cell)
        self.assertEqual([log["initial_soc"] for log in given["logs"]], [0.9])
        self.assertEqual(given["answer"]["tables"], [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]])
        self.assertEqual(given["answer"]["rates"], {"beta": 0.1, "tau_1": 9.0, "i_0": 7.0})
        self.assertEqual((given["branches"], given["charge_transfer"], given["self_heating"]),
                         (1, True, False))
        self.assertEqual(given["smoothness"], 0.01)


def joint_result(wall_s=0.4, our_rmse_V=0.001):
    """The stage's figures of one campaign, and one that is not there."""
    run = {"wall_s": wall_s, "joint_s": 0.3, "processor_s": 0.5, "peak_memory_MB": 90.0,
           "rmse_V": 0.001}
    peer = {"total_s": 4.0, "fit_s": 3.9, "load_s": 0.1, "rows": 10000, "points": 2000,
            "unknowns": 90, "evaluations": 100, "rmse_V": 0.001}
    return {"stages": {"joint": {"peer_limit_s": 600.0, "comparable": 1.05, "peer_skipped": None,
                                 "campaigns": [
        {"name": "nissan", "structure": {},
         "lipoid": {"command": "lipoid identify", "runs": [run], "median": run},
         "peer": {"command": "python3 joint_peer.py", "runs": [peer], "median": peer,
                  "judges": {"lipoid_rmse_V": our_rmse_V}}},
        {"name": "dmegc", "skipped": "there is no campaign.toml"}]}}}


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

    def test_the_joint_method_needs_time_and_rmse(self):
        for figures, wanted in (((0.5, 0.001), True), ((0.51, 0.001), False),
                                ((0.4, 0.00105), True), ((0.4, 0.00106), False)):
            found = goals.judge(joint_result(*figures))[-2:]
            self.assertEqual([row["met"] for row in found], [wanted, None])
        self.assertIn("10.0 times faster", goals.judge(joint_result())[-2]["found"])

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

    def test_build_times_are_minutes_beside_their_goals(self):
        figures = {"command": "cmake --build x", "processor_s": 330.0, "wall_s": 180.0}
        text = report.builds({"configure": "cmake --preset dev", "cores": 2, "changed_file": "a.h",
                              "processor": "P", "compiler": "c++ 12", "commit": "0123abc",
                              "lipoid": figures, "tests": {**figures, "processor_s": 90.0},
                              "changed": figures, "load_average_after": 2.1})
        self.assertIn("| the program, from nothing (`tools/demo`) | 7 | 5.50 | 3.00 |", text)
        self.assertIn("(`tools/test`) | 7 | 1.50 | 3.00 |", text)
        self.assertIn("| all again after a change of `a.h` | 4 | 5.50 | 3.00 |", text)
        self.assertIn("Commit 0123abc, c++ 12, on 2 cores of P;", text)

    def test_the_joint_method_has_a_row_for_every_campaign(self):
        text = report.joint(joint_result()["stages"]["joint"], None)
        self.assertIn("| nissan | 0.400 | 0.300 | 4.00 | 3.90 | 10.00 | 10,000 | 100 |", text)
        self.assertIn("skipped: there is no campaign.toml", text)
        self.assertIn("    lipoid identify\n    python3 joint_peer.py\n", text)

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
