"""Programs that are run and measured: wall time, processor time, peak memory."""

import dataclasses
import os
import pathlib
import shlex
import statistics
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


class BenchError(Exception):
    """What stops a stage, in a sentence for people."""


@dataclasses.dataclass
class Run:
    """One program that has ended. `command` is relative to the project's root."""

    command: str
    exit_code: int
    wall_s: float
    processor_s: float
    peak_memory_MB: float
    out: str
    err: str

    def figures(self):
        return {
            "wall_s": self.wall_s,
            "processor_s": self.processor_s,
            "peak_memory_MB": self.peak_memory_MB,
        }


def shown(command):
    """The command as typed in the root: no path of this machine."""
    text = shlex.join(str(word) for word in command)
    for path, short in ((f"{ROOT}/", ""), (f"{ROOT.parent}/", "../"),
                        ("/usr/bin/python3", "python3")):
        text = text.replace(path, short)
    return text


def run(command, expect_success=True, limit_s=None):
    """Runs the command in the root. Peak memory is that of the process alone, from the kernel.

    After limit_s it is killed; its exit code is then negative.
    """
    words = [str(word) for word in command]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.perf_counter()
        process = subprocess.Popen(words, stdout=out, stderr=err, cwd=ROOT)
        if limit_s is not None:
            end = threading.Timer(limit_s, process.kill)
            end.start()
        _, status, usage = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - start
        if limit_s is not None:
            end.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = [read_back(stream) for stream in (out, err)]
    ended = Run(
        command=shown(words),
        exit_code=process.returncode,
        wall_s=wall_s,
        processor_s=usage.ru_utime + usage.ru_stime,
        peak_memory_MB=usage.ru_maxrss * 1024 / 1e6,
        out=texts[0],
        err=texts[1],
    )
    if expect_success and ended.exit_code != 0:
        raise BenchError(f"{ended.command} ended with {ended.exit_code}:\n{ended.err[-2000:]}")
    return ended


def read_back(stream):
    stream.seek(0)
    return stream.read().decode(errors="replace")


def median(runs, key):
    """The median of a figure over runs, each a dictionary."""
    return statistics.median(figures[key] for figures in runs)


def python_with(*modules):
    """A python3 that has the modules (a virtual environment's may not), or None."""
    for python in ("/usr/bin/python3", "python3", sys.executable):
        probe = [python, "-c", "import " + ", ".join(modules)]
        try:
            if subprocess.run(probe, capture_output=True, check=False).returncode == 0:
                return python
        except FileNotFoundError:
            continue
    return None


def say(text):
    print(f"bench: {text}", file=sys.stderr, flush=True)
