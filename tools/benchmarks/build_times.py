"""What a build costs: from nothing, what the tests add, and what a change of one header brings."""

import os
import shutil

from .machine import describe
from .process import ROOT, run, say

CHANGED = "model/battery/cell.h"
FOLDER = ROOT / "build/times"
GOALS_MINUTES = {"lipoid": 7.0, "tests": 7.0, "changed": 4.0}


def build(*targets):
    """A build as tools/demo and tools/test make it, without the compiler cache."""
    command = ["cmake", "--build", FOLDER, "--parallel", os.cpu_count()]
    ended = run(["env", "CCACHE_DISABLE=1", *command, *(["--target", *targets] if targets else [])])
    return {"command": ended.command, "wall_s": ended.wall_s, "processor_s": ended.processor_s}


def measure():
    """The three figures, in a folder of their own that is made anew."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    configure = run(["cmake", "--preset", "dev", "-B", FOLDER, "--log-level=WARNING"])
    machine = describe(FOLDER)
    result = {"configure": configure.command, "changed_file": CHANGED,
              **{key: machine[key] for key in ("processor", "cores", "compiler", "commit")}}
    say("building lipoid from nothing")
    result["lipoid"] = build("lipoid")
    say("building the tests")
    result["tests"] = build()
    say(f"building what includes {CHANGED}")
    header = ROOT / CHANGED
    before = header.stat()
    try:
        os.utime(header)
        result["changed"] = build()
    finally:
        os.utime(header, ns=(before.st_atime_ns, before.st_mtime_ns))
    result["load_average_after"] = round(os.getloadavg()[0], 2)
    shutil.rmtree(FOLDER, ignore_errors=True)
    return result


def rows(result):
    """(what, goal, found) of each figure, in minutes."""
    names = {
        "lipoid": "the program, from nothing (`tools/demo`)",
        "tests": "the tests and benchmarks after it (`tools/test`)",
        "changed": f"all again after a change of `{result['changed_file']}`",
    }
    for key, what in names.items():
        yield (what, GOALS_MINUTES[key], result[key]["processor_s"] / 60.0,
               result[key]["wall_s"] / 60.0)
