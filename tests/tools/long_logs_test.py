"""Long logs: memory does not grow with their rows, in any command that reads them; what is found is what
every row would say, within its own standard error.

usage: long_logs_test.py LIPOID SCRATCH [--rows 1000000,4000000] [--most-rows 200000]
"""

import argparse
import gzip
import json
import math
import pathlib
import shutil
import subprocess
import sys

# What a run may take more for a log that is four times as long: pieces of text that are read while others
# wait, and what the allocator keeps of them.
GROWTH_MB = 40.0
SYNTHESIZE = ("synthesize", "gifi-600mAh-1", "--with", "r_1=0.03,c_1=1500", "--rates-C", "1,3", "--voltage-noise-V",
              "0.0002", "--seed", "1")


def write_low_rate(path, rows):
    """A discharge over 13 h at constant current with noise on the voltage, made without a random number."""
    step_s = 46800.0 / rows
    current_a = 0.046
    with open(path, "w", encoding="ascii") as file:
        file.write("time_s,current_A,voltage_V\n0,0,4.20000\n")
        for first in range(1, rows, 50000):
            lines = []
            for k in range(first, min(first + 50000, rows)):
                left = 1.0 - k / rows
                noise = 2e-4 * (((k * 7919) % 1009) / 504.5 - 1.0)
                voltage = 3.0 + 0.55 * left + 0.65 * left ** 0.25 + noise
                lines.append(f"{k * step_s:.4f},{current_a},{voltage:.5f}\n")
            file.write("".join(lines))


class Program:
    def __init__(self, lipoid, folder):
        self.lipoid = lipoid
        self.folder = folder

    def run(self, *words):
        """Its peak memory in MB."""
        words = [str(self.lipoid), *map(str, words), "--quiet"]
        before = "import os, resource, sys\npid = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)\n" \
                 "_, status, used = os.wait4(pid, 0)\n" \
                 "print(os.waitstatus_to_exitcode(status), used.ru_maxrss, file=sys.stderr)\n"
        ended = subprocess.run([sys.executable, "-c", before, *words], cwd=self.folder,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
        code, memory_kb = ended.stderr.split()[-2:]
        assert code in ("0", "1"), f"{' '.join(words)}\n{ended.stderr}"
        return float(memory_kb) / 1e3


def check_memory(program, rows, most):
    few, many = rows
    for count in rows:
        write_low_rate(program.folder / f"{count}.csv", count)
        with open(program.folder / f"{count}.csv", "rb") as plain, \
                gzip.open(program.folder / f"{count}.csv.gz", "wb", compresslevel=1) as packed:
            shutil.copyfileobj(plain, packed)
    cell = "gifi-600mAh-1"
    commands = {
        "inspect": lambda n: ("inspect", f"{n}.csv"),
        "inspect of gzip": lambda n: ("inspect", f"{n}.csv.gz"),
        "convert": lambda n: ("convert", f"{n}.csv", "-o", "converted.csv"),
        "validate": lambda n: ("validate", cell, f"{n}.csv"),
        "simulate": lambda n: ("simulate", cell, "--current", f"{n}.csv", "--beyond-cutoff", "-o", "simulated.csv"),
        "identify, staged": lambda n: ("identify", "--low-rate", f"{n}.csv", "--pulses", "logs/pulses.csv",
                                       "--cutoff-V", "3", "--method", "staged", "-o", "staged.json"),
        "identify, joint": lambda n: ("identify", "--low-rate", f"{n}.csv", "--pulses", "logs/pulses.csv",
                                      "--cutoff-V", "3", "--branches", "1", "-o", "joint.json"),
    }
    for name, words in commands.items():
        memory = [program.run(*words(count), "--most-rows", most) for count in rows]
        print(f"{name}: {memory[0]:.0f} MB for {few} rows, {memory[1]:.0f} MB for {many}")
        assert memory[1] < memory[0] + GROWTH_MB, name


def check_parameters(program, most):
    """The cell of thinned logs, pulses among them, against that of every row."""
    program.run(*SYNTHESIZE, "--sampling-s", "0.05", "-o", "fine")
    for method in ("staged", "joint"):
        cells = {}
        for name, limit in (("every", 10 ** 9), ("thinned", most)):
            program.run("identify", "fine/campaign.toml", "--method", method, "--branches", "1", "--most-rows", limit,
                        "-o", f"{name}.json", "--summary", f"{name}.summary.json")
            summary = json.loads((program.folder / f"{name}.summary.json").read_text(encoding="utf-8"))
            cells[name] = {each["name"]: each for each in summary["parameters"]}
        for name, every in cells["every"].items():
            thinned = cells["thinned"][name]
            error = every.get("standard_error")
            if error is None or not math.isfinite(error) or error == 0.0:
                continue
            off = abs(thinned["estimate"] - every["estimate"]) / error
            print(f"{method}: {name} is {every['estimate']:.6g} by every row, {thinned['estimate']:.6g} thinned, "
                  f"{off:.2f} standard errors apart")
            assert off < 1.0, name


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("lipoid", type=pathlib.Path)
    parser.add_argument("scratch", type=pathlib.Path)
    parser.add_argument("--rows", default="1000000,4000000")
    parser.add_argument("--most-rows", type=int, default=200000)
    options = parser.parse_args()
    rows = [int(count) for count in options.rows.split(",")]
    shutil.rmtree(options.scratch, ignore_errors=True)
    options.scratch.mkdir(parents=True)
    program = Program(options.lipoid.resolve(), options.scratch)
    try:
        program.run(*SYNTHESIZE, "--sampling-s", "1", "-o", "logs")
        check_memory(program, rows, options.most_rows)
        check_parameters(program, options.most_rows)
    finally:
        shutil.rmtree(options.scratch, ignore_errors=True)


if __name__ == "__main__":
    main()
