"""What the machine could do at best, and how far from it each stage is.

A file cannot be used faster than it is read from the page cache; a sweep cannot be faster than its
floating point operations. The operations are counted for the plain recurrences, row by row: what a
cleverer evaluation leaves out counts as speed.
"""

import time

from . import google
from .process import say

BLOCK = 1 << 20


def measure(settings):
    say("limits of the machine")
    command, rows = google.measure(settings, "Limit")
    return {
        "command": command,
        "page_cache_bytes_per_s": page_cache_speed(sorted(settings.campaign.glob("*.csv"))),
        "memory_bytes_per_s": google.counter(rows, "LimitReadMemory/real_time", "bytes_per_second"),
        "memory_bytes_per_s_all_cores": google.counter(
            rows, "LimitReadMemory/real_time/threads", "bytes_per_second"),
        "flops_per_s": google.counter(rows, "LimitMultiplyAdd/real_time", "flops_per_s"),
        "flops_per_s_all_cores": google.counter(
            rows, "LimitMultiplyAdd/real_time/threads", "flops_per_s"),
        "flops_per_row": flops_per_row(terms=10, branches=1),
    }


def page_cache_speed(files):
    """Bytes per second of reading the files once more, the best of three."""
    block = bytearray(BLOCK)
    best = 0.0
    for _ in range(3):
        start = time.perf_counter()
        total = 0
        for file in files:
            with open(file, "rb", buffering=0) as stream:
                while count := stream.readinto(block):
                    total += count
        best = max(best, total / (time.perf_counter() - start))
    return best


def flops_per_row(terms, branches):
    """One row of (4.61) with its exact Jacobian and J'J, without the interval's exponentials."""
    state = 3 * (terms + branches)  # x+ = p x + g i
    slope = 5 * (terms + branches)  # x'+ = p x' + p' x + g' i
    sums = 2 * terms + 4 * branches  # sigma and its slope; r_j x_j and its slopes
    voltage = 12  # charge, soc, v_oc(A) and its slope, r_s i, the residual
    columns = 3 + 2 * branches  # beta, r_s, r_j, tau_j, the residual
    normal_equations = columns * (columns + 1)  # a multiplication and an addition per entry
    return state + slope + sums + voltage + normal_equations
