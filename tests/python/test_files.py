"""Nothing is written over what it is made from."""

from __future__ import annotations

import copy
import hashlib
import os
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import lipoid
from lipoid import _core


@pytest.fixture(scope="module")
def found(lab: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    folder = tmp_path_factory.mktemp("found")
    shutil.copytree(lab, folder / "lab")
    result = lipoid.identify(folder / "lab" / "campaign.toml", method="staged")
    result.cell.save(folder / "c.json")
    os.symlink(folder / "c.json", folder / "link.json")
    (folder / "m.csv").write_text(
        "time_s,current_A,voltage_V\n0,0,4.2\n60,1,4.0\n120,1,3.99\n180,0,4.15\n"
    )
    return folder, result


def _reports(write: Callable[[Path, Any], object]) -> Any:
    without = pytest.mark.skipif(not _core.can_report(), reason="built without reports")
    return pytest.param(write, marks=without)


@pytest.mark.parametrize(
    "write",
    [
        lambda f, r: lipoid.export(f / "c.json", "tables", f / "c.json"),
        lambda f, r: lipoid.export(f / "c.json", "tables", f / "link.json"),
        lambda f, r: lipoid.export(lipoid.Cell.read(f / "c.json").pack(2), "tables", f / "c.json"),
        lambda f, r: lipoid.export(
            copy.copy(lipoid.Cell.read(f / "c.json")), "tables", f / "c.json"
        ),
        lambda f, r: lipoid.export(
            pickle.loads(pickle.dumps(lipoid.Cell.read(f / "c.json"))), "tables", f / "c.json"
        ),
        lambda f, r: lipoid.export(
            lipoid.Cell.read(f / "c.json").resample(1)[0], "tables", f / "c.json"
        ),
        lambda f, r: r.cell.resample(1)[0].save(f / "lab" / "pulses.csv"),
        lambda f, r: r.cell.resample(1)[0].pack(2).save(f / "lab" / "campaign.toml"),
        lambda f, r: lipoid.export(f / "c.json", "c", f / "m.csv", mission=f / "m.csv"),
        lambda f, r: lipoid.export(
            f / "c.json", "c", f / "m.csv", mission=lipoid.read_log(f / "m.csv")
        ),
        lambda f, r: lipoid.export(r, "tables", f / "lab" / "pulses.csv"),
        lambda f, r: lipoid.synthesize(f / "lab" / "truth.json", f / "lab", sampling_s=5.0),
        lambda f, r: lipoid.synthesize(r, f / "lab", sampling_s=5.0),
        lambda f, r: r.cell.save(f / "lab" / "pulses.csv"),
        lambda f, r: r.cell.save(f / "lab" / "../lab/campaign.toml"),
        lambda f, r: lipoid.Cell.read(f / "c.json").save(f / "lab" / "pulses.csv"),
        _reports(lambda f, r: r.report(f / "lab" / "campaign.toml")),
        _reports(lambda f, r: lipoid.report([r], f / "lab" / "pulses.csv")),
        _reports(
            lambda f, r: lipoid.fly("hover", cell=f / "c.json", duration=0.1).report(f / "c.json")
        ),
        _reports(
            lambda f, r: lipoid.endurance(f / "c.json", vehicle="mambo-physical").report(
                f / "link.json"
            )
        ),
    ],
)
def test_an_input_is_not_written_over(
    found: tuple[Path, Any], write: Callable[[Path, Any], object]
) -> None:
    folder, result = found
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with pytest.raises(lipoid.OptionError, match="is also an input; name another file"):
        write(folder, result)
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before


def test_a_cell_is_saved_over_the_file_that_it_was_read_from(
    found: tuple[Path, Any], tmp_path: Path
) -> None:
    shutil.copy(found[0] / "c.json", tmp_path / "c.json")
    lipoid.Cell.read(tmp_path / "c.json").pack(2).save(tmp_path / "c.json")
    assert lipoid.Cell.read(tmp_path / "c.json").series == 2


def test_an_export_names_the_file_that_the_cell_was_read_from(tmp_path: Path) -> None:
    file = Path(__file__).parents[2] / "fixtures" / "cells" / "gifi-600mAh-1.json"
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    for cell in (file, "gifi-600mAh-1", lipoid.Cell.read(file)):
        lipoid.export(cell, "px4", tmp_path / "battery.params")
        assert sha256 in (tmp_path / "battery.params").read_text()
