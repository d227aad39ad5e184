"""The program under test: a command in, its summary and its flight log out."""

import csv
import json
import pathlib
import shlex

from benchmarks.process import BenchError, run

SHOWN_SCRATCH = "build/reproduce/"


def xis(first=0.8, last=1.0, step=0.01):
    """Voltage ratios from `first` to `last`, both of them, rounded as typed."""
    return [round(first + k * step, 6) for k in range(round((last - first) / step) + 1)]


class Lipoid:
    """Runs commands. `scratch` holds what they write."""

    def __init__(self, program, scratch):
        self.program = pathlib.Path(program).resolve()
        self.scratch = pathlib.Path(scratch).resolve()
        self.scratch.mkdir(parents=True, exist_ok=True)

    def shown(self, *words):
        """As one would type it."""
        text = shlex.join(["lipoid", *map(str, words)])
        return text.replace(f"{self.scratch}/", SHOWN_SCRATCH)

    def run(self, *words, expected=(0,)):
        """Other exit codes than the expected ones stop everything."""
        ended = run([self.program, *words, "--quiet"], expect_success=False)
        if ended.exit_code not in expected:
            raise BenchError(f"{self.shown(*words)} ended with {ended.exit_code}:\n"
                             f"{ended.err[-2000:]}")

    def summary(self, *words, expected=(0,)):
        """The JSON of --summary."""
        file = self.scratch / "summary.json"
        file.unlink(missing_ok=True)
        self.run(*words, "--summary", file, expected=expected)
        return json.loads(file.read_text(encoding="utf-8"))

    def log(self, *words, step_s):
        """(summary, columns) of a flight; the columns of its log by name, as numbers."""
        file = self.scratch / "flight.csv"
        summary = self.summary(*words, "--log-step-s", step_s, "-o", file)
        with open(file, encoding="utf-8", newline="") as lines:
            rows = csv.reader(lines)
            header = next(rows)
            columns = list(zip(*([float(cell or "nan") for cell in row] for row in rows)))
        return summary, dict(zip(header, columns))


def between(times, first, last):
    """The indices of the rows in a span of time, both ends included."""
    return [k for k, time in enumerate(times) if first - 1e-9 <= time <= last + 1e-9]
