"""The process that identifies: one campaign after the other, each a line in and a line out.

It is a process of its own, so that a campaign which crashes it, or takes too long or too much
memory, costs that campaign alone (lipoid.fleet.worker). It ends when its input ends.
"""

from __future__ import annotations

import hashlib
import json
import os
import queue
import resource
import sys
import threading
import time
from typing import Any

import lipoid
from lipoid._many import identify_or_error
from lipoid.fleet.results import Row

# What differs from run to run, or says by which program and from where: no part of the result.
NOT_RESULT = {"wall_s", "run", "campaign"}


def _text(value: Any) -> str:
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def without(value: Any, names: set[str]) -> Any:
    """Return a value of JSON without the keys of these names, at any depth."""
    if isinstance(value, dict):
        return {key: without(one, names) for key, one in value.items() if key not in names}
    if isinstance(value, list) and value and isinstance(value[0], (dict, list)):
        return [without(one, names) for one in value]
    return value


def _inputs(run: dict[str, Any], began_ns: int) -> list[dict[str, Any]]:
    """Every file that was read, with what tells soon whether it is still the same.

    One that changed while it was read has null for both: its campaign is done again next time.
    """
    inputs = []
    for one in run["inputs"]:
        status = os.stat(one["file"])
        changed = began_ns <= status.st_ctime_ns <= time.time_ns()
        known = {
            "bytes": None if changed else status.st_size,
            "modified_ns": None if changed else status.st_mtime_ns,
        }
        inputs.append({"file": one["file"], "sha256": one["sha256"], **known})
    return inputs


def _found(result: lipoid.Identification, began_ns: int) -> Row:
    summary = dict(result.summary)
    cell = summary.pop("cell")
    verdict = summary.get("verdict") or {}
    parameters = []
    for one in summary["parameters"]:
        low, high = one.get("interval_95") or (None, None)
        known = (one["name"], one["unit"], one["estimate"], one["standard_error"])
        parameters.append((*known, low, high, one["verdict"]))
    essence = _text(without([cell, summary], NOT_RESULT))
    return {
        "status": "done",
        "converged": result.converged,
        "usable": result.usable,
        "grade": verdict.get("grade"),
        "mean_error_percent": verdict.get("mean_error_percent"),
        "rmse_V": verdict.get("rmse_V"),
        "cell": _text(cell),
        "summary": _text(summary),
        "inputs": _text(_inputs(cell["run"], began_ns)),
        "version": cell["run"]["version"],
        "commit": cell["run"]["commit"],
        "result_sha256": hashlib.sha256(essence.encode()).hexdigest(),
        "parameters": parameters,
    }


FAILURES: tuple[tuple[type[BaseException], str], ...] = (
    (lipoid.LoadError, "bad-input"),
    (lipoid.OptionError, "bad-option"),
    (MemoryError, "memory-limit"),
)


def _failed(error: BaseException) -> Row:
    kind = next((name for of, name in FAILURES if isinstance(error, of)), "internal-error")
    reason = str(error) or type(error).__name__
    if kind == "memory-limit":
        reason = "needed more memory than the limit allows"
    return {"status": "failed", "failure": kind, "reason": reason}


def _reset_peak() -> None:
    try:
        with open("/proc/self/clear_refs", "w") as file:
            file.write("5")
    except OSError:
        pass  # then the peak is that of all campaigns so far


def _peak_bytes() -> int | None:
    try:
        with open("/proc/self/status") as file:
            for line in file:
                if line.startswith("VmHWM:"):
                    return 1024 * int(line.split()[1])
    except OSError:
        pass
    return None


def identify_one(campaign: str, options: dict[str, Any]) -> Row:
    """Return the row of one campaign, whatever becomes of it."""
    _reset_peak()
    began, began_ns = time.perf_counter(), time.time_ns()
    cpu_began = time.process_time()
    result = identify_or_error(campaign, {"threads": 1, **options})
    try:
        if isinstance(result, lipoid.Identification):
            row = _found(result, began_ns)
        else:
            row = _failed(result)
    except Exception as error:  # a file that is gone by now, a number that JSON cannot hold
        row = _failed(error)
    row["wall_s"] = time.perf_counter() - began
    row["cpu_s"] = time.process_time() - cpu_began
    row["peak_memory_bytes"] = _peak_bytes()
    return row


def main() -> None:
    """Serve the process that started this one, until it is gone."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print goes elsewhere
    memory_bytes = int(sys.argv[1])
    if memory_bytes > 0:
        resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    asked: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def listen() -> None:
        for line in sys.stdin.buffer:
            asked.put(line)
        os._exit(0)  # nobody waits for the answer

    threading.Thread(target=listen, daemon=True).start()
    version = {"version": lipoid.__version__, "commit": lipoid._core.commit}
    answers.write(_text(version).encode() + b"\n")
    answers.flush()
    while True:
        one = json.loads(asked.get())
        row = identify_one(one["campaign"], one["options"])
        answers.write(_text(version | row).encode() + b"\n")
        answers.flush()


if __name__ == "__main__":
    main()
