"""The notebooks of docs run as they are committed."""

from __future__ import annotations

from pathlib import Path

import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs").glob("*.ipynb"))


def test_there_are_two() -> None:
    assert len(NOTEBOOKS) == 2


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(file: Path) -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(file, as_version=4)
    assert all(cell["execution_count"] for cell in notebook.cells if cell["cell_type"] == "code")
    resources = {"metadata": {"path": str(file.parent)}}
    nbclient.NotebookClient(notebook, timeout=600, resources=resources).execute()


def test_they_are_light() -> None:
    for file in NOTEBOOKS:
        assert file.stat().st_size < 400_000, file.name
