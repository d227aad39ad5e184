"""lipoid_bench, the Google Benchmark program, as dictionaries."""

import json

from .process import BenchError, run


def measure(settings, pattern, *options):
    """(command, rows): name, real time in seconds, counters; of repetitions their median."""
    ended = run([settings.lipoid_bench, f"--benchmark_filter={pattern}", "--benchmark_format=json",
                 *options])
    rows = []
    for row in json.loads(ended.out)["benchmarks"]:
        if row.get("error_occurred"):
            raise BenchError(f"{row['name']}: {row['error_message']}")
        if row.get("run_type") == "aggregate" and row["aggregate_name"] != "median":
            continue
        unit = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[row["time_unit"]]
        rows.append({**row, "real_s": row["real_time"] * unit,
                     "processor_s": row["cpu_time"] * unit})
    return ended.command, rows


def counter(rows, name_starts, key):
    """The counter of the first row whose name starts so."""
    for row in rows:
        if row["name"].startswith(name_starts):
            return row[key]
    raise BenchError(f"lipoid_bench has no benchmark {name_starts}")
