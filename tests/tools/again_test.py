"""From the run record of a result alone the result is made again, bit for bit.

Each command with a run record runs; what it wrote is put away; its record says which command with which
arguments read which files, and that is run. Files and numbers must be the same, but for the times that it took.

usage: again_test.py LIPOID SCRATCH
"""

import hashlib
import json
import pathlib
import shutil
import subprocess
import sys

# What differs from run to run by its nature: seconds of this machine.
TIMES = {"wall_s", "time_to_target_s"}

COMMANDS = (
    ["identify", "logs/campaign.toml", "--method", "staged", "-o", "new.json", "--residuals", "residuals.csv"],
    ["identify", "logs/campaign.toml", "--seed", "7", "-o", "new.json"],
    ["validate", "cell.json", "logs/pulses.csv", "logs/cc_1C.csv"],
    ["inspect", "logs/pulses.csv", "logs/low_rate.csv"],
    ["compare", "logs/campaign.toml", "--optimizers", "sqp,levenberg-marquardt", "--starts", "3", "--seed", "5"],
    ["study", "branches", "logs/campaign.toml"],
    ["plan", "cell.json", "--pulse-s", "10,30"],
    ["fly", "square", "--cell", "cell.json", "--duration", "5", "--seed", "3", "-o", "flight.csv"],
    ["poles", "altitude"],
    ["design", "altitude"],
)


def run(lipoid, folder, words):
    ended = subprocess.run([lipoid, *words, "--quiet"], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                           text=True, check=False, timeout=120)
    assert ended.returncode in (0, 1), f"{words}: {ended.returncode}: {ended.stderr}"


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(one) for key, one in value.items() if key not in TIMES}
    return [without_times(one) for one in value] if isinstance(value, list) else value


def written(folder):
    """Every file with its bytes; of JSON without the times."""
    files = {}
    for path in sorted(folder.iterdir()):
        if path.is_file() and path.name != "cell.json":
            text = path.read_bytes()
            files[path.name] = without_times(json.loads(text)) if path.suffix == ".json" else text
    return files


def put_away(folder):
    for path in folder.iterdir():
        if path.is_file() and path.name != "cell.json":
            path.unlink()


def check(lipoid, folder, words):
    run(lipoid, folder, [*words, "--summary", "summary.json"])
    first = written(folder)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    put_away(folder)
    record = summary["run"]
    for one in record["inputs"]:
        found = hashlib.sha256((folder / one["file"]).read_bytes()).hexdigest()
        assert found == one["sha256"], f"{words}: another {one['file']}"
    command = summary["command"].split()
    assert command[0] == words[0]
    # From here on nothing is known but the record.
    run(lipoid, folder, [command[0], *[word for word in record["arguments"] if word != "--quiet"]])
    second = written(folder)
    assert first.keys() == second.keys(), f"{words}: {first.keys()} and {second.keys()}"
    for name, content in first.items():
        assert content == second[name], f"{words}: {name} differs"
    put_away(folder)
    print(f"again: {' '.join(words[:2])}: {len(first)} files")


def main():
    lipoid, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    run(lipoid, folder, ["synthesize", "gifi-600mAh-1", "--sampling-s", "5", "--rates-C", "1,2", "--voltage-noise-V",
                         "0.001", "--seed", "2", "-o", "logs"])
    run(lipoid, folder, ["identify", "logs/campaign.toml", "-o", "cell.json"])
    for words in COMMANDS:
        check(lipoid, folder, words)
    shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
