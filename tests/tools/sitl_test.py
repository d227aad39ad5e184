#!/usr/bin/env python3
"""lipoid sitl from the other side: an autopilot's end of ArduPilot's JSON interface.

    sitl_test.py --lipoid PROGRAM [unittest's arguments]
    sitl_test.py --lipoid PROGRAM --real-time      how much faster than the clock lipoid is

The client packs frames and reads answers as the interface's documentation says, flies by loops of
its own, and compares with computations of its own: hover by the vehicle file, the battery by the
independent cell of tests/reference. Needs python3 with numpy and scipy.
"""

import argparse
import json
import math
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/reference"))
import reference_cell  # noqa: E402

LIPOID = None
CELL = "gifi-600mAh-1"
VEHICLE = "mambo-coupled"
GRAVITY = 9.81
PATIENCE_S = 20.0


class Live:
    """A lipoid sitl and the socket of its autopilot."""

    def __init__(self, *arguments, rate_Hz=400, idle_s=PATIENCE_S):
        self.folder = tempfile.TemporaryDirectory()
        self.summary_file = pathlib.Path(self.folder.name) / "s.json"
        self.said = pathlib.Path(self.folder.name) / "said"
        with self.said.open("w") as said:
            self.process = subprocess.Popen(
                [LIPOID, "sitl", "--port", "0", "--idle-s", str(idle_s), *arguments, "--summary",
                 str(self.summary_file)],
                stdout=subprocess.PIPE, stderr=said, text=True)
        patient_until = time.monotonic() + PATIENCE_S
        while not (found := re.search(r"at (\S+) port (\d+) \(UDP\)", self.said.read_text())):
            if self.process.poll() is not None or time.monotonic() > patient_until:
                raise AssertionError(self.said.read_text())
            time.sleep(0.005)
        self.address = (found[1], int(found[2]))
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(PATIENCE_S)
        self.rate_Hz = rate_Hz
        self.count = 0

    def send(self, pwm, count=None, magic=18458, rate_Hz=None, channels=16):
        values = list(pwm) + [0] * (channels - len(pwm))
        self.socket.sendto(struct.pack(f"<HHI{channels}H", magic, rate_Hz or self.rate_Hz,
                                       self.count if count is None else count, *values), self.address)

    def receive(self):
        text = self.socket.recv(4096).decode("ascii")
        assert text.startswith("\n") and text.endswith("\n") and text.count("\n") == 2, repr(text)
        assert " " not in text, "ArduPilot's reader wants the bracket right after the colon"
        return json.loads(text)

    def frame(self, pwm, **how):
        """The next frame and its answer."""
        self.send(pwm, **how)
        self.count += 1
        return self.receive()

    def silent(self):
        """Whether nothing comes."""
        self.socket.settimeout(0.2)
        try:
            self.socket.recv(4096)
            return False
        except TimeoutError:
            return True
        finally:
            self.socket.settimeout(PATIENCE_S)

    def end(self, how=signal.SIGINT):
        if how is not None:
            self.process.send_signal(how)
        self.out, _ = self.process.communicate(timeout=PATIENCE_S)
        self.err = self.said.read_text()
        self.socket.close()
        summary = json.loads(self.summary_file.read_text()) if self.summary_file.exists() else None
        self.folder.cleanup()
        return summary

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()
        self.socket.close()


class Autopilot:
    """Loops on altitude, roll, pitch and yaw; the mixer is ArduCopter's quad X."""

    def __init__(self, hover_duty, rate_Hz):
        self.hover, self.dt = hover_duty, 1.0 / rate_Hz
        self.climb_integral = 0.0

    def pwm(self, answer, altitude_m, roll=0.0, pitch=0.0, yaw=0.0):
        attitude, rates = answer["attitude"], answer["imu"]["gyro"]
        climb = -answer["velocity"][2]
        wanted_climb = max(-0.6, min(1.0, 1.5 * (altitude_m + answer["position"][2])))
        error = wanted_climb - climb
        self.climb_integral = max(-0.3, min(0.3, self.climb_integral + 0.1 * error * self.dt))
        throttle = self.hover + 0.12 * error + self.climb_integral
        right = 0.017 * (6.0 * (roll - attitude[0]) - rates[0])
        up = 0.017 * (6.0 * (pitch - attitude[1]) - rates[1])
        turned = math.remainder(yaw - attitude[2], 2.0 * math.pi)
        clockwise = max(-0.1, min(0.1, 0.06 * (1.5 * turned - rates[2])))
        # 1 front right (counter-clockwise), 2 back left (counter-clockwise), 3 front left, 4 back right.
        motors = (throttle - right + up + clockwise, throttle + right - up + clockwise,
                  throttle + right + up - clockwise, throttle - right - up - clockwise)
        return [round(1000 + 1000 * max(0.0, min(1.0, duty))) for duty in motors]


def vehicle():
    return tomllib.loads((ROOT / f"fixtures/vehicles/{VEHICLE}.toml").read_text())


def hover_power_W():
    """What four motors take at hover, whatever the voltage."""
    v = vehicle()
    speed = math.sqrt(v["mass_kg"] * GRAVITY / (4.0 * v["thrust_coefficient_N_s2"]))
    torque = (v["friction_N_m_s"] + v["torque_coefficient_N_m_s2"] * speed) * speed
    current = torque / v["motor_constant_N_m_per_A"]
    volts = v["armature_resistance_Ohm"] * current + v["motor_constant_N_m_per_A"] * speed
    return 4.0 * volts * current


def real_time(frames):
    """The summary of so many frames at 400 Hz, sent as fast as they are answered."""
    with Live() as live:
        for _ in range(frames):
            live.send([1500] * 4)
            live.count += 1
            live.socket.recv(4096)
        return live.end()


class Sitl(unittest.TestCase):
    def assert_all_near(self, found, wanted, delta):
        for one, other in zip(found, wanted, strict=True):
            self.assertAlmostEqual(one, other, delta=delta)

    def test_takes_off_hovers_and_lands_on_the_battery(self):
        with Live() as live:
            answers = [live.frame([1000] * 4)]
            self.assert_all_near(answers[0]["imu"]["accel_body"], (0.0, 0.0, -GRAVITY), 1e-6)
            self.assert_all_near(answers[0]["position"], (0.0, 0.0, 0.0), 1e-9)
            pilot = Autopilot(0.575, live.rate_Hz)

            def fly(seconds, altitude, **angles):
                for _ in range(round(seconds * live.rate_Hz)):
                    answers.append(live.frame(pilot.pwm(answers[-1], altitude, **angles)))
                return answers[-round(seconds * live.rate_Hz):]

            fly(4.0, 2.0)
            hover = fly(4.0, 2.0)
            for answer in hover[-400:]:
                self.assertAlmostEqual(-answer["position"][2], 2.0, delta=0.05)
            # Its power is the weight's; 0.5 % is what the pulse widths of a thousand steps leave.
            power = sum(a["battery"]["voltage"] * a["battery"]["current"]
                        for a in hover[-800:]) / 800
            self.assertAlmostEqual(power / hover_power_W(), 1.0, delta=0.005)
            fly(2.0, 2.0, roll=0.05, yaw=0.4)
            self.assertGreater(answers[-1]["position"][1], 0.1)  # to the right: east
            self.assertAlmostEqual(answers[-1]["attitude"][0], 0.05, delta=0.01)
            self.assertAlmostEqual(answers[-1]["attitude"][2], 0.4, delta=0.1)
            fly(1.0, 2.0, pitch=0.05, yaw=0.4)
            fly(6.0, -0.5, yaw=0.4)
            landed = [live.frame([1000] * 4) for _ in range(round(2.0 * live.rate_Hz))][-1]
            answers.append(landed)
            self.assertAlmostEqual(landed["position"][2], 0.0, delta=0.001)
            self.assert_all_near(landed["velocity"], (0.0, 0.0, 0.0), 1e-3)
            self.assertAlmostEqual(landed["imu"]["accel_body"][2], -GRAVITY, delta=0.01)
            self.assertAlmostEqual(landed["battery"]["current"], 0.0, delta=1e-3)
            summary = live.end()

        # The battery by another computation of the same cell, under the current that was sent.
        self.assertEqual(live.process.returncode, 0, live.err)
        cell = json.loads((ROOT / f"fixtures/cells/{CELL}.json").read_text())
        kept = answers[:-1]
        stamps = [0.0] + [a["timestamp"] for a in kept]
        current = [0.0] + [a["battery"]["current"] for a in kept]
        voltage = reference_cell.predict(cell, stamps, current)["voltage_V"][1:]
        worst = max(abs(v - a["battery"]["voltage"])
                    for v, a in zip(voltage, kept, strict=True))
        # The current of a frame's end stands for its mean: 1 mV after take-off, against a fall of 500.
        self.assertLess(worst, 2e-3)
        lowest = min(a["battery"]["voltage"] for a in answers)
        self.assertLess(lowest, 3.75)

        self.assertEqual(summary["frames"], len(answers) - 1 + round(2.0 * live.rate_Hz))
        self.assertEqual(summary["ended_by"], "interrupted")
        flight = summary["flights"][0]
        self.assertAlmostEqual(flight["minimum_voltage_V"], lowest, delta=1e-6)
        self.assertAlmostEqual(flight["simulated_s"], summary["frames"] / live.rate_Hz, delta=1e-6)
        charge = sum(current) / live.rate_Hz
        self.assertAlmostEqual(flight["charge_C"] / charge, 1.0, delta=1e-3)
        # What fly finds of hover on a full battery.
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "f.json"
            subprocess.run([LIPOID, "fly", "hover", "--duration", "0.1", "--summary", file, "--quiet"],
                           check=True, stdout=subprocess.DEVNULL)
            self.assertAlmostEqual(json.loads(file.read_text())["trim"]["battery_A"],
                                   summary["hover_A"], delta=1e-9)

    def test_the_channels_are_those_of_the_quad_x(self):
        """More thrust of two motors turns it as ArduCopter expects."""
        for louder, axis, sign in (((2, 3), 0, +1),   # left ones: right side down
                                   ((1, 4), 0, -1),
                                   ((1, 3), 1, +1),   # front ones: nose up
                                   ((2, 4), 1, -1),
                                   ((1, 2), 2, +1),   # counter-clockwise ones: nose to the right
                                   ((3, 4), 2, -1)):
            with Live("--vehicle", "mambo-physical") as live, self.subTest(louder=louder):
                for _ in range(200):
                    live.frame([1800] * 4)
                pwm = [1850 if channel in louder else 1750 for channel in (1, 2, 3, 4)]
                for _ in range(20):
                    answer = live.frame(pwm)
                self.assertGreater(-answer["position"][2], 0.1)
                gyro = answer["imu"]["gyro"]
                self.assertGreater(sign * gyro[axis], 0.02)
                others = [abs(gyro[k]) for k in range(3) if k != axis]
                self.assertLess(max(others), 0.1 * abs(gyro[axis]))
                live.end()

    def test_waits_on_the_ground_until_thrust_exceeds_weight(self):
        with Live() as live:
            for _ in range(1200):
                answer = live.frame([1500] * 4)  # hover is 1575
            self.assertLess(abs(answer["position"][2]), 0.004)
            self.assertGreater(answer["battery"]["current"], 1.0)
            for _ in range(400):
                answer = live.frame([1700] * 4)
            self.assertGreater(-answer["position"][2], 0.1)
            summary = live.end(signal.SIGTERM)
        self.assertEqual(live.process.returncode, 0)
        self.assertGreater(summary["flights"][0]["takeoff_s"], 3.0)

    def test_what_is_malformed_is_ignored_and_counted(self):
        good = struct.pack("<HHI16H", 18458, 400, 1, *([1000] * 16))
        bad = [b"", b"\x00", good[:-1], good + b"\x00", good + good, b"{}\n", bytes(2000), bytes(9000),
               struct.pack("<HHI16H", 29569, 400, 1, *([1000] * 16)),   # the magic of 32 channels
               struct.pack("<HHI32H", 18458, 400, 1, *([1000] * 32)),
               struct.pack("<HHI16H", 18459, 400, 1, *([1000] * 16)),
               struct.pack(">HHI16H", 18458, 400, 1, *([1000] * 16)),
               struct.pack("<HHI16H", 18458, 0, 1, *([1000] * 16))]     # no rate
        with Live() as live:
            live.frame([1000] * 4)
            for datagram in bad:
                live.socket.sendto(datagram, live.address)
            self.assertTrue(live.silent())
            answer = live.frame([1000] * 4)
            self.assertAlmostEqual(answer["timestamp"], 2.0 / 400.0, delta=1e-9)
            summary = live.end()
        self.assertEqual(summary["malformed"], len(bad))
        self.assertEqual(summary["packets"], len(bad) + 2)
        self.assertEqual(summary["frames"], 2)
        self.assertIn("malformed, ignored", live.out)

    def test_thirty_two_channels_fly_alike(self):
        with Live() as live:
            for k in range(400):
                answer = live.frame([1700] * 4, **({"magic": 29569, "channels": 32} if k % 2 else {}))
            live.end()
        with Live() as live:
            for _ in range(400):
                alike = live.frame([1700] * 4)
            live.end()
        self.assertEqual(answer, alike)

    def test_repeated_and_lost_frames(self):
        with Live() as live:
            for _ in range(100):
                answer = live.frame([1700] * 4)
            live.send([1000] * 4, count=live.count - 1)  # the answer was lost: the same again
            self.assertEqual(live.receive(), answer)
            live.count += 7  # seven frames never came
            later = live.frame([1700] * 4)
            self.assertAlmostEqual(later["timestamp"], 101.0 / 400.0, delta=1e-9)
            summary = live.end()
        self.assertEqual((summary["repeated"], summary["missed"], summary["restarts"]), (1, 7, 0))

    def test_a_restart_of_the_autopilot_is_one_of_the_flight(self):
        with Live() as live:
            first = [live.frame([1800] * 4) for _ in range(400)]
            live.count = 0
            second = [live.frame([1800] * 4) for _ in range(400)]
            summary = live.end()
        self.assertEqual(first, second)
        self.assertGreater(-first[-1]["position"][2], 0.1)
        self.assertEqual(summary["restarts"], 1)
        self.assertEqual(len(summary["flights"]), 2)
        self.assertEqual(summary["flights"][0], summary["flights"][1])
        self.assertAlmostEqual(summary["simulated_s"], 2.0, delta=1e-9)
        self.assertIn("the autopilot started anew after 1.0 s", live.err)

    def test_a_pack_and_a_starting_charge(self):
        with Live("--series", "3", "--parallel", "2", "--initial-soc", "0.5", "--vehicle",
                  "mambo-physical") as live:
            answer = live.frame([1000] * 4)
            self.assertAlmostEqual(answer["battery"]["voltage"], 3 * 3.82, delta=1e-6)
            live.end()
        self.assertIn("3 in series, 2 in parallel", live.err)

    def test_says_when_the_battery_is_at_its_cut_off_and_empty(self):
        with Live("--initial-soc", "0.04", rate_Hz=100) as live:
            for _ in range(4000):
                answer = live.frame([1400] * 4)  # on the ground, motors running
            summary = live.end()
        flight = summary["flights"][0]
        self.assertLess(flight["cutoff_s"], flight["empty_s"])
        self.assertIn(f"the battery reached its cut-off: below 3 V for a second at "
                      f"{flight['cutoff_s']:.1f} s", live.err)
        self.assertIn("the battery is empty at", live.err)
        self.assertAlmostEqual(answer["battery"]["current"], 0.0, delta=1e-6)

    def test_wind_is_told_and_pushes(self):
        with Live("--wind", "0,3") as live:
            for _ in range(800):
                answer = live.frame([1700] * 4)
            self.assertEqual(answer["velocity_wind"], [0, 3, 0])
            self.assertGreater(answer["velocity"][1], 0.1)
            live.end()

    def test_ends_with_its_limits(self):
        with Live("--packets", "5") as live:
            for _ in range(5):
                live.frame([1000] * 4)
            self.assertEqual(live.end(how=None)["ended_by"], "limit")
        with Live("--duration", "0.5", rate_Hz=1000) as live:
            for _ in range(500):
                live.frame([1000] * 4)
            self.assertAlmostEqual(live.end(how=None)["simulated_s"], 0.5, delta=1e-9)
        self.assertEqual(live.process.returncode, 0)
        with Live(idle_s=0.2) as live:
            summary = live.end(how=None)
        self.assertEqual(live.process.returncode, 1)
        self.assertEqual(summary["ended_by"], "idle")
        self.assertIn("no autopilot was heard", live.err)

    def test_a_flip_ends_the_flight_with_a_sentence(self):
        with Live("--vehicle", "mambo-physical") as live:
            for _ in range(200):
                live.frame([1800] * 4)
            with self.assertRaises((TimeoutError, AssertionError)):
                live.socket.settimeout(1.0)
                for _ in range(4000):
                    live.frame([2000, 1300, 2000, 1300])
            summary = live.end(how=None)
        self.assertEqual(live.process.returncode, 1)
        self.assertEqual(summary["ended_by"], "over")
        self.assertIn("Euler angles end (gimbal lock)", live.err)

    def test_options_that_cannot_be_are_refused(self):
        taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        taken.bind(("127.0.0.1", 0))
        for arguments, code, said in (
                (["--address", "example.org"], 2, "expected an address such as 127.0.0.1"),
                (["--address", "203.0.113.7"], 2, "cannot listen at 203.0.113.7 port 9002"),
                (["--port", str(taken.getsockname()[1])], 2, "Give another --port or --address"),
                (["--port", "65536"], 2, "--port"),
                (["--initial-soc", "0"], 2, "nothing to fly with"),
                (["--duration", "nan"], 2, "--duration"),
                (["--wind", "1,x"], 2, "--wind"),
                (["--cell", "none.json"], 3, "none.json")):
            ran = subprocess.run([LIPOID, "sitl", "--idle-s", "1", *arguments], capture_output=True,
                                 text=True, check=False)
            self.assertEqual(ran.returncode, code, ran.stderr)
            self.assertIn(said, ran.stderr)
            self.assertEqual(ran.stdout, "")
        taken.close()

    def test_real_time_has_a_margin(self):
        """A hundredfold on an idle machine (docs/flight-code.md); here it may be busy or sanitized."""
        summary = real_time(4000)
        self.assertGreater(summary["simulated_s"] / summary["cpu_s"], 10.0)

    def test_other_machines_are_let_in_only_when_asked(self):
        with Live() as live:
            self.assertEqual(live.address[0], "127.0.0.1")
            live.end()
            self.assertNotIn("anyone", live.err)
        with Live("--address", "0.0.0.0", idle_s=0.2) as live:
            live.end(how=None)
            self.assertIn("anyone who reaches 0.0.0.0 may fly it", live.err)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--lipoid", required=True)
    parser.add_argument("--real-time", action="store_true")
    known, rest = parser.parse_known_args()
    LIPOID = str(pathlib.Path(known.lipoid).resolve())
    if known.real_time:
        found = real_time(40_000)
        flown = found["simulated_s"]
        print(f"{flown:.0f} s at 400 Hz: {flown / found['cpu_s']:.0f} times real time by the processor time of "
              f"lipoid ({1e6 * found['cpu_s'] / found['frames']:.1f} us a frame, network included), "
              f"{flown / found['wall_s']:.0f} times with this client in lock step")
        sys.exit()
    unittest.main(argv=[sys.argv[0], *rest])
