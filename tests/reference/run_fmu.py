#!/usr/bin/env python3
"""Runs an exported FMU by FMPy in every way, for tests/model/export/fmi_test.cc.

    run_fmu.py FMU ROWS FOLDER

ROWS: time_s current_A, whitespace between; the current of a row flowed since the row before. Writes
into FOLDER, one row each:

    cosimulation.txt   voltage_V soc open_circuit_V, by the library in the FMU
    sources.txt        the same by the FMU compiled anew from its own sources
    exchange.txt       time_s voltage_V, model exchange under 2 A per cell in parallel by FMPy's solver
    power.txt          voltage_V drawn_current_A under 5 W a cell, steps of 0.5 s

and prints what must be: no problem found by FMPy's validation, a state that is restored and one that is
serialized continue alike, an input that was set is seen by the next get. Exit code 1 otherwise.
"""

import os
import shutil
import sys

import fmpy
import numpy as np
from fmpy.build import build_platform_binary
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

FAILED = []


def must(holds, what):
    print("yes" if holds else "NO ", what)
    if not holds:
        FAILED.append(what)


class Instance:
    """One co-simulation instance of either version, from initialization on."""

    def __init__(self, fmu, token=None, **parameters):
        self.description = fmpy.read_model_description(fmu)
        self.extracted = os.path.isfile(fmu)
        self.folder = fmpy.extract(fmu) if self.extracted else fmu
        self.three = self.description.fmiVersion.startswith("3")
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        arguments = {
            "guid": token or self.description.guid,
            "unzipDirectory": self.folder,
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
            "instanceName": "cell",
        }
        self.fmu = (FMU3Slave if self.three else FMU2Slave)(**arguments)
        self.fmu.instantiate()
        if not self.three:
            self.fmu.setupExperiment(startTime=0.0)
        for name, value in parameters.items():
            self.set(name, value)
        if self.three:
            self.fmu.enterInitializationMode(startTime=0.0)
        else:
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, name, value):
        reference = [self.references[name]]
        if isinstance(value, int):
            (self.fmu.setInt32 if self.three else self.fmu.setInteger)(reference, [value])
        else:
            (self.fmu.setFloat64 if self.three else self.fmu.setReal)(reference, [value])

    def get(self, *names):
        references = [self.references[name] for name in names]
        return (self.fmu.getFloat64 if self.three else self.fmu.getReal)(references)

    def step(self, now_s, step_s):
        self.fmu.doStep(now_s, step_s)

    def state(self):
        return self.fmu.getFMUState() if self.three else self.fmu.getFMUstate()

    def restore(self, state):
        (self.fmu.setFMUState if self.three else self.fmu.setFMUstate)(state)

    def through_bytes(self, state):
        if self.three:
            return self.fmu.deserializeFMUState(self.fmu.serializeFMUState(state))
        return self.fmu.deSerializeFMUstate(self.fmu.serializeFMUstate(state))

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        if self.extracted:
            shutil.rmtree(self.folder, ignore_errors=True)


def rows_of(fmu, rows, **parameters):
    cell = Instance(fmu, **parameters)
    found = []
    for k, (time_s, current_A) in enumerate(rows):
        cell.set("current_A", float(current_A))
        if k > 0:
            before_s = rows[k - 1][0]
            cell.step(before_s, time_s - before_s)
        found.append(cell.get("voltage_V", "soc", "open_circuit_V"))
    cell.close()
    return np.array(found)


def check_state(fmu, rows):
    cell = Instance(fmu)
    current_A = float(np.max(np.abs(rows[:, 1])))
    cell.set("current_A", current_A)
    for k in range(50):
        cell.step(0.1 * k, 0.1)
    saved = cell.state()
    serialized = cell.through_bytes(saved)
    seen = []
    for state in (None, saved, serialized):
        if state is not None:
            cell.set("current_A", 0.0)
            cell.step(7.0, 3.0)
            cell.restore(state)
        cell.step(5.0, 0.7)
        seen.append(cell.get("voltage_V", "soc", "current_A"))
    must(seen[0] == seen[1] == seen[2], "a restored and a serialized state continue alike")
    before = cell.get("voltage_V")[0]
    cell.set("current_A", 2.0 * current_A)
    must(cell.get("voltage_V")[0] < before - 1e-6, "an input that was set is seen by the next get")
    cell.close()


def check_pack(fmu, rows):
    description = fmpy.read_model_description(fmu)
    start = {v.name: v.start for v in description.modelVariables}
    series, parallel = int(start["series"]), int(start["parallel"])
    one = rows_of(fmu, rows[:400])
    scaled = rows[:400] * np.array([1.0, 3.0])
    pack = rows_of(fmu, scaled, series=2 * series, parallel=3 * parallel)
    must(np.max(np.abs(pack[:, 0] - 2.0 * one[:, 0])) < 1e-9, "a pack of 2s3p times has twice the voltage at 3 i")
    loaded = rows_of(fmu, rows[:400], series_resistance_scale=2.0)
    must(np.min(loaded[:, 0] - one[:, 0]) < -1e-3, "a larger series resistance lowers the voltage")
    half = rows_of(fmu, rows[:2], initial_soc=0.5)
    must(abs(half[0, 1] - 0.5) < 1e-12, "initial_soc is the state of charge at the start")


def check_refusals(fmu):
    try:
        Instance(fmu, token="{00000000-0000-0000-0000-000000000000}").close()
        must(False, "another guid is refused")
    except Exception:  # FMPy's own kinds differ between its versions
        must(True, "another guid is refused")
    folder = fmpy.extract(fmu)
    numbers = os.path.join(folder, "resources", "cell.bin")
    with open(numbers, "rb") as file:
        whole = file.read()
    for what, content in (("cut off", whole[:-8]), ("empty", b""), ("with a number too many", whole + b"\0" * 8),
                          ("with no number in it", whole[:80] + b"\xff" * 8 + whole[88:]),
                          ("with a count beyond its end", whole[:80] + b"\0\0\0\0\0\0\xf0\x41" + whole[88:])):
        with open(numbers, "wb") as file:
            file.write(content)
        try:
            Instance(folder).close()
            must(False, f"a resource {what} is refused")
        except Exception:
            must(True, f"a resource {what} is refused")
    shutil.rmtree(folder)
    cell = Instance(fmu)
    for name, value in (("voltage_V", 4.0), ("initial_soc", 0.3), ("current_A", float("nan"))):
        try:
            cell.set(name, value)
            must(False, f"{name} cannot be set to {value} while it runs")
        except Exception:
            must(True, f"{name} cannot be set to {value} while it runs")
    cell.set("power_W", 1e9)
    try:
        cell.step(0.0, 1.0)
        must(False, "more power than there is is refused")
    except Exception:
        must(True, "more power than there is is refused")
    cell.close()


def main():
    fmu, rows_file, folder = sys.argv[1:]
    rows = np.loadtxt(rows_file)
    problems = validate_fmu(fmu)
    must(not problems, f"FMPy's validation finds nothing {problems}")
    np.savetxt(os.path.join(folder, "cosimulation.txt"), rows_of(fmu, rows), fmt="%.17g")
    check_state(fmu, rows)
    check_pack(fmu, rows)
    check_refusals(fmu)

    description = fmpy.read_model_description(fmu)
    parallel = int({v.name: v.start for v in description.modelVariables}["parallel"])
    result = fmpy.simulate_fmu(fmu, fmi_type="ModelExchange", start_time=0.0, stop_time=60.0,
                               relative_tolerance=1e-9, output_interval=1.0,
                               start_values={"current_A": 2.0 * parallel}, output=["voltage_V", "soc"])
    np.savetxt(os.path.join(folder, "exchange.txt"), np.c_[result["time"], result["voltage_V"]], fmt="%.17g")
    result = fmpy.simulate_fmu(fmu, fmi_type="CoSimulation", stop_time=5.0, step_size=0.1, output=["soc"])
    must(abs(result["soc"][-1] - 1.0) < 1e-12, "FMPy's own simulation of a rest stays full")

    cell = Instance(fmu)
    series = int({v.name: v.start for v in description.modelVariables}["series"])
    cell.set("power_W", 5.0 * series * parallel)
    power = []
    for k in range(120):
        cell.step(0.5 * k, 0.5)
        power.append(cell.get("voltage_V", "drawn_current_A"))
    cell.close()
    np.savetxt(os.path.join(folder, "power.txt"), np.array(power), fmt="%.17g")

    compiled = fmpy.extract(fmu, os.path.abspath(os.path.join(folder, "compiled")))
    shutil.rmtree(os.path.join(compiled, "binaries"))
    os.remove(os.path.join(compiled, "resources", "cell.bin"))  # the sources hold the numbers
    build_platform_binary(compiled, all_warnings=True)
    np.savetxt(os.path.join(folder, "sources.txt"), rows_of(compiled, rows), fmt="%.17g")
    return 1 if FAILED else 0


if __name__ == "__main__":
    sys.exit(main())
