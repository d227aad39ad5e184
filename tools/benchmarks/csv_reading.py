"""Reading the low-rate log: lipoid's ReadLog against pandas.read_csv, in turn, on the same file."""

import json

from . import google
from .process import median, python_with, run, say

PANDAS = """
import json, sys, time, pandas
start = time.perf_counter()
rows = len(pandas.read_csv(sys.argv[1]))
print(json.dumps({"wall_s": time.perf_counter() - start, "rows": rows}))
"""


def measure(settings):
    file = settings.campaign / "low_rate.csv"
    python = python_with("pandas")
    ours = []
    theirs = []
    for k in range(settings.runs):
        say(f"CSV reading {k + 1} of {settings.runs}")
        command, rows = google.measure(settings, "ReadWholeLog", f"--csv-file={file}")
        ours.append({"wall_s": rows[0]["real_s"], "processor_s": rows[0]["processor_s"]})
        if python is not None:
            theirs.append(json.loads(run([python, "-c", PANDAS, file]).out))
    result = {
        "file": file.name,
        "bytes": file.stat().st_size,
        "lipoid": {"command": command, "runs": ours, "median": {"wall_s": median(ours, "wall_s")}},
        "pandas_skipped": None if python else "no python3 with pandas (Debian: python3-pandas)",
    }
    if theirs:
        result["pandas"] = {"command": f"pandas.read_csv('{file.name}')", "runs": theirs,
                            "median": {"wall_s": median(theirs, "wall_s")}}
    return result
