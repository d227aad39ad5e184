"""What the docs show as output is what the program prints.

Commands stand indented in README.md and docs/*.md, and below them what they print, in part. Commands that show
something are run, in the tutorial all of them, one after the other; each line that is shown must come, in order.
Words must be the same, numbers within a unit and a half of the last digit that is shown: other processors round
otherwise. Times of this machine may be anything.

usage: examples_test.py LIPOID SCRATCH
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
NOISE = "--voltage-noise-V 0.001"
# What stands before the first example, with the words of the docs.
BEFORE = {
    "README.md": [f"lipoid synthesize gifi-600mAh-1 --with r_1=0.03,c_1=1500 {NOISE} --seed 1 --sampling-s 1 -o lab",
                  "rm lab/campaign.toml lab/truth.json"],
    "docs/verdicts.md": ["lipoid synthesize gifi-600mAh-1 --with r_1=0.03,c_1=1000 --voltage-noise-V 0.0002"
                         " --sampling-s 1 --seed 1 -o logs"],
}
WHOLE = ("docs/tutorial.md",)
# Minutes, and nothing of it is shown.
LONG = ("lipoid compare ",)
# No command, but the place of a name that the reader has.
PLACE = re.compile(r"\b(LOOP|LAW|XI|FLIGHT|REFERENCE|VEHICLE|CELL|OMEGA|SEED|cell1)\b")
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


def blocks(text):
    """The indented blocks; an empty line stands between two parts of one."""
    block = []
    for line in [*text.split("\n"), "end"]:
        if line.startswith("    ") or (block and not line):
            block.append(line[4:])
        elif block:
            yield block
            block = []


def examples(text):
    """Commands that stand together, with what is shown below them: after an empty line, or after `$ command`."""
    for block in blocks(text):
        commands, shown, prompt, below = [], [], False, False
        lines = iter(block)
        for line in lines:
            if re.match(r"(\$ )?lipoid \S", line):
                if shown:
                    yield commands, shown
                    commands, shown = [], []
                prompt, below = line.startswith("$ "), False
                command = line.removeprefix("$ ")
                while command.endswith("\\"):
                    command = command[:-1] + next(lines).strip()
                commands.append(command)
            elif not line.strip():
                below = True
            elif commands and (prompt or below):
                shown.append(line)
            else:  # the command of another program, or words
                commands = []
        if commands:
            yield commands, shown


def same(shown, printed):
    """Whether a printed line is the line that is shown."""
    shown, printed = shown.split(), printed.split()
    if len(shown) != len(printed):
        return False
    for wanted, found in zip(shown, printed, strict=True):
        if wanted == found:
            continue
        numbers = NUMBER.findall(wanted), NUMBER.findall(found)
        if not numbers[0] or NUMBER.sub("#", wanted) != NUMBER.sub("#", found):
            return False
        for one, other in zip(*numbers, strict=True):
            mantissa, _, exponent = one.partition("e")
            digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
            if abs(float(one.replace(",", "")) - float(other.replace(",", ""))) > 1.5 * digit:
                return False
    return True


def without_times(lines):
    """The lines without the columns of a table that are headed `time / s`."""
    column, kept = None, []
    for line in lines:
        cells = re.split(r"\s{2,}", line.strip())
        if "time / s" in cells:
            column = cells.index("time / s")
        elif column is not None and len(cells) > column and NUMBER.fullmatch(cells[column]):
            cells[column] = "time"
        kept.append(" ".join(cells))
    return kept


def run(command, folder, lipoid):
    """What the command prints on a terminal: results and messages, in the order in which they come."""
    environment = dict(os.environ, PATH=f"{lipoid.parent}{os.pathsep}{os.environ['PATH']}")
    ended = subprocess.run(command.partition("  #")[0], shell=True, cwd=folder, env=environment, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, check=False,
                           timeout=300)
    assert ended.returncode in (0, 1), f"{command}: exit code {ended.returncode}: {ended.stdout}"
    return ended.stdout


def check(name, lipoid, scratch):
    """The number of lines that were compared, and what is shown but not printed."""
    folder = scratch / pathlib.Path(name).stem
    folder.mkdir(parents=True)
    (folder / "fixtures").symlink_to(ROOT / "fixtures")
    for command in BEFORE.get(name, []):
        run(command, folder, lipoid)
    compared, missing = 0, []
    for commands, shown in examples((ROOT / name).read_text(encoding="utf-8")):
        if any(PLACE.search(one) or one.startswith(LONG) for one in commands):
            assert not shown, f"{name}: {commands}: what is shown below it is not checked"
            continue
        if not shown and name not in WHOLE:
            continue
        printed = without_times("".join(run(one, folder, lipoid) for one in commands).split("\n"))
        for line in without_times(shown):
            if line == "...":
                continue
            compared += 1
            at = next((k for k, one in enumerate(printed) if same(line, one)), None)
            if at is None:
                missing.append(f"{name}: {commands[-1]}: not printed, or not in this order: {line}")
            else:
                printed = printed[at + 1:]
    return compared, missing


def main():
    lipoid, scratch = (pathlib.Path(one).resolve() for one in sys.argv[1:])
    shutil.rmtree(scratch, ignore_errors=True)
    names = ["README.md", *sorted(str(one.relative_to(ROOT)) for one in ROOT.glob("docs/*.md"))]
    results = {name: check(name, lipoid, scratch) for name in names}
    for name, (compared, _) in results.items():
        if compared:
            print(f"{name}: {compared} lines")
    missing = [line for _, lines in results.values() for line in lines]
    print("\n".join(missing))
    # The test itself: a digit that is wrong and a line that is gone are seen, the time of a machine is not.
    assert same("a  1.25 mV", "a 1.26 mV")
    assert not same("a  1.25 mV", "a 1.27 mV")
    assert not same("a 1.25 mV", "b 1.25 mV")
    assert without_times(["n  time / s  x", "1  0.5  2"])[1] == "1 time 2"
    assert results["docs/tutorial.md"][0] > 50
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
