"""Fleets: one row for each campaign whatever happens, the same bits whatever happened meanwhile."""

from __future__ import annotations

import contextlib
import html
import importlib.util
import itertools
import json
import math
import os
import shlex
import signal
import socket
import sqlite3
import subprocess
import sys
import threading
import time
import types
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import jsonschema
import numpy as np
import pandas as pd
import pytest

import lipoid
from conftest import ROOT, Lipoid
from lipoid.fleet import spread, worker
from lipoid.fleet.command import main
from lipoid.fleet.driver import Progress, Run, Signals, duration, still_the_same
from lipoid.fleet.errors import Stopped
from lipoid.fleet.results import Results
from lipoid.fleet.spread import Quantity
from lipoid.fleet.worker import Settings, identify_batch

ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join(one for one in sys.path if one)}
STAGED = ("--method", "staged", "--quiet")
CELLS = 8
SCHEMA = json.loads((ROOT / "docs/schemas/lipoid-fleet.summary.schema.json").read_text())


@pytest.fixture(scope="session")
def cells(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Small campaigns of cells that differ, in two batches."""
    folder = tmp_path_factory.mktemp("fleet")
    for k in range(CELLS):
        lipoid.synthesize(
            "gifi-600mAh-1",
            folder / f"batch-{k % 2}" / f"cell-{k}",
            parameters={"r_s": 0.12 + 0.002 * k, "r_1": 0.03, "c_1": 1500.0},
            seed=k,
            sampling_s=10.0,
            voltage_noise_V=0.001,
            rates_C="1,2",
        )
    return folder


def told_in(summary: Path) -> dict[str, Any]:
    """Return a summary, which is as docs/schemas says."""
    told: dict[str, Any] = json.loads(summary.read_text())
    jsonschema.validate(told, SCHEMA)
    return told


def rows(results: Path) -> dict[str, sqlite3.Row]:
    with sqlite3.connect(results) as database:
        database.row_factory = sqlite3.Row
        found = database.execute("SELECT * FROM campaigns").fetchall()
    assert len({row["campaign"] for row in found}) == len(found)
    return {row["campaign"]: row for row in found}


def essence(results: Path) -> list[tuple[Any, ...]]:
    """Return what may not depend on what happened meanwhile."""
    with sqlite3.connect(results) as database:
        return database.execute(
            "SELECT campaign, status, failure, reason, converged, usable, grade, rmse_V, options, "
            "result_sha256, name, unit, estimate, standard_error, low_95, high_95, verdict "
            "FROM campaigns LEFT JOIN parameters USING (id) ORDER BY campaign, name"
        ).fetchall()


def without(value: Any, names: set[str]) -> Any:
    if isinstance(value, dict):
        return {key: without(one, names) for key, one in value.items() if key not in names}
    return [without(one, names) for one in value] if isinstance(value, list) else value


@pytest.fixture(scope="session")
def undisturbed(cells: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    results = tmp_path_factory.mktemp("undisturbed") / "results.sqlite"
    assert main([str(cells), "-o", str(results), *STAGED]) == 0
    return results


def test_each_row_is_what_the_program_finds(
    cells: Path, undisturbed: Path, program: Lipoid, tmp_path: Path
) -> None:
    found = rows(undisturbed)
    assert len(found) == CELLS
    campaign = cells / "batch-1" / "cell-3" / "campaign.toml"
    row = found[str(campaign)]
    theirs = program("identify", campaign, "--method", "staged", "-o", "cell.json", folder=tmp_path)
    cell = json.loads((tmp_path / "cell.json").read_text())
    leave = {"wall_s", "run"}
    assert without(json.loads(row["cell"]), leave) == without(cell, leave)
    summary = json.loads(row["summary"])
    assert summary["parameters"] == theirs["parameters"]
    assert row["rmse_V"] == theirs["verdict"]["rmse_V"]
    inputs = {one["file"]: one["sha256"] for one in json.loads(row["inputs"])}
    assert set(inputs.values()) == {one["sha256"] for one in cell["run"]["inputs"]}
    assert (row["status"], row["attempts"], row["converged"]) == ("done", 1, 1)
    assert row["version"] == lipoid.__version__
    assert row["cpu_s"] > 0.0 and 5e7 < row["peak_memory_bytes"] < 1e9
    with sqlite3.connect(undisturbed) as database:
        (estimate,) = database.execute(
            "SELECT estimate FROM parameters JOIN campaigns USING (id) "
            "WHERE campaign = ? AND name = 'r_s'",
            (str(campaign),),
        ).fetchone()
    assert estimate == {one["name"]: one["estimate"] for one in theirs["parameters"]}["r_s"]


def test_a_full_disk_is_said_and_what_was_written_stays(
    cells: Path, undisturbed: Path, tmp_path: Path
) -> None:
    import resource

    results = tmp_path / "results.sqlite"
    limit_bytes = 250_000  # of a file; room for some of the rows

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))

    words = [str(cells), "-o", str(results), *STAGED]
    ran = subprocess.run(
        [sys.executable, "-m", "lipoid.fleet", *words],
        env=ENVIRONMENT,
        preexec_fn=limit,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert ran.returncode == 2, ran.stderr
    assert f"{results}: cannot be written: " in ran.stderr
    kept = rows(results)
    assert 0 < len(kept) < CELLS
    assert main(words) == 0
    assert essence(results) == essence(undisturbed)


def test_a_row_is_made_again_from_its_run_record_alone(undisturbed: Path) -> None:
    import hashlib

    from lipoid.fleet.runner import identify_one

    row = next(iter(rows(undisturbed).values()))
    record = json.loads(row["cell"])["run"]
    for one in record["inputs"]:
        assert hashlib.sha256(Path(one["file"]).read_bytes()).hexdigest() == one["sha256"]
    options = dict(record["options"])
    options["open_circuit_voltage_fit"] = options.pop("open_circuit_voltage")
    options |= options.pop("given")
    again = identify_one(record["inputs"][0]["file"], {"seed": record["seed"], **options})
    assert again["result_sha256"] == row["result_sha256"]


def test_what_is_done_is_kept(cells: Path, tmp_path: Path) -> None:
    import shutil

    own = tmp_path / "cells"
    shutil.copytree(cells / "batch-0", own)
    results, summary = tmp_path / "results.sqlite", tmp_path / "summary.json"
    command = [str(own), "-o", str(results), "--summary", str(summary), *STAGED]

    def run(*more: str) -> tuple[int, int]:
        assert main([*command, *more]) == 0
        told = told_in(summary)
        return told["done"], told["kept"]

    assert run() == (4, 0)
    first = rows(results)
    assert run() == (0, 4)
    os.utime(own / "cell-0" / "pulses.csv")  # another time, the same bytes
    assert run() == (0, 4)
    log = own / "cell-2" / "pulses.csv"
    lines = log.read_text().splitlines(keepends=True)
    log.write_text("".join(lines[:-1]))
    assert run() == (1, 3)
    assert main([*command, "--branches", "2"]) == 2  # would lose what is there
    assert {k: row["finished"] for k, row in rows(results).items() if "cell-2" not in k} == {
        k: row["finished"] for k, row in first.items() if "cell-2" not in k
    }
    assert run("--branches", "2", "--replace") == (4, 0)
    # A log that is out of reach, as on a server that is away, says nothing against its result.
    log.rename(tmp_path / "away.csv")
    done = {k: (row["status"], row["finished"]) for k, row in rows(results).items()}
    assert main([*command, "--branches", "2"]) == 1
    assert told_in(summary)["failed"] == 1
    assert {k: (row["status"], row["finished"]) for k, row in rows(results).items()} == done
    (tmp_path / "away.csv").rename(log)
    assert run("--branches", "2") == (0, 4)


def test_a_stopped_replacement_goes_on_only_by_its_name(
    cells: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results, table = tmp_path / "results.sqlite", tmp_path / "table.csv"
    first, second = (str(cells / "batch-0" / f"cell-{k}" / "campaign.toml") for k in (0, 2))
    table.write_text(f"campaign,batch\n{first},a\n{second},b\n")
    assert main([str(table), "-o", str(results), *STAGED]) == 0
    with sqlite3.connect(results) as database:  # as a run with --replace leaves it that is stopped
        other = database.execute("SELECT value FROM fleet WHERE name = 'options'").fetchone()[0]
        newer = json.dumps({**json.loads(other), "branches": 2}, sort_keys=True)
        database.execute("UPDATE fleet SET value = ? WHERE name = 'options'", (newer,))
        database.execute("UPDATE campaigns SET options = ? WHERE campaign = ?", (newer, first))
    database.close()
    again = [first, second, "-o", str(results), *STAGED, "--branches", "2"]
    assert main(again) == 2
    assert (
        f"of the options {other}, too, which a run with --replace has left ({second})"
        in capsys.readouterr().err
    )
    assert rows(results)[second]["options"] == other
    assert main([*again, "--replace"]) == 0
    batches = {k: json.loads(row["metadata"])["batch"] for k, row in rows(results).items()}
    assert batches == {first: "a", second: "b"}  # which no file says


def test_what_is_kept_counts_in_the_exit_code(
    cells: Path, undisturbed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second night says what the first one said."""
    import shutil

    results, told = tmp_path / "r.sqlite", tmp_path / "summary.json"
    shutil.copy(undisturbed, results)
    words = [str(cells), "-o", str(results), "--summary", str(told), *STAGED[:2]]
    assert main(words) == 0
    assert told_in(told)["kept_unusable"] == 0
    assert (told_in(told)["command"], told_in(told)["exit_code"]) == ("lipoid-fleet", 0)
    assert capsys.readouterr().err.endswith("; nothing was left to do\n")
    with sqlite3.connect(results) as database:
        database.execute("UPDATE campaigns SET usable = 0 WHERE id = 1")
    assert main(words) == 1
    assert (told_in(told)["kept"], told_in(told)["kept_unusable"]) == (CELLS, 1)
    assert told_in(told)["exit_code"] == 1
    assert f"{CELLS} kept from before (1 not usable)" in capsys.readouterr().err


def test_a_changed_reference_is_another_option(
    cells: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = str(cells / "batch-0" / "cell-0")
    reference = tmp_path / "reference.json"
    cell = lipoid.Cell.read("gifi-600mAh-1").to_dict()
    reference.write_text(json.dumps(cell))
    told = tmp_path / "summary.json"
    words = ["-o", str(tmp_path / "r.sqlite"), "--summary", str(told)]
    words = [one, *words, "--quiet", "--reference", str(reference)]
    assert main(words) in (0, 1)
    assert main(words) in (0, 1)
    assert told_in(told)["kept"] == 1
    cell["open_circuit_voltage"]["voltage_V"][-1] = 4.25
    reference.write_text(json.dumps(cell))
    assert main(words) == 2
    assert "--replace to do every campaign again" in capsys.readouterr().err
    # The summary is not that of the run before.
    assert told_in(told)["exit_code"] == 2
    assert "--replace" in told_in(told)["error"]["message"]
    assert main([*words, "--replace"]) in (0, 1)
    assert told_in(told)["kept"] == 0
    # A shipped cell goes by its name, as with lipoid identify.
    words[2] = str(tmp_path / "shipped.sqlite")
    assert main([*words[:-1], "gifi-600mAh-1"]) in (0, 1)
    (row,) = rows(tmp_path / "shipped.sqlite").values()
    assert row["status"] == "done", row["reason"]


@pytest.mark.parametrize("nobody", ["2>&-", "2>/dev/full", ">&- 2>&- <&-"])
def test_nobody_need_read_the_messages(nobody: str, cells: Path, tmp_path: Path) -> None:
    results, summary = tmp_path / "r.sqlite", tmp_path / "summary.json"
    words = [sys.executable, "-m", "lipoid.fleet", str(cells / "batch-0" / "cell-0"), "-o"]
    words += [str(results), "--summary", str(summary), *STAGED[:2]]
    run = subprocess.run(["sh", "-c", f"{shlex.join(words)} {nobody}"], check=False)
    assert (run.returncode, told_in(summary)["exit_code"]) == (0, 0)
    assert not Path(f"{results}-wal").exists()
    assert len(rows(results)) == 1


def test_a_lock_is_waited_for(cells: Path, tmp_path: Path) -> None:
    one, results = str(cells / "batch-0" / "cell-0"), tmp_path / "r.sqlite"
    assert main([one, "-o", str(results), *STAGED]) == 0
    with sqlite3.connect(results) as database:
        database.execute("DELETE FROM campaigns")
    locked = sqlite3.connect(results, isolation_level=None, check_same_thread=False)
    locked.execute("BEGIN IMMEDIATE")
    release = threading.Timer(7.0, lambda: locked.execute("ROLLBACK"))  # SQLite itself waits for 5
    release.start()
    assert main([one, "-o", str(results), *STAGED]) == 0
    release.join()
    locked.close()
    assert len(rows(results)) == 1


def test_files_that_are_gone_are_not_the_same(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("a")
    status = file.stat()
    known = {"bytes": 1, "modified_ns": status.st_mtime_ns, "sha256": "?", "file": str(file)}
    assert still_the_same([known]) == [known]
    file.unlink()
    assert still_the_same([known]) is None


def test_a_file_that_changes_while_it_is_read_is_not_known(tmp_path: Path) -> None:
    from lipoid.fleet.runner import _inputs

    file = tmp_path / "a.csv"
    file.write_text("a")
    read = {"inputs": [{"file": str(file), "sha256": "?"}]}
    time.sleep(0.05)  # the clock of the file system ticks every 4 to 10 ms
    (settled,) = _inputs(read, time.time_ns())
    assert settled["bytes"] == 1 and still_the_same([settled]) == [settled]
    began_ns = time.time_ns()
    time.sleep(0.05)
    file.write_text("b")
    os.utime(file, (0, 0))  # as a copy that keeps its times
    (changed,) = _inputs(read, began_ns)
    assert changed["modified_ns"] is None and still_the_same([changed]) is None


def test_what_is_wrong_with_a_campaign_is_its_row(cells: Path, tmp_path: Path) -> None:
    good = cells / "batch-0" / "cell-0" / "campaign.toml"
    bad = tmp_path / "bad.toml"
    bad.write_text("[cell]\ncapacity_Ah = 'much'\n")
    lacks = tmp_path / "lacks.toml"
    lacks.write_text('[[log]]\nkind = "pulses"\nfile = "gone.csv"\n')
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "folder.toml" / "campaign.toml").symlink_to("campaign.toml")  # to itself
    table = tmp_path / "table.csv"
    table.write_text(
        f"campaign,batch,age\n{good},A,1\nbad.toml,<b>,2\nlacks.toml,,3\nnone.toml,B,\n"
        "folder.toml,B,5\n"
    )
    results, summary = tmp_path / "results.sqlite", tmp_path / "summary.json"
    assert main([str(table), "-o", str(results), "--summary", str(summary), *STAGED]) == 1
    told = told_in(summary)
    assert (told["done"], told["failures"]) == (1, {"bad-input": told["failed"]})
    found = {Path(key).name: row for key, row in rows(results).items() if "folder" not in key}
    assert found["campaign.toml"]["status"] == "done"
    assert json.loads(found["campaign.toml"]["metadata"]) == {"batch": "A", "age": 1}
    for name in ("bad.toml", "lacks.toml", "none.toml"):
        assert (found[name]["status"], found[name]["failure"]) == ("failed", "bad-input")
    assert f"{bad}:2:15: error: capacity_Ah: expected" in found["bad.toml"]["reason"]
    assert "gone.csv" in found["lacks.toml"]["reason"]
    assert len(rows(results)) == 5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            b"",
            "table.csv:1:1: error: expected a column campaign with paths, found the columns none",
        ),
        (b"file,batch\na,b\n", "found the columns file, batch"),
        (b"campaign,a,a\nx,1,2\n", "table.csv:1:1: error: column a is there more than once"),
        (b"campaign\n", "found a table without rows"),
        (b"campaign,a\nx\n", "table.csv:2:1: error: expected 2 fields, found 1"),
        (b"campaign,a\n ,1\n", "table.csv:2:1: error: expected a path in the column campaign"),
        (b"campaign,a\nx,1\nx,1\n", "table.csv:3:1: error: x was named before, in row 2"),
        # Before Python 3.11 the csv module itself refuses a NUL.
        (
            b"campaign\nx\0y\n",
            "control characters" if sys.version_info >= (3, 11) else "line contains NUL",
        ),
        (b"campaign\n\xff\xfe\n", "expected text in UTF-8, found the byte 0xff"),
        (b'campaign\n"x\n', "unexpected end of data"),
        (b"campaign\n" + b"x" * 200_000, "field larger than field limit"),
    ],
)
def test_hostile_tables_are_refused_with_their_place(
    text: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "table.csv"
    table.write_bytes(text)
    assert main([str(table), "-o", str(tmp_path / "r.sqlite"), *STAGED]) == 3
    assert message in capsys.readouterr().err
    assert not (tmp_path / "r.sqlite").exists()


def test_tables_of_all_kinds_name_the_same_campaigns(cells: Path, tmp_path: Path) -> None:
    from lipoid.fleet.sources import find

    frame = pd.DataFrame(
        {
            "campaign": [str(path) for path in sorted(cells.glob("*/*"))],
            "batch": ["A", "B"] * (CELLS // 2),
            "age": [0.5 * k for k in range(CELLS)],
        }
    )
    frame.to_csv(tmp_path / "t.csv", index=False)
    frame.to_csv(tmp_path / "t.tsv", index=False, sep="\t")
    frame.to_parquet(tmp_path / "t.parquet")
    with sqlite3.connect(tmp_path / "t.sqlite") as database:
        frame.to_sql("cells", database)
    wanted = find([str(tmp_path / "t.csv")])
    assert wanted[3].metadata == {"batch": "B", "age": 1.5}
    assert find([str(tmp_path / "t.tsv")]) == wanted
    assert find([str(tmp_path / "t.parquet")]) == wanted
    query = "SELECT campaign, batch, age FROM cells ORDER BY age"
    assert find([str(tmp_path / "t.sqlite")], query) == wanted
    assert find([f"sqlite:///{tmp_path}/t.sqlite"], query) == wanted
    (near,) = find([str(tmp_path / "t.sqlite")], "SELECT 'a.toml' AS campaign")
    assert near.campaign == str(tmp_path / "a.toml")
    assert [one.campaign for one in find([str(cells / "*" / "*")])] == [
        one.campaign for one in find([str(cells)])
    ]
    assert {one.campaign for one in find([str(cells)])} == {one.campaign for one in wanted}
    for asked in ("DELETE FROM cells", "SELECT nothing FROM cells", "SELECT batch FROM cells"):
        results = str(tmp_path / "r.sqlite")
        asked_of = [str(tmp_path / "t.sqlite"), "--query", asked]
        assert main([*asked_of, "-o", results, *STAGED]) in (2, 3)
    assert find([str(tmp_path / "t.sqlite")], query) == wanted  # nothing was deleted


def test_exact_decimals_lose_nothing(tmp_path: Path) -> None:
    """NUMERIC of a server, decimals of Parquet: as the fields of a CSV file."""
    import decimal

    import pyarrow as pa
    from pyarrow import parquet

    from lipoid.fleet.sources import find

    serials = ["9007199254740993", "12"]  # 2**53 + 1, which no float is
    ages = ["1.50", "2.25"]
    columns = {
        "campaign": ["a", "b"],
        "serial": pa.array([decimal.Decimal(one) for one in serials], pa.decimal128(20, 0)),
        "age": pa.array([decimal.Decimal(one) for one in ages], pa.decimal128(8, 2)),
        "count": pa.array([decimal.Decimal(3), None], pa.decimal128(8, 0)),
    }
    parquet.write_table(pa.table(columns), tmp_path / "t.parquet")
    lines = [f"{a},{s},{age},{n}" for a, s, age, n in zip("ab", serials, ages, "3 ", strict=True)]
    (tmp_path / "t.csv").write_text("\n".join(["campaign,serial,age,count", *lines]) + "\n")
    found = find([str(tmp_path / "t.parquet")])
    assert [one.metadata for one in found] == [
        {"serial": "9007199254740993", "age": 1.5, "count": 3},
        {"serial": "12", "age": 2.25, "count": None},
    ]
    assert found == find([str(tmp_path / "t.csv")])


def test_folders_that_cannot_be_read_are_said(
    cells: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fleet = tmp_path / "fleet"
    (fleet / "open").mkdir(parents=True)
    (fleet / "open" / "cell").symlink_to(cells / "batch-0" / "cell-0")
    (fleet / "closed").mkdir()
    scandir = os.scandir

    def refuses(path: Any = ".") -> Any:  # as it does for all but root
        if not isinstance(path, int) and Path(path).name == "closed":
            raise PermissionError(13, "Permission denied", path)
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refuses)
    told = tmp_path / "summary.json"
    words = ["-o", str(tmp_path / "r.sqlite"), "--summary", str(told), *STAGED[:2]]
    assert main([str(fleet), *words]) == 0
    said = capsys.readouterr().err
    assert "1 folder cannot be read; campaigns in there are left out:" in said
    assert f"{fleet / 'closed'}: Permission denied" in said
    assert told_in(told)["unreadable_folders"] == 1
    assert main([str(fleet / "closed"), *words]) == 3
    assert "expected a readable folder, found none (Permission denied)" in capsys.readouterr().err
    (fleet / "open" / "cell").unlink()
    assert main([str(fleet), *words]) == 3
    assert f"below; {fleet / 'closed'}: Permission denied" in capsys.readouterr().err


def test_linked_folders_count_once(tmp_path: Path) -> None:
    from lipoid.fleet.sources import find

    fleet, elsewhere = tmp_path / "fleet", tmp_path / "elsewhere"
    for folder in (fleet / "b", elsewhere / "deep" / "c"):
        folder.mkdir(parents=True)
        (folder / "campaign.toml").write_text("")
    (fleet / "a").symlink_to("b")  # comes before what it leads to, and is not the campaign's name
    (fleet / "lab").symlink_to(elsewhere)
    (fleet / "lab-again").symlink_to(elsewhere)
    (elsewhere / "deep" / "loop").symlink_to(fleet)
    (fleet / "gone").symlink_to(tmp_path / "nowhere")
    wanted = [fleet / "b", fleet / "lab" / "deep" / "c"]
    assert [Path(one.campaign).parent for one in find([str(fleet)])] == wanted
    # A pattern names the broken link itself: its row will say so.
    found = [Path(one.campaign) for one in find([str(fleet / "*")])]
    assert found == [fleet / "gone", *(one / "campaign.toml" for one in wanted)]
    found = [Path(one.campaign).parent for one in find([str(fleet / "*" / "campaign.toml")])]
    assert found == [fleet / "b"]
    (tmp_path / "link").symlink_to(fleet)
    found = [Path(one.campaign).parent for one in find([str(tmp_path / "link")])]
    assert found == [tmp_path / "link" / "b", tmp_path / "link" / "lab" / "deep" / "c"]
    both = [str(tmp_path / "link" / "b"), str(fleet / "b")]
    assert [Path(one.campaign).parent for one in find(both)] == [tmp_path / "link" / "b"]
    table = tmp_path / "table.csv"
    table.write_text("campaign\nlink/b\nfleet/b\n")
    with pytest.raises(lipoid.LoadError, match="fleet/b was named before, in row 2"):
        find([str(table)])
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "self").symlink_to(".")
    with pytest.raises(lipoid.LoadError, match=r"found no campaign\.toml in this folder or below"):
        find([str(tmp_path / "empty")])
    with pytest.raises(lipoid.LoadError, match=r"elsewhere/deep/d: error: .* no campaign\.toml"):
        (elsewhere / "deep" / "d").mkdir()
        find([str(elsewhere / "deep" / "*")])


def test_tables_are_known_by_their_suffix_and_by_a_pattern(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from lipoid.fleet.sources import find

    folder = tmp_path / "lab"
    folder.mkdir()
    for name, batch in (("tab1.csv", "A"), ("tab2.CSV", "B"), ("tab3.TSV", "C")):
        (folder / name).write_text(f"campaign,batch\ncell-{batch}.toml,{batch}\n")
    pd.DataFrame({"campaign": ["cell-D.toml"], "batch": ["D"]}).to_parquet(folder / "tab4.PARQUET")
    wanted = [(str(folder / f"cell-{batch}.toml"), {"batch": batch}) for batch in "ABCD"]
    assert [tuple(one) for one in find([str(folder / "tab*")])] == wanted
    assert [tuple(one) for one in find([str(folder / "tab2.CSV")])] == wanted[1:2]
    with sqlite3.connect(tmp_path / "t.SQLITE") as database:
        database.execute("CREATE TABLE cells AS SELECT 'x.toml' AS campaign")
    assert len(find([str(tmp_path / "t.SQLITE")], "SELECT campaign FROM cells")) == 1
    results = ["-o", str(tmp_path / "r.sqlite"), *STAGED]
    assert main([str(folder / "none*.csv"), *results]) == 3
    assert "found no file or folder of this pattern" in capsys.readouterr().err
    assert main([str(folder / "none.csv"), *results]) == 3
    assert "expected a folder, a campaign, a table or a pattern" in capsys.readouterr().err
    # A pattern does not hide an input from an output.
    lost = str(folder / "tab4.PARQUET")
    assert main([str(folder / "tab*"), *results, "--parquet", lost]) == 2
    assert f"{lost} would overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("fields", "values"),
    [
        (["1", "-20", ""], [1, -20, None]),
        (["1", "0.5", "2e-3"], [1.0, 0.5, 2e-3]),
        (["1_1", "1_2", "2_1"], ["1_1", "1_2", "2_1"]),
        (["0012", "13", "14"], ["0012", "13", "14"]),  # a batch "12" may be another one
        (["nan", "1", "2"], ["nan", "1", "2"]),
        (["inf", "1", ""], ["inf", "1", None]),
        (["1e999", "1", "2"], ["1e999", "1", "2"]),
        (["\u0663", "1", "2"], ["\u0663", "1", "2"]),  # a digit of Arabic
        # Readers of JSON keep whole numbers below 2**53; a longer serial number stays as it is.
        (["9007199254740991", "1", "2"], [9007199254740991, 1, 2]),
        (["9007199254740993", "1", "2"], ["9007199254740993", "1", "2"]),
        (["123456789012345678901234567890", "1.5", ""],) * 2,
    ],
)
def test_columns_of_a_table_lose_nothing(
    fields: list[str], values: list[Any], tmp_path: Path
) -> None:
    from lipoid.fleet.sources import find

    lines = [f"{k}.toml,{field}\n" for k, field in enumerate(fields)]
    (tmp_path / "t.csv").write_text("campaign,x\n" + "".join(lines), encoding="utf-8")
    found = [one.metadata["x"] for one in find([str(tmp_path / "t.csv")])]
    assert found == [value or None for value in values]
    assert [type(one) for one in found] == [type(value or None) for value in values]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--method", "magic"], "method: expected"),
        (["--set", "pulses.term=3"], "unknown option 'pulses.term'"),
        (["--set", "pulses.terms=many"], "pulses.terms: expected 0 .. 1000, found 'many'"),
        (["--fix", "beta"], "--fix: expected NAME=VALUE, found 'beta'"),
        (["--bounds", "beta=1"], "--bounds: expected two numbers with a comma for beta"),
        (["--branches", "9"], "branches: expected a whole number, 0 .. 5"),
        (["--seed", "-1"], "--seed: expected 0 .. 18446744073709551615, found -1"),
        (["--seed", str(2**64)], "--seed: expected 0 .. 18446744073709551615, found 184467"),
        (["--profile", "beta,,r_s"], "--profile: expected names with a comma between them"),
        (["--retries", "-1"], "--retries: expected 0 .. 1000"),
        (["--time-limit-s", "nan"], "--time-limit-s: expected"),
        (["--memory-limit", "1MB"], "--memory-limit: expected at least 300MB"),
        (["--memory-limit", "much"], "--memory-limit: expected a size as 2GB"),
        (["--method", "joint", "--profile", "bta"], "no parameter 'bta' in this fit"),
        (["--method", "joint", "--fix", "bta=1"], "bta"),
        (["--fix", "bta=1"], "bta"),
        (["--query", "SELECT 1"], "--query needs one SOURCE that is a database"),
        (["--scheduler", "tcp://127.0.0.1:1"], "no scheduler answers"),
        (["--scheduler", "junk"], "--scheduler: expected an address as tcp://HOST:8786"),
        (["--summary", "/no/such/folder/s.json"], "cannot be written"),
    ],
)
def test_wrong_options_say_what_is_right(
    words: list[str],
    message: str,
    cells: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("lipoid.fleet.cluster.ANSWER_S", 1.0)
    one = cells / "batch-0" / "cell-0"
    assert main([str(one), "-o", str(tmp_path / "r.sqlite"), "--quiet", *words]) == 2
    assert message in capsys.readouterr().err


def test_options_are_those_of_identify(cells: Path, tmp_path: Path) -> None:
    words = ["--branches", "2", "--fix", "beta=0.2", "--bounds", "r_s=0.05,0.3"]
    words += ["--set", "pulses.terms=5", "open_circuit_voltage.knots=50", "--seed", "3"]
    one = cells / "batch-0" / "cell-0" / "campaign.toml"
    results = tmp_path / "r.sqlite"
    main([str(one), "-o", str(results), *STAGED, *words])
    (row,) = rows(results).values()
    run = json.loads(row["cell"])["run"]
    assert run["seed"] == 3
    assert run["options"]["pulses"]["terms"] == 5
    assert run["options"]["open_circuit_voltage"]["knots"] == 50
    assert json.loads(row["cell"])["diffusion"]["beta_per_sqrt_s"] == 0.2


def test_a_default_that_is_written_is_no_other_option(cells: Path, tmp_path: Path) -> None:
    one = str(cells / "batch-0" / "cell-0" / "campaign.toml")
    results = tmp_path / "r.sqlite"
    summary = tmp_path / "s.json"
    words = [one, "-o", str(results), *STAGED, "--summary", str(summary)]
    main(words)
    defaults = ["pulses.terms=10", "pulses.tail=true", "solver.step_tolerance=1.0e-10"]
    main([*words, "--seed", "0", "--set", *defaults])
    assert json.loads(summary.read_text())["kept"] == 1
    assert main([*words, "--set", "pulses.terms=9"]) == 2
    made = tmp_path / "joint.sqlite"
    main([one, "-o", str(made), "--quiet", "--method", "joint"])
    assert rows(made)[one]["options"] == "{}"


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("postgresql+nosuchdriver://u:secret@h/d", "SQLAlchemy knows no such database"),
        ("nosuchdatabase://u:secret@h/d", "SQLAlchemy knows no such database"),
        ("postgresql+pg8000://u:secret@h/d", "the driver of this database is not installed"),
        ("://", "expected an SQLAlchemy URL"),
        ("postgresql://u:secret@h:port/d", "expected an SQLAlchemy URL"),
    ],
)
def test_databases_out_of_reach_are_said(
    url: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("sqlalchemy")
    if "pg8000" in url and importlib.util.find_spec("pg8000"):
        pytest.skip("pg8000 is installed")
    words = ["-o", str(tmp_path / "r.sqlite"), "--query", "SELECT campaign FROM t"]
    assert main([url, *words]) == 2
    told = capsys.readouterr().err
    assert message in told and "secret" not in told


def test_profiles_are_asked_for_as_of_identify(cells: Path, tmp_path: Path) -> None:
    one = str(cells / "batch-0" / "cell-0" / "campaign.toml")
    results = [str(tmp_path / "a.sqlite"), str(tmp_path / "b.sqlite")]
    # The largest seed is one, too.
    words = [*STAGED, "--seed", str(2**64 - 1), "--profile"]
    assert main([one, "-o", results[0], *words, "beta,r_s"]) == 0
    assert main([one, "-o", results[1], *words, "beta", "r_s"]) == 0
    assert essence(Path(results[0])) == essence(Path(results[1]))
    (row,) = rows(Path(results[0])).values()
    assert [one["name"] for one in json.loads(row["summary"])["profiles"]] == ["beta", "r_s"]


def test_outputs_replace_nothing(
    cells: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = tmp_path / "text.sqlite"
    text.write_text("my only notes\n" * 100)
    other = tmp_path / "other.sqlite"
    with sqlite3.connect(other) as database:
        database.execute("CREATE TABLE mine (x)")
    table = tmp_path / "table.csv"
    table.write_text(f"campaign\n{cells / 'batch-0' / 'cell-0'}\n")
    before = [text.read_bytes(), other.read_bytes(), table.read_bytes()]
    assert main([str(cells), "-o", str(text), *STAGED]) == 2
    assert main([str(cells), "-o", str(other), *STAGED]) == 2
    assert "that lipoid-fleet did not make" in capsys.readouterr().err
    assert main([str(table), "-o", str(table), *STAGED]) == 2
    assert main([str(table), "-o", str(tmp_path / "r.sqlite"), "--parquet", str(table)]) == 2
    assert main([str(table), "-o", str(tmp_path), *STAGED]) == 2
    assert main([str(table), "-o", str(tmp_path / "none" / "r.sqlite"), *STAGED]) == 2
    assert before == [text.read_bytes(), other.read_bytes(), table.read_bytes()]
    assert not list(tmp_path.glob("*.lock"))
    foreign = tmp_path / "r.sqlite.lock"
    foreign.write_text("of another program")
    assert main([str(table), "-o", str(tmp_path / "r.sqlite"), *STAGED]) == 2
    assert "is not the lock of lipoid-fleet" in capsys.readouterr().err
    assert foreign.read_text() == "of another program"


def test_a_name_that_is_not_utf8_is_said_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = os.fsencode(tmp_path) + b"/z\xe4hler"
    os.mkdir(folder)
    Path(os.fsdecode(folder), "campaign.toml").write_text("")
    assert main([str(tmp_path), "-o", str(tmp_path / "r.sqlite"), *STAGED]) == 3
    assert "expected paths in UTF-8" in capsys.readouterr().err
    assert not (tmp_path / "r.sqlite").exists()


def test_results_are_read_where_nobody_may_write(undisturbed: Path) -> None:
    import shutil
    import tempfile

    from lipoid.fleet.results import open_for_reading

    with tempfile.TemporaryDirectory() as name:
        shutil.copy(undisturbed, f"{name}/r.sqlite")
        os.chmod(f"{name}/r.sqlite", 0o444)
        os.chmod(name, 0o555)
        user = os.geteuid()
        if user == 0:
            os.seteuid(65534)
        try:
            with contextlib.closing(open_for_reading(f"{name}/r.sqlite")) as database:
                (count,) = database.execute("SELECT count(*) FROM campaigns").fetchone()
        finally:
            os.seteuid(user)
            os.chmod(name, 0o755)
    assert count == CELLS


def test_limits_cost_a_retry_and_then_a_row(cells: Path, tmp_path: Path) -> None:
    good = str(cells / "batch-0" / "cell-0" / "campaign.toml")
    worker.start()  # a run before stopped it
    late = Settings({"method": "staged"}, time_limit_s=0.001, retries=2)
    (row,) = identify_batch([good], late)
    assert (row["failure"], row["attempts"]) == ("time-limit", 3)
    assert row["reason"] == "took longer than the limit of 0.001 s"
    lipoid.synthesize("gifi-600mAh-1", tmp_path / "large", sampling_s=0.02, rates_C="1")
    large = str(tmp_path / "large" / "campaign.toml")
    (free,) = identify_batch([large], Settings({"method": "staged"}))
    (small,) = identify_batch([good], Settings({"method": "staged"}))
    assert free["status"] == small["status"] == "done"
    # What counts are the bytes that the process may write to: about 170 MB before it begins.
    assert free["peak_memory_bytes"] > small["peak_memory_bytes"] + 80_000_000
    limited = Settings({"method": "staged"}, memory_bytes=240_000_000)
    first, second = identify_batch([large, good], limited)
    assert (first["failure"], first["attempts"]) == ("memory-limit", 2)
    assert second["status"] == "done"
    worker.stop()


def children(of: int) -> list[int]:
    """Return the processes that identify for this one."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            parent = int(path.joinpath("stat").read_text().rsplit(")", 1)[1].split()[1])
            command = path.joinpath("cmdline").read_bytes()
        except OSError:
            continue
        if parent == of and b"lipoid.fleet.runner" in command:
            found.append(int(path.name))
    return found


def start(*words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", *map(str, words)],
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_rows(results: Path, count: int, process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + 60.0
    while time.monotonic() < end and process.poll() is None:
        try:
            with sqlite3.connect(f"file:{results}?mode=ro", uri=True) as database:
                if database.execute("SELECT count(*) FROM campaigns").fetchone()[0] >= count:
                    return
        except sqlite3.Error:
            pass
        time.sleep(0.01)
    assert process.poll() is None, process.communicate()


def test_killed_processes_cost_nothing(cells: Path, undisturbed: Path, tmp_path: Path) -> None:
    results = tmp_path / "results.sqlite"
    words = [cells, "-o", results, *STAGED, "--retries", "50", "--summary", tmp_path / "s.json"]
    process = start("lipoid.fleet", *words)
    killed = 0
    while process.poll() is None:
        for one in children(process.pid):
            if killed < 6:
                os.kill(one, signal.SIGKILL)
                killed += 1
        time.sleep(0.02)  # a fast machine needs little longer for all of them
    assert process.wait() == 0, process.communicate()
    assert killed == 6
    told = told_in(tmp_path / "s.json")
    assert (told["done"], told["failed"]) == (CELLS, 0)
    assert told["retries"] >= 1
    assert essence(results) == essence(undisturbed)


def test_a_signal_stops_and_the_same_command_goes_on(
    cells: Path, undisturbed: Path, tmp_path: Path
) -> None:
    results = tmp_path / "results.sqlite"
    summary = tmp_path / "summary.json"
    words = [cells, "-o", results, "--method", "staged", "--workers", 1, "--summary", summary]
    process = start("lipoid.fleet", *words)
    wait_for_rows(results, 1, process)
    process.send_signal(signal.SIGSTOP)  # at once: a fast machine needs little longer for the rest
    running = children(process.pid)
    second = start("lipoid.fleet", *words)
    assert second.wait() == 2
    assert "another lipoid-fleet is writing to it" in second.communicate()[1]
    process.send_signal(signal.SIGCONT)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=30.0)
    written = len(rows(results))
    if process.returncode == -signal.SIGINT:  # it was not quicker than the signal
        assert "the same command goes on" in told
        assert written < CELLS
        assert told_in(summary)["exit_code"] == 128 + signal.SIGINT
        assert told_in(summary)["done"] == written
    end = time.monotonic() + 5.0  # init takes its time to bury what was killed
    while left := [one for one in running if Path(f"/proc/{one}").exists()]:
        assert time.monotonic() < end, left
        time.sleep(0.01)
    assert not results.with_name("results.sqlite.lock").exists()
    kept = rows(results)
    assert main([*map(str, words), "--quiet"]) == 0
    assert essence(results) == essence(undisturbed)
    assert all(rows(results)[key]["finished"] == row["finished"] for key, row in kept.items())


def test_a_scheduler_that_goes_while_it_is_asked_is_said() -> None:
    class Client:  # of dask, whose connection has just been closed
        status = "closed"
        scheduler = types.SimpleNamespace(address="tcp://nowhere:1")

        def nthreads(self) -> dict[str, int]:
            raise ConnectionResetError("Connection reset by peer")

    results = cast(Results, None)  # of no campaign
    run = Run(Client(), results, [], Settings(options={}), Progress(0, shown=False))
    with pytest.raises(Stopped, match="the scheduler at tcp://nowhere:1 is gone"):
        run.go(Signals())


def test_nothing_listens_on_this_machine(cells: Path, tmp_path: Path) -> None:
    import psutil

    process = start("lipoid.fleet", cells, "-o", tmp_path / "results.sqlite", *STAGED)
    wait_for_rows(tmp_path / "results.sqlite", 1, process)
    if process.poll() is None:
        assert not psutil.Process(process.pid).net_connections("inet")
    assert process.wait() == 0


@pytest.fixture()
def port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        number: int = one.getsockname()[1]
        return number


def dask(*words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_" + str(words[0]), *map(str, words[1:])],
        env=ENVIRONMENT,
        stderr=subprocess.DEVNULL,
        text=True,
    )


@pytest.fixture()
def cluster(port: int, tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """A scheduler and two workers of dask, each a process."""
    address = f"tcp://127.0.0.1:{port}"
    scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
    options = ["--no-nanny", "--nthreads", 1, "--no-dashboard", "--local-directory", tmp_path]
    processes = [scheduler] + [dask("worker", address, *options) for _ in range(2)]
    yield address, processes
    for process in processes:
        process.kill()
        process.wait()


def test_a_cluster_that_dies_costs_nothing_that_was_written(
    cells: Path,
    undisturbed: Path,
    tmp_path: Path,
    cluster: tuple[str, list[subprocess.Popen[str]]],
) -> None:
    address, (scheduler, first, _) = cluster
    results = tmp_path / "results.sqlite"
    command = [cells, "-o", results, "--method", "staged"]
    process = start("lipoid.fleet", *command, "--scheduler", address)
    wait_for_rows(results, 1, process)
    first.kill()
    wait_for_rows(results, 4, process)
    scheduler.kill()
    _, told = process.communicate(timeout=60.0)
    written = len(rows(results))
    if written < CELLS:
        assert process.returncode == 1
        assert f"the scheduler at {address} is gone; the same command goes on" in told
    kept = rows(results)
    assert main([*map(str, command), "--quiet"]) == 0
    assert essence(results) == essence(undisturbed)
    assert all(rows(results)[key]["finished"] == row["finished"] for key, row in kept.items())


def test_parquet_has_all_of_it(cells: Path, undisturbed: Path, tmp_path: Path) -> None:
    from lipoid.fleet import parquet

    parquet.write(str(undisturbed), str(tmp_path / "r.parquet"))
    table = pd.read_parquet(tmp_path / "r.parquet").set_index("campaign")
    assert len(table) == CELLS
    with sqlite3.connect(undisturbed) as database:
        for campaign, name, estimate, error in database.execute(
            "SELECT campaign, name, estimate, standard_error FROM campaigns JOIN parameters "
            "USING (id)"
        ):
            assert table.loc[campaign, name] == estimate
            assert error is None or table.loc[campaign, f"{name}_standard_error"] == error


def made_up(file: Path, count: int = 400) -> None:
    """Write results that are known: one stands out, r_s grows with age, alpha differs by batch."""
    rng = np.random.default_rng(0)
    with Results(file, "{}") as results:
        made = []
        for k in range(count):
            batch = "<script>alert(1)</script>" if k % 2 else "A & B"
            age = k // 4
            r_s = 0.1 * (1.0 + 0.001 * age) + rng.normal(0.0, 0.0005)
            r_s += 0.05 if k == 17 else 0.0
            alpha = 1350.0 - (10.0 if k % 2 else 0.0) + rng.normal(0.0, 3.0)
            parameters = [
                ("r_s", "Ohm", r_s, 1e-4, r_s, r_s, "identified"),
                ("alpha", "C", alpha, 1.0, alpha, alpha, "identified"),
                ("c_1", "F", 1.0 + k, None, None, None, "weak"),
            ]
            row: dict[str, Any] = {
                "campaign": f"/cells/{k}/<i>.toml",
                "status": "done",
                "options": "{}",
            }
            row |= {"version": "1", "commit": "c", "finished": "now"}
            row |= {"metadata": json.dumps({"batch": batch, "age": age})}
            made.append(row | {"attempts": 1, "rmse_V": 1e-3, "parameters": parameters})
        failed = {"campaign": "/x<b>.toml", "status": "failed", "failure": "died", "attempts": 2}
        failed |= {"reason": "<img src=x>", "options": "{}", "version": "1", "commit": "c"}
        made.append(failed | {"finished": "now", "metadata": "{}"})
        results.put(made)


def test_the_report_finds_what_is_there(tmp_path: Path) -> None:
    made_up(tmp_path / "r.sqlite")
    outliers, drift = tmp_path / "outliers.csv", tmp_path / "drift.csv"
    written = ["--outliers", str(outliers), "--drift", str(drift)]
    assert (
        main(["report", str(tmp_path / "r.sqlite"), "-o", str(tmp_path / "s.csv"), *written]) == 0
    )
    spread = pd.read_csv(tmp_path / "s.csv").set_index("name")
    # A median of 200 values is off by 1.25 / sqrt(200) of their width.
    assert spread.loc["alpha", "median"] == pytest.approx(1345.0, abs=1.0)
    assert spread.loc["c_1", "identified"] == 0 and spread.loc["c_1", "cells"] == 400
    both = [
        str(tmp_path / "r.sqlite"),
        "-o",
        str(tmp_path / "r.html"),
        "--outliers",
        "-",
        "--drift",
        "-",
    ]
    assert main(["report", *both]) == 0
    far = pd.read_csv(outliers)
    assert list(far["campaign"]) == ["/cells/17/<i>.toml"] and list(far["name"]) == ["r_s"]
    moved = pd.read_csv(drift)
    batches = moved[moved["over"] == "batch"].set_index(["name", "batch"])
    assert batches.loc[("alpha", "A & B"), "differs"]
    assert not batches.loc[("r_s", "A & B"), "differs"]
    ages = moved[moved["over"] == "age"].set_index("name")
    # The noise of 0.0005 Ohm over 400 cells of ages to 99: 9e-7 Ohm is its standard error.
    assert ages.loc["r_s", "slope_per_age"] == pytest.approx(1e-4, abs=4e-6)
    assert ages.loc["r_s", "drifts"] and not ages.loc["alpha", "drifts"]


class Reported(NamedTuple):
    page: str
    told: str  # on standard error
    outliers: pd.DataFrame
    drift: pd.DataFrame


def report_of(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    values: Sequence[float],
    metadata: Sequence[dict[str, Any]] = (),
    options: Sequence[str] = (),
    campaigns: Sequence[tuple[str, str]] = (),  # with the SHA-256 of their file
) -> Reported:
    """Return the report of cells with these values of r_s."""
    file = folder / "r.sqlite"
    file.unlink(missing_ok=True)
    made = []
    for k, value in enumerate(values):
        row: dict[str, Any] = {"campaign": f"/cells/{k}.toml", "status": "done", "version": "1"}
        row |= {"commit": "c", "finished": "now", "attempts": 1, "rmse_V": 1e-3 + 1e-5 * (k % 5)}
        row["metadata"] = json.dumps(metadata[k] if metadata else {})
        row["options"] = options[k] if options else "{}"
        if campaigns:
            row["campaign"], digest = campaigns[k]
            row["inputs"] = json.dumps([{"file": row["campaign"], "sha256": digest}])
        row["parameters"] = [("r_s", "Ohm", value, None, None, None, "identified")]
        made.append(row)
    with Results(file, "{}") as results:
        results.put(made)
    outliers, drift, page = folder / "outliers.csv", folder / "drift.csv", folder / "r.html"
    words = [str(file), "-o", str(page), "--outliers", str(outliers), "--drift", str(drift)]
    assert main(["report", *words]) == 0
    told = capsys.readouterr().err
    text = html.unescape(page.read_text())
    return Reported(text, told, pd.read_csv(outliers), pd.read_csv(drift, dtype={"batch": str}))


def test_cells_without_a_batch_are_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    batches = [1, 2, None, "", 1, 2, 1, 2, None]
    found = report_of(
        tmp_path, capsys, [0.1 + 0.001 * k for k in range(9)], [{"batch": one} for one in batches]
    )
    of_r_s = found.drift[(found.drift["name"] == "r_s") & (found.drift["over"] == "batch")]
    assert list(of_r_s["batch"]) == ["1", "2"] and list(of_r_s["cells"]) == [3, 3]


def test_dates_do_not_depend_on_where_the_machine_is(monkeypatch: pytest.MonkeyPatch) -> None:
    from lipoid.fleet import ages

    texts = ["2024-03-08", "2024-03-11", "2024-03-12T00:00:00Z", "2024-03-12T01:00:00+01:00"]
    for zone in ("America/New_York", "Asia/Tokyo"):  # the one with a clock set forward meanwhile
        monkeypatch.setenv("TZ", zone)
        time.tzset()
        days, note = ages.read("age", texts)
        monkeypatch.undo()
        time.tzset()
        assert list(days) == [0.0, 3.0, 4.0, 4.0] and not note
    days, _ = ages.read("age", ["0001-01-01", "9999-12-31T23:59:59"])
    assert days[1] == pytest.approx(3652058.99998843)  # days of 9999 years, less one second


@pytest.mark.parametrize(
    ("given", "ages_found", "note"),
    [
        ([0, 100, None, ""], [0, 100, None, None], ""),
        (["0", "100.5", "1e3"], [0, 100.5, 1000], ""),
        (
            [0, 100, "2024-01-01"],
            [0, 100, None],
            "The slopes use the 2 numbers of the column age and leave out 1 date (as "
            "'2024-01-01'). Write every age as a number, or every one as a date such as "
            "2024-01-31.",
        ),
        (
            ["2024-01-01", "2024-01-03", 5, "nan"],
            [0, 2, None, None],
            "The slopes use the 2 dates of the column age and leave out 1 number (as 5) and 1 "
            "value that is neither a number nor a date (as 'nan'). Write",
        ),
        (
            ["01.03.2024", "02.03.2024"],
            [None, None],
            "The slopes use nothing of the column age and leave out 2 values that are neither a "
            "number nor a date (as '01.03.2024'). Write",
        ),
        # Eight digits are dates where the other numbers are so, too.
        (["20240101", "20240301"], [0, 60], ""),
        ([20240101, 20240301], [0, 60], ""),
        (["20240101", "300", "20111111.5", "1"], [20240101, 300, 20111111.5, 1], ""),
    ],
)
def test_ages_that_cannot_be_used_are_said(
    given: list[object], ages_found: list[float | None], note: str
) -> None:
    from lipoid.fleet import ages

    found, said = ages.read("age", given)
    assert [None if one != one else one for one in found] == ages_found
    assert said.startswith(note) if note else not said


def test_the_report_says_which_ages_it_leaves_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = [0.1 + 0.001 * k for k in range(6)]
    german = [{"age": f"0{k + 1}.03.2024"} for k in range(6)]
    found = report_of(tmp_path, capsys, values, german)
    note = "leave out 6 values that are neither a number nor a date (as '01.03.2024')"
    assert note in found.page and note in found.told
    assert "at least three different ages; the results give 0." in found.page
    found = report_of(tmp_path, capsys, values, [{"age": 100 * k} for k in range(5)] + [{}])
    assert "column age" not in found.page + found.told and "r_s" in set(found.drift["name"])
    found = report_of(tmp_path, capsys, values[:1] * 6, [{"age": str(k)} for k in range(6)])
    assert list(found.drift["name"]) == ["rmse_V"]


def test_columns_that_no_result_has_are_refused(
    undisturbed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = ["report", str(undisturbed), "-o", str(tmp_path / "r.csv")]
    table = tmp_path / "fl.csv"
    table.write_text("campaign,batch\nc1,7\n")
    for option in ("--outliers", "--drift", "-o"):  # the last of -o counts
        assert main([*report, option, str(table)]) == 2
        assert "is there and holds something else" in capsys.readouterr().err
    assert table.read_text() == "campaign,batch\nc1,7\n"
    for _ in range(2):  # what is there is its own the second time
        told = ["--outliers", str(tmp_path / "o.csv"), "--drift", str(tmp_path / "d.csv")]
        assert main([*report, *told]) == 0
    assert main([*report, "--batch", "btach"]) == 2
    assert "--batch: expected a column of the results, none; found btach" in capsys.readouterr().err
    assert main([*report, "--batch", "batch", "--age", "age"]) == 0


def test_values_about_zero_have_no_percentage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = [-2e-9, -1e-9, 0.0, 1e-9, 2e-9]
    found = report_of(tmp_path, capsys, values, [{"age": k} for k in range(5)])
    slope = found.drift[found.drift["name"] == "r_s"].iloc[0]
    assert slope["slope_per_age"] == pytest.approx(1e-9)
    assert pd.isna(slope["slope_percent_per_age"])


def test_without_a_width_no_cell_is_measured_by_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = report_of(tmp_path, capsys, [0.13, 0.13, 0.13, 0.13, 0.1300001, 0.1])
    assert not len(found.outliers) and "e+308" not in found.page
    note = (
        "r_s: more than half of the cells have exactly 0.13 Ohm, so that the robust standard "
        "deviation is 0 and no cell can be measured by it. 2 cells have another value; the "
        "furthest, 0.1 Ohm, is of /cells/5.toml."
    )
    assert note in found.page and f"warning: {note}" in found.told
    assert "more than half" not in report_of(tmp_path, capsys, [0.13] * 4).told


def of_cells(
    values: Sequence[float], ages: Sequence[float], errors: Sequence[float] = ()
) -> Quantity:
    """Return the quantity of these cells."""
    known = pd.DataFrame({"value": values, "error": errors or np.nan}, index=range(len(values)))
    of = pd.DataFrame({"campaign": [f"/{k}" for k in known.index], "batch": None, "age": ages})
    return spread._quantity("r_s", "Ohm", len(values), known, of)


@pytest.mark.parametrize("cells", [3, 5, 6, 9, 40])
def test_noise_seldom_drifts_and_seldom_stands_out(cells: int) -> None:
    from scipy import stats

    rng = np.random.default_rng(8)
    fleets, quantities = 200 if cells >= 6 else 40, 6  # of fewer cells none drifts
    drifting = standing_out = 0
    for _ in range(fleets):
        noise = [of_cells(rng.normal(size=cells).tolist(), range(cells)) for _ in range(quantities)]
        found = spread.age_table(noise)
        drifting += int((found["drifts"].eq(True)).any())
        standing_out += sum(len(one.outliers(4.0)) > 0 for one in noise)
        assert found["drifts"].isna().all() == (cells < 6)
    # Three standard deviations of the counts above their means at the chances that are promised.
    assert drifting <= fleets * 0.05 + 3.0 * np.sqrt(fleets * 0.05 * 0.95)
    by_chance = fleets * quantities * cells * 2.0 * stats.norm.sf(4.0)
    assert standing_out <= (by_chance + 3.0 * np.sqrt(by_chance)) * (cells >= 10)


@pytest.mark.parametrize("ages", [[0, 1, 2, 3], [0, 0, 1, 2, 2], [3, 1, 1, 1, 0, 2, 2]])
def test_orders_are_counted_as_by_hand(ages: list[float]) -> None:
    pairs = [(a, b) for a, b in itertools.permutations(range(len(ages)), 2) if ages[a] < ages[b]]
    orders = [
        sum(values[a] > values[b] for a, b in pairs)
        for values in itertools.permutations(range(len(ages)))
    ]
    tied = [math.factorial(ages.count(age)) for age in set(ages)]
    expected = np.bincount(orders) // math.prod(tied)
    assert spread._orders(np.array(ages, dtype=float)) == expected.tolist()


def test_a_drift_of_few_cells_is_that_of_kendalls_exact_test() -> None:
    from scipy import stats

    rng = np.random.default_rng(9)
    for _ in range(100):
        ages = rng.permutation(9).astype(float)
        values = 0.4 * ages + rng.normal(size=9)
        found = spread.age_table([of_cells(values.tolist(), ages.tolist())]).iloc[0]
        p = stats.kendalltau(values, ages, method="exact").pvalue
        assert found["drifts"] == (p <= 0.05)


def test_few_cells_do_not_tell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ages = [{"age": k} for k in range(5)]
    found = report_of(tmp_path, capsys, [0.1, 0.1001, 0.1002, 0.2], ages)
    assert not len(found.outliers)
    note = (
        "There are not enough cells to tell whether one stands out: r_s (4), rmse_V (4). It takes "
        "10 whose logs identify the parameter."
    )
    assert note in found.page and f"warning: {note}" in found.told
    assert found.drift["drifts"].isna().all() and found.drift["low"].isna().all()
    # 2 / 5! is the 0.05 / 3 that each of three quantities may have; 2 / 4! is above it.
    needs = "Without an interval there are not enough cells to tell: with these 3 quantities it"
    assert f"{needs} takes 5 of different ages." in found.page
    found = report_of(tmp_path, capsys, [0.1, 0.1001, 0.1002, 0.1003, 0.2], ages)
    assert found.drift["drifts"].all() and needs not in found.page


def test_a_cell_is_no_odder_than_its_standard_error() -> None:
    values = [0.1 + 1e-4 * (k % 5) for k in range(11)] + [0.15]
    far = of_cells(values, range(12), [1e-5] * 12).outliers(4.0)
    assert list(far["value"]) == [0.15] and far["deviation"].iloc[0] > 100.0
    assert not len(of_cells(values, range(12), [1e-5] * 11 + [0.02]).outliers(4.0))


def test_results_of_several_options_are_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = [0.1 + 0.001 * k for k in range(5)]
    options = ['{"method": "staged"}', "{}", "{}", '{"method": "staged"}', "{}"]
    found = report_of(tmp_path, capsys, values, options=options)
    note = (
        "The results are of 2 sets of options: 3 cells of the defaults, 2 cells of "
        '{"method": "staged"}. Differences between cells may be differences between methods. To '
        "compare cells, do all with the same options: lipoid-fleet with --replace."
    )
    assert note in found.page and f"warning: {note}" in found.told
    assert "sets of options" not in report_of(tmp_path, capsys, values).told


def test_a_renamed_campaign_counts_once_and_copies_are_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("new", "b", "c"):
        (tmp_path / name).touch()
    (tmp_path / "d").symlink_to("c")
    names = [("old", "1"), ("new", "1"), ("b", "2"), ("c", "3"), ("d", "3"), ("gone", "4")]
    campaigns = [(str(tmp_path / name), digest) for name, digest in names]
    values = [9.0, 0.1, 0.2, 0.3, 9.0, 0.4]
    told = report_of(tmp_path, capsys, values, campaigns=campaigns).told
    assert "4 cells, 0 failed" in told
    assert "Left out: 2 results of campaigns that were moved or renamed since, or have" in told
    assert "byte for byte" not in told
    campaigns[4] = (str(tmp_path / "b"), "1")  # a copy, at another place that is there
    campaigns[2] = (str(tmp_path / "e"), "2")
    told = report_of(tmp_path, capsys, values, campaigns=campaigns).told
    assert "5 cells, 0 failed" in told and "Left out: 1 result of" in told
    copy = f"({tmp_path / 'new'} of {tmp_path / 'b'})"
    assert f"The files of 1 result are those of another one, byte for byte {copy}" in told
    assert report_of(tmp_path, capsys, values).told.startswith(
        "lipoid-fleet report: warning: There"
    )


def test_the_page_runs_nothing_and_loads_nothing(tmp_path: Path) -> None:
    import base64
    import hashlib
    import re
    from html.parser import HTMLParser

    made_up(tmp_path / "r.sqlite")
    assert main(["report", str(tmp_path / "r.sqlite"), "-o", str(tmp_path / "r.html")]) == 0
    text = (tmp_path / "r.html").read_text()
    tags: list[str] = []
    attributes: list[str] = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            tags.append(tag)
            attributes.extend(name for name, _ in attrs)

    Reader().feed(text)
    assert not {"script", "img", "link", "iframe", "b", "i", "a"} & set(tags)
    assert not {"src", "href", "style", "onload", "onclick"} & set(attributes)
    style = re.search("<style>(.*)</style>", text, re.DOTALL)
    assert style is not None
    digest = base64.b64encode(hashlib.sha256(style[1].encode()).digest()).decode()
    assert f"style-src 'sha256-{digest}'" in text and "default-src 'none'" in text
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text and "&lt;img src=x&gt;" in text
    assert "svg" in tags


def test_reports_of_little(
    undisturbed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", str(undisturbed), "-o", str(tmp_path / "r.html")]) == 0
    assert "fewer than two batches" in (tmp_path / "r.html").read_text()
    assert main(["report", str(tmp_path / "none"), "-o", str(tmp_path / "r.html")]) == 3
    assert main(["report", __file__, "-o", str(tmp_path / "r.html")]) == 3
    assert main(["report", str(undisturbed), "-o", str(tmp_path / "r.pdf")]) == 2
    assert main(["report", str(undisturbed), "-o", str(tmp_path / "none" / "r.csv")]) == 2
    capsys.readouterr()


@pytest.mark.parametrize(
    ("time_s", "text"),
    [(12.4, "12 s"), (99.6, "2 min"), (3600.0, "60 min"), (9000.0, "2.5 h"), (4e5, "4.6 days")],
)
def test_times_for_a_person(time_s: float, text: str) -> None:
    assert duration(time_s) == text


def test_takes_no_modules_from_the_folder_of_the_files(cells: Path, tmp_path: Path) -> None:
    """Files from elsewhere may be called like modules; none of them runs."""
    ran = tmp_path / "ran"
    names = ["resource", "json", "lipoid", "queue"]
    if sys.version_info >= (3, 11):  # before, the processes of dask itself look in the folder first
        names.append("multiprocessing")
    for name in names:
        (tmp_path / f"{name}.py").write_text(f"open({str(ran)!r}, 'a').write({name!r})\n")
    code = "import sys; sys.path[:] = [one for one in sys.path if one]; "
    code += "from lipoid.fleet.command import main; sys.exit(main())"
    subprocess.run(
        [sys.executable, "-c", code, str(cells), "-o", "r.sqlite", *STAGED],
        cwd=tmp_path,
        env=ENVIRONMENT,
        check=True,
        timeout=300,
    )
    assert not ran.exists(), ran.read_text()
    assert len(rows(tmp_path / "r.sqlite")) == CELLS


def test_what_it_did_not_write_is_not_replaced(cells: Path, tmp_path: Path) -> None:
    """A log, a campaign, a pipe: refused before any work, whatever leads there."""
    import shutil

    own = tmp_path / "cells"
    shutil.copytree(cells / "batch-0", own)
    log, campaign = own / "cell-0" / "low_rate.csv", own / "cell-0" / "campaign.toml"
    before = log.read_bytes(), campaign.read_bytes()
    link = tmp_path / "link"
    link.symlink_to(log)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    results = tmp_path / "r.sqlite"
    for outputs in (
        ["--summary", str(log)],
        ["--summary", str(link)],
        ["--parquet", str(campaign)],
        ["--summary", str(pipe)],
        ["--summary", str(tmp_path / "none" / "s.json")],
        ["-o", ""],
        ["-o", ":memory:"],
    ):
        words = [str(own), "-o", str(results), *STAGED, *outputs]
        assert main(words) == 2, outputs
    assert (log.read_bytes(), campaign.read_bytes()) == before
    assert pipe.is_fifo() and not results.exists()
