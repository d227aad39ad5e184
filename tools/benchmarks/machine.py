"""Where and with what the figures were made."""

import datetime
import os
import platform
import re
import subprocess

from .process import ROOT, python_with


def output_of(*command):
    ended = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    return ended.stdout.strip() if ended.returncode == 0 else ""


def first_match(path, pattern):
    try:
        with open(path, encoding="utf-8") as lines:
            for line in lines:
                if match := re.match(pattern, line):
                    return match.group(1).strip()
    except OSError:
        pass
    return ""


def versions_of_peers():
    """What pandas and its companions the peers run on."""
    python = python_with("numpy", "scipy", "pandas")
    if python is None:
        return {}
    code = ("import numpy, pandas, platform, scipy; "
            "print(platform.python_version(), numpy.__version__, scipy.__version__, "
            "pandas.__version__)")
    return dict(zip(("python", "numpy", "scipy", "pandas"), output_of(python, "-c", code).split()))


def describe(build):
    """`build` is the folder that lipoid was built in."""
    compiler = first_match(build / "CMakeCache.txt", r"CMAKE_CXX_COMPILER:\w+=(.*)")
    kind = first_match(build / "CMakeCache.txt", r"CMAKE_BUILD_TYPE:\w+=(.*)")
    flags = [first_match(build / "CMakeCache.txt", rf"{name}:\w+=(.*)")
             for name in ("CMAKE_CXX_FLAGS", f"CMAKE_CXX_FLAGS_{(kind or 'Release').upper()}")]
    memory_kB = first_match("/proc/meminfo", r"MemTotal:\s+(\d+) kB")
    return {
        "processor": first_match("/proc/cpuinfo", r"model name\s*:\s*(.*)") or platform.machine(),
        "cores": os.cpu_count(),
        "memory_GB": round(int(memory_kB or 0) * 1024 / 1e9, 1),
        "system": platform.system(),
        "kernel": platform.release(),
        "compiler": output_of(compiler, "--version").splitlines()[0] if compiler else "",
        "flags": " ".join(flag for flag in flags if flag),
        "commit": output_of("git", "rev-parse", "--short=12", "HEAD"),
        "modified": bool(output_of("git", "status", "--porcelain", "--untracked-files=no")),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "load_average_before": round(os.getloadavg()[0], 2),
        "peers": versions_of_peers(),
    }
